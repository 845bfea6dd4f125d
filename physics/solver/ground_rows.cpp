#include "physics/solver/ground_rows.h"

#include <algorithm>

#include "physics/solver/float4.h"

namespace brittle::physics {

namespace {

FourVectors all(const btVector3& v) {
    return {Float4::all(v.x()), Float4::all(v.y()), Float4::all(v.z())};
}
Float4 dot(const FourVectors& a, const FourVectors& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
FourVectors cross(const FourVectors& a, const FourVectors& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
FourVectors operator+(const FourVectors& a, const FourVectors& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
FourVectors operator-(const FourVectors& a, const FourVectors& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
FourVectors operator*(const FourVectors& a, Float4 factor) {
    return {a[0] * factor, a[1] * factor, a[2] * factor};
}
Float4 minus(Float4 a) {
    return Float4::all(-1.0f) * a;
}
void store(const FourVectors& v, std::array<Four, 3>& to) {
    for (size_t axis = 0; axis < 3; ++axis) v[axis].store(to[axis].data());
}

// What a row is made of besides its impulse.
struct Along {
    Float4 wanted, gain;
};

void clear(GroundRows& rows, size_t lane) {
    for (FourRows* of : {&rows.contacts, &rows.frictions}) {
        for (size_t axis = 0; axis < 3; ++axis)
            of->normal[axis][lane] = of->arm[axis][lane] = of->turn[axis][lane] = 0.0f;
        of->wanted[lane] = of->gain[lane] = of->impulse[lane] = 0.0f;
    }
    rows.speed[lane] = rows.depth[lane] = 0.0f;
}

// The movers of four points, each for itself or one for all.
struct Movers {
    const std::array<FourVectors, 3>& turning;
    const FourVectors &centre, &linear, &angular;
    Float4 light, restitution;
};

struct Points {
    FourVectors position;
    Float4 distance, kept_impulse;
    FourVectors held; // which way friction acts where they do not slide
};

// Rows that act on the bodies in a direction of each point.
Along rows_along(const FourVectors& normal, const FourVectors& arms, const Movers& movers, FourRows& rows) {
    const FourVectors arm = cross(arms, normal);
    const FourVectors turn{dot(movers.turning[0], arm), dot(movers.turning[1], arm), dot(movers.turning[2], arm)};
    store(normal, rows.normal);
    store(arm, rows.arm);
    store(turn, rows.turn);
    const Float4 none = Float4::all(0.0f), response = movers.light + dot(turn, arm);
    const Float4 gain = where_less(none, response, Float4::all(1.0f) / response, none);
    const Float4 apart = dot(normal, movers.linear) + dot(arm, movers.angular);
    return {minus(apart) * gain, gain};
}

void store(const Along& made, Float4 impulse, FourRows& rows) {
    made.wanted.store(rows.wanted.data());
    made.gain.store(rows.gain.data());
    impulse.store(rows.impulse.data());
}

const btVector3 up(0, 1, 0);

GroundRows rows_of(const Movers& movers, const Points& points, const GroundStep& step) {
    const Float4 none = Float4::all(0.0f), seconds = Float4::all(step.seconds);
    const FourVectors arms = points.position - movers.centre;

    GroundRows rows;
    Along contact = rows_along(all(up), arms, movers, rows.contacts);
    const Float4 apart = minus(contact.wanted) / contact.gain;
    const Float4 before = apart - Float4::all(up.dot(step.gravity) * step.seconds);
    const Float4 least = Float4::all(step.min_bounce_speed), faster = max(before, minus(before));
    const Float4 bounce = where_less(faster, least, none, max(minus(before) * movers.restitution, none));
    contact.wanted = contact.wanted + (bounce - max(points.distance, none) / seconds) * contact.gain;
    store(contact, points.kept_impulse * Float4::all(step.kept_impulse), rows.contacts);
    minus(before).store(rows.speed.data());
    (max(minus(points.distance), none) * Float4::all(GroundRows::undone_part) / seconds * contact.gain)
        .store(rows.depth.data());

    const FourVectors sliding = movers.linear + cross(movers.angular, arms) - all(up) * apart;
    const Float4 square = dot(sliding, sliding), epsilon = Float4::all(SIMD_EPSILON);
    FourVectors along = sliding * (Float4::all(1.0f) / sqrt(square));
    if (less(epsilon, square) != 0xf)
        for (size_t axis = 0; axis < 3; ++axis)
            along[axis] = where_less(epsilon, square, along[axis], points.held[axis]);
    store(rows_along(along, arms, movers, rows.frictions), none, rows.frictions);
    return rows;
}

// Points beside each other take turns between two ways, so that together they hold both.
const std::array<btVector3, 2>& held_ways() {
    static const std::array<btVector3, 2> ways = [] {
        std::array<btVector3, 2> both;
        btPlaneSpace1(up, both[0], both[1]);
        return both;
    }();
    return ways;
}

} // namespace

GroundRows ground_rows(const Mover& mover, const GroundManifold& ground, size_t first, const GroundStep& step) {
    const auto of = [&](const auto& value) {
        const auto at = [&](size_t i) { return value(ground.all[std::min<size_t>(first + i, ground.count - 1)]); };
        return Float4::of(at(0), at(1), at(2), at(3));
    };
    const auto position = [&](size_t axis) {
        return of([axis](const GroundPoint& point) { return point.position[axis]; });
    };
    const std::array<btVector3, 2>& ways = held_ways(); // first is even
    const auto held = [&](int axis) { return Float4::of(ways[0][axis], ways[1][axis], ways[0][axis], ways[1][axis]); };
    const std::array<FourVectors, 3> turning{all(mover.turning[0]), all(mover.turning[1]), all(mover.turning[2])};
    const FourVectors centre = all(mover.centre), linear = all(mover.linear), angular = all(mover.angular);
    return rows_of({turning, centre, linear, angular, Float4::all(mover.light), Float4::all(ground.restitution)},
                   {.position = {position(0), position(1), position(2)},
                    .distance = of([](const GroundPoint& point) { return point.distance; }),
                    .kept_impulse = of([](const GroundPoint& point) { return point.kept_impulse(); }),
                    .held = {held(0), held(1), held(2)}},
                   step);
}

FourGrounded::FourGrounded(const std::array<const Mover*, 4>& movers,
                           const std::array<const GroundManifold*, 4>& manifolds)
    : grounds(manifolds) {
    const auto lanes = [&](const auto& value) { return Float4::of(value(0), value(1), value(2), value(3)); };
    for (size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<int>(axis);
        for (size_t row = 0; row < 3; ++row)
            turning[row][axis] = lanes([&](size_t lane) { return movers[lane]->turning[row][i]; });
        centre[axis] = lanes([&](size_t lane) { return movers[lane]->centre[i]; });
        linear[axis] = lanes([&](size_t lane) { return movers[lane]->linear[i]; });
        angular[axis] = lanes([&](size_t lane) { return movers[lane]->angular[i]; });
    }
    light = lanes([&](size_t lane) { return movers[lane]->light; });
    restitution = lanes([&](size_t lane) { return manifolds[lane]->restitution; });
    friction = lanes([&](size_t lane) { return manifolds[lane]->friction; });
}

GroundRows ground_rows(const FourGrounded& bodies, size_t index, const GroundStep& step) {
    const auto of = [&](const auto& value) {
        const auto at = [&](size_t lane) {
            const GroundManifold& ground = *bodies.grounds[lane];
            return value(ground.all[std::min<size_t>(index, ground.count - 1)]);
        };
        return Float4::of(at(0), at(1), at(2), at(3));
    };
    const auto position = [&](size_t axis) {
        return of([axis](const GroundPoint& point) { return point.position[axis]; });
    };
    GroundRows rows =
        rows_of({bodies.turning, bodies.centre, bodies.linear, bodies.angular, bodies.light, bodies.restitution},
                {.position = {position(0), position(1), position(2)},
                 .distance = of([](const GroundPoint& point) { return point.distance; }),
                 .kept_impulse = of([](const GroundPoint& point) { return point.kept_impulse(); }),
                 .held = all(held_ways()[index % 2])},
                step);
    for (size_t lane = 0; lane < 4; ++lane)
        if (index >= bodies.grounds[lane]->count) clear(rows, lane);
    return rows;
}

} // namespace brittle::physics

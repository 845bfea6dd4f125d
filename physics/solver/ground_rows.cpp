#include "physics/solver/ground_rows.h"

#include <algorithm>

#include "physics/solver/float4.h"

namespace brittle::physics {

namespace {

FourVectors all(const glm::vec3& v) {
    return {Float4::all(v.x), Float4::all(v.y), Float4::all(v.z)};
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

struct Made {
    Float4 bias, effective_mass;
};

void clear(GroundRows& rows, size_t lane) {
    for (FourRows* of : {&rows.contacts, &rows.frictions}) {
        for (size_t axis = 0; axis < 3; ++axis)
            of->normal[axis][lane] = of->angular[axis][lane] = of->inverse_inertia_angular[axis][lane] = 0.0f;
        of->bias[lane] = of->effective_mass[lane] = of->impulse[lane] = 0.0f;
    }
    rows.speed[lane] = rows.correction[lane] = 0.0f;
}

// The bodies of four points in lanes: four bodies, or one body four times.
struct Bodies {
    const std::array<FourVectors, 3>& inverse_inertia;
    const FourVectors &centre, &linear, &angular;
    Float4 inverse_mass, restitution;
};

struct Points {
    FourVectors position;
    Float4 distance, warm_normal_impulse;
    FourVectors tangent; // direction of friction for points that do not slide
};

// Writes J and I^-1 (r x n) of rows along n at each point. Returns m_eff, and the bias of v_target = 0: -m_eff J v.
Made rows_along(const FourVectors& normal, const FourVectors& arms, const Bodies& bodies, FourRows& rows) {
    const FourVectors angular = cross(arms, normal);
    const FourVectors turn{dot(bodies.inverse_inertia[0], angular), dot(bodies.inverse_inertia[1], angular),
                           dot(bodies.inverse_inertia[2], angular)};
    store(normal, rows.normal);
    store(angular, rows.angular);
    store(turn, rows.inverse_inertia_angular);
    const Float4 none = Float4::all(0.0f), response = bodies.inverse_mass + dot(turn, angular);
    const Float4 effective_mass = where_less(none, response, Float4::all(1.0f) / response, none);
    const Float4 apart = dot(normal, bodies.linear) + dot(angular, bodies.angular);
    return {minus(apart) * effective_mass, effective_mass};
}

void store(const Made& made, Float4 impulse, FourRows& rows) {
    made.bias.store(rows.bias.data());
    made.effective_mass.store(rows.effective_mass.data());
    impulse.store(rows.impulse.data());
}

const glm::vec3 up(0, 1, 0);

// Contact, friction and split-impulse terms as in row.h, with b static.
GroundRows rows_of(const Bodies& bodies, const Points& points, const GroundStep& step) {
    const Float4 none = Float4::all(0.0f), seconds = Float4::all(step.seconds);
    const FourVectors arms = points.position - bodies.centre;

    GroundRows rows;
    Made contact = rows_along(all(up), arms, bodies, rows.contacts);
    const Float4 apart = minus(contact.bias) / contact.effective_mass;
    const Float4 before = apart - Float4::all(glm::dot(up, step.gravity) * step.seconds);
    const Float4 least = Float4::all(step.min_bounce_speed), faster = max(before, minus(before));
    const Float4 bounce = where_less(faster, least, none, max(minus(before) * bodies.restitution, none));
    contact.bias = contact.bias + (bounce - max(points.distance, none) / seconds) * contact.effective_mass;
    store(contact, points.warm_normal_impulse * Float4::all(step.warm_start_part), rows.contacts);
    minus(before).store(rows.speed.data());
    (max(minus(points.distance), none) * Float4::all(GroundRows::correction_part) / seconds * contact.effective_mass)
        .store(rows.correction.data());

    const FourVectors sliding = bodies.linear + cross(bodies.angular, arms) - all(up) * apart;
    const Float4 square = dot(sliding, sliding), min_square = Float4::all(min_sliding_square);
    FourVectors along = sliding * (Float4::all(1.0f) / sqrt(square));
    if (less(min_square, square) != 0xf)
        for (size_t axis = 0; axis < 3; ++axis)
            along[axis] = where_less(min_square, square, along[axis], points.tangent[axis]);
    store(rows_along(along, arms, bodies, rows.frictions), none, rows.frictions);
    return rows;
}

// Points that do not slide alternate between two tangents: together they hold the body in both directions.
const std::array<glm::vec3, 2>& tangents_of_ground() {
    static const Tangents tangents = tangents_of(up);
    static const std::array<glm::vec3, 2> both{tangents.first, tangents.second};
    return both;
}

} // namespace

GroundRows ground_rows(const SolverBody& body, const GroundManifold& ground, size_t first, const GroundStep& step) {
    const auto of = [&](const auto& value) {
        const auto at = [&](size_t i) { return value(ground.all[std::min<size_t>(first + i, ground.count - 1)]); };
        return Float4::of(at(0), at(1), at(2), at(3));
    };
    const auto position = [&](size_t axis) {
        return of([axis](const GroundPoint& point) { return point.position[static_cast<int>(axis)]; });
    };
    const std::array<glm::vec3, 2>& ways = tangents_of_ground(); // `first` is even
    const auto tangent = [&](int axis) {
        return Float4::of(ways[0][axis], ways[1][axis], ways[0][axis], ways[1][axis]);
    };
    const std::array<FourVectors, 3> inverse_inertia{all(body.inverse_inertia[0]), all(body.inverse_inertia[1]),
                                                     all(body.inverse_inertia[2])};
    const FourVectors centre = all(body.centre), linear = all(body.linear), angular = all(body.angular);
    return rows_of(
        {inverse_inertia, centre, linear, angular, Float4::all(body.inverse_mass), Float4::all(ground.restitution)},
        {.position = {position(0), position(1), position(2)},
         .distance = of([](const GroundPoint& point) { return point.distance; }),
         .warm_normal_impulse = of([](const GroundPoint& point) { return point.warm_normal_impulse(); }),
         .tangent = {tangent(0), tangent(1), tangent(2)}},
        step);
}

FourGrounded::FourGrounded(const std::array<const SolverBody*, 4>& bodies,
                           const std::array<const GroundManifold*, 4>& manifolds)
    : grounds(manifolds) {
    const auto lanes = [&](const auto& value) { return Float4::of(value(0), value(1), value(2), value(3)); };
    for (size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<int>(axis);
        for (size_t row = 0; row < 3; ++row)
            inverse_inertia[row][axis] = lanes([&](size_t lane) { return bodies[lane]->inverse_inertia[row][i]; });
        centre[axis] = lanes([&](size_t lane) { return bodies[lane]->centre[i]; });
        linear[axis] = lanes([&](size_t lane) { return bodies[lane]->linear[i]; });
        angular[axis] = lanes([&](size_t lane) { return bodies[lane]->angular[i]; });
    }
    inverse_mass = lanes([&](size_t lane) { return bodies[lane]->inverse_mass; });
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
        return of([axis](const GroundPoint& point) { return point.position[static_cast<int>(axis)]; });
    };
    GroundRows rows = rows_of(
        {bodies.inverse_inertia, bodies.centre, bodies.linear, bodies.angular, bodies.inverse_mass, bodies.restitution},
        {.position = {position(0), position(1), position(2)},
         .distance = of([](const GroundPoint& point) { return point.distance; }),
         .warm_normal_impulse = of([](const GroundPoint& point) { return point.warm_normal_impulse(); }),
         .tangent = all(tangents_of_ground()[index % 2])},
        step);
    for (size_t lane = 0; lane < 4; ++lane)
        if (index >= bodies.grounds[lane]->count) clear(rows, lane);
    return rows;
}

} // namespace brittle::physics

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
FourVectors operator-(const FourVectors& a, const FourVectors& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Float4 minus(Float4 a) {
    return Float4::all(-1.0f) * a;
}
void store(const FourVectors& v, std::array<Four, 3>& to) {
    for (size_t axis = 0; axis < 3; ++axis) v[axis].store(to[axis].data());
}

void clear(GroundRows& rows, size_t lane) {
    const auto clear_vectors = [lane](auto& of) {
        for (size_t axis = 0; axis < 3; ++axis) of.angular[axis][lane] = of.inverse_inertia_angular[axis][lane] = 0.0f;
    };
    FourRows& contact = rows.contacts;
    clear_vectors(contact);
    for (size_t axis = 0; axis < 3; ++axis) contact.normal[axis][lane] = 0.0f;
    contact.rest[lane] = contact.bias[lane] = contact.effective_mass[lane] = contact.impulse[lane] = 0.0f;
    contact.gap[lane] = contact.slop[lane] = contact.bounce[lane] = contact.start[lane] = contact.share[lane] = 0.0f;
    contact.residual[lane] = 0.0f;
    for (FourFrictions::Along& along : rows.frictions.along) {
        clear_vectors(along);
        for (size_t axis = 0; axis < 3; ++axis) along.tangent[axis][lane] = 0.0f;
        along.rest[lane] = along.impulse[lane] = along.total[lane] = 0.0f;
    }
    rows.frictions.mass_11[lane] = rows.frictions.mass_12[lane] = rows.frictions.mass_22[lane] = 0.0f;
    rows.frictions.sliding_mass[lane] = 0.0f;
    rows.speed[lane] = 0.0f;
}

// The bodies of four points in lanes: four bodies, or one body four times.
struct Bodies {
    const std::array<FourVectors, 3>& inverse_inertia;
    const FourVectors &centre, &linear, &angular;
    Float4 inverse_mass, restitution;
};

struct Points {
    FourVectors position;
    Float4 distance, slop, share, start_normal;
    FourVectors start_friction;
};

// A row along n at each point: r x n, I^-1 (r x n), J M^-1 J^T and J v.
struct Along {
    FourVectors angular, turn;
    Float4 response, apart;
};
Along row_along(const FourVectors& normal, const FourVectors& arms, const Bodies& bodies) {
    const FourVectors angular = cross(arms, normal);
    const FourVectors turn{dot(bodies.inverse_inertia[0], angular), dot(bodies.inverse_inertia[1], angular),
                           dot(bodies.inverse_inertia[2], angular)};
    return {angular, turn, bodies.inverse_mass + dot(turn, angular),
            dot(normal, bodies.linear) + dot(angular, bodies.angular)};
}

const glm::vec3 up(0, 1, 0);

// Contact and friction rows as in row.h, with b static. Precondition: no body has infinite
// mass.
GroundRows rows_of(const Bodies& bodies, const Points& points, const GroundStep& step) {
    const Float4 none = Float4::all(0.0f), one = Float4::all(1.0f);
    const FourVectors arms = points.position - bodies.centre;

    GroundRows rows;
    const Along contact = row_along(all(up), arms, bodies);
    const Float4 mass = one / contact.response;
    const Float4 approach = minus(contact.apart), faster = max(approach, contact.apart);
    const Float4 bounce =
        where_less(faster, Float4::all(step.min_bounce_speed), none, max(approach * bodies.restitution, none));
    store(all(up), rows.contacts.normal);
    store(contact.angular, rows.contacts.angular);
    store(contact.turn, rows.contacts.inverse_inertia_angular);
    (approach * mass).store(rows.contacts.rest.data());
    none.store(rows.contacts.bias.data());
    mass.store(rows.contacts.effective_mass.data());
    points.distance.store(rows.contacts.gap.data());
    points.slop.store(rows.contacts.slop.data());
    points.share.store(rows.contacts.share.data());
    none.store(rows.contacts.bias.data());
    (bounce * mass).store(rows.contacts.bounce.data());
    points.start_normal.store(rows.contacts.impulse.data());
    none.store(rows.contacts.total.data());
    points.start_normal.store(rows.contacts.start.data());
    approach.store(rows.speed.data());

    const FourVectors first = all(tangents_of_ground().first), second = all(tangents_of_ground().second);
    const Along along[2] = {row_along(first, arms, bodies), row_along(second, arms, bodies)};
    const Float4 between = dot(along[0].turn, along[1].angular);
    const Float4 inverse = one / (along[0].response * along[1].response - between * between);
    const Float4 mass_11 = along[1].response * inverse, mass_12 = minus(between) * inverse;
    const Float4 mass_22 = along[0].response * inverse;
    mass_11.store(rows.frictions.mass_11.data());
    mass_12.store(rows.frictions.mass_12.data());
    mass_22.store(rows.frictions.mass_22.data());
    (one / (along[0].response + along[1].response)).store(rows.frictions.sliding_mass.data());
    for (size_t i = 0; i < 2; ++i) {
        const FourVectors& tangent = i == 0 ? first : second;
        FourFrictions::Along& to = rows.frictions.along[i];
        store(tangent, to.tangent);
        store(along[i].angular, to.angular);
        store(along[i].turn, to.inverse_inertia_angular);
        minus(along[i].apart).store(to.rest.data());
        dot(tangent, points.start_friction).store(to.impulse.data());
        none.store(to.total.data());
    }
    return rows;
}

} // namespace

const Tangents& tangents_of_ground() {
    static const Tangents tangents = tangents_of(up);
    return tangents;
}

GroundRows ground_rows(const SolverBody& body, const GroundManifold& ground, size_t first, const GroundStep& step) {
    const auto of = [&](const auto& value) {
        const auto at = [&](size_t i) { return value(ground.all[std::min<size_t>(first + i, ground.count - 1)]); };
        return Float4::of(at(0), at(1), at(2), at(3));
    };
    const auto position = [&](size_t axis) {
        return of([axis](const GroundPoint& point) { return point.position[static_cast<int>(axis)]; });
    };
    const auto friction = [&](size_t axis) {
        return of([axis](const GroundPoint& point) { return point.start.friction[static_cast<int>(axis)]; });
    };
    const std::array<FourVectors, 3> inverse_inertia{all(body.inverse_inertia[0]), all(body.inverse_inertia[1]),
                                                     all(body.inverse_inertia[2])};
    const FourVectors centre = all(body.centre), linear = all(body.linear), angular = all(body.angular);
    return rows_of(
        {inverse_inertia, centre, linear, angular, Float4::all(body.inverse_mass), Float4::all(ground.restitution)},
        {.position = {position(0), position(1), position(2)},
         .distance = of([](const GroundPoint& point) { return point.distance; }),
         .slop = Float4::all(ground.slop),
         .share = Float4::all(body.share),
         .start_normal = of([](const GroundPoint& point) { return point.start.normal; }),
         .start_friction = {friction(0), friction(1), friction(2)}},
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
    share = lanes([&](size_t lane) { return bodies[lane]->share; });
    slop = lanes([&](size_t lane) { return manifolds[lane]->slop; });
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
    const auto friction = [&](size_t axis) {
        return of([axis](const GroundPoint& point) { return point.start.friction[static_cast<int>(axis)]; });
    };
    GroundRows rows = rows_of(
        {bodies.inverse_inertia, bodies.centre, bodies.linear, bodies.angular, bodies.inverse_mass, bodies.restitution},
        {.position = {position(0), position(1), position(2)},
         .distance = of([](const GroundPoint& point) { return point.distance; }),
         .slop = bodies.slop,
         .share = bodies.share,
         .start_normal = of([](const GroundPoint& point) { return point.start.normal; }),
         .start_friction = {friction(0), friction(1), friction(2)}},
        step);
    for (size_t lane = 0; lane < 4; ++lane)
        if (index >= bodies.grounds[lane]->count) clear(rows, lane);
    return rows;
}

} // namespace brittle::physics

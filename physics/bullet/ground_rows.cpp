#include "physics/bullet/ground_rows.h"

#include <algorithm>

#include "physics/bullet/float4.h"

namespace brittle::physics {

namespace {

using Vectors = std::array<Float4, 3>; // x, y and z of four

Vectors all(const btVector3& v) {
    return {Float4::all(v.x()), Float4::all(v.y()), Float4::all(v.z())};
}
Float4 dot(const Vectors& a, const Vectors& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Vectors cross(const Vectors& a, const Vectors& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vectors operator+(const Vectors& a, const Vectors& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
Vectors operator-(const Vectors& a, const Vectors& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Vectors operator*(const Vectors& a, Float4 factor) {
    return {a[0] * factor, a[1] * factor, a[2] * factor};
}
Float4 minus(Float4 a) {
    return Float4::all(-1.0f) * a;
}
void store(const Vectors& v, std::array<Four, 3>& to) {
    for (size_t axis = 0; axis < 3; ++axis) v[axis].store(to[axis].data());
}

// What a row is made of besides its impulse.
struct Along {
    Float4 wanted, gain;
};

// Rows that act on the body in a direction of each point.
Along rows_along(const Vectors& normal, const Vectors& arms, const Mover& mover, FourRows& rows) {
    const Vectors arm = cross(arms, normal);
    const Vectors turn{dot(all(mover.turning[0]), arm), dot(all(mover.turning[1]), arm), dot(all(mover.turning[2]), arm)};
    store(normal, rows.normal);
    store(arm, rows.arm);
    store(turn, rows.turn);
    const Float4 none = Float4::all(0.0f), response = Float4::all(mover.light) + dot(turn, arm);
    const Float4 gain = where_less(none, response, Float4::all(1.0f) / response, none);
    const Float4 apart = dot(normal, all(mover.linear)) + dot(arm, all(mover.angular));
    return {minus(apart) * gain, gain};
}

void store(const Along& made, Float4 impulse, FourRows& rows) {
    made.wanted.store(rows.wanted.data());
    made.gain.store(rows.gain.data());
    impulse.store(rows.impulse.data());
}

} // namespace

GroundRows ground_rows(const Mover& mover, const GroundManifold& ground, size_t first, const GroundStep& step) {
    const auto of = [&](const auto& value) {
        const auto at = [&](size_t i) { return value(ground.all[std::min<size_t>(first + i, ground.count - 1)]); };
        return Float4::of(at(0), at(1), at(2), at(3));
    };
    const auto position = [&](size_t axis) { return of([axis](const GroundPoint& point) { return point.position[axis]; }); };
    const Float4 none = Float4::all(0.0f), seconds = Float4::all(step.seconds);
    const Float4 distance = of([](const GroundPoint& point) { return point.distance; });
    const Vectors arms = Vectors{position(0), position(1), position(2)} - all(mover.centre);
    const btVector3 up(0, 1, 0);

    GroundRows rows;
    Along contact = rows_along(all(up), arms, mover, rows.contacts);
    const Float4 apart = minus(contact.wanted) / contact.gain;
    const Float4 before = apart - Float4::all(up.dot(step.gravity) * step.seconds);
    const Float4 least = Float4::all(step.least_bounce_speed), faster = max(before, minus(before));
    const Float4 bounce = where_less(faster, least, none, max(minus(before) * Float4::all(ground.restitution), none));
    contact.wanted = contact.wanted + (bounce - max(distance, none) / seconds) * contact.gain;
    const Float4 impulse = of([](const GroundPoint& point) { return point.kept_impulse(); });
    store(contact, impulse * Float4::all(step.kept_impulse), rows.contacts);
    minus(before).store(rows.speed.data());
    (max(minus(distance), none) * Float4::all(GroundRows::undone_part) / seconds * contact.gain).store(rows.depth.data());

    const Vectors sliding = all(mover.linear) + cross(all(mover.angular), arms) - all(up) * apart;
    const Float4 square = dot(sliding, sliding), epsilon = Float4::all(SIMD_EPSILON);
    Vectors along = sliding * (Float4::all(1.0f) / sqrt(square));
    if (less(epsilon, square) != 0xf) {
        // Points beside each other take turns, so that together they hold both ways.
        btVector3 even, odd;
        btPlaneSpace1(up, even, odd);
        for (size_t axis = 0; axis < 3; ++axis)
            along[axis] = where_less(epsilon, square, along[axis], Float4::of(even[axis], odd[axis], even[axis], odd[axis]));
    }
    const Along friction = rows_along(along, arms, mover, rows.frictions);
    store(friction, none, rows.frictions);
    return rows;
}

} // namespace brittle::physics

#include "physics/solver/debris_rows.h"

#include <cstddef>

namespace brittle::physics {

namespace {

FourVectors load(const std::array<Four, 3>& from) {
    return {Float4::load(from[0].data()), Float4::load(from[1].data()), Float4::load(from[2].data())};
}
void store(const FourVectors& from, std::array<Four, 3>& to) {
    for (size_t axis = 0; axis < 3; ++axis) from[axis].store(to[axis].data());
}
FourVectors operator+(const FourVectors& a, const FourVectors& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
FourVectors operator-(const FourVectors& a, const FourVectors& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
FourVectors operator*(const FourVectors& a, Float4 by) {
    return {a[0] * by, a[1] * by, a[2] * by};
}
Float4 dot(const FourVectors& a, const FourVectors& b) {
    return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}
FourVectors cross(const FourVectors& a, const FourVectors& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
// Shortened to a length.
FourVectors shortened(const FourVectors& v, Float4 longest) {
    const Float4 length = sqrt(dot(v, v));
    return v * where_less(longest, length, longest / length, Float4::all(1.0f));
}

// Rows of four bodies as columns.
struct Columns {
    FourVectors xyz;
    Float4 w;
};
template<class Of>
Columns gather(const std::array<uint32_t, 4>& bodies, const Of& of) {
    Float4 rows[4];
    for (size_t lane = 0; lane < 4; ++lane) rows[lane] = Float4::load(of(bodies[lane]));
    transpose(rows[0], rows[1], rows[2], rows[3]);
    return {{rows[0], rows[1], rows[2]}, rows[3]};
}
template<class Of>
void scatter(const Columns& columns, const std::array<uint32_t, 4>& bodies, const Of& of) {
    Float4 rows[4] = {columns.xyz[0], columns.xyz[1], columns.xyz[2], columns.w};
    transpose(rows[0], rows[1], rows[2], rows[3]);
    for (size_t lane = 0; lane < 4; ++lane) rows[lane].store(of(bodies[lane]));
}

// The motion of four bodies.
struct FourDebris {
    Columns linear, momentum; // w of linear: the inverse mass
    FourVectors diagonal, off;

    FourDebris(const std::array<uint32_t, 4>& at, const DebrisBodies& bodies)
        : linear(gather(at, [&](uint32_t i) { return bodies.motions[i].linear; })),
          momentum(gather(at, [&](uint32_t i) { return bodies.motions[i].momentum; })),
          diagonal(gather(at, [&](uint32_t i) { return bodies.inverse_inertias[i].diagonal; }).xyz),
          off(gather(at, [&](uint32_t i) { return bodies.inverse_inertias[i].off; }).xyz) {}

    void store(const std::array<uint32_t, 4>& at, DebrisBodies& bodies) const {
        scatter(linear, at, [&](uint32_t i) { return bodies.motions[i].linear; });
        scatter(momentum, at, [&](uint32_t i) { return bodies.motions[i].momentum; });
    }
    [[nodiscard]] FourVectors angular() const {
        const FourVectors& l = momentum.xyz;
        return {(diagonal[0] * l[0] + off[0] * l[1]) + off[1] * l[2],
                (off[0] * l[0] + diagonal[1] * l[1]) + off[2] * l[2],
                (off[1] * l[0] + off[2] * l[1]) + diagonal[2] * l[2]};
    }
    [[nodiscard]] FourVectors at(const FourVectors& arm) const { return linear.xyz + cross(angular(), arm); }
    void apply(const FourVectors& impulse, const FourVectors& arm) {
        linear.xyz = linear.xyz + impulse * linear.w;
        momentum.xyz = momentum.xyz + cross(arm, impulse);
    }
    void turn(const FourVectors& impulse) { momentum.xyz = momentum.xyz + impulse; }
};

// One iteration.
template<bool two_sided>
void iterate(DebrisRows& rows, DebrisBodies& bodies, Float4 target) {
    const FourVectors normal = load(rows.normal), arm_a = load(rows.arm_a), arm_b = load(rows.arm_b);
    FourDebris a(rows.a, bodies);
    FourDebris b = two_sided ? FourDebris(rows.b, bodies) : a;
    const FourVectors start = load(rows.apart);
    const auto apart = [&] { return start + (two_sided ? a.at(arm_a) - b.at(arm_b) : a.at(arm_a)); };
    const auto push = [&](const FourVectors& impulse) {
        a.apply(impulse, arm_a);
        if (two_sided) b.apply(FourVectors{} - impulse, arm_b);
    };
    const Float4 none = Float4::all(0.0f), before = Float4::load(rows.impulse.data());
    const Float4 after = max(before - (dot(normal, apart()) - target) * Float4::load(rows.normal_mass.data()), none);
    after.store(rows.impulse.data());
    push(normal * (after - before));
    const FourVectors old_friction = load(rows.friction), sliding = apart();
    const FourVectors friction =
        shortened(old_friction - (sliding - normal * dot(normal, sliding)) * Float4::load(rows.friction_mass.data()),
                  after * Float4::load(rows.coefficient.data()));
    store(friction, rows.friction);
    push(friction - old_friction);
    if (two_sided) {
        const FourVectors old_rolling = load(rows.rolling);
        const FourVectors rolling = shortened(
            old_rolling - (load(rows.turning) + a.angular() - b.angular()) * Float4::load(rows.rolling_mass.data()),
            after * Float4::load(rows.rolling_arm.data()));
        store(rolling, rows.rolling);
        const FourVectors turned = rolling - old_rolling;
        a.turn(turned);
        b.turn(FourVectors{} - turned);
        b.store(rows.b, bodies);
    }
    a.store(rows.a, bodies);
}

} // namespace

template<bool two_sided>
void start_substep(DebrisRows& rows, DebrisBodies& bodies) {
    const FourVectors impulse = load(rows.normal) * Float4::load(rows.impulse.data()) + load(rows.friction);
    FourDebris a(rows.a, bodies);
    a.apply(impulse, load(rows.arm_a));
    if (two_sided) {
        FourDebris b(rows.b, bodies);
        const FourVectors rolling = load(rows.rolling);
        a.turn(rolling);
        b.apply(FourVectors{} - impulse, load(rows.arm_b));
        b.turn(FourVectors{} - rolling);
        b.store(rows.b, bodies);
    }
    a.store(rows.a, bodies);
}

template<bool two_sided>
void solve_first(DebrisRows& rows, DebrisBodies& bodies, float substep_seconds, float longest_push) {
    const auto moved_at = [&](const std::array<uint32_t, 4>& at, const FourVectors& arm) {
        const auto linear = gather(at, [&](uint32_t i) { return bodies.moved[i].linear; });
        const auto angular = gather(at, [&](uint32_t i) { return bodies.moved[i].angular; });
        return linear.xyz + cross(angular.xyz, arm);
    };
    FourVectors moved = moved_at(rows.a, load(rows.arm_a));
    if (two_sided) moved = moved - moved_at(rows.b, load(rows.arm_b));
    const Float4 none = Float4::all(0.0f);
    const Float4 gap = Float4::load(rows.gap.data()) + dot(load(rows.normal), moved);
    const Float4 closing = none - max(gap, none) / Float4::all(substep_seconds);
    closing.store(rows.closing.data());
    const Float4 overlap = max(none - gap - Float4::load(rows.slop.data()), none) * Float4::load(rows.push.data());
    const Float4 push = two_sided ? min(overlap, Float4::all(longest_push)) : overlap;
    if (less(none, push) != 0) {
        (Float4::load(rows.pushed.data()) + push).store(rows.pushed.data());
        const FourVectors impulse = load(rows.normal) * (push * Float4::load(rows.normal_mass.data()));
        const auto displace = [&](const std::array<uint32_t, 4>& at, const FourVectors& by, const FourVectors& arm) {
            FourDebris motion(at, bodies);
            Columns linear = gather(at, [&](uint32_t i) { return bodies.moved[i].linear; });
            Columns angular = gather(at, [&](uint32_t i) { return bodies.moved[i].angular; });
            linear.xyz = linear.xyz + by * motion.linear.w;
            motion.momentum.xyz = cross(arm, by);
            angular.xyz = angular.xyz + motion.angular();
            scatter(linear, at, [&](uint32_t i) { return bodies.moved[i].linear; });
            scatter(angular, at, [&](uint32_t i) { return bodies.moved[i].angular; });
        };
        displace(rows.a, impulse, load(rows.arm_a));
        if (two_sided) displace(rows.b, FourVectors{} - impulse, load(rows.arm_b));
    }
    iterate<two_sided>(rows, bodies, closing);
}

template<bool two_sided>
void solve_second(DebrisRows& rows, DebrisBodies& bodies) {
    const Float4 none = Float4::all(0.0f);
    iterate<two_sided>(rows, bodies,
                       where_less(none, Float4::load(rows.impulse.data()), none, Float4::load(rows.closing.data())));
}

template<bool two_sided>
void solve_bounce(DebrisRows& rows, DebrisBodies& bodies) {
    const Float4 loaded = Float4::load(rows.impulse.data()) + Float4::load(rows.total.data());
    iterate<two_sided>(
        rows, bodies,
        where_less(Float4::all(0.0f), loaded, Float4::load(rows.bounce.data()), Float4::load(rows.closing.data())));
}

void scale(DebrisRows& rows, const Four& share) {
    const Float4 by = Float4::load(share.data());
    (Float4::load(rows.impulse.data()) * by).store(rows.impulse.data());
    store(load(rows.friction) * by, rows.friction);
    store(load(rows.rolling) * by, rows.rolling);
}

void finish_substep(DebrisRows& rows) {
    const Float4 impulse = Float4::load(rows.impulse.data()), one = Float4::all(1.0f);
    const Float4 limit = Float4::all(start_growth) * Float4::load(rows.start.data())
                         + Float4::all(start_speed) * Float4::load(rows.normal_mass.data());
    const Float4 kept = where_less(limit, impulse, limit / impulse, one);
    (Float4::load(rows.total.data()) + impulse).store(rows.total.data());
    (impulse * kept).store(rows.impulse.data());
    (impulse * kept).store(rows.start.data());
    const FourVectors friction = load(rows.friction);
    store(load(rows.friction_total) + friction, rows.friction_total);
    store(friction * kept, rows.friction);
    store(load(rows.rolling) * kept, rows.rolling);
}

template void start_substep<true>(DebrisRows&, DebrisBodies&);
template void start_substep<false>(DebrisRows&, DebrisBodies&);
template void solve_first<true>(DebrisRows&, DebrisBodies&, float, float);
template void solve_first<false>(DebrisRows&, DebrisBodies&, float, float);
template void solve_second<true>(DebrisRows&, DebrisBodies&);
template void solve_second<false>(DebrisRows&, DebrisBodies&);
template void solve_bounce<true>(DebrisRows&, DebrisBodies&);
template void solve_bounce<false>(DebrisRows&, DebrisBodies&);

} // namespace brittle::physics

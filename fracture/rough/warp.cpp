#include "fracture/rough/warp.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "fracture/base/box.h"
#include "fracture/base/random.h"
#include "fracture/base/simd.h"

namespace brittle::fracture::rough {

namespace {

// The bound of the slope of the noise in a step at amount 1. With that of the fade around calm balls, at most
// 1.5 / fade_wavelengths / cells_per_wavelength * max_step_slope * noise_height / noise_slope = 0.13, the sum stays
// below 1, so a step is one to one.
constexpr double max_step_slope = 0.86;

// Lattice cells per wavelength: the energy of gradient noise peaks at about two cells.
constexpr double cells_per_wavelength = 2.0;

constexpr uint32_t gradient_count = 64;

using Lanes = double __attribute__((vector_size(32)));

struct Gradient {
    Lanes columns[3];
};

// The rotation of an integer quaternion, whose entries are rational.
glm::dmat3 rotation(int a, int b, int c, int d) {
    const double s = 1.0 / (a * a + b * b + c * c + d * d);
    return glm::dmat3(s * (a * a + b * b - c * c - d * d), s * 2 * (b * c + a * d), s * 2 * (b * d - a * c),
                      s * 2 * (b * c - a * d), s * (a * a - b * b + c * c - d * d), s * 2 * (c * d + a * b),
                      s * 2 * (b * d + a * c), s * 2 * (c * d - a * b), s * (a * a - b * b - c * c + d * d));
}

glm::dmat3 random_rotation(Random& random) {
    for (;;) {
        int q[4];
        int norm = 0;
        for (int& x : q) {
            x = static_cast<int>(random.next() % 13) - 6;
            norm += x * x;
        }
        if (norm != 0) return rotation(q[0], q[1], q[2], q[3]);
    }
}

struct Gradients {
    std::array<Gradient, gradient_count> all;

    // Rotations and their negatives in turn, so that the noise has mean zero.
    Gradients() {
        Random random(1);
        for (uint32_t k = 0; k < gradient_count; k += 2) {
            const glm::dmat3 r = random_rotation(random);
            for (int c = 0; c < 3; ++c) {
                all[k].columns[c] = Lanes{r[c].x, r[c].y, r[c].z, 0.0};
                all[k + 1].columns[c] = -all[k].columns[c];
            }
        }
    }
};

const Gradients& gradients() {
    static const Gradients table;
    return table;
}

struct LatticeCell {
    int64_t index;
    double at; // in [0, 1]
};

inline __attribute__((always_inline)) LatticeCell cell_of(double u) {
    auto i = static_cast<int64_t>(u);
    i -= u < static_cast<double>(i) ? 1 : 0;
    return {i, u - static_cast<double>(i)};
}

inline __attribute__((always_inline)) double fade(double t) {
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
}

inline __attribute__((always_inline)) void add_noise(const Gradient* table, uint64_t seed, const glm::dvec3& u,
                                                     Lanes& sum) {
    // Beyond this the lattice has no cells in double precision; the comparison is false for NaN.
    if (!(std::abs(u.x) < 0x1p50 && std::abs(u.y) < 0x1p50 && std::abs(u.z) < 0x1p50)) return;
    const LatticeCell x = cell_of(u.x), y = cell_of(u.y), z = cell_of(u.z);
    const double wx[2] = {1.0 - fade(x.at), fade(x.at)};
    const double wy[2] = {1.0 - fade(y.at), fade(y.at)};
    const double wz[2] = {1.0 - fade(z.at), fade(z.at)};
    const uint64_t key = seed + static_cast<uint64_t>(x.index) * 0x9e3779b97f4a7c15ull
                         + static_cast<uint64_t>(y.index) * 0xc2b2ae3d27d4eb4full
                         + static_cast<uint64_t>(z.index) * 0x165667b19e3779f9ull;
    for (int k = 0; k < 2; ++k) {
        for (int j = 0; j < 2; ++j) {
            const uint64_t row = key + (j ? 0xc2b2ae3d27d4eb4full : 0) + (k ? 0x165667b19e3779f9ull : 0);
            for (int i = 0; i < 2; ++i) {
                uint64_t h = row + (i ? 0x9e3779b97f4a7c15ull : 0);
                h = (h ^ (h >> 32)) * 0xd6e8feb86659fd93ull;
                h ^= h >> 32;
                const Gradient& g = table[(h * 0xd6e8feb86659fd93ull) >> 58];
                const double w = wx[i] * wy[j] * wz[k];
                const double dx = w * (x.at - i), dy = w * (y.at - j), dz = w * (z.at - k);
                sum += g.columns[0] * dx + g.columns[1] * dy + g.columns[2] * dz;
            }
        }
    }
}

// The height of the noise at a point, from 0 to 1.
double height_at(const glm::dvec3& p, std::span<const CalmBall> calm, double fade) {
    double least = 1.0;
    for (const CalmBall& ball : calm) {
        const glm::dvec3 d = p - ball.centre;
        const double square = glm::dot(d, d), reach = ball.radius + fade * std::max(least, 0.0);
        if (square < reach * reach) least = std::min(least, (std::sqrt(square) - ball.radius) / fade);
    }
    return least <= 0.0 ? 0.0 : least * least * (3.0 - 2.0 * least);
}

// Finds the balls that may lower the noise at a point of a box.
void find_beside(const Box& box, std::span<const CalmBall> calm, double fade, std::vector<CalmBall>& beside) {
    beside.clear();
    for (const CalmBall& ball : calm) {
        const glm::dvec3 d = ball.centre - glm::clamp(ball.centre, box.min, box.max);
        const double reach = ball.radius + fade;
        if (!(glm::dot(d, d) > reach * reach)) beside.push_back(ball);
    }
}

} // namespace

// A friend, because a function with several versions (simd.h) cannot be a member.
BRITTLE_SIMD void warp_points(const Warp& warp, std::span<glm::dvec3> points, bool inverse) {
    const Gradient* const table = gradients().all.data();
    const std::span<const Warp::Step> steps(warp.steps_);
    // A point moves by at most reach_, to where the noise is looked up.
    const double margin = 1.001 * warp.reach_;
    const auto around = [&](const Box& box) { return Box{box.min - margin, box.max + margin}; };
    std::vector<CalmBall> beside; // any of the points
    if (!warp.calm_.empty() && !points.empty()) {
        Box box{points.front(), points.front()};
        for (const glm::dvec3& p : points) box = {glm::min(box.min, p), glm::max(box.max, p)};
        find_beside(around(box), warp.calm_, warp.fade_, beside);
    }
    std::vector<CalmBall> calm; // that are beside one point
    const auto displacement = [&](const Warp::Step& step, const glm::dvec3& p) __attribute__((always_inline)) {
        const double height = calm.empty() ? 1.0 : height_at(p, calm, warp.fade_);
        const glm::dmat3& a = step.to_lattice;
        const glm::dvec3 u = a[0] * p.x + a[1] * p.y + a[2] * p.z + step.offset;
        Lanes n{};
        add_noise(table, step.seed, u, n);
        const glm::dmat3& b = step.to_metres;
        return (b[0] * n[0] + b[1] * n[1] + b[2] * n[2]) * height;
    };
    for (glm::dvec3& p : points) {
        if (!beside.empty()) find_beside(around({p, p}), beside, warp.fade_, calm);
        if (!inverse) {
            for (const Warp::Step& step : steps) p += displacement(step, p);
            continue;
        }
        for (size_t k = steps.size(); k-- > 0;) {
            const glm::dvec3 image = p;
            for (uint32_t round = 0; round < inverse_rounds; ++round) p = image - displacement(steps[k], p);
        }
    }
}

Warp::Warp(const Roughness& roughness, double wavelength, std::span<const CalmBall> calm)
    : calm_(calm.begin(), calm.end()), fade_(fade_wavelengths * wavelength) {
    if (roughness.is_flat()) return;
    const double stretch = glm::length(roughness.grain);
    // Stretching is a linear change of coordinates: the warp between is one to one, so the whole is.
    glm::dmat3 stretched(1.0), shrunk(1.0);
    if (stretch > 0.0) {
        const glm::dvec3 axis = roughness.grain / stretch;
        const glm::dmat3 along = glm::outerProduct(axis, axis);
        stretched += (stretch - 1.0) * along;
        shrunk += (1.0 / stretch - 1.0) * along;
    }
    const double amplitude = roughness.amount * max_step_slope / noise_slope;
    Random random(roughness.seed);
    for (uint32_t octave = 0; octave < roughness.detail; ++octave) {
        const double cell = wavelength / cells_per_wavelength / static_cast<double>(1u << octave);
        // Turned and shifted, so that no plane of the lattices, where the noise is small, meets another.
        const glm::dmat3 turn = random_rotation(random);
        const double x = random.uniform(), y = random.uniform(), z = random.uniform();
        steps_.push_back({(turn * shrunk) / cell, glm::dvec3(x, y, z),
                          stretched * glm::transpose(turn) * (cell * amplitude), random.next()});
        reach_ += cell * amplitude * noise_height * (stretch > 1.0 ? stretch : 1.0);
    }
}

glm::dvec3 Warp::apply(const glm::dvec3& point) const {
    glm::dvec3 p = point;
    warp_points(*this, {&p, 1}, false);
    return p;
}

glm::dvec3 Warp::inverse(const glm::dvec3& point) const {
    glm::dvec3 p = point;
    warp_points(*this, {&p, 1}, true);
    return p;
}

void Warp::apply(std::span<glm::dvec3> points) const {
    warp_points(*this, points, false);
}

void Warp::inverse(std::span<glm::dvec3> points) const {
    warp_points(*this, points, true);
}

} // namespace brittle::fracture::rough

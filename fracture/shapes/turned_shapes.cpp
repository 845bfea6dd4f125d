// Household shapes: solids of revolution, and a flight of stairs.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/vec2.hpp>

#include "fracture/base/rounded_math.h"
#include "fracture/shapes/shapes.h"

namespace brittle::fracture {

namespace {

constexpr uint32_t max_sides = 4096, max_steps = 10'000;

// Points of a Catmull-Rom spline through the profile, `between` of them between two of its points. It keeps the height
// of the first and the last point.
std::vector<glm::dvec2> smooth(const std::vector<glm::dvec2>& profile, int between) {
    std::vector<glm::dvec2> points;
    const auto at = [&](size_t k, int offset) {
        const auto last = static_cast<std::ptrdiff_t>(profile.size()) - 1;
        return profile[static_cast<size_t>(
            std::clamp(static_cast<std::ptrdiff_t>(k) + offset, std::ptrdiff_t{0}, last))];
    };
    for (size_t k = 0; k + 1 < profile.size(); ++k)
        for (int step = 0; step < between; ++step) {
            const double t = static_cast<double>(step) / between;
            const glm::dvec2 a = at(k, -1), b = at(k, 0), c = at(k, 1), d = at(k, 2);
            points.push_back(0.5
                             * (2.0 * b + (c - a) * t + (2.0 * a - 5.0 * b + 4.0 * c - d) * (t * t)
                                + (3.0 * b - a - 3.0 * c + d) * (t * t * t)));
        }
    points.push_back(profile.back());
    return points;
}

} // namespace

TriangleMesh lathe(const std::vector<glm::dvec2>& profile, uint32_t sides) {
    sides = std::clamp(sides, 3u, max_sides);
    TriangleMesh mesh;
    if (profile.size() < 2) return mesh;
    for (const glm::dvec2& ring : profile)
        for (uint32_t k = 0; k < sides; ++k) {
            const double angle = 2.0 * std::numbers::pi * k / sides;
            mesh.positions.emplace_back(ring.x * rounded::cos(angle), ring.y, ring.x * rounded::sin(angle));
        }
    for (uint32_t ring = 0; ring + 1 < profile.size(); ++ring)
        for (uint32_t k = 0; k < sides; ++k) {
            const uint32_t a = ring * sides + k, b = ring * sides + (k + 1) % sides;
            mesh.triangles.emplace_back(a, a + sides, b);
            mesh.triangles.emplace_back(b, a + sides, b + sides);
        }
    const auto low = static_cast<uint32_t>(mesh.positions.size()), high = low + 1;
    mesh.positions.emplace_back(0.0, profile.front().y, 0.0);
    mesh.positions.emplace_back(0.0, profile.back().y, 0.0);
    const auto top = static_cast<uint32_t>(profile.size() - 1) * sides;
    for (uint32_t k = 0; k < sides; ++k) {
        mesh.triangles.emplace_back(low, k, (k + 1) % sides);
        mesh.triangles.emplace_back(high, top + (k + 1) % sides, top + k);
    }
    return mesh;
}

TriangleMesh vase(uint32_t sides) {
    std::vector<glm::dvec2> profile = smooth({{0.065, 0.0},
                                              {0.1, 0.06},
                                              {0.13, 0.15},
                                              {0.115, 0.23},
                                              {0.07, 0.3},
                                              {0.055, 0.34},
                                              {0.06, 0.38},
                                              {0.078, 0.4}},
                                             4);
    const std::vector<glm::dvec2> inside = smooth({{0.07, 0.4},
                                                   {0.05, 0.375},
                                                   {0.045, 0.34},
                                                   {0.06, 0.295},
                                                   {0.105, 0.225},
                                                   {0.12, 0.15},
                                                   {0.09, 0.07},
                                                   {0.05, 0.015}},
                                                  4);
    profile.insert(profile.end(), inside.begin(), inside.end());
    return lathe(profile, sides);
}

TriangleMesh plate(uint32_t sides) {
    std::vector<glm::dvec2> profile{{0.06, 0.0}, {0.065, 0.003}, {0.09, 0.006}, {0.12, 0.02}, {0.13, 0.026}};
    const std::vector<glm::dvec2> inside{{0.13, 0.031}, {0.118, 0.027}, {0.088, 0.013}, {0.06, 0.009}};
    profile.insert(profile.end(), inside.begin(), inside.end());
    return lathe(profile, sides);
}

TriangleMesh round_table(uint32_t sides) {
    return lathe({{0.28, 0.0},
                  {0.28, 0.03},
                  {0.09, 0.06},
                  {0.05, 0.12},
                  {0.04, 0.4},
                  {0.05, 0.64},
                  {0.12, 0.7},
                  {0.45, 0.715},
                  {0.46, 0.735},
                  {0.45, 0.75}},
                 sides);
}

TriangleMesh basin(uint32_t sides) {
    return lathe({{1.0, 0.0},  {1.0, 0.08}, {0.92, 0.1},  {0.92, 0.4}, {1.0, 0.43},  {1.0, 0.5}, {0.8, 0.5},
                  {0.8, 0.45}, {0.84, 0.4}, {0.84, 0.15}, {0.2, 0.15}, {0.12, 0.25}, {0.1, 0.8}, {0.14, 0.88},
                  {0.4, 0.95}, {0.5, 1.05}, {0.5, 1.1},   {0.42, 1.1}, {0.38, 1.05}, {0.1, 1.0}},
                 sides);
}

TriangleMesh stairs(uint32_t steps) {
    constexpr double tread = 0.3, rise = 0.17, half = 0.6;
    steps = std::clamp(steps, 1u, max_steps);
    // The outline from the foot at +Z up to the top, then down the back. Corners at the foot of each riser divide the
    // base, so that the sides are columns of one tread each.
    TriangleMesh mesh;
    const auto column = [&](uint32_t k) { return 0.5 * steps * tread - k * tread; }; // z of the k-th riser
    const auto add = [&](double y, double z) {
        for (const double x : {-half, half}) mesh.positions.emplace_back(x, y, z);
        return static_cast<uint32_t>(mesh.positions.size()) - 2; // at -half; the next vertex is at +half
    };
    std::vector<uint32_t> base, front, nose; // by riser: on the ground, at the foot of the riser, at its top
    for (uint32_t k = 0; k <= steps; ++k) {
        base.push_back(add(0.0, column(k)));
        front.push_back(k == 0 ? base.back() : add(k * rise, column(k)));
        nose.push_back(k == steps ? front.back() : add((k + 1) * rise, column(k)));
    }
    const auto quad = [&](uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
        mesh.triangles.emplace_back(a, b, c);
        mesh.triangles.emplace_back(a, c, d);
    };
    for (uint32_t k = 0; k < steps; ++k) {
        quad(front[k], front[k] + 1, nose[k] + 1, nose[k]);         // riser
        quad(nose[k], nose[k] + 1, front[k + 1] + 1, front[k + 1]); // tread
        quad(base[k] + 1, base[k], base[k + 1], base[k + 1] + 1);   // base
        const auto side = [&](uint32_t x, bool turned) {            // of the column between two risers
            std::vector<uint32_t> loop{base[k + 1] + x, front[k + 1] + x, nose[k] + x, base[k] + x};
            if (front[k] != base[k]) loop.insert(loop.end() - 1, front[k] + x);
            for (size_t c = 1; c + 1 < loop.size(); ++c)
                turned ? mesh.triangles.emplace_back(loop[0], loop[c + 1], loop[c])
                       : mesh.triangles.emplace_back(loop[0], loop[c], loop[c + 1]);
        };
        side(1, false);
        side(0, true);
    }
    quad(base[steps] + 1, base[steps], front[steps], front[steps] + 1); // back
    return mesh;
}

} // namespace brittle::fracture

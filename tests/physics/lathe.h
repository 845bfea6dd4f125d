// Solids of revolution for tests.
#pragma once

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "fracture/mesh/mesh.h"

namespace brittle::test {

// A closed solid around Y. The profile lists radius and height from the lowest ring up; radii are positive.
inline fracture::TriangleMesh lathe(const std::vector<std::pair<double, double>>& profile, uint32_t sides) {
    fracture::TriangleMesh mesh;
    for (const auto& [radius, height] : profile)
        for (uint32_t k = 0; k < sides; ++k) {
            const double angle = 2.0 * std::numbers::pi * k / sides;
            mesh.positions.emplace_back(radius * std::cos(angle), height, radius * std::sin(angle));
        }
    for (uint32_t ring = 0; ring + 1 < profile.size(); ++ring)
        for (uint32_t k = 0; k < sides; ++k) {
            const uint32_t a = ring * sides + k, b = ring * sides + (k + 1) % sides;
            mesh.triangles.emplace_back(a, a + sides, b);
            mesh.triangles.emplace_back(b, a + sides, b + sides);
        }
    const auto low = static_cast<uint32_t>(mesh.positions.size()), high = low + 1;
    mesh.positions.emplace_back(0.0, profile.front().second, 0.0);
    mesh.positions.emplace_back(0.0, profile.back().second, 0.0);
    const auto top = static_cast<uint32_t>((profile.size() - 1) * sides);
    for (uint32_t k = 0; k < sides; ++k) {
        mesh.triangles.emplace_back(low, k, (k + 1) % sides);
        mesh.triangles.emplace_back(high, top + (k + 1) % sides, top + k);
    }
    return mesh;
}

} // namespace brittle::test

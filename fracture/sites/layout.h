// Arrangements of sites around an axis: rings and rays of a radial crack, and the layers of splinters. Patterns
// (pattern.h) and the damage of an impact fill in different numbers.
//
// Lengths in metres. Pure functions of the random engine's state; equal input gives equal sites on every machine.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "fracture/base/random.h"
#include "fracture/base/rounded_math.h"

namespace brittle::fracture {

// A right-handed orthonormal frame: u x v = along.
struct AxisFrame {
    glm::dvec3 along, u, v;
};

// `along` is a unit vector.
[[nodiscard]] inline AxisFrame axis_frame(const glm::dvec3& along) {
    const glm::dvec3 other = std::abs(along.y) < 0.9 ? glm::dvec3(0.0, 1.0, 0.0) : glm::dvec3(1.0, 0.0, 0.0);
    const glm::dvec3 u = glm::normalize(glm::cross(other, along));
    return {along, u, glm::cross(along, u)};
}

// Rings of sites in the plane across the axis, with one site a ray: the cells of broken glass. About `count` sites:
// sqrt(count / 3) rings of at least three rays.
struct RadialLayout {
    uint32_t count = 0;
    bool exact = false; // stops at `count` sites; otherwise the last ring is complete
    double reach = 0.0; // m, the radius of the outermost ring's outer edge
    // The radius at ring position t, 0 to 1, is reach * t^ring_exponent: above 1, shards lengthen outwards.
    double ring_exponent = 1.0;
    double ring_turn = 0.0;    // largest random turn of a whole ring, in distances between rays
    double stagger = 0.0;      // turn of every second ring, in distances between rays
    double angle_jitter = 0.0; // width of a site's random range around its ray, in distances between rays
    double ring_jitter = 0.0;  // width of a site's random range across its ring, in distances between rings
};

[[nodiscard]] inline std::vector<glm::dvec3> radial_sites(const RadialLayout& layout, const glm::dvec3& centre,
                                                          const AxisFrame& frame, Random& random) {
    const auto rings = std::max(1u, static_cast<uint32_t>(std::lround(std::sqrt(layout.count / 3.0))));
    const uint32_t rays = std::max(3u, (layout.count + rings - 1) / rings);
    std::vector<glm::dvec3> sites;
    for (uint32_t ring = 0; ring < rings; ++ring) {
        const double turn = layout.ring_turn * random.uniform(), stagger = layout.stagger * (ring % 2);
        for (uint32_t ray = 0; ray < rays && !(layout.exact && sites.size() == layout.count); ++ray) {
            const double angle_shift = layout.angle_jitter * (random.uniform() - 0.5);
            const double ring_shift = layout.ring_jitter * (random.uniform() - 0.5);
            const double angle = 2.0 * std::numbers::pi * (ray + turn + stagger + angle_shift) / rays;
            const double radius = layout.reach * rounded::pow((ring + 0.5 + ring_shift) / rings, layout.ring_exponent);
            sites.push_back(centre + radius * (rounded::cos(angle) * frame.u + rounded::sin(angle) * frame.v));
        }
    }
    return sites;
}

// Layers across an axis, each a crowd of sites nearly level with one another: bisectors inside a layer run along the
// axis, so the cells are long along it.
struct SplinterLayers {
    glm::dvec3 centre{0.0};
    glm::dvec3 along{0.0};
    std::vector<double> heights; // m along the axis from the centre, one a layer

    // The point of the axis at a layer's height plus `lift` metres.
    [[nodiscard]] glm::dvec3 on_axis(size_t layer, double lift = 0.0) const {
        return centre + (heights[layer] + lift) * along;
    }
    // The layer of the site with this index; sites are dealt to the layers in turn.
    [[nodiscard]] size_t layer_of(uint32_t site) const { return site % heights.size(); }
};

} // namespace brittle::fracture

// The bisector planes between Voronoi sites, and those that bound the cell of a site.
//
// "Real Time Voronoi Fracturing of Polygon Meshes": the plane n·x = d between sites a and b has the normal n = b - a
// and contains the point halfway between them. It is always built from the lower to the higher index, so the cells on
// both of its sides compute with the same bits.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

struct Bisector {
    uint32_t low = 0;  // site index; the side where value() is negative
    uint32_t high = 0; // site index above low; the side where value() is positive
    // From site low to site high, scaled by a power of two such that the largest component lies in [0.5, 1). The
    // scaling loses no bit, and planes between sites that almost coincide do not underflow.
    glm::dvec3 normal{0};
    glm::dvec3 midpoint{0};

    // n·x - d, in m: the signed distance times the length of the normal. Computed as n·(x - midpoint), which keeps its
    // digits far from the origin. Its error is about 1e-16 |x - midpoint|: a plane between sites k mesh diameters away
    // is misplaced by up to about 1e-16 k diameters.
    [[nodiscard]] double value(const glm::dvec3& x) const { return glm::dot(normal, x - midpoint); }

    // Whether a point belongs to the cell of site low. A point on the plane does: there is no epsilon, and the two
    // cells share no point.
    [[nodiscard]] static bool keeps_low(double value) { return value <= 0.0; }
    [[nodiscard]] bool keeps(uint32_t site, double value) const { return keeps_low(value) == (site == low); }
    [[nodiscard]] uint32_t other(uint32_t site) const { return site == low ? high : low; }
};

// The plane between two different sites, in either order. With weights (m^2, one per site) it lies nearer to the
// lighter site, and `midpoint` is its intersection with the line through the sites.
[[nodiscard]] Bisector bisector(std::span<const glm::dvec3> sites, uint32_t a, uint32_t b,
                                std::span<const double> weights = {});

struct CellBounds {
    bool empty = false;              // the cell does not meet the box, or a duplicate site owns it
    std::vector<Bisector> bisectors; // nearest site first
};

// The bisectors that bound the cell of a site within a box. The function clips a box plane by plane, in order of
// distance, and stops at the security radius: no site farther away than twice the farthest corner of the remaining cell
// can cut it. Conservative: a bisector that comes near the cell without cutting it (within prune_margin, bisectors.cpp)
// may be in the list; one that cuts is never missing. It examines all sites once: O(sites) plus O(log) per candidate.
[[nodiscard]] CellBounds cell_bounds(std::span<const glm::dvec3> sites, uint32_t site, const Box& box,
                                     std::span<const double> weights = {});

} // namespace brittle::fracture

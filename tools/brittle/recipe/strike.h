// A blow of a hammer as sites: what lies near the point breaks as the pattern says, all else stays one piece.
//
//     const PatternSites sites = must(strike_sites(strikes, options.pattern));
//     settings.groups = sites.groups;                  // fracture.h: no cut between cells of one group
//
// Sites fill a cube around the point, a little larger than the ball that breaks; those outside every strike's ball are
// one group. They close the cells inside: unless sizes are graded, no crumb reaches further than 1.6 radii. The pattern gives
// kind, seed and shape; kinds that follow the surface (curvature, thickness) or a line break as `uniform` here. Radial
// shards run along the blow.
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "fracture/sites/pattern.h"

namespace brittle::tools {

struct Strike {
    glm::dvec3 at{0.0};                   // in the coordinates of the mesh
    glm::dvec3 direction{0.0, 0.0, -1.0}; // of the blow; any length but zero
    double radius = 0.1;                  // m, > 0
    uint32_t pieces = 16;                 // cells in the ball, about; those outside the solid give no piece

    friend bool operator==(const Strike&, const Strike&) = default;
};

// Of all strikes together. Errors: invalid_setting that names the strike's number and field.
[[nodiscard]] fracture::Result<fracture::PatternSites> strike_sites(std::span<const Strike> strikes,
                                                                    const fracture::Pattern& pattern);

} // namespace brittle::tools

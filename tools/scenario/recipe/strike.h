// A hammer blow as Voronoi sites: the solid breaks by the pattern near the point of the blow, and the rest stays one
// piece.
//
//     const PatternSites sites = must(strike_sites(strikes, options.pattern));
//     settings.groups = sites.groups;                  // fracture.h: no cut between cells of one group
//
// The sites fill a cube around the point, a little larger than the ball that breaks. Sites outside the balls of all
// strikes form one group. They close the cells inside: unless sizes are graded, no piece reaches further than 1.6
// radii. The pattern gives kind, seed and shape; kinds that follow the surface (curvature, thickness) or a line (curve)
// count as `uniform`. Radial shards run along the blow.
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "fracture/sites/pattern.h"

namespace brittle::tools {

struct Strike {
    glm::dvec3 at{0.0};                   // in the coordinates of the mesh
    glm::dvec3 direction{0.0, 0.0, -1.0}; // direction of the blow, of any length but zero
    double radius = 0.1;                  // m, > 0
    uint32_t pieces = 16; // approximate number of cells in the ball; a cell outside the solid gives no piece

    friend bool operator==(const Strike&, const Strike&) = default;
};

// Returns the sites of all strikes together. Errors: invalid_setting, with the index and field of the strike.
[[nodiscard]] fracture::Result<fracture::PatternSites> strike_sites(std::span<const Strike> strikes,
                                                                    const fracture::Pattern& pattern);

} // namespace brittle::tools

// The volume of a solid in each cell of a Voronoi diagram, by clipping that is slow, plain and shares no code with the
// library: the oracle of tools/compare.
//
// Each triangle of the surface spans a prism down to a plane below the solid. The volume of the solid in a convex cell
// is the sum over the triangles of the prism's part in the cell, signed by the side to which the triangle faces. Prisms
// and cells are convex, so half-spaces clip them one after the other, and a degenerate position needs no care: what
// lies on a plane has no volume on either side.
//
// The cells of a sample are computed in rational numbers, without any rounding. All others are computed in double, and
// the largest deviation between the two on the sample says how far these may be trusted.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tools/comparison/adapters/adapter.h"

namespace brittle::comparison {

struct CellVolume {
    double volume = 0.0;
    bool exact = false; // a rational number, rounded once
};

struct CellVolumes {
    std::vector<CellVolume> cells; // one a site; 0 for duplicates of a site with a lower index
    double deviation = 0.0;        // the largest of the volumes in double from the exact ones of the same cells
};

// A half-space: normal * x <= offset.
struct HalfSpace {
    Point normal;
    double offset;
};

// `max_prisms`: the exact cells, evenly spread, together clip at most about so many prisms in rational numbers.
[[nodiscard]] CellVolumes cell_volumes(const Part& mesh, std::span<const Point> sites, uint64_t max_prisms);

// The cells of the sites in a box around the mesh, larger by a tenth of its size, in double; a duplicate has none.
[[nodiscard]] std::vector<Part> voronoi_cells(const Part& mesh, std::span<const Point> sites);

} // namespace brittle::comparison

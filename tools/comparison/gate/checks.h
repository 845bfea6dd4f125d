// What tools/compare demands of the pieces of a fracture before their time counts: closed and oriented, not crossing
// themselves, one connected part each, the right volume in each cell, and equal caps on both sides of each facet.
//
// A length of a millionth of the mesh's size is the only tolerance (Gate::tolerance). It admits peers that compute in
// float. No code of the library is used.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tools/comparison/adapters/adapter.h"

namespace brittle::comparison {

struct Verdict {
    uint64_t pieces = 0;
    uint64_t triangles = 0;
    uint64_t open = 0;           // pieces with an edge without a neighbour, vertices within the tolerance being one
    uint64_t open_exactly = 0;   // the same with vertices that are one bit for bit
    uint64_t crossing = 0;       // pieces with an edge that pierces one of their triangles by more than the tolerance
    uint64_t joined_islands = 0; // pieces of several parts that do not hang together
    uint64_t negative = 0;       // pieces whose volume is not positive
    uint64_t wrong_cells = 0;    // cells whose pieces miss the volume by more than the tolerance times their surface
    double worst_cell = 0.0;     // the largest such error, as a share of the mean volume of a cell
    double volume_error = 0.0;   // of the sum of all pieces, as a share of the solid
    uint64_t wrong_caps = 0;     // facets whose caps on both sides differ in area or place
    double equal_caps = 0.0;     // share of the area of caps whose triangles are equal bit for bit on both sides

    // Empty for sound pieces, else what is wrong.
    [[nodiscard]] std::string reason() const;
};

// A segment along which two triangles cross each other.
struct Crossing {
    Point begin{}, end{};
};

class Gate {
  public:
    // `volumes`: of the solid in each cell.
    Gate(const Part& mesh, std::span<const Point> sites, std::span<const double> volumes);

    [[nodiscard]] Verdict check(const std::vector<Part>& pieces) const;

    static constexpr double relative_tolerance = 1e-6;

  private:
    const Part& mesh_;
    std::span<const Point> sites_;
    std::span<const double> volumes_;
    double tolerance_; // m
    std::vector<Crossing> input_crossings_;
};

} // namespace brittle::comparison

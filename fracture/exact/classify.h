// Which cell each mesh vertex lies in.
//
// A Classifier may guess: a GPU compares all sites in float32 and marks what its margin cannot prove. What is
// marked is decided here, exactly, so any device, or none, gives the same cells. Without a classifier each
// vertex is found by walking from the cell of the one before it, always to the neighbour that is nearer by
// most (in float32, then in double, then exactly, as far as needed). The walk ends, because every step comes
// strictly nearer; and where no neighbour is nearer, no site is.
#pragma once

#include <span>
#include <vector>

#include "fracture/exact/frames.h"
#include "fracture/parallel.h"
#include "fracture/exact/predicates.h"

namespace brittle::fracture::exact {

class Classifier {
  public:
    static constexpr uint32_t kUncertain = 0x80000000u;

    virtual ~Classifier() = default;

    // Writes for each position the index of the nearest site, with the bit kUncertain set unless rounding
    // cannot have changed the answer: |x - s_l|^2 must exceed |x - s_c|^2 for all l by more than the error of
    // both. Of equal sites it must be the lowest index, or uncertain. False: not available now, nothing was
    // written.
    virtual bool nearest(std::span<const glm::dvec3> positions, std::span<const glm::dvec3> sites,
                         std::span<uint32_t> out) = 0;
};

// A ball that is known to lie in one cell.
struct KnownBall {
    SiteId cell;
    glm::dvec3 centre{0.0};
    double radius = 0.0; // 0: nothing is known but that the cell is not empty
};

// The ball of q's cell around q, by walking from the cell of `from`.
[[nodiscard]] KnownBall locate(const Diagram& problem, const Frames& frames, const glm::dvec3& q,
                               const KnownBall& from, PredicateStats& stats);

// Cells of all positions; they must lie in the problem's box. classifier may be null.
void classify(const Diagram& problem, const VoronoiDiagram& diagram, const Frames& frames,
              std::span<const glm::dvec3> positions, Classifier* classifier, Threads& threads,
              std::vector<SiteId>& cell_of, PredicateStats& stats);

} // namespace brittle::fracture::exact

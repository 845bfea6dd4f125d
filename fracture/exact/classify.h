// Which cell each mesh vertex lies in.
//
// A Classifier (fracture/classifier.h) may have guessed; what it marked uncertain is decided here, exactly. Without
// one each vertex is found by walking from the cell of the one before it, always to the neighbour that is
// nearer by most (in float32, then in double, then exactly, as far as needed). The walk ends, because every
// step comes strictly nearer; and where no neighbour is nearer, no site is.
#pragma once

#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/classifier.h"
#include "fracture/exact/frames.h"
#include "fracture/exact/predicates.h"

namespace brittle::fracture::exact {

// A ball that is known to lie in one cell.
struct KnownBall {
    SiteId cell;
    glm::dvec3 centre{0.0};
    double radius = 0.0; // 0: nothing is known but that the cell is not empty
};

// The ball of q's cell around q, by walking from the cell of `from`.
[[nodiscard]] KnownBall locate(const Diagram& problem, const Frames& frames, const glm::dvec3& q, const KnownBall& from,
                               PredicateStats& stats);

// Cells of all positions; they must lie in the problem's box. Where `guessed`, cell_of holds a classifier's answers.
void classify(const Diagram& problem, const VoronoiDiagram& diagram, const Frames& frames,
              std::span<const glm::dvec3> positions, bool guessed, Threads& threads, std::vector<SiteId>& cell_of,
              PredicateStats& stats);

} // namespace brittle::fracture::exact

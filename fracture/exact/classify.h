// Classifies each mesh vertex: finds the cell that contains it.
//
// A Classifier (fracture/classifier.h) may have given answers already; the vertices that it marked uncertain are
// decided here, exactly. Otherwise the search walks from the cell of the vertex before, each time to the neighbour that
// is nearer by the largest margin, in float32, then in double, then exactly, as far as needed. The walk ends because
// each step comes strictly nearer; a cell with no nearer neighbour is the nearest of all.
#pragma once

#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/classifier.h"
#include "fracture/exact/frames.h"
#include "fracture/exact/predicates.h"

namespace brittle::fracture::exact {

// A ball that lies in one cell.
struct KnownBall {
    SiteId cell;
    glm::dvec3 centre{0.0};
    double radius = 0.0; // 0 where only `cell` is valid, as a cell that is not empty
};

// Returns a ball around q inside its cell. The search starts in the cell of `from`.
[[nodiscard]] KnownBall locate(const Diagram& problem, const Frames& frames, const glm::dvec3& q, const KnownBall& from,
                               PredicateStats& stats);

// Finds the cell of each position. Positions lie inside the box of the problem. `guessed`: cell_of holds the answers of
// a classifier.
void classify(const Diagram& problem, const VoronoiDiagram& diagram, const Frames& frames,
              std::span<const glm::dvec3> positions, bool guessed, Threads& threads, std::vector<SiteId>& cell_of,
              PredicateStats& stats);

} // namespace brittle::fracture::exact

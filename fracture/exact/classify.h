// Classifies each mesh vertex: finds the cell that contains it.
//
// A Classifier (fracture/classifier.h) may have given answers already; the vertices that it marked uncertain are
// decided here, exactly. Otherwise the vertices are sorted into the bins of a grid. Few planes meet a bin, and only
// these are compared with its vertices. A search walks from cell to cell, each time to the neighbour that is nearer by
// the largest margin, in float32, then in double, then exactly, as far as needed. It ends because each step comes
// strictly nearer; a cell with no nearer neighbour is the nearest of all.
#pragma once

#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/classifier.h"
#include "fracture/exact/frames.h"
#include "fracture/exact/predicates.h"
#include "fracture/exact/site_tree.h"

namespace brittle::fracture::exact {

// Finds the cell of each position. Positions lie inside the box of the problem. `guessed`: cell_of holds the answers of
// a classifier.
void classify(const Diagram& problem, const VoronoiDiagram& diagram, const Frames& frames, const SiteTree& tree,
              std::span<const glm::dvec3> positions, bool guessed, Threads& threads, std::vector<SiteId>& cell_of,
              PredicateStats& stats);

} // namespace brittle::fracture::exact

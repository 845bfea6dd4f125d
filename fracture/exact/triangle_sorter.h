// Divides the triangles of the mesh into whole ones, with all corners in one cell, and crossing ones.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/classifier.h"
#include "fracture/exact/cell_table.h"
#include "fracture/exact/cut.h"
#include "fracture/exact/surface.h"

namespace brittle::fracture::exact {

class TriangleSorter {
  public:
    struct Input {
        const Surface& surface;
        std::span<const Triangle> triangles;
        std::span<const SiteId> cell_of; // per vertex
        uint32_t cells;                  // their number
    };

    // Fills cut.crossing and cell_of_triangle (no_index for a crossing triangle and for a component that encloses
    // nothing), and whole_triangles().
    //
    // `guessed`: cell_of_triangle holds the answers of a classifier (classifier.h). Only triangles that the classifier
    // calls crossing are examined, and its flags for them go to CrossingTriangle::known.
    void run(const Input& input, bool guessed, Threads& threads, std::vector<SiteId>& cell_of_triangle, Cut& cut);

    // The number of whole triangles in each cell, a row for each chunk of triangles: of
    // threads.for_chunks(triangles, min_triangles_per_chunk, ...).
    [[nodiscard]] CellTable& whole_triangles() { return whole_; }
    static constexpr uint32_t min_triangles_per_chunk = 8192;

  private:
    struct Crossing {
        uint32_t triangle;
        uint32_t known; // as in CrossingTriangle
    };

    CellTable whole_;
    std::vector<std::vector<Crossing>> crossing_; // per chunk
};

} // namespace brittle::fracture::exact

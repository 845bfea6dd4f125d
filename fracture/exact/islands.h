// Splits each cell's run into islands: the parts of the solid that the cell holds separately.
//
// Triangles that share a vertex belong together. Most cells hold one island, and that is found cheaply: every
// connected part of a cell's surface either touches a cut or is a component of the mesh that was not cut at
// all. So it is enough to unite the vertices of polygons and caps, and only where these leave several groups
// to look at the whole triangles too. An inward shell (negative volume: a cavity) belongs to the smallest
// island around it.
#pragma once

#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/exact/assemble.h"
#include "fracture/pieces/fragments.h"

namespace brittle::fracture::exact {

class IslandSplitter {
  public:
    // After Assembler::run(): reorders the runs of cells with several islands and fills out.pieces, with mass
    // properties.
    void run(const Assembler::Input& input, std::span<const CellRun> cells, Threads& threads, Fragments& out);

  private:
    struct Chunk {
        std::vector<Piece> pieces;
        // Scratch.
        std::vector<uint32_t> parent, label, vertex_order, triangle_order, island_begin;
        std::vector<double> volume;
        std::vector<glm::dvec3> positions;
        std::vector<Triangle> triangles;
        std::vector<uint32_t> points, sources;
    };

    void count_uncut_components(const Assembler::Input& input);
    void split_cell(SiteId c, const CellRun& cell, Chunk& chunk, Fragments& out);
    uint32_t find_islands(SiteId c, const CellRun& cell, std::span<const Triangle> triangles, Chunk& chunk) const;
    static uint32_t attach_cavities(const CellRun& cell, const Fragments& out, uint32_t islands, Chunk& chunk);
    static void reorder(const CellRun& cell, uint32_t islands, Chunk& chunk, Fragments& out);

    std::vector<uint32_t> uncut_; // mesh components inside each cell that no bisector touches
    std::vector<uint8_t> component_is_cut_;
    std::vector<Chunk> chunks_;
};

} // namespace brittle::fracture::exact

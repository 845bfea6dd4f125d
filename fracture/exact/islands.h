// Splits the run of each cell into islands: the connected parts of the solid inside the cell.
//
// Triangles that share a vertex belong to one island. Most cells hold one island, and a cheap test finds that: every
// connected part of a cell's surface either touches a cut or is a whole component of the mesh. So uniting the vertices
// of the caps mostly suffices; those of polygons and of whole triangles are united only where several groups are left.
// An inward shell (a cavity, of negative volume) belongs to the smallest island around it.
#pragma once

#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/exact/assemble.h"
#include "fracture/pieces/fragments.h"

namespace brittle::fracture::exact {

class IslandSplitter {
  public:
    // Reorders the runs of cells with several islands and fills out.pieces, with mass properties. Runs after
    // Assembler::run().
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
    uint32_t count_groups(SiteId c, const CellRun& cell, Chunk& chunk) const;
    uint32_t find_islands(SiteId c, const CellRun& cell, std::span<const Triangle> triangles, Chunk& chunk) const;
    static uint32_t attach_cavities(const CellRun& cell, const Fragments& out, uint32_t islands, Chunk& chunk);
    static void reorder(const CellRun& cell, uint32_t islands, Chunk& chunk, Fragments& out);

    std::vector<uint32_t> uncut_; // per cell: the number of mesh components inside it that no bisector meets
    std::vector<uint8_t> component_is_cut_;
    std::vector<Chunk> chunks_;
};

} // namespace brittle::fracture::exact

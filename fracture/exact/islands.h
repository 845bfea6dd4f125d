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

#include "fracture/exact/assemble.h"
#include "fracture/parallel.h"
#include "fracture/fragments.h"

namespace brittle::fracture::exact {

class IslandSplitter {
  public:
    // After Assembler::run(): reorders the runs of cells with several islands and fills out.pieces, with mass
    // properties.
    void run(const Assembler::Input& input, std::span<const CellRun> cells, Threads& threads, Fragments& out);

    // The piece that holds a cell's vertex, named by its index in the cell before the split; an index into
    // Fragments::pieces.
    [[nodiscard]] uint32_t piece_of(SiteId cell, uint32_t local_index) const {
        const Labels& labels = labels_[cell];
        return labels.begin == kNone
                   ? labels.first_piece
                   : labels.first_piece + chunks_[labels.chunk].island[labels.begin + local_index];
    }
    [[nodiscard]] bool is_split(SiteId cell) const { return labels_[cell].begin != kNone; }
    [[nodiscard]] uint32_t first_piece(SiteId cell) const { return labels_[cell].first_piece; }

  private:
    struct Labels {
        uint32_t chunk = 0;
        uint32_t begin = kNone; // into Chunk::island; kNone where the cell holds one island or none
        uint32_t first_piece = 0;
    };
    struct Chunk {
        std::vector<Piece> pieces;
        std::vector<uint32_t> island; // of each vertex of split cells
        // Scratch.
        std::vector<uint32_t> parent, label, vertex_order, triangle_order, island_begin;
        std::vector<double> volume;
        std::vector<glm::dvec3> positions;
        std::vector<Triangle> triangles;
        std::vector<uint32_t> points, sources;
    };

    void count_uncut_components(const Assembler::Input& input);
    void split_cell(SiteId c, const CellRun& cell, Chunk& chunk, Fragments& out);
    uint32_t find_islands(SiteId c, const CellRun& cell, std::span<const Triangle> triangles,
                          Chunk& chunk) const;
    static uint32_t attach_cavities(const CellRun& cell, const Fragments& out, uint32_t islands,
                                    Chunk& chunk);
    static void reorder(const CellRun& cell, uint32_t islands, Chunk& chunk, Fragments& out);

    std::vector<uint32_t> uncut_; // mesh components inside each cell that no bisector touches
    std::vector<uint8_t> component_is_cut_;
    std::vector<Labels> labels_;
    std::vector<Chunk> chunks_;
};

} // namespace brittle::fracture::exact

// Assembles the cells: copies vertices and triangles into one contiguous run of each for every cell.
//
// No hashing is needed. The index of a vertex in a cell is its rank among the cell's vertices of one kind; the kinds
// follow each other: mesh vertices (each in one cell), edge points (two cells), pierce points (three), nodes (four).
// The triangles of a cell follow in the order whole triangles of the mesh, parts of crossing triangles, caps. A
// counting pass comes first and gives every thread its own place to write to. The run of a cell may hold several
// islands (islands.h).
#pragma once

#include <array>
#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/exact/caps.h"
#include "fracture/exact/cell_table.h"
#include "fracture/exact/cut.h"
#include "fracture/exact/surface.h"
#include "fracture/exact/triangle_sorter.h"
#include "fracture/pieces/fragments.h"

namespace brittle::fracture::exact {

// The run of one cell in the arrays of Fragments.
struct CellRun {
    Range vertices;
    Range triangles;
    uint32_t mesh_vertices = 0;   // the run starts with this many mesh vertices
    uint32_t whole_triangles = 0; // the run starts with this many uncut triangles of the mesh,
    uint32_t exterior = 0;        // and with this many triangles of the mesh surface, uncut or cut
};

class Assembler {
  public:
    struct Input {
        const TriangleMesh& mesh;
        const Scene& scene;
        const Surface& surface;
        const VoronoiDiagram& diagram;
        std::span<const SiteId> cell_of;
        std::span<const SiteId> cell_of_triangle;
        CellTable& whole_triangles; // as TriangleSorter counts them
        Cut& cut;                   // its points and nodes receive their local indices
        std::span<const CapChunk> caps;
    };

    // Fills out.positions, out.vertex_point, out.triangles and out.triangle_source, and cells().
    void run(const Input& input, Threads& threads, Fragments& out);

    [[nodiscard]] std::span<CellRun> cells() { return cells_; }

  private:
    // The index of a vertex in the run of a cell.
    [[nodiscard]] uint32_t local_index(const Input& input, VertexId id, SiteId cell) const;
    void count_vertices(const Input& input, Threads& threads);
    void count_triangles(const Input& input, Threads& threads);
    void lay_out(const Input& input, Threads& threads, Fragments& out);
    void place_vertices(const Input& input, Threads& threads, Fragments& out);
    void place_whole(const Input& input, Threads& threads, Fragments& out);
    void place_polygons(const Input& input, Threads& threads, Fragments& out);
    void place_caps(const Input& input, Threads& threads, Fragments& out);

    CellTable vertex_table_, triangle_table_;
    uint32_t edge_row_ = 0, pierce_row_ = 0, node_row_ = 0, polygon_row_ = 0, cap_row_ = 0;
    std::vector<uint32_t> vertex_total_, triangle_total_;
    std::vector<CellRun> cells_;
    std::vector<uint32_t> local_of_mesh_;
};

} // namespace brittle::fracture::exact

// Puts the pieces together: one run of vertices and one run of triangles for each cell.
//
// Nothing is hashed. A vertex's index in a cell is its rank among the cell's vertices of the same kind: mesh
// vertices first (each has one cell), then edge points (two cells), pierce points (three), nodes (four).
// Triangles follow as whole ones, parts of crossing ones, caps. Counting comes first, so every thread knows
// where to write. A cell's run may still hold several islands: see islands.h.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/classifier.h"
#include "fracture/exact/caps.h"
#include "fracture/exact/cell_table.h"
#include "fracture/exact/cut.h"
#include "fracture/exact/surface.h"
#include "fracture/pieces/fragments.h"

namespace brittle::fracture::exact {

// What a cell received, in Fragments' arrays.
struct CellRun {
    Range vertices;
    Range triangles;
    uint32_t mesh_vertices = 0;   // the first so many
    uint32_t whole_triangles = 0; // the first so many are uncut triangles of the mesh,
    uint32_t exterior = 0;        // and so many are parts of its surface
};

// Sorts the mesh's triangles into those inside a cell and those that cross: fills cut.crossing and
// cell_of_triangle (no_index where it crosses or is left out). Where `guessed`, cell_of_triangle holds a classifier's
// answers; only triangles that it calls crossing are looked at, and what it knows of them is kept.
void sort_triangles(const Surface& surface, std::span<const Triangle> triangles, std::span<const SiteId> cell_of,
                    bool guessed, Threads& threads, std::vector<SiteId>& cell_of_triangle, Cut& cut);

class Assembler {
  public:
    struct Input {
        const TriangleMesh& mesh;
        const Scene& scene;
        const Surface& surface;
        const VoronoiDiagram& diagram;
        std::span<const SiteId> cell_of;
        std::span<const SiteId> cell_of_triangle;
        Cut& cut; // receives local indices
        std::span<const CapChunk> caps;
    };

    // Fills positions, vertex_point, triangles and triangle_source.
    void run(const Input& input, Threads& threads, Fragments& out);

    [[nodiscard]] std::span<CellRun> cells() { return cells_; }

  private:
    // A vertex's index in its cell.
    [[nodiscard]] uint32_t local_index(const Input& input, VertexId id, SiteId cell) const;
    void count(const Input& input, Threads& threads);
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

// Removes slivers: the edges without length and triangles without area that a cut through a vertex, along an edge or in
// a face of the mesh creates.
//
// Symbolic perturbation makes every bisector pass beside the points that it passes through in truth. The pieces are
// closed then, but several points share one place, and corners lie on sides of triangles. Two operations remove this.
// Each acts on all cells at once, so that neighbours stay equal bit for bit:
//
//   - collapse: points closer than the minimum height become one, the one of the lowest kind (mesh vertex, edge point,
//     pierce point, node), only where the surface of each cell stays a manifold around it. This is the link condition
//     (Dey, Edelsbrunner, Guha and Nekhayev 1999) for more than two points at a time: where sixty cells meet in one
//     place, no two of the points there can become one without the others. Where a collapse leaves a cell with two
//     triangles back to back, both are dropped.
//   - split: a triangle with a corner on the opposite side is dropped, and every other triangle at that side is split
//     there. In a cell that has both triangles this is an edge flip. It is done only where the new edge does not exist
//     yet.
//
// A triangle below the minimum height remains only where both operations would change the topology, or where it is a
// triangle of the mesh that no bisector cuts. In sound input the cost is one test per triangle that a cut created.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/exact/assemble.h"
#include "fracture/pieces/fragments.h"

namespace brittle::fracture::exact {

class SliverCollapser {
  public:
    // The height below which a triangle is a sliver, as a share of the largest coordinate of the mesh: 512 units in the
    // last place, the error that the coordinates of a cut may have.
    static constexpr double min_height = 0x1p-44;

    // Removes the slivers. Runs after Assembler::run(). `cells` and `out` keep their invariants, with two exceptions: a
    // point of two kinds counts as the lower kind, and triangles of the mesh may be split.
    void run(const Assembler::Input& input, std::span<CellRun> cells, Threads& threads, Fragments& out);

    // Counts of the last run: slivers after the cut, those of a cap once, and slivers that remain.
    [[nodiscard]] uint64_t found() const { return found_; }
    [[nodiscard]] uint64_t left() const { return slivers_.size(); }

  private:
    struct Sliver {
        SiteId cell;
        uint32_t triangle; // into Fragments::triangles
    };
    // A triangle of a cell with a corner of a sliver. Corners are point numbers, see number().
    struct Face {
        std::array<uint32_t, 3> corners;
        SiteId cell;
        uint32_t triangle; // into Fragments::triangles; no_index for a new one
        uint32_t source;   // as in Fragments::triangle_source
        bool exterior;
        bool whole; // an uncut triangle of the mesh
        bool alive = true;
    };

    void find(std::span<const CellRun> cells, Threads& threads, const Fragments& out);
    void gather(const Assembler::Input& input, std::span<const CellRun> cells, const Fragments& out);
    void add_face(const Face& face);
    // Returns false where nothing could be removed.
    bool mend_all(const Assembler::Input& input);
    bool mend(const Assembler::Input& input, uint32_t face);
    void start_cluster();
    void add_to_cluster(uint32_t point);
    void find_cluster(const Assembler::Input& input, uint32_t seed);
    bool collapse();
    bool may_collapse();
    bool is_one_loop();
    void drop_two_sided(uint32_t corner, uint32_t f, uint32_t g);
    // Splits the side ab at c.
    bool split(uint32_t a, uint32_t b, uint32_t c);
    bool may_split(uint32_t a, uint32_t b, uint32_t c);
    void rebuild(const Assembler::Input& input, std::span<CellRun> cells, Fragments& out);
    void collect(const CellRun& cell, uint32_t gathered, std::span<const uint32_t> added, const Fragments& out);
    void place(const Assembler::Input& input, CellRun& cell, const Fragments& out);
    void copy(CellRun& cell, const Fragments& out);

    // Converts between vertex ids and point numbers, which have no gaps.
    [[nodiscard]] uint32_t number(uint32_t point) const;
    [[nodiscard]] VertexId id(uint32_t number) const;
    [[nodiscard]] glm::dvec3 position(const Assembler::Input& input, uint32_t number) const;
    // Whether the star of a point is known: all faces around it, in all cells.
    [[nodiscard]] bool is_gathered(uint32_t point) const { return star_of_[point] != no_index; }
    std::span<const uint32_t> star(uint32_t point);

    double to_heights_ = 1.0; // factor from input lengths to multiples of the minimum height
    uint64_t found_ = 0;
    std::vector<Sliver> slivers_;
    std::vector<std::vector<Sliver>> found_by_chunk_;
    std::array<uint32_t, 5> first_of_kind_{};
    std::vector<uint32_t> became_;             // per point: the point that it was merged into, or itself
    std::vector<uint32_t> star_of_;            // per point: into stars_, or no_index
    std::vector<std::vector<uint32_t>> stars_; // indices into faces_, possibly stale; the first star_count_ are in use
    uint32_t star_count_ = 0;
    std::vector<Face> faces_; // the first gathered_ are in ascending order of triangle, the others are new
    uint32_t gathered_ = 0;
    std::vector<uint32_t> work_;   // faces to test
    std::vector<uint8_t> changed_; // per cell
    Fragments rebuilt_;
    std::vector<Face> collected_;
    std::vector<uint32_t> local_;               // per point: its index in the current cell
    std::vector<uint32_t> cluster_;             // points to merge
    std::vector<uint8_t> in_cluster_;           // per point
    std::vector<uint32_t> moved_;               // the faces around the cluster
    std::vector<std::array<uint32_t, 3>> loop_; // from, to, face
    std::vector<std::array<uint32_t, 2>> two_sided_;
    std::vector<uint32_t> opposite_, added_;
};

} // namespace brittle::fracture::exact

// Takes back what a cut through a vertex, along an edge or in a face of the mesh leaves behind: edges without
// length and triangles without area.
//
// Symbolic perturbation lets every bisector pass beside what it really passes through. All is closed then,
// but points pile up in one place, and corners lie on sides. Two operations take that back, each in all cells
// at once, so that neighbours stay equal bit for bit:
//
//     collapse   points closer than the least height become one, the one of the lowest kind (mesh vertex,
//     edge point,
//                pierce point, node). Only where each cell's surface stays one around it; this is the link
//                condition (Dey, Edelsbrunner, Guha and Nekhayev 1999), for more than two points at a time:
//                where sixty cells meet in one place, no two of the points there can become one without the
//                others. A cell that is left with two sides of one triangle loses them.
//     split      a triangle whose corner lies on the opposite side vanishes, and every other triangle at that
//     side is
//                split there: in a cell that has both, an edge flip. Only where the new edge is not there
//                yet.
//
// A triangle of less height remains only where each of these would change the topology, or where it is a
// triangle of the mesh that no bisector cuts. Sound input costs one look at each triangle that a cut has
// made.
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
    // Triangles of less height than this share of the mesh's largest coordinate are slivers: 512 units in the
    // last place, what a cut's coordinates may be off.
    static constexpr double min_height = 0x1p-44;

    // After Assembler::run(); keeps what it says of `cells` and `out`, but that a point of two kinds counts
    // as the lower and that triangles of the mesh may be split.
    void run(const Assembler::Input& input, std::span<CellRun> cells, Threads& threads, Fragments& out);

    // Of the last run: slivers after the cut, each cap's counted once, and those left.
    [[nodiscard]] uint64_t found() const { return found_; }
    [[nodiscard]] uint64_t left() const { return slivers_.size(); }

  private:
    struct Sliver {
        SiteId cell;
        uint32_t triangle; // into Fragments::triangles
    };
    // A triangle of a cell that has a corner of a sliver. Corners are point numbers, see number().
    struct Face {
        std::array<uint32_t, 3> corners;
        SiteId cell;
        uint32_t triangle; // into Fragments::triangles; no_index where it is new
        uint32_t source;
        bool exterior;
        bool whole; // a triangle of the mesh
        bool alive = true;
    };

    void find(std::span<const CellRun> cells, Threads& threads, const Fragments& out);
    void gather(const Assembler::Input& input, std::span<const CellRun> cells, const Fragments& out);
    void add_face(const Face& face);
    // False where nothing could be done.
    bool mend_all(const Assembler::Input& input);
    bool mend(const Assembler::Input& input, uint32_t face);
    void start_cluster();
    void add_to_cluster(uint32_t point);
    void find_cluster(const Assembler::Input& input, uint32_t seed);
    bool collapse();
    bool may_collapse();
    bool is_one_loop();
    void drop_two_sided(uint32_t corner, uint32_t f, uint32_t g);
    // The side ab at c.
    bool split(uint32_t a, uint32_t b, uint32_t c);
    bool may_split(uint32_t a, uint32_t b, uint32_t c);
    void rebuild(const Assembler::Input& input, std::span<CellRun> cells, Fragments& out);
    void collect(const CellRun& cell, uint32_t gathered, std::span<const uint32_t> added, const Fragments& out);
    void place(const Assembler::Input& input, CellRun& cell, const Fragments& out);
    void copy(CellRun& cell, const Fragments& out);

    // Points numbered without gaps, and back to their ids.
    [[nodiscard]] uint32_t number(uint32_t point) const;
    [[nodiscard]] VertexId id(uint32_t number) const;
    [[nodiscard]] glm::dvec3 position(const Assembler::Input& input, uint32_t number) const;
    // Whether all faces at a point, of all cells, are in its star.
    [[nodiscard]] bool is_gathered(uint32_t point) const { return star_of_[point] != no_index; }
    std::span<const uint32_t> star(uint32_t point);

    double to_heights_ = 1.0; // from lengths of the input to multiples of the least height
    uint64_t found_ = 0;
    std::vector<Sliver> slivers_;
    std::vector<std::vector<Sliver>> found_by_chunk_;
    std::array<uint32_t, 5> first_of_kind_{};
    std::vector<uint32_t> became_;             // of each point: the one that it is now
    std::vector<uint32_t> star_of_;            // of each point: into stars_, the first star_count_ of which are used
    std::vector<std::vector<uint32_t>> stars_; // faces; may hold some that left
    uint32_t star_count_ = 0;
    std::vector<Face> faces_; // the first gathered_ ascend by triangle, the others are new
    uint32_t gathered_ = 0;
    std::vector<uint32_t> work_;   // faces that are or may be slivers
    std::vector<uint8_t> changed_; // cells
    Fragments rebuilt_;
    std::vector<Face> collected_;
    std::vector<uint32_t> local_;               // of each point, in the cell at work
    std::vector<uint32_t> cluster_;             // points to become one
    std::vector<uint8_t> in_cluster_;           // whether each point is one of them
    std::vector<uint32_t> moved_;               // faces around them
    std::vector<std::array<uint32_t, 3>> loop_; // from, to, face
    std::vector<std::array<uint32_t, 2>> two_sided_;
    std::vector<uint32_t> opposite_, added_;
};

} // namespace brittle::fracture::exact

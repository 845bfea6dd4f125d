// The arrangement of a mesh's triangles: which parts of them meet where.
//
// Two triangles meet in a segment where they cross, touch along a line, or lie in one plane. Each segment lies on a
// carrier: an edge of the mesh, or the common line of two triangles. A carrier is known to all triangles that hold a
// portion of it, so a point that one of them finds on the carrier divides it in the others too. Where triangles have
// only single points in common nothing is divided.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/mesh/mesh.h"
#include "fracture/unite/pairs.h"
#include "fracture/unite/points.h"

namespace brittle::fracture::arrangement {

struct Carrier {
    uint32_t from, to;                 // its end points
    std::array<uint32_t, 2> triangles; // that cross in it; no_index twice for an edge of the mesh
    std::vector<uint32_t> points{};    // that divide it, in any order
    std::vector<uint32_t> cuts{};      // that hold a portion: into Arrangement::cuts

    [[nodiscard]] bool is_edge() const { return triangles[0] == no_index; }
};

// A part of a carrier, as a segment in a triangle.
struct Portion {
    uint32_t carrier;
    uint32_t from, to; // end points
};

// A triangle that must be divided.
struct Cut {
    uint32_t triangle;
    bool is_covered = false; // another triangle lies in its plane and has a segment in common with it
    std::array<uint32_t, 3> edges{no_index, no_index, no_index}; // carriers, where there is one
    std::vector<Portion> portions{};                             // inside the triangle, or along its edges
};

struct Arrangement {
    explicit Arrangement(const TriangleMesh& input);

    TriangleMesh mesh; // the input; of vertices at one position all triangles name the first
    Points points;
    std::vector<int8_t> axis; // per triangle: see open_axis()
    std::vector<Carrier> carriers{};
    std::vector<Cut> cuts{};
    std::vector<uint32_t> cut_of{}; // per triangle: into cuts, or no_index
    std::unordered_map<uint64_t, uint32_t> carrier_of_edge{};

    [[nodiscard]] Corners corners(uint32_t triangle) const;
    [[nodiscard]] uint32_t corner(uint32_t triangle, int k) const { return mesh.triangles[triangle][k]; }

    [[nodiscard]] static uint64_t edge_key(uint32_t a, uint32_t b);
    // Returns the carrier of the edge from corner k of a triangle to the next.
    uint32_t edge_carrier(uint32_t triangle, int k);
    uint32_t cut(uint32_t triangle);
    // Of all triangles with area. Made once, when it is first asked for.
    [[nodiscard]] const BoxTree& tree(Threads& threads);

  private:
    std::optional<BoxTree> tree_;
};

// Finds the segments in which triangles meet, and adds carriers and portions. Only pairs with a triangle that
// `is_fresh` names are looked at.
void find_contacts(Arrangement& arrangement, const std::vector<uint8_t>& is_fresh, Threads& threads);

// Adds the points in which portions cross, and hands points over, until every portion of every triangle is divided by
// all points that lie on it.
void divide_carriers(Arrangement& arrangement);

// A part of a triangle, with its orientation.
struct Part {
    Triangle points;
    uint32_t triangle;
};

// Triangulates each cut along its portions. Triangles that lie in one plane are divided alike where they overlap: their
// parts there have equal corners.
[[nodiscard]] std::vector<Part> divide_triangles(const Arrangement& arrangement, Threads& threads);

} // namespace brittle::fracture::arrangement

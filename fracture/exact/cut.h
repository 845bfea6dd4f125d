// The vertices that a cut makes, and the polygons that the mesh's triangles fall into. Data only; edges.cpp
// and clip.cpp fill it.
//
// A vertex of the result is known by what it lies on, never by its coordinates:
//
//     mesh vertex    an index into the mesh
//     edge point     a mesh edge and a bisector
//     pierce point   a mesh triangle and a Voronoi edge
//     node           a Voronoi vertex (and a sheet, see winding.h), or a point inside a facet
//
// Each has one id, and one position that is computed once; the pieces that meet there copy it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/exact/scene.h"

namespace brittle::fracture::exact {

// A tagged index. 2^30 vertices of each kind.
class VertexId {
  public:
    enum Kind : uint32_t { mesh = 0, edge = 1, pierce = 2, node = 3 };

    VertexId() = default;
    VertexId(Kind kind, uint32_t index) : bits_(static_cast<uint32_t>(kind) << 30 | index) {}

    [[nodiscard]] Kind kind() const { return static_cast<Kind>(bits_ >> 30); }
    [[nodiscard]] uint32_t index() const { return bits_ & 0x3fffffffu; }
    [[nodiscard]] bool is_none() const { return bits_ == no_index; }
    [[nodiscard]] uint32_t bits() const { return bits_; } // Fragments::vertex_point
    friend bool operator==(VertexId, VertexId) = default;

  private:
    uint32_t bits_ = no_index;
};

struct EdgePoint {
    std::array<uint32_t, 2> cells; // in the order of the edge, from its lower to its higher vertex
    uint32_t facet;                // between them
    // The vertex that follows on the border of the facet's cap, seen from outside the cell with the lower
    // index.
    VertexId next;
    std::array<uint32_t, 2> local{}; // its index in the two cells' pieces
};

struct PiercePoint {
    std::array<uint32_t, 3> cells; // ascending
    uint32_t triangle;
    uint32_t voronoi_edge;
    uint32_t leaves; // 1 where the Voronoi edge, along its direction, leaves the solid here; 0 where it enters
    // As EdgePoint::next, on the facets (0,1), (0,2), (1,2) of cells.
    std::array<VertexId, 3> next;
    std::array<uint32_t, 3> local;
};

// Which of a pierce point's three facets lies between its a-th and b-th cell, a < b.
[[nodiscard]] constexpr uint32_t pair_index(uint32_t a, uint32_t b) {
    return a + b - 1;
}

struct Node {
    std::array<uint32_t, 4> cells; // ascending; no_index where fewer than four meet
    glm::dvec3 position;
    std::array<uint32_t, 4> local{};
};

// A triangle whose vertices are not all in one cell. The points on its edge e (from corner e to e+1) are
// edge_points[first[e] .. first[e] + count[e]), ordered from the lower vertex to the higher.
struct CrossingTriangle {
    uint32_t triangle;
    uint32_t known; // Classifier's bits of a crossing triangle; 0 without one
    std::array<uint32_t, 3> first;
    std::array<uint32_t, 3> count;
};

// Part of a crossing triangle in one cell: convex, counter-clockwise seen from outside the mesh.
struct Polygon {
    uint32_t cell;
    uint32_t triangle;
    uint32_t begin, end; // into the chunk's corners
};

// Polygons are kept where they were made, a chunk for each run of crossing triangles.
struct PolygonChunk {
    std::vector<Polygon> polygons;
    std::vector<VertexId> corners;
};

struct Cut {
    std::vector<CrossingTriangle> crossing; // ascending
    std::vector<EdgePoint> edge_points;
    std::vector<glm::dvec3> edge_positions;
    std::vector<PiercePoint> pierce_points;
    std::vector<glm::dvec3> pierce_positions;
    std::vector<Node> nodes;          // of Voronoi vertices first, in the order of Winding::node()
    std::vector<PolygonChunk> chunks; // the first `chunk_count` hold this cut's polygons
    uint32_t chunk_count = 0;
};

} // namespace brittle::fracture::exact

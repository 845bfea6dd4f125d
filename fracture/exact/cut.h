// The vertices that a cut creates, and the polygons that the mesh's triangles fall into. Data only; edges.cpp and
// clip.cpp fill it.
//
// A vertex of the result is identified by the objects that it lies on, never by its coordinates:
//
//     mesh vertex    an index into the mesh
//     edge point     a mesh edge and a bisector
//     pierce point   a mesh triangle and a Voronoi edge
//     node           a Voronoi vertex (and a sheet, see winding.h), or a point inside a facet
//
// Each has one id and one position, computed once. All pieces that meet there copy it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/exact/scene.h"

namespace brittle::fracture::exact {

// A tagged index: 2 bits for the kind, 30 bits for the index.
class VertexId {
  public:
    enum Kind : uint32_t { mesh = 0, edge = 1, pierce = 2, node = 3 };

    VertexId() = default;
    VertexId(Kind kind, uint32_t index) : bits_(static_cast<uint32_t>(kind) << 30 | index) {}

    [[nodiscard]] Kind kind() const { return static_cast<Kind>(bits_ >> 30); }
    [[nodiscard]] uint32_t index() const { return bits_ & 0x3fffffffu; }
    [[nodiscard]] bool is_none() const { return bits_ == no_index; }
    [[nodiscard]] uint32_t bits() const { return bits_; } // the value of Fragments::vertex_point
    friend bool operator==(VertexId, VertexId) = default;

  private:
    uint32_t bits_ = no_index;
};

struct EdgePoint {
    std::array<uint32_t, 2> cells; // in the direction of the edge, from its lower to its higher vertex
    uint32_t facet;                // between the two cells
    // The next vertex on the border of the facet's cap, as seen from outside the cell with the lower index.
    VertexId next;
    std::array<uint32_t, 2> local{}; // the index of this point in the runs of the two cells
};

struct PiercePoint {
    std::array<uint32_t, 3> cells; // ascending
    uint32_t triangle;
    uint32_t voronoi_edge;
    uint32_t leaves; // 1 where the Voronoi edge, along its direction, leaves the solid; 0 where it enters
    // EdgePoint::next on the three facets between cells (0,1), (0,2), (1,2).
    std::array<VertexId, 3> next;
    std::array<uint32_t, 3> local;
};

// The index of the facet between the a-th and the b-th cell of a pierce point, a < b.
[[nodiscard]] constexpr uint32_t pair_index(uint32_t a, uint32_t b) {
    return a + b - 1;
}

struct Node {
    std::array<uint32_t, 4> cells; // ascending; no_index where fewer than four meet
    glm::dvec3 position;
    std::array<uint32_t, 4> local{};
};

// A triangle with vertices in several cells. The points on its edge e, from corner e to corner e + 1, are
// edge_points[first[e] .. first[e] + count[e]), ordered from the lower mesh vertex to the higher.
struct CrossingTriangle {
    uint32_t triangle;
    uint32_t known; // the classifier's flags for a crossing triangle; 0 without a classifier
    std::array<uint32_t, 3> first;
    std::array<uint32_t, 3> count;
};

// The part of a crossing triangle in one cell: convex, counter-clockwise as seen from outside the mesh.
struct Polygon {
    uint32_t cell;
    uint32_t triangle;
    uint32_t begin, end; // into PolygonChunk::corners
};

// The polygons of one run of crossing triangles.
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
    std::vector<Node> nodes;          // those of Voronoi vertices first, in the order of Winding::node()
    std::vector<PolygonChunk> chunks; // the first chunk_count belong to this cut
    uint32_t chunk_count = 0;
};

} // namespace brittle::fracture::exact

// Half-edge meshes of triangles: flat index arrays that know every neighbour.
//
// "Real Time Voronoi Fracturing of Polygon Meshes", section 2.1.1. Each undirected edge is two half-edges,
// twins of each other, in opposite directions. A half-edge with a face belongs to exactly one triangle
// (counter-clockwise seen from outside). A half-edge without one (face == no_index) is a BORDER half-edge: it
// runs along the rim of a hole, and next and prev lead around that hole in one cyclic chain. So every
// half-edge has a twin, a next and a prev, whether the mesh is closed or not, and a closed mesh is one
// without BORDER half-edges.
//
// Faces come in one by one in any order; the border is kept whole after each (add_face). The mesh is plain
// data: the functions below keep its invariants, is_valid() states them.
//
//     Result<HalfEdgeMesh> mesh = build_half_edges(cube.positions, cube.triangles);
//     if (mesh && is_closed(*mesh)) ...
//
// Not synchronised; several threads may read one mesh.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/base/error.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

// Where a face comes from.
struct FaceSource {
    uint32_t index = 0; // exterior: the input triangle it is part of; interior: the site on the other side of the cap
    bool interior = false; // part of a cap

    bool operator==(const FaceSource&) const = default;
};

struct HalfEdge {
    uint32_t origin = no_index; // the vertex that it leaves
    uint32_t twin = no_index;   // the same edge in the other direction
    uint32_t next = no_index;   // around the face, or around the hole for a BORDER half-edge
    uint32_t prev = no_index;
    uint32_t face = no_index; // no_index for a BORDER half-edge
};

struct HalfEdgeMesh {
    std::vector<glm::dvec3> positions; // per vertex
    std::vector<uint32_t> outgoing;    // per vertex: a half-edge that leaves it, a BORDER one where it has one;
                                       // no_index for a vertex without faces
    std::vector<HalfEdge> half_edges;
    std::vector<uint32_t> faces;     // per face: one of its three half-edges
    std::vector<FaceSource> sources; // per face

    [[nodiscard]] const HalfEdge& operator[](uint32_t half_edge) const { return half_edges[half_edge]; }
    [[nodiscard]] HalfEdge& operator[](uint32_t half_edge) { return half_edges[half_edge]; }
    [[nodiscard]] bool is_border(uint32_t half_edge) const { return half_edges[half_edge].face == no_index; }
    [[nodiscard]] uint32_t target(uint32_t half_edge) const { return half_edges[half_edges[half_edge].twin].origin; }
};

// Appends a vertex without faces and returns its index.
uint32_t add_vertex(HalfEdgeMesh& mesh, const glm::dvec3& position);

enum class AddFace {
    added,
    repeated_vertex, // the triangle names a vertex twice
    taken_edge,      // one of its directed edges has a face already: misoriented or non-manifold
    taken_vertex     // a vertex would get a second fan while its first is complete: non-manifold
};

// Inserts one triangle. Where it lies against BORDER half-edges it takes them over, elsewhere it brings new
// ones, and the border is merged at each of its corners:
//  - one of the two edges at the corner is old: the new edge is spliced into that hole's chain;
//  - both are new and the corner lies on a border: the chain is led around the new triangle;
//  - both are old: that stretch of border is closed; where the two lay in different fans of the vertex, the
//  fans
//    between them are first linked elsewhere around the vertex, so that each hole stays one cyclic chain.
// A face that is not added leaves a valid mesh with the same faces. Time is linear in the valence of the
// corners.
[[nodiscard]] AddFace add_face(HalfEdgeMesh& mesh, const Triangle& triangle, FaceSource source);

// The half-edge from one vertex to another, or no_index. Linear in the smaller of the two valences.
[[nodiscard]] uint32_t find_half_edge(const HalfEdgeMesh& mesh, uint32_t from, uint32_t to);

// The mesh of a list of triangles. The source of each face is the index of its triangle.
// Errors: invalid_mesh naming the triangle, its vertices and what is wrong (index out of range, repeated
// vertex, directed edge used twice, vertex with several fans: see split_fans). Open meshes are no error.
[[nodiscard]] Result<HalfEdgeMesh> build_half_edges(std::span<const glm::dvec3> positions,
                                                    std::span<const Triangle> triangles);

// Gives every fan of triangles around a vertex its own copy of that vertex, appended at the end, so that a
// mesh whose edges are all paired becomes manifold. Order and orientation of the triangles stay.
[[nodiscard]] TriangleMesh split_fans(const TriangleMesh& mesh);

// The corners of a face, starting at the origin of faces[face].
[[nodiscard]] Triangle corners(const HalfEdgeMesh& mesh, uint32_t face);
[[nodiscard]] std::vector<Triangle> triangle_list(const HalfEdgeMesh& mesh);

// One half-edge loop per hole, in the order of their first half-edge.
[[nodiscard]] std::vector<std::vector<uint32_t>> border_loops(const HalfEdgeMesh& mesh);

// No BORDER half-edge.
[[nodiscard]] bool is_closed(const HalfEdgeMesh& mesh);

// All of: indices in range; twins mutual and opposite; next and prev inverse and head to tail; faces are
// cycles of three; BORDER chains hold BORDER half-edges only, with a face on their other side; outgoing as
// stated above; one turn around a vertex meets every half-edge that leaves it. For tests and debug checks:
// linear time.
[[nodiscard]] bool is_valid(const HalfEdgeMesh& mesh);

} // namespace brittle::fracture

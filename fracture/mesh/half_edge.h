// Half-edge meshes of triangles, stored as flat index arrays.
//
// "Real Time Voronoi Fracturing of Polygon Meshes", section 2.1.1. Each undirected edge is a pair of half-edges, twins
// of each other, in opposite directions. A half-edge with a face belongs to exactly one triangle (counter-clockwise
// seen from outside). A half-edge without a face (face == no_index) is a BORDER half-edge: it runs along the rim of a
// hole, and its next and prev lead around that hole in one cyclic chain. Every half-edge therefore has a twin, a next
// and a prev, in open and closed meshes alike; a closed mesh has no BORDER half-edge.
//
// add_face() inserts faces one at a time, in any order, and leaves a valid border after each. The mesh is plain data:
// the functions below keep the invariants that is_valid() states.
//
//     Result<HalfEdgeMesh> mesh = build_half_edges(cube.positions, cube.triangles);
//     if (mesh && is_closed(*mesh)) ...
//
// Not synchronised. Several threads may read one mesh.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/base/error.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

// The origin of a face.
struct FaceSource {
    // The input triangle (exterior face), or the site on the other side of the cap (interior face).
    uint32_t index = 0;
    bool interior = false; // whether the face is part of a cap

    bool operator==(const FaceSource&) const = default;
};

struct HalfEdge {
    uint32_t origin = no_index; // the vertex at its start
    uint32_t twin = no_index;   // the opposite half-edge of the edge
    uint32_t next = no_index;   // the successor around the face, or around the hole for a BORDER half-edge
    uint32_t prev = no_index;
    uint32_t face = no_index; // the triangle to its left; no_index for a BORDER half-edge
};

struct HalfEdgeMesh {
    std::vector<glm::dvec3> positions; // per vertex
    // Per vertex: an outgoing half-edge, a BORDER one if the vertex lies on the border; no_index without faces.
    std::vector<uint32_t> outgoing;
    std::vector<HalfEdge> half_edges;
    std::vector<uint32_t> faces;     // per face: one of its three half-edges
    std::vector<FaceSource> sources; // per face

    [[nodiscard]] const HalfEdge& operator[](uint32_t half_edge) const { return half_edges[half_edge]; }
    [[nodiscard]] HalfEdge& operator[](uint32_t half_edge) { return half_edges[half_edge]; }
    [[nodiscard]] bool is_border(uint32_t half_edge) const { return half_edges[half_edge].face == no_index; }
    [[nodiscard]] uint32_t target(uint32_t half_edge) const { return half_edges[half_edges[half_edge].twin].origin; }
};

// Appends a vertex without faces. Returns its index.
uint32_t add_vertex(HalfEdgeMesh& mesh, const glm::dvec3& position);

enum class AddFace {
    added,
    repeated_vertex, // two corners of the triangle are one vertex
    taken_edge,      // a directed edge of the triangle already has a face: a misoriented or non-manifold mesh
    taken_vertex     // the fan of a vertex is already complete, a second one would begin: non-manifold
};

// Inserts one triangle. An edge that exists as a BORDER half-edge becomes an edge of the triangle; a missing edge is
// added with a BORDER twin. The border is then merged at each corner:
//  - One edge at the corner is old: the new edge is spliced into the chain of that hole.
//  - Both edges are new and the corner lies on a border: the chain is routed around the new triangle.
//  - Both edges are old: that stretch of border closes. If the two edges lie in different fans of the vertex, the fans
//    between them are first relinked elsewhere around the vertex, so that each hole remains one cyclic chain.
// If the result is not `added`, the mesh has the same faces as before and is valid. Time is linear in the valence of
// the corners.
[[nodiscard]] AddFace add_face(HalfEdgeMesh& mesh, const Triangle& triangle, FaceSource source);

// Returns the half-edge from one vertex to another, or no_index. Time is linear in the smaller of the two valences.
[[nodiscard]] uint32_t find_half_edge(const HalfEdgeMesh& mesh, uint32_t from, uint32_t to);

// Builds the half-edge mesh of a triangle list. FaceSource::index of each face is the index of its triangle. The mesh
// may be open. Errors: invalid_mesh, with the triangle, its vertices and the fault (index out of range, repeated
// vertex, directed edge used twice, vertex with several fans; split_fans() removes the last).
[[nodiscard]] Result<HalfEdgeMesh> build_half_edges(std::span<const glm::dvec3> positions,
                                                    std::span<const Triangle> triangles);

// Gives every fan of triangles around a vertex its own copy of the vertex; copies are appended to the positions. A mesh
// whose edges are all paired becomes manifold. The order and orientation of the triangles are unchanged.
[[nodiscard]] TriangleMesh split_fans(const TriangleMesh& mesh);

// Returns the corners of a face, starting at the origin of faces[face].
[[nodiscard]] Triangle corners(const HalfEdgeMesh& mesh, uint32_t face);
[[nodiscard]] std::vector<Triangle> triangle_list(const HalfEdgeMesh& mesh);

// Returns one loop of BORDER half-edges per hole, ordered by the lowest half-edge index.
[[nodiscard]] std::vector<std::vector<uint32_t>> border_loops(const HalfEdgeMesh& mesh);

// Returns whether the mesh has no BORDER half-edge.
[[nodiscard]] bool is_closed(const HalfEdgeMesh& mesh);

// Checks all invariants, in linear time; for tests and debug checks:
//  - All indices are in range.
//  - Twins are mutual and have opposite directions.
//  - next and prev are inverse and join head to tail.
//  - Each face is a cycle of three half-edges.
//  - The chain of a BORDER half-edge consists of BORDER half-edges, each with a face on its twin.
//  - outgoing is as documented in HalfEdgeMesh.
//  - One turn around a vertex visits every half-edge that leaves it.
[[nodiscard]] bool is_valid(const HalfEdgeMesh& mesh);

} // namespace brittle::fracture

// Unites the parts of a mesh that pass through each other: the boundary of the region with winding number above 0.
//
//     const United united = unite(mesh);
//     std::fputs(describe(united.report).c_str(), stderr);
//     fracture(united.mesh, ...);
//
// A model is often many closed shells that pass through each other, or one that passes through itself. Fracture counts
// space as often as the surface winds around it (its winding number), so pieces of such a mesh overlap. unite() keeps
// what bounds the region that at least one part fills, and drops the walls inside.
//
// Which parts of which triangles remain is decided exactly, without tolerance (arrangement.h). Faces that lie on each
// other become one face, or none where they are back to back. New vertices are exact crossing points rounded to
// doubles. Lengths are in metres. The function is pure and deterministic, and may run in several threads.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

struct UniteReport {
    uint32_t cut_triangles = 0;     // of the input, divided where they meet others
    uint32_t dropped_triangles = 0; // of the input, of which nothing remains
    uint32_t new_vertices = 0;
    double volume_before = 0.0; // m^3, counted by winding number: what the pieces of a fracture add up to
    double volume_after = 0.0;  // m^3, of the region
    double inside_out = 0.0;    // m^3, >= 0: of space with a negative winding number, which is dropped
    uint32_t rounds = 0;
    // False where the rounding of new vertices leaves triangles that cross after the last round. The mesh is closed all
    // the same, and another call may mend it.
    bool complete = true;

    [[nodiscard]] bool changed() const { return rounds > 0; }
    // The share of the region's volume that the pieces of the mesh as it is have too much; negative where parts of it
    // are inside out. Zero up to rounding where parts only touch.
    [[nodiscard]] double excess() const {
        return volume_after > 0.0 ? (volume_before - volume_after) / volume_after : 0.0;
    }
};

struct United {
    TriangleMesh mesh;
    // The triangle of the input that each triangle is part of. An inside-out one is turned: the region is on its front.
    std::vector<uint32_t> source_triangle;
    UniteReport report;
};

// Returns the union. A mesh that bounds its region already is returned bit for bit, and so is the result of a complete
// call. Otherwise the result is a closed, oriented manifold: vertices that remain keep their order and come first, new
// ones follow; triangles are in the order of their sources; parts that only touch get vertices of their own. Triangles
// without area vanish.
//
// Preconditions: indices in range, coordinates finite and below 1e50 m, and each edge is used as often in one direction
// as in the other; check_topology() (topology.h) tells, and repair() makes such a mesh.
//
// `threads`: 0 for one per core. Their number changes no bit. Time is near linear in the triangles, plus what the
// crossing ones cost. Where a part meets more than eight others on average, by their boxes, the parts of each half are
// united first, so that walls inside others cost little.
[[nodiscard]] United unite(const TriangleMesh& mesh, uint32_t threads = 0);

// Returns what unite() would change, as its first round tells it: volumes are those of the union up to rounding, and
// `complete` is false where more rounds could follow. Takes less time than unite().
[[nodiscard]] UniteReport measure_union(const TriangleMesh& mesh, uint32_t threads = 0);

// A report of a few lines for a reader; empty where nothing changed.
[[nodiscard]] std::string describe(const UniteReport& report);

} // namespace brittle::fracture

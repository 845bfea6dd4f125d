// Mends flaws that modelling programs leave, where it is asked for. Import never repairs on its own.
//
//     const Repaired repaired = repair(mesh);
//     std::fputs(describe(repaired.report).c_str(), stderr);
//     fracture(repaired.mesh, ...);
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

struct RepairSettings {
    // Vertices on the rims of holes that lie this close to each other become one, in metres. Negative: 1e-6
    // of the diagonal of the box around all positions. 0: only vertices in the very same place. Vertices that
    // lie on no rim stay, however close.
    double weld_distance = -1.0;
    // Rims up to this length, in metres, are closed. 0: none.
    double close_holes = std::numeric_limits<double>::infinity();
    // Takes out patches that cover a place which is covered already, see remove_spare_patches().
    bool spare_patches = true;
    // Takes out single triangles that could only be closed by their own back.
    bool loose_triangles = true;
    // Turns a closed part inwards that lies inside an odd number of others. Otherwise such a part stays as it
    // faces.
    bool cavities = false;
    // Drops closed parts that have solid on both sides, or on neither: of two solids, one wholly inside the other, the
    // outer one is left, and space counts once. Parts that pass through others stay. For up to 1000 parts.
    bool covered_parts = false;
};

// What was changed, and what is left. Places are indices of the input.
struct RepairReport {
    struct Change {
        uint64_t count = 0;
        uint32_t first = no_index; // the lowest place; no_index for none

        void add(uint32_t place, uint64_t number = 1) {
            count += number;
            if (place < first) first = place;
        }
    };

    // The input cannot be read, and comes back as it is: an index out of range (the first triangle with one),
    // a coordinate that is not finite or beyond 1e50 m (the first vertex with one), more triangles than 2^30.
    Change bad_triangles;
    Change bad_vertices;
    bool too_large = false;

    Change welded_vertices;      // that became another
    Change degenerate_triangles; // dropped: they named a vertex twice, from the start or after welding
    Change duplicate_triangles;  // dropped: there before, or the back of another
    Change spare_triangles;      // dropped, see remove_spare_patches()
    uint64_t spare_patches = 0;
    Change loose_triangles;  // dropped
    Change covered_parts;    // dropped; the place is their first triangle
    Change turned_triangles; // their corners are named the other way around
    Change closed_holes;     // each rim counts; the place is its lowest vertex
    uint64_t new_triangles = 0;
    Change new_vertices; // in the middle of a hole, where nothing else fits; the place is as above

    // The place of an edge is its lower end.
    Change cut_edges;      // of surfaces that have one side only: both sides of the cut were filled
    Change split_edges;    // used by more than two triangles before
    Change halved_edges;   // that got a vertex in the middle: the same two fans meet in another edge too
    Change split_vertices; // copies, so that each has one fan of triangles; the place is what was copied

    // Left as they are.
    Change open_rims;         // longer than close_holes
    Change long_rims;         // of more than 4096 edges and not simple when seen from the front
    Change misoriented_edges; // their triangles face opposite ways
    Change crowded_edges;     // still used by more than two triangles
    Change flat_triangles;    // of three vertices on one line: without them the surface would be open

    [[nodiscard]] bool changed() const;
};

struct Repaired {
    TriangleMesh mesh;
    // For each triangle the one of the input that it was, or no_index for a new one; for materials and the
    // like. Two triangles have one source where an edge was halved.
    std::vector<uint32_t> source_triangle;
    RepairReport report;
};

// Makes a closed, oriented, manifold mesh of one that is nearly that:
//  1. Vertices on rims are welded.
//  2. Triangles that name a vertex twice go. Of triangles with the same vertices and orientation the first
//     stays; of one and its back neither, or one where the surface would be open without.
//  3. Spare patches go.
//  4. Triangles are turned until neighbours agree, the fewer ones of each patch.
//  5. Holes are closed: rims in one plane that lie in each other together, the others one by one in their
//     plane, also where they leave it, if they are simple as seen along its normal. Else with the least area
//     (up to 64 edges) or the shortest new edges. No triangle is made that is there already; where that
//     leaves nothing, a new vertex in the middle takes all sides. A surface of one side is cut open first.
//  6. Closed parts are turned outwards, those inside an odd number of others inwards.
//  7. Where more than two triangles meet in an edge, pairs of them are separated, so that what is solid
//     between two stays together. Every fan of triangles around a vertex gets its own copy of it.
//  8. Parts that others cover are dropped, where that is asked for.
// This is repeated until nothing changes, which is nearly always at once.
//
// Vertices keep their indices and places, new ones are appended, those that are used no more stay. Triangles
// keep their order, new ones are appended. A mesh without flaws comes back bit by bit, and so does what came
// out of a repair. Whatever can be read becomes a closed manifold, but for rims that are left open (above);
// flat sheets become solids without volume, and what was no surface becomes no sensible one. Parts that pass
// through each other stay so. What cannot be read comes back as it is.
//
// Deterministic. O(T log T), and O(n^2) for a rim of n edges that is not simple. 0.3 s for a million
// triangles without flaws, 3 s where a tenth of them is missing.
[[nodiscard]] Repaired repair(const TriangleMesh& mesh, const RepairSettings& settings = {});

// For people: a line for each kind of change, with how often and where first, then what is left. Empty where
// there is nothing to tell.
[[nodiscard]] std::string describe(const RepairReport& report);

struct Repair {
    TriangleMesh mesh;
    uint32_t removed_triangles = 0;
    uint32_t removed_patches = 0; // connected groups of them
};

// Removes patches that cover a place which is covered already, so that three triangles meet along their rims.
// Poorly merged quads are the usual case: one quad split along both diagonals, four triangles where two
// belong (the horse of glmark2 has six of them).
//
// A patch is what stays connected when the mesh is cut along all edges that are not used exactly twice. It is
// spare when it uses each edge of its rim once, each of them remains used in both directions without it, and
// fewer edges are then used more often in one direction than in the other. So a solid that touches itself or
// another along an edge loses nothing, while an inner wall goes. Where several patches could go, one with
// misoriented edges inside goes first, then the one with fewer triangles, then the one later in the file.
// Positions and order stay; a mesh without spare patches comes back as it is. Deterministic, O(T log T).
[[nodiscard]] Repair remove_spare_patches(const TriangleMesh& mesh);

} // namespace brittle::fracture

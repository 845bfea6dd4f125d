// Repairs flaws that modelling programs leave in meshes. Import never repairs on its own.
//
//     const Repaired repaired = repair(mesh);
//     std::fputs(describe(repaired.report).c_str(), stderr);
//     fracture(repaired.mesh, ...);
//
// Lengths are in metres. All functions are pure and deterministic, and may run in several threads.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

struct RepairSettings {
    // Vertices on the rims of holes within this distance of each other are merged, in metres. Negative: 1e-6 of the
    // diagonal of the box around all positions. 0: only vertices at the very same position. A vertex on no rim is never
    // merged.
    double weld_distance = -1.0;
    // The longest rim, in metres, that is closed. 0: none.
    double close_holes = std::numeric_limits<double>::infinity();
    // New vertices in holes. none: only where nothing else closes them, or closes them without passing through the
    // surface. flat: as dense as around, in the plane of each triangle of the fill. smooth: these, moved so that the
    // curvature around the hole goes on.
    enum class Remesh { none, flat, smooth };
    Remesh remesh_holes = Remesh::none;
    // Removes patches that cover a place which is already covered, see remove_spare_patches().
    bool spare_patches = true;
    // Removes single triangles that only their own back could close.
    bool loose_triangles = true;
    // Turns a closed part inwards where it lies inside an odd number of other parts. Otherwise such a part keeps its
    // orientation.
    bool cavities = false;
    // Drops closed parts with solid on both sides or on neither: of two solids, one wholly inside the other, the outer
    // one remains, and space counts once. Parts that pass through others stay. For up to 1000 parts.
    bool covered_parts = false;
};

// The changes, and the flaws that remain. Places are indices of the input.
struct RepairReport {
    struct Change {
        uint64_t count = 0;
        uint32_t first = no_index; // the lowest place; no_index where count is 0

        void add(uint32_t place, uint64_t number = 1) {
            count += number;
            if (place < first) first = place;
        }
    };

    // The input is unreadable and is returned unchanged: an index out of range (place: the first triangle with one), a
    // coordinate that is not finite or beyond 1e50 m (place: the first vertex with one), more triangles than 2^30.
    Change bad_triangles;
    Change bad_vertices;
    bool too_large = false;

    Change welded_vertices;      // merged into another vertex
    Change degenerate_triangles; // dropped: they name a vertex twice, in the input or after welding
    Change duplicate_triangles;  // dropped: repetitions or backs of other triangles
    Change spare_triangles;      // dropped, see remove_spare_patches()
    uint64_t spare_patches = 0;
    Change loose_triangles;  // dropped, see RepairSettings
    Change covered_parts;    // dropped; the place is the first triangle of a part
    Change turned_triangles; // with reversed orientation
    Change closed_holes;     // one per rim; the place is its lowest vertex
    uint64_t new_triangles = 0;
    Change new_vertices;   // in holes; the place as above
    Change crossing_fills; // holes of which every fill that was tried passes through the surface; the place as above
    uint64_t fill_crossings = 0; // pairs of triangles there

    // The place of an edge is its lower vertex.
    Change cut_edges;      // of one-sided surfaces; both sides of the cut were filled
    Change split_edges;    // were used by more than two triangles
    Change halved_edges;   // received a vertex in the middle: the two fans at their ends share another edge too
    Change split_vertices; // copies, so that each vertex has one fan of triangles; the place is the original

    // Unchanged:
    Change open_rims;         // longer than close_holes
    Change long_rims;         // of more than 4096 edges, and not simple in projection along the normal
    Change misoriented_edges; // their two triangles have opposite orientations
    Change crowded_edges;     // used by more than two triangles still
    Change flat_triangles;    // of three vertices on one line; the surface would be open without them

    [[nodiscard]] bool changed() const;
};

struct Repaired {
    TriangleMesh mesh;
    // The triangle of the input that each triangle comes from, for materials and other attributes; no_index for a new
    // one. Two triangles share a source where an edge was halved.
    std::vector<uint32_t> source_triangle;
    RepairReport report;
};

// Makes a closed, oriented manifold of a mesh that is nearly one:
//  1. Welds vertices on rims.
//  2. Drops triangles that name a vertex twice. Of triangles with equal vertices and orientation the first stays. Of a
//     triangle and its back neither stays, or one where the surface would be open without it.
//  3. Drops spare patches.
//  4. Turns triangles until neighbours agree, the smaller number in each patch.
//  5. Closes holes. Rims in one plane, one inside the other, are filled together. Any other rim is filled on its own:
//     in its plane, or in projection along its normal where it is simple there, else with the least area (up to 64
//     edges) or the shortest new edges. Where that passes through the surface, the fill of least area (up to 256 edges)
//     and then the same as a smooth surface with new vertices are tried, and the one with the fewest crossings stays
//     (Liepa, "Filling holes in meshes", 2003). A fill never repeats an existing triangle; where no fill remains, all sides are
//     joined to a new vertex in the middle. A one-sided surface is cut open first.
//  6. Turns closed parts outwards, and those inside an odd number of others inwards (RepairSettings::cavities).
//  7. Separates edges with more than two triangles into pairs, such that the two triangles around one wedge of solid
//     stay together. Every fan of triangles around a vertex gets its own copy of the vertex.
//  8. Drops covered parts (RepairSettings::covered_parts).
// The steps repeat until nothing changes, which is nearly always after one round.
//
// Vertices keep their indices and positions; new ones are appended, and unused ones stay. Triangles keep their order;
// new ones are appended. A mesh without flaws is returned bit for bit, and so is the result of a repair. Every readable
// mesh becomes a closed manifold, except for the rims that stay open (above). Flat sheets become solids without volume,
// and a soup of triangles becomes a closed surface without a sensible shape. Parts that pass through each other still
// do. An unreadable mesh is returned unchanged.
//
// Deterministic. O(T log T), and O(n^2) for a rim of n edges that is not simple.
[[nodiscard]] Repaired repair(const TriangleMesh& mesh, const RepairSettings& settings = {});

// A report for a reader: one line per kind of change, with its count and first place, then the remaining flaws. Empty
// where there is nothing to report.
[[nodiscard]] std::string describe(const RepairReport& report);

struct Repair {
    TriangleMesh mesh;
    uint32_t removed_triangles = 0;
    uint32_t removed_patches = 0; // connected groups of them
};

// Removes patches that cover a place which is already covered, so that three triangles meet along their rims. The usual
// cause is a badly merged quad: one quad split along both diagonals, four triangles instead of two (the horse of
// glmark2 has six of these quads).
//
// A patch is a connected part of the mesh after cutting along all edges that are not used exactly twice. It is spare
// when it uses each edge of its rim once, when each of these edges remains used in both directions without it, and when
// fewer edges are then used more often in one direction than in the other. So a solid that touches itself or another
// along an edge loses nothing, while an inner wall is removed. Where several patches qualify, one with misoriented
// edges inside goes first, then the one with fewer triangles, then the one later in the file. Positions and order stay;
// a mesh without spare patches is returned unchanged. Deterministic, O(T log T).
[[nodiscard]] Repair remove_spare_patches(const TriangleMesh& mesh);

} // namespace brittle::fracture

// Inspects a mesh: lists its flaws and predicts how fracture() will treat it.
//
//     const Inspection inspection = inspect(mesh);
//     std::puts(describe(inspection).c_str());
//
// The mesh is not changed; repair() (repair.h) mends it. Lengths are in metres. All functions are pure and may run in
// several threads.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "fracture/base/error.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/mesh/mesh.h"
#include "fracture/mesh/topology.h"

namespace brittle::fracture {

struct InspectSettings {
    // The maximum number of pairs of triangles with overlapping boxes that are tested for intersection. Bounds the time
    // to a third of a second for meshes where everything overlaps.
    uint64_t max_pairs = 4'000'000;
    // The maximum number of places listed per kind. The counts include all places.
    size_t max_places = 1000;
    // The maximum number of triangles whose thickness is measured, spread evenly over the list of triangles.
    uint32_t max_measured = 20'000;
    // The maximum number of nodes of the tree of triangles that the rays of these measurements enter, a tenth of a
    // second. Where boxes overlap so much that a ray enters many, fewer triangles are measured, but at least a thousand.
    uint64_t max_visits = 1'000'000;
};

// The places of the flaws: edges as (lower, higher) vertex, triangles, pairs of triangles, vertices. In ascending
// order.
struct Places {
    std::vector<glm::uvec2> open_edges, misoriented_edges, non_manifold_edges, crossings;
    std::vector<uint32_t> non_manifold_vertices, flat_triangles, duplicate_triangles, thin_triangles;
};

struct Inspection {
    TopologyReport topology;
    Box box;
    double area = 0.0;   // m^2
    double volume = 0.0; // m^3; meaningless where the surface is open

    uint64_t unused_vertices = 0;
    uint64_t flat_triangles = 0; // exactly no area: corners on one line, or equal
    std::optional<uint32_t> first_flat_triangle;
    uint64_t duplicate_triangles = 0;          // with the three vertices of an earlier triangle, in either orientation
    std::optional<glm::uvec2> first_duplicate; // and the earlier triangle

    // Pairs of triangles that cross, touch or lie on each other beyond their common vertices and edges. Exact.
    uint64_t intersections = 0;
    std::optional<glm::uvec2> first_intersection;
    bool all_pairs_seen = true; // false: max_pairs was reached, and there may be more intersections

    // The least thickness, measured from a triangle straight through the solid to the opposite side, over the measured
    // triangles.
    std::optional<double> min_thickness; // m
    uint32_t thinnest_triangle = 0;
    double thin_share = 0.0; // share of the measured surface with a thickness below thin_limit times the box's diagonal
    static constexpr double thin_limit = 0.01;

    struct Rim { // of a hole: connected open edges
        uint64_t edges = 0;
        double length = 0.0; // m
        uint32_t vertex = 0; // the lowest one on it
    };
    std::vector<Rim> rims; // longest first

    struct Component { // connected through vertices
        uint32_t first_triangle = 0;
        uint64_t triangles = 0;
        double volume = 0.0;        // signed
        bool closed = false;        // every edge is used once in each direction
        bool is_cavity = false;     // closed, facing inwards, inside another component
        bool is_inside_out = false; // closed, facing inwards, inside no other component
    };
    std::vector<Component> components; // in ascending order of first_triangle

    Places places;

    // The status that fracture() would return; nothing where it accepts the mesh.
    std::optional<Status> refusal;
};

// Inspects any mesh. An index out of range or a coordinate that is not finite gives the refusal invalid_mesh and
// nothing else.
[[nodiscard]] Inspection inspect(const TriangleMesh& mesh, const InspectSettings& settings = {});

// A report of several lines for a reader: the findings, how fracture() treats them, and the remedy.
[[nodiscard]] std::string describe(const Inspection& inspection);

} // namespace brittle::fracture

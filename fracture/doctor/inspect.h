// What is the matter with a mesh, and what fracture() will do with it.
//
//     const Inspection inspection = inspect(mesh);
//     std::puts(describe(inspection).c_str());
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
    // Pairs of triangles with overlapping boxes that are looked at for intersections, at most: bounds the time (a
    // second or so) for meshes where everything overlaps.
    uint64_t max_pairs = 10'000'000;
    // Places of each kind that are listed, at most; the counts are of all.
    size_t max_places = 1000;
    // Triangles whose thickness is measured, at most, spread evenly over the list of triangles.
    uint32_t max_measured = 20'000;
};

// Where it is wrong: edges as (smaller, larger) vertex, triangles, pairs of triangles, vertices. The lowest come first.
struct Places {
    std::vector<glm::uvec2> open_edges, misoriented_edges, non_manifold_edges, crossings;
    std::vector<uint32_t> non_manifold_vertices, flat_triangles, duplicate_triangles, thin_triangles;
};

struct Inspection {
    TopologyReport topology;
    Box box;
    double area = 0.0;   // m^2
    double volume = 0.0; // m^3; means little where the surface is open

    uint64_t unused_vertices = 0;
    uint64_t flat_triangles = 0; // exactly no area: corners on one line, or equal
    std::optional<uint32_t> first_flat_triangle;
    uint64_t duplicate_triangles = 0;          // the same three vertices as one before, either way around
    std::optional<glm::uvec2> first_duplicate; // with the one before

    // Of triangles: they cross, touch, or lie on each other without sharing all that they touch in. Exact.
    uint64_t intersections = 0;
    std::optional<glm::uvec2> first_intersection;
    bool all_pairs_seen = true; // false: max_pairs was reached, and there may be more

    // Straight through from a triangle to the other side, over those that were measured.
    std::optional<double> min_thickness; // m
    uint32_t thinnest_triangle = 0;
    double thin_share = 0.0; // of the surface measured, that is thinner than thin_limit of the box's diagonal
    static constexpr double thin_limit = 0.01;

    struct Rim { // of a hole: open edges that hang together
        uint64_t edges = 0;
        double length = 0.0; // m
        uint32_t vertex = 0; // one on it, the least
    };
    std::vector<Rim> rims; // longest first

    struct Component { // connected over vertices
        uint32_t first_triangle = 0;
        uint64_t triangles = 0;
        double volume = 0.0;        // signed
        bool closed = false;        // every edge is used once in each direction
        bool is_cavity = false;     // closed, inwards, inside another
        bool is_inside_out = false; // closed, inwards, inside none
    };
    std::vector<Component> components; // by first triangle

    Places places;

    // What fracture() would refuse it with; nothing where it takes the mesh.
    std::optional<Status> refusal;
};

// For any mesh: indices out of range and coordinates that are not finite give `refusal` invalid_mesh and nothing else.
[[nodiscard]] Inspection inspect(const TriangleMesh& mesh, const InspectSettings& settings = {});

// For people: what was found, then what fracture will do and what to do about it. Several lines.
[[nodiscard]] std::string describe(const Inspection& inspection);

} // namespace brittle::fracture

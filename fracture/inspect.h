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

#include "fracture/error.h"
#include "fracture/mass_properties.h"
#include "fracture/mesh.h"
#include "fracture/topology.h"

namespace brittle::fracture {

struct InspectSettings {
    // Pairs of triangles with overlapping boxes that are looked at for intersections, at most: bounds the time (a
    // second or so) for meshes where everything overlaps.
    uint64_t most_pairs = 10'000'000;
};

struct Inspection {
    TopologyReport topology;
    Box box;
    double area = 0.0;   // m^2
    double volume = 0.0; // m^3; means little where the surface is open

    uint64_t unused_vertices = 0;
    uint64_t flat_triangles = 0; // exactly no area: corners on one line, or equal
    std::optional<uint32_t> first_flat_triangle;
    uint64_t duplicate_triangles = 0; // the same three vertices as one before, either way around
    std::optional<glm::uvec2> first_duplicate; // with the one before

    // Of triangles: they cross, touch, or lie on each other without sharing all that they touch in. Exact.
    uint64_t intersections = 0;
    std::optional<glm::uvec2> first_intersection;
    bool all_pairs_seen = true; // false: most_pairs was reached, and there may be more

    struct Rim { // of a hole: open edges that hang together
        uint64_t edges = 0;
        double length = 0.0; // m
        uint32_t vertex = 0; // one on it, the least
    };
    std::vector<Rim> rims; // longest first

    struct Component { // connected over vertices
        uint32_t first_triangle = 0;
        uint64_t triangles = 0;
        double volume = 0.0;   // signed
        bool closed = false;   // every edge is used once in each direction
        bool is_cavity = false;     // closed, inwards, inside another
        bool is_inside_out = false; // closed, inwards, inside none
    };
    std::vector<Component> components; // by first triangle

    // What fracture() would refuse it with; nothing where it takes the mesh.
    std::optional<Status> refusal;
};

// For any mesh: indices out of range and coordinates that are not finite give `refusal` invalid_mesh and nothing else.
[[nodiscard]] Inspection inspect(const TriangleMesh& mesh, const InspectSettings& settings = {});

// For people: what was found, then what fracture will do and what to do about it. Several lines.
[[nodiscard]] std::string describe(const Inspection& inspection);

} // namespace brittle::fracture

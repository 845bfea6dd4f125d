// The one call: a closed mesh and Voronoi sites go in, watertight pieces come out.
//
//     Result<TriangleMesh> mesh = import_mesh("bunny.obj");
//     auto sites = uniform_sites(bounds(*mesh), 100, 1);
//     Result<Fragments> fragments = fracture(*mesh, sites);
//
// Equal input gives equal output, bit for bit, on every machine and with every thread count.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include <glm/vec3.hpp>

#include "fracture/error.h"
#include "fracture/fragments.h"
#include "fracture/mesh.h"

namespace brittle::fracture {

enum class Algorithm {
    exact,     // a restricted Voronoi diagram decided by exact predicates (exact/exact.h): the fast one
    sequential // the paper's Algorithm 1, plane by plane: the readable reference
};

// The name as on the command line and in recipes.
[[nodiscard]] constexpr const char* to_string(Algorithm algorithm) {
    switch (algorithm) {
    case Algorithm::exact: return "exact";
    case Algorithm::sequential: return "sequential";
    }
    return "unknown";
}

struct Settings {
    Algorithm algorithm = Algorithm::exact;
    uint32_t threads = 0; // cells are worked on side by side; 0 = one thread a core
    // Called now and then with the share of the work done, in [0, 1], from one thread at a time. May be empty.
    std::function<void(double)> progress{};
};

// Cuts the mesh along the bisectors of the sites: one or more pieces (islands) per non-empty cell.
// Errors: empty_mesh, invalid_mesh (not closed, not manifold, not oriented, inside out, without volume,
// non-finite or beyond 1e50), invalid_sites (none, non-finite, beyond 1e50; for the exact
// algorithm also beyond 1e30 mesh sizes), invalid_setting (more than 1024 threads), each with what and
// where. Solids that touch in a vertex are cut as if each had its own. Pieces whose volume is only rounding
// are left out. Of duplicate sites the one with the lowest index owns the cell, the others are empty.
[[nodiscard]] Result<Fragments> fracture(const TriangleMesh& mesh, std::span<const glm::dvec3> sites,
                                         const Settings& settings = {});

} // namespace brittle::fracture

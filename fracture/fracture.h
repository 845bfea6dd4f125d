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
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/error.h"
#include "fracture/fragments.h"
#include "fracture/mesh.h"

namespace brittle::fracture {

class Classifier;
class WorkLog;

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
    // A group for each site, or none: no cut is made between cells of one group. What of a group hangs together is one
    // piece, with the least of its sites. For the exact algorithm.
    std::vector<uint32_t> groups{};
    // Of each site, m^2, or none: cells of the power diagram, in which a site reaches as far as a ball of that squared radius
    // would. Graded sizes: heavy sites have large cells, light ones beside them small ones or none.
    std::vector<double> weights{};
    // m^3. Smaller pieces become part of the neighbour that they have the largest contact with, the smallest first, until
    // none is left that has a neighbour. 0 keeps all. For the exact algorithm.
    double min_volume = 0.0;
    // What guesses where vertices and triangles lie, on a GPU for instance (classifier.h); null for none. The pieces are
    // the same. For the exact algorithm.
    Classifier* classifier = nullptr;
    // Receives what each thread did and when (work_log.h); null for nothing. For the exact algorithm.
    WorkLog* work_log = nullptr;
    // Called now and then with the share of the work done, in [0, 1], from one thread at a time. May be empty.
    std::function<void(double)> progress{};
    // Asked now and then, by one thread at a time; true ends the fracture with Status::cancelled. May be empty. The exact
    // algorithm asks between its phases.
    std::function<bool()> cancelled{};
};

// Memory of a fracture, kept for the next one: from the second fracture of similar size on hardly anything is allocated,
// and a mesh that was cut before is not checked anew. Use one for each thread that fractures.
class Workspace {
  public:
    Workspace();
    ~Workspace();
    Workspace(Workspace&&) noexcept;
    Workspace& operator=(Workspace&&) noexcept;

    struct State;
    [[nodiscard]] State& state() { return *state_; }

  private:
    std::unique_ptr<State> state_;
};

// Cuts the mesh along the bisectors of the sites: one or more pieces (islands) per non-empty cell.
//
// Refused, each by a status of its own, with counts of all faults and the place of the first (check_topology() in
// topology.h gives the same as numbers):
//  - empty_mesh: no triangles.
//  - invalid_mesh: a position that is not finite or beyond 1e50, an index out of range, a triangle that names a vertex
//    twice, more than 2^28 triangles or vertices.
//  - not_closed: an edge of one triangle.
//  - non_manifold: an edge of three triangles or more, cut or not, even where its triangles could be paired.
//  - not_oriented: an edge whose two triangles face opposite ways.
//  - no_volume, inside_out: the surface encloses nothing but rounding; its volume is negative.
//  - invalid_sites: none, one that is not finite or beyond 1e50, for the exact algorithm also beyond 1e30 mesh sizes.
//  - cancelled: Settings::cancelled said so.
//  - invalid_setting: more than 1024 threads; groups or weights of which there are not as many as sites; a weight that is not finite; a minimum volume that is
//    negative or not finite; groups or a minimum volume for the sequential algorithm.
//
// Not refused:
//  - Solids that touch in a vertex are cut as if each had its own.
//  - A surface that passes through itself or another is cut as it is: space counts as often as the surface winds around
//    it. Pieces are closed and their signed volumes sum to the input's, but overlap where the input does; what is
//    inside out there gives pieces of negative volume (Certificate::smallest_piece tells).
//  - What encloses nothing is left out: two triangles back to back. Pieces whose volume is only rounding become part of
//    a neighbour, or are left out where they have none.
//  - Of duplicate sites the one with the lowest index owns the cell, the others are empty.
[[nodiscard]] Result<Fragments> fracture(const TriangleMesh& mesh, std::span<const glm::dvec3> sites,
                                         const Settings& settings = {});

// The same into `out`, whose memory is reused; unspecified after an error.
[[nodiscard]] Result<void> fracture(const TriangleMesh& mesh, std::span<const glm::dvec3> sites,
                                    const Settings& settings, Workspace& workspace, Fragments& out);

} // namespace brittle::fracture

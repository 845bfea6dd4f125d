// How fracture() cuts: the algorithm, threads, groups and weights of sites, and who watches.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

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
    case Algorithm::exact:
        return "exact";
    case Algorithm::sequential:
        return "sequential";
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

} // namespace brittle::fracture

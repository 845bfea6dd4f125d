// Settings of fracture(): algorithm, threads, roughness, groups and weights of sites, callbacks. The defaults suit most
// meshes.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <glm/vec3.hpp>

namespace brittle::fracture {

class Classifier;
class WorkLog;

enum class Algorithm {
    exact,     // the default: a restricted Voronoi diagram with exact predicates (exact/exact.h)
    sequential // the reference: Algorithm 1 of the paper, one plane at a time (sequential/sequential.h)
};

// Returns the name that the command line and recipes use.
[[nodiscard]] constexpr const char* to_string(Algorithm algorithm) {
    switch (algorithm) {
    case Algorithm::exact:
        return "exact";
    case Algorithm::sequential:
        return "sequential";
    }
    return "unknown";
}

// Cuts that are not flat (rough/rough.h). Both sides of a cut agree bit for bit, its border on the surface wanders too,
// and the volumes of the pieces still add up.
struct Roughness {
    double amount = 0.0;     // from 0, flat cuts, to 1
    double wavelength = 0.0; // the largest, m; 0 means the typical distance of adjacent sites
    // Stretches the noise along this direction by the factor |grain|, from 1/16 to 16: above 1 for splinters along the
    // grain of wood, below 1 for the layers of slate. 0 means no direction.
    glm::dvec3 grain{0.0};
    // Octaves of noise, 1 to 6, each with half the wavelength of the one before. An octave more makes four times as
    // many triangles of a cut.
    uint32_t detail = 1;
    uint64_t seed = 1;
    // A bound of the triangles that roughness adds, as estimated before the cut: octaves are left out until it holds.
    uint64_t max_triangles = 4'000'000;

    [[nodiscard]] bool is_flat() const { return amount == 0.0; }
};

struct Settings {
    Algorithm algorithm = Algorithm::exact;
    uint32_t threads = 0; // cells are processed in parallel; 0 means one thread per core
    // One group number per site, or empty. No cut is made between cells of one group: the connected cells of a group
    // form one piece, whose site is the lowest site index among them. Algorithm::exact only.
    std::vector<uint32_t> groups{};
    // One group number per site, or empty: pieces of one group will be merged by the caller (pieces/merge.h). Rough cuts
    // leave the cuts within a group coarse, which costs far less. Read only where `groups` is empty.
    std::vector<uint32_t> merged_later{};
    // One weight per site, in m^2, or empty. The cells are then those of the power diagram: the distance of a point x
    // to site s is |x - s|^2 - weight, that to a ball of radius sqrt(weight). Weights grade the sizes of pieces: a
    // heavy site has a large cell, a light site beside it a small cell or none.
    std::vector<double> weights{};
    // Minimum volume of a piece, m^3; 0 keeps all pieces. Smaller pieces, the smallest first, are merged into the
    // neighbour with the largest contact area, until every piece below the minimum is without neighbours.
    // Algorithm::exact only.
    double min_volume = 0.0;
    // Cuts that are not flat. Algorithm::exact only.
    Roughness rough{};
    // Classifies vertices and triangles ahead of the exact predicates, for example on a GPU (classifier.h); null for
    // none. The pieces do not depend on it. Must outlive the call. Algorithm::exact only, and only without weights.
    Classifier* classifier = nullptr;
    // Receives a time line of the threads (work_log.h); null for none. Must outlive the call. Algorithm::exact only.
    WorkLog* work_log = nullptr;
    // Called with the completed share of the work, in [0, 1], by one thread at a time. May be empty.
    std::function<void(double)> progress{};
    // Polled by one thread at a time, many times in each phase; returning true ends the fracture with Status::cancelled
    // within milliseconds. May be empty.
    std::function<bool()> cancelled{};
};

} // namespace brittle::fracture

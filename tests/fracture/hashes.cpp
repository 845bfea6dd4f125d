// Prints the hashes of sixteen fractures, on which every compiler, optimisation level and thread count must agree.
// tests/fracture/hashes.txt holds the expected output; tools/check-hashes compares, and --update rewrites the file.
//   fracture_hashes [THREADS...]     1, 2, 4 and 8 threads where none are given
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "fracture/fracture.h"
#include "fracture/pieces/certificate.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "tests/fracture/lattice.h"

using namespace brittle::fracture;
using namespace brittle::fracture::test;

namespace {

std::vector<uint32_t> thread_counts{1, 2, 4, 8};

bool print(const char* name, const TriangleMesh& mesh, const Sites& sites, Settings settings = {}) {
    uint64_t first = 0;
    for (const uint32_t threads : thread_counts) {
        settings.threads = threads;
        const auto fragments = fracture(mesh, sites, settings);
        if (!fragments) return std::printf("%s: %s\n", name, fragments.error().message.c_str()), false;
        const uint64_t one = hash(*fragments);
        if (threads == thread_counts.front()) first = one;
        if (one != first) return std::printf("%s: differs with %u threads\n", name, threads), false;
    }
    std::printf("%-28s %016" PRIx64 "\n", name, first);
    return true;
}

} // namespace

int main(int argc, char** argv) {
    if (argc > 1) thread_counts.clear();
    for (int k = 1; k < argc; ++k) thread_counts.push_back(static_cast<uint32_t>(std::atoi(argv[k])));
    const auto uniform = [](const TriangleMesh& mesh, uint32_t n) { return uniform_sites(bounds(mesh), n, 1); };
    const TriangleMesh ball = icosphere(4), ring = torus(), knot = torus_knot(), hollow = hollow_sphere(3);
    const TriangleMesh cubes = lattice_cube(8), sponge = menger_sponge(2), animal = four_legged_animal(48);
    Settings sequential, groups, merged;
    sequential.algorithm = Algorithm::sequential;
    for (uint32_t k = 0; k < 60; ++k) groups.groups.push_back(k % 4);
    merged.min_volume = 0.02;
    Settings rough, rough_groups, grain;
    rough.rough = {.amount = 0.5, .detail = 2};
    rough_groups.groups = groups.groups;
    rough_groups.rough = {.amount = 1.0};
    grain.rough = {.amount = 0.8, .wavelength = 0.3, .grain = {0.0, 4.0, 0.0}};
    TriangleMesh far = ball;
    for (glm::dvec3& p : far.positions) p = p * 1e-3 + glm::dvec3(1e6, -1e6, 1e6);
    bool good = print("icosphere", ball, uniform(ball, 100));
    good &= print("torus", ring, uniform(ring, 50));
    good &= print("torus_knot", knot, uniform(knot, 200));
    good &= print("hollow_sphere", hollow, uniform(hollow, 40));
    good &= print("menger_sponge", sponge, uniform(sponge, 30));
    good &= print("animal", animal, uniform(animal, 60));
    good &= print("far_away", far, uniform(far, 20));
    good &= print("lattice_cube_lattice", cubes, lattice(8));
    good &= print("icosphere_lattice", ball, lattice(4));
    good &= print("own_vertices", ball, Sites(ball.positions.begin(), ball.positions.begin() + 60));
    good &= print("groups", ball, uniform(ball, 60), groups);
    good &= print("min_volume", ball, uniform(ball, 100), merged);
    good &= print("rough", ring, uniform(ring, 50), rough);
    good &= print("rough_groups", ball, uniform(ball, 60), rough_groups);
    good &= print("rough_grain", cuboid({1.0, 3.0, 0.5}), uniform_sites({{-0.5, -1.5, -0.25}, {0.5, 1.5, 0.25}}, 20, 1),
                  grain);
    good &= print("sequential", icosphere(2), uniform(ball, 20), sequential);
    return good ? 0 : 1;
}

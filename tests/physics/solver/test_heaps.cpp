// Heaps of hundreds of pieces: how deep they sink into the ground, when they sleep, and that they gain no energy.
#include "physics/world/pieces.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <string>

#include <doctest/doctest.h>

#include "fracture/fracture.h"
#include "fracture/io/import.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"
#include "tests/physics/run_log.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

constexpr const char* bunny_file = "/usr/share/glmark2/models/bunny.obj"; // assets/SOURCES.md

// A metre long, 30 cm above the ground.
fracture::TriangleMesh lifted(fracture::TriangleMesh mesh) {
    const fracture::Box box = fracture::bounds(mesh);
    const double longest = std::max({box.size().x, box.size().y, box.size().z});
    for (glm::dvec3& p : mesh.positions)
        p = (p - glm::dvec3(box.centre().x, box.min.y, box.centre().z)) / longest + glm::dvec3(0.0, 0.3, 0.0);
    return mesh;
}

// The height of the lowest of a body's points, m.
float lowest_of(const Pose& pose, const auto& points) {
    float lowest = std::numeric_limits<float>::infinity();
    for (const auto& p : points) lowest = std::min(lowest, (pose.position + pose.orientation * glm::vec3(p)).y);
    return lowest;
}

void drop(const std::string& name, const fracture::TriangleMesh& mesh, uint32_t sites, uint64_t seed) {
    RunLog log(std::to_string(sites) + " sites in the " + name + ", seed " + std::to_string(seed));
    INFO(log);
    const auto fragments = fracture::fracture(mesh, fracture::uniform_sites(fracture::bounds(mesh), sites, seed));
    REQUIRE(fragments);
    const PieceHulls hulls = collision_hulls(*fragments);
    World world;
    const auto bodies = add_pieces(world, *fragments, {}, {}, hulls);
    REQUIRE(bodies);
    test_bodies::EnergyBooks energy(world);
    int steps = 0;
    for (; steps < 1200 && world.awake_count() > 0; ++steps) {
        world.step();
        log.look(world);
        energy.look(world);
    }
    float hull = 1.0f, vertex = 1.0f, centre = 1.0f;
    for (size_t i = 0; i < bodies->size(); ++i) {
        const Pose pose = world.pose((*bodies)[i]);
        const fracture::Piece& piece = fragments->pieces[i];
        std::vector<glm::dvec3> corners;
        for (const glm::dvec3& p : fragments->positions_of(piece)) corners.push_back(p - piece.mass.centre_of_mass);
        hull = std::min(hull, lowest_of(pose, hulls[i]->points) - hulls[i]->margin);
        vertex = std::min(vertex, lowest_of(pose, corners));
        centre = std::min(centre, pose.position.y);
    }
    MESSAGE(bodies->size() << " pieces asleep after " << steps / 120.0 << " s; lowest hull " << hull << " m, vertex "
                           << vertex << " m, centre " << centre << " m; energy rose by " << energy.risen / energy.start
                           << " of the start in all, above the least before by "
                           << energy.max_above_min / energy.start);
    CHECK(world.awake_count() == 0);
    CHECK(energy.steepest < 1e-4 * energy.start);
    CHECK(energy.risen < 5e-4 * energy.start);         // measured: 1.2e-4, and 3.4e-4 in 75 heaps
    CHECK(energy.max_above_min < 2e-4 * energy.start); // measured: 5e-5, and 1.7e-4
    CHECK(hull > -2e-3f);
    // Of pieces a fifth of a metre long, hulls of 32 points leave out and margins round off corners of 1 to 6 mm.
    CHECK(vertex > -0.008f);
    CHECK(centre > -1e-3f);
}

// Sanitizers make a drop ten times as long, and every drop runs the same code. BRITTLE_LONG_RUNS=1 drops 75
// (HACKING.md).
uint64_t last_seed() {
    const char* const long_runs = std::getenv("BRITTLE_LONG_RUNS");
    if (long_runs && *long_runs) return 15;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    return 1;
#else
    return 3;
#endif
}

void drop_shape(const char* name) {
    for (uint64_t seed = 1; seed <= last_seed(); ++seed) drop(name, lifted(*fracture::shape(name)), 300, seed);
}

} // namespace

TEST_CASE("three hundred pieces of a cube fall asleep within ten seconds, none of them in the ground"
          * doctest::test_suite("long")) {
    drop_shape("cube");
}

TEST_CASE("three hundred pieces of an animal fall asleep within ten seconds, none of them in the ground"
          * doctest::test_suite("long")) {
    drop_shape("animal");
}

TEST_CASE("three hundred pieces of an arch fall asleep within ten seconds, none of them in the ground"
          * doctest::test_suite("long")) {
    drop_shape("arch");
}

TEST_CASE("three hundred pieces of a wall fall asleep within ten seconds, none of them in the ground"
          * doctest::test_suite("long")) {
    drop_shape("wall");
}

TEST_CASE("three hundred pieces of the bunny fall asleep within ten seconds, none of them in the ground"
          * doctest::test_suite("long")) {
    if (!std::filesystem::exists(bunny_file)) {
        MESSAGE("skipped: glmark2's bunny.obj is not installed");
        return;
    }
    const auto bunny = fracture::import_mesh(bunny_file);
    REQUIRE(bunny);
    for (uint64_t seed = 1; seed <= last_seed(); ++seed) drop("bunny", lifted(*bunny), 570, seed);
    // Once, a correction of overlap moved a piece of this seed 2 mm down as all fell asleep.
    if (last_seed() < 6) drop("bunny", lifted(*bunny), 570, 6);
}

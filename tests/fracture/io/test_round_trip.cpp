// What repair wrote, fracture takes: parts that only touch come back apart from every format.
#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "fracture/base/random.h"
#include "fracture/fracture.h"
#include "fracture/io/export.h"
#include "fracture/io/import.h"
#include "fracture/io/weld.h"
#include "fracture/mesh/topology.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "tests/folder.h"
#include "tests/fracture/mesh_checks.h"
#include "tests/fracture/repair_checks.h"

using namespace brittle::fracture;
using namespace brittle::fracture::test;

namespace {

// Merges the vertices at equal positions, as a careless exporter does.
TriangleMesh merged(const TriangleMesh& mesh) {
    return weld(mesh);
}

TriangleMesh cubes_at(const std::vector<glm::dvec3>& places) {
    TriangleMesh mesh;
    for (const glm::dvec3& p : places) append(mesh, plain_cube(), p);
    return merged(mesh);
}

TriangleMesh moebius_strip() {
    TriangleMesh strip;
    const uint32_t n = 20;
    for (uint32_t k = 0; k < n; ++k) {
        const double a = 2.0 * std::numbers::pi * k / n;
        for (const double w : {-0.3, 0.3})
            strip.positions.emplace_back((1 + w * std::cos(a / 2)) * std::cos(a), w * std::sin(a / 2),
                                         (1 + w * std::cos(a / 2)) * std::sin(a));
    }
    for (uint32_t k = 0; k < n; ++k) {
        const uint32_t a = 2 * k, b = k + 1 == n ? 1 : 2 * k + 2, c = k + 1 == n ? 0 : 2 * k + 3;
        strip.triangles.emplace_back(a, b, c);
        strip.triangles.emplace_back(a, c, a + 1);
    }
    return strip;
}

TriangleMesh doubled_patch() {
    TriangleMesh mesh = plain_cube();
    mesh.triangles.insert(mesh.triangles.end(), {{5, 4, 6}, {5, 6, 7}, {0, 1, 2}, {2, 1, 3}});
    return mesh;
}

// Random triangles among few vertices.
TriangleMesh soup(uint64_t seed) {
    Random random(seed);
    TriangleMesh mesh;
    for (int k = 0; k < 12; ++k) mesh.positions.push_back(random.uniform_in({glm::dvec3(-1.0), glm::dvec3(1.0)}));
    for (int k = 0; k < 40; ++k)
        mesh.triangles.emplace_back(random.next() % 12, random.next() % 12, random.next() % 12);
    return mesh;
}

// A sphere with random triangles missing and others doubled.
TriangleMesh damaged_sphere(uint64_t seed) {
    Random random(seed);
    TriangleMesh mesh;
    const TriangleMesh whole = icosphere(2);
    mesh.positions = whole.positions;
    for (const Triangle& t : whole.triangles)
        for (uint64_t copies = random.next() % 8 == 0 ? random.next() % 3 : 1; copies > 0; --copies)
            mesh.triangles.push_back(t);
    return mesh;
}

std::vector<std::pair<std::string, TriangleMesh>> damaged_meshes() {
    std::vector<std::pair<std::string, TriangleMesh>> all{
        {"two cubes that share an edge", cubes_at({{0, 0, 0}, {2, 2, 0}})},
        {"three cubes along one edge line", cubes_at({{0, 0, 0}, {0, 0, 2}, {2, 2, 0}, {2, 2, 2}})},
        {"a staircase of cubes", cubes_at({{0, 0, 0}, {2, 2, 0}, {4, 4, 0}, {6, 2, 0}, {2, 6, 2}})},
        {"a chequerboard of cubes",
         cubes_at({{0, 0, 0}, {2, 2, 0}, {0, 2, 2}, {2, 0, 2}, {4, 0, 0}, {4, 2, 2}, {0, 4, 0}, {2, 4, 2}})},
        {"two cubes that share a vertex", cubes_at({{0, 0, 0}, {2, 2, 2}})},
        {"doubled patches", doubled_patch()},
        {"a strip of Moebius", moebius_strip()}};
    for (uint64_t seed = 1; seed <= 12; ++seed) {
        all.emplace_back("soup " + std::to_string(seed), soup(seed));
        all.emplace_back("damaged sphere " + std::to_string(seed), damaged_sphere(seed));
    }
    return all;
}

} // namespace

TEST_CASE("round trip: a repaired mesh comes back closed from every format") {
    const test::Folder folder;
    for (const auto& damaged : damaged_meshes()) {
        INFO(damaged.first);
        const Repaired repaired = repair(damaged.second);
        if (repaired.mesh.triangles.empty()) continue;
        const TopologyReport before = check_topology(repaired.mesh.positions.size(), repaired.mesh.triangles);
        REQUIRE(before.closed());
        for (const bool coloured : {false, true})
            for (const std::string ending : {".glb", ".obj", ".ply", ".stl"}) {
                CAPTURE(coloured);
                CAPTURE(ending);
                Model model;
                model.mesh = repaired.mesh;
                if (coloured)
                    for (size_t t = 0; t < model.mesh.triangles.size(); ++t)
                        model.colours.insert(model.colours.end(), 3, glm::vec4(t % 2, 0.5f, 0.0f, 1.0f));
                const std::filesystem::path file = folder.path / ("repaired" + ending);
                REQUIRE(export_model(file, model, "repaired"));
                const Result<Model> back = import_model(file);
                REQUIRE(back);
                const TopologyReport after = check_topology(back->mesh.positions.size(), back->mesh.triangles);
                INFO(describe(after));
                CHECK(after.closed());
                CHECK(after.triangles == before.triangles);
                CHECK(after.components == before.components);
                CHECK(brittle::fracture::signed_volume(back->mesh.positions, back->mesh.triangles)
                      == doctest::Approx(test::signed_volume(repaired.mesh)).epsilon(1e-5));
            }
    }
}

TEST_CASE("round trip: the pieces of a fracture come back as the pieces that they were") {
    const test::Folder folder;
    const TriangleMesh mesh = icosphere(2);
    const Result<Fragments> pieces = fracture(mesh, uniform_sites(bounds(mesh), 12, 1));
    REQUIRE(pieces);
    for (const char* name : {"a.obj", "a.ply", "a.stl"}) {
        CAPTURE(name);
        REQUIRE(export_pieces(folder.path / name, *pieces, {}));
        const Result<TriangleMesh> back = import_mesh(folder.path / name);
        REQUIRE(back);
        const TopologyReport report = check_topology(back->positions.size(), back->triangles);
        CHECK(report.manifold());
        CHECK(report.components == pieces->pieces.size());
    }
}

TEST_CASE("round trip: cubes that touch along an edge come back apart from a foreign STL file") {
    const test::Folder folder;
    Model model;
    model.mesh = cubes_at({{0, 0, 0}, {2, 2, 0}});
    REQUIRE(export_model(folder.path / "cubes.stl", model, "cubes"));
    std::string bytes = test::read_text(folder.path / "cubes.stl");
    bytes.replace(0, 7, "Foreign");
    std::ofstream(folder.path / "cubes.stl", std::ios::binary) << bytes;
    const Result<TriangleMesh> back = import_mesh(folder.path / "cubes.stl");
    REQUIRE(back);
    CHECK(check_topology(back->positions.size(), back->triangles).closed());
}

TEST_CASE("weld_surface: shared vertices of touching solids stay shared, and cracks are closed as before") {
    std::vector<uint32_t> kept;
    const TriangleMesh joined = cubes_at({{0, 0, 0}, {2, 2, 0}});
    CHECK(same(weld_surface(joined, {}, kept), joined)); // the file says that they are one vertex
    CHECK(kept.size() == joined.triangles.size());

    TriangleMesh soup_of_cube; // three vertices a triangle
    for (const Triangle& t : plain_cube().triangles) {
        const auto base = static_cast<uint32_t>(soup_of_cube.positions.size());
        for (int k = 0; k < 3; ++k) soup_of_cube.positions.push_back(plain_cube().positions[t[k]]);
        soup_of_cube.triangles.emplace_back(base, base + 1, base + 2);
    }
    CHECK(is_manifold(weld_surface(soup_of_cube, {}, kept)));
    // A wall doubled in a soup leaves edges of four triangles that no division of fans makes closed.
    TriangleMesh walls = soup_of_cube;
    append(walls, soup_of_cube, {2, 0, 0});
    CHECK(same(weld_surface(walls, {}, kept), weld(walls)));

    // Equal positions with different numbers stay apart; those with equal numbers are one.
    TriangleMesh apart;
    for (const glm::dvec3& p : {glm::dvec3(0.0), glm::dvec3(2, 2, 0)}) append(apart, plain_cube(), p);
    std::vector<uint32_t> point;
    for (uint32_t v = 0; v < apart.positions.size(); ++v) point.push_back(v);
    CHECK(is_manifold(weld_surface(apart, point, kept)));
}

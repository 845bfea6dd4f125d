// No volume is lost or negative without an error, however thin or twisted the mesh is.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "fracture/fracture.h"
#include "fracture/io/export.h"
#include "fracture/io/import.h"
#include "fracture/mesh/topology.h"
#include "fracture/pieces/certificate.h"
#include "fracture/sites/sites.h"
#include "tests/fracture/mesh_checks.h"
#include "tests/fracture/repair_checks.h"

using namespace brittle::fracture;
using namespace brittle::fracture::test;

namespace {

TriangleMesh corpus_mesh(const char* name) {
    Result<TriangleMesh> mesh = import_mesh(std::filesystem::path(BRITTLE_CORPUS) / "meshes" / name);
    REQUIRE(mesh);
    return *std::move(mesh);
}

TriangleMesh stretched(TriangleMesh mesh, const glm::dvec3& factor, const glm::dvec3& shift = glm::dvec3(0.0)) {
    for (glm::dvec3& p : mesh.positions) p = p * factor + shift;
    return mesh;
}

// Fractures with both algorithms. Either the pieces have the volume of the mesh, all of it positive, or there is an
// error. Returns whether all fractures succeeded.
bool keeps_volume(const TriangleMesh& mesh) {
    bool all = true;
    for (const Algorithm algorithm : {Algorithm::exact, Algorithm::sequential})
        for (const uint32_t count : {1u, 2u, 5u, 40u}) {
            CAPTURE(count);
            const Result<Fragments> pieces =
                fracture(mesh, uniform_sites(bounds(mesh), count, 3), {.algorithm = algorithm});
            all = all && pieces;
            if (!pieces) {
                CHECK(pieces.error().status != Status::invalid_mesh);
                continue;
            }
            const Certificate certificate = certify(mesh, *pieces);
            CHECK(certificate.pieces > 0);
            CHECK(certificate.closed);
            CHECK(certificate.negative_pieces == 0);
            CHECK(certificate.volume_error <= max_volume_error);
            for (const Piece& piece : pieces->pieces) CHECK(piece.mass.volume > 0.0);
        }
    return all;
}

Error refusal(const TriangleMesh& mesh, uint32_t count, const Settings& settings = {}) {
    const Result<Fragments> pieces = fracture(mesh, uniform_sites(bounds(mesh), count, 1), settings);
    REQUIRE_FALSE(pieces);
    return pieces.error();
}

// A bottle of Klein: a tube that passes through itself and comes back with its sides exchanged, cut open along one of
// its circles and closed by two discs.
TriangleMesh klein_tube() {
    constexpr uint32_t rings = 24, sides = 10;
    TriangleMesh mesh;
    for (uint32_t r = 0; r <= rings; ++r) {
        const double u = std::numbers::pi * r / rings;
        for (uint32_t s = 0; s < sides; ++s) {
            const double v = 2.0 * std::numbers::pi * s / sides;
            const double a = std::cos(u), b = std::sin(u), c = std::cos(v), d = std::sin(v);
            mesh.positions.emplace_back(
                -2.0 / 15.0 * a
                    * (3.0 * c - 30.0 * b + 90.0 * std::pow(a, 4) * b - 60.0 * std::pow(a, 6) * b + 5.0 * a * c * b),
                -1.0 / 15.0 * b
                    * (3.0 * c - 3.0 * a * a * c - 48.0 * std::pow(a, 4) * c + 48.0 * std::pow(a, 6) * c - 60.0 * b
                       + 5.0 * a * c * b - 5.0 * std::pow(a, 3) * c * b - 80.0 * std::pow(a, 5) * c * b
                       + 80.0 * std::pow(a, 7) * c * b),
                2.0 / 15.0 * (3.0 + 5.0 * a * b) * d);
        }
    }
    for (uint32_t r = 0; r < rings; ++r)
        for (uint32_t s = 0; s < sides; ++s) {
            const uint32_t a = r * sides + s, b = r * sides + (s + 1) % sides;
            mesh.triangles.emplace_back(a, b, b + sides);
            mesh.triangles.emplace_back(a, b + sides, a + sides);
        }
    for (uint32_t s = 1; s + 1 < sides; ++s) {
        mesh.triangles.emplace_back(0, s + 1, s);
        mesh.triangles.emplace_back(rings * sides, rings * sides + s, rings * sides + s + 1);
    }
    return mesh;
}

} // namespace

TEST_CASE("volumes: a needle keeps all of its volume") {
    CHECK(keeps_volume(corpus_mesh("needle.obj")));
}

TEST_CASE("volumes: boxes and tetrahedra of any thinness keep their volume or are refused") {
    for (int digits = 0; digits <= 20; ++digits) {
        CAPTURE(digits);
        const double thin = std::pow(10.0, -digits);
        // A needle that is thin in two directions, and a plate. At the origin coordinates are as fine as the mesh; from
        // 1e-12 on, points of the cut are not.
        CHECK((keeps_volume(stretched(plain_cube(), {1.0, thin, thin})) || digits >= 12));
        CHECK((keeps_volume(stretched(plain_cube(), {1.0, 1.0, thin})) || digits >= 12));
        const TriangleMesh tetrahedron{{{0, 0, 0}, {2e12, 0, 0}, {0, 4e14 * thin, 0}, {0, 0, 4e14 * thin}},
                                       {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
        CHECK((keeps_volume(tetrahedron) || digits >= 12));
        // Far from the origin thin parts drown in the rounding of coordinates.
        keeps_volume(stretched(plain_cube(), {1.0, thin, thin}, {7.0, 5.0, 3.0}));
        keeps_volume(stretched(plain_cube(), {1.0, 1.0, thin}, {1e6, 2e6, 3e6}));
    }
}

TEST_CASE("volumes: a thin part beside a large one is a piece of its own") {
    // The flatness of a part is judged by its own coordinates, not by those of the scene.
    TriangleMesh mesh = stretched(plain_cube(), glm::dvec3(1.0), {1e6, 0.0, 0.0});
    append(mesh, stretched(plain_cube(), {1e-3, 1e-3, 1e-13}));
    for (const Algorithm algorithm : {Algorithm::exact, Algorithm::sequential}) {
        const glm::dvec3 site(0.0);
        const Result<Fragments> pieces = fracture(mesh, {&site, 1}, {.algorithm = algorithm});
        REQUIRE(pieces);
        REQUIRE(pieces->pieces.size() == 2);
        CHECK(pieces->pieces[1].mass.volume == doctest::Approx(8e-19).epsilon(1e-9));
    }
}

TEST_CASE("volumes: the bound on the error of a volume holds") {
    // The volume of a tetrahedron with small integer coordinates is exact in double, that of a shifted one is not.
    const std::vector<Triangle> triangles{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    for (const double tip : {1.0, 0x1p-20, 0x1p-40, 0x1p-50}) {
        const std::vector<glm::dvec3> points{{0, 0, 0}, {3, 0, 0}, {1, 5, 0}, {1, 1, tip}};
        const double exact = 15.0 * tip / 6.0;
        const double error = std::abs(brittle::fracture::signed_volume(points, triangles) - exact);
        CHECK(error <= volume_error_bound(points, triangles));
        CHECK(volume_error_bound(points, triangles) < 1e-12);
    }
}

TEST_CASE("volumes: a surface that turns itself inside out is refused, with the place and the remedy") {
    const TriangleMesh mesh = corpus_mesh("figure_eight.obj");
    REQUIRE(check_topology(mesh.positions.size(), mesh.triangles).manifold());
    REQUIRE(test::signed_volume(mesh) > 0.0);
    for (const Algorithm algorithm : {Algorithm::exact, Algorithm::sequential}) {
        const Error error = refusal(mesh, 100, {.algorithm = algorithm});
        INFO(error.message);
        CHECK(error.status == Status::inverted_part);
        CHECK(error.message.find("inside out near (") != std::string::npos);
        CHECK(error.message.find("--unite") != std::string::npos);
    }
    const Repaired bottle = repair(klein_tube());
    REQUIRE(check_topology(bottle.mesh.positions.size(), bottle.mesh.triangles).closed());
    keeps_volume(bottle.mesh);
}

TEST_CASE("volumes: a certificate counts negative pieces, and no file holds one") {
    const TriangleMesh mesh = plain_cube();
    Result<Fragments> pieces = fracture(mesh, uniform_sites(bounds(mesh), 4, 1));
    REQUIRE(pieces);
    CHECK(certify(mesh, *pieces).negative_pieces == 0);
    const Piece& last = pieces->pieces.back();
    for (uint32_t t = last.triangles.begin; t < last.triangles.end; ++t)
        std::swap(pieces->triangles[t].x, pieces->triangles[t].y);
    CHECK(certify(mesh, *pieces).negative_pieces == 1);
    pieces->pieces.back().mass.volume = -1.0;
    for (const char* name : {"a.glb", "a.obj", "a.ply", "a.stl"}) {
        const std::filesystem::path file = std::filesystem::temp_directory_path() / name;
        const auto written = export_pieces(file, *pieces, certify(mesh, *pieces), {.rigid_bodies = true});
        REQUIRE_FALSE(written);
        CHECK(written.error().status == Status::inverted_part);
    }
}

#include "fracture/pieces/attributes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/fracture.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "tests/fracture/lattice.h"

using namespace brittle::fracture;
using namespace brittle::fracture::test;

namespace {

// Checks that barycentric weights reproduce a function that is linear in position.
void check_barycentrics(const TriangleMesh& mesh, const Fragments& f) {
    const auto value = [](const glm::dvec3& p) { return 0.3 * p.x - 1.7 * p.y + 0.9 * p.z + 0.25; };
    size_t vertices = 0;
    for (const Piece& piece : f.pieces) {
        for (uint32_t t = piece.triangles.begin; t < piece.triangles.begin + piece.exterior_triangles; ++t) {
            const auto weights = barycentrics(mesh, f, piece, t);
            const Triangle& source = mesh.triangles[f.triangle_source[t]];
            for (int k = 0; k < 3; ++k) {
                const glm::dvec3& w = weights[static_cast<size_t>(k)];
                REQUIRE(std::min({w.x, w.y, w.z}) >= 0.0);
                REQUIRE(std::abs(w.x + w.y + w.z - 1.0) < 1e-15);
                double sum = 0.0;
                for (int m = 0; m < 3; ++m) sum += w[m] * value(mesh.positions[source[m]]);
                const uint32_t v = piece.vertices.begin + f.triangles[t][k];
                REQUIRE(std::abs(sum - value(f.positions[v])) < 1e-11);
                if (f.vertex_point[v] >= 1u << 30) continue;
                ++vertices;
                REQUIRE(std::max({w.x, w.y, w.z}) == 1.0);
            }
        }
    }
    CHECK(vertices > 0);
}

void check_interior_uv(const Sites& sites, const Fragments& f) {
    std::map<std::tuple<uint32_t, uint32_t, uint32_t>, glm::dvec2> uv_at; // by both sites and the point
    size_t seen_twice = 0;
    for (const Piece& piece : f.pieces) {
        for (uint32_t t = piece.triangles.begin + piece.exterior_triangles; t < piece.triangles.end; ++t) {
            const auto uv = interior_uv(sites, f, piece, t);
            std::array<glm::dvec3, 3> p{};
            for (int k = 0; k < 3; ++k)
                p[static_cast<size_t>(k)] = f.positions[piece.vertices.begin + f.triangles[t][k]];
            for (size_t k = 0; k < 3; ++k) {
                const size_t next = (k + 1) % 3;
                REQUIRE(std::abs(glm::length(uv[next] - uv[k]) - glm::length(p[next] - p[k])) < 1e-9);
                const uint32_t other = f.triangle_source[t];
                const auto [at, is_new] =
                    uv_at.try_emplace({std::min(piece.site, other), std::max(piece.site, other),
                                       f.vertex_point[piece.vertices.begin + f.triangles[t][static_cast<int>(k)]]},
                                      uv[k]);
                REQUIRE(glm::length(at->second - uv[k]) < 1e-9);
                seen_twice += is_new ? 0 : 1;
            }
        }
    }
    CHECK(seen_twice > 0);
}

} // namespace

TEST_CASE("attributes: a triangle without area has weights along its longest side") {
    const std::array<glm::dvec3, 3> line = {glm::dvec3(0.0), glm::dvec3(1.0, 2.0, 2.0), glm::dvec3(4.0, 8.0, 8.0)};
    std::array<size_t, 3> order = {0, 1, 2};
    do {
        const std::array<glm::dvec3, 3> corners = {line[order[0]], line[order[1]], line[order[2]]};
        for (const double t : {0.0, 0.25, 0.6, 1.0}) {
            const glm::dvec3 p = t * line[2], w = barycentrics(corners, p);
            CHECK(std::min({w.x, w.y, w.z}) >= 0.0);
            CHECK(w.x + w.y + w.z == doctest::Approx(1.0));
            CHECK(glm::distance(w.x * corners[0] + w.y * corners[1] + w.z * corners[2], p) < 1e-12);
        }
        // Beyond an end, the end.
        const glm::dvec3 w = barycentrics(corners, 2.0 * line[2]);
        CHECK(w.x * corners[0] + w.y * corners[1] + w.z * corners[2] == line[2]);
    } while (std::next_permutation(order.begin(), order.end()));
    const glm::dvec3 w = barycentrics({glm::dvec3(3.0), glm::dvec3(3.0), glm::dvec3(3.0)}, glm::dvec3(5.0));
    CHECK(std::min({w.x, w.y, w.z}) == 0.0);
    CHECK(w.x + w.y + w.z == 1.0);
}

TEST_CASE("attributes: both sides of a plane have equal coordinates on it, in metres") {
    const glm::dvec3 p(0.3, -1.2, 0.7), q(-0.4, 0.9, 2.0);
    for (const glm::dvec3& direction :
         {glm::dvec3(1.0, 0.0, 0.0), glm::dvec3(0.0, 1.0, 0.0), glm::dvec3(0.0, 0.0, 1.0), glm::dvec3(0.0, 3.0, 4.0),
          glm::dvec3(-1.0, 2.0, 0.5), glm::dvec3(1e-9, -1.0, 1.0), glm::dvec3(0.01, 1.0, 0.01)}) {
        const glm::dvec3 n = glm::normalize(direction);
        CHECK(plane_uv(n, p) == plane_uv(-n, p));
        const glm::dvec3 apart = p - q, on_plane = apart - glm::dot(apart, n) * n;
        CHECK(glm::distance(plane_uv(n, p), plane_uv(n, q)) == doctest::Approx(glm::length(on_plane)));
    }
    // Upwards is up, unless the plane is level.
    CHECK(plane_uv({1.0, 0.0, 0.0}, {5.0, 2.0, 3.0}).y == doctest::Approx(2.0));
    CHECK(plane_uv({0.0, 0.0, -1.0}, {5.0, 2.0, 3.0}).y == doctest::Approx(2.0));
}

TEST_CASE("attributes: linear functions of the input stay linear on the pieces, and cuts are mapped in metres") {
    const std::pair<TriangleMesh, Sites> cases[] = {
        {lattice_cube(4), lattice(3)}, // cuts through vertices, edges and faces
        {lattice_cube(4), lattice(4)},
        {cube(), {{-1.0, 0.0, 0.0}, {3.0, 0.0, 0.0}}}, // bisector in a face
        {icosphere(2), icosphere(0).positions},
        {torus(24, 12), uniform_sites(bounds(torus(24, 12)), 30, 1)},
        {hollow_sphere(2), uniform_sites(bounds(hollow_sphere(2)), 30, 2)},
        {icosphere(4), uniform_sites(bounds(icosphere(4)), 100, 3)},
    };
    for (size_t k = 0; k < std::size(cases); ++k) {
        CAPTURE(k);
        const auto& [mesh, sites] = cases[k];
        const auto fragments = fracture(mesh, sites);
        REQUIRE(fragments);
        check_barycentrics(mesh, *fragments);
        if (fragments->pieces.size() > 1) check_interior_uv(sites, *fragments);
    }
}

TEST_CASE("attributes: merged pieces have cuts on several bisectors") {
    const TriangleMesh ball = icosphere(3);
    const Sites sites = uniform_sites(bounds(ball), 60, 5);
    Settings settings;
    for (uint32_t k = 0; k < sites.size(); ++k) settings.groups.push_back(k % 3);
    const auto fragments = fracture(ball, sites, settings);
    REQUIRE(fragments);
    check_barycentrics(ball, *fragments);
    for (const Piece& piece : fragments->pieces) {
        for (uint32_t t = piece.triangles.begin + piece.exterior_triangles; t < piece.triangles.end; ++t) {
            const auto uv = interior_uv(sites, *fragments, piece, t);
            for (size_t k = 0; k < 3; ++k) {
                const auto at = [&](size_t c) {
                    return fragments
                        ->positions[piece.vertices.begin + fragments->triangles[t][static_cast<int>(c % 3)]];
                };
                const double length = glm::distance(at(k), at(k + 1));
                CHECK(glm::length(uv[(k + 1) % 3] - uv[k]) == doctest::Approx(length).epsilon(0.01));
            }
        }
    }
}

TEST_CASE("attributes: a horizontal and a vertical cut have upright texture coordinates") {
    const Sites level = {{0.0, -0.5, 0.0}, {0.0, 0.5, 0.0}}, upright = {{-0.5, 0.0, 0.0}, {0.5, 0.0, 0.0}};
    for (const Sites& sites : {level, upright}) {
        const auto f = fracture(cube(), sites);
        REQUIRE(f);
        double area = 0.0;
        const Piece& piece = f->pieces[0];
        for (uint32_t t = piece.triangles.begin + piece.exterior_triangles; t < piece.triangles.end; ++t) {
            const auto uv = interior_uv(sites, *f, piece, t);
            const glm::dvec2 a = uv[1] - uv[0], b = uv[2] - uv[0];
            area += std::abs(a.x * b.y - a.y * b.x) / 2.0;
            for (const glm::dvec2& at : uv) CHECK(std::max(std::abs(at.x), std::abs(at.y)) == doctest::Approx(1.0));
        }
        CHECK(area == doctest::Approx(4.0));
    }
}

#include "fracture/pieces/merge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/fracture.h"
#include "fracture/pieces/certificate.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "tests/fracture/lattice.h"

using namespace brittle::fracture;
using namespace brittle::fracture::test;

namespace {

using Corners = std::array<std::array<double, 3>, 3>;

Fragments run(const TriangleMesh& mesh, const Sites& sites, Settings settings) {
    const auto fragments = fracture(mesh, sites, settings);
    REQUIRE_MESSAGE(fragments, (fragments ? std::string() : fragments.error().message));
    const Certificate certificate = certify(mesh, *fragments);
    CHECK(certificate.closed);
    CHECK(certificate.volume_error < 1e-12);
    settings.threads = settings.threads == 1 ? 3 : 1;
    CHECK(hash(*fracture(mesh, sites, settings)) == certificate.hash);
    return *fragments;
}

// Returns the triangles as positions of their corners, smallest first.
std::multiset<Corners> triangles_of(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles) {
    std::multiset<Corners> result;
    for (const Triangle& t : triangles) {
        Corners corners{};
        for (int k = 0; k < 3; ++k) {
            const glm::dvec3& p = positions[t[k]];
            corners[static_cast<size_t>(k)] = {p.x, p.y, p.z};
        }
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
        result.insert(corners);
    }
    return result;
}

double bonded_area(const Fragments& f) {
    double sum = 0.0;
    for (const Bond& bond : f.bonds) sum += bond.area;
    return sum;
}

} // namespace

TEST_CASE("merge: all cells in one group give back the input, triangle by triangle") {
    for (const TriangleMesh& mesh : {cube(), lattice_cube(6), icosphere(3), torus(24, 12), torus_knot(2, 3, 80, 8),
                                     hollow_sphere(2), menger_sponge(1)}) {
        for (const Sites& sites : {uniform_sites(bounds(mesh), 40, 1), lattice(3), lattice(4)}) {
            CAPTURE(mesh.triangles.size());
            CAPTURE(sites.size());
            const Fragments f = run(mesh, sites, {.groups = std::vector<uint32_t>(sites.size(), 7)});
            REQUIRE(f.pieces.size() == 1);
            CHECK(f.bonds.empty());
            CHECK(f.pieces[0].exterior_triangles == f.triangles.size());
            // Here vertices of the sponge lie on bisectors in its own faces, and sides are split at them.
            if (mesh.triangles.size() == 144 && sites.size() == 27) continue;
            CHECK(triangles_of(f.positions, f.triangles) == triangles_of(mesh.positions, mesh.triangles));
        }
    }
}

TEST_CASE("merge: cuts separate groups and leave their interiors whole") {
    const TriangleMesh ball = icosphere(4);
    const Sites sites = uniform_sites(bounds(ball), 80, 3);
    Settings settings;
    for (const glm::dvec3& s : sites) settings.groups.push_back(s.x < 0.0 ? 0 : (s.y < 0.0 ? 1 : 2));
    const Fragments f = run(ball, sites, settings);
    const Fragments apart = run(ball, sites, {});
    CHECK(f.pieces.size() == 3);
    std::map<uint32_t, double> volume, expected;
    for (const Piece& piece : f.pieces) volume[settings.groups[piece.site]] += piece.mass.volume;
    for (const Piece& piece : apart.pieces) expected[settings.groups[piece.site]] += piece.mass.volume;
    for (const auto& [group, v] : expected) CHECK(volume[group] == doctest::Approx(v).epsilon(1e-12));
    CHECK(bonded_area(f) < 0.4 * bonded_area(apart));
    // The remaining caps equal those of the fracture without groups.
    size_t kept = 0;
    std::multiset<Corners> before;
    for (const Piece& piece : apart.pieces)
        before.merge(triangles_of(apart.positions_of(piece), apart.triangles_of(piece)));
    for (const Piece& piece : f.pieces) {
        for (const Corners& corners :
             triangles_of(f.positions_of(piece), f.triangles_of(piece).subspan(piece.exterior_triangles))) {
            CHECK(before.contains(corners));
            ++kept;
        }
    }
    CHECK(kept > 100);
    // An input triangle inside one group has no point that only another group's cut needs.
    std::map<uint32_t, std::set<uint32_t>> groups_of;
    for (uint32_t p = 0; p < f.pieces.size(); ++p) {
        const Piece& piece = f.pieces[p];
        for (uint32_t t = piece.triangles.begin; t < piece.triangles.begin + piece.exterior_triangles; ++t)
            groups_of[f.triangle_source[t]].insert(p);
    }
    CHECK(groups_of.size() == ball.triangles.size());
    const auto whole =
        std::count_if(groups_of.begin(), groups_of.end(), [](const auto& g) { return g.second.size() == 1; });
    CHECK(whole > 4500); // of 5,120
}

TEST_CASE("merge: parts of a group that do not touch are pieces of their own") {
    const Sites sites = {{-0.75, 0.0, 0.0}, {-0.25, 0.0, 0.0}, {0.25, 0.0, 0.0}, {0.75, 0.0, 0.0}};
    const Fragments f = run(cube(), sites, {.groups = {0, 1, 1, 0}});
    REQUIRE(f.pieces.size() == 3);
    CHECK(f.pieces[1].mass.volume == doctest::Approx(4.0));
    REQUIRE(f.bonds.size() == 2);
    for (const Bond& bond : f.bonds) CHECK(bond.area == doctest::Approx(4.0));
}

TEST_CASE("merge: lattice cubes that meet only in an edge keep two fans") {
    // A chessboard: cells of one colour touch along edges and in corners.
    const Sites sites = lattice(4);
    Settings settings;
    for (int k = 0; k < 64; ++k) settings.groups.push_back(static_cast<uint32_t>((k + k / 4 + k / 16) % 2));
    CHECK(run(lattice_cube(4), sites, settings).pieces.size() == 64);
    // Three of the four cells around an edge, and both diagonals of a cube of eight cells.
    const Fragments corner = run(cube(), lattice(2), {.groups = {0, 0, 0, 1, 2, 3, 4, 5}});
    CHECK(corner.pieces.size() == 6);
    // A ring of groups that forms one piece and touches itself along an edge.
    const Fragments ring = run(cube(), lattice(2), {.groups = {0, 0, 1, 0, 0, 2, 0, 0}});
    CHECK(ring.pieces.size() == 3);
}

TEST_CASE("merge: pieces below the minimum volume join the neighbour with the largest contact") {
    const TriangleMesh ball = icosphere(4);
    const Sites sites = uniform_sites(bounds(ball), 150, 9);
    const Fragments all = run(ball, sites, {});
    size_t last = all.pieces.size();
    for (const double least : {0.005, 0.02, 0.2}) {
        CAPTURE(least);
        const Fragments f = run(ball, sites, {.min_volume = least});
        CHECK(f.pieces.size() < last);
        last = f.pieces.size();
        for (const Piece& piece : f.pieces) CHECK(piece.mass.volume >= least);
    }
    CHECK(run(ball, sites, {.min_volume = 1e3}).pieces.size() == 1);

    // Three slabs: the first is the smallest and has one neighbour, which keeps its site.
    const Sites slabs = {{-1.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.2, 0.0, 0.0}};
    const Fragments two = run(cube(), slabs, {.min_volume = 2.5});
    REQUIRE(two.pieces.size() == 2);
    CHECK(two.pieces[0].site == 1);
    CHECK(two.pieces[0].mass.volume == doctest::Approx(4.4));
    // Two separate balls: the small one has no neighbour.
    TriangleMesh balls = icosphere(2);
    for (const glm::dvec3& p : icosphere(2).positions) balls.positions.push_back(0.1 * p + glm::dvec3(3.0, 0.0, 0.0));
    for (const Triangle& t : icosphere(2).triangles)
        balls.triangles.push_back(t + Triangle(static_cast<uint32_t>(icosphere(2).positions.size())));
    CHECK(run(balls, {{0.0, 0.0, 0.0}, {3.0, 0.0, 0.0}}, {.min_volume = 1.0}).pieces.size() == 2);
}

TEST_CASE("merge: a sheet without volume becomes the exterior of the piece below it") {
    // The bisectors coincide with faces of the cube.
    const Sites sites = {{0.0, 0.0, 0.0}, {2.0, 0.0, 0.0}, {-2.0, 0.0, 0.0}, {0.0, 2.0, 0.0}, {0.0, 0.0, -2.0}};
    const Fragments f = run(lattice_cube(4), sites, {});
    REQUIRE(f.pieces.size() == 1);
    CHECK(f.pieces[0].site == 0);
    CHECK(f.pieces[0].exterior_triangles == f.triangles.size());
    CHECK(f.bonds.empty());
}

TEST_CASE("merge: invalid settings are refused") {
    const Sites sites = {{-0.5, 0.0, 0.0}, {0.5, 0.0, 0.0}};
    const auto status = [&](const Settings& settings) {
        const auto result = fracture(cube(), sites, settings);
        REQUIRE_FALSE(result);
        CHECK_FALSE(result.error().message.empty());
        return result.error().status;
    };
    CHECK(status({.groups = {1}}) == Status::invalid_setting);
    CHECK(status({.min_volume = -1.0}) == Status::invalid_setting);
    CHECK(status({.min_volume = std::numeric_limits<double>::quiet_NaN()}) == Status::invalid_setting);
    CHECK(status({.algorithm = Algorithm::sequential, .groups = {1, 1}}) == Status::invalid_setting);
    CHECK(status({.algorithm = Algorithm::sequential, .min_volume = 1.0}) == Status::invalid_setting);
}

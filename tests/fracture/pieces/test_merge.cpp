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

// Pieces with the given volumes and contacts, without triangles: the choice of mergers by volume needs no more.
Fragments pieces_of(const std::vector<double>& volumes, const std::vector<Bond>& bonds) {
    Fragments f;
    for (const double volume : volumes) {
        Piece piece;
        piece.site = static_cast<uint32_t>(f.pieces.size());
        piece.mass.volume = volume;
        f.pieces.push_back(piece);
    }
    f.bonds = bonds;
    return f;
}

// Adds a piece with the given box and surface area. Its only triangle has half of that area.
void add_box(Fragments& f, const glm::dvec3& low, const glm::dvec3& high, double volume, double area, bool exterior) {
    const double half = std::sqrt(area); // the legs of a right triangle with half of the area
    Piece piece;
    piece.site = static_cast<uint32_t>(f.pieces.size());
    piece.vertices.begin = static_cast<uint32_t>(f.positions.size());
    piece.triangles.begin = static_cast<uint32_t>(f.triangles.size());
    for (const glm::dvec3& p : {low, low + glm::dvec3(half, 0.0, 0.0), low + glm::dvec3(0.0, half, 0.0), high})
        f.positions.push_back(p);
    f.triangles.push_back({0, 1, 2});
    f.triangle_source.push_back(0);
    piece.vertices.end = static_cast<uint32_t>(f.positions.size());
    piece.triangles.end = static_cast<uint32_t>(f.triangles.size());
    piece.exterior_triangles = exterior ? 1 : 0;
    piece.mass.volume = volume;
    piece.mass.area = area;
    f.pieces.push_back(piece);
}

using Indices = std::vector<uint32_t>;

} // namespace

TEST_CASE("merge: the smallest piece chooses first, and the result may be large enough") {
    // A chain of three: the first joins the second, and both together are no longer small.
    CHECK(choose_mergers(pieces_of({1.0, 1.5, 9.0}, {{0, 1, 1.0}, {1, 2, 5.0}}), {.min_volume = 2.0})
          == Indices{1, 1, 2});
    // The second is the smallest now, and the union of the two still small.
    CHECK(choose_mergers(pieces_of({1.0, 0.5, 9.0}, {{0, 1, 1.0}, {1, 2, 0.5}}), {.min_volume = 2.0})
          == Indices{2, 2, 2});
    CHECK(choose_mergers(pieces_of({1.0, 9.0}, {{0, 1, 1.0}}), {.min_volume = 1.0}) == Indices{0, 1}); // not below it
    CHECK(choose_mergers(pieces_of({1.0, 9.0}, {}), {.min_volume = 2.0}) == Indices{0, 1});
    CHECK(choose_mergers(pieces_of({-5.0, 9.0}, {{0, 1, 1.0}}), {.min_volume = 2.0}) == Indices{0, 1});
    CHECK(choose_mergers(pieces_of({-1.0, 9.0}, {{0, 1, 1.0}}), {.min_volume = 2.0}) == Indices{1, 1});
}

TEST_CASE("merge: the largest contact decides, among equal ones the lower index") {
    CHECK(choose_mergers(pieces_of({9.0, 1.0, 9.0}, {{0, 1, 2.0}, {1, 2, 2.0}}), {.min_volume = 2.0})
          == Indices{0, 0, 2});
    CHECK(choose_mergers(pieces_of({9.0, 1.0, 9.0}, {{0, 1, 2.0}, {1, 2, 2.5}}), {.min_volume = 2.0})
          == Indices{0, 2, 2});
    // Piece 0 is absorbed by piece 3 first, which becomes the representative of both. Piece 5 then has contacts with
    // this union and with piece 1.
    const auto with_contacts = [](double with_union, double with_one) {
        return choose_mergers(pieces_of({0.5, 9.0, 9.0, 9.0, 9.0, 1.0},
                                        {{0, 2, 1.0}, {0, 3, 5.0}, {0, 4, 1.0}, {0, 5, with_union}, {1, 5, with_one}}),
                              {.min_volume = 2.0});
    };
    CHECK(with_contacts(2.0, 2.0) == Indices{3, 1, 2, 3, 4, 1});
    CHECK(with_contacts(2.0, 1.0) == Indices{3, 1, 2, 3, 4, 3});
    CHECK(with_contacts(1.0, 2.0) == Indices{3, 1, 2, 3, 4, 1});
}

TEST_CASE("merge: contacts of a union add up") {
    // Pieces 0 and 1 unite first. Piece 2 touches both, each less than piece 3.
    const std::vector<Bond> bonds = {{0, 1, 5.0}, {0, 2, 1.0}, {1, 2, 1.0}, {2, 3, 1.5}};
    CHECK(choose_mergers(pieces_of({0.5, 9.0, 1.0, 9.0}, bonds), {.min_volume = 2.0}) == Indices{1, 1, 1, 3});
    CHECK(choose_mergers(pieces_of({9.0, 0.5, 1.0, 9.0}, bonds), {.min_volume = 2.0}) == Indices{0, 0, 0, 3});
}

TEST_CASE("merge: an absorbed piece that separated two pieces of a group brings them together") {
    const Indices groups = {7, 8, 7, 9};
    const MergeRules rules{.group_of_site = groups, .min_volume = 2.0};
    CHECK(choose_mergers(pieces_of({9.0, 1.0, 9.0, 9.0}, {{0, 1, 1.0}, {1, 2, 2.0}, {2, 3, 1.0}}), rules)
          == Indices{0, 0, 0, 3});
    // It joins a third group: those two stay apart.
    CHECK(choose_mergers(pieces_of({9.0, 1.0, 9.0, 9.0}, {{0, 1, 1.0}, {1, 2, 1.0}, {1, 3, 2.0}}), rules)
          == Indices{0, 3, 2, 3});
}

TEST_CASE("merge: a sheet joins the neighbour that covers one of its sides, or is dropped") {
    // Piece 0 is a cube with an edge of 3, piece 1 a sheet with an area of 2, half of it exterior.
    const auto with_sheet = [](const glm::dvec3& low, double contact, bool exterior = true) {
        Fragments f;
        add_box(f, glm::dvec3(0.0), glm::dvec3(3.0), 27.0, 6.0, true);
        add_box(f, low, low + glm::dvec3(0.5, 0.5, 0.0), 0.0, 2.0, exterior);
        f.bonds = {{0, 1, contact}};
        const std::vector<uint8_t> flat = {0, 1};
        return choose_mergers(f, {.flat = flat});
    };
    CHECK(with_sheet(glm::dvec3(0.0), 1.0) == Indices{0, 0});                  // all of one side
    CHECK(with_sheet(glm::dvec3(0.0), 1.0 - 1e-9) == Indices{0, 0});           // up to rounding
    CHECK(with_sheet(glm::dvec3(0.0), 0.9) == Indices{0, dropped});            // another neighbour has the rest
    CHECK(with_sheet(glm::dvec3(-0.1, 0.0, 0.0), 1.0) == Indices{0, dropped}); // sticks out of the cube
    CHECK(with_sheet(glm::dvec3(0.0, 0.0, 3.1), 1.0) == Indices{0, dropped});  // on the other side
    CHECK(with_sheet(glm::dvec3(-1e-15, 0.0, 0.0), 1.0) == Indices{0, 0});     // up to rounding
    CHECK(with_sheet(glm::dvec3(0.0), 0.5, false) == Indices{0, 0});           // a speck inside the solid
    CHECK(with_sheet(glm::dvec3(-0.1, 0.0, 0.0), 0.5, false) == Indices{0, 0});
}

TEST_CASE("merge: sheets that no solid piece covers are dropped together") {
    Fragments f;
    add_box(f, glm::dvec3(0.0), glm::dvec3(3.0), 27.0, 6.0, true);
    add_box(f, glm::dvec3(0.0), glm::dvec3(0.5, 0.5, 0.0), 0.0, 2.0, true);
    add_box(f, glm::dvec3(0.0), glm::dvec3(0.5, 0.5, 0.0), 0.0, 2.0, true);
    const std::vector<uint8_t> flat = {0, 1, 1};
    f.bonds = {{1, 2, 1.0}};
    CHECK(choose_mergers(f, {.flat = flat}) == Indices{0, dropped, dropped});
    CHECK(choose_mergers(f, {.min_volume = 28.0, .flat = flat}) == Indices{0, dropped, dropped});
    // The cube covers the second, and the union of both is solid.
    f.bonds = {{0, 2, 1.0}, {1, 2, 1.5}};
    CHECK(choose_mergers(f, {.flat = flat}) == Indices{0, 0, 0});
    CHECK(choose_mergers(f, {}) == Indices{0, 1, 2});
}

TEST_CASE("merge: a bond of groups is the sum of the bonds between their cells") {
    const TriangleMesh ball = icosphere(3);
    const Sites sites = uniform_sites(bounds(ball), 60, 4);
    Settings settings;
    for (const glm::dvec3& s : sites) settings.groups.push_back(s.y < 0.1 ? 5 : 3);
    const Fragments apart = run(ball, sites, {}), f = run(ball, sites, settings);
    REQUIRE(f.pieces.size() == 2);
    REQUIRE(f.bonds.size() == 1);
    const uint32_t first = settings.groups[f.pieces[0].site];
    double area = 0.0;
    glm::dvec3 centroid(0.0), normal(0.0);
    for (const Bond& bond : apart.bonds) {
        const uint32_t a = settings.groups[apart.pieces[bond.a].site], b = settings.groups[apart.pieces[bond.b].site];
        if (a == b) continue;
        area += bond.area;
        centroid += bond.area * bond.centroid;
        normal += (a == first ? bond.area : -bond.area) * bond.normal;
    }
    CHECK(f.bonds[0].a == 0);
    CHECK(f.bonds[0].b == 1);
    CHECK(f.bonds[0].area == doctest::Approx(area).epsilon(1e-12));
    CHECK(glm::distance(f.bonds[0].centroid, centroid / area) < 1e-12);
    CHECK(glm::distance(f.bonds[0].normal, glm::normalize(normal)) < 1e-12);
    CHECK(glm::dot(f.bonds[0].normal, f.pieces[1].mass.centre_of_mass - f.pieces[0].mass.centre_of_mass) > 0.0);
}

TEST_CASE("merge: the bond around an enclosed piece has a unit normal") {
    Settings settings;
    for (int k = 0; k < 27; ++k) settings.groups.push_back(k == 13 ? 1 : 0);
    const Fragments f = run(lattice_cube(3), lattice(3), settings);
    REQUIRE(f.pieces.size() == 2);
    REQUIRE(f.bonds.size() == 1);
    CHECK(f.bonds[0].area == doctest::Approx(6.0 * 4.0 / 9.0));
    CHECK(f.bonds[0].normal == glm::dvec3(0.0, 1.0, 0.0));
    CHECK(glm::length(f.bonds[0].centroid) < 1e-12);
}

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

#include "fracture/sites/pattern.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/base/random.h"
#include "fracture/fracture.h"
#include "fracture/mesh/inside.h"
#include "fracture/mesh/islands.h"
#include "fracture/pieces/certificate.h"
#include "fracture/shapes/shapes.h"

using namespace brittle::fracture;

namespace {

constexpr PatternKind all_kinds[] = {
    PatternKind::uniform, PatternKind::clustered, PatternKind::radial, PatternKind::grid,      PatternKind::bricks,
    PatternKind::slices,  PatternKind::splinters, PatternKind::curve,  PatternKind::curvature, PatternKind::thickness};

PatternSites make(const Pattern& pattern, const TriangleMesh& mesh) {
    const auto made = make_sites(pattern, mesh);
    REQUIRE_MESSAGE(made, (made ? std::string() : made.error().message));
    REQUIRE((made->groups.empty() || made->groups.size() == made->sites.size()));
    return *made;
}

Fragments break_by(const Pattern& pattern, const TriangleMesh& mesh) {
    const PatternSites made = make(pattern, mesh);
    const auto fragments = fracture(mesh, made.sites, {.groups = made.groups});
    REQUIRE_MESSAGE(fragments, (fragments ? std::string() : fragments.error().message));
    const Certificate certificate = certify(mesh, *fragments);
    CHECK(certificate.closed);
    CHECK(certificate.volume_error < 1e-12);
    return *fragments;
}

Box box_of(const Fragments& f, const Piece& piece) {
    const auto positions = f.positions_of(piece);
    return bounds(positions);
}

TriangleMesh wall() {
    TriangleMesh mesh = cube(1.0);
    for (glm::dvec3& p : mesh.positions) p *= glm::dvec3(4.0, 2.0, 0.3);
    return mesh;
}

} // namespace

TEST_CASE("pattern: grading spreads the sizes of pieces") {
    const TriangleMesh mesh = cube();
    const auto spread = [&](double grading) { // standard deviation of the volumes, divided by their mean
        const PatternSites made = make({.kind = PatternKind::uniform, .count = 200, .grading = grading}, mesh);
        CHECK(made.weights.size() == (grading > 0.0 ? made.sites.size() : 0));
        const auto fragments = fracture(mesh, made.sites, {.weights = made.weights});
        REQUIRE(fragments);
        double sum = 0.0, squares = 0.0;
        for (const Piece& piece : fragments->pieces) {
            sum += piece.mass.volume;
            squares += piece.mass.volume * piece.mass.volume;
        }
        const auto n = static_cast<double>(fragments->pieces.size());
        return std::sqrt(squares / n - sum * sum / n / n) / (sum / n);
    };
    const double even = spread(0.0);
    CHECK(spread(0.5) > even);
    CHECK(spread(1.0) > 1.3 * even);
}

TEST_CASE("pattern: several cells a piece divide the pieces of every kind into facets, in their places") {
    const TriangleMesh mesh = wall();
    for (const PatternKind kind : all_kinds) {
        for (const double grading : {0.0, 0.5}) {
            CAPTURE(int(kind));
            CAPTURE(grading);
            const Pattern plain{.kind = kind, .count = 24, .grading = grading};
            Pattern faceted = plain;
            faceted.cells_per_piece = 16;
            const PatternSites whole = make(plain, mesh), cells = make(faceted, mesh);
            // Cells beside a heavy one may be small or empty.
            CHECK(cells.sites.size() <= 16 * whole.sites.size());
            if (whole.weights.empty()) CHECK(cells.sites.size() == 16 * whole.sites.size());
            REQUIRE(cells.groups.size() == cells.sites.size());
            CHECK(cells.weights.empty());
            // A cell lies in the piece of its group: no other site of the plain pattern is nearer, by power.
            const auto power = [&](const glm::dvec3& p, size_t s) {
                const glm::dvec3 d = p - whole.sites[s];
                return glm::dot(d, d) - (whole.weights.empty() ? 0.0 : whole.weights[s]);
            };
            for (size_t c = 0; c < cells.sites.size(); ++c) {
                double own = std::numeric_limits<double>::infinity(), others = own;
                for (size_t s = 0; s < whole.sites.size(); ++s) {
                    const uint32_t group = whole.groups.empty() ? static_cast<uint32_t>(s) : whole.groups[s];
                    double& least = group == cells.groups[c] ? own : others;
                    least = std::min(least, power(cells.sites[c], s));
                }
                CHECK(own <= others);
            }
            const Fragments pieces = break_by(faceted, mesh);
            CHECK(pieces.pieces.size() >= whole.sites.size() / 4);
            uint64_t facets = 0;
            for (const Piece& piece : pieces.pieces) facets += piece.triangles.size() - piece.exterior_triangles;
            CHECK(facets > 40 * pieces.pieces.size()); // the cells of a random diagram have about 15 facets
        }
    }
    Pattern one{.count = 1};
    one.cells_per_piece = 16;
    CHECK(make(one, mesh).sites.size() == 1);
}

TEST_CASE("pattern: thin parts of a solid have more sites per volume") {
    // A cube and a separate plate with a tenth of its height.
    TriangleMesh mesh = cube(1.0);
    for (glm::dvec3 p : cube(1.0).positions) mesh.positions.emplace_back(p.x + 2.0, p.y * 0.1, p.z);
    for (const Triangle& t : cube(1.0).triangles) mesh.triangles.push_back(t + glm::uvec3(8));
    const PatternSites made = make({.kind = PatternKind::thickness, .count = 2000}, mesh);
    REQUIRE(made.sites.size() == 2000);
    double plate = 0.0;
    for (const glm::dvec3& s : made.sites) {
        const bool in_cube = std::abs(s.x) < 0.5 && std::abs(s.y) < 0.5;
        const bool in_plate = std::abs(s.x - 2.0) < 0.5 && std::abs(s.y) < 0.05;
        CHECK((in_cube || in_plate));
        plate += in_plate ? 1.0 : 0.0;
    }
    // The cube's faces and the plate's two ends have their opposite side at one metre, the plate's large faces at a
    // tenth of a metre: weights of 2 x 100 and 4 x 0.1 to 6.
    CHECK(plate / 2000.0 == doctest::Approx(200.4 / 206.4).epsilon(0.02));
}

TEST_CASE("inside: agrees with the winding number by solid angles") {
    TriangleMesh two = hollow_sphere(2);
    for (const Triangle& t : cube(1.0).triangles)
        two.triangles.push_back(t + Triangle(static_cast<uint32_t>(two.positions.size())));
    for (const glm::dvec3& p : cube(1.0).positions) two.positions.push_back(p + glm::dvec3(0.9, 0.0, 0.0)); // overlaps
    for (const TriangleMesh& mesh :
         {icosphere(3), torus(24, 12), torus_knot(2, 3, 100, 8), lattice_cube(5), two, menger_sponge(2)}) {
        CAPTURE(mesh.triangles.size());
        const InsideTest inside(mesh);
        Box box = bounds(mesh);
        const glm::dvec3 margin = box.size() * 0.1;
        box = {box.min - margin, box.max + margin};
        Random random(3);
        int in = 0;
        for (int k = 0; k < 400; ++k) {
            const glm::dvec3 p = random.uniform_in(box);
            const bool expected = winding_number(p, mesh.positions, mesh.triangles) > 0.5;
            CHECK(inside(p) == expected);
            in += expected ? 1 : 0;
        }
        CHECK(in > 20);
    }
}

TEST_CASE("inside: rays through vertices and along edges and faces") {
    const TriangleMesh mesh = lattice_cube(4); // from -1 to 1 in steps of a half
    const InsideTest inside(mesh);
    for (int x = -3; x <= 3; ++x)
        for (int y = -3; y <= 3; ++y)
            for (int z = -3; z <= 3; ++z) CHECK(inside(glm::dvec3(x, y, z) * 0.25));
    CHECK_FALSE(inside({1.5, 0.0, 0.0}));
    CHECK_FALSE(inside({-1.5, 0.5, 0.5}));
    CHECK_FALSE(inside({0.0, 0.0, std::numeric_limits<double>::quiet_NaN()}));
    const TriangleMesh sponge = menger_sponge(1);
    CHECK_FALSE(InsideTest(sponge)({0.0, 0.0, 0.0}));
}

TEST_CASE("pattern: every kind breaks every shape, reproducibly, or returns an error") {
    for (const PatternKind kind : all_kinds) {
        CAPTURE(pattern_names()[static_cast<size_t>(kind)]);
        for (const TriangleMesh& mesh : {icosphere(2), torus(24, 12), wall()}) {
            const Pattern pattern{.kind = kind, .count = 24, .seed = 5};
            CHECK(break_by(pattern, mesh).pieces.size() > 3);
            CHECK(make(pattern, mesh).sites == make(pattern, mesh).sites);
            Pattern other = pattern;
            other.seed = 6;
            other.jitter = 0.5;
            CHECK(make(other, mesh).sites != make(pattern, mesh).sites);
        }
    }
}

TEST_CASE("pattern: counts are as documented, and the inside setting keeps inside sites only") {
    const TriangleMesh ring = torus(32, 16);
    for (const PatternKind kind : {PatternKind::uniform, PatternKind::clustered, PatternKind::slices,
                                   PatternKind::curvature, PatternKind::thickness})
        CHECK(make({.kind = kind, .count = 37}, ring).sites.size() == 37);
    for (const PatternKind kind : all_kinds) {
        CAPTURE(pattern_names()[static_cast<size_t>(kind)]);
        const auto made = make_sites({.kind = kind, .count = 200, .inside = true}, ring);
        // No slice has its centre inside the ring.
        if (!made) {
            CHECK(kind == PatternKind::slices);
            CHECK(made.error().message.find("inside") != std::string::npos);
            continue;
        }
        for (const glm::dvec3& site : made->sites) CHECK(winding_number(site, ring.positions, ring.triangles) > 0.4);
        if (kind == PatternKind::uniform || kind == PatternKind::clustered) CHECK(made->sites.size() == 200);
    }
    // Pieces of a quarter of a metre in a cube of edge two: 8^3.
    CHECK(make({.piece_size = 0.25}, cube()).sites.size() == 512);
}

TEST_CASE("pattern: a grid without jitter gives boxes of equal size") {
    const Fragments f = break_by({.kind = PatternKind::grid, .count = 27}, cube());
    REQUIRE(f.pieces.size() == 27);
    for (const Piece& piece : f.pieces) {
        CHECK(piece.mass.volume == doctest::Approx(8.0 / 27.0));
        CHECK(piece.triangles.size() == 12);
    }
}

TEST_CASE("pattern: bricks are boxes in running bond") {
    const Fragments f = break_by({.kind = PatternKind::bricks, .count = 60}, wall());
    std::set<double> starts[2]; // along X, by course
    std::set<long> courses;
    for (const Piece& piece : f.pieces) {
        const Box box = box_of(f, piece);
        CHECK(piece.mass.volume == doctest::Approx(box.size().x * box.size().y * box.size().z));
        const long course = std::lround((box.min.y + 1.0) / box.size().y);
        courses.insert(course);
        starts[course % 2].insert(std::round(box.min.x * 1e6) / 1e6);
        CHECK(box.size().x >= 0.99 * box.size().y);
    }
    CHECK(courses.size() >= 3);
    for (const double x : starts[0]) CHECK((x == -2.0 || !starts[1].contains(x)));
    // Even courses have whole bricks only. Odd courses have one brick more, and two of theirs are halves.
    CHECK(starts[1].size() == starts[0].size() + 1);
}

TEST_CASE("pattern: slices are flat and of equal thickness") {
    const Fragments f = break_by({.kind = PatternKind::slices, .count = 8, .axis = {1.0, 0.0, 0.0}}, wall());
    REQUIRE(f.pieces.size() == 8);
    for (const Piece& piece : f.pieces) CHECK(box_of(f, piece).size().x == doctest::Approx(0.5));
}

TEST_CASE("pattern: splinters are long along the axis, radial shards cross the solid and are smallest at the focus") {
    const Fragments wood = break_by({.kind = PatternKind::splinters, .count = 60, .axis = {1.0, 0.0, 0.0}}, cube());
    double longer = 0.0;
    for (const Piece& piece : wood.pieces) {
        const glm::dvec3 size = box_of(wood, piece).size();
        longer += size.x > 1.5 * std::max(size.y, size.z) ? 1.0 : 0.0;
    }
    CHECK(longer > 0.7 * static_cast<double>(wood.pieces.size()));

    const Fragments glass = break_by({.kind = PatternKind::radial, .count = 60, .axis = {0.0, 0.0, 1.0}}, wall());
    double near = 0.0, far = 0.0, near_count = 0.0, far_count = 0.0;
    for (const Piece& piece : glass.pieces) {
        CHECK(box_of(glass, piece).size().z == doctest::Approx(0.3));
        const bool is_near = glm::length(piece.mass.centre_of_mass) < 0.7;
        (is_near ? near : far) += piece.mass.volume;
        (is_near ? near_count : far_count) += 1.0;
    }
    CHECK(near / near_count < 0.5 * far / far_count);
}

TEST_CASE("pattern: a crack follows its line") {
    // A straight line without jitter gives two rows of boxes, split along the middle.
    const Fragments f = break_by({.kind = PatternKind::curve, .count = 16, .jitter = 0.0}, wall());
    CHECK(f.pieces.size() == 16);
    for (const Piece& piece : f.pieces) {
        const Box box = box_of(f, piece);
        CHECK(box.min.z * box.max.z == doctest::Approx(0.0).epsilon(1e-9));
    }
}

TEST_CASE("pattern: an invalid setting is refused with the name of its field") {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto refused = [](const Pattern& pattern, const char* field) {
        const auto made = make_sites(pattern, cube());
        REQUIRE_FALSE(made);
        CHECK(made.error().status == Status::invalid_setting);
        CHECK(made.error().message.find(field) != std::string::npos);
    };
    refused({.count = 0}, "count");
    refused({.count = 1'000'000'000}, "count");
    refused({.piece_size = nan}, "piece_size");
    refused({.piece_size = 1e-9}, "piece_size");
    refused({.jitter = nan}, "jitter");
    refused({.jitter = 1.5}, "jitter");
    refused({.focus = {nan, 0.0, 0.0}}, "focus");
    refused({.axis = {0.0, 0.0, 0.0}}, "axis");
    refused({.spread = 0.0}, "spread");
    refused({.slenderness = 0.5}, "slenderness");
    refused({.cells_per_piece = 0}, "cells_per_piece");
    refused({.cells_per_piece = 1001}, "cells_per_piece");
    refused({.count = 10'001, .cells_per_piece = 100}, "cells_per_piece");
    refused({.kind = PatternKind::curve, .line = {{0.0, 0.0, 0.0}}}, "line");
    CHECK(make_sites({}, {}).error().status == Status::empty_mesh);
}

TEST_CASE("pattern: a diagram is rotated, scaled and translated onto another box") {
    const Box from{{0.0, 0.0, 0.0}, {2.0, 1.0, 1.0}}, onto{{9.0, 9.0, 9.0}, {10.0, 13.0, 10.0}};
    const std::vector<glm::dvec3> sites = {{1.0, 0.5, 0.5}, {2.0, 0.5, 0.5}};
    const auto placed = place(sites, from, onto, {.turn = {0.0, 0.0, 90.0}, .scale = 0.5, .move = {0.0, 0.0, 1.0}});
    CHECK(glm::length(placed[0] - glm::dvec3(9.5, 11.0, 10.5)) < 1e-12);
    CHECK(glm::length(placed[1] - glm::dvec3(9.5, 12.0, 10.5)) < 1e-12); // X became Y, twice as long, scaled by half
}

TEST_CASE("pattern: a diagram is rotated by any finite angle") {
    const Box box{{0.0, 0.0, 0.0}, {2.0, 1.0, 1.0}};
    const std::vector<glm::dvec3> sites = {{2.0, 0.25, 0.5}};
    for (const double turns : {1.0, -1.0, 1e6, -1e12}) {
        const auto placed = place(sites, box, box, {.turn = {0.0, 0.0, 360.0 * turns + 90.0}});
        CHECK(glm::length(placed[0] - glm::dvec3(1.25, 1.5, 0.5)) < 1e-12);
    }
    const double largest = std::numeric_limits<double>::max();
    for (const glm::dvec3& turn : {glm::dvec3(1e300, 0.0, 0.0), glm::dvec3(-1e300, 1e18, 0.0), glm::dvec3(largest)}) {
        const glm::dvec3 from_centre = place(sites, box, box, {.turn = turn})[0] - box.centre();
        CHECK(glm::length(from_centre) == doctest::Approx(glm::length(sites[0] - box.centre())));
    }
}

#include "tests/fracture/exact_checks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include "fracture/base/random.h"
#include "fracture/base/work_log.h"
#include "fracture/fracture.h"
#include "fracture/pieces/certificate.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"

using namespace brittle::fracture;
using namespace brittle::fracture::test;

TEST_CASE("exact fracture: weights give the power diagram") {
    Random random(11);
    for (int round = 0; round < 40; ++round) {
        CAPTURE(round);
        const TriangleMesh mesh = round % 3 == 0 ? torus() : (round % 3 == 1 ? lattice_cube(3) : hollow_sphere(2));
        const uint64_t site_count = 5 + random.next() % 30;
        auto sites = uniform_sites(bounds(mesh), static_cast<uint32_t>(site_count), random.next());
        Settings settings{.threads = 1};
        const bool rounded = round % 2 == 0; // rounded coordinates give many exact ties
        for (glm::dvec3& s : sites) {
            if (rounded) s = glm::round(s * 4.0) / 4.0;
            const double w = random.uniform() * 0.4 - 0.1;
            settings.weights.push_back(rounded ? std::round(w * 8.0) / 8.0 : w);
        }
        const auto exact = brittle::fracture::fracture(mesh, sites, settings);
        REQUIRE(exact);
        const Certificate certificate = certify(mesh, *exact);
        CHECK(certificate.closed);
        CHECK(certificate.volume_error < 1e-12);
        const auto power = [&](size_t k, const glm::dvec3& p) {
            return glm::dot(p - sites[k], p - sites[k]) - settings.weights[k];
        };
        for (const Piece& piece : exact->pieces)
            for (const glm::dvec3& p : exact->positions_of(piece))
                for (size_t k = 0; k < sites.size(); ++k) CHECK(power(piece.site, p) <= power(k, p) + 1e-12);
        settings.threads = 4;
        CHECK(hash(*brittle::fracture::fracture(mesh, sites, settings)) == certificate.hash);
        settings.algorithm = Algorithm::sequential;
        const auto sequential = brittle::fracture::fracture(mesh, sites, settings);
        REQUIRE(sequential);
        std::vector<double> volume(sites.size(), 0.0);
        for (const Piece& piece : exact->pieces) volume[piece.site] += piece.mass.volume;
        for (const Piece& piece : sequential->pieces) volume[piece.site] -= piece.mass.volume;
        for (const double difference : volume) CHECK(std::abs(difference) < 1e-9);
    }
}

TEST_CASE(
    "exact fracture: of many weighted sites, one that is far away and heavy takes the part that has a light one") {
    // A cube with 150 sites in it, and one far from it, beside which lies a site without a cell.
    TriangleMesh mesh = cube(1.0);
    TriangleMesh far = cube(1.0);
    for (glm::dvec3& p : far.positions) p.x += 10.0;
    for (Triangle t : far.triangles) mesh.triangles.push_back(t + static_cast<uint32_t>(mesh.positions.size()));
    mesh.positions.insert(mesh.positions.end(), far.positions.begin(), far.positions.end());
    std::vector<glm::dvec3> sites = uniform_sites(bounds(cube(1.0)), 150, 3);
    Settings settings{.threads = 1};
    settings.weights.assign(sites.size(), 0.0);
    sites.insert(sites.end(), {{10.0, 0.1, 0.2}, {30.0, 0.0, 0.0}});
    settings.weights.insert(settings.weights.end(), {-1000.0, 600.0});
    const auto found = brittle::fracture::fracture(mesh, sites, settings);
    REQUIRE(found);
    const Certificate certificate = certify(mesh, *found);
    CHECK(certificate.closed);
    CHECK(certificate.volume_error < 1e-12);
    CHECK(std::ranges::count(found->pieces, 151u, &Piece::site) == 1);
    CHECK(std::ranges::count(found->pieces, 150u, &Piece::site) == 0);
}

TEST_CASE("exact fracture: equal weights change nothing, a heavy site takes all, weights are checked") {
    const TriangleMesh mesh = icosphere(3);
    const auto sites = uniform_sites(bounds(mesh), 20, 5);
    const auto fracture_with = [&](const std::vector<double>& weights) {
        return brittle::fracture::fracture(mesh, sites, {.weights = weights});
    };
    CHECK(hash(*fracture_with(std::vector<double>(20, 0.5))) == hash(*fracture_with({})));
    std::vector<double> heavy(20, 0.0);
    heavy[7] = 1e3;
    const auto one = fracture_with(heavy);
    REQUIRE(one);
    REQUIRE(one->pieces.size() == 1);
    CHECK(one->pieces[0].site == 7);
    heavy[7] = std::numeric_limits<double>::quiet_NaN();
    CHECK(fracture_with(heavy).error().status == Status::invalid_setting);
    CHECK(fracture_with({1.0}).error().status == Status::invalid_setting);
    CHECK(!voronoi_diagram(sites, {glm::dvec3(-1.0), glm::dvec3(1.0)}, 1, std::vector<double>{1.0}));
}

TEST_CASE("exact: an unsound mesh or site is refused with a named status") {
    const Sites one{glm::dvec3(0.0)};
    CHECK(fracture_exact({}, one).error().status == Status::empty_mesh);
    CHECK(fracture_exact(cube(), {}).error().status == Status::invalid_sites);
    CHECK(fracture_exact(cube(), Sites{glm::dvec3(std::nan(""))}).error().status == Status::invalid_sites);
    CHECK(fracture_exact(cube(), Sites{glm::dvec3(1e300)}).error().status == Status::invalid_sites);

    TriangleMesh broken = cube();
    broken.triangles.pop_back();
    CHECK(fracture_exact(broken, lattice_sites(2)).error().status == Status::not_closed);
    CHECK(fracture_exact(broken, lattice_sites(2)).error().message.find("open") != std::string::npos);

    broken = cube();
    std::swap(broken.triangles[3].x, broken.triangles[3].y);
    CHECK(fracture_exact(broken, lattice_sites(2)).error().status == Status::not_oriented);

    broken = cube();
    broken.positions[2].y = std::numeric_limits<double>::infinity();
    CHECK(fracture_exact(broken, one).error().message.find("vertex 2") != std::string::npos);

    broken = cube();
    broken.triangles[5].z = 8;
    CHECK(fracture_exact(broken, one).error().message.find("triangle 5") != std::string::npos);

    broken = cube();
    broken.triangles[5].z = broken.triangles[5].x; // opens three more edges
    CHECK(fracture_exact(broken, one).error().status == Status::not_closed);
}

TEST_CASE("exact: an edge that four triangles share is refused, whether a bisector cuts it or not") {
    // Two cubes that touch along an edge, with the vertices of that edge in common.
    TriangleMesh mesh = together(cube(), moved(cube(), {2.0, 2.0, 0.0}));
    std::vector<uint32_t> same(mesh.positions.size());
    for (uint32_t v = 0; v < same.size(); ++v) {
        same[v] = static_cast<uint32_t>(std::find(mesh.positions.begin(), mesh.positions.end(), mesh.positions[v])
                                        - mesh.positions.begin());
    }
    for (Triangle& t : mesh.triangles) t = {same[t.x], same[t.y], same[t.z]};
    for (const Sites& sites : {Sites{{0.0, 0.0, -0.5}, {0.0, 0.0, 0.5}}, Sites{glm::dvec3(0.0)}}) {
        const auto result = fracture_exact(mesh, sites);
        REQUIRE(!result);
        CHECK(result.error().status == Status::non_manifold);
        CHECK(result.error().message.find("1 edge used by three triangles or more") != std::string::npos);
    }
}

TEST_CASE("exact: one site leaves the mesh unchanged") {
    const TriangleMesh mesh = icosphere(2);
    const Fragments f = check_fracture(mesh, {glm::dvec3(0.3)});
    REQUIRE(f.pieces.size() == 1);
    CHECK(f.positions == mesh.positions);
    CHECK(f.triangles == mesh.triangles);
    CHECK(f.bonds.empty());
}

TEST_CASE("exact: of duplicate sites the lowest index gets the piece") {
    const Fragments f = check_fracture(cube(), {{-0.5, 0.0, 0.0}, {-0.5, -0.0, 0.0}, {0.5, 0.0, 0.0}, {0.5, 0.0, 0.0}});
    REQUIRE(f.pieces.size() == 2);
    CHECK(f.pieces[0].site == 0);
    CHECK(f.pieces[1].site == 2);
}

TEST_CASE("exact: a cube cut in half has the volumes, caps and bond of two boxes") {
    const Fragments f = check_fracture(cube(), {{-0.5, 0.1, 0.2}, {0.5, 0.1, 0.2}});
    REQUIRE(f.pieces.size() == 2);
    CHECK(f.pieces[0].mass.volume == doctest::Approx(4.0));
    CHECK(f.pieces[1].mass.volume == doctest::Approx(4.0));
    CHECK(f.pieces[0].mass.centre_of_mass.x == doctest::Approx(-0.5));
    REQUIRE(f.bonds.size() == 1);
    CHECK(f.bonds[0].area == doctest::Approx(4.0));
    CHECK(glm::length(f.bonds[0].centroid) < 1e-12);
    CHECK(f.bonds[0].normal == glm::dvec3(1.0, 0.0, 0.0));
    check_caps_match(f);
}

TEST_CASE("exact: tori and knots, cut across and through the hole") {
    for (const uint32_t n : {2u, 7u, 40u, 200u}) {
        CAPTURE(n);
        check_fracture(torus(), uniform_sites(bounds(torus()), n, n));
        check_fracture(torus_knot(), uniform_sites(bounds(torus_knot()), n, n + 1));
    }
    check_fracture(torus(), {{0.0, -0.1, 0.0}, {0.0, 0.1, 0.0}}); // a cap with a hole
    check_fracture(torus(), {{-0.1, 0.0, 0.0}, {0.1, 0.0, 0.0}}); // two caps on one facet
    check_fracture(torus(), {{0.0, 0.0, 0.0}, {0.0, 0.8, 0.0}});  // tangent to the top
}

TEST_CASE("exact: two halves of a torus share one bond of two caps") {
    const Fragments f = check_fracture(torus(96, 48, 1.0, 0.4), {{-0.1, 0.01, 0.02}, {0.1, 0.01, 0.02}});
    REQUIRE(f.pieces.size() == 2);
    REQUIRE(f.bonds.size() == 1);
    CHECK(f.bonds[0].area == doctest::Approx(2.0 * 3.14159265 * 0.16).epsilon(0.01));
}

TEST_CASE("exact: the legs of an animal become islands") {
    const TriangleMesh animal = four_legged_animal();
    const Box box = bounds(animal);
    const double y = 0.25 * box.size().y;
    const Fragments f =
        check_fracture(animal, {{0.0, 0.05 * box.size().y, 0.0}, {0.0, 2.0 * y - 0.05 * box.size().y, 0.0}});
    CHECK(std::count_if(f.pieces.begin(), f.pieces.end(), [](const Piece& p) { return p.site == 0; }) == 4);
    CHECK(f.bonds.size() == 4);
}

TEST_CASE("exact: a cavity belongs to the island around it") {
    const TriangleMesh shell = hollow_sphere();
    CHECK(check_fracture(shell, {glm::dvec3(0.0)}).pieces.size() == 1);
    // The border of the middle cell runs within the wall: cavity and border belong to one piece.
    Sites sites{glm::dvec3(0.0)};
    for (const auto& s : icosphere(1).positions) sites.push_back(s * 1.6);
    const Fragments f = check_fracture(shell, sites);
    CHECK(std::count_if(f.pieces.begin(), f.pieces.end(), [](const Piece& p) { return p.site == 0; }) == 1);
    for (const uint32_t n : {2u, 10u, 100u}) check_fracture(shell, uniform_sites(bounds(shell), n, n));
    // Two balls with one cavity each, in one cell: each keeps its own.
    const TriangleMesh pair = together(shell, moved(shell, {5.0, 0.0, 0.0}));
    const Fragments two = check_fracture(pair, {glm::dvec3(0.0)});
    REQUIRE(two.pieces.size() == 2);
    CHECK(two.pieces[0].mass.volume == doctest::Approx(two.pieces[1].mass.volume));
    CHECK(two.pieces[1].mass.centre_of_mass.x == doctest::Approx(5.0));
    // A ball inside the cavity is a solid of its own.
    CHECK(check_fracture(together(shell, moved(icosphere(3), {}, 0.3)), {glm::dvec3(0.0)}).pieces.size() == 2);
}

TEST_CASE("exact: separate components are separate pieces") {
    TriangleMesh mesh;
    for (int k = 0; k < 20; ++k) mesh = together(mesh, moved(icosphere(1), {3.0 * k, 0.0, 0.0}));
    CHECK(check_fracture(mesh, {glm::dvec3(0.0)}).pieces.size() == 20);
    CHECK(check_fracture(mesh, {glm::dvec3(0.0), glm::dvec3(1.0, 0.0, 0.0)}).pieces.size() == 21);
    check_fracture(mesh, uniform_sites(bounds(mesh), 50, 6));
}

TEST_CASE("exact: unused vertices are omitted") {
    TriangleMesh mesh = icosphere(2);
    mesh.positions.insert(mesh.positions.begin(), glm::dvec3(0.1));
    for (Triangle& t : mesh.triangles) t += 1u;
    mesh.positions.push_back(glm::dvec3(0.9));
    check_fracture(mesh, uniform_sites(bounds(mesh), 10, 3));
}

TEST_CASE("exact: offsets of 1e6 and scales of 1e-9, 1e9 and beyond") {
    const Box unit{glm::dvec3(-1.0), glm::dvec3(1.0)};
    const Sites sites = uniform_sites(unit, 40, 31);
    const auto pieces = check_fracture(icosphere(3), sites).pieces.size();
    for (const double scale : {1e-9, 1e9, 1e-100, 1e90}) {
        CAPTURE(scale);
        Sites scaled = sites;
        for (glm::dvec3& s : scaled) s *= scale;
        CHECK(check_fracture(moved(icosphere(3), {}, scale), scaled).pieces.size() == pieces);
    }
    // Far from the origin positions are rounded to 1e-10 of the size, which limits the precision of the sum.
    const glm::dvec3 offset(1e6, -1e6, 1e6);
    Sites far = sites;
    for (glm::dvec3& s : far) s += offset;
    CHECK(check_fracture(moved(icosphere(3), offset), far, 1e-9).pieces.size() == pieces);
}

TEST_CASE("exact: random sites in random shapes, caps equal on both sides") {
    for (uint64_t seed = 1; seed <= 6; ++seed) {
        for (const char* name : {"icosphere", "torus_knot", "four_legged_animal"}) {
            const auto mesh = shape(name);
            if (!mesh) continue;
            const auto count = static_cast<uint32_t>(3 + 37 * seed);
            CAPTURE(seed);
            CAPTURE(name);
            check_caps_match(check_fracture(*mesh, uniform_sites(bounds(*mesh), count, seed)));
        }
    }
    check_fracture(icosphere(4), uniform_sites(bounds(icosphere(4)), 2000, 1));
}

TEST_CASE("exact: the Stanford bunny at 10, 100 and 1000 sites") {
    const TriangleMesh bunny = read_obj("/usr/share/glmark2/models/bunny.obj");
    if (bunny.triangles.empty()) {
        MESSAGE("skipped: glmark2's bunny.obj is not installed");
        return;
    }
    for (const uint32_t n : {10u, 100u, 1000u}) {
        CAPTURE(n);
        const Fragments f = check_fracture(bunny, uniform_sites(bounds(bunny), n, 1));
        check_caps_match(f);
        CHECK(f.pieces.size() >= n / 3);
    }
}

TEST_CASE("exact: a work log records the steps of each thread and changes no bit") {
    const TriangleMesh mesh = icosphere(6);
    const Sites sites = uniform_sites(bounds(mesh), 300, 9);
    const auto none = fracture_exact(mesh, sites, {.threads = 1});
    for (const uint32_t threads : {1u, 3u}) {
        WorkLog log;
        const auto logged = fracture_exact(mesh, sites, {.threads = threads, .work_log = &log});
        REQUIRE(logged);
        CHECK(hash(*logged) == hash(*none));
        CHECK(log.threads() == threads);
        std::map<std::string, std::vector<std::pair<uint32_t, uint32_t>>> runs;
        for (size_t k = 0; k < log.threads(); ++k) {
            int64_t last = 0;
            for (const WorkLog::Slice& slice : log.of_thread(k)) {
                REQUIRE(slice.from >= last);
                REQUIRE(slice.to >= slice.from);
                last = slice.to;
                runs[slice.step].emplace_back(slice.begin, slice.end);
            }
        }
        for (const char* step : {"prepare", "cells", "classify", "cut edges", "cut triangles", "winding", "caps",
                                 "assemble", "slivers", "islands"}) {
            CAPTURE(step);
            CHECK_FALSE(runs[step].empty());
        }
        // The first loop over sites builds the cells: its chunks are contiguous, in any threads.
        auto& cells = runs["cells"];
        std::sort(cells.begin(), cells.end());
        uint32_t reached = 0;
        for (const auto& [begin, end] : cells)
            if (begin == reached) reached = end;
        CHECK(reached >= sites.size());
        log.clear();
        CHECK(log.of_thread(0).empty());
        CHECK(log.threads() == threads);
    }
}

TEST_CASE("exact: used scratch memory gives the same bits") {
    exact::Scratch scratch;
    Fragments out;
    for (const uint32_t n : {50u, 300u, 2u, 50u}) {
        const TriangleMesh mesh = n == 2 ? torus() : icosphere(4);
        const Sites sites = uniform_sites(bounds(mesh), n, 9);
        REQUIRE(fracture_exact(mesh, sites, {.threads = 2}, scratch, out));
        const auto fresh = fracture_exact(mesh, sites, {.threads = 1});
        CHECK(hash(out) == hash(*fresh));
    }
}

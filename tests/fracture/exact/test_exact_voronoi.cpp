#include "fracture/exact/voronoi.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/base/random.h"
#include "fracture/base/threads.h"
#include "fracture/exact/diagram.h"

using namespace brittle::fracture;

namespace {

const Box unit_box{glm::dvec3(0.0), glm::dvec3(1.0)};

std::vector<glm::dvec3> random_sites(uint32_t count, uint64_t seed, const Box& box = unit_box) {
    Random random(seed);
    std::vector<glm::dvec3> sites;
    for (uint32_t i = 0; i < count; ++i) sites.push_back(random.uniform_in(box));
    return sites;
}

std::vector<glm::dvec3> lattice_sites(uint32_t n) {
    std::vector<glm::dvec3> sites;
    for (uint32_t z = 0; z < n; ++z)
        for (uint32_t y = 0; y < n; ++y)
            for (uint32_t x = 0; x < n; ++x) sites.push_back((glm::dvec3(x, y, z) + 0.5) / static_cast<double>(n));
    return sites;
}

bool even(uint32_t a, uint32_t b, uint32_t c) {
    return (a < b && b < c) || (b < c && c < a) || (c < a && a < b);
}

// Checks all promises of the header about the combinatorics.
void check_structure(const VoronoiDiagram& d) {
    std::vector<uint32_t> uses(d.vertices.size(), 0);
    for (const auto& facet : d.facets) {
        REQUIRE(facet.i < facet.j);
        const auto ring = d.ring_of(facet);
        REQUIRE(ring.size() >= 3);
        for (size_t m = 0; m < ring.size(); ++m) {
            const auto& corner = ring[m];
            const auto& before = ring[(m + ring.size() - 1) % ring.size()];
            const auto& edge = d.edges[corner.edge];
            REQUIRE(std::count(edge.planes.begin(), edge.planes.end(), facet.i) == 1);
            REQUIRE(std::count(edge.planes.begin(), edge.planes.end(), facet.j) == 1);
            REQUIRE(std::count(edge.planes.begin(), edge.planes.end(), corner.third) == 1);
            const bool along = even(facet.i, facet.j, corner.third);
            REQUIRE(corner.vertex == (along ? edge.end : edge.start));
            REQUIRE(before.vertex == (along ? edge.start : edge.end));
            ++uses[corner.vertex];
        }
    }
    for (size_t v = 0; v < d.vertices.size(); ++v) {
        const auto& planes = d.vertices[v].planes;
        REQUIRE(std::is_sorted(planes.begin(), planes.end()));
        const auto sites =
            std::count_if(planes.begin(), planes.end(), [](uint32_t p) { return p < VoronoiDiagram::first_box_plane; });
        REQUIRE(uses[v] == sites * (sites - 1) / 2); // a facet for each pair of cells
    }
    for (uint32_t c = 0; c + 1 < d.cell_begin.size(); ++c) {
        uint32_t last = 0;
        bool first = true;
        for (const auto& n : d.neighbours_of(c)) {
            REQUIRE((first || n.site > last));
            first = false;
            last = n.site;
            REQUIRE(d.facet_between(c, n.site) == n.facet);
            REQUIRE(d.facet_between(n.site, c) == n.facet);
        }
    }
}

// Checks that the sites of a vertex are equally near to it, and no other site is nearer.
void check_vertices(const VoronoiDiagram& d, const std::vector<glm::dvec3>& sites, double tolerance) {
    for (const auto& vertex : d.vertices) {
        const double own = glm::distance(vertex.position, sites[vertex.planes[0]]);
        for (const uint32_t p : vertex.planes) {
            if (p < VoronoiDiagram::first_box_plane) {
                REQUIRE(std::abs(glm::distance(vertex.position, sites[p]) - own) <= tolerance);
            }
        }
        double nearest = std::numeric_limits<double>::infinity();
        for (const auto& s : sites) nearest = std::min(nearest, glm::distance(vertex.position, s));
        REQUIRE(nearest >= own - tolerance);
    }
}

// The volume of an interior cell, by pyramids over its facets.
double volume_of_interior_cell(const VoronoiDiagram& d, uint32_t c, const std::vector<glm::dvec3>& sites) {
    double volume = 0.0;
    for (const auto& n : d.neighbours_of(c)) {
        const auto ring = d.ring_of(d.facets[n.facet]);
        glm::dvec3 area(0.0);
        const glm::dvec3 origin = d.vertices[ring[0].vertex].position;
        for (size_t m = 1; m + 1 < ring.size(); ++m) {
            area += glm::cross(d.vertices[ring[m].vertex].position - origin,
                               d.vertices[ring[m + 1].vertex].position - origin)
                    * 0.5;
        }
        const double sign = c == d.facets[n.facet].i ? 1.0 : -1.0;
        volume += sign * glm::dot(area, origin - sites[c]) / 3.0;
    }
    return volume;
}

} // namespace

TEST_CASE("no site, a site that is not finite and a flat box have named errors") {
    CHECK(voronoi_diagram({}, unit_box).error().status == Status::invalid_sites);
    const std::vector<glm::dvec3> bad{{0.0, 0.0, 0.0}, {0.0, std::nan(""), 0.0}};
    const auto result = voronoi_diagram(bad, unit_box);
    REQUIRE(!result);
    CHECK(result.error().status == Status::invalid_sites);
    CHECK(result.error().message.find("site 1") != std::string::npos);
    CHECK(voronoi_diagram(lattice_sites(1), Box{glm::dvec3(0.0), glm::dvec3(1.0, 0.0, 1.0)}).error().status
          == Status::invalid_setting);
}

TEST_CASE("one site has the whole box and no facet") {
    const auto d = voronoi_diagram(lattice_sites(1), unit_box);
    REQUIRE(d);
    CHECK(d->facets.empty());
    CHECK(d->cell_is_empty == std::vector<uint8_t>{0});
}

TEST_CASE("two sites share one facet that the box bounds") {
    const std::vector<glm::dvec3> sites{{0.25, 0.5, 0.5}, {0.75, 0.5, 0.5}};
    const auto d = voronoi_diagram(sites, unit_box);
    REQUIRE(d);
    check_structure(*d);
    REQUIRE(d->facets.size() == 1);
    CHECK(d->vertices.size() == 4);
    for (const auto& v : d->vertices) CHECK(v.position.x == 0.5);
    CHECK(volume_of_interior_cell(*d, 0, sites) == doctest::Approx(0.25 / 3.0)); // one of the six pyramids
}

TEST_CASE("of duplicate sites the lowest index owns the cell") {
    std::vector<glm::dvec3> sites = random_sites(20, 5);
    const auto unique = voronoi_diagram(sites, unit_box);
    sites.insert(sites.end(), sites.begin(), sites.end());
    sites.push_back({-0.0, 0.0, 0.0});
    sites.push_back({0.0, -0.0, 0.0});
    const auto d = voronoi_diagram(sites, unit_box);
    REQUIRE(d);
    check_structure(*d);
    for (uint32_t c = 0; c < 20; ++c) CHECK(d->cell_is_empty[c] == 0);
    for (uint32_t c = 20; c < 40; ++c) CHECK(d->cell_is_empty[c] == 1);
    CHECK(d->cell_is_empty[40] == 0);
    CHECK(d->cell_is_empty[41] == 1);
    CHECK(unique->vertices.size() > 20);
}

TEST_CASE("collinear, coplanar, cospherical and lattice sites give sound diagrams") {
    std::vector<glm::dvec3> collinear, coplanar, sphere;
    for (int i = 0; i < 12; ++i) collinear.push_back({(i + 0.5) / 12.0, 0.5, 0.5});
    for (int i = 0; i < 36; ++i) coplanar.push_back({(i % 6 + 0.5) / 6.0, 0.5, (i / 6 + 0.5) / 6.0});
    // All integer points at distance 3, and their centre.
    for (int x = -3; x <= 3; ++x)
        for (int y = -3; y <= 3; ++y)
            for (int z = -3; z <= 3; ++z)
                if (x * x + y * y + z * z == 9) sphere.push_back(glm::dvec3(x, y, z) / 8.0 + 0.5);
    for (const auto& sites : {collinear, coplanar, sphere, lattice_sites(2), lattice_sites(4), lattice_sites(5)}) {
        const auto d = voronoi_diagram(sites, unit_box);
        REQUIRE(d);
        check_structure(*d);
        check_vertices(*d, sites, 1e-9);
    }
    sphere.push_back(glm::dvec3(0.5));
    const auto d = voronoi_diagram(sphere, unit_box);
    REQUIRE(d);
    check_structure(*d);
    const auto centre = static_cast<uint32_t>(sphere.size()) - 1;
    CHECK(d->neighbours_of(centre).size() == sphere.size() - 1);
}

TEST_CASE("the cells of a lattice are cubes") {
    const auto sites = lattice_sites(5);
    const auto d = voronoi_diagram(sites, unit_box);
    REQUIRE(d);
    CHECK(volume_of_interior_cell(*d, 62, sites) == doctest::Approx(1.0 / 125.0));
}

TEST_CASE("far sites and sites of mixed scales give sound diagrams") {
    std::vector<glm::dvec3> sites = random_sites(30, 9);
    for (const auto& s : random_sites(20, 10)) sites.push_back((s - 0.5) * 1000.0);
    for (const auto& s : random_sites(10, 11)) sites.push_back((s - 0.5) * 1e12);
    const auto d = voronoi_diagram(sites, unit_box);
    REQUIRE(d);
    check_structure(*d);
    for (uint32_t c = 0; c < 30; ++c) CHECK(d->cell_is_empty[c] == 0);
}

TEST_CASE("sites far outside the box still share all of it") {
    const auto sites = random_sites(200, 3, {glm::dvec3(5.0), glm::dvec3(6.0)});
    const auto d = voronoi_diagram(sites, unit_box);
    REQUIRE(d);
    check_structure(*d);
    CHECK(std::count(d->cell_is_empty.begin(), d->cell_is_empty.end(), uint8_t{0}) >= 1);
}

TEST_CASE("far sites on a sphere around the box, whose cells all meet in its middle but for rounding") {
    // The corners of a dodecahedron, turned: rounding decides how the twenty cells meet.
    const double golden = 0.5 * (1.0 + std::sqrt(5.0));
    std::vector<glm::dvec3> corners;
    for (const double x : {-1.0, 1.0})
        for (const double y : {-1.0, 1.0}) {
            for (const double z : {-1.0, 1.0}) corners.emplace_back(x, y, z);
            corners.emplace_back(0.0, x / golden, y * golden);
            corners.emplace_back(x / golden, y * golden, 0.0);
            corners.emplace_back(y * golden, 0.0, x / golden);
        }
    REQUIRE(corners.size() == 20);
    for (int k = 0; k < 40; ++k) {
        const double u = 0.3 + 0.1 * k, v = 0.7 * k, radius = std::ldexp(1.0, k % 20);
        std::vector<glm::dvec3> sites;
        for (const glm::dvec3& p : corners) {
            const glm::dvec3 turned(std::cos(u) * p.x - std::sin(u) * p.y, std::sin(u) * p.x + std::cos(u) * p.y, p.z);
            sites.push_back(0.5
                            + radius
                                  * glm::dvec3(turned.x, std::cos(v) * turned.y - std::sin(v) * turned.z,
                                               std::sin(v) * turned.y + std::cos(v) * turned.z));
        }
        CAPTURE(k);
        const auto diagram = voronoi_diagram(sites, unit_box);
        REQUIRE(diagram);
        check_structure(*diagram);
        check_vertices(*diagram, sites, 1e-12 * radius);
    }
}

TEST_CASE("random diagrams are sound at every size, offset and scale") {
    for (const uint32_t count : {3u, 4u, 5u, 10u, 100u, 1000u}) {
        CAPTURE(count);
        const auto sites = random_sites(count, count);
        const auto d = voronoi_diagram(sites, unit_box);
        REQUIRE(d);
        check_structure(*d);
        check_vertices(*d, sites, 1e-9);
    }
    for (const double offset : {0.0, 1e6})
        for (const double scale : {1e-9, 1e9}) {
            CAPTURE(offset);
            CAPTURE(scale);
            const Box box{glm::dvec3(offset * scale), glm::dvec3((offset + 1.0) * scale)};
            const auto d = voronoi_diagram(random_sites(50, 2, box), box);
            REQUIRE(d);
            check_structure(*d);
        }
}

TEST_CASE("clusters inside clusters give sound diagrams") {
    Random random(12);
    std::vector<glm::dvec3> sites;
    for (const double size : {1.0, 1e-2, 1e-5}) {
        const glm::dvec3 centre(0.31, 0.72, 0.44);
        const Box box{centre - 0.25 * size, centre + 0.25 * size};
        for (int k = 0; k < 150; ++k) sites.push_back(random.uniform_in(box));
    }
    const auto d = voronoi_diagram(sites, unit_box);
    REQUIRE(d);
    check_structure(*d);
    check_vertices(*d, sites, 1e-9);
    for (const auto& facet : d->facets) { // independent of the order of clipping
        const auto ring = d->ring_of(facet);
        REQUIRE(std::all_of(ring.begin(), ring.end(), [&](const auto& c) { return c.third >= ring[0].third; }));
    }
}

TEST_CASE("neighbours agree with brute force") {
    const auto sites = random_sites(60, 77);
    const auto d = voronoi_diagram(sites, unit_box);
    REQUIRE(d);
    // Random sample points: near the bisector, the second nearest site is a neighbour of the nearest one.
    Random random(4);
    for (int sample = 0; sample < 20000; ++sample) {
        const glm::dvec3 p = random.uniform_in(unit_box);
        uint32_t first = 0, second = 1;
        for (uint32_t s = 0; s < sites.size(); ++s) {
            const double r = glm::distance(sites[s], p);
            if (r < glm::distance(sites[first], p)) {
                second = first;
                first = s;
            } else if (s != first && r < glm::distance(sites[second], p)) {
                second = s;
            }
        }
        if (second == first) continue;
        // The second nearest site is always a Delaunay neighbour of the nearest, but in the box only near the facet.
        const glm::dvec3 n = sites[second] - sites[first];
        const double h = 0.5 * glm::dot(n, sites[second] + sites[first]) - glm::dot(n, p);
        if (h / glm::length(n) < 1e-3) CHECK(d->facet_between(first, second) != VoronoiDiagram::none);
    }
}

// Bounds of rounding that are too large change no result, and make the diagram ten times as slow.
TEST_CASE("the filters decide nearly all questions of a random diagram, wherever its box lies") {
    for (const double offset : {0.0, 0.25}) {
        CAPTURE(offset);
        const Box box{glm::dvec3(offset), glm::dvec3(offset + 0.5)};
        const std::vector<glm::dvec3> sites = random_sites(2000, 5, box);
        Threads threads(1);
        exact::DiagramBuilder builder;
        VoronoiDiagram diagram;
        builder.build({sites, box}, threads, nullptr, diagram);
        CHECK(builder.stats().exact_calls() < diagram.vertices.size() / 1000);
    }
}

TEST_CASE("the diagram does not depend on the number of threads") {
    const auto sites = random_sites(300, 12);
    const auto one = voronoi_diagram(sites, unit_box, 1);
    for (const uint32_t threads : {2u, 4u}) {
        const auto more = voronoi_diagram(sites, unit_box, threads);
        REQUIRE(more);
        REQUIRE(more->vertices.size() == one->vertices.size());
        REQUIRE(more->rings.size() == one->rings.size());
        for (size_t v = 0; v < one->vertices.size(); ++v) {
            REQUIRE(more->vertices[v].planes == one->vertices[v].planes);
            REQUIRE(more->vertices[v].position == one->vertices[v].position);
        }
        for (size_t m = 0; m < one->rings.size(); ++m) {
            REQUIRE(more->rings[m].vertex == one->rings[m].vertex);
            REQUIRE(more->rings[m].edge == one->rings[m].edge);
        }
    }
}

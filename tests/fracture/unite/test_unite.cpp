#include "tests/fracture/unite/unite_checks.h"

#include <array>
#include <optional>

#include <glm/vector_relational.hpp>

#include "fracture/base/random.h"
#include "fracture/fracture.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"

using namespace brittle::fracture;
using namespace brittle::fracture::test;

namespace {

std::vector<glm::dvec3> points_around(const TriangleMesh& mesh, uint32_t count) {
    Random random(7);
    const Box box = bounds(mesh);
    std::vector<glm::dvec3> points;
    for (uint32_t k = 0; k < count; ++k) points.push_back(random.uniform_in(box));
    return points;
}

glm::dvec3 direction(Random& random) {
    while (true) {
        const glm::dvec3 v(random.uniform() * 2.0 - 1.0, random.uniform() * 2.0 - 1.0, random.uniform() * 2.0 - 1.0);
        if (const double length = glm::length(v); length > 0.1 && length < 1.0) return v / length;
    }
}

void rotate(TriangleMesh& mesh, Random& random) {
    const glm::dvec3 x = direction(random), y = glm::normalize(glm::cross(x, direction(random))), z = glm::cross(x, y);
    for (glm::dvec3& p : mesh.positions) p = p.x * x + p.y * y + p.z * z;
}

TriangleMesh tetrahedron(Random& random) {
    TriangleMesh mesh;
    do {
        mesh.positions.clear();
        for (int k = 0; k < 4; ++k) mesh.positions.push_back(random.uniform_in({glm::dvec3(0.0), glm::dvec3(1.0)}));
        mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
        if (signed_volume(mesh) < 0.0) turn_inside_out(mesh);
    } while (signed_volume(mesh) < 1e-3);
    return mesh;
}

// The volume of the part of a tetrahedron within all faces of others, by cutting convex polygons face by face: the
// divergence theorem over the faces of the common part.
double common_volume(const std::vector<TriangleMesh>& solids) {
    struct Plane {
        glm::dvec3 normal;
        double offset;
    };
    std::vector<Plane> planes;
    for (const TriangleMesh& solid : solids)
        for (const Triangle& t : solid.triangles) {
            const glm::dvec3& a = solid.positions[t.x];
            const glm::dvec3 n = glm::normalize(glm::cross(solid.positions[t.y] - a, solid.positions[t.z] - a));
            planes.push_back({n, glm::dot(n, a)});
        }
    double volume = 0.0;
    for (size_t face = 0; face < planes.size(); ++face) {
        const Plane& own = planes[face];
        const glm::dvec3 u = glm::normalize(
            glm::cross(own.normal, std::abs(own.normal.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
        const glm::dvec3 v = glm::cross(own.normal, u), middle = own.offset * own.normal;
        std::vector<glm::dvec3> polygon{middle + 9.0 * u + 9.0 * v, middle - 9.0 * u + 9.0 * v,
                                        middle - 9.0 * u - 9.0 * v, middle + 9.0 * u - 9.0 * v};
        for (size_t k = 0; k < planes.size() && !polygon.empty(); ++k) {
            if (k == face) continue;
            std::vector<glm::dvec3> rest;
            for (size_t i = 0; i < polygon.size(); ++i) {
                const glm::dvec3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
                const double hp = glm::dot(planes[k].normal, p) - planes[k].offset;
                const double hq = glm::dot(planes[k].normal, q) - planes[k].offset;
                if (hp <= 0.0) rest.push_back(p);
                if (hp * hq < 0.0) rest.push_back(p + (q - p) * (hp / (hp - hq)));
            }
            polygon = rest;
        }
        for (size_t i = 1; i + 1 < polygon.size(); ++i)
            volume += glm::dot(polygon[0], glm::cross(polygon[i], polygon[i + 1])) / 6.0;
    }
    return volume;
}

// A square of a side of 1 in the plane z = 0, swept upwards, whose corners are crossed: a figure eight.
TriangleMesh bow_tie() {
    TriangleMesh mesh = box_mesh({0, 0, 0}, {1, 1, 1});
    for (const uint32_t v : {2, 3, 6, 7}) mesh.positions[v].x = 1.0 - mesh.positions[v].x;
    return mesh;
}

} // namespace

TEST_CASE("unite: a solid that meets nothing stays bit for bit") {
    for (const TriangleMesh& mesh : {cube(), icosphere(3), torus(), hollow_sphere(2), menger_sponge(2), torus_knot()})
        CHECK_FALSE(check_union(mesh).report.changed());
}

TEST_CASE("unite: nothing comes of nothing") {
    const United united = unite({});
    CHECK(united.mesh.triangles.empty());
    CHECK_FALSE(united.report.changed());
}

TEST_CASE("unite: boxes in every relation have the volume of what they cover") {
    struct Row {
        const char* name;
        glm::dvec3 low, high;
        double volume;
        size_t triangles; // where it is worth to know; 0 elsewhere
    };
    const std::array rows = {
        Row{"corner in corner", {0.5, 0.5, 0.5}, {1.5, 1.5, 1.5}, 1.875, 0},
        Row{"bar through a face", {0.3, 0.3, 0.3}, {1.4, 0.9, 0.8}, 1.12, 0},
        Row{"bar through both faces", {-0.5, 0.3, 0.3}, {1.4, 0.9, 0.8}, 1.0 + 0.9 * 0.6 * 0.5, 0},
        Row{"face on face", {1, 0, 0}, {2, 1, 1}, 2.0, 20},
        Row{"face within face", {1, 0.25, 0.25}, {2, 0.75, 0.75}, 1.25, 0},
        Row{"face within face, two edges flush", {1, 0.25, 0}, {2, 0.75, 1}, 1.5, 0},
        Row{"faces that overlap", {1, 0.5, 0}, {2, 1.5, 1}, 2.0, 0},
        Row{"the same", {0, 0, 0}, {1, 1, 1}, 1.0, 12},
        Row{"inside, in a corner", {0, 0, 0}, {0.5, 0.5, 0.5}, 1.0, 0},
        Row{"flush bar", {0, 0, 0}, {2, 0.5, 0.5}, 1.25, 0},
        Row{"inside", {0.25, 0.25, 0.25}, {0.5, 0.5, 0.5}, 1.0, 12},
        Row{"longer", {0.5, 0, 0}, {1.5, 1, 1}, 1.5, 0},
        Row{"edge to edge", {1, 1, 0}, {2, 2, 1}, 2.0, 24},
        Row{"corner to corner", {1, 1, 1}, {2, 2, 2}, 2.0, 24},
        Row{"apart", {3, 3, 3}, {4, 4, 4}, 2.0, 24},
    };
    for (const Row& row : rows)
        for (const bool swapped : {false, true}) {
            CAPTURE(row.name);
            CAPTURE(swapped);
            TriangleMesh mesh = box_mesh({0, 0, 0}, {1, 1, 1}), other = box_mesh(row.low, row.high);
            if (swapped) std::swap(mesh, other);
            append(mesh, other);
            const United united = check_union(mesh);
            CHECK(signed_volume(united.mesh) == doctest::Approx(row.volume).epsilon(1e-14));
            if (row.triangles > 0) CHECK(united.mesh.triangles.size() == row.triangles);
        }
}

TEST_CASE("unite: boxes on a lattice fill the cells that one of them fills") {
    // The oracle counts cells. A shear with integers keeps every coordinate exact and lets no face stay axis-parallel.
    Random random(1);
    const auto below = [&](uint32_t n) { return static_cast<int>(random.next() % n); };
    constexpr int size = 5;
    for (int round = 0; round < 150; ++round) {
        CAPTURE(round);
        TriangleMesh mesh;
        std::array<std::array<std::array<bool, size>, size>, size> filled{};
        for (int boxes = 2 + below(5); boxes > 0; --boxes) {
            glm::ivec3 low, high;
            for (int k = 0; k < 3; ++k) {
                low[k] = below(size);
                high[k] = low[k] + 1 + below(static_cast<uint32_t>(size - low[k]));
            }
            append(mesh, box_mesh(low, high));
            for (int x = low.x; x < high.x; ++x)
                for (int y = low.y; y < high.y; ++y)
                    for (int z = low.z; z < high.z; ++z)
                        filled[static_cast<size_t>(x)][static_cast<size_t>(y)][static_cast<size_t>(z)] = true;
        }
        int cells = 0;
        for (const auto& plane : filled)
            for (const auto& row : plane) cells += static_cast<int>(std::count(row.begin(), row.end(), true));
        if (round % 2 == 1)
            for (glm::dvec3& p : mesh.positions)
                p = {p.x + 2.0 * p.y, p.y - p.z, 3.0 * p.x + 7.0 * p.y + p.z}; // of determinant
        const double scale = round % 2 == 1 ? std::abs(1.0 * (1.0 + 7.0) - 2.0 * (0.0 + 3.0)) : 1.0;
        const United united = check_union(mesh);
        CHECK(signed_volume(united.mesh) == doctest::Approx(scale * cells).epsilon(1e-12));
    }
}

TEST_CASE("unite: crowds of boxes on a lattice fill the cells that one of them fills") {
    Random random(8);
    const auto below = [&](uint32_t n) { return static_cast<int>(random.next() % n); };
    constexpr int size = 8;
    for (int round = 0; round < 12; ++round) {
        CAPTURE(round);
        TriangleMesh mesh;
        std::vector<int> filled(size * size * size, 0);
        for (int boxes = 40; boxes > 0; --boxes) {
            glm::ivec3 low, high;
            for (int k = 0; k < 3; ++k) {
                low[k] = below(size - 1);
                high[k] = low[k] + 1 + below(static_cast<uint32_t>(std::min(size - low[k], 4)));
            }
            const bool hollow = round % 3 == 2 && glm::all(glm::greaterThan(high - low, glm::ivec3(2)));
            append(mesh, box_mesh(low, high));
            if (hollow) { // a part with a cavity, in which others may lie
                TriangleMesh cavity = box_mesh(low + 1, high - 1);
                turn_inside_out(cavity);
                append(mesh, cavity);
            }
            for (int x = low.x; x < high.x; ++x)
                for (int y = low.y; y < high.y; ++y)
                    for (int z = low.z; z < high.z; ++z) {
                        const glm::ivec3 cell(x, y, z);
                        const bool in_cavity =
                            hollow && glm::all(glm::greaterThan(cell, low)) && glm::all(glm::lessThan(cell, high - 1));
                        if (!in_cavity) filled[static_cast<size_t>((x * size + y) * size + z)] = 1;
                    }
        }
        const auto cells = static_cast<double>(std::count(filled.begin(), filled.end(), 1));
        const United united = check_union(mesh);
        CHECK(signed_volume(united.mesh) == doctest::Approx(cells).epsilon(1e-12));
        CHECK(std::is_sorted(united.source_triangle.begin(), united.source_triangle.end()));
    }
}

TEST_CASE("unite: crowds of solids in any place fill the space that one of them fills") {
    Random random(9);
    // One part of the last two crowds counts against the others, as a whole or in one half of a figure eight.
    enum class Negative { none, part, half };
    for (const Negative negative : {Negative::none, Negative::part, Negative::half}) {
        CAPTURE(static_cast<int>(negative));
        TriangleMesh mesh;
        for (int k = 0; k < 36; ++k) {
            TriangleMesh part = k % 3 == 0 ? torus(12, 6) : (k % 3 == 1 ? cube(0.8) : icosphere(1, 0.6));
            rotate(part, random);
            if (negative == Negative::part && k == 20) turn_inside_out(part);
            if (negative == Negative::half && k == 20) part = bow_tie();
            append(mesh, part, 0.7 * direction(random));
        }
        const United united = check_union(mesh);
        check_points(mesh, united.mesh, points_around(mesh, 200));
        CHECK((united.report.inside_out > 0.0) == (negative != Negative::none));
        CHECK(united.report.dropped_triangles > 100);
        CHECK(united.report.cut_triangles > 100);

        // Vertices that remain come first, in their order.
        size_t at = 0;
        for (; at < united.mesh.positions.size(); ++at) {
            const auto known = std::find(mesh.positions.begin(), mesh.positions.end(), united.mesh.positions[at]);
            if (known == mesh.positions.end()) break;
            if (at > 0)
                CHECK(known >= std::find(mesh.positions.begin(), mesh.positions.end(), united.mesh.positions[at - 1]));
        }
        CHECK(at > 50);
        for (; at < united.mesh.positions.size(); ++at)
            CHECK(std::find(mesh.positions.begin(), mesh.positions.end(), united.mesh.positions[at])
                  == mesh.positions.end());
        for (const uint32_t threads : {1u, 3u}) {
            const United again = unite(mesh, threads);
            CHECK(again.mesh.positions == united.mesh.positions);
            CHECK(again.mesh.triangles == united.mesh.triangles);
        }
    }
}

TEST_CASE("unite: tetrahedra have the volume of inclusion and exclusion") {
    Random random(2);
    for (int round = 0; round < 200; ++round) {
        CAPTURE(round);
        const TriangleMesh a = tetrahedron(random), b = tetrahedron(random), c = tetrahedron(random);
        TriangleMesh mesh = a;
        append(mesh, b);
        append(mesh, c);
        const double expected = signed_volume(a) + signed_volume(b) + signed_volume(c) - common_volume({a, b})
                                - common_volume({b, c}) - common_volume({c, a}) + common_volume({a, b, c});
        const United united = check_union(mesh);
        CHECK(signed_volume(united.mesh) == doctest::Approx(expected).epsilon(1e-9));
        check_points(mesh, united.mesh, points_around(mesh, 10));
    }
}

TEST_CASE("unite: round solids in any place fill the space that one of them fills") {
    Random random(3);
    for (int round = 0; round < 12; ++round) {
        CAPTURE(round);
        TriangleMesh mesh;
        for (int k = 0; k < 4; ++k) {
            TriangleMesh part =
                k == 0 ? torus(24, 12) : (k == 1 ? torus_knot(2, 3, 60, 8) : (k == 2 ? cube(1.3) : icosphere(2)));
            rotate(part, random);
            append(mesh, part, 0.5 * direction(random));
        }
        const United united = check_union(mesh);
        check_points(mesh, united.mesh, points_around(mesh, 40));
    }
}

TEST_CASE("unite: a shell that passes through itself becomes one that does not") {
    SUBCASE("a tube that is thicker than its bends") {
        TriangleMesh mesh = torus(40, 24, 1.0, 0.4);
        for (glm::dvec3& p : mesh.positions) p.x *= 0.35; // flattened until the inner sides pass through each other
        TriangleMesh knot = torus_knot(2, 3, 120, 12, 0.6);
        for (const TriangleMesh& each : {mesh, knot}) {
            const United united = check_union(each);
            check_points(each, united.mesh, points_around(each, 60));
        }
        CHECK(unite(knot).report.changed());
    }
    SUBCASE("a figure eight keeps the half that is the right way out") {
        const United united = check_union(bow_tie());
        CHECK(united.report.inside_out == doctest::Approx(0.25));
        CHECK(signed_volume(united.mesh) == doctest::Approx(0.25));
        check_points(bow_tie(), united.mesh, points_around(bow_tie(), 60));
    }
    SUBCASE("a ball with crumpled skin") {
        Random random(5);
        for (int round = 0; round < 30; ++round) {
            CAPTURE(round);
            TriangleMesh mesh = icosphere(2);
            for (glm::dvec3& p : mesh.positions) p += direction(random) * random.uniform() * 0.5;
            check_points(mesh, check_union(mesh).mesh, points_around(mesh, 30));
        }
    }
}

TEST_CASE("unite: vertices on a coarse lattice, with faces that fold onto each other") {
    Random random(6);
    for (int round = 0; round < 60; ++round) {
        CAPTURE(round);
        TriangleMesh mesh = round % 2 == 0 ? icosphere(2) : torus(12, 8);
        const double steps = 2.0 + static_cast<double>(random.next() % 6);
        rotate(mesh, random);
        for (glm::dvec3& p : mesh.positions) p = glm::round(p * steps) / steps;
        const United united = check_union(mesh);
        std::vector<glm::dvec3> points = points_around(mesh, 20);
        check_points(mesh, united.mesh, points);
    }
}

TEST_CASE("unite: cavities stay, and parts that are inside out count against the others") {
    TriangleMesh mesh = hollow_sphere(2); // a shell and, in its cavity, a ball
    append(mesh, icosphere(1, 0.3));
    CHECK_FALSE(check_union(mesh).report.changed());

    TriangleMesh cut = box_mesh({0, 0, 0}, {2, 2, 2}), tool = box_mesh({1, 1, 1}, {3, 3, 3});
    turn_inside_out(tool);
    append(cut, tool);
    const United difference = check_union(cut);
    CHECK(signed_volume(difference.mesh) == doctest::Approx(7.0));
    CHECK(difference.report.inside_out == doctest::Approx(7.0));

    TriangleMesh nothing = icosphere(1);
    turn_inside_out(nothing);
    const United empty = unite(nothing);
    CHECK(empty.mesh.triangles.empty());
    CHECK(empty.report.changed());
}

TEST_CASE("unite: triangles without area close no crack and vanish") {
    // The top of a box has a vertex in the middle of one edge, and a triangle without area closes the crack beside it.
    TriangleMesh mesh = box_mesh({0, 0, 0}, {1, 1, 1});
    mesh.positions.push_back({0.5, 1.0, 1.0});
    for (Triangle& t : mesh.triangles) {
        if (t != Triangle(4, 7, 6)) continue;
        t = {4, 7, 8};
        mesh.triangles.push_back({4, 8, 6});
        mesh.triangles.push_back({8, 7, 6});
        break;
    }
    REQUIRE(check_topology(mesh.positions.size(), mesh.triangles).manifold());
    CHECK_FALSE(check_union(mesh).report.changed()); // it bounds its region
    append(mesh, box_mesh({0.25, 0.25, 0.5}, {0.75, 2.0, 1.5}));
    const United united = check_union(mesh);
    CHECK(signed_volume(united.mesh) == doctest::Approx(1.0 + 0.5 * 1.75 * 1.0 - 0.5 * 0.75 * 0.5));
    for (const Triangle& t : united.mesh.triangles) {
        const glm::dvec3& a = united.mesh.positions[t.x];
        CHECK(glm::length(glm::cross(united.mesh.positions[t.y] - a, united.mesh.positions[t.z] - a)) > 1e-12);
    }
}

TEST_CASE("unite: each triangle lies in its source and looks the same way") {
    TriangleMesh mesh = torus(24, 12);
    append(mesh, icosphere(3, 0.6), {1.0, 0.1, 0.2});
    const United united = check_union(mesh);
    for (size_t t = 0; t < united.mesh.triangles.size(); ++t) {
        const auto corners = [](const TriangleMesh& m, const Triangle& c) {
            return std::array{m.positions[c.x], m.positions[c.y], m.positions[c.z]};
        };
        const auto own = corners(united.mesh, united.mesh.triangles[t]);
        const auto source = corners(mesh, mesh.triangles[united.source_triangle[t]]);
        const glm::dvec3 normal = glm::normalize(glm::cross(source[1] - source[0], source[2] - source[0]));
        for (const glm::dvec3& p : own) {
            CHECK(std::abs(glm::dot(normal, p - source[0])) < 1e-14);
            for (size_t k = 0; k < 3; ++k)
                CHECK(glm::dot(normal, glm::cross(source[(k + 1) % 3] - source[k], p - source[k])) > -1e-14);
        }
        CHECK(glm::dot(normal, glm::cross(own[1] - own[0], own[2] - own[0])) > 0.0);
    }
}

TEST_CASE("unite: pieces whose faces rounding has moved into each other do not multiply") {
    const TriangleMesh whole = torus(32, 16);
    for (const uint64_t seed : {1, 2, 3}) {
        CAPTURE(seed);
        const auto made = brittle::fracture::fracture(whole, uniform_sites(bounds(whole), 40, seed));
        REQUIRE(made);
        TriangleMesh mesh;
        for (const Piece& piece : made->pieces) {
            const glm::vec3 centre(piece.mass.centre_of_mass); // as files hold a place and floats around it
            TriangleMesh moved;
            for (const glm::dvec3& p : made->positions_of(piece))
                moved.positions.push_back(glm::dvec3(centre) + glm::dvec3(glm::vec3(p - glm::dvec3(centre))));
            const auto triangles = made->triangles_of(piece);
            moved.triangles.assign(triangles.begin(), triangles.end());
            append(mesh, moved);
        }
        const United united = unite(mesh, 1); // which may be incomplete
        CHECK(check_topology(united.mesh.positions.size(), united.mesh.triangles).manifold());
        CHECK(signed_volume(united.mesh) == doctest::Approx(signed_volume(whole)).epsilon(1e-6));
        CHECK(united.mesh.triangles.size() < 3 * mesh.triangles.size());
        const UniteReport measured = measure_union(mesh);
        CHECK(measured.volume_after == doctest::Approx(signed_volume(whole)).epsilon(1e-6));
        CHECK(measured.cut_triangles == united.report.cut_triangles);
    }
}

TEST_CASE("unite: sizes from atoms to stars, and places far from the origin") {
    for (const double scale : {1e-20, 1e-3, 1e20})
        for (const double far : {0.0, 1e6}) {
            CAPTURE(scale);
            CAPTURE(far);
            TriangleMesh mesh = box_mesh(glm::dvec3(far), glm::dvec3(far + 1.0));
            append(mesh, icosphere(2, 0.5), glm::dvec3(far + 0.9));
            for (glm::dvec3& p : mesh.positions) p *= scale;
            const United united = check_union(mesh);
            CHECK(united.report.changed());
        }
}

TEST_CASE("unite: the number of threads changes no bit") {
    TriangleMesh mesh;
    Random random(9);
    for (int k = 0; k < 12; ++k) append(mesh, icosphere(3, 0.4), random.uniform_in({glm::dvec3(0.0), glm::dvec3(1.0)}));
    const United one = unite(mesh, 1), four = unite(mesh, 4);
    CHECK(one.mesh.positions == four.mesh.positions);
    CHECK(one.mesh.triangles == four.mesh.triangles);
    CHECK(one.source_triangle == four.source_triangle);
}

#include "fracture/pieces/contacts.h"

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "fracture/base/random.h"
#include "fracture/fracture.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/pattern.h"
#include "fracture/sites/sites.h"

using namespace brittle::fracture;

namespace {

TriangleMesh box(const glm::dvec3& low, const glm::dvec3& high) {
    TriangleMesh mesh = cube(2.0);
    for (glm::dvec3& p : mesh.positions) p = 0.5 * (low + high) + 0.5 * p * (high - low);
    return mesh;
}

std::vector<PieceSurface> surfaces_of(const std::vector<TriangleMesh>& meshes) {
    std::vector<PieceSurface> surfaces;
    for (const TriangleMesh& mesh : meshes) surfaces.push_back({mesh.positions, mesh.triangles});
    return surfaces;
}

std::vector<Bond> contacts(const std::vector<TriangleMesh>& meshes, const ContactSettings& settings = {}) {
    Result<std::vector<Bond>> found = find_contacts(surfaces_of(meshes), settings);
    REQUIRE(found);
    return std::move(*found);
}

void check_near(const glm::dvec3& a, const glm::dvec3& b, double distance) {
    CAPTURE(a.x);
    CAPTURE(a.y);
    CAPTURE(a.z);
    CHECK(glm::length(a - b) <= distance);
}

// A rotation by an angle about an axis (Rodrigues).
glm::dmat3 turn(const glm::dvec3& axis, double angle) {
    const glm::dvec3 n = glm::normalize(axis);
    const double c = std::cos(angle), s = std::sin(angle);
    glm::dmat3 m(0.0);
    const glm::dvec3 e[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int k = 0; k < 3; ++k) m[k] = c * e[k] + s * glm::cross(n, e[k]) + (1.0 - c) * n[k] * n;
    return m;
}

TriangleMesh mapped(TriangleMesh mesh, const glm::dmat3& map, const glm::dvec3& move) {
    for (glm::dvec3& p : mesh.positions) p = map * p + move;
    if (glm::dot(map[0], glm::cross(map[1], map[2])) < 0.0)
        for (Triangle& t : mesh.triangles) std::swap(t.y, t.z);
    return mesh;
}

} // namespace

TEST_CASE("no piece, one piece and pieces without triangles have no contacts") {
    CHECK(contacts({}).empty());
    CHECK(contacts({cube()}).empty());
    CHECK(contacts({{}, {}}).empty());
    CHECK(contacts({cube(), {}}).empty());
}

TEST_CASE("broken surfaces and tolerances are errors that name the piece and the triangle") {
    std::vector<TriangleMesh> meshes{cube(), cube()};
    meshes[1].triangles[3].y = 8;
    Result<std::vector<Bond>> found = find_contacts(surfaces_of(meshes));
    REQUIRE_FALSE(found);
    CHECK(found.error().status == Status::invalid_mesh);
    CHECK(found.error().message.find("piece 1, triangle 3") != std::string::npos);
    meshes[1] = cube();
    meshes[1].positions[7].z = std::numeric_limits<double>::quiet_NaN();
    found = find_contacts(surfaces_of(meshes));
    REQUIRE_FALSE(found);
    CHECK(found.error().status == Status::invalid_mesh);
    for (const double tolerance : {-1.0, std::numeric_limits<double>::infinity(), std::nan("")}) {
        found = find_contacts(std::span<const PieceSurface>(), {.tolerance = tolerance});
        REQUIRE_FALSE(found);
        CHECK(found.error().status == Status::invalid_setting);
    }
}

TEST_CASE("boxes that share a point, an edge or their whole space are in no contact") {
    const TriangleMesh one = box({0, 0, 0}, {1, 1, 1});
    CHECK(contacts({one, box({1, 1, 1}, {2, 2, 2})}).empty());
    CHECK(contacts({one, box({1, 1, 0}, {2, 2, 1})}).empty());
    CHECK(contacts({one, box({1, 1, 0.3}, {2, 2, 0.7})}).empty());
    CHECK(contacts({one, one}).empty());
    CHECK(contacts({one, box({0.25, 0.25, 0.25}, {0.75, 0.75, 0.75})}).empty());
    // Turned, edges coincide up to rounding only.
    for (int k = 1; k <= 20; ++k) {
        const glm::dmat3 map = turn({1, 2, 3}, 0.3 * k);
        const glm::dvec3 move(0.1 * k, -0.7, 3.0);
        CHECK(contacts({mapped(one, map, move), mapped(box({1, 1, 0}, {2, 2, 1}), map, move)}).empty());
    }
}

TEST_CASE("faces without area make no contact, nor hide that of others") {
    TriangleMesh needle = box({1, 0, 0}, {2, 1, 1});
    const auto first = static_cast<uint32_t>(needle.positions.size());
    needle.positions.insert(needle.positions.end(), {{1, 0, 0}, {1, 0.5, 0.5}, {1, 1, 1}, {1, 0, 0}});
    needle.triangles.insert(needle.triangles.begin(), {first, first + 1, first + 2});
    needle.triangles.insert(needle.triangles.begin(), {first, first + 3, first + 1});
    needle.triangles.emplace_back(0, 0, 0);
    const std::vector<Bond> found = contacts({box({0, 0, 0}, {1, 1, 1}), needle});
    REQUIRE(found.size() == 1);
    CHECK(found[0].area == doctest::Approx(1.0).epsilon(1e-12));
}

TEST_CASE("the contact of two boxes is the rectangle that their faces share") {
    const std::vector<Bond> found = contacts({box({0, 0, 0}, {1, 1, 1}), box({1, 0.25, -0.5}, {3, 2, 0.75})});
    REQUIRE(found.size() == 1);
    CHECK(found[0].a == 0);
    CHECK(found[0].b == 1);
    CHECK(found[0].area == doctest::Approx(0.75 * 0.75).epsilon(1e-12));
    check_near(found[0].centroid, {1.0, 0.625, 0.375}, 1e-12);
    check_near(found[0].normal, {1, 0, 0}, 1e-12);
    const std::vector<Bond> other = contacts({box({1, 0.25, -0.5}, {3, 2, 0.75}), box({0, 0, 0}, {1, 1, 1})});
    REQUIRE(other.size() == 1);
    check_near(other[0].normal, {-1, 0, 0}, 1e-12);
}

TEST_CASE("a grid divides a contact into cells that have all of it") {
    const TriangleMesh low = box({0, 0, 0}, {3, 1, 2}), high = box({0, 1, 0}, {3, 2, 2});
    const auto divided = [&](const ContactGrid& grid, const TriangleMesh& a, const TriangleMesh& b) {
        return contacts({a, b}, {.grid = [&](uint32_t, uint32_t) { return grid; }});
    };
    // Six squares of 1 m; the height of the face, a multiple of the size too, divides nothing.
    const std::vector<Bond> squares = divided({{0, 0, 0}, 1.0}, low, high);
    REQUIRE(squares.size() == 6);
    glm::dvec3 sum(0.0);
    for (const Bond& bond : squares) {
        CHECK(bond.area == doctest::Approx(1.0).epsilon(1e-12));
        check_near(bond.centroid - glm::floor(bond.centroid), {0.5, 0.0, 0.5}, 1e-9);
        check_near(bond.normal, {0, 1, 0}, 1e-12);
        sum += bond.centroid;
    }
    check_near(sum / 6.0, {1.5, 1.0, 1.0}, 1e-12);
    // A border of the grid that is off by rounding makes no sliver.
    CHECK(divided({{1e-9, 0, -1e-9}, 1.0}, low, high).size() == 6);
    CHECK(divided({{0, 0, 0}, 5.0}, low, high).size() == 1);
    // Turned, with cells that the face does not fill: the sums are those of the undivided contact.
    const glm::dmat3 map = turn({1, 2, -1}, 0.7);
    const TriangleMesh a = mapped(low, map, {5, -3, 1}), b = mapped(high, map, {5, -3, 1});
    const Bond whole = contacts({a, b}).at(0);
    const std::vector<Bond> cells = divided({{0.3, 0.1, 0.2}, 0.7}, a, b);
    CHECK(cells.size() > 6);
    double area = 0.0;
    glm::dvec3 moment(0.0);
    for (const Bond& bond : cells) {
        area += bond.area;
        moment += bond.area * bond.centroid;
        CHECK(bond.area <= 0.7 * 0.7 * std::sqrt(3.0));
        check_near(bond.normal, whole.normal, 1e-12);
    }
    CHECK(area == doctest::Approx(whole.area).epsilon(1e-12));
    check_near(moment / area, whole.centroid, 1e-11);
    for (const double size : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), 1e-9, 0.001}) {
        CAPTURE(size);
        const auto grid = [&](uint32_t, uint32_t) { return ContactGrid{{}, size}; };
        const auto found = find_contacts(surfaces_of({low, high}), {.grid = grid});
        REQUIRE_FALSE(found);
        CHECK(found.error().status == Status::invalid_setting);
    }
}

TEST_CASE("rotated, mirrored, scaled and far from the origin a contact is the same") {
    Random random(7);
    for (int k = 0; k < 60; ++k) {
        const double scale = std::pow(10.0, 3.0 * random.uniform() - 1.5);
        glm::dmat3 map =
            scale * turn({random.uniform() - 0.5, random.uniform(), random.uniform() - 0.5}, 6.0 * random.uniform());
        if (k % 3 == 0) map[1] = -map[1];
        const glm::dvec3 move = (k % 2 == 0 ? 1.0 : 1000.0) * glm::dvec3(random.uniform(), random.uniform(), -0.5);
        const std::vector<Bond> found =
            contacts({mapped(box({0, 0, 0}, {1, 1, 1}), map, move), mapped(box({1, 0.5, 0.25}, {2, 2, 2}), map, move)});
        CAPTURE(k);
        REQUIRE(found.size() == 1);
        CHECK(found[0].area == doctest::Approx(0.375 * scale * scale).epsilon(1e-9));
        check_near(found[0].centroid, map * glm::dvec3(1.0, 0.75, 0.625) + move, 1e-9 * (scale + glm::length(move)));
        check_near(found[0].normal, glm::normalize(map * glm::dvec3(1, 0, 0)), 1e-9);
    }
}

TEST_CASE("a gap or an overlap within the tolerance is a contact, a wider one is not") {
    for (const double gap : {-1e-3, 1e-3}) {
        const std::vector<TriangleMesh> meshes{box({0, 0, 0}, {1, 1, 1}), box({1 + gap, 0, 0}, {2, 1, 1})};
        CHECK(contacts(meshes, {.tolerance = 0.9e-3}).empty());
        const std::vector<Bond> found = contacts(meshes, {.tolerance = 1.1e-3});
        REQUIRE(found.size() == 1);
        CHECK(found[0].area == doctest::Approx(1.0).epsilon(1e-12));
        check_near(found[0].centroid, {1.0 + 0.5 * gap, 0.5, 0.5}, 1e-12);
    }
}

TEST_CASE("a face that leans away by more than a degree, or by more than the tolerance, is in no contact") {
    const TriangleMesh one = box({0, 0, 0}, {1, 1, 1});
    const auto leaning = [&](double degrees) {
        TriangleMesh other = box({0, 0, 0}, {1, 1, 1});
        return mapped(other, turn({0, 0, 1}, -degrees * std::numbers::pi / 180.0), {1, 0, 0});
    };
    CHECK(contacts({one, leaning(0.5)}, {.tolerance = 0.01}).size() == 1);
    CHECK(contacts({one, leaning(0.5)}, {.tolerance = 0.001}).empty());
    CHECK(contacts({one, leaning(3.0)}, {.tolerance = 0.1}).empty());
}

TEST_CASE("the contacts of two pieces in two planes are one bond with the mean normal") {
    // An L around a corner of a box.
    const TriangleMesh inner = box({0, 0, 0}, {1, 1, 1});
    TriangleMesh outer = box({1, 0, 0}, {2, 2, 1});
    const TriangleMesh lid = box({0, 1, 0}, {1, 2, 1});
    const auto base = static_cast<uint32_t>(outer.positions.size());
    outer.positions.insert(outer.positions.end(), lid.positions.begin(), lid.positions.end());
    for (const Triangle& t : lid.triangles) outer.triangles.push_back(t + base);
    const std::vector<Bond> found = contacts({inner, outer});
    REQUIRE(found.size() == 1);
    CHECK(found[0].area == doctest::Approx(2.0));
    check_near(found[0].centroid, {0.75, 0.75, 0.5}, 1e-12);
    check_near(found[0].normal, glm::normalize(glm::dvec3(1, 1, 0)), 1e-12);
    // A tongue in a groove: the two sides cancel, and the larger one decides.
    TriangleMesh groove = box({0, 0, 0}, {1, 1, 1});
    const TriangleMesh far_side = box({2, 0, 0}, {3, 0.5, 1});
    for (const Triangle& t : far_side.triangles) groove.triangles.push_back(t + 8u);
    groove.positions.insert(groove.positions.end(), far_side.positions.begin(), far_side.positions.end());
    const std::vector<Bond> held = contacts({box({1, 0, 0}, {2, 1, 1}), groove});
    REQUIRE(held.size() == 1);
    CHECK(held[0].area == doctest::Approx(1.5));
    check_near(held[0].normal, {-1, 0, 0}, 1e-12);
}

TEST_CASE("contacts that are not wanted are not looked for") {
    const std::vector<TriangleMesh> row{box({0, 0, 0}, {1, 1, 1}), box({1, 0, 0}, {2, 1, 1}),
                                        box({2, 0, 0}, {3, 1, 1})};
    CHECK(contacts(row).size() == 2);
    const std::vector<Bond> found = contacts(row, {.wanted = [](uint32_t a, uint32_t b) {
                                                 CHECK(a < b);
                                                 return a == 1;
                                             }});
    REQUIRE(found.size() == 1);
    CHECK(found[0].a == 1);
    CHECK(found[0].b == 2);
}

TEST_CASE("the contacts of a fracture, found in its pieces alone, are its bonds") {
    const auto check = [](const TriangleMesh& mesh, const Pattern& pattern) {
        const Result<PatternSites> made = make_sites(pattern, mesh);
        REQUIRE(made);
        const Result<Fragments> fragments = fracture(mesh, made->sites, {});
        REQUIRE(fragments);
        REQUIRE(fragments->bonds.size() > 10);
        const Result<std::vector<Bond>> found = find_contacts(*fragments, {.tolerance = 1e-9});
        REQUIRE(found);
        REQUIRE(found->size() == fragments->bonds.size());
        for (size_t k = 0; k < found->size(); ++k) {
            const Bond &ours = (*found)[k], &theirs = fragments->bonds[k];
            CAPTURE(k);
            CHECK(ours.a == theirs.a);
            CHECK(ours.b == theirs.b);
            CHECK(std::abs(ours.area - theirs.area) <= 1e-6 * theirs.area);
            check_near(ours.centroid, theirs.centroid, 1e-6);
            check_near(ours.normal, theirs.normal, 1e-5);
        }
    };
    check(cube(), {.count = 60});
    check(torus(), {.count = 100, .seed = 5});
    check(icosphere(3), {.kind = PatternKind::bricks, .count = 40});
    check(mapped(icosphere(3), turn({1, 1, 0}, 1.0), {100, 20, -3}), {.count = 80});
}

// BRITTLE_MEASURE_CONTACTS=1: the time for 10,000 pieces of a million faces.
TEST_CASE("the contacts of many pieces") {
    const char* const large = std::getenv("BRITTLE_MEASURE_CONTACTS");
    const TriangleMesh mesh = icosphere(large ? 7 : 3);
    const std::vector<glm::dvec3> sites = uniform_sites(bounds(mesh), large ? 19'000 : 300, 1);
    const Result<Fragments> fragments = fracture(mesh, sites, {});
    REQUIRE(fragments);
    const auto start = std::chrono::steady_clock::now();
    const Result<std::vector<Bond>> found = find_contacts(*fragments);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    REQUIRE(found);
    CHECK(found->size() >= fragments->bonds.size() * 99 / 100);
    if (large)
        MESSAGE(fragments->pieces.size(), " pieces, ", fragments->triangles.size(), " triangles, ", found->size(),
                " contacts, ", fragments->bonds.size(), " bonds: ", seconds.count(), " s");
}

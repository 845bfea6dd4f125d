#include "physics/cutting/solid_piece.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <span>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/base/random.h"
#include "fracture/fracture.h"
#include "fracture/mesh/convex_hull.h"
#include "fracture/mesh/topology.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

SolidPtr must_make(const fracture::TriangleMesh& mesh, const SolidSettings& settings = {}) {
    const fracture::Result<SolidPtr> solid = make_solid(mesh, settings);
    REQUIRE_MESSAGE(solid.has_value(), (solid ? std::string() : solid.error().message));
    return *solid;
}

std::vector<SolidPtr> must_break(const SolidPiece& solid, uint32_t count, uint64_t seed,
                                 const SolidSettings& settings) {
    const auto sites = fracture::uniform_sites(fracture::bounds(solid.surface().mesh), count, seed);
    std::vector<uint32_t> groups;
    for (uint32_t i = 0; i < count; ++i) groups.push_back(i);
    const auto pieces = break_solid(solid, sites, groups, settings);
    REQUIRE_MESSAGE(pieces.has_value(), (pieces ? std::string() : pieces.error().message));
    return *pieces;
}

} // namespace

TEST_CASE("solid piece: invalid meshes and settings are refused") {
    CHECK_FALSE(make_solid({}).has_value());
    fracture::TriangleMesh open = fracture::cube();
    open.triangles.pop_back();
    CHECK(make_solid(open).error().status == fracture::Status::not_closed);
    for (const double size : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()})
        CHECK(make_solid(fracture::cube(), {.min_size = size}).error().message.find("least size") != std::string::npos);
    CHECK_FALSE(make_solid(fracture::cube(), {.material = {.fracture_energy = 0.0f}}).has_value());
    const SolidPtr cube = must_make(fracture::cube());
    CHECK_FALSE(break_solid(*cube, {}, {}, {}).has_value());
    const glm::dvec3 site(0.0);
    const uint32_t group = 0;
    CHECK(break_solid(*cube, {&site, 1}, {&group, 1}, {}, [] { return true; }).error().status
          == fracture::Status::cancelled);
}

TEST_CASE("solid piece: after three levels pieces are closed, volumes sum to the whole, and old cuts stay interior") {
    const fracture::TriangleMesh mesh = fracture::four_legged_animal(48);
    const double volume = fracture::signed_volume(mesh.positions, mesh.triangles);
    double area = 0.0;
    for (const fracture::Triangle& t : mesh.triangles)
        area += 0.5
                * glm::length(
                    glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]));
    const SolidSettings settings{.min_size = 1e-6};
    std::vector<SolidPtr> pieces{must_make(mesh, settings)};
    for (int level = 1; level <= 3; ++level) {
        std::vector<SolidPtr> next;
        for (size_t i = 0; i < pieces.size(); ++i)
            for (const SolidPtr& piece :
                 must_break(*pieces[i], level == 3 ? 4 : 6, 10 * i + static_cast<size_t>(level), settings))
                next.push_back(piece);
        pieces = std::move(next);
        double sum = 0.0, exterior = 0.0;
        std::set<uint32_t> sources;
        for (const SolidPtr& piece : pieces) {
            REQUIRE(piece->breakable);
            const fracture::TriangleMesh& m = piece->surface().mesh;
            CHECK(fracture::check_topology(m.positions.size(), m.triangles).manifold());
            sum += fracture::signed_volume(m.positions, m.triangles);
            CHECK(piece->surface().source.size() == piece->surface().exterior_triangles);
            CHECK(piece->surface().positions.size() == m.positions.size());
            CHECK_FALSE(piece->parts.empty());
            for (uint32_t k = 0; k < piece->surface().exterior_triangles; ++k) {
                const glm::dvec3 a = m.positions[m.triangles[k].x], b = m.positions[m.triangles[k].y],
                                 c = m.positions[m.triangles[k].z];
                exterior += 0.5 * glm::length(glm::cross(b - a, c - a));
                // The exterior triangle lies in the plane of its source triangle.
                const fracture::Triangle& from = mesh.triangles[piece->surface().source[k]];
                sources.insert(piece->surface().source[k]);
                const glm::dvec3 p = mesh.positions[from.x];
                const glm::dvec3 n = glm::cross(mesh.positions[from.y] - p, mesh.positions[from.z] - p);
                if (glm::length(n) > 1e-9)
                    for (const glm::dvec3& at : {a, b, c}) CHECK(std::abs(glm::dot(glm::normalize(n), at - p)) < 1e-6);
            }
        }
        MESSAGE("level ", level, ": ", pieces.size(), " pieces, volume off by ", std::abs(sum - volume) / volume);
        CHECK(std::abs(sum - volume) < 1e-9 * volume);
        CHECK(std::abs(exterior - area) < 1e-9 * area);
        CHECK(sources.size() == mesh.triangles.size());
    }
}

TEST_CASE("solid piece: rough pieces of rough pieces are closed, and volumes and exterior areas sum to the whole") {
    const fracture::TriangleMesh mesh = fracture::torus(48, 24);
    const SolidPtr whole = must_make(mesh);
    const SolidSettings settings{.min_size = 1e-3, .rough = {.amount = 1.0}};
    std::vector<SolidPtr> pieces{whole};
    for (uint64_t level = 1; level <= 2; ++level) {
        std::vector<SolidPtr> next;
        for (size_t i = 0; i < pieces.size(); ++i)
            if (pieces[i]->breakable)
                for (const SolidPtr& piece : must_break(*pieces[i], 6, 10 * i + level, settings)) next.push_back(piece);
        CHECK(next.size() > 2 * pieces.size());
        pieces = std::move(next);
        double volume = 0.0, exterior = 0.0;
        for (const SolidPtr& piece : pieces) {
            volume += piece->mass.volume;
            if (!piece->breakable) continue;
            const fracture::TriangleMesh& m = piece->surface().mesh;
            CHECK(fracture::check_topology(m.positions.size(), m.triangles).manifold());
            CHECK(fracture::signed_volume(m.positions, m.triangles) == doctest::Approx(piece->mass.volume));
            for (const fracture::Triangle& t : std::span(m.triangles).first(piece->surface().exterior_triangles))
                exterior +=
                    0.5
                    * glm::length(glm::cross(m.positions[t.y] - m.positions[t.x], m.positions[t.z] - m.positions[t.x]));
        }
        CHECK(volume == doctest::Approx(whole->mass.volume).epsilon(1e-9));
        if (std::ranges::all_of(pieces, [](const SolidPtr& piece) { return piece->breakable; }))
            CHECK(exterior == doctest::Approx(whole->mass.area).epsilon(1e-9));
    }
}

TEST_CASE("solid piece: cuts keep numbers of their own through later cuts") {
    const SolidPtr whole = must_make(fracture::cube(1.0));
    CHECK(whole->surface().cut.empty());
    const SolidSettings settings{.min_size = 0.01};
    std::vector<SolidPtr> pieces{whole};
    for (uint64_t level = 1; level <= 3; ++level) {
        std::vector<SolidPtr> next;
        for (const SolidPtr& piece : pieces)
            for (const SolidPtr& part : must_break(*piece, 4, level, settings)) next.push_back(part);
        pieces = std::move(next);
        size_t most = 0;
        for (const SolidPtr& piece : pieces) {
            const fracture::TriangleMesh& mesh = piece->surface().mesh;
            REQUIRE(piece->surface().cut.size() == mesh.triangles.size() - piece->surface().exterior_triangles);
            if (!piece->breakable) continue;        // without positions
            std::map<uint32_t, glm::dvec3> normals; // every cell is convex, so each of its cuts has a direction
            for (size_t k = 0; k < piece->surface().cut.size(); ++k) {
                const fracture::Triangle& t = mesh.triangles[piece->surface().exterior_triangles + k];
                const glm::dvec3 area =
                    glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
                if (glm::length(area) < 1e-9) continue;
                const auto [known, is_new] = normals.emplace(piece->surface().cut[k], glm::normalize(area));
                CHECK(glm::distance(known->second, glm::normalize(area)) < 1e-5);
                for (const auto& [number, other] : normals)
                    if (number != piece->surface().cut[k]) CHECK(glm::distance(other, glm::normalize(area)) > 1e-5);
            }
            most = std::max(most, normals.size());
        }
        CHECK(most > level); // of old and new cuts
    }
}

TEST_CASE("solid piece: where the pieces of a blow are hardly larger than the minimum size, its cuts are flat") {
    const SolidPtr whole = must_make(fracture::cube(1.0));
    const auto triangles = [&](double min_size, double amount) {
        size_t sum = 0;
        for (const SolidPtr& piece : must_break(*whole, 20, 1, {.min_size = min_size, .rough = {.amount = amount}}))
            sum += piece->surface().mesh.triangles.size();
        return sum;
    };
    CHECK(triangles(0.02, 1.0) > 4 * triangles(0.02, 0.0));
    CHECK(triangles(0.2, 1.0) == triangles(0.2, 0.0));
}

TEST_CASE("solid piece: the hull of a rough piece has the size of the piece") {
    const SolidPtr whole = must_make(fracture::cube(1.0));
    for (const SolidPtr& piece : must_break(*whole, 12, 3, {.min_size = 0.01, .rough = {.amount = 1.0}})) {
        double volume = 0.0;
        for (const BodyPart& part : piece->parts) {
            const fracture::TriangleMesh hull = fracture::convex_hull(part.hull->points);
            volume += fracture::signed_volume(hull.positions, hull.triangles);
        }
        // The margin takes a little off, and the planes of the contacts what bumps there are.
        CHECK(volume > 0.6 * piece->mass.volume);
        CHECK(volume < 1.2 * piece->mass.volume);
    }
}

TEST_CASE("solid piece: islands of held blocks break apart along flat and rough cuts, whatever pieces these yield") {
    // Disks on a shaft: one cell of the blocks holds several pieces.
    const fracture::TriangleMesh comb = fracture::lathe({{0.1, 0.0},
                                                         {0.1, 0.3},
                                                         {0.5, 0.32},
                                                         {0.5, 0.38},
                                                         {0.1, 0.4},
                                                         {0.1, 0.5},
                                                         {0.5, 0.52},
                                                         {0.5, 0.58},
                                                         {0.1, 0.6},
                                                         {0.1, 1.0}},
                                                        24);
    for (const double amount : {0.0, 0.4, 1.0}) {
        CAPTURE(amount);
        const SolidSettings settings{
            .min_size = 0.01, .anchors = {fracture::Box{{-1.0, -1.0, -1.0}, {1.0, 0.05, 1.0}}}, .rough = {amount}};
        const SolidPtr solid = must_make(comb, settings);
        REQUIRE(solid->blocks);
        const std::vector<StressNode>& nodes = solid->blocks->nodes;
        CHECK(solid->blocks->cells.size() == nodes.size());
        for (const double height : {0.2, 0.35, 0.45, 0.55}) {
            CAPTURE(height);
            std::vector<uint32_t> islands;
            for (const StressNode& node : nodes) islands.push_back(node.centre.y > height);
            const auto pieces = break_apart(*solid, islands, settings);
            REQUIRE(pieces.has_value());
            CHECK(pieces->size() == 2);
            double volume = 0.0;
            for (const SolidPtr& piece : *pieces) volume += piece->mass.volume;
            CHECK(volume == doctest::Approx(solid->mass.volume).epsilon(1e-9));
        }
    }
}

TEST_CASE("solid piece: none is below the minimum size, and a solid too small for two is not cut") {
    const SolidSettings settings{.min_size = 0.3};
    const SolidPtr cube = must_make(fracture::cube(1.0), settings);
    const std::vector<SolidPtr> pieces = must_break(*cube, 200, 7, settings);
    CHECK(pieces.size() > 5);
    for (const SolidPtr& piece : pieces) {
        CHECK(std::cbrt(piece->mass.volume) >= 0.3);
        CHECK(piece->breakable == (piece->mass.volume >= 2.0 * 0.027));
        CHECK(piece->surface().mesh.positions.empty() != piece->breakable);
    }
    CHECK_FALSE(must_make(fracture::cube(0.37), settings)->breakable); // 0.0507 m^3, below twice the minimum of 0.027
}

TEST_CASE("solid piece: a group is one piece with a hull for each cell, and hulls of pieces do not overlap") {
    const SolidSettings settings{.min_size = 0.01};
    const SolidPtr cube = must_make(fracture::cube(1.0), settings);
    const auto sites = fracture::uniform_sites(fracture::bounds(cube->surface().mesh), 30, 3);
    std::vector<uint32_t> groups(30, 20);
    for (uint32_t i = 0; i < 20; ++i) groups[i] = i;
    const auto pieces = break_solid(*cube, sites, groups, settings);
    REQUIRE(pieces.has_value());
    size_t parts = 0;
    double sum = 0.0;
    for (const SolidPtr& piece : *pieces) {
        parts += piece->parts.size();
        sum += piece->mass.volume;
        for (const BodyPart& part : piece->parts) {
            // All vertices of a hull are nearest to one site, that of its cell.
            std::set<size_t> cells;
            for (const glm::vec3& corner : part.hull->points) {
                const glm::dvec3 at = glm::dvec3(corner + part.offset) + piece->mass.centre_of_mass;
                size_t nearest = 0;
                for (size_t i = 1; i < sites.size(); ++i)
                    if (glm::distance(at, sites[i]) < glm::distance(at, sites[nearest])) nearest = i;
                cells.insert(nearest);
            }
            CHECK(cells.size() == 1);
        }
    }
    CHECK(parts == 30);
    CHECK(pieces->size() < 30);
    CHECK(pieces->size() >= 21);
    CHECK(sum == doctest::Approx(1.0).epsilon(1e-12));
}

TEST_CASE("solid piece: one that reaches into an anchor is anchored, also without a vertex inside") {
    const SolidSettings settings{.min_size = 0.01,
                                 .anchors = {fracture::Box{{-0.05, -0.6, -0.05}, {0.05, -0.45, 0.05}}}};
    const SolidPtr cube = must_make(fracture::cube(1.0), settings);
    CHECK(cube->anchored); // the anchor box pierces the middle of its lower face
    const glm::dvec3 sites[] = {{0.0, -0.25, 0.0}, {0.0, 0.25, 0.0}};
    const uint32_t groups[] = {0, 1};
    const auto halves = break_solid(*cube, sites, groups, settings);
    REQUIRE(halves->size() == 2);
    CHECK((*halves)[0]->anchored);
    CHECK_FALSE((*halves)[1]->anchored);
}

TEST_CASE("solid piece: thin and slender solids bear less than a cube of their volume") {
    const Material material;
    const auto bears = [&](const glm::dvec3& size) {
        return must_make(fracture::cuboid(size), {.material = material})->bearable;
    };
    // The section across the longest side, small enough that the strength decides.
    CHECK(bears({0.5, 0.5, 0.5}) == doctest::Approx(0.25 * material.tensile));
    CHECK(bears({1.0, 1.0, 0.1}) == doctest::Approx(0.1 * material.tensile));
    CHECK(bears({10.0, 0.1, 0.1}) == doctest::Approx(0.01 * material.tensile));
}

TEST_CASE("solid piece: rough pieces that are cut again along the cuts that they have stay closed") {
    const fracture::TriangleMesh mesh = *fracture::shape("wall");
    const fracture::Box box = fracture::bounds(mesh);
    std::vector<glm::dvec3> sites; // of a lattice
    std::vector<uint32_t> groups;
    for (int x = 0; x < 5; ++x)
        for (int y = 0; y < 5; ++y) {
            sites.push_back(box.min + glm::dvec3((x + 0.5) / 5.0, (y + 0.5) / 5.0, 0.5) * box.size());
            groups.push_back(static_cast<uint32_t>(groups.size()));
        }
    SolidSettings settings{.min_size = 0.01, .rough = {.amount = 0.4, .wavelength = 0.2}};
    std::vector<SolidPtr> solids{must_make(mesh, settings)};
    for (uint64_t level = 1; level <= 3; ++level) {
        settings.rough.seed = level;
        std::vector<SolidPtr> pieces;
        for (const SolidPtr& solid : solids) {
            const auto broken = break_solid(*solid, sites, groups, settings);
            REQUIRE_MESSAGE(broken.has_value(), (broken ? std::string() : broken.error().message));
            pieces.insert(pieces.end(), broken->begin(), broken->end());
        }
        for (const SolidPtr& piece : pieces) {
            const auto report =
                fracture::check_topology(piece->surface().positions.size(), piece->surface().mesh.triangles);
            CHECK(fracture::describe(report) == "");
        }
        solids.clear();
        for (const SolidPtr& piece : pieces)
            if (piece->breakable && solids.size() < 12) solids.push_back(piece);
    }
}

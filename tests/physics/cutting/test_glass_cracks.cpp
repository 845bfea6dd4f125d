// The cracks of glass: rays from the contact that reach the edges, and what a second blow makes of them.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "tests/physics/bodies.h"
#include "tests/physics/destruction_fixture.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_destruction;
using test_bodies::empty_space;

namespace {

const glm::dvec3 half(1.0, 0.7, 0.015); // of the pane, m

BreakableDesc pane_desc(uint64_t seed) {
    BreakableDesc desc = desc_of(0.01, material_preset("glass")->material);
    desc.pattern.kind = fracture::PatternKind::radial;
    desc.pattern.seed = seed;
    return desc;
}

bool on_rim(const glm::dvec3& p) {
    return std::abs(std::abs(p.x) - half.x) < 1e-6 || std::abs(std::abs(p.y) - half.y) < 1e-6;
}

std::vector<glm::dvec3> points_of(const SolidPiece& solid) {
    std::vector<glm::dvec3> points;
    for (const glm::vec3& p : solid.surface().positions) points.push_back(solid.mass.centre_of_mass + glm::dvec3(p));
    return points;
}

struct Cracks {
    size_t pieces = 0, at_rim = 0; // pieces in all, and those that reach the rim
    double largest = 0.0;          // share of the pane
    size_t rays = 0;               // cracks that end at the rim and whose planes hold the contact, by their directions
    double astray = 0.0; // m, largest distance between the contact and the plane of a crack that ends at the rim
    bool broke = false;
};

Cracks cracks_of(double energy, const glm::dvec3& at, uint64_t seed, double force = 1e12) {
    World world(empty_space);
    Destruction destruction;
    must_add(destruction, world, fracture::cuboid(2.0 * half), pane_desc(seed));
    const auto cut =
        destruction.foresee(world, destruction.pieces()[0], glm::vec3(at), {0.0f, 0.0f, -1.0f}, energy, force);
    if (!cut) return {};
    const auto pieces = carry_out(*cut);
    REQUIRE(pieces);
    Cracks cracks{.pieces = pieces->size(), .broke = pieces->size() > 1};
    std::vector<glm::dvec3> ways;
    for (const SolidPtr& piece : *pieces) {
        const std::vector<glm::dvec3> points = points_of(*piece);
        cracks.at_rim += std::ranges::any_of(points, on_rim);
        cracks.largest = std::max(cracks.largest, piece->mass.volume / (8.0 * half.x * half.y * half.z));
        for (size_t t = piece->surface().exterior_triangles; t < piece->surface().mesh.triangles.size(); ++t) {
            const fracture::Triangle& corners = piece->surface().mesh.triangles[t];
            const glm::dvec3 a = points[corners[0]], b = points[corners[1]], c = points[corners[2]];
            if (!on_rim(a) && !on_rim(b) && !on_rim(c)) continue;
            const glm::dvec3 normal = glm::cross(b - a, c - a);
            if (glm::length(normal) < 1e-6) continue; // a sliver has no plane
            const double distance = std::abs(glm::dot(glm::normalize(normal), at - a));
            cracks.astray = std::max(cracks.astray, distance);
            if (distance > 1e-3) continue;
            const glm::dvec3 end = on_rim(a) ? a : on_rim(b) ? b : c, way = glm::normalize(end - at);
            if (std::ranges::all_of(ways, [&](const glm::dvec3& known) { return glm::dot(known, way) < 0.9998; }))
                ways.push_back(way);
        }
    }
    cracks.rays = ways.size();
    return cracks;
}

} // namespace

TEST_CASE("glass cracks: a blow without energy makes none, also at a corner of the pane") {
    CHECK_FALSE(cracks_of(0.0, {0.0, 0.0, half.z}, 1).broke);
    CHECK_FALSE(cracks_of(1e-6, half, 1).broke);
    CHECK_FALSE(cracks_of(1e-6, {half.x, 0.0, half.z}, 1).broke);
}

TEST_CASE("glass cracks: rays from the contact reach the edges, with concentric cracks between them") {
    for (const glm::dvec3& at : {glm::dvec3(0.0, 0.0, half.z), {-0.4, 0.3, half.z}, {0.7, -0.5, half.z}})
        for (uint64_t seed = 1; seed <= 8; ++seed)
            for (const double energy : {200.0, 600.0, 3000.0}) {
                CAPTURE(at.x);
                CAPTURE(seed);
                CAPTURE(energy);
                const Cracks cracks = cracks_of(energy, at, seed);
                CHECK(cracks.at_rim >= 3);
                CHECK(cracks.pieces > cracks.at_rim);
                CHECK(cracks.pieces <= 48);
                CHECK(cracks.largest < 0.75);
                CHECK(cracks.rays >= 3);
                if (energy == 3000.0) CHECK(cracks.rays >= 6);
                if (at.x == 0.0) CHECK(cracks.astray < 1e-3); // elsewhere concentric cracks reach the nearest edge
            }
}

TEST_CASE("glass cracks: a blow that does not pay for rays, or that the pane bears, makes a hole") {
    size_t holes = 0, before = 0;
    for (const double energy : {10.0, 40.0, 3000.0}) {
        size_t rays = 0;
        for (uint64_t seed = 1; seed <= 8; ++seed) {
            const Cracks cracks = cracks_of(energy, {-0.1, 0.2, half.z}, seed);
            rays += cracks.at_rim;
            if (cracks.at_rim != 1) continue;
            ++holes;
            CHECK(cracks.broke);
            CHECK(cracks.largest > 0.9);
        }
        CHECK(rays >= before);
        before = rays;
    }
    CHECK(holes >= 8);
    const double borne =
        0.9 * bearable_force(material_preset("glass")->material, 8.0 * half.x * half.y * half.z, {-half, half});
    for (const double energy : {100.0, 1e4}) CHECK(cracks_of(energy, {-0.1, 0.2, half.z}, 1, borne).largest > 0.9);
}

TEST_CASE("glass cracks: those of a second blow end at those of the first") {
    for (uint64_t seed = 1; seed <= 6; ++seed) {
        CAPTURE(seed);
        World world(empty_space);
        Destruction destruction;
        BreakableDesc desc = pane_desc(seed);
        desc.solid.anchors = {
            fracture::Box{{-2.0, -2.0, -1.0}, {2.0, -0.68, 1.0}}, fracture::Box{{-2.0, 0.68, -1.0}, {2.0, 2.0, 1.0}},
            fracture::Box{{-2.0, -2.0, -1.0}, {-0.98, 2.0, 1.0}}, fracture::Box{{0.98, -2.0, -1.0}, {2.0, 2.0, 1.0}}};
        must_add(destruction, world, fracture::cuboid(2.0 * half), desc);
        REQUIRE(destruction.strike(world, destruction.pieces()[0], {-0.2f, 0.1f, 0.015f}, {0.0f, 0.0f, -1.0f}, 1000.0));
        run(world, destruction, 3);
        const std::vector<PieceId> first = destruction.pieces();
        REQUIRE(first.size() > 5);
        const PieceId shard = largest(destruction); // held, so it is where it was
        const SolidPtr struck = destruction.solid(shard);
        REQUIRE(struck->anchored);
        const glm::vec3 at = world.pose(destruction.body(shard)).position;
        REQUIRE(destruction.strike(world, shard, at + glm::vec3(0.0f, 0.0f, 0.015f), {0.0f, 0.0f, -1.0f}, 1000.0));
        run(world, destruction, 3);
        // Only the struck shard is cut, although the second blow's damage reaches beyond it.
        for (const PieceId piece : first) CHECK(destruction.contains(piece) == (piece != shard));
        double volume = 0.0;
        size_t parts = 0, at_cracks = 0;
        for (const PieceId piece : destruction.pieces()) {
            if (std::ranges::binary_search(first, piece)) continue;
            const SolidPiece& part = *destruction.solid(piece);
            volume += part.mass.volume;
            ++parts;
            // Does it touch a crack of the first blow, a plane of an interior triangle of the shard?
            bool touches = false;
            const std::vector<glm::dvec3> old = points_of(*struck), now = points_of(part);
            for (size_t t = struck->surface().exterior_triangles;
                 t < struck->surface().mesh.triangles.size() && !touches; ++t) {
                const fracture::Triangle& corners = struck->surface().mesh.triangles[t];
                const glm::dvec3 normal =
                    glm::cross(old[corners[1]] - old[corners[0]], old[corners[2]] - old[corners[0]]);
                if (glm::length(normal) < 1e-6) continue;
                const auto close = [&](const glm::dvec3& p) {
                    return std::abs(glm::dot(glm::normalize(normal), p - old[corners[0]])) < 1e-5;
                };
                touches = std::ranges::count_if(now, close) >= 4;
            }
            at_cracks += touches;
        }
        CHECK(parts > 4);
        CHECK(at_cracks >= 3);
        CHECK(volume == doctest::Approx(struck->mass.volume).epsilon(1e-9));
    }
}

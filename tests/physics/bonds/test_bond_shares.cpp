// Bonds of a piece that is cut: which part gets which share of them.
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "physics/bonds/bond_shares.h"
#include "physics/world/hull.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

// Boxes with the hulls of pieces, and given bonds.
struct Boxes {
    fracture::Fragments fragments;
    std::vector<std::vector<BodyPart>> hulls;
    glm::dquat turn{1.0, 0.0, 0.0, 0.0}; // of all of them about the origin

    std::vector<BodyPart> box(const glm::dvec3& from, const glm::dvec3& to) const {
        std::vector<glm::dvec3> corners;
        for (int k = 0; k < 8; ++k)
            corners.push_back(turn * glm::dvec3((k & 1 ? to : from).x, (k & 2 ? to : from).y, (k & 4 ? to : from).z));
        const glm::dvec3 centre = turn * (0.5 * (from + to));
        return {{std::make_shared<const CollisionHull>(collision_hull(corners, centre))}};
    }
    void add(const glm::dvec3& from, const glm::dvec3& to) {
        fracture::Piece piece;
        piece.mass.centre_of_mass = turn * (0.5 * (from + to));
        piece.mass.volume = (to.x - from.x) * (to.y - from.y) * (to.z - from.z);
        fragments.pieces.push_back(piece);
        hulls.push_back(box(from, to));
    }
    void bond(uint32_t a, uint32_t b, double area, const glm::dvec3& centroid, const glm::dvec3& normal) {
        fragments.bonds.push_back({a, b, area, turn * centroid, turn * normal});
    }
    [[nodiscard]] PlacedHulls hulls_of(uint32_t piece) const {
        return {hulls[piece], fragments.pieces[piece].mass.centre_of_mass};
    }
    struct Part {
        std::vector<BodyPart> hulls;
        glm::dvec3 centre;
    };
    [[nodiscard]] Part part(const glm::dvec3& from, const glm::dvec3& to) const {
        return {box(from, to), turn * (0.5 * (from + to))};
    }
    [[nodiscard]] std::vector<BondShare> share(uint32_t piece, const std::vector<Part>& parts) const {
        std::vector<PlacedHulls> placed;
        for (const Part& one : parts) placed.push_back({one.hulls, one.centre});
        return share_bonds(
            BondGraph(fragments, Material{}), piece, [&](uint32_t k) { return hulls_of(k); }, placed);
    }
};

} // namespace

TEST_CASE("the parts of a cut cube share each bond by the area that they have of it") {
    for (const double angle : {0.0, 0.7}) {
        CAPTURE(angle);
        Boxes boxes;
        boxes.turn = glm::angleAxis(angle, glm::normalize(glm::dvec3(1.0, 2.0, 3.0)));
        boxes.add({0, 0, 0}, {1, 1, 1});
        boxes.add({1, 0, 0}, {2, 1, 1});
        boxes.add({0, 1, 0}, {1, 2, 1});
        boxes.bond(0, 1, 1.0, {1, 0.5, 0.5}, {1, 0, 0});
        boxes.bond(0, 2, 1.0, {0.5, 1, 0.5}, {0, 1, 0});
        // A slice of three tenths at x = 0, and two halves of the rest.
        const std::vector<BondShare> shares =
            boxes.share(0, {boxes.part({0, 0, 0}, {0.3, 1, 1}), boxes.part({0.3, 0, 0}, {1, 0.5, 1}),
                            boxes.part({0.3, 0.5, 0}, {1, 1, 1})});
        REQUIRE(shares.size() == 4);
        const double grid = angle == 0.0 ? 1e-6 : 0.02; // the points lie on a grid along axes of its own
        const auto check = [&](const BondShare& share, uint32_t bond, uint32_t part, double size,
                               const glm::dvec3& centroid) {
            CHECK(share.bond == bond);
            CHECK(share.part == part);
            CHECK(share.share == doctest::Approx(size).epsilon(grid));
            CHECK(glm::length(share.centroid - boxes.turn * centroid) < grid);
        };
        check(shares[0], 0, 1, 0.5, {1, 0.25, 0.5}); // the slice does not touch the right neighbour
        check(shares[1], 0, 2, 0.5, {1, 0.75, 0.5});
        check(shares[2], 1, 0, 0.3, {0.15, 1, 0.5});
        check(shares[3], 1, 2, 0.7, {0.65, 1, 0.5});
    }
}

TEST_CASE("a part gets the bonds of the neighbours that it touches, not of others in the same plane") {
    Boxes boxes; // a brick under two others, in a running bond
    boxes.add({0, 0, 0}, {2, 1, 1});
    boxes.add({-1, 1, 0}, {1, 2, 1});
    boxes.add({1, 1, 0}, {3, 2, 1});
    boxes.bond(0, 1, 1.0, {0.5, 1, 0.5}, {0, 1, 0});
    boxes.bond(0, 2, 1.0, {1.5, 1, 0.5}, {0, 1, 0});
    const std::vector<BondShare> shares =
        boxes.share(0, {boxes.part({0, 0, 0}, {1, 1, 1}), boxes.part({1, 0, 0}, {2, 1, 1})});
    REQUIRE(shares.size() == 2);
    for (uint32_t k = 0; k < 2; ++k) {
        CHECK(shares[k].bond == k);
        CHECK(shares[k].part == k);
        CHECK(shares[k].share == 1.0);
        CHECK(glm::length(shares[k].centroid - boxes.fragments.bonds[k].centroid) < 1e-9);
    }
}

TEST_CASE("a thin part before the contact takes its bond from what lies behind") {
    Boxes boxes;
    boxes.add({0, 0, 0}, {1, 1, 1});
    boxes.add({1, 0, 0}, {2, 1, 1});
    boxes.bond(0, 1, 1.0, {1, 0.5, 0.5}, {1, 0, 0});
    const std::vector<BondShare> shares =
        boxes.share(0, {boxes.part({0, 0, 0}, {0.995, 1, 1}), boxes.part({0.995, 0, 0}, {1, 1, 1})});
    REQUIRE(shares.size() == 1);
    CHECK(shares[0].part == 1);
}

TEST_CASE("a bond whose area no hull shows goes whole to the nearest part, and one to a support by its disc") {
    Boxes boxes;
    boxes.add({0, 0, 0}, {1, 1, 1});
    boxes.add({1.5, 0, 0}, {2, 1, 1});                   // half a metre away
    boxes.add({0, -1, 0}, {1, 0, 1});                    // a support
    boxes.bond(0, 1, 1.0, {1.25, 0.9, 0.5}, {1, 0, 0});  // between them
    boxes.bond(0, 2, 0.09, {0.2, 0.0, 0.5}, {0, -1, 0}); // a small area at one end
    boxes.hulls[2].clear();
    const std::vector<BondShare> shares =
        boxes.share(0, {boxes.part({0, 0, 0}, {1, 0.5, 1}), boxes.part({0, 0.5, 0}, {1, 1, 1})});
    REQUIRE(shares.size() == 2);
    CHECK(shares[0].part == 1);
    CHECK(shares[0].share == 1.0);
    CHECK(glm::length(shares[0].centroid - glm::dvec3(1.25, 0.9, 0.5)) < 1e-12);
    CHECK(shares[1].part == 0);
    const std::vector<BondShare> ends =
        boxes.share(0, {boxes.part({0, 0, 0}, {0.5, 1, 1}), boxes.part({0.5, 0, 0}, {1, 1, 1})});
    REQUIRE(ends.size() == 2); // the other end stands on nothing
    CHECK(ends[1].part == 0);
}

TEST_CASE("a graph keeps areas, moments and health where a piece is divided") {
    Boxes boxes;
    boxes.add({0, 0, 0}, {1, 1, 1});
    boxes.add({1, 0, 0}, {2, 1, 1});
    boxes.add({2, 0, 0}, {3, 1, 1});
    boxes.bond(0, 1, 1.0, {1, 0.5, 0.5}, {1, 0, 0});
    boxes.bond(1, 2, 1.0, {2, 0.5, 0.5}, {1, 0, 0});
    BondGraph graph(boxes.fragments, Material{});
    graph.weaken(0, 0.25);
    const std::vector<Boxes::Part> parts{boxes.part({1, 0, 0}, {2, 0.4, 1}), boxes.part({1, 0.4, 0}, {2, 1, 1})};
    const std::vector<PlacedHulls> placed{{parts[0].hulls, parts[0].centre}, {parts[1].hulls, parts[1].centre}};
    graph.divide(1, std::vector{parts[0].centre, parts[1].centre},
                 share_bonds(
                     graph, 1, [&](uint32_t k) { return boxes.hulls_of(k); }, placed));
    CHECK(graph.piece_count() == 5);
    REQUIRE(graph.bonds().size() == 4);
    CHECK(graph.bonds_of(1).empty());
    CHECK(graph.take_broken().empty());
    std::map<std::pair<uint32_t, uint32_t>, BondGraph::Bond> by_pieces;
    for (const BondGraph::Bond& bond : graph.bonds()) by_pieces[{bond.a, bond.b}] = bond;
    for (const uint32_t part : {3u, 4u}) {
        CHECK(graph.bonds_of(part).size() == 2);
        const double area = part == 3 ? 0.4 : 0.6, height = part == 3 ? 0.2 : 0.7;
        REQUIRE(by_pieces.contains({0, part}));
        REQUIRE(by_pieces.contains({part, 2}));
        const BondGraph::Bond left = by_pieces[{0, part}], right = by_pieces[{part, 2}];
        for (const BondGraph::Bond& bond : {left, right}) {
            CHECK(bond.area == doctest::Approx(area));
            CHECK(bond.centroid.y == doctest::Approx(height));
            CHECK(bond.normal == glm::dvec3(1, 0, 0));
            const double span = 1.0 + (height - 0.5) * (height - 0.5); // squared
            CHECK(bond.lever == doctest::Approx(area / span).epsilon(1e-6));
            CHECK(bond.share == contact_strength_share(Material{}, bond.area));
        }
        CHECK(left.health == 0.75);
        CHECK(right.health == 1.0);
    }
    const std::vector<uint32_t> all{0, 2, 3, 4};
    CHECK(graph.islands(all).size() == 1);
    // One part after the other lets go.
    for (const uint32_t bond : graph.bonds_of(3)) graph.weaken(bond, 1.0);
    CHECK(graph.islands(all) == std::vector<std::vector<uint32_t>>{{0, 2, 4}, {3}});
}

#include "physics/bonds/held_blocks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/fracture.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/shapes/shapes.h"
#include "physics/cutting/solid_piece.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

const glm::dvec3 down(0.0, -9.81, 0.0);
const Material concrete{};
const fracture::Box ground{{-9.0, -1.0, -9.0}, {9.0, 0.01, 9.0}};

std::shared_ptr<const HeldBlocks> blocks_of(const fracture::TriangleMesh& mesh, const fracture::Box& anchor = ground) {
    Result<SolidPtr> solid = make_solid(mesh, {.min_size = 0.02, .anchors = {anchor}});
    REQUIRE(solid);
    return (*solid)->blocks;
}

// A foot, a stem of this radius, and a head of about a ton one metre up.
fracture::TriangleMesh mushroom(double stem) {
    return fracture::lathe({{0.3, 0.0}, {0.3, 0.1}, {stem, 0.15}, {stem, 0.9}, {0.5, 1.0}, {0.5, 1.5}}, 24);
}

bool stands(const std::vector<uint32_t>& islands) {
    return std::ranges::all_of(islands, [](uint32_t island) { return island == 0; });
}

// Returns the islands of the blocks that satisfy the predicate.
template<class Choice>
std::set<uint32_t> islands_of(const HeldBlocks& blocks, const std::vector<uint32_t>& islands, Choice choice) {
    std::set<uint32_t> found;
    for (size_t i = 0; i < islands.size(); ++i)
        if (choice(blocks.nodes[i])) found.insert(islands[i]);
    return found;
}

// Checks that the mushroom's foot and head are each whole, and separate.
void check_head_is_off(const HeldBlocks& blocks, const std::vector<uint32_t>& islands) {
    REQUIRE_FALSE(stands(islands));
    const auto foot = islands_of(blocks, islands, [](const StressNode& node) { return node.fixed; });
    const auto head = islands_of(blocks, islands, [](const StressNode& node) { return node.centre.y > 1.05; });
    CHECK(foot.size() == 1);
    CHECK(head.size() == 1);
    CHECK(foot != head);
}

} // namespace

TEST_CASE("blocks: a solid that is not held, too small to break or degenerate has none") {
    const auto solid = [](const SolidSettings& settings) {
        return (*make_solid(fracture::cube(1.0), settings))->blocks;
    };
    const fracture::Box below{{-1.0, -1.0, -1.0}, {1.0, -0.45, 1.0}};
    CHECK(solid({.min_size = 0.1, .anchors = {below}}));
    CHECK_FALSE(solid({.min_size = 0.1}));
    CHECK_FALSE(solid({.min_size = 2.0, .anchors = {below}}));
    CHECK_FALSE(solid({.min_size = 0.1, .anchors = {below}, .blocks = {.enabled = false}}));
    CHECK(block_sites({}, 10).empty());
    fracture::TriangleMesh flat{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}};
    CHECK(block_sites(flat, 10).size() <= 10);
}

TEST_CASE("blocks: those of a solid without a chip are those of the remains, divided by the same sites") {
    const fracture::TriangleMesh mesh = mushroom(0.15);
    const std::shared_ptr<const HeldBlocks> blocks = blocks_of(mesh);
    REQUIRE(blocks);
    for (const glm::dvec3& place :
         {glm::dvec3(0.5, 1.25, 0.0), glm::dvec3(0.0, 1.5, 0.4), glm::dvec3(0.15, 0.5, 0.0)}) {
        // What is near the place leaves, in two pieces; the rest is one.
        const double reach = 0.08;
        std::vector<glm::dvec3> sites{place, place + glm::dvec3(0.0, 0.5 * reach, 0.0)};
        for (int axis = 0; axis < 3; ++axis)
            for (const double side : {-1.0, 1.0}) {
                sites.push_back(place);
                sites.back()[axis] += side * 2.0 * reach;
            }
        const auto cut = fracture::fracture(mesh, sites, {.groups = {0, 1, 2, 2, 2, 2, 2, 2}});
        REQUIRE(cut);
        fracture::TriangleMesh lost, rest;
        for (const fracture::Piece& piece : cut->pieces) {
            fracture::TriangleMesh& to = piece.site < 2 ? lost : rest;
            const auto base = static_cast<uint32_t>(to.positions.size());
            const auto positions = cut->positions_of(piece);
            to.positions.insert(to.positions.end(), positions.begin(), positions.end());
            for (const fracture::Triangle& t : cut->triangles_of(piece)) to.triangles.push_back(t + base);
        }
        const auto left = blocks_without(*blocks, lost, concrete.density);
        REQUIRE(left);
        const auto expected = fracture::fracture(rest, blocks->sites);
        REQUIRE(expected);
        REQUIRE(expected->pieces.size() == left->nodes.size()); // in the same order
        for (size_t k = 0; k < left->nodes.size(); ++k) {
            const fracture::Piece& piece = expected->pieces[k];
            const double density = concrete.density;
            REQUIRE(piece.site == left->cells[k]);
            CHECK(left->nodes[k].mass == doctest::Approx(density * piece.mass.volume).epsilon(1e-9));
            CHECK(glm::distance(left->nodes[k].centre, piece.mass.centre_of_mass) < 1e-9);
            for (int axis = 0; axis < 3; ++axis)
                for (int other = 0; other < 3; ++other)
                    CHECK(std::abs(left->nodes[k].inertia[axis][other] - density * piece.mass.inertia[axis][other])
                          < 1e-9 * density);
        }
        REQUIRE(expected->bonds.size() == left->bonds.size());
        for (const StressBond& bond : left->bonds) {
            const auto same = std::ranges::find_if(expected->bonds, [&](const fracture::Bond& other) {
                return std::minmax(other.a, other.b) == std::minmax(bond.a, bond.b);
            });
            REQUIRE(same != expected->bonds.end());
            CHECK(bond.area == doctest::Approx(same->area).epsilon(1e-9));
            CHECK(glm::distance(bond.centroid, same->centroid) < 1e-9);
            CHECK(left->min_area <= bond.area);
        }
    }
}

TEST_CASE("blocks: a solid that loses most of a block, or what no block holds, is divided anew") {
    const fracture::TriangleMesh mesh = mushroom(0.1);
    const std::shared_ptr<const HeldBlocks> blocks = blocks_of(mesh);
    REQUIRE(blocks);
    CHECK_FALSE(blocks_without(*blocks, mesh, concrete.density));
    const auto moved = [](fracture::TriangleMesh other, const glm::dvec3& size, const glm::dvec3& to) {
        for (glm::dvec3& p : other.positions) p = size * p + to;
        return other;
    };
    // Most of the stem's section, a little of its length.
    CHECK_FALSE(
        blocks_without(*blocks, moved(fracture::cube(1.0), {0.14, 0.2, 0.14}, {0.0, 0.5, 0.0}), concrete.density));
    const auto left =
        blocks_without(*blocks, moved(fracture::cube(1.0), glm::dvec3(0.01), {0.0, 1.2, 0.0}), concrete.density);
    REQUIRE(left);
    CHECK(left->first_masses == blocks->first_masses);
    CHECK(left->first_areas == blocks->first_areas);
}

TEST_CASE("blocks: sites lie inside and denser where the solid is thin, and masses sum to the total") {
    const fracture::TriangleMesh mesh = mushroom(0.1);
    const std::vector<glm::dvec3> sites = block_sites(mesh, 96);
    CHECK(sites.size() <= 96);
    CHECK(block_sites(mesh, 7).size() == 7);
    int in_stem = 0;
    for (const glm::dvec3& site : sites) {
        CHECK(site.y > 0.0);
        CHECK(site.y < 1.5);
        if (site.y > 0.2 && site.y < 0.85) {
            CHECK(std::hypot(site.x, site.z) < 0.1);
            ++in_stem;
        }
    }
    CHECK(in_stem >= 5); // length 0.65 m, thickness 0.2 m: a site about every half thickness
    const auto blocks = blocks_of(mesh);
    REQUIRE(blocks);
    double mass = 0.0;
    for (const StressNode& node : blocks->nodes) mass += node.mass;
    const double volume = fracture::signed_volume(mesh.positions, mesh.triangles);
    CHECK(mass == doctest::Approx(volume * static_cast<double>(concrete.density)).epsilon(1e-6));
    CHECK(std::ranges::any_of(blocks->nodes, &StressNode::fixed));
}

// The pressure at the foot of a column of radius r is m g / (pi r^2).
TEST_CASE("blocks: a stem bears the load of its cross section, and breaks in the stem") {
    const auto section_ratio = [](double stem) { // from compression alone, at the stem's lower end
        const fracture::TriangleMesh mesh = mushroom(stem);
        const double above =
            fracture::signed_volume(mesh.positions, mesh.triangles) - std::numbers::pi * 0.3 * 0.3 * 0.1;
        const double pressure = above * 2400.0 * 9.81 / (std::numbers::pi * stem * stem);
        return pressure / static_cast<double>(concrete.compressive);
    };
    for (const double stem : {0.05, 0.1}) {
        CAPTURE(stem);
        const auto blocks = blocks_of(mushroom(stem));
        REQUIRE(blocks);
        const auto scale = static_cast<float>(section_ratio(stem));
        // Contacts of Voronoi blocks are slightly tilted, and the head's centre is not exactly above them.
        CHECK(stands(islands_under_load(*blocks, concrete, 8.0f * scale, down, {})));
        check_head_is_off(*blocks, islands_under_load(*blocks, concrete, 0.6f * scale, down, {}));
    }
}

// Bending stress at the wall for length l, height h and width b: 6 (rho b h l g) (l / 2) / (b h^2) = 3 rho g l^2 / h.
TEST_CASE("blocks: a cantilever breaks at the Euler-Bernoulli load, up to the error of discs for square sections") {
    const double length = 2.0, height = 0.2;
    const double stress = 3.0 * 2400.0 * 9.81 * length * length / height;
    const auto critical = stress / static_cast<double>(concrete.tensile); // strength scale at the limit
    const auto blocks = blocks_of(fracture::cuboid({length, height, 0.2}), {{-1.1, -1.0, -1.0}, {-0.99, 1.0, 1.0}});
    REQUIRE(blocks);
    double low = 0.01 * critical, high = 100.0 * critical; // breaks, stands
    REQUIRE(!stands(islands_under_load(*blocks, concrete, static_cast<float>(low), down, {})));
    REQUIRE(stands(islands_under_load(*blocks, concrete, static_cast<float>(high), down, {})));
    for (int k = 0; k < 30; ++k) {
        const double middle = std::sqrt(low * high);
        (stands(islands_under_load(*blocks, concrete, static_cast<float>(middle), down, {})) ? high : low) = middle;
    }
    MESSAGE("the beam stands at ", high / critical, " of the strength by the formula");
    // Expected from the disc's I = A^2 / (4 pi) and a first contact at a distance from the wall.
    CHECK(high > 0.4 * critical);
    CHECK(high < 2.0 * critical);
    // A load at its end adds to the weight, and without gravity nothing breaks.
    const PointLoad hanging{{0.95, 0.0, 0.0}, {0.0, -2400.0 * 0.08 * 9.81, 0.0}};
    CHECK_FALSE(stands(islands_under_load(*blocks, concrete, static_cast<float>(1.2 * high), down, {&hanging, 1})));
    CHECK(stands(islands_under_load(*blocks, concrete, static_cast<float>(low), glm::dvec3(0.0), {})));
}

TEST_CASE("blocks: a blow breaks the stem if and only if its energy pays for the cross section") {
    const double stem = 0.1;
    const fracture::TriangleMesh mesh = mushroom(stem);
    const auto blocks = blocks_of(mesh);
    REQUIRE(blocks);
    // The impulse J at which J^2 / (2 m) equals G A, with the stem's area A and the mushroom's mass m.
    const double head = fracture::signed_volume(mesh.positions, mesh.triangles) * 2400.0;
    const double energy = std::numbers::pi * stem * stem * static_cast<double>(concrete.fracture_energy);
    const double impulse = std::sqrt(2.0 * head * energy);
    const auto after = [&](double share, double own_energy) {
        return islands_after_blow(*blocks, concrete, 1.0f, down, {{0.5, 1.25, 0.0}, {-share * impulse, 0.0, 0.0}},
                                  own_energy);
    };
    CHECK(stands(after(0.4, 1e6)));
    CHECK(stands(after(2.5, 0.5 * energy))); // limited by the blow's own energy
    check_head_is_off(*blocks, after(2.5, 1e6));
    // The foot is fixed: a blow to it breaks nothing.
    CHECK(stands(
        islands_after_blow(*blocks, concrete, 1.0f, down, {{0.3, 0.005, 0.0}, {-1e-3 * impulse, 0.0, 0.0}}, 1e6)));
}

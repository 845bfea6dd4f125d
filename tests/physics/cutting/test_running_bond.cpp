#include "physics/cutting/running_bond.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/fracture.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/mesh/nearest.h"
#include "fracture/shapes/shapes.h"
#include "physics/cutting/destruction.h"
#include "physics/cutting/impact_pattern.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
const fracture::Box wall_box{{-1.0, 0.0, -0.12}, {1.0, 1.2, 0.12}};
const RunningBond laid{{0.25, 0.075, 0.12}, wall_box.min}; // 8 bricks long, 16 courses, 2 layers

bool anywhere(const glm::dvec3&) {
    return true;
}

fracture::TriangleMesh box_mesh(const fracture::Box& box) {
    fracture::TriangleMesh mesh = fracture::cuboid(box.size());
    for (glm::dvec3& p : mesh.positions) p += box.centre();
    return mesh;
}

// The pieces that a blow makes of a solid.
fracture::Fragments broken(const fracture::TriangleMesh& mesh, const glm::dvec3& point, const glm::dvec3& normal,
                           const Damage& damage, ImpactSites& cut) {
    const ImpactPattern pattern{.kind = fracture::PatternKind::bricks, .bond = laid};
    cut = impact_sites(mesh, fracture::mass_properties(mesh.positions, mesh.triangles), {point, normal, 1.0}, damage,
                       pattern);
    const ImpactSites again = impact_sites(mesh, fracture::mass_properties(mesh.positions, mesh.triangles),
                                           {point, normal, 1.0}, damage, pattern);
    CHECK(again.sites == cut.sites);
    CHECK(again.groups == cut.groups);
    fracture::Settings settings;
    settings.groups = cut.groups;
    auto fragments = fracture::fracture(mesh, cut.sites, settings);
    REQUIRE(fragments);
    return *fragments;
}

// True if the box of a piece is a brick of the bond, or half a brick at an end of the wall.
bool is_brick(const fracture::Box& box) {
    const glm::dvec3 low = (box.min - laid.corner) / laid.brick, high = (box.max - laid.corner) / laid.brick;
    const double course = std::round(low.y), layer = std::round(low.z);
    const double shift = 0.5 * std::fmod(course + layer, 2.0), length = high.x - low.x;
    const auto whole = [](double value) { return std::abs(value - std::round(value)) < 1e-9; };
    const bool across =
        whole(low.y) && whole(low.z) && std::abs(high.y - low.y - 1.0) < 1e-9 && std::abs(high.z - low.z - 1.0) < 1e-9;
    const bool at_end =
        shift > 0.0 && std::abs(length - 0.5) < 1e-9 && (std::abs(low.x) < 1e-9 || std::abs(high.x - 8.0) < 1e-9);
    return across && (at_end || (std::abs(length - 1.0) < 1e-9 && whole(low.x + shift)));
}

} // namespace

TEST_CASE("running bond: no bricks without a size or a wall") {
    for (const double bad : {0.0, -1.0, not_a_number, infinity, 1e-300})
        for (int k = 0; k < 3; ++k) {
            RunningBond bond = laid;
            bond.brick[k] = bad;
            CHECK(bricks_near(bond, wall_box, {0.0, 0.6, 0.12}, 0.3, 40, anywhere).bricks.empty());
        }
    RunningBond lost = laid;
    lost.corner.x = not_a_number;
    CHECK(bricks_near(lost, wall_box, {0.0, 0.6, 0.12}, 0.3, 40, anywhere).bricks.empty());
    for (const double bad : {not_a_number, infinity}) {
        const RunningBond tiny{{0.001, 0.001, 0.001}, wall_box.min};
        CHECK(bricks_near(tiny, wall_box, {0.0, 0.6, 0.12}, bad, 40, anywhere).bricks.empty());
        CHECK(bricks_near(tiny, wall_box, {0.0, bad, 0.12}, 0.3, 40, anywhere).bricks.empty());
    }
    const fracture::Box one{{-1.0, 0.0, -0.12}, {-0.75, 0.075, 0.0}};
    CHECK(bricks_near(laid, one, one.centre(), 0.3, 40, anywhere).bricks.empty());
    fracture::Box nearly = one; // as the box of a cut piece, with rounding
    nearly.min -= 1e-9;
    nearly.max += 1e-9;
    CHECK(bricks_near(laid, nearly, one.centre(), 0.3, 40, anywhere).bricks.empty());
    CHECK(bricks_near(laid, wall_box, {0.0, 0.6, 0.12}, 0.3, 0, anywhere).bricks.empty());
    CHECK(bricks_near(laid, wall_box, {0.0, 0.6, 0.12}, 1e-3, 40, anywhere).bricks.empty());
    CHECK(bricks_near(laid, wall_box, {50.0, 0.6, 0.12}, 0.3, 40, anywhere).bricks.empty());
}

TEST_CASE("running bond: the nearest bricks are those that a search of all bricks finds, also in a large wall") {
    for (const auto& [case_size, radius, case_most] :
         {std::tuple(1.0, 0.3, 40u), {1.0, 0.3, 5u}, {1.0, 10.0, 1000u}, {0.25, 0.5, 40u}, {0.01, 5.0, 100u}}) {
        const auto size = case_size;
        const auto most = case_most; // clang 14 captures no structured binding
        CAPTURE(size);
        CAPTURE(most);
        const RunningBond bond{size * laid.brick, laid.corner};
        const glm::dvec3 point(0.11, 0.63, 0.12), half = bond.brick * glm::dvec3(0.5, 1.0, 1.0);
        const BricksTaken taken = bricks_near(bond, wall_box, point, radius, most, anywhere);
        const auto distance_of = [&](const std::array<glm::dvec3, 2>& brick) {
            return std::min(glm::distance(brick[0], point), glm::distance(brick[1], point));
        };
        for (size_t i = 1; i < taken.bricks.size(); ++i)
            CHECK(distance_of(taken.bricks[i - 1]) <= distance_of(taken.bricks[i]));
        for (const auto& brick : taken.bricks) {
            CHECK(distance_of(brick) <= radius);
            CHECK(glm::length(brick[1] - brick[0] - glm::dvec3(half.x, 0.0, 0.0)) < 1e-9 * half.x);
        }
        // No other brick is nearer than the last one found: a search over the middles of all halves of the wall.
        if (size < 0.1) {
            CHECK(taken.bricks.size() == most);
            continue;
        }
        std::map<std::tuple<int, int, int>, double> within; // distance by brick
        for (int z = 0; z < std::lround(2.0 / size); ++z)
            for (int y = 0; y < std::lround(16.0 / size); ++y)
                for (int x = 0; x < std::lround(16.0 / size); ++x)
                    if (const double distance = glm::distance(bond.corner + (glm::dvec3(x, y, z) + 0.5) * half, point);
                        distance <= radius) {
                        const auto at = within.try_emplace({(x + (y + z) % 2) / 2, y, z}, distance).first;
                        at->second = std::min(at->second, distance);
                    }
        std::vector<double> nearest;
        for (const auto& [brick, distance] : within) nearest.push_back(distance);
        std::ranges::sort(nearest);
        REQUIRE(taken.bricks.size() == std::min<size_t>(nearest.size(), most));
        for (size_t i = 0; i < taken.bricks.size(); ++i)
            CHECK(distance_of(taken.bricks[i]) == doctest::Approx(nearest[i]));
        std::set<std::pair<double, double>> middles; // of distinct bricks
        for (const auto& brick : taken.bricks) middles.insert({brick[0].x + 1e3 * brick[0].y, brick[0].z});
        CHECK(middles.size() == taken.bricks.size());
    }
}

TEST_CASE("running bond: each blow to a wall takes out whole bricks, the struck one among them") {
    const fracture::TriangleMesh wall = box_mesh(wall_box);
    const Damage damage{.radius = 0.2, .pieces = 40};
    const glm::dvec3 into(0.0, 0.0, -1.0);
    fracture::TriangleMesh solid = wall;
    for (const glm::dvec3& point :
         {glm::dvec3(0.03, 0.61, 0.12), glm::dvec3(0.52, 0.61, 0.12), glm::dvec3(-0.97, 0.02, 0.12)}) {
        ImpactSites cut;
        const fracture::Fragments pieces = broken(solid, point, into, damage, cut);
        CHECK(cut.rest >= 4);
        REQUIRE(pieces.pieces.size() > 4);
        size_t largest = 0;
        double volume = 0.0;
        bool hit = false;
        for (size_t i = 0; i < pieces.pieces.size(); ++i) {
            volume += pieces.pieces[i].mass.volume;
            if (pieces.pieces[i].mass.volume > pieces.pieces[largest].mass.volume) largest = i;
        }
        CHECK(volume
              == doctest::Approx(fracture::mass_properties(solid.positions, solid.triangles).volume).epsilon(1e-12));
        for (size_t i = 0; i < pieces.pieces.size(); ++i) {
            if (i == largest) continue;
            const auto positions = pieces.positions_of(pieces.pieces[i]);
            const fracture::Box box = fracture::bounds(positions);
            CHECK(is_brick(box));
            CHECK(pieces.pieces[i].mass.volume
                  == doctest::Approx(box.size().x * box.size().y * box.size().z).epsilon(1e-9));
            hit = hit
                  || (glm::all(glm::lessThanEqual(box.min, point + 1e-9))
                      && glm::all(glm::greaterThanEqual(box.max, point - 1e-9)));
        }
        CHECK(hit);
        const auto positions = pieces.positions_of(pieces.pieces[largest]);
        const auto triangles = pieces.triangles_of(pieces.pieces[largest]);
        solid = {{positions.begin(), positions.end()}, {triangles.begin(), triangles.end()}};
    }
}

TEST_CASE("running bond: a blow beside a hole takes bricks that are still there") {
    const auto right = [](const glm::dvec3& middle) { return middle.x > 0.0; };
    const BricksTaken taken = bricks_near(laid, wall_box, {-0.01, 0.6, 0.12}, 0.2, 5, right);
    REQUIRE(taken.bricks.size() == 5);
    for (const auto& brick : taken.bricks) CHECK(brick[1].x > 0.0);
    CHECK(bricks_near(laid, wall_box, {-0.5, 0.6, 0.12}, 0.2, 5, right).bricks.empty());
    // A wall with a hole of some bricks, and a blow on its rim with a reach of half a brick.
    ImpactSites cut;
    const fracture::Fragments first =
        broken(box_mesh(wall_box), {0.03, 0.61, 0.12}, {0.0, 0.0, -1.0}, {.radius = 0.2, .pieces = 40}, cut);
    const auto rest =
        std::ranges::max_element(first.pieces, {}, [](const fracture::Piece& piece) { return piece.mass.volume; });
    const auto positions = first.positions_of(*rest);
    const auto triangles = first.triangles_of(*rest);
    const fracture::TriangleMesh holed{{positions.begin(), positions.end()}, {triangles.begin(), triangles.end()}};
    for (const double angle : {0.3, 1.4, 2.5, 3.6, 4.7, 5.8}) {
        CAPTURE(angle);
        const glm::dvec3 towards(0.03 + 0.3 * std::cos(angle), 0.61 + 0.3 * std::sin(angle), 0.06);
        const glm::dvec3 rim = fracture::nearest_on(holed, glm::mix(glm::dvec3(0.03, 0.61, 0.06), towards, 0.3));
        CHECK(broken(holed, rim, {0.0, 0.0, -1.0}, {.radius = 0.09, .pieces = 1}, cut).pieces.size() > 1);
    }
}

TEST_CASE("running bond: bricks stay whole near corners of the solid") {
    // Two bricks end to end, struck at their joint.
    ImpactSites cut;
    const fracture::Fragments two = broken(box_mesh({{-1.0, 0.0, -0.12}, {-0.5, 0.075, 0.0}}), {-0.75, 0.075, -0.06},
                                           {0.0, -1.0, 0.0}, {.radius = 0.08, .pieces = 4}, cut);
    CHECK(two.pieces.size() == 2);
    for (const fracture::Piece& piece : two.pieces)
        CHECK(piece.mass.volume == doctest::Approx(laid.brick.x * laid.brick.y * laid.brick.z).epsilon(1e-12));
}

TEST_CASE("running bond: a single brick crumbles, and a weak blow chips a wall") {
    ImpactSites cut;
    const fracture::Box one{{-1.0, 0.0, -0.12}, {-0.75, 0.075, 0.0}};
    CHECK(broken(box_mesh(one), {-0.8, 0.05, 0.0}, {0.0, 0.0, -1.0}, {.radius = 0.08, .pieces = 8}, cut).pieces.size()
          > 4);
    const fracture::Fragments chips =
        broken(box_mesh(wall_box), {0.03, 0.61, 0.12}, {0.0, 0.0, -1.0}, {.radius = 0.02, .pieces = 4}, cut);
    CHECK(chips.pieces.size() > 2);
    std::vector<double> volumes;
    for (const fracture::Piece& piece : chips.pieces) volumes.push_back(piece.mass.volume);
    std::ranges::sort(volumes);
    CHECK(volumes[volumes.size() - 2] < 0.05 * laid.brick.x * laid.brick.y * laid.brick.z);
}

TEST_CASE("running bond: a brick with remains of others crumbles, and so do bricks below the minimum size") {
    BreakableDesc desc;
    desc.pattern = {.kind = fracture::PatternKind::bricks, .bond = laid};
    desc.solid.min_size = 0.04;
    fracture::Box crumbs{wall_box.min, wall_box.min + glm::dvec3(1.02, 1.0, 1.0) * laid.brick};
    for (const fracture::Box& box : {crumbs, wall_box}) {
        const fracture::TriangleMesh mesh = box_mesh(box);
        const auto solid = make_solid(mesh, desc.solid);
        REQUIRE(solid);
        const Blow blow{{box.min.x + 0.1, box.min.y + 0.03, box.max.z}, {0.0, 0.0, -1.0}, 1e6}; // pays for the damage
        const auto pieces = carry_out({.solid = *solid,
                                       .desc = std::make_shared<const BreakableDesc>(desc),
                                       .blow = blow,
                                       .damage = {.radius = 0.15, .pieces = 8}});
        REQUIRE(pieces);
        CHECK(pieces->size() > 3);
        desc.pattern.bond.brick *= 0.1;
    }
}

TEST_CASE("running bond: bricks come from the wall that was hit, not from another wall of its mesh") {
    fracture::TriangleMesh room = box_mesh(wall_box), back = box_mesh(wall_box);
    const auto first = static_cast<uint32_t>(room.positions.size());
    for (glm::dvec3& p : back.positions) room.positions.push_back(p - glm::dvec3(0.0, 0.0, 3.0));
    for (const fracture::Triangle& t : back.triangles) room.triangles.push_back(t + first);
    ImpactSites cut;
    const fracture::Fragments pieces =
        broken(room, {0.03, 0.61, 0.12}, {0.0, 0.0, -1.0}, {.radius = 0.2, .pieces = 40}, cut);
    CHECK(pieces.pieces.size() > 6);
    for (const fracture::Piece& piece : pieces.pieces) {
        const auto positions = pieces.positions_of(piece);
        const fracture::Box box = fracture::bounds(positions);
        if (piece.mass.volume > 0.1) continue;
        CHECK(is_brick(box));
        CHECK(box.min.z > -1.0);
    }
}

TEST_CASE("running bond: bricks along another axis are equal ones, turned, and an invalid axis has none") {
    const glm::dvec3 point(0.11, 0.63, 0.12);
    const BricksTaken straight = bricks_near(laid, wall_box, point, 0.3, 40, anywhere);
    for (const int axis : {1, 2}) {
        const auto turned = [&](glm::dvec3 p) {
            std::swap(p.x, p[axis]);
            return p;
        };
        const RunningBond bond{turned(laid.brick), turned(laid.corner), static_cast<uint32_t>(axis)};
        const fracture::Box box{turned(wall_box.min), turned(wall_box.max)};
        const BricksTaken taken = bricks_near(bond, box, turned(point), 0.3, 40, anywhere);
        CHECK(taken.diagonal == doctest::Approx(straight.diagonal));
        const auto by_place = [](const auto& brick) { return std::tuple(brick[0].x, brick[0].y, brick[0].z); };
        std::set<std::tuple<double, double, double>> these, those;
        for (const auto& brick : taken.bricks) these.insert(by_place(std::array{turned(brick[0]), turned(brick[1])}));
        for (const auto& brick : straight.bricks) those.insert(by_place(brick));
        CHECK(these == those);
        CHECK(taken.beside.size() == straight.beside.size());
        CHECK(fitted(bond, box).along == bond.along);
    }
    RunningBond none = laid;
    none.along = 3;
    CHECK(bricks_near(none, wall_box, point, 0.3, 40, anywhere).bricks.empty());
}

TEST_CASE("running bond: fitted bricks fill the box") {
    const fracture::Box box{{3.0, -1.0, 0.5}, {4.1, 0.3, 0.51}};
    const RunningBond bond = fitted({}, box);
    CHECK(bond.corner == box.min);
    for (int k = 0; k < 3; ++k) {
        const double count = box.size()[k] / bond.brick[k];
        CHECK(count == doctest::Approx(std::round(count)));
        CHECK(count >= 1.0 - 1e-12);
    }
    CHECK(bond.brick.x == doctest::Approx(1.1 / 4));
    CHECK(bond.brick.z == doctest::Approx(0.01));
}

// Which blows break a free wall of each material, by simulation: an independent check of the orders and limits that
// material.h and impact_pattern.h promise.
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "tests/physics/bodies.h"
#include "tests/physics/destruction_fixture.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_destruction;
using test_bodies::empty_space;

namespace {

// m^2, from the triangles of the meshes; the two sides of a crack are one.
double crack_area(const SolidPiece& whole, const std::vector<SolidPtr>& pieces) {
    const auto area_of = [](const SolidPiece& solid) {
        double area = 0.0;
        for (const fracture::Triangle& t : solid.surface().mesh.triangles) {
            const glm::dvec3 a(solid.surface().positions[t[0]]), b(solid.surface().positions[t[1]]),
                c(solid.surface().positions[t[2]]);
            area += 0.5 * glm::length(glm::cross(b - a, c - a));
        }
        return area;
    };
    double area = -area_of(whole);
    for (const SolidPtr& piece : pieces) area += area_of(*piece);
    return 0.5 * area;
}

struct Outcome {
    size_t pieces = 0;
    double came_off = 0.0; // share of the volume outside the largest piece
    double surface = 0.0;  // m^2, new surface; the two sides of a crack are one
    Destruction::Statistics statistics;
};

// A steel ball of 111 kg hits the middle of a free wall of 2 x 1.2 x 0.2 m.
Outcome shot_wall(const MaterialPreset& preset, float speed) {
    World world(empty_space);
    Destruction destruction;
    BreakableDesc desc = desc_of(0.05, preset.material);
    desc.pattern.kind = preset.pattern.kind;
    desc.pattern.bond = fitted({}, {{-1.0, -0.6, -0.1}, {1.0, 0.6, 0.1}});
    must_add(destruction, world, fracture::cuboid({2.0, 1.2, 0.2}), desc);
    const double volume = volume_of(destruction), area = destruction.solid(destruction.pieces()[0])->mass.area;
    shoot(world, 0.15f, 111.0f, {0.0f, 0.0f, 0.3f}, {0.0f, 0.0f, -speed});
    run(world, destruction, static_cast<int>(6.0f / speed) + 8);
    Outcome outcome{.pieces = destruction.pieces().size(), .statistics = destruction.statistics()};
    outcome.came_off = 1.0 - destruction.solid(largest(destruction))->mass.volume / volume;
    for (const PieceId piece : destruction.pieces()) outcome.surface += 0.5 * destruction.solid(piece)->mass.area;
    outcome.surface -= 0.5 * area;
    return outcome;
}

MaterialPreset preset_of(const std::string& name) {
    if (name != "steel") return *material_preset(name);
    return {"steel",
            {7850.0f, 0.5f, 0.3f, 400e6f, 400e6f, 250e6f, 50e6f, 1e5f},
            {.kind = fracture::PatternKind::uniform},
            {},
            glm::vec3(0.5f),
            glm::vec3(0.5f)};
}

// The lowest speed, to 3 %, from which a tenth of the wall comes off; `most` if none below does it.
float breaking_speed(const std::string& name, float most) {
    const MaterialPreset preset = preset_of(name);
    float low = 0.6f, high = most;
    while (high > 1.03f * low) {
        const float middle = std::sqrt(low * high);
        (shot_wall(preset, middle).came_off > 0.1 ? high : low) = middle;
    }
    return high;
}

} // namespace

TEST_CASE("impact thresholds: fifty kilojoules break a wall of any brittle material at handbook strength") {
    for (const MaterialPreset& preset : material_presets()) {
        const Outcome outcome = shot_wall(preset, 30.0f);
        CAPTURE(preset.name);
        MESSAGE(preset.name, ": ", outcome.pieces, " pieces, ", outcome.came_off, " came off, ", outcome.surface,
                " m^2");
        CHECK(outcome.pieces > 8);
        CHECK(outcome.statistics.failed == 0);
        if (preset.name == "glass" || preset.name == "ceramic") CHECK(outcome.came_off > 0.8);
        CHECK(outcome.surface * static_cast<double>(preset.material.fracture_energy) < 0.5 * 111.0 * 900.0);
    }
}

TEST_CASE("impact thresholds: glass breaks first, then ceramic, then concrete and stone, wood and steel last") {
    std::map<std::string, float> speed;
    for (const char* name : {"glass", "ceramic", "concrete", "stone", "wood", "steel"}) {
        speed[name] = breaking_speed(name, 60.0f);
        MESSAGE(std::string(name), " breaks from ", speed[name], " m/s");
    }
    CHECK(speed["glass"] < speed["ceramic"]);
    for (const char* harder : {"concrete", "stone"}) {
        CHECK(speed["ceramic"] < speed[harder]);
        CHECK(speed[harder] < speed["wood"]);
    }
    CHECK(speed["wood"] < speed["steel"]);
}

TEST_CASE("impact thresholds: cracks take no more energy than the blow has" * doctest::test_suite("long")) {
    double most = 0.0;
    int cuts = 0;
    for (const MaterialPreset& preset : material_presets())
        for (const glm::dvec3& size : {glm::dvec3(0.6), {2.0, 1.2, 0.2}, {1.4, 1.0, 0.03}, {0.2, 0.2, 2.0}}) {
            World world(empty_space);
            Destruction destruction;
            BreakableDesc desc = desc_of(0.02, preset.material);
            desc.pattern.kind = preset.pattern.kind;
            desc.pattern.bond = fitted({}, {-0.5 * size, 0.5 * size});
            must_add(destruction, world, fracture::cuboid(size), desc);
            const PieceId whole = destruction.pieces()[0];
            for (const glm::dvec3& at : {glm::dvec3(0.0, 0.0, 0.5), {0.45, 0.4, 0.5}, {-0.2, 0.5, 0.1}})
                for (double energy = 3.0; energy < 1e5; energy *= 9.0)
                    for (const double force : {0.5 * destruction.solid(whole)->bearable, 1e12}) {
                        const glm::vec3 normal =
                            at.z < 0.5 ? glm::vec3(0.0f, -1.0f, 0.0f) : glm::vec3(0.0f, 0.0f, -1.0f);
                        const auto cut = destruction.foresee(world, whole, glm::vec3(at * size), normal, energy, force);
                        if (!cut) continue;
                        const auto pieces = carry_out(*cut);
                        REQUIRE(pieces);
                        const double spent = crack_area(*cut->solid, *pieces)
                                             * static_cast<double>(preset.material.fracture_energy) / energy;
                        CAPTURE(preset.name);
                        CAPTURE(size.x);
                        CAPTURE(size.z);
                        CAPTURE(energy);
                        CAPTURE(force);
                        CHECK(spent <= 1.0 + 1e-5); // positions are single precision
                        most = std::max(most, spent);
                        ++cuts;
                    }
        }
    MESSAGE(cuts, " cuts, cracks took at most ", most, " of the energy");
    CHECK(cuts > 100);
    CHECK(most > 0.5);
}

TEST_CASE("impact thresholds: a blow that the wall bears leaves a chip, deeper with more energy") {
    const MaterialPreset& stone = *material_preset("stone");
    double before = 0.0;
    int chips = 0;
    for (const float speed : {0.6f, 1.0f, 1.6f, 2.4f, 3.4f, 4.0f}) {
        const Outcome outcome = shot_wall(stone, speed);
        CAPTURE(speed);
        MESSAGE(speed, " m/s: ", outcome.pieces, " pieces, ", outcome.came_off, " came off");
        CHECK(outcome.statistics.breaks == outcome.statistics.chips);
        CHECK(outcome.came_off >= before);
        CHECK(outcome.came_off < 0.05);
        chips += outcome.statistics.chips > 0;
        before = outcome.came_off;
    }
    CHECK(chips >= 3);
    CHECK(shot_wall(stone, 12.0f).statistics.chips == 0);
}

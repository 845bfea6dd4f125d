// The scenes of assets/scenes and helpers for their tests. A scene is a type, so that each scene is a test case of its
// own: the cases run in parallel, stay within ctest's time limit under sanitizers, and name the scene that failed.
//
//     using Shot = std::tuple<scene::brick_wall_rammed, scene::tower_collapses>;
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <tuple>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/mesh/mass_properties.h"
#include "fracture/mesh/topology.h"
#include "physics/cutting/destruction.h"
#include "tools/brittle/stage/stage.h"
#include "tools/scenario/recipe/input.h"
#include "tools/scenario/recipe/recipe.h"

// Prints the recipe of a run without actions if a check fails later in the block. `brittle render RECIPE` repeats the
// run.
#define BRITTLE_RUN_OF(options) INFO("the run of this recipe: ", brittle::tools::recipe_json(options))

namespace scene {

// Sorted by the names of their files. test_scenes.cpp reports missing ones.
using All = std::tuple<
    struct arch_loses_a_column, struct brick_wall_rammed, struct bunny_dropped, struct card_house_shot_by_a_marble,
    struct crushed_stone_falls, struct dominoes_fall, struct door_is_pushed_open, struct drawbridge_loses_its_chain,
    struct figure_03_voronoi_diagram, struct figure_04_bunny_with_three_sites, struct figure_09_clip_step_0,
    struct figure_09_clip_step_1, struct figure_09_clip_step_2, struct figure_09_clip_step_3, struct figure_10_hulls,
    struct figure_11_icosphere_falls_apart, struct figure_12_legs_below_the_knees, struct glass_pane_shot_by_a_ball,
    struct hanging_lamp_is_shot, struct heap_of_20000, struct pane_hangs_by_its_corners, struct pyramid_of_1275,
    struct rough_wall_is_shot, struct stack_of_50, struct statue_broken_three_levels_deep, struct stone_arch_falls,
    struct stone_arch_stands, struct tower_collapses, struct wrecking_ball_hits_a_wall>;

} // namespace scene

namespace brittle::tools::test {

// The name that the test case has, without the namespace.
template<typename Scene>
[[nodiscard]] std::string name_of() {
    const std::string name = doctest::toString<Scene>().c_str();
    return name.substr(name.rfind(':') + 1);
}

template<typename Scenes>
[[nodiscard]] std::vector<std::string> names_of() {
    return []<typename... Scene>(std::tuple<Scene...>*) {
        return std::vector<std::string>{name_of<Scene>()...};
    }(static_cast<Scenes*>(nullptr));
}

[[nodiscard]] inline std::filesystem::path scene_file(const std::string& name) {
    return std::filesystem::path(BRITTLE_ASSETS "/scenes") / (name + ".json");
}

[[nodiscard]] inline FractureOptions recipe_of(const std::string& name) {
    FractureOptions options;
    read_recipe(scene_file(name), options);
    return options;
}

template<typename Scene>
[[nodiscard]] FractureOptions recipe_of() {
    return recipe_of(name_of<Scene>());
}

// Returns the files of scenes for which `wanted` holds, sorted.
template<typename Predicate>
[[nodiscard]] std::vector<std::string> scenes_where(Predicate wanted) {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(BRITTLE_ASSETS "/scenes"))
        if (wanted(recipe_of(entry.path().stem().string()))) names.push_back(entry.path().stem().string());
    std::sort(names.begin(), names.end());
    return names;
}

// Returns the initial pieces of the physics: on the stage, broken by the recipe.
[[nodiscard]] inline fracture::Fragments started(const FractureOptions& options) {
    return break_input(placed_on_stage(load_input(options), options.world), options).fragments;
}

// Checks that all pieces are closed, have positive volume and add up to the whole.
inline void check_pieces(const physics::Destruction& destruction, double whole) {
    double sum = 0.0;
    for (const physics::PieceId id : destruction.pieces()) {
        const physics::SolidPiece& piece = *destruction.solid(id);
        CHECK(fracture::check_topology(piece.surface().positions.size(), piece.surface().mesh.triangles).closed());
        const std::vector<glm::dvec3> positions(piece.surface().positions.begin(), piece.surface().positions.end());
        const double volume = fracture::signed_volume(positions, piece.surface().mesh.triangles);
        CHECK(volume > 0.0);
        sum += volume;
    }
    CHECK(destruction.statistics().failed == 0);
    CHECK(sum == doctest::Approx(whole).epsilon(1e-6)); // positions for drawing have single precision
}

// Sums of absolute values over all bodies, with which errors of momentum are compared; the vector sums may cancel.
// Never 0.
struct Motion {
    double momentum = 1e-3; // kg m/s
    double angular = 1e-3;  // kg m^2/s
};
[[nodiscard]] inline Motion motion_of(const physics::World& world) {
    Motion all;
    for (const physics::BodyId body : world.bodies()) {
        const physics::Mechanics own = world.mechanics(body);
        all.momentum += glm::length(own.momentum);
        all.angular += glm::length(own.angular_momentum);
    }
    return all;
}

} // namespace brittle::tools::test

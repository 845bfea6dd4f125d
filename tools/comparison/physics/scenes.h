// The scenes of tools/compare --physics: those of tools/bench/scenes.h and a broken bunny, as files that every peer reads.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "tools/comparison/adapters/rigid_scene.h"

namespace brittle::comparison {

// What must happen.
enum class Outcome {
    stands,  // no body moves
    falls,   // a body leaves its place
    slides,  // the first body, along a slope
    rests,   // the first body, on a slope
    bounces, // the first body, on the ground
    wave,    // dominoes
    piles_up // pieces that fall
};

struct SceneInfo {
    const char* name;
    const char* title;
    Outcome outcome;
    // Thickness of an arch in mean radii, degrees of a slope above the angle of repose, coefficient of restitution, or
    // the height, m, from which pieces fall; 0 otherwise.
    double parameter;
    double fall;             // m, by which a body has left its place: stands and falls
    double seconds;          // to simulate
    uint32_t steps_a_record; // between two poses in the trajectory
};

[[nodiscard]] std::span<const SceneInfo> scene_infos();
// Throws std::runtime_error, with the names that there are, where there is none of this name.
[[nodiscard]] const SceneInfo& scene_info(const std::string& name);
[[nodiscard]] RigidScene make_scene(const SceneInfo& info);
void write_scene(const std::string& file, const RigidScene& scene);

inline constexpr double slope_friction = 0.5;
inline constexpr double bounce_height = 1.0; // m, of the lowest point above the ground

} // namespace brittle::comparison

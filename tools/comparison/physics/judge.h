// Judges what a peer made of a scene, from the poses alone: the same for all peers.
//
// Every trajectory must be complete, finite, begin at the poses of the scene, leave fixed bodies where they are, gain no
// energy, and end with no body in the ground or in another one. Then the truth of the scene decides: statics, mechanics,
// or that real ones stand (tools/bench/theory.h). Bounds are those of tools/bench/bounds.h.
#pragma once

#include <string>
#include <vector>

#include "tools/comparison/adapters/rigid_scene.h"
#include "tools/comparison/physics/scenes.h"

namespace brittle::comparison {

struct Judgement {
    std::string truth;
    std::string result; // what the poses show; empty where they cannot be used
    std::vector<std::string> faults{};

    [[nodiscard]] std::string reason() const; // the faults, joined; empty: sound
};

// Throws std::runtime_error that names the file where it is missing, too short or too long.
[[nodiscard]] Trajectory read_poses(const std::string& file);

[[nodiscard]] Judgement judge(const SceneInfo& info, const RigidScene& scene, const Trajectory& trajectory);

} // namespace brittle::comparison

// Measures a scene of several objects: how long its start takes, then frames in which it stands and frames in which it
// is played, with its shots.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/render/renderer.h"
#include "tools/brittle/profile/scenario.h"
#include "tools/brittle/profile/series.h"
#include "tools/brittle/profile/trace.h"
#include "tools/scenario/recipe/view_options.h"

namespace brittle::tools {

struct SceneTimes {
    size_t objects = 0;
    size_t triangles = 0;           // of the meshes of all objects
    size_t pieces = 0;              // at the start
    std::vector<std::string> notes; // for people: LoadedScene::notes
    double first_milliseconds = 0.0;
    // read: files, repairs and sites; prepare: fractures, solids and hulls, and with a renderer their geometry; total.
    Series start;
};

// Each series has frame, physics (where time passes), scene, draw (with reading back) and the passes.
struct SceneFrames {
    Series starting; // the frame that takes over the objects; it also has "bodies and upload"
    Series standing; // before time begins
    Series playing;
    std::vector<double> milliseconds; // duration of each of these frames in their order
    size_t playing_from = 0;          // index of the first frame of `playing`
    uint32_t cuts = 0;                // that took effect
    size_t pieces = 0;                // at the end
};

// Starts the scene warm_up + repeats times. `renderer` may be null. Throws a Failure.
[[nodiscard]] SceneTimes measure_starts(const Scenario& scenario, const ProfilePlan& plan, engine::Renderer* renderer,
                                        Trace* trace);

// Draws plan.frames frames that stand, and as many that are played, at the pace of the scene's time. Cuts take effect
// after a fixed time, so that every run does the same work; a frame waits for one that is late. Throws a Failure.
[[nodiscard]] SceneFrames measure_scene_frames(const Scenario& scenario, const ProfilePlan& plan,
                                               const ViewOptions& view, engine::Renderer& renderer, Trace* trace);

} // namespace brittle::tools

// Measures scenarios, one after the other.
//
//     Trace trace;
//     Profiler profiler(plan, view, &trace);
//     for (const Scenario& scenario : scenarios) json.push_back(profiler.measure(scenario));
#pragma once

#include <memory>

#include <nlohmann/json.hpp>

#include "engine/render/renderer.h"
#include "tools/brittle/profile/scenario.h"
#include "tools/brittle/profile/trace.h"
#include "tools/scenario/recipe/view_options.h"

namespace brittle::tools {

class Profiler {
  public:
    // `trace` may be null. All three must outlive the profiler.
    Profiler(const ProfilePlan& plan, const ViewOptions& view, Trace* trace);

    // Measures a scenario and returns an object.
    //
    // Keys: name, mesh, vertices, triangles, sites, pieces, closed, classify ("cpu" or "gpu"), classify_why (for
    // people), recipe; import and first (ms: reading the mesh, and the fracture before any warm-up); fracture {phase:
    // statistics of ms, ..., rest, total, pass NAME, ...}. With frames also
    //   frames {whole, breaking, taking over, falling: {frame, physics, scene, draw, pass NAME, ...}}
    //   frame_series {milliseconds [of each frame], breaking_from, fracture_frame}
    // breaking_from is the index of the first frame beside which another thread breaks the mesh, as in the demo;
    // fracture_frame is the index of the frame that takes over the pieces.
    //
    // A scene has other keys: name, objects, triangles, pieces (at the start), recipe, first; start {read, prepare,
    // total: statistics of ms}. With frames also
    //   frames {starting, standing, playing: {frame, physics, scene, draw, pass NAME, ...}}
    //   frame_series {milliseconds, playing_from}
    //   played {cuts, pieces (at the end)}
    //
    // Throws a Failure.
    [[nodiscard]] nlohmann::ordered_json measure(const Scenario& scenario);

    // Returns {device, driver, common_clock} of the device in use; empty if there is none.
    [[nodiscard]] nlohmann::ordered_json device() const;

    // Throws a Failure if the validation layer reported anything.
    void check() const;

  private:
    [[nodiscard]] nlohmann::ordered_json measure_mesh(const Scenario& scenario);
    [[nodiscard]] nlohmann::ordered_json measure_scene(const Scenario& scenario);
    [[nodiscard]] ClassifyChoice choose(const Scenario& scenario, const Input& input);
    [[nodiscard]] engine::Renderer& renderer();

    const ProfilePlan& plan_;
    const ViewOptions& view_;
    Trace* trace_;
    // Two devices, because one thread may classify while another one draws.
    std::unique_ptr<engine::Device> compute_device_, render_device_;
    std::unique_ptr<engine::Renderer> renderer_;
};

} // namespace brittle::tools

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
#include "tools/brittle/recipe/view_options.h"

namespace brittle::tools {

class Profiler {
  public:
    // `trace` may be null; it and the other two must outlive the profiler.
    Profiler(const ProfilePlan& plan, const ViewOptions& view, Trace* trace);

    // Keys: name, mesh, vertices, triangles, sites, pieces, closed, classify ("cpu" or "gpu"), classify_why (for people),
    // recipe; import and first (ms: reading the mesh, and
    // the fracture before any warm-up); fracture {phase: statistics of ms, ..., rest, total, pass NAME, ...}.
    // With frames also
    //   frames {whole, breaking, taking over, falling: {frame, physics, scene, draw, pass NAME, ...}}
    //   frame_series {milliseconds [of each frame], breaking_from, fracture_frame}, the last two indices of frames: the
    //   first beside which the mesh is being broken, as in the demo by another thread, and the one that takes its
    //   pieces over.
    // Throws a Failure.
    [[nodiscard]] nlohmann::ordered_json measure(const Scenario& scenario);

    // {device, driver, common_clock} of the device that was used; empty where none was.
    [[nodiscard]] nlohmann::ordered_json device() const;

    // Throws a Failure where the validation layer had something to say.
    void check() const;

  private:
    [[nodiscard]] ClassifyChoice choose(const Scenario& scenario, const Input& input);
    [[nodiscard]] engine::Renderer& renderer();

    const ProfilePlan& plan_;
    const ViewOptions& view_;
    Trace* trace_;
    // Two devices, because one thread may classify while another draws.
    std::unique_ptr<engine::Device> compute_device_, render_device_;
    std::unique_ptr<engine::Renderer> renderer_;
};

} // namespace brittle::tools

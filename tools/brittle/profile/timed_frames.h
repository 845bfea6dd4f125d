// Draws frames of a stage, and measures their parts.
//
//     TimedFrames frames(stage, view, renderer, trace);
//     Series falling;
//     for (uint32_t frame = 0; frame < 60; ++frame) frames.draw(falling);
#pragma once

#include <functional>

#include "engine/camera/camera.h"
#include "engine/render/renderer.h"
#include "tools/brittle/profile/series.h"
#include "tools/brittle/profile/trace.h"
#include "tools/brittle/stage/stage.h"
#include "tools/scenario/recipe/view_options.h"

namespace brittle::tools {

class TimedFrames {
  public:
    // `trace` may be null. All must outlive the object. The camera looks at the bounds that the stage has now.
    TimedFrames(Stage& stage, const ViewOptions& view, engine::Renderer& renderer, Trace* trace);

    static constexpr double seconds = 1.0 / 60.0; // by which a frame advances the time

    enum class Time { passes, stands_still };

    // Draws one frame, reads it back and returns its duration, ms. Adds to the series frame, physics (where time
    // passes), scene, draw and each pass. `take_over`, if given, changes the stage first; it is the part of the frame
    // that is named "bodies and upload".
    double draw(Series& series, Time time = Time::passes, const std::function<void()>& take_over = {});

  private:
    Stage& stage_;
    const ViewOptions& view_;
    engine::Renderer& renderer_;
    Trace* trace_;
    engine::Camera camera_;
};

} // namespace brittle::tools

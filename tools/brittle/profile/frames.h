// Frame times before, during and after a fracture, as in the demo: another thread breaks the mesh, and the first frame
// after its end takes over the pieces.
#pragma once

#include <vector>

#include "engine/compute/gpu_classifier.h"
#include "engine/render/renderer.h"
#include "tools/brittle/profile/scenario.h"
#include "tools/brittle/profile/series.h"
#include "tools/brittle/profile/trace.h"
#include "tools/scenario/recipe/input.h"
#include "tools/scenario/recipe/view_options.h"

namespace brittle::tools {

struct FrameTimes {
    // Each series has frame, physics, scene, draw (with reading back) and the passes; taking_over also has "bodies and
    // upload".
    Series whole;       // the unbroken mesh at rest, without the first frame, which draws the shadow
    Series breaking;    // frames during the fracture
    Series taking_over; // the one frame that takes over the pieces
    Series falling;
    std::vector<double> milliseconds; // duration of each of these frames in their order
    size_t breaking_from = 0;         // index of the first frame of `breaking`
    size_t fracture_frame = 0;        // index of the frame that takes over the pieces
};

// Measures `frames` frames before the fracture and as many after it. `classifier` belongs to another device than the
// renderer; `classifier` and `trace` may be null. Throws a Failure.
[[nodiscard]] FrameTimes measure_frames(const Scenario& scenario, const Input& input, uint32_t frames,
                                        const ViewOptions& view, engine::Renderer& renderer,
                                        engine::GpuClassifier* classifier, Trace* trace);

} // namespace brittle::tools

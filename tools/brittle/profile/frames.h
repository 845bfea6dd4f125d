// Frames before, during and after a fracture, as the demo makes them: another thread breaks the mesh, and the first
// frame that finds it done takes the pieces over.
#pragma once

#include <vector>

#include "engine/compute/gpu_classifier.h"
#include "engine/render/renderer.h"
#include "tools/brittle/profile/scenario.h"
#include "tools/brittle/profile/series.h"
#include "tools/brittle/profile/trace.h"
#include "tools/brittle/recipe/input.h"
#include "tools/brittle/recipe/view_options.h"

namespace brittle::tools {

struct FrameTimes {
    // Each: frame, physics, scene, draw (with reading back) and the passes; taking over also "bodies and upload".
    Series whole;       // the unbroken mesh at rest; the first frame, which draws the shadow, left out
    Series breaking;    // while the other thread works
    Series taking_over; // one frame
    Series falling;
    std::vector<double> milliseconds; // of each of these frames in their order
    size_t breaking_from = 0;         // index of the first frame of `breaking`
    size_t fracture_frame = 0;        // and of the one that takes over
};

// So many frames before and after. `classifier` belongs to another device than the renderer; it and `trace` may be
// null. Throws a Failure.
[[nodiscard]] FrameTimes measure_frames(const Scenario& scenario, const Input& input, uint32_t frames,
                                        const ViewOptions& view, engine::Renderer& renderer,
                                        engine::GpuClassifier* classifier, Trace* trace);

} // namespace brittle::tools

// Repeated measurement of one fracture.
#pragma once

#include "engine/compute/gpu_classifier.h"
#include "fracture/base/work_log.h"
#include "tools/brittle/profile/scenario.h"
#include "tools/brittle/profile/series.h"
#include "tools/brittle/profile/trace.h"
#include "tools/scenario/recipe/input.h"

namespace brittle::tools {

struct FractureTimes {
    Series series; // each phase, rest (checks, and freeing of memory), total, and each pass of the classifier
    double first_milliseconds = 0.0; // duration of the first fracture, before any warm-up
    fracture::Certificate certificate;
};

// Measures a scenario. `classifier` and `trace` may be null. Throws a Failure.
[[nodiscard]] FractureTimes measure_fractures(const Scenario& scenario, const Input& input, const ProfilePlan& plan,
                                              engine::GpuClassifier* classifier, Trace* trace);

// Adds one fracture to the trace: its phases, the work of each thread and the passes of the classifier. It began at
// `begin` (trace_clock()).
void trace_fracture(Trace& trace, Track track, int depth, int64_t begin, const Broken& broken,
                    const fracture::WorkLog& work, const engine::GpuClassifier* classifier);

// Throws the failure of the classifier's device, if any. Without this the CPU's times would be reported as the
// device's.
void check_classifier(const engine::GpuClassifier* classifier);

} // namespace brittle::tools

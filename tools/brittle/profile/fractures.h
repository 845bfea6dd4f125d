// The same fracture again and again.
#pragma once

#include "engine/compute/gpu_classifier.h"
#include "fracture/base/work_log.h"
#include "tools/brittle/profile/scenario.h"
#include "tools/brittle/profile/series.h"
#include "tools/brittle/profile/trace.h"
#include "tools/brittle/recipe/input.h"

namespace brittle::tools {

struct FractureTimes {
    Series series; // each phase, rest (checks, and giving memory back), total, and each pass of the classifier
    double first_milliseconds = 0.0; // of the very first one, before any warm-up
    fracture::Certificate certificate;
};

// `classifier` and `trace` may be null. Throws a Failure.
[[nodiscard]] FractureTimes measure_fractures(const Scenario& scenario, const Input& input, const ProfilePlan& plan,
                                              engine::GpuClassifier* classifier, Trace* trace);

// One fracture that began at `begin` (trace_clock()): its phases, what each thread did of them, and the classifier's passes.
void trace_fracture(Trace& trace, Track track, int depth, int64_t begin, const Broken& broken,
                    const fracture::WorkLog& work, const engine::GpuClassifier* classifier);

// What a classifier's device refused ends the profile: the CPU's times would go by its name.
void check_classifier(const engine::GpuClassifier* classifier);

} // namespace brittle::tools

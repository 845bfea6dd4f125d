#include "tools/brittle/profile/fractures.h"

#include <algorithm>
#include <cmath>

#include "tools/brittle/base/interrupt.h"
#include "tools/brittle/base/progress.h"
#include "tools/brittle/profile/passes.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {

FractureTimes measure_fractures(const Scenario& scenario, const Input& input, const ProfilePlan& plan,
                                engine::GpuClassifier* classifier, Trace* trace) {
    FractureTimes times;
    Progress progress("fracturing " + scenario.name);
    const uint32_t runs = plan.warm_up + plan.repeats;
    fracture::WorkLog work;
    for (uint32_t run = 0; run < runs; ++run) {
        const int64_t begin = trace_clock();
        work.clear();
        const Broken broken =
            break_input(input, scenario.fracture, {}, classifier, is_interrupted, trace ? &work : nullptr);
        check_classifier(classifier);
        progress.update(static_cast<double>(run + 1) / runs);
        if (run == 0) times.first_milliseconds = broken.milliseconds;
        times.certificate = broken.certificate;
        if (trace) trace_fracture(*trace, Track::main, 1, begin, broken, work, classifier);
        if (run < plan.warm_up) continue;
        double named = 0.0;
        for (const fracture::Milliseconds& t : broken.fragments.timings) {
            times.series.add(t.phase, t.milliseconds);
            named += t.milliseconds;
        }
        times.series.add("rest", std::max(0.0, broken.milliseconds - named));
        times.series.add("total", broken.milliseconds);
        if (classifier) add_passes(times.series, classifier->timings());
    }
    return times;
}

void trace_fracture(Trace& trace, Track track, int depth, int64_t begin, const Broken& broken,
                    const fracture::WorkLog& work, const engine::GpuClassifier* classifier) {
    trace.add(track, depth, "fracture", begin, begin + std::llround(broken.milliseconds * 1e6));
    // Phases follow one another; the short gaps between them are added up at the end.
    std::vector<Trace::Step> steps;
    for (const fracture::Milliseconds& t : broken.fragments.timings) steps.push_back({t.phase, t.milliseconds});
    trace.add_steps(track, depth + 1, steps, begin);
    for (size_t thread = 0; thread < work.threads(); ++thread)
        for (const fracture::WorkLog::Slice& slice : work.of_thread(thread))
            trace.add(share_track(thread), 0, slice.step, slice.from, slice.to, slice.begin, slice.end);
    if (classifier) trace_passes(trace, Track::classifier, classifier->timings());
}

void check_classifier(const engine::GpuClassifier* classifier) {
    if (classifier && !classifier->error().empty()) throw Failure(exit_environment, classifier->error());
}

} // namespace brittle::tools

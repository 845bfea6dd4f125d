#include "tools/brittle/profile/frames.h"

#include <chrono>
#include <future>
#include <utility>

#include "tools/brittle/base/interrupt.h"
#include "tools/brittle/base/progress.h"
#include "tools/brittle/profile/fractures.h"
#include "tools/brittle/profile/timed_frames.h"
#include "tools/brittle/stage/stage.h"

namespace brittle::tools {

FrameTimes measure_frames(const Scenario& scenario, const Input& input, uint32_t frames, const ViewOptions& view,
                          engine::Renderer& renderer, engine::GpuClassifier* classifier, Trace* trace) {
    FrameTimes times;
    Stage stage(renderer, input.model.mesh, scenario.fracture.material);
    TimedFrames drawer(stage, view, renderer, trace);
    Progress progress("rendering " + scenario.name);
    Series warm_up;
    (void)drawer.draw(warm_up);
    for (uint32_t frame = 0; frame < frames; ++frame) {
        times.milliseconds.push_back(drawer.draw(times.whole));
        progress.update(0.5 * (frame + 1) / frames);
    }

    int64_t begin = 0;
    fracture::WorkLog work;
    times.breaking_from = times.milliseconds.size();
    int64_t cut = 0, ready = 0;
    std::future<std::pair<Broken, PreparedPieces>> breaking = std::async(std::launch::async, [&] {
        begin = trace_clock();
        Broken broken = break_input(input, scenario.fracture, {}, classifier, is_interrupted, trace ? &work : nullptr);
        cut = trace_clock();
        PreparedPieces ahead =
            prepare_pieces(renderer, broken.fragments, {}, scenario.fracture.material, scenario.fracture.threads);
        ready = trace_clock();
        return std::pair(std::move(broken), std::move(ahead));
    });
    do {
        times.milliseconds.push_back(drawer.draw(times.breaking));
    } while (breaking.wait_for(std::chrono::seconds(0)) != std::future_status::ready);
    auto [broken, ahead] = breaking.get();
    check_classifier(classifier);
    times.fracture_frame = times.milliseconds.size();
    if (trace) {
        trace_fracture(*trace, Track::worker, 0, begin, broken, work, classifier);
        trace->add(Track::worker, 1, "hulls and geometry", cut, ready);
        trace->mark("the pieces are there", trace_clock());
    }
    times.milliseconds.push_back(
        drawer.draw(times.taking_over, TimedFrames::Time::passes,
                    [&, &pieces = broken.fragments, &made = ahead] { stage.stand(pieces, {}, std::move(made)); }));

    for (uint32_t frame = 0; frame < frames; ++frame) {
        times.milliseconds.push_back(drawer.draw(times.falling));
        progress.update(0.5 + 0.5 * (frame + 1) / frames);
    }
    return times;
}

} // namespace brittle::tools

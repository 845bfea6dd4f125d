#include "tools/brittle/profile/timed_frames.h"

#include "tools/brittle/base/device_failure.h"
#include "tools/brittle/base/interrupt.h"
#include "tools/brittle/pictures/view.h"
#include "tools/brittle/profile/passes.h"

namespace brittle::tools {

TimedFrames::TimedFrames(Stage& stage, const ViewOptions& view, engine::Renderer& renderer, Trace* trace)
    : stage_(stage), view_(view), renderer_(renderer), trace_(trace) {
    const float aspect = static_cast<float>(view.width) / static_cast<float>(view.height);
    camera_ = engine::look_at_bounds(stage_view(stage.home_bounds()), 0.55f, 0.3f, aspect);
}

double TimedFrames::draw(Series& series, Time time, const std::function<void()>& take_over) {
    throw_if_interrupted();
    const int64_t begin = trace_clock();
    int64_t at = begin;
    const auto measure = [&](const char* part) {
        const int64_t end = trace_clock();
        series.add(part, milliseconds_between(at, end));
        if (trace_) trace_->add(Track::main, 2, part, at, end);
        at = end;
    };
    if (take_over) {
        take_over();
        measure("bodies and upload");
    }
    if (time == Time::passes) {
        stage_.advance(seconds);
        measure("physics");
    }
    engine::Scene scene = stage_.scene();
    scene.camera = camera_;
    measure("scene");
    (void)must(renderer_.render(scene, {view_.width, view_.height}));
    measure("draw");
    series.add("frame", milliseconds_between(begin, at));
    add_passes(series, renderer_.timings());
    if (trace_) {
        trace_->add(Track::main, 1, "frame", begin, at);
        trace_passes(*trace_, Track::device, renderer_.timings());
    }
    return milliseconds_between(begin, at);
}

} // namespace brittle::tools

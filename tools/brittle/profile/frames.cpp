#include "tools/brittle/profile/frames.h"

#include <chrono>
#include <future>
#include <utility>

#include "engine/camera/camera.h"
#include "tools/brittle/base/device_failure.h"
#include "tools/brittle/base/interrupt.h"
#include "tools/brittle/base/progress.h"
#include "tools/brittle/pictures/view.h"
#include "tools/brittle/profile/fractures.h"
#include "tools/brittle/profile/passes.h"
#include "tools/brittle/stage/stage.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {

namespace {

constexpr double frame_seconds = 1.0 / 60.0;

double milliseconds_between(int64_t begin, int64_t end) {
    return static_cast<double>(end - begin) * 1e-6;
}

class Frames {
  public:
    Frames(const Scenario& scenario, const Input& input, const ViewOptions& view, engine::Renderer& renderer,
           Trace* trace)
        : view_(view), renderer_(renderer), trace_(trace),
          stage_(renderer, input.model.mesh, scenario.fracture.material) {
        const float aspect = static_cast<float>(view.width) / static_cast<float>(view.height);
        camera_ = engine::look_at_bounds(stage_view(stage_.home_bounds()), 0.55f, 0.3f, aspect);
    }

    // Draws one frame and returns its duration, ms. If pieces are given they replace the unbroken mesh first.
    double draw(Series& series, const fracture::Fragments* pieces = nullptr, PreparedPieces ahead = {}) {
        throw_if_interrupted();
        const int64_t begin = trace_clock();
        int64_t shattered = begin;
        if (pieces) {
            stage_.stand(*pieces, {}, std::move(ahead));
            shattered = trace_clock();
            series.add("bodies and upload", milliseconds_between(begin, shattered));
        }
        stage_.advance(frame_seconds);
        const int64_t advanced = trace_clock();
        engine::Scene scene = stage_.scene();
        scene.camera = camera_;
        const int64_t described = trace_clock();
        (void)must(renderer_.render(scene, {view_.width, view_.height}));
        const int64_t end = trace_clock();

        series.add("physics", milliseconds_between(shattered, advanced));
        series.add("scene", milliseconds_between(advanced, described));
        series.add("draw", milliseconds_between(described, end));
        series.add("frame", milliseconds_between(begin, end));
        add_passes(series, renderer_.timings());
        if (trace_) {
            trace_->add(Track::main, 1, "frame", begin, end);
            if (pieces) trace_->add(Track::main, 2, "bodies and upload", begin, shattered);
            trace_->add(Track::main, 2, "physics", shattered, advanced);
            trace_->add(Track::main, 2, "scene", advanced, described);
            trace_->add(Track::main, 2, "draw", described, end);
            trace_passes(*trace_, Track::device, renderer_.timings());
        }
        return milliseconds_between(begin, end);
    }

  private:
    const ViewOptions& view_;
    engine::Renderer& renderer_;
    Trace* trace_;
    Stage stage_;
    engine::Camera camera_;
};

} // namespace

FrameTimes measure_frames(const Scenario& scenario, const Input& input, uint32_t frames, const ViewOptions& view,
                          engine::Renderer& renderer, engine::GpuClassifier* classifier, Trace* trace) {
    FrameTimes times;
    Frames drawer(scenario, input, view, renderer, trace);
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
    times.milliseconds.push_back(drawer.draw(times.taking_over, &broken.fragments, std::move(ahead)));

    for (uint32_t frame = 0; frame < frames; ++frame) {
        times.milliseconds.push_back(drawer.draw(times.falling));
        progress.update(0.5 + 0.5 * (frame + 1) / frames);
    }
    return times;
}

} // namespace brittle::tools

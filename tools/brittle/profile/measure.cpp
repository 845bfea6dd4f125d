#include "tools/brittle/profile/measure.h"

#include <filesystem>

#include "tools/brittle/base/console.h"
#include "tools/brittle/base/device_failure.h"
#include "tools/brittle/pictures/view.h"
#include "tools/brittle/profile/fractures.h"
#include "tools/brittle/profile/frames.h"
#include "tools/brittle/profile/scenes.h"
#include "tools/brittle/stage/loading.h"
#include "tools/brittle/stage/stage.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/recipe.h"

namespace brittle::tools {

namespace {

using Json = nlohmann::ordered_json;

// The recipe with bare file names, because paths are private.
Json recipe_without_folders(FractureOptions options) {
    const auto shorten = [](std::string& file) {
        if (!file.starts_with("shape:")) file = std::filesystem::path(file).filename().string();
    };
    shorten(options.mesh);
    shorten(options.sites_file);
    shorten(options.level.mesh);
    for (SceneObject& object : options.objects) {
        shorten(object.recipe.mesh);
        shorten(object.recipe.sites_file);
    }
    return Json::parse(recipe_json(options));
}

} // namespace

Profiler::Profiler(const ProfilePlan& plan, const ViewOptions& view, Trace* trace)
    : plan_(plan), view_(view), trace_(trace) {}

ClassifyChoice Profiler::choose(const Scenario& scenario, const Input& input) {
    if (scenario.classify == ClassifyPath::cpu) return {.why = "cpu, as requested"};
    try {
        if (!compute_device_) compute_device_ = open_device(view_);
    } catch (const Failure& failure) {
        if (scenario.classify == ClassifyPath::gpu) throw;
        return {.why = std::string("cpu: ") + failure.what()};
    }
    return choose_classifier(scenario.classify, *compute_device_, input, scenario.fracture);
}

engine::Renderer& Profiler::renderer() {
    if (!render_device_) render_device_ = open_device(view_);
    if (!renderer_) {
        renderer_ = must(engine::Renderer::create(*render_device_, renderer_settings(view_)));
        must(renderer_->warm_up());
    }
    return *renderer_;
}

Json Profiler::measure(const Scenario& scenario) {
    return is_scene(scenario.fracture) ? measure_scene(scenario) : measure_mesh(scenario);
}

Json Profiler::measure_scene(const Scenario& scenario) {
    const std::string& recipe = scenario.fracture.save_recipe;
    if (!recipe.empty()) write_recipe(recipe, scenario.fracture);
    const int64_t begin = trace_clock();
    engine::Renderer* const drawer = plan_.frames > 0 ? &renderer() : nullptr;
    const SceneTimes times = measure_starts(scenario, plan_, drawer, trace_);
    for (const std::string& note : times.notes) tell("%s", note.c_str());
    Json json{{"name", scenario.name},
              {"objects", times.objects},
              {"triangles", times.triangles},
              {"pieces", times.pieces},
              {"recipe", recipe_without_folders(scenario.fracture)},
              {"first", times.first_milliseconds},
              {"start", times.start.json()}};
    if (drawer) {
        const SceneFrames frames = measure_scene_frames(scenario, plan_, view_, *drawer, trace_);
        json["frames"] = {{"starting", frames.starting.json()},
                          {"standing", frames.standing.json()},
                          {"playing", frames.playing.json()}};
        json["frame_series"] = {{"milliseconds", frames.milliseconds}, {"playing_from", frames.playing_from}};
        json["played"] = {{"cuts", frames.cuts}, {"pieces", frames.pieces}};
    }
    if (trace_) trace_->add(Track::main, 0, scenario.name, begin, trace_clock());
    return json;
}

Json Profiler::measure_mesh(const Scenario& scenario) {
    const Input input = placed_on_stage(open_input(scenario.fracture));
    const ClassifyChoice choice = choose(scenario, input);
    engine::GpuClassifier* const classifier = choice.classifier.get();
    const int64_t begin = trace_clock();
    const FractureTimes times = measure_fractures(scenario, input, plan_, classifier, trace_);
    Json json{{"name", scenario.name},
              {"mesh", input.name},
              {"vertices", input.model.mesh.positions.size()},
              {"triangles", input.model.mesh.triangles.size()},
              {"sites", input.sites.size()},
              {"pieces", times.certificate.pieces},
              {"closed", times.certificate.closed},
              {"classify", classifier ? "gpu" : "cpu"},
              {"classify_why", choice.why},
              {"recipe", recipe_without_folders(scenario.fracture)},
              {"import", input.import_milliseconds},
              {"first", times.first_milliseconds},
              {"fracture", times.series.json()}};
    if (plan_.frames > 0) {
        const FrameTimes frames = measure_frames(scenario, input, plan_.frames, view_, renderer(), classifier, trace_);
        json["frames"] = {{"whole", frames.whole.json()},
                          {"breaking", frames.breaking.json()},
                          {"taking over", frames.taking_over.json()},
                          {"falling", frames.falling.json()}};
        json["frame_series"] = {{"milliseconds", frames.milliseconds},
                                {"breaking_from", frames.breaking_from},
                                {"fracture_frame", frames.fracture_frame}};
    }
    if (trace_) trace_->add(Track::main, 0, scenario.name, begin, trace_clock());
    return json;
}

Json Profiler::device() const {
    const engine::Device* device = render_device_ ? render_device_.get() : compute_device_.get();
    if (!device) return Json::object();
    return {{"device", device->info().name},
            {"driver", device->info().driver},
            {"common_clock", device->has_common_clock()}};
}

void Profiler::check() const {
    for (const auto* device : {compute_device_.get(), render_device_.get()})
        if (device) check_validation(*device);
}

} // namespace brittle::tools

#include <cstdio>

#include "engine/core/bitmap.h"
#include "tools/brittle/classify_choice.h"
#include "tools/brittle/commands.h"
#include "tools/brittle/failure.h"
#include "tools/brittle/picture_name.h"
#include "tools/brittle/interrupt.h"
#include "tools/brittle/progress.h"
#include "tools/brittle/stage.h"
#include "tools/brittle/view.h"

namespace brittle::tools {

namespace {

constexpr double frame_seconds = 1.0 / 60.0;
constexpr float azimuth = 0.55f;  // rad
constexpr float elevation = 0.3f; // rad

void check_output(const RenderCommand& command) {
    if (is_numbered(command.output)) return;
    if (!is_plain(command.output)) {
        throw Failure(exit_usage, "--output '" + command.output +
                                      "' is no file name: put %04d where the frame's number is to go, or no % at all");
    }
    if (!command.whole && command.frames >= command.every) {
        throw Failure(exit_usage, "--output '" + command.output +
                                      "' names one file for several pictures: put %04d where the frame's number is to "
                                      "go, e.g. frame_%04d.png, or give --frames 0 for one picture");
    }
}

} // namespace

int run_render(const RenderCommand& command) {
    check_output(command);
    catch_interrupts();
    const Input input = placed_on_stage(load_input(command.fracture));
    const std::unique_ptr<engine::Device> device = open_device(command.view);
    const auto renderer = must(engine::Renderer::create(*device));
    Stage stage(*renderer, input.model.mesh, command.fracture.material);
    if (!command.whole) {
        const ClassifyChoice choice =
            choose_classifier(classify_path(command.classify), *device, input, command.fracture);
        if (command.classify != "cpu") std::fprintf(stderr, "brittle: classification on the %s\n", choice.why.c_str());
        Progress progress("fracturing " + input.name);
        const Broken broken = break_input(
            input, command.fracture, [&](double share) { progress.update(share); }, choice.classifier.get());
        stage.shatter(broken.fragments);
    }
    if (command.sites) stage.show_sites(input.sites);
    stage.show_hulls(command.hulls);
    stage.explode(command.explode);

    const float aspect = static_cast<float>(command.view.width) / static_cast<float>(command.view.height);
    const engine::Camera camera =
        engine::look_at_bounds(stage_view(stage.home_bounds()), azimuth, elevation, aspect);
    const uint32_t frames = command.whole ? 0 : command.frames;
    uint32_t pictures = 0;
    std::string last;
    Progress progress("rendering");
    for (uint32_t frame = 0; frame <= frames; ++frame) {
        throw_if_interrupted();
        if (frame > 0) stage.advance(frame_seconds);
        if (frame % command.every != 0) continue;
        engine::Scene scene = stage.scene();
        scene.camera = camera;
        const engine::Bitmap picture = must(renderer->render(scene, {command.view.width, command.view.height}));
        last = picture_name(command.output, frame);
        must(engine::write_png(picture, last));
        ++pictures;
        progress.update(frames == 0 ? 1.0 : static_cast<double>(frame) / frames);
    }
    std::printf("%u picture%s of %s on %s, the last %s\n", pictures, pictures == 1 ? "" : "s", input.name.c_str(),
                device->info().name.c_str(), last.c_str());
    check_validation(*device);
    return exit_success;
}

} // namespace brittle::tools

#include <cmath>
#include <cstdio>
#include <span>

#include "engine/core/bitmap.h"
#include "fracture/io/atomic_file.h"
#include "tools/brittle/classify_choice.h"
#include "tools/brittle/commands.h"
#include "tools/brittle/failure.h"
#include "tools/brittle/id_picture.h"
#include "tools/brittle/picture.h"
#include "tools/brittle/picture_name.h"
#include "tools/brittle/interrupt.h"
#include "tools/brittle/progress.h"
#include "tools/brittle/stage.h"
#include "tools/brittle/view.h"

namespace brittle::tools {

namespace {

constexpr double frame_seconds = 1.0 / 60.0;

void check_output(const char* option, const std::string& output) {
    if (is_numbered(output) || is_plain(output)) return;
    throw Failure(exit_usage, std::string(option) + " '" + output +
                                  "' is no file name: put %04d where the frame's number is to go, or no % at all for "
                                  "one picture of the end");
}

} // namespace

int run_render(const RenderCommand& command) {
    const PictureOptions& picture = command.fracture.picture;
    const WorldOptions& world = command.fracture.world;
    check_output("--output", command.output);
    check_output("--ids", command.ids);
    catch_interrupts();
    const Input input = placed_on_stage(load_input(command.fracture), command.fracture.world);
    const std::unique_ptr<engine::Device> device = open_device(command.view);
    const auto renderer = must(engine::Renderer::create(*device, renderer_settings(command.view)));
    Stage stage(*renderer, input.model.mesh, command.fracture.material);
    if (picture.planes > 0) {
        stage.shatter(partly_cut(input, picture.planes));
    } else if (!picture.whole) {
        const ClassifyChoice choice =
            choose_classifier(classify_path(command.classify), *device, input, command.fracture);
        if (command.classify != "cpu") std::fprintf(stderr, "brittle: classification on the %s\n", choice.why.c_str());
        Progress progress("fracturing " + input.name);
        const Broken broken = break_input(
            input, command.fracture, [&](double share) { progress.update(share); }, choice.classifier.get());
        if (world.bonded || world.anchored) stage.stand(broken.fragments, world);
        else stage.shatter(broken.fragments);
    }
    if (picture.sites) stage.show_sites(input.sites);
    if (picture.cells) stage.show_lines(cell_lines(input));
    stage.show_hulls(picture.hulls);
    stage.explode(picture.explode);

    const float aspect = static_cast<float>(command.view.width) / static_cast<float>(command.view.height);
    const engine::Camera camera = picture_camera(picture, stage.home_bounds(), aspect);
    const uint32_t frames = picture.whole ? 0 : picture.frames;
    uint32_t pictures = 0;
    std::string last;
    Progress progress("rendering");
    for (uint32_t frame = 0; frame <= frames; ++frame) {
        throw_if_interrupted();
        for (const Shot& shot : world.shots)
            if (frame == static_cast<uint32_t>(std::lround(shot.time / frame_seconds))) stage.shoot(shot);
        if (frame > 0) stage.advance(frame_seconds);
        if (is_numbered(command.output) ? frame % command.every != 0 : frame != frames) continue;
        engine::Scene scene = stage.scene();
        scene.camera = camera;
        scene.smooth = picture.smooth;
        scene.wireframe = picture.wireframe;
        const engine::Bitmap image = must(renderer->render(scene, {command.view.width, command.view.height}));
        last = picture_name(command.output, frame);
        must(engine::write_png(image, last));
        if (!command.ids.empty()) {
            const engine::IdImage ids = must(renderer->render_ids(scene, {command.view.width, command.view.height}));
            must(engine::write_png(id_picture(ids), picture_name(command.ids, frame)));
        }
        ++pictures;
        progress.update(frames == 0 ? 1.0 : static_cast<double>(frame) / frames);
    }
    if (!command.graph.empty()) {
        const std::string& dot = renderer->graph_dot();
        must(fracture::write_file_atomically(command.graph, std::as_bytes(std::span(dot))));
    }
    std::printf("%u picture%s of %s on %s, the last %s\n", pictures, pictures == 1 ? "" : "s", input.name.c_str(),
                device->info().name.c_str(), last.c_str());
    check_validation(*device);
    return exit_success;
}

} // namespace brittle::tools

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "fracture/io/atomic_file.h"
#include "physics/bonds/anchor.h"
#include "physics/material.h"
#include "tools/brittle/base/console.h"
#include "tools/brittle/base/device_failure.h"
#include "tools/brittle/base/interrupt.h"
#include "tools/brittle/base/progress.h"
#include "tools/brittle/commands/commands.h"
#include "tools/brittle/commands/report.h"
#include "tools/brittle/pictures/film.h"
#include "tools/brittle/pictures/picture.h"
#include "tools/brittle/pictures/view.h"
#include "tools/brittle/stage/classify_choice.h"
#include "tools/brittle/stage/loading.h"
#include "tools/brittle/stage/stage.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/base/stopwatch.h"
#include "tools/scenario/recipe/json_reader.h"
#include "tools/scenario/recipe/recipe.h"
#include "tools/scenario/replay/recorder.h"
#include "tools/scenario/run/scene.h"
#include "tools/scenario/run/state_export.h"

namespace brittle::tools {

namespace {

using Json = nlohmann::ordered_json;

// Refuses outputs that need a fracture and its motion together with pictures that have neither.
void check_run(const RenderCommand& command) {
    const PictureOptions& picture = command.fracture.picture;
    for (const char* option : {"--record", "--export"}) {
        const std::string& file = option == std::string("--record") ? command.record : command.pieces.output;
        if (file.empty()) continue;
        if (picture.whole)
            throw Failure(exit_usage, std::string(option) + ": cannot be combined with --whole, because nothing moves");
        if (picture.planes > 0)
            throw Failure(exit_usage, std::string(option)
                                          + ": cannot be combined with --planes, because the mesh is not fractured");
    }
}

// Warns of anchors that touch no part of the mesh. A likely reason is an anchor in the coordinates of the file.
void name_idle_anchors(const fracture::TriangleMesh& on_stage, const WorldOptions& world) {
    for (const Anchor& anchor : world.anchors) {
        const physics::AnchorRegion ball =
            physics::Ball{anchor.at + glm::dvec3(0.0, foot_height(world), 0.0), anchor.radius};
        if (physics::reaches({&ball, 1}, on_stage.positions, on_stage.triangles)) continue;
        tell("the anchor at (%g, %g, %g), radius %g, touches no part of the mesh; its coordinates are metres from the "
             "middle of the mesh's foot, with the mesh 2 m long",
             anchor.at.x, anchor.at.y, anchor.at.z, anchor.radius);
    }
}

// Warns of a limit on pieces in a world without debris.
void name_idle_limit(const WorldOptions& world) {
    if (world.breakable || world.piece_limit == WorldOptions{}.piece_limit) return;
    tell("--piece-limit has no effect: pieces are removed in a breakable world only");
}

// Warns of the size of bricks in a world in which no blow takes out bricks.
void name_idle_brick(const WorldOptions& world, const std::string& material) {
    const physics::RunningBond plain;
    if (world.bond.brick == plain.brick && world.bond.along == plain.along) return;
    const physics::MaterialPreset* preset = physics::material_preset(material);
    const bool of_material = starts_whole(world) && preset && preset->pattern.kind == fracture::PatternKind::bricks;
    if (world.blows ? world.blows->kind == fracture::PatternKind::bricks && world.blows->diagram.empty() : of_material)
        return;
    tell("the recipe's world/brick has no effect: blows take out bricks in a world that is breakable and not bonded, "
         "with the material brick or the pattern bricks");
}

void warn_of_idle_options(const RenderCommand& command, const Input& on_stage, const WorldOptions& world) {
    name_idle_anchors(on_stage.model.mesh, world);
    name_idle_limit(world);
    name_idle_brick(world, command.fracture.material);
}

// Fractures the input and puts the pieces on the stage. Returns the pieces.
std::shared_ptr<const fracture::Fragments> break_on_stage(const RenderCommand& command, const Input& input,
                                                          const WorldOptions& world, engine::Device& device,
                                                          Stage& stage) {
    const ClassifyChoice choice = choose_classifier(classify_path(command.classify), device, input, command.fracture);
    if (command.classify != "cpu") tell("classification on the %s", choice.why.c_str());
    Progress progress("fracturing " + input.name);
    Broken broken = break_input(
        input, command.fracture, [&](double share) { progress.update(share); }, choice.classifier.get(),
        is_interrupted);
    stage.stand(broken.fragments, world);
    return std::make_shared<const fracture::Fragments>(std::move(broken.fragments));
}

// Returns the looks of the mesh, and says what pictures do not show of them.
std::shared_ptr<const MeshLooks> load_looks(const Input& source, const Input& on_stage, const PictureOptions& picture) {
    std::vector<std::string> notes = wants_looks(picture) ? source.model.notes : std::vector<std::string>();
    std::shared_ptr<const MeshLooks> looks = looks_for(source.model, on_stage.model.mesh, picture, notes);
    for (const std::string& note : notes) tell("%s: %s", source.name.c_str(), note.c_str());
    return looks;
}

void show_extras(const PictureOptions& picture, const Input& input, Stage& stage) {
    if (picture.sites) stage.show_sites(input.sites);
    if (picture.cells) stage.show_lines(cell_lines(input));
    stage.show_hulls(picture.hulls);
    stage.explode(picture.explode);
}

void draw_frames(Film& film, Stage& stage, uint32_t frames) {
    film.watch(stage);
    Progress progress("rendering");
    for (uint32_t frame = 0; frame <= frames; ++frame) {
        throw_if_interrupted();
        if (frame > 0) stage.advance(film_frame_seconds);
        film.frame(stage, frame, frame == frames);
        progress.update(frames == 0 ? 1.0 : static_cast<double>(frame) / frames);
    }
    film.finish();
}

void write_graph(const RenderCommand& command, const engine::Renderer& renderer) {
    if (command.graph.empty()) return;
    const std::string& dot = renderer.graph_dot();
    must(fracture::write_file_atomically(command.graph, std::as_bytes(std::span(dot))));
}

// What was written besides pictures, for the report.
struct Done {
    std::string name;                             // of the mesh, or the number of objects
    size_t objects = 0;                           // of a scene; 0: one mesh
    size_t pieces = 0;                            // in the files below
    std::vector<std::filesystem::path> exports{}; // the one to open first
};

// Keys: mesh or objects, device, frames, simulated_seconds, seconds (how long the command took), written {pictures, ids,
// video, export, record, graph, recipe}, each where it was asked for, pieces (in the export), recipe.
Json report_json(const RenderCommand& command, const Done& done, const Film& film, uint32_t frames,
                 const engine::Device& device, const Stopwatch& stopwatch) {
    Json json = done.objects > 0 ? Json{{"objects", done.objects}} : Json{{"mesh", done.name}};
    json["device"] = device.info().name;
    json["frames"] = frames;
    json["simulated_seconds"] = frames * film_frame_seconds;
    json["seconds"] = stopwatch.milliseconds() / 1000.0;
    Json& written = json["written"] = Json::object();
    if (!film.pictures().empty()) written["pictures"] = film.pictures();
    if (!film.ids().empty()) written["ids"] = film.ids();
    if (!command.video.empty()) written["video"] = command.video;
    for (const std::filesystem::path& file : done.exports) written["export"].push_back(file.string());
    if (!command.record.empty()) written["record"] = command.record;
    if (!command.graph.empty()) written["graph"] = command.graph;
    if (!command.fracture.save_recipe.empty()) written["recipe"] = command.fracture.save_recipe;
    if (!done.exports.empty()) json["pieces"] = done.pieces;
    json["recipe"] = Json::parse(recipe_json(command.fracture));
    return json;
}

void report(const RenderCommand& command, const Done& done, const Film& film, uint32_t frames,
            const engine::Device& device, const Stopwatch& stopwatch) {
    if (command.json) {
        std::printf("%s\n", text_of(report_json(command, done, film, frames, device, stopwatch), 2).c_str());
        return;
    }
    std::string text = film.summary();
    if (!done.exports.empty()) text += (text.empty() ? "" : ", and ") + written_text(done.pieces, done.exports);
    print_report("%s: %s on %s\n", done.name.c_str(), text.c_str(), device.info().name.c_str());
}

// Refuses what a scene cannot show, and warns of options of one mesh, which its objects have themselves.
void check_scene_options(const RenderCommand& command) {
    check_export_of_scene(command.fracture, command.pieces);
    const PictureOptions& picture = command.fracture.picture;
    const std::pair<bool, const char*> of_one_mesh[] = {
        {picture.whole, "whole"}, {picture.planes > 0, "planes"}, {picture.sites, "sites"}, {picture.cells, "cells"}};
    for (const auto& [given, name] : of_one_mesh)
        if (given) throw Failure(exit_usage, std::string("a scene of several objects has no picture of ") + name);
    print_idle_note(command.fracture);
}

// Loads a scene, puts it on a stage and draws it.
int render_scene(const RenderCommand& command, const FilmOptions& film_options, const Stopwatch& stopwatch) {
    const PictureOptions& picture = command.fracture.picture;
    check_scene_options(command);
    const Host host = drawing_host();
    LoadedScene scene = open_scene(command.fracture, host, nullptr, !command.pieces.output.empty());
    if (!command.fracture.save_recipe.empty()) write_recipe(command.fracture.save_recipe, command.fracture);
    const std::unique_ptr<engine::Device> device = open_device(command.view);
    const auto renderer = must(engine::Renderer::create(*device, film_settings(command.view)));
    Stage stage(*renderer, scene.home);
    std::optional<Recorder> recorder;
    if (!command.record.empty()) {
        recorder.emplace(command.record, command.fracture, program_host());
        stage.simulation().observe(&*recorder);
    }
    {
        Progress progress("preparing the scene");
        stage.stand(prepare_scene(scene, host, payload_maker(*renderer), [&](double share) { progress.update(share); }),
                    scene.world);
    }
    for (const std::string& note : scene.notes) tell("%s", note.c_str());
    stage.show_hulls(picture.hulls);
    stage.explode(picture.explode);
    stage.colour_by(picture.colours);
    stage.dust(picture.dust);
    Film film(*renderer, film_options, picture, command.view, stage.home_bounds());
    draw_frames(film, stage, picture.frames);
    if (recorder) recorder->finish();
    write_graph(command, *renderer);
    Done done{.name = std::to_string(scene.objects.size()) + " objects", .objects = scene.objects.size()};
    if (const ExportSettings& files = command.pieces; !files.output.empty()) {
        done.pieces = write_scene_state(files, pieces_as(command.pieces.as), scene, stage.simulation());
        done.exports = {files.output};
    }
    report(command, done, film, picture.frames, *device, stopwatch);
    check_validation(*device);
    return exit_success;
}

} // namespace

int run_render(const RenderCommand& command) {
    const Stopwatch stopwatch;
    const PictureOptions& picture = command.fracture.picture;
    const FilmOptions film_options{
        .output = command.output, .ids = command.ids, .every = picture.every, .video = command.video};
    check_film(film_options);
    check_run(command);
    catch_interrupts();
    if (is_scene(command.fracture)) return render_scene(command, film_options, stopwatch);
    const bool exports = !command.pieces.output.empty();
    const Input source = open_input(command.fracture, exports || wants_looks(picture)),
                input = placed_on_stage(source, command.fracture.world);
    const std::shared_ptr<const MeshLooks> looks = load_looks(source, input, picture);
    const WorldOptions world = world_of(command.fracture, input.scale);
    warn_of_idle_options(command, input, world);
    const std::unique_ptr<engine::Device> device = open_device(command.view);
    const auto renderer = must(engine::Renderer::create(*device, film_settings(command.view)));
    Stage stage(*renderer, input.model.mesh, command.fracture.material, looks);
    stage.colour_by(picture.colours);
    stage.dust(picture.dust);
    std::optional<Recorder> recorder;
    if (!command.record.empty()) {
        recorder.emplace(command.record, command.fracture, program_host());
        stage.simulation().observe(&*recorder);
    }
    std::shared_ptr<const fracture::Fragments> fragments;
    if (picture.planes > 0)
        stage.shatter(partly_cut(input, picture.planes));
    else if (!picture.whole)
        fragments = break_on_stage(command, input, world, *device, stage);
    show_extras(picture, input, stage);

    Film film(*renderer, film_options, picture, command.view, stage.home_bounds());
    const uint32_t frames = picture.whole ? 0 : picture.frames;
    draw_frames(film, stage, frames);
    if (recorder) recorder->finish();
    write_graph(command, *renderer);
    Done done{.name = input.name};
    if (exports) {
        const Snapshot state = snapshot(stage.simulation(), fragments);
        done.pieces = state.pieces.size();
        done.exports = write_state(command.pieces, pieces_as(command.pieces.as), command.fracture, source, state);
        print_split_note(command.pieces, done.exports);
    }
    report(command, done, film, frames, *device, stopwatch);
    check_validation(*device);
    return exit_success;
}

} // namespace brittle::tools

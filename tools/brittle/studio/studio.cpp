#include "tools/brittle/studio/studio.h"

#include <algorithm>
#include <array>
#include <thread>
#include <utility>

#include <imgui.h>

#include "engine/core/bitmap.h"
#include "fracture/io/export.h"
#include "fracture/io/import.h"
#include "physics/material.h"
#include "tools/brittle/base/device_failure.h"
#include "tools/brittle/base/interrupt.h"
#include "tools/brittle/pictures/picture_name.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double recorded_frame = 1.0 / 60.0;        // s
constexpr auto idle = std::chrono::milliseconds(50); // between checks of a minimised window
constexpr float exploded = 0.3f;                     // share by which the key X moves pieces apart

constexpr std::array<std::string_view, 4> video_endings{".mp4", ".mkv", ".webm", ".gif"};

// Returns the scene for a picture without panels, centred.
engine::Scene unshifted(engine::Scene scene) {
    scene.camera.shift = glm::vec2(0.0f);
    scene.region = {};
    return scene;
}

bool toggle(bool& on) {
    on = !on;
    return true;
}

} // namespace

Studio::Studio(engine::Window& window, engine::Device& device, engine::Renderer& renderer, Session& session,
               float scale)
    : window_(window), device_(device), renderer_(renderer), session_(session), scale_(scale),
      recent_files_(Recent::usual_place("recent"), max_recent_files),
      recent_materials_(Recent::usual_place("recent_materials"), max_recent_materials) {
    session_.activity().wake_by([&window] { window.wake(); });
    session_.files().opened = [this](const std::string& file) { add_file(recent_files_, file); };
    add_file(recent_files_, session_.recipe_file.empty() ? session_.recipe().mesh : session_.recipe_file);
    if (const std::string& save = session_.recipe().save_recipe; !save.empty()) session_.recipe_file = save;
    show_title();
}

glm::vec2 Studio::window_size() const {
    const ImVec2 size = ImGui::GetIO().DisplaySize; // size in the last frame, in the units of Input
    return size.x > 0.0f && size.y > 0.0f ? glm::vec2(size.x, size.y) : glm::vec2(window_.framebuffer_size());
}

float Studio::aspect() const {
    return viewport().free_aspect();
}

Viewport Studio::viewport() const {
    const glm::vec2 size = window_size();
    const Layout layout = layout_of(size, scale_, panels_.shown);
    return {navigation_.camera(Viewport::shift(size, layout.free_min, layout.free_max)), size, layout.free_min,
            layout.free_max};
}

void Studio::run() {
    Clock::time_point last = Clock::now();
    while (!window_.should_close()) {
        throw_if_interrupted();
        const engine::Input& input = window_.poll(idleness_.wait());
        const bool slow =
            ImGui::GetIO().WantTextInput || !session_.activity().message().text.empty() || session_.only_works();
        if (!idleness_.draws(input.stirred || is_lively(), slow)) {
            last = Clock::now(); // a pause does not count as a frame
            continue;
        }
        const Clock::time_point now = Clock::now();
        const double seconds = std::chrono::duration<double>(now - last).count();
        last = now;
        times_.add(seconds);
        if (seen_ != &session_.object()) {
            const bool first = seen_ == nullptr;
            seen_ = &session_.object();
            if (first) navigation_.look_as(session_.recipe().picture, session_.stage().home_bounds(), aspect());
        }
        handle(input, seconds);
        watch();
        session_.update(panels_.recording ? recorded_frame : seconds);
        if (session_.take_fracture_mark()) {
            times_.mark();
            panels_.hint = false;
        }
        const Viewport view = viewport();
        engine::Scene scene = session_.scene(view.camera());
        scene.region = {view.free_min() / view.window(), view.free_max() / view.window()};
        if (std::exchange(screenshot_due_, false)) screenshot(scene);
        if (panels_.recording)
            record(scene);
        else
            video_.reset(); // cancelled
        const bool drawn = must(renderer_.present(scene, [&] { draw(view); }));
        idleness_.took(std::chrono::duration<double>(Clock::now() - now).count());
        if (!drawn) std::this_thread::sleep_for(idle); // minimised
        take_panels();
        show_title();
    }
}

bool Studio::is_lively() const {
    const bool still = session_.quiet() || session_.only_works();
    return !still || panels_.recording || screenshot_due_ || tools_.holds() || seen_ != &session_.object();
}

void Studio::handle(const engine::Input& input, double seconds) {
    open_dropped(input, viewport(), session_);
    if (dialog_.is_open()) {
        if (input.pressed(engine::Key::escape)) dialog_.close();
        if (input.pressed(engine::Key::enter)) dialog_.confirm();
    } else if (!ImGui::GetIO().WantTextInput) {
        handle_keys(input);
    }
    const bool free = !renderer_.ui_wants_mouse() && !dialog_.is_open() && !panels_.export_open;
    tools_.handle(input, viewport(), free, session_, navigation_);
    session_.preview().held = ImGui::IsAnyMouseDown();
    if (tools_.right_held()) fly(seconds);
}

void Studio::handle_keys(const engine::Input& input) {
    for (size_t k = 0; k < input.keys.size(); ++k) {
        // While the right button is held, letters move the camera.
        const bool flies =
            tools_.right_held()
            && std::string_view("WASDQE").find(static_cast<char>(input.keys[k])) != std::string_view::npos;
        if (flies && !input.key_modifiers[k].control) continue;
        if (const auto action = command_for(input.keys[k], input.key_modifiers[k])) perform(*action);
    }
}

void Studio::fly(double seconds) {
    const auto held = [this](char key) { return window_.is_down(static_cast<engine::Key>(key)) ? 1.0f : 0.0f; };
    const glm::vec3 way(held('W') - held('S'), held('D') - held('A'), held('E') - held('Q'));
    if (way != glm::vec3(0.0f)) navigation_.fly(way, std::min(seconds, 0.1));
}

// Passes the view to the session: the part beside the panels, or the whole of a recorded picture, which has no panels.
void Studio::watch() {
    const Viewport view = viewport();
    if (panels_.recording)
        session_.watch(view.camera(), view.window().x / view.window().y);
    else
        session_.watch(view.free_camera(), view.free_aspect());
}

// Points the camera at the selected piece, or at everything.
void Studio::frame_selected() {
    std::optional<engine::Bounds> bounds;
    if (session_.piece && session_.broken()) bounds = session_.pieces().bounds(*session_.piece);
    navigation_.frame(bounds.value_or(session_.all_bounds()), aspect());
}

bool Studio::perform_view(Command action) {
    PictureOptions& view = session_.picture();
    switch (action) {
    case Command::explode:
        view.explode = view.explode > 0.0f ? 0.0f : exploded;
        return true;
    case Command::wireframe:
        return device_.has_line_mode() ? toggle(view.wireframe) : true;
    case Command::colours:
        view.colours = session_.stage().shows_materials() ? PieceColours::pieces : PieceColours::materials;
        return true;
    case Command::smooth:
        return toggle(view.smooth);
    case Command::hulls:
        return toggle(view.hulls);
    case Command::cells:
        return toggle(view.cells);
    case Command::sites:
        return toggle(view.sites);
    case Command::bonds:
        return toggle(session_.bonds);
    case Command::help:
        return toggle(panels_.help);
    case Command::panels:
        return toggle(panels_.shown);
    case Command::page_up:
        panels_.roll(-1);
        return true;
    case Command::page_down:
        panels_.roll(1);
        return true;
    case Command::screenshot:
        screenshot_due_ = true;
        return true;
    case Command::frame:
        frame_selected();
        return true;
    default:
        return false;
    }
}

void Studio::perform(Command action) {
    if (perform_view(action)) return;
    const auto tool = static_cast<size_t>(action) - static_cast<size_t>(Command::tool_inspect);
    if (tool < all_tools.size()) {
        tools_.choose(all_tools[tool], session_);
        return;
    }
    if (const auto mode = static_cast<size_t>(action) - static_cast<size_t>(Command::gizmo_move); mode < 3) {
        tools_.choose(static_cast<GizmoMode>(mode));
        return;
    }
    const auto material = static_cast<size_t>(action) - static_cast<size_t>(Command::material_1);
    if (material < physics::material_presets().size()) {
        const std::string name(physics::material_presets()[material].name);
        recent_materials_.add(name);
        if (session_.object().is_scene())
            session_.change_selected([&](SceneObject& object) { use_material(name, object.recipe); });
        else
            session_.edit(SetMaterial{name});
        return;
    }
    switch (action) {
    case Command::break_all:
        session_.break_all();
        break;
    case Command::reset:
        session_.reset();
        break;
    case Command::pause:
        session_.playback.paused = !session_.playback.paused;
        break;
    case Command::step:
        session_.step_once();
        break;
    case Command::undo:
        session_.undo();
        break;
    case Command::redo:
        session_.redo();
        break;
    case Command::remove:
        tools_.remove_selected(session_);
        break;
    case Command::duplicate:
        tools_.duplicate_selected(session_);
        break;
    case Command::mirror:
        tools_.mirror_selected(session_, 0);
        break;
    case Command::open:
        ask(Asked::open);
        break;
    case Command::save:
        if (session_.recipe_file.empty())
            ask(Asked::recipe);
        else
            answer_recipe(session_.recipe_file);
        break;
    case Command::export_dialog:
        panels_.export_open = !panels_.export_open;
        break;
    case Command::quit:
        quit_or_close();
        break;
    default:
        break;
    }
}

void Studio::quit_or_close() {
    if (panels_.export_open)
        panels_.export_open = false;
    else if (panels_.help)
        panels_.help = false;
    else
        window_.close();
}

void Studio::draw(const Viewport& view) {
    const PanelState state{.session = session_,
                           .tools = tools_,
                           .times = times_,
                           .renderer = renderer_,
                           .recent_files = recent_files_,
                           .recent_materials = recent_materials_,
                           .device = device_.info().name,
                           .has_line_mode = device_.has_line_mode(),
                           .scale = scale_,
                           .window = window_size()};
    panels_.draw(state, tools_.overlay(view, session_));
    if (const auto file = dialog_.draw(scale_)) answer(*file);
}

void Studio::take_panels() {
    for (const Command action : panels_.take_actions()) perform(action);
    switch (panels_.take_export()) {
    case Panels::ExportKind::pieces:
        ask(Asked::pieces);
        break;
    case Panels::ExportKind::recipe:
        ask(Asked::recipe);
        break;
    case Panels::ExportKind::screenshot:
        screenshot_due_ = true;
        break;
    case Panels::ExportKind::replay:
        ask(Asked::replay);
        break;
    case Panels::ExportKind::sequence:
        ask(Asked::sequence);
        break;
    case Panels::ExportKind::none:
        break;
    }
}

void Studio::ask(Asked what) {
    asked_ = what;
    const std::string name = session_.name();
    const std::filesystem::path beside = std::filesystem::path(session_.recipe_file).parent_path();
    const std::filesystem::path folder = beside.empty() ? "." : beside;
    std::vector<std::string> meshes = fracture::importable_extensions();
    meshes.emplace_back(".json");
    switch (what) {
    case Asked::open:
        dialog_.open("Open a mesh or a recipe", folder, "", std::move(meshes), false);
        break;
    case Asked::recipe:
        dialog_.open("Save the recipe", folder, name + ".json", {".json"}, true);
        break;
    case Asked::pieces:
        dialog_.open("Export the pieces", folder, name + "_pieces.glb", fracture::exportable_extensions(), true);
        break;
    case Asked::replay:
        dialog_.open("Save the replay log", folder, name + ".log", {".log"}, true);
        break;
    case Asked::sequence:
        dialog_.open("Write pictures or a video", folder, name + "_%04d.png", {".png", ".mp4", ".mkv", ".webm", ".gif"},
                     true);
        break;
    }
}

void Studio::answer_recipe(const std::string& file) {
    navigation_.tell(session_.picture(), session_.stage().home_bounds(), aspect());
    session_.files().save_recipe(file);
}

void Studio::answer(const std::filesystem::path& file) {
    switch (asked_) {
    case Asked::open:
        session_.files().open(file.string());
        break;
    case Asked::recipe:
        answer_recipe(file.extension() == ".json" ? file.string() : file.string() + ".json");
        break;
    case Asked::pieces:
        session_.files().export_pieces(file, session_.broken() ? panels_.pieces_as : PiecesAs::made);
        break;
    case Asked::replay:
        session_.files().save_replay(file);
        break;
    case Asked::sequence:
        begin_recording(file.string());
        break;
    }
}

void Studio::screenshot(const engine::Scene& scene) {
    const glm::uvec2 size = window_.framebuffer_size();
    if (size.x == 0 || size.y == 0) return;
    const std::string file = unused_name(session_.name() + "_%03d.png");
    const auto image = renderer_.render(unshifted(scene), size);
    const auto written = image ? engine::write_png(*image, file) : engine::Result<void>(image.error());
    if (written)
        session_.activity().say({"wrote " + file});
    else
        session_.activity().say({written.error().message, true});
}

void Studio::begin_recording(const std::string& file) {
    const std::string ending = std::filesystem::path(file).extension().string();
    const bool video = std::find(video_endings.begin(), video_endings.end(), ending) != video_endings.end();
    if (!video && !is_numbered(file)) {
        session_.activity().say(
            {"'" + file + "' needs %04d where the frame's number is to go, or the ending of a video, such as .mp4",
             true});
        return;
    }
    sequence_ = file;
    recorded_size_ = window_.framebuffer_size();
    video_ = video ? std::make_shared<Video>(file, 1.0 / recorded_frame) : nullptr;
    panels_.recording = Recording{0, static_cast<uint32_t>(panels_.sequence_frames)};
}

void Studio::record(const engine::Scene& scene) {
    Recording& recording = *panels_.recording;
    try {
        const engine::Bitmap image = must(renderer_.render(unshifted(scene), recorded_size_));
        if (video_)
            video_->add(image);
        else
            must(engine::write_png(image, picture_name(sequence_, recording.done)));
    } catch (const Failure& failure) {
        if (failure.code() == exit_environment) throw;
        panels_.recording.reset();
        session_.activity().say({failure.what(), true});
        return;
    }
    if (++recording.done == recording.total) end_recording();
}

void Studio::end_recording() {
    const Recording recorded = *std::exchange(panels_.recording, std::nullopt);
    if (video_)
        session_.files().finish_video(std::exchange(video_, nullptr), sequence_);
    else
        session_.activity().say(
            {std::to_string(recorded.total) + " pictures, the last " + picture_name(sequence_, recorded.total - 1)});
}

void Studio::show_title() {
    std::string title = "Brittle: " + session_.name() + ", ";
    if (session_.object().is_scene())
        title += session_.playing() ? "playing" : "editing";
    else if (session_.broken() && session_.counts())
        title += std::to_string(session_.counts()->pieces) + " pieces";
    else
        title += "whole";
    if (title == title_) return;
    title_ = std::move(title);
    window_.set_title(title_);
}

} // namespace brittle::tools

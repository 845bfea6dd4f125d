#include "tools/brittle/studio/panels.h"

#include <algorithm>
#include <cstdio>

#include <imgui.h>

#include "tools/brittle/studio/style.h"
#include "tools/brittle/studio/widgets.h"

namespace brittle::tools {

namespace {

constexpr float column = 276.0f; // widths and heights in pixels at scale 1
constexpr float min_column = 220.0f;
constexpr float bar_height = 42.0f;
constexpr float line_height = 26.0f;
constexpr float min_scene = 400.0f;        // width of the scene that columns leave free, and that the tools need
constexpr float two_help_columns = 760.0f; // width that the help sheet needs for two columns

// Height of the largest tool panel, reserved for all tools so that the panels below stay in place. A single column has
// no room to reserve.
constexpr float tool_rows = 4.0f;

constexpr double message_seconds = 5.0; // time after which messages without a fault disappear

constexpr ImGuiWindowFlags docked = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove
                                    | ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus
                                    | ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav;
constexpr ImGuiWindowFlags sheet = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize
                                   | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings
                                   | ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav;

ImVec2 at(glm::vec2 p) {
    return {p.x, p.y};
}

struct ButtonLook {
    ImU32 colour, hovered, text;
};
constexpr ButtonLook active_look{IM_COL32(236, 142, 66, 255), IM_COL32(236, 142, 66, 255), IM_COL32(24, 20, 16, 255)};
constexpr ButtonLook break_look{IM_COL32(120, 70, 36, 255), IM_COL32(158, 92, 42, 255), IM_COL32(240, 236, 230, 255)};

// Widths of the buttons of the bar: the room beside names and keys is divided equally. Keys are omitted if there is no
// room for them.
struct BarPlan {
    explicit BarPlan(float scale) : gap(6.0f * scale), between(10.0f * scale) {
        float names = key_button_width("Break", "") + key_button_width("Reset", "");
        float keys = key_button_width("Break", "Space") + key_button_width("Reset", "R");
        for (const Tool tool : all_tools) {
            const std::string name(info_of(tool).name);
            names += key_button_width(name, "");
            keys += key_button_width(name, info_of(tool).key);
        }
        const float buttons = static_cast<float>(all_tools.size()) + 2.0f;
        const float room = ImGui::GetContentRegionAvail().x - (buttons - 1.0f) * gap - between;
        with_keys = room - keys >= buttons * min_padding * scale;
        padding = std::max((room - (with_keys ? keys : names)) / buttons, 0.0f);
    }
    [[nodiscard]] bool button(const std::string& name, const char* key, const ButtonLook* look) const {
        const std::string shown = with_keys ? key : "";
        if (look) {
            ImGui::PushStyleColor(ImGuiCol_Button, look->colour);
            ImGui::PushStyleColor(ImGuiCol_ButtonHovered, look->hovered);
        }
        const bool pressed = key_button(name, shown, key_button_width(name, shown) + padding,
                                        look ? look->text : ImGui::GetColorU32(ImGuiCol_Text));
        if (look) ImGui::PopStyleColor(2);
        return pressed;
    }

    static constexpr float min_padding = 12.0f; // pixels at scale 1
    float gap, between;                         // between buttons; between the tools and the other buttons
    float padding = 0.0f;
    bool with_keys = false;
};

// Returns the description of a tool, with its details if there is room. The button's tip shows all of it.
std::string fitting_hint(const ToolInfo& info) {
    const std::string hint = info.hint, brief = hint.substr(0, hint.find(" ("));
    const float room = ImGui::GetContentRegionAvail().x;
    for (const std::string& text : {std::string(info.name) + ": " + hint, std::string(info.name) + ": " + brief})
        if (ImGui::CalcTextSize(text.c_str()).x <= room) return text;
    return brief;
}

void draw_overlay(const Overlay& overlay, float scale) {
    const StudioColours colours;
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    for (const Overlay::Axis& axis : overlay.axes) {
        const float width = (axis.strong ? 4.0f : 2.5f) * scale;
        list.AddLine(at(axis.from), at(axis.to), colours.outline, width + 2.0f * scale);
        list.AddLine(at(axis.from), at(axis.to), colours.axis[axis.axis], width);
        const float end = (axis.strong ? 6.0f : 5.0f) * scale;
        if (axis.scales)
            list.AddRectFilled({axis.to.x - end, axis.to.y - end}, {axis.to.x + end, axis.to.y + end},
                               colours.axis[axis.axis]);
        else
            list.AddCircleFilled(at(axis.to), end, colours.axis[axis.axis]);
    }
    for (const Overlay::Ring& ring : overlay.rings) {
        std::vector<ImVec2> points;
        for (const glm::vec2& p : ring.points) points.push_back(at(p));
        const float width = (ring.strong ? 4.0f : 2.5f) * scale;
        const auto count = static_cast<int>(points.size());
        list.AddPolyline(points.data(), count, colours.outline, ImDrawFlags_None, width + 2.0f * scale);
        list.AddPolyline(points.data(), count, colours.axis[ring.axis], ImDrawFlags_None, width);
    }
    if (overlay.middle) {
        const float half = (overlay.middle->strong ? 8.0f : 6.5f) * scale;
        const glm::vec2 middle = overlay.middle->at;
        const ImVec2 low{middle.x - half, middle.y - half}, high{middle.x + half, middle.y + half};
        const float rounding = overlay.middle->scales ? 0.0f : half;
        list.AddRectFilled(low, high, IM_COL32(244, 244, 246, 255), rounding);
        list.AddRect(low, high, colours.outline, rounding, 0, 1.5f * scale);
    }
    if (overlay.box) {
        const ImVec2 from = at((*overlay.box)[0]), to = at((*overlay.box)[1]);
        const ImVec2 low{std::min(from.x, to.x), std::min(from.y, to.y)},
            high{std::max(from.x, to.x), std::max(from.y, to.y)};
        list.AddRectFilled(low, high, IM_COL32(236, 142, 66, 36));
        list.AddRect(low, high, colours.accent, 0.0f, 0, 1.5f * scale);
    }
    if (!overlay.text.empty()) {
        const ImVec2 mouse = ImGui::GetIO().MousePos, size = ImGui::CalcTextSize(overlay.text.c_str());
        const ImVec2 low{mouse.x + 16.0f * scale, mouse.y + 14.0f * scale};
        const float pad = 5.0f * scale;
        list.AddRectFilled({low.x - pad, low.y - pad}, {low.x + size.x + pad, low.y + size.y + pad},
                           IM_COL32(24, 24, 28, 220), 4.0f * scale);
        list.AddText(low, IM_COL32(240, 236, 230, 255), overlay.text.c_str());
    }
    for (const Overlay::Spot& spot : overlay.spots) {
        list.AddCircleFilled(at(spot.centre), spot.radius, colours.anchor);
        list.AddCircle(at(spot.centre), spot.radius, colours.anchor_rim, 0, 1.5f * scale);
    }
    for (const glm::vec2& site : overlay.idle) { // a grey cross through the mark
        const float arm = 5.0f * scale;
        for (const float side : {-arm, arm}) {
            list.AddLine({site.x - arm, site.y - side}, {site.x + arm, site.y + side}, colours.outline, 4.0f * scale);
            list.AddLine({site.x - arm, site.y - side}, {site.x + arm, site.y + side}, colours.idle, 2.0f * scale);
        }
    }
    for (const Overlay::Circle& circle : overlay.circles) {
        list.AddCircle(at(circle.centre), circle.radius, colours.outline, 0, 4.0f * scale);
        list.AddCircle(at(circle.centre), circle.radius, circle.strong ? colours.accent : colours.accent_soft, 0,
                       2.0f * scale);
    }
    if (overlay.string) {
        list.AddLine(at((*overlay.string)[0]), at((*overlay.string)[1]), colours.accent, 2.0f * scale);
        list.AddCircleFilled(at((*overlay.string)[0]), 4.0f * scale, colours.accent);
    }
}

} // namespace

Layout layout_of(glm::vec2 window, float scale, bool panels) {
    Layout layout;
    layout.free_max = window;
    if (!panels) return layout;
    const float spare = window.x / scale - min_scene; // room for columns
    if (window.y >= 300.0f * scale) {
        const bool both = spare >= 2.0f * min_column;
        if (spare >= min_column) layout.left = scale * std::min(both ? 0.5f * spare : spare, column);
        if (both) layout.right = layout.left;
    }
    if (spare >= 0.0f && window.y >= 240.0f * scale) {
        layout.top = bar_height * scale;
        layout.bottom = line_height * scale;
    }
    layout.free_min = {layout.left, layout.top};
    layout.free_max = window - glm::vec2(layout.right, layout.bottom);
    return layout;
}

void Panels::edit(Session& session, const Edit& edit) {
    if (gesture_ == 0) gesture_ = session.begin_gesture();
    session.edit(edit, gesture_);
}

void Panels::draw(const PanelState& state, const Overlay& overlay) {
    if (!ImGui::IsAnyItemActive()) gesture_ = 0;
    const Layout layout = layout_of(state.window, state.scale, shown);
    draw_overlay(overlay, state.scale);
    if (layout.left > 0.0f) left_column(state, layout);
    if (layout.right > 0.0f) right_column(state, layout);
    if (layout.top > 0.0f) {
        bar(state, layout);
        state_line(state, layout);
    }
    message(state, layout);
    progress(state, layout);
    if (help) help_sheet(state);
    if (export_open) export_window(state);
    pages_ = 0;
}

void Panels::roll_window() const {
    constexpr float page = 0.8f; // share of the window's height, so that some lines stay visible
    if (pages_ == 0) return;
    const float to = ImGui::GetScrollY() + page * static_cast<float>(pages_) * ImGui::GetWindowHeight();
    ImGui::SetScrollY(std::clamp(to, 0.0f, ImGui::GetScrollMaxY()));
}

void Panels::left_column(const PanelState& state, const Layout& layout) {
    ImGui::SetNextWindowPos({0.0f, 0.0f});
    ImGui::SetNextWindowSize({layout.left, state.window.y});
    ImGui::Begin("left", nullptr, docked & ~ImGuiWindowFlags_NoScrollbar);
    const bool alone = layout.right == 0.0f;
    object_panel(state);
    if (alone) tool_panel(state, 0.0f);
    if (state.session.object().is_scene()) {
        scene_panel(state);
    } else {
        pattern_panel(state);
        material_panel(state);
        cuts_panel(state);
    }
    if (alone) {
        simulation_panel(state);
        view_panel(state);
        statistics_panel(state);
    }
    if (!help) roll_window();
    ImGui::End();
}

void Panels::right_column(const PanelState& state, const Layout& layout) {
    ImGui::SetNextWindowPos({state.window.x - layout.right, 0.0f});
    ImGui::SetNextWindowSize({layout.right, state.window.y});
    ImGui::Begin("right", nullptr, docked & ~ImGuiWindowFlags_NoScrollbar);
    tool_panel(state, tool_rows);
    simulation_panel(state);
    view_panel(state);
    statistics_panel(state);
    if (!help) roll_window();
    ImGui::End();
}

void Panels::bar(const PanelState& state, const Layout& layout) {
    ImGui::SetNextWindowPos({layout.left, 0.0f});
    ImGui::SetNextWindowSize({layout.free_max.x - layout.free_min.x, layout.top});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {8.0f * state.scale, 8.0f * state.scale});
    ImGui::Begin("tools", nullptr, docked | ImGuiWindowFlags_NoScrollWithMouse);
    const BarPlan plan(state.scale);
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {plan.gap, 0.0f});
    for (const Tool tool : all_tools) {
        const ToolInfo& info = info_of(tool);
        const std::string name(info.name);
        const bool active = state.tools.tool() == tool;
        if (plan.button(name, info.key, active ? &active_look : nullptr)) state.tools.choose(tool, state.session);
        tip((std::string(info.hint) + " [" + info.key + "]").c_str());
        ImGui::SameLine();
    }
    ImGui::SetCursorPosX(ImGui::GetCursorPosX() + plan.between);
    const bool scene = state.session.object().is_scene(), playing = state.session.playing();
    if (plan.button(scene ? "Play" : "Break", "Space", scene && playing ? &active_look : &break_look))
        actions_.push_back(Command::break_all);
    if (scene)
        tip(playing ? "The scene is played; Reset puts it back" : "Let time begin (Space)");
    else
        tip(playing ? "The mesh is broken; Reset makes it whole again"
                    : "Break the mesh by the pattern or the sites (Space)");
    ImGui::SameLine();
    if (plan.button("Reset", "R", nullptr)) actions_.push_back(Command::reset);
    tip(scene ? "Put all objects back to their places, whole (R)" : "Make the mesh whole again (R)");
    ImGui::PopStyleVar();
    ImGui::End();
    ImGui::PopStyleVar();
}

void Panels::state_line(const PanelState& state, const Layout& layout) {
    ImGui::SetNextWindowPos({layout.left, layout.free_max.y});
    ImGui::SetNextWindowSize({layout.free_max.x - layout.free_min.x, layout.bottom});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {8.0f * state.scale, 4.0f * state.scale});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1.0f, 1.0f});
    ImGui::Begin("state", nullptr, docked | ImGuiWindowFlags_NoScrollWithMouse);
    const ToolInfo& info = info_of(state.tools.tool());
    ImGui::TextDisabled("%s", fitting_hint(info).c_str());
    const char* keys = state.session.playback.paused ? "paused (P)" : "H: keys";
    const float width = ImGui::CalcTextSize(keys).x;
    const float at_x = ImGui::GetWindowWidth() - width - 8.0f * state.scale;
    ImGui::SameLine();
    if (ImGui::GetCursorPosX() < at_x) {
        ImGui::SetCursorPosX(at_x);
        ImGui::TextDisabled("%s", keys);
    }
    ImGui::End();
    ImGui::PopStyleVar(2);
}

void Panels::message(const PanelState& state, const Layout& layout) {
    const Message& message = state.session.activity().message();
    if (message.text != told_) {
        told_ = message.text;
        told_at_ = ImGui::GetTime();
    }
    if (!told_.empty() && !message.fault && ImGui::GetTime() - told_at_ > message_seconds)
        state.session.activity().say({});
    const bool hints = hint && state.tools.tool() == Tool::inspect && !state.session.playing() && message.text.empty()
                       && layout.top > 0.0f;
    if (message.text.empty() && !hints) return;
    const float middle = 0.5f * (layout.free_min.x + layout.free_max.x);
    const float width = std::min(0.9f * (layout.free_max.x - layout.free_min.x), 520.0f * state.scale);
    ImGui::SetNextWindowPos({middle, layout.free_max.y - 12.0f * state.scale}, ImGuiCond_Always, {0.5f, 1.0f});
    ImGui::SetNextWindowBgAlpha(0.92f);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 6.0f * state.scale);
    ImGui::Begin("message", nullptr, hints ? sheet | ImGuiWindowFlags_NoInputs : sheet);
    if (hints) {
        ImGui::PushTextWrapPos(width);
        ImGui::TextUnformatted(state.session.object().is_scene()
                                   ? "Space plays the scene; F3 and a click strike an object with a hammer."
                                   : "Space breaks it all; F3 and a click strike it with a hammer.");
        ImGui::PopTextWrapPos();
    } else {
        ImGui::PushTextWrapPos(width);
        if (message.fault) ImGui::TextColored({0.98f, 0.52f, 0.42f, 1.0f}, "That did not work");
        ImGui::TextUnformatted(message.text.c_str());
        ImGui::PopTextWrapPos();
        const std::string mend = message.mend;
        bool close = false;
        if (!mend.empty()) {
            if (ImGui::Button("Mend and open")) {
                state.session.activity().say({});
                state.session.files().open(mend, true);
            }
            ImGui::SameLine();
        }
        if (ImGui::Button("Close")) close = true;
        if (close) state.session.activity().say({});
    }
    ImGui::End();
    ImGui::PopStyleVar();
}

void Panels::progress(const PanelState& state, const Layout& layout) {
    constexpr double patience = 0.3; // s; work that is done sooner shows no bar
    const auto work = state.session.activity().work();
    if (!work) worked_since_ = ImGui::GetTime();
    if (!recording && (!work || ImGui::GetTime() - worked_since_ < patience)) return;
    const float middle = 0.5f * (layout.free_min.x + layout.free_max.x);
    ImGui::SetNextWindowPos({middle, layout.free_min.y + 12.0f * state.scale}, ImGuiCond_Always, {0.5f, 0.0f});
    ImGui::SetNextWindowBgAlpha(0.92f);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 6.0f * state.scale);
    ImGui::Begin("progress", nullptr, sheet);
    const float share = recording
                            ? static_cast<float>(recording->done) / static_cast<float>(std::max(recording->total, 1u))
                            : static_cast<float>(work->share);
    ImGui::TextUnformatted(recording ? "writing pictures" : work->what.c_str());
    ImGui::ProgressBar(std::max(share, 0.0f), {220.0f * state.scale, 0.0f}, share < 0.0f ? "..." : nullptr);
    ImGui::SameLine();
    if (ImGui::Button("Cancel")) recording ? recording.reset() : state.session.activity().cancel();
    ImGui::End();
    ImGui::PopStyleVar();
}

void Panels::help_sheet(const PanelState& state) {
    ImGui::SetNextWindowPos({0.5f * state.window.x, 0.5f * state.window.y}, ImGuiCond_Always, {0.5f, 0.5f});
    ImGui::SetNextWindowBgAlpha(0.97f);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 6.0f * state.scale);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 1.0f);
    ImGui::SetNextWindowSizeConstraints({0.0f, 0.0f}, at(state.window));
    ImGui::Begin("help", nullptr, sheet & ~ImGuiWindowFlags_NoScrollbar);
    std::vector<std::pair<const char*, const char*>> lines;
    for (const MouseHelp& line : mouse_help()) lines.emplace_back(line.shown, line.what);
    for (const KeyBinding& binding : key_bindings())
        if (*binding.shown) lines.emplace_back(binding.shown, binding.what);
    // Lines run down the first of two columns and then the second; a narrow window has one column.
    const size_t columns = state.window.x >= two_help_columns * state.scale ? 2 : 1;
    const size_t half = (lines.size() + columns - 1) / columns;
    if (ImGui::BeginTable(columns == 2 ? "keys" : "keys below each other", static_cast<int>(2 * columns),
                          ImGuiTableFlags_PadOuterX)) {
        for (size_t k = 0; k < columns * half; ++k) {
            const size_t at = k / columns + (k % columns) * half;
            ImGui::TableNextColumn();
            if (at < lines.size()) ImGui::TextColored({0.93f, 0.62f, 0.36f, 1.0f}, "%s", lines[at].first);
            ImGui::TableNextColumn();
            if (at < lines.size()) ImGui::TextUnformatted(lines[at].second);
        }
        ImGui::EndTable();
    }
    roll_window();
    ImGui::End();
    ImGui::PopStyleVar(2);
}

void Panels::piece_options(Session& session) {
    ImGui::BeginDisabled(!session.broken());
    const auto as = [this](const char* name, const char* tip_text, PiecesAs what) {
        if (ImGui::RadioButton(name, pieces_as == what)) pieces_as = what;
        tip(tip_text);
    };
    as("as they lie", "Pieces in their current poses", PiecesAs::they_lie);
    ImGui::SameLine();
    as("as made", "Pieces where they were cut; together they form the mesh", PiecesAs::made);
    ImGui::EndDisabled();
    control("Hulls", "GLB only: collision hulls, under the names that this engine recognises");
    const std::string& now = session.exports().hulls;
    if (ImGui::BeginCombo("##Hulls", now.empty() ? "none" : now.c_str())) {
        for (const char* name : {"", "godot", "unreal"})
            if (ImGui::Selectable(*name ? name : "none", now == name)) session.exports().hulls = name;
        ImGui::EndCombo();
    }
    ImGui::Separator();
}

void Panels::export_window(const PanelState& state) {
    ImGui::SetNextWindowPos({0.5f * state.window.x, 0.5f * state.window.y}, ImGuiCond_Always, {0.5f, 0.5f});
    ImGui::SetNextWindowSize({330.0f * state.scale, 0.0f});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 6.0f * state.scale);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 1.0f);
    ImGui::Begin("Export", &export_open,
                 ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove
                     | ImGuiWindowFlags_NoSavedSettings);
    const auto choice = [this](const char* name, const char* tip_text, ExportKind kind) {
        if (!wide_button(name, tip_text)) return;
        export_ = kind;
        export_open = false;
    };
    const bool broken = state.session.broken();
    choice("Pieces: GLB, OBJ, PLY or STL ...",
           broken ? "The pieces on the stage, with all cuts made by blows, for other programs"
                  : "The pieces of the recipe, as `brittle fracture` writes them, for other programs",
           ExportKind::pieces);
    piece_options(state.session);
    choice("Recipe ...", "Mesh and options; `brittle render` and `brittle fracture` read it, too", ExportKind::recipe);
    choice("Screenshot", "The view without panels, as PNG in the current folder (F12)", ExportKind::screenshot);
    ImGui::BeginDisabled(!state.session.broken());
    choice("Replay log ...",
           state.session.broken() ? "The run since the break; `brittle replay` repeats it and makes pictures of it"
                                  : "Available once the mesh is broken",
           ExportKind::replay);
    ImGui::EndDisabled();
    ImGui::Separator();
    control("Frames", "Number of frames in the sequence; 60 per second");
    char frames[32];
    std::snprintf(frames, sizeof frames, "%%d (%.1f s)", sequence_frames / 60.0);
    (void)slider("##frames", sequence_frames, 1, 600, frames);
    choice("Picture sequence or video ...",
           "Frames from now on: one PNG each, or a video for a name that ends with .mp4, which needs ffmpeg",
           ExportKind::sequence);
    ImGui::End();
    ImGui::PopStyleVar(2);
}

} // namespace brittle::tools

// The left column: what is broken, and how.
#include <algorithm>
#include <array>
#include <filesystem>
#include <string>

#include <imgui.h>

#include "fracture/shapes.h"
#include "physics/material.h"
#include "tools/brittle/studio/panels.h"
#include "tools/brittle/studio/style.h"

namespace brittle::tools {

namespace {

using fracture::Pattern;
using fracture::PatternKind;

constexpr std::array kind_tips{
    "At random: anything",
    "Most of them near the focus: what was hit at one place",
    "Rings and rays around the axis: glass",
    "Boxes: tiles, blocks",
    "Running bond: walls",
    "Slabs across the axis: slate, bread",
    "Long along the axis: wood, ice",
    "A crack along a line, deep along the axis",
    "Where the surface bends most: edges and corners chip first",
    "Small where the solid is thin, large where it is thick",
};

bool slider(const char* name, const char* tip_text, double& value, double low, double high, const char* format,
            ImGuiSliderFlags flags = 0) {
    control(name, tip_text);
    auto shown = static_cast<float>(value);
    const bool changed = ImGui::SliderFloat((std::string("##") + name).c_str(), &shown, static_cast<float>(low), static_cast<float>(high), format, flags | ImGuiSliderFlags_AlwaysClamp);
    if (changed) value = shown;
    return changed;
}

bool vector(const char* name, const char* tip_text, glm::dvec3& value, float low, float high) {
    control(name, tip_text);
    float shown[3] = {static_cast<float>(value.x), static_cast<float>(value.y), static_cast<float>(value.z)};
    const bool changed = ImGui::SliderFloat3((std::string("##") + name).c_str(), shown, low, high, "%.2f", ImGuiSliderFlags_AlwaysClamp);
    if (changed) value = {shown[0], shown[1], shown[2]};
    return changed;
}

bool has_axis(PatternKind kind) {
    return kind == PatternKind::radial || kind == PatternKind::slices || kind == PatternKind::splinters || kind == PatternKind::curve;
}

bool has_focus(PatternKind kind) {
    return kind == PatternKind::clustered || kind == PatternKind::radial;
}

bool pattern_kind(Pattern& pattern) {
    const auto names = fracture::pattern_names();
    control("Kind", "How the sites lie");
    bool changed = false;
    if (!ImGui::BeginCombo("##Kind", std::string(names[static_cast<size_t>(pattern.kind)]).c_str())) return false;
    for (size_t k = 0; k < names.size(); ++k) {
        if (ImGui::Selectable(std::string(names[k]).c_str(), static_cast<size_t>(pattern.kind) == k)) {
            pattern.kind = static_cast<PatternKind>(k);
            changed = true;
        }
        tip(kind_tips[k]);
    }
    ImGui::EndCombo();
    return changed;
}

bool count_and_seed(Pattern& pattern) {
    bool changed = false;
    control("Pieces", "How many sites; those outside the solid give no piece");
    auto count = static_cast<int>(pattern.count);
    if (ImGui::SliderInt("##Pieces", &count, 2, 1000, "%d", ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_Logarithmic)) {
        pattern.count = static_cast<uint32_t>(count);
        pattern.piece_size = 0.0;
        changed = true;
    }
    control("Seed", "Of what is random: equal seeds, equal pieces");
    auto seed = static_cast<int>(std::min<uint64_t>(pattern.seed, 1'000'000));
    if (ImGui::InputInt("##Seed", &seed)) {
        pattern.seed = static_cast<uint64_t>(std::clamp(seed, 0, 1'000'000));
        changed = true;
    }
    return changed;
}

} // namespace

void Panels::object_panel(const PanelState& state) {
    Session& session = state.session;
    const Object& object = session.object();
    ImGui::PushStyleColor(ImGuiCol_Text, StudioColours{}.accent);
    ImGui::TextUnformatted("Brittle");
    ImGui::PopStyleColor();
    ImGui::SameLine();
    ImGui::TextDisabled("%s%s", object.name().c_str(), session.document().saved() ? "" : " (changed)");
    if (!begin_panel("Object")) return;
    control("Mesh", "What to break; drop a file on the window, or open one");
    if (ImGui::BeginCombo("##Mesh", object.name().c_str())) {
        if (ImGui::Selectable("open a file ...")) actions_.push_back(Command::open);
        if (!state.recent.files().empty()) ImGui::Separator();
        for (const std::string& file : state.recent.files()) {
            if (ImGui::Selectable((std::filesystem::path(file).filename().string() + "##" + file).c_str())) session.open(file);
            tip(file.c_str());
        }
        ImGui::Separator();
        for (const std::string_view name : fracture::shape_names())
            if (ImGui::Selectable(std::string(name).c_str())) session.open("shape:" + std::string(name));
        ImGui::EndCombo();
    }
    const glm::dvec3 size = fracture::bounds(object.file().model.mesh).size();
    ImGui::TextDisabled("%zu triangles, %.3g x %.3g x %.3g m", object.mesh().triangles.size(), size.x, size.y, size.z);
    if (wide_button("Open", "A mesh or a recipe (Ctrl+O)", 1.0f / 3.0f)) actions_.push_back(Command::open);
    ImGui::SameLine();
    if (wide_button("Save", "The recipe (Ctrl+S)", 0.5f)) actions_.push_back(Command::save);
    ImGui::SameLine();
    if (wide_button("Export", "Pieces, recipe, pictures (Ctrl+E)")) actions_.push_back(Command::export_dialog);
    const Document& document = session.document();
    if (wide_button("Undo", ("Ctrl+Z: " + std::string(document.undo_name())).c_str(), 0.5f)) actions_.push_back(Command::undo);
    ImGui::SameLine();
    if (wide_button("Redo", ("Ctrl+Shift+Z: " + std::string(document.redo_name())).c_str())) actions_.push_back(Command::redo);
}

void Panels::pattern_panel(const PanelState& state) {
    if (!begin_panel("Pattern")) return;
    Session& session = state.session;
    Pattern pattern = session.recipe().pattern;
    bool changed = pattern_kind(pattern);
    changed |= count_and_seed(pattern);
    if (has_focus(pattern.kind)) changed |= vector("Focus", "Where it is densest, 0 to 1 along each side of the mesh's box", pattern.focus, 0.0f, 1.0f);
    if (has_axis(pattern.kind)) {
        glm::dvec3 axis = pattern.axis;
        if (vector("Axis", "The direction of shards, slices and splinters", axis, -1.0f, 1.0f) && axis != glm::dvec3(0.0)) {
            pattern.axis = axis;
            changed = true;
        }
    }
    if (pattern.kind == PatternKind::clustered) changed |= slider("Spread", "Share of the mesh's size", pattern.spread, 0.02, 1.0, "%.2f");
    if (pattern.kind == PatternKind::splinters) changed |= slider("Slenderness", "Length by width", pattern.slenderness, 1.0, 40.0, "%.0f");
    double jitter = std::max(pattern.jitter, 0.0);
    if (slider("Jitter", "How irregular it is", jitter, 0.0, 1.0, pattern.jitter < 0.0 ? "its own" : "%.2f")) {
        pattern.jitter = jitter;
        changed = true;
    }
    if (pattern.kind != PatternKind::bricks) changed |= slider("Grading", "0: pieces of like sizes; 1: from crumbs to lumps", pattern.grading, 0.0, 1.0, "%.2f");
    control("Inside only", "Only sites inside the solid, so that each makes a piece");
    changed |= ImGui::Checkbox("##Inside only", &pattern.inside);
    if (!changed) return;
    session.picture().cells = true; // one sees what one does
    edit(session, SetPattern{pattern});
}

void Panels::sites_panel(const PanelState& state) {
    Session& session = state.session;
    const bool by_hand = !session.recipe().points.empty();
    if (!begin_panel("Sites", false)) return;
    ImGui::TextDisabled("%zu %s, %zu selected", session.sites().size(), by_hand ? "placed by hand" : "by the pattern", session.selection.size());
    if (wide_button("Delete", "The selected sites (Del)", 1.0f / 2.0f)) actions_.push_back(Command::remove);
    ImGui::SameLine();
    if (wide_button("Duplicate", "The selected sites, a little beside (Ctrl+D)")) actions_.push_back(Command::duplicate);
    constexpr const char* mirrors[] = {"Mirror X", "Mirror Y", "Mirror Z"};
    for (int axis = 0; axis < 3; ++axis) {
        if (wide_button(mirrors[axis], "Adds the mirror images of the selected sites, or of all, across the middle of the mesh", 1.0f / static_cast<float>(3 - axis)))
            state.tools.mirror_selected(session, axis);
        if (axis < 2) ImGui::SameLine();
    }
    if (by_hand && wide_button("Back to the pattern", "Forgets the sites that were placed by hand")) edit(session, SetSites{});
}

void Panels::material_panel(const PanelState& state) {
    if (!begin_panel("Material")) return;
    Session& session = state.session;
    control("Material", "What it is made of: how it breaks, moves and looks (keys 1 to 5)");
    const std::string& now = session.recipe().material;
    if (ImGui::BeginCombo("##Material", now.empty() ? "plain" : now.c_str())) {
        if (ImGui::Selectable("plain", now.empty())) edit(session, SetMaterial{});
        for (const physics::MaterialPreset& preset : physics::material_presets())
            if (ImGui::Selectable(std::string(preset.name).c_str(), preset.name == now)) edit(session, SetMaterial{std::string(preset.name)});
        ImGui::EndCombo();
    }
    const physics::MaterialPreset* preset = physics::material_preset(session.recipe().material);
    const physics::Material material = preset ? preset->material : physics::Material{};
    ImGui::TextDisabled("%.0f kg/m\xc2\xb3, tensile %.0f MPa", static_cast<double>(material.density), static_cast<double>(material.tensile) * 1e-6);
}

} // namespace brittle::tools

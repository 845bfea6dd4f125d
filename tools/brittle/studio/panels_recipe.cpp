// The panels of the left column: object, pattern and material.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>

#include <glm/geometric.hpp>
#include <imgui.h>

#include "fracture/shapes/shapes.h"
#include "physics/material.h"
#include "tools/brittle/studio/material_menu.h"
#include "tools/brittle/studio/panels.h"
#include "tools/brittle/studio/style.h"
#include "tools/brittle/studio/widgets.h"

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

bool named_slider(const char* name, const char* tip_text, double& value, double low, double high, const char* format) {
    control(name, tip_text);
    auto shown = static_cast<float>(value);
    const bool changed =
        slider((std::string("##") + name).c_str(), shown, static_cast<float>(low), static_cast<float>(high), format);
    if (changed) value = shown;
    return changed;
}

bool vector(const char* name, const char* tip_text, glm::dvec3& value, float low, float high) {
    control(name, tip_text);
    const float gap = ImGui::GetStyle().ItemInnerSpacing.x,
                width = (ImGui::GetContentRegionAvail().x - 2.0f * gap) / 3.0f;
    bool changed = false;
    ImGui::PushID(name);
    for (int k = 0; k < 3; ++k) {
        constexpr const char* ids[] = {"##x", "##y", "##z"};
        auto shown = static_cast<float>(value[k]);
        if (k > 0) ImGui::SameLine(0.0f, gap);
        ImGui::SetNextItemWidth(width);
        if (slider(ids[k], shown, low, high, "%.2f")) {
            value[k] = shown;
            changed = true;
        }
    }
    ImGui::PopID();
    return changed;
}

bool has_axis(PatternKind kind) {
    return kind == PatternKind::radial || kind == PatternKind::slices || kind == PatternKind::splinters
           || kind == PatternKind::curve;
}

bool has_focus(PatternKind kind) {
    return kind == PatternKind::clustered || kind == PatternKind::radial;
}

bool pattern_kind(Pattern& pattern) {
    const auto names = fracture::pattern_names();
    control("Type", "Arrangement of the sites");
    bool changed = false;
    if (!ImGui::BeginCombo("##Type", std::string(names[static_cast<size_t>(pattern.kind)]).c_str())) return false;
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
    control("Sites", "Number of sites; a site inside the solid makes one piece or more");
    auto count = static_cast<int>(pattern.count);
    if (slider("##Sites", count, 2, 1000, "%d", ImGuiSliderFlags_Logarithmic)) {
        pattern.count = static_cast<uint32_t>(count);
        pattern.piece_size = 0.0;
        changed = true;
    }
    control("Seed", "Seed of all random numbers: equal seeds give equal pieces");
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
    explain((session.name() + (session.document().saved() ? "" : " (changed)")).c_str());
    if (!begin_panel(object.is_scene() ? "Scene" : "Object")) return;
    control(object.is_scene() ? "File" : "Mesh", "Mesh or scene to break; drop a file on the window, or open one");
    if (ImGui::BeginCombo("##Mesh", session.name().c_str())) {
        if (ImGui::Selectable("open a file ...")) actions_.push_back(Command::open);
        if (!state.recent_files.entries().empty()) ImGui::TextDisabled("recent files");
        for (const std::string& file : state.recent_files.entries()) {
            if (ImGui::Selectable((std::filesystem::path(file).filename().string() + "##" + file).c_str()))
                session.files().open(file);
            tip(file.c_str());
        }
        ImGui::TextDisabled("built-in shapes");
        for (const std::string_view name : fracture::shape_names())
            if (ImGui::Selectable(std::string(name).c_str())) session.files().open("shape:" + std::string(name));
        ImGui::EndCombo();
    }
    const glm::dvec3 size = object.extent().size();
    char metres[64];
    std::snprintf(metres, sizeof metres, "%.3g x %.3g x %.3g m", size.x, size.y, size.z);
    explain((grouped(object.triangles()) + " triangles, " + metres).c_str());
    if (!object.overlap().empty()) {
        explain(("Take care: " + object.overlap() + ".").c_str());
        if (wide_button("Unite parts", "Makes one solid of parts that pass through each other"))
            session.edit(SetUnite{true});
    }
    if (wide_button("Open", "A mesh or a recipe (Ctrl+O)", 1.0f / 3.0f)) actions_.push_back(Command::open);
    ImGui::SameLine();
    if (wide_button("Save", "The recipe (Ctrl+S)", 0.5f)) actions_.push_back(Command::save);
    ImGui::SameLine();
    if (wide_button("Export", "Pieces, recipe, pictures (Ctrl+E)")) actions_.push_back(Command::export_dialog);
    const Document& document = session.document();
    const auto history = [this](const char* name, const std::string& key, std::string_view what, Command action,
                                float share) {
        ImGui::BeginDisabled(what.empty());
        if (wide_button(name, (key + (what.empty() ? "" : ": " + std::string(what))).c_str(), share))
            actions_.push_back(action);
        ImGui::EndDisabled();
    };
    history("Undo", "Ctrl+Z", document.undo_name(), Command::undo, 0.5f);
    ImGui::SameLine();
    history("Redo", "Ctrl+Shift+Z", document.redo_name(), Command::redo, 1.0f);
}

void Panels::pattern_panel(const PanelState& state) {
    if (!begin_panel("Pattern")) return;
    Session& session = state.session;
    Pattern pattern = session.recipe().pattern;
    if (!session.recipe().points.empty()) {
        value("By hand", "%zu sites", session.sites().on_stage().size());
        if (wide_button("Back to the pattern", "Removes the sites placed by hand; so does every control below"))
            edit(session, SetSites{});
    }
    bool changed = pattern_kind(pattern);
    changed |= count_and_seed(pattern);
    if (has_focus(pattern.kind))
        changed |= vector("Focus", "Point where the pattern is densest, 0 to 1 along each side of the mesh's box",
                          pattern.focus, 0.0f, 1.0f);
    if (has_axis(pattern.kind)) {
        glm::dvec3 axis = pattern.axis;
        if (vector("Axis", "The direction of shards, slices and splinters", axis, -1.0f, 1.0f)
            && axis != glm::dvec3(0.0)) {
            pattern.axis = axis;
            changed = true;
        }
    }
    if (pattern.kind == PatternKind::clustered)
        changed |= named_slider("Spread", "Standard deviation of the cluster, as a share of the box's diagonal",
                                pattern.spread, 0.02, 1.0, "%.2f");
    if (pattern.kind == PatternKind::splinters)
        changed |= named_slider("Slenderness", "Length by width", pattern.slenderness, 1.0, 40.0, "%.0f");
    double jitter = std::max(pattern.jitter, 0.0);
    if (named_slider("Jitter", "Irregularity of the pattern; automatic: as suits the type", jitter, 0.0, 1.0,
                     pattern.jitter < 0.0 ? "automatic" : "%.2f")) {
        pattern.jitter = jitter;
        changed = true;
    }
    if (pattern.kind != PatternKind::bricks)
        changed |= named_slider("Grading", "Spread of sizes: 0 gives similar pieces, 1 pieces from small to large",
                                pattern.grading, 0.0, 1.0, "%.2f");
    double cells = pattern.cells_per_piece;
    if (named_slider("Cells a piece", "1 gives convex pieces, about 16 pieces of many facets, as of crushed stone",
                     cells, 1.0, 32.0, "%.0f")) {
        pattern.cells_per_piece = static_cast<uint32_t>(std::lround(cells));
        changed = true;
    }
    control("Inside only", "Only sites inside the solid, so that each makes a piece");
    changed |= ImGui::Checkbox("##Inside only", &pattern.inside);
    if (!changed) return;
    session.picture().cells = true; // shows the effect of the change
    edit(session, SetPattern{pattern});
}

void Panels::material_panel(const PanelState& state) {
    if (!begin_panel("Material")) return;
    Session& session = state.session;
    control("Material", "Material of the mesh: decides how it breaks, moves and looks (keys 1 to 6)");
    if (const std::optional<std::string> chosen = material_menu(session.recipe().material, state.recent_materials))
        edit(session, SetMaterial{*chosen});
    const physics::MaterialPreset* preset = physics::material_preset(session.recipe().material);
    const physics::Material material = preset ? preset->material : physics::Material{};
    char text[64];
    std::snprintf(text, sizeof text, "%.0f kg/m\xc2\xb3, tensile %.0f MPa", static_cast<double>(material.density),
                  static_cast<double>(material.tensile) * 1e-6);
    explain(text);
}

namespace {

// The axes that the menu of the grain offers.
constexpr std::array grain_axes = {glm::dvec3(1.0, 0.0, 0.0), glm::dvec3(0.0, 1.0, 0.0), glm::dvec3(0.0, 0.0, 1.0)};
constexpr std::array grain_names = {"along X", "along Y", "along Z"};
constexpr double wood_stretch = 4.0; // of a grain that is chosen where there was none

bool grain_menu(glm::dvec3& grain) {
    const double stretch = glm::length(grain);
    const auto lies_along = [&](size_t k) { return stretch > 0.0 && grain == stretch * grain_axes[k]; };
    const char* shown = stretch == 0.0 ? "none" : "oblique";
    for (size_t k = 0; k < grain_axes.size(); ++k)
        if (lies_along(k)) shown = grain_names[k];
    control("Grain", "Direction along which the bumps are stretched, as the fibres of wood");
    if (!ImGui::BeginCombo("##Grain", shown)) return false;
    bool changed = false;
    const auto choice = [&](const char* name, bool chosen, const glm::dvec3& value) {
        if (!ImGui::Selectable(name, chosen)) return;
        grain = value;
        changed = true;
    };
    choice("none", stretch == 0.0, glm::dvec3(0.0));
    for (size_t k = 0; k < grain_axes.size(); ++k)
        choice(grain_names[k], lies_along(k), (stretch > 0.0 ? stretch : wood_stretch) * grain_axes[k]);
    ImGui::EndCombo();
    return changed;
}

bool grain_stretch(glm::dvec3& grain) {
    const double stretch = glm::length(grain);
    if (stretch == 0.0) return false;
    control("Stretch", "Length of the bumps along the grain by their width: 4 for wood, 0.25 for the layers of slate");
    auto shown = static_cast<float>(stretch);
    if (!slider("##Stretch", shown, static_cast<float>(min_stretch), static_cast<float>(max_stretch), "%.2f",
                ImGuiSliderFlags_Logarithmic))
        return false;
    const double length = std::clamp(static_cast<double>(shown), min_stretch, max_stretch);
    grain *= length / stretch;
    return true;
}

} // namespace

void Panels::cuts_panel(const PanelState& state) {
    if (!begin_panel("Cuts")) return;
    Session& session = state.session;
    fracture::Roughness rough = session.recipe().rough;
    bool changed = named_slider("Roughness",
                                "From 0, flat cuts, to 1. Materials bring their own. The preview shows fewer details "
                                "while the mouse is held.",
                                rough.amount, 0.0, 1.0, rough.is_flat() ? "flat" : "%.2f");
    if (rough.is_flat()) {
        if (changed) edit(session, SetRoughness{rough});
        return;
    }
    const glm::dvec3 size = session.object().extent().size();
    changed |=
        named_slider("Bump size", "Size of the largest bumps; automatic: as large as the pieces", rough.wavelength, 0.0,
                     std::max({size.x, size.y, size.z}), rough.wavelength > 0.0 ? "%.3g m" : "automatic");
    if (ImGui::TreeNode("More about cuts")) {
        control("Detail", "Octaves, each with bumps of half the size. One more makes four times as many triangles.");
        auto detail = static_cast<int>(rough.detail);
        if (slider("##Detail", detail, 1, static_cast<int>(max_detail), "%d")) {
            rough.detail = static_cast<uint32_t>(detail);
            changed = true;
        }
        changed |= grain_menu(rough.grain);
        changed |= grain_stretch(rough.grain);
        ImGui::TreePop();
    }
    if (changed) edit(session, SetRoughness{rough});
}

} // namespace brittle::tools

// The panel of the selected tool: its settings and its selection.
#include <algorithm>
#include <array>
#include <functional>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <imgui.h>

#include "tools/brittle/studio/panels.h"
#include "tools/brittle/studio/style.h"
#include "tools/brittle/studio/widgets.h"
#include "tools/scenario/recipe/recipe.h"

namespace brittle::tools {

namespace {

constexpr float max_weight_shown = 1.0f; // m^2, on the stage, where the mesh is 2 m long

// What lengths on the stage compare to: a mesh without units is scaled, anything else has its true size.
const char* note_on_size(const Session& session) {
    const bool is_fit = !session.object().is_scene() && session.recipe().units == LengthUnit::fit;
    return is_fit ? "; the mesh is 2 m long on the stage" : "";
}

// The gizmo on the selected objects of a scene that stands.
void gizmo_buttons(Tools& tools) {
    constexpr std::array<const char*, 3> names{"Move", "Turn", "Scale"};
    constexpr std::array<const char*, 3> tips{
        "Arrows move along an axis, the dot in the view's plane; Shift lays them on what is under the cursor (W)",
        "Rings turn about an axis (E)", "Squares scale along an axis, the one in the middle evenly (T)"};
    for (size_t k = 0; k < names.size(); ++k) {
        const auto mode = static_cast<GizmoMode>(k);
        const bool active = tools.gizmo() == mode;
        if (active) {
            ImGui::PushStyleColor(ImGuiCol_Button, StudioColours{}.accent);
            ImGui::PushStyleColor(ImGuiCol_ButtonHovered, StudioColours{}.accent);
            ImGui::PushStyleColor(ImGuiCol_Text, IM_COL32(24, 20, 16, 255));
        }
        if (wide_button(names[k], "", 1.0f / static_cast<float>(names.size() - k))) tools.choose(mode);
        if (active) ImGui::PopStyleColor(3);
        tip(tips[k]);
        if (k + 1 < names.size()) ImGui::SameLine();
    }
    switch (tools.gizmo()) {
    case GizmoMode::move:
        explain("Ctrl: steps of 0.1 m. Shift + the dot: onto what is under the cursor.");
        break;
    case GizmoMode::turn:
        explain("Ctrl: steps of 15 degrees.");
        break;
    case GizmoMode::scale:
        explain("Ctrl: steps of a tenth. One object is scaled along its own axes.");
        break;
    }
}

void selected_piece(const Session& session) {
    if (!session.piece || !session.pieces().contains(*session.piece) || !session.counts()) {
        const bool stands = session.object().is_scene() && !session.playing();
        explain(stands             ? "Drag turns the view. Click an object to move it; Shift + drag selects several."
                : session.broken() ? "Click a piece to see its volume."
                                   : "Drag turns the view. Once it is broken, click a piece to see its volume.");
        return;
    }
    if (session.object().is_scene()) {
        const Simulation& simulation = session.stage().simulation();
        value("Object", simulation.members()[simulation.member_of(*session.piece)].name.c_str());
        value("Piece", "number %u", *session.piece);
        value("Volume", "%.3g m\xc2\xb3", session.pieces().volume(*session.piece));
        value("Triangles", grouped(session.pieces().triangles(*session.piece)).c_str());
        return;
    }
    const double scale = session.object().scale(), volume = session.pieces().volume(*session.piece);
    const double all = session.counts()->certificate.volume_sum;
    value("Piece", "number %u", *session.piece);
    value("Volume", "%.3g m\xc2\xb3", volume / (scale * scale * scale));
    value("Share", "%.2g %% of the whole", all > 0.0 ? 100.0 * volume / all : 0.0);
    value("Triangles", grouped(session.pieces().triangles(*session.piece)).c_str());
}

// Settings of the hammer. In a breakable world the number of pieces is a maximum, a setting of the world; otherwise it
// belongs to the hammer.
void hammer_settings(Session& session, const std::function<void(const WorldOptions&)>& set_world) {
    control("Radius",
            (std::string("Radius of the part that a blow breaks (Shift + wheel)") + note_on_size(session)).c_str());
    (void)slider("##radius", session.tools.hammer_radius, 0.05f, 1.5f, "%.2f m");
    if (session.object().is_scene()) {
        explain("Lines: where a click cuts what lies still.");
        return; // the number of pieces is each object's
    }
    WorldOptions world = session.recipe().world;
    control("Pieces", world.breakable ? "Maximum number of pieces of a blow; the number depends on energy and material"
                                      : "Approximate number of pieces of a blow");
    auto pieces = static_cast<int>(world.breakable ? world.blow_pieces : session.tools.hammer_pieces);
    if (slider("##pieces", pieces, 2, 100, world.breakable ? "at most %d" : "%d")) {
        world.blow_pieces = static_cast<uint32_t>(pieces);
        if (world.breakable)
            set_world(world);
        else
            session.tools.hammer_pieces = world.blow_pieces;
    }
    explain(session.broken() && world.breakable ? "Lines: where a click cuts what lies still."
                                                : "Orange: what a click breaks off.");
}

void ball_settings(Session& session) {
    control("Speed", "Speed of balls");
    (void)slider("##speed", session.tools.ball_speed, 1.0f, 40.0f, "%.0f m/s");
    control("Radius", (std::string("Radius of the ball (Shift + wheel)") + note_on_size(session)).c_str());
    (void)slider("##ball radius", session.tools.ball_radius, 0.02f, 0.5f, "%.2f m");
    const double r = session.tools.ball_radius;
    const double mass = 4.0 / 3.0 * std::numbers::pi * r * r * r * Shot{}.density;
    value("Mass", mass < 10.0 ? "%.1f kg of steel" : "%.0f kg of steel", mass);
}

void anchor_settings(Session& session) {
    const size_t count = session.recipe().world.anchors.size();
    control("Radius", (std::string("Radius of the brush (Shift + wheel)") + note_on_size(session)).c_str());
    (void)slider("##brush", session.tools.brush_radius, 0.02f, 0.5f, "%.2f m");
    value("Painted", count == 1 ? "%zu spot" : "%zu spots", count);
    ImGui::BeginDisabled(count == 0 || session.broken());
    if (wide_button("Rub all out", "Removes all anchors; the foot stays fixed if the mesh is anchored")) {
        std::vector<uint32_t> all(count);
        std::iota(all.begin(), all.end(), 0u);
        session.edit(RemoveAnchors{std::move(all)});
    }
    ImGui::EndDisabled();
    explain("What lies in the blue spots is held, and the rest by its bonds.");
}

} // namespace

void Panels::tool_panel(const PanelState& state, float rows) {
    if (!begin_panel((std::string(info_of(state.tools.tool()).name) + "###tool").c_str())) return;
    const float top = ImGui::GetCursorPosY();
    switch (state.tools.tool()) {
    case Tool::inspect:
        if (state.session.middle_of_selected())
            gizmo_buttons(state.tools);
        else
            selected_piece(state.session);
        break;
    case Tool::sites:
        site_tools(state);
        break;
    case Tool::hammer:
        hammer_settings(state.session, [&](const WorldOptions& world) { edit(state.session, SetWorld{world}); });
        break;
    case Tool::shoot:
        ball_settings(state.session);
        break;
    case Tool::grab:
        explain("Drag a piece: it hangs on a spring from the mouse, and pulls what is bonded to it.");
        break;
    case Tool::anchors:
        anchor_settings(state.session);
        break;
    }
    ImGui::SetCursorPosY(std::max(ImGui::GetCursorPosY(), top + rows * ImGui::GetFrameHeightWithSpacing()));
}

void Panels::site_tools(const PanelState& state) {
    Session& session = state.session;
    value("Sites", "%zu, %zu selected", session.sites().on_stage().size(), session.sites().selection.size());
    tip("Click one to select it, Ctrl + click selects more");
    ImGui::BeginDisabled(session.sites().selection.empty() || session.broken());
    if (wide_button("Delete", "Deletes the selected sites (Del)", 1.0f / 2.0f)) actions_.push_back(Command::remove);
    ImGui::SameLine();
    if (wide_button("Duplicate", "Copies the selected sites to places beside them (Ctrl+D)"))
        actions_.push_back(Command::duplicate);
    ImGui::EndDisabled();
    constexpr const char* mirrors[] = {"Mirror X", "Mirror Y", "Mirror Z"};
    ImGui::BeginDisabled(session.broken());
    for (int axis = 0; axis < 3; ++axis) {
        if (wide_button(mirrors[axis],
                        "Adds the mirror images of the selected sites, or of all, across the middle of the mesh",
                        1.0f / static_cast<float>(3 - axis)))
            state.tools.mirror_selected(session, axis);
        if (axis < 2) ImGui::SameLine();
    }
    ImGui::EndDisabled();
    selected_sites(session);
    const size_t idle = session.preview().idle_sites().size();
    const std::string count = std::to_string(idle) + (idle == 1 ? " crossed site is" : " crossed sites are");
    if (idle > 0) explain((count + " nearest to nothing of the mesh: no piece, no cut.").c_str());
}

// Controls for the weight and group of all selected sites. They show the first site's value unless the values differ.
void Panels::selected_sites(Session& session) {
    const double scale = session.object().scale();
    const std::vector<PlacedSite> sites = session.sites().selected();
    const PlacedSite first = sites.empty() ? PlacedSite{} : sites.front();
    const auto alike = [&](auto member) {
        return std::ranges::all_of(sites, [&](const PlacedSite& s) { return s.*member == first.*member; });
    };
    const auto change = [&](const Edit& to) {
        if (gesture_ == 0) gesture_ = session.begin_gesture();
        session.take_sites(gesture_);
        session.edit(to, gesture_);
    };
    const float gap = ImGui::GetStyle().ItemSpacing.x, half = 0.5f * (ImGui::GetContentRegionAvail().x - gap);
    ImGui::BeginDisabled(sites.empty() || session.broken());
    auto weight = static_cast<float>(first.weight * scale * scale);
    ImGui::SetNextItemWidth(half);
    if (slider("##weight", weight, -max_weight_shown, max_weight_shown,
               alike(&PlacedSite::weight) ? "weight %.2f" : "weights differ"))
        change(SetSiteWeight{session.sites().selection, double{weight} / (scale * scale)});
    tip("Extent of the selected sites' cells relative to their neighbours': m\xc2\xb2 on the stage, where the "
        "mesh is 2 m long (drag, or Ctrl + click to type)");
    ImGui::SameLine(0.0f, gap);
    auto group = static_cast<int>(first.group);
    ImGui::SetNextItemWidth(-1.0f);
    constexpr float slow = 0.1f; // numbers per pixel
    const char* format = !alike(&PlacedSite::group) ? "groups differ" : group > 0 ? "group %d" : "no group";
    if (ImGui::DragInt("##group", &group, slow, 0, static_cast<int>(max_group), format, ImGuiSliderFlags_AlwaysClamp))
        change(SetSiteGroup{session.sites().selection, static_cast<uint32_t>(group)});
    tip("Cells of one number are one piece; 0: each is a piece by itself (drag, or Ctrl + click to type)");
    ImGui::EndDisabled();
}

} // namespace brittle::tools

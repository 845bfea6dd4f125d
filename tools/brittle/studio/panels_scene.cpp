// The panel of a scene's objects: their list, and the properties of those that are selected.
#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include <imgui.h>

#include "fracture/shapes/shapes.h"
#include "tools/brittle/studio/material_menu.h"
#include "tools/brittle/studio/panels.h"
#include "tools/brittle/studio/style.h"
#include "tools/brittle/studio/widgets.h"

namespace brittle::tools {

namespace {

constexpr float max_rows = 9.0f; // of the list; more scroll
constexpr float metres_a_pixel = 0.01f;
constexpr float degrees_a_pixel = 0.5f;
constexpr float min_factor = 0.001f;

struct KindInfo {
    const char* name;
    const char* tip;
};
enum class Kind { breakable, bonded, shattered, rigid, fixed };
constexpr std::array kinds{
    KindInfo{"breakable", "Starts whole; blows cut it, again and again"},
    KindInfo{"bonded", "Cut by its pattern at the start; blows and loads break the bonds of its pieces"},
    KindInfo{"shattered", "Cut by its pattern at the start, into loose pieces"},
    KindInfo{"rigid", "Moves, but is never cut"},
    KindInfo{"fixed", "Never moves or breaks; its mesh may be open"},
};

Kind kind_of(const SceneObject& object) {
    if (object.fixed) return Kind::fixed;
    if (object.recipe.world.bonded) return Kind::bonded;
    if (object.shattered) return Kind::shattered;
    return object.recipe.world.breakable ? Kind::breakable : Kind::rigid;
}

bool is_cut(Kind kind) {
    return kind == Kind::bonded || kind == Kind::shattered;
}

void make(SceneObject& object, Kind kind) {
    if (is_cut(kind) && !is_cut(kind_of(object))) object.recipe.automatic = AutomaticPattern{}; // as in a recipe
    object.fixed = kind == Kind::fixed;
    object.shattered = kind == Kind::shattered;
    object.recipe.world.bonded = kind == Kind::bonded;
    object.recipe.world.breakable = kind != Kind::rigid;
    if (object.fixed) {
        object.recipe.world.anchored = false;
        object.recipe.world.anchors.clear();
    }
}

const char* name_of(Kind kind) {
    return kinds[static_cast<size_t>(kind)].name;
}

bool three(const char* name, const char* tip_text, glm::dvec3& value, float speed, float low, const char* format) {
    control(name, tip_text);
    std::array<float, 3> shown{static_cast<float>(value.x), static_cast<float>(value.y), static_cast<float>(value.z)};
    const bool bounded = low > 0.0f;
    ImGui::SetNextItemWidth(-1.0f);
    if (!ImGui::DragFloat3((std::string("##") + name).c_str(), shown.data(), speed, bounded ? low : 0.0f,
                           bounded ? 1000.0f : 0.0f, format, ImGuiSliderFlags_AlwaysClamp))
        return false;
    for (int k = 0; k < 3; ++k)
        if (shown[static_cast<size_t>(k)] != static_cast<float>(value[k])) value[k] = shown[static_cast<size_t>(k)];
    return true;
}

} // namespace

void Panels::object_list(Session& session) {
    const std::vector<SceneObject>& objects = session.recipe().objects;
    const float rows = std::min(static_cast<float>(objects.size()), max_rows);
    ImGui::BeginChild("objects", {0.0f, rows * ImGui::GetTextLineHeightWithSpacing() + ImGui::GetStyle().ItemSpacing.y},
                      false);
    for (uint32_t k = 0; k < objects.size(); ++k) {
        const bool selected = std::ranges::find(session.selected, k) != session.selected.end();
        const bool hidden = session.is_hidden(k), locked = session.is_locked(k);
        const std::string label = objects[k].name + "##" + std::to_string(k);
        ImGui::PushID(static_cast<int>(k));
        if (icon_button("eye", hidden ? Icon::closed_eye : Icon::eye, hidden,
                        hidden ? "Hidden, but still there; click to show it" : "Hide it; it still collides"))
            session.hide(k, !hidden);
        ImGui::SameLine(0.0f, 0.0f);
        if (icon_button("lock", locked ? Icon::padlock : Icon::open_padlock, locked,
                        locked ? "Locked: clicks in the view pass it by; click to unlock it"
                               : "Lock it: clicks and boxes in the view pass it by"))
            session.lock(k, !locked);
        ImGui::SameLine();
        ImGui::PopID();
        if (hidden) ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
        const bool clicked = ImGui::Selectable(label.c_str(), selected);
        if (hidden) ImGui::PopStyleColor();
        if (clicked) session.select(k, ImGui::GetIO().KeyShift || ImGui::GetIO().KeyCtrl);
        if (selected && k == session.selected.back() && listed_ != session.selected && !ImGui::IsItemVisible())
            ImGui::SetScrollHereY(); // it was selected in the view
        const char* kind = name_of(kind_of(objects[k]));
        ImGui::SameLine(ImGui::GetContentRegionMax().x - ImGui::CalcTextSize(kind).x);
        ImGui::TextDisabled("%s", kind);
    }
    listed_ = session.selected;
    ImGui::EndChild();
}

void Panels::scene_panel(const PanelState& state) {
    Session& session = state.session;
    if (!begin_panel("Objects")) return;
    object_list(session);
    control("Add", "Adds a shape where the view looks; drop a mesh file on the window to add it where you drop it");
    if (ImGui::BeginCombo("##Add", "a shape")) {
        for (const std::string_view name : fracture::shape_names())
            if (ImGui::Selectable(std::string(name).c_str())) session.add_object("shape:" + std::string(name));
        ImGui::EndCombo();
    }
    if (session.selected.empty()) {
        explain("Click an object to edit it, here or in the view; Shift selects more.");
        return;
    }
    if (wide_button("Duplicate", "Copies the selected objects (Ctrl+D)", 0.5f)) actions_.push_back(Command::duplicate);
    ImGui::SameLine();
    if (wide_button("Delete", "Removes the selected objects (Del)")) actions_.push_back(Command::remove);
    selected_objects(session, state.recent_materials);
}

// The controls show the values of the first selected object, and set those of all.
void Panels::selected_objects(Session& session, Recent& recent_materials) {
    SceneObject first = session.recipe().objects[session.selected.front()];
    const auto set = [&](const std::function<void(SceneObject&)>& change) {
        if (gesture_ == 0) gesture_ = session.begin_gesture();
        session.change_selected(change, gesture_);
    };
    const std::string count = std::to_string(session.selected.size()) + " objects";
    if (!begin_panel((session.selected.size() == 1 ? first.name + "###selected" : count + "###selected").c_str()))
        return;
    if (session.selected.size() == 1) {
        control("Name", "Unique in the scene; Enter sets it");
        std::array<char, 128> name{};
        first.name.copy(name.data(), name.size() - 1);
        ImGui::SetNextItemWidth(-1.0f);
        if (ImGui::InputText("##Name", name.data(), name.size(), ImGuiInputTextFlags_EnterReturnsTrue) && name[0] != 0)
            session.rename(session.selected.front(), name.data());
    }
    control("Material", "Decides how it breaks, moves and looks (keys 1 to 6)");
    if (const std::optional<std::string> chosen = material_menu(first.recipe.material, recent_materials))
        set([&](SceneObject& o) {
            if (chosen->empty())
                o.recipe.material.clear();
            else
                use_material(*chosen, o.recipe);
        });
    const Kind kind = kind_of(first);
    control("Kind", kinds[static_cast<size_t>(kind)].tip);
    if (ImGui::BeginCombo("##Kind", name_of(kind))) {
        for (size_t k = 0; k < kinds.size(); ++k) {
            const Kind one = static_cast<Kind>(k);
            if (ImGui::Selectable(kinds[k].name, one == kind)) set([one](SceneObject& o) { make(o, one); });
            tip(kinds[k].tip);
        }
        ImGui::EndCombo();
    }
    if (kind != Kind::fixed) {
        control("Anchored", "Its lowest centimetre is held");
        bool anchored = first.recipe.world.anchored;
        if (ImGui::Checkbox("##Anchored", &anchored))
            set([anchored](SceneObject& o) { o.recipe.world.anchored = anchored && !o.fixed; });
    }
    if (kind != Kind::fixed) {
        control("Strength", "Factor on the strength of its material");
        auto strength = static_cast<float>(first.recipe.world.strength);
        if (slider("##Strength", strength, 0.01f, 100.0f, "%.2f", ImGuiSliderFlags_Logarithmic))
            set([strength](SceneObject& o) { o.recipe.world.strength = double{strength}; });
        control("Roughness", "Of its cuts, from 0, flat, to 1");
        auto rough = static_cast<float>(first.recipe.rough.amount);
        if (slider("##Roughness", rough, 0.0f, 1.0f, first.recipe.rough.is_flat() ? "flat" : "%.2f"))
            set([rough](SceneObject& o) { o.recipe.rough.amount = double{rough}; });
        const bool named = is_cut(kind) && first.recipe.automatic && first.recipe.automatic->named_seed;
        control("Seed", named ? "Equal seeds give equal cuts; this one comes from the name, until you set it"
                              : "Equal seeds give equal cuts");
        auto seed = named ? 0 : static_cast<int>(std::min<uint64_t>(first.recipe.pattern.seed, 1'000'000));
        constexpr int one = 1;
        if (ImGui::InputScalar("##Seed", ImGuiDataType_S32, &seed, &one, nullptr, named ? "from the name" : "%d"))
            set([seed](SceneObject& o) {
                o.recipe.pattern.seed = static_cast<uint64_t>(std::clamp(seed, 0, 1'000'000));
                if (o.recipe.automatic) o.recipe.automatic->named_seed = false;
            });
    }
    if (is_cut(kind)) {
        control("Automatic", "Its material and size decide the number of pieces");
        bool automatic = first.recipe.automatic.has_value();
        if (ImGui::Checkbox("##Automatic", &automatic))
            set([automatic](SceneObject& o) {
                o.recipe.automatic = automatic ? std::optional(AutomaticPattern{}) : std::nullopt;
            });
    }
    if (is_cut(kind) && first.recipe.automatic) {
        control("Piece size", "Factor on the size of its pieces");
        auto scale = static_cast<float>(first.recipe.automatic->scale);
        if (slider("##Piece size", scale, 0.1f, 10.0f, "%.2f", ImGuiSliderFlags_Logarithmic))
            set([scale](SceneObject& o) {
                if (o.recipe.automatic) o.recipe.automatic->scale = double{scale};
            });
    } else if (is_cut(kind)) {
        control("Sites", "Number of sites of its pattern");
        auto sites = static_cast<int>(first.recipe.pattern.count);
        if (slider("##Sites", sites, 2, 1000, "%d", ImGuiSliderFlags_Logarithmic))
            set([sites](SceneObject& o) {
                o.recipe.pattern.count = static_cast<uint32_t>(sites);
                o.recipe.pattern.piece_size = 0.0;
            });
    }
    glm::dvec3 turn = first.placement.rotation, size = first.placement.scale;
    glm::dvec3 to = first.placement.translation;
    if (three("Place", "X, Y and Z in metres; all selected objects move alike", to, metres_a_pixel, 0.0f, "%.3f"))
        set([by = to - first.placement.translation](SceneObject& o) { o.placement.translation += by; });
    if (three("Turn", "Degrees about X, then Y, then Z", turn, degrees_a_pixel, 0.0f, "%.1f"))
        set([turn](SceneObject& o) { o.placement.rotation = turn; });
    const bool mirrored = size.x <= 0.0 || size.y <= 0.0 || size.z <= 0.0; // by the recipe: no slider spans zero
    if (three("Scale", "Factors along the mesh's X, Y and Z", size, metres_a_pixel, mirrored ? 0.0f : min_factor,
              "%.3f")
        && size.x * size.y * size.z != 0.0)
        set([size](SceneObject& o) { o.placement.scale = size; });
}

} // namespace brittle::tools

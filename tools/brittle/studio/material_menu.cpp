#include "tools/brittle/studio/material_menu.h"

#include <imgui.h>

#include "physics/material.h"

namespace brittle::tools {

std::vector<std::string> recent_materials(const Recent& recent) {
    std::vector<std::string> known;
    for (const std::string& name : recent.entries())
        if (physics::material_preset(name)) known.push_back(name);
    return known;
}

std::optional<std::string> material_menu(const std::string& now, Recent& recent) {
    std::optional<std::string> chosen;
    if (!ImGui::BeginCombo("##Material", now.empty() ? "plain" : now.c_str(), ImGuiComboFlags_HeightLarge))
        return chosen;
    const std::vector<std::string> newest = recent_materials(recent);
    if (!newest.empty()) ImGui::TextDisabled("recent");
    for (const std::string& name : newest)
        if (ImGui::Selectable((name + "##recent").c_str())) chosen = name;
    if (!newest.empty()) ImGui::TextDisabled("all");
    if (ImGui::Selectable("plain", now.empty())) chosen = "";
    for (const physics::MaterialPreset& preset : physics::material_presets())
        if (ImGui::Selectable(std::string(preset.name).c_str(), preset.name == now)) chosen = std::string(preset.name);
    ImGui::EndCombo();
    if (chosen) recent.add(*chosen);
    return chosen;
}

} // namespace brittle::tools

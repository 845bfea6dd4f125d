// Colours, font and style of the studio. apply_style() is called once, when Dear ImGui has its context.
#pragma once

#include <string>

#include <imgui.h>

namespace brittle::tools {

struct StudioColours {
    ImU32 accent = IM_COL32(236, 142, 66, 255); // terracotta, for everything that breaks
    ImU32 accent_soft = IM_COL32(236, 142, 66, 110);
    ImU32 axis[3] = {IM_COL32(228, 84, 74, 255), IM_COL32(118, 192, 82, 255), IM_COL32(84, 148, 236, 255)};
    ImU32 anchor = IM_COL32(84, 148, 236, 70); // fill of painted anchors
    ImU32 anchor_rim = IM_COL32(120, 176, 250, 255);
    ImU32 bar = IM_COL32(112, 70, 40, 255); // bar of a slider, under its number
    ImU32 outline = IM_COL32(0, 0, 0, 120);
    ImU32 idle = IM_COL32(208, 208, 212, 255); // sites without effect
};
inline constexpr float text_height = 14.0f; // pixels at scale 1

// Loads DejaVu Sans if it is installed (package fonts-dejavu-core), else Dear ImGui's own font. `scale` 2 suits
// displays of twice the usual density.
void apply_style(float scale);

} // namespace brittle::tools

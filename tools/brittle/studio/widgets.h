// Controls that the studio's panels are made of: a name left, the control right, a tip under the mouse; sliders with a bar
// instead of a grab, which would hide their numbers.
//
//     control("Radius", "Of the hammer (Shift + wheel)");
//     changed |= slider("##radius", radius, 0.05f, 1.5f, "%.2f m");
//
// Pixels are the window's. For Dear ImGui's thread, between its new frame and render.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include <imgui.h>

namespace brittle::tools {

// The name of a control and where the control is to come: the rest of the line. `tip` shows while the mouse is over it.
void control(const char* name, const char* tip);
void tip(const char* text); // of the item before
// A button as wide as `share` of the line that is left.
[[nodiscard]] bool wide_button(const char* name, const char* tip_text, float share = 1.0f);
[[nodiscard]] bool begin_panel(const char* name, bool open = true);

// Whether it was moved. The value stays within its limits. Logarithmic where the flags say so; `low` is positive then.
[[nodiscard]] bool slider(const char* id, float& value, float low, float high, const char* format,
                          ImGuiSliderFlags flags = 0);
[[nodiscard]] bool slider(const char* id, int& value, int low, int high, const char* format,
                          ImGuiSliderFlags flags = 0);

// A button with its key beside the name, in a fainter colour; without the key where `key` is empty.
[[nodiscard]] bool key_button(const std::string& name, const std::string& key, float width, ImU32 text_colour);
[[nodiscard]] float key_button_width(const std::string& name, const std::string& key); // of what is written on it

// Greyed, in as many lines as it takes.
void explain(const char* text);
// A line of a table: a name and what is so.
void value(const char* name, const char* text);
template<class... Values>
void value(const char* name, const char* format, Values... values) {
    char text[96];
    std::snprintf(text, sizeof text, format, values...);
    value(name, static_cast<const char*>(text));
}

[[nodiscard]] std::string grouped(uint64_t number); // 69666: "69,666"

} // namespace brittle::tools

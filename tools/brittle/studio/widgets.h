// Controls of the studio's panels: a name on the left, the control on the right, a tip under the mouse. Sliders have a
// bar instead of a grab, which would hide their numbers.
//
//     control("Radius", "Of the hammer (Shift + wheel)");
//     changed |= slider("##radius", radius, 0.05f, 1.5f, "%.2f m");
//
// Lengths are pixels of the window. Call from Dear ImGui's thread, between its new frame and render.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include <imgui.h>

namespace brittle::tools {

// Draws the name of a control and reserves the rest of the line for the control. `tip` shows while the mouse is over
// it.
void control(const char* name, const char* tip);
void tip(const char* text); // tip for the item before
// Draws a button as wide as `share` of the rest of the line.
[[nodiscard]] bool wide_button(const char* name, const char* tip_text, float share = 1.0f);
[[nodiscard]] bool begin_panel(const char* name, bool open = true);

// Return whether the value changed. The value stays within its limits. The flags may make the slider logarithmic; `low`
// must be positive then.
[[nodiscard]] bool slider(const char* id, float& value, float low, float high, const char* format,
                          ImGuiSliderFlags flags = 0);
[[nodiscard]] bool slider(const char* id, int& value, int low, int high, const char* format,
                          ImGuiSliderFlags flags = 0);

// Draws a button with its key beside the name, in a fainter colour; without a key if `key` is empty.
[[nodiscard]] bool key_button(const std::string& name, const std::string& key, float width, ImU32 text_colour);
// Width of the text on the button.
[[nodiscard]] float key_button_width(const std::string& name, const std::string& key);

// Draws a small button with a picture: an eye, or a padlock. It is faint while it is not `strong`, so that a column of
// them stays calm.
enum class Icon { eye, closed_eye, padlock, open_padlock };
[[nodiscard]] bool icon_button(const char* id, Icon icon, bool strong, const char* tip_text);
[[nodiscard]] float icon_width();

// Draws greyed text over as many lines as it needs.
void explain(const char* text);
// Draws a line of a table: a name and a value.
void value(const char* name, const char* text);
template<class... Values>
void value(const char* name, const char* format, Values... values) {
    char text[96];
    std::snprintf(text, sizeof text, format, values...);
    value(name, static_cast<const char*>(text));
}

[[nodiscard]] std::string grouped(uint64_t number); // 69666: "69,666"

} // namespace brittle::tools

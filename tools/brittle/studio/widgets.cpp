#include "tools/brittle/studio/widgets.h"

#include <algorithm>
#include <cmath>

#include "tools/brittle/studio/style.h"

namespace brittle::tools {

namespace {

constexpr float name_share = 0.42f; // share of a line
constexpr float tip_width = 28.0f;  // heights of the text; longer lines would not fit with a large font
constexpr float key_gap = 6.0f;     // pixels between a name and its key

void to_control() {
    const float left = ImGui::GetWindowContentRegionMin().x, right = ImGui::GetWindowContentRegionMax().x;
    ImGui::SameLine(left + name_share * (right - left));
}

// Draws the frame of a slider and its bar. While the object exists, Dear ImGui draws neither.
class SliderBar {
  public:
    explicit SliderBar(float share) {
        const StudioColours colours;
        const ImVec2 low = ImGui::GetCursorScreenPos();
        const ImVec2 high{low.x + ImGui::CalcItemWidth(), low.y + ImGui::GetFrameHeight()};
        const float rounding = ImGui::GetStyle().FrameRounding,
                    end = low.x + std::clamp(share, 0.0f, 1.0f) * (high.x - low.x);
        ImDrawList& list = *ImGui::GetWindowDrawList();
        list.AddRectFilled(low, high, ImGui::GetColorU32(ImGuiCol_FrameBg), rounding);
        list.AddRectFilled(low, {std::max(end, low.x + 2.0f), high.y}, colours.bar, rounding);
        for (const ImGuiCol hidden : {ImGuiCol_FrameBg, ImGuiCol_SliderGrab, ImGuiCol_SliderGrabActive})
            ImGui::PushStyleColor(hidden, IM_COL32_BLACK_TRANS);
        for (const ImGuiCol over : {ImGuiCol_FrameBgHovered, ImGuiCol_FrameBgActive})
            ImGui::PushStyleColor(over, IM_COL32(255, 255, 255, 14));
    }
    ~SliderBar() { ImGui::PopStyleColor(5); }
    SliderBar(const SliderBar&) = delete;
    SliderBar& operator=(const SliderBar&) = delete;
};

float share_of(float value, float low, float high, ImGuiSliderFlags flags) {
    if (flags & ImGuiSliderFlags_Logarithmic) return std::log(std::max(value, low) / low) / std::log(high / low);
    return (value - low) / (high - low);
}

} // namespace

void control(const char* name, const char* tip_text) {
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(name);
    tip(tip_text);
    to_control();
    ImGui::SetNextItemWidth(-1.0f);
}

void tip(const char* text) {
    if (*text == 0 || !ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) return;
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(tip_width * ImGui::GetFontSize());
    ImGui::TextUnformatted(text);
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
}

bool wide_button(const char* name, const char* tip_text, float share) {
    const float gap = ImGui::GetStyle().ItemSpacing.x, left = ImGui::GetContentRegionAvail().x;
    const bool pressed = ImGui::Button(name, {share < 1.0f ? (left + gap) * share - gap : left, 0.0f});
    tip(tip_text);
    return pressed;
}

bool begin_panel(const char* name, bool open) {
    return ImGui::CollapsingHeader(name, open ? ImGuiTreeNodeFlags_DefaultOpen : ImGuiTreeNodeFlags_None);
}

bool slider(const char* id, float& value, float low, float high, const char* format, ImGuiSliderFlags flags) {
    const SliderBar bar(share_of(value, low, high, flags));
    return ImGui::SliderFloat(id, &value, low, high, format, flags | ImGuiSliderFlags_AlwaysClamp);
}

bool slider(const char* id, int& value, int low, int high, const char* format, ImGuiSliderFlags flags) {
    const SliderBar bar(share_of(static_cast<float>(value), static_cast<float>(low), static_cast<float>(high), flags));
    return ImGui::SliderInt(id, &value, low, high, format, flags | ImGuiSliderFlags_AlwaysClamp);
}

float key_button_width(const std::string& name, const std::string& key) {
    const float text = ImGui::CalcTextSize(name.c_str()).x;
    return key.empty() ? text : text + key_gap + ImGui::CalcTextSize(key.c_str()).x;
}

bool key_button(const std::string& name, const std::string& key, float width, ImU32 text_colour) {
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const bool pressed = ImGui::Button(("##" + name).c_str(), {width, 0.0f});
    const ImVec2 at{std::round(corner.x + 0.5f * (width - key_button_width(name, key))),
                    corner.y + ImGui::GetStyle().FramePadding.y};
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddText(at, text_colour, name.c_str());
    constexpr ImU32 faint = 0x8cffffffu; // alpha, in Dear ImGui's order of bytes
    if (!key.empty())
        list.AddText({at.x + ImGui::CalcTextSize(name.c_str()).x + key_gap, at.y}, text_colour & faint, key.c_str());
    return pressed;
}

float icon_width() {
    return 1.3f * ImGui::GetTextLineHeight();
}

bool icon_button(const char* id, Icon icon, bool strong, const char* tip_text) {
    const float line = ImGui::GetTextLineHeight();
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const bool pressed = ImGui::InvisibleButton(id, {icon_width(), line});
    const ImU32 colour = ImGui::GetColorU32(ImGuiCol_Text, ImGui::IsItemHovered() ? 1.0f : strong ? 0.85f : 0.3f);
    tip(tip_text);
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const ImVec2 middle{corner.x + 0.5f * icon_width(), corner.y + 0.55f * line};
    const float unit = line / 14.0f, thick = 1.3f * unit;
    if (icon == Icon::eye || icon == Icon::closed_eye) {
        const float wide = 5.5f * unit, high = 4.5f * unit;
        const ImVec2 left{middle.x - wide, middle.y}, right{middle.x + wide, middle.y};
        if (icon == Icon::eye) {
            list.AddBezierQuadratic(left, {middle.x, middle.y - 2.0f * high}, right, colour, thick);
            list.AddCircleFilled({middle.x, middle.y - 0.2f * unit}, 1.9f * unit, colour);
        }
        list.AddBezierQuadratic(left, {middle.x, middle.y + 2.0f * high}, right, colour, thick);
        return pressed;
    }
    const float half = 3.6f * unit;
    list.AddRectFilled({middle.x - half, middle.y - 0.5f * unit}, {middle.x + half, middle.y + 5.0f * unit}, colour,
                       1.0f * unit);
    const float shift = icon == Icon::padlock ? 0.0f : 3.6f * unit; // the bow of an open one is turned aside
    const ImVec2 bow{middle.x + shift, middle.y - 1.5f * unit};
    list.PathArcTo(bow, 2.3f * unit, 3.14159265f, 2.0f * 3.14159265f, 10);
    list.PathLineTo({bow.x + 2.3f * unit, middle.y + (icon == Icon::padlock ? 0.0f : -1.0f) * unit});
    list.PathStroke(colour, ImDrawFlags_None, thick);
    return pressed;
}

void explain(const char* text) {
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
    ImGui::TextWrapped("%s", text);
    ImGui::PopStyleColor();
}

void value(const char* name, const char* text) {
    ImGui::TextDisabled("%s", name);
    to_control();
    ImGui::TextWrapped("%s", text);
}

std::string grouped(uint64_t number) {
    std::string text = std::to_string(number);
    for (size_t at = text.size(); at > 3; at -= 3) text.insert(at - 3, ",");
    return text;
}

} // namespace brittle::tools

#include "tools/brittle/studio/style.h"

#include <array>
#include <cmath>
#include <filesystem>

namespace brittle::tools {

namespace {

constexpr std::array font_files{"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
                                "/usr/share/fonts/TTF/DejaVuSans.ttf",
                                "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf"};

ImVec4 rgb(int red, int green, int blue, float alpha = 1.0f) {
    return {static_cast<float>(red) / 255.0f, static_cast<float>(green) / 255.0f, static_cast<float>(blue) / 255.0f,
            alpha};
}

void add_font(float scale) {
    ImGuiIO& io = ImGui::GetIO();
    const float pixels = std::round(text_height * scale);
    for (const char* file : font_files) {
        std::error_code error;
        if (!std::filesystem::exists(file, error)) continue; // Dear ImGui would assert
        if (io.Fonts->AddFontFromFileTTF(file, pixels)) return;
    }
    ImFontConfig config;
    config.SizePixels = std::round(13.0f * scale);
    io.Fonts->AddFontDefault(&config);
}

void colour(ImGuiStyle& style) {
    ImVec4* c = style.Colors;
    c[ImGuiCol_Text] = rgb(222, 220, 216);
    c[ImGuiCol_TextDisabled] = rgb(138, 138, 140);
    c[ImGuiCol_WindowBg] = rgb(29, 30, 33);
    c[ImGuiCol_ChildBg] = rgb(29, 30, 33, 0.0f);
    c[ImGuiCol_PopupBg] = rgb(38, 39, 43);
    c[ImGuiCol_Border] = rgb(58, 60, 65);
    c[ImGuiCol_FrameBg] = rgb(45, 47, 52);
    c[ImGuiCol_FrameBgHovered] = rgb(58, 60, 67);
    c[ImGuiCol_FrameBgActive] = rgb(66, 68, 76);
    c[ImGuiCol_TitleBg] = c[ImGuiCol_TitleBgActive] = rgb(38, 39, 43);
    c[ImGuiCol_ScrollbarBg] = rgb(29, 30, 33);
    c[ImGuiCol_ScrollbarGrab] = rgb(104, 106, 114);
    c[ImGuiCol_CheckMark] = rgb(236, 142, 66);
    c[ImGuiCol_SliderGrab] = rgb(198, 122, 62);
    c[ImGuiCol_SliderGrabActive] = rgb(236, 142, 66);
    c[ImGuiCol_Button] = rgb(54, 56, 62);
    c[ImGuiCol_ButtonHovered] = rgb(72, 74, 82);
    c[ImGuiCol_ButtonActive] = rgb(158, 92, 42);
    c[ImGuiCol_Header] = rgb(42, 44, 49);
    c[ImGuiCol_HeaderHovered] = rgb(56, 58, 64);
    c[ImGuiCol_HeaderActive] = rgb(64, 66, 73);
    c[ImGuiCol_Separator] = rgb(52, 54, 59);
    c[ImGuiCol_PlotLines] = rgb(150, 178, 206);
    c[ImGuiCol_PlotHistogram] = rgb(236, 142, 66);
    c[ImGuiCol_TextSelectedBg] = rgb(236, 142, 66, 0.35f);
    c[ImGuiCol_ModalWindowDimBg] = rgb(10, 10, 12, 0.45f);
}

} // namespace

void apply_style(float scale) {
    ImGui::StyleColorsDark();
    ImGuiStyle& style = ImGui::GetStyle();
    style.WindowPadding = {10.0f, 8.0f};
    style.FramePadding = {7.0f, 3.0f};
    style.ItemSpacing = {7.0f, 5.0f};
    style.ItemInnerSpacing = {6.0f, 4.0f};
    style.ScrollbarSize = 11.0f;
    style.GrabMinSize = 4.0f;
    style.WindowRounding = 0.0f;
    style.FrameRounding = 4.0f;
    style.PopupRounding = 5.0f;
    style.GrabRounding = 4.0f;
    style.WindowBorderSize = 0.0f;
    style.PopupBorderSize = 1.0f;
    colour(style);
    style.ScaleAllSizes(scale);
    add_font(scale);
}

} // namespace brittle::tools

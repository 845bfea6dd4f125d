#include "engine/render/scene.h"

#include <cmath>

#include <glm/common.hpp>

namespace brittle::engine {

// Colours of nearly one lightness and of one chroma in Oklab (Ottosson 2020), so that no piece stands out. Hues step by
// the golden angle, so that consecutive pieces, which are often neighbours, never look alike.
glm::vec3 piece_tint(uint32_t index) {
    constexpr float lightness = 0.86f;
    constexpr float chroma = 0.085f;
    constexpr double golden_turn = 0.6180339887498949;
    const double turn = 0.12 + golden_turn * index;
    const auto hue = static_cast<float>((turn - std::floor(turn)) * 6.283185307179586);
    // Lightness alternates between three levels, because more than about a dozen hues look alike.
    const float l0 = lightness + 0.035f * (static_cast<float>(index % 3) - 1.0f);
    const float a = chroma * std::cos(hue), b = chroma * std::sin(hue);

    const auto cube = [](float x) { return x * x * x; };
    const float l = cube(l0 + 0.3963377774f * a + 0.2158037573f * b);
    const float m = cube(l0 - 0.1055613458f * a - 0.0638541728f * b);
    const float s = cube(l0 - 0.0894841775f * a - 1.2914855480f * b);
    const glm::vec3 linear(4.0767416621f * l - 3.3077115913f * m + 0.2309699292f * s,
                           -1.2684380046f * l + 2.6097574011f * m - 0.3413193965f * s,
                           -0.0041960863f * l - 0.7034186147f * m + 1.7076147010f * s);
    return glm::clamp(linear, glm::vec3(0.0f), glm::vec3(1.0f));
}

} // namespace brittle::engine

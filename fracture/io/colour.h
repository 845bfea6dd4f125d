// Between linear light and sRGB (IEC 61966-2-1), both in 0 .. 1.
#pragma once

#include <cmath>

namespace brittle::fracture {

[[nodiscard]] inline double linear_of_srgb(double value) {
    return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

[[nodiscard]] inline double srgb_of_linear(double value) {
    return value <= 0.0031308 ? value * 12.92 : 1.055 * std::pow(value, 1.0 / 2.4) - 0.055;
}

} // namespace brittle::fracture

// Pixel formats of images, free of Vulkan's types; access_vulkan.cpp maps them.
#pragma once

#include <cstdint>

namespace brittle::engine {

enum class Format : std::uint8_t {
    r8_unorm,
    rgba8_unorm,
    bgra8_unorm,
    r32_uint,
    r32_float,
    rg16_float,
    rgba16_float,
    d32_float // the one depth format
};

} // namespace brittle::engine

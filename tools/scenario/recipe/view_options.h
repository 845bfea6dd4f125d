// Size, device and quality of pictures: options of every command that draws.
#pragma once

#include <cstdint>
#include <string>

namespace brittle::tools {

struct ViewOptions {
    std::string device; // as in engine::DeviceOptions::select
    uint32_t width = 1280;
    uint32_t height = 720;
    std::string quality = "auto"; // auto, fast or best
    bool validation = false;      // run under the Vulkan validation layer, and fail if it reports anything
};

} // namespace brittle::tools

#include "engine/render/quality.h"

#include <algorithm>
#include <string>

#include "engine/gpu/device.h"

namespace brittle::engine {

namespace {

constexpr uint32_t max_shadow_size = 8192;
// Share of the picture's sides; smaller pictures show little more than colours.
constexpr float min_scale = 0.25f;

} // namespace

// The defaults of a CPU device keep lavapipe at interactive rates: at 1280x720, 4 samples or 16 shadow taps multiply the
// time of a frame by 1.5 to 2, and ambient occlusion by 4 to 6.
Result<Quality> choose_quality(Quality quality, const Device& device) {
    const bool cpu = device.is_cpu();
    if (!quality.shadow_size) quality.shadow_size = cpu ? 1024 : 2048;
    if (!quality.soft_shadows) quality.soft_shadows = !cpu;
    if (!quality.samples) quality.samples = cpu ? 1 : 4;
    if (!quality.ambient_occlusion) quality.ambient_occlusion = !cpu;
    if (!quality.culling) quality.culling = device.has_multi_draw();
    if (!quality.front_to_back) quality.front_to_back = cpu;
    if (!quality.moving_scale) quality.moving_scale = cpu ? 0.5f : 1.0f;

    const uint32_t size = *quality.shadow_size;
    const uint32_t max_size = std::min(max_shadow_size, device.limits().maxImageDimension2D);
    if (size < min_shadow_size || size > max_size)
        return Error{Status::invalid_argument,
                     "a shadow map of " + std::to_string(size) + " texels a side is out of range, which is "
                         + std::to_string(min_shadow_size) + " to " + std::to_string(max_size)};
    // Every device supports 1 and 4 samples for all formats that Brittle uses; other numbers are optional.
    if (*quality.samples != 1 && *quality.samples != 4)
        return Error{Status::invalid_argument,
                     std::to_string(*quality.samples) + " samples a pixel are not supported: use 1 or 4"};
    if (!(*quality.moving_scale >= min_scale && *quality.moving_scale <= 1.0f))
        return Error{Status::invalid_argument, "a moving_scale of " + std::to_string(*quality.moving_scale)
                                                   + " is out of range, which is 0.25 to 1"};
    return quality;
}

} // namespace brittle::engine

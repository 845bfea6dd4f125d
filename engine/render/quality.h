// The trade-off between time and quality of a picture.
//
//     RendererSettings settings{.quality = {.samples = 4}}; // the other members are chosen for the device
#pragma once

#include <cstdint>
#include <optional>

#include "engine/core/result.h"

namespace brittle::engine {

class Device;

// Smallest side of a shadow map, texels.
inline constexpr uint32_t min_shadow_size = 64;

// An unset member is chosen for the device: cheap on a CPU, good on a GPU.
struct Quality {
    std::optional<uint32_t> shadow_size{}; // shadow map texels a side, 64 to 8192; default: 1024 on a CPU, else 2048
    // 16 filter taps instead of 1, on a GPU each of 2x2 texels; default: on a GPU only.
    std::optional<bool> soft_shadows{};
    std::optional<uint32_t> samples{}; // samples a pixel, 1 or 4; default: 1 on a CPU, 4 on a GPU
    // Screen-space ambient occlusion, which darkens gaps and the ground under objects; default: on a GPU only.
    std::optional<bool> ambient_occlusion{};
    // Frustum culling of pieces on the device, which does not change the picture; default: if the device has
    // multi-draws.
    std::optional<bool> culling{};
    // Draws near pieces first, sorted on the CPU in each frame, so that hidden pixels are not shaded. Changes the
    // picture only where surfaces coincide. Default: on a CPU only.
    std::optional<bool> front_to_back{};
    // The scale of the picture's sides, 0.25 to 1, while Scene::moved is true; it also scales shadow_size. The picture
    // is upscaled, and the user interface is drawn on it in full resolution. Applies to present() and
    // render_as_presented() only; scenes without motion, and render(), use full resolution. Default: 0.5 on a CPU, 1 on a GPU. Always 1 if the window system does
    // not support transfers to its images.
    std::optional<float> moving_scale{};
};

// Chooses the unset members for the device. Fails with invalid_argument when a member is out of its range.
[[nodiscard]] Result<Quality> choose_quality(Quality quality, const Device& device);

} // namespace brittle::engine

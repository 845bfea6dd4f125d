// Device, renderer settings, view and validation check, shared by the commands that draw.
#pragma once

#include <memory>

#include "engine/camera/camera.h"
#include "engine/gpu/device.h"
#include "engine/render/renderer.h"
#include "tools/scenario/recipe/view_options.h"

namespace brittle::tools {

// Opens the device of the options. For tests, the environment variable BRITTLE_FAULTS injects failures
// (engine/gpu/fault.h). Throws a Failure.
[[nodiscard]] std::unique_ptr<engine::Device> open_device(const ViewOptions& view);

// Returns the settings for ViewOptions::quality: those that the device can afford, the lowest, or the highest at any
// cost.
[[nodiscard]] engine::RendererSettings renderer_settings(const ViewOptions& view);

// Returns renderer_settings() with a finer shadow map, for pictures in files: writing a file takes longer than drawing
// that shadow map.
[[nodiscard]] engine::RendererSettings film_settings(const ViewOptions& view);

// Returns the bounds that the camera looks at: the unbroken mesh, the ground below it and some room for pieces to
// spread.
[[nodiscard]] engine::Bounds stage_view(const engine::Bounds& mesh);

// Throws a Failure if the validation layer was on and reported anything. Its messages are on standard error by then.
void check_validation(const engine::Device& device);

} // namespace brittle::tools

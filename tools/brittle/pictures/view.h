// What the commands that draw have in common: the device, the camera, the check of the validation layer.
#pragma once

#include <memory>

#include "engine/gpu/device.h"
#include "engine/render/camera.h"
#include "engine/render/renderer.h"
#include "tools/brittle/recipe/view_options.h"

namespace brittle::tools {

// With the failures that the variable BRITTLE_FAULTS orders, for tests (engine/gpu/fault.h).
[[nodiscard]] std::unique_ptr<engine::Device> open_device(const ViewOptions& view);

// By ViewOptions::quality: what the device is good for, or the least, or the most whatever it costs.
[[nodiscard]] engine::RendererSettings renderer_settings(const ViewOptions& view);

// Of pictures that go to files: the same with a finer shadow map, as a file takes longer to write than that to draw.
[[nodiscard]] engine::RendererSettings film_settings(const ViewOptions& view);

// Around the unbroken mesh, the ground below it and some room for pieces to spread: what the camera looks at.
[[nodiscard]] engine::Bounds stage_view(const engine::Bounds& mesh);

// Throws a Failure when validation was asked for and had something to say; the messages are on standard error by then.
void check_validation(const engine::Device& device);

} // namespace brittle::tools

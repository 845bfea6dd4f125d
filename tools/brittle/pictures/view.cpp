#include "tools/brittle/pictures/view.h"

#include <cstdlib>

#include "tools/brittle/base/device_failure.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {

std::unique_ptr<engine::Device> open_device(const ViewOptions& view) {
    engine::DeviceOptions options{.select = view.device, .validation = view.validation};
    static engine::FaultInjector faults; // outlives every device
    if (const char* plan = std::getenv("BRITTLE_FAULTS")) {
        must(faults.plan(plan));
        options.faults = &faults;
    }
    return must(engine::Device::create(options));
}

engine::RendererSettings renderer_settings(const ViewOptions& view) {
    if (view.quality == "fast")
        return {.quality = {.shadow_size = 1024, .soft_shadows = false, .samples = 1, .ambient_occlusion = false}};
    if (view.quality == "best")
        return {.quality = {.shadow_size = 4096,
                            .soft_shadows = true,
                            .samples = 4,
                            .ambient_occlusion = true,
                            .moving_scale = 1.0f}};
    return {};
}

engine::RendererSettings film_settings(const ViewOptions& view) {
    engine::RendererSettings settings = renderer_settings(view);
    if (view.quality == "auto") settings.quality.shadow_size = 4096;
    return settings;
}

engine::Bounds stage_view(const engine::Bounds& mesh) {
    const glm::vec3 spread = 0.15f * mesh.size() * glm::vec3(1.0f, 0.0f, 1.0f);
    engine::Bounds view{mesh.min - spread, mesh.max + spread};
    view.min.y = 0.0f;
    return view;
}

void check_validation(const engine::Device& device) {
    const size_t count = device.validation_messages().size();
    if (count > 0) {
        throw Failure(exit_failure, "the Vulkan validation layer reported " + std::to_string(count)
                                        + (count == 1 ? " message" : " messages") + ", printed above");
    }
}

} // namespace brittle::tools

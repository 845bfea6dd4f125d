// A renderer to test, and a stage for it.
#pragma once

#include <memory>

#include <doctest/doctest.h>

#include "support.h"

namespace brittle::engine::test {

inline constexpr glm::uvec2 small{96, 64};

// A device and a renderer, checked at the end for silence of the validation layer. Empty where there is no
// device.
struct Fixture {
    std::unique_ptr<Device> device = make_device();
    std::unique_ptr<Renderer> renderer;

    explicit Fixture(const Quality& quality = {.shadow_size = 512,
                                               .soft_shadows = false,
                                               .samples = 1,
                                               .ambient_occlusion = false}) {
        if (!device) return;
        Result<std::unique_ptr<Renderer>> made = Renderer::create(*device, {.quality = quality});
        REQUIRE(made);
        renderer = *std::move(made);
    }
    ~Fixture() {
        if (!device) return;
        const auto messages = device->share_validation_messages();
        renderer.reset();
        device.reset();
        CHECK(messages->empty());
    }
    explicit operator bool() const { return renderer != nullptr; }

    Bitmap draw(const Scene& scene, glm::uvec2 size = small) const {
        Result<Bitmap> image = renderer->render(scene, size);
        REQUIRE(image);
        REQUIRE(image->pixels.size() == size_t{4} * size.x * size.y);
        return *std::move(image);
    }
};

// Looks at the origin from the front, and nothing else is there.
inline Scene empty_stage() {
    Scene scene{.camera = {{0.0f, 0.0f, 5.0f}, {0.0f, 0.0f, 0.0f}, 0.6f},
                .bounds = {glm::vec3(-1.5f), glm::vec3(1.5f)}};
    scene.ground = false;
    return scene;
}

} // namespace brittle::engine::test

// A renderer under test, and an empty scene.
#pragma once

#include <memory>

#include <doctest/doctest.h>

#include "support.h"

namespace brittle::engine::test {

inline constexpr glm::uvec2 small{96, 64};

inline constexpr Quality plain_quality{
    .shadow_size = 512, .soft_shadows = false, .samples = 1, .ambient_occlusion = false};
inline constexpr Quality automatic_quality{.shadow_size = 128, .soft_shadows = false};

// A renderer on a device with fault injection. The destructor checks that the validation layer reported nothing.
// Without a device, the fixture is empty.
struct Fixture {
    FaultInjector faults; // used unless the constructor got another injector
    std::unique_ptr<Device> device;
    std::unique_ptr<Renderer> renderer;

    explicit Fixture(const RendererSettings& settings, FaultInjector* other_faults = nullptr)
        : device(make_device(other_faults ? other_faults : &faults)) {
        if (!device) return;
        Result<std::unique_ptr<Renderer>> made = Renderer::create(*device, settings);
        REQUIRE(made);
        renderer = *std::move(made);
    }
    explicit Fixture(const Quality& quality = plain_quality) : Fixture(RendererSettings{.quality = quality}) {}
    ~Fixture() {
        if (!device) return;
        const auto messages = device->share_validation_messages();
        renderer.reset();
        device.reset();
        CHECK(messages->empty());
    }
    Fixture(const Fixture&) = delete;
    Fixture& operator=(const Fixture&) = delete;
    explicit operator bool() const { return renderer != nullptr; }

    Bitmap draw(const Scene& scene, glm::uvec2 size = small) const {
        Result<Bitmap> image = renderer->render(scene, size);
        REQUIRE(image);
        REQUIRE(image->pixels.size() == size_t{4} * size.x * size.y);
        return *std::move(image);
    }
};

// Returns a scene without ground whose camera looks at the origin along -Z.
inline Scene empty_stage() {
    Scene scene{.camera = {{0.0f, 0.0f, 5.0f}, {0.0f, 0.0f, 0.0f}, 0.6f},
                .bounds = {glm::vec3(-1.5f), glm::vec3(1.5f)}};
    scene.ground = false;
    return scene;
}

} // namespace brittle::engine::test

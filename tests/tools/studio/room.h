// A session of the studio on a real renderer, without a window.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include <doctest/doctest.h>

#include "tests/engine/support.h"
#include "tools/brittle/base/device_failure.h"
#include "tools/brittle/studio/session.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools::test {

inline constexpr double frame = 1.0 / 60.0; // s

// `device` is null where there is no Vulkan device; the test is skipped then.
class Room {
  public:
    explicit Room(const std::string& mesh, uint32_t sites = 8) : Room(options_of(mesh, sites)) {}
    explicit Room(const FractureOptions& options) : Room(options, Object::load(options)) {}
    Room(const FractureOptions& options, std::shared_ptr<const Object> object) {
        device = engine::test::make_device();
        if (!device) return;
        renderer = must(engine::Renderer::create(*device));
        session = std::make_unique<Session>(options, std::move(object), *renderer, nullptr);
    }
    // Runs frames until the condition holds, for half a minute at most.
    template<class Condition>
    bool soon(const Condition& condition, int frames = 3000) {
        for (int k = 0; k < frames && !condition(); ++k) {
            session->update(frame);
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        return condition();
    }
    void break_it() {
        session->break_all();
        REQUIRE(soon([&] { return session->broken(); }));
    }
    engine::Bitmap picture() {
        const engine::Camera camera = engine::look_at_bounds(session->stage().home_bounds(), 0.5f, 0.3f, 4.0f / 3.0f);
        return must(renderer->render(session->scene(camera), {160, 120}));
    }

    std::unique_ptr<engine::Device> device;
    std::unique_ptr<engine::Renderer> renderer;
    std::unique_ptr<Session> session;

  private:
    static FractureOptions options_of(const std::string& mesh, uint32_t sites) {
        FractureOptions options;
        options.mesh = mesh;
        options.pattern.count = sites;
        return options;
    }
};

} // namespace brittle::tools::test

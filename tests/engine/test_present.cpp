// Drawing into a window while the window system misbehaves. Needs a display: run by tests/with_display.
#include <array>
#include <chrono>
#include <functional>
#include <thread>

#include <doctest/doctest.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "engine/core/window.h"
#include "engine/gpu/swapchain.h"
#include "renderer_fixture.h"

using namespace brittle::engine;
using namespace brittle::engine::test;

namespace {

struct OpenWindow {
    std::unique_ptr<Window> window;

    OpenWindow() {
        Result<std::unique_ptr<Window>> opened = Window::create({.title = "faults", .width = 120, .height = 90});
        REQUIRE(opened);
        window = *std::move(opened);
    }
};

// A window with the known scene. The window outlives the renderer.
struct WindowFixture : OpenWindow, Fixture {
    KnownScene known;

    WindowFixture() : Fixture({.quality = automatic_quality, .vsync = false}) {
        if (renderer) REQUIRE(renderer->set_pieces(known.pieces()));
    }

    Result<bool> present() {
        window->poll();
        return renderer->present(known.scene, [] {});
    }
    void show(int frames = 4) {
        for (int i = 0; i < frames; ++i) {
            const Result<bool> shown = present();
            REQUIRE(shown);
            CHECK(*shown);
        }
    }
    void attach() { REQUIRE(renderer->attach(*window)); }
    bool wait_until(const std::function<bool()>& true_now) {
        for (int i = 0; i < 500; ++i) {
            window->poll();
            if (true_now()) return true;
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        return false;
    }
};

} // namespace

TEST_CASE("the swapchain's extent is prescribed by the surface, or the window's size within its limits") {
    VkSurfaceCapabilitiesKHR can{};
    const auto is = [&](glm::uvec2 window, uint32_t width, uint32_t height) {
        const VkExtent2D extent = choose_extent(can, window);
        return extent.width == width && extent.height == height;
    };
    can.currentExtent = {300, 200};
    CHECK(is({640, 480}, 300, 200));
    can.currentExtent = {0, 0}; // minimised, on Windows
    CHECK(is({640, 480}, 0, 0));
    can.currentExtent = {UINT32_MAX, UINT32_MAX};
    can.minImageExtent = {16, 16};
    can.maxImageExtent = {1000, 1000};
    CHECK(is({640, 480}, 640, 480));
    CHECK(is({2000, 1}, 1000, 16));
    can.minImageExtent = can.maxImageExtent = {0, 0};
    CHECK(is({640, 480}, 0, 0));
}

TEST_CASE("a present mode that is not offered is replaced by FIFO") {
    constexpr std::array all{VK_PRESENT_MODE_IMMEDIATE_KHR, VK_PRESENT_MODE_MAILBOX_KHR, VK_PRESENT_MODE_FIFO_KHR,
                             VK_PRESENT_MODE_FIFO_RELAXED_KHR};
    CHECK(choose_present_mode(all, true) == VK_PRESENT_MODE_FIFO_KHR);
    CHECK(choose_present_mode(all, false) == VK_PRESENT_MODE_MAILBOX_KHR);
    CHECK(choose_present_mode(std::span(all).first(1), false) == VK_PRESENT_MODE_IMMEDIATE_KHR);
    CHECK(choose_present_mode(std::span(all).subspan(2), false) == VK_PRESENT_MODE_FIFO_KHR);
    CHECK(choose_present_mode({}, false) == VK_PRESENT_MODE_FIFO_KHR); // a driver that violates the specification
}

TEST_CASE("attaching a window to a device without swapchains is an error with advice") {
    WindowFixture f;
    if (!f) return;
    FaultInjector faults;
    faults.hide("VK_KHR_swapchain");
    const std::unique_ptr<Device> device = make_device(&faults);
    Result<std::unique_ptr<Renderer>> renderer = Renderer::create(*device);
    REQUIRE(renderer);
    for (int attempt = 0; attempt < 2; ++attempt) {
        const Result<void> attached = (*renderer)->attach(*f.window);
        REQUIRE_FALSE(attached);
        CHECK(attached.error().status == Status::missing_feature);
        CHECK(attached.error().message.find("brittle render") != std::string::npos);
    }
    CHECK((*renderer)->render({}, {40, 30})); // off-screen pictures still work
}

TEST_CASE("an out-of-date swapchain is recreated, and the frame is shown") {
    WindowFixture f;
    if (!f) return;
    f.attach();
    f.show();
    const uint32_t made = f.faults.count(Call::create_swapchain);
    f.faults.fail(Call::acquire, VK_ERROR_OUT_OF_DATE_KHR);
    f.show(1);
    CHECK(f.faults.count(Call::create_swapchain) == made + 1);
    f.show();
    f.faults.fail(Call::present, VK_ERROR_OUT_OF_DATE_KHR);
    f.show();
    CHECK(f.faults.count(Call::create_swapchain) == made + 2);
    // Two failures in one frame: this frame is skipped and the next is shown.
    f.faults.fail(Call::acquire, VK_ERROR_OUT_OF_DATE_KHR, 1, 2);
    const Result<bool> shown = f.present();
    REQUIRE(shown);
    CHECK_FALSE(*shown);
    f.show();
}

TEST_CASE("a suboptimal swapchain is shown, and recreated once only") {
    WindowFixture f;
    if (!f) return;
    f.attach();
    f.show();
    for (const Call kind : {Call::acquire, Call::present}) {
        const uint32_t made = f.faults.count(Call::create_swapchain);
        f.faults.fail(kind, VK_SUBOPTIMAL_KHR);
        f.show();
        CHECK(f.faults.count(Call::create_swapchain) == made + 1);
        f.faults.fail(kind, VK_SUBOPTIMAL_KHR, 1, 10);
        f.show(10);
        CHECK(f.faults.count(Call::create_swapchain) == made + 2);
        f.show();
    }
}

TEST_CASE("a lost surface is recreated") {
    WindowFixture f;
    if (!f) return;
    f.attach();
    f.show();
    for (const Call kind : {Call::acquire, Call::present, Call::create_swapchain}) {
        f.faults.fail(kind, VK_ERROR_SURFACE_LOST_KHR);
        if (kind == Call::create_swapchain) f.faults.fail(Call::acquire, VK_ERROR_OUT_OF_DATE_KHR);
        (void)f.present();
        f.show();
    }
}

TEST_CASE("a window system that holds all images delays one frame only") {
    WindowFixture f;
    if (!f) return;
    f.attach();
    f.show();
    f.faults.fail(Call::acquire, VK_TIMEOUT, 1, 2);
    const Result<bool> shown = f.present();
    REQUIRE(shown);
    CHECK_FALSE(*shown);
    f.show();
}

TEST_CASE("out of memory at any call of a frame in a window is an error, and the next frame is shown") {
    WindowFixture f;
    if (!f) return;
    f.attach();
    for (const VkResult result : {VK_ERROR_OUT_OF_DEVICE_MEMORY, VK_ERROR_OUT_OF_HOST_MEMORY})
        for (const Call kind : {Call::create_swapchain, Call::acquire, Call::submit, Call::present, Call::allocate}) {
            f.show();
            CAPTURE(static_cast<int>(kind));
            f.faults.fail(Call::present, VK_ERROR_OUT_OF_DATE_KHR); // the swapchain is recreated, too
            f.show(1);
            if (kind == Call::allocate) { // makes the arenas grow, so that there is an allocation
                f.faults.fail(kind, result);
                const auto added = f.renderer->add_pieces(f.known.pieces());
                REQUIRE_FALSE(added);
                CHECK(added.error().status == Status::out_of_memory);
                continue;
            }
            f.faults.fail(kind, result);
            const Result<bool> shown = f.present();
            REQUIRE_FALSE(shown);
            CHECK(shown.error().status == Status::out_of_memory);
        }
    f.show();
}

TEST_CASE("attaching a window fails without memory, and a later attempt succeeds") {
    WindowFixture f;
    if (!f) return;
    f.faults.fail(Call::submit, VK_ERROR_OUT_OF_DEVICE_MEMORY);
    const Result<void> attached = f.renderer->attach(*f.window);
    REQUIRE_FALSE(attached);
    CHECK(attached.error().status == Status::out_of_memory);
    f.attach();
    f.show();
}

TEST_CASE("a device lost while a window is attached is reported, and all objects can be destroyed") {
    for (const Call kind : {Call::acquire, Call::submit, Call::wait, Call::present}) {
        WindowFixture f;
        if (!f) return;
        f.attach();
        f.show();
        f.faults.fail(kind, VK_ERROR_DEVICE_LOST);
        for (int again = 0; again < 3; ++again) {
            const Result<bool> shown = f.present();
            REQUIRE_FALSE(shown);
            CHECK(shown.error().status == Status::device_lost);
        }
    }
}

TEST_CASE("a device that hangs while a window is attached is reported, and all objects can be destroyed") {
    WindowFixture f;
    if (!f) return;
    f.attach();
    f.show();
    f.faults.fail(Call::wait, VK_TIMEOUT);
    const Result<bool> shown = f.present();
    REQUIRE_FALSE(shown);
    CHECK(shown.error().status == Status::device_lost);
}

TEST_CASE("full and upscaled frames may alternate, at any size of the window") {
    WindowFixture f;
    if (!f) return;
    f.attach();
    const float scale = *f.renderer->quality().moving_scale;
    for (const glm::ivec2 size : {glm::ivec2(120, 90), glm::ivec2(121, 91), glm::ivec2(37, 1), glm::ivec2(1)}) {
        glfwSetWindowSize(f.window->handle(), size.x, size.y);
        REQUIRE(f.wait_until([&] { return f.window->framebuffer_size() == glm::uvec2(size); }));
        for (int frame = 0; frame < 8; ++frame) {
            f.known.scene.moved = frame % 3 == 0;
            f.show(1);
            CHECK(f.renderer->stats().scale == (f.known.scene.moved ? scale : 1.0f));
            const bool enlarged = f.renderer->graph_dot().find("upscale") != std::string::npos;
            CHECK(enlarged == (f.known.scene.moved && scale < 1.0f));
        }
    }
}

TEST_CASE("a minimised window is not drawn into, and is drawn into again once it is restored") {
    WindowFixture f;
    if (!f) return;
    f.attach();
    f.show();
    for (int round = 0; round < 3; ++round) {
        glfwIconifyWindow(f.window->handle());
        REQUIRE(f.wait_until([&] { return f.window->framebuffer_size() == glm::uvec2(0); }));
        const uint32_t presented = f.faults.count(Call::present);
        const Result<bool> shown = f.present();
        REQUIRE(shown);
        CHECK_FALSE(*shown);
        CHECK(f.faults.count(Call::present) == presented);
        glfwRestoreWindow(f.window->handle());
        REQUIRE(f.wait_until([&] { return f.window->framebuffer_size() != glm::uvec2(0); }));
        f.show();
    }
}

TEST_CASE("a window that is resized before each frame is drawn into at each size") {
    WindowFixture f;
    if (!f) return;
    f.attach();
    int shown = 0;
    for (int i = 0; i < 60; ++i) {
        glfwSetWindowSize(f.window->handle(), 60 + 37 * i % 200, 50 + 53 * i % 150);
        const Result<bool> done = f.present();
        REQUIRE(done);
        shown += *done;
    }
    CHECK(shown > 30);
    glfwSetWindowSize(f.window->handle(), 1, 1);
    REQUIRE(f.wait_until([&] { return f.window->framebuffer_size() == glm::uvec2(1); }));
    f.show();
}

// The engine's response to failures of the machine, which are injected (engine/gpu/fault.h). Failures of windows are in
// test_present.cpp, and failures of the whole program in tests/tools.
#include <algorithm>
#include <array>
#include <new>
#include <regex>

#include <doctest/doctest.h>

#include "engine/compute/gpu_classifier.h"
#include "fracture/fracture.h"
#include "fracture/shapes/shapes.h"
#include "renderer_fixture.h"

using namespace brittle::engine;
using namespace brittle::engine::test;

namespace {

bool has(const Error& error, const std::string& text) {
    return error.message.find(text) != std::string::npos;
}

// More than drivers add to the size of an allocation.
constexpr uint64_t driver_rounding = 128 << 10;

// Returns the size that the message of a failed allocation names, or 0.
uint64_t bytes_in(const Error& error) {
    static const std::regex allocation("allocate ([0-9]+) bytes of device memory");
    std::smatch found;
    return std::regex_search(error.message, found, allocation) ? std::stoull(found[1]) : 0;
}

// A fixture whose renderer has the pieces of the known scene.
struct KnownFixture : Fixture {
    KnownScene known;

    KnownFixture() : Fixture(automatic_quality) {}
    using Fixture::draw;
    [[nodiscard]] Bitmap draw() const { return draw(known.scene); }
};

} // namespace

TEST_CASE("fault injection: exactly the chosen calls fail") {
    FaultInjector faults;
    int made = 0;
    const auto call = [&](Call kind) {
        return faults.attempt(kind, [&] {
            ++made;
            return VK_SUCCESS;
        });
    };
    faults.fail(Call::allocate, VK_ERROR_OUT_OF_DEVICE_MEMORY, 2, 2);
    CHECK(call(Call::allocate) == VK_SUCCESS);
    CHECK(call(Call::map) == VK_SUCCESS);
    CHECK(call(Call::allocate) == VK_ERROR_OUT_OF_DEVICE_MEMORY);
    CHECK(call(Call::allocate) == VK_ERROR_OUT_OF_DEVICE_MEMORY);
    CHECK(call(Call::allocate) == VK_SUCCESS);
    CHECK(made == 3);
    CHECK(faults.count(Call::allocate) == 4);

    // The real call is made for a failed present and for a suboptimal acquire.
    faults.fail(Call::present, VK_ERROR_OUT_OF_DATE_KHR);
    faults.fail(Call::acquire, VK_SUBOPTIMAL_KHR);
    CHECK(call(Call::present) == VK_ERROR_OUT_OF_DATE_KHR);
    CHECK(call(Call::acquire) == VK_SUBOPTIMAL_KHR);
    CHECK(made == 5);

    faults.fail(Call::submit, VK_ERROR_DEVICE_LOST);
    CHECK(call(Call::submit) == VK_ERROR_DEVICE_LOST);
    CHECK(made == 5);
    CHECK(call(Call::submit) == VK_ERROR_DEVICE_LOST); // permanent
    CHECK(call(Call::acquire) == VK_ERROR_DEVICE_LOST);
    CHECK(made == 5);
    CHECK(call(Call::wait) == VK_ERROR_DEVICE_LOST);
    CHECK(made == 6);
}

TEST_CASE("fault injection: a plan is parsed, and an invalid one is refused with its text") {
    FaultInjector faults;
    REQUIRE(faults.plan("allocate:-2:3:2,hide:multiDrawIndirect,submit:-4:1"));
    CHECK(faults.hides("multiDrawIndirect"));
    CHECK_FALSE(faults.hides("drawIndirectFirstInstance"));
    const auto allocate = [&] { return faults.attempt(Call::allocate, [] { return VK_SUCCESS; }); };
    CHECK(allocate() == VK_SUCCESS);
    CHECK(allocate() == VK_SUCCESS);
    CHECK(allocate() == VK_ERROR_OUT_OF_DEVICE_MEMORY);
    CHECK(allocate() == VK_ERROR_OUT_OF_DEVICE_MEMORY);
    CHECK(allocate() == VK_SUCCESS);
    REQUIRE(faults.plan(""));
    for (const char* bad : {"explode:-4:1", "submit", "submit:-4", "submit:-4:0", "submit:lost:1", "submit:-4:1:0",
                            "submit:-4:1:2:3", "hide:", "submit:-4:99999999999"}) {
        CAPTURE(bad);
        const Result<void> read = faults.plan(bad);
        REQUIRE_FALSE(read);
        CHECK(read.error().status == Status::invalid_argument);
        CHECK(has(read.error(), bad));
    }
}

TEST_CASE("a missing feature is named in the error, for the automatic choice and for a choice by index") {
    FaultInjector faults;
    const std::unique_ptr<Device> whole = make_device();
    if (!whole) return;
    faults.hide("drawIndirectFirstInstance");
    faults.hide("synchronization2");
    for (const std::string& select : {std::string(), std::to_string(whole->info().index)}) {
        const Result<std::unique_ptr<Device>> device = Device::create({.select = select, .faults = &faults});
        REQUIRE_FALSE(device);
        CHECK(device.error().status == (select.empty() ? Status::no_device : Status::missing_feature));
        CHECK(has(device.error(), "it lacks the feature drawIndirectFirstInstance, synchronization2"));
        CHECK(has(device.error(), whole->info().name));
    }
}

TEST_CASE("a request for a missing validation layer fails and says what to install") {
    FaultInjector faults;
    if (!make_device()) return;
    faults.hide("VK_LAYER_KHRONOS_validation");
    const Result<std::unique_ptr<Device>> device = Device::create({.validation = true, .faults = &faults});
    REQUIRE_FALSE(device);
    CHECK(device.error().status == Status::missing_feature);
    CHECK(has(device.error(), "vulkan-validationlayers"));
}

TEST_CASE("a device without surface or swapchain extensions still draws pictures") {
    for (const char* extension : {"VK_KHR_surface", "VK_KHR_swapchain"}) {
        FaultInjector faults;
        faults.hide(extension);
        const std::unique_ptr<Device> device = make_device(&faults);
        if (!device) return;
        CHECK_FALSE(device->can_present());
        Result<std::unique_ptr<Renderer>> renderer = Renderer::create(*device);
        REQUIRE(renderer);
        CHECK((*renderer)->render({}, small));
        CHECK(device->validation_messages().empty());
    }
}

TEST_CASE("the failure to create a device names the device and the reason") {
    const std::unique_ptr<Device> whole = make_device();
    if (!whole) return;
    const struct {
        VkResult result;
        Status status;
    } cases[] = {{VK_ERROR_INITIALIZATION_FAILED, Status::device_failure},
                 {VK_ERROR_DEVICE_LOST, Status::device_lost},
                 {VK_ERROR_TOO_MANY_OBJECTS, Status::device_failure},
                 {VK_ERROR_OUT_OF_HOST_MEMORY, Status::out_of_memory},
                 {VK_ERROR_OUT_OF_DEVICE_MEMORY, Status::out_of_memory}};
    for (const auto& [result, status] : cases) {
        FaultInjector faults;
        faults.fail(Call::create_device, result);
        const Result<std::unique_ptr<Device>> device =
            Device::create({.select = whole->info().name, .faults = &faults});
        REQUIRE_FALSE(device);
        CHECK(device.error().status == status);
        CHECK(has(device.error(), whole->info().name));
        CHECK(Device::create({.select = whole->info().name, .faults = &faults})); // the fault covers one call
    }
}

TEST_CASE("out of memory at any allocation of Renderer::create() is an error, and the next attempt succeeds") {
    FaultInjector faults;
    const std::unique_ptr<Device> device = make_device(&faults);
    if (!device) return;
    const RendererSettings settings{.quality = {.shadow_size = 128, .soft_shadows = false}};
    for (const VkResult result : {VK_ERROR_OUT_OF_DEVICE_MEMORY, VK_ERROR_OUT_OF_HOST_MEMORY})
        for (const Call kind : {Call::allocate, Call::map}) {
            for (uint32_t n = 1;; ++n) {
                const uint32_t before = faults.count(kind);
                faults.fail(kind, result, n);
                const Result<std::unique_ptr<Renderer>> made = Renderer::create(*device, settings);
                if (made) {
                    CHECK(n > 1);
                    CHECK(faults.count(kind) == before + n - 1);
                    break;
                }
                CHECK(made.error().status == Status::out_of_memory);
                CHECK(has(made.error(), kind == Call::map ? "map" : "bytes"));
                CHECK(has(made.error(), "Close other programs"));
            }
            faults.fail(kind, VK_SUCCESS);
        }
    CHECK(device->validation_messages().empty());
}

TEST_CASE("out of memory in set_pieces() names the size and keeps the old pieces") {
    KnownFixture f;
    if (!f) return;
    REQUIRE(f.renderer->set_pieces(f.known.pieces()));
    const Bitmap before = f.draw();
    const Shape ball = icosphere(1.0f, 4);
    const PieceMesh piece = ball.piece(7);
    int refused = 0;
    for (uint32_t n = 1;; ++n, ++refused) {
        f.faults.fail(Call::allocate, VK_ERROR_OUT_OF_DEVICE_MEMORY, n);
        const auto set = f.renderer->set_pieces({&piece, 1});
        f.faults.fail(Call::allocate, VK_SUCCESS);
        if (set) break;
        CHECK(set.error().status == Status::out_of_memory);
        CHECK(has(set.error(), " bytes of device memory"));
        if (n == 1) {
            const uint64_t asked = ball.positions.size() * sizeof(glm::vec3), named = bytes_in(set.error());
            CHECK(named >= asked);
            CHECK(named < asked + driver_rounding);
        }
        CHECK(f.renderer->body_count() == 4);
        CHECK(f.draw().pixels == before.pixels);
    }
    CHECK(refused == 3); // one allocation each for the arenas of vertices, normals and indices
    CHECK(f.renderer->body_count() == 8);
}

TEST_CASE("out of memory in a frame fails that frame only") {
    KnownFixture f;
    if (!f) return;
    REQUIRE(f.renderer->set_pieces(f.known.pieces()));
    const Bitmap before = f.draw();
    (void)f.draw(); // both frame slots now have their buffers
    const glm::uvec2 larger{200, 150};
    for (const Call kind : {Call::allocate, Call::map, Call::submit}) {
        for (uint32_t n = 1;; ++n) {
            f.faults.fail(kind, VK_ERROR_OUT_OF_DEVICE_MEMORY, n);
            const Result<Bitmap> image = f.renderer->render(f.known.scene, larger);
            f.faults.fail(kind, VK_SUCCESS);
            if (image) break;
            CHECK(image.error().status == Status::out_of_memory);
            CHECK(f.draw().pixels == before.pixels);
            REQUIRE(n < 20);
        }
    }
}

TEST_CASE("exhausted host memory in a callback fails that frame only") {
    KnownFixture f;
    if (!f) return;
    REQUIRE(f.renderer->set_pieces(f.known.pieces()));
    const Bitmap before = f.draw();
    Scene scene = f.known.scene;
    scene.write_poses = [](std::span<BodyPose>, uint64_t) { throw std::bad_alloc(); };
    const Result<Bitmap> image = f.renderer->render(scene, small);
    REQUIRE_FALSE(image);
    CHECK(image.error().status == Status::out_of_memory);
    CHECK(f.draw().pixels == before.pixels);
}

TEST_CASE("a lost device is reported by every call that meets it, and all objects can be destroyed") {
    for (const Call kind : {Call::submit, Call::wait}) {
        KnownFixture f;
        if (!f) return;
        REQUIRE(f.renderer->set_pieces(f.known.pieces()));
        (void)f.draw();
        f.faults.fail(kind, VK_ERROR_DEVICE_LOST);
        const Result<Bitmap> image = f.renderer->render(f.known.scene, small);
        REQUIRE_FALSE(image);
        CHECK(image.error().status == Status::device_lost);
        CHECK(has(image.error(), "the device was lost"));
        CHECK(has(image.error(), "start again"));
        for (int again = 0; again < 3; ++again) {
            const Result<Bitmap> next = f.renderer->render(f.known.scene, small);
            REQUIRE_FALSE(next);
            CHECK(next.error().status == Status::device_lost);
        }
        const auto set = f.renderer->set_pieces(f.known.pieces());
        REQUIRE_FALSE(set);
        CHECK(set.error().status == Status::device_lost);
        CHECK(f.renderer->body_count() == 4);
        CHECK_FALSE(f.renderer->warm_up());
    }
}

TEST_CASE("after a device is lost during an upload, all staged memory is freed") {
    KnownFixture f;
    if (!f) return;
    REQUIRE(f.renderer->set_pieces(f.known.pieces())); // the next frame uploads them
    f.faults.fail(Call::wait, VK_ERROR_DEVICE_LOST);
    const Result<Bitmap> image = f.renderer->render(f.known.scene, small);
    REQUIRE_FALSE(image);
    CHECK(image.error().status == Status::device_lost);
}

TEST_CASE("pieces whose frame fails are uploaded by the next one, whether arenas grow or not") {
    KnownFixture f;
    if (!f) return;
    const std::vector<PieceMesh> pieces = f.known.pieces();
    REQUIRE(f.renderer->set_pieces(pieces));
    const Bitmap expected = f.draw();
    REQUIRE(f.renderer->set_pieces({}));
    int failed = 0;
    for (size_t i = 0; i < pieces.size(); ++i) { // each piece makes the arenas grow
        for (const Call kind : {Call::allocate, Call::map, Call::submit}) {
            REQUIRE(f.renderer->add_pieces({&pieces[i], 1}));
            f.faults.fail(kind, VK_ERROR_OUT_OF_DEVICE_MEMORY);
            failed += !f.renderer->render(f.known.scene, small);
            f.faults.fail(kind, VK_SUCCESS);
        }
        (void)f.draw();
    }
    CHECK(failed > 4);
    CHECK(f.renderer->stats().pieces == 12);
    CHECK(f.draw().pixels == expected.pixels); // every piece is there three times, at one pose
}

TEST_CASE("a hung device is reported as lost, with the timeout") {
    KnownFixture f;
    if (!f) return;
    REQUIRE(f.renderer->set_pieces(f.known.pieces()));
    f.faults.fail(Call::wait, VK_TIMEOUT);
    const Result<Bitmap> image = f.renderer->render(f.known.scene, small);
    REQUIRE_FALSE(image);
    CHECK(image.error().status == Status::device_lost);
    CHECK(has(image.error(), "hangs"));
    CHECK(has(image.error(), " s."));
}

TEST_CASE("when the device fails during classification, the CPU classifies and the pieces are equal") {
    FaultInjector faults;
    const std::unique_ptr<Device> device = make_device(&faults);
    if (!device) return;
    Result<std::unique_ptr<GpuClassifier>> classifier = GpuClassifier::create(*device);
    REQUIRE(classifier);
    const auto mesh = brittle::fracture::icosphere(3);
    const std::vector<glm::dvec3> sites{{0.5, 0.1, 0.2}, {-0.5, 0.2, 0.1}, {0.1, -0.6, 0.3}};
    const auto positions = [&](brittle::fracture::Classifier* by) {
        const auto broken = brittle::fracture::fracture(mesh, sites, {.classifier = by});
        REQUIRE(broken);
        return broken->positions;
    };
    const auto expected = positions(nullptr);
    CHECK(positions(classifier->get()) == expected);
    const struct {
        Call kind;
        VkResult result;
    } cases[] = {{Call::submit, VK_ERROR_OUT_OF_DEVICE_MEMORY},
                 {Call::submit, VK_ERROR_DEVICE_LOST},
                 {Call::wait, VK_ERROR_DEVICE_LOST}};
    for (const auto& [kind, result] : cases) {
        faults.fail(kind, result);
        CHECK(positions(classifier->get()) == expected);
        CHECK_FALSE((*classifier)->error().empty());
    }
    const auto messages = device->share_validation_messages();
    classifier->reset();
    CHECK(messages->empty());
}

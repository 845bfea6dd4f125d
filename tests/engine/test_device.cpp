#include <cstdlib>

#include <doctest/doctest.h>

#include "engine/gpu/device.h"
#include "support.h"

using namespace brittle::engine;
using namespace brittle::engine::test;

TEST_CASE("without a driver, the error says what to install") {
    // The loader reads the variable once in a process; ctest runs each test case in its own process.
    setenv("VK_DRIVER_FILES", "/nonexistent.json", 1);
    setenv("VK_ICD_FILENAMES", "/nonexistent.json", 1);
    const Result<std::unique_ptr<Device>> device = Device::create();
    unsetenv("VK_DRIVER_FILES");
    unsetenv("VK_ICD_FILENAMES");
    REQUIRE_FALSE(device);
    CHECK((device.error().status == Status::no_driver || device.error().status == Status::no_device));
    if (device.error().status == Status::no_driver)
        CHECK(device.error().message.find("mesa-vulkan-drivers") != std::string::npos);
}

TEST_CASE("selecting a device that does not exist fails with the list of devices") {
    if (!make_device()) return;
    const Result<std::vector<DeviceInfo>> infos = list_devices();
    REQUIRE(infos);
    REQUIRE_FALSE(infos->empty());
    for (const char* select : {"9999", "no such device", "99999999999999999999"}) {
        CAPTURE(select);
        const Result<std::unique_ptr<Device>> device = Device::create({.select = select});
        REQUIRE_FALSE(device);
        CHECK(device.error().status == Status::no_device);
        CHECK(device.error().message.find(select) != std::string::npos);
        CHECK(device.error().message.find(infos->front().name) != std::string::npos);
    }
}

TEST_CASE("each usable device can be selected by its index and by part of its name") {
    if (!make_device()) return;
    const Result<std::vector<DeviceInfo>> infos = list_devices();
    REQUIRE(infos);
    for (const DeviceInfo& info : *infos) {
        if (!info.problem.empty()) continue;
        CAPTURE(info.name);
        Result<std::unique_ptr<Device>> by_index = Device::create({.select = std::to_string(info.index)});
        REQUIRE(by_index);
        CHECK((*by_index)->info().index == info.index);
        Result<std::unique_ptr<Device>> by_name = Device::create({.select = info.name.substr(0, 6)});
        REQUIRE(by_name);
        CHECK((*by_name)->info().name.substr(0, 6) == info.name.substr(0, 6));
    }
}

TEST_CASE("the automatic choice is the best kind of device") {
    const std::unique_ptr<Device> device = make_device();
    if (!device || std::getenv("BRITTLE_TEST_DEVICE")) return;
    const Result<std::vector<DeviceInfo>> infos = list_devices();
    REQUIRE(infos);
    for (const DeviceInfo& info : *infos)
        if (info.problem.empty()) CHECK(device->info().kind <= info.kind);
}

TEST_CASE("validation reports a misuse, and a leak at the device's destruction") {
    std::unique_ptr<Device> device = make_device();
    if (!device) return;
    if (Result<std::unique_ptr<Device>> layer = Device::create({.validation = true}); !layer) return;
    CHECK(device->validation_messages().empty());
    VkBuffer buffer = VK_NULL_HANDLE;
    const VkBufferCreateInfo no_usage{
        VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, nullptr, 0, 16, 0, VK_SHARING_MODE_EXCLUSIVE, 0, nullptr};
    vkCreateBuffer(device->handle(), &no_usage, nullptr, &buffer);
    CHECK_FALSE(device->validation_messages().empty());
    vkDestroyBuffer(device->handle(), buffer, nullptr);

#if !defined(__SANITIZE_ADDRESS__) // LeakSanitizer would report the driver's memory of the leaked object
    const auto messages = device->share_validation_messages();
    const size_t before = messages->size();
    const VkFenceCreateInfo fence_info{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, nullptr, 0};
    VkFence leaked = VK_NULL_HANDLE;
    REQUIRE(vkCreateFence(device->handle(), &fence_info, nullptr, &leaked) == VK_SUCCESS);
    device.reset();
    CHECK(messages->size() > before);
#endif
}

TEST_CASE("a clock match converts timestamps before and after it") {
    const ClockMatch match{.ticks = 1'000, .nanoseconds = 5'000, .period = 40.0};
    CHECK(match.host(1'000) == 5'000);
    CHECK(match.host(1'010) == 5'400);
    CHECK(match.host(990) == 4'600);
}

TEST_CASE("both clocks are sampled together, and neither runs backwards") {
    const std::unique_ptr<Device> device = make_device();
    if (!device) return;
    const std::optional<ClockMatch> first = device->match_clocks(), second = device->match_clocks();
    CHECK(first.has_value() == device->has_common_clock());
    if (!first || !second) return;
    CHECK(second->ticks >= first->ticks);
    CHECK(second->nanoseconds >= first->nanoseconds);
    CHECK(device->validation_messages().empty());
}

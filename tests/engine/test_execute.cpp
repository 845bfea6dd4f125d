// The execute half of the frame graph, with plans of transfers whose results are read back.
#include <algorithm>
#include <chrono>
#include <cstring>

#include <doctest/doctest.h>

#include "engine/gpu/check.h"
#include "engine/gpu/commands.h"
#include "engine/gpu/memory.h"
#include "engine/graph/access_vulkan.h"
#include "engine/graph/execute.h"
#include "engine/graph/upload.h"
#include "support.h"

using namespace brittle::engine;
using namespace brittle::engine::test;

namespace {

void run(GraphExecutor& executor, const Device& device, FrameGraph&& graph, const External& external) {
    CompileResult plan = std::move(graph).compile(executor.memory_needs());
    REQUIRE_MESSAGE(plan, plan.error().message);
    CommandSlot commands(device);
    commands.begin();
    executor.record(*plan, external, commands.buffer());
    commands.submit({}, VK_NULL_HANDLE);
    commands.wait();
}

constexpr int64_t max_deviation = 1'000'000; // between the clocks of host and device, nanoseconds

int64_t now() {
    return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Declares a chain of copies through transients that ends in `result`. The transients share memory, so a missing
// barrier or a wrong offset gives a wrong value or a validation message.
void copy_chain(FrameGraph& graph, External& external, const DeviceBuffer& result, uint32_t value, int links) {
    const BufferDesc desc{result.size()};
    Buffer from = graph.create_buffer("link 0", desc);
    graph.add_pass(
        "fill", PassKind::transfer, [&](PassBuilder& p) { from = p.write(from, Access::transfer_write); },
        [from, value](PassContext& c) { vkCmdFillBuffer(c.commands, c.buffer(from), 0, VK_WHOLE_SIZE, value); });
    for (int i = 1; i <= links; ++i) {
        const bool last = i == links;
        Buffer to =
            last ? graph.import_buffer(
                "result", desc, {.initial = {}, .final = Access::host_read, .external = external.add(result.handle())})
                 : graph.create_buffer("link " + std::to_string(i), desc);
        graph.add_pass(
            "copy " + std::to_string(i), PassKind::transfer,
            [&](PassBuilder& p) {
                p.read(from, Access::transfer_read);
                to = p.write(to, Access::transfer_write);
            },
            [from, to, size = desc.size](PassContext& c) {
                const VkBufferCopy region{0, 0, size};
                vkCmdCopyBuffer(c.commands, c.buffer(from), c.buffer(to), 1, &region);
            });
        from = to;
    }
}

} // namespace

TEST_CASE("every access has stages, and usage where a pass may declare it") {
    for (unsigned i = 0; i < static_cast<unsigned>(Access::count); ++i) {
        const auto access = static_cast<Access>(i);
        CAPTURE(to_string(access));
        CHECK(to_vulkan(access).stages != 0);
        if (traits(access).kinds == 0) continue; // legal only as an initial or final access
        CHECK((to_vulkan(access).image_usage != 0) == traits(access).images);
        CHECK((to_vulkan(access).buffer_usage != 0) == traits(access).buffers);
        CHECK(to_vulkan(access).access != 0);
    }
}

TEST_CASE("an empty graph runs") {
    const std::unique_ptr<Device> device = make_device();
    if (!device) return;
    GraphExecutor executor(*device);
    run(executor, *device, FrameGraph(), {});
    CHECK(executor.collect_times().empty());
    CHECK(device->validation_messages().empty());
}

TEST_CASE("values are copied through transients that share memory, in graphs that change from run to run") {
    const std::unique_ptr<Device> device = make_device();
    if (!device) return;
    GraphExecutor executor(*device);
    uint32_t value = 0x1234;
    for (const int links : {1, 2, 6, 6, 3, 9}) {
        for (const uint64_t size : {4u, 65536u}) {
            const DeviceBuffer result(*device, "result", size, VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryKind::readback);
            FrameGraph graph;
            External external;
            copy_chain(graph, external, result, ++value, links);
            const int64_t before = now();
            run(executor, *device, std::move(graph), external);
            const std::span<uint32_t> words = result.mapped_as<uint32_t>(0, size / 4);
            CHECK(std::ranges::all_of(words, [&](uint32_t word) { return word == value; }));
            if (device->limits().timestampComputeAndGraphics) {
                const std::vector<PassTime> times = executor.collect_times();
                REQUIRE(times.size() == static_cast<size_t>(links) + 1);
                CHECK(times[0].name == "fill");
                for (size_t i = 1; i < times.size(); ++i) CHECK(times[i].begin >= times[i - 1].begin);
                CHECK(times.back().begin <= now() + max_deviation);
                if (device->has_common_clock()) CHECK(times[0].begin >= before - max_deviation);
            }
        }
    }
    CHECK(device->validation_messages().empty());
}

TEST_CASE("uploads copy their bytes, and empty uploads are skipped") {
    const std::unique_ptr<Device> device = make_device();
    if (!device) return;
    upload(*device, {});
    constexpr VkBufferUsageFlags usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT;
    const DeviceBuffer a(*device, "a", 64, usage, MemoryKind::readback);
    const DeviceBuffer b(*device, "b", 16, usage, MemoryKind::readback);
    const DeviceBuffer none(*device, "none", 0, usage, MemoryKind::device);
    std::vector<std::byte> bytes(64);
    for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(3 * i + 1);
    const std::span<const std::byte> all(bytes);
    const Upload uploads[] = {
        {&a, all, Access::host_read}, {&none, {}, {}}, {&b, all.subspan(5, 16), Access::host_read}};
    upload(*device, uploads);
    CHECK(std::memcmp(a.mapped(), bytes.data(), 64) == 0);
    CHECK(std::memcmp(b.mapped(), bytes.data() + 5, 16) == 0);
    CHECK(device->validation_messages().empty());
}

TEST_CASE("an allocation without an allowed memory type is an error") {
    const std::unique_ptr<Device> device = make_device();
    if (!device) return;
    const auto allocate = [&]() -> Result<void> {
        const VkDeviceMemory memory =
            allocate_memory(*device, 1024, 0, MemoryKind::device); // no memory type is allowed
        vkFreeMemory(device->handle(), memory, nullptr);
        return {};
    };
    CHECK_FALSE(guarded(allocate));
}

#include "engine/graph/upload.h"

#include <cstring>

#include "engine/gpu/check.h"
#include "engine/gpu/commands.h"
#include "engine/gpu/device.h"
#include "engine/graph/execute.h"

namespace brittle::engine {

namespace {

struct Copy {
    Buffer destination;
    uint64_t offset; // in the staging buffer
    uint64_t size;
};

} // namespace

void upload(const Device& device, std::span<const Upload> uploads) {
    uint64_t size = 0;
    for (const Upload& one : uploads) size += one.bytes.size();
    if (size == 0) return;
    const DeviceBuffer staging(device, "staging", size, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, MemoryKind::upload);

    FrameGraph graph;
    External external;
    const Buffer source = graph.import_buffer(
        "staging", {size},
        {.initial = Access::host_write, .final = {}, .read_only = true, .external = external.add(staging.handle())});
    std::vector<Copy> copies;
    uint64_t offset = 0;
    for (const Upload& one : uploads) {
        if (one.bytes.empty()) continue;
        std::memcpy(staging.mapped() + offset, one.bytes.data(), one.bytes.size());
        const uint64_t object = external.add(one.destination->handle());
        const Buffer destination =
            graph.import_buffer("destination " + std::to_string(copies.size()), {one.destination->size()},
                                {.initial = {}, .final = one.used_as, .external = object});
        copies.push_back({destination, offset, one.bytes.size()});
        offset += one.bytes.size();
    }
    graph.add_pass(
        "upload", PassKind::transfer,
        [&](PassBuilder& pass) {
            pass.read(source, Access::transfer_read);
            for (Copy& copy : copies) copy.destination = pass.write(copy.destination, Access::transfer_write);
        },
        [&](PassContext& context) {
            for (const Copy& copy : copies) {
                const VkBufferCopy region{copy.offset, 0, copy.size};
                vkCmdCopyBuffer(context.commands, context.buffer(source), context.buffer(copy.destination), 1, &region);
            }
        });

    GraphExecutor executor(device);
    CompileResult plan = std::move(graph).compile(executor.memory_needs());
    if (!plan) throw VulkanFailure{{Status::invalid_argument, plan.error().message}};
    CommandSlot commands(device);
    commands.begin();
    executor.record(*plan, external, commands.buffer());
    commands.submit({}, {});
    commands.wait();
}

} // namespace brittle::engine

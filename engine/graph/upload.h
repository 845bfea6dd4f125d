// Copies data into device memory, once and for good: geometry, not what changes each frame.
#pragma once

#include <cstddef>
#include <span>

#include "engine/gpu/memory.h"
#include "engine/graph/access.h"

namespace brittle::engine {

class Device;

struct Upload {
    const DeviceBuffer* destination; // of at least the size of bytes, created with TRANSFER_DST usage
    std::span<const std::byte> bytes;
    AccessSet used_as; // what later submissions do with it; they need no barrier of their own
};

// Waits until the copies are done. Empty ones are skipped. Throws VulkanFailure.
void upload(const Device& device, std::span<const Upload> uploads);

} // namespace brittle::engine

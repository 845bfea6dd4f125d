// Copies static data, such as geometry, into device memory, and waits for the copies.
#pragma once

#include <cstddef>
#include <span>

#include "engine/gpu/memory.h"
#include "engine/graph/access.h"

namespace brittle::engine {

class Device;

struct Upload {
    const DeviceBuffer* destination; // at least as large as `bytes`, created with TRANSFER_DST usage
    std::span<const std::byte> bytes;
    AccessSet used_as; // the accesses of later submissions, which then need no barrier of their own
};

// Makes all copies in one submission and waits for it. Empty copies are skipped. Throws VulkanFailure.
void upload(const Device& device, std::span<const Upload> uploads);

} // namespace brittle::engine

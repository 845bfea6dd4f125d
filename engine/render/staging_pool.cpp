#include "engine/render/staging_pool.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <utility>

#include "engine/gpu/device.h"

namespace brittle::engine {

namespace {

// Rounds up to a multiple of an eighth of the highest power of two, so that batches of similar size can share buffers.
uint64_t rounded_up(uint64_t size) {
    const uint64_t grain = std::max<uint64_t>(std::bit_floor(size) / 8, 4096);
    return (size + grain - 1) / grain * grain;
}

uint64_t sum(const std::vector<DeviceBuffer>& buffers) {
    return std::accumulate(buffers.begin(), buffers.end(), uint64_t{0},
                           [](uint64_t bytes, const DeviceBuffer& buffer) { return bytes + buffer.size(); });
}

} // namespace

void StagingPool::Idle::give_back(DeviceBuffer buffer) noexcept {
    const std::scoped_lock lock(mutex);
    --out;
    if (!buffer.handle()) return; // its allocation failed
    buffers.insert(std::ranges::lower_bound(buffers, buffer.size(), {}, &DeviceBuffer::size), std::move(buffer));
}

std::shared_ptr<DeviceBuffer> StagingPool::take(uint64_t size) {
    DeviceBuffer taken;
    std::vector<DeviceBuffer> surplus; // freed after the lock is released
    {
        const std::scoped_lock lock(idle_->mutex);
        std::vector<DeviceBuffer>& buffers = idle_->buffers;
        const auto at = std::ranges::lower_bound(buffers, size, {}, &DeviceBuffer::size);
        if (at != buffers.end() && at->size() / 2 <= size) { // large buffers are kept for large batches
            taken = std::move(*at);
            buffers.erase(at);
        }
        while (sum(buffers) > max_idle) {
            surplus.push_back(std::move(buffers.back()));
            buffers.pop_back();
        }
        buffers.reserve(buffers.size() + idle_->out + 1);
        ++idle_->out;
    }
    const auto return_it = [idle = idle_](DeviceBuffer* buffer) {
        idle->give_back(std::move(*buffer));
        delete buffer;
    };
    std::shared_ptr<DeviceBuffer> buffer(new DeviceBuffer(std::move(taken)), return_it);
    if (!buffer->handle())
        *buffer = {device_, "staged geometry", rounded_up(size), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, MemoryKind::upload};
    return buffer;
}

uint64_t StagingPool::idle_bytes() const {
    const std::scoped_lock lock(idle_->mutex);
    return sum(idle_->buffers);
}

} // namespace brittle::engine

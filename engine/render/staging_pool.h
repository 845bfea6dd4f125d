// Memory from which the device copies, for who fills it beside the frame, on any thread: a worker that makes pieces
// ready. What is let go is used again, for memory is slow at its first touch, and as slow to give back: so it is given
// back, too, by who takes some.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "engine/gpu/memory.h"

namespace brittle::engine {

class Device;

class StagingPool {
  public:
    static constexpr uint64_t max_idle = 64 << 20; // bytes that stay when one was taken

    explicit StagingPool(const Device& device) : device_(device), idle_(std::make_shared<Idle>()) {}

    // A mapped buffer of so many bytes or more, for one user until the last pointer to it goes, on any thread, at the
    // latest before the device. Throws VulkanFailure.
    [[nodiscard]] std::shared_ptr<DeviceBuffer> take(uint64_t size);

    [[nodiscard]] uint64_t idle_bytes() const;

  private:
    struct Idle { // outlives the pool while a buffer is out
        std::mutex mutex;
        std::vector<DeviceBuffer> buffers; // ascending in size; with room for those that are out
        size_t out = 0;

        void give_back(DeviceBuffer buffer) noexcept;
    };

    const Device& device_;
    std::shared_ptr<Idle> idle_;
};

} // namespace brittle::engine

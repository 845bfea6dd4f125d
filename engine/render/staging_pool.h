// A pool of mapped staging buffers for threads that prepare geometry beside the frame. All functions may run on any
// thread.
//
// Released buffers are reused, because the first touch of new memory is slow. Freeing memory is as slow, so take()
// frees surplus buffers on the worker's thread, and a release only returns its buffer to the pool.
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
    static constexpr uint64_t max_idle = 64 << 20; // bytes of idle buffers that take() leaves in the pool

    explicit StagingPool(const Device& device) : device_(device), idle_(std::make_shared<Idle>()) {}

    // Returns a mapped buffer of at least `size` bytes. It returns to the pool when the last pointer is released, on
    // any thread, which must happen before the device is destroyed. Throws VulkanFailure.
    [[nodiscard]] std::shared_ptr<DeviceBuffer> take(uint64_t size);

    [[nodiscard]] uint64_t idle_bytes() const;

  private:
    struct Idle { // shared with the buffers in use, so it may outlive the pool
        std::mutex mutex;
        std::vector<DeviceBuffer> buffers; // ascending in size; has capacity for the buffers in use, too
        size_t out = 0;                    // number of buffers in use

        void give_back(DeviceBuffer buffer) noexcept;
    };

    const Device& device_;
    std::shared_ptr<Idle> idle_;
};

} // namespace brittle::engine

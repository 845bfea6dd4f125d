// A command buffer with the fence of its submission.
//
//     CommandSlot slot(device);
//     slot.begin();
//     vkCmd...(slot.buffer(), ...);
//     slot.submit({}, VK_NULL_HANDLE);
//     slot.wait(); // required before the next begin()
#pragma once

#include <cstdint>

#include <vulkan/vulkan.h>

namespace brittle::engine {

class Device;

// Two slots used alternately give two frames in flight. All functions throw VulkanFailure. Not thread-safe.
class CommandSlot {
  public:
    explicit CommandSlot(const Device& device);
    ~CommandSlot(); // waits for a pending submission, for at most wait_timeout (device.h)
    CommandSlot(const CommandSlot&) = delete;
    CommandSlot& operator=(const CommandSlot&) = delete;

    void begin(); // discards earlier commands; no submission may be pending
    [[nodiscard]] VkCommandBuffer buffer() const { return commands_; }

    // The semaphore that the submission waits for and the stage that waits: for a swapchain image, the stage of
    // Access::acquired. A null semaphore means no wait.
    struct Wait {
        VkSemaphore semaphore = VK_NULL_HANDLE;
        VkPipelineStageFlags2 stage = 0;
    };
    // Ends the recording and submits it; `signal` may be null.
    void submit(Wait wait, VkSemaphore signal);

    // Waits for the pending submission, if any. Throws device_lost after wait_timeout.
    void wait();

  private:
    void destroy();
    [[nodiscard]] VkResult wait_for_fence() const;

    const Device& device_;
    VkCommandPool pool_ = VK_NULL_HANDLE;
    VkCommandBuffer commands_ = VK_NULL_HANDLE;
    VkFence fence_ = VK_NULL_HANDLE;
    bool pending_ = false;
};

} // namespace brittle::engine

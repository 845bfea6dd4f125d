// A command buffer with the fence of its submission: begin(), record, submit(), and wait() before the next
// begin().
#pragma once

#include <cstdint>

#include <vulkan/vulkan.h>

namespace brittle::engine {

class Device;

// Two in turn are what "two frames in flight" means. All functions throw VulkanFailure.
class CommandSlot {
  public:
    explicit CommandSlot(const Device& device);
    ~CommandSlot(); // waits for what was submitted, wait_timeout at most (device.h)
    CommandSlot(const CommandSlot&) = delete;
    CommandSlot& operator=(const CommandSlot&) = delete;

    void begin(); // what was recorded before is dropped; what was submitted must have been waited for
    [[nodiscard]] VkCommandBuffer buffer() const { return commands_; }

    // A semaphore to wait for, at the stage where the frame graph takes an acquired image over, or none.
    struct Wait {
        VkSemaphore semaphore = VK_NULL_HANDLE;
        VkPipelineStageFlags2 stage = 0;
    };
    void submit(Wait wait, VkSemaphore signal);

    // Returns at once when nothing is pending. Throws device_lost after wait_timeout.
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

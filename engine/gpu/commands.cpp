#include "engine/gpu/commands.h"

#include <cassert>
#include <string>

#include "engine/gpu/check.h"
#include "engine/gpu/device.h"

namespace brittle::engine {

CommandSlot::CommandSlot(const Device& device) : device_(device) {
    try {
        const VkCommandPoolCreateInfo pool{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                           .flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
                                           .queueFamilyIndex = device.queue_family()};
        check(vkCreateCommandPool(device.handle(), &pool, nullptr, &pool_), "create a command pool");
        const VkCommandBufferAllocateInfo commands{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                   .commandPool = pool_,
                                                   .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                                   .commandBufferCount = 1};
        check(vkAllocateCommandBuffers(device.handle(), &commands, &commands_), "allocate a command buffer");
        const VkFenceCreateInfo fence{.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
        check(vkCreateFence(device.handle(), &fence, nullptr, &fence_), "create a fence");
    } catch (...) {
        destroy();
        throw;
    }
}

CommandSlot::~CommandSlot() {
    destroy();
}

void CommandSlot::destroy() {
    if (pending_) (void)wait_for_fence(); // a destructor cannot report a failure
    vkDestroyFence(device_.handle(), fence_, nullptr);
    vkDestroyCommandPool(device_.handle(), pool_, nullptr);
}

void CommandSlot::begin() {
    assert(!pending_ && "wait() comes before begin()");
    check(vkResetCommandPool(device_.handle(), pool_, 0), "reset a command pool");
    const VkCommandBufferBeginInfo info{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                        .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    check(vkBeginCommandBuffer(commands_, &info), "begin a command buffer");
}

void CommandSlot::submit(Wait wait, VkSemaphore signal) {
    check(vkEndCommandBuffer(commands_), "record a frame");
    const VkSemaphoreSubmitInfo waited{
        .sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO, .semaphore = wait.semaphore, .stageMask = wait.stage};
    const VkSemaphoreSubmitInfo signalled{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                          .semaphore = signal,
                                          .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT};
    const VkCommandBufferSubmitInfo commands{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
                                             .commandBuffer = commands_};
    const VkSubmitInfo2 info{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                             .waitSemaphoreInfoCount = wait.semaphore ? 1u : 0u,
                             .pWaitSemaphoreInfos = &waited,
                             .commandBufferInfoCount = 1,
                             .pCommandBufferInfos = &commands,
                             .signalSemaphoreInfoCount = signal ? 1u : 0u,
                             .pSignalSemaphoreInfos = &signalled};
    check(vkResetFences(device_.handle(), 1, &fence_), "reset a fence");
    check(
        device_.attempt(
            Call::submit,
            [&] { return device_.with_queue([&](VkQueue queue) { return vkQueueSubmit2(queue, 1, &info, fence_); }); }),
        "submit a frame");
    pending_ = true;
}

void CommandSlot::wait() {
    if (!pending_) return;
    const VkResult result = wait_for_fence();
    if (result == VK_TIMEOUT)
        throw VulkanFailure{{Status::device_lost, "the device hangs: it did not finish a frame within "
                                                      + std::to_string(wait_timeout / 1'000'000'000)
                                                      + " s. Start again; if it happens again, draw smaller"
                                                        " pictures, update the driver or choose another device."}};
    check(result, "wait for a frame");
    pending_ = false;
}

VkResult CommandSlot::wait_for_fence() const {
    return device_.attempt(Call::wait,
                           [&] { return vkWaitForFences(device_.handle(), 1, &fence_, VK_TRUE, wait_timeout); });
}

} // namespace brittle::engine

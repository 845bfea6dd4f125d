// A Vulkan 1.3 instance, one device and its one queue.
//
//     for (const DeviceInfo& info : *list_devices()) std::printf("%u  %s\n", info.index, info.name.c_str());
//     Result<std::unique_ptr<Device>> device = Device::create({.select = "cpu", .validation = true});
//
// One queue serves graphics, compute and transfer: software drivers offer no second queue, and the passes of a fracture
// frame depend on each other. One thread creates and destroys the device and reads its messages. with_queue()
// serialises submissions of several threads; the const functions may run on any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <vulkan/vulkan.h>

#include "engine/core/result.h"
#include "engine/gpu/clock_match.h"
#include "engine/gpu/fault.h"

namespace brittle::engine {

// From the most to the least preferred kind.
enum class DeviceKind { discrete, integrated, virtual_gpu, cpu, other };

[[nodiscard]] const char* to_string(DeviceKind kind);

struct DeviceInfo {
    uint32_t index = 0; // position in the loader's order
    std::string name;
    DeviceKind kind = DeviceKind::other;
    std::string driver;  // name and version
    std::string problem; // the reason why Brittle cannot use the device; empty for a usable device
};

struct DeviceOptions {
    // The choice of a device. "" or "auto": the best usable device (discrete, then integrated, then virtual, then CPU).
    // "gpu", "cpu": the best usable device of that kind. A number: an index of list_devices(). Any other text: part of
    // the device's name, in upper or lower case.
    std::string select{};
    // Enables the Khronos validation layer with synchronization validation. Each message is printed to stderr and kept
    // for validation_messages(). create() fails with missing_feature when the layer is not installed.
    bool validation = false;
    // For tests: makes Vulkan calls fail on demand (fault.h). Must outlive the device.
    FaultInjector* faults = nullptr;
};

// Returns all devices, usable or not. Fails with no_driver when the machine has no Vulkan driver.
[[nodiscard]] Result<std::vector<DeviceInfo>> list_devices();

// The longest wait for the device, in nanoseconds. A device that is still busy afterwards counts as hung. GPU drivers
// report a lost device after about ten seconds; a CPU device may need much of the minute for a large picture.
inline constexpr uint64_t wait_timeout = 60'000'000'000;

class Device {
  public:
    // Fails with no_driver, with no_device when no usable device matches DeviceOptions::select, with missing_feature
    // when the device selected by index is unusable, or with the failure of a Vulkan call.
    [[nodiscard]] static Result<std::unique_ptr<Device>> create(const DeviceOptions& options = {});
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    [[nodiscard]] const DeviceInfo& info() const { return info_; }
    [[nodiscard]] bool is_cpu() const { return info_.kind == DeviceKind::cpu; }

    // Returns the warnings and errors of the validation layer so far, in order. Empty without
    // DeviceOptions::validation.
    [[nodiscard]] const std::vector<std::string>& validation_messages() const { return *messages_; }
    // Shares the list of messages beyond the device's destruction, which reports leaked objects.
    [[nodiscard]] std::shared_ptr<const std::vector<std::string>> share_validation_messages() const {
        return messages_;
    }

    [[nodiscard]] VkInstance instance() const { return instance_; }
    [[nodiscard]] VkPhysicalDevice physical() const { return physical_; }
    [[nodiscard]] VkDevice handle() const { return device_; }
    // Calls use(queue) under the mutex of the queue, and returns its result.
    template<class Use>
    auto with_queue(const Use& use) const {
        const std::lock_guard lock(queue_mutex_);
        return use(queue_);
    }
    [[nodiscard]] uint32_t queue_family() const { return queue_family_; }
    [[nodiscard]] const VkPhysicalDeviceLimits& limits() const { return limits_; }
    // Optional features, enabled where the device has them.
    [[nodiscard]] bool has_multi_draw() const { return multi_draw_; } // multiDrawIndirect
    [[nodiscard]] bool has_line_mode() const { return line_mode_; }   // fillModeNonSolid
    [[nodiscard]] bool has_anisotropy() const { return anisotropy_; } // samplerAnisotropy
    [[nodiscard]] bool has_ballots() const { return ballots_; }       // subgroup ballots in compute shaders
    [[nodiscard]] bool can_present() const { return can_present_; }   // surface and swapchain extensions

    // Returns whether the driver can sample its timestamp clock and steady_clock together: VK_EXT_calibrated_timestamps
    // or VK_KHR_calibrated_timestamps.
    [[nodiscard]] bool has_common_clock() const { return match_clocks_ != nullptr; }
    // Samples both clocks. Returns nullopt without has_common_clock(). Takes microseconds.
    [[nodiscard]] std::optional<ClockMatch> match_clocks() const;

    // Names objects and labels commands for profilers and validation messages. Without validation, these do nothing.
    void set_name(VkObjectType type, uint64_t handle, const char* name) const;
    void begin_label(VkCommandBuffer commands, const char* name) const;
    void end_label(VkCommandBuffer commands) const;

    // Waits until the device is idle or lost, for at most wait_timeout.
    void wait_idle() const;

    // Makes a Vulkan call through the fault injector, if there is one. Every call of a kind in fault.h goes through
    // here.
    template<class Function>
    VkResult attempt(Call kind, Function&& call) const {
        return faults_ ? faults_->attempt(kind, call) : call();
    }

    // Returns the first memory type in the bit mask `allowed` (VkMemoryRequirements::memoryTypeBits) that has all
    // `flags`, or nullopt.
    [[nodiscard]] std::optional<uint32_t> find_memory_type(uint32_t allowed, VkMemoryPropertyFlags flags) const;
    // Returns the size in bytes of a memory type's heap.
    [[nodiscard]] uint64_t heap_size(uint32_t memory_type) const;

  private:
    Device() = default;
    Result<void> create_instance(bool validation);
    void create_device();
    // Returns the calibrated-timestamps extension to enable for match_clocks(), or null.
    [[nodiscard]] const char* find_clock_extension(const std::vector<VkExtensionProperties>& offered) const;

    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    mutable std::mutex queue_mutex_;
    uint32_t queue_family_ = 0;
    VkFence idle_ = VK_NULL_HANDLE; // the fence of wait_idle()
    mutable bool hangs_ = false;    // wait_idle() timed out
    FaultInjector* faults_ = nullptr;
    bool can_present_ = false;
    bool multi_draw_ = false;
    bool line_mode_ = false;
    bool anisotropy_ = false;
    bool ballots_ = false;
    bool debug_utils_ = false;
    PFN_vkSetDebugUtilsObjectNameEXT set_name_ = nullptr;
    PFN_vkCmdBeginDebugUtilsLabelEXT begin_label_ = nullptr;
    PFN_vkCmdEndDebugUtilsLabelEXT end_label_ = nullptr;
    PFN_vkGetCalibratedTimestampsEXT match_clocks_ = nullptr;
    DeviceInfo info_;
    VkPhysicalDeviceLimits limits_{};
    VkPhysicalDeviceMemoryProperties memory_{};
    // On the heap, because the messenger holds its address.
    std::shared_ptr<std::vector<std::string>> messages_ = std::make_shared<std::vector<std::string>>();
};

} // namespace brittle::engine

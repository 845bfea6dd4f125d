// A Vulkan 1.3 instance, one device of it and its one queue.
//
//     for (const DeviceInfo& info : *list_devices()) std::printf("%u  %s\n", info.index, info.name.c_str());
//     Result<std::unique_ptr<Device>> device = Device::create({.select = "cpu", .validation = true});
//
// One queue of one family does graphics, compute and transfer: software drivers have no other, and a
// fracture's frame has nothing to overlap. Not thread-safe: one thread records and submits.
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

enum class DeviceKind { discrete, integrated, virtual_gpu, cpu, other };

[[nodiscard]] const char* to_string(DeviceKind kind);

struct DeviceInfo {
    uint32_t index = 0; // in the order the loader reports them
    std::string name;
    DeviceKind kind = DeviceKind::other;
    std::string driver;  // name and version, for reports
    std::string problem; // why Brittle cannot use it; empty when it can
};

struct DeviceOptions {
    // Which device: "" or "auto" takes the best usable one (discrete, then integrated, then virtual, then
    // CPU); "gpu" and "cpu" restrict that choice; a number is an index of list_devices(); anything else is
    // part of a name, upper or lower case.
    std::string select{};
    // Turns on the Khronos validation layer with synchronization validation. Each message is printed to
    // stderr and kept for validation_messages(). Fails with missing_feature when the layer is not installed.
    bool validation = false;
    // For tests: makes calls fail on demand (fault.h). Must outlive the device.
    FaultInjector* faults = nullptr;
};

// All devices, usable or not. Fails with no_driver when there is no Vulkan driver at all.
[[nodiscard]] Result<std::vector<DeviceInfo>> list_devices();

// Nanoseconds. A device that is still busy after that hangs. Drivers give up much earlier, after some ten
// seconds, and report a lost device; a CPU device may draw a large picture for a good part of it.
inline constexpr uint64_t wait_timeout = 60'000'000'000;

class Device {
  public:
    [[nodiscard]] static Result<std::unique_ptr<Device>> create(const DeviceOptions& options = {});
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    [[nodiscard]] const DeviceInfo& info() const { return info_; }
    [[nodiscard]] bool is_cpu() const { return info_.kind == DeviceKind::cpu; }

    // Warnings and errors of the validation layer so far, in order. Always empty without
    // DeviceOptions::validation.
    [[nodiscard]] const std::vector<std::string>& validation_messages() const { return *messages_; }
    // The same list, to keep beyond the device's end: destroying a device reports what was leaked.
    [[nodiscard]] std::shared_ptr<const std::vector<std::string>> share_validation_messages() const {
        return messages_;
    }

    [[nodiscard]] VkInstance instance() const { return instance_; }
    [[nodiscard]] VkPhysicalDevice physical() const { return physical_; }
    [[nodiscard]] VkDevice handle() const { return device_; }
    // Calls use(queue) while no other thread uses the queue.
    template<class Use>
    auto with_queue(const Use& use) const {
        const std::lock_guard lock(queue_mutex_);
        return use(queue_);
    }
    [[nodiscard]] uint32_t queue_family() const { return queue_family_; }
    [[nodiscard]] const VkPhysicalDeviceLimits& limits() const { return limits_; }
    // Optional features, on where the device has them.
    [[nodiscard]] bool has_multi_draw() const { return multi_draw_; } // multiDrawIndirect
    [[nodiscard]] bool has_line_mode() const { return line_mode_; }   // fillModeNonSolid
    [[nodiscard]] bool has_ballots() const { return ballots_; }       // subgroup ballots in compute shaders
    [[nodiscard]] bool can_present() const { return can_present_; }   // surface and swapchain extensions are on

    // Whether the driver tells its timestamps and steady_clock at one moment (VK_EXT_calibrated_timestamps, or
    // the KHR extension of the same content).
    [[nodiscard]] bool has_common_clock() const { return match_clocks_ != nullptr; }
    // Both clocks now; nothing without has_common_clock(). Takes microseconds.
    [[nodiscard]] std::optional<ClockMatch> match_clocks() const;

    // Labels what profilers and validation messages show; does nothing without validation.
    void set_name(VkObjectType type, uint64_t handle, const char* name) const;
    void begin_label(VkCommandBuffer commands, const char* name) const;
    void end_label(VkCommandBuffer commands) const;

    // Until the device has nothing to do, is lost, or hangs (wait_timeout).
    void wait_idle() const;

    // Makes a Vulkan call that can be told to fail.
    template<class Function>
    VkResult attempt(Call kind, Function&& call) const {
        return faults_ ? faults_->attempt(kind, call) : call();
    }

    // The first memory type among those `allowed` (bits, as in VkMemoryRequirements) that has all `flags`.
    [[nodiscard]] std::optional<uint32_t> find_memory_type(uint32_t allowed, VkMemoryPropertyFlags flags) const;
    // In bytes, of the heap that a memory type's allocations come from.
    [[nodiscard]] uint64_t heap_size(uint32_t memory_type) const;

  private:
    Device() = default;
    Result<void> create_instance(bool validation);
    void create_device();
    // The extension for match_clocks() to be asked for; null without one.
    [[nodiscard]] const char* find_clock_extension(const std::vector<VkExtensionProperties>& offered) const;

    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    mutable std::mutex queue_mutex_;
    uint32_t queue_family_ = 0;
    VkFence idle_ = VK_NULL_HANDLE; // of wait_idle()
    mutable bool hangs_ = false;    // wait_idle() gave up once
    FaultInjector* faults_ = nullptr;
    bool can_present_ = false;
    bool multi_draw_ = false;
    bool line_mode_ = false;
    bool ballots_ = false;
    bool debug_utils_ = false;
    PFN_vkSetDebugUtilsObjectNameEXT set_name_ = nullptr;
    PFN_vkCmdBeginDebugUtilsLabelEXT begin_label_ = nullptr;
    PFN_vkCmdEndDebugUtilsLabelEXT end_label_ = nullptr;
    PFN_vkGetCalibratedTimestampsEXT match_clocks_ = nullptr;
    DeviceInfo info_;
    VkPhysicalDeviceLimits limits_{};
    VkPhysicalDeviceMemoryProperties memory_{};
    // On the heap: the messenger holds its address.
    std::shared_ptr<std::vector<std::string>> messages_ = std::make_shared<std::vector<std::string>>();
};

} // namespace brittle::engine

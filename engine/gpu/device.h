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
#include <optional>
#include <string>
#include <vector>

#include <vulkan/vulkan.h>

#include "engine/core/result.h"

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
};

// All devices, usable or not. Fails with no_driver when there is no Vulkan driver at all.
[[nodiscard]] Result<std::vector<DeviceInfo>> list_devices();

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
    [[nodiscard]] VkQueue queue() const { return queue_; }
    [[nodiscard]] uint32_t queue_family() const { return queue_family_; }
    [[nodiscard]] const VkPhysicalDeviceLimits& limits() const { return limits_; }
    // Optional features, on where the device has them.
    [[nodiscard]] bool has_multi_draw() const { return multi_draw_; } // multiDrawIndirect
    [[nodiscard]] bool has_line_mode() const { return line_mode_; }   // fillModeNonSolid
    [[nodiscard]] bool can_present() const { return can_present_; } // surface and swapchain extensions are on

    // Labels what profilers and validation messages show; does nothing without validation.
    void set_name(VkObjectType type, uint64_t handle, const char* name) const;
    void begin_label(VkCommandBuffer commands, const char* name) const;
    void end_label(VkCommandBuffer commands) const;

    void wait_idle() const;

    // The first memory type among those `allowed` (bits, as in VkMemoryRequirements) that has all `flags`.
    [[nodiscard]] std::optional<uint32_t> find_memory_type(uint32_t allowed,
                                                           VkMemoryPropertyFlags flags) const;

  private:
    Device() = default;
    Result<void> create_instance(bool validation);
    void create_device();

    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    uint32_t queue_family_ = 0;
    bool can_present_ = false;
    bool multi_draw_ = false;
    bool line_mode_ = false;
    bool debug_utils_ = false;
    PFN_vkSetDebugUtilsObjectNameEXT set_name_ = nullptr;
    PFN_vkCmdBeginDebugUtilsLabelEXT begin_label_ = nullptr;
    PFN_vkCmdEndDebugUtilsLabelEXT end_label_ = nullptr;
    DeviceInfo info_;
    VkPhysicalDeviceLimits limits_{};
    VkPhysicalDeviceMemoryProperties memory_{};
    // On the heap: the messenger holds its address.
    std::shared_ptr<std::vector<std::string>> messages_ = std::make_shared<std::vector<std::string>>();
};

} // namespace brittle::engine

// The choice of a device: describes the devices of an instance, finds the unusable ones, and selects the device for
// DeviceOptions::select. Internal to engine/gpu; device.cpp creates the instance and the device.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <vulkan/vulkan.h>

#include "engine/core/result.h"
#include "engine/gpu/device.h"
#include "engine/gpu/fault.h"

namespace brittle::engine {

// The features of a device, as one pNext chain: for the query of a device's features, and for the request of Brittle's.
struct DeviceFeatures {
    VkPhysicalDeviceVulkan13Features v13{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES,
                                         .pNext = nullptr};
    VkPhysicalDeviceFeatures2 all{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &v13};
    DeviceFeatures() = default;
    DeviceFeatures(const DeviceFeatures&) = delete; // `all` points to `v13`
};

// Enables the features that Brittle needs.
void enable_needed_features(DeviceFeatures& features);

// Returns whether a test hides the feature, extension or layer.
[[nodiscard]] bool is_hidden(const FaultInjector* faults, const char* name);

// Returns the first family with graphics and compute; in practice every device has one.
[[nodiscard]] std::optional<uint32_t> find_queue_family(VkPhysicalDevice device);

// Returns a description of each device, usable or not, in the order of `devices`.
[[nodiscard]] std::vector<DeviceInfo> describe_devices(const std::vector<VkPhysicalDevice>& devices,
                                                       const FaultInjector* faults);

// Returns the index of the usable device that matches DeviceOptions::select. Fails with no_device, or with
// missing_feature when `select` is the index of an unusable device.
[[nodiscard]] Result<uint32_t> choose_device(const std::vector<DeviceInfo>& infos, const std::string& select);

// Returns the advice to install a driver, and to unset variables that hide installed drivers from the loader.
[[nodiscard]] std::string driver_advice();

} // namespace brittle::engine

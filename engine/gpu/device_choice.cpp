#include "engine/gpu/device_choice.h"

#include <charconv>
#include <cstdlib>

#include "engine/gpu/enumerate.h"

namespace brittle::engine {

namespace {

struct NeededFeature {
    const char* name;
    VkBool32& (*member)(DeviceFeatures&);
};

constexpr NeededFeature needed_features[] = {
    {"drawIndirectFirstInstance",
     [](DeviceFeatures& f) -> VkBool32& { return f.all.features.drawIndirectFirstInstance; }},
    {"dynamicRendering", [](DeviceFeatures& f) -> VkBool32& { return f.v13.dynamicRendering; }},
    {"synchronization2", [](DeviceFeatures& f) -> VkBool32& { return f.v13.synchronization2; }},
    {"maintenance4", [](DeviceFeatures& f) -> VkBool32& { return f.v13.maintenance4; }},
};

// Returns the reason why Brittle cannot use the device, or "".
std::string find_problem(VkPhysicalDevice device, const VkPhysicalDeviceProperties& properties,
                         const FaultInjector* faults) {
    if (properties.apiVersion < VK_API_VERSION_1_3)
        return "its driver offers Vulkan " + std::to_string(VK_API_VERSION_MAJOR(properties.apiVersion)) + "."
               + std::to_string(VK_API_VERSION_MINOR(properties.apiVersion)) + ", Brittle needs 1.3";
    if (!find_queue_family(device)) return "it has no queue for both graphics and compute";
    DeviceFeatures features;
    vkGetPhysicalDeviceFeatures2(device, &features.all);
    std::string missing;
    for (const NeededFeature& feature : needed_features)
        if (!feature.member(features) || is_hidden(faults, feature.name))
            missing += (missing.empty() ? "" : ", ") + std::string(feature.name);
    return missing.empty() ? "" : "it lacks the feature " + missing;
}

DeviceKind kind_of(VkPhysicalDeviceType type) {
    switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
        return DeviceKind::discrete;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
        return DeviceKind::integrated;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
        return DeviceKind::virtual_gpu;
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
        return DeviceKind::cpu;
    default:
        return DeviceKind::other;
    }
}

DeviceInfo describe(VkPhysicalDevice device, uint32_t index, const FaultInjector* faults) {
    VkPhysicalDeviceProperties basic;
    vkGetPhysicalDeviceProperties(device, &basic);
    DeviceInfo info{index, basic.deviceName, kind_of(basic.deviceType), {}, {}};
    // VkPhysicalDeviceDriverProperties exists from Vulkan 1.2 on; older devices are unusable.
    if (basic.apiVersion >= VK_API_VERSION_1_2) {
        VkPhysicalDeviceDriverProperties driver{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
        VkPhysicalDeviceProperties2 properties{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                               .pNext = &driver};
        vkGetPhysicalDeviceProperties2(device, &properties);
        info.driver = std::string(driver.driverName) + " " + driver.driverInfo;
    }
    info.problem = find_problem(device, basic, faults);
    return info;
}

std::string lowercase(std::string text) {
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return text;
}

std::string device_table(const std::vector<DeviceInfo>& infos) {
    std::string text;
    for (const DeviceInfo& info : infos)
        text += "\n  " + std::to_string(info.index) + "  " + info.name + " (" + to_string(info.kind) + ")"
                + (info.problem.empty() ? "" : ": unusable, " + info.problem);
    return text;
}

} // namespace

void enable_needed_features(DeviceFeatures& features) {
    for (const NeededFeature& feature : needed_features) feature.member(features) = VK_TRUE;
}

bool is_hidden(const FaultInjector* faults, const char* name) {
    return faults && faults->hides(name);
}

std::optional<uint32_t> find_queue_family(VkPhysicalDevice device) {
    const auto families = enumerate<VkQueueFamilyProperties>(vkGetPhysicalDeviceQueueFamilyProperties, device);
    for (uint32_t i = 0; i < families.size(); ++i) {
        constexpr VkQueueFlags wanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
        if ((families[i].queueFlags & wanted) == wanted) return i;
    }
    return std::nullopt;
}

std::vector<DeviceInfo> describe_devices(const std::vector<VkPhysicalDevice>& devices, const FaultInjector* faults) {
    std::vector<DeviceInfo> infos;
    for (uint32_t i = 0; i < devices.size(); ++i) infos.push_back(describe(devices[i], i, faults));
    return infos;
}

std::string driver_advice() {
    std::string text = " Install a driver: on Debian, `apt install mesa-vulkan-drivers` has drivers for most GPUs"
                       " and one for the CPU.";
    for (const char* name : {"VK_DRIVER_FILES", "VK_ICD_FILENAMES"})
        if (const char* value = std::getenv(name))
            text += std::string(" The variable ") + name + "=" + value + " restricts the search for drivers; unset it.";
    return text;
}

Result<uint32_t> choose_device(const std::vector<DeviceInfo>& infos, const std::string& select) {
    const std::string wanted = lowercase(select);
    uint32_t index = 0;
    const char* end = wanted.data() + wanted.size();
    const auto number = std::from_chars(wanted.data(), end, index);
    if (!wanted.empty() && number.ptr == end && number.ec == std::errc()) {
        if (index >= infos.size())
            return Error{Status::no_device,
                         "there is no Vulkan device " + select + ". The devices are:" + device_table(infos)};
        if (!infos[index].problem.empty())
            return Error{Status::missing_feature, "Vulkan device " + select + " (" + infos[index].name
                                                      + ") cannot be used: " + infos[index].problem};
        return index;
    }

    const auto matches = [&](const DeviceInfo& info) {
        if (wanted.empty() || wanted == "auto") return true;
        if (wanted == "cpu") return info.kind == DeviceKind::cpu;
        if (wanted == "gpu") return info.kind != DeviceKind::cpu;
        return lowercase(info.name).find(wanted) != std::string::npos;
    };
    const DeviceInfo* best = nullptr;
    for (const DeviceInfo& info : infos)
        if (matches(info) && info.problem.empty() && (!best || info.kind < best->kind)) best = &info;
    if (best) return best->index;
    const std::string which = wanted.empty() || wanted == "auto" ? "no usable Vulkan device"
                                                                 : "no usable Vulkan device matches \"" + select + "\"";
    if (infos.empty()) return Error{Status::no_device, which + ": the installed drivers find none." + driver_advice()};
    return Error{Status::no_device, which + ". The devices are:" + device_table(infos)};
}

const char* to_string(DeviceKind kind) {
    switch (kind) {
    case DeviceKind::discrete:
        return "discrete GPU";
    case DeviceKind::integrated:
        return "integrated GPU";
    case DeviceKind::virtual_gpu:
        return "virtual GPU";
    case DeviceKind::cpu:
        return "CPU";
    case DeviceKind::other:
        return "other";
    }
    return "other";
}

} // namespace brittle::engine

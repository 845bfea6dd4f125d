#include "engine/gpu/device.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <span>

#if defined(__SANITIZE_ADDRESS__)
#include <dlfcn.h>
#endif

#include "engine/gpu/check.h"
#include "engine/gpu/device_choice.h"
#include "engine/gpu/enumerate.h"

namespace brittle::engine {

namespace {

// Missing in the headers of Vulkan 1.3.239; its types and functions equal those of VK_EXT_calibrated_timestamps.
constexpr const char* khr_calibrated_timestamps = "VK_KHR_calibrated_timestamps";
constexpr const char* validation_layer = "VK_LAYER_KHRONOS_validation";

// Prepares the process for the Vulkan loader; call it before an instance is created.
//
// Mesa's device-select layer is switched off. It only reorders devices, which DeviceOptions::select makes needless, and
// without a Wayland server its query makes libwayland print an error.
//
// Under AddressSanitizer, lavapipe and the validation layer stay mapped. LeakSanitizer cannot symbolise leaks of an
// unloaded library; this way the few bytes that the two leak at exit stay reachable or can be suppressed by name.
void prepare_loader() {
    setenv("NODEVICE_SELECT", "1", 0);
#if defined(__SANITIZE_ADDRESS__)
    dlopen("libvulkan_lvp.so", RTLD_NOW | RTLD_NODELETE);
    dlopen("libVkLayer_khronos_validation.so", RTLD_NOW | RTLD_NODELETE);
#endif
}

bool offers_extension(const std::vector<VkExtensionProperties>& extensions, const char* name,
                      const FaultInjector* faults) {
    if (is_hidden(faults, name)) return false;
    return std::any_of(extensions.begin(), extensions.end(),
                       [&](const auto& e) { return std::strcmp(e.extensionName, name) == 0; });
}

bool validation_available(const FaultInjector* faults) {
    if (is_hidden(faults, validation_layer)) return false;
    const auto layers = enumerate<VkLayerProperties>(vkEnumerateInstanceLayerProperties);
    return std::any_of(layers.begin(), layers.end(),
                       [](const auto& l) { return std::strcmp(l.layerName, validation_layer) == 0; });
}

VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                          const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    static_cast<std::vector<std::string>*>(user)->push_back(data->pMessage);
    std::fprintf(stderr, "vulkan validation: %s\n", data->pMessage);
    return VK_FALSE;
}

// General messages, such as the loader's about other drivers, are skipped; only validation messages concern our calls.
VkDebugUtilsMessengerCreateInfoEXT messenger_info(std::vector<std::string>* messages) {
    return {.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
            .messageSeverity =
                VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
            .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
            .pfnUserCallback = on_message,
            .pUserData = messages};
}

template<class Function>
Function instance_function(VkInstance instance, const char* name) {
    return reinterpret_cast<Function>(vkGetInstanceProcAddr(instance, name));
}

// The loader reports exhausted memory when the only driver file is damaged.
bool means_no_driver(VkResult result) {
    return result == VK_ERROR_INCOMPATIBLE_DRIVER || result == VK_ERROR_INITIALIZATION_FAILED
           || result == VK_ERROR_OUT_OF_HOST_MEMORY;
}

Error no_driver(VkResult result) {
    return {Status::no_driver, std::string("no Vulkan driver was found, or it is damaged (the loader says: ")
                                   + to_string(result) + ")." + driver_advice()};
}

} // namespace

Result<std::vector<DeviceInfo>> list_devices() {
    prepare_loader();
    const VkApplicationInfo application{
        .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .pApplicationName = "brittle", .apiVersion = VK_API_VERSION_1_3};
    const VkInstanceCreateInfo info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &application};
    VkInstance instance = VK_NULL_HANDLE;
    const VkResult result = vkCreateInstance(&info, nullptr, &instance);
    if (result != VK_SUCCESS) return no_driver(result);
    std::vector<DeviceInfo> infos =
        describe_devices(enumerate<VkPhysicalDevice>(vkEnumeratePhysicalDevices, instance), nullptr);
    vkDestroyInstance(instance, nullptr);
    return infos;
}

Result<std::unique_ptr<Device>> Device::create(const DeviceOptions& options) {
    prepare_loader();
    return guarded([&]() -> Result<std::unique_ptr<Device>> {
        std::unique_ptr<Device> device(new Device);
        device->faults_ = options.faults;
        if (Result<void> made = device->create_instance(options.validation); !made) return made.error();

        const auto devices = enumerate<VkPhysicalDevice>(vkEnumeratePhysicalDevices, device->instance_);
        const std::vector<DeviceInfo> infos = describe_devices(devices, options.faults);
        Result<uint32_t> index = choose_device(infos, options.select);
        if (!index) return index.error();
        device->physical_ = devices[*index];
        device->info_ = infos[*index];
        device->create_device();
        return device;
    });
}

Result<void> Device::create_instance(bool validation) {
    if (validation && !validation_available(faults_))
        return Error{Status::missing_feature,
                     "the Vulkan validation layer is not installed: on Debian, `apt install vulkan-validationlayers`"};

    // Surfaces of every window system that the loader offers, because the window is created later.
    const auto offered = enumerate<VkExtensionProperties>(vkEnumerateInstanceExtensionProperties, nullptr);
    std::vector<const char*> extensions;
    if (offers_extension(offered, "VK_KHR_surface", faults_))
        for (const char* name :
             {"VK_KHR_surface", "VK_KHR_xcb_surface", "VK_KHR_xlib_surface", "VK_KHR_wayland_surface"})
            if (offers_extension(offered, name, faults_)) extensions.push_back(name);
    can_present_ = !extensions.empty();

    const VkValidationFeatureEnableEXT enables[] = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
    const VkValidationFeaturesEXT features{.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                           .enabledValidationFeatureCount = 1,
                                           .pEnabledValidationFeatures = enables};
    // In the pNext chain, the messenger covers creation and destruction of the instance.
    VkDebugUtilsMessengerCreateInfoEXT messenger = messenger_info(messages_.get());
    messenger.pNext = &features;
    if (validation) {
        extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
        extensions.push_back(VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
    }

    const VkApplicationInfo application{.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                        .pApplicationName = "brittle",
                                        .pEngineName = "brittle",
                                        .apiVersion = VK_API_VERSION_1_3};
    const VkInstanceCreateInfo info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                    .pNext = validation ? &messenger : nullptr,
                                    .pApplicationInfo = &application,
                                    .enabledLayerCount = validation ? 1u : 0u,
                                    .ppEnabledLayerNames = &validation_layer,
                                    .enabledExtensionCount = static_cast<uint32_t>(extensions.size()),
                                    .ppEnabledExtensionNames = extensions.data()};
    const VkResult result = vkCreateInstance(&info, nullptr, &instance_);
    if (means_no_driver(result)) return no_driver(result);
    check(result, "create a Vulkan instance");

    debug_utils_ = validation;
    if (validation) {
        messenger.pNext = nullptr;
        const auto create =
            instance_function<PFN_vkCreateDebugUtilsMessengerEXT>(instance_, "vkCreateDebugUtilsMessengerEXT");
        check(create(instance_, &messenger, nullptr, &messenger_), "create a debug messenger");
    }
    return {};
}

void Device::create_device() {
    VkPhysicalDeviceSubgroupProperties subgroups{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
    VkPhysicalDeviceProperties2 properties{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                           .pNext = &subgroups};
    vkGetPhysicalDeviceProperties2(physical_, &properties);
    limits_ = properties.properties.limits;
    ballots_ = (subgroups.supportedOperations & VK_SUBGROUP_FEATURE_BALLOT_BIT) != 0
               && (subgroups.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT) != 0
               && !is_hidden(faults_, "subgroupBallot");
    queue_family_ = *find_queue_family(physical_); // choose_device() guarantees one

    DeviceFeatures features;
    enable_needed_features(features);
    VkPhysicalDeviceFeatures optional;
    vkGetPhysicalDeviceFeatures(physical_, &optional);
    line_mode_ = optional.fillModeNonSolid;
    features.all.features.fillModeNonSolid = optional.fillModeNonSolid;
    anisotropy_ = optional.samplerAnisotropy && !is_hidden(faults_, "samplerAnisotropy");
    features.all.features.samplerAnisotropy = anisotropy_;
    multi_draw_ = optional.multiDrawIndirect && !is_hidden(faults_, "multiDrawIndirect");
    features.all.features.multiDrawIndirect = multi_draw_;

    std::vector<const char*> extensions;
    const auto offered = enumerate<VkExtensionProperties>(vkEnumerateDeviceExtensionProperties, physical_, nullptr);
    can_present_ = can_present_ && offers_extension(offered, VK_KHR_SWAPCHAIN_EXTENSION_NAME, faults_);
    if (can_present_) extensions.push_back(VK_KHR_SWAPCHAIN_EXTENSION_NAME);
    const char* const clock_extension = find_clock_extension(offered);
    if (clock_extension) extensions.push_back(clock_extension);

    const float priority = 1.0f;
    const VkDeviceQueueCreateInfo queue{.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                        .queueFamilyIndex = queue_family_,
                                        .queueCount = 1,
                                        .pQueuePriorities = &priority};
    const VkDeviceCreateInfo info{.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                  .pNext = &features.all,
                                  .queueCreateInfoCount = 1,
                                  .pQueueCreateInfos = &queue,
                                  .enabledExtensionCount = static_cast<uint32_t>(extensions.size()),
                                  .ppEnabledExtensionNames = extensions.data()};
    const std::string doing = "start the Vulkan device " + info_.name;
    check(attempt(Call::create_device, [&] { return vkCreateDevice(physical_, &info, nullptr, &device_); }),
          doing.c_str());
    const VkFenceCreateInfo fence{.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    check(vkCreateFence(device_, &fence, nullptr, &idle_), "create a fence");
    vkGetDeviceQueue(device_, queue_family_, 0, &queue_);
    vkGetPhysicalDeviceMemoryProperties(physical_, &memory_);
    if (clock_extension) {
        const bool is_khr = std::strcmp(clock_extension, khr_calibrated_timestamps) == 0;
        match_clocks_ = reinterpret_cast<PFN_vkGetCalibratedTimestampsEXT>(
            vkGetDeviceProcAddr(device_, is_khr ? "vkGetCalibratedTimestampsKHR" : "vkGetCalibratedTimestampsEXT"));
    }

    if (debug_utils_) {
        set_name_ = instance_function<PFN_vkSetDebugUtilsObjectNameEXT>(instance_, "vkSetDebugUtilsObjectNameEXT");
        begin_label_ = instance_function<PFN_vkCmdBeginDebugUtilsLabelEXT>(instance_, "vkCmdBeginDebugUtilsLabelEXT");
        end_label_ = instance_function<PFN_vkCmdEndDebugUtilsLabelEXT>(instance_, "vkCmdEndDebugUtilsLabelEXT");
    }
}

const char* Device::find_clock_extension(const std::vector<VkExtensionProperties>& offered) const {
    if (!limits_.timestampComputeAndGraphics) return nullptr;
    const bool is_ext = offers_extension(offered, VK_EXT_CALIBRATED_TIMESTAMPS_EXTENSION_NAME, faults_);
    if (!is_ext && !offers_extension(offered, khr_calibrated_timestamps, faults_)) return nullptr;
    const auto list = instance_function<PFN_vkGetPhysicalDeviceCalibrateableTimeDomainsEXT>(
        instance_,
        is_ext ? "vkGetPhysicalDeviceCalibrateableTimeDomainsEXT" : "vkGetPhysicalDeviceCalibrateableTimeDomainsKHR");
    if (!list) return nullptr;
    const auto domains = enumerate<VkTimeDomainEXT>(list, physical_);
    for (const VkTimeDomainEXT needed : {VK_TIME_DOMAIN_DEVICE_EXT, VK_TIME_DOMAIN_CLOCK_MONOTONIC_EXT})
        if (std::find(domains.begin(), domains.end(), needed) == domains.end()) return nullptr;
    return is_ext ? VK_EXT_CALIBRATED_TIMESTAMPS_EXTENSION_NAME : khr_calibrated_timestamps;
}

std::optional<ClockMatch> Device::match_clocks() const {
    if (!match_clocks_) return std::nullopt;
    constexpr VkStructureType type = VK_STRUCTURE_TYPE_CALIBRATED_TIMESTAMP_INFO_EXT;
    // steady_clock is CLOCK_MONOTONIC in every library for Linux.
    const VkCalibratedTimestampInfoEXT clocks[] = {{.sType = type, .timeDomain = VK_TIME_DOMAIN_DEVICE_EXT},
                                                   {.sType = type, .timeDomain = VK_TIME_DOMAIN_CLOCK_MONOTONIC_EXT}};
    uint64_t now[2] = {};
    uint64_t deviation = 0;
    if (match_clocks_(device_, 2, clocks, now, &deviation) != VK_SUCCESS) return std::nullopt;
    return ClockMatch{now[0], static_cast<int64_t>(now[1]), static_cast<double>(limits_.timestampPeriod)};
}

Device::~Device() {
    if (idle_) vkDestroyFence(device_, idle_, nullptr);
    if (device_) vkDestroyDevice(device_, nullptr);
    if (messenger_)
        instance_function<PFN_vkDestroyDebugUtilsMessengerEXT>(instance_, "vkDestroyDebugUtilsMessengerEXT")(
            instance_, messenger_, nullptr);
    if (instance_) vkDestroyInstance(instance_, nullptr);
}

void Device::set_name(VkObjectType type, uint64_t object, const char* name) const {
    if (!set_name_) return;
    const VkDebugUtilsObjectNameInfoEXT info{.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
                                             .objectType = type,
                                             .objectHandle = object,
                                             .pObjectName = name};
    set_name_(device_, &info);
}

void Device::begin_label(VkCommandBuffer commands, const char* name) const {
    if (!begin_label_) return;
    const VkDebugUtilsLabelEXT label{.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT, .pLabelName = name};
    begin_label_(commands, &label);
}

void Device::end_label(VkCommandBuffer commands) const {
    if (end_label_) end_label_(commands);
}

void Device::wait_idle() const {
    // A failure is ignored: a lost device fails again, with a message, in the next call that uses it. The fence comes
    // first because vkDeviceWaitIdle(), which also waits for presentation, never returns when the device hangs.
    if (hangs_ || vkResetFences(device_, 1, &idle_) != VK_SUCCESS) return;
    with_queue([&](VkQueue queue) {
        if (vkQueueSubmit2(queue, 0, nullptr, idle_) != VK_SUCCESS) return;
        hangs_ = vkWaitForFences(device_, 1, &idle_, VK_TRUE, wait_timeout) == VK_TIMEOUT;
        if (!hangs_) vkDeviceWaitIdle(device_);
    });
}

uint64_t Device::heap_size(uint32_t memory_type) const {
    return memory_.memoryHeaps[memory_.memoryTypes[memory_type].heapIndex].size;
}

std::optional<uint32_t> Device::find_memory_type(uint32_t allowed, VkMemoryPropertyFlags flags) const {
    for (uint32_t i = 0; i < memory_.memoryTypeCount; ++i)
        if ((allowed >> i & 1u) && (memory_.memoryTypes[i].propertyFlags & flags) == flags) return i;
    return std::nullopt;
}

} // namespace brittle::engine

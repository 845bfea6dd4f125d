#include "engine/gpu/memory.h"

#include <algorithm>
#include <string>

#include "engine/gpu/check.h"
#include "engine/gpu/device.h"

namespace brittle::engine {

namespace {

constexpr VkMemoryPropertyFlags mapped_flags =
    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;

// Returns the preferred flags and the required flags.
std::pair<VkMemoryPropertyFlags, VkMemoryPropertyFlags> flags_of(MemoryKind kind) {
    switch (kind) {
    case MemoryKind::device:
        return {VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0};
    case MemoryKind::upload:
        return {mapped_flags, mapped_flags};
    case MemoryKind::readback:
        return {mapped_flags | VK_MEMORY_PROPERTY_HOST_CACHED_BIT, mapped_flags};
    }
    return {0, 0};
}

template<class Object>
uint64_t bits(Object object) {
    return reinterpret_cast<uint64_t>(object);
}

} // namespace

VkDeviceMemory allocate_memory(const Device& device, uint64_t size, uint32_t allowed, MemoryKind kind) {
    const auto [preferred, required] = flags_of(kind);
    std::optional<uint32_t> type = device.find_memory_type(allowed, preferred);
    if (!type) type = device.find_memory_type(allowed, required);
    if (!type)
        throw VulkanFailure{{Status::missing_feature, "the device has no mapped, host-coherent memory for buffers"}};
    const VkMemoryAllocateInfo info{
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = size, .memoryTypeIndex = *type};
    VkDeviceMemory memory = VK_NULL_HANDLE;
    const std::string doing = "allocate " + std::to_string(size) + " bytes of device memory";
    // Some drivers accept allocations that are larger than the heap.
    check(size > device.heap_size(*type)
              ? VK_ERROR_OUT_OF_DEVICE_MEMORY
              : device.attempt(Call::allocate,
                               [&] { return vkAllocateMemory(device.handle(), &info, nullptr, &memory); }),
          doing.c_str());
    return memory;
}

VkImageView create_view(VkDevice device, VkImage image, VkFormat format, VkImageViewType type) {
    const bool depth = format == VK_FORMAT_D32_SFLOAT;
    const VkImageAspectFlags aspect = depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
    const VkImageViewCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
        .image = image,
        .viewType = type,
        .format = format,
        .subresourceRange = {aspect, 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS}};
    VkImageView view = VK_NULL_HANDLE;
    check(vkCreateImageView(device, &info, nullptr, &view), "create an image view");
    return view;
}

// The destructor does not run when a constructor throws. The constructors therefore build a local object, whose
// destructor frees a partial result, and swap it in at the end.
DeviceBuffer::DeviceBuffer(const Device& device, const char* name, uint64_t size, VkBufferUsageFlags usage,
                           MemoryKind kind) {
    DeviceBuffer made;
    made.device_ = device.handle();
    made.size_ = size;
    const VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                  .size = std::max<uint64_t>(size, 1),
                                  .usage = usage,
                                  .sharingMode = VK_SHARING_MODE_EXCLUSIVE};
    check(vkCreateBuffer(device.handle(), &info, nullptr, &made.buffer_), "create a buffer");
    device.set_name(VK_OBJECT_TYPE_BUFFER, bits(made.buffer_), name);

    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(device.handle(), made.buffer_, &needs);
    made.memory_ = allocate_memory(device, needs.size, needs.memoryTypeBits, kind);
    check(vkBindBufferMemory(device.handle(), made.buffer_, made.memory_, 0), "bind a buffer's memory");
    if (kind != MemoryKind::device) {
        void* mapped = nullptr;
        check(device.attempt(Call::map,
                             [&] { return vkMapMemory(device.handle(), made.memory_, 0, VK_WHOLE_SIZE, 0, &mapped); }),
              "map a buffer's memory");
        made.mapped_ = static_cast<std::byte*>(mapped);
    }
    swap(made);
}

DeviceBuffer::~DeviceBuffer() {
    if (buffer_) vkDestroyBuffer(device_, buffer_, nullptr);
    if (memory_) vkFreeMemory(device_, memory_, nullptr);
}

void DeviceBuffer::swap(DeviceBuffer& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(buffer_, other.buffer_);
    std::swap(memory_, other.memory_);
    std::swap(size_, other.size_);
    std::swap(mapped_, other.mapped_);
}

DeviceImage::DeviceImage(const Device& device, const char* name, const ImageShape& shape, VkFormat format,
                         VkImageUsageFlags usage) {
    DeviceImage made;
    made.device_ = device.handle();
    const VkImageCreateInfo info{.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                 .imageType = VK_IMAGE_TYPE_2D,
                                 .format = format,
                                 .extent = {shape.extent.width, shape.extent.height, 1},
                                 .mipLevels = shape.levels,
                                 .arrayLayers = std::max(shape.layers, 1u),
                                 .samples = VK_SAMPLE_COUNT_1_BIT,
                                 .tiling = VK_IMAGE_TILING_OPTIMAL,
                                 .usage = usage,
                                 .sharingMode = VK_SHARING_MODE_EXCLUSIVE,
                                 .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED};
    check(vkCreateImage(device.handle(), &info, nullptr, &made.image_), "create an image");
    device.set_name(VK_OBJECT_TYPE_IMAGE, bits(made.image_), name);

    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(device.handle(), made.image_, &needs);
    made.memory_ = allocate_memory(device, needs.size, needs.memoryTypeBits, MemoryKind::device);
    check(vkBindImageMemory(device.handle(), made.image_, made.memory_, 0), "bind an image's memory");
    made.view_ = create_view(device.handle(), made.image_, format,
                             shape.layers > 0 ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D);
    swap(made);
}

DeviceImage::~DeviceImage() {
    if (view_) vkDestroyImageView(device_, view_, nullptr);
    if (image_) vkDestroyImage(device_, image_, nullptr);
    if (memory_) vkFreeMemory(device_, memory_, nullptr);
}

void DeviceImage::swap(DeviceImage& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(image_, other.image_);
    std::swap(view_, other.view_);
    std::swap(memory_, other.memory_);
}

} // namespace brittle::engine

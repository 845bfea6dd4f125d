// Buffers and images that own their memory.
//
// Each has one vkAllocateMemory. Brittle has a few dozen of them (arenas, per-frame buffers, the frame graph's heaps),
// far below maxMemoryAllocationCount, so there is no sub-allocation. The transients of a frame share heaps, which the
// frame graph's executor allocates.
//
// All functions throw VulkanFailure (check.h).
#pragma once

#include <cstdint>
#include <span>
#include <utility>

#include <vulkan/vulkan.h>

namespace brittle::engine {

class Device;

enum class MemoryKind {
    device,  // device-local, not mapped
    upload,  // mapped; the CPU writes in ascending order and never reads
    readback // mapped; the CPU reads
};

class DeviceBuffer {
  public:
    DeviceBuffer() = default; // no buffer: every getter returns null or zero
    // Creates a buffer of `size` bytes. Size zero creates one byte, because Vulkan has no empty buffer.
    DeviceBuffer(const Device& device, const char* name, uint64_t size, VkBufferUsageFlags usage, MemoryKind kind);
    ~DeviceBuffer();
    DeviceBuffer(DeviceBuffer&& other) noexcept { swap(other); }
    DeviceBuffer& operator=(DeviceBuffer&& other) noexcept {
        DeviceBuffer(std::move(other)).swap(*this);
        return *this;
    }

    [[nodiscard]] VkBuffer handle() const { return buffer_; }
    [[nodiscard]] uint64_t size() const { return size_; }

    // Returns the mapped, host-coherent bytes, valid for the life of the buffer; null for MemoryKind::device.
    [[nodiscard]] std::byte* mapped() const { return mapped_; }
    template<class T>
    [[nodiscard]] std::span<T> mapped_as(uint64_t offset, size_t count) const {
        return {reinterpret_cast<T*>(mapped_ + offset), count};
    }

  private:
    void swap(DeviceBuffer& other) noexcept;

    VkDevice device_ = VK_NULL_HANDLE;
    VkBuffer buffer_ = VK_NULL_HANDLE;
    VkDeviceMemory memory_ = VK_NULL_HANDLE;
    uint64_t size_ = 0;
    std::byte* mapped_ = nullptr;
};

// The levels and layers of an image; with layers, it is an array.
struct ImageShape {
    VkExtent2D extent{};
    uint32_t levels = 1;
    uint32_t layers = 0; // 0: no array
};

// A 2D image in device memory, with a view of the whole image.
class DeviceImage {
  public:
    DeviceImage() = default;
    DeviceImage(const Device& device, const char* name, const ImageShape& shape, VkFormat format,
                VkImageUsageFlags usage);
    ~DeviceImage();
    DeviceImage(DeviceImage&& other) noexcept { swap(other); }
    DeviceImage& operator=(DeviceImage&& other) noexcept {
        DeviceImage(std::move(other)).swap(*this);
        return *this;
    }

    [[nodiscard]] VkImage handle() const { return image_; }
    [[nodiscard]] VkImageView view() const { return view_; }

  private:
    void swap(DeviceImage& other) noexcept;

    VkDevice device_ = VK_NULL_HANDLE;
    VkImage image_ = VK_NULL_HANDLE;
    VkImageView view_ = VK_NULL_HANDLE;
    VkDeviceMemory memory_ = VK_NULL_HANDLE;
};

// Allocates memory of the kind from a memory type in the bit mask `allowed`. Throws missing_feature when no type fits,
// and out_of_memory.
[[nodiscard]] VkDeviceMemory allocate_memory(const Device& device, uint64_t size, uint32_t allowed, MemoryKind kind);

// Creates a view of every mip level and layer, of the depth aspect for a depth format and of colour otherwise.
[[nodiscard]] VkImageView create_view(VkDevice device, VkImage image, VkFormat format,
                                      VkImageViewType type = VK_IMAGE_VIEW_TYPE_2D);

} // namespace brittle::engine

// Buffers and images with memory of their own, owned by RAII.
//
// One vkAllocateMemory each: Brittle has a few dozen of them (arenas, a handful of slices, the frame graph's
// heaps), far below maxMemoryAllocationCount, so there is nothing to sub-allocate. Transients of a frame
// share heaps, which the frame graph's executor makes.
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
    device,  // fastest for the device; the CPU cannot touch it
    upload,  // mapped; the CPU writes, in order, and never reads
    readback // mapped; the CPU reads
};

class DeviceBuffer {
  public:
    DeviceBuffer() = default; // no buffer: every getter gives null or zero
    // `size` in bytes; zero is made one byte, because Vulkan has no empty buffer.
    DeviceBuffer(const Device& device, const char* name, uint64_t size, VkBufferUsageFlags usage, MemoryKind kind);
    ~DeviceBuffer();
    DeviceBuffer(DeviceBuffer&& other) noexcept { swap(other); }
    DeviceBuffer& operator=(DeviceBuffer&& other) noexcept {
        DeviceBuffer(std::move(other)).swap(*this);
        return *this;
    }

    [[nodiscard]] VkBuffer handle() const { return buffer_; }
    [[nodiscard]] uint64_t size() const { return size_; }

    // The mapped bytes, for the life of the buffer; upload and readback only. Host-coherent.
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

// A 2D image in device memory with a view of all of it.
class DeviceImage {
  public:
    DeviceImage() = default;
    DeviceImage(const Device& device, const char* name, VkExtent2D extent, VkFormat format, VkImageUsageFlags usage);
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

// Memory of the kind, from a type among `allowed`. Throws out_of_memory.
[[nodiscard]] VkDeviceMemory allocate_memory(const Device& device, uint64_t size, uint32_t allowed, MemoryKind kind);

// The view of every mip level and layer; depth for depth formats, colour else.
[[nodiscard]] VkImageView create_view(VkDevice device, VkImage image, VkFormat format);

} // namespace brittle::engine

// Textures of one size with their mipmaps: the layers of an array, which every Vulkan device has. Descriptor indexing,
// which would allow any sizes, is missing on CPU devices.
//
//     TextureStack stack = TextureStack::of(images, {.srgb = true});   // on any thread
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/bitmap.h"

namespace brittle::engine {

struct StackSettings {
    bool srgb = true;                // colours are averaged in linear light; false: as numbers, for normal maps
    uint32_t max_side = 4096;        // texels
    uint64_t max_bytes = 256u << 20; // of all layers with their mipmaps; larger ones are halved until they fit
};

class TextureStack {
  public:
    TextureStack() = default; // no layers

    // Every image gets the size of the largest width and height among them, within the limits. Images must not be empty.
    [[nodiscard]] static TextureStack of(std::span<const Bitmap> images, const StackSettings& settings = {});
    // The layers of several stacks, one after the other; all have been made with these settings.
    [[nodiscard]] static TextureStack joined(std::span<const TextureStack* const> stacks,
                                             const StackSettings& settings = {});

    [[nodiscard]] uint32_t width() const { return width_; }
    [[nodiscard]] uint32_t height() const { return height_; }
    [[nodiscard]] uint32_t layers() const { return layers_; }
    [[nodiscard]] uint32_t levels() const { return static_cast<uint32_t>(pixels_.size()); }
    // RGBA, layer by layer, of a level whose sides are those of the level before, halved and at least 1.
    [[nodiscard]] std::span<const uint8_t> level(uint32_t level) const { return pixels_[level]; }

  private:
    void add(const Bitmap& image, bool srgb);
    [[nodiscard]] Bitmap layer(uint32_t layer) const; // its largest level

    uint32_t width_ = 0, height_ = 0, layers_ = 0;
    std::vector<std::vector<uint8_t>> pixels_; // by level
};

} // namespace brittle::engine

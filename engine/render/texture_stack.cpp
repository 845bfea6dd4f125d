#include "engine/render/texture_stack.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <tuple>

namespace brittle::engine {

namespace {

// Linear light of the 256 values of sRGB, and back through a table that is finer than those values are apart.
struct SrgbTables {
    static constexpr size_t steps = 1 << 14;
    std::array<float, 256> linear{};
    std::array<uint8_t, steps + 1> srgb{};

    SrgbTables() {
        for (size_t i = 0; i < linear.size(); ++i) {
            const double c = static_cast<double>(i) / 255.0;
            linear[i] = static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
        }
        for (size_t i = 0; i <= steps; ++i) {
            const double x = static_cast<double>(i) / steps;
            const double c = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
            srgb[i] = static_cast<uint8_t>(std::lround(255.0 * c));
        }
    }
    [[nodiscard]] uint8_t encoded(float x) const {
        return srgb[static_cast<size_t>(x * static_cast<float>(steps) + 0.5f)];
    }
};

const SrgbTables& tables() {
    static const SrgbTables made;
    return made;
}

// The weighted texels of one row or column of the source that make up a texel of the result.
struct Taps {
    struct Tap {
        uint32_t from;
        float weight;
    };
    std::vector<Tap> taps;
    std::vector<uint32_t> begin; // by texel of the result
};

// A box as wide as a texel of the result, or linear interpolation where that is narrower than one of the source. Borders
// wrap around, as most textures do.
Taps taps_of(uint32_t from, uint32_t to) {
    Taps made;
    const double scale = static_cast<double>(from) / to;
    for (uint32_t i = 0; i < to; ++i) {
        made.begin.push_back(static_cast<uint32_t>(made.taps.size()));
        if (scale >= 1.0) {
            const double low = i * scale, high = low + scale;
            for (auto k = static_cast<uint32_t>(low); k < from && k < high; ++k) {
                const double share = std::min(high, k + 1.0) - std::max(low, static_cast<double>(k));
                if (share > 1e-9) made.taps.push_back({k, static_cast<float>(share / scale)});
            }
        } else {
            const double at = (i + 0.5) * scale - 0.5, low = std::floor(at);
            const auto wrapped = [&](double k) { return static_cast<uint32_t>(static_cast<int64_t>(k) + from) % from; };
            made.taps.push_back({wrapped(low), static_cast<float>(1.0 - (at - low))});
            made.taps.push_back({wrapped(low + 1.0), static_cast<float>(at - low)});
        }
    }
    made.begin.push_back(static_cast<uint32_t>(made.taps.size()));
    return made;
}

// Colours are weighted by opacity, so that those of invisible texels do not show at the edges of cut-outs.
Bitmap resized(const Bitmap& image, uint32_t width, uint32_t height, bool srgb) {
    if (image.width == width && image.height == height) return image;
    const SrgbTables& table = tables();
    const Taps across = taps_of(image.width, width), down = taps_of(image.height, height);
    constexpr float faint = 1.0f / 1024.0f; // weight of an invisible texel, whose colour counts where all are
    std::vector<std::array<float, 5>> row(image.width); // rgb by weight, the weight, alpha
    Bitmap made{width, height, std::vector<uint8_t>(size_t{4} * width * height)};
    for (uint32_t y = 0; y < height; ++y) {
        std::ranges::fill(row, std::array<float, 5>{});
        for (uint32_t t = down.begin[y]; t < down.begin[y + 1]; ++t) {
            const auto [from, share] = down.taps[t];
            const uint8_t* in = image.at(0, from);
            for (uint32_t x = 0; x < image.width; ++x, in += 4) {
                const float alpha = static_cast<float>(in[3]) / 255.0f, weight = share * std::max(alpha, faint);
                for (size_t c = 0; c < 3; ++c)
                    row[x][c] += weight * (srgb ? table.linear[in[c]] : static_cast<float>(in[c]) / 255.0f);
                row[x][3] += weight;
                row[x][4] += share * alpha;
            }
        }
        uint8_t* out = made.at(0, y);
        for (uint32_t x = 0; x < width; ++x, out += 4) {
            std::array<float, 5> sum{};
            for (uint32_t t = across.begin[x]; t < across.begin[x + 1]; ++t)
                for (size_t c = 0; c < sum.size(); ++c) sum[c] += across.taps[t].weight * row[across.taps[t].from][c];
            for (size_t c = 0; c < 3; ++c) {
                const float value = std::clamp(sum[c] / sum[3], 0.0f, 1.0f);
                out[c] = srgb ? table.encoded(value) : static_cast<uint8_t>(value * 255.0f + 0.5f);
            }
            out[3] = static_cast<uint8_t>(std::clamp(sum[4], 0.0f, 1.0f) * 255.0f + 0.5f);
        }
    }
    return made;
}

// The largest sides of the images, halved until all layers fit.
std::pair<uint32_t, uint32_t> common_size(uint32_t width, uint32_t height, uint64_t layers,
                                          const StackSettings& settings) {
    const auto bytes = [&] { return uint64_t{4} * width * height * layers * 4 / 3; };
    while (width > settings.max_side || height > settings.max_side
           || (bytes() > settings.max_bytes && width * height > 1)) {
        width = std::max(width / 2, 1u);
        height = std::max(height / 2, 1u);
    }
    return {width, height};
}

} // namespace

TextureStack TextureStack::of(std::span<const Bitmap> images, const StackSettings& settings) {
    TextureStack stack;
    if (images.empty()) return stack;
    uint32_t width = 1, height = 1;
    for (const Bitmap& image : images) {
        assert(image.width > 0 && image.height > 0);
        width = std::max(width, image.width);
        height = std::max(height, image.height);
    }
    std::tie(stack.width_, stack.height_) = common_size(width, height, images.size(), settings);
    stack.pixels_.resize(std::bit_width(std::max(stack.width_, stack.height_)));
    for (const Bitmap& image : images) stack.add(image, settings.srgb);
    return stack;
}

void TextureStack::add(const Bitmap& image, bool srgb) {
    Bitmap level = resized(image, width_, height_, srgb);
    for (std::vector<uint8_t>& pixels : pixels_) {
        pixels.insert(pixels.end(), level.pixels.begin(), level.pixels.end());
        level = resized(level, std::max(level.width / 2, 1u), std::max(level.height / 2, 1u), srgb);
    }
    ++layers_;
}

Bitmap TextureStack::layer(uint32_t layer) const {
    const size_t size = size_t{4} * width_ * height_;
    const auto from = pixels_[0].begin() + static_cast<ptrdiff_t>(layer * size);
    return {width_, height_, {from, from + static_cast<ptrdiff_t>(size)}};
}

TextureStack TextureStack::joined(std::span<const TextureStack* const> stacks, const StackSettings& settings) {
    uint32_t width = 1, height = 1, layers = 0;
    for (const TextureStack* stack : stacks) {
        width = std::max(width, stack->width_);
        height = std::max(height, stack->height_);
        layers += stack->layers_;
    }
    TextureStack all;
    if (layers == 0) return all;
    std::tie(all.width_, all.height_) = common_size(width, height, layers, settings);
    all.pixels_.resize(std::bit_width(std::max(all.width_, all.height_)));
    for (const TextureStack* stack : stacks) {
        if (stack->width_ == all.width_ && stack->height_ == all.height_) {
            for (size_t k = 0; k < all.pixels_.size(); ++k)
                all.pixels_[k].insert(all.pixels_[k].end(), stack->pixels_[k].begin(), stack->pixels_[k].end());
            all.layers_ += stack->layers_;
        } else {
            for (uint32_t k = 0; k < stack->layers_; ++k) all.add(stack->layer(k), settings.srgb);
        }
    }
    return all;
}

} // namespace brittle::engine

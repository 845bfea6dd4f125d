// Bitmaps: 8-bit RGBA images in main memory, their PNG files, and the comparison of two for golden-image tests. In the
// engine, an Image is a handle of the frame graph.
//
//     Result<Bitmap> expected = read_png("golden.png");
//     if (!expected) return expected.error();
//     if (!compare_bitmaps(actual, *expected).within_tolerance) (void)write_png(actual, "actual.png");
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine/core/result.h"

namespace brittle::engine {

// Rows from top to bottom without padding, four bytes a pixel (red, green, blue, alpha), sRGB-encoded.
struct Bitmap {
    uint32_t width = 0;
    uint32_t height = 0;
    std::vector<uint8_t> pixels; // 4 * width * height bytes

    [[nodiscard]] const uint8_t* at(uint32_t x, uint32_t y) const { return &pixels[4 * (size_t{y} * width + x)]; }
    [[nodiscard]] uint8_t* at(uint32_t x, uint32_t y) { return &pixels[4 * (size_t{y} * width + x)]; }
};

// Writes a PNG file of 8-bit RGBA. The file is written beside its destination and renamed over it, so a failure leaves
// an existing file unchanged. Fails with invalid_argument on an empty bitmap or one whose pixels do not match its size,
// with out_of_memory, and with file_error.
[[nodiscard]] Result<void> write_png(const Bitmap& image, const std::string& path);

// Reads a PNG file of 8 bits a channel. Grey and palette images become RGBA; a missing alpha channel becomes opaque.
// Fails with file_error.
[[nodiscard]] Result<Bitmap> read_png(const std::string& path);

// Decodes a PNG or JPEG image. Fails with invalid_argument on other or damaged data, and on an image of more pixels,
// which is not decoded; the message names neither file nor image.
[[nodiscard]] Result<Bitmap> decode_image(std::span<const std::byte> bytes, uint64_t max_pixels);

// The allowed difference between two images of one scene. The defaults suit one driver on different machines, where
// only the rounding of library functions differs. Two drivers round differently everywhere and put edges on either
// side of a pixel; for them, use {.ignore = 3, .channel = 255, .fraction = 0.02}.
struct BitmapTolerance {
    int ignore = 0;          // the largest channel difference, of 255, at which two pixels still count as equal
    int channel = 3;         // the largest channel difference, of 255, that any pixel may have
    double fraction = 0.005; // the largest share of unequal pixels
};

struct BitmapDifference {
    bool same_size = false;
    uint64_t unequal_pixels = 0; // pixels with a channel that differs by more than BitmapTolerance::ignore
    int largest = 0;             // the largest channel difference over all pixels, of 255
    bool within_tolerance = false;
    Bitmap picture; // black at equal pixels, red to white at unequal ones; empty when the sizes differ
};

// Compares two bitmaps channel by channel. Bitmaps of different sizes are never within tolerance.
[[nodiscard]] BitmapDifference compare_bitmaps(const Bitmap& actual, const Bitmap& expected,
                                               const BitmapTolerance& tolerance = {});

} // namespace brittle::engine

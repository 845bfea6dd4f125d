// A bitmap: an 8-bit RGBA image in main memory, its PNG file, and the comparison that golden-image tests rest
// on. (An Image, in the engine, is a handle of the frame graph.)
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/core/result.h"

namespace brittle::engine {

// Rows from top to bottom, four bytes a pixel (red, green, blue, alpha), sRGB-encoded, no padding.
struct Bitmap {
    uint32_t width = 0;
    uint32_t height = 0;
    std::vector<uint8_t> pixels; // 4 * width * height bytes

    [[nodiscard]] const uint8_t* at(uint32_t x, uint32_t y) const { return &pixels[4 * (size_t{y} * width + x)]; }
    [[nodiscard]] uint8_t* at(uint32_t x, uint32_t y) { return &pixels[4 * (size_t{y} * width + x)]; }
};

// Written beside the destination and renamed over it, so that a failure leaves an existing file as it was.
[[nodiscard]] Result<void> write_png(const Bitmap& image, const std::string& path);

// Any PNG of 8 bits a channel; a file without alpha gets an opaque one.
[[nodiscard]] Result<Bitmap> read_png(const std::string& path);

// What two images of one scene may differ by. The defaults are for one driver on different machines, where
// little but the rounding of library functions can differ. Between drivers, rounding differs everywhere and
// edges fall to either side of a pixel: use {.ignore = 3, .channel = 255, .fraction = 0.02}.
struct BitmapTolerance {
    int ignore = 0;          // pixels whose channels differ by no more, of 255, count as equal
    int channel = 3;         // no channel of any pixel may differ by more
    double fraction = 0.005; // of all pixels that may be unequal
};

struct BitmapDifference {
    bool same_size = false;
    uint64_t unequal_pixels = 0; // with a channel that differs by more than BitmapTolerance::ignore
    int largest = 0;             // the largest difference of any channel of any pixel
    bool within_tolerance = false;
    Bitmap picture; // black where equal, red to white where not; empty when the sizes differ
};

// Images of different size are never within tolerance.
[[nodiscard]] BitmapDifference compare_bitmaps(const Bitmap& actual, const Bitmap& expected,
                                               const BitmapTolerance& tolerance = {});

} // namespace brittle::engine

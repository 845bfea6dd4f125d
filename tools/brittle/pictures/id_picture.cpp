#include "tools/brittle/pictures/id_picture.h"

namespace brittle::tools {

namespace {

constexpr uint32_t factor = 0x9E3779; // 2^24 divided by the golden ratio: consecutive numbers have distant colours
constexpr uint32_t inverse = 0xB382C9;
constexpr uint32_t mask = 0xffffff;
static_assert((factor * inverse & mask) == 1);

} // namespace

engine::Bitmap id_picture(const engine::IdImage& ids) {
    engine::Bitmap picture{ids.width, ids.height, std::vector<uint8_t>(4 * ids.ids.size())};
    uint8_t* pixel = picture.pixels.data();
    for (const uint32_t id : ids.ids) {
        const uint32_t colour = id * factor & mask;
        if (id != 0) {
            pixel[0] = static_cast<uint8_t>(colour >> 16);
            pixel[1] = static_cast<uint8_t>(colour >> 8);
            pixel[2] = static_cast<uint8_t>(colour);
            pixel[3] = 255;
        }
        pixel += 4;
    }
    return picture;
}

std::optional<uint32_t> piece_of_colour(const uint8_t* pixel) {
    if (pixel[3] == 0) return std::nullopt;
    const uint32_t colour = static_cast<uint32_t>(pixel[0]) << 16 | static_cast<uint32_t>(pixel[1]) << 8 | pixel[2];
    return (colour * inverse & mask) - 1;
}

} // namespace brittle::tools

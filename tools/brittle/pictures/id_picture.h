// Which piece each pixel shows, as a picture: for compositing (a mask of each piece) and for tests.
//
// A piece's number is its index in the fracture's order, which is the number in the names of exported nodes. Its colour is the
// 24 bits of (number + 1) * 0x9E3779 modulo 2^24, red the highest byte, with alpha 255; where there is no piece all four
// bytes are 0. The factor is odd, so colours are different for all of 2^24 - 1 pieces and lead back to the number:
//
//     number = (red << 16 | green << 8 | blue) * 0xB382C9 modulo 2^24, minus 1
//
// Neighbouring numbers get colours that are easily told apart. Edges are hard: a pixel shows what lies at its middle.
#pragma once

#include <cstdint>
#include <optional>

#include "engine/core/bitmap.h"
#include "engine/render/renderer.h"

namespace brittle::tools {

// Four bytes a pixel, as above. Ids are those of Renderer::render_ids(), 0 for none; above 2^24 - 1 they repeat.
[[nodiscard]] engine::Bitmap id_picture(const engine::IdImage& ids);

// The number that a pixel of such a picture stands for; nothing where there is no piece.
[[nodiscard]] std::optional<uint32_t> piece_of_colour(const uint8_t* pixel);

} // namespace brittle::tools

// Pictures of piece numbers: each pixel has the colour of the piece that it shows. For compositing (a mask of each
// piece) and for tests.
//
// The number of a piece is its index in the order of the fracture, as in the names of exported nodes. Its colour is the
// 24 bits of (number + 1) * 0x9E3779 modulo 2^24, with red as the highest byte and alpha 255. A pixel without a piece
// has four bytes of 0. The factor is odd, so all 2^24 - 1 pieces have different colours, and the number follows from
// the colour:
//
//     number = (red << 16 | green << 8 | blue) * 0xB382C9 modulo 2^24, minus 1
//
// Consecutive numbers have clearly different colours. Edges are hard: a pixel shows the piece at its centre.
#pragma once

#include <cstdint>
#include <optional>

#include "engine/core/bitmap.h"
#include "engine/render/renderer.h"

namespace brittle::tools {

// Returns the picture, four bytes per pixel. Ids are those of Renderer::render_ids(), with 0 for no piece; colours of
// ids above 2^24 - 1 repeat.
[[nodiscard]] engine::Bitmap id_picture(const engine::IdImage& ids);

// Returns the number of the piece of a pixel; nothing for a pixel without a piece.
[[nodiscard]] std::optional<uint32_t> piece_of_colour(const uint8_t* pixel);

} // namespace brittle::tools

#include "fracture/pieces/cap_pairs.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace brittle::fracture {

CapPairs::CapPairs(const Fragments& fragments, const std::function<bool(uint32_t, uint32_t)>& selects)
    : piece_of_(fragments.triangles.size()), across_(fragments.triangles.size(), no_index) {
    std::vector<Side> sides;
    for (uint32_t p = 0; p < fragments.pieces.size(); ++p) {
        const Piece& piece = fragments.pieces[p];
        for (uint32_t t = piece.triangles.begin; t < piece.triangles.end; ++t) {
            piece_of_[t] = p;
            if (t < piece.triangles.begin + piece.exterior_triangles) continue;
            const uint32_t other = fragments.triangle_source[t];
            if (selects(std::min(piece.site, other), std::max(piece.site, other)))
                sides.push_back(side(fragments, piece, t));
        }
    }
    pair(sides);
}

CapPairs::Side CapPairs::side(const Fragments& fragments, const Piece& piece, uint32_t t) {
    const uint32_t other = fragments.triangle_source[t];
    std::array<uint32_t, 3> points{};
    for (int k = 0; k < 3; ++k)
        points[static_cast<size_t>(k)] = fragments.vertex_point[piece.vertices.begin + fragments.triangles[t][k]];
    const bool upper = piece.site > other;
    if (upper) std::swap(points[1], points[2]);
    std::rotate(points.begin(), std::min_element(points.begin(), points.end()), points.end());
    return {{std::min(piece.site, other), std::max(piece.site, other), points[0], points[1], points[2]}, upper, t};
}

void CapPairs::pair(std::vector<Side>& sides) {
    std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) {
        return std::tie(x.key, x.upper, x.triangle) < std::tie(y.key, y.upper, y.triangle);
    });
    for (size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
        size_t lower = 0;
        for (; end < sides.size() && sides[end].key == sides[begin].key; ++end) lower += sides[end].upper ? 0 : 1;
        for (size_t k = begin; k < begin + lower && k + lower < end; ++k) {
            across_[sides[k].triangle] = sides[k + lower].triangle;
            across_[sides[k + lower].triangle] = sides[k].triangle;
        }
    }
}

} // namespace brittle::fracture

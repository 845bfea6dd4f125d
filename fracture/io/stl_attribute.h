// The two attribute bytes of a triangle in the STL files that Brittle writes, which begin with stl_head.
//
// Bit 0 is 1 on cuts. STL has no vertices of its own, so three times five bits say which points the corners are, first
// corner lowest: the rank of the point among those at its position, in the order of the pieces and their vertices. So a
// reader can tell parts that touch from one that is connected. All ranks are 0 where no two points share a position;
// the 32nd point and further ones have the rank 31.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string_view>

namespace brittle::fracture {

inline constexpr std::string_view stl_head = "Brittle ";
inline constexpr uint32_t max_stl_rank = 31;

[[nodiscard]] constexpr uint16_t stl_attribute(bool is_cut, uint32_t rank0, uint32_t rank1, uint32_t rank2) {
    const auto bits = [](uint32_t rank) { return std::min(rank, max_stl_rank); };
    return static_cast<uint16_t>((is_cut ? 1u : 0u) | bits(rank0) << 1 | bits(rank1) << 6 | bits(rank2) << 11);
}

[[nodiscard]] constexpr uint32_t stl_rank(uint16_t attribute, uint32_t corner) {
    return attribute >> (1 + 5 * corner) & max_stl_rank;
}

} // namespace brittle::fracture

// Which cap triangles of a fracture are the two sides of one.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "fracture/pieces/fragments.h"

namespace brittle::fracture {

class CapPairs {
  public:
    static constexpr uint32_t none = 0xffffffffu;

    // Of caps between sites (lower, higher) of which `wanted` says yes. Sides are told by vertex_point, so
    // the fragments come from Algorithm::exact.
    CapPairs(const Fragments& fragments, const std::function<bool(uint32_t, uint32_t)>& wanted);

    [[nodiscard]] uint32_t piece_of(uint32_t triangle) const { return piece_of_[triangle]; }
    // The other side of a cap triangle; none for what is no cap, was not wanted, or has no other side.
    [[nodiscard]] uint32_t across(uint32_t triangle) const { return across_[triangle]; }

  private:
    struct Side {
        std::array<uint32_t, 5> key; // sites, points from the least on, as seen from the lower site
        bool upper;
        uint32_t triangle;
    };
    static Side side(const Fragments& fragments, const Piece& piece, uint32_t t);
    void pair(std::vector<Side>& sides);

    std::vector<uint32_t> piece_of_, across_;
};

} // namespace brittle::fracture

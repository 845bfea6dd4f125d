// Pairs up the cap triangles of a fracture: the two sides of each cap triangle.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "fracture/pieces/fragments.h"

namespace brittle::fracture {

class CapPairs {
  public:
    // Pairs the triangles of the caps between sites (lower, higher) for which `selects` returns true. Vertices are
    // identified by vertex_point, so the fragments must come from Algorithm::exact.
    CapPairs(const Fragments& fragments, const std::function<bool(uint32_t, uint32_t)>& selects);

    [[nodiscard]] uint32_t piece_of(uint32_t triangle) const { return piece_of_[triangle]; }
    // Returns the cap triangle on the other side; no_index for an exterior triangle, a cap that was not selected or a
    // cap without other side.
    [[nodiscard]] uint32_t across(uint32_t triangle) const { return across_[triangle]; }

  private:
    struct Side {
        // The two sites, then the three points in the orientation seen from the lower site, smallest first.
        std::array<uint32_t, 5> key;
        bool upper;
        uint32_t triangle;
    };
    static Side side(const Fragments& fragments, const Piece& piece, uint32_t t);
    void pair(std::vector<Side>& sides);

    std::vector<uint32_t> piece_of_, across_;
};

} // namespace brittle::fracture

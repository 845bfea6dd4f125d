// Disjoint sets as a forest of parent indices (union-find). A root is its own parent: parent[x] == x. Initialise with
// std::iota. unite() makes the lower of two roots the root of both, so a root is the minimum of its set.
#pragma once

#include <cstdint>
#include <vector>

namespace brittle::fracture {

// Returns the root of x. Path halving shortens later searches.
[[nodiscard]] inline uint32_t root_of(std::vector<uint32_t>& parent, uint32_t x) {
    while (parent[x] != x) x = parent[x] = parent[parent[x]];
    return x;
}

inline void unite(std::vector<uint32_t>& parent, uint32_t a, uint32_t b) {
    a = root_of(parent, a);
    b = root_of(parent, b);
    if (a < b)
        parent[b] = a;
    else
        parent[a] = b;
}

} // namespace brittle::fracture

// Disjoint sets as a forest of parents: parent[x] == x marks a root. Begin with parent[x] = x for all x (std::iota).
// The lower of two roots becomes the root of both, so that a root is the least of its set.
#pragma once

#include <cstdint>
#include <vector>

namespace brittle::fracture {

// Shortens the way for those who ask later (path halving).
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

// Sites in the centres of n^3 equal boxes of the cube from -1 to 1: degenerate positions everywhere.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

namespace brittle::fracture::test {

using Sites = std::vector<glm::dvec3>;

inline Sites lattice(int n) {
    Sites sites;
    for (int k = 0; k < n * n * n; ++k)
        sites.push_back((glm::dvec3(k % n, k / n % n, k / n / n) + 0.5) * (2.0 / n) - 1.0);
    return sites;
}

} // namespace brittle::fracture::test

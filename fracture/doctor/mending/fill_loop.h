// Triangles that fill one rim.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture::mending {

// What is there already.
class Taken {
  public:
    virtual ~Taken() = default;
    [[nodiscard]] virtual bool triangle(const Triangle& t) const = 0; // either way around
    [[nodiscard]] virtual bool edge(uint32_t a, uint32_t b) const = 0;
};

struct Fill {
    std::vector<Triangle> triangles; // empty: none will do
    bool too_long = false;           // because there are more than 4096 corners
};

// The loop's corners are different vertices, three or more; the triangles run along it. None of them is
// taken; inner edges avoid taken ones where they can. No point is added. In the plane of the loop where it is
// simple there: near-linear time. Else up to 64 corners the least area, cubic time; then ears, the shortest
// edge first, quadratic time.
[[nodiscard]] Fill fill_loop(std::span<const glm::dvec3> positions, std::span<const uint32_t> loop, const Taken& taken);

} // namespace brittle::fracture::mending

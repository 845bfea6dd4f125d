// Fills one rim with triangles.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture::mending {

// The triangles and edges that exist already.
class Taken {
  public:
    virtual ~Taken() = default;
    [[nodiscard]] virtual bool triangle(const Triangle& t) const = 0; // in either orientation
    [[nodiscard]] virtual bool edge(uint32_t a, uint32_t b) const = 0;
};

struct Fill {
    std::vector<Triangle> triangles; // empty where no fill exists
    bool too_long = false;           // whether the reason is a loop of more than 4096 corners
};

// Fills a loop of three or more distinct vertices; the triangles run along it. No fill triangle exists already, and
// inner edges avoid existing ones where possible. No point is added. In projection along the loop's normal where the
// loop is simple there: near-linear time. Else up to 64 corners the fill of least area, in cubic time; beyond that ear
// clipping with the shortest edge first, in quadratic time.
[[nodiscard]] Fill fill_loop(std::span<const glm::dvec3> positions, std::span<const uint32_t> loop, const Taken& taken);

// Returns the fill of least area of a loop of up to 256 corners, in cubic time; nothing for a longer one, or where every
// fill repeats a triangle.
[[nodiscard]] std::vector<Triangle> fill_by_area(std::span<const glm::dvec3> positions, std::span<const uint32_t> loop,
                                                 const Taken& taken);

} // namespace brittle::fracture::mending

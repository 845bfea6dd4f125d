// The fast path of cap triangulation: one simple counter-clockwise loop of moderate size, no holes.
//
// Nine caps of ten are such a loop. It is clipped ear by ear (Meisters; the concave vertices as by ElGindy,
// Everett and Toussaint) without allocating, and its diagonals are flipped towards Delaunay. Whatever looks
// doubtful in double (a collinear or repeated point, no strict ear, many concave vertices) is left to
// triangulate() (fracture/triangulation/triangulate.h), which copes with everything.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec2.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture::exact {

class EarClipper {
  public:
    // Appends n - 2 counter-clockwise triangles of indices first + k for the loop's points k = 0 .. n - 1.
    // False, with nothing appended, where the loop is not plainly simple and counter-clockwise.
    bool clip(std::span<const glm::dvec2> loop, uint32_t first, std::vector<Triangle>& out);

  private:
    bool find_concave(std::span<const glm::dvec2> loop);
    [[nodiscard]] bool is_ear(std::span<const glm::dvec2> loop, uint32_t v) const;
    bool cut_ears(std::span<const glm::dvec2> loop);
    void cut(uint32_t v);
    void flip(std::span<const glm::dvec2> loop);
    bool flip_edge(std::span<const glm::dvec2> loop, uint32_t half_edge);

    std::vector<uint32_t> next_, prev_;
    std::vector<uint32_t> beyond_; // of the remaining polygon's edge from each vertex: the half-edge on the other side
    std::vector<int8_t> turn_;
    std::vector<uint32_t> concave_;
    // Triangle t has the half-edges 3t + k from corner k to the next; twins are no_twin on the loop.
    std::vector<std::array<uint32_t, 3>> corners_;
    std::vector<uint32_t> twin_;
    std::vector<uint32_t> pending_;
};

} // namespace brittle::fracture::exact

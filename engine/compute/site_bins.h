// Sites sorted into the bins of a uniform grid over the mesh's box.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "fracture/mesh/mesh.h"
#include "shaders/classify.h"

namespace brittle::engine {

struct SiteBins {
    std::vector<glm::vec4> sites; // by bin; w: the bits of the site's index
    std::vector<uint32_t> begin;  // bins + 1
    shared::ClassifyGrid grid{};  // without the counts of vertices and triangles

    // Sites outside the box go to the nearest bin, so what is beyond a bin's side is no nearer than that
    // side.
    void build(std::span<const glm::dvec3> positions, const fracture::Box& box);

  private:
    std::vector<uint32_t> bin_of_, cursor_;
};

} // namespace brittle::engine

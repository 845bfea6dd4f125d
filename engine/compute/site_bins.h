// Sites sorted into the bins of a uniform grid over the mesh's bounding box.
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
    std::vector<glm::vec4> sites; // positions, grouped by bin; w: the bits of the site's index
    std::vector<uint32_t> begin;  // index of each bin's first site in `sites`; one more than there are bins
    shared::ClassifyGrid grid{};  // without the counts of vertices and triangles

    // Sorts the sites. Sites outside the box go to the nearest bin, so a site in a bin beyond a plane between bins is
    // never nearer than that plane.
    void build(std::span<const glm::dvec3> positions, const fracture::Box& box);

  private:
    std::vector<uint32_t> bin_of_, cursor_;
};

} // namespace brittle::engine

// Finds patches that cover a place which is already covered, see remove_spare_patches() in repair.h.
#pragma once

#include <cstdint>
#include <vector>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture::mending {

struct SparePatches {
    std::vector<uint8_t> is_spare; // per triangle
    uint32_t triangles = 0;
    uint32_t patches = 0;
};

[[nodiscard]] SparePatches find_spare_patches(const TriangleMesh& mesh);

} // namespace brittle::fracture::mending

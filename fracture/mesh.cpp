#include "fracture/mesh.h"

#include <glm/common.hpp>

namespace brittle::fracture {

Box bounds(const TriangleMesh& mesh) {
    if (mesh.positions.empty()) return {};
    Box box{mesh.positions.front(), mesh.positions.front()};
    for (const glm::dvec3& p : mesh.positions) {
        box.min = glm::min(box.min, p);
        box.max = glm::max(box.max, p);
    }
    return box;
}

} // namespace brittle::fracture

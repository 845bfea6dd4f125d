#include "fracture/mesh/mesh.h"

#include <glm/common.hpp>

namespace brittle::fracture {

Box bounds(std::span<const glm::dvec3> positions) {
    if (positions.empty()) return {};
    Box box{positions.front(), positions.front()};
    for (const glm::dvec3& p : positions) {
        box.min = glm::min(box.min, p);
        box.max = glm::max(box.max, p);
    }
    return box;
}

} // namespace brittle::fracture

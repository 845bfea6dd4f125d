// An axis-aligned box, in the unit of its coordinates; min <= max along every axis.
#pragma once

#include <glm/vec3.hpp>

namespace brittle::fracture {

struct Box {
    glm::dvec3 min{0.0};
    glm::dvec3 max{0.0};

    [[nodiscard]] glm::dvec3 size() const { return max - min; }
    [[nodiscard]] glm::dvec3 centre() const { return (min + max) * 0.5; }
};

} // namespace brittle::fracture

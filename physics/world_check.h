// What may come into a world: reasons against descriptions of bodies; and validate() of world.h.
#pragma once

#include <cmath>
#include <sstream>
#include <string>

#include <glm/vec3.hpp>

#include "physics/world.h"

namespace brittle::physics {

[[nodiscard]] inline bool finite(const glm::vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Values one after the other, for messages.
template<class... Parts>
std::string text(const Parts&... parts) {
    std::ostringstream stream;
    (stream << ... << parts);
    return stream.str();
}

// Reasons why no body can be made of a description; an empty string where there is none.
[[nodiscard]] std::string fault_of(const BodyDesc& desc);

// Fault of principal moments, or an empty string; raises those too small for the solver.
[[nodiscard]] std::string settle_moments(glm::dvec3& moments);

} // namespace brittle::physics

// What may come into a world: reasons against descriptions of bodies; and validate() of world.h.
#pragma once

#include <cmath>
#include <sstream>
#include <string>

#include <glm/vec3.hpp>

#include "fracture/mesh/principal_axes.h"
#include "physics/world/world.h"

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

// Why no body can be made of a description; an empty string where one can: of what make_form() takes, and of the
// rest. The principal axes are then known, with moments that the solver can bear; those of a fixed body are not
// looked for.
[[nodiscard]] std::string fault_of_form(const BodyDesc& desc, fracture::PrincipalAxes& principal);
[[nodiscard]] std::string fault_of_place(const BodyDesc& desc);

} // namespace brittle::physics

// Validation of body descriptions, with messages for people; and validate() of world.h.
#pragma once

#include <cmath>
#include <sstream>
#include <string>

#include <glm/vec3.hpp>

#include "fracture/mesh/principal_axes.h"
#include "physics/world/joint.h"
#include "physics/world/world.h"

namespace brittle::physics {

[[nodiscard]] inline bool finite(const glm::vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Concatenates values into a message.
template<class... Parts>
std::string text(const Parts&... parts) {
    std::ostringstream stream;
    (stream << ... << parts);
    return stream.str();
}

// Return what makes a body description invalid, or an empty string: fault_of_form() for the members that make_form()
// reads, fault_of_place() for the others. fault_of_form() also computes the principal axes of a body that is not fixed,
// with moments raised to what the solver's precision allows.
[[nodiscard]] std::string fault_of_form(const BodyDesc& desc, fracture::PrincipalAxes& principal);
[[nodiscard]] std::string fault_of_place(const BodyDesc& desc);
// Returns what makes a joint invalid, apart from its bodies, or an empty string.
[[nodiscard]] std::string fault_of(const JointDesc& desc);

} // namespace brittle::physics

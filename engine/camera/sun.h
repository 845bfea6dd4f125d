// The sun of pictures whose look names no other direction.
#pragma once

#include <glm/vec3.hpp>

namespace brittle::engine {

inline constexpr glm::vec3 default_to_light{-0.55f, 0.90f, 0.55f}; // direction to the sun, of any length but zero

} // namespace brittle::engine

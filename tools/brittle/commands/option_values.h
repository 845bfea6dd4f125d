// Option values that consist of several numbers. Each function throws a CLI::ValidationError that names the option,
// the value and the form expected.
#pragma once

#include <string>

#include <glm/vec2.hpp>

#include "tools/brittle/recipe/input.h"

namespace brittle::tools {

struct Ball {
    glm::dvec3 centre{0.0};
    double radius = 0.0;
};

// X,Y,Z,RADIUS
[[nodiscard]] Ball parse_ball(const std::string& option, const std::string& text);
// X,Y,Z,RADIUS with a radius from 0.001 to 10 m.
[[nodiscard]] Anchor parse_anchor(const std::string& text);
// X,Y,Z,VX,VY,VZ,RADIUS or X,Y,Z,VX,VY,VZ,RADIUS,SECONDS
[[nodiscard]] Shot parse_shot(const std::string& text);
// WIDTHxHEIGHT in pixels, each from 16 to 8192.
[[nodiscard]] glm::uvec2 parse_size(const std::string& text);

} // namespace brittle::tools

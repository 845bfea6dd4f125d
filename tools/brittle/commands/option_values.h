// Option values: limits of numbers, and values that consist of several numbers.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <glm/vec2.hpp>

#include "tools/scenario/recipe/input.h"

namespace brittle::tools {

// Validators of numbers. All refuse NaN and infinity, and messages give limits as people write them.
[[nodiscard]] CLI::Validator number_from(double low, double high);
[[nodiscard]] CLI::Validator positive_number();
[[nodiscard]] CLI::Validator non_negative_number();
[[nodiscard]] CLI::Validator finite_number();
// Names words for the help and for shells, and accepts any: the option's own function knows better what to say of others.
[[nodiscard]] CLI::Validator known_words(const std::vector<std::string>& words);

// The functions below throw a CLI::ValidationError that names the option, the value and the form expected.

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

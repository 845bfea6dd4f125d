// Settings of the studio's tools, and the blows of its hammer.
#pragma once

#include <cstdint>

#include "tools/brittle/studio/foresight.h"
#include "tools/brittle/studio/object.h"
#include "tools/scenario/recipe/strike.h"

namespace brittle::tools {

// Lengths are those of the stage, where the mesh is 2 m long.
struct ToolSettings {
    float hammer_radius = 0.3f;  // m
    uint32_t hammer_pieces = 16; // number of cells in the ball
    float ball_speed = 14.0f;    // m/s
    float ball_radius = 0.1f;    // m
    float brush_radius = 0.15f;  // m, of painted anchors
};

// Returns the strike of the hammer at a point of the stage, in the coordinates of the object's file.
[[nodiscard]] inline Strike strike_at(const ToolSettings& tools, const Object& object, const glm::dvec3& at,
                                      const glm::dvec3& direction) {
    return {object.to_file(at), direction, tools.hammer_radius / object.scale(), tools.hammer_pieces};
}

// Returns the blow of the hammer at a point of a breakable mesh that is still whole.
[[nodiscard]] inline AimedBlow blow_at(const ToolSettings& tools, const glm::dvec3& at, const glm::dvec3& direction) {
    return {at, direction, double{tools.hammer_radius}};
}

} // namespace brittle::tools

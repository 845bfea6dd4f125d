// What things are made of: how they move, how they break, and what they look like inside. One word gives a good result.
#pragma once

#include <span>
#include <string_view>

#include <glm/vec3.hpp>

#include "fracture/pattern.h"

namespace brittle::physics {

struct Material {
    float density = 2400.0f; // kg/m^3; concrete
    float friction = 0.8f;
    float restitution = 0.2f;
};

// Density, friction and restitution are those of handbooks, rounded; colours are linear light.
struct MaterialPreset {
    std::string_view name;
    Material material;
    fracture::Pattern pattern; // how it breaks: kind and shape, not count and seed
    glm::vec3 exterior;
    glm::vec3 interior;
};

// glass, stone, concrete, wood, ceramic.
[[nodiscard]] std::span<const MaterialPreset> material_presets();
// Null where there is none of that name.
[[nodiscard]] const MaterialPreset* material_preset(std::string_view name);

} // namespace brittle::physics

// What things are made of: how they move, how they break, and what they look like inside. One word gives a good result.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include <glm/vec3.hpp>

#include "fracture/sites/pattern.h"

namespace brittle::physics {

// A blow breaks it where the impulse through an area exceeds strength * impact_seconds * area, and its energy pays for that
// area; see toughness() and fracture_energy.
struct Material {
    float density = 2400.0f; // kg/m^3; concrete
    float friction = 0.8f;
    float restitution = 0.2f;
    float tensile = 3e6f;      // Pa; also what bending may pull at the outermost fibre
    float compressive = 30e6f; // Pa
    float shear = 5e6f;        // Pa
    // What a blow spends on one square metre of new surface, J/m^2: the fracture energy of handbooks times fifty, as in
    // crushing about one part in fifty of the energy ends in new surface and the rest in heat and sound.
    float fracture_energy = 5e3f;
};

// How long a blow between hard bodies of a kilogram lasts, s: about that of Hertz's contact of stones at some metres
// a second. For larger ones it grows with their size, so with the cube root of the mass that is stopped.
inline constexpr float impact_seconds = 1e-4f;

// Impulse through one square metre that breaks the material, Pa s: its tensile strength for the time of a blow.
[[nodiscard]] constexpr float toughness(const Material& material) {
    return material.tensile * impact_seconds;
}

// What is wrong with a material's density or strengths, or an empty string. A world refuses wrong friction and
// restitution itself.
[[nodiscard]] std::string fault_of(const Material& material);

// Density, friction, restitution and strengths are those of handbooks, rounded (annealed glass, granite, plain concrete,
// softwood between along and across the grain, porcelain, clay bricks in mortar); colours are linear light.
struct MaterialPreset {
    std::string_view name;
    Material material;
    fracture::Pattern pattern; // how it breaks: kind and shape, not count and seed
    glm::vec3 exterior;
    glm::vec3 interior;
};

// glass, stone, concrete, wood, ceramic, brick.
[[nodiscard]] std::span<const MaterialPreset> material_presets();
// Null where there is none of that name.
[[nodiscard]] const MaterialPreset* material_preset(std::string_view name);

} // namespace brittle::physics

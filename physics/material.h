// Materials: density, friction, strength and fracture energy, and presets that name a material with its fracture
// pattern and its colours.
//
//     const MaterialPreset* stone = material_preset("stone");
//     Material weathered = scale_strength(stone->material, flawed_strength);
//
// SI units. Plain data and pure functions, for any thread.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include <glm/vec3.hpp>

#include "fracture/sites/pattern.h"

namespace brittle::physics {

// A blow breaks an area A of the material if its impulse through A exceeds strength * impact_seconds * A (toughness())
// and its energy exceeds fracture_energy * A. The defaults are those of concrete.
struct Material {
    float density = 2400.0f; // kg/m^3
    float friction = 0.8f;
    float restitution = 0.2f;
    float tensile = 3e6f;      // Pa; also the limit of bending stress at the outermost fibre
    float compressive = 30e6f; // Pa
    float shear = 5e6f;        // Pa
    // J/m^2, the energy that a blow spends on new surface: fifty times the fracture energy of handbooks. In crushing,
    // about one part in fifty of the energy becomes new surface; the rest becomes heat and sound.
    float fracture_energy = 5e3f;
};

// Duration of a blow between hard bodies of one kilogram, s: about the duration of Hertz's contact between stones at
// some metres a second. The duration of a heavier blow grows with the size of the bodies, hence with the cube root of
// the mass that is stopped.
inline constexpr float impact_seconds = 1e-4f;

// Strength of a real object against blows, as a share of its material's handbook strength. Handbooks measure small,
// nearly flawless samples. The largest flaw decides the strength of a brittle body (Griffith, "The phenomena of rupture
// and flow in solids", 1921), and a larger body holds larger flaws (Weibull, "A statistical theory of the strength of
// materials", 1939). At full handbook strength, a stone arch turns back a ball of a quarter of a ton.
inline constexpr float flawed_strength = 0.1f;

// Strength of a real object under a permanent load, as a share of its material's handbook strength: the default of
// WearSettings and HeldBlockSettings. At full handbook strength a model of one metre would carry a hundred times its
// own weight, and nothing would ever fall. At a twentieth, as with old mortar, a concrete slab over a gap of one metre
// just carries itself if its thickness is a sixth of the gap.
inline constexpr float sustained_strength = 0.05f;

// The material with its tensile, compressive and shear strength multiplied by `factor`. Its fracture energy stays.
[[nodiscard]] Material scale_strength(const Material& material, float factor);

// Impulse through one square metre that breaks the material, Pa s: the tensile strength for the duration of a blow.
[[nodiscard]] constexpr float toughness(const Material& material) {
    return material.tensile * impact_seconds;
}

// Names the first density, strength or fracture energy that is not positive and finite; empty for a valid material. A
// world checks friction and restitution itself.
[[nodiscard]] std::string fault_of(const Material& material);

// Density, friction, restitution and strengths are rounded handbook values of annealed glass, granite, plain concrete,
// softwood (between its values along and across the grain), porcelain, and clay bricks in mortar.
struct MaterialPreset {
    std::string_view name;
    Material material;
    fracture::Pattern pattern; // kind and shape; its count and seed are the caller's
    glm::vec3 exterior;        // linear colour of the original surface
    glm::vec3 interior;        // linear colour of fracture surfaces
};

// In this order: glass, stone, concrete, wood, ceramic, brick.
[[nodiscard]] std::span<const MaterialPreset> material_presets();
// Null for an unknown name.
[[nodiscard]] const MaterialPreset* material_preset(std::string_view name);

} // namespace brittle::physics

// Materials: density, friction, strength, toughness and fracture energy, and presets that name a material with its
// fracture pattern and its colours.
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

#include "fracture/settings.h"
#include "fracture/sites/pattern.h"

namespace brittle::physics {

// A blow breaks a section of area A if its force exceeds breaking_force() of A, and its energy fracture_energy * A.
// Both are necessary: stress starts a crack, and energy drives it (Leguillon, "Strength or toughness? A criterion for
// crack onset at a notch", 2002). The defaults are those of concrete.
struct Material {
    float density = 2400.0f; // kg/m^3
    float friction = 0.8f;
    float restitution = 0.2f;
    float tensile = 3e6f;      // Pa; also the limit of bending stress at the outermost fibre
    float compressive = 30e6f; // Pa
    float shear = 5e6f;        // Pa
    // K_IC, Pa m^1/2: a crack of depth c runs where the stress across it exceeds about K_IC / sqrt(1.6 c).
    float fracture_toughness = 1.7e6f;
    // J/m^2, the energy that a blow spends on new surface: fifty times G = K_IC^2 / E of a brittle material, E being
    // Young's modulus. In crushing, about one part in fifty of the energy becomes new surface; the rest becomes heat
    // and sound. For wood, whose fibres take the energy as they are pulled out, its work of fracture across the grain.
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

// The material with every force that breaks it multiplied by `factor`: its tensile, compressive and shear strength and
// its fracture toughness. Its fracture energy stays.
[[nodiscard]] Material scale_strength(const Material& material, float factor);

// Depth, m, of the crack that a hard contact of a force (N) makes below it: (contact_sharpness force / K_IC)^(2/3)
// (Lawn, "Fracture of Brittle Solids", chapter 8). Zero for no force; infinite for an infinite one.
[[nodiscard]] double contact_crack(const Material& material, double force);

// 0.016 sqrt(E / hardness), 0.05 to 0.06 for glass, porcelain and granite (Anstis, Chantikul, Lawn and Marshall, "A
// critical evaluation of indentation techniques for measuring fracture toughness", 1981).
inline constexpr double contact_sharpness = 0.05;

// Force, N, of a hard contact that breaks a section of an area, m^2: the lower of
// - the strength of the material, tensile * area;
// - the strength that the contact leaves. Its crack, c deep, lets the section bear K_IC / (1.26 sqrt(c)), for a half
//   penny in a surface. With c = contact_crack() of the same force: (1.26 contact_sharpness^(1/3))^(-3/4) K_IC
//   area^(3/4), about 1.8 K_IC area^(3/4) (Lawn, chapter 10; Lawn, Wiederhorn and Johnson, "Strength degradation of
//   brittle surfaces: blunt indenters", 1975).
// So glass, which is stronger than stone, breaks before stone where it is thicker than a few centimetres: toughness
// decides there. Thin panes keep more of their strength. Zero for an area that is not positive.
[[nodiscard]] double breaking_force(const Material& material, double area);

// Share of the strength of an area, m^2, that a hard contact leaves: breaking_force() / (tensile * area), at most 1.
[[nodiscard]] double contact_strength_share(const Material& material, double area);

// Names the first density, strength, toughness or fracture energy that is not positive and finite; empty for a valid
// material. A world checks friction and restitution itself.
[[nodiscard]] std::string fault_of(const Material& material);

// Density, friction, restitution, strengths and toughness are rounded handbook values of annealed glass, granite, plain
// concrete, softwood (between its values along and across the grain; toughness across it), porcelain, and clay bricks
// in mortar. Ashby, "Materials Selection in Mechanical Design", has them, but for the toughness of concrete, which is
// that of a fracture energy of 100 J/m^2 (CEB-FIP Model Code 1990) at 30 GPa.
struct MaterialPreset {
    std::string_view name;
    Material material;
    fracture::Pattern pattern; // kind and shape; its count and seed are the caller's
    fracture::Roughness rough; // amount, grain and detail; size and seed are the caller's
    glm::vec3 exterior;        // linear colour of the original surface
    glm::vec3 interior;        // linear colour of fracture surfaces
};

// In this order: glass, stone, concrete, wood, ceramic, brick.
[[nodiscard]] std::span<const MaterialPreset> material_presets();
// Null for an unknown name.
[[nodiscard]] const MaterialPreset* material_preset(std::string_view name);

} // namespace brittle::physics

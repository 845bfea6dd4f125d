#include "physics/material.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <utility>

namespace brittle::physics {

using fracture::PatternKind;

Material scale_strength(const Material& material, float factor) {
    Material scaled = material;
    for (float* strength : {&scaled.tensile, &scaled.compressive, &scaled.shear, &scaled.fracture_toughness})
        *strength *= factor;
    return scaled;
}

double contact_crack(const Material& material, double force) {
    if (!(force > 0.0)) return 0.0;
    const double root = std::cbrt(contact_sharpness * force / static_cast<double>(material.fracture_toughness));
    return root * root;
}

double contact_strength_share(const Material& material, double area) {
    constexpr double half_penny = 1.26; // 1.12 * 2 / pi * sqrt(pi)
    // (half_penny contact_sharpness^(1/3))^(-3/4)
    static const double shape = 1.0 / std::sqrt(std::sqrt(half_penny * half_penny * half_penny * contact_sharpness));
    if (!(area > 0.0)) return 0.0;
    const double toughness = static_cast<double>(material.fracture_toughness);
    return std::min(1.0, shape * toughness / (static_cast<double>(material.tensile) * std::sqrt(std::sqrt(area))));
}

double breaking_force(const Material& material, double area) {
    if (!(area > 0.0)) return 0.0;
    return static_cast<double>(material.tensile) * area * contact_strength_share(material, area);
}

std::string fault_of(const Material& material) {
    std::ostringstream text;
    if (!(material.density > 0.0f) || !std::isfinite(material.density))
        text << "the material's density is " << material.density << " kg/m^3; it must be positive";
    for (const auto& [name, value] :
         {std::pair("tensile", material.tensile), {"compressive", material.compressive}, {"shear", material.shear}})
        if (text.str().empty() && (!(value > 0.0f) || !std::isfinite(value)))
            text << "the material's " << name << " strength is " << value << " Pa; it must be positive";
    if (text.str().empty() && (!(material.fracture_toughness > 0.0f) || !std::isfinite(material.fracture_toughness)))
        text << "the material's fracture toughness is " << material.fracture_toughness
             << " Pa m^1/2; it must be positive";
    if (text.str().empty() && (!(material.fracture_energy > 0.0f) || !std::isfinite(material.fracture_energy)))
        text << "the material's fracture energy is " << material.fracture_energy << " J/m^2; it must be positive";
    return text.str();
}

std::span<const MaterialPreset> material_presets() {
    static const std::array presets = {
        // Rings of shards around the point of impact, each as deep as the pane. Its fracture surfaces are smooth.
        MaterialPreset{"glass",
                       {2500.0f, 0.5f, 0.3f, 40e6f, 1000e6f, 40e6f, 0.75e6f, 5e2f},
                       {.kind = PatternKind::radial, .jitter = 0.5, .axis = {0.0, 0.0, 1.0}},
                       {},
                       {0.42f, 0.56f, 0.52f},
                       {0.20f, 0.42f, 0.36f}},
        MaterialPreset{"stone",
                       {2600.0f, 0.8f, 0.2f, 8e6f, 150e6f, 15e6f, 1.8e6f, 5e3f},
                       {.kind = PatternKind::uniform},
                       {.amount = 0.8, .detail = 2},
                       {0.62f, 0.60f, 0.56f},
                       {0.45f, 0.32f, 0.23f}},
        // Crumbs at the point of impact, large lumps elsewhere.
        MaterialPreset{"concrete",
                       {2400.0f, 0.8f, 0.15f, 3e6f, 30e6f, 5e6f, 1.7e6f, 5e3f},
                       {.kind = PatternKind::clustered, .spread = 0.3},
                       {.amount = 1.0, .detail = 2},
                       {0.50f, 0.50f, 0.48f},
                       {0.30f, 0.29f, 0.27f}},
        MaterialPreset{"wood",
                       {700.0f, 0.6f, 0.25f, 15e6f, 15e6f, 7e6f, 5e6f, 1e4f},
                       {.kind = PatternKind::splinters, .slenderness = 8.0},
                       {.amount = 0.8, .grain = {0.0, 4.0, 0.0}, .detail = 2},
                       {0.36f, 0.20f, 0.09f},
                       {0.58f, 0.38f, 0.19f}},
        // Thin walls break into small sherds, thick walls into large ones, along smooth, bent (conchoidal) surfaces.
        MaterialPreset{"ceramic",
                       {2300.0f, 0.5f, 0.25f, 30e6f, 400e6f, 35e6f, 1.0e6f, 1e3f},
                       {.kind = PatternKind::thickness},
                       {.amount = 0.6, .detail = 1},
                       {0.75f, 0.74f, 0.70f},
                       {0.55f, 0.22f, 0.10f}},
        // Breaks along its joints.
        MaterialPreset{"brick",
                       {1900.0f, 0.7f, 0.15f, 1e6f, 12e6f, 1.5e6f, 0.45e6f, 1e3f},
                       {.kind = PatternKind::bricks},
                       {.amount = 0.4, .detail = 1},
                       {0.38f, 0.16f, 0.11f},
                       {0.52f, 0.24f, 0.15f}}};
    return presets;
}

const MaterialPreset* material_preset(std::string_view name) {
    const auto presets = material_presets();
    const auto found = std::find_if(presets.begin(), presets.end(), [&](const auto& p) { return p.name == name; });
    return found == presets.end() ? nullptr : &*found;
}

} // namespace brittle::physics

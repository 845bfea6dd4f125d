#include "physics/material.h"

#include <cmath>
#include <limits>
#include <string>

#include <doctest/doctest.h>

using namespace brittle::physics;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

double force_of(const char* name, double area) {
    return breaking_force(material_preset(name)->material, area);
}

// Structural steel: beyond the presets, the far end of the scale.
constexpr Material steel{.density = 7850.0f,
                         .tensile = 400e6f,
                         .compressive = 400e6f,
                         .shear = 250e6f,
                         .fracture_toughness = 50e6f,
                         .fracture_energy = 1e5f};

} // namespace

TEST_CASE("material presets are valid, and the fault of an invalid material is named") {
    for (const MaterialPreset& preset : material_presets()) {
        CHECK(fault_of(preset.material).empty());
        CHECK(preset.material.compressive >= preset.material.tensile);
    }
    CHECK(fault_of({.density = NAN}).find("density") != std::string::npos);
    CHECK(fault_of({.compressive = 0.0f}).find("compressive") != std::string::npos);
    CHECK(fault_of({.shear = std::numeric_limits<float>::infinity()}).find("shear") != std::string::npos);
    for (const float bad : {0.0f, -1.0f, NAN, std::numeric_limits<float>::infinity()}) {
        CHECK(fault_of({.fracture_toughness = bad}).find("toughness") != std::string::npos);
        CHECK(fault_of({.fracture_energy = bad}).find("energy") != std::string::npos);
    }
}

TEST_CASE("material: no force makes no crack, and no area bears no force") {
    const Material material;
    for (const double none : {0.0, -1.0, -infinity, std::nan("")}) {
        CHECK(contact_crack(material, none) == 0.0);
        CHECK(breaking_force(material, none) == 0.0);
        CHECK(contact_strength_share(material, none) == 0.0);
    }
    CHECK(contact_crack(material, infinity) == infinity);
}

// The oracle is the equilibrium of a half penny crack, K_IC = 1.26 stress sqrt(depth), by Lawn.
TEST_CASE("material: a section bears its tensile strength or that of its contact crack, whichever is lower") {
    for (const MaterialPreset& preset : material_presets())
        for (double area = 1e-9; area < 1e3; area *= 2.7) {
            CAPTURE(preset.name);
            CAPTURE(area);
            const Material& material = preset.material;
            const double force = breaking_force(material, area), stress = force / area;
            const double intensity = 1.26 * stress * std::sqrt(contact_crack(material, force));
            const double strength = static_cast<double>(material.tensile),
                         toughness = static_cast<double>(material.fracture_toughness);
            CHECK(stress <= strength * (1.0 + 1e-12));
            CHECK(intensity <= toughness * (1.0 + 1e-6));
            CHECK((stress > strength * (1.0 - 1e-12) || intensity > toughness * (1.0 - 1e-6)));
            CHECK(breaking_force(material, 1.01 * area) > force);
            const Material third = scale_strength(material, 0.3f);
            CHECK(breaking_force(third, area) == doctest::Approx(0.3 * force));
            CHECK(third.fracture_energy == material.fracture_energy);
        }
}

TEST_CASE("material: of thick sections those of glass and ceramic break first, of wood and steel last") {
    for (double area = 0.15; area < 100.0; area *= 1.3) {
        CAPTURE(area);
        CHECK(force_of("glass", area) < force_of("ceramic", area));
        for (const char* harder : {"concrete", "stone"}) {
            CHECK(force_of("ceramic", area) < force_of(harder, area));
            CHECK(force_of(harder, area) < force_of("wood", area));
        }
        CHECK(force_of("wood", area) < breaking_force(steel, area));
    }
    // Panes and cups are thin: their strength counts. A pane of concrete of 5 mm by 1 m breaks before one of glass.
    CHECK(force_of("glass", 0.005) > force_of("concrete", 0.005));
    // The energy of new surface has the same order.
    const auto energy_of = [](const char* name) { return material_preset(name)->material.fracture_energy; };
    CHECK(energy_of("glass") < energy_of("ceramic"));
    CHECK(energy_of("ceramic") < energy_of("stone"));
    CHECK(energy_of("stone") < energy_of("wood"));
    CHECK(energy_of("wood") < steel.fracture_energy);
}

// Materials of the C interface.
#include "physics/material.h"
#include "bindings/c/handles.h"
#include "fracture/sites/pattern.h"

using namespace brittle;

namespace brittle::c {

const physics::MaterialPreset& preset_of(const char* name) {
    const std::string material = name ? name : "stone";
    const physics::MaterialPreset* preset = physics::material_preset(material);
    if (!preset) {
        std::string known;
        for (const auto& one : physics::material_presets()) known.append(known.empty() ? "" : ", ").append(one.name);
        refuse("there is no material named '" + material + "'; the materials are: " + known);
    }
    return *preset;
}

namespace {

// Names of presets and patterns are literals, so their text ends with zero.
brittle_material material_of(const physics::MaterialPreset& preset) {
    brittle_material values{};
    values.rough_detail = preset.rough.detail;
    values.name = preset.name.data();
    values.density = preset.material.density;
    values.friction = preset.material.friction;
    values.restitution = preset.material.restitution;
    values.tensile = preset.material.tensile;
    values.compressive = preset.material.compressive;
    values.shear = preset.material.shear;
    values.fracture_toughness = preset.material.fracture_toughness;
    values.fracture_energy = preset.material.fracture_energy;
    values.pattern = fracture::pattern_names()[static_cast<size_t>(preset.pattern.kind)].data();
    values.pattern_jitter = preset.pattern.jitter;
    values.pattern_spread = preset.pattern.spread;
    values.pattern_slenderness = preset.pattern.slenderness;
    values.roughness = preset.rough.amount;
    for (int k = 0; k < 3; ++k) {
        values.pattern_axis[k] = preset.pattern.axis[k];
        values.rough_grain[k] = preset.rough.grain[k];
        values.exterior[k] = static_cast<double>(preset.exterior[k]);
        values.interior[k] = static_cast<double>(preset.interior[k]);
    }
    return values;
}

} // namespace

} // namespace brittle::c

using c::guarded;
using c::need;

extern "C" {

const char* brittle_material_name(uint32_t index) {
    const auto presets = physics::material_presets();
    return index < presets.size() ? presets[index].name.data() : nullptr;
}

brittle_status brittle_material_get(const char* name, brittle_material* out, brittle_error* error) {
    return guarded(error, [&] {
        need(out, "out");
        c::write_struct(c::material_of(c::preset_of(c::read_text(name, "name").c_str())), out, "out");
    });
}

} // extern "C"

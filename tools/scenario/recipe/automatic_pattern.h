// A pattern that is chosen for a mesh, so that objects of a scene break into pieces of a size that suits their stuff,
// whatever their size.
//
//     options.automatic = AutomaticPattern{};                             // "pattern": {"type": "automatic"}
//     Pattern pattern = automatic_pattern(*options.automatic, options.pattern, mesh, material);
#pragma once

#include <cstdint>
#include <string_view>

#include "fracture/mesh/mesh.h"
#include "fracture/sites/pattern.h"
#include "physics/material.h"

namespace brittle::tools {

struct AutomaticPattern {
    double scale = 1.0;     // factor of the size of pieces
    bool named_seed = true; // the seed comes from the name of the object, not from its pattern

    friend bool operator==(const AutomaticPattern&, const AutomaticPattern&) = default;
};

// Size of the pieces of stone, m. That of other stuff is to it as (K_IC / density)^(2/3): Grady's balance of inertia and
// toughness ("Local inertial effects in dynamic fragmentation", 1982), at one speed of sound and rate of strain.
inline constexpr double stone_piece_size = 0.2;

// The pattern of a material (`shape`: kind, axis, seed and so on) with a count for a closed mesh in metres. Pieces are
// as large as the material wants them, and as thick as the mesh where it is thinner. There are 8 to 1,000 of them.
// Pieces that lie anywhere (uniform) become smaller where the mesh is thin.
[[nodiscard]] fracture::Pattern automatic_pattern(const AutomaticPattern& automatic, const fracture::Pattern& shape,
                                                  const fracture::TriangleMesh& mesh,
                                                  const physics::Material& material);

// A seed for a name: FNV-1a, equal on every machine.
[[nodiscard]] uint64_t seed_of_name(std::string_view name);

} // namespace brittle::tools

// Where a thing that starts whole and is held gives way: under its weight and what rests on it, or under a blow that does
// not break it where it lands.
//
// For this the solid is taken as blocks: Voronoi cells of sites in the middle between its sides, closer together where it is
// thin. So a stem is blocks one upon another, whose contacts are its sections. How blocks bear on each other is what
// StressSolver finds; contacts beyond their strength part, the worst first, until all that is left bears its load.
//
//     std::shared_ptr<const HeldBlocks> blocks = held_blocks(mesh, density, anchors);
//     std::vector<uint32_t> islands = overloaded(*blocks, material, gravity, {});   // all 0: it stands
//
// A blow that breaks nothing where it lands sets what it hits moving: J^2 / (2 m) of energy, where m is all that the
// weakest section under it lets go of; or the blow's own energy where that is less. That section breaks where this is more than the fracture energy of its area
// (Griffith, as in impact_pattern.h): a tap leaves a statue on its ankles, a ram does not.
//
// Coordinates of the solid, SI units. Pure functions for worker threads; equal input gives equal results.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"
#include "physics/bonds/stress.h"
#include "physics/material.h"

namespace brittle::physics {

struct HeldBlockSettings {
    bool enabled = true;
    uint32_t max_blocks = 96; // blocks aimed at; sites in what is evenly thick stop earlier. At least 2
    // Of the material's strengths, against loads that last: as WearSettings::strength_scale.
    float strength_scale = 0.05f;
};

struct HeldBlocks {
    std::vector<glm::dvec3> sites;
    std::vector<StressNode> nodes; // one a piece of the fracture by the sites, in its order
    std::vector<StressBond> bonds;
    double min_area = 0.0; // m^2, of a contact
};

// Sites for blocks: each is halfway through the solid from a place of its surface, the farthest from all before in
// thicknesses there, until none is farther than half of one. The first is in the thinnest place.
[[nodiscard]] std::vector<glm::dvec3> block_sites(const fracture::TriangleMesh& mesh, uint32_t max_sites);

// Null where the solid cannot be cut, or is one block. `held` says which pieces of the fracture the world holds.
[[nodiscard]] std::shared_ptr<const HeldBlocks>
held_blocks(const fracture::TriangleMesh& mesh, float density, const HeldBlockSettings& settings,
            const std::function<bool(const fracture::Fragments&, const fracture::Piece&)>& held, uint32_t threads = 1,
            const std::function<bool()>& cancelled = {});

// At a point: a force that lasts, N; of a blow its impulse, N s.
struct PointLoad {
    glm::dvec3 point{0.0};
    glm::dvec3 force{0.0};
};

// For each block the island that it is in when what is overloaded has parted, islands numbered by their first blocks:
// all 0 where the solid stands. Islands that nothing holds stay together. Pushes go to the nearest block.
[[nodiscard]] std::vector<uint32_t> overloaded(const HeldBlocks& blocks, const Material& material, float strength_scale,
                                               const glm::dvec3& gravity, std::span<const PointLoad> contact_loads);

// The same after a blow of an impulse, N s, at a point, and with the weight of what is left; energy, J, is the blow's own: what
// is light gets no more.
[[nodiscard]] std::vector<uint32_t> knocked_loose(const HeldBlocks& blocks, const Material& material,
                                                  float strength_scale, const glm::dvec3& gravity,
                                                  const PointLoad& impulse, double energy);

} // namespace brittle::physics

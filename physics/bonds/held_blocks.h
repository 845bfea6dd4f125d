// Fracture of a whole solid that is held in place, under its weight and its loads, or under a blow that does not break
// it at the point of impact.
//
// The solid is divided into blocks: the Voronoi cells of sites midway between its sides, denser where it is thin. A
// stem becomes a row of blocks whose contacts are its cross sections. StressSolver finds the stresses between the
// blocks. Contacts beyond their strength break, the most loaded first, until the rest bears its load.
//
//     std::shared_ptr<const HeldBlocks> blocks = held_blocks(mesh, density, settings, is_held);
//     std::vector<uint32_t> islands = islands_under_load(*blocks, material, sustained_strength, gravity, {});
//     // all 0: the solid stands
//
// A blow of impulse J that breaks nothing where it lands gives the struck part the kinetic energy J^2 / (2 m), at most
// the energy of the blow; m is the mass beyond the weakest section under the blow. That section breaks if the energy
// exceeds its area times the fracture energy (Griffith, as in impact_pattern.h): a tap leaves a statue on its ankles,
// a ram does not.
//
// Coordinates of the solid, SI units. Pure functions for worker threads; deterministic.
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
    uint32_t max_blocks = 96;                  // upper bound, at least 2; fewer in a solid of even thickness
    float strength_scale = sustained_strength; // factor on the material's strengths against permanent loads
};

struct HeldBlocks {
    std::vector<glm::dvec3> sites;
    std::vector<StressNode> nodes; // one a piece, in the order of the flat fracture by `sites`
    std::vector<uint32_t> cells;   // by node: the site of its cell
    std::vector<StressBond> bonds;
    double min_area = 0.0; // m^2, of the smallest contact
    // When the solid was divided: the masses of the nodes, kg, and the areas of the bonds, m^2.
    std::vector<double> first_masses, first_areas;
};

// Returns sites for blocks. Candidates lie halfway through the solid from sampled surface points. The first site is at
// the thinnest place; each further one is the candidate that is farthest from all sites, measured in local
// thicknesses. Stops at max_sites, or where no candidate is farther than half a thickness. Empty for a mesh without
// area or interior.
[[nodiscard]] std::vector<glm::dvec3> block_sites(const fracture::TriangleMesh& mesh, uint32_t max_sites);

// Divides the solid into blocks. `held` returns whether a piece of that fracture is fixed to the world. threads: 0 is
// one a core. One block without bonds if the solid has no thin places. Null if it cannot be fractured, or if `cancelled`
// returns true.
[[nodiscard]] std::shared_ptr<const HeldBlocks>
held_blocks(const fracture::TriangleMesh& mesh, float density, const HeldBlockSettings& settings,
            const std::function<bool(const fracture::Fragments&, const fracture::Piece&)>& held, uint32_t threads = 1,
            const std::function<bool()>& cancelled = {});

// The blocks of a solid that lost some of its pieces: masses and contact areas less those of `lost`, the closed surfaces
// of the pieces. Costs a fracture of these alone. Null where the solid must be divided anew, because blocks no longer
// tell where it is weak: a contact or a block has lost too much, or it is not clear which block has lost something.
// Precondition: no lost piece is held.
[[nodiscard]] std::shared_ptr<const HeldBlocks>
blocks_without(const HeldBlocks& blocks, const fracture::TriangleMesh& lost, float density, uint32_t threads = 1);

// A permanent force, N, or the impulse of a blow, N s, at a point of the solid.
struct PointLoad {
    glm::dvec3 point{0.0};
    glm::dvec3 force{0.0};
};

// Breaks overloaded contacts until none is left, and returns the island of each block. Islands are numbered by their
// first blocks; all are 0 if the solid stands. An island without a fixed block carries no load and stays whole. Each
// contact load acts on the nearest block.
[[nodiscard]] std::vector<uint32_t> islands_under_load(const HeldBlocks& blocks, const Material& material,
                                                       float strength_scale, const glm::dvec3& gravity,
                                                       std::span<const PointLoad> contact_loads);

// Returns the islands after a blow of an impulse (N s) at a point and of an energy (J), which bounds the kinetic energy
// of the struck part; all 0 if no section breaks. Once a section breaks, further contacts may break under the weight.
[[nodiscard]] std::vector<uint32_t> islands_after_blow(const HeldBlocks& blocks, const Material& material,
                                                       float strength_scale, const glm::dvec3& gravity,
                                                       const PointLoad& impulse, double energy);

} // namespace brittle::physics

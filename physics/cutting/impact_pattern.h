// Voronoi sites of a blow: where the cells around a contact cut a solid, in the pattern of its material.
//
// Each cell near the contact becomes a piece. All cells beyond share one group (Settings::groups), so the rest of the
// solid stays together. A shell of such cells around the damage ends the cracks at its radius.
//
// Extent and fineness. A blow of energy E makes the new surface A = E / Material::fracture_energy, m^2. With L the cube
// root of the solid's volume, it makes n = 24 sqrt(A) / L pieces, at least 4 and at most max_pieces. n equal cubes in a
// half ball of radius R and volume V = 2/3 pi R^3 share the surface 3 V / (V / n)^(1/3) = 4.9 R^2 n^(1/3), so R =
// sqrt(A / (4.9 n^(1/3))). Hence R grows as E^(5/12) and n as E^(1/2). The energy of a blow becomes new surface:
// Griffith, "The phenomena of rupture and flow in solids", 1921; for comminution, Rittinger's law.
//
// Local damage. A solid that bears the force of the blow as a whole chips: the damage reaches no farther than
// contact_crack() (material.h) of the force, with fewer pieces in the same proportion.
//
//     const Damage damage = damage_of(blow, material, volume, limits);
//     const ImpactSites cut = impact_sites(solid, mass, blow, damage, {.kind = PatternKind::radial, .seed = 7});
//
// Coordinates of the solid, metres, joules. Pure functions; equal input gives equal sites on every machine.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/local/cluster_mesh.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/mesh/mesh.h"
#include "fracture/sites/pattern.h"
#include "physics/cutting/running_bond.h"
#include "physics/material.h"

namespace brittle::physics {

struct Blow {
    glm::dvec3 point{0.0};
    glm::dvec3 normal{0.0, -1.0, 0.0}; // unit, into the solid
    double energy = 0.0;               // J
    // N, of a blow of impact_seconds; infinite where the energy alone decides.
    double force = std::numeric_limits<double>::infinity();
};

struct DamageLimits {
    uint32_t max_pieces = 48;
    double min_volume = 0.0; // m^3, lower limit of the mean volume of the pieces
    double bearable = 0.0;   // N; a blow of no more force leaves local damage
};

struct Damage {
    double radius = 0.0; // m; 0: the blow breaks nothing
    uint32_t pieces = 0;
    bool local = false; // the solid bears the blow as a whole
};

// Extent of the damage. None for an energy or volume that is not positive and finite, for a point or normal that is not
// finite, for a zero normal, for a force that is not positive, for damage below the minimum volume,
// and for a solid below twice the minimum volume.
[[nodiscard]] Damage damage_of(const Blow& blow, const Material& material, double volume,
                               const DamageLimits& limits = {});

// Energy, J, of the blow whose damage has the given radius, without a minimum volume. For tools with a fixed reach. 0
// for a radius or volume that is not positive and finite.
[[nodiscard]] double energy_of(double radius, const Material& material, double volume, uint32_t max_pieces);

// Energy, J, of the weakest blow that does damage, among blows of the same striker at other speeds: the force grows as
// the speed, the energy as its square. `bounce`: share of the energy that the striker keeps where the solid bears the blow.
// Infinite where not even a thousand times the speed suffices.
[[nodiscard]] double breaking_energy(const Blow& blow, double bounce, const Material& material, double volume,
                                     const DamageLimits& limits);

struct ImpactPattern {
    // uniform: half of the pieces anywhere in the damage, half close to the contact. clustered, thickness: close to the
    // contact. radial: where the damage goes through the solid along the normal, rays of cracks from the contact to the
    // edges with concentric cracks between them, or a hole with a sharp rim where the energy does not pay for rays to
    // the edges; elsewhere shards in rings around the contact. splinters: long along the solid's longest principal
    // axis. bricks: whole bricks of the bond, the nearest first; as uniform for a single brick, and where the damage
    // reaches no half brick's middle. All others: as uniform.
    fracture::PatternKind kind = fracture::PatternKind::uniform;
    uint64_t seed = 1;
    double slenderness = 8.0; // splinters: length by width
    RunningBond bond{}; // bricks: in the solid's coordinates, so that every blow on an object meets the same bricks
    // Sites made in advance, which replace those of `kind`: fitted to the solid's box, turned about Y by the seed and
    // then placed by `placement`. Cells beyond the damage stay together (the paper, section 4).
    std::vector<glm::dvec3> diagram{};
    fracture::Placement placement{};
};

struct ImpactSites {
    std::vector<glm::dvec3> sites;
    std::vector<uint32_t> groups; // by site: the piece's number, or `rest`
    uint32_t rest = 0;            // group of the cells that stay together
    bool bricks = false;          // whole bricks come off, rather than crumbs
};

// The direction of the least moment of inertia, along which splinters run. A unit vector.
[[nodiscard]] glm::dvec3 longest_axis(const fracture::MassProperties& mass);

// Empty without damage. The cost of the second one does not grow with the solid.
[[nodiscard]] ImpactSites impact_sites(const fracture::TriangleMesh& solid, const fracture::MassProperties& mass,
                                       const Blow& blow, const Damage& damage, const ImpactPattern& pattern);
[[nodiscard]] ImpactSites impact_sites(const fracture::ClusterMesh& solid, const fracture::MassProperties& mass,
                                       const Blow& blow, const Damage& damage, const ImpactPattern& pattern);

// Farthest-point sampling: up to `count` of the vertices, each the farthest from those before it and from `given`.
// Considers fewer than 8,192 vertices, evenly strided. Fewer points where fewer distinct vertices exist.
[[nodiscard]] std::vector<glm::dvec3> spread_points(std::span<const glm::dvec3> vertices, uint32_t count,
                                                    std::span<const glm::dvec3> given = {});

} // namespace brittle::physics

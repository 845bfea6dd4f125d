// Where a blow cuts: Voronoi sites around a point of contact, in the manner of a material.
//
// Near the contact each cell becomes a piece; all cells beyond share one group, so that what is left stays together
// (Settings::groups). A shell of such cells ends the damage where it should end.
//
// How far and how fine: a blow of energy E makes the new surface A = E / Material::fracture_energy, m^2. With the size L =
// cube root of the solid's volume, it makes about n = 24 sqrt(A) / L pieces (4 at least, max_pieces at most). n equal
// cubes in a half ball of radius R have 3 V / (V / n)^(1/3) of surface between them, V = 2/3 pi R^3, that is 4.9 R^2 n^(1/3);
// so R = sqrt(A / (4.9 n^(1/3))). R grows as E^(5/12) and n as E^(1/2). That the energy of a blow goes into new
// surface is Griffith, "The phenomena of rupture and flow in solids", 1921; for comminution, Rittinger's law.
//
//     const Damage damage = damage_of(blow, material, volume, limits);
//     const ImpactSites cut = impact_sites(solid, blow, damage, {.kind = PatternKind::radial, .seed = 7});
//
// Coordinates of the solid, metres, joules. Pure functions; equal input gives equal sites on every machine.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

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
};

struct DamageLimits {
    uint32_t max_pieces = 48;
    double min_volume = 0.0; // m^3; damage is not cut into pieces that are smaller in the mean
};

struct Damage {
    double radius = 0.0; // m; 0: nothing breaks
    uint32_t pieces = 0;
};

// No damage for an energy, volume, point or normal that is not positive or not finite, and where fewer than two pieces of
// the least volume would come of it.
[[nodiscard]] Damage damage_of(const Blow& blow, const Material& material, double volume,
                               const DamageLimits& limits = {});

// The energy, J, of a blow whose damage reaches that far, without min_volume: what a hammer of a given reach strikes with.
// 0 for a radius or volume that is not positive and finite.
[[nodiscard]] double energy_of(double radius, const Material& material, double volume, uint32_t max_pieces);

struct ImpactPattern {
    // radial: shards in rings around the contact, through the solid along the normal. uniform: half of the pieces anywhere
    // in the damage, half close to the contact. clustered, thickness: close to the contact. splinters: long along the
    // solid's longest principal axis. bricks: whole ones out of the bond, the nearest first; as uniform of a brick by itself,
    // and where the damage reaches the middle of no half. Others: as uniform.
    fracture::PatternKind kind = fracture::PatternKind::uniform;
    uint64_t seed = 1;
    double slenderness = 8.0; // splinters: length by width
    RunningBond bond{};       // bricks: in the solid's coordinates, so all blows on an object find the same
    // A diagram made beforehand in place of those: fitted to the solid's box, turned by the seed and moved as the
    // placement says; its cells beyond the damage stay together (the paper, section 4).
    std::vector<glm::dvec3> diagram{};
    fracture::Placement placement{};
};

struct ImpactSites {
    std::vector<glm::dvec3> sites;
    std::vector<uint32_t> groups; // one a site; rest where it stays together
    uint32_t rest = 0;            // the group of what is left
    bool bricks = false;          // whole ones come off, not crumbs
};

// Empty where there is no damage.
[[nodiscard]] ImpactSites impact_sites(const fracture::TriangleMesh& solid, const fracture::MassProperties& mass,
                                       const Blow& blow, const Damage& damage, const ImpactPattern& pattern);

// count points of the solid's surface, far from each other and from those given: each is, of at most 4,096 vertices,
// the farthest from all before. Fewer where there are fewer vertices.
[[nodiscard]] std::vector<glm::dvec3> spread_points(std::span<const glm::dvec3> vertices, uint32_t count,
                                                    std::span<const glm::dvec3> given = {});

} // namespace brittle::physics

// Assemblies: the pieces of several objects in one Structure, bonded by glue where the objects touch.
//
//     std::vector<AssemblyPart> parts{{&wall, wall_desc}, {&shelf, shelf_desc}};
//     Result<Assembly> made = assemble(world, parts, glue);
//     each step:  world.step();  made->structure.update(world);
//
// - Glued objects move as one body, with the mass and inertia of all their pieces, until glue or bonds break.
// - The coordinates of the structure are those of the first part: its fragments are not turned, and its hulls are
//   shared. Pieces are numbered part by part.
// - Glue to something that is fixed gets a support (StructureDesc), numbered after all pieces. The support lies where
//   an equal neighbour of the piece would: that decides the lever of the bond.
// - Glue is a bond like any other: blows, loads and wear break it. A part that comes off as a whole is no debris
//   (Structure::is_detached()).
//
// World coordinates unless stated; metres, kilograms, seconds. Deterministic; follows the thread rule of Structure.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "fracture/pieces/fragments.h"
#include "physics/bonds/structure.h"
#include "physics/material.h"
#include "physics/world/world.h"

namespace brittle::physics {

struct AssemblyPart {
    const fracture::Fragments* fragments = nullptr; // in coordinates of the part; used by assemble() alone
    // As for a structure of its own. Velocities, impact_speed and wear are those of the first part.
    StructureDesc desc{};
};

// A bond between pieces of two parts, or between a piece and something that is fixed.
struct GlueBond {
    struct Side {
        uint32_t part = 0;
        uint32_t piece = 0; // of the part
    };
    Side a{};
    std::optional<Side> b{};                  // nothing: something that is fixed
    double area = 0.0;                        // m^2, positive
    glm::dvec3 centroid{0.0};                 // in the world
    glm::dvec3 normal{0.0};                   // unit, from a to b, in the world
    float strength = 1.0f;                    // positive; multiple of the strength of the weaker material
    std::optional<Material> fixed_material{}; // of what is fixed; nothing: that of the piece
};

// From the coordinates of a part to those of the structure.
struct PartPlacement {
    glm::dquat turn{1.0, 0.0, 0.0, 0.0};
    glm::dvec3 move{0.0};

    [[nodiscard]] glm::dvec3 to_structure(const glm::dvec3& p) const { return move + turn * p; }
    [[nodiscard]] glm::dvec3 to_part(const glm::dvec3& p) const { return glm::conjugate(turn) * (p - move); }
    [[nodiscard]] bool is_turned() const { return turn != PartPlacement{}.turn; }
    // Of a piece, about its centre of mass, from the axes of the part to those of the structure. The same bits where the
    // part is not turned.
    [[nodiscard]] glm::dmat3 to_structure(const glm::dmat3& inertia) const;
    [[nodiscard]] std::vector<BodyPart> to_structure(std::vector<BodyPart> hulls) const;
};

struct Assembly {
    Structure structure;
    std::vector<uint32_t> first_piece;     // by part; after the last part, the number of pieces without supports
    std::vector<PartPlacement> placements; // by part; the first one's is the identity
};

// Fails as Structure::create() does, naming the part where there are several, and with invalid_setting where there is
// no part, and on glue whose pieces, area or strength are invalid or whose sides are one part. On failure the world is
// unchanged.
[[nodiscard]] Result<Assembly> assemble(World& world, std::span<const AssemblyPart> parts,
                                        std::span<const GlueBond> glue);

} // namespace brittle::physics

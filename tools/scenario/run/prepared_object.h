// An object that is ready to join a simulation: its pieces with their bodies, and how they hold together and break.
//
//     PreparedObject vase{.name = "vase", .fragments = pieces, .world = world_of(options), .material = "ceramic"};
//     prepare(vase);                                       // on any thread: most of the cost of a start
//     simulation.start({std::move(vase), ...}, world);
//
// Objects that differ in their place alone share fragments and solids: copy_of() one that is prepared.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"
#include "physics/bonds/structure.h"
#include "physics/cutting/destruction.h"
#include "physics/cutting/piece_payload.h"
#include "physics/cutting/solid_piece.h"
#include "physics/material.h"
#include "physics/world/hull.h"
#include "physics/world/world.h"
#include "tools/scenario/recipe/host.h"
#include "tools/scenario/recipe/world_options.h"

namespace brittle::tools {

// The part of a start that costs milliseconds: a hull a piece, or for breakable pieces a solid and a payload a piece.
struct PreparedBodies {
    physics::PieceHulls hulls;
    std::vector<physics::SolidPtr> solids;
    std::vector<physics::PayloadPtr> payloads;
};

// A contact at which an object is glued to another one of the scene.
struct PreparedGlue {
    uint32_t piece = 0;
    uint32_t other = 0; // an earlier object, or a fixed one
    uint32_t other_piece = 0;
    double area = 0.0;        // m^2
    glm::dvec3 centroid{0.0}; // in the world, for the places of both
    glm::dvec3 normal{0.0};   // unit, towards the other
    float strength = 1.0f;    // multiple of that of the weaker material
    // Held by a fixed joint, since one of the objects starts whole and breaks; else by a bond of their structure.
    bool by_joint = false;
};

struct PreparedObject {
    std::string name{};
    std::shared_ptr<const fracture::Fragments> fragments{};  // in the object's coordinates; null for a fixed object
    std::shared_ptr<const fracture::TriangleMesh> surface{}; // of a fixed object
    WorldOptions world{};                                    // of world_of()
    std::string material{};                                  // name of a preset, or empty
    bool rigid = false;                                      // never cut
    std::shared_ptr<const MeshLooks> looks{};                // of its mesh, for drawing; or null
    physics::Pose placement{};                               // from the object's coordinates to the world
    PreparedBodies bodies{};
    std::vector<PreparedGlue> glue{}; // set by find_glue() (scene_glue.h); copy_of() leaves it out

    [[nodiscard]] bool fixed() const { return surface != nullptr; }
    // Whether blows cut the object, or its separate parts, from whole.
    [[nodiscard]] bool breaks_from_whole() const { return !fixed() && !rigid && !world.bonded; }
};

// A physics::PayloadMaker that is also given the looks of the object, or null.
using DrawingMaker = std::function<physics::PayloadPtr(const physics::SolidPiece& piece,
                                                       const physics::SolidPiece* cut_from, const MeshLooks* looks)>;

// Makes the bodies. `payload` must be the simulation's. threads: 0 is one a core. Throws a Failure.
void prepare(PreparedObject& object, const DrawingMaker& payload = {}, uint32_t threads = 0);
// Returns an object with the fragments and solids of one that is breakable, rigid or fixed. Its payloads are its own;
// they are null without `payload`, for a stage that draws it like the other one.
[[nodiscard]] PreparedObject copy_of(const PreparedObject& object, const DrawingMaker& payload = {},
                                     uint32_t threads = 0);

// Hash of the pieces of all objects, and of the surfaces of fixed ones: fracture::hash() for one object.
[[nodiscard]] uint64_t pieces_hash(std::span<const PreparedObject> objects);

[[nodiscard]] physics::Material plain_material(const physics::MaterialPreset* preset);
// Of the bonds and pieces of an object: weaker than handbook values by flaws, and by the object's strength.
[[nodiscard]] physics::Material flawed_material(const PreparedObject& object);
// How the pieces of an object are bonded, and how they break.
[[nodiscard]] physics::StructureDesc structure_desc(const PreparedObject& object);
[[nodiscard]] physics::BreakableDesc breakable_desc(const PreparedObject& object, const DrawingMaker& payload);

} // namespace brittle::tools

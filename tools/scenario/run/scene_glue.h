// Where the glued objects of a scene touch (recipe/glue.h).
//
//     std::vector<std::string> notes = find_glue(scene, objects);      // sets PreparedObject::glue
//     simulation.start(std::move(objects), scene.world);
//
// Contacts are those of find_contacts() (fracture/pieces/contacts.h) between the pieces of two objects at their places
// in the world; an object that is not cut is one piece, and a fixed one its whole surface.
//
// Glue is a bond of a structure that the objects share (glued_groups()), or, where one of them starts whole and breaks,
// a fixed joint for each cell of the contact (glue_joint()). When a blow cuts the object, each joint goes on with the
// piece that is nearest to it: what is left of a glued face stays glued.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "physics/world/joint.h"
#include "tools/scenario/run/prepared_object.h"
#include "tools/scenario/run/scene.h"

namespace brittle::tools {

// `objects` are those of the scene, in its order, at their places. Returns notes for people: entries of glue that have
// no effect, and why. Throws a Failure.
std::vector<std::string> find_glue(const LoadedScene& scene, std::span<PreparedObject> objects);

// Returns the groups of objects that bonds of glue hold together, or to something fixed, by their first members;
// ascending.
[[nodiscard]] std::map<uint32_t, std::vector<uint32_t>> glued_groups(std::span<const PreparedObject> objects);

// The joint of a contact `by_joint` of an object. It bears what a bond of its area does, and bends as a disc would.
[[nodiscard]] physics::JointDesc glue_joint(std::span<const PreparedObject> objects, const PreparedObject& object,
                                            const PreparedGlue& contact, physics::BodyId a, physics::BodyId b);

} // namespace brittle::tools

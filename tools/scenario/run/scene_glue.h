// Where the glued objects of a scene touch (recipe/glue.h).
//
//     std::vector<std::string> notes = find_glue(scene, objects);      // sets PreparedObject::glue
//     simulation.start(std::move(objects), scene.world);
//
// Contacts are those of find_contacts() (fracture/pieces/contacts.h) between the pieces of two objects at their places
// in the world; an object that is not cut is one piece, and a fixed one its whole surface.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "tools/scenario/run/prepared_object.h"
#include "tools/scenario/run/scene.h"

namespace brittle::tools {

// `objects` are those of the scene, in its order, at their places. Returns notes for people: entries of glue that have
// no effect, and why. Throws a Failure.
std::vector<std::string> find_glue(const LoadedScene& scene, std::span<PreparedObject> objects);

// Returns the groups of objects that glue holds together, or to something fixed, by their first members; ascending.
[[nodiscard]] std::map<uint32_t, std::vector<uint32_t>> glued_groups(std::span<const PreparedObject> objects);

} // namespace brittle::tools

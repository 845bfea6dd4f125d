// The rigid-body properties of a piece as JSON of the glTF extension KHR_physics_rigid_bodies, in its draft of June
// 2026 (Khronos pull request 2424).
#pragma once

#include <cstddef>
#include <optional>

#include <nlohmann/json.hpp>

#include "fracture/mesh/mass_properties.h"

namespace brittle::fracture {

inline constexpr const char* rigid_body_extension = "KHR_physics_rigid_bodies";

// The extension object of the node of a piece. `mass`: at density 1, in the axes of the node, whose origin is the
// centre of mass. `density`: kg/m^3. `mesh`: the convex hull that is its collider; without it the piece has no
// collider of its own. A piece whose mass is not above 0 has a motion without mass, which engines compute themselves.
[[nodiscard]] nlohmann::ordered_json rigid_body_json(const MassProperties& mass, double density,
                                                     std::optional<size_t> mesh);
// The extension object of a child node that is one of several colliders of a piece.
[[nodiscard]] nlohmann::ordered_json collider_json(size_t mesh);
// The extension object of a node that never moves and collides with the surface of a mesh.
[[nodiscard]] nlohmann::ordered_json surface_collider_json(size_t mesh);

} // namespace brittle::fracture

// A piece as the extension KHR_physics_rigid_bodies of glTF says it, by the draft of 2024 (Khronos pull request 2424).
#pragma once

#include <cstddef>
#include <optional>

#include <nlohmann/json.hpp>

#include "fracture/mesh/mass_properties.h"

namespace brittle::fracture {

inline constexpr const char* rigid_body_extension = "KHR_physics_rigid_bodies";

// `mass` at density 1 in the node's axes, `density` in kg/m^3; the node's origin is the centre of mass. `hull` is the node
// whose mesh bounds the piece, whose convex hull collides; without one the piece has no collider of its own.
[[nodiscard]] nlohmann::ordered_json rigid_body_json(const MassProperties& mass, double density,
                                                     std::optional<size_t> hull);
// Of a node below it that is one of several colliders.
[[nodiscard]] nlohmann::ordered_json collider_json(size_t hull);

} // namespace brittle::fracture

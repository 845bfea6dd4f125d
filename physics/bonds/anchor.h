// Anchors: regions of space in which the world holds breakable objects, and the pieces that they hold.
//
// A region holds each piece whose surface reaches into it: a foot in the ground, a rim in a frame, a painted spot.
// Coordinates are those of the fragments, metres. Pure functions; thread-safe.
//
//     desc.anchored = anchor_to(fragments, std::array{AnchorRegion(Ball{{0.0, 1.0, 0.0}, 0.1})});
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <variant>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"
#include "physics/world/world.h"

namespace brittle::physics {

struct Ball {
    glm::dvec3 centre{0.0};
    double radius = 0.0; // m
};

// The points with dot(normal, point) <= distance.
struct HalfSpace {
    glm::dvec3 normal{0.0, 1.0, 0.0};
    double distance = 0.0; // m
};

using AnchorRegion = std::variant<fracture::Box, Ball, HalfSpace>;

// Returns whether a triangle intersects a region; touching counts. Boxes are tested by separating axes (box normals,
// triangle normal, cross products of edges), balls by the triangle's nearest point to the centre.
[[nodiscard]] bool reaches(const AnchorRegion& region, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);
// Returns whether any triangle intersects any region.
[[nodiscard]] bool reaches(std::span<const AnchorRegion> regions, std::span<const glm::dvec3> positions,
                           std::span<const fracture::Triangle> triangles);

// The following functions return pieces for StructureDesc::anchored, ascending.
//
// Pieces whose surface intersects a region.
[[nodiscard]] std::vector<uint32_t> anchor_to(const fracture::Fragments& fragments,
                                              std::span<const AnchorRegion> regions);
// Pieces with a vertex at most `height` (m) above the plane y = ground (m, world) once placed.
[[nodiscard]] std::vector<uint32_t> anchor_to_ground(const fracture::Fragments& fragments, const Pose& placement = {},
                                                     float ground = 0.0f, float height = 0.01f);
// Pieces for which the predicate returns true.
[[nodiscard]] std::vector<uint32_t> anchor_where(const fracture::Fragments& fragments,
                                                 const std::function<bool(const fracture::Piece&)>& held);

} // namespace brittle::physics

// Where the world holds what is breakable: regions of space, and which pieces they hold.
//
// A piece is held where its surface reaches into a region: a foot in the ground, a rim in a frame, a spot that was
// painted. Coordinates are those of the fragments, metres. Pure functions.
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

using AnchorRegion = std::variant<fracture::Box, Ball>;

// Whether a triangle reaches into a region; touching counts. Boxes by separating axes (their sides, the normal, cross
// products of edges), balls by the triangle's nearest point.
[[nodiscard]] bool reaches(const AnchorRegion& region, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);
// Whether one of the triangles reaches into one of the regions.
[[nodiscard]] bool reaches(std::span<const AnchorRegion> regions, std::span<const glm::dvec3> positions,
                           std::span<const fracture::Triangle> triangles);

// For StructureDesc::anchored, ascending: the pieces that reach into one of the regions,
[[nodiscard]] std::vector<uint32_t> anchor_to(const fracture::Fragments& fragments,
                                              std::span<const AnchorRegion> regions);
// those that come within height (m) of the ground or reach below it,
[[nodiscard]] std::vector<uint32_t> anchor_to_ground(const fracture::Fragments& fragments, const Pose& placement = {},
                                                     float ground = 0.0f, float height = 0.01f);
// and those for which the predicate holds.
[[nodiscard]] std::vector<uint32_t> anchor_where(const fracture::Fragments& fragments,
                                                 const std::function<bool(const fracture::Piece&)>& held);

} // namespace brittle::physics

// Tangents for normal maps, by MikkTSpace, which normal maps are baked for and which glTF prescribes for meshes without
// tangents. Computed for the source's corners, so that pieces can interpolate them and shade like the uncut mesh.
//
// M. S. Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008, and its reference implementation with the default
// angular threshold of 180 degrees: corners with equal position, normal and texture coordinates in triangles that are
// connected around the vertex by edges with equal corners, and that are mapped with equal handedness, share a tangent.
// It is the mean of the triangles' tangents in the plane of the normal, weighted by the angles at the vertex.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "fracture/io/model.h"

namespace brittle::fracture {

// Returns whether a material of the model is shaded by tangents and the model has the texture coordinates for them.
[[nodiscard]] bool uses_tangents(const Model& model, uint32_t material);

// Returns a tangent for each corner, as glTF has it: a unit vector perpendicular to the normal along u, and in w the sign
// of the bitangent, w * cross(normal, tangent), along which the image rises. Zero in triangles whose material does not
// use tangents; an empty list if no material does.
[[nodiscard]] std::vector<glm::vec4> corner_tangents(const Model& model);

// Returns a unit vector perpendicular to the unit normal, as near to `tangent` as possible.
[[nodiscard]] glm::vec3 perpendicular(const glm::vec3& normal, const glm::vec3& tangent);

} // namespace brittle::fracture

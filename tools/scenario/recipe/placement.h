// Where an object of a scene stands.
#pragma once

#include <optional>

#include <glm/ext/quaternion_double.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::tools {

// A mesh point p comes to translation + R * (H * (scale * p)), m, with p in metres. R is the rotation about X, then Y,
// then Z; H is the shear: (x + xy * y + xz * z, y + yz * z, z).
struct ObjectPlacement {
    glm::dvec3 translation{0.0}; // m
    glm::dvec3 rotation{0.0};    // degrees
    glm::dvec3 shear{0.0};       // xy, xz, yz
    glm::dvec3 scale{1.0};       // a negative product mirrors

    friend bool operator==(const ObjectPlacement&, const ObjectPlacement&) = default;
};

// Limits of the absolute value of a scale.
inline constexpr double min_scale = 1e-9, max_scale = 1e9;

[[nodiscard]] glm::dquat rotation_of(const ObjectPlacement& placement);
// R * H * scale.
[[nodiscard]] glm::dmat3 linear_part(const ObjectPlacement& placement);

// Scales by a factor, and then by scale and shear of the placement. A mirrored mesh is turned, so that it stays outside
// out.
void deform(fracture::TriangleMesh& mesh, double factor, const ObjectPlacement& placement);

// Shear, and differences of scale, below this share are rounding of files in single precision.
inline constexpr double placement_rounding = 1e-6;

// The placement that equals an affine transform, by the QR decomposition of its linear part, to twelve digits. Shear that is
// rounding becomes 0. Nothing where the transform flattens the mesh, or a scale is beyond the limits.
[[nodiscard]] std::optional<ObjectPlacement> placement_of(const glm::dmat4& transform);

} // namespace brittle::tools

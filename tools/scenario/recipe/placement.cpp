#include "tools/scenario/recipe/placement.h"

#include <charconv>
#include <cmath>
#include <iterator>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/trigonometric.hpp>

namespace brittle::tools {

namespace {

// Degrees about X, then Y, then Z: Ken Shoemake's extraction. Where Y is at 90 degrees, X and Z turn about one axis; there
// Z is 0.
glm::dvec3 angles_of(const glm::dmat3& rotation) {
    constexpr double rounding = 1e-12; // rad; smaller angles than that between Y and 90 degrees are 0
    const bool is_upright = std::hypot(rotation[0][0], rotation[0][1]) < rounding;
    const double z = is_upright ? 0.0 : std::atan2(rotation[0][1], rotation[0][0]);
    const double y = std::atan2(-rotation[0][2], std::hypot(rotation[1][2], rotation[2][2]));
    const double sine = std::sin(z), cosine = std::cos(z);
    const double x =
        std::atan2(sine * rotation[2][0] - cosine * rotation[2][1], cosine * rotation[1][1] - sine * rotation[1][0]);
    return glm::degrees(glm::dvec3(x, y, z));
}

// Rounding of the decomposition is removed, so that angles and scales are those that a person would write: angles are
// multiples of 1e-10 degrees, and scales have twelve significant digits.
glm::dvec3 rounded_angles(const glm::dvec3& degrees) {
    constexpr double steps = 1e10;                    // per degree
    return glm::round(degrees * steps) / steps + 0.0; // no -0
}

double rounded_scale(double scale) {
    char text[32];
    const auto [end, failed] = std::to_chars(text, std::end(text), scale, std::chars_format::general, 12);
    std::from_chars(text, end, scale);
    return scale;
}

glm::dvec3 sheared(const glm::dvec3& shear, const glm::dvec3& p) {
    return {p.x + shear.x * p.y + shear.y * p.z, p.y + shear.z * p.z, p.z};
}

} // namespace

glm::dquat rotation_of(const ObjectPlacement& placement) {
    const glm::dvec3 angle = glm::radians(placement.rotation);
    return glm::angleAxis(angle.z, glm::dvec3(0.0, 0.0, 1.0)) * glm::angleAxis(angle.y, glm::dvec3(0.0, 1.0, 0.0))
           * glm::angleAxis(angle.x, glm::dvec3(1.0, 0.0, 0.0));
}

glm::dmat3 linear_part(const ObjectPlacement& placement) {
    const glm::dmat3 rotation = glm::mat3_cast(rotation_of(placement));
    glm::dmat3 linear;
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 edge(0.0);
        edge[axis] = placement.scale[axis];
        linear[axis] = rotation * sheared(placement.shear, edge);
    }
    return linear;
}

void deform(fracture::TriangleMesh& mesh, double factor, const ObjectPlacement& placement) {
    const glm::dvec3 scale = factor * placement.scale;
    for (glm::dvec3& p : mesh.positions) p *= scale;
    if (placement.shear != glm::dvec3(0.0))
        for (glm::dvec3& p : mesh.positions) p = sheared(placement.shear, p);
    if (scale.x * scale.y * scale.z > 0.0) return;
    for (fracture::Triangle& t : mesh.triangles) std::swap(t.y, t.z);
}

std::optional<ObjectPlacement> placement_of(const glm::dmat4& transform) {
    const glm::dmat3 linear(transform);
    glm::dmat3 rotation, upper(0.0); // linear = rotation * upper, by Gram and Schmidt
    for (int column = 0; column < 3; ++column) {
        glm::dvec3 rest = linear[column];
        for (int k = 0; k < column; ++k) {
            upper[column][k] = glm::dot(rotation[k], rest);
            rest -= upper[column][k] * rotation[k];
        }
        upper[column][column] = glm::length(rest);
        if (!(upper[column][column] >= min_scale && upper[column][column] <= max_scale)) return std::nullopt;
        rotation[column] = rest / upper[column][column];
    }
    if (glm::determinant(rotation) < 0.0) {
        rotation[2] = -rotation[2];
        upper[2][2] = -upper[2][2];
    }
    ObjectPlacement placement{.translation = glm::dvec3(transform[3]),
                              .rotation = rounded_angles(angles_of(rotation)),
                              .shear = glm::dvec3(upper[1][0], upper[2][0], upper[2][1])
                                       / glm::dvec3(upper[1][1], upper[2][2], upper[2][2]),
                              .scale = {upper[0][0], upper[1][1], upper[2][2]}};
    for (int k = 0; k < 3; ++k) {
        placement.scale[k] = rounded_scale(placement.scale[k]);
        if (std::abs(placement.shear[k]) < placement_rounding) placement.shear[k] = 0.0;
    }
    return placement;
}

} // namespace brittle::tools

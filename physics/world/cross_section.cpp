#include "physics/world/cross_section.h"

#include <cmath>

#include <glm/geometric.hpp>

namespace brittle::physics {

namespace {

// One of each pair of opposite directions to a cube's faces, edges and corners; not normalised.
constexpr std::array<std::array<int, 3>, 13> axes_of_cube{{
    {1, 0, 0},
    {0, 1, 0},
    {0, 0, 1}, //
    {1, 1, 0},
    {1, -1, 0},
    {1, 0, 1},
    {1, 0, -1},
    {0, 1, 1},
    {0, 1, -1}, //
    {1, 1, 1},
    {1, 1, -1},
    {1, -1, 1},
    {-1, 1, 1},
}};

} // namespace

float CrossSection::along(const glm::vec3& direction) const {
    float sum = 0.0f;
    for (const glm::vec3& side : sides) sum += std::abs(glm::dot(side, direction));
    return sum;
}

float CrossSection::mean() const {
    float sum = 0.0f;
    for (const glm::vec3& side : sides) sum += glm::length(side);
    return 0.5f * sum; // the mean of |a . u| over all u is |a| / 2
}

CrossSection section_of_faces(std::span<const glm::dvec3> areas) {
    CrossSection section;
    section.sides.reserve(areas.size());
    for (const glm::dvec3& area : areas) section.sides.push_back(glm::vec3(0.5 * area));
    return section;
}

CrossSection section_of_box(const glm::dvec3& half, const std::array<glm::dvec3, 3>& axes) {
    return {{glm::vec3(4.0 * half.y * half.z * axes[0]), glm::vec3(4.0 * half.z * half.x * axes[1]),
             glm::vec3(4.0 * half.x * half.y * axes[2])}};
}

CrossSection reduced(std::span<const glm::vec3> sides) {
    std::array<glm::dvec3, axes_of_cube.size()> axes, sums{};
    for (size_t i = 0; i < axes.size(); ++i)
        axes[i] = glm::normalize(glm::dvec3(axes_of_cube[i][0], axes_of_cube[i][1], axes_of_cube[i][2]));
    double given = 0.0, kept = 0.0;
    for (const glm::vec3& one : sides) {
        const glm::dvec3 side(one);
        size_t nearest = 0;
        for (size_t i = 1; i < axes.size(); ++i)
            if (std::abs(glm::dot(side, axes[i])) > std::abs(glm::dot(side, axes[nearest]))) nearest = i;
        sums[nearest] += glm::dot(side, axes[nearest]) < 0.0 ? -side : side;
        given += glm::length(side);
    }
    for (const glm::dvec3& sum : sums) kept += glm::length(sum);
    CrossSection section;
    for (const glm::dvec3& sum : sums)
        if (sum != glm::dvec3(0.0)) section.sides.push_back(glm::vec3(sum * (given / kept)));
    return section;
}

} // namespace brittle::physics

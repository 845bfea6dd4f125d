#include "physics/solver/air_drag.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "physics/solver/float4.h"
#include "physics/solver/rotate4.h"
#include "physics/solver/transform.h"

namespace brittle::physics {

namespace {

// Below this, 1 + x rounds to 1 and drag changes no bit.
constexpr float nothing = 5e-8f;

constexpr size_t group_size = 12; // floats in a group of four sides

} // namespace

AirDrag::AirDrag(std::span<const glm::vec3> sides, const glm::quat& turn, float mass, const glm::dvec3& moments) {
    lanes_.resize((sides.size() + 3) / 4 * group_size);
    const Float4 of_area = Float4::all(0.5f * drag_coefficient / mass);
    const auto side = [&](size_t i) { return i < sides.size() ? sides[i] : glm::vec3(0.0f); };
    std::array<double, 3> across{}; // the mean of |side . u| over unit vectors u across an axis
    // Square roots take most of the time, hence four sides at once. Sums are in the order of the sides.
    for (size_t i = 0; i < sides.size(); i += 4) {
        Vector4 own = rotated(turn, Vector4::of(side(i), side(i + 1), side(i + 2), side(i + 3)));
        own = {of_area * own.x, of_area * own.y, of_area * own.z};
        float* const group = lanes_.data() + i / 4 * group_size;
        own.x.store(group), own.y.store(group + 4), own.z.store(group + 8);
        std::array<float, 4> length;
        sqrt(own.x * own.x + own.y * own.y + own.z * own.z).store(length.data());
        std::array<double, group_size> square, met;
        for (size_t k = 0; k < group_size; ++k)
            square[k] = static_cast<double>(group[k]) * static_cast<double>(group[k]);
        for (size_t k = 0; k < group_size; ++k) // the component across the axis, from the other two
            met[k] = 2.0 / std::numbers::pi * std::sqrt(square[(k + 4) % group_size] + square[(k + 8) % group_size]);
        for (size_t lane = 0; lane < 4; ++lane) {
            most_ += length[lane];
            for (size_t axis = 0; axis < 3; ++axis) across[axis] += met[axis * 4 + lane];
        }
    }
    for (int axis = 0; axis < 3; ++axis) {
        const double radius = std::sqrt(moments[axis] / static_cast<double>(mass));
        spin_[axis] = static_cast<float>(across[static_cast<size_t>(axis)] * radius);
        radius_ = std::max(radius_, static_cast<float>(radius));
    }
}

void AirDrag::brake(Velocity& of, const glm::mat3& basis, float density, float seconds, float unfelt) const {
    const float air = density * seconds;
    const glm::vec3 velocity = of.linear;
    const float speed = glm::length(velocity), most = air * most_ * speed;
    if (most > nothing && most * speed > unfelt) {
        const glm::vec3 along = velocity * basis; // in principal axes
        const Float4 x = Float4::all(along.x), y = Float4::all(along.y), z = Float4::all(along.z);
        Float4 sum = Float4::all(0.0f);
        for (const float* group = lanes_.data(); group != lanes_.data() + lanes_.size(); group += group_size) {
            const Float4 met = Float4::load(group) * x + Float4::load(group + 4) * y + Float4::load(group + 8) * z;
            sum = sum + max(met, Float4::all(0.0f) - met);
        }
        float met[4];
        sum.store(met);
        of.linear *= 1.0f / (1.0f + air * ((met[0] + met[1]) + (met[2] + met[3])));
    }
    const float spin = glm::length(of.angular);
    const glm::vec3 lost = spin_ * (air * spin);
    const float max_lost = std::max({lost.x, lost.y, lost.z});
    if (max_lost > nothing && max_lost * spin * radius_ > unfelt)
        of.angular = basis * ((of.angular * basis) / (1.0f + lost));
}

} // namespace brittle::physics

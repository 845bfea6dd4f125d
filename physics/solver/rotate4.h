// Four vectors rotated at once, each as glm rotates it alone, bit for bit.
#pragma once

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "physics/solver/float4.h"

namespace brittle::physics {

// Four vectors, component by component.
struct Vector4 {
    Float4 x, y, z;

    static Vector4 of(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d) {
        return {Float4::of(a.x, b.x, c.x, d.x), Float4::of(a.y, b.y, c.y, d.y), Float4::of(a.z, b.z, c.z, d.z)};
    }
};

// v + 2 (w q x v + q x (q x v)), in glm's order of operations.
[[nodiscard]] inline Vector4 rotated(const glm::quat& q, const Vector4& v) {
    const Float4 x = Float4::all(q.x), y = Float4::all(q.y), z = Float4::all(q.z);
    const auto crossed = [&](const Vector4& a) -> Vector4 {
        return {y * a.z - a.y * z, z * a.x - a.z * x, x * a.y - a.x * y};
    };
    const Vector4 once = crossed(v), twice = crossed(once);
    const Float4 w = Float4::all(q.w), two = Float4::all(2.0f);
    return {v.x + (once.x * w + twice.x) * two, v.y + (once.y * w + twice.y) * two, v.z + (once.z * w + twice.z) * two};
}

} // namespace brittle::physics

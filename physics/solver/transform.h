// Rigid transforms in single precision, as the solver uses them.
//
// A rotation is a matrix, because the solver rotates many points for each change of orientation. Column vectors,
// right-handed. Every function is a fixed sequence of IEEE operations, so results are equal with every compiler.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace brittle::physics {

// Means no bound; its square is a finite float.
inline constexpr float unbounded = 1e18f;

[[nodiscard]] inline float length_squared(const glm::vec3& v) {
    return glm::dot(v, v);
}

// A row of a matrix: the direction, in local axes, of a world axis.
[[nodiscard]] inline glm::vec3 row(const glm::mat3& m, int index) {
    return {m[0][index], m[1][index], m[2][index]};
}

// world = basis * local + origin
struct Transform {
    glm::mat3 basis{1.0f}; // a rotation
    glm::vec3 origin{0.0f};

    friend bool operator==(const Transform&, const Transform&) = default;

    [[nodiscard]] glm::vec3 operator*(const glm::vec3& local) const { return basis * local + origin; }
    [[nodiscard]] Transform operator*(const Transform& local) const {
        return {basis * local.basis, basis * local.origin + origin};
    }
    [[nodiscard]] glm::vec3 to_local(const glm::vec3& world) const { return (world - origin) * basis; }
    // The other transform in the coordinates of this one: inverse(*this) * other.
    [[nodiscard]] Transform to_local(const Transform& other) const {
        return {glm::transpose(basis) * other.basis, (other.origin - origin) * basis};
    }
    [[nodiscard]] Transform inverse() const {
        const glm::mat3 back = glm::transpose(basis);
        return {back, back * -origin};
    }
};

// The matrix of a rotation; the quaternion may have any length except zero.
[[nodiscard]] inline glm::mat3 matrix_of(const glm::quat& q) {
    const float s = 2.0f / (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    const float xs = q.x * s, ys = q.y * s, zs = q.z * s;
    const float wx = q.w * xs, wy = q.w * ys, wz = q.w * zs;
    const float xx = q.x * xs, xy = q.x * ys, xz = q.x * zs;
    const float yy = q.y * ys, yz = q.y * zs, zz = q.z * zs;
    return {{1.0f - (yy + zz), xy + wz, xz - wy},
            {xy - wz, 1.0f - (xx + zz), yz + wx},
            {xz + wy, yz - wx, 1.0f - (xx + yy)}};
}

// The unit quaternion of a rotation matrix, by its largest component (Shepperd, "Quaternion from rotation matrix",
// 1978).
[[nodiscard]] inline glm::quat rotation_of(const glm::mat3& m) {
    const float trace = m[0][0] + m[1][1] + m[2][2];
    if (trace > 0.0f) {
        const float root = std::sqrt(trace + 1.0f), s = 0.5f / root;
        return {root * 0.5f, (m[1][2] - m[2][1]) * s, (m[2][0] - m[0][2]) * s, (m[0][1] - m[1][0]) * s};
    }
    const int i = m[0][0] < m[1][1] ? (m[1][1] < m[2][2] ? 2 : 1) : (m[0][0] < m[2][2] ? 2 : 0);
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const float root = std::sqrt(m[i][i] - m[j][j] - m[k][k] + 1.0f), s = 0.5f / root;
    glm::vec3 axis;
    axis[i] = root * 0.5f;
    axis[j] = (m[i][j] + m[j][i]) * s;
    axis[k] = (m[i][k] + m[k][i]) * s;
    return {(m[j][k] - m[k][j]) * s, axis.x, axis.y, axis.z};
}

// Two unit vectors that make a right-handed frame with a unit normal: normal x first = second.
struct Tangents {
    glm::vec3 first, second;
};
[[nodiscard]] inline Tangents tangents_of(const glm::vec3& n) {
    if (std::abs(n.z) > 0.7071067811865475244f) {
        const float a = n.y * n.y + n.z * n.z, k = 1.0f / std::sqrt(a);
        const glm::vec3 first(0.0f, -n.z * k, n.y * k);
        return {first, {a * k, -n.x * first.z, n.x * first.y}};
    }
    const float a = n.x * n.x + n.y * n.y, k = 1.0f / std::sqrt(a);
    const glm::vec3 first(-n.y * k, n.x * k, 0.0f);
    return {first, {-n.z * first.y, n.z * first.x, a * k}};
}

// Axis-aligned bounds.
struct Bounds {
    glm::vec3 low{0.0f}, high{0.0f};

    [[nodiscard]] bool overlaps(const Bounds& other) const {
        return low.x <= other.high.x && high.x >= other.low.x && low.y <= other.high.y && high.y >= other.low.y
               && low.z <= other.high.z && high.z >= other.low.z;
    }
    // Extended to contain its content along a translation, and by a distance on all sides.
    [[nodiscard]] Bounds grown(const glm::vec3& translation, float by) const {
        Bounds box = *this;
        for (int axis = 0; axis < 3; ++axis) {
            box.low[axis] += std::min(translation[axis], 0.0f) - by;
            box.high[axis] += std::max(translation[axis], 0.0f) + by;
        }
        return box;
    }
    // The bounds of this box in a frame.
    [[nodiscard]] Bounds in(const Transform& frame) const {
        const glm::vec3 half = 0.5f * (high - low), middle = frame * (0.5f * (high + low));
        glm::vec3 extent;
        for (int axis = 0; axis < 3; ++axis) extent[axis] = glm::dot(half, glm::abs(row(frame.basis, axis)));
        return {middle - extent, middle + extent};
    }
    friend Bounds both(const Bounds& a, const Bounds& b) { return {glm::min(a.low, b.low), glm::max(a.high, b.high)}; }
};

} // namespace brittle::physics

// Between our vectors in metres and Bullet's in its own unit of length.
//
// physics/bullet/ is the only place where headers know Bullet; the headers of physics/ itself never include
// one of these.
#pragma once

#include <array>

#include <btBulletDynamicsCommon.h>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

namespace brittle::physics {

// Bullet counts in decimetres here. Its tolerances are made for bodies of metres (its GJK takes points of
// less than a centimetre apart for one): in metres, pieces of that size find wrong contacts and creep apart.
inline constexpr float bullet_units = 10.0f; // per metre

// Axes, angular velocities.
inline btVector3 to_bullet(const glm::vec3& v) {
    return {v.x, v.y, v.z};
}
// Positions, velocities, accelerations, impulses: whatever has one metre in it.
inline btVector3 metres_to_bullet(const glm::vec3& v) {
    return to_bullet(v * bullet_units);
}
inline btQuaternion to_bullet(const glm::quat& q) {
    return {q.x, q.y, q.z, q.w};
}
inline glm::vec3 to_glm(const btVector3& v) {
    return {v.x(), v.y(), v.z()};
}
inline glm::vec3 metres_from_bullet(const btVector3& v) {
    return to_glm(v) / bullet_units;
}
inline glm::quat to_glm(const btQuaternion& q) {
    return {q.w(), q.x(), q.y(), q.z()};
}
// Three floats where a btVector3's fourth would be in the way.
inline std::array<float, 3> packed(const btVector3& v) {
    return {v.x(), v.y(), v.z()};
}
inline btVector3 unpacked(const std::array<float, 3>& v) {
    return {v[0], v[1], v[2]};
}

} // namespace brittle::physics

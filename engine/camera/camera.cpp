#include "engine/camera/camera.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace brittle::engine {

namespace {

bool finite(glm::vec3 v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Returns the unit vector from the target to the eye.
glm::vec3 orbit_direction(float azimuth, float elevation) {
    return {std::sin(azimuth) * std::cos(elevation), std::sin(elevation), std::cos(azimuth) * std::cos(elevation)};
}

constexpr float min_radius = 1e-4f; // metres; makes a scene of one point drawable

} // namespace

Bounds join(const Bounds& a, const Bounds& b) {
    return {glm::min(a.min, b.min), glm::max(a.max, b.max)};
}

CameraMatrices matrices(const Camera& camera, float aspect, const Bounds& bounds) {
    glm::vec3 eye = finite(camera.eye) ? camera.eye : Camera{}.eye;
    const glm::vec3 to_target = (finite(camera.target) ? camera.target : glm::vec3(0.0f)) - eye;
    const float reach = glm::length(to_target);
    const glm::vec3 forward = reach > 0.0f ? to_target / reach : glm::vec3(0.0f, 0.0f, -1.0f);
    const glm::vec3 up = std::abs(forward.y) < 0.9999f ? glm::vec3(0.0f, 1.0f, 0.0f) : glm::vec3(0.0f, 0.0f, -1.0f);

    CameraMatrices result;
    result.view = glm::lookAt(eye, eye + forward, up);

    // The far plane also includes the ground up to the distance at which it has faded out, a few times the distance to
    // the target. The near plane stays near the eye even if the scene is far away, for the ground in front of the
    // scene; D32 is precise enough for that.
    const float radius = std::max(glm::length(bounds.size()) * 0.5f, min_radius);
    const float distance = glm::length(bounds.centre() - eye);
    result.far_plane = std::max(distance + radius, 8.0f * reach) * 1.01f;
    result.near_plane = std::max((distance - radius) * 0.1f, result.far_plane * 2e-4f);

    const float fov = std::isfinite(camera.vertical_fov) ? std::clamp(camera.vertical_fov, 0.01f, 3.0f) : 0.6f;
    result.projection = glm::perspectiveRH_ZO(fov, std::max(aspect, 1e-3f), result.near_plane, result.far_plane);
    result.projection[1][1] *= -1.0f; // Vulkan's Y points down
    if (std::isfinite(camera.shift.x) && std::isfinite(camera.shift.y)) {
        // The third column is multiplied by z, and the division by w = -z leaves the shift with its sign changed.
        result.projection[2][0] -= camera.shift.x;
        result.projection[2][1] -= camera.shift.y;
    }
    return result;
}

Camera look_at_bounds(const Bounds& bounds, float azimuth, float elevation, float aspect, float vertical_fov,
                      float margin) {
    const glm::vec3 back = orbit_direction(azimuth, elevation);
    const glm::vec3 right(std::cos(azimuth), 0.0f, -std::sin(azimuth));
    const glm::vec3 up = glm::cross(back, right);
    const float tangent_y = std::tan(0.5f * vertical_fov);
    const float tangent_x = tangent_y * aspect;
    const glm::vec3 half = glm::max(bounds.size() * 0.5f, glm::vec3(min_radius));
    float distance = 0.0f;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 p =
            half * glm::vec3(corner & 1 ? 1.0f : -1.0f, corner & 2 ? 1.0f : -1.0f, corner & 4 ? 1.0f : -1.0f);
        const float sideways =
            std::max(std::abs(glm::dot(p, right)) / tangent_x, std::abs(glm::dot(p, up)) / tangent_y);
        distance = std::max(distance, glm::dot(p, back) + margin * sideways);
    }
    return {bounds.centre() + back * distance, bounds.centre(), vertical_fov};
}

OrbitCamera OrbitCamera::around(const Bounds& bounds, float aspect) {
    OrbitCamera orbit;
    const Camera camera = look_at_bounds(bounds, orbit.azimuth, orbit.elevation, aspect, orbit.vertical_fov);
    orbit.target = camera.target;
    orbit.distance = glm::length(camera.eye - camera.target);
    return orbit;
}

void OrbitCamera::rotate(glm::vec2 pixels) {
    constexpr float radians_per_pixel = 0.006f;
    constexpr float pole = 1.5f;
    azimuth -= pixels.x * radians_per_pixel;
    elevation = std::clamp(elevation + pixels.y * radians_per_pixel, -pole, pole);
}

void OrbitCamera::pan(glm::vec2 pixels) {
    const glm::vec3 back = orbit_direction(azimuth, elevation);
    const glm::vec3 right(std::cos(azimuth), 0.0f, -std::sin(azimuth));
    const float metres_per_pixel = distance * 0.0015f;
    target += (-pixels.x * right + pixels.y * glm::cross(back, right)) * metres_per_pixel;
}

void OrbitCamera::zoom(float notches) {
    distance = std::max(distance * std::pow(0.9f, notches), min_radius);
}

Camera OrbitCamera::camera() const {
    return {target + orbit_direction(azimuth, elevation) * distance, target, vertical_fov, shift};
}

} // namespace brittle::engine

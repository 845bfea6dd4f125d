#include "tools/brittle/studio/navigation.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "tools/brittle/view.h"

namespace brittle::tools {

namespace {

constexpr float margin = 1.05f;     // of look_at_bounds(), as picture_camera() has it
constexpr float fly_rate = 1.0f;    // distances to the target a second
constexpr float zoom_factor = 0.9f; // of the distance, a notch; as OrbitCamera::zoom()

float distance_of(const engine::Bounds& bounds, float azimuth, float elevation, float aspect, float fov) {
    const engine::Camera camera = engine::look_at_bounds(bounds, azimuth, elevation, aspect, fov, margin);
    return glm::length(camera.eye - camera.target);
}

} // namespace

void Navigation::look_as(const PictureOptions& picture, const engine::Bounds& home, float aspect) {
    const engine::Bounds bounds = stage_view(home);
    orbit_.azimuth = glm::radians(picture.azimuth);
    orbit_.elevation = glm::radians(picture.elevation);
    orbit_.target = bounds.centre();
    orbit_.distance = picture.distance * distance_of(bounds, orbit_.azimuth, orbit_.elevation, aspect, orbit_.vertical_fov);
}

void Navigation::tell(PictureOptions& picture, const engine::Bounds& home, float aspect) const {
    const float around = distance_of(stage_view(home), orbit_.azimuth, orbit_.elevation, aspect, orbit_.vertical_fov);
    picture.azimuth = std::remainder(glm::degrees(orbit_.azimuth), 360.0f);
    picture.elevation = std::clamp(glm::degrees(orbit_.elevation), -89.0f, 89.0f);
    picture.distance = std::clamp(orbit_.distance / around, 0.1f, 10.0f);
}

void Navigation::frame(const engine::Bounds& bounds, float aspect) {
    orbit_.target = bounds.centre();
    orbit_.distance = distance_of(bounds, orbit_.azimuth, orbit_.elevation, aspect, orbit_.vertical_fov);
}

void Navigation::zoom(float notches, const Viewport& view, glm::vec2 cursor) {
    if (notches == 0.0f) return;
    const Ray ray = view.ray(cursor);
    const glm::vec3 forward = view.forward(), direction(ray.direction);
    const float along = glm::dot(direction, forward);
    if (along > 0.1f) {
        const glm::vec3 under = view.camera().eye + orbit_.distance / along * direction; // in the plane of the target
        orbit_.target = under + (orbit_.target - under) * std::pow(zoom_factor, notches);
    }
    orbit_.zoom(notches);
}

void Navigation::fly(const glm::vec3& forward_right_up, double seconds) {
    const engine::Camera now = orbit_.camera();
    const glm::vec3 forward = glm::normalize(now.target - now.eye);
    const glm::vec3 right = glm::normalize(glm::cross(forward, glm::vec3(0.0f, 1.0f, 0.0f)));
    const glm::vec3 way = forward_right_up.x * forward + forward_right_up.y * right + glm::vec3(0.0f, forward_right_up.z, 0.0f);
    orbit_.target += way * (fly_rate * orbit_.distance * static_cast<float>(seconds));
}

engine::Camera Navigation::camera(glm::vec2 shift) const {
    engine::OrbitCamera orbit = orbit_;
    orbit.shift = shift;
    return orbit.camera();
}

} // namespace brittle::tools

#include "tools/brittle/studio/navigation.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace brittle::tools {

namespace {

constexpr float margin = 1.05f;     // margin for look_at_bounds()
constexpr int halvings = 30;        // bisection steps on an interval of length 10; more exceed the precision of a float
constexpr float fly_rate = 1.0f;    // speed per second, as a multiple of the distance to the target
constexpr float zoom_factor = 0.9f; // factor on the distance per notch, as in OrbitCamera::zoom()

} // namespace

void Navigation::look_as(const PictureOptions& picture, const engine::Bounds& home, float aspect) {
    const engine::Camera camera = picture_camera(picture, home, aspect);
    orbit_.azimuth = glm::radians(picture.azimuth);
    orbit_.elevation = glm::radians(picture.elevation);
    orbit_.target = camera.target;
    orbit_.distance = glm::distance(camera.eye, camera.target);
    orbit_.vertical_fov = camera.vertical_fov;
}

void Navigation::tell(PictureOptions& picture, const engine::Bounds& home, float aspect) const {
    picture.azimuth = std::remainder(glm::degrees(orbit_.azimuth), 360.0f);
    picture.elevation = std::clamp(glm::degrees(orbit_.elevation), -89.0f, 89.0f);
    // The distance of the eye grows with the picture's distance, though not in proportion, so it is found by bisection.
    float low = 0.1f, high = 10.0f;
    for (int k = 0; k < halvings; ++k) {
        picture.distance = 0.5f * (low + high);
        const engine::Camera camera = picture_camera(picture, home, aspect);
        (glm::distance(camera.eye, camera.target) < orbit_.distance ? low : high) = picture.distance;
    }
}

void Navigation::frame(const engine::Bounds& bounds, float aspect) {
    orbit_.target = bounds.centre();
    const engine::Camera camera =
        engine::look_at_bounds(bounds, orbit_.azimuth, orbit_.elevation, aspect, orbit_.vertical_fov, margin);
    orbit_.distance = glm::distance(camera.eye, camera.target);
}

void Navigation::zoom(float notches, const Viewport& view, glm::vec2 cursor) {
    if (notches == 0.0f) return;
    const Ray ray = view.ray(cursor);
    const glm::vec3 forward = view.forward(), direction(ray.direction);
    const float along = glm::dot(direction, forward);
    if (along > 0.1f) {
        // The point under the cursor in the plane of the target.
        const glm::vec3 under = view.camera().eye + orbit_.distance / along * direction;
        orbit_.target = under + (orbit_.target - under) * std::pow(zoom_factor, notches);
    }
    orbit_.zoom(notches);
}

void Navigation::fly(const glm::vec3& forward_right_up, double seconds) {
    const engine::Camera now = orbit_.camera();
    const glm::vec3 forward = glm::normalize(now.target - now.eye);
    const glm::vec3 right = glm::normalize(glm::cross(forward, glm::vec3(0.0f, 1.0f, 0.0f)));
    const glm::vec3 way =
        forward_right_up.x * forward + forward_right_up.y * right + glm::vec3(0.0f, forward_right_up.z, 0.0f);
    orbit_.target += way * (fly_rate * orbit_.distance * static_cast<float>(seconds));
}

engine::Camera Navigation::camera(glm::vec2 shift) const {
    engine::OrbitCamera orbit = orbit_;
    orbit.shift = shift;
    return orbit.camera();
}

} // namespace brittle::tools

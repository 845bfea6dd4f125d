#include "tools/brittle/studio/viewport.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace brittle::tools {

Viewport::Viewport(const engine::Camera& camera, glm::vec2 window, glm::vec2 free_min, glm::vec2 free_max)
    : camera_(camera), window_(glm::max(window, glm::vec2(1.0f))), free_min_(free_min), free_max_(free_max) {
    // Depth is irrelevant here, so any bounds will do.
    const engine::CameraMatrices m = engine::matrices(camera, window_.x / window_.y, {});
    clip_from_world_ = m.projection * m.view;
    world_from_clip_ = glm::inverse(clip_from_world_);
}

Ray Viewport::ray(glm::vec2 pixel) const {
    const glm::vec2 ndc = 2.0f * pixel / window_ - 1.0f;
    const glm::vec4 far = world_from_clip_ * glm::vec4(ndc, 0.5f, 1.0f);
    const glm::dvec3 eye(camera_.eye);
    return {eye, glm::normalize(glm::dvec3(far) / static_cast<double>(far.w) - eye)};
}

std::optional<glm::vec2> Viewport::pixel(const glm::vec3& point) const {
    const glm::vec4 clip = clip_from_world_ * glm::vec4(point, 1.0f);
    if (clip.w <= 0.0f) return std::nullopt;
    return (glm::vec2(clip) / clip.w * 0.5f + 0.5f) * window_;
}

float Viewport::pixels_a_metre(const glm::vec3& at) const {
    const float distance = std::max(glm::dot(at - camera_.eye, forward()), 1e-3f);
    return 0.5f * window_.y / (std::tan(0.5f * camera_.vertical_fov) * distance);
}

bool Viewport::is_free(glm::vec2 pixel) const {
    return pixel.x >= free_min_.x && pixel.y >= free_min_.y && pixel.x < free_max_.x && pixel.y < free_max_.y;
}

engine::Camera Viewport::free_camera() const {
    engine::Camera camera = camera_;
    const float share = std::max(free_max_.y - free_min_.y, 1.0f) / window_.y;
    camera.vertical_fov = 2.0f * std::atan(share * std::tan(0.5f * camera.vertical_fov));
    camera.shift = glm::vec2(0.0f);
    return camera;
}

float Viewport::free_aspect() const {
    const glm::vec2 free = glm::max(free_max_ - free_min_, glm::vec2(1.0f));
    return free.x / free.y;
}

glm::vec3 Viewport::forward() const {
    const glm::vec3 way = camera_.target - camera_.eye;
    const float length = glm::length(way);
    return length > 0.0f ? way / length : glm::vec3(0.0f, 0.0f, -1.0f);
}

glm::vec2 Viewport::shift(glm::vec2 window, glm::vec2 free_min, glm::vec2 free_max) {
    const glm::vec2 size = glm::max(window, glm::vec2(1.0f));
    return (free_min + free_max) / size - 1.0f;
}

} // namespace brittle::tools

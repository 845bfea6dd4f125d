// The part of the window that shows the scene: from the cursor to rays, from places to pixels. Pixels from the top left.
#pragma once

#include <optional>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "engine/render/camera.h"

namespace brittle::tools {

struct Ray {
    glm::dvec3 from{0.0};
    glm::dvec3 direction{0.0, 0.0, -1.0}; // unit
};

class Viewport {
  public:
    // Of the window, and what of it no panel covers.
    Viewport(const engine::Camera& camera, glm::vec2 window, glm::vec2 free_min, glm::vec2 free_max);

    [[nodiscard]] Ray ray(glm::vec2 pixel) const;
    [[nodiscard]] std::optional<glm::vec2> pixel(const glm::vec3& point) const; // nothing for what is behind the eye
    [[nodiscard]] float pixels_a_metre(const glm::vec3& at) const;
    [[nodiscard]] bool is_free(glm::vec2 pixel) const;
    [[nodiscard]] const engine::Camera& camera() const { return camera_; }
    // The camera of a picture that shows the free part and no more, where shift() puts its middle.
    [[nodiscard]] engine::Camera free_camera() const;
    [[nodiscard]] float free_aspect() const;
    [[nodiscard]] glm::vec2 window() const { return window_; }
    [[nodiscard]] glm::vec2 free_min() const { return free_min_; }
    [[nodiscard]] glm::vec2 free_max() const { return free_max_; }
    [[nodiscard]] glm::vec3 forward() const; // unit

    // How far from the middle of the window the middle of the free part is, as Camera::shift wants it.
    [[nodiscard]] static glm::vec2 shift(glm::vec2 window, glm::vec2 free_min, glm::vec2 free_max);

  private:
    engine::Camera camera_;
    glm::vec2 window_, free_min_, free_max_;
    glm::mat4 clip_from_world_, world_from_clip_;
};

} // namespace brittle::tools

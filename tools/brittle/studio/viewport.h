// The part of the window that shows the scene: converts pixels to rays and points to pixels. Pixels count from the top
// left.
#pragma once

#include <optional>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "engine/camera/camera.h"

namespace brittle::tools {

struct Ray {
    glm::dvec3 from{0.0};
    glm::dvec3 direction{0.0, 0.0, -1.0}; // unit
};

class Viewport {
  public:
    // `window` is the size of the window; `free_min` and `free_max` bound the part without panels.
    Viewport(const engine::Camera& camera, glm::vec2 window, glm::vec2 free_min, glm::vec2 free_max);

    [[nodiscard]] Ray ray(glm::vec2 pixel) const;
    [[nodiscard]] std::optional<glm::vec2> pixel(const glm::vec3& point) const; // nothing for a point behind the eye
    [[nodiscard]] float pixels_a_metre(const glm::vec3& at) const;
    [[nodiscard]] bool is_free(glm::vec2 pixel) const;
    [[nodiscard]] const engine::Camera& camera() const { return camera_; }
    // Returns the camera of a picture of the free part alone, whose centre is where shift() puts it.
    [[nodiscard]] engine::Camera free_camera() const;
    [[nodiscard]] float free_aspect() const;
    [[nodiscard]] glm::vec2 window() const { return window_; }
    [[nodiscard]] glm::vec2 free_min() const { return free_min_; }
    [[nodiscard]] glm::vec2 free_max() const { return free_max_; }
    [[nodiscard]] glm::vec3 forward() const; // unit

    // Returns the offset of the free part's centre from the window's, in the units of Camera::shift.
    [[nodiscard]] static glm::vec2 shift(glm::vec2 window, glm::vec2 free_min, glm::vec2 free_max);

  private:
    engine::Camera camera_;
    glm::vec2 window_, free_min_, free_max_;
    glm::mat4 clip_from_world_, world_from_clip_;
};

} // namespace brittle::tools

// The view volume of a camera, for visibility tests on the CPU.
//
// - It has four side planes and no near or far plane: it begins at the eye and its depth is unlimited.
// - The test is that of the cull pass (shaders/frustum.h) and is conservative: it never rejects a visible ball, and may
//   accept a ball near an edge or corner of the volume.
// - Plain data; any thread.
//
//     const ViewVolume view(scene.camera, 16.0f / 9.0f);
//     if (!view.sees(ball.centre, ball.radius)) remove(ball);
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "engine/camera/camera.h"

namespace brittle::engine {

class ViewVolume {
  public:
    // `aspect` is width / height.
    ViewVolume(const Camera& camera, float aspect);

    // Returns whether any part of a ball may be visible. Metres.
    [[nodiscard]] bool sees(const glm::vec3& centre, float radius) const { return sees(centre, centre, radius); }
    // Returns whether any part of a ball that moves along a segment may be visible.
    [[nodiscard]] bool sees(const glm::vec3& from, const glm::vec3& to, float radius) const;

  private:
    glm::mat4 clip_from_world_;
};

} // namespace brittle::engine

// The part of the world that a picture shows, for whoever asks of many things whether they are in it.
//
// - From the eye on, however near or far: unlike a picture's, its depth has no end.
// - The test is that of the cull pass (shaders/frustum.h): what is drawn is never called unseen, what is beyond a corner
//   may be called seen.
// - Plain data; any thread.
//
//     const ViewVolume view(scene.camera, 16.0f / 9.0f);
//     if (!view.sees(ball.centre, ball.radius)) take_out(ball);
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "engine/render/camera.h"

namespace brittle::engine {

class ViewVolume {
  public:
    // aspect: width by height.
    ViewVolume(const Camera& camera, float aspect);

    // Metres.
    [[nodiscard]] bool sees(const glm::vec3& centre, float radius) const { return sees(centre, centre, radius); }
    // Any of a ball that is moved along a segment.
    [[nodiscard]] bool sees(const glm::vec3& from, const glm::vec3& to, float radius) const;

  private:
    glm::mat4 clip_from_world_;
};

} // namespace brittle::engine

// The camera of the studio: orbit, pan, zoom towards the cursor, fly, frame.
#pragma once

#include "engine/camera/camera.h"
#include "engine/core/window.h"
#include "tools/brittle/pictures/picture.h"
#include "tools/brittle/studio/viewport.h"

namespace brittle::tools {

class Navigation {
  public:
    // Sets the camera by the picture of a recipe. `aspect` is that of the free part of the window, here and below.
    void look_as(const PictureOptions& picture, const engine::Bounds& home, float aspect);
    // Writes the direction and distance of the camera to the picture of a recipe. Panning is not part of a picture.
    void tell(PictureOptions& picture, const engine::Bounds& home, float aspect) const;

    void frame(const engine::Bounds& bounds, float aspect); // looks at the bounds without turning
    void orbit(glm::vec2 pixels) { orbit_.rotate(pixels); }
    void pan(glm::vec2 pixels) { orbit_.pan(pixels); }
    void zoom(float notches, const Viewport& view, glm::vec2 cursor); // the point under the cursor keeps its pixel
    // Moves along the view, to the right and up, in shares of the usual speed.
    void fly(const glm::vec3& forward_right_up, double seconds);

    [[nodiscard]] engine::Camera camera(glm::vec2 shift) const;

  private:
    engine::OrbitCamera orbit_;
};

} // namespace brittle::tools

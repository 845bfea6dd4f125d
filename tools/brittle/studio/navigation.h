// The camera of the studio: orbit, pan, zoom towards the cursor, fly, frame.
#pragma once

#include "engine/core/window.h"
#include "engine/render/camera.h"
#include "tools/brittle/pictures/picture.h"
#include "tools/brittle/studio/viewport.h"

namespace brittle::tools {

class Navigation {
  public:
    // As the recipe's picture has it. `aspect` of the part of the window that is free; so below.
    void look_as(const PictureOptions& picture, const engine::Bounds& home, float aspect);
    // What the recipe's picture is to say for the camera of now; where it pans to is not kept.
    void tell(PictureOptions& picture, const engine::Bounds& home, float aspect) const;

    void frame(const engine::Bounds& bounds, float aspect); // keeps the direction
    void orbit(glm::vec2 pixels) { orbit_.rotate(pixels); }
    void pan(glm::vec2 pixels) { orbit_.pan(pixels); }
    void zoom(float notches, const Viewport& view, glm::vec2 cursor); // what is under the cursor stays there
    // Along the view, to the side and up, as shares of a usual speed.
    void fly(const glm::vec3& forward_right_up, double seconds);

    [[nodiscard]] engine::Camera camera(glm::vec2 shift) const;

  private:
    engine::OrbitCamera orbit_;
};

} // namespace brittle::tools

// The camera, and an orbit camera for the mouse.
//
// World space is right-handed with Y up, in metres. View space looks along -Z. Clip space is Vulkan's, with depth from
// 0 (near) to 1 (far) and Y downwards; matrices() negates the Y row of the projection. The negation also compensates
// for the handedness of Vulkan's screen: triangles that are counter-clockwise seen from outside in world space stay
// counter-clockwise on the screen, and front faces are VK_FRONT_FACE_COUNTER_CLOCKWISE.
//
// Plain data and pure functions; any thread.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace brittle::engine {

// An axis-aligned box, in metres.
struct Bounds {
    glm::vec3 min{-1.0f};
    glm::vec3 max{1.0f};

    [[nodiscard]] glm::vec3 centre() const { return (min + max) * 0.5f; }
    [[nodiscard]] glm::vec3 size() const { return max - min; }
};

// Returns the smallest box around both.
[[nodiscard]] Bounds join(const Bounds& a, const Bounds& b);

struct Camera {
    glm::vec3 eye{0.0f, 1.0f, 4.0f};
    glm::vec3 target{0.0f};
    float vertical_fov = 0.6f; // radians, in (0, pi)
    // The position of the target in the picture, relative to its centre, in units of half the width and half the
    // height; x to the right, y down. For pictures partly covered by panels.
    glm::vec2 shift{0.0f};
};

struct CameraMatrices {
    glm::mat4 view{1.0f};
    glm::mat4 projection{1.0f};
    float near_plane = 0.1f; // metres
    float far_plane = 100.0f;
};

// Returns the camera's matrices; the near and far planes enclose `bounds`. `aspect` is width / height. Every camera
// gives finite matrices: an eye at its target looks along -Z, and a view straight up or down has Z as its up axis.
[[nodiscard]] CameraMatrices matrices(const Camera& camera, float aspect, const Bounds& bounds);

// Returns a camera that sees all corners of `bounds`. Azimuth turns about Y from +Z towards +X, and elevation is the
// angle above the ground, both in radians. `margin` 1 fits the picture tightly; larger values leave space around.
[[nodiscard]] Camera look_at_bounds(const Bounds& bounds, float azimuth, float elevation, float aspect,
                                    float vertical_fov = 0.6f, float margin = 1.05f);

// An orbit camera for the mouse:
//
//     OrbitCamera orbit = OrbitCamera::around(bounds, aspect);
//     orbit.rotate(input.drag_left); orbit.pan(input.drag_right); orbit.zoom(input.scroll);
//     scene.camera = orbit.camera();
struct OrbitCamera {
    glm::vec3 target{0.0f};
    float azimuth = 0.5f;   // radians, from +Z towards +X
    float elevation = 0.3f; // radians, clamped before the poles
    float distance = 4.0f;  // metres, > 0
    float vertical_fov = 0.6f;
    glm::vec2 shift{0.0f}; // as Camera::shift

    [[nodiscard]] static OrbitCamera around(const Bounds& bounds, float aspect);
    void rotate(glm::vec2 pixels);
    void pan(glm::vec2 pixels); // moves the target in the view plane
    void zoom(float notches);   // positive moves the eye towards the target
    [[nodiscard]] Camera camera() const;
};

} // namespace brittle::engine

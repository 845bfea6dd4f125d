// The camera, and an orbit around a point for mice.
//
// World space is right-handed with Y up, in metres. View space looks along -Z. Clip space is Vulkan's: depth
// from 0 (near) to 1 (far), and Y downwards, which projection() takes care of by negating its Y row. The
// negation turns the screen's handedness round, so that triangles that are counter-clockwise seen from
// outside in world space stay counter-clockwise on the screen: front faces are
// VK_FRONT_FACE_COUNTER_CLOCKWISE.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace brittle::engine {

struct Bounds {
    glm::vec3 min{-1.0f};
    glm::vec3 max{1.0f};

    [[nodiscard]] glm::vec3 centre() const { return (min + max) * 0.5f; }
    [[nodiscard]] glm::vec3 size() const { return max - min; }
};

// The smallest box around both.
[[nodiscard]] Bounds join(const Bounds& a, const Bounds& b);

struct Camera {
    glm::vec3 eye{0.0f, 1.0f, 4.0f};
    glm::vec3 target{0.0f};
    float vertical_fov = 0.6f; // radians, in (0, pi)
    // Where the target appears, from the picture's centre, in half pictures: x to the right, y down. For pictures of
    // which panels cover a part.
    glm::vec2 shift{0.0f};
};

struct CameraMatrices {
    glm::mat4 view{1.0f};
    glm::mat4 projection{1.0f};
    float near_plane = 0.1f; // metres
    float far_plane = 100.0f;
};

// Near and far planes enclose `bounds`. Any camera gives finite matrices: an eye on its target looks along
// -Z, a view straight up or down turns about Z.
[[nodiscard]] CameraMatrices matrices(const Camera& camera, float aspect, const Bounds& bounds);

// A camera that sees all of `bounds`. Azimuth turns about Y from +Z towards +X, elevation rises from the
// ground; both in radians. `margin` 1 fits the bounding sphere tightly.
[[nodiscard]] Camera look_at_bounds(const Bounds& bounds, float azimuth, float elevation, float aspect,
                                    float vertical_fov = 0.6f, float margin = 1.05f);

// An orbit for the mouse:
//
//     OrbitCamera orbit = OrbitCamera::around(bounds, aspect);
//     orbit.rotate(input.drag_left); orbit.pan(input.drag_right); orbit.zoom(input.scroll);
//     scene.camera = orbit.camera();
struct OrbitCamera {
    glm::vec3 target{0.0f};
    float azimuth = 0.5f;   // radians, from +Z towards +X
    float elevation = 0.3f; // radians, kept short of the poles
    float distance = 4.0f;  // metres, > 0
    float vertical_fov = 0.6f;
    glm::vec2 shift{0.0f}; // as Camera::shift

    [[nodiscard]] static OrbitCamera around(const Bounds& bounds, float aspect);
    void rotate(glm::vec2 pixels);
    void pan(glm::vec2 pixels); // moves the target in the view plane
    void zoom(float notches);   // positive comes closer
    [[nodiscard]] Camera camera() const;
};

} // namespace brittle::engine

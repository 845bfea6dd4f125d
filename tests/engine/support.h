// Common parts of the engine's tests: a device, shapes, and golden images.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "engine/core/bitmap.h"
#include "engine/gpu/device.h"
#include "engine/render/renderer.h"
#include "engine/render/scene.h"

namespace brittle::engine::test {

// Returns the device for tests, with validation if the layer is installed. The environment variable BRITTLE_TEST_DEVICE
// has the role of DeviceOptions::select. Without a device, prints "skipped: ...", which ctest counts, and returns null.
[[nodiscard]] std::unique_ptr<Device> make_device(FaultInjector* faults = nullptr);

struct Shape {
    std::vector<glm::vec3> positions;
    std::vector<glm::uvec3> triangles;
    uint32_t exterior_triangles = 0;

    [[nodiscard]] PieceMesh piece(uint32_t body, glm::vec3 tint = glm::vec3(1.0f)) const {
        return {positions, triangles, exterior_triangles, body, tint};
    }
};

// Returns a box around the origin. The last `interior_faces` of its six faces (-x +x -y +y -z +z) are interior.
[[nodiscard]] Shape box(glm::vec3 half, uint32_t interior_faces = 0);
// Returns a subdivided icosahedron with 20 * 4^levels triangles.
[[nodiscard]] Shape icosphere(float radius, int levels);

// The scene of the golden images: boxes and a ball on the ground, with marks. Its members point to each other, so it
// cannot be copied.
class KnownScene {
  public:
    KnownScene();
    KnownScene(const KnownScene&) = delete;
    KnownScene& operator=(const KnownScene&) = delete;

    [[nodiscard]] std::vector<PieceMesh> pieces() const;
    std::vector<BodyPose> poses;
    std::vector<LineVertex> lines;
    std::vector<Sphere> spheres;
    Scene scene;

  private:
    std::vector<Shape> shapes_;
};

struct GoldenCheck {
    bool passed = false;
    std::string message; // the difference, and the paths of its pictures
};

// Compares a picture with `folder`/NAME.png. A missing golden fails. When the two differ, writes NAME.actual.png,
// NAME.expected.png and NAME.difference.png to failure_folder(). With BRITTLE_UPDATE_GOLDENS=1 in the environment
// (tools/update-goldens), writes the golden instead unless it is equal byte for byte, describes the difference, and
// writes NAME.before.png and NAME.difference.png to failure_folder().
[[nodiscard]] GoldenCheck check_golden(const Bitmap& actual, const std::string& name, const BitmapTolerance& tolerance,
                                       const std::string& folder);
[[nodiscard]] bool is_updating_goldens();
[[nodiscard]] std::string golden_folder();  // tests/images
[[nodiscard]] std::string failure_folder(); // in the build folder

// Returns a pixel as 0xRRGGBB.
[[nodiscard]] uint32_t pixel(const Bitmap& bitmap, uint32_t x, uint32_t y);

} // namespace brittle::engine::test

// What the engine's tests share: a device, shapes, and golden images.
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

// The device that tests run on, with validation where the layer is installed: BRITTLE_TEST_DEVICE, as in
// DeviceOptions::select, or the automatic choice. Null, with "skipped: ..." printed for ctest to count, if
// there is none.
[[nodiscard]] std::unique_ptr<Device> make_device(FaultInjector* faults = nullptr);

struct Shape {
    std::vector<glm::vec3> positions;
    std::vector<glm::uvec3> triangles;
    uint32_t exterior_triangles = 0;

    [[nodiscard]] PieceMesh piece(uint32_t body, glm::vec3 tint = glm::vec3(1.0f)) const {
        return {positions, triangles, exterior_triangles, body, tint};
    }
};

// Centred on the origin; the last `interior_faces` of its six faces (-x +x -y +y -z +z) are interior.
[[nodiscard]] Shape box(glm::vec3 half, uint32_t interior_faces = 0);
// 20 * 4^levels triangles.
[[nodiscard]] Shape icosphere(float radius, int levels);

// Boxes and a ball on the ground, with marks: the scene of the golden images. Points into itself, so it stays
// put.
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
    std::string message; // what differs, and where the pictures of it are
};

// Compares with `folder`/NAME.png. Where they differ, leaves NAME.actual.png, NAME.expected.png and
// NAME.difference.png in the folder of the test's program. A golden that is missing fails. With
// BRITTLE_UPDATE_GOLDENS=1 in the environment (tools/update-goldens) writes the golden instead where it is not equal to the
// last bit, says how it differs, and leaves NAME.before.png and NAME.difference.png there.
[[nodiscard]] GoldenCheck check_golden(const Bitmap& actual, const std::string& name, const BitmapTolerance& tolerance,
                                       const std::string& folder);
[[nodiscard]] bool is_updating_goldens();
[[nodiscard]] std::string golden_folder();  // tests/images
[[nodiscard]] std::string failure_folder(); // in the build folder

// The bytes of a pixel as 0xRRGGBB.
[[nodiscard]] uint32_t pixel(const Bitmap& bitmap, uint32_t x, uint32_t y);

} // namespace brittle::engine::test

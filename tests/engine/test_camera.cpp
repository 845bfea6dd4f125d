#include <cmath>
#include <limits>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include "engine/camera/camera.h"
#include "engine/render/scene.h"

using namespace brittle::engine;

namespace {

bool finite(const glm::mat4& m) {
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r)
            if (!std::isfinite(m[c][r])) return false;
    return true;
}

glm::vec3 project(const CameraMatrices& m, glm::vec3 p) {
    const glm::vec4 clip = m.projection * m.view * glm::vec4(p, 1.0f);
    return glm::vec3(clip) / clip.w;
}

} // namespace

TEST_CASE("any camera gives finite matrices") {
    const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    const Bounds point{{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}};
    for (const Camera& camera : {Camera{{1, 1, 1}, {1, 1, 1}}, Camera{{0, 5, 0}, {0, 0, 0}}, Camera{{0, -5, 0}, {}},
                                 Camera{{nan, 0, 0}, {}}, Camera{{0, 0, 1}, {inf, 0, 0}}, Camera{{0, 0, 1}, {}, 0.0f},
                                 Camera{{0, 0, 1}, {}, 9.0f}, Camera{{0, 0, 1}, {}, nan}})
        for (const Bounds& bounds : {point, Bounds{}}) {
            const CameraMatrices m = matrices(camera, 1.5f, bounds);
            CHECK(finite(m.view));
            CHECK(finite(m.projection));
            CHECK(m.near_plane > 0.0f);
            CHECK(m.far_plane > m.near_plane);
        }
}

TEST_CASE("the camera's target projects to the centre, with +Y up and +X right") {
    const CameraMatrices m = matrices({{0, 0, 5}, {0, 0, 0}}, 2.0f, {});
    const glm::vec3 middle = project(m, {0, 0, 0});
    CHECK(middle.x == doctest::Approx(0.0f));
    CHECK(middle.y == doctest::Approx(0.0f));
    CHECK(project(m, {0, 0.5f, 0}).y < 0.0f); // Vulkan's Y points down
    CHECK(project(m, {0.5f, 0, 0}).x > 0.0f);
}

TEST_CASE("depth runs from 0 at the near plane to 1 at the far plane, with the bounds between") {
    const CameraMatrices m = matrices({{0, 0, 5}, {0, 0, 0}}, 1.0f, {});
    CHECK(project(m, {0, 0, 5.0f - m.near_plane}).z == doctest::Approx(0.0f));
    CHECK(project(m, {0, 0, 5.0f - m.far_plane}).z == doctest::Approx(1.0f));
    CHECK(project(m, {0, 0, 1}).z > 0.0f);
    CHECK(project(m, {1, 1, -1}).z < 1.0f);
}

TEST_CASE("a camera that looks at bounds sees all of their corners, with a narrow margin") {
    const Bounds bounds{{-3.0f, 0.0f, -0.2f}, {1.0f, 0.7f, 0.4f}};
    for (const float aspect : {0.4f, 1.0f, 16.0f / 9.0f})
        for (const float azimuth : {0.0f, 0.8f, 2.5f})
            for (const float elevation : {-0.5f, 0.0f, 0.4f, 1.5f}) {
                const CameraMatrices m =
                    matrices(look_at_bounds(bounds, azimuth, elevation, aspect, 0.6f, 1.0f), aspect, bounds);
                float outermost = 0.0f;
                for (int i = 0; i < 8; ++i) {
                    const glm::vec3 p =
                        project(m, {i & 1 ? bounds.max.x : bounds.min.x, i & 2 ? bounds.max.y : bounds.min.y,
                                    i & 4 ? bounds.max.z : bounds.min.z});
                    outermost = std::max({outermost, std::abs(p.x), std::abs(p.y)});
                }
                CHECK(outermost == doctest::Approx(1.0f).epsilon(1e-3));
            }
}

TEST_CASE("an orbit camera keeps its distance when it rotates and its direction when it zooms") {
    OrbitCamera orbit = OrbitCamera::around({}, 1.5f);
    const float distance = orbit.distance;
    orbit.rotate({123.0f, -77.0f});
    CHECK(glm::length(orbit.camera().eye - orbit.camera().target) == doctest::Approx(distance));
    const glm::vec3 before = glm::normalize(orbit.camera().eye - orbit.camera().target);
    orbit.zoom(3.0f);
    CHECK(orbit.distance < distance);
    CHECK(glm::length(glm::normalize(orbit.camera().eye - orbit.camera().target) - before) < 1e-5f);
    orbit.rotate({0.0f, 1e6f});
    CHECK(orbit.elevation < 1.5707f);
    orbit.zoom(1e6f);
    CHECK(orbit.distance > 0.0f);
}

TEST_CASE("panning moves the picture with the mouse") {
    OrbitCamera orbit = OrbitCamera::around({}, 1.0f);
    const glm::vec3 mark = orbit.target;
    orbit.pan({40.0f, 25.0f});
    const glm::vec3 seen = project(matrices(orbit.camera(), 1.0f, {}), mark);
    CHECK(seen.x > 0.0f); // to the right
    CHECK(seen.y > 0.0f); // and down
}

TEST_CASE("piece tints are bright, in range, and differ between consecutive pieces") {
    for (uint32_t i = 0; i < 1000; ++i) {
        const glm::vec3 a = piece_tint(i), b = piece_tint(i + 1);
        for (int c = 0; c < 3; ++c) {
            CHECK(a[c] >= 0.15f);
            CHECK(a[c] <= 1.0f);
        }
        CHECK(glm::length(a - b) > 0.08f);
    }
}

TEST_CASE("Camera::shift moves the picture in units of half its size and changes no depth") {
    Camera camera{{0, 0, 5}, {0, 0, 0}};
    const CameraMatrices plain = matrices(camera, 1.5f, {});
    camera.shift = {0.25f, -0.5f};
    const CameraMatrices shifted = matrices(camera, 1.5f, {});
    for (const glm::vec3& p : {glm::vec3(0, 0, 0), glm::vec3(0.5f, -0.3f, 2), glm::vec3(-1, 1, -3)}) {
        const glm::vec3 before = project(plain, p), after = project(shifted, p);
        CHECK(after.x == doctest::Approx(before.x + 0.25f));
        CHECK(after.y == doctest::Approx(before.y - 0.5f));
        CHECK(after.z == doctest::Approx(before.z));
    }
}

// Culling on the device: equal pictures from fewer draws.
#include <algorithm>
#include <cmath>

#include <glm/gtc/quaternion.hpp>

#include "renderer_fixture.h"

using namespace brittle::engine;
using namespace brittle::engine::test;

namespace {

Quality quality(bool culling) {
    return {.shadow_size = 512, .soft_shadows = false, .samples = 1, .ambient_occlusion = false, .culling = culling};
}

// A grid of boxes in the x-y plane around the origin, one metre apart, each with its own rotation.
struct Grid {
    Shape cube = box({0.3f, 0.2f, 0.1f}, 2);
    int side;
    std::vector<PieceMesh> pieces;
    std::vector<BodyPose> poses;
    Scene scene;

    explicit Grid(int pieces_a_side) : side(pieces_a_side) {
        for (glm::vec3& p : cube.positions)
            p += glm::vec3(0.1f, -0.2f, 0.05f); // moves the bounding spheres off the origin
        const float middle = 0.5f * static_cast<float>(side - 1);
        for (int i = 0; i < side * side; ++i) {
            const auto number = static_cast<uint32_t>(i);
            pieces.push_back(cube.piece(number, piece_tint(number)));
            poses.push_back(
                {.rotation = glm::angleAxis(0.7f * static_cast<float>(i), glm::vec3(0.6f, 0.0f, 0.8f)),
                 .position = {static_cast<float>(i % side) - middle, static_cast<float>(i / side) - middle, 0.0f},
                 .scale = i % 7 == 3 ? 1.4f : 1.0f});
        }
        scene.write_poses = [this](std::span<BodyPose> out, uint64_t) {
            std::copy(poses.begin(), poses.end(), out.begin());
        };
        scene.bounds = {glm::vec3(-middle - 1.0f, -middle - 1.0f, -1.0f),
                        glm::vec3(middle + 1.0f, middle + 1.0f, 1.0f)};
        scene.ground_height = -middle - 1.0f;
        scene.camera = look_at_bounds(scene.bounds, 0.0f, 0.0f, 1.5f);
    }
};

} // namespace

TEST_CASE("culling changes no picture, wherever the camera is") {
    const Fixture all(quality(false)), culled(quality(true));
    if (!all || !all.device->has_multi_draw()) return;
    Grid grid(9);
    REQUIRE(all.renderer->set_pieces(grid.pieces));
    REQUIRE(culled.renderer->set_pieces(grid.pieces));
    uint32_t fewest = ~0u, most = 0;
    for (int i = 0; i < 60; ++i) {
        const float t = static_cast<float>(i);
        grid.scene.camera = {.eye = {6.0f * std::sin(0.9f * t), 4.0f * std::cos(1.3f * t), 5.0f * std::cos(0.4f * t)},
                             .target = {3.0f * std::sin(2.1f * t), 3.0f * std::cos(1.7f * t), 0.0f},
                             .vertical_fov = i % 5 == 0 ? 0.05f : 0.6f};
        grid.scene.bounds.max.x = i % 4 == 0 ? 0.0f : 5.0f; // some cast no shadow
        grid.scene.moved = i % 3 != 0;
        grid.poses[static_cast<size_t>(i)].scale = 0.0f;
        grid.poses[40].scale = -1.0f; // mirrored
        CAPTURE(i);
        CHECK(culled.draw(grid.scene).pixels == all.draw(grid.scene).pixels);
        const FrameStats& stats = culled.renderer->stats();
        CHECK(stats.pieces == 81);
        fewest = std::min(fewest, stats.pieces_in_view);
        most = std::max(most, stats.pieces_in_view);
        CHECK(all.renderer->stats().pieces_in_view == 81);
    }
    CHECK(fewest < 10);
    CHECK(most > 30);
}

TEST_CASE("culling counts each visible piece once, whatever its draw ranges") {
    const Fixture f(quality(true));
    if (!f || !f.device->has_multi_draw()) return;
    Grid grid(5);
    REQUIRE(f.renderer->set_pieces(grid.pieces));
    (void)f.draw(grid.scene);
    CHECK(f.renderer->stats().draws == 50);
    CHECK(f.renderer->stats().pieces_in_view == 25);
    CHECK(f.renderer->stats().indirect_calls == 2);
    grid.poses[7].scale = 0.0f;
    (void)f.draw(grid.scene);
    CHECK(f.renderer->stats().pieces_in_view == 24);
    // Towards one piece of the middle row, so near that no other piece is visible.
    grid.scene.camera = {.eye = {0.0f, 0.0f, 1.0f}, .target = {0.0f, 0.0f, 0.0f}, .vertical_fov = 0.1f};
    (void)f.draw(grid.scene);
    CHECK(f.renderer->stats().pieces_in_view == 1);
    grid.scene.camera.target = {0.0f, 0.0f, 2.0f}; // away from all pieces
    (void)f.draw(grid.scene);
    CHECK(f.renderer->stats().pieces_in_view == 0);
    REQUIRE(f.renderer->set_pieces({}));
    (void)f.draw(grid.scene);
    CHECK(f.renderer->stats().pieces_in_view == 0);
}

TEST_CASE("a piece outside the camera's view still casts its shadow into it") {
    const Fixture f(quality(true));
    if (!f || !f.device->has_multi_draw()) return;
    const Shape cube = box(glm::vec3(0.5f));
    const PieceMesh piece = cube.piece(0);
    REQUIRE(f.renderer->set_pieces({&piece, 1}));
    Scene scene{.camera = {{3.0f, 3.0f, 0.001f}, {3.0f, 0.0f, 0.0f}, 0.3f},
                .bounds = {{-0.5f, 2.5f, -0.5f}, {0.5f, 3.5f, 0.5f}}};
    scene.write_poses = [](std::span<BodyPose> poses, uint64_t) { poses[0].position = {0.0f, 3.0f, 0.0f}; };
    scene.look.to_light = {-1.0f, 1.0f, 0.0f};
    const Bitmap image = f.draw(scene);
    CHECK(f.renderer->stats().pieces_in_view == 0);
    scene.pieces_visible = false;
    const Bitmap without = f.draw(scene);
    CHECK(image.at(small.x / 2, small.y / 2)[1] < without.at(small.x / 2, small.y / 2)[1] - 20);
}

TEST_CASE("ten thousand pieces need one draw call in each pass") {
    const Fixture f(quality(true));
    if (!f || !f.device->has_multi_draw()) return;
    const Grid grid(100);
    REQUIRE(f.renderer->set_pieces(grid.pieces));
    (void)f.draw(grid.scene);
    CHECK(f.renderer->stats().pieces_in_view == 10000);
    CHECK(f.renderer->stats().draws == 20000);
    CHECK(f.renderer->stats().indirect_calls == 2);
}

TEST_CASE("a device without multi-draws draws equal pictures, with one call for each draw range") {
    const Fixture with;
    if (!with || !with.device->has_multi_draw()) return;
    FaultInjector faults;
    faults.hide("multiDrawIndirect");
    KnownScene known;
    REQUIRE(with.renderer->set_pieces(known.pieces()));
    const Bitmap expected = with.draw(known.scene);
    const Result<IdImage> expected_ids = with.renderer->render_ids(known.scene, small);
    REQUIRE(expected_ids);
    const auto check_without = [&](const Quality& asked, bool culls) {
        const Fixture without({.quality = asked}, &faults);
        CHECK_FALSE(without.device->has_multi_draw());
        CHECK(*without.renderer->quality().culling == culls);
        const auto handles = without.renderer->set_pieces(known.pieces());
        REQUIRE(handles);
        CHECK(without.draw(known.scene).pixels == expected.pixels);
        CHECK(without.renderer->stats().draws == 6);
        CHECK(without.renderer->stats().indirect_calls == 12); // six ranges, in the shadow and the shade pass
        CHECK(without.renderer->stats().pieces_in_view == 4);
        const Result<IdImage> ids = without.renderer->render_ids(known.scene, small);
        REQUIRE(ids);
        CHECK(ids->ids == expected_ids->ids);
        // Solid and fading ranges, each drawn by its own call.
        REQUIRE(without.renderer->fade_pieces(std::span(*handles).first(1), 0.5f));
        (void)without.draw(known.scene);
        CHECK(without.renderer->stats().indirect_calls == 12);
    };
    check_without(plain_quality, false);
    check_without(quality(true), true);
}

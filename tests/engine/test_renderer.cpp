#include <cstring>
#include <limits>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

#include "renderer_fixture.h"

using namespace brittle::engine;
using namespace brittle::engine::test;

namespace {

bool reddish(uint32_t rgb) {
    return (rgb >> 16) > (rgb & 0xff) + 40;
}

} // namespace

TEST_CASE("an empty scene draws the background alone") {
    const Fixture f;
    if (!f) return;
    CHECK(f.renderer->body_count() == 0);
    const Bitmap image = f.draw(empty_stage());
    CHECK(f.renderer->stats().draws == 0);
    CHECK(f.renderer->stats().indirect_calls == 0);
    CHECK(pixel(image, 0, 0) != 0);
    for (uint32_t y = 0; y < image.height; ++y)
        for (uint32_t x = 1; x < image.width; ++x) REQUIRE(pixel(image, x, y) == pixel(image, 0, y));
    CHECK(image.at(5, 5)[3] == 255);
}

TEST_CASE("no pieces, pieces without triangles and an empty size do not crash") {
    const Fixture f;
    if (!f) return;
    CHECK(f.renderer->set_pieces({}));
    const PieceMesh nothing{};
    CHECK(f.renderer->set_pieces({&nothing, 1}));
    CHECK(f.renderer->body_count() == 1);
    (void)f.draw(empty_stage());
    CHECK(f.renderer->stats().draws == 0);
    for (const glm::uvec2 size : {glm::uvec2(0, 10), glm::uvec2(10, 0), glm::uvec2(1u << 30, 4)}) {
        const Result<Bitmap> image = f.renderer->render(empty_stage(), size);
        REQUIRE_FALSE(image);
        CHECK(image.error().status == Status::invalid_argument);
    }
}

TEST_CASE("invalid pieces are refused with their number, and the old ones stay") {
    const Fixture f;
    if (!f) return;
    const Shape cube = box(glm::vec3(1.0f));
    const PieceMesh good = cube.piece(0);
    REQUIRE(f.renderer->set_pieces({&good, 1}));
    const Bitmap before = f.draw(empty_stage());

    Shape bad_index = cube;
    bad_index.triangles[7].y = 8;
    PieceMesh bad_exterior = good, bad_body = good;
    bad_exterior.exterior_triangles = 13;
    bad_body.body = std::numeric_limits<uint32_t>::max();
    for (const PieceMesh& bad : {bad_index.piece(0), bad_exterior, bad_body}) {
        const PieceMesh two[] = {good, bad};
        const auto set = f.renderer->set_pieces(two);
        REQUIRE_FALSE(set);
        CHECK(set.error().status == Status::invalid_argument);
        CHECK(set.error().message.find("piece 1") != std::string::npos);
    }
    CHECK(f.draw(empty_stage()).pixels == before.pixels);
}

TEST_CASE("a shadow map out of range is refused") {
    const std::unique_ptr<Device> device = make_device();
    if (!device) return;
    for (const uint32_t size : {0u, 63u, 1u << 20}) {
        const Result<std::unique_ptr<Renderer>> made = Renderer::create(*device, {.quality = {.shadow_size = size}});
        REQUIRE_FALSE(made);
        CHECK(made.error().status == Status::invalid_argument);
    }
}

TEST_CASE("present without a window is an error") {
    const Fixture f;
    if (!f) return;
    const Result<bool> shown = f.renderer->present(empty_stage());
    REQUIRE_FALSE(shown);
    CHECK(shown.error().status == Status::invalid_argument);
}

TEST_CASE("scenes with NaN and infinity are drawn without a crash") {
    const Fixture f;
    if (!f) return;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const Shape cube = box(glm::vec3(1.0f));
    const PieceMesh piece = cube.piece(0);
    REQUIRE(f.renderer->set_pieces({&piece, 1}));
    Scene scene;
    scene.camera.eye.x = nan;
    (void)f.draw(scene);
    scene = {};
    scene.bounds = {glm::vec3(nan), glm::vec3(nan)};
    scene.look.to_light = {0.0f, 0.0f, 0.0f};
    (void)f.draw(scene);
    scene = {};
    scene.write_poses = [&](std::span<BodyPose> poses, uint64_t) { poses[0].position = glm::vec3(nan); };
    (void)f.draw(scene);
    scene = {};
    scene.bounds = {glm::vec3(0.0f), glm::vec3(0.0f)};
    (void)f.draw(scene, {1, 1});
}

TEST_CASE("one indirect call draws all ranges, in the shadow pass and in the shade pass") {
    const Fixture f;
    if (!f) return;
    const KnownScene known;
    REQUIRE(f.renderer->set_pieces(known.pieces()));
    CHECK(f.renderer->body_count() == 4);
    (void)f.draw(known.scene);
    const FrameStats& stats = f.renderer->stats();
    CHECK(stats.pieces == 4);
    CHECK(stats.draws == 6); // two of the four have interior faces
    CHECK(stats.indirect_calls == 2);
    CHECK(stats.triangles == 3 * 12 + 1280);
    CHECK(stats.shadow_drawn);
}

TEST_CASE("interior faces have the interior's colour") {
    const Fixture f;
    if (!f) return;
    for (const uint32_t interior : {0u, 1u}) { // the last face, +z, faces the camera
        const Shape cube = box(glm::vec3(1.0f), interior);
        const PieceMesh piece = cube.piece(0);
        REQUIRE(f.renderer->set_pieces({&piece, 1}));
        const Bitmap image = f.draw(empty_stage());
        CHECK(reddish(pixel(image, small.x / 2, small.y / 2)) == (interior == 1));
    }
}

TEST_CASE("back faces are culled and front faces are not") {
    const Fixture f;
    if (!f) return;
    Shape cube = box(glm::vec3(1.0f));
    Scene scene = empty_stage();
    PieceMesh piece = cube.piece(0);
    REQUIRE(f.renderer->set_pieces({&piece, 1}));
    const uint32_t outside = pixel(f.draw(scene), small.x / 2, small.y / 2);
    for (glm::uvec3& t : cube.triangles) std::swap(t.y, t.z);
    piece = cube.piece(0);
    REQUIRE(f.renderer->set_pieces({&piece, 1}));
    const uint32_t inside = pixel(f.draw(scene), small.x / 2, small.y / 2);
    CHECK(outside != inside); // inside is the far wall, in the cube's own shadow
}

TEST_CASE("a pose moves, rotates, scales and hides its own body only") {
    const Fixture f;
    if (!f) return;
    const Shape cube = box(glm::vec3(0.3f));
    const PieceMesh pieces[] = {cube.piece(0), cube.piece(1, {0.4f, 0.5f, 1.0f})};
    REQUIRE(f.renderer->set_pieces(pieces));
    std::vector<BodyPose> poses(2);
    Scene scene = empty_stage();
    scene.write_poses = [&](std::span<BodyPose> out, uint64_t) { std::copy(poses.begin(), poses.end(), out.begin()); };
    const glm::uvec2 size{128, 64};
    poses[0].position.x = -1.0f;
    poses[1].position.x = 1.0f;
    const Bitmap apart = f.draw(scene, size);
    const uint32_t backdrop = pixel(apart, 64, 32);
    const auto left = [&](const Bitmap& b) { return pixel(b, 64 - 21, 32); };
    const auto right = [&](const Bitmap& b) { return pixel(b, 64 + 21, 32); };
    CHECK(left(apart) != backdrop);
    CHECK(right(apart) != backdrop);
    CHECK(left(apart) != right(apart));

    poses[0].position.x = 0.0f;
    const Bitmap moved = f.draw(scene, size);
    CHECK(left(moved) == backdrop);
    CHECK(pixel(moved, 64, 32) != backdrop);
    CHECK(right(moved) == right(apart));

    poses[0].scale = 0.0f;
    const Bitmap hidden = f.draw(scene, size);
    CHECK(pixel(hidden, 64, 32) == backdrop);
    CHECK(right(hidden) == right(apart));

    // A long horizontal box, rotated upright by a quarter turn about Z.
    const Shape beam = box({1.0f, 0.1f, 0.1f});
    const PieceMesh piece = beam.piece(0);
    REQUIRE(f.renderer->set_pieces({&piece, 1}));
    poses = {BodyPose{}};
    const Bitmap lying = f.draw(scene, size);
    poses[0].rotation = glm::angleAxis(1.5707963f, glm::vec3(0.0f, 0.0f, 1.0f));
    const Bitmap standing = f.draw(scene, size);
    CHECK(left(lying) != backdrop);
    CHECK(left(standing) == backdrop);
    CHECK(pixel(lying, 64, 15) == pixel(standing, 2, 15));
    CHECK(pixel(standing, 64, 15) != pixel(standing, 2, 15));
}

TEST_CASE("two pieces may share a body") {
    const Fixture f;
    if (!f) return;
    const Shape a = box(glm::vec3(0.2f));
    Shape b = a;
    for (glm::vec3& p : b.positions) p.x += 1.0f;
    const PieceMesh pieces[] = {a.piece(0), b.piece(0)};
    REQUIRE(f.renderer->set_pieces(pieces));
    CHECK(f.renderer->body_count() == 1);
    Scene scene = empty_stage();
    const Bitmap shown = f.draw(scene);
    scene.write_poses = [](std::span<BodyPose> poses, uint64_t) { poses[0].scale = 0.0f; };
    const Bitmap hidden = f.draw(scene);
    const uint32_t x = small.x / 2 + 21;
    CHECK(pixel(shown, small.x / 2, small.y / 2) != pixel(hidden, small.x / 2, small.y / 2));
    CHECK(pixel(shown, x, small.y / 2) != pixel(hidden, x, small.y / 2));
}

TEST_CASE("a box above the ground casts its shadow along the sun's direction") {
    const Fixture f;
    if (!f) return;
    const Shape cube = box(glm::vec3(0.5f));
    const PieceMesh piece = cube.piece(0);
    REQUIRE(f.renderer->set_pieces({&piece, 1}));
    // Seen from above, the box would hide its own shadow, so the light is oblique.
    Scene scene{.camera = {{0.0f, 6.0f, 0.001f}, {0.0f, 0.0f, 0.0f}, 0.9f},
                .bounds = {{-0.5f, 1.0f, -0.5f}, {0.5f, 2.0f, 0.5f}}};
    scene.write_poses = [](std::span<BodyPose> poses, uint64_t) { poses[0].position = {0.0f, 1.5f, 0.0f}; };
    scene.look.to_light = {-1.0f, 1.0f, 0.0f}; // the shadow falls to +x, 1.5 m away from the box
    const Bitmap image = f.draw(scene, {129, 129});
    const auto brightness = [&](uint32_t x, uint32_t y) {
        const uint8_t* p = image.at(x, y);
        return p[0] + p[1] + p[2];
    };
    // 6 m up, 0.9 rad: 129 pixels are 5.8 m; 1.5 m are 33.
    const int shadow = brightness(64 + 33, 64), mirrored = brightness(64 - 33, 64);
    CHECK(shadow < mirrored - 60);
    CHECK(mirrored == brightness(64, 64 + 45));
}

TEST_CASE("a reused shadow map gives an equal picture without the shadow pass") {
    const Fixture f;
    if (!f) return;
    KnownScene known;
    REQUIRE(f.renderer->set_pieces(known.pieces()));
    const Bitmap first = f.draw(known.scene);
    known.scene.moved = false;
    const Bitmap second = f.draw(known.scene);
    CHECK_FALSE(f.renderer->stats().shadow_drawn);
    CHECK(first.pixels == second.pixels);
    CHECK(f.renderer->graph_dot().find("\"shadow\"") == std::string::npos);
    REQUIRE(f.renderer->set_pieces(known.pieces()));
    (void)f.draw(known.scene);
    CHECK(f.renderer->stats().shadow_drawn); // new pieces invalidate the shadow map, even with moved == false
}

TEST_CASE("the same scene gives the same bytes, frame after frame and size after size") {
    const Fixture f;
    if (!f) return;
    const KnownScene known;
    REQUIRE(f.renderer->set_pieces(known.pieces()));
    const Bitmap first = f.draw(known.scene);
    const Bitmap large = f.draw(known.scene, {200, 150});
    const Bitmap tiny = f.draw(known.scene, {1, 1});
    CHECK(f.draw(known.scene).pixels == first.pixels);
    CHECK(f.draw(known.scene, {200, 150}).pixels == large.pixels);
    CHECK(f.draw(known.scene, {1, 1}).pixels == tiny.pixels);
}

TEST_CASE("lines are drawn behind the pieces or on top of them") {
    const Fixture f;
    if (!f) return;
    const Shape cube = box(glm::vec3(0.5f));
    const PieceMesh piece = cube.piece(0);
    REQUIRE(f.renderer->set_pieces({&piece, 1}));
    // A red line through the centre of the cube, and a green one beside the cube.
    const LineVertex lines[] = {{{-1.0f, 0.01f, 0.0f}},
                                {{1.0f, 0.01f, 0.0f}},
                                {{-1.0f, -0.8f, 0.0f}, srgb8(0, 255, 0)},
                                {{1.0f, -0.8f, 0.0f}, srgb8(0, 255, 0)}};
    Scene scene = empty_stage();
    scene.lines = lines;
    const auto count = [](const Bitmap& b, uint32_t colour, uint32_t from, uint32_t to) {
        int n = 0;
        for (uint32_t y = 0; y < b.height; ++y)
            for (uint32_t x = from; x < to; ++x) n += pixel(b, x, y) == colour;
        return n;
    };
    constexpr uint32_t red = 0xd7261e, green = 0x00ff00;
    const Bitmap behind = f.draw(scene);
    CHECK(count(behind, red, 40, 56) == 0); // the columns of the cube
    CHECK(count(behind, red, 0, small.x) >= 10);
    CHECK(count(behind, green, 40, 56) >= 16);
    scene.lines_on_top = true;
    CHECK(count(f.draw(scene), red, 40, 56) >= 16);
}

TEST_CASE("spheres are drawn at their centres, hidden by pieces or on top") {
    const Fixture f;
    if (!f) return;
    const Shape cube = box(glm::vec3(0.5f));
    const PieceMesh piece = cube.piece(0);
    REQUIRE(f.renderer->set_pieces({&piece, 1}));
    const Sphere spheres[] = {{{0.0f, 0.0f, 0.0f}, 0.2f}, {{1.2f, 0.0f, 0.0f}, 0.2f}};
    Scene scene = empty_stage();
    scene.spheres = spheres;
    const uint32_t beside = small.x / 2 + 25;
    const Bitmap hidden = f.draw(scene);
    CHECK_FALSE(reddish(pixel(hidden, small.x / 2, small.y / 2)));
    CHECK(reddish(pixel(hidden, beside, small.y / 2)));
    scene.spheres_on_top = true;
    CHECK(reddish(pixel(f.draw(scene), small.x / 2, small.y / 2)));
    scene.spheres_on_top = false;
    scene.pieces_visible = false;
    CHECK(reddish(pixel(f.draw(scene), small.x / 2, small.y / 2)));
}

TEST_CASE("a ball's shadow covers the points whose light rays hit it, and marks cast none") {
    const Fixture f;
    if (!f) return;
    const Sphere ball{{0.1f, 1.0f, -0.1f}, 0.3f};
    Scene scene = empty_stage();
    scene.ground = true;
    scene.bounds = {ball.centre - ball.radius, ball.centre + ball.radius};
    scene.camera = {.eye = {0.3f, 5.0f, 1.5f}, .target = {0.3f, 0.0f, -0.3f}};
    const Bitmap bare = f.draw(scene);
    scene.spheres = {&ball, 1};
    const Bitmap mark = f.draw(scene);
    scene.spheres_cast_shadows = true;
    const Bitmap image = f.draw(scene);

    const CameraMatrices camera =
        matrices(scene.camera, static_cast<float>(small.x) / static_cast<float>(small.y), scene.bounds);
    const glm::mat4 world_from_clip = glm::inverse(camera.projection * camera.view);
    const auto green = [](uint32_t rgb) { return rgb >> 8 & 0xff; };
    // Returns the distance of the ball's centre from a line through a point.
    const auto distance = [&](glm::vec3 from, glm::vec3 along) {
        return glm::length(glm::cross(ball.centre - from, glm::normalize(along)));
    };
    int shaded = 0;
    for (uint32_t y = 0; y < small.y; ++y) {
        for (uint32_t x = 0; x < small.x; ++x) {
            const glm::vec2 at = (glm::vec2(x, y) + 0.5f) / glm::vec2(small) * 2.0f - 1.0f;
            const glm::vec4 far = world_from_clip * glm::vec4(at, 1.0f, 1.0f);
            const glm::vec3 ray = glm::vec3(far) / far.w - scene.camera.eye;
            if (distance(scene.camera.eye, ray) < 1.15f * ball.radius) continue; // the ball itself
            const glm::vec3 ground = scene.camera.eye - ray * (scene.camera.eye.y / ray.y);
            const float off = distance(ground, scene.look.to_light) / ball.radius;
            CHECK(pixel(mark, x, y) == pixel(bare, x, y));
            if (off < 0.85f) { // below 1, because the mesh is inscribed in the ball
                CHECK(green(pixel(image, x, y)) + 15 < green(pixel(bare, x, y)));
                ++shaded;
            }
            if (off > 1.15f) CHECK(pixel(image, x, y) == pixel(bare, x, y));
        }
    }
    CHECK(shaded > 20);
}

TEST_CASE("the number of marks may change from frame to frame") {
    const Fixture f;
    if (!f) return;
    Scene scene = empty_stage();
    const Bitmap bare = f.draw(scene);
    for (const size_t count : {2, 2000, 4, 0, 600, 0}) {
        const std::vector<LineVertex> lines(count, LineVertex{{0.0f, 0.0f, 0.0f}});
        const std::vector<Sphere> spheres(count, Sphere{{0.0f, 0.0f, 0.0f}, 0.2f});
        scene.lines = lines;
        scene.spheres = spheres;
        const Bitmap image = f.draw(scene);
        CHECK((image.pixels == bare.pixels) == (count == 0));
        scene.lines = {};
        scene.spheres = {};
    }
}

TEST_CASE("every pass of a frame is timed") {
    const Fixture f;
    if (!f) return;
    const KnownScene known;
    REQUIRE(f.renderer->set_pieces(known.pieces()));
    (void)f.draw(known.scene); // the first frame also has the upload pass
    (void)f.draw(known.scene);
    if (!f.device->limits().timestampComputeAndGraphics) return;
    std::vector<std::string> names;
    for (const PassTime& time : f.renderer->timings()) {
        names.push_back(time.name);
        CHECK(time.milliseconds >= 0.0);
        CHECK(time.milliseconds < 60000.0);
    }
    CHECK(names == std::vector<std::string>{"cull", "shadow", "shade", "marks", "read back"});
}

TEST_CASE("warm_up() leaves no piece and changes no picture") {
    const Fixture f;
    if (!f) return;
    REQUIRE(f.renderer->warm_up());
    CHECK(f.renderer->body_count() == 0);
    const KnownScene known;
    REQUIRE(f.renderer->set_pieces(known.pieces()));
    const Bitmap before = f.draw(known.scene);
    REQUIRE(f.renderer->warm_up());
    CHECK(f.renderer->body_count() == 4);
    CHECK(f.draw(known.scene).pixels == before.pixels);
}

TEST_CASE("two renderers share a device") {
    const Fixture f;
    if (!f) return;
    Result<std::unique_ptr<Renderer>> other = Renderer::create(
        *f.device, {.quality = {.shadow_size = 512, .soft_shadows = false, .samples = 1, .ambient_occlusion = false}});
    REQUIRE(other);
    const KnownScene known;
    REQUIRE(f.renderer->set_pieces(known.pieces()));
    REQUIRE((*other)->set_pieces(known.pieces()));
    const Result<Bitmap> image = (*other)->render(known.scene, small);
    REQUIRE(image);
    CHECK(image->pixels == f.draw(known.scene).pixels);
}

TEST_CASE("thousands of bodies draw in one call") {
    const Fixture f;
    if (!f) return;
    const Shape cube = box(glm::vec3(0.01f), 2);
    std::vector<PieceMesh> pieces;
    for (uint32_t i = 0; i < 5000; ++i) pieces.push_back(cube.piece(i));
    REQUIRE(f.renderer->set_pieces(pieces));
    Scene scene = empty_stage();
    scene.write_poses = [](std::span<BodyPose> poses, uint64_t) {
        for (size_t i = 0; i < poses.size(); ++i)
            poses[i] = {.position = {static_cast<float>(i % 71) / 35.0f - 1.0f,
                                     static_cast<float>(i / 71) / 35.0f - 1.0f, 0.0f}};
    };
    const Bitmap image = f.draw(scene);
    CHECK(f.renderer->stats().draws == 10000);
    CHECK(f.renderer->stats().indirect_calls <= 2);
    CHECK(pixel(image, small.x / 2, small.y / 2) != pixel(image, 0, small.y / 2));
}

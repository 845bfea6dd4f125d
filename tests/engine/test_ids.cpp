// Piece ids: the handle of the piece that each pixel shows.
#include <algorithm>

#include "renderer_fixture.h"

using namespace brittle::engine;
using namespace brittle::engine::test;

namespace {

IdImage ids_of(const Fixture& f, const Scene& scene, glm::uvec2 size = small) {
    Result<IdImage> image = f.renderer->render_ids(scene, size);
    REQUIRE_MESSAGE(image, (image ? "" : image.error().message));
    REQUIRE(image->ids.size() == size_t{size.x} * size.y);
    return *std::move(image);
}

} // namespace

TEST_CASE("piece ids: without pieces every pixel is 0, and an empty size is refused") {
    const Fixture f;
    if (!f) return;
    Scene scene = empty_stage();
    scene.ground = true;
    CHECK(std::ranges::count(ids_of(f, scene).ids, 0u) == small.x * small.y);
    CHECK(ids_of(f, scene, {1, 1}).ids.size() == 1);
    CHECK_FALSE(f.renderer->render_ids(scene, {0, 4}));
    CHECK_FALSE(f.renderer->render_ids(scene, {1u << 30, 4}));
    const Shape cube = box(glm::vec3(1.0f));
    const PieceMesh piece = cube.piece(0);
    REQUIRE(f.renderer->set_pieces({&piece, 1}));
    scene.pieces_visible = false;
    CHECK(std::ranges::count(ids_of(f, scene).ids, 0u) == small.x * small.y);
}

TEST_CASE("piece ids: a pixel has an id exactly where the picture shows a piece") {
    for (const uint32_t samples : {1u, 4u}) { // ids have one sample at every quality
        const Fixture f({.shadow_size = 512, .soft_shadows = false, .samples = samples, .ambient_occlusion = false});
        if (!f) return;
        KnownScene known;
        REQUIRE(f.renderer->set_pieces(known.pieces()));
        const IdImage ids = ids_of(f, known.scene);
        std::vector<uint32_t> counts(5);
        for (const uint32_t id : ids.ids) {
            REQUIRE(id <= 4);
            ++counts[id];
        }
        for (const uint32_t count : counts) CHECK(count > 20);

        if (samples > 1) continue;
        known.scene.lines = {};
        known.scene.spheres = {};
        known.scene.ground = false;
        const Bitmap picture = f.draw(known.scene);
        known.scene.pieces_visible = false;
        const Bitmap backdrop = f.draw(known.scene);
        for (uint32_t y = 0; y < small.y; ++y)
            for (uint32_t x = 0; x < small.x; ++x)
                REQUIRE((pixel(picture, x, y) != pixel(backdrop, x, y)) == (ids.at(x, y) != 0));
    }
}

TEST_CASE("piece ids: the nearest piece has the pixel, with exterior or interior face") {
    const Fixture f;
    if (!f) return;
    // A row of pieces away from the camera, and one at the side that shares a body with the first.
    const Shape cube = box(glm::vec3(0.3f), 3);
    Shape beside = cube;
    for (glm::vec3& p : beside.positions) p.x += 1.0f;
    const PieceMesh pieces[] = {cube.piece(0), cube.piece(1), beside.piece(0)};
    REQUIRE(f.renderer->set_pieces(pieces));
    std::vector<BodyPose> poses(2);
    Scene scene = empty_stage();
    scene.write_poses = [&](std::span<BodyPose> out, uint64_t) { std::copy(poses.begin(), poses.end(), out.begin()); };
    const auto middle = [&] { return ids_of(f, scene).at(small.x / 2, small.y / 2); };
    poses[1].position.z = 1.0f;
    CHECK(middle() == 2);
    CHECK(ids_of(f, scene).at(small.x / 2 + 21, small.y / 2) == 3);
    poses[1].position.z = -1.0f;
    CHECK(middle() == 1);
    poses[0].scale = 0.0f;
    CHECK(middle() == 2);
    CHECK(ids_of(f, scene).at(small.x / 2 + 21, small.y / 2) == 0);
}

TEST_CASE("piece ids: render_ids() between two pictures does not change them") {
    const Fixture f;
    if (!f) return;
    KnownScene known;
    REQUIRE(f.renderer->set_pieces(known.pieces()));
    const Bitmap before = f.draw(known.scene);
    known.scene.moved = false;
    (void)ids_of(f, known.scene, {200, 10});
    CHECK(f.draw(known.scene).pixels == before.pixels);
    CHECK_FALSE(f.renderer->stats().shadow_drawn);

    known.poses[3].position.y += 0.3f;
    known.scene.moved = true;
    (void)ids_of(f, known.scene);
    known.scene.moved = false; // nothing moved after render_ids()
    const Bitmap after = f.draw(known.scene);
    CHECK(f.renderer->stats().shadow_drawn);
    known.scene.moved = true;
    CHECK(f.draw(known.scene).pixels == after.pixels);
}

// Clear glass: its tint follows the way of light through it, whatever the order of the pieces.
#include <algorithm>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include "renderer_fixture.h"

using namespace brittle::engine;
using namespace brittle::engine::test;

namespace {

constexpr glm::uvec2 size{96, 96};

double linear_of(uint32_t srgb) {
    const double c = srgb / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

Scene scene_with_glass(const glm::vec3& colour) {
    Scene scene = empty_stage();
    scene.materials = true;
    scene.look.grain = Grain::glass;
    scene.look.exterior = colour;
    scene.look.background_top = scene.look.background_bottom = glm::vec3(0.5f);
    return scene;
}

Shape slab(float thickness) {
    return box({0.8f, 0.8f, 0.5f * thickness});
}

PieceMesh at(const Shape& shape, uint32_t body) {
    return shape.piece(body);
}

void place(Scene& scene, std::vector<glm::vec3> places) {
    scene.write_poses = [places = std::move(places)](std::span<BodyPose> poses, uint64_t) {
        for (size_t k = 0; k < poses.size(); ++k) poses[k] = {.position = places[k]};
    };
}

int difference(const Bitmap& a, const Bitmap& b, uint32_t x, uint32_t y) {
    int largest = 0;
    for (int k = 0; k < 3; ++k) largest = std::max(largest, std::abs(a.at(x, y)[k] - b.at(x, y)[k]));
    return largest;
}

int largest_difference(const Bitmap& a, const Bitmap& b) {
    return compare_bitmaps(a, b, {.ignore = 0, .channel = 255, .fraction = 1.0}).largest;
}

} // namespace

TEST_CASE("glass: light that passes it falls off with the way, by the law of Beer and Lambert") {
    const Fixture f;
    if (!f) return;
    const glm::vec3 colour(0.4f, 0.8f, 0.6f);
    const Scene white = scene_with_glass(glm::vec3(1.0f)), tinted = scene_with_glass(colour);
    for (const float thickness : {0.05f, 0.5f, 1.2f}) {
        CAPTURE(thickness);
        const Shape shape = slab(thickness);
        REQUIRE(f.renderer->set_pieces({{at(shape, 0)}}));
        const Bitmap clear = f.draw(white, size), picture = f.draw(tinted, size);
        for (uint32_t k = 0; k < 3; ++k) {
            // What is seen through white glass is the background, dimmed, and a reflection, the same in all channels.
            const double behind = linear_of(clear.at(2, 2)[k]), seen = linear_of(clear.at(48, 48)[k]);
            const double reflected = (seen - behind) / (1.0 - 0.6 * behind);
            CHECK(reflected > 0.0);
            const double passed = std::pow(static_cast<double>(colour[static_cast<int>(k)]), thickness / 0.5);
            const double expected = behind * passed * (1.0 - 0.6 * reflected) + reflected;
            CHECK(linear_of(picture.at(48, 48)[k]) == doctest::Approx(expected).epsilon(0.02));
        }
        CHECK(difference(clear, picture, 2, 2) == 0);
    }
}

TEST_CASE("glass: the order of the pieces changes nothing, with one sample and with four") {
    for (const uint32_t samples : {1u, 4u}) {
        Quality quality = plain_quality;
        quality.samples = samples;
        const Fixture f(quality);
        if (!f) return;
        Scene scene = scene_with_glass({0.5f, 0.8f, 0.7f});
        const Shape thin = slab(0.05f), thick = box({0.3f, 0.5f, 0.1f});
        place(scene, {{0.2f, 0.0f, 0.4f}, {-0.1f, 0.1f, -0.3f}});
        REQUIRE(f.renderer->set_pieces({{at(thin, 0), at(thick, 1)}}));
        const Bitmap one = f.draw(scene, size);
        REQUIRE(f.renderer->set_pieces({{at(thick, 1), at(thin, 0)}}));
        const Bitmap other = f.draw(scene, size);
        // Half precision rounds sums by their order.
        CHECK(largest_difference(one, other) <= 1);
        CHECK(difference(one, f.draw(scene_with_glass(glm::vec3(1.0f)), size), 48, 48) > 8);
    }
}

TEST_CASE("glass: what lies before it hides it, and what lies behind it shows through") {
    const Fixture f;
    if (!f) return;
    const Shape glass = slab(0.1f), block = box({0.4f, 0.4f, 0.1f});
    Scene scene = scene_with_glass({0.5f, 0.9f, 0.8f});
    // The block has a surface of its own, of stone.
    const SurfaceLook stone{.exterior = {0.7f, 0.2f, 0.1f}, .tint = 0.0f, .grain = Grain::stone};
    scene.surfaces = {&stone, 1};
    const auto draw = [&](float of_block, bool with_glass) {
        REQUIRE(f.renderer->set_pieces({}));
        const PieceMesh meshes[] = {at(glass, 0), at(block, 1)};
        Result<PieceBatch> batch = PieceBatch::create(meshes);
        REQUIRE(batch);
        const Result<std::vector<PieceHandle>> added = f.renderer->add_pieces(*std::move(batch));
        REQUIRE(added);
        REQUIRE(f.renderer->attach_pieces({&(*added)[1], 1}, {.body = 1, .surface = 1}));
        place(scene, {{0.0f, with_glass ? 0.0f : 50.0f, 0.0f}, {0.0f, 0.0f, of_block}});
        return f.draw(scene, size);
    };
    const Bitmap before = draw(1.0f, true), behind = draw(-1.0f, true);
    const Bitmap before_alone = draw(1.0f, false), behind_alone = draw(-1.0f, false);
    CHECK(difference(before, before_alone, 48, 48) <= 1);
    CHECK(difference(behind, behind_alone, 48, 48) > 8);
    // Red stone stays red behind glass.
    CHECK(behind.at(48, 48)[0] > behind.at(48, 48)[2] + 20);
}

TEST_CASE("glass: without the view of materials, and with materials of the mesh, it is drawn as before") {
    const Fixture f;
    if (!f) return;
    const Shape glass = slab(0.1f);
    REQUIRE(f.renderer->set_pieces({{at(glass, 0)}}));
    Scene scene = scene_with_glass({0.5f, 0.9f, 0.8f});
    scene.materials = false;
    Scene stone = scene;
    stone.look.grain = Grain::stone;
    CHECK(largest_difference(f.draw(scene, size), f.draw(stone, size)) == 0);
}

TEST_CASE("glass: a region of the picture has the pixels of the whole picture") {
    const Fixture f;
    if (!f) return;
    const Shape ball = icosphere(0.8f, 3);
    REQUIRE(f.renderer->set_pieces({{at(ball, 0)}}));
    Scene scene = scene_with_glass({0.5f, 0.8f, 0.7f});
    scene.ground = true;
    scene.ground_height = -0.8f;
    const Bitmap whole = f.draw(scene, size);
    scene.region = {{0.3f, 0.25f}, {0.7f, 0.75f}};
    const Bitmap part = f.draw(scene, size);
    for (uint32_t y = 24; y < 72; ++y)
        for (uint32_t x = 29; x < 67; ++x) REQUIRE(difference(whole, part, x, y) == 0);
}

TEST_CASE("glass: its shadow is fainter than that of stone") {
    const Fixture f(Quality{.shadow_size = 512, .soft_shadows = true, .samples = 1, .ambient_occlusion = false});
    if (!f) return;
    const Shape cube = box(glm::vec3(0.4f));
    REQUIRE(f.renderer->set_pieces({{at(cube, 0)}}));
    Scene scene = scene_with_glass({0.9f, 0.95f, 0.95f});
    scene.camera = {{0.0f, 4.0f, 2.0f}, {0.0f, -0.4f, 0.0f}, 0.6f};
    scene.ground = true;
    scene.ground_height = -0.4f;
    scene.look.to_light = {-1.0f, 1.0f, 0.0f};
    const auto darkest = [&](Grain grain) {
        scene.look.grain = grain;
        const Bitmap picture = f.draw(scene, size);
        int least = 255;
        for (uint32_t x = 62; x < 72; ++x) least = std::min(least, int{picture.at(x, 48)[1]});
        return least;
    };
    const int glass = darkest(Grain::glass), stone = darkest(Grain::stone);
    scene.pieces_visible = false;
    const int open = darkest(Grain::stone);
    CAPTURE(glass);
    CAPTURE(stone);
    CAPTURE(open);
    CHECK(glass > stone + (open - stone) / 3);
    CHECK(glass < open);
}

TEST_CASE("glass: fading pieces, no pieces, and pieces of no size") {
    const Fixture f;
    if (!f) return;
    Scene scene = scene_with_glass({0.5f, 0.8f, 0.7f});
    REQUIRE(f.renderer->set_pieces({}));
    (void)f.draw(scene, size);
    const Shape glass = slab(0.1f), point = box(glm::vec3(0.0f));
    REQUIRE(f.renderer->set_pieces({{at(glass, 0), at(point, 1)}}));
    place(scene, {glm::vec3(0.0f), glm::vec3(0.5f)});
    const Bitmap solid = f.draw(scene, size);
    scene.pieces_visible = false;
    const Bitmap none = f.draw(scene, size);
    CHECK(difference(solid, none, 48, 48) > 8);
    scene.pieces_visible = true;
    const PieceMesh mesh = at(glass, 0);
    REQUIRE(f.renderer->set_pieces({}));
    Result<PieceBatch> batch = PieceBatch::create({&mesh, 1});
    REQUIRE(batch);
    const Result<std::vector<PieceHandle>> added = f.renderer->add_pieces(*std::move(batch));
    REQUIRE(added);
    REQUIRE(f.renderer->fade_pieces(*added, 1.0f));
    CHECK(largest_difference(f.draw(scene, size), none) == 0);
    REQUIRE(f.renderer->fade_pieces(*added, 0.5f));
    const Bitmap half = f.draw(scene, size);
    CHECK(largest_difference(half, none) > 8);
    CHECK(largest_difference(half, solid) > 8);
}

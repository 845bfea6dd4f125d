// Dust and splinters: what hides them, what they hide, and that their order does not matter.
#include <algorithm>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include "renderer_fixture.h"

using namespace brittle::engine;
using namespace brittle::engine::test;

namespace {

constexpr glm::uvec2 size{96, 96};

int difference(const Bitmap& a, const Bitmap& b, uint32_t x, uint32_t y) {
    int largest = 0;
    for (int k = 0; k < 3; ++k) largest = std::max(largest, std::abs(a.at(x, y)[k] - b.at(x, y)[k]));
    return largest;
}

int largest_difference(const Bitmap& a, const Bitmap& b) {
    return compare_bitmaps(a, b, {.ignore = 0, .channel = 255, .fraction = 1.0}).largest;
}

// The mean of the pixels within a radius of the middle, in channel 0.
double mean_of_middle(const Bitmap& picture, int radius) {
    double sum = 0.0, count = 0.0;
    for (int y = -radius; y <= radius; ++y)
        for (int x = -radius; x <= radius; ++x) {
            if (x * x + y * y > radius * radius) continue;
            sum += picture.at(static_cast<uint32_t>(48 + x), static_cast<uint32_t>(48 + y))[0];
            ++count;
        }
    return sum / count;
}

constexpr DustPuff black_puff{
    .centre = {0.0f, 0.0f, 0.0f}, .radius = 0.8f, .colour = glm::vec3(0.0f), .opacity = 0.9f, .pattern = 7};

} // namespace

TEST_CASE("particles: black dust darkens what is behind it, most in its middle, and nothing beside it") {
    const Fixture f;
    if (!f) return;
    Scene scene = empty_stage();
    const Bitmap without = f.draw(scene, size);
    scene.dust = {&black_puff, 1};
    const Bitmap with = f.draw(scene, size);
    for (uint32_t y = 0; y < size.y; ++y)
        for (uint32_t x = 0; x < size.x; ++x)
            for (int k = 0; k < 3; ++k) REQUIRE(with.at(x, y)[k] <= without.at(x, y)[k]);
    CHECK(mean_of_middle(with, 8) < 0.75 * mean_of_middle(without, 8));
    CHECK(mean_of_middle(with, 8) < mean_of_middle(with, 20));
    // The ball's radius is 0.8 m at 5 m, and the picture 2 * 5 * tan(0.3) m high: 25 pixels.
    CHECK(difference(with, without, 48 + 28, 48) == 0);
    CHECK(difference(with, without, 48, 48 - 28) == 0);
    DustPuff clear = black_puff;
    clear.opacity = 0.0f;
    scene.dust = {&clear, 1};
    CHECK(largest_difference(f.draw(scene, size), without) == 0);
}

TEST_CASE("particles: a piece hides dust behind it, and less the less of it is behind") {
    for (const uint32_t samples : {1u, 4u}) {
        CAPTURE(samples);
        Quality quality = plain_quality;
        quality.samples = samples;
        const Fixture f(quality);
        if (!f) return;
        const Shape wall = box({1.2f, 1.2f, 0.1f});
        REQUIRE(f.renderer->set_pieces({{wall.piece(0)}}));
        Scene scene = empty_stage();
        const double without = mean_of_middle(f.draw(scene, size), 6);
        double last = without;
        for (const float z : {-1.0f, -0.4f, 0.1f, 0.5f, 0.95f}) {
            DustPuff puff = black_puff;
            puff.centre.z = z;
            scene.dust = {&puff, 1};
            const Bitmap picture = f.draw(scene, size);
            const double now = mean_of_middle(picture, 6);
            if (z == -1.0f)
                CHECK(now == without);
            else
                CHECK(now < last - 1.0);
            last = now;
        }
    }
}

TEST_CASE("particles: one sample a pixel and four show the same dust") {
    Quality quality = plain_quality;
    quality.samples = 4;
    const Fixture one, four(quality);
    if (!one) return;
    Scene scene = empty_stage();
    scene.dust = {&black_puff, 1};
    CHECK(largest_difference(one.draw(scene, size), four.draw(scene, size)) <= 1);
}

TEST_CASE("particles: the order of the dust changes nothing") {
    const Fixture f;
    if (!f) return;
    Scene scene = empty_stage();
    std::vector<DustPuff> dust;
    for (int k = 0; k < 6; ++k)
        dust.push_back({.centre = {0.1f * static_cast<float>(k) - 0.3f, 0.05f * static_cast<float>(k % 3),
                                   0.25f * static_cast<float>(k)},
                        .radius = 0.6f,
                        .colour = k % 2 == 0 ? glm::vec3(0.9f, 0.1f, 0.1f) : glm::vec3(0.1f, 0.1f, 0.9f),
                        .opacity = 0.7f,
                        .pattern = static_cast<uint32_t>(k)});
    scene.dust = dust;
    const Bitmap sorted = f.draw(scene, size);
    std::vector<DustPuff> mixed = dust;
    std::swap(mixed[0], mixed[4]);
    std::swap(mixed[1], mixed[5]);
    scene.dust = mixed;
    CHECK(largest_difference(f.draw(scene, size), sorted) == 0);
    // Dust of another place in the order would look different: the nearest puff is the last one.
    mixed = dust;
    std::swap(mixed[0].colour, mixed[5].colour);
    scene.dust = mixed;
    CHECK(difference(f.draw(scene, size), sorted, 48, 48) > 8);
}

TEST_CASE("particles: a region of the picture has the pixels of the whole picture") {
    const Fixture f;
    if (!f) return;
    Scene scene = empty_stage();
    scene.dust = {&black_puff, 1};
    const Splinter splinter{.centre = {0.1f, 0.1f, 1.0f}, .length = 0.3f};
    scene.splinters = {&splinter, 1};
    const Bitmap whole = f.draw(scene, size);
    scene.region = {{0.3f, 0.25f}, {0.7f, 0.75f}};
    const Bitmap part = f.draw(scene, size);
    for (uint32_t y = 24; y < 72; ++y)
        for (uint32_t x = 29; x < 67; ++x) REQUIRE(difference(whole, part, x, y) == 0);
}

TEST_CASE("particles: dust that surrounds the eye, and dust without a size, is not drawn") {
    const Fixture f;
    if (!f) return;
    Scene scene = empty_stage();
    const Bitmap without = f.draw(scene, size);
    DustPuff puffs[] = {black_puff, black_puff, black_puff};
    puffs[0].centre = scene.camera.eye;
    puffs[1].centre = scene.camera.eye + glm::vec3(0.0f, 0.0f, -0.5f);
    puffs[2].radius = 0.0f;
    scene.dust = puffs;
    CHECK(largest_difference(f.draw(scene, size), without) == 0);
}

TEST_CASE("particles: dust lies over glass, and marks on top do not uncover dust behind a piece") {
    const Fixture f;
    if (!f) return;
    const Shape wall = box({1.2f, 1.2f, 0.1f});
    REQUIRE(f.renderer->set_pieces({{wall.piece(0)}}));
    Scene scene = empty_stage();
    scene.materials = true;
    scene.look.grain = Grain::glass;
    scene.dust = {&black_puff, 1};
    DustPuff before = black_puff;
    before.centre.z = 1.0f;
    const Bitmap glass = [&] {
        Scene clear = scene;
        clear.dust = {};
        return f.draw(clear, size);
    }();
    scene.dust = {&before, 1};
    CHECK(mean_of_middle(f.draw(scene, size), 8) < 0.8 * mean_of_middle(glass, 8));

    Scene stone = empty_stage();
    const LineVertex line[] = {{{-1.0f, 0.9f, 0.0f}}, {{1.0f, 0.9f, 0.0f}}};
    stone.lines = line;
    stone.lines_on_top = true;
    const Bitmap without = f.draw(stone, size);
    DustPuff behind = black_puff;
    behind.centre.z = -1.0f;
    stone.dust = {&behind, 1};
    CHECK(largest_difference(f.draw(stone, size), without) == 0);
}

TEST_CASE("particles: a splinter has its colour, hides and is hidden, and casts a shadow") {
    const Fixture f;
    if (!f) return;
    Scene scene = empty_stage();
    scene.ground = true;
    scene.ground_height = -0.5f;
    scene.camera.eye = {0.0f, 2.0f, 4.0f};
    scene.look.to_light = {0.0f, 1.0f, 0.0f};
    const Bitmap without = f.draw(scene, size);
    const Splinter splinter{
        .centre = {0.0f, 0.4f, 0.0f}, .length = 0.5f, .colour = {0.8f, 0.05f, 0.05f}, .width = 0.8f};
    scene.splinters = {&splinter, 1};
    const Bitmap with = f.draw(scene, size);
    size_t red = 0, darker = 0;
    for (uint32_t y = 0; y < size.y; ++y)
        for (uint32_t x = 0; x < size.x; ++x) {
            const auto *a = with.at(x, y), *b = without.at(x, y);
            const bool is_red = a[0] > a[2] + 40;
            red += is_red;
            darker += !is_red && a[0] + 20 < b[0];
        }
    CHECK(red > 60);
    CHECK(darker > 40); // its shadow on the ground
    const Shape wall = box({1.2f, 1.2f, 0.1f});
    REQUIRE(f.renderer->set_pieces({{wall.piece(0)}}));
    scene.write_poses = [](std::span<BodyPose> poses, uint64_t) { poses[0] = {.position = {0.0f, 0.4f, 1.5f}}; };
    const Bitmap hidden = f.draw(scene, size);
    CHECK(hidden.at(48, 44)[0] < hidden.at(48, 44)[2] + 40);
}

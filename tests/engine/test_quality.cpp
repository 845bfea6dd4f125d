// What Quality changes in a picture, and what it must not.
#include <cmath>
#include <set>

#include "renderer_fixture.h"

using namespace brittle::engine;
using namespace brittle::engine::test;

namespace {

constexpr Quality plain{.shadow_size = 512, .soft_shadows = false, .samples = 1, .ambient_occlusion = false};
constexpr Quality shaded_gaps{
    .shadow_size = 512, .soft_shadows = false, .samples = 1, .ambient_occlusion = true};
constexpr Quality smooth_edges{
    .shadow_size = 512, .soft_shadows = false, .samples = 4, .ambient_occlusion = false};

// Each pixel the mean of `factor` squared.
Bitmap shrunk(const Bitmap& large, uint32_t factor) {
    Bitmap small_one{large.width / factor, large.height / factor, {}};
    for (uint32_t y = 0; y < small_one.height; ++y)
        for (uint32_t x = 0; x < small_one.width; ++x)
            for (int channel = 0; channel < 4; ++channel) {
                uint32_t sum = 0;
                for (uint32_t j = 0; j < factor; ++j)
                    for (uint32_t i = 0; i < factor; ++i)
                        sum += large.at(x * factor + i, y * factor + j)[channel];
                small_one.pixels.push_back(static_cast<uint8_t>(sum / (factor * factor)));
            }
    return small_one;
}

double mean_difference(const Bitmap& a, const Bitmap& b) {
    REQUIRE(a.pixels.size() == b.pixels.size());
    double sum = 0.0;
    for (size_t i = 0; i < a.pixels.size(); ++i) sum += std::abs(int{a.pixels[i]} - int{b.pixels[i]});
    return sum / static_cast<double>(a.pixels.size());
}

} // namespace

TEST_CASE("quality is chosen by the device where it is left open") {
    const Fixture open(Quality{});
    if (!open) return;
    const Quality& chosen = open.renderer->quality();
    const bool cpu = open.device->is_cpu();
    CHECK(chosen.shadow_size == (cpu ? 1024u : 2048u));
    CHECK(chosen.soft_shadows == !cpu);
    CHECK(chosen.samples == (cpu ? 1u : 4u));
    CHECK(chosen.ambient_occlusion == !cpu);
    const Fixture given(smooth_edges);
    CHECK(given.renderer->quality().samples == 4u);
    CHECK(given.renderer->quality().shadow_size == 512u);
}

TEST_CASE("samples that not every device has are refused") {
    const std::unique_ptr<Device> device = make_device();
    if (!device) return;
    for (const uint32_t samples : {0u, 2u, 3u, 8u, 64u}) {
        const Result<std::unique_ptr<Renderer>> made =
            Renderer::create(*device, {.quality = {.samples = samples}});
        REQUIRE_FALSE(made);
        CHECK(made.error().status == Status::invalid_argument);
    }
}

TEST_CASE("four samples a pixel come nearer to a picture of 64") {
    const Fixture one(plain), four(smooth_edges);
    if (!one) return;
    KnownScene known;
    known.scene.lines = {}; // a pixel wide at any size
    REQUIRE(one.renderer->set_pieces(known.pieces()));
    REQUIRE(four.renderer->set_pieces(known.pieces()));
    const Bitmap reference = shrunk(one.draw(known.scene, 8u * small), 8);
    const double rough = mean_difference(one.draw(known.scene), reference);
    const double fine = mean_difference(four.draw(known.scene), reference);
    CHECK(rough > 0.1);
    CHECK(fine < 0.7 * rough);
}

TEST_CASE("samples are resolved whichever pass is the last to draw") {
    const Fixture one(plain), four(smooth_edges);
    if (!one) return;
    KnownScene known;
    REQUIRE(one.renderer->set_pieces(known.pieces()));
    REQUIRE(four.renderer->set_pieces(known.pieces()));
    const std::vector<LineVertex> lines = known.lines;
    for (const bool has_lines : {false, true})
        for (const bool has_spheres : {false, true})
            for (const bool on_top : {false, true}) {
                known.scene.lines = has_lines ? std::span(lines) : std::span<const LineVertex>();
                known.scene.spheres = has_spheres ? std::span(known.spheres) : std::span<Sphere>();
                known.scene.lines_on_top = on_top;
                known.scene.spheres_on_top = !on_top;
                const Bitmap a = one.draw(known.scene), b = four.draw(known.scene);
                CAPTURE(has_lines);
                CAPTURE(has_spheres);
                CHECK(mean_difference(a, b) > 0.0);
                CHECK(mean_difference(a, b) < 6.0);
            }
    CHECK(four.draw(known.scene).pixels == four.draw(known.scene).pixels);
}

TEST_CASE("ambient occlusion darkens the ground at a box's foot, and nothing in the open") {
    const Fixture off(plain), on(shaded_gaps);
    if (!off) return;
    const Shape cube = box(glm::vec3(0.5f));
    const PieceMesh piece = cube.piece(0);
    Scene scene{.camera = {{0.0f, 1.5f, 5.0f}, {0.0f, 0.3f, 0.0f}, 0.6f},
                .bounds = {{-0.5f, 0.0f, -0.5f}, {0.5f, 1.0f, 0.5f}}};
    scene.write_poses = [](std::span<BodyPose> poses, uint64_t) { poses[0].position = {0.0f, 0.5f, 0.0f}; };
    REQUIRE(off.renderer->set_pieces({&piece, 1}));
    REQUIRE(on.renderer->set_pieces({&piece, 1}));
    const glm::uvec2 size{192, 128};
    const Bitmap without = off.draw(scene, size), with = on.draw(scene, size);
    const auto darker = [&](uint32_t x, uint32_t y) {
        return int{without.at(x, y)[1]} - int{with.at(x, y)[1]};
    };
    // Down the middle column: sky, the box, its foot, the ground before it.
    uint32_t foot = size.y - 1;
    int most = 0;
    for (uint32_t y = size.y / 2; y < size.y; ++y)
        if (darker(size.x / 2, y) > most) {
            most = darker(size.x / 2, y);
            foot = y;
        }
    CHECK(most >= 8);
    CHECK(foot > size.y / 2);
    CHECK(foot < size.y - 20);
    CHECK(darker(size.x / 2, 2) == 0);
    CHECK(std::abs(darker(size.x / 2, size.y - 2)) <= 2); // far in front of the box
    CHECK(std::abs(darker(8, size.y / 2 + 10)) <= 2);     // far beside it
    CHECK(on.draw(scene, size).pixels == with.pixels);
    scene.ground = false;
    scene.pieces_visible = false;
    CHECK(on.draw(scene, size).pixels == off.draw(scene, size).pixels);
}

TEST_CASE("exposure multiplies light") {
    const Fixture f;
    if (!f) return;
    KnownScene known;
    REQUIRE(f.renderer->set_pieces(known.pieces()));
    double before = 0.0;
    for (const float exposure : {0.0f, 0.5f, 1.0f, 2.0f}) {
        known.scene.look.exposure = exposure;
        const Bitmap image = f.draw(known.scene);
        double sum = 0.0;
        for (const uint8_t value : image.pixels) sum += value;
        CHECK(sum > before);
        before = sum;
    }
}

TEST_CASE("the shadow map covers everything within the bounds") {
    const Fixture f;
    if (!f) return;
    // Two boxes at opposite ends of a long scene, seen from above; each must have its shadow at its side.
    const Shape cube = box(glm::vec3(0.5f));
    const PieceMesh pieces[] = {cube.piece(0), cube.piece(1)};
    REQUIRE(f.renderer->set_pieces(pieces));
    Scene scene{.camera = {{0.0f, 40.0f, 0.01f}, {0.0f, 0.0f, 0.0f}, 0.6f},
                .bounds = {{-10.5f, 0.0f, -0.5f}, {10.5f, 1.0f, 0.5f}}};
    scene.write_poses = [](std::span<BodyPose> poses, uint64_t) {
        poses[0].position = {-10.0f, 0.5f, 0.0f};
        poses[1].position = {10.0f, 0.5f, 0.0f};
    };
    scene.look.to_light = {-1.0f, 1.0f, 0.0f}; // a metre of shadow on the right of each
    const glm::uvec2 size{256, 128};
    const Bitmap image = f.draw(scene, size);
    // 40 m up, 0.6 rad: 128 pixels are 24.7 m.
    const auto column = [&](float x) { return static_cast<uint32_t>(128.0f + x * 128.0f / 24.75f); };
    const uint8_t lit = image.at(column(0.0f), 64)[1];
    CHECK(image.at(column(-9.0f), 64)[1] < lit - 20);
    CHECK(image.at(column(11.0f), 64)[1] < lit - 20);
    CHECK(image.at(column(-11.2f), 64)[1] == lit);
}

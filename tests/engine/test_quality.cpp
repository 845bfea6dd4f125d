// The effect of Quality and of Scene::region on pictures.
#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer_fixture.h"

using namespace brittle::engine;
using namespace brittle::engine::test;

namespace {

constexpr Quality plain{.shadow_size = 512, .soft_shadows = false, .samples = 1, .ambient_occlusion = false};
constexpr Quality shaded_gaps{.shadow_size = 512, .soft_shadows = false, .samples = 1, .ambient_occlusion = true};
constexpr Quality smooth_edges{.shadow_size = 512, .soft_shadows = false, .samples = 4, .ambient_occlusion = false};

// Returns the picture reduced by `factor`: each pixel is the mean of factor x factor pixels.
Bitmap shrunk(const Bitmap& large, uint32_t factor) {
    Bitmap small_one{large.width / factor, large.height / factor, {}};
    for (uint32_t y = 0; y < small_one.height; ++y)
        for (uint32_t x = 0; x < small_one.width; ++x)
            for (int channel = 0; channel < 4; ++channel) {
                uint32_t sum = 0;
                for (uint32_t j = 0; j < factor; ++j)
                    for (uint32_t i = 0; i < factor; ++i) sum += large.at(x * factor + i, y * factor + j)[channel];
                small_one.pixels.push_back(static_cast<uint8_t>(sum / (factor * factor)));
            }
    return small_one;
}

// Returns the picture doubled by bilinear interpolation: the centres of the four nearest pixels of `from` lie 1/4 or
// 3/4 of a pixel away.
Bitmap doubled(const Bitmap& from) {
    Bitmap large{2 * from.width, 2 * from.height, {}};
    const auto near = [](uint32_t at, uint32_t size) { return std::min(at / 2, size - 1); };
    const auto far = [](uint32_t at, uint32_t size) {
        return at % 2 == 0 ? (at == 0 ? 0 : at / 2 - 1) : std::min(at / 2 + 1, size - 1);
    };
    for (uint32_t y = 0; y < large.height; ++y)
        for (uint32_t x = 0; x < large.width; ++x)
            for (int channel = 0; channel < 4; ++channel) {
                const auto row = [&](uint32_t v) {
                    return 0.75 * from.at(near(x, from.width), v)[channel]
                           + 0.25 * from.at(far(x, from.width), v)[channel];
                };
                const double value = 0.75 * row(near(y, from.height)) + 0.25 * row(far(y, from.height));
                large.pixels.push_back(static_cast<uint8_t>(std::lround(value)));
            }
    return large;
}

int largest_difference(const Bitmap& a, const Bitmap& b) {
    REQUIRE(a.pixels.size() == b.pixels.size());
    int most = 0;
    for (size_t i = 0; i < a.pixels.size(); ++i) most = std::max(most, std::abs(int{a.pixels[i]} - int{b.pixels[i]}));
    return most;
}

Quality with_scale(float scale, uint32_t shadow_size = 512) {
    Quality quality = plain;
    quality.shadow_size = shadow_size;
    quality.moving_scale = scale;
    return quality;
}

Bitmap presented(const Fixture& f, const Scene& scene, glm::uvec2 size = small) {
    Result<Bitmap> image = f.renderer->render_as_presented(scene, size);
    REQUIRE(image);
    REQUIRE(image->width == size.x);
    REQUIRE(image->height == size.y);
    return *std::move(image);
}

double mean_difference(const Bitmap& a, const Bitmap& b) {
    REQUIRE(a.pixels.size() == b.pixels.size());
    double sum = 0.0;
    for (size_t i = 0; i < a.pixels.size(); ++i) sum += std::abs(int{a.pixels[i]} - int{b.pixels[i]});
    return sum / static_cast<double>(a.pixels.size());
}

} // namespace

TEST_CASE("unset members of Quality are chosen for the device") {
    const Fixture open(Quality{});
    if (!open) return;
    const Quality& chosen = open.renderer->quality();
    const bool cpu = open.device->is_cpu();
    CHECK(chosen.shadow_size == (cpu ? 1024u : 2048u));
    CHECK(chosen.soft_shadows == !cpu);
    CHECK(chosen.samples == (cpu ? 1u : 4u));
    CHECK(chosen.ambient_occlusion == !cpu);
    CHECK(chosen.moving_scale == (cpu ? 0.5f : 1.0f));
    const Fixture given(smooth_edges);
    CHECK(given.renderer->quality().samples == 4u);
    CHECK(given.renderer->quality().shadow_size == 512u);
}

TEST_CASE("numbers of samples other than 1 and 4 are refused") {
    const std::unique_ptr<Device> device = make_device();
    if (!device) return;
    for (const uint32_t samples : {0u, 2u, 3u, 8u, 64u}) {
        const Result<std::unique_ptr<Renderer>> made = Renderer::create(*device, {.quality = {.samples = samples}});
        REQUIRE_FALSE(made);
        CHECK(made.error().status == Status::invalid_argument);
    }
}

TEST_CASE("a moving_scale out of range is refused") {
    const std::unique_ptr<Device> device = make_device();
    if (!device) return;
    for (const float scale :
         {0.0f, 0.2f, 1.01f, -0.5f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        const Result<std::unique_ptr<Renderer>> made = Renderer::create(*device, {.quality = {.moving_scale = scale}});
        REQUIRE_FALSE(made);
        CHECK(made.error().status == Status::invalid_argument);
    }
}

TEST_CASE("pixels inside Scene::region equal those of the whole picture, at every quality and scale") {
    Quality best = smooth_edges;
    best.ambient_occlusion = true;
    best.soft_shadows = true;
    const std::vector<LineVertex> lines{{{-1.0f, 0.1f, 0.0f}, srgb8(255, 0, 0)},
                                        {{1.0f, 0.9f, 0.3f}, srgb8(255, 0, 0)}};
    for (const Quality& quality : {with_scale(1.0f), with_scale(0.5f), with_scale(0.7f), best}) {
        const Fixture whole(quality), f(quality);
        if (!f) return;
        KnownScene known;
        REQUIRE(whole.renderer->set_pieces(known.pieces()));
        REQUIRE(f.renderer->set_pieces(known.pieces()));
        known.scene.lines = lines;
        for (const glm::uvec2 size : {glm::uvec2(1), small, glm::uvec2(95, 63)})
            for (const bool moved : {true, false}) {
                known.scene.moved = moved;
                known.scene.region = {};
                const Bitmap expected = presented(whole, known.scene, size);
                for (const Region& region : {Region{{0.21f, 0.1f}, {0.8f, 0.93f}}, Region{{0.0f, 0.5f}, {0.5f, 1.0f}},
                                             Region{{-1.0f, -1.0f}, {2.0f, 2.0f}}, Region{{0.5f, 0.5f}, {0.5f, 0.5f}},
                                             Region{{0.9f, 0.9f}, {0.1f, 0.1f}}}) {
                    known.scene.region = region;
                    const Bitmap part = presented(f, known.scene, size);
                    const glm::vec2 low = glm::max(glm::floor(region.min * glm::vec2(size)), 0.0f);
                    const glm::vec2 high = glm::min(glm::ceil(region.max * glm::vec2(size)), glm::vec2(size));
                    int differ = 0;
                    for (auto y = static_cast<uint32_t>(low.y); static_cast<float>(y) < high.y; ++y)
                        for (auto x = static_cast<uint32_t>(low.x); static_cast<float>(x) < high.x; ++x) {
                            const size_t at = 4 * (size_t{y} * size.x + x);
                            differ += !std::equal(&part.pixels[at], &part.pixels[at] + 4, &expected.pixels[at]);
                        }
                    CHECK(differ == 0);
                }
            }
    }
}

TEST_CASE("a scene at rest is presented in full resolution, at any size and after any frame") {
    for (const float scale : {0.25f, 0.5f, 0.7f, 1.0f}) {
        const Fixture full(with_scale(1.0f)), f(with_scale(scale));
        if (!f) return;
        KnownScene known;
        REQUIRE(full.renderer->set_pieces(known.pieces()));
        REQUIRE(f.renderer->set_pieces(known.pieces()));
        CAPTURE(scale);
        for (const glm::uvec2 size : {glm::uvec2(1), glm::uvec2(1, 33), small, glm::uvec2(95, 63)}) {
            known.scene.moved = true;
            const Bitmap expected = full.draw(known.scene, size);
            (void)presented(f, known.scene, size); // its coarse shadow map must not be reused
            known.scene.moved = false;
            CHECK(presented(f, known.scene, size).pixels == expected.pixels);
            CHECK(f.renderer->stats().scale == 1.0f);
            known.scene.moved = true;
            CHECK(f.draw(known.scene, size).pixels == expected.pixels); // render() never upscales
            CHECK(f.renderer->stats().scale == 1.0f);
        }
    }
}

TEST_CASE("at a moving_scale of 0.5, a moving scene is the picture of half the size, upscaled") {
    const Fixture half(with_scale(1.0f, 256)), f(with_scale(0.5f));
    if (!f) return;
    KnownScene known;
    REQUIRE(half.renderer->set_pieces(known.pieces()));
    REQUIRE(f.renderer->set_pieces(known.pieces()));
    for (const glm::uvec2 size : {small, glm::uvec2(2, 64), glm::uvec2(322, 182)}) {
        const Bitmap expected = doubled(half.draw(known.scene, size / 2u));
        const Bitmap image = presented(f, known.scene, size);
        CHECK(f.renderer->stats().scale == 0.5f);
        CHECK(largest_difference(image, expected) <= 1); // the device rounds its interpolation weights
        CHECK(presented(f, known.scene, size).pixels == image.pixels);
    }
}

TEST_CASE("an upscaled picture is near the full one, at odd sizes and with samples and occlusion") {
    for (const bool costly : {false, true})
        for (const float scale : {0.5f, 0.7f}) {
            Quality quality = with_scale(scale);
            quality.samples = costly ? 4 : 1;
            quality.ambient_occlusion = costly;
            const Fixture f(quality);
            if (!f) return;
            KnownScene known;
            REQUIRE(f.renderer->set_pieces(known.pieces()));
            for (const glm::uvec2 size : {glm::uvec2(95, 63), glm::uvec2(191, 128), glm::uvec2(192, 127)}) {
                CAPTURE(size.x);
                const double difference = mean_difference(presented(f, known.scene, size), f.draw(known.scene, size));
                CHECK(difference > 0.0);
                CHECK(difference < 6.0); // of 255, on average
            }
            for (const glm::uvec2 size : {glm::uvec2(1), glm::uvec2(1, 33), glm::uvec2(3, 2)})
                (void)presented(f, known.scene, size);
        }
}

TEST_CASE("four samples a pixel approach the picture of 64 samples") {
    const Fixture one(plain), four(smooth_edges);
    if (!one) return;
    KnownScene known;
    known.scene.lines = {}; // lines are one pixel wide at any size
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

TEST_CASE("ambient occlusion darkens the ground at the foot of a box, and no open ground") {
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
    const auto darker = [&](uint32_t x, uint32_t y) { return int{without.at(x, y)[1]} - int{with.at(x, y)[1]}; };
    // Down the middle column: background, the box, its foot, the ground in front of it.
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

TEST_CASE("the shadow map covers all casters within the bounds") {
    const Fixture f;
    if (!f) return;
    // Two boxes at opposite ends of a long scene, seen from above; each must have its shadow beside it.
    const Shape cube = box(glm::vec3(0.5f));
    const PieceMesh pieces[] = {cube.piece(0), cube.piece(1)};
    REQUIRE(f.renderer->set_pieces(pieces));
    Scene scene{.camera = {{0.0f, 40.0f, 0.01f}, {0.0f, 0.0f, 0.0f}, 0.6f},
                .bounds = {{-10.5f, 0.0f, -0.5f}, {10.5f, 1.0f, 0.5f}}};
    scene.write_poses = [](std::span<BodyPose> poses, uint64_t) {
        poses[0].position = {-10.0f, 0.5f, 0.0f};
        poses[1].position = {10.0f, 0.5f, 0.0f};
    };
    scene.look.to_light = {-1.0f, 1.0f, 0.0f}; // each box casts one metre of shadow to the right
    const glm::uvec2 size{256, 128};
    const Bitmap image = f.draw(scene, size);
    // 40 m up, 0.6 rad: 128 pixels are 24.7 m.
    const auto column = [&](float x) { return static_cast<uint32_t>(128.0f + x * 128.0f / 24.75f); };
    const uint8_t lit = image.at(column(0.0f), 64)[1];
    CHECK(image.at(column(-9.0f), 64)[1] < lit - 20);
    CHECK(image.at(column(11.0f), 64)[1] < lit - 20);
    CHECK(image.at(column(-11.2f), 64)[1] == lit);
}

// What Quality changes in a picture, and what it must not.
#include <cmath>
#include <set>

#include "renderer_fixture.h"

using namespace brittle::engine;
using namespace brittle::engine::test;

namespace {

constexpr Quality plain{.shadow_size = 512, .soft_shadows = false, .samples = 1};
constexpr Quality smooth_edges{.shadow_size = 512, .soft_shadows = false, .samples = 4};

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

// Dust and splinters of breaks: they stay above the ground and within their number, end, and move nothing.
#include <algorithm>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "tests/engine/support.h"
#include "tests/tools/scenes.h"
#include "tools/brittle/base/device_failure.h"
#include "tools/brittle/stage/particles.h"
#include "tools/brittle/stage/stage.h"

using namespace brittle;
using namespace brittle::tools;
using namespace brittle::tools::test;

namespace {

constexpr float step = 1.0f / 120.0f;

struct Drawn {
    std::vector<engine::Splinter> splinters;
    std::vector<engine::DustPuff> dust;

    explicit Drawn(const Particles& particles, float alpha = 1.0f) { particles.draw(alpha, splinters, dust); }
};

bool is_finite(const glm::vec3& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

// A picture of a run after some frames, and what the run came to.
struct Shown {
    engine::Bitmap picture;
    uint64_t state = 0;
    size_t splinters = 0, puffs = 0; // the most in any frame
};

Shown show(engine::Renderer& renderer, const std::string& name, float dust, uint32_t frames) {
    const FractureOptions options = recipe_of(name);
    const Input input = placed_on_stage(load_input(options), options.world);
    Stage stage(renderer, input.model.mesh, options.material);
    stage.dust(dust);
    const Broken broken = break_input(input, options);
    const WorldOptions world = world_of(options, input.scale);
    stage.stand(broken.fragments, world);
    Shown shown;
    for (uint32_t frame = 0; frame < frames; ++frame) {
        stage.advance(1.0 / 60.0);
        const engine::Scene scene = stage.scene();
        shown.splinters = std::max(shown.splinters, scene.splinters.size());
        shown.puffs = std::max(shown.puffs, scene.dust.size());
        for (const engine::Splinter& one : scene.splinters) REQUIRE(is_finite(one.centre));
        for (const engine::DustPuff& one : scene.dust) REQUIRE(is_finite(one.centre));
    }
    engine::Scene scene = stage.scene();
    scene.camera = engine::look_at_bounds(stage.home_bounds(), 0.6f, 0.3f, 1.0f);
    shown.picture = must(renderer.render(scene, {160, 120}));
    shown.state = stage.simulation().state_hash();
    return shown;
}

} // namespace

TEST_CASE("particles: they stay above the ground, stay within their number, and end") {
    Particles particles;
    const Crack crack{
        .at = {0.0f, 0.5f, 0.0f}, .normal = {1.0f, 0.0f, 0.0f}, .velocity = {0.0f, -8.0f, 0.0f}, .area = 0.5f};
    for (uint64_t seed = 0; seed < 2000; ++seed) particles.burst(crack, {}, seed);
    CHECK(particles.splinter_count() <= Particles::max_splinters);
    CHECK(particles.puff_count() <= Particles::max_puffs);
    CHECK(particles.splinter_count() > Particles::max_splinters / 2);
    CHECK(particles.puff_count() > Particles::max_puffs / 2);
    int steps = 0;
    for (; !particles.empty(); ++steps) {
        REQUIRE(steps < 20 * 120);
        particles.step(step);
        const Drawn drawn(particles);
        for (const engine::Splinter& one : drawn.splinters) {
            REQUIRE(is_finite(one.centre));
            REQUIRE(one.centre.y >= 0.0f);
            REQUIRE(std::abs(glm::length(one.rotation) - 1.0f) < 1e-4f);
        }
        for (const engine::DustPuff& one : drawn.dust) {
            REQUIRE(is_finite(one.centre));
            REQUIRE(one.centre.y >= 0.0f);
            REQUIRE(one.opacity >= 0.0f);
            REQUIRE(one.opacity <= 1.0f);
        }
    }
    CHECK(steps > 120);
}

TEST_CASE("particles: a larger crack throws off more, none throws off nothing, and equal cracks equal ones") {
    const auto thrown = [](float area, uint64_t seed) {
        Particles particles;
        particles.burst({.area = area}, {}, seed);
        return particles;
    };
    size_t small = 0, large = 0;
    for (uint64_t seed = 0; seed < 200; ++seed) {
        CHECK(thrown(0.0f, seed).empty());
        CHECK(thrown(-1.0f, seed).empty());
        small += thrown(0.002f, seed).splinter_count();
        large += thrown(0.02f, seed).splinter_count();
    }
    CHECK(large > 7 * small);
    CHECK(large < 13 * small);
    const Particles a = thrown(0.04f, 5), b = thrown(0.04f, 5), c = thrown(0.04f, 6);
    REQUIRE(a.splinter_count() == b.splinter_count());
    const auto first = [](const Particles& particles) { return Drawn(particles).splinters.front().centre; };
    CHECK(first(a) == first(b));
    CHECK(first(a) != first(c));
}

TEST_CASE("particles: between two steps they are drawn between their places") {
    Particles particles;
    particles.burst({.at = {0.0f, 3.0f, 0.0f}, .area = 0.02f}, {}, 1);
    particles.step(step);
    const Drawn before(particles);
    particles.step(step);
    const Drawn from(particles, 0.0f), middle(particles, 0.5f), to(particles);
    REQUIRE(!before.splinters.empty());
    for (size_t k = 0; k < before.splinters.size(); ++k) {
        CHECK(glm::distance(from.splinters[k].centre, before.splinters[k].centre) < 2e-3f);
        const glm::vec3 mean = 0.5f * (from.splinters[k].centre + to.splinters[k].centre);
        CHECK(glm::distance(middle.splinters[k].centre, mean) < 1e-4f);
    }
}

TEST_CASE("particles: bonds and cuts throw them off, the pictures repeat, and no body moves otherwise") {
    const std::unique_ptr<engine::Device> device = engine::test::make_device();
    if (!device) return;
    const std::unique_ptr<engine::Renderer> renderer = must(engine::Renderer::create(*device));
    for (const char* name : {"brick_wall_rammed", "glass_pane_shot_by_a_ball"}) {
        CAPTURE(name);
        const uint32_t frames = 60;
        const Shown none = show(*renderer, name, 0.0f, frames);
        const Shown all = show(*renderer, name, 1.0f, frames);
        const Shown again = show(*renderer, name, 1.0f, frames);
        CHECK(none.splinters == 0);
        CHECK(none.puffs == 0);
        CHECK(all.splinters > 20);
        CHECK(all.state == none.state);
        CHECK(all.picture.pixels != none.picture.pixels);
        CHECK(again.picture.pixels == all.picture.pixels);
        MESSAGE(name, ": ", all.splinters, " splinters, ", all.puffs, " puffs of dust");
    }
}

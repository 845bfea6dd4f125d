// Dust and splinters of breaks: they stay above the ground and obstacles and within their number, end, and move nothing.
#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include <doctest/doctest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "physics/world/world.h"
#include "tests/engine/support.h"
#include "tests/physics/bodies.h"
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

// A level plate of no end, seen from above: it rises at a speed from a height at time 0.
struct Plate {
    float height = 0.0f, speed = 0.0f, seconds = 0.0f;
    bool exists = true;
    size_t asked = 0, most = 0; // ways, and the most in a step

    [[nodiscard]] float top() const { return height + speed * seconds; }
    Obstacles obstacles() {
        return [this](std::span<const Way> ways, std::span<std::optional<Obstacle>> met) {
            REQUIRE(ways.size() == met.size());
            asked += ways.size();
            for (size_t k = 0; exists && k < ways.size(); ++k) {
                const float from = ways[k].from.y - top(), to = ways[k].to.y - top();
                if (from > 0.0f && to <= 0.0f)
                    met[k] = Obstacle{glm::mix(ways[k].from, ways[k].to, from / (from - to)),
                                      {0.0f, 1.0f, 0.0f},
                                      {0.0f, speed, 0.0f}};
            }
        };
    }
    void step(Particles& particles) {
        asked = 0;
        particles.step(step_seconds, obstacles());
        most = std::max(most, asked);
        seconds += step_seconds;
    }
    static constexpr float step_seconds = 1.0f / 120.0f;
};

float lowest_of(const Particles& particles) {
    const Drawn drawn(particles);
    float lowest = INFINITY;
    for (const engine::Splinter& one : drawn.splinters) lowest = std::min(lowest, one.centre.y);
    for (const engine::DustPuff& one : drawn.dust) lowest = std::min(lowest, one.centre.y);
    return lowest;
}

float highest_splinter(const Particles& particles) {
    float highest = -INFINITY;
    for (const engine::Splinter& one : Drawn(particles).splinters) highest = std::max(highest, one.centre.y);
    return highest;
}

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

TEST_CASE("particles: they land on an obstacle, however fast, and fall once it is gone") {
    const auto thrown_from = [](float height, float speed) {
        Particles particles;
        for (uint64_t seed = 0; seed < 30; ++seed)
            particles.burst({.at = {0.0f, height, 0.0f}, .velocity = {0.0f, speed, 0.0f}, .area = 0.02f}, {}, seed);
        REQUIRE(particles.splinter_count() > 100);
        return particles;
    };
    for (const float speed : {0.0f, -8.0f, -60.0f}) {
        CAPTURE(speed);
        Plate plate{.height = 1.0f};
        Particles particles = thrown_from(1.5f - 0.2f * speed, speed);
        const size_t thrown = particles.splinter_count();
        for (int k = 0; k < 240; ++k) {
            plate.step(particles);
            REQUIRE(lowest_of(particles) >= plate.top());
        }
        CHECK(particles.splinter_count() == thrown);
        if (speed < -8.0f) continue;                // they still bounce
        CHECK(highest_splinter(particles) < 1.02f); // all lie on it
        plate.exists = false;
        // After a tenth of a second in which it may hang, each falls for a tenth.
        for (int k = 0; k < 24; ++k) plate.step(particles);
        CHECK(highest_splinter(particles) < 0.97f);
    }
}

TEST_CASE("particles: an obstacle that rises slowly or sinks carries them") {
    for (const float speed : {-0.03f, 0.04f, -1.0f}) {
        CAPTURE(speed);
        Plate plate{.height = 1.5f, .speed = speed};
        Particles particles;
        for (uint64_t seed = 0; seed < 30; ++seed) particles.burst({.at = {0.0f, 2.5f, 0.0f}, .area = 0.02f}, {}, seed);
        for (int k = 0; k < 150; ++k) {
            plate.step(particles);
            REQUIRE(lowest_of(particles) >= std::max(plate.top(), 0.0f) - 1e-4f);
        }
        if (plate.top() > 0.0f) CHECK(highest_splinter(particles) < plate.top() + 0.06f);
    }
}

TEST_CASE("particles: a step asks for the obstacles of a third of them at most, and new ones meet none") {
    Plate plate{.height = 1.0f};
    Particles particles;
    for (uint64_t seed = 0; seed < 2000; ++seed)
        particles.burst({.at = {0.0f, 3.0f, 0.0f}, .velocity = {0.0f, -3.0f, 0.0f}, .area = 0.5f}, {}, seed);
    const size_t count = particles.splinter_count() + particles.puff_count();
    REQUIRE(count > 2000);
    for (int k = 0; k < 11; ++k) plate.step(particles);
    CHECK(plate.most == 0);
    for (int k = 0; k < 200; ++k) plate.step(particles);
    CHECK(plate.most > count / 8);
    CHECK(plate.most < count / 3);
    CHECK(plate.asked > 0);
    CHECK(plate.asked < count / 8); // of splinters at rest
}

TEST_CASE("particles: born between the faces of a crack, they leave without a jump") {
    physics::World world;
    physics::BodyDesc block = physics::test_bodies::box(glm::vec3(0.3f), 1.0f, {0.0f, 1.0f, 0.0f});
    block.fixed = true;
    REQUIRE(world.add_body(block));
    const Obstacles obstacles = [&](std::span<const Way> ways, std::span<std::optional<Obstacle>> met) {
        for (size_t k = 0; k < ways.size(); ++k)
            if (const std::optional<physics::RayHit> hit = world.cast_ray({ways[k].from, ways[k].to});
                hit && hit->body != physics::BodyId{})
                met[k] = Obstacle{hit->point, hit->normal};
    };
    Particles particles;
    // On a face of the block, within it, and above it.
    for (const float height : {1.3f, 1.2f, 1.6f})
        for (uint64_t seed = 0; seed < 20; ++seed)
            particles.burst({.at = {0.0f, height, 0.0f}, .normal = {0.0f, 1.0f, 0.0f}, .area = 0.03f}, {}, seed);
    Drawn before(particles);
    size_t on_top = 0, below = 0;
    for (int k = 0; k < 250; ++k) {
        particles.step(step, obstacles);
        const Drawn now(particles);
        REQUIRE(now.splinters.size() == before.splinters.size());
        for (size_t i = 0; i < now.splinters.size(); ++i)
            REQUIRE(glm::distance(now.splinters[i].centre, before.splinters[i].centre) < 0.06f);
        before = now;
    }
    for (const engine::Splinter& one : before.splinters) {
        on_top += one.centre.y > 1.29f && one.centre.y < 1.32f ? 1 : 0;
        below += one.centre.y < 0.1f ? 1 : 0;
        CHECK((one.centre.y > 1.29f || one.centre.y < 0.1f)); // none is stuck in the block
    }
    CHECK(on_top > 20);
    CHECK(below > 20);
    MESSAGE(on_top, " lie on the block, ", below, " on the ground");
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

// Stock Bullet as the reference of the solver: scenes with a known outcome, on both engines, and comparisons of the
// two. Where stock Bullet does worse, the name of the test case says so.
#include "physics/bullet/bullet_engine.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "physics/world/pieces.h"
#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;

namespace {

constexpr EngineKind both[] = {EngineKind::solver, EngineKind::bullet};
constexpr float g = 9.81f;

std::string name(EngineKind engine) {
    return to_string(engine);
}

WorldSettings on(EngineKind engine, WorldSettings settings = {}) {
    settings.engine = engine;
    settings.air_density = 0.0f; // Bullet has no drag
    return settings;
}

BodyDesc fixed_box(const glm::vec3& half, const glm::vec3& position) {
    BodyDesc desc = box(half, 1.0f, position);
    desc.fixed = true;
    return desc;
}

// rad
float angle_between(const glm::quat& a, const glm::quat& b) {
    const glm::quat turn = glm::conjugate(a) * b;
    return 2.0f * std::asin(std::min(1.0f, glm::length(glm::vec3(turn.x, turn.y, turn.z))));
}

// Steps until everything sleeps. Returns the seconds that it took, at most `limit`.
float settle(World& world, float limit) {
    const uint64_t start = world.steps_taken();
    const auto seconds = [&] { return static_cast<float>(world.steps_taken() - start) * world.settings().step; };
    do world.step();
    while (world.awake_count() > 0 && seconds() < limit);
    return seconds();
}

// A box of 60 Voronoi cells, 60 cm wide, one metre above the ground.
std::vector<BodyId> add_pile(World& world) {
    const fracture::Fragments pieces = test::voronoi_pieces(glm::dvec3(-0.3), glm::dvec3(0.3), 60, 11);
    const auto added = add_pieces(world, pieces, {}, {.placement = {.position = {0.0f, 1.3f, 0.0f}}});
    REQUIRE(added);
    REQUIRE(added->size() == 60);
    return *added;
}

float lowest_point(const World& world) {
    std::vector<DebugLine> lines;
    world.debug_lines(lines);
    float lowest = INFINITY;
    for (const DebugLine& line : lines) lowest = std::min({lowest, line.from.y, line.to.y});
    return lowest;
}

} // namespace

TEST_CASE("bullet: a world without bodies steps, and sums to nothing") {
    World world(on(EngineKind::bullet));
    run(world, 0.1f);
    CHECK(world.steps_taken() == 12);
    CHECK(world.body_count() == 0);
    CHECK(world.awake_count() == 0);
    CHECK(world.contact_count() == 0);
    CHECK(world.contacts().empty());
    CHECK(world.mechanics().kinetic == 0.0);
    std::vector<DebugLine> lines;
    world.debug_lines(lines, {.hulls = true, .contacts = true});
    CHECK(lines.empty());
}

TEST_CASE("bullet: a body that cannot be is refused with the solver's words, and the world is unchanged") {
    const BodyDesc good = block({0.0f, 1.0f, 0.0f});
    std::vector<BodyDesc> faulty(5, good);
    faulty[0].mass = 0.0f;
    faulty[1].inertia = glm::mat3(0.0f);
    faulty[2].hull.points.resize(3);
    faulty[3].pose.orientation = glm::quat(0.0f, 0.0f, 0.0f, 0.0f);
    faulty[4].linear_velocity.x = NAN;
    for (const BodyDesc& desc : faulty) {
        World own(on(EngineKind::solver)), bullet(on(EngineKind::bullet));
        const Result<BodyId> expected = own.add_body(desc), found = bullet.add_body(desc);
        REQUIRE_FALSE(expected);
        REQUIRE_FALSE(found);
        CHECK(found.error().status == expected.error().status);
        CHECK(found.error().message == expected.error().message);
        CHECK_FALSE(bullet.add_bodies(std::vector{good, desc, good}));
        CHECK(bullet.body_count() == 0);
        CHECK(bullet.add_body(good));
    }
}

TEST_CASE("bullet: handles stay valid while others go, and are never used again") {
    World world(on(EngineKind::bullet, empty_space));
    std::vector<BodyId> ids;
    for (int i = 0; i < 5; ++i) ids.push_back(must_add(world, block({static_cast<float>(i), 0.0f, 0.0f})));
    CHECK(world.remove_body(ids[1]));
    CHECK_FALSE(world.remove_body(ids[1]));
    CHECK_FALSE(world.contains(ids[1]));
    CHECK(world.bodies()[1] == ids[2]);
    CHECK(world.removed_count() == 1);
    world.set_velocity(ids[4], {0.0f, 1.0f, 0.0f}, glm::vec3(0.0f));
    run(world, 0.5f);
    CHECK(world.pose(ids[4]).position.y == doctest::Approx(0.5f).epsilon(1e-5).scale(0.0));
    CHECK(world.pose(ids[3]).position.x == doctest::Approx(3.0f));
    CHECK(world.last_moved_step(ids[4]) == world.steps_taken());
    CHECK(world.last_moved_step(ids[3]) == 0);
    world.clear();
    CHECK(world.body_count() == 0);
    CHECK(world.steps_taken() == 0);
    CHECK(must_add(world, block({})).value == 5);
}

TEST_CASE("bullet: bodies that are about to meet can be removed one after the other") {
    for (const bool with_step : {false, true}) {
        WorldSettings settings = on(EngineKind::bullet, empty_space);
        World world(settings);
        const BodyId wall = must_add(world, fixed_box({0.05f, 2.0f, 2.0f}, {}));
        BodyDesc ball = box(glm::vec3(0.1f), 1000.0f, {-0.4f, 0.0f, 0.0f});
        ball.linear_velocity = {40.0f, 0.0f, 0.0f}; // 0.33 m a step: through the wall within the first
        const BodyId first = must_add(world, ball);
        ball.pose.position.y = 1.0f;
        const BodyId second = must_add(world, ball);
        world.step();
        for (const BodyId id : {first, wall, second}) {
            CHECK(world.remove_body(id));
            static_cast<void>(world.contacts());
            static_cast<void>(world.contact_count());
            if (with_step) world.step();
        }
        CHECK(world.body_count() == 0);
        CHECK(world.contact_count() == 0);
    }
}

TEST_CASE("bullet: impulses beyond single precision leave a finite velocity, as on the solver") {
    for (const EngineKind engine : both) {
        CAPTURE(name(engine));
        World world(on(engine, empty_space));
        const BodyId grain = must_add(world, box(glm::vec3(1e-4f), 1e-9f, {}));
        for (const glm::vec3& impulse : {glm::vec3(1e9f, 0.0f, 0.0f), glm::vec3(0.0f, -3e38f, 3e38f)}) {
            world.apply_impulse(grain, impulse, {-1e9f, 1e9f, 0.0f});
            CHECK(glm::length(glm::dvec3(world.linear_velocity(grain))) <= 3e9);
            world.step();
            CHECK(std::isfinite(glm::length(world.pose(grain).position)));
            CHECK(std::isfinite(glm::length(world.angular_velocity(grain))));
        }
    }
}

TEST_CASE("bullet: a mountain that spins, and a block that spins a million times a second, stay at a place") {
    for (const EngineKind engine : both)
        for (const float half : {0.5f, 100.0f}) {
            CAPTURE(name(engine));
            CAPTURE(half);
            World world(on(engine, empty_space));
            BodyDesc desc = box({half, 0.5f * half, 0.3f * half}, 8e3f * half * half * half, {});
            desc.angular_velocity = half > 1.0f ? glm::vec3(3.0f, 4.0f, 5.0f) : glm::vec3(1e7f, -2e7f, 1e7f);
            const BodyId body = must_add(world, desc);
            run(world, 0.1f);
            CHECK(std::isfinite(glm::length(world.angular_velocity(body))));
            const glm::quat q = world.pose(body).orientation;
            CHECK(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z == doctest::Approx(1.0f).epsilon(1e-5));
        }
}

TEST_CASE("bullet: a ball at three times the speed of light inside a pile leaves all bodies at a place") {
    for (const EngineKind engine : both) {
        CAPTURE(name(engine));
        World world(on(engine));
        add_pile(world);
        BodyDesc ball = box(glm::vec3(5.0f), 8e6f, {0.0f, 1.3f, 0.0f});
        ball.linear_velocity = {9e8f, -1e8f, 3e8f};
        must_add(world, ball);
        for (int step = 0; step < 24; ++step) {
            world.step();
            bool finite = true;
            for (const BodyId body : world.bodies())
                finite = finite && std::isfinite(glm::length(world.pose(body).position))
                         && std::isfinite(glm::length(world.linear_velocity(body)));
            REQUIRE(finite);
        }
    }
}

TEST_CASE("bullet: the same calls give the same state, in a new world and in a cleared one") {
    const auto play = [](World& world) {
        world.clear(on(EngineKind::bullet));
        add_pile(world);
        run(world, 2.0f);
        return world.state_hash();
    };
    check_repeats(play);
}

TEST_CASE("bullet: removing a support wakes the body on it, which falls") {
    for (const EngineKind engine : both) {
        CAPTURE(name(engine));
        World world(on(engine));
        const BodyId below = must_add(world, block({0.0f, block_half, 0.0f}));
        const BodyId above = must_add(world, block({0.0f, 3.0f * block_half, 0.0f}));
        CHECK(settle(world, 5.0f) < 5.0f);
        REQUIRE(world.remove_body(below));
        CHECK(world.awake(above));
        CHECK(settle(world, 5.0f) < 5.0f);
        CHECK(world.pose(above).position.y == doctest::Approx(block_half).epsilon(0.02).scale(0.0));
    }
}

// The solver moves a free body along its parabola. Bullet integrates by symplectic Euler, which lags the parabola by
// g t h / 2. 120 sums of single precision at ten metres may add 120 * 2^-24 * 10 m = 7e-5 m to each. Rotations: Bullet
// turns by the angle w h, the solver by the Cayley map, 2 atan(w h / 2), which is less by (w h)^2 / 12 of it.
TEST_CASE("bullet: a free body flies as the solver's does, within the error of the integrators") {
    World worlds[] = {World(on(EngineKind::solver, {.ground_height = std::nullopt})),
                      World(on(EngineKind::bullet, {.ground_height = std::nullopt}))};
    constexpr float seconds = 1.0f, spin = 3.0f;
    const float lag = 0.5f * g * seconds * worlds[1].settings().step;
    std::vector<Pose> poses;
    for (World& world : worlds) {
        BodyDesc desc = box({0.1f, 0.2f, 0.3f}, 2.0f, {0.0f, 10.0f, 0.0f});
        desc.pose.orientation = glm::normalize(glm::quat(0.9f, 0.2f, -0.3f, 0.1f));
        desc.linear_velocity = {1.0f, 2.0f, -0.5f};
        desc.angular_velocity = desc.pose.orientation * glm::vec3(0.0f, 0.0f, spin); // about a principal axis
        const BodyId id = must_add(world, desc);
        run(world, seconds);
        const bool lags = world.settings().engine == EngineKind::bullet;
        const glm::vec3 exact(1.0f, 10.0f + 2.0f - 0.5f * g - (lags ? lag : 0.0f), -0.5f);
        CHECK(glm::length(world.pose(id).position - exact) < 2e-4f);
        CHECK(glm::length(world.linear_velocity(id) - glm::vec3(1.0f, 2.0f - g, -0.5f)) < 1e-4f);
        CHECK(glm::length(world.angular_velocity(id)) == doctest::Approx(spin).epsilon(1e-4).scale(0.0));
        poses.push_back(world.pose(id));
    }
    CHECK(glm::length(poses[0].position - glm::vec3(0.0f, lag, 0.0f) - poses[1].position) < 2e-4f);
    const float turn = spin * worlds[0].settings().step;
    CHECK(angle_between(poses[0].orientation, poses[1].orientation) < spin * seconds * turn * turn / 12.0f + 1e-3f);
}

TEST_CASE("bullet: an impulse changes momentum and angular momentum by its own, and response() foretells the speed") {
    for (const EngineKind engine : both) {
        CAPTURE(name(engine));
        World world(on(engine, empty_space));
        const BodyId id = must_add(world, box({0.1f, 0.2f, 0.3f}, 2.0f, {1.0f, 0.0f, 0.0f}));
        const glm::vec3 direction = glm::normalize(glm::vec3(0.5f, -1.0f, 0.25f)), point(1.1f, 0.1f, -0.2f);
        const glm::vec3 impulse = 1.5f * direction;
        world.apply_impulse(id, impulse, point);
        const Mechanics now = world.mechanics();
        CHECK(glm::length(now.momentum - glm::dvec3(impulse)) < 1e-5);
        CHECK(glm::length(now.angular_momentum - glm::cross(glm::dvec3(point), glm::dvec3(impulse))) < 1e-5);
        const glm::vec3 speed =
            world.linear_velocity(id) + glm::cross(world.angular_velocity(id), point - world.pose(id).position);
        CHECK(glm::dot(speed, direction)
              == doctest::Approx(1.5f * world.response(id, point, direction)).epsilon(1e-5).scale(0.0));
    }
}

// Symplectic Euler stops at most one step of the first speed away from that.
TEST_CASE("bullet: a sliding body stops after v^2 / (2 mu g), on stock Bullet up to a tenth later") {
    for (const EngineKind engine : both)
        for (const float speed : {1.0f, 3.0f}) {
            CAPTURE(name(engine));
            CAPTURE(speed);
            World world(on(engine));
            constexpr float half_height = 0.02f; // flat: it does not pitch
            const BodyDesc desc = box({0.2f, half_height, 0.2f}, 2.0f, {0.0f, half_height, 0.0f});
            const BodyId id = must_add(world, desc);
            run(world, 0.5f); // onto its contacts
            world.set_velocity(id, {speed, 0.0f, 0.0f}, glm::vec3(0.0f));
            const glm::vec3 from = world.pose(id).position;
            run(world, 3.0f);
            const float expected = speed * speed / (2.0f * desc.friction * world.settings().ground_friction * g);
            const float step_way = speed * world.settings().step;
            const glm::vec3 way = world.pose(id).position - from;
            CHECK(way.x > expected - step_way);
            // Bullet drops contact points that slide far in a step and finds one of them anew.
            CHECK(way.x < expected + (engine == EngineKind::bullet ? 0.1f * expected : step_way));
            CHECK(std::abs(way.z) < 0.01f);
            CHECK(glm::length(world.linear_velocity(id)) < 1e-3f);
        }
}

// Bullet drops contact points that move by a fiftieth of the body's radius in a step. The one that it finds anew carries
// one corner, and the others sink.
TEST_CASE("bullet: a body that slides fast stays on the ground, into which it sinks on stock Bullet until it slows") {
    for (const EngineKind engine : both) {
        CAPTURE(name(engine));
        World world(on(engine));
        BodyDesc desc = box({0.1f, 0.05f, 0.08f}, 2.0f, {0.0f, 0.05f, 0.0f});
        desc.linear_velocity = {7.0f, 0.0f, 0.0f};
        const BodyId id = must_add(world, desc);
        for (int step = 0; step < 600; ++step) {
            world.step();
            if (engine == EngineKind::solver) CHECK(world.pose(id).position.y > 0.049f);
            CHECK(world.pose(id).position.y > 0.0f);
        }
        CHECK(world.pose(id).position.y == doctest::Approx(0.05f).epsilon(0.02).scale(0.0));
        CHECK_FALSE(world.awake(id));
    }
}

TEST_CASE("bullet: a stack of three stands, and falls asleep") {
    for (const EngineKind engine : both) {
        CAPTURE(name(engine));
        World world(on(engine));
        std::vector<BodyId> ids;
        for (int i = 0; i < 3; ++i)
            ids.push_back(must_add(world, block({0.0f, block_half * static_cast<float>(2 * i + 1), 0.0f})));
        run(world, 5.0f);
        CHECK(world.awake_count() == 0);
        for (int i = 0; i < 3; ++i) {
            const Pose pose = world.pose(ids[static_cast<size_t>(i)]);
            const glm::vec3 place(0.0f, block_half * static_cast<float>(2 * i + 1), 0.0f);
            CHECK(glm::length(pose.position - place) < 2e-3f);
            CHECK(angle_between(pose.orientation, {1.0f, 0.0f, 0.0f, 0.0f}) < 0.01f);
        }
    }
}

// Bullet finds a single contact as a box lands flat, and the box turns about it.
TEST_CASE("bullet: dropped boxes rest on the face that the solver's rest on, on stock Bullet some centimetres aside") {
    std::vector<std::vector<Pose>> rest;
    for (const EngineKind engine : both) {
        CAPTURE(name(engine));
        World world(on(engine, {.ground_restitution = 0.0f}));
        for (const float drop : {0.0f, 0.1f, 0.2f, 0.3f})
            must_add(world, box({0.1f, 0.05f, 0.15f}, 3.0f, {10.0f * drop, 0.15f + drop, 0.0f}));
        CHECK(settle(world, 5.0f) < 5.0f);
        rest.push_back(poses_of(world));
    }
    for (size_t i = 0; i < rest[0].size(); ++i) {
        const glm::vec3 apart = rest[1][i].position - rest[0][i].position, up(0.0f, 1.0f, 0.0f);
        CHECK(std::abs(apart.y) < 1e-3f);
        CHECK(glm::length(apart) < 0.03f);
        for (const std::vector<Pose>& poses : rest) CHECK((poses[i].orientation * up).y > 0.9999f);
    }
}

TEST_CASE("bullet: 60 pieces pile up, none below the ground, and all come to rest, stock Bullet's later and flatter") {
    std::vector<double> energies;
    for (const EngineKind engine : both) {
        CAPTURE(name(engine));
        World world(on(engine));
        add_pile(world);
        const double start = energy_of(world);
        const float seconds = settle(world, 20.0f);
        CHECK(seconds < 20.0f);
        CHECK(world.body_count() == 60);
        CHECK(all_finite(world));
        CHECK(world.mechanics().kinetic == 0.0);
        CHECK(lowest_point(world) > -2e-3f);
        CHECK(energy_of(world) < 0.5 * start);
        energies.push_back(energy_of(world));
    }
    CHECK(energies[1] < energies[0]);
    CHECK(energies[1] > 0.5 * energies[0]);
}

TEST_CASE("bullet: the energy of a falling pile does not rise") {
    for (const EngineKind engine : both) {
        CAPTURE(name(engine));
        World world(on(engine));
        add_pile(world);
        EnergyBooks energy(world);
        for (int step = 0; step < 600; ++step) {
            world.step();
            energy.look(world);
        }
        CHECK(energy.risen < 1e-6 * energy.start);
        CHECK(energy.last < 0.15 * energy.start);
    }
}

TEST_CASE("bullet: a compound moves and rests as the same box of one hull") {
    const glm::vec3 half(0.2f, 0.05f, 0.1f);
    for (const EngineKind engine : both) {
        CAPTURE(name(engine));
        World world(on(engine, {.ground_restitution = 0.0f}));
        BodyDesc desc = box(half, 4.0f, {0.0f, 0.5f, 0.0f});
        const BodyId single = must_add(world, desc);
        desc.pose.position.z = 2.0f;
        const BodyId compound = must_add(world, in_slabs(desc, half, 4));
        run(world, 0.2f);
        CHECK(world.pose(compound).position.y == world.pose(single).position.y);
        CHECK(settle(world, 5.0f) < 5.0f);
        CHECK(world.pose(compound).position.y == doctest::Approx(half.y).epsilon(0.02).scale(0.0));
        CHECK(std::abs(world.pose(compound).position.y - world.pose(single).position.y) < 1e-3f);
        run(world, 0.1f);
        std::vector<uint8_t> pressed(4, 0);
        for (const Contact& contact : world.contacts())
            if (contact.a == compound) {
                REQUIRE(contact.part_a < 4);
                pressed[contact.part_a] = 1;
            }
        CHECK(std::ranges::count(pressed, 1) >= 2);
    }
}

// The sum of the normal impulses of a second is m g t. On the ground, and on a fixed slab through a second body.
TEST_CASE("bullet: the contacts of a second hold up the weight") {
    for (const EngineKind engine : both)
        for (const bool on_slab : {false, true}) {
            CAPTURE(name(engine));
            CAPTURE(on_slab);
            World world(on(engine, {.sleeping = false}));
            float top = 0.0f;
            if (on_slab) {
                must_add(world, fixed_box({1.0f, 0.1f, 1.0f}, {0.0f, 0.5f, 0.0f}));
                top = 0.6f;
            }
            const BodyId below = must_add(world, box(glm::vec3(0.1f), 8.0f, {0.0f, top + 0.1f, 0.0f}));
            const BodyId above = must_add(world, box({0.05f, 0.05f, 0.05f}, 2.0f, {0.0f, top + 0.25f, 0.0f}));
            run(world, 1.0f);
            double support = 0.0, between = 0.0; // N s
            for (int step = 0; step < 120; ++step) {
                world.step();
                for (const Contact& contact : world.contacts()) {
                    CHECK(contact.impulse >= 0.0f);
                    const bool moving_pair =
                        (contact.a == above && contact.b == below) || (contact.a == below && contact.b == above);
                    const float towards_a = contact.impulse * contact.normal.y + contact.friction.y;
                    if (moving_pair)
                        between += contact.a == above ? towards_a : -towards_a;
                    else
                        support += contact.a == below ? towards_a : -towards_a;
                }
            }
            CHECK(support == doctest::Approx(10.0 * 9.81).epsilon(0.02).scale(0.0));
            CHECK(between == doctest::Approx(2.0 * 9.81).epsilon(0.02).scale(0.0));
        }
}

TEST_CASE("bullet: a blow's contact names its speed, its point and the impulse that stops the body") {
    for (const EngineKind engine : both) {
        CAPTURE(name(engine));
        World world(on(engine, {.ground_restitution = 0.0f}));
        const BodyId id = must_add(world, block({0.0f, 0.5f, 0.0f}));
        glm::vec3 before(0.0f);
        float speed = 0.0f, impulse = 0.0f;
        for (int step = 0; step < 120 && impulse == 0.0f; ++step) {
            before = world.linear_velocity(id);
            world.step();
            for (const Contact& contact : world.contacts()) {
                CHECK(contact.a == id);
                CHECK(contact.b == BodyId{});
                CHECK(contact.normal.y == doctest::Approx(1.0f));
                CHECK(contact.blow == contact.impulse);
                impulse += contact.impulse;
                speed = std::max(speed, contact.speed);
            }
        }
        CHECK(speed == doctest::Approx(-before.y).epsilon(1e-3).scale(0.0));
        // One step of gravity before the fall's end, and up to one more where the contact is made before the touch.
        CHECK(std::abs(speed - std::sqrt(2.0f * g * 0.45f)) < 2.0f * g * world.settings().step);
        const float change = world.linear_velocity(id).y - (before.y - g * world.settings().step);
        CHECK(impulse == doctest::Approx(world.mass(id) * change).epsilon(1e-3).scale(0.0));
    }
}

TEST_CASE("bullet: fixed bodies do not move, and nothing passes through them") {
    for (const EngineKind engine : both) {
        CAPTURE(name(engine));
        World world(on(engine, {.ground_height = std::nullopt}));
        const BodyId slab = must_add(world, fixed_box({1.0f, 0.01f, 1.0f}, {0.0f, 0.0f, 0.0f}));
        std::vector<BodyId> shot;
        for (int x = -2; x <= 2; ++x)
            for (int z = -2; z <= 2; ++z) {
                BodyDesc desc = block({0.3f * static_cast<float>(x), 1.0f + 0.1f * static_cast<float>(x + 2),
                                       0.3f * static_cast<float>(z)});
                desc.linear_velocity = {0.0f, -10.0f * static_cast<float>(z + 3), 0.0f}; // 10 to 50 m/s
                desc.restitution = 0.0f;
                shot.push_back(must_add(world, desc));
            }
        CHECK(world.fixed(slab));
        CHECK_FALSE(world.awake(slab));
        CHECK(world.response(slab, {}, {0.0f, 1.0f, 0.0f}) == 0.0f);
        world.apply_impulse(slab, {0.0f, 100.0f, 0.0f}, {});
        for (int step = 0; step < 120; ++step) {
            world.step();
            for (const BodyId id : shot) { // above the slab, or thrown over its edge
                const glm::vec3 at = world.pose(id).position;
                CHECK((at.y > 0.0f || std::abs(at.x) > 1.0f || std::abs(at.z) > 1.0f));
            }
        }
        CHECK(world.pose(slab).position == glm::vec3(0.0f));
        CHECK(world.linear_velocity(slab) == glm::vec3(0.0f));
        CHECK(world.mechanics(slab).kinetic == 0.0);
    }
}

TEST_CASE("bullet: rewind() returns a body to the start of the step, and move_on() moves it without contacts") {
    for (const EngineKind engine : both) {
        CAPTURE(name(engine));
        World world(on(engine, {.ground_restitution = 0.0f}));
        const BodyId id = must_add(world, block({0.0f, 0.2f, 0.0f}));
        glm::vec3 before(0.0f);
        do {
            before = world.linear_velocity(id);
            world.step();
        } while (world.contacts().empty() && world.steps_taken() < 120);
        REQUIRE_FALSE(world.contacts().empty());
        const Pose start = world.previous_pose(id);
        const float step = world.settings().step;
        const glm::vec3 push(0.5f, 0.0f, 0.0f); // a change of velocity after the step stays
        world.apply_impulse(id, push, world.pose(id).position);
        CHECK(world.rewind(id) == step);
        CHECK(glm::length(world.pose(id).position - start.position) < 1e-6f);
        const glm::vec3 expected = before + world.settings().gravity * step + push / world.mass(id);
        CHECK(glm::length(world.linear_velocity(id) - expected) < 1e-5f);
        world.move_on(id, 0.5f * step);
        CHECK(glm::length(world.pose(id).position - (start.position + expected * (0.5f * step))) < 1e-6f);
        CHECK(world.last_moved_step(id) == world.steps_taken());
        CHECK(world.rewind(id) == 0.5f * step); // the time that it was moved on
        CHECK(glm::length(world.pose(id).position - start.position) < 1e-6f);

        const BodyId late = must_add(world, block({1.0f, 0.2f, 0.0f}));
        CHECK(world.rewind(late) == 0.0f);
        CHECK(glm::length(world.pose(late).position - glm::vec3(1.0f, 0.2f, 0.0f)) < 1e-6f);
        CHECK(world.linear_velocity(late) == glm::vec3(0.0f));
        const BodyId late_wall = must_add(world, fixed_box(glm::vec3(0.1f), {3.0f, 0.1f, 0.0f}));
        world.move_on(late_wall, step);
        CHECK(world.pose(late_wall).position == glm::vec3(3.0f, 0.1f, 0.0f));
    }
}

TEST_CASE("bullet: debris collides with the ground and with larger bodies, and with debris on the solver only") {
    for (const EngineKind engine : both) {
        CAPTURE(name(engine));
        World world(on(engine));
        const BodyId below = must_add(world, block({0.0f, block_half, 0.0f}, true));
        const BodyId above = must_add(world, block({0.0f, 4.0f * block_half, 0.0f}, true));
        const BodyId table = must_add(world, box({0.3f, 0.1f, 0.3f}, 20.0f, {2.0f, 0.1f, 0.0f}));
        const BodyId on_table = must_add(world, block({2.0f, 0.3f, 0.0f}, true));
        CHECK(world.debris(below));
        CHECK_FALSE(world.debris(table));
        CHECK(world.awake_count() == 4);
        CHECK(world.colliding_count() == 1);
        CHECK(settle(world, 5.0f) < 5.0f);
        if (engine == EngineKind::bullet)
            CHECK(world.pose(above).position.y == doctest::Approx(block_half).epsilon(0.04).scale(0.0));
        else
            CHECK(glm::length(world.pose(above).position - world.pose(below).position) > 2.0f * block_half);
        CHECK(world.pose(on_table).position.y == doctest::Approx(0.2f + block_half).epsilon(0.02).scale(0.0));
    }
}

// Bullet's split impulse handles overlaps beyond 4 mm. Smaller ones are closed by velocity, a fifth of the overlap a
// step.
TEST_CASE("bullet: hulls that overlap are moved apart, on stock Bullet with some velocity") {
    for (const EngineKind engine : both) {
        CAPTURE(name(engine));
        World world(on(engine, empty_space));
        const BodyId left = must_add(world, box(glm::vec3(0.1f), 1.0f, {-0.09f, 0.0f, 0.0f}));
        const BodyId right = must_add(world, box(glm::vec3(0.1f), 1.0f, {0.09f, 0.0f, 0.0f}));
        const float by_bullet = 0.2f * 0.004f / world.settings().step;
        CHECK(drift(world, 120).speed < (engine == EngineKind::bullet ? by_bullet : 1e-3f));
        CHECK(world.pose(right).position.x - world.pose(left).position.x > 0.195f);
    }
}

TEST_CASE("bullet: stock Bullet bounces by the restitution, and a fast body on the ground of the solver by less") {
    for (const EngineKind engine : both) {
        CAPTURE(name(engine));
        World world(on(engine, {.ground_restitution = 1.0f}));
        BodyDesc desc = block({0.0f, 1.0f + block_half, 0.0f});
        desc.restitution = 0.5f;
        const BodyId id = must_add(world, desc);
        while (world.linear_velocity(id).y <= 0.0f && world.steps_taken() < 240) world.step();
        const float expected = 0.5f * std::sqrt(2.0f * g), error = 1.5f * g * world.settings().step;
        CHECK(world.linear_velocity(id).y > 0.0f);
        CHECK(world.linear_velocity(id).y < expected + error);
        if (engine == EngineKind::bullet) CHECK(world.linear_velocity(id).y > expected - error);
    }
}

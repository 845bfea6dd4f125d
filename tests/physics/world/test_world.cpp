#include "physics/world/world.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "physics/world/pieces.h"
#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;

namespace {

constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();

// Random boxes that fly at each other from all sides.
void add_swarm(World& world, int count) {
    test::Random random(5);
    for (int i = 0; i < count; ++i) {
        const glm::dvec3 place = random.direction() * random.uniform(0.5, 2.0);
        BodyDesc desc = box(glm::vec3(random.point(glm::dvec3(0.05), glm::dvec3(0.2))),
                            static_cast<float>(random.uniform(0.5, 3.0)), glm::vec3(place + glm::dvec3(0.0, 3.0, 0.0)));
        desc.linear_velocity = glm::vec3(-place);
        desc.angular_velocity = glm::vec3(random.point(glm::dvec3(-3.0), glm::dvec3(3.0)));
        must_add(world, desc);
    }
}

} // namespace

TEST_CASE("world: without bodies it steps, has no energy and draws nothing") {
    World world;
    run(world, 0.1f);
    CHECK(world.body_count() == 0);
    CHECK(world.awake_count() == 0);
    CHECK(world.contact_count() == 0);
    CHECK(world.mechanics().kinetic == 0.0);
    std::vector<DebugLine> lines;
    world.debug_lines(lines, {.hulls = true, .contacts = true});
    CHECK(lines.empty());
    CHECK(poses_of(world).empty());
    CHECK_FALSE(world.remove_body({}));
    CHECK_FALSE(world.contains({}));
}

TEST_CASE("world: a setting outside its range is named") {
    const std::vector<std::pair<WorldSettings, std::string>> cases{
        {{.gravity = {0.0f, nan_value, 0.0f}}, "gravity"},
        {{.step = 0.0f}, "step"},
        {{.step = nan_value}, "step"},
        {{.max_substeps = 0}, "max_substeps"},
        {{.ground_height = std::numeric_limits<float>::infinity()}, "ground_height"},
        {{.ground_friction = -1.0f}, "ground_friction"},
        {{.ground_restitution = 2.0f}, "ground_restitution"},
        {{.linear_damping = 1.5f}, "linear_damping"},
        {{.angular_damping = -0.5f}, "angular_damping"},
        {{.air_density = -1.0f}, "air_density"},
        {{.air_density = nan_value}, "air_density"},
        {{.solver_substeps = 0}, "solver_substeps"},
        {{.separation_speed = -1.0f}, "separation_speed"},
        {{.debris_size = -1.0f}, "debris_size"},
        {{.sleep_linear_speed = nan_value}, "sleep_linear_speed"},
        {{.sleep_angular_speed = -1.0f}, "sleep_angular_speed"},
        {{.sleep_seconds = -1.0f}, "sleep_seconds"},
    };
    for (const auto& [settings, field] : cases) {
        const Result<void> result = validate(settings);
        REQUIRE_FALSE(result.has_value());
        CHECK(result.error().status == fracture::Status::invalid_setting);
        CHECK(result.error().message.find(field) != std::string::npos);
    }
    CHECK(validate({}).has_value());
}

TEST_CASE("world: an invalid body is refused with its fault, and the world is unchanged") {
    const BodyDesc good = box({0.1f, 0.1f, 0.1f}, 1.0f, {0.0f, 1.0f, 0.0f});
    std::vector<std::pair<BodyDesc, std::string>> cases(13, {good, ""});
    cases[0].first.mass = 0.0f, cases[0].second = "mass";
    cases[1].first.mass = -1.0f, cases[1].second = "mass";
    cases[2].first.mass = nan_value, cases[2].second = "mass";
    cases[3].first.inertia[1][1] = nan_value, cases[3].second = "inertia";
    cases[4].first.inertia = glm::mat3(0.0f), cases[4].second = "inertia";
    cases[5].first.inertia[0][0] = 10.0f, cases[5].second = "inertia";
    cases[6].first.inertia[2][2] = -1.0f, cases[6].second = "inertia";
    cases[7].first.pose.position.x = nan_value, cases[7].second = "position";
    cases[8].first.pose.orientation = glm::quat(0.0f, 0.0f, 0.0f, 0.0f), cases[8].second = "orientation";
    cases[9].first.angular_velocity.y = std::numeric_limits<float>::infinity(), cases[9].second = "velocity";
    cases[10].first.hull.points.resize(3), cases[10].second = "3 points";
    cases[11].first.hull.points[5].z = nan_value, cases[11].second = "point 5";
    cases[12].first.restitution = 1.5f, cases[12].second = "restitution";
    World world;
    for (const auto& [desc, word] : cases) {
        const Result<BodyId> id = world.add_body(desc);
        REQUIRE_FALSE(id.has_value());
        CAPTURE(id.error().message);
        CHECK(id.error().message.find(word) != std::string::npos);
        CHECK(world.body_count() == 0);
    }
    CHECK(world.add_body(good).has_value());
}

TEST_CASE("world: handles stay valid while other bodies are removed, and are never reused") {
    World world(empty_space);
    std::vector<BodyId> ids;
    for (int i = 0; i < 5; ++i)
        ids.push_back(must_add(world, box({0.1f, 0.1f, 0.1f}, 1.0f, {static_cast<float>(i), 0.0f, 0.0f})));
    CHECK(world.remove_body(ids[1]));
    CHECK_FALSE(world.remove_body(ids[1]));
    CHECK_FALSE(world.contains(ids[1]));
    CHECK(world.body_count() == 4);
    CHECK(world.pose(ids[3]).position.x == 3.0f);
    CHECK(poses_of(world)[1].position.x == 2.0f);
    CHECK(world.bodies()[1] == ids[2]);
    world.clear();
    CHECK(world.body_count() == 0);
    CHECK_FALSE(world.contains(ids[0]));
    const BodyId fresh = must_add(world, box({0.1f, 0.1f, 0.1f}, 1.0f, {}));
    CHECK(fresh.value == 5);
    std::ostringstream text;
    text << fresh << ", " << BodyId{};
    CHECK(text.str() == "body 5, body none");
}

TEST_CASE("world: free fall follows the parabola to rounding") {
    World world({.ground_height = std::nullopt, .air_density = 0.0f});
    BodyDesc desc = box({0.1f, 0.1f, 0.1f}, 2.0f, {0.0f, 10.0f, 0.0f});
    desc.linear_velocity = {1.0f, 2.0f, 0.0f};
    const BodyId id = must_add(world, desc);
    run(world, 1.0f);
    const glm::vec3 position = world.pose(id).position;
    CHECK(position.x == doctest::Approx(1.0).epsilon(1e-5).scale(0.0));
    // A step moves a free body at the mean of its speeds before and after, which integrates gravity exactly.
    CHECK(position.y == doctest::Approx(10.0 + 2.0 - 0.5 * 9.81).epsilon(1e-5).scale(0.0));
    CHECK(world.linear_velocity(id).y == doctest::Approx(2.0 - 9.81).epsilon(1e-5).scale(0.0));
}

TEST_CASE("world: advance takes the steps that fit and interpolates the rest") {
    World world({.max_substeps = 4, .ground_height = std::nullopt});
    const BodyId id = must_add(world, box({0.1f, 0.1f, 0.1f}, 1.0f, {}));
    CHECK(world.advance(0.25 / 120.0) == doctest::Approx(0.25));
    CHECK(world.steps_taken() == 0);
    CHECK(world.advance(2.0 / 120.0) == doctest::Approx(0.25));
    CHECK(world.steps_taken() == 2);
    CHECK(world.advance(-1.0) == doctest::Approx(0.25));
    CHECK(world.advance(std::numeric_limits<double>::quiet_NaN()) == doctest::Approx(0.25));
    CHECK(world.advance(std::numeric_limits<double>::infinity()) == doctest::Approx(0.25));
    CHECK(world.advance(100.0) < 1.0f);
    CHECK(world.steps_taken() == 6);
    CHECK(world.advance(0.0) < 1.0f);
    CHECK(world.steps_taken() == 6);

    const glm::vec3 start = world.interpolated_pose(id, 0.0f).position,
                    half = world.interpolated_pose(id, 0.5f).position, end = world.interpolated_pose(id, 1.0f).position;
    CHECK(end == world.pose(id).position);
    CHECK(start == world.previous_pose(id).position);
    CHECK(start.y > end.y);
    CHECK(half.y == doctest::Approx(0.5f * (start.y + end.y)).scale(0.0));
}

TEST_CASE("world: orientations are interpolated along the shorter arc") {
    World world(empty_space);
    BodyDesc desc = box({0.1f, 0.2f, 0.3f}, 1.0f, {});
    desc.angular_velocity = {0.0f, 0.0f, 6.0f};
    const BodyId id = must_add(world, desc);
    run(world, 0.5f);
    const glm::vec3 x = world.interpolated_pose(id, 0.25f).orientation * glm::vec3(1.0f, 0.0f, 0.0f);
    const double angle = 6.0 * (60.0 - 0.75) / 120.0; // 2.96, below pi
    // The Cayley map turns by 2 atan(w step / 2): a relative error of 2e-4 at this speed.
    CHECK(std::abs(std::atan2(x.y, x.x) - angle) < 1e-3);
}

TEST_CASE("world: momentum survives a collision in empty space, and energy does not rise") {
    for (const float restitution : {0.0f, 0.5f, 1.0f}) {
        World world(empty_space);
        BodyDesc first = box({0.1f, 0.1f, 0.1f}, 1.0f, {-0.5f, 0.03f, 0.02f});
        first.linear_velocity = {2.0f, 0.0f, 0.0f};
        BodyDesc second = box({0.2f, 0.1f, 0.1f}, 3.0f, {0.5f, 0.0f, 0.0f});
        second.angular_velocity = {0.5f, 1.0f, 0.0f};
        first.restitution = second.restitution = restitution;
        const BodyId moving = must_add(world, first);
        must_add(world, second);
        const Mechanics before = world.mechanics();
        run(world, 1.0f);
        const Mechanics after = world.mechanics();
        CAPTURE(restitution);
        CHECK(world.linear_velocity(moving).x < 1.5f); // they did collide
        CHECK(glm::length(after.momentum - before.momentum) < 1e-4 * glm::length(before.momentum));
        CHECK(glm::length(after.angular_momentum - before.angular_momentum) < 2e-2);
        CHECK(after.kinetic <= before.kinetic * (1.0 + 1e-3));
    }
}

TEST_CASE("world: a body with three different moments tumbles with constant angular momentum and energy") {
    for (const bool turned : {false, true}) {
        World world(empty_space);
        BodyDesc desc = box({0.05f, 0.1f, 0.2f}, 2.0f, {});
        if (turned) { // the same box in other body axes: a full tensor
            const glm::mat3 turn = glm::mat3_cast(glm::normalize(glm::quat(0.8f, 0.3f, -0.4f, 0.2f)));
            for (glm::vec3& point : desc.hull.points) point = turn * point;
            desc.inertia = turn * desc.inertia * glm::transpose(turn);
            desc.angular_velocity = turn * glm::vec3(0.05f, 5.0f, 0.1f);
        } else {
            desc.angular_velocity = {0.05f, 5.0f, 0.1f};
        }
        const glm::mat3 inertia = desc.inertia;
        const BodyId id = must_add(world, desc);
        const glm::dvec3 momentum = glm::dvec3(inertia * desc.angular_velocity); // orientation is the identity
        CHECK(glm::length(world.mechanics().angular_momentum - momentum) < 1e-5 * glm::length(momentum));
        const double energy = world.mechanics().kinetic;
        run(world, 10.0f);
        const glm::dvec3 now = world.mechanics().angular_momentum;
        CHECK(glm::length(now - momentum) < 1e-3 * glm::length(momentum));
        CHECK(world.mechanics().kinetic == doctest::Approx(energy).epsilon(1e-3).scale(0.0));
        // Independently of mechanics(): from the pose and the given tensor.
        const glm::mat3 axes = glm::mat3_cast(world.pose(id).orientation);
        const glm::dvec3 own(axes * inertia * glm::transpose(axes) * world.angular_velocity(id));
        CHECK(glm::length(own - momentum) < 1e-3 * glm::length(momentum));
    }
}

TEST_CASE("world: the pose of a body with a full inertia tensor is that of the given axes") {
    World world(empty_space);
    BodyDesc desc = box({0.05f, 0.1f, 0.2f}, 2.0f, {1.0f, 2.0f, 3.0f});
    const glm::mat3 turn = glm::mat3_cast(glm::normalize(glm::quat(0.8f, 0.3f, -0.4f, 0.2f)));
    for (glm::vec3& point : desc.hull.points) point = turn * point;
    desc.inertia = turn * desc.inertia * glm::transpose(turn);
    desc.pose.orientation = glm::normalize(glm::quat(0.1f, 0.2f, 0.3f, 0.9f));
    const BodyId id = must_add(world, desc);
    CHECK(std::abs(glm::dot(world.pose(id).orientation, desc.pose.orientation)) == doctest::Approx(1.0f));
    // The edges are drawn between the hull's points in that pose.
    std::vector<DebugLine> lines;
    world.debug_lines(lines);
    CHECK(lines.size() == 12);
    for (const DebugLine& line : lines) {
        float nearest = 1.0f;
        for (const glm::vec3& point : desc.hull.points)
            nearest = std::min(nearest, glm::length(desc.pose.position + desc.pose.orientation * point - line.from));
        CHECK(nearest < 1e-5f);
    }
}

TEST_CASE("world: an impulse changes momentum and angular momentum by exactly its own") {
    World world(empty_space);
    const BodyId id = must_add(world, box({0.1f, 0.2f, 0.3f}, 2.0f, {1.0f, 0.0f, 0.0f}));
    const glm::vec3 impulse(0.5f, -1.0f, 0.25f), point(1.1f, 0.1f, -0.2f);
    world.apply_impulse(id, impulse, point);
    const Mechanics now = world.mechanics();
    CHECK(glm::length(now.momentum - glm::dvec3(impulse)) < 1e-6);
    CHECK(glm::length(now.angular_momentum - glm::cross(glm::dvec3(point), glm::dvec3(impulse))) < 1e-6);
}

TEST_CASE("world: boxes dropped from two metres land on the ground and none passes through") {
    for (const float half : {0.005f, 0.05f, 0.5f}) {
        World world;
        std::vector<BodyId> ids;
        test::Random random(9);
        for (int i = 0; i < 8; ++i) {
            BodyDesc desc = box({half, half * 0.7f, half * 1.3f}, 2400.0f * half * half * half * 8.0f,
                                {static_cast<float>(i) * half * 5.0f, 2.0f + half, 0.0f});
            const glm::dvec3 axis = random.direction();
            desc.pose.orientation = glm::angleAxis(static_cast<float>(random.uniform(0.0, 3.0)), glm::vec3(axis));
            ids.push_back(must_add(world, desc));
        }
        float lowest = 1.0f;
        for (int step = 0; step < 600; ++step) {
            world.step();
            for (const BodyId id : ids) lowest = std::min(lowest, world.pose(id).position.y);
        }
        CAPTURE(half);
        CHECK(lowest > 0.0f);
        for (const BodyId id : ids) {
            CHECK(glm::length(world.linear_velocity(id)) < 0.05f);
            CHECK(world.pose(id).position.y < half * 1.4f);
            CHECK(world.pose(id).position.y > half * 0.65f);
        }
    }
}

TEST_CASE("world: a box at rest stands on the ground without a gap") {
    World world;
    const BodyId id = must_add(world, box({0.1f, 0.1f, 0.1f}, 8.0f, {0.0f, 0.1f, 0.0f}));
    run(world, 2.0f);
    CHECK(std::abs(world.pose(id).position.y - 0.1f) < 1e-3f);
    CHECK(world.contact_count() >= 3);
    std::vector<DebugLine> lines;
    world.debug_lines(lines, {.hulls = false, .contacts = true});
    CHECK(lines.size() == world.contact_count());
    for (const DebugLine& line : lines) CHECK(std::abs(line.from.y) < 2e-3f);
}

TEST_CASE(
    "world: bodies on the ground have contacts, awake or asleep, and removed bodies and bodies in the air have none") {
    World world;
    std::vector<BodyId> boxes;
    for (int i = 0; i < 4; ++i)
        boxes.push_back(must_add(world, box({0.1f, 0.1f, 0.1f}, 8.0f, {static_cast<float>(i), 0.1f, 0.0f})));
    run(world, 2.0f);
    REQUIRE(world.awake_count() == 0);
    const auto drawn = [&world] {
        std::vector<DebugLine> lines;
        world.debug_lines(lines, {.hulls = false, .contacts = true});
        return lines.size();
    };
    const auto pressing = [&world](BodyId id) {
        return std::ranges::any_of(world.contacts(), [id](const Contact& contact) { return contact.a == id; });
    };
    CHECK(world.contact_count() == 16); // four corners each
    CHECK(drawn() == 16);
    for (const BodyId id : boxes) CHECK(pressing(id));
    REQUIRE(world.remove_body(boxes[1]));
    CHECK(world.contact_count() == 12);
    const BodyId above = must_add(world, box({0.1f, 0.1f, 0.1f}, 8.0f, {1.0f, 3.0f, 0.0f}));
    const BodyId lands = must_add(world, box({0.1f, 0.1f, 0.1f}, 8.0f, {7.0f, 0.1005f, 0.0f}));
    run(world, 0.1f);
    CHECK(world.contact_count() == 16);
    CHECK(drawn() == 16);
    CHECK(pressing(lands));
    CHECK_FALSE(pressing(above));
    world.set_velocity(lands, {0.0f, 5.0f, 0.0f}, glm::vec3(0.0f));
    run(world, 0.05f);
    CHECK(world.contact_count() == 12);
    CHECK_FALSE(pressing(lands));
    REQUIRE(world.remove_body(lands));
    REQUIRE(world.remove_body(above));
    CHECK(world.contact_count() == 12);
    for (const BodyId id : {boxes[0], boxes[2], boxes[3]}) CHECK(pressing(id));
}

TEST_CASE("world: energy never rises by itself while a swarm falls and piles up") {
    World world;
    add_swarm(world, 40);
    EnergyBooks energy(world);
    for (int step = 0; step < 600; ++step) {
        world.step();
        energy.look(world);
    }
    MESSAGE("energy rose by ", energy.risen / energy.start, " of the start in all, above the least before by ",
            energy.max_above_min / energy.start);
    CHECK(energy.risen < 2e-7 * energy.start); // measured: 2e-8
    CHECK(energy.max_above_min < 2e-7 * energy.start);
    CHECK(energy.last < 0.5 * energy.start);
}

TEST_CASE("world: overlapping hulls are moved apart slowly and get no velocity from it") {
    for (const float speed : {0.02f, 0.2f}) {
        WorldSettings settings = empty_space;
        settings.separation_speed = speed;
        World world(settings);
        const BodyId left = must_add(world, box({0.1f, 0.1f, 0.1f}, 1.0f, {-0.05f, 0.0f, 0.0f}));
        const BodyId right = must_add(world, box({0.1f, 0.1f, 0.1f}, 1.0f, {0.05f, 0.0f, 0.0f}));
        float before = 0.1f;
        for (int step = 0; step < 60; ++step) {
            world.step();
            const float apart = glm::length(world.pose(right).position - world.pose(left).position);
            CHECK(apart - before < 1.2f * speed / 120.0f);
            before = apart;
            CHECK(glm::length(world.linear_velocity(left)) < 1e-3f);
        }
        CHECK(before > 0.1f + 0.4f * speed);
    }
}

TEST_CASE("world: the same calls give the same state, in a new world and in a cleared one") {
    const auto play = [](World& world) {
        add_swarm(world, 30);
        run(world, 2.0f);
        return world.state_hash();
    };
    check_repeats(play);
    World world;
    const uint64_t hash = play(world);
    world.step();
    CHECK(world.state_hash() != hash);
}

TEST_CASE("world: a sleeping body wakes when it is pushed, when it is hit and when its support is removed") {
    World world;
    const BodyId below = must_add(world, box({0.2f, 0.1f, 0.2f}, 8.0f, {0.0f, 0.1f, 0.0f}));
    const BodyId above = must_add(world, box({0.1f, 0.1f, 0.1f}, 8.0f, {0.0f, 0.3f, 0.0f}));
    run(world, 3.0f);
    CHECK(world.awake_count() == 0);
    CHECK(world.mechanics().kinetic == 0.0);
    world.apply_impulse(above, {0.0f, 20.0f, 0.0f}, world.pose(above).position);
    CHECK(world.awake(above));
    run(world, 0.3f);
    CHECK(world.pose(above).position.y > 0.5f);
    run(world, 5.0f);
    CHECK(world.awake_count() == 0);
    REQUIRE(world.pose(above).position.y > 0.25f);
    CHECK(world.remove_body(below));
    CHECK(world.awake(above));
    run(world, 3.0f);
    CHECK(world.pose(above).position.y == doctest::Approx(0.1).epsilon(0.02).scale(0.0));
}

TEST_CASE("world: an island wakes as a whole, and other islands sleep on") {
    World world;
    std::vector<BodyId> row, others;
    for (int i = 0; i < 5; ++i)
        row.push_back(must_add(world, box({0.1f, 0.1f, 0.1f}, 8.0f, {0.2f * static_cast<float>(i), 0.1f, 0.0f})));
    for (int i = 0; i < 3; ++i)
        others.push_back(must_add(world, box({0.1f, 0.1f, 0.1f}, 8.0f, {0.2f * static_cast<float>(i), 0.1f, 3.0f})));
    run(world, 3.0f);
    REQUIRE(world.awake_count() == 0);
    const uint64_t before = world.steps_taken();
    must_add(world, box({0.05f, 0.05f, 0.05f}, 1.0f, {0.0f, 0.4f, 0.0f}));
    for (int i = 0; i < 60 && !world.awake(row.front()); ++i) world.step();
    for (const BodyId id : row) CHECK(world.awake(id));
    for (const BodyId id : others) {
        CHECK_FALSE(world.awake(id));
        CHECK(world.last_moved_step(id) < before);
    }
    run(world, 5.0f);
    CHECK(world.awake_count() == 0);
}

TEST_CASE("world: sleeping bodies far away change nothing for awake ones, bit for bit") {
    const auto falls = [](bool among_sleepers) {
        World world;
        const auto add = [&world](const glm::vec3& at) {
            const auto fragments = test::voronoi_pieces({-0.25, 0.3, -0.25}, {0.25, 0.8, 0.25}, 40, 5);
            const auto bodies = add_pieces(world, fragments, {}, {.placement = {at, {1.0f, 0.0f, 0.0f, 0.0f}}});
            REQUIRE(bodies);
            return *bodies;
        };
        if (among_sleepers) {
            add({6.0f, 0.0f, 1.0f});
            run(world, 8.0f);
            REQUIRE(world.awake_count() == 0);
        }
        std::vector<Pose> poses;
        const std::vector<BodyId> bodies = add({0.0f, 0.0f, 0.0f});
        run(world, 2.0f);
        for (const BodyId id : bodies) poses.push_back(world.pose(id));
        return poses;
    };
    const std::vector<Pose> alone = falls(false), beside = falls(true);
    for (size_t i = 0; i < alone.size(); ++i) {
        CHECK(alone[i].position == beside[i].position);
        CHECK(alone[i].orientation == beside[i].orientation);
    }
}

TEST_CASE("world: a body that flies past sleeping ones and wakes them moves as if alone, bit for bit") {
    for (const int sleepers : {2, 40}) {
        CAPTURE(sleepers);
        const auto path = [](int others) {
            World world({.air_density = 0.0f});
            std::vector<BodyId> row;
            for (int i = 0; i < others; ++i)
                row.push_back(must_add(world, box(glm::vec3(0.1f), 8.0f, {0.2f * static_cast<float>(i), 0.1f, 0.0f})));
            run(world, 3.0f);
            REQUIRE(world.awake_count() == 0);
            BodyDesc flies = box(glm::vec3(0.1f), 8.0f, {-0.4f, 0.25f, 0.203f}); // bounds overlap, bodies do not touch
            flies.linear_velocity = {2.0f, 0.0f, 0.0f};
            const BodyId id = must_add(world, flies);
            std::vector<glm::vec3> positions;
            for (int i = 0; i < 18; ++i) {
                world.step();
                positions.push_back(world.pose(id).position);
            }
            for (const BodyId sleeper : row) CHECK(world.awake(sleeper));
            return positions;
        };
        CHECK(path(sleepers) == path(0));
    }
}

TEST_CASE("world: sleeping bodies press as before while others wake, come and go") {
    World world;
    const auto stack_at = [&](float x) {
        return std::pair(must_add(world, box({0.2f, 0.1f, 0.2f}, 8.0f, {x, 0.1f, 0.0f})),
                         must_add(world, box({0.1f, 0.1f, 0.1f}, 8.0f, {x, 0.3f, 0.0f})));
    };
    const auto gone = stack_at(-2.0f), woken = stack_at(0.0f), left = stack_at(2.0f);
    run(world, 3.0f);
    REQUIRE(world.awake_count() == 0);
    // The impulse that carries a body: weight times the time of a step, asleep or not.
    const auto carried = [&](BodyId id) {
        float sum = 0.0f;
        for (const Contact& contact : world.contacts())
            if (contact.normal.y > 0.5f)
                sum += contact.a == id ? contact.impulse : contact.b == id ? -contact.impulse : 0.0f;
            else if (contact.normal.y < -0.5f)
                sum += contact.b == id ? contact.impulse : contact.a == id ? -contact.impulse : 0.0f;
        return sum;
    };
    const float weight = 8.0f * 9.81f / 120.0f;
    const auto check = [&](BodyId id) { CHECK(carried(id) == doctest::Approx(weight).epsilon(0.05)); };
    for (const BodyId id : {gone.first, gone.second, woken.first, woken.second, left.first, left.second}) check(id);

    CHECK(world.remove_body(gone.second));
    CHECK(world.remove_body(gone.first));
    world.step();
    for (const Contact& contact : world.contacts())
        for (const BodyId id : {contact.a, contact.b}) CHECK((id != gone.first && id != gone.second));
    for (const BodyId id : {woken.first, woken.second, left.first, left.second}) check(id);

    world.apply_impulse(woken.second, {0.0f, 20.0f, 0.0f}, world.pose(woken.second).position);
    run(world, 0.2f);
    CHECK(carried(woken.second) == 0.0f);
    for (const BodyId id : {left.first, left.second}) check(id);
    run(world, 4.0f);
    REQUIRE(world.awake_count() == 0);
    for (const BodyId id : {woken.first, left.first, left.second}) check(id);
}

TEST_CASE("world: solved contacts come first, and can be read without the others") {
    const auto same = [](const Contact& a, const Contact& b) {
        return a.a == b.a && a.b == b.b && a.point == b.point && a.normal == b.normal && a.impulse == b.impulse;
    };
    World world;
    const BodyId first = must_add(world, box({0.2f, 0.1f, 0.2f}, 8.0f, {0.0f, 0.1f, 0.0f}));
    must_add(world, box({0.1f, 0.1f, 0.1f}, 8.0f, {0.0f, 0.3f, 0.0f}));
    CHECK(world.solved_contacts().empty());
    run(world, 3.0f);
    REQUIRE(world.awake_count() == 0);
    CHECK(world.solved_contacts().empty());
    CHECK(world.contacts().size() >= 8); // two boxes on four corners each
    const size_t asleep = world.contacts().size();

    const BodyId late = must_add(world, box({0.2f, 0.1f, 0.2f}, 8.0f, {2.0f, 0.1f, 0.0f}));
    world.step();
    const std::vector<Contact> solved(world.solved_contacts().begin(), world.solved_contacts().end());
    REQUIRE(!solved.empty());
    for (const Contact& contact : solved) CHECK((contact.a == late || contact.b == late));
    CHECK(world.contacts().size() == solved.size() + asleep);
    CHECK(std::ranges::equal(solved, world.contacts().first(solved.size()), same));
    CHECK(std::ranges::equal(solved, world.solved_contacts(), same));

    // The solved contacts still name a removed body. The bodies that it carried are awake; their contacts come with the
    // next step.
    world.step();
    CHECK(world.remove_body(late));
    CHECK(!world.solved_contacts().empty());
    CHECK(world.contacts().size() == world.solved_contacts().size() + asleep);
    world.step();
    CHECK(world.solved_contacts().empty());
    CHECK(world.remove_body(first));
    CHECK(world.contacts().empty());
}

TEST_CASE("world: removed bodies are counted") {
    World world;
    CHECK(world.removed_count() == 0);
    const BodyId one = must_add(world, box({0.1f, 0.1f, 0.1f}, 1.0f, {}));
    must_add(world, box({0.1f, 0.1f, 0.1f}, 1.0f, {1.0f, 0.0f, 0.0f}));
    CHECK(world.remove_body(one));
    CHECK(!world.remove_body(one));
    CHECK(world.removed_count() == 1);
    world.clear();
    world.clear();
    CHECK(world.removed_count() == 2);
}

TEST_CASE("world: a body that touches nothing never sleeps at any speed") {
    World world({.gravity = {0.0f, 0.0f, 0.0f}, .ground_height = std::nullopt});
    BodyDesc desc = box({0.1f, 0.1f, 0.1f}, 1.0f, {});
    desc.linear_velocity = {0.01f, 0.0f, 0.0f};
    const BodyId id = must_add(world, desc);
    run(world, 5.0f);
    CHECK(world.awake(id));
    CHECK(world.pose(id).position.x == doctest::Approx(0.05).epsilon(1e-3).scale(0.0));
}

TEST_CASE("world: a visit since a step gets exactly the poses that changed") {
    World world;
    add_swarm(world, 40);
    must_add(world, box({0.2f, 0.1f, 0.2f}, 8.0f, {9.0f, 0.1f, 0.0f}));
    test::Random random(5);
    constexpr Pose untouched{glm::vec3(-1e9f), {1.0f, 0.0f, 0.0f, 0.0f}};
    std::vector<Pose> kept(world.body_count(), untouched);
    uint64_t since = 0;
    size_t most = 0, least = world.body_count();
    for (int frame = 0; frame < 400; ++frame) {
        if (frame == 200) { // some bodies wake, and one is added
            world.apply_impulse(world.bodies()[3], {0.0f, 2.0f, 0.0f}, world.pose(world.bodies()[3]).position);
            must_add(world, box({0.1f, 0.1f, 0.1f}, 8.0f, {-9.0f, 1.0f, 0.0f}));
            kept.resize(world.body_count(), untouched);
        }
        const int steps = static_cast<int>(random.uniform(0.0, 4.0));
        for (int i = 0; i < steps; ++i) world.step();
        const auto alpha = static_cast<float>(random.uniform(0.0, 1.0));
        size_t visited = 0;
        world.visit_poses(alpha, since, [&](size_t i, const Pose& pose) { kept[i] = pose, ++visited; });
        since = world.steps_taken();
        const std::vector<Pose> all = poses_of(world, alpha);
        for (size_t i = 0; i < all.size(); ++i)
            REQUIRE((kept[i].position == all[i].position && kept[i].orientation == all[i].orientation));
        most = std::max(most, visited), least = std::min(least, visited);
    }
    CHECK(most >= 41);
    CHECK(world.awake_count() == 0);
    CHECK(least == 0);
    CHECK(world.last_moved_step(world.bodies()[0]) < world.steps_taken());
}

TEST_CASE("world: small bodies are debris, and lie on each other, larger bodies, fixed ones and the ground") {
    WorldSettings settings;
    settings.debris_size = 0.05f;
    World world(settings);
    BodyDesc shelf = box({0.2f, 0.05f, 0.2f}, 1.0f, {2.0f, 0.05f, 0.0f});
    shelf.fixed = true;
    must_add(world, shelf);
    must_add(world, box({0.2f, 0.05f, 0.2f}, 10.0f, {4.0f, 0.05f, 0.0f}));
    const glm::vec3 crumb(0.01f);
    std::vector<std::pair<BodyId, BodyId>> crumbs;
    for (const auto& place : {std::pair(0.0f, 0.0f), std::pair(2.0f, 0.1f), std::pair(4.0f, 0.1f)}) {
        const float x = place.first, floor = place.second;
        const auto add = [&](float gap) { return must_add(world, box(crumb, 0.02f, {x, floor + 0.01f + gap, 0.0f})); };
        const BodyId below = add(0.001f);
        crumbs.emplace_back(below, add(0.2f));
    }
    run(world, 2.0f);
    for (size_t i = 0; i < crumbs.size(); ++i) {
        CAPTURE(i);
        const glm::vec3 below = world.pose(crumbs[i].first).position, above = world.pose(crumbs[i].second).position;
        CHECK(world.debris(crumbs[i].first));
        CHECK(std::abs(std::min(below.y, above.y) - (i == 0 ? 0.01f : 0.11f)) < 2e-3f);
        CHECK(glm::length(above - below) > 0.018f);
    }
    // In a world without debris, too.
    settings.debris_size = 0.0f;
    World solid(settings);
    for (const float y : {0.011f, 0.033f}) must_add(solid, box(crumb, 0.02f, {0.0f, y, 0.0f}));
    run(solid, 2.0f);
    CHECK(glm::length(solid.pose(solid.bodies()[0]).position - solid.pose(solid.bodies()[1]).position) > 0.018f);
}

TEST_CASE("world: two worlds with different settings, one of them moved, do not disturb each other") {
    World first;
    add_swarm(first, 10);
    World alone;
    add_swarm(alone, 10);
    run(alone, 1.0f);
    World second({.solver_substeps = 5});
    add_swarm(second, 5);
    for (int step = 0; step < 60; ++step) first.step(), second.step();
    World moved = std::move(first);
    for (int step = 0; step < 60; ++step) moved.step(), second.step();
    CHECK(moved.state_hash() == alone.state_hash());
}

TEST_CASE("world: a body beyond all bounds stops where it is and disturbs no other") {
    const auto ends = [](bool astray) {
        World world;
        const BodyId stays = must_add(world, box({0.1f, 0.1f, 0.1f}, 1.0f, {0.0f, 0.5f, 0.0f}));
        BodyDesc far = box({0.1f, 0.1f, 0.1f}, 1.0f, {5.0f, 5.0f, 0.0f});
        far.linear_velocity = {1e9f, 0.0f, 0.0f};
        BodyId gone;
        if (astray) gone = must_add(world, far);
        run(world, 1.0f);
        if (astray) CHECK(std::isfinite(world.pose(gone).position.x));
        return world.pose(stays).position;
    };
    CHECK(ends(true) == ends(false));
}

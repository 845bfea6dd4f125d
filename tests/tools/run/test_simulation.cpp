// Simulations: scheduled actions, grabbing, blows, and the poses that a frame must write.
#include "tools/scenario/run/simulation.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "tests/tools/scenes.h"
#include "tests/tools/wall.h"

using namespace brittle;
using namespace brittle::tools;
using namespace brittle::tools::test;

TEST_CASE("simulation: without pieces, actions and steps do nothing") {
    Simulation simulation;
    CHECK(!simulation.running());
    for (const Action& action : {Action(Damage{}), Action(Saw{}), Action(Release{}), Action(Drag{}), Action(LetGo{})})
        simulation.apply(action);
    simulation.step();
    CHECK(simulation.steps() == 1);
    simulation.start(fracture::Fragments{}, {});
    CHECK(simulation.steps() == 0);
    simulation.step();
    CHECK(!simulation.running());
}

TEST_CASE("simulation: a breakable object starts whole, is cut where it is hit, and its foot is held") {
    FractureOptions options;
    options.mesh = "shape:wall";
    use_material("concrete", options);
    options.world = {.anchored = true, .breakable = true};
    const fracture::Fragments whole = started(options);
    REQUIRE(whole.pieces.size() == 1);
    Simulation simulation(options.material);
    simulation.start(whole, options.world);
    const double volume = simulation.destruction()->solid({0})->mass.volume;
    for (int k = 0; k < 60; ++k) simulation.step();
    CHECK(simulation.number_count() == 1);
    CHECK(simulation.world().fixed(simulation.body_of(0)));
    CHECK(simulation.structure() == nullptr);
    simulation.apply(Hammer{0, {0.0, 1.1, 0.1}, {0.0, 0.0, -1e-3}}); // below the bearable impulse
    simulation.apply(Hammer{0, {0.0, 1.1, 0.1}, {0.0, 0.0, -80.0}});
    for (int k = 0; k < 60; ++k) simulation.step();
    CHECK(simulation.body_of(0) == physics::BodyId{});
    CHECK(simulation.number_count() > 3);
    double sum = 0.0;
    int held = 0;
    for (const physics::PieceId piece : simulation.destruction()->pieces()) {
        sum += simulation.destruction()->solid(piece)->mass.volume;
        held += simulation.world().fixed(simulation.body_of(piece.value));
        CHECK(simulation.pieces_of(simulation.body_of(piece.value)) == std::vector<uint32_t>{piece.value});
    }
    CHECK(sum == doctest::Approx(volume).epsilon(1e-12));
    CHECK(held == 1);
    // Actions on pieces that are gone, or never existed, have no effect.
    for (const Action& action : {Action(Hammer{0, {}, {0, 0, 9}}), Action(Push{99'999, {}, {1, 0, 0}}),
                                 Action(Grab{0, {}}), Action(Release{{0, 5}}), Action(Damage{}), Action(Saw{})})
        simulation.apply(action);
    simulation.step();
}

TEST_CASE("simulation: pieces beyond the limit of colliding ones are debris, by the options of each start") {
    FractureOptions options = wall_options();
    options.world = {.height = 0.5};
    const fracture::Fragments pieces = started(options);
    REQUIRE(pieces.pieces.size() > 20);
    Simulation simulation(options.material);
    for (const uint32_t most : {10u, 0u, 20u}) {
        options.world.max_colliding = most;
        simulation.start(pieces, options.world);
        CHECK(simulation.world().settings().max_colliding == most);
        CHECK(simulation.world().colliding_count() == (most == 0 ? pieces.pieces.size() : most));
    }
}

TEST_CASE("simulation: poses since a step are the changed ones") {
    FractureOptions options = wall_options();
    for (const bool breakable : {false, true}) {
        for (const bool bonded : {false, true}) {
            CAPTURE(breakable);
            CAPTURE(bonded);
            options.world = {.bonded = bonded, .height = 0.0, .breakable = breakable};
            Simulation simulation(options.material);
            simulation.start(started(options), options.world);
            simulation.schedule(3, Shoot{{0.3, 0.5, 2.0}, {0.0, 0.0, -20.0}, 0.15, 7800.0});
            std::vector<physics::Pose> kept(2000);
            uint64_t written = 0;
            std::mt19937 random(4);
            for (int frame = 0; frame < 120; ++frame) {
                const float alpha = simulation.advance(static_cast<double>(random() % 30) * 1e-3);
                simulation.visit_poses(alpha, written,
                                       [&](uint32_t slot, const physics::Pose& pose) { kept[slot] = pose; });
                written = simulation.steps();
                simulation.visit_poses(alpha, 0, [&](uint32_t slot, const physics::Pose& pose) {
                    CHECK(kept[slot].position == pose.position);
                    CHECK(kept[slot].orientation == pose.orientation);
                });
            }
            CHECK(simulation.steps() > 60);
            if (breakable && !bonded) CHECK(simulation.number_count() > 1);
        }
    }
}

TEST_CASE("simulation: invalid actions are reported") {
    const double nan = std::nan("");
    CHECK(fault_of(Shoot{}, 0).empty());
    CHECK(fault_of(Shoot{.from = {nan, 0, 0}}, 0).find("from") != std::string::npos);
    CHECK(fault_of(Shoot{.velocity = {0, HUGE_VAL, 0}}, 0).find("velocity") != std::string::npos);
    CHECK(fault_of(Shoot{.radius = 0.0}, 0).find("radius") != std::string::npos);
    CHECK(fault_of(Shoot{.density = nan}, 0).find("density") != std::string::npos);
    CHECK(fault_of(Damage{.radius = -1.0}, 0).find("radius") != std::string::npos);
    CHECK(fault_of(Saw{.amount = nan}, 0).find("amount") != std::string::npos);
    CHECK(fault_of(Hammer{.piece = 3}, 3).find("piece is 3") != std::string::npos);
    CHECK(fault_of(Hammer{.point = {nan, 0, 0}}, 3).find("point") != std::string::npos);
    CHECK(fault_of(Hammer{.piece = 2}, 3).empty());
    CHECK(fault_of(Push{.piece = 0}, 0).find("piece") != std::string::npos);
    CHECK(fault_of(Grab{.piece = 9}, 9).find("piece") != std::string::npos);
    CHECK(fault_of(Release{{0, 5}}, 5).find("piece is 5") != std::string::npos);
    CHECK(fault_of(Drag{{0, 0, nan}}, 0).find("to") != std::string::npos);
}

TEST_CASE("simulation: a scheduled action takes effect at its step, in the order of calls") {
    struct Diary : SimulationObserver {
        std::string text;
        void stepped(const Simulation& simulation) override { text += " " + std::to_string(simulation.steps()); }
        void acted(uint64_t step, const Action& action) override {
            text += " @" + std::to_string(step) + "kind" + std::to_string(action.index());
        }
    } diary;
    Simulation simulation;
    simulation.observe(&diary);
    simulation.start(started(wall_options()), {.bonded = true, .shots = {{.time = 2.0 / 120.0}}});
    simulation.schedule(3, Drag{});
    simulation.schedule(1, LetGo{});
    simulation.schedule(3, LetGo{});
    simulation.schedule(0, Drag{});
    for (int k = 0; k < 4; ++k) simulation.step();
    simulation.schedule(2, LetGo{}); // step 2 has passed, so it takes effect at once
    CHECK(diary.text == " @0kind7 1 @1kind8 2 @2kind0 3 @3kind7 @3kind8 4 @4kind8");
    CHECK(simulation.balls().size() == 1);
}

TEST_CASE("simulation: a grabbed piece comes to the hand, stays there, and falls when released") {
    FractureOptions options;
    options.mesh = "shape:cube";
    options.pattern.count = 1;
    for (const bool bonded : {false, true}) {
        options.world = {.bonded = bonded, .height = 1.0};
        Simulation simulation;
        simulation.start(started(options), options.world);
        const auto position = [&] { return simulation.pose_of(0).position; };
        simulation.apply(Grab{0, glm::dvec3(position())});
        simulation.apply(Drag{{1.5, 4.0, -0.5}});
        for (int k = 0; k < 120; ++k) simulation.step();
        // The piece approaches at ten times its distance a second. Gravity in one step holds it off by at most 1/1200
        // of that.
        CHECK(glm::distance(position(), glm::vec3(1.5f, 4.0f, -0.5f)) < 0.02f);
        simulation.apply(LetGo{});
        const float before = position().y;
        for (int k = 0; k < 60; ++k) simulation.step();
        CHECK(before - position().y == doctest::Approx(0.5 * 9.81 * 0.25).epsilon(0.05));
    }
}

// The kinds of pieces that a run on stock Bullet may have: loose, bonded, whole and breakable, bonded and breakable.
TEST_CASE("simulation: on stock Bullet a wall breaks and comes to rest, whatever its pieces") {
    for (const bool breakable : {false, true})
        for (const bool bonded : {false, true}) {
            CAPTURE(breakable);
            CAPTURE(bonded);
            FractureOptions options = wall_options();
            options.world = {
                .engine = physics::EngineKind::bullet,
                .bonded = bonded,
                .height = 0.0,
                .breakable = breakable,
                .shots = {{.time = 0.1, .from = {0.3, 0.6, 2.0}, .velocity = {0.0, 0.0, -25.0}, .radius = 0.15}}};
            Simulation simulation(options.material);
            const fracture::Fragments pieces = started(options);
            simulation.start(pieces, options.world);
            const physics::World& world = simulation.world();
            CHECK(world.settings().engine == physics::EngineKind::bullet);
            const size_t bodies = world.body_count();
            bool finite = true;
            const auto lowest_centre = [&](uint64_t since) {
                float lowest = 0.0f;
                simulation.visit_poses(1.0f, since, [&](uint32_t, const physics::Pose& pose) {
                    finite = finite && std::isfinite(glm::length(pose.position) + pose.orientation.w);
                    lowest = std::min(lowest, pose.position.y);
                });
                return lowest;
            };
            while (simulation.steps() < 20 * 120 && (simulation.steps() < 120 || world.awake_count() > 0)) {
                simulation.step();
                CHECK(lowest_centre(simulation.steps()) > -0.15f); // stock Bullet's sliding bodies sink, and come up
            }
            CHECK(lowest_centre(0) > -1e-3f);
            CHECK(finite);
            CHECK(world.awake_count() == 0);
            if (bonded || breakable) CHECK(world.body_count() > bodies + 1); // the ball is one more
        }
}

TEST_CASE("simulation: on stock Bullet a grabbed piece comes to the hand, and equal actions give equal states") {
    FractureOptions options = wall_options();
    options.world.engine = physics::EngineKind::bullet;
    const fracture::Fragments pieces = started(options);
    uint64_t hash = 0;
    for (int run = 0; run < 2; ++run) {
        Simulation simulation(options.material);
        simulation.start(pieces, options.world);
        simulation.apply(Release{});
        simulation.apply(Damage{{0.0, 0.5, 0.0}, 10.0, 1.0});
        simulation.schedule(10, Grab{20, {0.0, 1.0, 0.0}});
        simulation.schedule(11, Drag{{0.5, 1.5, 1.0}});
        for (int k = 0; k < 240; ++k) simulation.step();
        CHECK(simulation.world().body_count() > 1);
        if (run > 0) CHECK(simulation.state_hash() == hash);
        hash = simulation.state_hash();
    }
    // Another engine in the next start of one simulation.
    Simulation simulation(options.material);
    simulation.start(pieces, options.world);
    options.world.engine = physics::EngineKind::solver;
    simulation.start(pieces, options.world);
    CHECK(simulation.world().settings().engine == physics::EngineKind::solver);
    simulation.step();
}

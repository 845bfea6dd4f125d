// Simulations, their replay logs, and that a run repeats to the bit: from every scene that moves, at any
// frame rate, with any number of threads.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "tests/tools/support.h"
#include "tests/tools/wall.h"
#include "tools/brittle/failure.h"
#include "tools/brittle/input.h"
#include "tools/brittle/recipe.h"
#include "tools/brittle/replay/body_text.h"
#include "tools/brittle/replay/log.h"
#include "tools/brittle/replay/player.h"
#include "tools/brittle/replay/recorder.h"
#include "tools/brittle/simulation.h"
#include "tools/brittle/stage.h"

using namespace brittle;
using namespace brittle::tools;
using namespace brittle::tools::test;
namespace fs = std::filesystem;

namespace {

std::string content(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

fracture::Fragments broken(const FractureOptions& options) {
    const Input input = placed_on_stage(load_input(options), options.world);
    return break_input(input, options).fragments;
}

// One action of each kind at various steps, against the wall.
std::vector<std::pair<uint64_t, Action>> various_actions() {
    return {{0, Shoot{{0.3, 0.5, 2.0}, {0.0, 0.0, -20.0}, 0.15, 7800.0}},
            {5, Damage{{-0.6, 0.9, 0.0}, 0.3, 0.7}},
            {5, Saw{{-1.0, 0.7, 0.0}, {0.1, 0.7, 0.0}, 0.02, 1.0}},
            {20, Hammer{12, {0.4, 0.5, -0.1}, {0.0, 0.0, 900.0}}},
            {21, Grab{20, {0.0, 1.0, 0.0}}},
            {22, Drag{{0.5, 1.5, 0.6}}},
            {40, Push{3, {0.1, 0.2, 0.0}, {1.0, 2.0, 3.0}}},
            {41, Release{{0, 1}}},
            {60, LetGo{}},
            {60, Release{}}};
}

// The log of so many steps, driven by whole steps.
ReplayLog recorded(const FractureOptions& options, const fracture::Fragments& fragments, uint64_t steps,
                   const std::vector<std::pair<uint64_t, Action>>& actions, const fs::path& file) {
    Simulation simulation(options.material);
    Recorder recorder(file, options);
    simulation.observe(&recorder);
    simulation.start(fragments, world_of(options));
    for (const auto& [step, action] : actions) simulation.schedule(step, action);
    while (simulation.steps() < steps) simulation.step();
    recorder.finish();
    return read_replay_log(file);
}

std::optional<Difference> replayed(const ReplayLog& log, const fracture::Fragments& fragments) {
    Simulation simulation(log.recipe.material);
    Player player(log);
    simulation.observe(&player);
    follow(log, simulation);
    simulation.start(fragments, world_of(log.recipe));
    if (!player.difference()) schedule(log, simulation);
    while (!player.done() && !player.difference()) simulation.step();
    return player.difference();
}

std::string message_of(const fs::path& file) {
    try {
        (void)read_replay_log(file);
    } catch (const Failure& failure) {
        CHECK(failure.code() == exit_input);
        return failure.what();
    }
    return "";
}

} // namespace

TEST_CASE("body checks: texts are counted and compared, damaged ones are none") {
    CHECK(count_bodies("") == 0);
    CHECK(count_bodies("00ff(3)abcd(1)") == 6);
    for (const char* bad : {"0", "00f", "00FF", "00fg", "(", "()", "(0)", "(3", "(-1)", "(3)1",
                            "(99999999999999999999)", "(100000000)(100000000)", " 00ff", "(3 )"})
        CHECK_MESSAGE(!count_bodies(bad), bad);
    CHECK(!first_difference("00ff(3)abcd", "00ff(3)abcd"));
    CHECK(!first_difference("00ff(3)abcd", "00ff(1)(2)abcd"));
    CHECK(first_difference("00ff(3)abcd", "00ff(3)abce") == 4);
    CHECK(first_difference("00ff(3)", "00ff(1)abcd(1)") == 2);
    CHECK(first_difference("(3)", "(2)0000") == 2);
    CHECK(first_difference("1111(3)", "0000(3)") == 0);
}

TEST_CASE("simulation: with nothing there, actions and steps do nothing") {
    Simulation simulation;
    CHECK(!simulation.running());
    for (const Action& action :
         {Action(Damage{}), Action(Saw{}), Action(Release{}), Action(Drag{}), Action(LetGo{})})
        simulation.apply(action);
    simulation.step();
    CHECK(simulation.steps() == 1);
    simulation.start({}, {});
    CHECK(simulation.steps() == 0);
    simulation.step();
    CHECK(!simulation.running());
}

TEST_CASE("simulation: a breakable thing stays whole, is cut where it is hit, and its foot is held") {
    FractureOptions options;
    options.mesh = "shape:wall";
    use_material("concrete", options);
    options.world = {.anchored = true, .breakable = true};
    const fracture::Fragments whole = broken(options);
    REQUIRE(whole.pieces.size() == 1);
    Simulation simulation(options.material);
    simulation.start(whole, options.world);
    const double volume = simulation.destruction()->solid({0})->mass.volume;
    for (int k = 0; k < 60; ++k) simulation.step();
    CHECK(simulation.number_count() == 1);
    CHECK(simulation.world().fixed(simulation.body_of(0)));
    CHECK(simulation.structure() == nullptr);
    simulation.apply(Hammer{0, {0.0, 1.1, 0.1}, {0.0, 0.0, -1e-3}}); // too weak
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
    // What is no longer there, or never was, is left alone.
    for (const Action& action : {Action(Hammer{0, {}, {0, 0, 9}}), Action(Push{99'999, {}, {1, 0, 0}}),
                                 Action(Grab{0, {}}), Action(Release{{0, 5}}), Action(Damage{}), Action(Saw{})})
        simulation.apply(action);
    simulation.step();
}

TEST_CASE("simulation: poses since a step are those that changed") {
    FractureOptions options = test::wall_options();
    for (const bool breakable : {false, true}) {
        for (const bool bonded : {false, true}) {
            CAPTURE(breakable);
            CAPTURE(bonded);
            options.world = {.bonded = bonded, .height = 0.0, .breakable = breakable};
            Simulation simulation(options.material);
            simulation.start(broken(options), options.world);
            simulation.schedule(3, Shoot{{0.3, 0.5, 2.0}, {0.0, 0.0, -20.0}, 0.15, 7800.0});
            std::vector<physics::Pose> kept(2000);
            uint64_t written = 0;
            std::mt19937 random(4);
            for (int frame = 0; frame < 120; ++frame) {
                const float alpha = simulation.advance(static_cast<double>(random() % 30) * 1e-3);
                simulation.visit_poses(alpha, written, [&](uint32_t slot, const physics::Pose& pose) {
                    kept[slot] = pose;
                });
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

TEST_CASE("simulation: actions that make no sense are named") {
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

TEST_CASE("simulation: what is scheduled takes effect at its step, in the order of calls") {
    struct Diary : SimulationObserver {
        std::string text;
        void stepped(const Simulation& simulation) override {
            text += " " + std::to_string(simulation.steps());
        }
        void acted(uint64_t step, const Action& action) override {
            text += " @" + std::to_string(step) + "kind" + std::to_string(action.index());
        }
    } diary;
    Simulation simulation;
    simulation.observe(&diary);
    simulation.start(broken(test::wall_options()), {.bonded = true, .shots = {{.time = 2.0 / 120.0}}});
    simulation.schedule(3, Drag{});
    simulation.schedule(1, LetGo{});
    simulation.schedule(3, LetGo{});
    simulation.schedule(0, Drag{});
    for (int k = 0; k < 4; ++k) simulation.step();
    simulation.schedule(2, LetGo{}); // over: at once
    CHECK(diary.text == " @0kind7 1 @1kind8 2 @2kind0 3 @3kind7 @3kind8 4 @4kind8");
    CHECK(simulation.balls().size() == 1);
}

TEST_CASE("simulation: what is grabbed comes to the hand, stays there, and falls when it is let go") {
    FractureOptions options;
    options.mesh = "shape:cube";
    options.pattern.count = 1;
    for (const bool bonded : {false, true}) {
        options.world = {.bonded = bonded, .height = 1.0};
        Simulation simulation;
        simulation.start(broken(options), options.world);
        const auto position = [&] {
            std::vector<physics::Pose> pose(1);
            simulation.write_poses(pose, 1.0f);
            return pose[0].position;
        };
        simulation.apply(Grab{0, glm::dvec3(position())});
        simulation.apply(Drag{{1.5, 4.0, -0.5}});
        for (int k = 0; k < 120; ++k) simulation.step();
        // Ten times a second nearer by its distance, less what gravity pulls it off in a step: 1/1200 of it
        // at most.
        CHECK(glm::distance(position(), glm::vec3(1.5f, 4.0f, -0.5f)) < 0.02f);
        simulation.apply(LetGo{});
        const float before = position().y;
        for (int k = 0; k < 60; ++k) simulation.step();
        CHECK(before - position().y == doctest::Approx(0.5 * 9.81 * 0.25).epsilon(0.05));
    }
}

TEST_CASE("replay: what is recorded is read again to the last bit, with every kind of action") {
    const Folder folder;
    const FractureOptions options = test::wall_options();
    const auto actions = various_actions();
    const ReplayLog log = recorded(options, broken(options), 80, actions, folder.path / "run.log");
    CHECK(log.end == "finished");
    CHECK(log.states.size() == 81);
    REQUIRE(log.actions.size() == actions.size());
    for (size_t k = 0; k < actions.size(); ++k) {
        CHECK(log.actions[k].first == actions[k].first);
        CHECK(action_line(0, log.actions[k].second) == action_line(0, actions[k].second));
        CHECK(log.actions[k].second.index() == actions[k].second.index());
    }
    CHECK(recipe_json(log.recipe) == recipe_json(options));
    CHECK(other_build(log).empty());
    // Written out again it is the same file.
    std::string text = header_line(log, folder.path);
    size_t action = 0;
    for (uint64_t step = 0; step < log.states.size(); ++step) {
        text += state_line(step, log.states[step]);
        for (; action < log.actions.size() && log.actions[action].first == step; ++action)
            text += action_line(step, log.actions[action].second);
    }
    CHECK(text + end_line(80, log.end) == content(folder.path / "run.log"));
}

TEST_CASE("replay: mesh and sites in files are found from where the log lies") {
    const Folder folder;
    FractureOptions options;
    options.mesh = BRITTLE_CORPUS "/meshes/cube.obj";
    options.sites_file = BRITTLE_ASSETS "/sites/clip_steps.txt";
    options.fit_sites = true;
    fs::current_path(folder.path);
    fs::copy_file(options.mesh, "mesh.obj");
    options.mesh = "mesh.obj";
    fs::create_directory("logs");
    const ReplayLog log = recorded(options, broken(options), 3, {}, "logs/run.log");
    fs::current_path(fs::temp_directory_path());
    const ReplayLog again = read_replay_log(folder.path / "logs" / "run.log");
    CHECK(!replayed(again, broken(again.recipe)));
}

TEST_CASE("replay: at other frame rates and with other threads the states are equal") {
    const Folder folder;
    const FractureOptions options = test::wall_options();
    const ReplayLog log = recorded(options, broken(options), 120, various_actions(), folder.path / "run.log");
    CHECK(log.states.front().hash != log.states.back().hash);
    for (const uint32_t threads : {1u, 2u, 4u}) {
        FractureOptions threaded = log.recipe;
        threaded.threads = threads;
        CHECK_FALSE(replayed(log, broken(threaded)));
    }
    std::mt19937 random(11);
    for (const double rate : {20.0, 60.0, 144.0, 1000.0, 0.0}) {
        CAPTURE(rate);
        Simulation simulation(log.recipe.material);
        Player player(log);
        simulation.observe(&player);
        simulation.start(broken(log.recipe), log.recipe.world);
        schedule(log, simulation);
        while (!player.done())
            simulation.advance(rate > 0.0 ? 1.0 / rate : static_cast<double>(random() % 50) * 1e-3);
        CHECK_FALSE(player.difference());
    }
}

namespace {

// A ball that stands, whole, and is shot at and struck; or a bonded wall.
FractureOptions breakable_options(bool bonded) {
    FractureOptions options = test::wall_options();
    options.world.breakable = true;
    options.world.bonded = bonded;
    options.world.min_size = 0.04;
    if (!bonded) options.mesh = "shape:icosphere:2";
    return options;
}

// Piece 3 is not there before the first blow's cut.
std::vector<std::pair<uint64_t, Action>> blows() {
    return {{0, Shoot{{0.3, 0.8, 3.0}, {0.0, 0.0, -25.0}, 0.15, 7800.0}},
            {20, Hammer{0, {-0.6, 0.9, 0.3}, {20.0, -40.0, 0.0}}},
            {25, Hammer{3, {0.0, 0.5, 0.0}, {0.0, -60.0, 0.0}}},
            {30, Shoot{{0.0, 0.9, 3.0}, {0.0, 0.0, -25.0}, 0.1, 7800.0}},
            {60, Push{5, {0.0, 0.5, 0.0}, {1.0, 20.0, 3.0}}}};
}

} // namespace

TEST_CASE("replay: what is cut anew repeats, by its own latency and by the log, with any threads") {
    const Folder folder;
    for (const bool bonded : {false, true}) {
        CAPTURE(bonded);
        const FractureOptions options = breakable_options(bonded);
        const ReplayLog log = recorded(options, broken(options), 120, blows(), folder.path / "run.log");
        CHECK(log.commits.size() >= 2);
        CHECK(log.pieces == (bonded ? broken(options).pieces.size() : 1));
        for (const uint32_t threads : {1u, 2u, 4u}) {
            CAPTURE(threads);
            FractureOptions threaded = log.recipe;
            threaded.threads = threads;
            const fracture::Fragments fragments = broken(threaded);
            CHECK_FALSE(replayed(log, fragments));
            Simulation simulation(log.recipe.material); // by itself: with the latency that it was recorded with
            Player player(log);
            simulation.observe(&player);
            simulation.start(fragments, world_of(log.recipe),
                             prepare_bodies(fragments, world_of(log.recipe), log.recipe.material, {}, threads));
            schedule(log, simulation);
            while (!player.done() && !player.difference()) simulation.advance(0.017);
            CHECK_FALSE(player.difference());
        }
        // A cut that is left out is missed in the step that it was part of.
        ReplayLog damaged = log;
        damaged.commits.erase(damaged.commits.begin());
        const std::optional<Difference> difference = replayed(damaged, broken(log.recipe));
        REQUIRE(difference);
        CHECK(difference->step == log.commits.front().step);
        // So is one too early; jobs that there never are, are nothing.
        damaged = log;
        damaged.commits.insert(damaged.commits.begin(), {1, 7'000'000});
        CHECK_FALSE(replayed(damaged, broken(log.recipe)));
    }
}

TEST_CASE("replay: the recipe's seed says where blows cut, and is in the log") {
    const Folder folder;
    FractureOptions options = breakable_options(false);
    use_material(options.material, options); // its own way to break, which is also that of sites by themselves
    const fracture::Fragments whole = broken(options); // what starts whole has no sites that a seed could move
    const auto states_of = [&](uint64_t seed) {
        options.pattern.seed = seed;
        const ReplayLog log = recorded(options, whole, 60, blows(), folder.path / "run.log");
        CHECK(log.commits.size() >= 1);
        CHECK_FALSE(replayed(log, broken(log.recipe)));
        return log.states.back().hash;
    };
    const uint64_t first = states_of(11);
    CHECK(states_of(12) != first);
    CHECK(states_of(11) == first);
    // Also where sites are points, which have no seed of their own.
    options.points = {{0.0, 0.0, 0.0}};
    CHECK(states_of(11) == first);
}

TEST_CASE("replay: a run whose cuts came when they were ready repeats by its log") {
    const Folder folder;
    for (const bool bonded : {false, true}) {
        CAPTURE(bonded);
        const FractureOptions options = breakable_options(bonded);
        Simulation simulation(options.material);
        Recorder recorder(folder.path / "run.log", options);
        simulation.observe(&recorder);
        simulation.commit_as(physics::Timing::when_ready);
        simulation.start(broken(options), world_of(options));
        for (const auto& [step, action] : blows()) simulation.schedule(step, action);
        // Until all is cut, however long the worker takes: nothing here depends on a clock but the steps of the cuts.
        while (simulation.steps() < 100 || (simulation.destruction()->jobs_in_flight() > 0 && simulation.steps() < 20'000)) {
            simulation.step();
            // Steps of a world at rest take no time: twenty thousand are over before a busy machine's worker has begun.
            if (simulation.steps() > 100) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        recorder.finish();
        const ReplayLog log = read_replay_log(folder.path / "run.log");
        CHECK(log.commits.size() >= 2);
        CHECK_FALSE(replayed(log, broken(log.recipe)));
    }
}

TEST_CASE("replay: damaged lines of cuts are refused") {
    const Folder folder;
    FractureOptions options = breakable_options(false);
    recorded(options, broken(options), 40, blows(), folder.path / "good.log");
    const std::string good = content(folder.path / "good.log");
    const size_t at = good.rfind('\n', good.find(R"("commit":{)")) + 1; // the header names the build's commit
    const std::string line = good.substr(at, good.find('\n', at) - at);
    REQUIRE(line.find("commit") != std::string::npos);
    const auto with = [&](const std::string& other) {
        std::string text = good;
        text.replace(at, line.size(), other);
        return message_of(folder.write("run.log", text));
    };
    CHECK(with(line).empty());
    CHECK(with(R"({"after":1,"commit":{"job":0}})").find("/after: 1 is not the step") != std::string::npos);
    CHECK(with(R"({"commit":{"job":0}})").find("/after: is missing") != std::string::npos);
    const std::string after = line.substr(0, line.find(",\"commit"));
    CHECK(with(after + R"(,"commit":{}})").find("/commit/job: is missing") != std::string::npos);
    CHECK(with(after + R"(,"commit":{"job":-1}})").find("/commit/job") != std::string::npos);
    CHECK(with(after + R"(,"commit":{"job":1,"by":2}})").find("/commit/by: unknown key") != std::string::npos);
    CHECK(with(after + R"(,"commit":{"job":1},"let_go":{}})").find("/let_go: unknown key") != std::string::npos);
    CHECK(with(after + R"(,"commit":[]})").find("/commit") != std::string::npos);
    // Where nothing is breakable there are none.
    std::string text = good;
    const std::string flag = R"("breakable":true)";
    text.replace(text.find(flag), flag.size(), R"("breakable":false)");
    CHECK(message_of(folder.write("run.log", text)).find("nothing is breakable") != std::string::npos);
}

TEST_CASE("replay: actions between frames at any time are recorded at their step") {
    const Folder folder;
    const FractureOptions options = test::wall_options();
    const fracture::Fragments fragments = broken(options);
    Simulation simulation(options.material);
    Recorder recorder(folder.path / "run.log", options);
    simulation.observe(&recorder);
    simulation.start(fragments, options.world);
    std::mt19937 random(3);
    for (int frame = 0; frame < 60; ++frame) {
        simulation.advance(static_cast<double>(random() % 40) * 1e-3);
        if (frame == 7) simulation.apply(Shoot{{0.3, 0.5, 2.0}, {0.0, 0.0, -20.0}, 0.15, 7800.0});
        if (frame == 20) simulation.apply(Grab{25, {0.8, 1.1, 0.0}});
        if (frame >= 20 && frame < 50) simulation.apply(Drag{{0.8, 1.1 + 0.02 * frame, 0.02 * frame}});
        if (frame == 50) simulation.apply(LetGo{});
    }
    recorder.finish();
    const ReplayLog log = read_replay_log(folder.path / "run.log");
    CHECK(log.actions.size() == 33);
    CHECK_FALSE(replayed(log, fragments));
}

TEST_CASE("replay: what differs is found at its step, with the body") {
    const Folder folder;
    FractureOptions options = test::wall_options();
    options.world = {.height = 0.2}; // loose pieces: a body each
    const fracture::Fragments fragments = broken(options);
    // Out of the wall first, so that the second push is felt by this piece alone.
    const glm::dvec3 centre = fragments.pieces[7].mass.centre_of_mass;
    const Push out{7, centre, {0.0, 0.0, 200.0}},
        push{7, centre + glm::dvec3(0.0, 0.0, 1.0), {0.0, 0.0, 5.0}};
    ReplayLog log = recorded(options, fragments, 40, {{0, out}, {25, push}}, folder.path / "run.log");
    CHECK_FALSE(replayed(log, fragments));

    SUBCASE("an action that is missing") {
        log.actions.pop_back();
        const auto difference = replayed(log, fragments);
        REQUIRE(difference);
        CHECK(difference->step == 26);
        CHECK(difference->what.find("body 7 (piece 7)") != std::string::npos);
    }
    SUBCASE("an action a step later") {
        log.actions[1].first = 26;
        const auto difference = replayed(log, fragments);
        REQUIRE(difference);
        CHECK(difference->step == 26);
        CHECK(difference->what.find("body 7 (piece 7)") != std::string::npos);
    }
    SUBCASE("an action changed by the smallest amount that a float shows") {
        std::get<Push>(log.actions[1].second).impulse.z = static_cast<double>(std::nextafter(5.0f, 6.0f));
        const auto difference = replayed(log, fragments);
        REQUIRE(difference);
        CHECK(difference->step >= 26);
    }
    SUBCASE("a ball more") {
        log.actions.emplace_back(30, Shoot{{0.0, 5.0, 0.0}, {}, 0.1, 1000.0});
        const auto difference = replayed(log, fragments);
        REQUIRE(difference);
        CHECK(difference->step == 31);
        CHECK(difference->what.find(std::to_string(fragments.pieces.size())
                                    + " bodies were recorded, there are "
                                    + std::to_string(fragments.pieces.size() + 1))
              != std::string::npos);
    }
    SUBCASE("another hash") {
        log.states[13].hash ^= 1;
        const auto difference = replayed(log, fragments);
        REQUIRE(difference);
        CHECK(difference->step == 13);
    }
    SUBCASE("other pieces") {
        FractureOptions other = options;
        other.pattern.count = 60;
        const auto difference = replayed(log, broken(other));
        REQUIRE(difference);
        CHECK(difference->step == 0);
        CHECK(difference->what.find("pieces") != std::string::npos);
    }
}

TEST_CASE("replay: a log of what was interrupted tells the run so far, a new start begins a new one") {
    const Folder folder;
    const FractureOptions options = test::wall_options();
    const fracture::Fragments fragments = broken(options);
    {
        Simulation simulation(options.material);
        Recorder recorder(folder.path / "run.log", options);
        simulation.observe(&recorder);
        simulation.start(fragments, options.world);
        for (int k = 0; k < 9; ++k) simulation.step();
        simulation.clear();
        simulation.start(fragments, options.world);
        for (int k = 0; k < 5; ++k) simulation.step();
        CHECK(!fs::exists(folder.path / "run.log"));
    } // as an exception would
    const ReplayLog log = read_replay_log(folder.path / "run.log");
    CHECK(log.end == "failed");
    CHECK(log.states.size() == 6);
    CHECK_FALSE(replayed(log, fragments));
}

TEST_CASE("replay: nothing started, nothing written, a folder that is not there is an output error") {
    const Folder folder;
    const FractureOptions options = test::wall_options();
    Recorder(folder.path / "run.log", options).finish();
    CHECK(!fs::exists(folder.path / "run.log"));
    Simulation simulation;
    Recorder recorder(folder.path / "none" / "run.log", options);
    simulation.observe(&recorder);
    simulation.start(broken(options), options.world);
    try {
        recorder.finish();
        FAIL("written into nowhere");
    } catch (const Failure& failure) {
        CHECK(failure.code() == exit_output);
    }
}

TEST_CASE("replay: damaged logs are refused with line and field") {
    const Folder folder;
    CHECK(message_of(folder.path / "none.log").find("cannot be read") != std::string::npos);
    CHECK(message_of(folder.write("run.log", "")).find("empty") != std::string::npos);
    const FractureOptions options = test::wall_options();
    recorded(options, broken(options), 2, {{1, Shoot{}}}, folder.path / "good.log");
    std::vector<std::string> lines; // header, state 0, state 1, action, state 2, end
    std::ifstream stream(folder.path / "good.log");
    for (std::string line; std::getline(stream, line);) lines.push_back(line + "\n");
    REQUIRE(lines.size() == 6);
    const auto with = [&](size_t line, const std::string& from, const std::string& to) {
        std::string text;
        for (size_t k = 0; k < lines.size(); ++k) {
            std::string one = lines[k];
            if (k == line) {
                REQUIRE(one.find(from) != std::string::npos);
                one.replace(one.find(from), from.size(), to);
            }
            text += one;
        }
        return message_of(folder.write("run.log", text));
    };
    struct Case {
        size_t line;
        const char *from, *to, *message;
    };
    const Case cases[] = {
        {0, R"("brittle_log":1)", R"("brittle_log":2)",
         "run.log:1: /brittle_log: expected the log's version"},
        {0, R"("pieces":)", R"("pebbles":)", "run.log:1: /pieces: is missing"},
        {0, R"("step_seconds":)", R"("step_second":)", "run.log:1: /step_seconds: is missing"},
        {0, R"("pieces_hash":")", R"("pieces_hash":"z)", "run.log:1: /pieces_hash: expected sixteen"},
        {0, R"("build":{)", R"("build":3,"x":{)", "run.log:1: /build: expected an object"},
        {0, R"("recipe":{)", R"("recipes":{)", "run.log:1: /recipe: is missing"},
        {0, R"("anchored":true)", R"("anchored":1)",
         "run.log:1: /recipe/world/anchored: expected true or false"},
        {1, R"("step":0)", R"("step":1)", "run.log:2: /step: expected step 0, found 1"},
        {1, R"("hash":")", R"("hash":"0)", "run.log:2: /hash: expected sixteen"},
        {1, R"("bodies":")", R"("bodies":"x)", "run.log:2: /bodies: expected four"},
        {1, "{", "[", "run.log:2: the JSON cannot be read"},
        {3, R"("after":1)", R"("after":0)", "run.log:4: /after: 0 is not the step"},
        {3, R"("shoot")", R"("shout")", "run.log:4: /after: there is no action"},
        {3, R"("radius":0.1)", R"("radius":"big")", "run.log:4: /shoot/radius: expected a number"},
        {3, R"("radius":0.1)", R"("radius":99)", "run.log:4: /shoot: radius is 99"},
        {3, R"("radius":0.1)", R"("radios":0.1)", "run.log:4: /shoot/radius: is missing"},
        {3, R"("from":[0.0,)", R"("from":[)", "run.log:4: /shoot/from: expected three numbers"},
        {3, R"("shoot")", R"("let_go":{},"shoot")", "run.log:4: /let_go: there is another action"},
        {3, "}}", R"(},"and":1})", "run.log:4: /and: unknown key"},
        {4, R"({"step":2)", R"({"stop":2)", "run.log:5: expected a line with step, after or end"},
        {5, R"("steps":2)", R"("steps":3)", "run.log:6: /steps: 3 is not the step"},
        {5, R"("finished")", "7", "run.log:6: /end: expected text"},
        {5, "\n", "\n{}\n", "run.log:7: nothing may follow the end"}};
    for (const Case& c : cases) {
        const std::string message = with(c.line, c.from, c.to);
        CAPTURE(c.message);
        CAPTURE(message);
        CHECK(message.find(c.message) != std::string::npos);
    }
    CHECK(message_of(folder.write("run.log", lines[0])).find("has no end; it was cut after line 1")
          != std::string::npos);
    CHECK(message_of(folder.write("run.log", std::string(100'000, '['))).find("nested too deeply") != std::string::npos);
}

TEST_CASE("replay: logs with random bytes, or cut anywhere, are read or refused") {
    const Folder folder;
    const FractureOptions options = test::wall_options();
    recorded(options, broken(options), 4, {{1, Shoot{}}, {2, Release{{1, 2}}}, {2, Grab{4, {0, 1, 0}}}},
             folder.path / "good.log");
    const std::string good = content(folder.path / "good.log");
    for (size_t size = 0; size + 1 < good.size(); size += 7)
        CHECK(!message_of(folder.write("run.log", good.substr(0, size))).empty());
    std::mt19937 random(5);
    int refused = 0;
    for (int k = 0; k < 500; ++k) {
        std::string text = good;
        for (uint32_t n = 1 + random() % 4; n > 0; --n)
            text[random() % text.size()] = static_cast<char>(random() % 256);
        const std::string message = message_of(folder.write("run.log", text));
        if (!message.empty()) ++refused;
        if (!message.empty()) CHECK(message.find("run.log") != std::string::npos);
    }
    CHECK(refused > 300); // most bytes matter; a digit of a hash does not, to the reader
}

TEST_CASE("replay: every scene that moves repeats to the bit") {
    const Folder folder;
    int moved = 0;
    std::vector<fs::path> scenes;
    for (const auto& entry : fs::directory_iterator(BRITTLE_ASSETS "/scenes")) scenes.push_back(entry.path());
    std::sort(scenes.begin(), scenes.end());
    for (const fs::path& scene : scenes) {
        FractureOptions options;
        read_recipe(scene, options);
        if (options.picture.whole || options.picture.planes > 0 || options.picture.frames == 0) continue;
        CAPTURE(scene.string());
        ++moved;
        // Long enough for the blow and the fall; the tower's thousand bodies are slow.
        const uint64_t steps = std::min<uint64_t>(2 * options.picture.frames, 120);
        const fs::path file = folder.path / (scene.stem().string() + ".log");
        const ReplayLog log = recorded(options, broken(options), steps, {}, file);
        const std::optional<Difference> difference = replayed(log, broken(log.recipe));
        if (!difference) continue;
        const fs::path kept = fs::path(BRITTLE_FAILURE_FOLDER) / file.filename();
        fs::create_directories(BRITTLE_FAILURE_FOLDER);
        fs::copy_file(file, kept, fs::copy_options::overwrite_existing);
        FAIL_CHECK("step ", difference->step, ": ", difference->what, "; brittle replay ", kept.string());
    }
    CHECK(moved >= 5);
}

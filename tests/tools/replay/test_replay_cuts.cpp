// Replay logs of breakable worlds, with cuts committed by latency, by the log, and when a worker is ready.
#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include "tests/tools/log_text.h"
#include "tests/tools/replays.h"
#include "tests/tools/scenes.h"
#include "tests/tools/support.h"
#include "tests/tools/wall.h"

using namespace brittle;
using namespace brittle::tools;
using namespace brittle::tools::test;

namespace {

// A whole ball on the ground, or a bonded wall; both are shot at and struck.
FractureOptions breakable_options(bool bonded) {
    FractureOptions options = wall_options();
    options.world.breakable = true;
    options.world.bonded = bonded;
    options.world.min_size = 0.07; // m: small enough for pieces that are cut again, and a few seconds a run
    if (!bonded) options.mesh = "shape:icosphere:2";
    return options;
}

// Piece 3 exists only after the first blow's cut.
std::vector<std::pair<uint64_t, Action>> blows() {
    return {{0, Shoot{{0.3, 0.8, 3.0}, {0.0, 0.0, -25.0}, 0.15, 7800.0}},
            {20, Hammer{0, {-0.6, 0.9, 0.3}, {20.0, -40.0, 0.0}}},
            {25, Hammer{3, {0.0, 0.5, 0.0}, {0.0, -60.0, 0.0}}},
            {30, Shoot{{0.0, 0.9, 3.0}, {0.0, 0.0, -25.0}, 0.1, 7800.0}},
            {60, Push{5, {0.0, 0.5, 0.0}, {1.0, 20.0, 3.0}}}};
}

// Records 120 steps with blows, of a mesh that starts whole or of a bonded wall.
struct Bonded {
    static constexpr bool value = true;
};
struct Whole {
    static constexpr bool value = false;
};
template<typename Start>
ReplayLog recorded_cuts() {
    const Folder folder;
    const FractureOptions options = breakable_options(Start::value);
    return recorded(options, started(options), 120, blows(), folder.path / "run.log");
}

FractureOptions with_threads(FractureOptions options, uint32_t threads) {
    options.threads = threads;
    return options;
}

} // namespace

TYPE_TO_STRING(Bonded);
TYPE_TO_STRING(Whole);

TEST_CASE_TEMPLATE("replay: cuts of blows repeat by the log, with any number of threads", Start, Whole, Bonded) {
    const ReplayLog log = recorded_cuts<Start>();
    CHECK(log.commits.size() >= 2);
    CHECK(log.pieces == (Start::value ? started(log.recipe).pieces.size() : 1));
    for (const uint32_t threads : {1u, 2u, 4u}) {
        CAPTURE(threads);
        CHECK_FALSE(replayed(log, started(with_threads(log.recipe, threads))));
    }
}

TEST_CASE_TEMPLATE("replay: cuts of blows repeat by their own latency, with any number of threads", Start, Whole,
                   Bonded) {
    const ReplayLog log = recorded_cuts<Start>();
    for (const uint32_t threads : {1u, 2u, 4u}) {
        CAPTURE(threads);
        const fracture::Fragments fragments = started(with_threads(log.recipe, threads));
        Simulation simulation(log.recipe.material); // with the latency of the recording
        Player player(log);
        simulation.observe(&player);
        PreparedObject object{.fragments = std::make_shared<const fracture::Fragments>(fragments),
                              .world = world_of(log.recipe),
                              .material = log.recipe.material};
        prepare(object, {}, threads);
        simulation.start(std::move(object));
        schedule(log, simulation);
        while (!player.done() && !player.difference()) simulation.advance(0.017);
        CHECK_FALSE(player.difference());
    }
}

TEST_CASE_TEMPLATE("replay: a missing cut is reported at its step", Start, Whole, Bonded) {
    const ReplayLog log = recorded_cuts<Start>();
    REQUIRE(log.commits.size() >= 2);
    ReplayLog damaged = log;
    damaged.commits.erase(damaged.commits.begin());
    const std::optional<Difference> difference = replayed(damaged, started(log.recipe));
    REQUIRE(difference);
    CHECK(difference->step == log.commits.front().step);
    // A cut that comes too early is also reported. Jobs that never exist have no effect.
    damaged = log;
    damaged.commits.insert(damaged.commits.begin(), {1, 7'000'000});
    CHECK_FALSE(replayed(damaged, started(log.recipe)));
}

TEST_CASE("replay: the recipe's seed decides the cuts of blows, and is in the log") {
    const Folder folder;
    FractureOptions options = breakable_options(false);
    use_material(options.material, options); // sets the material's own pattern, which also applies to single sites
    const fracture::Fragments whole = started(options); // a mesh that starts whole has no sites that a seed could move
    const auto states_of = [&](uint64_t seed) {
        options.pattern.seed = seed;
        const ReplayLog log = recorded(options, whole, 60, blows(), folder.path / "run.log");
        CHECK(log.commits.size() >= 1);
        CHECK_FALSE(replayed(log, started(log.recipe)));
        return log.states.back().hash;
    };
    const uint64_t first = states_of(11);
    CHECK(states_of(12) != first);
    CHECK(states_of(11) == first);
    // The seed also counts with sites listed as points, which have no seed of their own.
    options.points = {{{0.0, 0.0, 0.0}}};
    CHECK(states_of(11) == first);
}

TEST_CASE("replay: the recipe decides size and orientation of bricks, and is in the log") {
    const Folder folder;
    FractureOptions options;
    options.mesh = "shape:wall";
    use_material("brick", options);
    options.world = {.anchored = true,
                     .breakable = true,
                     .shots = {{.from = {0.3, 0.5, 2.0}, .velocity = {0.0, 0.0, -25.0}, .radius = 0.15}}};
    const fracture::Fragments whole = started(options);
    const auto states_of = [&](const physics::RunningBond& bond) {
        options.world.bond = bond;
        const ReplayLog log = recorded(options, whole, 16, {}, folder.path / "run.log");
        CHECK(log.commits.size() >= 1);
        CHECK_FALSE(replayed(log, started(log.recipe)));
        return log.states.back().hash;
    };
    const uint64_t plain = states_of({});
    const uint64_t large = states_of({.brick = {0.4, 0.15, 0.12}}),
                   upright = states_of({.brick = {0.075, 0.25, 0.12}, .along = 1});
    CHECK(large != plain);
    CHECK(upright != plain);
    CHECK(upright != large);
    CHECK(states_of({}) == plain);
    (void)states_of({.brick = {0.001, 0.001, 0.001}});
    (void)states_of({.brick = {10.0, 10.0, 10.0}});
}

TEST_CASE("replay: a run whose cuts were committed when ready repeats by its log") {
    const Folder folder;
    for (const bool bonded : {false, true}) {
        CAPTURE(bonded);
        const FractureOptions options = breakable_options(bonded);
        Simulation simulation(options.material);
        Recorder recorder(folder.path / "run.log", options);
        simulation.observe(&recorder);
        simulation.commit_as(physics::Timing::when_ready);
        simulation.start(started(options), world_of(options));
        for (const auto& [step, action] : blows()) simulation.schedule(step, action);
        // Runs until all cuts are made, however long the worker takes. Only the steps of the cuts depend on the clock.
        while (simulation.steps() < 100
               || (simulation.destruction()->jobs_in_flight() > 0 && simulation.steps() < 20'000)) {
            simulation.step();
            // Steps of a world at rest take no time: a busy machine may take twenty thousand of them before its worker
            // begins.
            if (simulation.steps() > 100) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        recorder.finish();
        const ReplayLog log = read_replay_log(folder.path / "run.log");
        CHECK(log.commits.size() >= 2);
        CHECK_FALSE(replayed(log, started(log.recipe)));
    }
}

namespace {

// A broken ball with more pieces than the limit, and a view of it.
FractureOptions crowded_options() {
    FractureOptions options = breakable_options(false);
    options.world.piece_limit = 6;
    return options;
}
Watch from_the_front() {
    return {{0.0, 1.0, 5.0}, {0.0, 1.0, 0.0}, 0.8, 1.5};
}
Watch turned_away() {
    return {{0.0, 1.0, 5.0}, {0.0, 1.0, 10.0}, 0.8, 1.5};
}

// Returns the state after each of 120 steps with blows, while the view moves.
ReplayLog recorded_view(const std::vector<std::pair<uint64_t, Action>>& views) {
    const Folder folder;
    const FractureOptions options = crowded_options();
    std::vector<std::pair<uint64_t, Action>> actions = blows();
    actions.insert(actions.end(), views.begin(), views.end());
    return recorded(options, started(options), 120, actions, folder.path / "run.log");
}

std::vector<uint64_t> hashes(const ReplayLog& log) {
    std::vector<uint64_t> hashes;
    for (const ReplayLog::State& state : log.states) hashes.push_back(state.hash);
    return hashes;
}

} // namespace

TEST_CASE("replay: the view is part of a run with debris beyond the limit") {
    const ReplayLog front = recorded_view({{0, from_the_front()}}), away = recorded_view({{0, turned_away()}});
    const ReplayLog moved = recorded_view({{0, turned_away()}, {20, from_the_front()}, {34, turned_away()}});
    for (const ReplayLog* log : {&front, &away, &moved}) CHECK_FALSE(replayed(*log, started(log->recipe)));
    CHECK(hashes(front) != hashes(away)); // visible debris fades, so it exists a while longer
    CHECK(hashes(moved) != hashes(away));
    CHECK(hashes(moved) != hashes(front));
    // Without the line of the view the run differs.
    ReplayLog cut = moved;
    std::erase_if(cut.actions, [](const auto& entry) { return std::holds_alternative<Watch>(entry.second); });
    CHECK(replayed(cut, started(cut.recipe)));
    // A view that always contains everything has no effect.
    CHECK(hashes(front) == hashes(recorded_view({})));
}

TEST_CASE("replay: bonded pieces removed as debris by the view are removed again in the replay") {
    const Folder folder;
    FractureOptions options = breakable_options(true);
    const auto run = [&](const Watch& view) {
        std::vector<std::pair<uint64_t, Action>> actions = blows();
        actions.push_back({0, view});
        return recorded(options, started(options), 200, actions, folder.path / "run.log");
    };
    const ReplayLog all = run(turned_away());
    options.world.piece_limit = 6;
    const ReplayLog front = run(from_the_front()), away = run(turned_away());
    CHECK(hashes(away) != hashes(all));
    CHECK(hashes(away) != hashes(front));
    for (const ReplayLog* log : {&front, &away})
        for (const uint32_t threads : {1u, 3u})
            CHECK_FALSE(replayed(*log, started(with_threads(log->recipe, threads))));
}

TEST_CASE("replay: pieces beyond max_colliding become debris in the replay as in the run") {
    const Folder folder;
    FractureOptions options = breakable_options(false);
    const ReplayLog free = recorded(options, started(options), 120, blows(), folder.path / "free.log");
    options.world.max_colliding = 3;
    const ReplayLog crowd = recorded(options, started(options), 120, blows(), folder.path / "crowd.log");
    CHECK(crowd.recipe.world.max_colliding == 3);
    CHECK(hashes(crowd) != hashes(free));
    // A log from before the limit was renamed.
    std::string text = read_text(folder.path / "crowd.log");
    const size_t key = text.find("\"max_colliding\"");
    REQUIRE(key != std::string::npos);
    write_text(folder.path / "former.log", text.replace(key, 15, "\"most_colliding\""));
    CHECK(read_replay_log(folder.path / "former.log").recipe.world.max_colliding == 3);
    for (const uint32_t threads : {1u, 3u}) {
        const FractureOptions again = with_threads(crowd.recipe, threads);
        CHECK_FALSE(replayed(crowd, started(again)));
    }
}

TEST_CASE("replay: a view has no effect without debris beyond the limit, and in a world that is not breakable") {
    const Folder folder;
    const FractureOptions options = breakable_options(false), wall = wall_options();
    const auto states_of = [&](const FractureOptions& of, std::vector<std::pair<uint64_t, Action>> actions) {
        return hashes(recorded(of, started(of), 60, actions, folder.path / "run.log"));
    };
    std::vector<std::pair<uint64_t, Action>> watched = blows();
    watched.insert(watched.begin(), {0, turned_away()});
    CHECK(states_of(options, blows()) == states_of(options, watched));
    CHECK(states_of(wall, {}) == states_of(wall, {{0, turned_away()}}));
}

TEST_CASE("simulation: visible debris fades, and so does debris with a visible shadow") {
    FractureOptions options;
    options.mesh = "shape:cube";
    use_material("concrete", options);
    options.world = {.height = 3.0, .breakable = true, .piece_limit = 4};
    const fracture::Fragments whole = started(options);
    // Views straight down at the ground. The shadow of a cube of 2 m at this height falls there; no debris does.
    const glm::dvec3 shadow(2.4, 0.0, -2.4), nothing(-2.4, 0.0, 2.4);
    const auto down_at = [](const glm::dvec3& place) {
        return Watch{place + glm::dvec3(0.0, 1.0, 0.0), place, 0.6, 1.0};
    };
    struct Case {
        Watch watch;
        bool fades;
    };
    for (const Case& c : {Case{{{0.0, 4.0, 9.0}, {0.0, 4.0, 0.0}, 0.6, 1.0}, true}, Case{down_at(shadow), true},
                          Case{down_at(nothing), false}, Case{{{0.0, 4.0, 9.0}, {0.0, 4.0, 18.0}, 0.6, 1.0}, false}}) {
        CAPTURE(c.watch.target.x);
        CAPTURE(c.watch.target.z);
        Simulation simulation(options.material);
        simulation.start(whole, options.world);
        simulation.apply(c.watch);
        simulation.apply(Hammer{0, {0.0, 4.0, 1.0}, {0.0, 0.0, -500.0}});
        for (int k = 0; k < 6; ++k) simulation.step();
        CHECK(simulation.number_count() > 8);
        CHECK(simulation.take_events().fading.empty() != c.fades);
        CHECK((simulation.destruction()->pieces().size() == 4) != c.fades);
    }
}

TEST_CASE("replay: damaged lines of views are refused") {
    const Folder folder;
    const FractureOptions options = breakable_options(false);
    recorded(options, started(options), 2, {{1, from_the_front()}}, folder.path / "good.log");
    const std::string good = read_text(folder.path / "good.log");
    const auto with = [&](const std::string& from, const std::string& to) {
        std::string text = good;
        const size_t at = text.find(from, text.find(R"("watch")"));
        REQUIRE(at != std::string::npos);
        text.replace(at, from.size(), to);
        return message_of(folder.write("run.log", text));
    };
    CHECK(with(R"("fov":0.8)", R"("fov":0.7)").empty());
    CHECK(with(R"("fov":0.8)", R"("fov":4)").find("/watch: fov is 4") != std::string::npos);
    CHECK(with(R"("fov":0.8)", R"("fog":0.8)").find("/watch/fov: is missing") != std::string::npos);
    CHECK(with(R"("aspect":1.5)", R"("aspect":0)").find("/watch: aspect is 0") != std::string::npos);
    CHECK(with(R"("eye":[)", R"("eye":[1,)").find("/watch/eye: expected three numbers") != std::string::npos);
}

TEST_CASE("replay: damaged lines of cuts are refused") {
    const Folder folder;
    FractureOptions options = breakable_options(false);
    recorded(options, started(options), 40, blows(), folder.path / "good.log");
    const std::string good = read_text(folder.path / "good.log");
    CHECK(log_text(read_replay_log(folder.path / "good.log"), folder.path) == good);
    const size_t at = good.rfind('\n', good.find(R"("commit":{)")) + 1; // the header also contains the word commit
    const std::string line = good.substr(at, good.find('\n', at) - at);
    REQUIRE(line.find("commit") != std::string::npos);
    const auto with = [&](const std::string& other) {
        std::string text = good;
        text.replace(at, line.size(), other);
        return message_of(folder.write("run.log", text));
    };
    CHECK(with(line).empty());
    const std::string early = with(R"({"after":1,"commit":{"job":0}})");
    CAPTURE(early);
    CHECK(early.find("/after: expected ") != std::string::npos);
    CHECK(early.find(", the step of the last state, found 1") != std::string::npos);
    CHECK(with(R"({"commit":{"job":0}})").find("/after: is missing") != std::string::npos);
    const std::string after = line.substr(0, line.find(",\"commit"));
    CHECK(with(after + R"(,"commit":{}})").find("/commit/job: is missing") != std::string::npos);
    CHECK(with(after + R"(,"commit":{"job":-1}})").find("/commit/job") != std::string::npos);
    CHECK(with(after + R"(,"commit":{"job":1,"by":2}})").find("/commit/by: unknown key") != std::string::npos);
    CHECK(with(after + R"(,"commit":{"job":1},"let_go":{}})").find("/let_go: unknown key") != std::string::npos);
    CHECK(with(after + R"(,"commit":[]})").find("/commit") != std::string::npos);
    // A world that is not breakable has no cuts.
    std::string text = good;
    const std::string flag = R"("breakable":true)";
    text.replace(text.find(flag), flag.size(), R"("breakable":false)");
    CHECK(message_of(folder.write("run.log", text)).find("world is breakable") != std::string::npos);
}

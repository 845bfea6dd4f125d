// Replay logs, and bit-equal replays at any frame rate and with any number of threads. run/test_scenes.cpp replays
// every scene that moves.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "tests/tools/log_text.h"
#include "tests/tools/replays.h"
#include "tests/tools/scenes.h"
#include "tests/tools/support.h"
#include "tests/tools/wall.h"
#include "tools/scenario/replay/body_text.h"

using namespace brittle;
using namespace brittle::tools;
using namespace brittle::tools::test;
namespace fs = std::filesystem;

namespace {

// One action of each kind at various steps, applied to the wall.
std::vector<std::pair<uint64_t, Action>> various_actions() {
    return {{0, Shoot{{0.3, 0.5, 2.0}, {0.0, 0.0, -20.0}, 0.15, 7800.0}},
            {5, Damage{{-0.6, 0.9, 0.0}, 0.3, 0.7}},
            {5, Saw{{-1.0, 0.7, 0.0}, {0.1, 0.7, 0.0}, 0.02, 1.0}},
            {20, Hammer{12, {0.4, 0.5, -0.1}, {0.0, 0.0, 900.0}}},
            {21, Grab{20, {0.0, 1.0, 0.0}}},
            {22, Drag{{0.5, 1.5, 0.6}}},
            {40, Push{3, {0.1, 0.2, 0.0}, {1.0, 2.0, 3.0}}},
            {41, Release{{0, 1}}},
            {45, Watch{{0.1, 1.0, 3.0}, {0.0, 0.5, 0.0}, 0.7, 1.6}},
            {60, LetGo{}},
            {60, Release{}}};
}

} // namespace

TEST_CASE("body checks: texts are counted and compared, and damaged texts are refused") {
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

TEST_CASE("replay: a recorded log is read back to the bit, with every kind of action") {
    const Folder folder;
    const FractureOptions options = wall_options();
    const auto actions = various_actions();
    const ReplayLog log = recorded(options, started(options), 80, actions, folder.path / "run.log");
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
    CHECK(log_text(log, folder.path) == read_text(folder.path / "run.log"));
}

TEST_CASE("replay: paths of mesh and sites are relative to the log's folder") {
    const Folder folder;
    FractureOptions options;
    options.mesh = BRITTLE_CORPUS "/meshes/cube.obj";
    options.sites_file = BRITTLE_ASSETS "/sites/clip_steps.txt";
    options.fit_sites = true;
    fs::current_path(folder.path);
    fs::copy_file(options.mesh, "mesh.obj");
    options.mesh = "mesh.obj";
    fs::create_directory("logs");
    const ReplayLog log = recorded(options, started(options), 3, {}, "logs/run.log");
    fs::current_path(fs::temp_directory_path());
    const ReplayLog again = read_replay_log(folder.path / "logs" / "run.log");
    CHECK(!replayed(again, started(again.recipe)));
}

TEST_CASE("replay: states are equal at other frame rates and with other numbers of threads") {
    const Folder folder;
    const FractureOptions options = wall_options();
    const ReplayLog log = recorded(options, started(options), 120, various_actions(), folder.path / "run.log");
    CHECK(log.states.front().hash != log.states.back().hash);
    for (const uint32_t threads : {1u, 2u, 4u}) {
        FractureOptions threaded = log.recipe;
        threaded.threads = threads;
        CHECK_FALSE(replayed(log, started(threaded)));
    }
    std::mt19937 random(11);
    for (const double rate : {20.0, 60.0, 144.0, 1000.0, 0.0}) {
        CAPTURE(rate);
        Simulation simulation(log.recipe.material);
        Player player(log);
        simulation.observe(&player);
        simulation.start(started(log.recipe), log.recipe.world);
        schedule(log, simulation);
        while (!player.done()) simulation.advance(rate > 0.0 ? 1.0 / rate : static_cast<double>(random() % 50) * 1e-3);
        CHECK_FALSE(player.difference());
    }
}

TEST_CASE("replay: a run on stock Bullet repeats to the bit, bonded and breakable") {
    const Folder folder;
    for (const bool breakable : {false, true}) {
        CAPTURE(breakable);
        FractureOptions options = wall_options();
        options.world.engine = physics::EngineKind::bullet;
        options.world.breakable = breakable;
        const auto actions = breakable ? std::vector(1, various_actions().front()) : various_actions();
        const ReplayLog log = recorded(options, started(options), 120, actions, folder.path / "run.log");
        CHECK(log.recipe.world.engine == physics::EngineKind::bullet);
        CHECK(log.states.front().hash != log.states.back().hash);
        CHECK_FALSE(replayed(log, started(log.recipe)));
        ReplayLog other = log;
        other.recipe.world.engine = physics::EngineKind::solver;
        CHECK(replayed(other, started(other.recipe)));
    }
}

TEST_CASE("replay: actions at any time between frames are recorded at their step") {
    const Folder folder;
    const FractureOptions options = wall_options();
    const fracture::Fragments fragments = started(options);
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

TEST_CASE("replay: a difference is found at its step, with the body") {
    const Folder folder;
    FractureOptions options = wall_options();
    options.world = {.height = 0.2}; // loose pieces, one body each
    const fracture::Fragments fragments = started(options);
    // The first push moves the piece out of the wall, so that the second push acts on this piece alone.
    const glm::dvec3 centre = fragments.pieces[7].mass.centre_of_mass;
    const Push out{7, centre, {0.0, 0.0, 200.0}}, push{7, centre + glm::dvec3(0.0, 0.0, 1.0), {0.0, 0.0, 5.0}};
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
    SUBCASE("an action changed by little more than the rounding of a speed") {
        std::get<Push>(log.actions[1].second).impulse.z *= 1.0 + 1e-5;
        const auto difference = replayed(log, fragments);
        REQUIRE(difference);
        CHECK(difference->step >= 26);
    }
    SUBCASE("a ball more") {
        log.actions.emplace_back(30, Shoot{{0.0, 5.0, 0.0}, {}, 0.1, 1000.0});
        const auto difference = replayed(log, fragments);
        REQUIRE(difference);
        CHECK(difference->step == 31);
        CHECK(difference->what.find(std::to_string(fragments.pieces.size()) + " bodies were recorded, but there are "
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
        const auto difference = replayed(log, started(other));
        REQUIRE(difference);
        CHECK(difference->step == 0);
        CHECK(difference->what.find("pieces") != std::string::npos);
    }
}

TEST_CASE("replay: a missing action is found even before it moves anything") {
    const Folder folder;
    FractureOptions options = wall_options();
    options.world = {.anchored = true};
    for (const bool breakable : {false, true}) {
        options.world.bonded = options.world.breakable = breakable;
        const fracture::Fragments fragments = started(options);
        ReplayLog log =
            recorded(options, fragments, 20, {{10, Damage{{-0.6, 0.9, 0.0}, 0.3, 0.1}}}, folder.path / "run.log");
        CHECK_FALSE(replayed(log, fragments));
        log.actions.clear();
        const auto difference = replayed(log, fragments);
        REQUIRE(difference);
        CHECK(difference->step == 11);
        CHECK(difference->what.find("all bodies are equal") != std::string::npos);
    }
}

TEST_CASE("replay: the log of an interrupted run holds the run so far, and a new start begins a new log") {
    const Folder folder;
    const FractureOptions options = wall_options();
    const fracture::Fragments fragments = started(options);
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
    } // destroyed without finish(), as by an exception
    const ReplayLog log = read_replay_log(folder.path / "run.log");
    CHECK(log.end == "failed");
    CHECK(log.states.size() == 6);
    CHECK_FALSE(replayed(log, fragments));
}

TEST_CASE("replay: no log is written without a start, and a missing folder is an output error") {
    const Folder folder;
    const FractureOptions options = wall_options();
    Recorder(folder.path / "run.log", options).finish();
    CHECK(!fs::exists(folder.path / "run.log"));
    Simulation simulation;
    Recorder recorder(folder.path / "none" / "run.log", options);
    simulation.observe(&recorder);
    simulation.start(started(options), options.world);
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
    const FractureOptions options = wall_options();
    recorded(options, started(options), 2, {{1, Shoot{}}}, folder.path / "good.log");
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
        {0, R"("brittle_log":1)", R"("brittle_log":2)", "run.log:1: /brittle_log: expected the log's version"},
        {0, R"("pieces":)", R"("pebbles":)", "run.log:1: /pieces: is missing"},
        {0, R"("step_seconds":)", R"("step_second":)", "run.log:1: /step_seconds: is missing"},
        {0, R"("pieces_hash":")", R"("pieces_hash":"z)", "run.log:1: /pieces_hash: expected sixteen"},
        {0, R"("build":{)", R"("build":3,"x":{)", "run.log:1: /build: expected an object"},
        {0, R"("recipe":{)", R"("recipes":{)", "run.log:1: /recipe: is missing"},
        {0, R"("anchored":true)", R"("anchored":1)", "run.log:1: /recipe/world/anchored: expected true or false"},
        {1, R"("step":0)", R"("step":1)", "run.log:2: /step: expected step 0, found 1"},
        {1, R"("hash":")", R"("hash":"0)", "run.log:2: /hash: expected sixteen"},
        {1, R"("bodies":")", R"("bodies":"x)", "run.log:2: /bodies: expected four"},
        {1, "{", "[", "run.log:2: the JSON cannot be read"},
        {3, R"("after":1)", R"("after":0)", "run.log:4: /after: expected 1, the step of the last state, found 0"},
        {3, R"("shoot")", R"("shout")", "run.log:4: /after: there is no action"},
        {3, R"("radius":0.1)", R"("radius":"big")", "run.log:4: /shoot/radius: expected a number"},
        {3, R"("radius":0.1)", R"("radius":99)", "run.log:4: /shoot: radius is 99"},
        {3, R"("radius":0.1)", R"("radios":0.1)", "run.log:4: /shoot/radius: is missing"},
        {3, R"("from":[0.0,)", R"("from":[)", "run.log:4: /shoot/from: expected three numbers"},
        {3, R"("from":[0.0,)", R"("from":[-1e39,)",
         "run.log:4: /shoot: from/0 is -1e+39; it must be from -1e+09 to 1e+09"},
        {3, R"("shoot")", R"("let_go":{},"shoot")", "run.log:4: /let_go: a line may hold only one action"},
        {3, "}}", R"(},"and":1})", "run.log:4: /and: unknown key"},
        {4, R"({"step":2)", R"({"stop":2)", "run.log:5: expected a line with step, after or end"},
        {5, R"("steps":2)", R"("steps":3)", "run.log:6: /steps: expected 2, the step of the last state, found 3"},
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
    CHECK(message_of(folder.write("run.log", std::string(100'000, '['))).find("nested too deeply")
          != std::string::npos);
}

TEST_CASE("replay: logs with random bytes, or truncated anywhere, are read or refused") {
    const Folder folder;
    const FractureOptions options = wall_options();
    recorded(options, started(options), 4, {{1, Shoot{}}, {2, Release{{1, 2}}}, {2, Grab{4, {0, 1, 0}}}},
             folder.path / "good.log");
    const std::string good = read_text(folder.path / "good.log");
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
    CHECK(refused > 300); // most bytes matter; the reader does not check the digits of hashes
}

// --record, `brittle replay` and --video from the user's point of view. Runs the real binary.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <thread>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "fracture/io/import.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/shapes/shapes.h"
#include "tests/tools/support.h"
#include "tools/scenario/replay/action_json.h"

namespace fs = std::filesystem;
using namespace brittle;
using namespace brittle::tools::test;

namespace {

// Records a short run of the wall.
Outcome record(const Folder& folder, const std::string& more = "") {
    return run_brittle(folder, "render " BRITTLE_ASSETS "/scenes/brick_wall_rammed.json --frames 30 --size 64x48 -o "
                                   + folder / "a_%02d.png" + " --every 10 --record " + folder / "run.log" + " " + more);
}

// Writes an executable script of the given name.
void make_program(const std::string& file, const std::string& script) {
    write_text(file, "#!/bin/sh\n" + script);
    REQUIRE(chmod(file.c_str(), 0755) == 0);
}

} // namespace

TEST_CASE("a run recorded by render repeats without a device, and is drawn again with equal pictures") {
    const Folder folder;
    const Outcome recorded = record(folder);
    INFO(recorded.output);
    if (no_vulkan(recorded)) return;
    REQUIRE(recorded.exit_code == 0);
    // No Vulkan driver can be found.
    const Outcome replayed =
        run_brittle(folder, "replay " + folder / "run.log", "VK_DRIVER_FILES=/dev/null VK_ICD_FILENAMES=/dev/null");
    INFO(replayed.output);
    CHECK(replayed.exit_code == 0);
    CHECK(replayed.has("59 steps, all equal; 1 actions, finished"));
    const Outcome drawn = run_brittle(folder, "replay " + folder / "run.log" + " --size 64x48 --every 10 --render "
                                                  + folder / "b_%02d.png");
    INFO(drawn.output);
    CHECK(drawn.exit_code == 0);
    CHECK(drawn.has("all equal"));
    for (const char* number : {"00", "10", "20", "30"})
        CHECK(read_text(folder / "a_" + number + ".png") == read_text(folder / "b_" + number + ".png"));
}

TEST_CASE("a run on stock Bullet repeats in another process, and its log names the engine") {
    const Folder folder;
    for (const std::string mesh : {"shape:wall --material concrete --pattern bricks -n 30 --anchored",
                                   "shape:wall --material wood --breakable --anchored"}) {
        CAPTURE(mesh);
        const Outcome recorded =
            run_brittle(folder, "render " + mesh
                                    + " --physics bullet --shot 0.3,0.5,4,0,1,-20,0.15"
                                      " --frames 40 --every 40 --size 64x48 -o "
                                    + (folder / "a_%02d.png") + " --record " + (folder / "run.log"));
        INFO(recorded.output);
        if (no_vulkan(recorded)) return;
        REQUIRE(recorded.exit_code == 0);
        const std::string log = read_text(folder / "run.log");
        const size_t physics = log.find(R"("physics":"bullet")");
        REQUIRE(physics != std::string::npos);
        const Outcome replayed = run_brittle(folder, "replay " + (folder / "run.log"));
        INFO(replayed.output);
        CHECK(replayed.exit_code == 0);
        CHECK(replayed.has("79 steps, all equal"));
        // The solver's states are others: the log's engine took effect.
        write_text(folder / "other.log", std::string(log).replace(physics, 18, R"("physics":"solver")"));
        CHECK(run_brittle(folder, "replay " + (folder / "other.log")).exit_code == 8);
    }
}

TEST_CASE("render and replay export equal pieces at the end of a run") {
    const Folder folder;
    const std::string run =
        "render shape:animal --breakable --material stone --height 1.5 --air-density 0 --frames 60 --size 64x48";
    const Outcome rendered =
        run_brittle(folder, run + " --record " + (folder / "run.log") + " --export " + (folder / "a.ply"));
    INFO(rendered.output);
    if (no_vulkan(rendered)) return;
    REQUIRE(rendered.exit_code == 0);
    CHECK(rendered.has(" pieces in " + (folder / "a.ply")));
    CHECK_FALSE(rendered.has("1 pieces"));
    CHECK_FALSE(rendered.has(": 1 piece "));            // it broke by its fall
    CHECK_FALSE(fs::exists(folder / "frame_0060.png")); // pictures are written only if requested
    const Outcome replayed = run_brittle(folder, "replay " + (folder / "run.log") + " --export " + (folder / "b.ply"));
    INFO(replayed.output);
    CHECK(replayed.exit_code == 0);
    CHECK(read_text(folder / "a.ply") == read_text(folder / "b.ply"));
    const Outcome made = run_brittle(folder, "replay " + (folder / "run.log")
                                                 + " --export-as made --hulls unreal --export " + (folder / "b.glb"));
    CHECK(made.exit_code == 0);
    CHECK(read_text(folder / "b.glb").find("_01\"") != std::string::npos); // legs and body
    // Pieces as made touch each other. A reader that merges equal corners may see edges with three triangles, but no
    // part is missing.
    CHECK(run_brittle(folder, "replay " + (folder / "run.log") + " --export-as made --export " + (folder / "d.glb"))
              .exit_code
          == 0);
    const auto pieces = fracture::import_mesh(folder / "d.glb");
    REQUIRE(pieces);
    const auto volume_of = [](const fracture::TriangleMesh& mesh) {
        return fracture::signed_volume(mesh.positions, mesh.triangles);
    };
    CHECK(volume_of(*pieces)
          == doctest::Approx(volume_of(*fracture::shape("animal"))).epsilon(1e-6)); // positions have single precision

    CHECK(run_brittle(folder, run + " --whole --export " + (folder / "c.glb")).exit_code == 2);
    CHECK(run_brittle(folder, run + " --export " + (folder / "c.fbx")).exit_code == 2);
    CHECK(run_brittle(folder, run + " --export-as flat --export " + (folder / "c.glb")).exit_code == 2);
    CHECK(run_brittle(folder, "replay " + (folder / "run.log") + " --render " + (folder / "c_%02d.png") + " --export "
                                  + (folder / "c.glb"))
              .exit_code
          == 2);
    CHECK(run_brittle(folder, run + " --export " + (folder / "none/c.glb")).exit_code == 5);
}

TEST_CASE("replay exports with the options of the recorded run, which its command line overrides") {
    const Folder folder;
    const std::string log = folder / "run.log";
    const Outcome rendered =
        run_brittle(folder, "render shape:cube -n 4 --material glass --units cm --frames 5 --size 64x48 --record " + log
                                + " --per-piece --name vase --hulls unreal --rigid-bodies --hull-parts 2 --density 900 "
                                  "--export-as made --export "
                                + (folder / "a.glb"));
    INFO(rendered.output);
    if (no_vulkan(rendered)) return;
    REQUIRE(rendered.exit_code == 0);
    const auto replay = [&](const std::string& options) {
        const Outcome outcome = run_brittle(folder, "replay " + log + " " + options);
        CHECK_MESSAGE(outcome.exit_code == 0, outcome.output);
        return outcome;
    };
    CHECK_FALSE(replay("").has("no effect")); // nothing is exported
    (void)replay("--export " + (folder / "b.glb"));
    CHECK_FALSE(fs::exists(folder / "b.glb"));
    for (const char* piece : {"_000.glb", "_001.glb", "_002.glb", "_003.glb"}) {
        CAPTURE(piece);
        REQUIRE(fs::exists(folder / (std::string("b") + piece)));
        CHECK(read_text(folder / (std::string("a") + piece)) == read_text(folder / (std::string("b") + piece)));
    }
    CHECK(read_text(folder / "b_000.glb").find("UCX_vase_000_00") != std::string::npos);

    (void)replay("--one-file --name jug --hulls godot --density 700 --export-as lie --export " + (folder / "c.glb"));
    REQUIRE(fs::exists(folder / "c.glb"));
    const std::string given = read_text(folder / "c.glb");
    CHECK(given.find("jug_000-rigid") != std::string::npos);
    CHECK(given.find("UCX_") == std::string::npos);
    CHECK(given.find("KHR_physics_rigid_bodies") != std::string::npos); // of the recorded run

    const Outcome ply = replay("--export " + (folder / "d.ply"));
    CHECK(ply.has("the recipe's --hulls has no effect"));
    CHECK(fs::exists(folder / "d_003.ply"));
    const Outcome refused = run_brittle(folder, "replay " + log + " --hulls unreal --export " + (folder / "e.ply"));
    CHECK(refused.exit_code == 2);
    CHECK(refused.has("--hulls: "));
    CHECK(run_brittle(folder, "replay " + log + " --rigid-bodies").has("--rigid-bodies: there is no file"));
}

TEST_CASE("a replay that differs has its own exit code and names step and body") {
    const Folder folder;
    const Outcome recorded = record(folder);
    if (no_vulkan(recorded)) return;
    REQUIRE(recorded.exit_code == 0);
    std::string log = read_text(folder / "run.log");
    const std::string_view velocity = R"("velocity":[-0.8,0.0,12.0])";
    const size_t speed = log.find(velocity);
    REQUIRE(speed != std::string::npos);
    log.replace(speed, velocity.size(), R"("velocity":[-0.8,0.0,12.1])");
    write_text(folder / "other.log", log);
    const Outcome replayed = run_brittle(folder, "replay " + folder / "other.log");
    INFO(replayed.output);
    CHECK(replayed.exit_code == 8);
    CHECK(replayed.has("step 13 of 59 differs"));
    CHECK(replayed.has("(a ball)"));
    CHECK(!replayed.has("it was recorded with"));
    const size_t compiler = log.find(R"("compiler":")");
    REQUIRE(compiler != std::string::npos);
    write_text(folder / "foreign.log", log.insert(compiler + 12, "not "));
    CHECK(run_brittle(folder, "replay " + folder / "foreign.log").has("it was recorded with compiler \"not "));
}

TEST_CASE("replay and --record refuse impossible requests") {
    const Folder folder;
    CHECK(run_brittle(folder, "replay").exit_code == 2);
    CHECK(run_brittle(folder, "replay " + folder / "none.log").exit_code == 3);
    CHECK(run_brittle(folder, "render shape:cube --whole --record " + folder / "run.log").exit_code == 2);
    CHECK(run_brittle(folder, "render shape:cube --planes 2 --record " + folder / "run.log").exit_code == 2);
    CHECK(run_brittle(folder, "replay x.log --render %s.png").exit_code == 2);
}

TEST_CASE("an interrupted run leaves a log that can be replayed") {
    const Folder folder;
    const std::string log = folder / "run.log";
    const std::string output = folder / "output";
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
        if (!std::freopen(output.c_str(), "w", stderr) || !std::freopen("/dev/null", "w", stdout)) _exit(99);
        execl(BRITTLE_PROGRAM, BRITTLE_PROGRAM, "render", "shape:cube", "-n", "20", "--frames", "100000", "--size",
              "64x48", "--every", "1", "-o", (folder / "f_%06d.png").c_str(), "--record", log.c_str(), nullptr);
        _exit(98);
    }
    // Waits until the program writes pictures, or gave up for lack of a device.
    int status = 0;
    bool over = false;
    for (int k = 0; k < 600 && !over && !fs::exists(folder / "f_000005.png"); ++k) {
        over = waitpid(child, &status, WNOHANG) == child;
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    if (!over) {
        kill(child, SIGINT);
        REQUIRE(waitpid(child, &status, 0) == child);
    }
    if (no_vulkan({WIFEXITED(status) ? WEXITSTATUS(status) : -1, ""})) return;
    INFO(read_text(output));
    REQUIRE(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 130);
    const Outcome replayed = run_brittle(folder, "replay " + log);
    INFO(replayed.output);
    CHECK(replayed.exit_code == 0);
    CHECK(replayed.has("all equal"));
    CHECK(replayed.has("interrupted"));
}

TEST_CASE("a video holds all frames, and ffmpeg's absence and failures are reported") {
    const Folder folder;
    const std::string render = "render shape:cube -n 5 --size 64x48 --frames 6 --video " + folder / "fall.mp4";
    fs::create_directory(folder / "bin");
    const std::string path = "PATH=" + folder / "bin";

    const Outcome missing = run_brittle(folder, render, path);
    if (no_vulkan(missing)) return;
    INFO(missing.output);
    CHECK(missing.exit_code == 2);
    CHECK(missing.has("needs the program ffmpeg"));

    // A stand-in for ffmpeg, which copies its input to the file named last.
    make_program(folder / "bin/ffmpeg", "echo \"$@\" > '" + folder / "words"
                                            + "'\n"
                                              "for last; do :; done\n/bin/cat > \"${last#file:}\"\n");
    const Outcome made = run_brittle(folder, render, path);
    INFO(made.output);
    CHECK(made.exit_code == 0);
    CHECK(made.has("fall.mp4"));
    CHECK(fs::file_size(folder / "fall.mp4") == 7 * 64 * 48 * 4);
    CHECK(read_text(folder / "words").find("-video_size 64x48 -framerate 60") != std::string::npos);
    CHECK(!fs::exists("frame_0000.png"));
    CHECK(!fs::exists(folder / "fall.part.mp4"));

    const Outcome both = run_brittle(folder, render + " -o " + folder / "f_%d.png" + " --every 3", path);
    CHECK(both.exit_code == 0);
    CHECK(fs::exists(folder / "f_6.png"));

    write_text(folder / "fall.mp4", "old");
    make_program(folder / "bin/ffmpeg", "/bin/cat > /dev/null\necho 'no such codec' >&2\nexit 1\n");
    const Outcome failed = run_brittle(folder, render, path);
    INFO(failed.output);
    CHECK(failed.exit_code == 5);
    CHECK(failed.has("no such codec"));
    CHECK(read_text(folder / "fall.mp4") == "old");

    make_program(folder / "bin/ffmpeg", "exit 1\n");
    const Outcome deaf =
        run_brittle(folder, "render shape:cube -n 5 --size 640x480 --frames 6 --video " + folder / "fall.mp4", path);
    INFO(deaf.output);
    CHECK(deaf.exit_code == 5);
    CHECK(read_text(folder / "fall.mp4") == "old");
}

TEST_CASE("the schema of replay logs lists exactly the actions and their fields") {
    using namespace brittle::tools;
    const auto schema = nlohmann::json::parse(std::ifstream(BRITTLE_ASSETS "/replay.schema.json"));
    const auto& known = schema["$defs"]["action"]["properties"];
    size_t kinds = 0;
    for (const Action& action : {Action(Shoot{}), Action(Damage{}), Action(Saw{}), Action(Hammer{}), Action(Release{}),
                                 Action(Push{}), Action(Grab{}), Action(Drag{}), Action(LetGo{}), Action(Watch{})}) {
        CHECK(action.index() == kinds++);
        nlohmann::ordered_json object;
        write_action(object, action);
        REQUIRE(object.size() == 1);
        const std::string name = object.begin().key();
        CAPTURE(name);
        REQUIRE(known.contains(name));
        const auto fields = known[name].value("properties", nlohmann::json::object());
        CHECK(fields.size() == object[name].size());
        for (const auto& [field, value] : object[name].items()) CHECK(fields.contains(field));
    }
    CHECK(kinds == std::variant_size_v<Action>);
    CHECK(known.size() == kinds + 1); // and "after"
}

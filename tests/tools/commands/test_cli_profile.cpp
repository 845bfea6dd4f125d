// `brittle profile` from the user's point of view: meshes and scenes, lists of them, comparisons, time lines, refusals.
#include <doctest/doctest.h>

#include <map>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/tools/support.h"

using namespace brittle::tools::test;

TEST_CASE("profile measures the fracture without a device and prints JSON") {
    const Folder folder;
    const Outcome outcome =
        run_brittle(folder, "profile shape:icosphere -n 5 --repeats 3 --frames 0 --json -o " + folder / "p.json");
    INFO(outcome.output);
    REQUIRE(outcome.exit_code == 0);
    const auto profile = nlohmann::json::parse(outcome.output);
    const auto& scenario = profile["scenarios"][0];
    CHECK(scenario["name"] == "icosphere 5 cpu");
    CHECK(scenario["fracture"]["total"]["samples"] == 3);
    CHECK(scenario["fracture"]["total"]["median"].get<double>() > 0.0);
    CHECK_FALSE(profile["environment"].contains("device"));
    CHECK(profile == nlohmann::json::parse(read_text(folder / "p.json")));
    CHECK(run_brittle(folder, "profile shape:cube -n 3 --repeats 1 --frames 0").has("median"));
}

TEST_CASE("profile measures frames before and after the fracture") {
    const Folder folder;
    const Outcome outcome = run_brittle(folder, "profile shape:cube -n 4 --repeats 1 --frames 2 --size 64x48 --json");
    INFO(outcome.output);
    if (no_vulkan(outcome)) return;
    REQUIRE(outcome.exit_code == 0);
    const auto profile = nlohmann::json::parse(outcome.output);
    const auto& scenario = profile["scenarios"][0];
    CHECK(scenario["frames"]["whole"]["frame"]["samples"] == 2);
    CHECK(scenario["frames"]["falling"]["physics"]["samples"] == 2);
    CHECK(scenario["frames"]["taking over"]["bodies and upload"]["samples"] == 1);
    CHECK(profile["environment"].contains("driver"));
    const auto& series = scenario["frame_series"];
    const auto begun = series["breaking_from"].get<size_t>(), broken = series["fracture_frame"].get<size_t>();
    CHECK(begun == 2);
    CHECK(broken > begun);
    CHECK(series["milliseconds"].size() == broken + 3);
}

TEST_CASE("profile measures the starts of a scene and its frames, standing and played") {
    const Folder folder;
    write_text(folder / "two.json", R"({"brittle": 2,
        "objects": [{"name": "block", "mesh": "shape:cube", "scale": 0.2, "shattered": true, "pattern": {"count": 6}},
                    {"name": "floor", "mesh": "shape:cube", "translation": [0, -1, 0], "fixed": true},
                    {"name": "pane", "mesh": "shape:pane", "translation": [0, 0, -3], "material": "glass"}],
        "world": {"shots": [{"time": 0, "from": [0, 0, -4], "velocity": [0, 0, 60], "radius": 0.1, "density": 7800}]}})");
    const std::string command = "profile " + (folder / "two.json") + " --warm-up 1 --repeats 2 --json ";
    const Outcome alone = run_brittle(folder, command + "--frames 0");
    INFO(alone.output);
    REQUIRE(alone.exit_code == 0);
    const auto without = nlohmann::json::parse(alone.output);
    CHECK(without["scenarios"][0]["recipe"]["objects"].size() == 3);
    CHECK_FALSE(without["environment"].contains("device"));
    CHECK_FALSE(without["scenarios"][0].contains("frames"));

    const Outcome outcome = run_brittle(folder, command + "--frames 20 --size 64x48 --csv " + (folder / "two.csv")
                                                    + " --trace " + (folder / "trace.json"));
    INFO(outcome.output);
    if (no_vulkan(outcome)) return;
    REQUIRE(outcome.exit_code == 0);
    const auto profile = nlohmann::json::parse(outcome.output);
    const auto& scenario = profile["scenarios"][0];
    CHECK(scenario["name"] == "two");
    CHECK(scenario["objects"] == 3);
    CHECK(scenario["triangles"] == 36);
    const auto pieces = scenario["pieces"].get<int>();
    CHECK(pieces > 4); // of the block, the floor and the pane
    CHECK(pieces <= 8);
    for (const char* phase : {"read", "prepare", "total"}) CHECK(scenario["start"][phase]["samples"] == 2);
    CHECK(scenario["frames"]["starting"]["bodies and upload"]["samples"] == 1);
    CHECK(scenario["frames"]["standing"]["frame"]["samples"] == 20);
    CHECK_FALSE(scenario["frames"]["standing"].contains("physics"));
    CHECK(scenario["frames"]["playing"]["physics"]["samples"] == 20);
    CHECK(scenario["frame_series"]["playing_from"] == 21);
    CHECK(scenario["frame_series"]["milliseconds"].size() == 41);
    CHECK(scenario["played"]["cuts"].get<int>() >= 1); // the ball meets the pane
    CHECK(scenario["played"]["pieces"].get<int>() > pieces);
    const std::string csv = read_text(folder / "two.csv");
    CHECK(csv.find("two,,36,,") != std::string::npos); // it has no mesh and no sites
    CHECK(csv.find(",start,total,") != std::string::npos);
    CHECK(csv.find(",frames playing,physics,") != std::string::npos);
    CHECK(read_text(folder / "trace.json").find("\"prepare\"") != std::string::npos);

    write_text(folder / "old.json", profile.dump());
    const std::string again =
        "profile " + (folder / "two.json") + " --repeats 5 --frames 0 --compare " + (folder / "old.json");
    const Outcome few = run_brittle(folder, again);
    CHECK(few.exit_code == 0);
    CHECK(few.has("3 objects, 36 triangles"));
    CHECK(few.has("two, start"));
    CHECK(few.has("too few samples"));
    auto fast = profile;
    for (auto& [phase, row] : fast["scenarios"][0]["start"].items())
        row = {{"min", 1e-4}, {"median", 1e-4}, {"samples", 9}};
    write_text(folder / "old.json", fast.dump());
    CHECK(run_brittle(folder, again).exit_code == 7);
    const Outcome idle =
        run_brittle(folder, "profile " + (folder / "two.json") + " --material glass --frames 0 --repeats 1"
                                + " --save-recipe " + (folder / "saved.json"));
    CHECK(idle.exit_code == 0);
    CHECK(idle.has("--material and --pieces, have no effect on a scene"));
    CHECK(read_text(folder / "saved.json").find("\"pane\"") != std::string::npos);
    const Outcome listed = run_brittle(folder, "profile " + (folder / "two.json") + " --counts 3,4");
    CHECK(listed.exit_code == 2);
    CHECK(listed.has("a scene is measured as it is"));
}

TEST_CASE("profile measures lists of meshes and counts, on both sides, and writes CSV and a time line") {
    const Folder folder;
    const Outcome outcome =
        run_brittle(folder, "profile --meshes shape:cube,shape:icosphere --counts 3,4 --classify cpu,gpu "
                            "--warm-up 0 --repeats 1 --frames 1 --size 64x48 --validation --csv "
                                + (folder / "p.csv") + " --trace " + (folder / "t.json"));
    INFO(outcome.output);
    if (no_vulkan(outcome)) return;
    REQUIRE(outcome.exit_code == 0);
    for (const char* name : {"cube 3 cpu", "cube 4 gpu", "icosphere 4 gpu", "medians"}) CHECK(outcome.has(name));
    CHECK(read_text(folder / "p.csv").starts_with("scenario,"));
    const auto trace = nlohmann::json::parse(read_text(folder / "t.json"));
    CHECK(trace["otherData"].contains("device_clock"));
    size_t scenarios = 0, passes = 0;
    for (const auto& event : trace["traceEvents"]) {
        if (event["ph"] != "X") continue;
        CHECK(event["ts"].get<double>() >= 0.0);
        CHECK(event["dur"].get<double>() >= 0.0);
        scenarios += event["name"] == "cube 3 cpu" || event["name"] == "icosphere 4 gpu";
        passes += event["name"] == "classify vertices" || event["name"] == "shade";
    }
    CHECK(scenarios == 2);
    CHECK(passes > 0);
}

TEST_CASE("a time line shows each thread's part of a fracture") {
    const Folder folder;
    REQUIRE(run_brittle(folder, "profile shape:torus -n 50 --threads 2 --warm-up 0 --repeats 2 --frames 0 --trace "
                                    + (folder / "t.json"))
                .exit_code
            == 0);
    const auto trace = nlohmann::json::parse(read_text(folder / "t.json"));
    REQUIRE(trace["traceEvents"].is_array());
    std::map<int, std::string> threads;
    std::map<int, double> end_of; // end of each thread's last slice with items
    std::set<std::string> steps;
    for (const auto& event : trace["traceEvents"]) {
        // Fields of the Trace Event Format: of every event, and additional ones of complete events.
        for (const char* key : {"name", "ph", "pid", "tid"}) REQUIRE(event.contains(key));
        const int thread = event["tid"].get<int>();
        if (event["ph"] == "M" && event["name"] == "thread_name") threads[thread] = event["args"]["name"];
        if (event["ph"] != "X") continue;
        REQUIRE(threads.contains(thread)); // named before it is used
        REQUIRE(event["ts"].is_number());
        REQUIRE(event["dur"].is_number());
        if (!event.contains("args")) continue;
        CHECK(threads[thread].starts_with("worker "));
        CHECK(event["args"]["from"].get<unsigned>() <= event["args"]["to"].get<unsigned>());
        CHECK(event["ts"].get<double>() >= end_of[thread]);
        end_of[thread] = event["ts"].get<double>() + event["dur"].get<double>();
        steps.insert(event["name"]);
    }
    CHECK(threads.contains(1));
    CHECK(end_of.size() >= 1);
    CHECK(end_of.size() <= 2);
    for (const char* step : {"cells", "classify", "cut edges", "cut triangles", "caps", "islands"})
        CHECK(steps.contains(step));
}

TEST_CASE("profile measures which processor classifies faster, and reports it") {
    const Folder folder;
    const Outcome outcome =
        run_brittle(folder, "profile shape:icosphere -n 20 --classify auto --warm-up 0 --repeats 1 --frames 0 --json");
    INFO(outcome.output);
    if (no_vulkan(outcome)) return;
    REQUIRE(outcome.exit_code == 0);
    const auto profile = nlohmann::json::parse(outcome.output);
    const auto& scenario = profile["scenarios"][0];
    CHECK(scenario["name"] == "icosphere 20 auto");
    const auto where = scenario["classify"].get<std::string>();
    CHECK((where == "cpu" || where == "gpu"));
    CHECK(scenario["classify_why"].get<std::string>().starts_with(where + ": the fracture takes "));
    CHECK(scenario["fracture"].contains("pass classify vertices") == (where == "gpu"));
    CHECK(run_brittle(folder, "profile shape:cube -n 3 --classify auto --warm-up 0 --repeats 1 --frames 0")
              .has("classification on the "));
}

TEST_CASE("profile --compare reports faster and slower runs, and refuses a file that is not a profile") {
    const Folder folder;
    const std::string command = "profile shape:cube -n 4 --repeats 5 --frames 0 ", old = folder / "old.json";
    REQUIRE(run_brittle(folder, command + "-o " + old).exit_code == 0);
    auto profile = nlohmann::ordered_json::parse(read_text(old));
    const auto set = [&](double milliseconds) {
        for (auto& [phase, row] : profile["scenarios"][0]["fracture"].items())
            for (const char* key : {"min", "median"}) row[key] = milliseconds;
        write_text(old, profile.dump());
    };
    set(1e9);
    const Outcome faster = run_brittle(folder, command + "--compare " + old);
    CHECK(faster.exit_code == 0);
    CHECK(faster.has("nothing is slower"));
    CHECK(faster.has("faster"));
    set(1e-9);
    const Outcome slower = run_brittle(folder, command + "--json --compare " + old + " --threshold 2");
    CHECK(slower.exit_code == 7);
    CHECK(nlohmann::json::parse(slower.output)["comparison"]["slower"] == true);
    write_text(old, "{}");
    const Outcome none = run_brittle(folder, command + "--compare " + old);
    CHECK(none.exit_code == 3);
    CHECK(none.has("not a profile"));
    CHECK(run_brittle(folder, command + "--compare " + (folder / "missing.json")).exit_code == 3);
}

TEST_CASE("profile refuses impossible requests before any work") {
    const Folder folder;
    const auto refused = [&](const std::string& arguments, int code, const std::string& words) {
        const Outcome outcome = run_brittle(folder, "profile " + arguments);
        INFO(arguments, ": ", outcome.output);
        CHECK(outcome.exit_code == code);
        CHECK(outcome.has(words));
    };
    refused("--frames 0", 2, "--meshes");
    refused("shape:cube --meshes shape:torus", 2, "--meshes");
    refused("shape:cube --counts 3 -n 4", 2, "--counts");
    refused("shape:cube --counts 3,x", 2, "--counts");
    refused("shape:cube --counts 3,3", 2, "two scenarios");
    refused("shape:cube --classify tpu", 2, "--classify");
    refused("shape:cube --threshold 2", 2, "--compare");
    refused("shape:cube --compare a.json --threshold 0.5", 2, "--threshold");
    refused("--scenarios " + (folder / "none.json"), 3, "none.json");
    write_text(folder / "plan.json", R"({"brittle_profile": 1, "scenarios": [{"counts": [0]}]})");
    refused("--scenarios " + (folder / "plan.json"), 3, "/scenarios/0/counts");
    write_text(folder / "plan.json", R"({"brittle_profile": 1, "frames": 0, "warm_up": 0, "repeats": 50,
        "scenarios": [{"meshes": ["shape:cube"], "counts": [2, 3]}]})");
    const Outcome planned = run_brittle(folder, "profile --json --repeats 1 --scenarios " + (folder / "plan.json"));
    REQUIRE(planned.exit_code == 0);
    const auto profile = nlohmann::json::parse(planned.output);
    CHECK(profile["scenarios"].size() == 2);
    CHECK(profile["settings"]["warm_up"] == 0);
    CHECK(profile["settings"]["repeats"] == 1); // the command line overrides the file
    refused("shape:cube -n 2 --repeats 1 --frames 0 --csv " + (folder / "no/such.csv"), 5, "no/such");
}

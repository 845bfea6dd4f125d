// Processing of measurements by `brittle profile`: scenarios, series, CSV, time line, comparison of two runs.
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/tools/support.h"
#include "tools/brittle/profile/compare.h"
#include "tools/brittle/profile/csv.h"
#include "tools/brittle/profile/scenario.h"
#include "tools/brittle/profile/series.h"
#include "tools/brittle/profile/trace.h"
#include "tools/scenario/base/environment.h"
#include "tools/scenario/base/failure.h"

using namespace brittle::tools;
using Json = nlohmann::ordered_json;
using namespace brittle::tools::test;
namespace fs = std::filesystem;

namespace {

// Returns the message of the Failure that `work` throws and checks its exit code; "" if it throws none.
template<class Work>
std::string message_of(ExitCode code, const Work& work) {
    try {
        work();
    } catch (const Failure& failure) {
        CHECK(failure.code() == code);
        return failure.what();
    }
    return "";
}

bool has(const std::string& text, const std::string& words) {
    CAPTURE(text);
    const bool found = text.find(words) != std::string::npos;
    CHECK(found);
    return found;
}

std::string plan_message(const std::string& text) {
    const Folder folder;
    return message_of(exit_input, [&] {
        ProfilePlan plan;
        read_profile_plan(folder.write("plan.json", text), plan);
    });
}

Json row(double least, double median, int samples = 9) {
    return {{"min", least},        {"median", median},    {"p95", 2.0 * median},
            {"p99", 2.0 * median}, {"max", 2.0 * median}, {"samples", samples}};
}

Json profile_of(const Json& total, const Json& frame, const std::string& name = "bunny 100 cpu") {
    return {{"brittle_profile", 1},
            {"environment", {{"processor", "one"}}},
            {"settings", {{"size", "64x48"}}},
            {"scenarios",
             {{{"name", name},
               {"mesh", "bunny"},
               {"triangles", 12},
               {"sites", 100},
               {"pieces", 73},
               {"classify", "cpu"},
               {"fracture", {{"clip", total}, {"total", total}}},
               {"frames", {{"falling", {{"frame", frame}}}, {"taking over", {{"frame", row(1.0, 1.0, 1)}}}}}}}}};
}

Comparison compared(const Json& before_total, const Json& after_total, double threshold = 1.1) {
    const Json frame = row(10.0, 12.0);
    return compare_profiles(profile_of(before_total, frame), profile_of(after_total, frame), threshold);
}

Verdict verdict_of(const Comparison& comparison, const std::string& group, const std::string& phase) {
    for (const ComparedPhase& p : comparison.phases)
        if (p.group == group && p.phase == phase) return p.verdict;
    FAIL("no such phase");
    return Verdict::same;
}

} // namespace

TEST_CASE("profile: the scenarios are all combinations of the lists, in their order") {
    FractureOptions base;
    base.pattern.seed = 7;
    const ScenarioGroup lists{{}, {}, {"shape:torus", "folder/b.obj"}, {10, 20}, {"cpu", "gpu"}};
    const std::vector<Scenario> all = make_scenarios({}, lists, base);
    REQUIRE(all.size() == 8);
    CHECK(all[0].name == "torus 10 cpu");
    CHECK(all[1].name == "torus 10 gpu");
    CHECK(all[1].classify == ClassifyPath::gpu);
    CHECK(all[7].name == "b 20 gpu");
    CHECK(all[7].fracture.mesh == "folder/b.obj");
    CHECK(all[7].fracture.pattern.count == 20);
    CHECK(all[7].fracture.pattern.seed == 7);
}

TEST_CASE("profile: one mesh and one count are one scenario") {
    FractureOptions base;
    base.mesh = "shape:cube";
    base.pattern.count = 5;
    const std::vector<Scenario> all = make_scenarios({}, {}, base);
    REQUIRE(all.size() == 1);
    CHECK(all[0].name == "cube 5 cpu");
    CHECK(all[0].classify == ClassifyPath::cpu);
}

TEST_CASE("profile: a plan's groups replace the lists, which fill in what a group leaves open") {
    const Folder folder;
    (void)folder.write("glass.json",
                       R"({"brittle": 1, "mesh": "pane.obj", "pattern": {"type": "radial", "count": 30}})");
    ProfilePlan plan;
    read_profile_plan(folder.write("plan.json", R"({"brittle_profile": 1, "repeats": 3, "warm_up": 0, "scenarios": [
        {"meshes": ["shape:cube", "b.obj"], "counts": [4]},
        {"name": "glass", "recipe": "glass.json", "classify": ["gpu"]}]})"),
                      plan);
    CHECK(plan.repeats == 3);
    CHECK(plan.warm_up == 0);
    CHECK(plan.frames == ProfilePlan().frames);
    const FractureOptions nothing; // GCC 12 misfires on a temporary one (-Wmaybe-uninitialized)
    const std::vector<Scenario> all = make_scenarios(plan, {}, nothing);
    REQUIRE(all.size() == 3);
    CHECK(all[0].name == "cube 4 cpu");
    CHECK(all[1].fracture.mesh == (folder.path / "b.obj").string());
    CHECK(all[2].name == "glass pane 30 gpu");
    CHECK(all[2].fracture.pattern.kind == brittle::fracture::PatternKind::radial);

    ScenarioGroup lists;
    lists.counts = {6, 7};
    lists.meshes = {"shape:torus"};
    const std::vector<Scenario> more = make_scenarios(plan, lists, nothing);
    REQUIRE(more.size() == 4); // cube and b with 4; torus of glass, with 6 and 7
    CHECK(more[3].name == "glass torus 7 gpu");
}

TEST_CASE("profile: a scene is one scenario, named by its file, and takes no lists") {
    FractureOptions scene;
    scene.objects.emplace_back();
    CHECK(make_scenarios({}, {}, scene).front().name == "scene");
    ScenarioGroup lists;
    lists.recipe = "folder/room.json"; // of the command line: it has been read, and is not read again
    const std::vector<Scenario> all = make_scenarios({}, lists, scene);
    REQUIRE(all.size() == 1);
    CHECK(all[0].name == "room");
    CHECK(all[0].fracture.objects.size() == 1);
    for (const ScenarioGroup& more : {ScenarioGroup{{}, {}, {"shape:cube"}, {}, {}}, ScenarioGroup{{}, {}, {}, {3}, {}},
                                      ScenarioGroup{{}, {}, {}, {}, {"cpu"}}})
        has(message_of(exit_usage, [&] { (void)make_scenarios({}, more, scene); }), "a scene is measured as it is");

    const Folder folder;
    (void)folder.write("hall.json", R"({"brittle": 2, "objects": [{"name": "a", "mesh": "shape:cube"}]})");
    ProfilePlan plan;
    read_profile_plan(folder.write("plan.json", R"({"brittle_profile": 1, "scenarios": [
        {"recipe": "hall.json", "name": "big"}, {"meshes": ["shape:cube"], "counts": [4]}]})"),
                      plan);
    const FractureOptions nothing;
    const std::vector<Scenario> mixed = make_scenarios(plan, {}, nothing);
    REQUIRE(mixed.size() == 2);
    CHECK(mixed[0].name == "big hall");
    CHECK(mixed[1].name == "cube 4 cpu");
}

TEST_CASE("profile: the start of a scene is compared, and decides") {
    const auto scene = [](double total, double frame) {
        Json json = profile_of(row(1.0, 1.0), row(1.0, 1.0), "room");
        Json& scenario = json["scenarios"][0];
        scenario.erase("fracture");
        scenario["start"] = {{"read", row(1.0, 1.0)}, {"total", row(total, total)}};
        scenario["frames"] = {{"playing", {{"frame", row(frame, frame)}}}};
        return json;
    };
    CHECK_FALSE(compare_profiles(scene(1.0, 1.0), scene(1.0, 1.0), 1.1).slower);
    CHECK(compare_profiles(scene(1.0, 1.0), scene(2.0, 1.0), 1.1).slower);
    CHECK(compare_profiles(scene(1.0, 1.0), scene(1.0, 2.0), 1.1).slower);
    // A mesh of that name was measured before.
    CHECK_FALSE(compare_profiles(profile_of(row(1.0, 1.0), row(1.0, 1.0), "room"), scene(9.0, 1.0), 1.1).slower);
}

TEST_CASE("profile: impossible scenarios are refused") {
    FractureOptions base;
    has(message_of(exit_usage, [&] { (void)make_scenarios({}, {}, base); }), "--meshes");
    base.mesh = "shape:cube";
    ScenarioGroup lists;
    lists.counts = {10, 10};
    has(message_of(exit_usage, [&] { (void)make_scenarios({}, lists, base); }),
        "two scenarios are named 'cube 10 cpu'");
    lists.counts = {10, 20};
    base.save_recipe = "r.json";
    has(message_of(exit_usage, [&] { (void)make_scenarios({}, lists, base); }), "--save-recipe");
    base.sites_file = "sites.txt";
    has(message_of(exit_usage, [&] { (void)make_scenarios({}, lists, base); }), "counts need a pattern");
}

TEST_CASE("profile: faults of a plan are named with their place") {
    has(plan_message("{}"), "plan.json: /brittle_profile");
    has(plan_message(R"({"brittle_profile": 1})"), "/scenarios");
    has(plan_message(R"({"brittle_profile": 1, "scenarios": []})"), "that is not empty");
    has(plan_message(R"({"brittle_profile": 1, "scenarios": [3]})"), "/scenarios/0: expected an object");
    has(plan_message(R"({"brittle_profile": 1, "scenarios": [{"counts": [0]}]})"),
        "/scenarios/0/counts: expected a whole");
    has(plan_message(R"({"brittle_profile": 1, "scenarios": [{"counts": 5}]})"), "a list [ ]");
    has(plan_message(R"({"brittle_profile": 1, "scenarios": [{"classify": ["tpu"]}]})"),
        "\"auto\", \"cpu\" or \"gpu\"");
    has(plan_message(R"({"brittle_profile": 1, "scenarios": [{"meshes": [1]}]})"), "text in quotes");
    has(plan_message(R"({"brittle_profile": 1, "scenarios": [{"mesh": "a"}]})"),
        "unknown key; the keys are: name, recipe, meshes");
    has(plan_message(R"({"brittle_profile": 1, "repeats": 0, "scenarios": [{}]})"), "/repeats");
    has(plan_message(R"({"brittle_profile": 1, "loops": 1, "scenarios": [{}]})"), "/loops: unknown key");
    has(plan_message("[1"), "cannot be read");
}

TEST_CASE("profile: the plans in assets/ can be read, and the schema lists their keys") {
    const auto schema = nlohmann::json::parse(std::ifstream(BRITTLE_ASSETS "/profile.schema.json"));
    const auto& keys = schema["properties"];
    const auto& group_keys = keys["scenarios"]["items"]["properties"];
    for (const auto& [name, least] : {std::pair{"shapes.json", 6u}, {"sweep.json", 6u}, {"gpu_classify.json", 4u}}) {
        const fs::path file = fs::path(BRITTLE_ASSETS) / "profiles" / name;
        ProfilePlan plan;
        read_profile_plan(file, plan);
        FractureOptions base;
        base.mesh = "shape:cube";
        CHECK(make_scenarios(plan, {}, base).size() >= least);
        const auto json = nlohmann::json::parse(std::ifstream(file));
        for (const auto& [key, value] : json.items()) CHECK(keys.contains(key));
        for (const auto& group : json["scenarios"])
            for (const auto& [key, value] : group.items()) CHECK(group_keys.contains(key));
    }
    // The schema has no key that the reader refuses.
    const auto is_known = [](const std::string& text) {
        return plan_message("{\"brittle_profile\": 1, " + text).find("unknown key") == std::string::npos;
    };
    for (const auto& [key, value] : keys.items()) CHECK(is_known("\"" + key + "\": null, \"scenarios\": [{}]}"));
    for (const auto& [key, value] : group_keys.items()) CHECK(is_known("\"scenarios\": [{\"" + key + "\": null}]}"));
}

TEST_CASE("profile: a series keeps the order of its names") {
    Series series;
    series.add("b", 2.0);
    series.add("a", 1.0);
    series.add("b", 4.0);
    const Json json = series.json();
    CHECK(json.begin().key() == "b");
    CHECK(json["b"]["median"] == 3.0);
    CHECK(json["b"]["samples"] == 2);
    CHECK(json["a"]["p99"] == 1.0);
    CHECK(Series().json() == Json::object());
}

TEST_CASE("profile: slices of a trace nest, and overlaps by a rounding error are removed") {
    Trace trace;
    trace.add(Track::device, 0, "second", 1'500, 2'500); // begins before the end of the first
    trace.add(Track::device, 0, "first", 1'000, 1'600);
    trace.add_steps(Track::main, 1, {{"a", 0.001}, {"b", 0.002}, {"late", 0.5}}, 1'000);
    trace.add(Track::main, 0, "all", 1'000, 5'000);
    trace.add(Track::main, 0, "next", 5'000, 5'000);
    trace.add(Track::worker, 1, "orphan", 900, 800); // ends before it begins, and lies in no other slice
    trace.mark("now", 3'000);
    trace.add(share_track(1), 0, "cells", 2'000, 2'500, 40, 80);
    const Json json = Json::parse(trace.json({{"device", "none"}}).dump());
    CHECK(json["otherData"]["device"] == "none");

    struct Slice {
        std::string name;
        double begin, end;
    };
    std::map<int, std::vector<Slice>> open; // open slices of each thread, outermost first
    std::map<std::string, Slice> slices;
    double last = -1.0;
    int last_thread = 0, names = 0, marks = 0;
    for (const Json& event : json["traceEvents"]) {
        const auto kind = event["ph"].get<std::string>();
        CHECK(event["pid"] == 1);
        if (kind == "M") ++names;
        if (kind == "i") {
            ++marks;
            CHECK(event["ts"] == 2.0); // from the orphan, at 900 ns, in eighths of a microsecond
        }
        if (kind != "X") continue;
        const double begin = event["ts"].get<double>(), duration = event["dur"].get<double>();
        const int thread = event["tid"].get<int>();
        CHECK(begin >= 0.0);
        CHECK(duration >= 0.0);
        if (thread == last_thread) CHECK(begin >= last);
        last_thread = thread;
        last = begin;
        auto& outer = open[thread];
        while (!outer.empty() && outer.back().end <= begin) outer.pop_back();
        if (!outer.empty()) CHECK(begin + duration <= outer.back().end);
        const Slice slice{event["name"].get<std::string>(), begin, begin + duration};
        outer.push_back(slice);
        slices[slice.name] = slice;
    }
    CHECK(names == 5); // the process and four threads
    CHECK(marks == 1);
    CHECK(slices.size() == 9);
    CHECK(slices["second"].begin == slices["first"].end);
    CHECK(slices["late"].end == slices["all"].end); // cut
    CHECK(slices["b"].begin == slices["a"].end);
}

TEST_CASE("profile: CSV has one line per phase and quotes where needed") {
    const std::string csv = profile_csv(profile_of(row(1.5, 2.0), row(3.0, 4.0), "a \"b\", c"));
    std::istringstream stream(csv);
    std::vector<std::vector<std::string>> lines;
    for (std::string line; std::getline(stream, line);) {
        std::vector<std::string> cells(1);
        bool quoted = false;
        for (size_t i = 0; i < line.size(); ++i) {
            if (line[i] == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"')
                cells.back() += line[++i];
            else if (line[i] == '"')
                quoted = !quoted;
            else if (line[i] == ',' && !quoted)
                cells.emplace_back();
            else
                cells.back() += line[i];
        }
        CHECK_FALSE(quoted);
        lines.push_back(cells);
    }
    REQUIRE(lines.size() == 5); // columns; clip, total; the frame falling and taking over
    for (const auto& line : lines) CHECK(line.size() == 14);
    CHECK(lines[0][0] == "scenario");
    CHECK(lines[2][0] == "a \"b\", c");
    CHECK(lines[2][7] == "total");
    CHECK(std::stod(lines[2][8]) == 1.5);
    CHECK(lines[3][6] == "frames falling");
    CHECK(lines[3][13] == "9");
}

TEST_CASE("profile: a phase is slower if median and minimum exceed the threshold") {
    const Comparison same = compared(row(9.0, 10.0), row(12.0, 10.5));
    CHECK_FALSE(same.slower);
    CHECK(verdict_of(same, "fracture", "total") == Verdict::same);
    CHECK(same.notes.empty());

    const Comparison slower = compared(row(9.0, 10.0), row(10.0, 11.5));
    CHECK(slower.slower);
    CHECK(verdict_of(slower, "fracture", "total") == Verdict::slower);
    CHECK(verdict_of(slower, "fracture", "clip") == Verdict::slower);
    CHECK_FALSE(compared(row(9.0, 10.0), row(10.0, 11.5), 1.2).slower);

    const Comparison noise = compared(row(9.0, 10.0), row(9.1, 20.0));
    CHECK_FALSE(noise.slower);
    CHECK(verdict_of(noise, "fracture", "total") == Verdict::noise);

    CHECK(verdict_of(compared(row(9.0, 10.0), row(4.0, 5.0)), "fracture", "total") == Verdict::faster);
    CHECK(verdict_of(compared(row(9.0, 10.0), row(9.0, 9.2)), "fracture", "total") == Verdict::same);
    CHECK(verdict_of(compared(row(4.0, 10.0), row(4.0, 5.0)), "fracture", "total") == Verdict::noise);
}

TEST_CASE("profile: few samples and single phases decide nothing") {
    const Comparison few = compared(row(9.0, 10.0, 4), row(90.0, 100.0, 9));
    CHECK_FALSE(few.slower);
    CHECK(verdict_of(few, "fracture", "total") == Verdict::few);
    CHECK(verdict_of(few, "frames taking over", "frame") == Verdict::few);

    Json before = profile_of(row(10.0, 11.0), row(10.0, 11.0)), after = before;
    after["scenarios"][0]["fracture"]["clip"] = row(90.0, 91.0);
    CHECK_FALSE(compare_profiles(before, after, 1.1).slower);
    after["scenarios"][0]["frames"]["falling"]["frame"] = row(90.0, 91.0);
    CHECK(compare_profiles(before, after, 1.1).slower);
}

TEST_CASE("profile: a phase that took no time before is infinitely slower, which is null in JSON") {
    const Comparison comparison = compared(row(0.0, 0.0), row(1.0, 1.0));
    CHECK(comparison.slower);
    CHECK(Json::parse(comparison_json(comparison).dump())["phases"][1]["ratio"].is_null());
    CHECK_FALSE(compared(row(0.0, 0.0), row(0.0, 0.0)).slower);
}

TEST_CASE("profile: differences of machine and work, and unmatched scenarios, are noted") {
    const Json old = profile_of(row(1.0, 1.0), row(1.0, 1.0));
    Json now = old;
    now["environment"]["processor"] = "two";
    now["scenarios"][0]["pieces"] = 74;
    now["scenarios"].push_back(profile_of(row(1.0, 1.0), row(1.0, 1.0), "cat 10 cpu")["scenarios"][0]);
    const Comparison comparison = compare_profiles(old, now, 1.1);
    REQUIRE(comparison.notes.size() == 3);
    has(comparison.notes[0], "processor was \"one\", is \"two\"");
    has(comparison.notes[1], "bunny 100 cpu: pieces was 73, is 74");
    has(comparison.notes[2], "cat 10 cpu is new");
    has(compare_profiles(now, old, 1.1).notes.back(), "cat 10 cpu was not measured again");
    has(message_of(exit_input,
                   [&] { (void)compare_profiles(old, profile_of(row(1.0, 1.0), row(1.0, 1.0), "dog 10 cpu"), 1.1); }),
        "no scenario in common");
}

TEST_CASE("profile: --compare refuses a file that is not a profile") {
    const Folder folder;
    const auto message = [&](const Json& json) {
        return message_of(exit_input, [&] { (void)read_profile(folder.write("old.json", json.dump())); });
    };
    const Json good = profile_of(row(1.0, 1.0), row(1.0, 1.0));
    CHECK(message(good).empty());
    has(message({{"brittle", 1}}), "old.json: this is not a profile");
    Json bad = good;
    bad["scenarios"][0]["fracture"]["total"].erase("median");
    has(message(bad), "/scenarios/0/fracture/total/median: is missing");
    bad = good;
    bad["scenarios"][0]["frames"]["falling"]["frame"]["min"] = "fast";
    has(message(bad), "/frames/falling/frame/min: expected a number");
    bad = good;
    bad["scenarios"][0].erase("fracture");
    has(message(bad), "/scenarios/0/fracture: is missing");
    bad = good;
    bad["scenarios"] = 3;
    has(message(bad), "this is not a profile");
    has(message_of(exit_input, [&] { (void)read_profile(folder.path / "none.json"); }), "cannot be read");
}

TEST_CASE("profile: the environment names no path") {
    const Json json = environment();
    for (const char* key : {"brittle", "commit", "compiler", "build", "system", "processor", "hardware_threads"})
        CHECK(json.contains(key));
    CHECK(json["commit"].get<std::string>().find('/') == std::string::npos);
    CHECK(json["hardware_threads"].get<unsigned>() > 0);
}

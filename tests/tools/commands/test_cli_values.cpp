// Odd values and odd names on the command line, and files that are written together. Runs the real binary.
#include <doctest/doctest.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include "tests/tools/support.h"

namespace fs = std::filesystem;
using namespace brittle::tools::test;

TEST_CASE("NaN, infinity and text are refused for every number, with limits as people write them") {
    const Folder folder;
    const std::vector<std::string> options{"fracture:--jitter",      "fracture:--grading",
                                           "fracture:--piece-size",  "fracture:--min-volume",
                                           "fracture:--scale-sites", "fracture:--density",
                                           "fracture:--pieces",      "fracture:--seed",
                                           "fracture:--threads",     "render:--strength",
                                           "render:--min-size",      "render:--air-density",
                                           "render:--height",        "render:--azimuth",
                                           "render:--elevation",     "render:--distance",
                                           "render:--explode",       "render:--dust",
                                           "render:--frames",        "repair:--weld",
                                           "repair:--close-holes",   "profile:--threshold",
                                           "fracture:--roughness",   "fracture:--rough-size",
                                           "fracture:--detail",      "fracture:--cells-per-piece"};
    for (const std::string& option : options)
        for (const char* value : {"nan", "-nan", "inf", "-inf", "NAN(7)", "1e999", "", "three", "0x"}) {
            const size_t colon = option.find(':');
            const std::string name = option.substr(colon + 1);
            const Outcome outcome = run_brittle(folder, option.substr(0, colon) + " shape:cube -o " + (folder / "a.glb")
                                                            + " " + name + " '" + value + "'");
            INFO(option, " ", value, ": ", outcome.output);
            CHECK(outcome.exit_code == 2);
            CHECK(outcome.has(name));
        }
    for (const char* vector : {"--focus", "--axis", "--move-sites", "--turn-sites", "--grain"})
        for (const char* value : {"nan,0,0", "0,inf,0", "0,0,-nan"}) {
            const Outcome outcome =
                run_brittle(folder, "fracture shape:cube -o " + (folder / "a.glb") + " " + vector + " " + value);
            INFO(outcome.output);
            CHECK(outcome.exit_code == 2);
        }
    for (const char* beyond : {"--shot 1e39,0,0,0,0,0,0.1", "--shot 0,0,0,0,-1e39,0,0.1", "--anchor 0,1e39,0,1"}) {
        const Outcome outcome = run_brittle(folder, "render shape:cube -o " + (folder / "a.png") + " " + beyond);
        INFO(outcome.output);
        CHECK(outcome.exit_code == 2);
        CHECK(outcome.has("1e+39, which is larger than 1,000,000,000"));
    }
    CHECK(folder.files() == 0);
    const auto message = [&](const std::string& arguments) {
        return run_brittle(folder, "fracture shape:cube -o " + (folder / "a.glb") + " " + arguments).output;
    };
    CHECK(message("-n 0").find("'0' is not a number from 1 to 1,000,000") != std::string::npos);
    CHECK(message("--jitter 1.5").find("'1.5' is not a number from 0 to 1") != std::string::npos);
    CHECK(message("--roughness 1.5").find("'1.5' is not a number from 0 to 1") != std::string::npos);
    CHECK(message("--detail 7").find("'7' is not a number from 1 to 6") != std::string::npos);
    for (const char* grain : {"0,20,0", "0.01,0,0", "1e200,1e200,0"})
        CHECK(message(std::string("--grain ") + grain).find("give a direction as long as") != std::string::npos);
    CHECK(message("--piece-size -1").find("'-1' is not a number above 0") != std::string::npos);
}

TEST_CASE("a file name that is not UTF-8 gives JSON that is, and no text of an exception") {
    const Folder folder;
    const std::string name = folder / "m\xe9sh\xff.off"; // Latin-1
    write_text(name, "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n");
    const Outcome inspected = run_brittle(folder, "inspect --json '" + name + "'");
    CHECK(inspected.exit_code == 0);
    CHECK(nlohmann::json::accept(inspected.output));
    const std::string report = folder / "report.json";
    for (const char* ending : {"glb", "obj", "ply", "stl"}) {
        const Outcome broken = run_brittle(folder, "fracture '" + name + "' -n 3 -o " + (folder / "out.") + ending
                                                       + " --report " + report);
        INFO(broken.output);
        CHECK(broken.exit_code == 0);
        CHECK_FALSE(broken.has("json.exception"));
        CHECK(nlohmann::json::accept(read_text(report)));
    }
    // A recipe would name another file, so it is refused.
    const Outcome saved = run_brittle(folder, "fracture '" + name + "' -n 3 -o " + (folder / "out.glb")
                                                  + " --save-recipe " + (folder / "recipe.json"));
    INFO(saved.output);
    CHECK_FALSE(saved.has("json.exception"));
    CHECK(saved.exit_code == 5);
    CHECK(saved.has("UTF-8"));
    CHECK_FALSE(fs::exists(folder / "recipe.json"));
}

TEST_CASE("on a full disk one file per piece leaves nothing behind") {
    for (const std::string ending : {".glb", ".obj", ".stl"}) {
        const Folder folder;
        const std::string command = "fracture shape:icosphere -n 12 --pattern clustered --seed 3 --per-piece -o "
                                    + (folder / ("piece" + ending));
        REQUIRE(run_brittle(folder, command).exit_code == 0);
        uintmax_t first = 0, largest = 0;
        for (const auto& entry : fs::directory_iterator(folder.path)) {
            if (entry.path().extension() != ending) continue;
            largest = std::max(largest, entry.file_size());
            if (entry.path().stem() == "piece_000") first = entry.file_size();
        }
        REQUIRE(first < largest); // so that files are complete before one fails
        for (const auto& entry : fs::directory_iterator(folder.path)) fs::remove(entry.path());
        // Larger files cannot be written: without the signal, write() fails as on a full disk.
        rlimit before{};
        REQUIRE(::getrlimit(RLIMIT_FSIZE, &before) == 0);
        const auto handler = std::signal(SIGXFSZ, SIG_IGN);
        const rlimit little{largest - 1, before.rlim_max};
        REQUIRE(::setrlimit(RLIMIT_FSIZE, &little) == 0);
        const Outcome outcome = run_brittle(folder, command);
        REQUIRE(::setrlimit(RLIMIT_FSIZE, &before) == 0);
        std::signal(SIGXFSZ, handler);
        INFO(ending, ": ", outcome.output);
        CHECK(outcome.exit_code == 5);
        CHECK(outcome.has("cannot write"));
        CHECK(folder.files() == 0);
    }
}

TEST_CASE("-n gives about that many pieces, --sites-in-box fewer, and recipes keep their sites") {
    const Folder folder;
    const std::string report = folder / "report.json", recipe = folder / "recipe.json";
    const auto run = [&](const std::string& arguments) {
        const Outcome outcome =
            run_brittle(folder, "fracture " + arguments + " -o " + (folder / "a.ply") + " --report " + report);
        REQUIRE_MESSAGE(outcome.exit_code == 0, outcome.output);
        auto json = nlohmann::json::parse(read_text(report));
        json["text"] = outcome.output;
        return json;
    };
    for (const std::string pattern : {"uniform", "clustered"}) {
        const std::string options = "shape:animal -n 60 --pattern " + pattern;
        const auto inside = run(options + " --save-recipe " + recipe);
        CHECK(inside["cells"] == 60);
        CHECK(inside["pieces"] >= 60);
        CHECK(inside["pieces"] <= 75);
        const auto again = run("--recipe " + recipe);
        CHECK(again["hash"] == inside["hash"]);
        const auto in_box = run(options + " --sites-in-box --save-recipe " + recipe);
        CHECK(in_box["cells"] < 60);
        CHECK(in_box["text"].get<std::string>().find("cells that miss the solid") != std::string::npos);
        // A recipe without a word about it, as those before this option, keeps its sites in the box.
        CHECK_FALSE(nlohmann::json::parse(read_text(recipe))["pattern"].contains("inside"));
        CHECK(run("--recipe " + recipe)["hash"] == in_box["hash"]);
        CHECK(run(recipe)["hash"] == in_box["hash"]);
        CHECK(run("--recipe " + recipe + " --inside")["hash"] == inside["hash"]);
    }
    const auto grid = run("shape:animal -n 60 --pattern grid"), grid_in_box = run("shape:animal -n 60 --pattern grid "
                                                                                  "--sites-in-box");
    CHECK(grid["hash"] == grid_in_box["hash"]);
    CHECK(run_brittle(folder, "fracture shape:cube --inside --sites-in-box -o " + (folder / "a.ply")).exit_code == 2);
}

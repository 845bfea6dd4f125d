// Recipes and the command line: --save-recipe keeps every option that decides what is written. The options are those
// that the parser lists, so that a new one cannot be forgotten here.
#include <doctest/doctest.h>

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "tests/tools/support.h"
#include "tools/brittle/commands/command_line.h"

namespace fs = std::filesystem;
using namespace brittle::tools;
using namespace brittle::tools::test;

namespace {

// Options that belong to one call. A recipe says what is made, whoever makes it, where and with what.
const std::map<std::string, const char*> of_the_call{
    {"--help", "prints the help"},
    {"--recipe", "names the recipe itself"},
    {"--save-recipe", "names the recipe itself"},
    {"--output", "a name of files"},
    {"--export", "a name of files"},
    {"--video", "a name of files"},
    {"--record", "a name of files"},
    {"--ids", "a name of files"},
    {"--graph", "a name of files"},
    {"--report", "a name of files"},
    {"--threads", "the result does not depend on it"},
    {"--classify", "the result does not depend on it"},
    {"--device", "names a part of this machine"},
    {"--format", "of a mesh on standard input, which no recipe can name"},
    {"--output-format", "of a mesh on standard output, as the ending of a file"},
    {"--quiet", "what is told about the call"},
    {"--json", "what is told about the call"},
    {"--validation", "watches the driver of this machine"},
};

// Also of a hidden option, whose get_name() is empty.
std::string name_of(const CLI::Option& option) {
    return option.get_lnames().empty() ? option.get_name() : "--" + option.get_lnames().front();
}

struct Value {
    std::string words;              // the option with its value
    std::string needs{};            // options without which it has no effect
    std::string mesh{"shape:cube"}; // empty: no mesh
};

std::map<std::string, Value> values_of(const std::string& command, const Folder& folder) {
    const std::string sites = "--sites " + folder.write("sites.txt", "0 0 0\n0.5 0.1 0\n0 0.4 0.3\n").string();
    const std::string set = folder / "set.glb";
    REQUIRE(run_brittle(folder, "fracture shape:cube -n 3 -o " + set).exit_code == 0);
    const std::string image = BRITTLE_GOLDEN_FOLDER "/scenes/stone_arch_falls.png";
    REQUIRE(fs::exists(image));
    const std::string to_file = command == "render" ? "--export " + (folder / "out.glb") : "";
    const std::string bodies = to_file + " --rigid-bodies";
    return {
        // mesh and fracture
        {"mesh", {"", "", "shape:torus"}},
        {"--units", {"--units cm"}},
        {"--pieces", {"--pieces 7"}},
        {"--seed", {"--seed 9"}},
        {"--material", {"--material wood"}},
        {"--pattern", {"--pattern radial"}},
        {"--focus", {"--focus 0.1,0.2,0.3"}},
        {"--axis", {"--axis 1,2,3"}},
        {"--jitter", {"--jitter 0.25"}},
        {"--piece-size", {"--piece-size 0.75"}},
        {"--grading", {"--grading 0.5"}},
        {"--cells-per-piece", {"--cells-per-piece 2"}},
        {"--inside", {"--inside", "--pattern grid"}},
        {"--sites-in-box", {"--sites-in-box"}},
        {"--sites", {sites}},
        {"--fit-sites", {"--fit-sites", sites}},
        {"--turn-sites", {"--turn-sites 0,0,30", sites}},
        {"--scale-sites", {"--scale-sites 0.5", sites}},
        {"--move-sites", {"--move-sites 0.1,0,0", sites}},
        {"--strike", {"--strike 0,0,0,0.5"}},
        {"--roughness", {"--roughness 0.25"}},
        {"--rough-size", {"--rough-size 0.25"}},
        {"--grain", {"--grain 0,0,2"}},
        {"--detail", {"--detail 3"}},
        {"--repair", {"--repair"}},
        {"--unite", {"--unite"}},
        {"--algorithm", {"--algorithm sequential"}},
        {"--min-volume", {"--min-volume 0.001"}},
        // files of pieces
        {"--name", {"--name vase", to_file}},
        {"--per-piece", {"--per-piece", to_file}},
        {"--one-file", {"--one-file", to_file}},
        {"--hulls", {"--hulls unreal", to_file}},
        {"--rigid-bodies", {"--rigid-bodies", to_file}},
        {"--hull-parts", {"--hull-parts 3", bodies}},
        {"--density", {"--density 900", bodies}},
        {"--interior-texture", {"--interior-texture " + image, to_file}},
        {"--export-as", {"--export-as made", to_file}},
        // pictures
        {"--pieces-from", {"--pieces-from " + set, "", ""}},
        {"--frames", {"--frames 7"}},
        {"--every", {"--every 3"}},
        {"--size", {"--size 1280x720"}}, // the default, which a recipe that names it keeps if the default changes
        {"--quality", {"--quality fast"}},
        {"--whole", {"--whole"}},
        {"--planes", {"--planes 2"}},
        {"--explode", {"--explode 0.5"}},
        {"--dust", {"--dust 0.5"}},
        {"--show-sites", {"--show-sites"}},
        {"--show-hulls", {"--show-hulls"}},
        {"--show-cells", {"--show-cells"}},
        {"--colors", {"--colors materials"}},
        {"--smooth", {"--smooth"}},
        {"--wireframe", {"--wireframe"}},
        {"--azimuth", {"--azimuth 10"}},
        {"--elevation", {"--elevation 10"}},
        {"--distance", {"--distance 2"}},
        // physics
        {"--physics", {"--physics bullet"}},
        {"--bonded", {"--bonded"}},
        {"--anchored", {"--anchored"}},
        {"--anchor", {"--anchor 0,0,0,0.5"}},
        {"--shot", {"--shot 0,0.8,4,0,1,-30,0.15,0.5"}},
        {"--strength", {"--strength 0.5"}},
        {"--breakable", {"--breakable"}},
        {"--min-size", {"--min-size 0.1"}},
        {"--blow-pieces", {"--blow-pieces 12"}},
        {"--piece-limit", {"--piece-limit 70"}},
        {"--air-density", {"--air-density 0"}},
        {"--max-colliding", {"--max-colliding 70"}},
        {"--most-colliding", {"--most-colliding 70"}},
        {"--height", {"--height 2"}},
    };
}

// Runs a command up to its recipe. `render` writes it before it looks for a device, and here it finds none.
nlohmann::json saved_recipe(const Folder& folder, const std::string& command, const std::string& words) {
    const std::string recipe = folder / "saved.json";
    fs::remove(recipe);
    const bool renders = command == "render";
    const Outcome outcome = run_brittle(
        folder, command + " " + words + " --save-recipe " + recipe + (renders ? "" : " -o " + (folder / "out.glb")),
        renders ? "env -u VK_ICD_FILENAMES VK_DRIVER_FILES=/nowhere.json" : "");
    CAPTURE(words);
    CAPTURE(outcome.output);
    CHECK(outcome.exit_code == (renders ? 6 : 0));
    REQUIRE(fs::exists(recipe));
    return nlohmann::json::parse(read_text(recipe));
}

void check_every_option(const std::string& command) {
    const Folder folder;
    CLI::App app;
    Run run;
    add_fracture(app, run);
    add_render(app, run);
    const std::map<std::string, Value> values = values_of(command, folder);
    std::map<std::string, nlohmann::json> without; // recipes by what an option needs
    size_t walked = 0;
    for (const CLI::Option* option : app.get_subcommand(command)->get_options()) {
        const std::string name = name_of(*option);
        CAPTURE(name);
        if (of_the_call.contains(name)) continue;
        const auto value = values.find(name);
        if (value == values.end()) {
            FAIL_CHECK("a new option: give it a value in values_of(), or a reason in of_the_call");
            continue;
        }
        const auto& [words, needs, mesh] = value->second;
        const std::string plain = "shape:cube " + needs;
        if (!without.contains(plain)) without[plain] = saved_recipe(folder, command, plain);
        const nlohmann::json with = saved_recipe(folder, command, mesh + " " + needs + " " + words);
        CHECK(with != without[plain]);
        const fs::path recipe = folder.path / "recipe.json";
        fs::rename(folder.path / "saved.json", recipe);
        CHECK(saved_recipe(folder, command, "--recipe " + recipe.string()) == with);
        ++walked;
    }
    CHECK(walked > (command == "render" ? 50u : 30u));
}

} // namespace

TEST_CASE("a recipe keeps every option of fracture that decides what is written") {
    check_every_option("fracture");
}

TEST_CASE("a recipe keeps every option of render that decides what is written") {
    check_every_option("render");
}

TEST_CASE("options that belong to one call are options") {
    CLI::App app;
    Run run;
    add_fracture(app, run);
    add_render(app, run);
    std::set<std::string> names;
    for (const char* command : {"fracture", "render"})
        for (const CLI::Option* option : app.get_subcommand(command)->get_options()) names.insert(name_of(*option));
    for (const auto& entry : of_the_call) {
        CAPTURE(entry.first);
        CHECK(names.contains(entry.first));
    }
}

TEST_CASE("a recipe with the contents of files gives the same files, and fits other formats and commands") {
    const Folder folder;
    const std::string recipe = folder / "recipe.json", once = folder / "once.glb", again = folder / "again.glb";
    const Outcome made = run_brittle(folder, "fracture shape:torus -n 5 --hulls unreal --rigid-bodies --density 900 "
                                             "--hull-parts 3 --name vase --save-recipe "
                                                 + recipe + " -o " + once);
    REQUIRE_MESSAGE(made.exit_code == 0, made.output);
    for (const char* word : {"KHR_physics_rigid_bodies", "UCX_vase_000_00", "\"vase_004\""})
        CHECK(read_text(once).find(word) != std::string::npos);
    const Outcome repeated = run_brittle(folder, "fracture " + recipe + " -o " + again);
    CHECK(repeated.exit_code == 0);
    CHECK(read_text(once) == read_text(again));

    const Outcome other = run_brittle(folder, "fracture " + recipe + " -o " + (folder / "out.ply"));
    INFO(other.output);
    CHECK(other.exit_code == 0);
    CHECK(other.has("the recipe's --hulls has no effect"));
    CHECK(other.has("the recipe's --name has no effect"));
    const Outcome given = run_brittle(folder, "fracture " + recipe + " --hulls unreal -o " + (folder / "no.ply"));
    CHECK(given.exit_code == 2);
    CHECK(given.has("--hulls: "));
    CHECK_FALSE(fs::exists(folder / "no.ply"));

    // Without --export there is nothing to tell; and what does not fit stays in the recipe.
    const auto kept = saved_recipe(folder, "render", recipe);
    CHECK(kept["export"] == nlohmann::json::parse(read_text(recipe))["export"]);
    const auto overridden = saved_recipe(folder, "fracture", recipe + " --density 700 --name jug");
    CHECK(overridden["export"]["density"] == 700);
    CHECK(overridden["export"]["name"] == "jug");
    CHECK(overridden["export"]["hull_parts"] == 3);
}

TEST_CASE("--one-file and --per-piece override each other's setting in a recipe") {
    const Folder folder;
    for (const bool per_piece : {true, false}) {
        const std::string recipe =
            folder
                .write("recipe.json", R"({"brittle": 1, "mesh": "shape:cube", "pattern": {"count": 3},
                "export": {"per_piece": )" + std::string(per_piece ? "true" : "false")
                                          + "}}")
                .string();
        const std::string words = recipe + (per_piece ? " --one-file" : " --per-piece");
        const std::string file = folder / (per_piece ? "one.stl" : "each.stl");
        const Outcome made = run_brittle(folder, "fracture " + words + " -o " + file);
        CHECK_MESSAGE(made.exit_code == 0, made.output);
        CHECK(fs::exists(file) == per_piece);
        CHECK(fs::exists(folder / "one_000.stl") == false);
        CHECK(fs::exists(folder / "each_002.stl") == !per_piece);
        for (const std::string command : {"fracture", "render"}) {
            CAPTURE(command);
            const std::string to_file = command == "render" ? " --export " + (folder / "out.glb") : "";
            CHECK(saved_recipe(folder, command, words + to_file)["export"]["per_piece"] == !per_piece);
        }
    }
    const Outcome rendered = run_brittle(
        folder, "render "
                    + folder
                          .write("run.json", R"({"brittle": 1, "mesh": "shape:cube", "pattern": {"count": 3},
            "export": {"per_piece": true}})")
                          .string()
                    + " --frames 1 --size 64x48 --one-file --export " + (folder / "rubble.glb"));
    if (rendered.exit_code == 6) return; // no Vulkan device
    CHECK_MESSAGE(rendered.exit_code == 0, rendered.output);
    CHECK(fs::exists(folder / "rubble.glb"));
    CHECK_FALSE(fs::exists(folder / "rubble_000.glb"));
}

TEST_CASE("the name of pieces is checked") {
    const Folder folder;
    const std::string out = " -o " + (folder / "a.glb");
    for (const std::string& name :
         {std::string("''"), std::string("'a\tb'"), std::string("\"$(printf 'm\\351sh')\""), std::string(201, 'x')}) {
        const Outcome outcome = run_brittle(folder, "fracture shape:cube -n 2 --name " + name + out);
        INFO(name, ": ", outcome.output);
        CHECK(outcome.exit_code == 2);
        CHECK(outcome.has("--name"));
    }
    CHECK(folder.files() == 0);
}

// The program from the user's point of view: exit codes, messages, files. Runs the real binary.
#include <doctest/doctest.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <sys/stat.h>

#include "tests/tools/support.h"

namespace fs = std::filesystem;
using namespace brittle::tools::test;

TEST_CASE("a missing or unknown command and bad options are usage errors that name the alternatives") {
    const Folder folder;
    const Outcome nothing = run_brittle(folder, ""), unknown = run_brittle(folder, "shatter x.obj");
    for (const Outcome& outcome : {nothing, unknown}) {
        CHECK(outcome.exit_code == 2);
        for (const char* command : {"fracture", "render", "demo", "replay"}) CHECK(outcome.has(command));
    }
    CHECK(unknown.has("'shatter'"));
    CHECK(run_brittle(folder, "fracture").exit_code == 2);
    CHECK(run_brittle(folder, "fracture shape:cube").exit_code == 2); // no --output
    const Outcome zero = run_brittle(folder, "fracture shape:cube -n 0 -o " + folder / "a.glb");
    CHECK(zero.exit_code == 2);
    CHECK(zero.has("--pieces"));
    CHECK(run_brittle(folder, "fracture shape:cube -n 5 --sites s.txt -o " + folder / "a.glb").exit_code == 2);
    CHECK(run_brittle(folder, "fracture shape:cube --algorithm magic -o " + folder / "a.glb").exit_code == 2);
    const Outcome size = run_brittle(folder, "render shape:cube --size 12 -o " + folder / "a.png");
    CHECK(size.exit_code == 2);
    CHECK(size.has("1280x720"));
    CHECK(folder.files() == 0);
}

TEST_CASE("a word that is nearly a command or an option is corrected, and help lists the options of a command") {
    const Folder folder;
    const auto refused = [&](const char* words, const char* message) {
        const Outcome outcome = run_brittle(folder, words);
        INFO(outcome.output);
        CHECK(outcome.exit_code == 2);
        CHECK(outcome.has(message));
    };
    refused("fractur shape:cube", "did you mean fracture?");
    refused("fracture shape:cube --stes 4", "fracture has no option '--stes'; did you mean --sites?");
    refused("render shape:cube --sead=3", "did you mean --seed?");
    refused("fracture shape:cube --frobnicate", "brittle help fracture lists them");
    refused("help fractur", "did you mean fracture?");
    refused("fracture --", "--output is required"); // a mesh may be named anything behind --
    const Outcome help = run_brittle(folder, "help fracture"), option = run_brittle(folder, "fracture --help");
    CHECK(help.exit_code == 0);
    CHECK(help.has("--sites"));
    CHECK(help.output == option.output);
    CHECK(run_brittle(folder, "help").output == run_brittle(folder, "--help").output);
    CHECK(run_brittle(folder, "-V").output == run_brittle(folder, "--version").output);
}

TEST_CASE("--physics chooses the engine, overrides the recipe's and is saved in one") {
    const Folder folder;
    const std::string plain = "render shape:cube -n 2 --frames 3 --size 64x48 -o " + (folder / "a.png");
    const std::string recipe = folder / "recipe.json";
    const Outcome bullet = run_brittle(folder, plain + " --physics bullet --save-recipe " + recipe);
    INFO(bullet.output);
    if (no_vulkan(bullet)) return;
    CHECK(bullet.exit_code == 0);
    CHECK(nlohmann::json::parse(read_text(recipe))["world"]["physics"] == "bullet");
    CHECK(run_brittle(folder, "render --recipe " + recipe + " --physics solver --frames 3 --size 64x48 -o "
                                  + (folder / "b.png") + " --save-recipe " + (folder / "other.json"))
              .exit_code
          == 0);
    CHECK_FALSE(nlohmann::json::parse(read_text(folder / "other.json")).contains("world"));
}

TEST_CASE("--physics refuses another word and names the choices, in render and demo") {
    const Folder folder;
    for (const std::string command : {"render", "demo"}) {
        const Outcome outcome = run_brittle(folder, command + " shape:cube --physics magic");
        INFO(outcome.output);
        CHECK(outcome.exit_code == 2);
        for (const char* word : {"--physics", "solver", "bullet", "magic"}) CHECK(outcome.has(word));
        CHECK(run_brittle(folder, command + " --help").has("--physics"));
    }
}

TEST_CASE("--most-colliding is a hidden alias of --max-colliding") {
    const Folder folder;
    CHECK_FALSE(run_brittle(folder, "render --help").has("--most-colliding"));
    for (const char* option : {"--max-colliding", "--most-colliding"}) {
        const std::string plain = "render shape:cube -n 2 --frames 0 --size 64x48 -o " + (folder / "a.png");
        const std::string recipe = folder / "recipe.json";
        const Outcome outcome = run_brittle(folder, plain + " --save-recipe " + recipe + " " + option + " 70");
        INFO(outcome.output);
        if (no_vulkan(outcome)) return;
        CHECK(outcome.exit_code == 0);
        CHECK(nlohmann::json::parse(read_text(recipe))["world"]["max_colliding"] == 70);
    }
    CHECK(run_brittle(folder, "render shape:cube --max-colliding 1 --most-colliding 1").exit_code == 2);
}

TEST_CASE("help and version succeed and name every command and exit code") {
    const Folder folder;
    const Outcome help = run_brittle(folder, "--help");
    CHECK(help.exit_code == 0);
    for (const char* word : {"fracture", "render", "demo", "profile", "Exit codes"}) CHECK(help.has(word));
    for (const char* command : {"fracture", "render", "demo", "profile"}) {
        const Outcome outcome = run_brittle(folder, std::string(command) + " --help");
        CHECK(outcome.exit_code == 0);
        CHECK(outcome.has("shape:torus"));
    }
    const Outcome version = run_brittle(folder, "--version");
    CHECK(version.exit_code == 0);
    CHECK(version.has("brittle 0."));
}

TEST_CASE("missing, empty, truncated and foreign files are input errors that name the file") {
    const Folder folder;
    const auto refused = [&](const std::string& name) {
        const std::string file = folder / name;
        const Outcome outcome = run_brittle(folder, "fracture " + file + " -o " + folder / "out.glb");
        INFO(name, ": ", outcome.output);
        CHECK(outcome.exit_code == 3);
        CHECK(outcome.has(name));
        CHECK_FALSE(fs::exists(folder / "out.glb"));
    };
    refused("missing.obj");
    write_text(folder / "empty.stl", "");
    refused("empty.stl");
    write_text(folder / "mesh.xyz", "1 2 3");
    refused("mesh.xyz");
    write_text(folder / "truncated.glb", std::string("glTF\x02\0\0\0\xff\0\0\0", 12));
    refused("truncated.glb");
    std::string stl(84, '\0');
    stl[80] = 100; // 100 triangles, none present
    write_text(folder / "truncated.stl", stl);
    refused("truncated.stl");
    const Outcome shape = run_brittle(folder, "fracture shape:dragon -o " + folder / "out.glb");
    CHECK(shape.exit_code == 3);
    CHECK(shape.has("torus"));
}

TEST_CASE("a bad line in a file of sites is named") {
    const Folder folder;
    write_text(folder / "sites.txt", "# two sites\n0 0 0\n1 2\n");
    const Outcome outcome =
        run_brittle(folder, "fracture shape:cube --sites " + folder / "sites.txt" + " -o " + folder / "out.glb");
    INFO(outcome.output);
    CHECK(outcome.exit_code == 3);
    CHECK(outcome.has("sites.txt:3"));
}

TEST_CASE("fracture writes pieces and a report that agree, whatever the number of threads") {
    const Folder folder;
    std::string hash;
    for (const char* threads : {"1", "4"}) {
        const Outcome outcome =
            run_brittle(folder, "fracture shape:torus -n 12 --seed 3 --threads " + std::string(threads) + " -o "
                                    + folder / "out.glb" + " --report " + folder / "r.json");
        INFO(outcome.output);
        REQUIRE(outcome.exit_code == 0);
        const auto report = nlohmann::json::parse(read_text(folder / "r.json"));
        for (const char* key : {"pieces", "islands", "closed", "volume_input", "volume_sum", "volume_error",
                                "triangles_in", "triangles_out", "cap_triangles", "milliseconds", "hash"}) {
            CHECK(report.contains(key));
        }
        CHECK(report["closed"] == true);
        CHECK(report["volume_error"].get<double>() < 1e-9);
        CHECK(report["pieces"].get<int>() >= report["cells"].get<int>());
        CHECK(outcome.has(report["hash"].get<std::string>()));
        if (!hash.empty()) CHECK(hash == report["hash"].get<std::string>());
        hash = report["hash"].get<std::string>();
        CHECK(read_text(folder / "out.glb").starts_with("glTF"));
    }
    CHECK(folder.files() == 2);
}

TEST_CASE("an output that cannot be written is an error and leaves the old file") {
    const Folder folder;
    const Outcome missing = run_brittle(folder, "fracture shape:cube -n 3 -o " + folder / "no/such/out.glb");
    INFO(missing.output);
    CHECK(missing.exit_code == 5);
    CHECK(missing.has("no/such"));
    fs::create_directory(folder / "taken.glb");
    CHECK(run_brittle(folder, "fracture shape:cube -n 3 -o " + folder / "taken.glb").exit_code == 5);
    CHECK(folder.files() == 1);
}

TEST_CASE("the demo without a display reports that and names the command that needs none") {
    const Folder folder;
    const Outcome outcome = run_brittle(folder, "demo shape:cube", "env -u DISPLAY -u WAYLAND_DISPLAY");
    INFO(outcome.output);
    CHECK(outcome.exit_code == 6);
    CHECK(outcome.has("brittle render"));
}

TEST_CASE("an unknown device is refused with the list of devices") {
    const Folder folder;
    const Outcome outcome =
        run_brittle(folder, "render shape:cube --whole --device no-such-device -o " + folder / "a.png");
    INFO(outcome.output);
    CHECK(outcome.exit_code == 6);
    CHECK((outcome.has("The devices are:") || outcome.has("apt install")));
}

TEST_CASE("without a driver, or with a damaged one, commands that draw report that and the others work") {
    const Folder folder;
    write_text(folder / "garbage.json", "{ not a driver");
    write_text(folder / "empty.json", "");
    write_text(folder / "no_library.json", R"({"file_format_version": "1.0.0",
        "ICD": {"library_path": "/nowhere/libnone.so", "api_version": "1.3.0"}})");
    write_text(folder / "other.json", R"({"file_format_version": "1.0.0",
        "ICD": {"library_path": "libc.so.6", "api_version": "1.3.0"}})");
    for (const char* name : {"missing.json", "garbage.json", "empty.json", "no_library.json", "other.json"})
        for (const std::string variable : {"VK_DRIVER_FILES", "VK_ICD_FILENAMES"}) {
            const std::string environment =
                "env -u VK_DRIVER_FILES -u VK_ICD_FILENAMES " + variable + "=" + (folder / name);
            for (const std::string& command : {"render shape:cube --whole -o " + (folder / "a.png"),
                                               "inspect shape:cube --picture " + (folder / "a.png"),
                                               std::string("profile shape:cube -n 3 --repeats 1 --frames 2")}) {
                const Outcome outcome = run_brittle(folder, command, environment);
                INFO(variable, " ", name, ": ", outcome.output);
                CHECK(outcome.exit_code == 6);
                CHECK(outcome.has("no Vulkan driver was found"));
                CHECK(outcome.has("mesa-vulkan-drivers"));
                CHECK(outcome.has(variable + "=" + (folder / name)));
            }
            CHECK(run_brittle(folder, "fracture shape:cube -n 3 -o " + (folder / "a.glb"), environment).exit_code == 0);
        }
    CHECK_FALSE(fs::exists(folder / "a.png"));
}

TEST_CASE("failures of a device are reported with an exit code and leave no half-written file") {
    const Folder folder;
    const std::string picture = folder / "f_%02d.png";
    const auto render = [&](const std::string& faults) {
        return run_brittle(folder,
                           "render shape:cube -n 5 --size 64x48 --frames 6 --every 1 --validation -o " + picture,
                           "BRITTLE_FAULTS=" + faults);
    };
    if (no_vulkan(render(""))) return;
    for (const char* i : {"0", "1", "2", "3", "4", "5", "6"}) fs::remove(folder / ("f_0" + std::string(i) + ".png"));
    const struct {
        const char* faults;
        int exit_code;
        const char* said;
    } cases[] = {{"submit:-4:1", 6, "the device was lost"},
                 {"wait:2:1", 6, "the device hangs"},
                 {"create_device:-3:1", 1, "cannot start the Vulkan device"},
                 {"hide:dynamicRendering", 6, "it lacks the feature dynamicRendering"},
                 {"hide:VK_LAYER_KHRONOS_validation", 6, "vulkan-validationlayers"},
                 {"allocate:-2:1", 1, "bytes of device memory: out of device memory"},
                 {"map:-1:1", 1, "out of host memory"},
                 {"nonsense", 2, "nonsense"}};
    for (const auto& [case_faults, exit_code, said] : cases) {
        const auto faults = case_faults; // clang 14 captures no structured binding
        const Outcome outcome = render(faults);
        INFO(faults, ": ", outcome.output);
        CHECK(outcome.exit_code == exit_code);
        CHECK(outcome.has(said));
        CHECK_FALSE(outcome.has("vulkan validation:"));
        CHECK(folder.files() == 0);
    }
    // A device lost halfway: existing pictures are complete.
    const Outcome lost = render("submit:-4:8");
    INFO(lost.output);
    CHECK(lost.exit_code == 6);
    CHECK_FALSE(lost.has("vulkan validation:"));
    CHECK(folder.files() > 0);
    CHECK(folder.files() < 7);
    for (size_t i = 0; i < folder.files(); ++i)
        CHECK(read_text(folder / ("f_0" + std::to_string(i) + ".png")).ends_with("IEND\xae\x42\x60\x82"));
}

TEST_CASE("render names the anchor that touches nothing, and no other") {
    const Folder folder;
    const std::string render = "render shape:pane --material glass --frames 0 --size 64x48 -o " + (folder / "a.png");
    const Outcome one = run_brittle(folder, render + " --anchor 0,0,0,0.2 --anchor 7,0,0,0.2");
    INFO(one.output);
    CHECK(one.has("anchor at (7, 0, 0), radius 0.2, touches no part of the mesh"));
    CHECK_FALSE(one.has("anchor at (0"));
}

TEST_CASE("render writes a picture at every interval of --every") {
    const Folder folder;
    const Outcome outcome = run_brittle(
        folder, "render shape:cube -n 5 --size 64x48 --frames 6 --every 3 --validation -o " + folder / "f_%02d.png");
    INFO(outcome.output);
    if (no_vulkan(outcome)) return;
    CHECK(outcome.exit_code == 0);
    CHECK(fs::exists(folder / "f_00.png"));
    CHECK(fs::exists(folder / "f_03.png"));
    CHECK(fs::exists(folder / "f_06.png"));
    CHECK(folder.files() == 3);
    CHECK(read_text(folder / "f_00.png") != read_text(folder / "f_06.png"));
}

TEST_CASE("a name without a number gives one picture, of the last frame") {
    const Folder folder;
    const std::string render = "render shape:cube -n 5 --size 64x48 --frames 6 --every 3 -o ";
    const Outcome outcome = run_brittle(folder, render + (folder / "one.png"));
    if (no_vulkan(outcome)) return;
    CHECK(outcome.exit_code == 0);
    CHECK(folder.files() == 1);
    CHECK(run_brittle(folder, render + (folder / "f_%02d.png")).exit_code == 0);
    CHECK(read_text(folder / "one.png") == read_text(folder / "f_06.png"));
    CHECK(run_brittle(folder, "render shape:cube -o " + (folder / "bad_%s.png")).exit_code == 2);
}

TEST_CASE("a signal ends a long command, wherever it is, and leaves no half-written file") {
    const Folder folder;
    // The work would take minutes, or wait for ever. The program must get the signal once and alone: a second one ends
    // it at once. A third after five seconds kills a program that ignores the first. run_brittle() cannot be used,
    // because its own time limit would pass the signal on, and the signal must not go to the whole process group.
    const std::string log = folder / "output", pipe = folder / "pipe";
    REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
    const std::vector<std::string> works{
        "INT:fracture shape:animal -n 3000 --algorithm sequential", "INT:fracture shape:animal -n 1000000",
        "TERM:fracture shape:cube --sites " + pipe, "TERM:render shape:cube --size 64x48 --sites " + pipe};
    for (const std::string& work : works) {
        CAPTURE(work);
        const size_t colon = work.find(':');
        const std::string output = folder / (work.substr(colon + 1, 1) == "f" ? "out.glb" : "out.png");
        const int status =
            std::system(("/usr/bin/timeout --foreground --preserve-status -k 5 -s " + work.substr(0, colon)
                         + " 1 " BRITTLE_PROGRAM " " + work.substr(colon + 1) + " -o " + output + " > " + log + " 2>&1")
                            .c_str());
        CHECK(WEXITSTATUS(status) == 130);
        const std::string text = read_text(log);
        CHECK((text.find("cancelled") != std::string::npos || text.find("interrupted") != std::string::npos));
        std::filesystem::remove(log);
        CHECK(folder.files() == 1); // the pipe
    }
}

TEST_CASE("a minimum volume gives fewer pieces, and none below it") {
    const Folder folder;
    const auto pieces = [&](const std::string& options) {
        const std::string report = folder / "report.json";
        const Outcome outcome = run_brittle(folder, "fracture shape:icosphere -n 100 " + options + " -o "
                                                        + (folder / "out.glb") + " --report " + report);
        REQUIRE_MESSAGE(outcome.exit_code == 0, outcome.output);
        return nlohmann::json::parse(read_text(report));
    };
    const auto all = pieces(""), merged = pieces("--min-volume 0.05");
    CHECK(merged["pieces"].get<int>() < all["pieces"].get<int>());
    CHECK(merged["smallest_piece"].get<double>() >= 0.05);
    CHECK(run_brittle(folder, "fracture shape:cube --min-volume -1 -o " + (folder / "x.glb")).exit_code == 2);
}

TEST_CASE("--roughness bends the cuts, 0 gives the flat ones, and a recipe repeats them") {
    const Folder folder;
    const std::string report = folder / "report.json", recipe = folder / "recipe.json";
    const auto run = [&](const std::string& options) {
        const Outcome outcome =
            run_brittle(folder, "fracture " + options + " -o " + (folder / "out.glb") + " --report " + report);
        REQUIRE_MESSAGE(outcome.exit_code == 0, outcome.output);
        auto json = nlohmann::json::parse(read_text(report));
        json["text"] = outcome.output;
        return json;
    };
    const auto says = [](const nlohmann::json& json, const char* words) {
        return json["text"].get<std::string>().find(words) != std::string::npos;
    };
    const std::string cube = "shape:cube -n 12 ";
    const auto flat = run(cube), zero = run(cube + "--roughness 0 --rough-size 0.1 --grain 0,4,0 --detail 5");
    CHECK(zero["hash"] == flat["hash"]);
    CHECK_FALSE(says(flat, "roughness"));
    CHECK(flat["roughness"] == 0);
    const auto rough = run(cube + "--roughness 1 --save-recipe " + recipe);
    CHECK(rough["closed"] == true);
    CHECK(rough["pieces"] == 12);
    CHECK(rough["hash"] != flat["hash"]);
    CHECK(rough["roughness"] == 1);
    CHECK(rough["cap_triangles"].get<int>() > 5 * flat["cap_triangles"].get<int>());
    CHECK(says(rough, "roughness  1, detail 1"));
    CHECK(run("--recipe " + recipe)["hash"] == rough["hash"]);
    CHECK(run("--recipe " + recipe + " --roughness 0")["hash"] == flat["hash"]);
    for (const char* other : {"--detail 2", "--grain 0,4,0", "--rough-size 0.2", "--seed 2"})
        CHECK(run(cube + "--roughness 1 " + other)["hash"] != rough["hash"]);

    // Every value goes from the command line into a recipe and back.
    const auto all =
        run(cube + "--roughness 0.5 --rough-size 0.3 --grain 0,0,-2 --detail 3 --seed 9 --save-recipe " + recipe);
    const auto saved = nlohmann::json::parse(read_text(recipe));
    CHECK(saved["roughness"] == 0.5);
    CHECK(saved["rough_size"] == 0.3);
    CHECK(saved["grain"] == std::vector<double>{0, 0, -2});
    CHECK(saved["detail"] == 3);
    const auto again = run(recipe);
    CHECK(again["hash"] == all["hash"]);
    CHECK(again["recipe"] == all["recipe"]);
}

TEST_CASE("--material brings its roughness, which options override and the sequential algorithm leaves out") {
    const Folder folder;
    const auto run = [&](const std::string& options) {
        const std::string report = folder / "report.json";
        const Outcome outcome = run_brittle(folder, "fracture shape:cube -n 8 --material wood " + options + " -o "
                                                        + (folder / "out.glb") + " --report " + report);
        REQUIRE_MESSAGE(outcome.exit_code == 0, outcome.output);
        return nlohmann::json::parse(read_text(report));
    };
    const auto wood = run(""), flat = run("--roughness 0");
    CHECK(wood["roughness"] > 0);
    CHECK(wood["hash"] != flat["hash"]);
    CHECK(run("--detail 1 --grain 0,0,0")["hash"] != wood["hash"]);
    CHECK(run("--axis 1,0,0 --grain 4,0,0")["hash"] == run("--axis 1,0,0")["hash"]);
    CHECK(run("--algorithm sequential")["roughness"] == 0);
    const Outcome refused =
        run_brittle(folder, "fracture shape:cube --algorithm sequential --roughness 1 -o " + (folder / "x.glb"));
    CHECK(refused.exit_code != 0);
    CHECK(refused.has("roughness needs the exact algorithm"));
}

TEST_CASE("pieces are written in every format, with materials, hulls and one file per piece") {
    const Folder folder;
    const std::string crate = BRITTLE_CORPUS "/meshes/crate.glb";
    for (const std::string ending : {"glb", "obj", "ply", "stl"}) {
        const Outcome whole =
            run_brittle(folder, "fracture " + crate + " -n 6 --one-file -o " + (folder / ("a." + ending)));
        CHECK(whole.exit_code == 0);
        const Outcome again = run_brittle(folder, "inspect " + (folder / ("a." + ending)));
        CHECK(again.output.find("components") != std::string::npos);
    }
    CHECK(fs::exists(folder / "a.mtl"));
    CHECK(fs::exists(folder / "a_image0.png"));
    const Outcome each =
        run_brittle(folder, "fracture " + crate + " -n 6 --per-piece --hulls unreal --rigid-bodies --material glass -o "
                                + (folder / "b.glb"));
    CHECK(each.exit_code == 0);
    CHECK(read_text(folder / "b_003.glb").find("UCX_crate_003_00") != std::string::npos);
    CHECK(read_text(folder / "b_003.glb").find("KHR_physics_rigid_bodies") != std::string::npos);
    struct Refusal {
        const char *options, *file, *words;
    };
    for (const Refusal& refusal : {Refusal{"--hulls godot", "c.ply", "--hulls: "},
                                   {"--rigid-bodies", "c.stl", "cannot hold bodies"},
                                   {"--density 800", "c.glb", "add --rigid-bodies"},
                                   {"--hull-parts 4", "c.glb", "there are no hulls"},
                                   {"--hull-parts 4 --hulls godot", "c.glb", "Godot makes the shapes"},
                                   {"--interior-texture none.png", "c.ply", "cannot hold images"}}) {
        CAPTURE(refusal.options);
        const std::string file = folder / refusal.file;
        const Outcome refused = run_brittle(folder, "fracture " + crate + " -n 2 " + refusal.options + " -o " + file);
        CHECK(refused.exit_code == 2);
        CHECK(refused.has(refusal.words));
        CHECK_FALSE(fs::exists(file));
    }
    const Outcome both =
        run_brittle(folder, "fracture " + crate + " -n 2 --per-piece --one-file -o " + (folder / "c.stl"));
    CHECK(both.exit_code == 2);
    CHECK(both.has("--per-piece excludes --one-file"));
    CHECK(
        run_brittle(folder, "render " + crate + " -n 2 --one-file -o " + (folder / "c.png")).has("--one-file: there"));
    const Outcome no_file = run_brittle(folder, "render " + crate + " -n 2 --hulls godot -o " + (folder / "c.png"));
    CHECK(no_file.exit_code == 2);
    CHECK(no_file.has("give --export FILE"));
    const Outcome bad = run_brittle(folder, "fracture " + crate + " -n 2 -o " + (folder / "a.fbx"));
    CHECK(bad.exit_code == 2);
    CHECK(bad.output.find(".glb, .obj, .ply, .stl") != std::string::npos);
}

TEST_CASE("STL has a file for each piece, unless one file is asked for") {
    const Folder folder;
    const auto fracture = [&](const std::string& options) {
        const Outcome outcome = run_brittle(folder, "fracture shape:cube -n 5 " + options);
        CHECK(outcome.exit_code == 0);
        return outcome;
    };
    const auto triangles = [&](const std::string& file) { return (fs::file_size(file) - 84) / 50; };
    const Outcome split = fracture("-o " + (folder / "a.stl"));
    CHECK(split.has("a.stl: STL does not tell pieces apart"));
    CHECK(split.has("--one-file"));
    CHECK(split.has("a_004.stl"));
    CHECK_FALSE(fs::exists(folder / "a.stl"));
    CHECK_FALSE(fs::exists(folder / "a_005.stl"));
    const Outcome joined = fracture("--one-file -o " + (folder / "b.stl"));
    CHECK_FALSE(joined.has("STL does not"));
    CHECK_FALSE(fs::exists(folder / "b_000.stl"));
    uintmax_t sum = 0;
    for (int piece = 0; piece < 5; ++piece) {
        const std::string file = folder / ("a_00" + std::to_string(piece) + ".stl");
        REQUIRE(fs::exists(file));
        CHECK(run_brittle(folder, "inspect " + file).exit_code == 0); // closed
        sum += triangles(file);
    }
    CHECK(triangles(folder / "b.stl") == sum);
    CHECK_FALSE(fracture("--per-piece -o " + (folder / "c.stl")).has("STL does not")); // it was asked for
    CHECK_FALSE(fracture("-o " + (folder / "d.ply")).has("does not tell pieces apart"));
    CHECK(fs::exists(folder / "d.ply"));
    const Outcome single = run_brittle(folder, "fracture shape:cube -n 1 -o " + (folder / "e.stl"));
    CHECK_FALSE(single.has("STL does not"));
    CHECK(fs::exists(folder / "e.stl"));
}

TEST_CASE("sites of a file are fitted, turned, scaled and moved") {
    const Folder folder;
    write_text(folder / "sites.txt", "0 0 0\n10 0 0\n");
    const auto pieces = [&](const std::string& options) {
        const Outcome outcome =
            run_brittle(folder, "fracture shape:cube --sites " + (folder / "sites.txt") + " --report "
                                    + (folder / "r.json") + " -o " + (folder / "a.glb") + options);
        CHECK(outcome.exit_code == 0);
        return nlohmann::json::parse(read_text(folder / "r.json"))["pieces"].get<int>();
    };
    CHECK(pieces("") == 1); // the plane is at x = 5
    CHECK(pieces(" --fit-sites") == 2);
    CHECK(pieces(" --move-sites -5,0,0") == 2);
    CHECK(pieces(" --fit-sites --scale-sites 0.5 --turn-sites 0,0,90 --move-sites 0,0.9,0") == 2);
    CHECK(pieces(" --fit-sites --turn-sites 0,0,90 --move-sites 0,1.1,0") == 1);
}

TEST_CASE("the pieces are the same with every --classify, and auto reports the processor") {
    const Folder folder;
    const auto hash = [&](const std::string& where) {
        const Outcome outcome = run_brittle(folder, "fracture shape:torus -n 40 --classify " + where + " --report "
                                                        + (folder / "r.json") + " -o " + (folder / "a.glb"));
        CHECK(outcome.exit_code == 0);
        CHECK(outcome.has("classification on the") == (where != "cpu"));
        if (where == "auto") CHECK(outcome.has("the fracture takes"));
        return nlohmann::json::parse(read_text(folder / "r.json"))["hash"].get<std::string>();
    };
    const std::string on_cpu = hash("cpu");
    CHECK(hash("gpu") == on_cpu);
    CHECK(hash("auto") == on_cpu);
}

TEST_CASE("--pieces-from renders, records and repeats the pieces of a file, and takes no mesh beside it") {
    const Folder folder;
    const std::string set = folder / "set.glb";
    REQUIRE(run_brittle(folder, "fracture shape:cube -n 12 -o " + set).exit_code == 0);
    const std::string plain = "render --pieces-from " + set + " --size 64x48 ";
    const Outcome both = run_brittle(folder, plain + "shape:cube -o " + folder / "a.png");
    CHECK(both.exit_code == 2);
    CHECK(both.has("--pieces-from"));
    const Outcome repaired = run_brittle(folder, plain + "--repair -o " + folder / "a.png");
    CHECK(repaired.exit_code == 2);
    CHECK(repaired.has("--repair"));
    CHECK(folder.files() == 1);
    const std::string log = folder / "run.log", recipe = folder / "recipe.json";
    const Outcome drawn = run_brittle(folder, plain + "--material stone --frames 30 --record " + log + " --save-recipe "
                                                  + recipe + " -o " + folder / "a.png");
    if (no_vulkan(drawn)) return;
    CHECK(drawn.exit_code == 0);
    CHECK(drawn.has("1 objects"));
    CHECK_FALSE(drawn.has("stays whole"));
    CHECK(run_brittle(folder, "replay " + log).exit_code == 0);
    CHECK(read_text(recipe).find("\"in_pieces\": true") != std::string::npos);
    CHECK(run_brittle(folder, "render " + recipe + " --size 64x48 --frames 1 -o " + folder / "b.png").exit_code == 0);
}

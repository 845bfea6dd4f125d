// Meshes on standard input and output, --quiet and --json. Runs the real binary, with both streams apart.
#include <doctest/doctest.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/tools/support.h"
#include "tools/brittle/stage/standard_streams.h"
#include "tools/scenario/base/failure.h"

namespace fs = std::filesystem;
using namespace brittle::tools;
using namespace brittle::tools::test;

namespace {

const std::string meshes = BRITTLE_CORPUS "/meshes/";

struct Streams {
    int exit_code = -1;
    std::string output, errors;

    [[nodiscard]] bool says(const std::string& text) const { return errors.find(text) != std::string::npos; }
};

// `input`: a file for standard input; or empty.
Streams run(const Folder& folder, const std::string& arguments, const std::string& input = "/dev/null",
            const std::string& before = "") {
    const std::string out = folder / "stdout", err = folder / "stderr";
    const int status = std::system(
        (before + " /usr/bin/timeout 120 " BRITTLE_PROGRAM " " + arguments + " < " + input + " > " + out + " 2> " + err)
            .c_str());
    Streams streams{WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), read_text(out), read_text(err)};
    fs::remove(out);
    fs::remove(err);
    return streams;
}

} // namespace

TEST_CASE("standard input that is empty, unknown, damaged or not asked for is named, with what to do") {
    const Folder folder;
    const auto refused = [&](const std::string& arguments, const std::string& input, int code,
                             const std::string& words) {
        const Streams streams = run(folder, arguments, input);
        INFO(arguments, ": ", streams.errors);
        CHECK(streams.exit_code == code);
        CHECK(streams.says(words));
        CHECK(streams.output.empty());
    };
    const std::string noise = folder.write("noise", "\x01\x02\x03 nothing of the kind").string();
    const std::string cut = folder.write("cut", std::string("glTF\x02\0\0\0\xff\0\0\0", 12)).string();
    const std::string out = " -o " + (folder / "a.glb");
    for (const std::string& command : {"fracture -" + out, "repair -" + out, std::string("inspect -")}) {
        refused(command, "/dev/null", 3, "standard input: is empty");
        refused(command, noise, 3, "give --format and one of obj, stl, ply, off, glb, gltf, 3ds");
        refused(command, cut, 3, "standard input: ");
        refused(command + " --format ply", meshes + "crate.glb", 3, "standard input: ");
        refused(command + " --format fbx", meshes + "crate.glb", 2, "--format");
    }
    refused("inspect shape:cube --format obj", "/dev/null", 2, "only the mesh - needs one");
    refused("fracture - --save-recipe " + (folder / "r.json") + out, meshes + "crate.glb", 2, "--save-recipe: ");
    refused("render - --record " + (folder / "r.log"), meshes + "crate.glb", 2, "--record: ");
    refused("demo -", meshes + "crate.glb", 2, "reads no mesh from standard input");
    refused("profile -", meshes + "crate.glb", 2, "reads no mesh from standard input");
    refused("profile --meshes shape:cube,-", meshes + "crate.glb", 2, "reads no mesh from standard input");
    CHECK(folder.files() == 2); // noise and cut
}

TEST_CASE("a stream is read up to a limit") {
    const auto read = [](const std::string& text, uint64_t limit) {
        int ends[2];
        REQUIRE(::pipe(ends) == 0);
        REQUIRE(::write(ends[1], text.data(), text.size()) == static_cast<ssize_t>(text.size()));
        ::close(ends[1]);
        std::string result;
        try {
            for (const std::byte byte : read_stream(ends[0], "the pipe", limit))
                result.push_back(static_cast<char>(byte));
        } catch (const Failure& failure) {
            CHECK(failure.code() == exit_input);
            result = failure.what();
        }
        ::close(ends[0]);
        return result;
    };
    CHECK(read("", 0).empty());
    CHECK(read("abc", 3) == "abc");
    CHECK(read("abcd", 3).find("the pipe: longer than 3 bytes") == 0);
    const std::string longer(60'000, 'x');
    CHECK(read(longer, 60'000) == longer);
    CHECK(read(longer, 59'999).find("longer than 59999 bytes") != std::string::npos);
    CHECK_THROWS_AS((void)read_stream(-1, "nothing", 9), Failure);
}

TEST_CASE("a mesh on standard input gives what its file gives, whatever its format") {
    const Folder folder;
    const std::string from_file = folder / "file.ply", from_stream = folder / "stream.ply";
    for (const std::string ending : {"glb", "obj", "ply", "stl"}) {
        CAPTURE(ending);
        const std::string mesh = folder / ("mesh." + ending);
        REQUIRE(run(folder, "repair shape:torus -o " + mesh).exit_code == 0);
        REQUIRE(run(folder, "fracture " + mesh + " -n 5 -o " + from_file).exit_code == 0);
        for (const std::string& format : {std::string(), " --format " + ending}) {
            const Streams streams = run(folder, "fracture - -n 5 -o " + from_stream + format, mesh);
            INFO(streams.errors);
            CHECK(streams.exit_code == 0);
            CHECK(read_text(from_stream) == read_text(from_file));
        }
        CHECK(run(folder, "inspect -", mesh).output.starts_with("mesh\n"));
        CHECK(run(folder, "repair - -o " + (folder / "sound.obj"), mesh).exit_code == 0);
    }
}

TEST_CASE("standard output holds the file that -o FILE writes, and standard error the report") {
    const Folder folder;
    for (const std::string ending : {"glb", "ply", "stl", "obj"}) {
        CAPTURE(ending);
        const std::string file = folder / ("pieces." + ending);
        const std::string joined = ending == "stl" ? " --one-file" : ""; // as on standard output
        const Streams plain = run(folder, "fracture shape:torus -n 5 -o " + file + joined);
        REQUIRE(plain.exit_code == 0);
        const std::string format = ending == "glb" ? "" : " --output-format " + ending;
        const Streams streams = run(folder, "fracture shape:torus -n 5 -o -" + format);
        INFO(streams.errors);
        CHECK(streams.exit_code == 0);
        CHECK(streams.says("every one closed and oriented"));
        CHECK(streams.says("written    standard output"));
        std::string expected = read_text(file);
        if (ending == "obj") expected.replace(expected.find("mtllib"), std::string("mtllib pieces.mtl\n").size(), "");
        CHECK(streams.output == expected);
        const Streams quiet = run(folder, "fracture shape:torus -n 5 --quiet -o -" + format);
        CHECK(quiet.output == expected);
        CHECK(quiet.errors.empty());
        // What one command writes, the next one reads.
        const Streams repaired = run(folder, "repair shape:torus -o -" + format);
        CHECK(repaired.exit_code == 0);
        CHECK(repaired.says("written to standard output"));
        const Streams inspected = run(folder, "inspect -", folder.write("mesh", repaired.output).string());
        CHECK(inspected.exit_code == 0);
        CHECK(inspected.output.starts_with("mesh\n"));
    }
}

TEST_CASE("standard output refuses what needs several files, and says what to give instead") {
    const Folder folder;
    const auto refused = [&](const std::string& arguments, const std::string& words) {
        const Streams streams = run(folder, "fracture shape:cube -n 2 " + arguments);
        INFO(arguments, ": ", streams.errors);
        CHECK(streams.exit_code == 2);
        CHECK(streams.says(words));
        CHECK(streams.output.empty());
    };
    refused("-o - --per-piece", "--per-piece: standard output holds one file");
    refused("-o - --output-format obj --interior-texture a.png", "the images of an OBJ file are files beside it");
    refused("-o - --output-format ply --hulls godot", "give --output-format and one of glb");
    refused("-o - --output-format fbx", "--output-format");
    refused("-o a.glb --output-format ply", "the ending of a.glb gives the format");
    refused("-o - --json", "--json: standard output holds the mesh");
    CHECK(run(folder, "repair shape:cube -o a.glb --output-format ply").exit_code == 2);
    CHECK_FALSE(fs::exists("a.glb"));
}

TEST_CASE("standard output that cannot be written is an error") {
    const Folder folder;
    for (const std::string arguments : {"fracture shape:cube -n 2 -o -", "repair shape:cube -o -",
                                        "inspect shape:cube --json", "inspect shape:cube"}) {
        CAPTURE(arguments);
        const int status =
            std::system((BRITTLE_PROGRAM " " + arguments + " > /dev/full 2> " + (folder / "errors")).c_str());
        CHECK(WEXITSTATUS(status) == 5);
        CHECK(read_text(folder / "errors").find("standard output: cannot be written: No space left")
              != std::string::npos);
    }
}

TEST_CASE("--quiet prints errors only, and --json the content of --report") {
    const Folder folder;
    const std::string out = folder / "a.glb", report = folder / "r.json";
    const std::string fracture = "fracture shape:torus -n 4 -o " + out;
    const Streams quiet = run(folder, fracture + " -q");
    CHECK(quiet.exit_code == 0);
    CHECK(quiet.output.empty());
    CHECK(quiet.errors.empty());
    CHECK(fs::exists(out));
    for (const std::string& arguments :
         {std::string("inspect shape:cube --quiet"), "repair shape:cube -q -o " + out,
          std::string("profile shape:cube -n 2 --repeats 1 --frames 0 -q"), fracture + " --repair --quiet"}) {
        const Streams streams = run(folder, arguments);
        INFO(arguments, ": ", streams.output, streams.errors);
        CHECK(streams.exit_code == 0);
        CHECK(streams.output.empty());
        CHECK(streams.errors.empty());
    }
    CHECK_FALSE(run(folder, fracture + " --repair").errors.empty()); // "nothing to repair"
    const Streams failed = run(folder, "fracture missing.obj -q -o " + out);
    CHECK(failed.exit_code == 3);
    CHECK(failed.says("missing.obj"));

    for (const std::string& also : {std::string(), std::string(" --quiet")}) {
        const Streams json = run(folder, fracture + " --json --report " + report + also);
        INFO(json.errors);
        CHECK(json.exit_code == 0);
        CHECK(json.output == read_text(report));
        CHECK(nlohmann::json::parse(json.output)["pieces"] >= 4);
    }
    CHECK(nlohmann::json::accept(run(folder, "inspect shape:cube --json --quiet").output));
}

TEST_CASE("render --json tells what was written, on which device, frames and seconds") {
    const Folder folder;
    const std::string recipe = folder / "recipe.json";
    const std::string shared = " --size 64x48 --frames 4 --every 2 --json";
    const Streams streams =
        run(folder, "render shape:cube -n 3 -o " + (folder / "f_%02d.png") + " --ids " + (folder / "i_%02d.png")
                        + " --export " + (folder / "end.glb") + " --record " + (folder / "run.log") + " --save-recipe "
                        + recipe + shared);
    INFO(streams.errors);
    if (streams.exit_code == 6) {
        MESSAGE("skipped: no Vulkan device");
        return;
    }
    REQUIRE(streams.exit_code == 0);
    const auto json = nlohmann::json::parse(streams.output);
    CHECK(json["mesh"] == "cube");
    CHECK_FALSE(json["device"].get<std::string>().empty());
    CHECK(json["frames"] == 4);
    CHECK(json["simulated_seconds"].get<double>() == doctest::Approx(4.0 / 60.0));
    CHECK(json["seconds"].get<double>() > 0.0);
    CHECK(json["pieces"] == 3);
    const auto& written = json["written"];
    CHECK(written["pictures"]
          == std::vector<std::string>{folder / "f_00.png", folder / "f_02.png", folder / "f_04.png"});
    CHECK(written["ids"] == std::vector<std::string>{folder / "i_00.png", folder / "i_02.png", folder / "i_04.png"});
    CHECK(written["export"] == std::vector<std::string>{folder / "end.glb"});
    CHECK(written["record"] == folder / "run.log");
    CHECK(written["recipe"] == recipe);
    CHECK_FALSE(written.contains("video"));
    size_t files = 0; // each of them is there, and there are no others
    for (const auto& entry : written.items())
        for (const auto& file : entry.value().is_array() ? entry.value() : nlohmann::json::array({entry.value()})) {
            CHECK(fs::exists(file.get<std::string>()));
            ++files;
        }
    CHECK(files == folder.files());
    CHECK(json["recipe"]["picture"]["every"] == 2);

    // Size and interval come from the recipe.
    const Streams again = run(folder, "render " + recipe + " --json --quiet -o " + (folder / "g_%02d.png"));
    REQUIRE(again.exit_code == 0);
    CHECK(nlohmann::json::parse(again.output)["written"]["pictures"].size() == 3);
    CHECK(read_text(folder / "g_04.png") == read_text(folder / "f_04.png"));
    CHECK(again.errors.empty());
}

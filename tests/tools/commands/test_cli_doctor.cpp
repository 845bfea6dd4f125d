// inspect, repair and --unite from the user's point of view. Runs the real binary.
#include <doctest/doctest.h>

#include <array>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "fracture/shapes/shapes.h"
#include "tests/glb_file.h"
#include "tests/tools/support.h"
#include "tools/scenario/base/failure.h"

namespace fs = std::filesystem;
using namespace brittle;
using namespace brittle::tools;
using namespace brittle::tools::test;

namespace {

const std::string tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

// Two tetrahedra that share the edge 1-2.
const std::string shared_edge = tetrahedron + "v 0 -1 0\nv 0 0 -1\nf 1 6 5\nf 1 2 6\nf 2 5 6\nf 1 5 2\n";

} // namespace

TEST_CASE("open and non-manifold meshes are refused with the place of the first fault") {
    const Folder folder;
    write_text(folder / "open.obj", tetrahedron.substr(0, tetrahedron.rfind("f ")));
    const Outcome open = run_brittle(folder, "fracture " + folder / "open.obj" + " -o " + folder / "out.glb");
    INFO(open.output);
    CHECK(open.exit_code == 4);
    CHECK(open.has("open edge"));
    CHECK(open.has("between"));
    write_text(folder / "shared.obj", shared_edge);
    const Outcome shared = run_brittle(folder, "fracture " + folder / "shared.obj" + " -o " + folder / "out.glb");
    INFO(shared.output);
    CHECK(shared.exit_code == 4);
    CHECK(shared.has("three triangles"));
    CHECK(shared.has("between vertices 0 and 1"));
    CHECK_FALSE(fs::exists(folder / "out.glb"));
}

TEST_CASE("a mesh with a doubled face is refused with advice to repair, and broken with --repair") {
    const Folder folder;
    // One face of the tetrahedron is present twice.
    write_text(folder / "doubled.obj", tetrahedron + "f 2 3 4\n");
    const std::string command = "fracture " + folder / "doubled.obj" + " -n 3 -o " + folder / "out.glb";
    const Outcome refused = run_brittle(folder, command);
    INFO(refused.output);
    CHECK(refused.exit_code == 4);
    CHECK(refused.has("--repair"));
    const Outcome repaired = run_brittle(folder, command + " --repair");
    INFO(repaired.output);
    CHECK(repaired.exit_code == 0);
    CHECK(repaired.has("1 duplicate triangle dropped"));
}

TEST_CASE("repair repairs a mesh that fracture refuses, reports the repair, and keeps materials") {
    const Folder folder;
    // The crate without its floor; repair closes the hole.
    std::string crate = read_text(BRITTLE_CORPUS "/meshes/crate.obj");
    crate.erase(crate.find("usemtl iron"));
    write_text(folder / "open.obj", crate);
    fs::copy(BRITTLE_CORPUS "/meshes/crate.mtl", folder / "crate.mtl");
    fs::copy(BRITTLE_CORPUS "/meshes/crate planks.png", folder / "crate planks.png");
    CHECK(run_brittle(folder, "inspect " + (folder / "open.obj")).exit_code == 4);
    const Outcome repaired = run_brittle(folder, "repair " + (folder / "open.obj") + " -o " + (folder / "whole.glb"));
    CHECK(repaired.exit_code == 0);
    CHECK(repaired.has("1 hole closed with 2 triangles"));
    CHECK(repaired.has("takes it as it is"));
    const std::string glb = read_text(folder / "whole.glb");
    for (const char* kept : {"planks", "painted lid", "exterior", "image/png"})
        CHECK(glb.find(kept) != std::string::npos);
    const Outcome at_once =
        run_brittle(folder, "fracture " + (folder / "open.obj") + " --repair -n 5 -o " + (folder / "pieces.glb"));
    CHECK(at_once.exit_code == 0);
    CHECK(at_once.has("every one closed"));
    const Outcome left =
        run_brittle(folder, "repair --close-holes 1 " + (folder / "open.obj") + " -o " + (folder / "left.stl"));
    CHECK(left.exit_code == 4);
    CHECK(left.has("1 hole left open: too long"));
    const Outcome sound = run_brittle(folder, "repair shape:torus -o " + (folder / "torus.ply"));
    CHECK(sound.exit_code == 0);
    CHECK(sound.has("nothing to repair"));
}

TEST_CASE("parts that pass through each other are told of, and united on request") {
    const Folder folder;
    // Two boxes of 1 m, with an eighth of a cubic metre in common, and a third one, inside out.
    std::string boxes;
    int vertices = 0;
    const auto box = [&](double at, bool inside_out) {
        for (int v = 0; v < 8; ++v)
            boxes += "v " + std::to_string(at + (v & 1)) + " " + std::to_string(at + (v >> 1 & 1)) + " "
                     + std::to_string(at + (v >> 2)) + "\n";
        for (const auto& [a, b, c] : std::initializer_list<std::array<int, 3>>{{1, 3, 4},
                                                                               {1, 4, 2},
                                                                               {5, 6, 8},
                                                                               {5, 8, 7},
                                                                               {1, 2, 6},
                                                                               {1, 6, 5},
                                                                               {3, 7, 8},
                                                                               {3, 8, 4},
                                                                               {1, 5, 7},
                                                                               {1, 7, 3},
                                                                               {2, 4, 8},
                                                                               {2, 8, 6}})
            boxes += "f " + std::to_string(a + vertices) + " " + std::to_string((inside_out ? c : b) + vertices) + " "
                     + std::to_string((inside_out ? b : c) + vertices) + "\n";
        vertices += 8;
    };
    box(0.0, false);
    box(0.5, false);
    write_text(folder / "boxes.obj", boxes);
    const std::string pieces = "fracture " + folder / "boxes.obj" + " -n 4 -o " + folder / "out.glb";
    const Outcome told = run_brittle(folder, pieces);
    INFO(told.output);
    CHECK(told.exit_code == 0);
    CHECK(told.has("6.67 % of its volume counts twice"));
    CHECK(told.has("--unite"));
    const Outcome united = run_brittle(folder, pieces + " --unite --report " + folder / "report.json");
    INFO(united.output);
    CHECK(united.exit_code == 0);
    CHECK_FALSE(united.has("counts twice"));
    CHECK(nlohmann::json::parse(read_text(folder / "report.json"))["volume_sum"].get<double>()
          == doctest::Approx(1.875));

    const Outcome inspected = run_brittle(folder, "inspect --json " + folder / "boxes.obj");
    const auto found = nlohmann::json::parse(inspected.output)["union"];
    CHECK(found["changes"] == true);
    CHECK(found["volume"].get<double>() == doctest::Approx(1.875));
    CHECK(run_brittle(folder, "inspect " + folder / "boxes.obj").has("6.67 % of its volume counts twice"));

    CHECK(run_brittle(folder, "repair --unite " + folder / "boxes.obj" + " -o " + folder / "one.ply")
              .has("parts united"));
    const Outcome again = run_brittle(folder, "repair --unite " + folder / "one.ply" + " -o " + folder / "two.ply");
    CHECK(again.has("nothing to unite"));
    CHECK(read_text(folder / "one.ply") == read_text(folder / "two.ply"));
    CHECK_FALSE(run_brittle(folder, "inspect " + folder / "one.ply").has("union"));

    boxes.clear();
    vertices = 0;
    box(0.0, true);
    write_text(folder / "turned.obj", boxes);
    const Outcome empty =
        run_brittle(folder, "fracture " + folder / "turned.obj" + " --unite -n 4 -o " + folder / "e.glb");
    INFO(empty.output);
    CHECK(empty.exit_code == 4);
    CHECK(empty.has("inside out"));
    CHECK_FALSE(fs::exists(folder / "e.glb"));
    write_text(folder / "open.obj", tetrahedron.substr(0, tetrahedron.rfind("f ")));
    const Outcome open =
        run_brittle(folder, "repair --close-holes 0 --unite " + folder / "open.obj" + " -o " + folder / "e.glb");
    CHECK(open.exit_code == 4);
    CHECK(open.has("only where the mesh is closed"));
    CHECK_FALSE(fs::exists(folder / "e.glb"));
}

TEST_CASE("inspect marks faults in a file and in a picture") {
    const Folder folder;
    write_text(folder / "open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n");
    const Outcome outcome = run_brittle(folder, "inspect " + (folder / "open.obj") + " --size 320x240 --marks "
                                                    + (folder / "m.glb") + " --picture " + (folder / "m.png"));
    CHECK(outcome.exit_code == 4);
    CHECK(outcome.output.find("open edges orange") != std::string::npos);
    CHECK(read_text(folder / "m.glb").find("open edges") != std::string::npos);
    CHECK(read_text(folder / "m.png").size() > 1000);
    const auto json = nlohmann::json::parse(run_brittle(folder, "inspect --json " + (folder / "open.obj")).output);
    CHECK(json["places"]["open_edges"].size() == 3);
}

TEST_CASE("inspect reports whether a mesh can be fractured, as text and as JSON") {
    const Folder folder;
    const Outcome sound = run_brittle(folder, "inspect shape:hollow_sphere");
    CHECK(sound.exit_code == 0);
    CHECK(sound.has("cavities   1"));
    CHECK(sound.has("takes it as it is"));
    write_text(folder / "open.obj", tetrahedron.substr(0, tetrahedron.rfind("f ")));
    const Outcome open = run_brittle(folder, "inspect --json " + (folder / "open.obj"));
    CHECK(open.exit_code == 4);
    const auto json = nlohmann::json::parse(open.output);
    CHECK(json["refusal"] == "not_closed");
    CHECK(json["closed"] == false);
    for (const char* property : {"manifold", "oriented"}) CHECK(json[property] == true);
    CHECK(json["self_intersecting"] == false);
    // Each property stands for itself.
    const auto properties_of = [&](const std::string& text) {
        write_text(folder / "mesh.obj", text);
        const auto found = nlohmann::json::parse(run_brittle(folder, "inspect --json " + (folder / "mesh.obj")).output);
        std::string all;
        for (const char* property : {"closed", "manifold", "oriented", "self_intersecting"})
            all += found[property] == true ? "+" : "-";
        return all;
    };
    const std::string rest = tetrahedron.substr(tetrahedron.find("f 1 2 4"));
    CHECK(properties_of(tetrahedron) == "+++-");
    CHECK(properties_of(tetrahedron.substr(0, tetrahedron.find("f ")) + "f 1 2 3\n" + rest) == "++--"); // turned
    CHECK(properties_of(shared_edge) == "+-+-");
    CHECK(properties_of(tetrahedron
                        + "v 0.1 0.1 -1\nv 0.2 0.1 -1\nv 0.1 0.2 -1\nv 0.1 0.1 0.3\n"
                          "f 5 7 6\nf 5 6 8\nf 6 7 8\nf 5 8 7\n")
          == "++++");
    const Outcome text = run_brittle(folder, "inspect " + (folder / "open.obj"));
    CHECK(text.has("open, oriented, manifold"));
    CHECK(text.has("3 open edges"));
    CHECK(json["open_edges"] == 3);
    CHECK(json["rims"][0]["edges"] == 3);
    CHECK(run_brittle(folder, "inspect nowhere.obj").exit_code == 3);
}

TEST_CASE("inspect lists the nodes of a glTF file, and the objects of a scene") {
    const Folder folder;
    test_files::GlbFile glb;
    fracture::TriangleMesh open = fracture::cuboid(glm::dvec3(1.0));
    open.triangles.pop_back();
    glb.add_mesh(open);
    glb.add_mesh(fracture::cuboid({1.0, 2.0, 3.0}));
    folder.write("level.glb", glb.bytes(R"("nodes": [{"name": "Rug", "mesh": 0}, {"name": "Box", "mesh": 1},
        {"name": "Box", "mesh": 1, "scale": [2, -1, 1]}, {"name": "Box", "mesh": 1, "translation": [9, 0, 0]}])"));
    const std::string level = folder / "level.glb";
    const Outcome text = run_brittle(folder, "inspect " + level);
    CHECK(text.exit_code == exit_mesh); // of the whole file, which other commands take as one mesh
    CHECK(text.has("Box 2         12       1  2 x 2 x 3"));
    CHECK(text.has("cannot be broken: not closed, 3 open edges"));
    const auto nodes = nlohmann::json::parse(run_brittle(folder, "inspect --json " + level).output)["objects"];
    REQUIRE(nodes.size() == 4);
    CHECK(nodes[0]["name"] == "Rug");
    CHECK(nodes[0]["triangles"] == 11);
    CHECK(nodes[0]["breakable"] == false);
    CHECK(nodes[1]["copies"] == 2); // the scaled one is another mesh
    CHECK(nodes[1]["size"] == std::vector<double>{1.0, 2.0, 3.0});
    CHECK(nodes[2]["breakable"] == true);
    CHECK(nodes[3]["name"] == "Box 3");
    CHECK_FALSE(run_brittle(folder, "inspect shape:cube").has("nodes"));

    const std::string scene = folder / "scene.json";
    const auto inspect_with = [&](const std::string& rule) {
        folder.write("scene.json", R"({"brittle": 2, "level": {"mesh": "level.glb", "rules": [)" + rule
                                       + R"({"node": "Box*", "then": {"bonded": true}}]}})");
        return run_brittle(folder, "inspect " + scene);
    };
    const Outcome whole = inspect_with("");
    CHECK(whole.exit_code == exit_success);
    CHECK(whole.has("4 objects"));
    CHECK(whole.has("fixed; cannot be broken: not closed, 3 open edges"));
    CHECK(whole.has("bonded\n"));
    const Outcome faulty = inspect_with(R"({"node": "Rug", "then": {}}, )");
    CHECK(faulty.exit_code == exit_mesh);
    CHECK(faulty.has("Rug stays whole and fixed"));
    const Outcome idle = inspect_with(R"({"node": "Lamp", "then": {}}, )");
    CHECK(idle.exit_code == exit_success);
    CHECK(idle.has("/level/rules/0 decides for no node"));
    folder.write("one.json", R"({"brittle": 1, "mesh": "shape:cube"})");
    CHECK(run_brittle(folder, "inspect " + (folder / "one.json")).has("inspect shape:cube instead"));
    CHECK(run_brittle(folder, "inspect --marks x.glb " + scene).exit_code == exit_usage);
}

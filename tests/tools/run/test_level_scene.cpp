// Scenes whose objects are nodes of a glTF file.
#include <algorithm>
#include <string>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "fracture/io/import.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/shapes/shapes.h"
#include "tests/glb_file.h"
#include "tests/tools/replays.h"
#include "tests/tools/support.h"
#include "tools/scenario/recipe/recipe.h"
#include "tools/scenario/run/scene.h"

using namespace brittle;
using namespace brittle::tools;
using namespace brittle::tools::test;
using brittle::test_files::GlbFile;

namespace {

FractureOptions read_scene(const Folder& folder, const std::string& members) {
    FractureOptions options;
    read_recipe(folder.write("scene.json", R"({"brittle": 2, )" + members + "}"), options);
    return options;
}

std::string vector(const glm::dvec3& v) {
    return "[" + std::to_string(v.x) + ", " + std::to_string(v.y) + ", " + std::to_string(v.z) + "]";
}

// Steps two scenes and requires equal states all along.
void check_equal_runs(const FractureOptions& a, const FractureOptions& b, int steps) {
    LoadedScene first = load_scene(a), second = load_scene(b);
    Simulation one, other;
    one.start(prepare_scene(first), first.world);
    other.start(prepare_scene(second), second.world);
    for (Simulation* simulation : {&one, &other})
        simulation->schedule(5, Shoot{{0.0, 0.6, 4.0}, {0.0, 0.0, -25.0}, 0.15, 7800.0});
    for (int step = 0; step < steps; ++step) {
        REQUIRE(one.state_hash() == other.state_hash());
        one.step();
        other.step();
    }
    CHECK(one.number_count() > one.piece_count()); // something broke
}

} // namespace

TEST_CASE("level scene: a file that is missing, no glTF or without the node is a failure that names the object") {
    const Folder folder;
    GlbFile glb;
    glb.add_mesh(fracture::cuboid(glm::dvec3(1.0)));
    (void)folder.write("kit.glb",
                       glb.bytes(R"("nodes": [{"name": "Crate", "mesh": 0}, {"name": "Eye", "camera": 0}])"));
    (void)folder.write("kit.obj", "v 0 0 0\n");
    const auto message = [&](const std::string& members) -> std::string {
        try {
            (void)load_scene(read_scene(folder, members));
        } catch (const Failure& failure) {
            CHECK(failure.code() == exit_input);
            return failure.what();
        }
        return "";
    };
    CHECK(message(R"("level": {"mesh": "none.glb"})").find("none.glb: ") != std::string::npos);
    CHECK(message(R"("level": {"mesh": "kit.obj"})").find("only .glb and .gltf files have nodes") != std::string::npos);
    CHECK(message(R"("objects": [{"name": "a", "mesh": "none.glb", "node": "Crate"}])").find("object a: ") == 0);
    const std::string lost = message(R"("objects": [{"name": "a", "mesh": "kit.glb", "node": "Eye"}])");
    CHECK(lost.find("object a: ") == 0);
    CHECK(lost.find("kit.glb has no node \"Eye\" that shows a mesh; its nodes are: Crate") != std::string::npos);
    CHECK(message(R"("objects": [{"mesh": "shape:cube", "node": "Eye"}])").find("/objects/0/node: a shape has no nodes")
          != std::string::npos);
}

TEST_CASE("level scene: objects are where the file has them, and instances share mesh, solids and hulls") {
    const Folder folder;
    GlbFile glb;
    glb.add_mesh(fracture::cuboid({1.0, 2.0, 3.0}));
    glb.add_mesh(fracture::icosphere(2, 0.5));
    const std::string file = glb.bytes(R"("nodes": [
        {"translation": [100, 200, 300], "scale": [1, 2, 1], "rotation": [0, 0.6, 0, 0.8], "children": [1, 2]},
        {"name": "skewed", "mesh": 0, "rotation": [0, 0, 0.28, 0.96]},
        {"name": "mirrored", "mesh": 0, "scale": [-1, 1, 1], "translation": [0, 0, 50]},
        {"name": "ball 1", "mesh": 1}, {"name": "ball 2", "mesh": 1, "translation": [0, 0, 9], "rotation": [0.6, 0, 0, 0.8]},
        {"name": "large", "mesh": 1, "scale": [2, 2, 2]}], "scenes": [{"nodes": [0, 3, 4, 5]}])");
    (void)folder.write("level.glb", file);
    const FractureOptions options = read_scene(folder, R"("units": "cm", "level": {"mesh": "level.glb",
        "rules": [{"then": {"material": "stone"}}]}, "objects": [{"mesh": "level.glb", "node": "ball 1"},
        {"name": "ball 2", "mesh": "level.glb", "node": "ball 1", "material": "stone", "translation": [0, 0, 1]}])");
    LoadedScene loaded = load_scene(options);
    CHECK(loaded.notes.empty());
    REQUIRE(loaded.objects.size() == 7);
    const auto joined = fracture::import_mesh(folder / "level.glb");
    REQUIRE(joined);
    fracture::Box box = loaded.objects[0].box;
    double volume = 0.0;
    for (size_t k = 0; k < 5; ++k) {
        const LoadedObject& object = loaded.objects[k];
        box = {glm::min(box.min, object.box.min), glm::max(box.max, object.box.max)};
        const fracture::TriangleMesh& mesh = object.input->model.mesh;
        const double own = fracture::signed_volume(mesh.positions, mesh.triangles);
        CHECK(own > 0.0);
        volume += own;
    }
    const fracture::Box expected = fracture::bounds(*joined);
    CHECK(glm::length(box.min - 0.01 * expected.min) < 1e-6); // the world has single precision
    CHECK(glm::length(box.max - 0.01 * expected.max) < 1e-6);
    CHECK(volume == doctest::Approx(1e-6 * fracture::signed_volume(joined->positions, joined->triangles)));

    const auto& at = loaded.objects;
    CHECK(at[5].object.name == "ball 1"); // the recipe's objects keep their names
    CHECK(at[2].object.name == "ball 1 2");
    CHECK(at[3].object.name == "ball 2 2");
    CHECK(at[6].object.name == "ball 2");
    for (const size_t k : {3u, 5u, 6u}) CHECK(at[k].input == at[2].input);
    CHECK(at[4].input != at[2].input);
    CHECK(at[0].input != at[1].input);
    const std::vector<PreparedObject> objects = prepare_scene(loaded);
    CHECK(objects[3].bodies.solids[0] == objects[2].bodies.solids[0]);
    CHECK(objects[6].bodies.solids[0] == objects[2].bodies.solids[0]);
    CHECK(objects[5].bodies.solids[0] != objects[2].bodies.solids[0]); // another material

    // As objects of the recipe, one by one, it is the same scene.
    FractureOptions expanded = options;
    CHECK(expand_level(expanded).empty());
    CHECK(expanded.level.mesh.empty());
    const LoadedScene again = load_scene(expanded);
    REQUIRE(again.objects.size() == loaded.objects.size());
    for (size_t k = 0; k < again.objects.size(); ++k) {
        CHECK(again.objects[k].object.name == loaded.objects[k].object.name);
        CHECK(again.objects[k].box.min == loaded.objects[k].box.min);
        CHECK(again.objects[k].box.max == loaded.objects[k].box.max);
    }
    FractureOptions read_again;
    read_recipe(folder.write("expanded.json", recipe_json(expanded)), read_again);
    CHECK(recipe_json(read_again) == recipe_json(expanded));
}

TEST_CASE("level scene: a mesh that cannot be broken stays fixed, with a note, and others break") {
    const Folder folder;
    GlbFile glb;
    fracture::TriangleMesh open = fracture::cuboid(glm::dvec3(1.0));
    open.triangles.pop_back();
    glb.add_mesh(open);
    glb.add_mesh(fracture::cuboid(glm::dvec3(1.0)));
    (void)folder.write("level.glb", glb.bytes(R"("nodes": [{"name": "open", "mesh": 0},
        {"name": "closed", "mesh": 1, "translation": [3, 0, 0]}, {"name": "flat", "mesh": 1, "scale": [1, 0, 1]},
        {"name": "typo", "mesh": 1, "extras": {"brittle": {"fixd": true}}}])"));
    LoadedScene loaded =
        load_scene(read_scene(folder, R"("level": {"mesh": "level.glb", "rules": [{"then": {"material": "glass"}}]})"));
    REQUIRE(loaded.objects.size() == 3);
    CHECK(loaded.objects[0].object.fixed);
    CHECK_FALSE(loaded.objects[1].object.fixed);
    CHECK(loaded.objects[2].object.fixed);
    REQUIRE(loaded.notes.size() == 3);
    CHECK(loaded.notes[0].find("flat is left out") == 0);
    CHECK(loaded.notes[1].find("typo stays whole and fixed") == 0);
    CHECK(loaded.notes[2].find("open stays whole and fixed") == 0);
}

TEST_CASE("level scene: its states equal those of the same objects in a recipe, one by one") {
    const Folder folder;
    GlbFile glb;
    glb.add_mesh(fracture::cuboid({4.0, 0.2, 4.0}));
    glb.add_mesh(fracture::cuboid({1.0, 1.2, 0.1}));
    glb.add_mesh(fracture::icosphere(2, 0.25));
    (void)folder.write("level.glb", glb.bytes(R"("materials": [{"name": "Window"}], "nodes": [
        {"name": "floor", "mesh": 0}, {"name": "pane", "mesh": 1, "translation": [0, 0.7, 0]},
        {"name": "balls", "translation": [0, 0.35, -1], "children": [3, 4]},
        {"name": "ball", "mesh": 2, "rotation": [0, 0.7071067811865476, 0, 0.7071067811865476], "scale": [1, 1, 1]},
        {"name": "ball", "mesh": 2, "translation": [1, 0, 0]}], "scenes": [{"nodes": [0, 1, 2]}])"));
    // The same objects, each with a file of its own.
    const auto ball = fracture::icosphere(2, 0.25);
    GlbFile floor, pane, one_ball;
    floor.add_mesh(fracture::cuboid({4.0, 0.2, 4.0}));
    pane.add_mesh(fracture::cuboid({1.0, 1.2, 0.1}));
    one_ball.add_mesh(ball);
    const std::string node = R"("nodes": [{"mesh": 0}])";
    (void)folder.write("floor.glb", floor.bytes(node));
    (void)folder.write("pane.glb", pane.bytes(node));
    (void)folder.write("ball.glb", one_ball.bytes(node));
    const FractureOptions level = read_scene(folder, R"("level": {"mesh": "level.glb", "rules": [
        {"node": "pane", "then": {"material": "glass", "min_size": 0.1}}, {"node": "ball*", "then": {"material": "stone"}}]})");
    const std::string ball_keys = R"("mesh": "ball.glb", "material": "stone", )";
    const FractureOptions listed = read_scene(folder, R"("objects": [{"mesh": "floor.glb", "fixed": true},
        {"mesh": "pane.glb", "material": "glass", "min_size": 0.1, "translation": [0, 0.7, 0]},
        {)" + ball_keys + R"("translation": [0, 0.35, -1], "rotation": [0, 90, 0]},
        {)" + ball_keys + R"("translation": [1, 0.35, -1]}])");
    check_equal_runs(level, listed, 60);
}

TEST_CASE("level scene: two hundred nodes run alike with any number of threads, from the log") {
    const Folder folder;
    GlbFile glb;
    glb.add_mesh(fracture::cuboid({30.0, 0.2, 30.0}));
    glb.add_mesh(fracture::cuboid({0.4, 0.8, 0.2}));
    glb.add_mesh(fracture::icosphere(1, 0.3));
    std::string nodes = R"({"name": "floor", "mesh": 0, "translation": [0, -0.1, 0]})";
    for (int k = 0; k < 200; ++k) {
        const glm::dvec3 at(k % 15 - 7.0, 0.4, k / 15 - 6.0);
        nodes +=
            R"(, {"name": "thing", "mesh": )" + std::to_string(1 + k % 2) + R"(, "translation": )" + vector(at)
            + (k % 7 == 0 ? R"(, "scale": [-1, 1, 1])" : "")
            + (k % 11 == 0 ? R"(, "extras": {"brittle": {"bonded": true, "pattern": {"type": "uniform", "count": 5}}})"
                           : "")
            + "}";
    }
    (void)folder.write("level.glb", glb.bytes(R"("nodes": [)" + nodes + "]"));
    const FractureOptions scene = read_scene(folder, R"("level": {"mesh": "level.glb", "rules": [
        {"node": "thing*", "then": {"material": "ceramic", "min_size": 0.1}}]}, "world": {"shots": [
            {"time": 0.02, "from": [-9, 0.4, 0], "velocity": [60, 0, 0], "radius": 0.2}]})");
    uint32_t broken = 0;
    {
        LoadedScene loaded = load_scene(scene);
        CHECK(loaded.notes.empty());
        REQUIRE(loaded.objects.size() == 201);
        Simulation simulation;
        Recorder recorder(folder / "level.log", scene);
        simulation.observe(&recorder);
        simulation.start(prepare_scene(loaded), loaded.world);
        const uint32_t before = simulation.number_count();
        while (simulation.steps() < 30) simulation.step();
        broken = simulation.number_count() - before;
        recorder.finish();
    }
    CHECK(broken > 10);
    const ReplayLog log = read_replay_log(folder / "level.log");
    for (const uint32_t threads : {1u, 2u, 7u}) {
        uint64_t steps = 0;
        CHECK_FALSE(replayed_scene(log, threads, steps));
        CHECK(steps == 30);
    }
}

// Scenes of several objects in one world.
#include "tools/scenario/run/scene.h"

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <tuple>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "fracture/shapes/shapes.h"
#include "tests/glb_file.h"
#include "tests/tools/replays.h"
#include "tests/tools/support.h"
#include "tools/scenario/recipe/recipe.h"
#include "tools/scenario/run/scene_cache.h"

using namespace brittle;
using namespace brittle::tools;
using namespace brittle::tools::test;

namespace {

FractureOptions scene_of(const std::string& objects, const std::string& more = "") {
    const Folder folder;
    FractureOptions options;
    read_recipe(folder.write("scene.json", R"({"brittle": 2, "objects": [)" + objects + "]" + more + "}"), options);
    return options;
}

FractureOptions world_file(const std::string& name) {
    FractureOptions options;
    read_recipe(BRITTLE_ASSETS "/worlds/" + name + ".json", options);
    return options;
}

// The pieces of each object.
std::map<std::string, size_t> counts(const Simulation& simulation) {
    std::map<std::string, size_t> pieces;
    for (const physics::PieceId id : simulation.destruction()->pieces())
        ++pieces[simulation.members()[simulation.member_of(id.value)].name];
    return pieces;
}

float fastest(const physics::World& world) {
    float speed = 0.0f;
    for (const physics::BodyId body : world.bodies()) speed = std::max(speed, glm::length(world.linear_velocity(body)));
    return speed;
}

// What the loading of a scene says and makes.
struct Told {
    std::vector<std::string> notes, reports;
    std::vector<glm::dvec3> positions;

    bool operator==(const Told&) const = default;
};

} // namespace

TEST_CASE("scene: a file that cannot be read is a failure that names the object") {
    const FractureOptions scene = scene_of(R"({"name": "vase", "mesh": "missing.obj"})");
    try {
        (void)load_scene(scene);
        FAIL("loaded");
    } catch (const Failure& failure) {
        CHECK(failure.code() == exit_input);
        CHECK(std::string(failure.what()).find("object vase: ") == 0);
    }
}

TEST_CASE("scene: a mesh that cannot be broken stays fixed, with a note, and others break") {
    const Folder folder;
    const std::string open = folder.write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 3 2\n").string();
    const std::string inside_out =
        folder.write("out.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n").string();
    CHECK(load_scene(scene_of(R"({"mesh": ")" + inside_out + R"("})")).notes.at(0).find("face inwards")
          != std::string::npos);
    for (const char* kind : {R"("bonded": true)", R"("anchored": true)", R"("shattered": true)"}) {
        LoadedScene held = load_scene(scene_of(R"({"mesh": ")" + open + R"(", )" + kind + "}"));
        Simulation simulation;
        simulation.start(prepare_scene(held), held.world);
        CHECK(simulation.world().fixed(simulation.body_of(0)));
    }
    const FractureOptions scene =
        scene_of(R"({"name": "rug", "mesh": ")" + open + R"("}, {"name": "rug 2", "mesh": ")" + open
                 + R"("}, {"name": "box", "mesh": "shape:cube", "translation": [0, 3, 0]})");
    LoadedScene loaded = load_scene(scene);
    REQUIRE(loaded.notes.size() == 2);
    CHECK(loaded.notes[0].find("rug stays whole and fixed") == 0);
    CHECK(loaded.objects[0].object.fixed);
    CHECK(loaded.objects[1].object.fixed);
    CHECK_FALSE(loaded.objects[2].object.fixed);
    CHECK(loaded.home.min.y == doctest::Approx(2.0)); // around what moves
    Simulation simulation;
    simulation.start(prepare_scene(loaded), loaded.world);
    CHECK(simulation.piece_count() == 3);
    CHECK(simulation.world().fixed(simulation.body_of(0)));
    CHECK_FALSE(simulation.world().fixed(simulation.body_of(2)));
}

TEST_CASE("scene: a mesh that turns out not to be breakable when it is cut stays fixed, and others break") {
    // Two spheres side by side, the smaller one inside out: closed, and of positive volume as a whole.
    const Folder folder;
    fracture::TriangleMesh mesh = fracture::icosphere(2, 1.0), hole = fracture::icosphere(2, 0.8);
    const auto base = static_cast<uint32_t>(mesh.positions.size());
    for (const glm::dvec3& p : hole.positions) mesh.positions.push_back(p + glm::dvec3(3.0, 0.0, 0.0));
    for (const fracture::Triangle& t : hole.triangles)
        mesh.triangles.emplace_back(base + t.x, base + t.z, base + t.y); // beside the first one, inside out
    std::string text;
    for (const glm::dvec3& p : mesh.positions)
        text += "v " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
    for (const fracture::Triangle& t : mesh.triangles)
        text += "f " + std::to_string(t.x + 1) + " " + std::to_string(t.y + 1) + " " + std::to_string(t.z + 1) + "\n";
    const std::string file = folder.write("spheres.obj", text).string();
    LoadedScene loaded = load_scene(scene_of(R"({"name": "a", "mesh": ")" + file + R"("}, {"name": "b", "mesh": ")"
                                             + file + R"(", "translation": [0, 5, 0]}, {"mesh": "shape:cube"})"));
    CHECK(loaded.notes.empty());
    Simulation simulation;
    simulation.start(prepare_scene(loaded), loaded.world);
    CHECK(loaded.notes.size() == 2);
    CHECK(simulation.piece_count() == 3);
    CHECK(simulation.world().fixed(simulation.body_of(0)));
    CHECK(simulation.world().fixed(simulation.body_of(1)));
    CHECK_FALSE(simulation.world().fixed(simulation.body_of(2)));
}

TEST_CASE("scene: meshes, notes, reports and failures are the same whatever number of threads makes the meshes") {
    const Folder folder;
    const std::string open =
        folder.write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\n").string();
    std::string objects;
    for (int k = 0; k < 24; ++k)
        objects += std::string(k > 0 ? ", " : "") + R"({"name": "o)" + std::to_string(k) + R"(", "mesh": ")"
                   + (k % 3 == 0 ? "shape:vase" : open) + R"(", "repair": )" + (k % 3 == 1 ? "true" : "false")
                   + R"(, "bonded": true, "scale": )" + std::to_string(1 + k / 6) + "}";
    const FractureOptions scene = scene_of(objects);
    std::optional<Told> first;
    for (const uint32_t threads : {1u, 2u, 7u}) {
        FractureOptions options = scene;
        options.threads = threads;
        Told told;
        const LoadedScene loaded =
            load_scene(options, {.report = [&](const std::string& text) { told.reports.push_back(text); }});
        told.notes = loaded.notes;
        for (size_t k = 0; k < loaded.objects.size(); ++k) {
            const auto& positions = loaded.objects[k].input->model.mesh.positions;
            told.positions.insert(told.positions.end(), positions.begin(), positions.end());
            CHECK(loaded.objects[k].refused == (k % 3 == 2)); // open
        }
        CHECK(told.notes.size() == 8);
        CHECK(told.reports.size() == 8); // of repairs
        if (!first) first = told;
        CHECK(told == *first);

        for (const size_t k : {21u, 6u, 12u}) options.objects[k].recipe.sites_file = folder / "missing.txt";
        CHECK_THROWS_WITH_AS((void)load_scene(options), doctest::Contains("object o6: "), Failure);
    }
}

TEST_CASE("scene: notes, failures, progress and pieces are the same whatever number of threads prepares the objects") {
    const Folder folder;
    const auto spheres = [&](double apart) { // of which one is inside out, which only the cut finds
        fracture::TriangleMesh mesh = fracture::icosphere(1, 1.0);
        const size_t triangles = mesh.triangles.size(), vertices = mesh.positions.size();
        for (size_t v = 0; v < vertices; ++v)
            mesh.positions.push_back(0.5 * mesh.positions[v] + glm::dvec3(apart, 0.0, 0.0));
        for (size_t t = 0; t < triangles; ++t) {
            const fracture::Triangle turned(mesh.triangles[t].x, mesh.triangles[t].z, mesh.triangles[t].y);
            mesh.triangles.push_back(turned + static_cast<uint32_t>(vertices));
        }
        test_files::GlbFile glb;
        glb.add_mesh(mesh);
        return folder.write(std::to_string(apart) + ".glb", glb.bytes(R"("nodes": [{"mesh": 0}])")).string();
    };
    std::string objects;
    for (int k = 0; k < 24; ++k) {
        const std::string mesh = k % 5 == 3 ? spheres(3.0 + k) : k % 5 == 4 ? spheres(3.0) : "shape:vase";
        objects += (k > 0 ? R"(, {"mesh": ")" : R"({"mesh": ")") + mesh + R"(", "scale": )"
                   + (k % 2 == 0 ? "1" : std::to_string(1 + k)) + R"(, "translation": [)" + std::to_string(30 * k)
                   + R"(, 0, 0], "name": "o)" + std::to_string(k) + R"("})";
    }
    const FractureOptions scene = scene_of(objects);
    std::optional<uint64_t> hash;
    for (const uint32_t threads : {1u, 2u, 7u}) {
        FractureOptions options = scene;
        options.threads = threads;
        LoadedScene loaded = load_scene(options);
        CHECK(loaded.notes.empty());
        std::vector<double> shares;
        const std::vector<PreparedObject> prepared =
            prepare_scene(loaded, {}, {}, [&](double share) { shares.push_back(share); });
        REQUIRE(prepared.size() == 24);
        for (size_t k = 0; k < 24; ++k) CHECK(prepared[k].name == "o" + std::to_string(k));
        CHECK(shares.size() == 24);
        CHECK(std::ranges::is_sorted(shares));
        CHECK(shares.back() == 1.0);
        std::vector<std::string> fixed;
        for (const std::string& note : loaded.notes) fixed.push_back(note.substr(0, note.find(' ')));
        CHECK(fixed == std::vector<std::string>{"o3", "o4", "o8", "o9", "o13", "o14", "o18", "o19", "o23"});
        const uint64_t own = pieces_hash(prepared);
        CHECK(own == hash.value_or(own));
        hash = own;

        for (const size_t k : {20u, 5u, 11u}) options.objects[k].recipe.sites_file = folder / "missing.txt";
        loaded = load_scene(options);
        CHECK_THROWS_WITH_AS((void)prepare_scene(loaded), doctest::Contains("object o5: "), Failure);
    }
}

TEST_CASE("scene: it is no input of one mesh, and render refuses what it cannot show") {
    const Folder folder;
    CHECK_THROWS_WITH_AS((void)load_input(scene_of(R"({"mesh": "shape:cube"})")),
                         doctest::Contains("the recipe is a scene of 1 objects"), Failure);
    const std::string scene = BRITTLE_ASSETS "/worlds/staircase.json";
    const std::string render = "render " + scene + " --frames 0 --size 32x32 -o " + folder / "x.png";
    CHECK(run_brittle(folder, render + " --whole").has("no picture of whole"));
    const Outcome exported = run_brittle(folder, render + " --export " + folder / "x.obj");
    CHECK(exported.exit_code == exit_usage);
    CHECK(exported.has("--export: a scene is written as one .glb file"));
    CHECK(run_brittle(folder, render + " --per-piece --export " + folder / "x.glb").has("--per-piece: a scene"));
    CHECK_FALSE(std::filesystem::exists(folder / "x.png"));
    CHECK(run_brittle(folder, render + " --material glass").has("have no effect on a scene"));
    CHECK_FALSE(run_brittle(folder, render + " --air-density 0").has("have no effect on a scene"));
}

TEST_CASE("scene: objects stand where translation, rotation and scale put them, in the units of the files") {
    const Folder folder;
    const std::string box =
        folder.write("box.obj", "v 0 0 0\nv 40 0 0\nv 0 20 0\nv 0 0 10\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n").string();
    const FractureOptions scene =
        scene_of(R"({"name": "a", "mesh": ")" + box + R"(", "translation": [1, 2, 3], "rotation": [30, -50, 70],
                                                 "scale": [2, 1, -1]})",
                 R"(, "units": "cm")");
    LoadedScene loaded = load_scene(scene);
    glm::dmat4 oracle = glm::translate(glm::dmat4(1.0), {1.0, 2.0, 3.0});
    oracle = glm::rotate(oracle, glm::radians(70.0), {0.0, 0.0, 1.0});
    oracle = glm::rotate(oracle, glm::radians(-50.0), {0.0, 1.0, 0.0});
    oracle = glm::rotate(oracle, glm::radians(30.0), {1.0, 0.0, 0.0});
    oracle = glm::scale(oracle, glm::dvec3(0.02, 0.01, -0.01));
    glm::dvec3 centre(0.0), low(1e9), high(-1e9);
    for (const glm::dvec4& p :
         {glm::dvec4(0, 0, 0, 1), glm::dvec4(40, 0, 0, 1), glm::dvec4(0, 20, 0, 1), glm::dvec4(0, 0, 10, 1)}) {
        const glm::dvec3 at(oracle * p);
        centre += at / 4.0;
        low = glm::min(low, at);
        high = glm::max(high, at);
    }
    CHECK(glm::length(loaded.objects[0].box.min - low) < 1e-6);
    CHECK(glm::length(loaded.objects[0].box.max - high) < 1e-6);
    Simulation simulation;
    simulation.start(prepare_scene(loaded), loaded.world);
    CHECK(glm::length(glm::dvec3(simulation.pose_of(0).position) - centre) < 1e-6);
    CHECK(simulation.destruction()->solid({0})->mass.volume == doctest::Approx(2.0 * 0.4 * 0.2 * 0.1 / 6.0));
}

TEST_CASE("scene: objects that differ in place alone share mesh and solids") {
    const FractureOptions scene = scene_of(R"({"mesh": "shape:vase", "translation": [0, 0, 0]},
        {"mesh": "shape:vase", "translation": [1, 0, 0], "rotation": [0, 90, 0]},
        {"mesh": "shape:vase", "translation": [2, 0, 0], "material": "ceramic"},
        {"mesh": "shape:vase", "translation": [3, 0, 0], "scale": 2})");
    LoadedScene loaded = load_scene(scene);
    CHECK(loaded.objects[0].input == loaded.objects[1].input);
    CHECK(loaded.objects[0].input == loaded.objects[2].input);
    CHECK(loaded.objects[0].input != loaded.objects[3].input);
    const std::vector<PreparedObject> objects = prepare_scene(loaded);
    CHECK(objects[0].bodies.solids[0] == objects[1].bodies.solids[0]);
    CHECK(objects[0].bodies.solids[0] != objects[2].bodies.solids[0]); // another density
    CHECK(objects[0].bodies.solids[0] != objects[3].bodies.solids[0]);
}

TEST_CASE("scene: edits with a cache make the pieces and states of a fresh load, and only what changed anew") {
    const Folder folder;
    const auto spike = [](double height) {
        return "v 0 0 0\nv 1 0 0\nv 0 " + std::to_string(height) + " 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    };
    const std::string file = folder.write("spike.obj", spike(1.0)).string();
    const std::string sheet = folder.write("sheet.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 3 2\n").string();
    FractureOptions scene = scene_of(
        R"({"name": "floor", "mesh": "shape:cube", "scale": [9, 0.1, 9], "fixed": true},
        {"name": "vase", "mesh": "shape:vase", "material": "ceramic", "translation": [0, 2, 0]},
        {"name": "twin", "mesh": "shape:vase", "material": "ceramic", "translation": [2, 2, 0]},
        {"name": "wall", "mesh": "shape:wall", "material": "brick", "translation": [-3, 1, 0], "scale": 0.3, "bonded": true,
         "anchored": true, "roughness": 0.5},
        {"name": "sheet", "mesh": ")"
        + sheet + R"("},
        {"name": "spike", "mesh": ")"
        + file + R"(", "translation": [4, 1, 0], "shattered": true,
         "pattern": {"type": "uniform", "count": 5}})");
    SceneCache cache;
    const auto solids_of = [&](SceneCache* with) {
        LoadedScene loaded = load_scene(scene, {}, with);
        std::vector<PreparedObject> objects = prepare_scene(loaded, {}, {}, {}, with);
        std::vector<const physics::SolidPiece*> first; // of each object; the cache keeps them
        for (const PreparedObject& object : objects) first.push_back(object.bodies.solids[0].get());
        Simulation simulation;
        const uint64_t pieces = pieces_hash(objects);
        simulation.start(std::move(objects), loaded.world);
        for (int step = 0; step < 40; ++step) simulation.step();
        return std::tuple(first, pieces, simulation.state_hash(), loaded.notes);
    };
    auto before = std::get<0>(solids_of(&cache));
    // Edits, and the objects that they change.
    struct Change {
        const char* what;
        std::function<void()> make;
        std::vector<bool> anew;
    };
    const auto placement = [&](size_t k) -> ObjectPlacement& { return scene.objects[k].placement; };
    const std::vector<Change> changes{
        {"nothing", [] {}, {false, false, false, false, false, false}},
        {"places",
         [&] { placement(1).translation.x = -0.5, placement(5).rotation.y = 30.0; },
         {false, false, false, false, false, false}},
        {"an anchored object turned",
         [&] { placement(3).rotation.x = 90.0; },
         {false, false, false, true, false, false}},
        {"scale", [&] { placement(5).scale.y = 2.0; }, {false, false, false, false, false, true}},
        {"material", [&] { scene.objects[2].recipe.material = "glass"; }, {false, false, true, false, false, false}},
        {"back",
         [&] { scene.objects[2].recipe.material = "ceramic"; },
         {false, false, true, false, false, false}}, // the twin of the vase again
        {"seed of what starts whole",
         [&] { scene.objects[1].recipe.pattern.seed = 9; },
         {false, true, true, false, false, false}},
        {"name of an automatic pattern",
         [&] { scene.objects[3].name = "other wall"; },
         {false, false, false, true, false, false}},
        {"strength", [&] { scene.objects[3].recipe.world.strength = 0.5; }, {false, false, false, true, false, false}},
        {"pattern", [&] { scene.objects[5].recipe.pattern.count = 7; }, {false, false, false, false, false, true}},
        {"kind", [&] { scene.objects[1].fixed = true; }, {false, true, true, false, false, false}},
        {"units", [&] { scene.units = LengthUnit::centimetre; }, {true, true, true, true, true, true}},
        {"file", [&] { folder.write("spike.obj", spike(12.5)); }, {false, false, false, false, false, true}}};
    for (const Change& change : changes) {
        CAPTURE(std::string(change.what));
        change.make();
        const auto [cached, pieces, state, notes] = solids_of(&cache);
        const auto [fresh, fresh_pieces, fresh_state, fresh_notes] = solids_of(nullptr);
        CHECK(pieces == fresh_pieces);
        CHECK(state == fresh_state);
        CHECK(notes == fresh_notes);
        for (size_t k = 0; k < cached.size(); ++k) {
            CAPTURE(k);
            CHECK((cached[k] != before[k]) == change.anew[k]);
        }
        before = cached;
    }
    for (int k = 0; k < 60; ++k) { // what is not used is forgotten
        placement(5).scale.y = 1.0 + 0.01 * k;
        LoadedScene loaded = load_scene(scene, {}, &cache);
        (void)prepare_scene(loaded, {}, {}, {}, &cache);
    }
    CHECK(cache.meshes.size() < 20);
    CHECK(cache.prepared.size() < 20);
}

TEST_CASE("scene: every kind of object in one world does what it says") {
    const FractureOptions scene = scene_of(
        R"({"name": "table", "mesh": "shape:cube", "fixed": true, "scale": [4, 0.5, 4], "translation": [0, 0.5, 0]},
           {"name": "rigid", "mesh": "shape:cube", "breakable": false, "scale": 0.2, "translation": [-2, 1.21, 0]},
           {"name": "whole", "mesh": "shape:cube", "scale": 0.2, "translation": [-1, 1.21, 0], "material": "glass"},
           {"name": "bonded", "mesh": "shape:cube", "bonded": true, "scale": 0.2, "translation": [0, 1.21, 0],
            "pattern": {"type": "uniform", "count": 8}},
           {"name": "held", "mesh": "shape:cube", "anchored": true, "scale": 0.2, "translation": [1, 1.5, 0],
            "rotation": [0, 0, 45]},
           {"name": "loose", "mesh": "shape:cube", "shattered": true, "scale": 0.2, "translation": [2, 1.21, 0],
            "pattern": {"type": "uniform", "count": 8}, "breakable": false},
           {"name": "pinned", "mesh": "shape:cube", "bonded": true, "anchored": true, "scale": 0.2,
            "translation": [3, 1.5, 0], "breakable": false, "pattern": {"type": "uniform", "count": 8}})");
    LoadedScene loaded = load_scene(scene);
    Simulation simulation;
    simulation.start(prepare_scene(loaded), loaded.world);
    const std::map<std::string, size_t> start{{"table", 1}, {"rigid", 1}, {"whole", 1}, {"bonded", 8},
                                              {"held", 1},  {"loose", 8}, {"pinned", 8}};
    CHECK(counts(simulation) == start);
    CHECK(simulation.structures().size() == 2);
    for (int step = 0; step < 240; ++step) simulation.step();
    CHECK(counts(simulation) == start);
    const auto height = [&](uint32_t piece) { return simulation.pose_of(piece).position.y; };
    for (uint32_t piece = 1; piece < simulation.piece_count(); ++piece) CHECK(height(piece) > 1.0f);
    const uint32_t held = 1 + 1 + 1 + 8;
    CHECK(simulation.member_of(held) == 4);
    CHECK(simulation.world().fixed(simulation.body_of(held)));
    CHECK(height(held) == doctest::Approx(1.5f));
    CHECK(height(1) == doctest::Approx(1.2f).epsilon(0.005)); // rests on the table

    const auto strike = [&](uint32_t piece) { // hard, from above
        simulation.apply(Hammer{piece, glm::dvec3(simulation.pose_of(piece).position) + glm::dvec3(0.0, 0.2, 0.0),
                                glm::dvec3(0.0, -600.0, 0.0)});
    };
    for (const uint32_t piece : {0u, 1u, 2u, held, held + 1}) strike(piece);
    for (int step = 0; step < 60; ++step) simulation.step();
    const std::map<std::string, size_t> end = counts(simulation);
    CHECK(end.at("table") == 1);
    CHECK(end.at("rigid") == 1);
    CHECK(end.at("whole") > 1);
    CHECK(end.at("held") > 1);
    CHECK(end.at("loose") == 8);
    CHECK(end.at("pinned") == 8);
    simulation.apply(Release{});
    for (int step = 0; step < 60; ++step) simulation.step();
    CHECK(simulation.pose_of(simulation.number_count() > 0 ? held + 9 : 0).position.y < 1.5f); // no longer pinned
}

TEST_CASE("scene: a scene of one object has the state hashes of a recipe of one mesh") {
    FractureOptions one;
    one.mesh = "shape:arch"; // 2 m long, and on the ground: the stage does not change it
    one.material = "stone";
    use_material("stone", one);
    one.rough.amount = 0.0; // as in a recipe
    one.world.breakable = true;
    one.world.height = 0.0;
    const fracture::Fragments whole = break_input(placed_on_stage(load_input(one), one.world), one).fragments;
    const FractureOptions scene = scene_of(R"({"mesh": "shape:arch", "material": "stone"})");
    LoadedScene loaded = load_scene(scene);
    Simulation alone("stone"), in_scene;
    alone.start(whole, world_of(one));
    in_scene.start(prepare_scene(loaded), loaded.world);
    for (Simulation* simulation : {&alone, &in_scene})
        simulation->schedule(10, Shoot{{0.0, 1.2, 3.0}, {0.0, 0.0, -25.0}, 0.15, 7800.0});
    for (int step = 0; step < 120; ++step) {
        REQUIRE(alone.state_hash() == in_scene.state_hash());
        alone.step();
        in_scene.step();
    }
    CHECK(alone.number_count() > 10);
}

TEST_CASE("scene: the room is calm until the first shot, then pane, dishes and wall break, and a replay is equal") {
    const FractureOptions scene = world_file("room_with_a_view");
    LoadedScene loaded = load_scene(scene);
    CHECK(loaded.notes.empty());
    const Folder folder;
    {
        Simulation simulation;
        Recorder recorder(folder / "room.log", scene);
        simulation.observe(&recorder);
        simulation.start(prepare_scene(loaded), loaded.world);
        const std::map<std::string, size_t> before = counts(simulation);
        for (const auto& [name, pieces] : before) CHECK(pieces == 1);
        float speed = 0.0f;
        for (int step = 0; step < 58; ++step) { // the first shot comes after 60
            simulation.step();
            speed = std::max(speed, fastest(simulation.world()));
        }
        CHECK(speed < 0.15f); // m/s: things settle by half a millimetre
        CHECK(counts(simulation) == before);
        while (simulation.steps() < 540) simulation.step();
        const std::map<std::string, size_t> after = counts(simulation);
        for (const char* name : {"window pane", "brick wall", "vase on the table"}) {
            CAPTURE(name);
            CHECK(after.at(name) > 3);
        }
        for (const char* name : {"left wall", "side wall", "sill", "shelf left"}) CHECK(after.at(name) == 1);
        CHECK(after.size() == before.size());
        CHECK(simulation.destruction()->statistics().failed == 0);
        for (const physics::BodyId body : simulation.world().bodies()) // nothing fell through the ground
            CHECK(simulation.world().pose(body).position.y > -0.05f);
        recorder.finish();
    }
    const ReplayLog log = read_replay_log(folder / "room.log");
    CHECK(is_scene(log.recipe));
    for (const uint32_t threads : {1u, 7u}) {
        uint64_t steps = 0;
        CHECK_FALSE(replayed_scene(log, threads, steps));
    }
}

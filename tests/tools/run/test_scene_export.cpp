// Export of a scene's pieces: one GLB file with a root node for each object.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>

#include "fracture/io/atomic_file.h"
#include "fracture/io/export.h"
#include "fracture/io/import.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/mesh/topology.h"
#include "fracture/shapes/shapes.h"
#include "tests/tools/support.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/recipe.h"
#include "tools/scenario/run/broken_scene.h"
#include "tools/scenario/run/scene.h"
#include "tools/scenario/run/state_export.h"

using namespace brittle;
using namespace brittle::tools;
using namespace brittle::tools::test;
using nlohmann::json;

namespace {

struct Run {
    LoadedScene scene;
    Simulation simulation;

    Run(const Folder& folder, const std::string& objects) {
        FractureOptions options;
        read_recipe(folder.write("scene.json", R"({"brittle": 2, "objects": [)" + objects + "]}"), options);
        scene = load_scene(options);
        simulation.start(prepare_scene(scene), scene.world);
    }
    void steps(int count) {
        for (int k = 0; k < count; ++k) simulation.step();
    }
    size_t write(const std::string& file, PiecesAs as, ExportSettings settings = {}) const {
        settings.output = file;
        return write_scene_state(settings, as, scene, simulation);
    }
};

// A floor that is open, a vase, a bonded wall and a turned, mirrored crate on it.
const std::string courtyard = R"(
    {"name": "floor", "mesh": "FLOOR", "fixed": true},
    {"name": "vase", "mesh": "shape:vase", "material": "ceramic", "translation": [0, 0.01, 0], "min_size": 0.02},
    {"name": "wall", "mesh": "shape:cube", "scale": [0.5, 0.5, 0.1], "translation": [2, 0.51, 0], "material": "stone",
     "bonded": true, "pattern": {"type": "uniform", "count": 12}},
    {"name": "crate", "mesh": "shape:cube", "scale": [0.3, -0.2, 0.3], "translation": [-2, 0.21, 0],
     "rotation": [0, 30, 0], "material": "stone"})";

std::string courtyard_in(const Folder& folder) {
    const std::string floor =
        folder.write("floor.obj", "v -4 0 -4\nv 4 0 -4\nv 4 0 4\nv -4 0 4\nf 1 3 2\nf 1 4 3\n").string();
    std::string objects = courtyard;
    return objects.replace(objects.find("FLOOR"), 5, floor);
}

json document_of(const std::string& glb) {
    const std::string bytes = read_text(glb);
    uint32_t size = 0;
    std::memcpy(&size, bytes.data() + 12, 4);
    return json::parse(bytes.substr(20, size));
}

// The object of each piece by the name of its node.
std::map<std::string, std::string> objects_of(const json& document) {
    std::map<std::string, std::string> objects;
    for (const json& root : document["scenes"][0]["nodes"]) {
        const json& node = document["nodes"][root.get<size_t>()];
        CHECK(node["extras"]["brittle"]["object"] == node["name"]);
        if (!node.contains("children")) continue;
        for (const json& child : node["children"])
            objects[document["nodes"][child.get<size_t>()]["name"]] = node["name"];
    }
    return objects;
}

double volume_of(const fracture::TriangleMesh& mesh) {
    return fracture::signed_volume(mesh.positions, mesh.triangles);
}

} // namespace

TEST_CASE("scene export: a scene from which nothing can be written is refused, and leaves the old file") {
    const Folder folder;
    Run run(folder, R"({"mesh": "shape:cube"})");
    folder.write("old.glb", "old");
    CHECK_THROWS_AS(run.write(folder / "missing/x.glb", PiecesAs::made), Failure);
    ExportSettings textured;
    textured.interior_texture = folder / "none.png";
    CHECK_THROWS_AS(run.write(folder / "old.glb", PiecesAs::made, textured), Failure);
    CHECK(read_text(folder / "old.glb") == "old");
    fracture::ObjectExport none;
    CHECK(none.write(folder / "old.glb").error().status == fracture::Status::invalid_setting);
    CHECK(read_text(folder / "old.glb") == "old");
}

TEST_CASE("scene export: before anything moves, the pieces of each object make up its mesh, as made and as they lie") {
    const Folder folder;
    const Run run(folder, courtyard_in(folder));
    for (const PiecesAs as : {PiecesAs::made, PiecesAs::they_lie}) {
        const std::string file = folder / "scene.glb";
        CHECK(run.write(file, as) == 15);
        const json document = document_of(file);
        const auto objects = objects_of(document);
        CHECK(document["scenes"][0]["nodes"].size() == 4);
        CHECK(document["materials"].size() == 6); // crate and wall share theirs
        const fracture::MeshScene written = must(fracture::import_scene(file));
        REQUIRE(written.nodes.size() == 15);
        std::map<std::string, double> volumes;
        std::map<std::string, fracture::Box> boxes;
        for (const fracture::SceneNode& node : written.nodes) {
            const std::string& object = objects.at(node.name);
            const fracture::TriangleMesh& mesh = written.meshes[node.mesh].mesh;
            if (object != "floor") CHECK(fracture::check_topology(mesh.positions.size(), mesh.triangles).closed());
            volumes[object] += volume_of(mesh);
            for (const glm::dvec3& p : mesh.positions) {
                const glm::dvec3 at(node.world * glm::dvec4(p, 1.0));
                fracture::Box& box = boxes.try_emplace(object, fracture::Box{at, at}).first->second;
                box = {glm::min(box.min, at), glm::max(box.max, at)};
            }
        }
        for (const LoadedObject& object : run.scene.objects) {
            const std::string& name = object.object.name;
            CAPTURE(name);
            CHECK(volumes[name] == doctest::Approx(volume_of(object.input->model.mesh)).epsilon(1e-5));
            CHECK(glm::length(boxes[name].min - object.box.min) < 1e-5);
            CHECK(glm::length(boxes[name].max - object.box.max) < 1e-5);
        }
    }
}

TEST_CASE("scene export: after blows each piece lies where its body is, with the bonds that hold, and as hulls") {
    const Folder folder;
    Run run(folder, courtyard_in(folder));
    Simulation& simulation = run.simulation;
    simulation.apply(Shoot{{0.0, 0.2, 2.0}, {0.0, 0.0, -25.0}, 0.05, 7800.0});
    simulation.apply(Shoot{{2.0, 0.7, 2.0}, {0.0, 0.0, -25.0}, 0.1, 7800.0});
    run.steps(90);
    ExportSettings with_hulls;
    with_hulls.hulls = "unreal";
    with_hulls.rigid_bodies = true;
    const std::string file = folder / "scene.glb";
    const size_t pieces = run.write(file, PiecesAs::they_lie, with_hulls);
    CHECK(pieces == simulation.destruction()->pieces().size());
    const json document = document_of(file);
    std::map<std::string, size_t> counts, bonds, hulls;
    for (const auto& [piece, object] : objects_of(document)) ++counts[object];
    CHECK(counts["vase"] > 3);
    CHECK(counts["wall"] >= 12);
    CHECK(counts["floor"] == 1);
    const auto objects = objects_of(document);
    for (const json& node : document["nodes"]) {
        const std::string name = node["name"];
        if (!objects.contains(name)) continue;
        const json& extras = node["extras"]["brittle"];
        const uint32_t number = extras["site"];
        CHECK(simulation.members()[simulation.member_of(number)].name == objects.at(name));
        const physics::Pose pose = simulation.pose_of(number);
        const std::vector<double> at = node["translation"];
        CHECK(glm::length(glm::dvec3(at[0], at[1], at[2]) - glm::dvec3(pose.position)) < 1e-6);
        if (extras.contains("bonds")) bonds[objects.at(name)] += extras["bonds"].size();
        CHECK(node["extensions"]["KHR_physics_rigid_bodies"].contains("motion") == (objects.at(name) != "floor"));
        if (node.contains("children")) hulls[objects.at(name)] += node["children"].size();
    }
    REQUIRE(simulation.structures().size() == 1);
    size_t live = 0;
    for (const physics::BondGraph::Bond& bond : simulation.structures()[0]->graph().bonds())
        live += bond.live() ? 1 : 0;
    CHECK(bonds["wall"] == live);
    CHECK(live > 0);
    CHECK(bonds.size() == 1);
    CHECK(hulls["vase"] >= counts["vase"]);
    CHECK(hulls["floor"] == 0);
}

TEST_CASE("scene export: the rubble of a scene is a level again") {
    const Folder folder;
    Run run(folder, courtyard_in(folder));
    run.simulation.apply(Shoot{{0.0, 0.2, 2.0}, {0.0, 0.0, -25.0}, 0.05, 7800.0});
    run.steps(60);
    const size_t pieces = run.write(folder / "rubble.glb", PiecesAs::they_lie);
    FractureOptions options;
    read_recipe(folder.write("again.json", R"({"brittle": 2, "level": {"mesh": "rubble.glb", "rules": [
        {"node": "floor*", "then": {"fixed": true}}, {"then": {"material": "stone", "breakable": false}}]}})"),
                options);
    LoadedScene again = load_scene(options);
    CHECK(again.notes.empty());
    CHECK(again.objects.size() == pieces);
    for (const LoadedObject& object : again.objects) CHECK(object.object.fixed == (object.object.name == "floor_000"));
}

TEST_CASE("scene export: render and replay write the same pieces") {
    const Folder folder;
    folder.write("scene.json", R"({"brittle": 2, "objects": [)" + courtyard_in(folder) + R"(], "world": {"shots": [
        {"time": 0.1, "from": [0, 0.2, 2], "velocity": [0, 0, -25], "radius": 0.05}]}, "picture": {"frames": 40}})");
    const Outcome rendered = run_brittle(folder, "render " + (folder / "scene.json") + " --size 32x32 --record "
                                                     + (folder / "run.log") + " --export " + (folder / "a.glb"));
    CAPTURE(rendered.output);
    CHECK(rendered.exit_code == exit_success);
    CHECK(rendered.has(" pieces in "));
    const Outcome replayed = run_brittle(folder, "replay " + (folder / "run.log") + " --export " + (folder / "b.glb"));
    CAPTURE(replayed.output);
    CHECK(replayed.exit_code == exit_success);
    CHECK(read_text(folder / "a.glb").size() > 10'000);
    CHECK((read_text(folder / "a.glb") == read_text(folder / "b.glb")));
}

TEST_CASE("scene export: objects, nodes and pieces of files keep their materials, and mirrored ones their normals") {
    const Folder folder;
    // A box with a material for each direction, whose texture coordinates are its places and whose normals are its own.
    fracture::Model box;
    box.mesh = fracture::cuboid({1.0, 0.6, 0.4});
    for (const char* name : {"x", "y", "z"}) {
        box.materials.push_back({.name = name});
        box.materials.back().base_colour = glm::dvec4(0.1 * double(box.materials.size()), 0.5, 0.25, 1.0);
    }
    for (const fracture::Triangle& t : box.mesh.triangles) {
        const auto& at = box.mesh.positions;
        const glm::dvec3 normal = glm::normalize(glm::cross(at[t.y] - at[t.x], at[t.z] - at[t.x]));
        box.material_of.push_back(std::abs(normal.x) > 0.5 ? 0 : (std::abs(normal.y) > 0.5 ? 1 : 2));
        for (int k = 0; k < 3; ++k) {
            box.uv[0].emplace_back(at[t[k]].x, at[t[k]].y + 10.0 * at[t[k]].z);
            box.normals.emplace_back(normal);
        }
    }
    const std::string file = folder / "box.glb";
    must(fracture::export_model(file, box));
    const std::string node = must(fracture::import_scene(file)).nodes.at(0).name;
    // A shape's pieces have no materials of a file. Sheared, mirrored and scaled objects; a fixed one.
    FractureOptions options;
    read_recipe(folder.write("scene.json", R"({"brittle": 2, "objects": [
        {"name": "whole", "mesh": "box.glb", "shattered": true, "pattern": {"type": "uniform", "count": 5}},
        {"name": "node", "mesh": "box.glb", "node": ")"
                                               + node + R"(", "translation": [3, 0, 0],
         "scale": [-2, 1, 0.5], "rotation": [0, 90, 0], "shattered": true, "pattern": {"type": "uniform", "count": 4}},
        {"name": "pieces", "mesh": "box.glb", "in_pieces": true, "translation": [6, 0, 0], "scale": [1, -1, 1]},
        {"name": "sheared", "mesh": "box.glb", "translation": [9, 0, 0], "shear": [0.5, 0, 0]},
        {"name": "fixed", "mesh": "box.glb", "fixed": true, "translation": [12, 0, 0]},
        {"name": "shape", "mesh": "shape:cube", "material": "stone", "translation": [15, 0, 0]}]})"),
                options);
    LoadedScene scene = load_scene(options, {}, nullptr, true);
    Simulation simulation;
    simulation.start(prepare_scene(scene), scene.world);
    const std::string written = folder / "scene.glb";
    ExportSettings settings;
    settings.output = written;
    CHECK(write_scene_state(settings, PiecesAs::made, scene, simulation) > 10);

    const auto objects = objects_of(document_of(written));
    const fracture::MeshScene read = must(fracture::import_scene(written, true));
    CHECK(read.looks.materials.size() < 9);                       // each once: three, and those of Brittle's own
    std::map<std::string, std::map<std::string, size_t>> corners; // by object and material
    for (const fracture::SceneNode& part : read.nodes) {
        const std::string& name = objects.at(part.name);
        CAPTURE(name);
        const LoadedObject& object =
            *std::ranges::find_if(scene.objects, [&](const LoadedObject& one) { return one.object.name == name; });
        const glm::dmat4 to_world = [&] {
            glm::dmat4 world(linear_part(object.object.placement));
            world[3] = glm::dvec4(object.object.placement.translation, 1.0);
            return world;
        }();
        const fracture::Model model = fracture::model_of(read, part.mesh);
        REQUIRE(model.normals.size() == 3 * model.mesh.triangles.size());
        for (size_t t = 0; t < model.mesh.triangles.size(); ++t) {
            const fracture::Material& material = model.materials.at(model.material_of.at(t));
            ++corners[name][material.name];
            if (material.name.size() > 1) continue; // not of the file
            CHECK(material.base_colour.y == 0.5);
            std::array<glm::dvec3, 3> at; // in the box
            for (int k = 0; k < 3; ++k) {
                const glm::dvec4 p(model.mesh.positions[model.mesh.triangles[t][k]], 1.0);
                at[size_t(k)] = glm::dvec3(glm::inverse(to_world) * part.world * p);
            }
            const bool mirrored = glm::determinant(glm::dmat3(to_world)) < 0.0;
            const glm::dvec3 across = (mirrored ? -1.0 : 1.0) * glm::cross(at[1] - at[0], at[2] - at[0]);
            if (!(glm::length(across) > 1e-3)) continue; // a sliver
            const int axis = material.name[0] - 'x';
            CHECK(std::abs(glm::normalize(across)[axis]) > 0.999);
            const glm::dvec3 expected =
                glm::normalize(glm::transpose(glm::inverse(glm::dmat3(to_world))) * glm::normalize(across));
            for (size_t k = 0; k < 3; ++k) {
                const glm::vec2 uv(at[k].x, at[k].y + 10.0 * at[k].z);
                CHECK(glm::distance(model.uv[0][3 * t + k], uv) < 1e-4f);
                const glm::dvec3 normal = glm::dmat3(part.world) * glm::dvec3(model.normals[3 * t + k]);
                CHECK(glm::dot(normal, expected) > 0.999);
            }
        }
    }
    for (const char* name : {"whole", "node", "pieces", "sheared", "fixed"}) {
        CAPTURE(name);
        for (const char* material : {"x", "y", "z"}) CHECK(corners[name][material] >= 4);
    }
    CHECK(corners["whole"]["interior"] > 0);
    CHECK_FALSE(corners["pieces"].contains("interior"));
    CHECK(corners["shape"].size() == 1);
    CHECK(corners["shape"].contains("stone"));
}

TEST_CASE("broken scene: what cannot be broken is written whole, with a note, and other formats are refused") {
    const Folder folder;
    const std::string open = folder.write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 3 2\n").string();
    folder.write("scene.json", R"({"brittle": 2, "objects": [{"name": "rug", "mesh": ")" + open + R"("},
        {"name": "rock", "mesh": "shape:cube", "breakable": false, "translation": [0, 3, 0]},
        {"name": "box", "mesh": "shape:cube", "translation": [3, 0, 0], "pattern": {"type": "uniform", "count": 9}}]})");
    const std::string fracture = "fracture " + folder / "scene.json ";
    for (const auto& [options, refusal] :
         {std::pair("-o " + folder / "x.obj", "--output: a scene is written as one .glb file"),
          std::pair("--per-piece -o " + folder / "x.glb", "--per-piece: a scene"),
          std::pair(std::string("-o - --output-format ply"), "--output-format: a scene is written as glb"),
          std::pair("--classify gpu -o " + folder / "x.glb", "--classify gpu: ")}) {
        const Outcome refused = run_brittle(folder, fracture + options);
        CHECK(refused.exit_code == exit_usage);
        CHECK(refused.has(refusal));
    }
    CHECK_FALSE(std::filesystem::exists(folder.path / "x.glb"));
    CHECK(run_brittle(folder, fracture + "--material glass -o " + folder / "x.glb").has("no effect on a scene"));

    const Outcome made = run_brittle(folder, fracture + "--report " + folder / "r.json -o " + folder / "x.glb");
    CAPTURE(made.output);
    CHECK(made.exit_code == exit_success);
    CHECK(made.has("rug stays whole and fixed"));
    CHECK(made.has("10 of 2 objects, every one closed and oriented; 1 fixed and whole"));
    const json report = json::parse(read_text(folder / "r.json"));
    CHECK(report["pieces"] == 10);
    CHECK(report["closed"] == true);
    CHECK(report["objects"][0] == json{{"name", "rug"}, {"fixed", true}, {"sites", 0}, {"milliseconds", 0.0}});
    CHECK(report["objects"][1]["pieces"] == 1); // rigid
    CHECK(report["objects"][2]["pieces"] == 9);
    CHECK(report["objects"][2]["volume_error"] < 1e-12);
    std::map<std::string, int> pieces;
    for (const auto& [piece, object] : objects_of(document_of(folder / "x.glb"))) ++pieces[object];
    CHECK(pieces == std::map<std::string, int>{{"rug", 1}, {"rock", 1}, {"box", 9}});
}

TEST_CASE("broken scene: an object whose parts pass through each other is named, and one that is united is not") {
    const Folder folder;
    fracture::TriangleMesh mesh = fracture::icosphere(2, 1.0);
    const size_t vertices = mesh.positions.size(), triangles = mesh.triangles.size();
    for (size_t v = 0; v < vertices; ++v) mesh.positions.push_back(mesh.positions[v] + glm::dvec3(0.5, 0.1, 0.2));
    for (size_t t = 0; t < triangles; ++t)
        mesh.triangles.push_back(mesh.triangles[t] + fracture::Triangle(static_cast<uint32_t>(vertices)));
    fracture::Model model;
    model.mesh = mesh;
    const std::string file = folder / "two.glb";
    REQUIRE(fracture::export_model(file, model));
    folder.write("scene.json", R"({"brittle": 2, "objects": [{"name": "two", "mesh": ")" + file + R"("},
        {"name": "one", "mesh": ")" + file
                                   + R"(", "unite": true, "translation": [9, 0, 0]}]})");
    const Outcome made = run_brittle(folder, "fracture " + folder / "scene.json -o " + folder / "x.glb");
    CAPTURE(made.output);
    CHECK(made.exit_code == exit_success);
    CHECK(made.has("object two: its parts pass through each other"));
    CHECK(made.has(R"("unite": true makes one solid of it)"));
    CHECK_FALSE(made.has("object one: its parts"));
}

TEST_CASE("broken scene: each object has the pieces of its mesh alone, at its place, by any number of threads") {
    const Folder folder;
    FractureOptions options;
    read_recipe(folder.write("scene.json", R"({"brittle": 2, "objects": [)" + courtyard_in(folder) + "]}"), options);
    std::vector<uint64_t> hashes;
    std::vector<std::byte> bytes;
    for (const uint32_t threads : {1u, 2u, 7u}) {
        options.threads = threads;
        LoadedScene scene = load_scene(with_cuts(options));
        std::vector<double> shares;
        const std::vector<BrokenObject> objects =
            break_scene(scene, {}, [&](double share) { shares.push_back(share); });
        CHECK(shares == std::vector<double>{0.25, 0.5, 0.75, 1.0});
        CHECK(scene.notes.empty());
        CHECK_FALSE(objects[0].certificate); // the open floor
        std::vector<uint64_t> own;
        for (size_t k = 1; k < objects.size(); ++k) {
            REQUIRE(objects[k].certificate);
            CHECK(objects[k].certificate->closed);
            CHECK(objects[k].certificate->volume_error < 1e-12);
            CHECK(objects[k].certificate->pieces > 3);
            own.push_back(objects[k].certificate->hash);
        }
        fracture::ObjectExport file;
        add_pieces(file, {.hulls = "unreal"}, scene, objects);
        const std::vector<std::byte> written = *file.bytes();
        if (hashes.empty()) {
            hashes = own;
            bytes = written;
        }
        CHECK(own == hashes);
        CHECK(written == bytes);
        Input vase = load_mesh_only("shape:vase");
        SiteSet sites = sites_for(scene.objects[1].object.recipe, vase.model.mesh);
        vase.sites = std::move(sites.sites);
        FractureOptions alone = scene.objects[1].object.recipe;
        alone.world.breakable = false;
        CHECK(break_input(vase, alone).certificate.hash == own[0]);

        must(fracture::write_file_atomically(folder / "pieces.glb", written));
        const auto read = fracture::import_scene(folder / "pieces.glb");
        REQUIRE(read);
        double volume = 0.0;
        fracture::Box crate{glm::dvec3(1e9), glm::dvec3(-1e9)};
        for (const fracture::SceneNode& node : read->nodes) {
            if (node.name.find("crate") == std::string::npos || node.name.find("UCX") != std::string::npos) continue;
            fracture::TriangleMesh mesh = read->meshes[node.mesh].mesh;
            for (glm::dvec3& p : mesh.positions) {
                p = glm::dvec3(node.world * glm::dvec4(p, 1.0));
                crate = {glm::min(crate.min, p), glm::max(crate.max, p)};
            }
            volume += volume_of(mesh);
        }
        CHECK(volume == doctest::Approx(0.6 * 0.4 * 0.6).epsilon(1e-5));
        CHECK(glm::distance(crate.min, scene.objects[3].box.min) < 1e-5);
        CHECK(glm::distance(crate.max, scene.objects[3].box.max) < 1e-5);
    }
}

TEST_CASE("broken scene: standard output has the bytes of the file, and a level is broken node by node") {
    const Folder folder;
    const Run run(folder, courtyard_in(folder));
    run.write(folder / "level.glb", PiecesAs::made);
    const std::string scene = folder
                                  .write("level.json", R"({"brittle": 2, "level": {"mesh": "level.glb",
        "rules": [{"node": "crate*", "then": {"breakable": true, "material": "ceramic",
                   "pattern": {"type": "uniform", "count": 7}}}]}})")
                                  .string();
    const Outcome made = run_brittle(folder, "fracture " + scene + " -o " + folder / "made.glb");
    CAPTURE(made.output);
    CHECK(made.exit_code == exit_success);
    int crate = 0;
    for (const auto& [piece, object] : objects_of(document_of(folder / "made.glb")))
        crate += object.starts_with("crate");
    CHECK(crate == 7);
    for (const char* world : {"balcony", "courtyard", "room_with_a_view", "staircase"}) {
        const Outcome whole = run_brittle(folder, std::string("fracture " BRITTLE_ASSETS "/worlds/") + world
                                                      + ".json -o " + folder / "world.glb" + " --json --quiet");
        CAPTURE(whole.output);
        CHECK(whole.exit_code == exit_success);
        CHECK(json::parse(whole.output)["max_volume_error"] < 1e-9);
    }
    const std::string streamed = BRITTLE_PROGRAM " fracture " + scene + " -o - --quiet >" + folder / "stream.glb";
    CHECK(std::system(streamed.c_str()) == 0);
    CHECK(read_text(folder / "stream.glb") == read_text(folder / "made.glb"));
}

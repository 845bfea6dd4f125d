#include "tools/scenario/recipe/level.h"

#include <string>

#include <doctest/doctest.h>
#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

#include "tests/tools/support.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/recipe.h"

using namespace brittle;
using namespace brittle::tools;
using namespace brittle::tools::test;

namespace {

FractureOptions read_level(const std::string& level, const std::string& more = "") {
    const Folder folder;
    FractureOptions options;
    read_recipe(folder.write("scene.json", R"({"brittle": 2, "level": )" + level + more + "}"), options);
    return options;
}

Level rules(const std::string& list) {
    return read_level(R"({"mesh": "/a.glb", "rules": [)" + list + "]}").level;
}

void check_says(const std::string& level, const std::string& words) {
    std::string message;
    try {
        (void)read_level(level);
    } catch (const Failure& failure) {
        CHECK(failure.code() == exit_input);
        message = failure.what();
    }
    CAPTURE(message);
    CHECK(message.find(words) != std::string::npos);
}

// A file of one mesh with a material, and a node for each name.
fracture::MeshScene file_of(const std::vector<std::string>& names, const std::string& material = "Brick wall") {
    fracture::MeshScene file;
    file.meshes.emplace_back().materials = {"Mortar", material};
    for (const std::string& name : names) file.nodes.emplace_back().name = name;
    return file;
}

std::vector<SceneObject> objects(const Level& level, const fracture::MeshScene& file) {
    return level_objects(level, file, 1.0).objects;
}

} // namespace

TEST_CASE("level: bad values are named by rule and path") {
    check_says("7", "/level");
    check_says("{}", "/level/mesh: expected a .glb or .gltf file");
    check_says(R"({"mesh": "shape:cube"})", "/level/mesh: expected a .glb or .gltf file");
    check_says(R"({"mesh": "a.glb", "node": "x"})", "/level/node: unknown key");
    check_says(R"({"mesh": "a.glb", "scale": 0})", "/level/scale");
    check_says(R"({"mesh": "a.glb", "rules": {}})", "/level/rules: expected a list");
    check_says(R"({"mesh": "a.glb", "rules": [7]})", "/level/rules/0");
    check_says(R"({"mesh": "a.glb", "rules": [{"then": {}}, {"node": "b"}]})",
               "/level/rules/1/then: expected the keys");
    check_says(R"({"mesh": "a.glb", "rules": [{"name": "b", "then": {}}]})", "/level/rules/0/name: unknown key");
    check_says(R"({"mesh": "a.glb", "rules": [{"node": 7, "then": {}}]})", "/level/rules/0/node");
    check_says(R"({"mesh": "a.glb", "rules": [{"extras": [], "then": {}}]})",
               "/level/rules/0/extras: expected an object");
    check_says(R"({"mesh": "a.glb", "rules": [{"then": {"material": "cheese"}}]})",
               "/level/rules/0/then/material: there is no material");
    check_says(R"({"mesh": "a.glb", "rules": [{"then": {"fixed": true, "bonded": true}}]})",
               "/level/rules/0/then/fixed: a fixed object");
    for (const char* key : {"name", "mesh", "node", "translation", "rotation", "shear", "scale"}) // the node's
        check_says(R"({"mesh": "a.glb", "rules": [{"then": {")" + std::string(key) + R"(": 1}}]})",
                   std::string("/level/rules/0/then/") + key + ": unknown key");
}

TEST_CASE("level: writing and reading preserve every value, and a level alone is a scene") {
    const std::string text = R"({"mesh": "/levels/street.glb", "translation": [1, 2, 3], "rotation": [0, 90, 0],
        "shear": [0.5, 0, 0], "scale": [2, 2, -2], "rules": [
            {"node": "Wall*", "material": "Brick?", "extras": {"load": true, "n": [1, {"m": null}]},
             "then": {"material": "brick", "pattern": {"type": "uniform", "count": 33, "seed": 7}, "bonded": true,
                      "min_size": 0.125, "anchors": [{"at": [0, 1, 0], "radius": 0.2}]}},
            {"then": {"fixed": true}}]})";
    const FractureOptions scene = read_level(text);
    CHECK(is_scene(scene));
    CHECK(scene.objects.empty());
    const std::string once = recipe_json(scene);
    FractureOptions again;
    const Folder folder;
    read_recipe(folder.write("scene.json", once), again);
    CHECK(recipe_json(again) == once);
    const auto given = nlohmann::json::parse(text), written = nlohmann::json::parse(once)["level"];
    for (const char* key : {"mesh", "translation", "rotation", "shear", "scale"}) CHECK(written[key] == given[key]);
    for (const auto& entry : given["rules"][0].items()) {
        const std::string key = entry.key();
        if (key != "then") CHECK(written["rules"][0][key] == entry.value());
    }
    for (const auto& entry : given["rules"][0]["then"].items())
        CHECK(written["rules"][0]["then"][entry.key()] == entry.value());
    CHECK(written["rules"][1]["then"]["fixed"] == true);
    // Beside a recipe elsewhere the path goes on leading to the file.
    CHECK(recipe_object(scene, "/levels/recipes")["level"]["mesh"] == "/levels/street.glb");
    FractureOptions beside = scene;
    beside.level.mesh = "street.glb";
    CHECK(recipe_object(beside, std::filesystem::current_path() / "recipes")["level"]["mesh"] == "../street.glb");

    const FractureOptions both = read_level(R"({"mesh": "a.glb"})", R"(, "objects": [{"mesh": "shape:cube"}])");
    CHECK(both.objects.size() == 1);
    CHECK(both.level.mesh.ends_with("a.glb"));
    FractureOptions plain = both; // a recipe of one mesh has no level
    read_recipe(folder.write("one.json", R"({"brittle": 1, "mesh": "shape:cube"})"), plain);
    CHECK_FALSE(is_scene(plain));
}

TEST_CASE("level: the first rule that fits decides, and what none names is fixed and whole") {
    const Level level = rules(R"({"node": "Wall*", "material": "Brick*", "then": {"material": "brick"}},
                                 {"node": "Wall*", "then": {"material": "stone"}},
                                 {"node": "?ase*.0?", "then": {"material": "ceramic"}})");
    const auto material = [&](const std::string& node, const std::string& of_mesh) {
        const std::vector<SceneObject> made = objects(level, file_of({node}, of_mesh));
        REQUIRE(made.size() == 1);
        CHECK(made[0].name == node);
        CHECK(made[0].node == node);
        CHECK(made[0].recipe.mesh == "/a.glb");
        CHECK(made[0].fixed == made[0].recipe.material.empty());
        return made[0].recipe.material;
    };
    CHECK(material("Wall", "Brick") == "brick");
    CHECK(material("Wall.001", "Brick wall") == "brick");
    CHECK(material("Wall.001", "brick") == "stone");
    CHECK(material("A Wall", "Brick") == "");
    CHECK(material("Vase.01", "") == "ceramic");
    CHECK(material("base of vase.01.02", "") == "ceramic");
    CHECK(material("Vase.0", "") == "");
    CHECK(material("ase.01", "") == "");
    CHECK(objects(rules(R"({"then": {"material": "glass"}})"), file_of({""}))[0].recipe.material == "glass");
    CHECK(
        objects(rules(R"({"node": "*a*a*a*a*a*a*a*a*b", "then": {}})"), file_of({std::string(100'000, 'a')}))[0].fixed);
}

TEST_CASE("level: rules match custom properties of the node, or else of its mesh") {
    const Level level = rules(R"({"extras": {"kind": "vase", "n": 2}, "then": {"material": "ceramic"}},
                                 {"extras": {"kind": "pane"}, "then": {"material": "glass"}})");
    const auto material = [&](const std::string& node, const std::string& mesh) {
        fracture::MeshScene file = file_of({"a"});
        file.nodes[0].extras = node;
        file.meshes[0].extras = mesh;
        return objects(level, file)[0].recipe.material;
    };
    CHECK(material("", "") == "");
    CHECK(material(R"({"kind":"vase"})", "") == "");
    CHECK(material(R"({"kind":"vase","n":2.0,"more":[]})", "") == "ceramic");
    CHECK(material(R"({"kind":"vase","n":"2"})", "") == "");
    CHECK(material(R"({"kind":"vase"})", R"({"n":2})") == "ceramic");
    CHECK(material(R"({"kind":"pane"})", R"({"kind":"vase","n":2})") == "glass");
    CHECK(material("[1]", R"({"kind":"pane"})") == "glass");
}

TEST_CASE("level: the property brittle says what a node is, as an object or a text, and a faulty one is noted") {
    const Level level = rules(R"({"then": {"material": "stone"}})");
    fracture::MeshScene file = file_of({"plain", "object", "text", "typo", "damaged", "of mesh"});
    file.nodes[1].extras = R"({"brittle":{"material":"glass","anchored":true}})";
    file.nodes[2].extras = R"({"brittle":"{\"material\": \"ceramic\", \"min_size\": 0.25}"})";
    file.nodes[3].extras = R"({"brittle":{"min-size":0.25}})";
    file.nodes[4].extras = R"({"brittle":"{"})";
    file.meshes.emplace_back().extras = R"({"brittle":{"fixed":true}})";
    file.nodes[5].mesh = 1;
    const LevelObjects made = level_objects(level, file, 1.0);
    REQUIRE(made.objects.size() == 6);
    CHECK(made.objects[0].recipe.material == "stone");
    CHECK(made.objects[1].recipe.material == "glass");
    CHECK(made.objects[1].recipe.world.anchored);
    CHECK(made.objects[2].recipe.material == "ceramic");
    CHECK(made.objects[2].recipe.world.min_size == 0.25);
    for (const size_t k : {3u, 4u, 5u}) {
        CHECK(made.objects[k].fixed);
        CHECK(made.objects[k].recipe.material.empty());
    }
    file.nodes[1].extras = R"({"brittle":{"site":3,"volume":0.5}})"; // a piece that the program exported
    CHECK(objects(level, file)[1].recipe.material == "stone");
    REQUIRE(made.notes.size() == 2);
    CHECK(made.notes[0].find("typo stays whole and fixed: /a.glb: node 'typo': /extras/brittle/min-size: unknown key")
          == 0);
    CHECK(made.notes[1].find("damaged stays whole and fixed: /a.glb: node 'damaged': /extras/brittle: the JSON") == 0);
}

TEST_CASE("level: names that objects of the recipe have get a number, and idle rules are noted") {
    const Level level = rules(R"({"node": "Vase*", "then": {}}, {"node": "Vase 2", "then": {}})");
    const LevelObjects made = level_objects(level, file_of({"Vase", "Vase 2"}), 1.0, {"Vase"});
    CHECK(made.objects[0].name == "Vase 2");
    CHECK(made.objects[0].node == "Vase");
    CHECK(made.objects[1].name == "Vase 2 2");
    REQUIRE(made.notes.size() == 1);
    CHECK(made.notes[0] == "/level/rules/1 decides for no node of /a.glb");
    fracture::MeshScene crowd = file_of({});
    crowd.nodes.resize(max_objects + 1);
    CHECK_THROWS_WITH_AS((void)level_objects(level, crowd, 1.0), doctest::Contains("10001 nodes show meshes"), Failure);
}

TEST_CASE("level: a node stands where its transform, the unit of the file and the level's placement put it") {
    Level level = rules("");
    level.placement = {.translation = {10.0, 0.0, 0.0}, .rotation = {0.0, 90.0, 0.0}, .scale = glm::dvec3(2.0)};
    fracture::MeshScene file = file_of({"a", "flat"});
    glm::dmat4 world = glm::translate(glm::dmat4(1.0), {100.0, 200.0, 300.0}); // cm
    world = glm::scale(glm::rotate(world, 0.7, glm::normalize(glm::dvec3(1.0, 2.0, 3.0))), {1.0, -2.0, 3.0});
    file.nodes[0].world = glm::rotate(world, 0.3, {0.0, 0.0, 1.0}); // sheared, and mirrored
    file.nodes[1].world[1] = glm::dvec4(0.0);
    const LevelObjects made = level_objects(level, file, 0.01);
    REQUIRE(made.objects.size() == 1);
    CHECK(made.notes.at(0).find("flat is left out") == 0);
    const ObjectPlacement& placement = made.objects[0].placement;
    CHECK(placement.shear != glm::dvec3(0.0));
    // The mesh is in metres when it is placed.
    const glm::dvec3 p(0.3, 0.5, 0.7);
    const glm::dvec3 placed = placement.translation + linear_part(placement) * p;
    const glm::dvec3 in_file = 0.01 * glm::dvec3(file.nodes[0].world * glm::dvec4(p / 0.01, 1.0));
    const glm::dvec3 expected = glm::dvec3(10.0, 0.0, 0.0) + 2.0 * glm::dvec3(in_file.z, in_file.y, -in_file.x);
    CHECK(glm::length(placed - expected) < 1e-10);
}

TEST_CASE("level: instances whose scales differ by rounding get one, others keep theirs") {
    fracture::MeshScene file = file_of({"a", "b", "c", "d"});
    file.meshes.emplace_back();
    const double scales[] = {0.7, 0.7 * (1.0 + 3e-7), 0.7 * (1.0 + 3e-6), 0.7 * (1.0 - 3e-7)};
    for (size_t k = 0; k < 4; ++k) file.nodes[k].world = glm::scale(glm::dmat4(1.0), glm::dvec3(scales[k]));
    file.nodes[3].mesh = 1;
    const std::vector<SceneObject> made = objects(rules(""), file);
    CHECK(made[1].placement.scale == made[0].placement.scale);
    CHECK(made[2].placement.scale != made[0].placement.scale);
    CHECK(made[3].placement.scale != made[0].placement.scale); // of another mesh
}

// Recipes of version 2: scenes of several objects.
#include <initializer_list>
#include <set>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/tools/support.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/recipe.h"

using namespace brittle;
using namespace brittle::tools;
using namespace brittle::tools::test;

namespace {

FractureOptions read(const std::string& text) {
    const Folder folder;
    FractureOptions options;
    read_recipe(folder.write("scene.json", text), options);
    return options;
}

// Returns the message of reading a text, or "" if it can be read.
std::string message_of(const std::string& text) {
    try {
        (void)read(text);
    } catch (const Failure& failure) {
        CHECK(failure.code() == exit_input);
        return failure.what();
    }
    return "";
}

void check_says(const std::string& object, const std::string& words) {
    const std::string message = message_of(R"({"brittle": 2, "objects": [)" + object + "]}");
    CAPTURE(message);
    CHECK(message.find(words) != std::string::npos);
}

} // namespace

TEST_CASE("scene recipe: names bring no control characters into messages") {
    const std::string message = Failure(exit_input, "a\x1b[31m.obj\tb\x7f\nc").at("\x1b").what();
    CHECK(message == "\\x1b: a\\x1b[31m.obj\\x09b\\x7f\nc");
}

TEST_CASE("scene recipe: bad values are named by object and path") {
    CHECK(message_of(R"({"brittle": 2})").find("/objects: expected 1 to 10000 objects") != std::string::npos);
    CHECK(message_of(R"({"brittle": 2, "objects": []})").find("/objects") != std::string::npos);
    CHECK(message_of(R"({"brittle": 2, "objects": [{"mesh": "shape:cube"}], "mesh": "a.obj"})").find("/mesh")
          != std::string::npos);
    CHECK(message_of(R"({"brittle": 2, "objects": [{"mesh": "shape:cube"}], "units": "ell"})").find("/units: expected")
          != std::string::npos);
    CHECK(message_of(R"({"brittle": 2, "objects": [{"mesh": "shape:cube"}], "world": {"breakable": true}})")
              .find("/world/breakable")
          != std::string::npos);
    check_says(R"({"name": "a"})", "/objects/0/mesh: expected a mesh file or shape:NAME (object \"a\")");
    check_says(R"({"mesh": "shape:cube", "size": 2})", "/objects/0/size");
    check_says(R"({"mesh": "shape:cube"}, {"name": "b", "mesh": "shape:cube", "rotation": [0, 1]})",
               "/objects/1/rotation");
    check_says(R"({"mesh": "shape:cube", "translation": [0, 1e39, 0]})", "/objects/0/translation/1: expected a number");
    check_says(R"({"mesh": "shape:cube", "shear": [1e39, 0, 0]})", "/objects/0/shear/0: expected a number");
    check_says(R"({"mesh": "shape:cube", "scale": 0})", "/objects/0/scale");
    check_says(R"({"mesh": "shape:cube", "scale": [1, 0, 1]})", "none of which is 0");
    check_says(R"({"mesh": "shape:cube", "material": "cheese"})", "/objects/0/material: there is no material");
    check_says(R"({"mesh": "shape:cube", "pattern": {"kind": "grid"}})", "/objects/0/pattern/kind");
    check_says(R"({"mesh": "shape:cube", "anchors": [{"radius": -1}]})", "/objects/0/anchors/0/radius");
    check_says(R"({"mesh": "shape:cube", "fixed": true, "bonded": true})", "/objects/0/fixed: a fixed object");
    check_says(R"({"mesh": "shape:cube", "fixed": true, "breakable": true})", "/objects/0/fixed: a fixed object");
    check_says(R"({"mesh": "shape:cube", "shattered": true, "anchored": true})", "/objects/0/shattered");
    check_says(R"({"mesh": "shape:cube", "in_pieces": true})", "/objects/0/in_pieces: the pieces are the nodes");
    check_says(R"({"mesh": "a.glb", "in_pieces": 1})", "/objects/0/in_pieces");
    check_says(R"({"mesh": "a.glb", "in_pieces": true, "node": "b"})",
               "/objects/0/in_pieces: the pieces are all nodes");
    check_says(R"({"mesh": "a.glb", "in_pieces": true, "unite": true})", "leave repair, unite and strikes out");
    check_says(R"({"mesh": "a.glb", "in_pieces": true, "contact_tolerance": -1})", "/objects/0/contact_tolerance");
    check_says(R"({"mesh": "a.glb", "contact_tolerance": 0.001})", "/objects/0/contact_tolerance: only pieces");
    check_says(R"({"name": "a", "mesh": "shape:cube"}, {"name": "a", "mesh": "shape:cube"})",
               "there is another object \"a\"");
}

TEST_CASE("scene recipe: bad glue is named by its path") {
    const auto check = [](const std::string& glue, const std::string& words) {
        const std::string message = message_of(
            R"({"brittle": 2, "objects": [{"name": "a", "mesh": "shape:cube", "fixed": true},
                {"name": "b", "mesh": "shape:cube", "bonded": true}, {"name": "c", "mesh": "shape:cube"},
                {"name": "d", "mesh": "shape:cube", "shattered": true},
                {"name": "e", "mesh": "shape:cube", "breakable": false}], "glue": )"
            + glue + "}");
        CAPTURE(message);
        if (words.empty())
            CHECK(message.empty());
        else
            CHECK(message.find(words) != std::string::npos);
    };
    check("[]", "");
    check(R"([{"between": ["a", "b"]}, {"between": ["[abe]", "b"]}])", "/glue/1/between/0: no object has the name");
    check("{}", "/glue: expected a list");
    check("[{}]", "/glue/0/between: expected the names of two objects");
    check(R"([{"between": ["a"]}])", "/glue/0/between");
    check(R"([{"between": ["a", 1]}])", "/glue/0/between");
    check(R"([{"between": ["a", "x*"]}])", "/glue/0/between/1: no object has the name \"x*\"");
    check(R"([{"between": ["a", "b"], "strength": 0}])", "/glue/0/strength");
    check(R"([{"between": ["a", "b"], "tolerance": -1}])", "/glue/0/tolerance");
    check(R"([{"between": ["a", "b"], "power": 1}])", "/glue/0/power");
    check(R"([{"between": ["e", "b"]}])", "");
    check(R"([{"between": ["a", "c"]}])", "");
    check(R"([{"between": ["a", "d"]}])", "/glue/0/between/1: the object 'd' is loose pieces");
    check(R"([{"between": ["?", "b"]}])", "/glue/0/between/0: the object 'd'");
    CHECK(message_of(R"({"brittle": 1, "mesh": "shape:cube", "glue": []})").find("/glue") != std::string::npos);
}

TEST_CASE("scene recipe: patterns of names stand for any text by * and for any byte by ?") {
    CHECK(fits_pattern("", ""));
    CHECK_FALSE(fits_pattern("", "a"));
    CHECK(fits_pattern("*", ""));
    CHECK(fits_pattern("**", "ab"));
    CHECK(fits_pattern("a*c", "abbc"));
    CHECK(fits_pattern("a*b*c", "abcbc"));
    CHECK_FALSE(fits_pattern("a*b", "abc"));
    CHECK(fits_pattern("?b", "ab"));
    CHECK_FALSE(fits_pattern("?", ""));
    CHECK_FALSE(fits_pattern("a?", "a"));
}

TEST_CASE("scene recipe: glue follows the names of objects, and goes with the last object that it fits") {
    const auto objects = [](std::initializer_list<const char*> names) {
        std::vector<SceneObject> all;
        for (const char* name : names) all.emplace_back().name = name;
        return all;
    };
    std::vector<Glue> glue{{"shelf", "wall"}, {"b*", "wall"}, {"nobody", "wall"}};
    follow_objects(glue, objects({"wall", "shelf", "b1", "b2"}), objects({"wall", "board", "b1", "b2"}));
    CHECK(glue == std::vector<Glue>{{"board", "wall"}, {"b*", "wall"}, {"nobody", "wall"}});
    follow_objects(glue, objects({"wall", "board", "b1", "b2"}), objects({"wall", "b2"}));
    CHECK(glue == std::vector<Glue>{{"b*", "wall"}, {"nobody", "wall"}});
    follow_objects(glue, objects({"wall", "b2"}), objects({"b2"}));
    CHECK(glue.empty());
}

TEST_CASE("scene recipe: objects without a name are named by their meshes, and start whole and breakable") {
    const FractureOptions scene = read(
        R"({"brittle": 2, "objects": [{"mesh": "shape:cube"}, {"mesh": "shape:cube"}, {"mesh": "things/vase.obj"},
            {"name": "wall", "mesh": "shape:cube", "fixed": true}, {"name": "x", "mesh": "shape:cube", "breakable": false}]})");
    REQUIRE(scene.objects.size() == 5);
    CHECK(is_scene(scene));
    CHECK(scene.units == LengthUnit::metre);
    CHECK(read(R"({"brittle": 2, "objects": [{"mesh": "shape:cube"}, {"name": "cube", "mesh": "shape:cube"}]})")
              .objects[0]
              .name
          == "cube 2"); // a name that is given comes first
    CHECK(scene.objects[0].name == "cube");
    CHECK(scene.objects[1].name == "cube 2");
    CHECK(scene.objects[2].name == "vase");
    CHECK(scene.objects[2].recipe.mesh.ends_with("things/vase.obj"));
    CHECK(starts_whole(scene.objects[0].recipe.world));
    CHECK(scene.objects[3].fixed);
    CHECK_FALSE(scene.objects[4].recipe.world.breakable);
}

TEST_CASE("scene recipe: writing and reading preserve every value") {
    const std::string text = R"({"brittle": 2, "units": "cm", "objects": [
        {"name": "vase", "mesh": "/meshes/shop.glb", "material": "ceramic", "repair": true, "unite": true,
         "pattern": {"type": "uniform", "count": 33, "seed": 7}, "min_volume": 0.25, "roughness": 0.3,
         "translation": [1, 2, 0.3333333333333333], "rotation": [10, 20, 30], "scale": [1, 2, -3],
         "node": "Vase.001", "shear": [0.5, 0, -0.25],
         "bonded": true, "anchored": true, "strength": 0.5, "min_size": 0.125, "blow_pieces": 30,
         "brick": {"size": [0.3, 0.05, 0.1], "along": "z"}, "anchors": [{"at": [0, 1, 0], "radius": 0.2}]},
        {"name": "floor", "mesh": "/meshes/set.glb", "in_pieces": true, "contact_tolerance": 0.002, "bonded": true},
        {"name": "heap", "mesh": "shape:cube", "shattered": true, "breakable": false}],
        "glue": [{"between": ["v*", "floor"]}, {"between": ["floor", "floor"], "strength": 0.5, "tolerance": 0.002}],
        "world": {"physics": "bullet", "air_density": 0.5, "max_colliding": 70, "piece_limit": 900,
                  "shots": [{"time": 1, "from": [0, 1, 4], "velocity": [0, 0, -12], "radius": 0.1, "density": 7800}]},
        "picture": {"frames": 7, "azimuth": 90}})";
    const std::string once = recipe_json(read(text));
    CHECK(recipe_json(read(once)) == once);
    const auto given = nlohmann::json::parse(text), written = nlohmann::json::parse(once);
    for (const auto& [key, value] : given.items())
        if (key != "objects") CHECK(written[key] == value);
    for (size_t k = 0; k < 3; ++k)
        for (const auto& entry : given["objects"][k].items()) {
            const std::string key = entry.key();
            CAPTURE(key);
            CHECK(written["objects"][k][key] == entry.value());
        }
}

TEST_CASE("scene recipe: the schema lists exactly the keys of objects") {
    const auto schema = nlohmann::json::parse(read_text(BRITTLE_ASSETS "/scene.schema.json"));
    const auto& keys = schema["properties"]["objects"]["items"]["properties"];
    for (const auto& entry : keys.items()) {
        const std::string key = entry.key();
        if (key == "strikes" || key == "algorithm" || key == "rough_size" || key == "grain" || key == "detail")
            continue;
        CAPTURE(key);
        const std::string message =
            message_of(R"({"brittle": 2, "objects": [{"mesh": "shape:cube", ")" + key + R"(": null}]})");
        CHECK(message.find("unknown") == std::string::npos); // a bad value, but a known key
        CHECK(message.find(key) != std::string::npos);
    }
    for (const char* key : {"name",        "mesh",        "node",
                            "shear",       "translation", "rotation",
                            "scale",       "in_pieces",   "contact_tolerance",
                            "fixed",       "shattered",   "material",
                            "repair",      "unite",       "pattern",
                            "strikes",     "algorithm",   "min_volume",
                            "roughness",   "rough_size",  "grain",
                            "detail",      "bonded",      "anchored",
                            "strength",    "breakable",   "min_size",
                            "blow_pieces", "brick",       "anchors"})
        CHECK(keys.contains(key));
}

TEST_CASE("scene recipe: the schema lists exactly the keys of a level, of its rules and of what they make of nodes") {
    const auto schema = nlohmann::json::parse(read_text(BRITTLE_ASSETS "/scene.schema.json"))["properties"];
    const auto& level = schema["level"]["properties"];
    const auto& rule = level["rules"]["items"]["properties"];
    const auto& then = rule["then"]["properties"];
    const auto check_known = [&](const nlohmann::json& keys, const std::string& before, const std::string& behind) {
        for (const auto& entry : keys.items()) {
            const std::string key = entry.key();
            CAPTURE(key);
            const std::string message =
                message_of(R"({"brittle": 2, "level": )" + before + "\"" + key + R"(": [[]])" + behind + "}");
            CHECK(message.find("unknown") == std::string::npos); // a bad value, but a known key
            CHECK(message.find("/" + key) != std::string::npos);
        }
    };
    auto others = level;
    others.erase("mesh");
    CHECK(message_of(R"({"brittle": 2, "level": {"mesh": 7}})").find("/level/mesh") != std::string::npos);
    check_known(others, R"({"mesh": "a.glb", )", "}");
    check_known(rule, R"({"mesh": "a.glb", "rules": [{)", "}]}");
    check_known(then, R"({"mesh": "a.glb", "rules": [{"then": {)", "}}]}");
    std::set<std::string> missing; // what an object has, and a rule cannot say
    for (const auto& entry : schema["objects"]["items"]["properties"].items())
        if (!then.contains(entry.key())) missing.insert(entry.key());
    CHECK(missing
          == std::set<std::string>{"name", "mesh", "node", "in_pieces", "contact_tolerance", "translation", "rotation",
                                   "shear", "scale"});
    CHECK(message_of(R"({"brittle": 2, "level": {"mesh": "a.glb", "size": 1}})")
              .find("keys are: mesh, translation, "
                    "rotation, shear, scale, rules")
          != std::string::npos);
    CHECK(level.size() == 6);
    CHECK(rule.size() == 4);
}

TEST_CASE("scene recipe: units of a single mesh are written where they do not fit it to the stage") {
    const FractureOptions options = read(R"({"brittle": 1, "mesh": "shape:cube", "units": "mm"})");
    CHECK(options.units == LengthUnit::millimetre);
    CHECK(nlohmann::json::parse(recipe_json(options))["units"] == "mm");
    CHECK_FALSE(nlohmann::json::parse(recipe_json(read(R"({"brittle": 1, "mesh": "shape:cube"})"))).contains("units"));
}

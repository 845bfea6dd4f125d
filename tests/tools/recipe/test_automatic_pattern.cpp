#include <doctest/doctest.h>

#include <string>

#include <nlohmann/json.hpp>

#include "fracture/mesh/mesh.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/pattern.h"
#include "tools/scenario/recipe/automatic_pattern.h"
#include "tools/scenario/recipe/recipe.h"
#include "tools/scenario/run/scene.h"

using namespace brittle;
using namespace brittle::tools;

namespace {

fracture::Pattern chosen(const fracture::TriangleMesh& mesh, const char* material, double scale = 1.0) {
    const physics::MaterialPreset& preset = *physics::material_preset(material);
    return automatic_pattern({.scale = scale}, preset.pattern, mesh, preset.material);
}

fracture::TriangleMesh box(const glm::dvec3& size) {
    fracture::TriangleMesh mesh = fracture::cube(); // 2 m
    for (glm::dvec3& p : mesh.positions) p *= 0.5 * size;
    return mesh;
}

} // namespace

TEST_CASE("automatic pattern: pieces of stone are 0.2 m, whatever the size of the mesh") {
    CHECK(chosen(box({1, 1, 1}), "stone").count == 125);
    CHECK(chosen(box({1, 1, 2}), "stone").count == 250);
    CHECK(chosen(box({1, 1, 1}), "stone", 0.5).count == 1000);
}

TEST_CASE("automatic pattern: pieces of a plate are as thick as it") {
    // Nearly: the rim belongs to the area.
    CHECK(chosen(box({4, 4, 0.01}), "stone").count == doctest::Approx(16 / 0.04).epsilon(0.02));
    CHECK(chosen(box({4, 4, 0.02}), "stone").count == doctest::Approx(16 / 0.04).epsilon(0.02));
}

TEST_CASE("automatic pattern: an object has 8 to 1,000 pieces") {
    CHECK(chosen(box({0.01, 0.01, 0.01}), "stone").count == 8);
    CHECK(chosen(box({100, 100, 100}), "stone").count == 1000);
    CHECK(chosen(fracture::TriangleMesh{}, "stone").count == 8);
}

TEST_CASE("automatic pattern: tougher and lighter stuff breaks into larger pieces, in its own arrangement") {
    const fracture::TriangleMesh block = box({1, 1, 1});
    CHECK(chosen(block, "glass").count > chosen(block, "stone").count);
    CHECK(chosen(block, "stone").count > chosen(block, "wood").count);
    CHECK(chosen(block, "glass").kind == fracture::PatternKind::radial);
    CHECK(chosen(block, "wood").kind == fracture::PatternKind::splinters);
    CHECK(chosen(block, "brick").kind == fracture::PatternKind::bricks);
    CHECK(chosen(block, "stone").kind == fracture::PatternKind::thickness);
}

TEST_CASE("automatic pattern: seeds of names differ, and are those of FNV-1a") {
    CHECK(seed_of_name("") == 0xcbf29ce484222325);
    CHECK(seed_of_name("a") == 0xaf63dc4c8601ec8c);
    CHECK(seed_of_name("foobar") == 0x85944171f73967e8);
}

TEST_CASE("automatic pattern: scenes use it where an object is cut at the start and names no pattern") {
    FractureOptions scene;
    read_recipe("scene.json", nlohmann::ordered_json::parse(R"({"brittle": 2, "piece_scale": 0.5, "objects": [
        {"name": "first", "mesh": "shape:cube", "material": "stone", "shattered": true, "scale": 0.5},
        {"name": "second", "mesh": "shape:cube", "material": "stone", "shattered": true, "scale": 0.5},
        {"name": "seeded", "mesh": "shape:cube", "material": "stone", "bonded": true, "scale": 0.5,
         "pattern": {"type": "automatic", "scale": 2, "seed": 7}},
        {"name": "chosen", "mesh": "shape:cube", "shattered": true, "pattern": {"type": "uniform", "count": 3}},
        {"name": "whole", "mesh": "shape:cube"}]})"),
                "", scene);
    CHECK(scene.objects[0].recipe.automatic == AutomaticPattern{});
    CHECK(scene.objects[2].recipe.automatic == AutomaticPattern{.scale = 2.0, .named_seed = false});
    CHECK(scene.objects[2].recipe.pattern.seed == 7);
    CHECK_FALSE(scene.objects[3].recipe.automatic.has_value());
    CHECK_FALSE(scene.objects[4].recipe.automatic.has_value());

    // Writing and reading change nothing.
    FractureOptions again;
    const std::string text = recipe_json(scene);
    read_recipe("scene.json", nlohmann::ordered_json::parse(text), "", again);
    CHECK(recipe_json(again) == text);
    CHECK(again.objects[2].recipe.automatic == scene.objects[2].recipe.automatic);

    const LoadedScene loaded = load_scene(scene);
    CHECK(loaded.objects[0].input->sites.size() == 1000); // 1 m^3 in pieces of 0.1 m
    CHECK(loaded.objects[2].input->sites.size() == 125);
    CHECK(loaded.objects[3].input->sites.size() == 3);
    CHECK(loaded.objects[4].input->sites.empty());
    CHECK(loaded.objects[0].input->sites != loaded.objects[1].input->sites); // other names
    const LoadedScene repeated = load_scene(again);
    CHECK(loaded.objects[0].input->sites == repeated.objects[0].input->sites);
}

TEST_CASE("automatic pattern: bad values are refused by their path") {
    FractureOptions scene;
    const auto refusal = [&](const char* text) -> std::string {
        try {
            read_recipe("scene.json", nlohmann::ordered_json::parse(text), "", scene);
        } catch (const std::exception& failure) {
            return failure.what();
        }
        return "";
    };
    CHECK(refusal(R"({"brittle": 2, "piece_scale": 0, "objects": [{"mesh": "shape:cube"}]})").find("/piece_scale")
          != std::string::npos);
    CHECK(refusal(R"({"brittle": 2, "objects": [{"mesh": "shape:cube", "shattered": true,
        "pattern": {"type": "automatic", "scale": -1}}]})")
              .find("/objects/0/pattern/scale")
          != std::string::npos);
    CHECK(refusal(R"({"brittle": 2, "objects": [{"mesh": "shape:cube", "shattered": true,
        "pattern": {"type": "automatic", "count": 5}}]})")
              .find("/objects/0/pattern/count")
          != std::string::npos);
}

#include "tests/tools/support.h"
#include "tools/scenario/recipe/recipe.h"

#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "fracture/shapes/shapes.h"
#include "physics/material.h"
#include "tools/scenario/base/failure.h"

using namespace brittle;
using namespace brittle::tools;
using namespace brittle::tools::test;
namespace fs = std::filesystem;

namespace {

// Returns the message of reading a text, or "" if it can be read.
std::string message_of(const std::string& text) {
    const Folder folder;
    FractureOptions options;
    try {
        read_recipe(folder.write("recipe.json", text), options);
    } catch (const Failure& failure) {
        CHECK(failure.code() == exit_input);
        CHECK(std::string(failure.what()).find("recipe.json: ") != std::string::npos);
        return failure.what();
    }
    return "";
}

bool says(const std::string& text, const std::string& words) {
    const std::string message = message_of(text);
    CAPTURE(message);
    const bool found = message.find(words) != std::string::npos;
    CHECK(found);
    return found;
}

FractureOptions everything() {
    FractureOptions options;
    options.mesh = "shape:torus";
    options.units = LengthUnit::inch;
    options.repair = true;
    options.unite = true;
    options.algorithm = fracture::Algorithm::sequential;
    options.min_volume = 0.25;
    options.rough = {.amount = 1.0 / 3.0, .wavelength = 0.1, .grain = {0.0, 1.0 / 7.0, 3.0}, .detail = 5};
    options.material = "wood";
    options.pattern = {.kind = fracture::PatternKind::curve,
                       .count = 33,
                       .piece_size = 0.5,
                       .seed = 18446744073709551615u,
                       .jitter = 0.1,
                       .focus = {0.1, 0.2, 0.3},
                       .axis = {0.0, 0.6, 0.8},
                       .spread = 0.7,
                       .slenderness = 3.5,
                       .line = {{0.0, 0.0, 0.0}, {1.0, 0.3, 1.0 / 3.0}, {1.0, 1.0, 1.0}},
                       .grading = 0.75,
                       .cells_per_piece = 16,
                       .inside = true};
    options.world = {.engine = physics::EngineKind::bullet,
                     .bonded = true,
                     .anchored = true,
                     .height = 1.5,
                     .air_density = 0.3,
                     .max_colliding = 700,
                     .strength = 0.25,
                     .breakable = true,
                     .min_size = 0.125,
                     .blow_pieces = 30,
                     .bond = {.brick = {0.3, 0.05, 1.0 / 3.0}, .along = 2},
                     .piece_limit = 900,
                     .anchors = {{{0.5, 1.0, 1.0 / 3.0}, 0.25}, {}},
                     .shots = {{0.25, {1, 2, 3}, {4, 5, 6}, 0.5, 1000.0}, {}},
                     .joints = {{.kind = physics::JointKind::distance,
                                 .shot = 1,
                                 .at = {0, 1, 0},
                                 .to_piece = true,
                                 .to = {0, 3, 1.0 / 3.0},
                                 .axis = {1, 0, 0},
                                 .min_length = 0.5,
                                 .max_length = 2.5,
                                 .max_force = 1e4,
                                 .link_radius = 0.02},
                                {.kind = physics::JointKind::hinge, .at = {1, 1, 1}},
                                {.kind = physics::JointKind::fixed, .at = {1, 0, 1}, .max_torque = 20.0},
                                {.to = {0, 1, 0}, .links = 7}}};
    options.strikes = {{{0.1, 0.2, 1.0 / 3.0}, {0.0, 1.0, 0.0}, 0.25, 9}, {}};
    options.picture = {.every = 4,
                       .width = 640,
                       .height = 480,
                       .quality = "fast",
                       .frames = 7,
                       .whole = true,
                       .planes = 2,
                       .explode = 0.5f,
                       .dust = 0.25f,
                       .sites = true,
                       .hulls = true,
                       .colours = PieceColours::pieces,
                       .interior_texture = "/images/cut.png",
                       .smooth = true,
                       .wireframe = true,
                       .cells = true,
                       .azimuth = 90.0f,
                       .elevation = -5.0f,
                       .distance = 2.0f};
    options.exports = {.name = "column \"7\"",
                       .per_piece = true,
                       .hulls = "unreal",
                       .rigid_bodies = true,
                       .hull_parts = 3,
                       .density = 1.0 / 3.0,
                       .interior_texture = "/images/inside.png",
                       .as = "made"};
    return options;
}

// Sites from a file, with a placement.
FractureOptions points() {
    FractureOptions options;
    options.mesh = "shape:cube";
    options.sites_file = "/sites/fan.txt";
    options.fit_sites = true;
    options.pattern.seed = 77;
    options.sites_placement = {.turn = {10.0, -20.0, 1.0 / 3.0}, .scale = 0.5, .move = {0.0, 1e-3, 2.0}};
    return options;
}

// Sites listed in the recipe.
FractureOptions listed() {
    FractureOptions options;
    options.mesh = "shape:cube";
    options.points = {{{0.1, -0.2, 1.0 / 3.0}}, {{1e-300, 5e-324, -0.0}}, {{0.5, 0.5, 0.5}}};
    return options;
}
FractureOptions weighted() {
    FractureOptions options = listed();
    options.points[0].weight = 1.0 / 3.0;
    options.points[2].weight = -0.25;
    return options;
}
FractureOptions grouped() {
    FractureOptions options = weighted();
    options.points[0].group = options.points[2].group = 1'000'000;
    return options;
}

} // namespace

TEST_CASE("recipe: writing and reading preserve every value to the bit") {
    const Folder folder;
    const auto check = [&](const FractureOptions& options) {
        FractureOptions again;
        read_recipe(folder.write("recipe.json", recipe_json(options)), again);
        CHECK((again.points == options.points || !options.strikes.empty()));
        CHECK(recipe_json(again) == recipe_json(options));
        write_recipe(folder.path / "saved.json", options);
        FractureOptions saved;
        read_recipe(folder.path / "saved.json", saved);
        CHECK(recipe_json(saved) == recipe_json(options));
    };
    const FractureOptions plain; // GCC 12 misfires on a temporary one (-Wmaybe-uninitialized)
    check(plain);
    check(everything());
    check(points());
    check(listed());
    check(weighted());
    check(grouped());
}

TEST_CASE("recipe: values that differ from the material's pattern are written, even if they are the plain defaults") {
    const Folder folder;
    FractureOptions options;
    use_material("glass", options);
    REQUIRE(options.pattern.axis != fracture::Pattern{}.axis);
    options.pattern.axis = fracture::Pattern{}.axis;
    FractureOptions again;
    read_recipe(folder.write("recipe.json", recipe_json(options)), again);
    CHECK(again.pattern.axis == options.pattern.axis);
    CHECK(again.pattern.jitter == options.pattern.jitter);
}

TEST_CASE("recipe: options that it does not mention stay") {
    const Folder folder;
    FractureOptions options = everything();
    read_recipe(folder.write("recipe.json", R"({"brittle": 1, "pattern": {"type": "grid"}})"), options);
    CHECK(options.pattern.kind == fracture::PatternKind::grid);
    CHECK(options.pattern.count == 33);
    CHECK(options.mesh == "shape:torus");
}

TEST_CASE("recipe: a material sets the pattern, and the pattern's own keys override it") {
    const Folder folder;
    for (const physics::MaterialPreset& preset : physics::material_presets()) {
        FractureOptions options;
        read_recipe(folder.write("recipe.json", R"({"brittle": 1, "material": ")" + std::string(preset.name) + "\"}"),
                    options);
        CHECK(options.pattern.kind == preset.pattern.kind);
        CHECK(fracture::make_sites(options.pattern, fracture::cube()));
        read_recipe(folder.write("recipe.json", R"({"brittle": 1, "pattern": {"type": "grid"}, "material": ")"
                                                    + std::string(preset.name) + "\"}"),
                    options);
        CHECK(options.pattern.kind == fracture::PatternKind::grid);
        CHECK(options.material == preset.name);
    }
    says(R"({"brittle": 1, "material": "cheese"})",
         "/material: there is no material 'cheese'; the materials are: glass, stone");
}

TEST_CASE("recipe: a material brings grain and detail, and its roughness where it is chosen by hand") {
    const Folder folder;
    for (const physics::MaterialPreset& preset : physics::material_presets()) {
        const std::string material(preset.name);
        FractureOptions chosen;
        chosen.rough.wavelength = 0.5;
        use_material(material, chosen);
        CHECK(chosen.rough.amount == preset.rough.amount);
        CHECK(chosen.rough.grain == preset.rough.grain);
        CHECK(chosen.rough.detail == preset.rough.detail);
        CHECK(chosen.rough.wavelength == 0.5);
        // Recipes written before roughness was there keep their flat cuts.
        FractureOptions read;
        read.rough.amount = 0.5;
        read_recipe(folder.write("recipe.json", R"({"brittle": 1, "material": ")" + material + "\"}"), read);
        CHECK(read.rough.is_flat());
        CHECK(read.rough.detail == preset.rough.detail);
        read_recipe(
            folder.write("recipe.json", R"({"brittle": 1, "roughness": 0.25, "material": ")" + material + "\"}"), read);
        CHECK(read.rough.amount == 0.25);
        const auto json = nlohmann::json::parse(recipe_json(read));
        CHECK(json["roughness"] == 0.25);
        CHECK_FALSE(json.contains("detail"));
        CHECK_FALSE(json.contains("grain"));
    }
}

TEST_CASE("recipe: the grain of wood lies along the pattern's axis unless it is given") {
    const Folder folder;
    const auto read = [&](const std::string& keys) {
        FractureOptions options;
        read_recipe(folder.write("recipe.json", R"({"brittle": 1, "material": "wood")" + keys + "}"), options);
        return options;
    };
    const auto along_x = read(R"(, "pattern": {"axis": [2, 0, 0]})");
    CHECK(along_x.rough.grain == glm::dvec3(4.0, 0.0, 0.0));
    CHECK_FALSE(nlohmann::json::parse(recipe_json(along_x)).contains("grain"));
    const auto given = read(R"(, "pattern": {"axis": [2, 0, 0]}, "grain": [0, 0, 2])");
    CHECK(given.rough.grain == glm::dvec3(0.0, 0.0, 2.0));
    CHECK(read(R"(, "grain": [0, 0, 0])").rough.grain == glm::dvec3(0.0));
    // A recipe with sites of its own holds no axis.
    FractureOptions sites = along_x;
    sites.points = {{{0.0, 0.0, 0.0}}, {{1.0, 0.0, 0.0}}};
    for (const FractureOptions& options : {along_x, given, read(R"(, "grain": [0, 0, 0])"), sites}) {
        FractureOptions again;
        read_recipe(folder.write("recipe.json", recipe_json(options)), again);
        CHECK(again.rough.grain == options.rough.grain);
    }
}

TEST_CASE("recipe: blows have the roughness of the recipe, with its seed, in metres of the stage") {
    FractureOptions options = everything();
    options.strikes.clear();
    const fracture::Roughness blows = world_of(options, 4.0).rough;
    CHECK(blows.amount == options.rough.amount);
    CHECK(blows.wavelength == 4.0 * options.rough.wavelength);
    CHECK(blows.grain == options.rough.grain);
    CHECK(blows.detail == options.rough.detail);
    CHECK(blows.seed == options.pattern.seed);
    CHECK(roughness_of(options).wavelength == options.rough.wavelength);
}

TEST_CASE("recipe: listed sites replace the pattern, and another pattern removes them") {
    const Folder folder;
    FractureOptions options = points();
    read_recipe(folder.write("recipe.json", recipe_json(listed())), options);
    CHECK(options.sites_file.empty());
    const SiteSet set = sites_for(options, fracture::cube());
    REQUIRE(set.sites.size() == 3);
    for (size_t s = 0; s < 3; ++s) CHECK(set.sites[s] == listed().points[s].at);
    CHECK(set.weights.empty());
    CHECK(set.groups.empty());
    read_recipe(folder.write("recipe.json", R"({"brittle": 1, "pattern": {"type": "uniform", "count": 7}})"), options);
    CHECK(options.points.empty());
    CHECK(sites_for(options, fracture::cube()).sites.size() == 7);
}

TEST_CASE("recipe: listed sites have weights and groups, and a site alone in its group has number 0") {
    CHECK(sites_for(weighted(), fracture::cube()).weights == std::vector{1.0 / 3.0, 0.0, -0.25});
    CHECK(sites_for(weighted(), fracture::cube()).groups.empty());
    const std::vector<uint32_t> groups = sites_for(grouped(), fracture::cube()).groups;
    REQUIRE(groups.size() == 3);
    CHECK(groups[0] == groups[2]);
    CHECK(groups[0] != groups[1]);
    FractureOptions alone = listed();
    alone.points[1].group = 5;
    CHECK(sites_for(alone, fracture::cube()).groups.empty());
    // Written and read again.
    const SiteSet set{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, {9, 4, 9, 7}, {0.0, 1.0, 0.0, 2.0}};
    const std::vector<PlacedSite> placed = placed_sites(set);
    REQUIRE(placed.size() == 4);
    CHECK(placed[0].group == placed[2].group);
    CHECK(placed[0].group > 0);
    CHECK(placed[1].group == 0);
    CHECK(placed[3].group == 0);
    FractureOptions again = listed();
    again.points = placed;
    CHECK(sites_for(again, fracture::cube()).sites == set.sites);
    CHECK(sites_for(again, fracture::cube()).weights == set.weights);
    CHECK(placed_sites({}).empty());
}

TEST_CASE("recipe: cells of one group make one piece, and a heavier site gets a larger cell") {
    FractureOptions options;
    options.mesh = "shape:cube";
    options.points = {{{-0.5, 0.0, 0.0}}, {{0.0, 0.0, 0.0}}, {{0.5, 0.0, 0.0}}};
    const auto volumes = [&] { // in order of position along x
        std::map<double, double> at;
        const Broken broken = break_input(load_input(options), options);
        CHECK(broken.certificate.closed);
        for (const fracture::Piece& piece : broken.fragments.pieces)
            at[piece.mass.centre_of_mass.x] = piece.mass.volume;
        std::vector<double> in_order;
        for (const auto& [x, volume] : at) in_order.push_back(volume);
        return in_order;
    };
    const std::vector<double> plain = volumes();
    REQUIRE(plain.size() == 3);
    const double area = 2.0 * plain[1]; // area of a section; the middle piece is half a metre thick
    options.points[1].weight = 0.1;     // moves both bisectors of the site by w / 2 d
    const std::vector<double> heavy = volumes();
    REQUIRE(heavy.size() == 3);
    CHECK(heavy[1] - plain[1] == doctest::Approx(2.0 * area * 0.1 / (2.0 * 0.5)).epsilon(1e-9));
    options.points[1].weight = 0.0;
    options.points[0].group = options.points[1].group = 3;
    const std::vector<double> joined = volumes();
    REQUIRE(joined.size() == 2);
    CHECK(joined[0] == doctest::Approx(plain[0] + plain[1]).epsilon(1e-12));
}

TEST_CASE("recipe: weights and groups that do not match the sites are refused") {
    const auto with = [](const std::string& more) {
        return R"({"brittle": 1, "mesh": "shape:cube", "pattern": {"type": "points", "sites": [[0, 0, 0], [1, 0, 0]], )"
               + more + "}}";
    };
    says(with(R"("weights": [1])"), "/pattern/weights: expected a list of 2 values, one per site");
    says(with(R"("weights": [1, "much"])"), "/pattern/weights/1: expected a number");
    says(with(R"("weights": [1, 1e300])"), "/pattern/weights/1: expected a number");
    says(with(R"("groups": 3)"), "/pattern/groups: expected a list of 2 values, one per site");
    says(with(R"("groups": [0, -1])"), "/pattern/groups/1: expected a whole number");
    says(with(R"("groups": [0, 1000001])"), "/pattern/groups/1: expected a whole number");
}

TEST_CASE("recipe: $schema is any text, and is not kept") {
    const Folder folder;
    FractureOptions options;
    read_recipe(folder.write("recipe.json", R"({"$schema": "../recipe.schema.json", "brittle": 1, "mesh": "a.obj"})"),
                options);
    CHECK(recipe_json(options).find("schema") == std::string::npos);
    says(R"({"$schema": 7, "brittle": 1})", "/$schema: expected text");
    for (const char* name : {"recipe", "scene", "profile", "replay"}) {
        const auto schema = nlohmann::json::parse(read_text(BRITTLE_ASSETS "/" + std::string(name) + ".schema.json"));
        // References between the files count from it.
        CHECK(schema["$id"] == "https://brittle.invalid/schema/" + std::string(name) + ".schema.json");
    }
}

TEST_CASE("recipe: relative paths count from the recipe's folder") {
    const Folder folder;
    FractureOptions options;
    const std::string text =
        R"({"brittle": 1, "mesh": "meshes/a.obj", "pattern": {"type": "points", "file": "../sites.txt"}})";
    read_recipe(folder.write("recipe.json", text), options);
    CHECK(options.mesh == (folder.path / "meshes/a.obj").string());
    CHECK(options.sites_file == (folder.path.parent_path() / "sites.txt").string());
    options.mesh = fs::proximate(folder.path / "b.obj").string();
    write_recipe(folder.path / "saved.json", options);
    const auto json = nlohmann::json::parse(std::ifstream(folder.path / "saved.json"));
    CHECK(json["mesh"] == "b.obj");
}

TEST_CASE("recipe: an unknown key or a bad value is named by its path, with what was expected") {
    says(R"({"brittle": 1, "pattern": {"cuont": 4}})", "/pattern/cuont: unknown key; the keys are: type, count");
    says(R"({"brittle": 1, "mseh": ""})", "/mseh: unknown key");
    says(R"({"brittle": 1, "pattern": {"count": 0}})",
         "/pattern/count: expected a whole number from 1 to 1000000, found 0");
    says(R"({"brittle": 1, "pattern": {"count": 2.5}})", "found 2.5");
    says(R"({"brittle": 1, "pattern": {"seed": -1}})", "/pattern/seed: expected a whole number from 0");
    says(R"({"brittle": 1, "pattern": {"jitter": "lots"}})",
         "/pattern/jitter: expected a number from 0.0 to 1.0, found \"lots\"");
    says(R"({"brittle": 1, "pattern": {"focus": [1, 2]}})", "/pattern/focus: expected three numbers");
    says(R"({"brittle": 1, "pattern": {"line": [[0, 0, 0], [1, "x", 0]]}})", "/pattern/line/1: expected three numbers");
    says(R"({"brittle": 1, "pattern": {"type": "glass"}})", "there is no pattern \"glass\"; the patterns are: uniform");
    says(R"({"brittle": 1, "pattern": {"type": "points"}})", "/pattern/file: a pattern of points needs");
    says(R"({"brittle": 1, "pattern": {"type": "points", "file": "a", "sites": [[0, 0, 0]]}})",
         "/pattern/file: a pattern of points needs");
    says(R"({"brittle": 1, "pattern": {"type": "points", "sites": []}})", "/pattern/sites: expected 1 to 10000 points");
    says(R"({"brittle": 1, "pattern": {"type": "points", "sites": [[0, 0, 0], [0, 1]]}})",
         "/pattern/sites/1: expected three numbers");
    says(R"({"brittle": 1, "strikes": [{"at": [0, 0, 0]}, {"radius": -1}]})", "/strikes/1/radius: expected a number");
    says(R"({"brittle": 1, "strikes": [{"where": 1}]})", "/strikes/0/where: unknown key");
    says(R"({"brittle": 1, "strikes": {}})", "/strikes: expected a list");
    says(R"({"brittle": 1, "world": {"physics": "fast"}})",
         "/world/physics: expected \"solver\" or \"bullet\", found \"fast\"");
    says(R"({"brittle": 1, "world": {"physics": 1}})", "/world/physics: expected text in quotes, found 1");
    says(R"({"brittle": 1, "world": {"max_colliding": -1}})",
         "/world/max_colliding: expected a whole number from 0 to 1000000, found -1");
    says(R"({"brittle": 1, "world": {"max_colliding": 1000001}})", "/world/max_colliding: expected a whole number");
    says(R"({"brittle": 1, "world": {"most_colliding": -1}})", "/world/most_colliding: expected a whole number");
    says(R"({"brittle": 1, "world": {"most_colliding": 5, "max_colliding": 5}})",
         "/world/most_colliding: is the former name of max_colliding; give only one of the two");
    says(R"({"brittle": 1, "world": {"anchors": 1}})", "/world/anchors: expected a list");
    says(R"({"brittle": 1, "world": {"anchors": [{"radius": 0}]}})", "/world/anchors/0/radius: expected a number");
    says(R"({"brittle": 1, "world": {"anchors": [{"at": [0, 0, 0], "size": 1}]}})", "/world/anchors/0");
    says(R"({"brittle": 1, "world": {"joints": {}}})", "/world/joints: expected a list");
    says(R"({"brittle": 1, "world": {"joints": [{"kind": "glue"}]}})",
         "/world/joints/0/kind: expected \"ball\", \"hinge\", \"distance\" or \"fixed\", found \"glue\"");
    says(R"({"brittle": 1, "world": {"joints": [{"kind": "ball"}, {"at": [1, 0, 0]}, {"at": [0, 0, 0]}]}})",
         "/world/joints/2/to: is where \"at\" is");
    says(R"({"brittle": 1, "world": {"joints": [{"kind": "hinge", "max_torque": 1}]}})",
         "/world/joints/0/max_torque: only a fixed joint breaks by torque");
    says(R"({"brittle": 1, "world": {"joints": [{"kind": "hinge", "axis": [0, 0, 0]}]}})",
         "/world/joints/0/axis: expected a direction");
    says(R"({"brittle": 1, "world": {"joints": [{"kind": "fixed", "axis": [0, 0, 0]}]}})",
         "/world/joints/0/axis: expected a direction");
    says(R"({"brittle": 1, "world": {"joints": [{"to": [0, 1, 0], "min_length": 2, "max_length": 1}]}})",
         "/world/joints/0/max_length: is below min_length");
    says(R"({"brittle": 1, "world": {"joints": [{"kind": "ball", "links": 3}]}})",
         "/world/joints/0/links: only a distance joint has links");
    says(R"({"brittle": 1, "world": {"joints": [{"to": [0, 1, 0], "max_length": 2, "links": 3}]}})",
         "/world/joints/0/links: a chain is as long as its ends are apart");
    says(R"({"brittle": 1, "world": {"joints": [{"to": [0, 1, 0], "shot": -1}]}})",
         "/world/joints/0/shot: expected a whole number");
    says(R"({"brittle": 1, "world": {"joints": [{"to": [0, 1, 0], "max_force": -1}]}})",
         "/world/joints/0/max_force: expected a number");
    says(R"({"brittle": 1, "world": {"joints": [{"to": [0, 1, 0], "rope": 1}]}})", "/world/joints/0/rope: unknown key");
    says(R"({"brittle": 1, "export": {"hulls": "unity"}})",
         "/export/hulls: expected one of \"godot\", \"unreal\", found \"unity\"");
    says(R"({"brittle": 1, "export": {"hulls": ""}})", "/export/hulls: expected one of");
    says(R"({"brittle": 1, "export": {"as": 1}})", "/export/as: expected one of");
    says(R"({"brittle": 1, "export": {"hull_parts": 257}})",
         "/export/hull_parts: expected a whole number from 1 to 256");
    says(R"({"brittle": 1, "export": {"density": 0}})", "/export/density: expected a number above 0");
    says(R"({"brittle": 1, "export": {"density": -1}})", "/export/density: expected a number");
    says(R"({"brittle": 1, "export": {"name": "a\nb"}})", "/export/name: a name with control characters");
    says(R"({"brittle": 1, "export": {"output": "a.glb"}})", "/export/output: unknown key");
    says(R"({"brittle": 1, "picture": {"every": 0}})", "/picture/every: expected a whole number");
    says(R"({"brittle": 1, "picture": {"size": [640]}})", "/picture/size: expected two numbers");
    says(R"({"brittle": 1, "picture": {"size": [640, 9000]}})",
         "/picture/size/1: expected a whole number from 16 to 8192");
    says(R"({"brittle": 1, "picture": {"quality": "good"}})", "/picture/quality: expected one of");
    says(R"({"brittle": 1, "pattern": 7})", "/pattern: expected an object { }, found 7");
    says(R"({"brittle": 1, "repair": "yes"})", "/repair: expected true or false");
    says(R"({"brittle": 1, "algorithm": "fast"})", "/algorithm: expected \"exact\" or \"sequential\"");
    says(R"({"brittle": 1, "min_volume": -1})", "/min_volume: expected a number");
    says(R"({"brittle": 1, "roughness": 1.5})", "/roughness: expected a number from 0.0 to 1.0, found 1.5");
    says(R"({"brittle": 1, "roughness": "high"})", "/roughness: expected a number");
    says(R"({"brittle": 1, "rough_size": -0.1})", "/rough_size: expected a number");
    says(R"({"brittle": 1, "detail": 7})", "/detail: expected a whole number from 1 to 6, found 7");
    says(R"({"brittle": 1, "detail": 0})", "/detail: expected a whole number");
    says(R"({"brittle": 1, "grain": [0, 1]})", "/grain: expected three numbers");
    for (const char* grain : {"[0, 20, 0]", "[0.01, 0, 0]", "[1e200, 1e200, 0]", "[1e-300, 0, 0]"})
        says(R"({"brittle": 1, "grain": )" + std::string(grain) + "}", "/grain: expected a direction as long as");
    says(R"({"mesh": "shape:cube"})", "/brittle: expected the recipe's version");
    says(R"({"brittle": 3})", "which is 1 for one mesh and 2 for a scene");
    says("[1]", "expected an object");
    says("{", "the JSON cannot be read: parse error at line 1");
    says(std::string(100'000, '['), "nested too deeply");
    // Brackets inside strings do not count.
    const std::string deep = R"(, "repair": )" + std::string(100'000, '[') + std::string(100'000, ']') + "}";
    says(R"({"brittle": 1, "mesh": ")" + std::string(200'000, ']') + "\"" + deep, "nested too deeply");
    says(std::string(size_t{2} << 20, ' '), "the recipe is larger than 1 MiB");
}

TEST_CASE("recipe: the physics engine is read by its name, and written where it is not the default") {
    const Folder folder;
    for (const auto engine : {physics::EngineKind::bullet, physics::EngineKind::solver}) {
        const std::string name = physics::to_string(engine);
        FractureOptions options = everything();
        read_recipe(folder.write("recipe.json", R"({"brittle": 1, "world": {"physics": ")" + name + "\"}}"), options);
        CHECK(options.world.engine == engine);
        const auto world = nlohmann::json::parse(recipe_json(options))["world"];
        CHECK(world.contains("physics") == (engine == physics::EngineKind::bullet));
        CHECK(world.value("physics", "solver") == name);
    }
}

TEST_CASE("recipe: max_colliding is also read under its former name most_colliding, and written under the new one") {
    const Folder folder;
    for (const std::string key : {"max_colliding", "most_colliding"}) {
        FractureOptions options;
        read_recipe(folder.write("recipe.json", R"({"brittle": 1, "world": {")" + key + R"(": 1000}})"), options);
        CHECK(options.world.max_colliding == 1000);
        const auto world = nlohmann::json::parse(recipe_json(options))["world"];
        CHECK(world["max_colliding"] == 1000);
        CHECK_FALSE(world.contains("most_colliding"));
    }
}

TEST_CASE("recipe: a brick has length, height and thickness, and an axis that its length lies along") {
    const Folder folder;
    const auto bond_of = [&](const std::string& brick) {
        FractureOptions options;
        read_recipe(folder.write("recipe.json", R"({"brittle": 1, "world": {"brick": )" + brick + "}}"), options);
        return options.world.bond;
    };
    const physics::RunningBond plain;
    CHECK(bond_of("{}").brick == plain.brick);
    CHECK(bond_of("{}").along == 0);
    CHECK(bond_of(R"({"size": [0.4, 0.2, 0.3]})").brick == glm::dvec3(0.4, 0.2, 0.3));
    CHECK(bond_of(R"({"size": [0.4, 0.2, 0.3], "along": "y"})").brick == glm::dvec3(0.2, 0.4, 0.3));
    CHECK(bond_of(R"({"size": [0.4, 0.2, 0.3], "along": "z"})").brick == glm::dvec3(0.3, 0.2, 0.4));
    CHECK(bond_of(R"({"along": "z"})").brick == glm::dvec3(plain.brick.z, plain.brick.y, plain.brick.x));
    CHECK(bond_of(R"({"along": "z"})").along == 2);
    const auto with = [](const std::string& brick) { return R"({"brittle": 1, "world": {"brick": )" + brick + "}}"; };
    const std::string sizes =
        "/world/brick/size: expected length, height and thickness in metres, such as [0.25, 0.075, 0.12], found ";
    says(with("0.25"), "/world/brick: expected an object { }, found 0.25");
    says(with(R"({"size": 0.25})"), sizes + "0.25");
    says(with(R"({"size": [0.25, 0.12]})"), sizes + "[0.25,0.12]");
    for (const char* bad : {"0", "-0.1", "0.0009", "10.5", "1e300", "5e-324", "null", "\"long\"", "[1]"}) {
        CAPTURE(bad);
        says(with(R"({"size": [0.25, )" + std::string(bad) + ", 0.12]}"),
             "/world/brick/size/1: expected a number from 0.001 to 10.0, found ");
    }
    for (const char* none : {"nan", "Infinity", "1e999"})
        says(with(R"({"size": [0.25, )" + std::string(none) + ", 0.12]}"), "the JSON cannot be read");
    says(with(R"({"along": "w"})"), "/world/brick/along: expected \"x\", \"y\" or \"z\", found \"w\"");
    says(with(R"({"along": 0})"), "/world/brick/along: expected text in quotes");
    says(with(R"({"length": 0.25})"), "/world/brick/length: unknown key; the keys are: size, along");
}

TEST_CASE("recipe: places and velocities beyond the range of the physics are refused by their names") {
    const auto with = [](const std::string& world) { return R"({"brittle": 1, "world": {)" + world + "}}"; };
    const std::string range = ": expected a number from -1000000000.0 to 1000000000.0, found ";
    says(with(R"("shots": [{"from": [0, 1e39, 0]}])"), "/world/shots/0/from/1" + range + "1e+39");
    says(with(R"("shots": [{"velocity": [-1e300, 0, 0]}])"), "/world/shots/0/velocity/0" + range + "-1e+300");
    says(with(R"("anchors": [{"at": [0, 0, 2e9]}])"), "/world/anchors/0/at/2" + range + "2000000000.0");
    for (const std::string field : {"at", "to", "axis"})
        says(with(R"("joints": [{")" + field + R"(": [1e200, 0, 0]}])"), "/world/joints/0/" + field + "/0" + range);
    CHECK(message_of(with(R"("shots": [{"from": [1e9, -1e9, 0]}])")).empty());
}

TEST_CASE("recipe: messages contain no control characters and do not quote a whole file") {
    const std::string escape = R"(\u001b[31m)";
    for (const std::string& text :
         {R"({"brittle": 1, ")" + escape + R"(": 1})", R"({"brittle": 1, "algorithm": ")" + escape + R"("})",
          R"({"brittle": 1, "pattern": {"type": ")" + escape + R"("}})",
          R"({"brittle": 1, ")" + std::string(100'000, 'x') + R"(": 1})", "{\"" + std::string(100'000, 'x')}) {
        const std::string message = message_of(text);
        CAPTURE(message);
        CHECK(message.size() > 10);
        CHECK(message.size() < 1000);
        CHECK(message.find('\x1b') == std::string::npos);
    }
}

TEST_CASE("recipe: the schema lists exactly the keys that are written and read") {
    const auto schema = nlohmann::json::parse(std::ifstream(BRITTLE_ASSETS "/recipe.schema.json"));
    const auto all = nlohmann::json::parse(recipe_json(everything()));
    for (const auto& [key, value] : all.items()) CHECK(schema["properties"].contains(key));
    for (const auto& [key, value] : all["pattern"].items())
        CHECK(schema["properties"]["pattern"]["properties"].contains(key));
    for (const auto& [key, value] : schema["properties"].items())
        CHECK(all.contains(key) == (key != "$schema")); // which is read, but not kept
    for (const char* part : {"picture", "world", "export"})
        for (const auto& [key, value] : schema["properties"][part]["properties"].items())
            CHECK(all[part].contains(key) != value.value("deprecated", false)); // former names are read, not written
    for (const auto& [key, value] : all["world"].items())
        CHECK(schema["properties"]["world"]["properties"].contains(key));
    for (const auto& [key, value] : all["export"].items())
        CHECK(schema["properties"]["export"]["properties"].contains(key));
    for (const auto& [key, value] : all["picture"].items())
        CHECK(schema["properties"]["picture"]["properties"].contains(key));
    const auto of_points = nlohmann::json::parse(recipe_json(points()))["pattern"];
    for (const auto& [key, value] : of_points.items())
        CHECK(schema["properties"]["pattern"]["properties"].contains(key));
    const auto of_list = nlohmann::json::parse(recipe_json(grouped()))["pattern"];
    for (const auto& [key, value] : of_list.items()) CHECK(schema["properties"]["pattern"]["properties"].contains(key));
    for (const auto& [key, value] : schema["properties"]["pattern"]["properties"].items())
        CHECK((all["pattern"].contains(key) || of_points.contains(key) || of_list.contains(key)));
    const auto& of_strike = schema["properties"]["strikes"]["items"]["properties"];
    for (const auto& [key, value] : of_strike.items()) CHECK(all["strikes"][0].contains(key));
    for (const auto& [key, value] : all["strikes"][0].items()) CHECK(of_strike.contains(key));
    const auto& of_anchor = schema["properties"]["world"]["properties"]["anchors"]["items"]["properties"];
    for (const auto& [key, value] : of_anchor.items()) CHECK(all["world"]["anchors"][0].contains(key));
    for (const auto& [key, value] : all["world"]["anchors"][0].items()) CHECK(of_anchor.contains(key));
    const auto& of_joint = schema["properties"]["world"]["properties"]["joints"]["items"]["properties"];
    const auto& joints = all["world"]["joints"];
    for (const auto& [key, value] : of_joint.items()) {
        const std::string& name = key; // clang 14 captures no structured binding
        CHECK(std::ranges::any_of(joints, [&](const auto& joint) { return joint.contains(name); }));
    }
    for (const auto& joint : joints)
        for (const auto& [key, value] : joint.items()) CHECK(of_joint.contains(key));
    const auto& of_brick = schema["properties"]["world"]["properties"]["brick"]["properties"];
    for (const auto& [key, value] : of_brick.items()) CHECK(all["world"]["brick"].contains(key));
    for (const auto& [key, value] : all["world"]["brick"].items()) CHECK(of_brick.contains(key));
    const auto& materials = schema["properties"]["material"]["enum"];
    REQUIRE(materials.size() == physics::material_presets().size());
    for (size_t k = 0; k < materials.size(); ++k)
        CHECK(materials[k] == std::string(physics::material_presets()[k].name));
    const auto& types = schema["properties"]["pattern"]["properties"]["type"]["enum"];
    const size_t kinds = fracture::pattern_names().size();
    REQUIRE(types.size() == kinds + 2);
    for (size_t k = 0; k < kinds; ++k) CHECK(types[k] == std::string(fracture::pattern_names()[k]));
    CHECK(types[kinds] == "automatic");
    CHECK(types[kinds + 1] == "points");
}

// Objects of a scene whose pieces are the nodes of a file.
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/fracture.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "tests/glb_file.h"
#include "tests/tools/replays.h"
#include "tests/tools/support.h"
#include "tools/scenario/recipe/recipe.h"
#include "tools/scenario/run/scene.h"

using namespace brittle;
using namespace brittle::tools;
using namespace brittle::tools::test;

namespace {

fracture::TriangleMesh box(const glm::dvec3& low, const glm::dvec3& high) {
    fracture::TriangleMesh mesh = fracture::cube(2.0);
    for (glm::dvec3& p : mesh.positions) p = 0.5 * (low + high) + 0.5 * p * (high - low);
    return mesh;
}

// A file with a node for each mesh.
std::string glb_of(const std::vector<fracture::TriangleMesh>& meshes) {
    test_files::GlbFile glb;
    std::string nodes;
    for (size_t k = 0; k < meshes.size(); ++k) {
        glb.add_mesh(meshes[k]);
        nodes += (k > 0 ? ", " : "") + (R"({"name": "brick )" + std::to_string(k) + R"(", "mesh": )")
                 + std::to_string(k) + "}";
    }
    return glb.bytes(R"("nodes": [)" + nodes + R"(], "scenes": [{"nodes": [)" + [&] {
        std::string list;
        for (size_t k = 0; k < meshes.size(); ++k) list += (k > 0 ? ", " : "") + std::to_string(k);
        return list;
    }() + "]}]");
}

// A wall in the plane z = 0 of rows of bricks of 0.4 x 0.2 x 0.2 m, every other row half a brick aside.
std::vector<fracture::TriangleMesh> wall(int rows, int columns) {
    std::vector<fracture::TriangleMesh> bricks;
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            const double x = 0.4 * column + (row % 2 == 0 ? 0.0 : 0.2), y = 0.2 * row;
            bricks.push_back(box({x, y, -0.1}, {x + 0.4, y + 0.2, 0.1}));
        }
    return bricks;
}

FractureOptions scene_of(const Folder& folder, const std::string& bytes, const std::string& members) {
    folder.write("set.glb", bytes);
    FractureOptions options;
    read_recipe(folder.write("scene.json",
                             R"({"brittle": 2, "objects": [{"mesh": "set.glb", "in_pieces": true, )" + members + "}]}"),
                options);
    return options;
}

} // namespace

TEST_CASE("scene in pieces: a node that is no piece is named, and the object stays whole and fixed") {
    std::vector<fracture::TriangleMesh> bricks = wall(1, 3);
    bricks[1].triangles.pop_back();
    const Folder folder;
    LoadedScene loaded = load_scene(scene_of(folder, glb_of(bricks), R"("bonded": true)"));
    REQUIRE(loaded.notes.size() == 1);
    CHECK(loaded.notes[0].find("set stays whole and fixed: the piece \"brick 1\"") == 0);
    CHECK(loaded.objects[0].refused);
    Simulation simulation;
    simulation.start(prepare_scene(loaded), loaded.world);
    CHECK(simulation.piece_count() == 1);
    bricks = wall(1, 3);
    for (fracture::Triangle& t : bricks[2].triangles) std::swap(t.y, t.z);
    LoadedScene inside_out = load_scene(scene_of(folder, glb_of(bricks), R"("bonded": true)"));
    REQUIRE(inside_out.notes.size() == 1);
    CHECK(inside_out.notes[0].find("\"brick 2\": it encloses no volume, or its triangles face inwards")
          != std::string::npos);
}

TEST_CASE("scene in pieces: a file that is no glTF file is a failure that names the object") {
    const Folder folder;
    const FractureOptions scene = scene_of(folder, "no glb", R"("bonded": true)");
    try {
        (void)load_scene(scene);
        FAIL("loaded");
    } catch (const Failure& failure) {
        CHECK(std::string(failure.what()).find("object set: ") == 0);
    }
}

TEST_CASE("scene in pieces: bricks are bonded where they touch, with the area of the contact") {
    const Folder folder;
    LoadedScene loaded =
        load_scene(scene_of(folder, glb_of(wall(3, 4)), R"("bonded": true, "anchored": true, "material": "brick")"));
    CHECK(loaded.notes.empty());
    Simulation simulation;
    simulation.start(prepare_scene(loaded), loaded.world);
    CHECK(simulation.piece_count() == 12);
    const physics::Structure* structure = simulation.structure();
    REQUIRE(structure);
    // In a row 3 contacts of 0.04 m^2; between two rows 7 of half a brick, 0.04 m^2.
    CHECK(structure->graph().live_count() == 3 * 3 + 2 * 7);
    for (const physics::BondGraph::Bond& bond : structure->graph().bonds())
        CHECK(bond.area == doctest::Approx(0.04).epsilon(1e-5));
    CHECK(structure->bodies().size() == 1);
    CHECK(simulation.world().fixed(simulation.body_of(11)));
    for (int k = 0; k < 60; ++k) simulation.step();
    CHECK(structure->graph().live_count() == 23); // it bears its weight
}

TEST_CASE("scene in pieces: a gap counts as a contact only within contact_tolerance, and loose pieces have no bonds") {
    const Folder folder;
    std::vector<fracture::TriangleMesh> pair{box({0, 0, 0}, {1, 1, 1}), box({1.002, 0, 0}, {2, 1, 1})};
    const auto bodies = [&](const std::string& members) {
        LoadedScene loaded = load_scene(scene_of(folder, glb_of(pair), members));
        Simulation simulation;
        simulation.start(prepare_scene(loaded), loaded.world);
        CHECK(simulation.piece_count() == 2);
        return simulation.world().body_count();
    };
    CHECK(bodies(R"("bonded": true)") == 2);
    CHECK(bodies(R"("bonded": true, "contact_tolerance": 0.0025)") == 1);
    // The tolerance is in metres of the world, whatever the scale of the object.
    CHECK(bodies(R"("bonded": true, "contact_tolerance": 0.0025, "scale": 2)") == 2);
    CHECK(bodies(R"("shattered": true, "contact_tolerance": 0.0025)") == 2);
    CHECK(bodies(R"("contact_tolerance": 0.0025)") == 2);
}

TEST_CASE("scene in pieces: the pieces of our own fracture hold together as before it was written") {
    const fracture::TriangleMesh mesh = fracture::torus(24, 12);
    const auto sites = fracture::uniform_sites(fracture::bounds(mesh), 40, 3);
    const auto fragments = fracture::fracture(mesh, sites, {});
    REQUIRE(fragments);
    std::vector<fracture::TriangleMesh> pieces;
    for (const fracture::Piece& piece : fragments->pieces) {
        const auto positions = fragments->positions_of(piece);
        const auto triangles = fragments->triangles_of(piece);
        pieces.push_back({{positions.begin(), positions.end()}, {triangles.begin(), triangles.end()}});
    }
    const Folder folder;
    LoadedScene loaded = load_scene(scene_of(folder, glb_of(pieces), R"("bonded": true)"));
    CHECK(loaded.notes.empty());
    Simulation simulation;
    simulation.start(prepare_scene(loaded), loaded.world);
    REQUIRE(simulation.piece_count() == fragments->pieces.size());
    const auto bonds = simulation.structure()->graph().bonds();
    REQUIRE(bonds.size() == fragments->bonds.size());
    for (size_t k = 0; k < bonds.size(); ++k) {
        CHECK(bonds[k].a == fragments->bonds[k].a);
        CHECK(bonds[k].b == fragments->bonds[k].b);
        CHECK(bonds[k].area == doctest::Approx(fragments->bonds[k].area).epsilon(1e-3)); // single precision in the file
    }
}

TEST_CASE("scene in pieces: a ball breaks a wall of bricks, and the run repeats with any number of threads") {
    const Folder folder;
    FractureOptions scene =
        scene_of(folder, glb_of(wall(5, 6)), R"("bonded": true, "anchored": true, "material": "brick")");
    scene.world.shots.push_back({0.05, {1.2, 0.6, 2.0}, {0.0, 0.0, -20.0}, 0.15, 7800.0});
    const auto file = folder.path / "run.log";
    {
        LoadedScene loaded = load_scene(scene);
        Simulation simulation;
        Recorder recorder(file, scene);
        simulation.observe(&recorder);
        simulation.start(prepare_scene(loaded), loaded.world);
        for (int k = 0; k < 60; ++k) simulation.step();
        recorder.finish();
        CHECK(simulation.structure()->graph().live_count() < simulation.structure()->graph().bonds().size());
        CHECK(simulation.world().body_count() > 5);
    }
    const ReplayLog log = read_replay_log(file);
    for (const uint32_t threads : {1u, 2u, 7u}) {
        uint64_t steps = 0;
        CHECK_FALSE(replayed_scene(log, threads, steps));
        CHECK(steps == 60);
    }
}

TEST_CASE("scene in pieces: --pieces-from makes a scene of one bonded object, with the physics of the options") {
    FractureOptions options;
    CHECK(recipe_json(scene_of_pieces(options)) == recipe_json(options));
    options.pieces_from = "folder/set.glb";
    use_material("stone", options);
    options.world.anchored = true;
    options.world.strength = 0.5;
    options.world.shots.push_back({});
    const FractureOptions scene = scene_of_pieces(options);
    REQUIRE(scene.objects.size() == 1);
    const SceneObject& object = scene.objects[0];
    CHECK(object.name == "set");
    CHECK(object.recipe.mesh == "folder/set.glb");
    CHECK(object.in_pieces);
    CHECK(object.recipe.material == "stone");
    CHECK(object.recipe.world.bonded);
    CHECK(object.recipe.world.anchored);
    CHECK(object.recipe.world.strength == 0.5);
    CHECK(scene.world.shots.size() == 1);
    CHECK(scene.units == LengthUnit::metre);
    options.units = LengthUnit::centimetre;
    CHECK(scene_of_pieces(options).units == LengthUnit::centimetre);
    options.repair = true;
    CHECK_THROWS_AS((void)scene_of_pieces(options), Failure);
    options.repair = false;
    options.objects.emplace_back();
    CHECK_THROWS_AS((void)scene_of_pieces(options), Failure);
}

// Options of breakable worlds in recipes and on the command line: cuts of blows, bricks, shots.
#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "physics/material.h"
#include "tests/tools/scenes.h"
#include "tests/tools/support.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/recipe.h"
#include "tools/scenario/run/simulation.h"

using namespace brittle;
using namespace brittle::tools;
using namespace brittle::tools::test;

TEST_CASE("breakable: a missing or malformed file of a diagram is refused by name") {
    const Folder folder;
    FractureOptions options;
    options.sites_file = folder / "none.txt";
    CHECK(!world_of(options).blows); // the world is not breakable, so the file is not read
    options.world.breakable = true;
    CHECK_THROWS_WITH_AS((void)world_of(options), doctest::Contains("none.txt"), Failure);
    write_text(options.sites_file, "0 0 zero\n");
    CHECK_THROWS_WITH_AS((void)world_of(options), doctest::Contains("none.txt"), Failure);
}

TEST_CASE("breakable: blows cut by the pattern, which the material sets unless the recipe does") {
    for (const physics::MaterialPreset& material : physics::material_presets()) {
        FractureOptions options;
        options.world.breakable = true;
        use_material(std::string(material.name), options);
        REQUIRE(world_of(options).blows);
        CHECK(world_of(options).blows->kind == material.pattern.kind);
        CHECK(world_of(options).blows->slenderness == material.pattern.slenderness);
        options.pattern.kind = fracture::PatternKind::splinters;
        CHECK(world_of(options).blows->kind == fracture::PatternKind::splinters);
        FractureOptions placed = options, bonded = options;
        placed.points = {{{0.0, 0.0, 0.0}}, {{0.1, 0.0, 0.0}}}; // a recipe with listed sites has no kind of pattern
        bonded.world.bonded = true;                             // the pattern has cut the mesh beforehand
        CHECK_FALSE(world_of(placed).blows);
        CHECK_FALSE(world_of(bonded).blows);
    }
}

// Sites on a vertical line give horizontal cuts, unless the line is turned.
TEST_CASE("breakable: blows take bricks out of a whole wall, and a wall cut into bricks beforehand crumbles") {
    for (const bool ahead : {false, true}) {
        FractureOptions options;
        options.mesh = "shape:wall";
        use_material("brick", options);
        options.world = {.bonded = ahead, .breakable = true};
        const fracture::Fragments pieces = started(options);
        Simulation simulation(options.material);
        simulation.start(pieces, world_of(options));
        const auto cut = simulation.foresee({0, glm::dvec3(simulation.pose_of(0).position), {0.0, 0.0, -2000.0}});
        REQUIRE(cut);
        CHECK((cut->desc->pattern.kind == fracture::PatternKind::bricks) == !ahead);
        const auto made = physics::carry_out(*cut, [] { return false; });
        REQUIRE(made);
        CHECK(made->size() > 2);
    }
}

TEST_CASE("breakable: blows take out the recipe's bricks, and render warns where no blow does") {
    const Folder folder;
    const auto recipe = [&](const std::string& material, const std::string& world) {
        return folder.write("wall.json", R"({"brittle": 1, "mesh": "shape:wall", "material": ")" + material
                                             + R"(", "world": {"brick": {"size": [0.5, 0.3, 0.2], "along": "x"}, )"
                                             + world + "}}");
    };
    FractureOptions options;
    read_recipe(recipe("brick", R"("breakable": true)"), options);
    Simulation simulation(options.material);
    const fracture::Fragments whole = started(options);
    simulation.start(whole, world_of(options));
    const auto cut = simulation.foresee({0, glm::dvec3(simulation.pose_of(0).position), {0.0, 0.0, -2000.0}});
    REQUIRE(cut);
    const auto made = physics::carry_out(*cut);
    REQUIRE(made);
    const glm::dvec3 size = physics::fitted(options.world.bond, fracture::bounds(whole.positions)).brick;
    CHECK(size.y > 0.2);
    CHECK(std::ranges::count_if(*made,
                                [&](const physics::SolidPtr& piece) {
                                    return std::abs(piece->mass.volume / (size.x * size.y * size.z) - 1.0) < 1e-9;
                                })
          > 2);
    for (const auto& [case_material, world, said] : {std::tuple("brick", R"("breakable": true)", false),
                                                     {"concrete", R"("breakable": true)", true},
                                                     {"brick", R"("anchored": true)", true}}) {
        const auto material = case_material; // clang 14 captures no structured binding
        CAPTURE(material);
        const Outcome outcome = run_brittle(folder, "render " + recipe(material, world).string()
                                                        + " --frames 0 --size 64x48 -o " + (folder / "a.png"));
        CHECK(outcome.has("world/brick has no effect") == said);
    }
}

TEST_CASE("breakable: blows cut along a diagram from a file, fitted to the piece that is hit and then placed") {
    const Folder folder;
    FractureOptions options;
    options.mesh = "shape:wall";
    std::string line;
    for (int k = 0; k < 30; ++k) line += "5 " + std::to_string(10 * k) + " 5\n";
    options.sites_file = folder.write("line.txt", line).string();
    use_material("concrete", options);
    options.rough = {}; // flat cuts show the diagram
    options.world = {.height = 0.0,
                     .breakable = true,
                     .shots = {{.from = {0.0, 0.7, 2.0}, .velocity = {0.0, 0.0, -30.0}, .radius = 0.15},
                               {.time = 0.5, .from = {0.3, 0.4, 2.0}, .velocity = {0.0, 0.0, -30.0}, .radius = 0.15}}};
    for (const bool laid_down : {false, true}) {
        CAPTURE(laid_down);
        options.sites_placement.turn = {laid_down ? 90.0 : 0.0, 0.0, 0.0};
        Simulation simulation(options.material);
        simulation.start(started(options), world_of(options));
        while (simulation.steps() < 120) simulation.step();
        const physics::Destruction& destruction = *simulation.destruction();
        CHECK(destruction.pieces().size() > 2);
        CHECK(destruction.statistics().overloads == 0); // overloads would cut along blocks of their own
        int cuts = 0;
        for (const physics::PieceId id : destruction.pieces()) {
            const physics::SolidPiece& piece = *destruction.solid(id);
            for (size_t k = piece.surface().exterior_triangles; k < piece.surface().mesh.triangles.size(); ++k) {
                const auto corner = [&](int c) {
                    return glm::dvec3(piece.surface().positions[piece.surface().mesh.triangles[k][c]]);
                };
                const glm::dvec3 across = glm::cross(corner(1) - corner(0), corner(2) - corner(0));
                if (glm::length(across) < 1e-5) continue; // m^2; positions for drawing have single precision
                CHECK(std::abs(across.y / glm::length(across)) == doctest::Approx(laid_down ? 0.0 : 1.0).epsilon(1e-3));
                ++cuts;
            }
        }
        CHECK(cuts > 0);
    }
}

TEST_CASE("breakable: --shot equals the shots of a recipe, and faults of a shot are named") {
    const Folder folder;
    const std::string start = "render shape:pane --breakable --frames 0 --size 64x48 -o " + (folder / "a.png");
    // The recipe is written before a device is opened.
    (void)run_brittle(folder, start + " --shot -1,0.5,4,0,1.5,-20,0.25 --shot 0,1,2,3,4,5,0.1,0.75 --save-recipe "
                                  + (folder / "r.json"));
    FractureOptions options;
    read_recipe(folder / "r.json", options);
    REQUIRE(options.world.shots.size() == 2);
    const Shot &one = options.world.shots[0], &two = options.world.shots[1];
    CHECK(one.from == glm::dvec3(-1.0, 0.5, 4.0));
    CHECK(one.velocity == glm::dvec3(0.0, 1.5, -20.0));
    CHECK(one.radius == 0.25);
    CHECK(one.time == 0.0);
    CHECK(two.velocity == glm::dvec3(3.0, 4.0, 5.0));
    CHECK(two.time == 0.75);
    for (const char* bad : {"1,2,3,4,5,6", "1,2,3,4,5,6,x", "1,2,3,4,5,6,0.1,", "nan,0,0,1,1,1,1", "0,0,0,0,0,0,0",
                            "0,0,0,0,0,0,11", "0,0,0,0,0,0,1,-1", "0,0,0,0,0,0,1,1,1"}) {
        CAPTURE(bad);
        const Outcome outcome = run_brittle(folder, start + " --shot " + bad);
        CHECK(outcome.exit_code == 2);
        CHECK(outcome.has("--shot"));
    }
}

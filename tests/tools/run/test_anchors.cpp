// Anchors, which fix parts of a mesh to the world: WorldOptions::anchors.
#include <set>
#include <vector>

#include <doctest/doctest.h>

#include "tests/tools/support.h"
#include "tools/brittle/stage/stage.h"
#include "tools/scenario/recipe/input.h"
#include "tools/scenario/run/simulation.h"

using namespace brittle;
using namespace brittle::tools;

namespace {

// A pane of 2 m by 1.5 m on the stage; anchors are relative to the middle of its lower edge.
const std::vector<Anchor> upper_corners{{{-1.0, 1.5, 0.0}, 0.15}, {{1.0, 1.5, 0.0}, 0.15}};

FractureOptions pane(const WorldOptions& world) {
    FractureOptions options;
    options.mesh = "shape:pane";
    options.material = "glass";
    options.pattern = {.kind = fracture::PatternKind::uniform, .count = 40, .seed = 3};
    options.world = world;
    return options;
}

fracture::Fragments started(const FractureOptions& options) {
    return break_input(placed_on_stage(load_input(options), options.world), options).fragments;
}

std::set<uint32_t> fixed_pieces(const Simulation& simulation) {
    std::set<uint32_t> fixed;
    for (uint32_t piece = 0; piece < simulation.number_count(); ++piece) {
        const physics::BodyId body = simulation.body_of(piece);
        if (simulation.world().contains(body) && simulation.world().fixed(body)) fixed.insert(piece);
    }
    return fixed;
}

float lowest(const Simulation& simulation) {
    float low = 1e9f;
    for (const physics::BodyId body : simulation.world().bodies())
        low = std::min(low, simulation.world().pose(body).position.y);
    return low;
}

void run(Simulation& simulation, double seconds) {
    const uint64_t end = simulation.steps() + static_cast<uint64_t>(seconds * 120.0);
    while (simulation.steps() < end) simulation.step();
}

} // namespace

TEST_CASE("anchors: bonded pieces hang from painted anchors, and fall when they are released") {
    const FractureOptions options = pane({.height = 1.0, .strength = 1e3, .anchors = upper_corners});
    const fracture::Fragments pieces = started(options);
    REQUIRE(pieces.pieces.size() > 20);
    Simulation simulation(options.material);
    simulation.start(pieces, options.world);
    CHECK(simulation.world().body_count() == 1); // bonded, because anchors imply it
    const float height = lowest(simulation);
    run(simulation, 1.0);
    CHECK(lowest(simulation) == height);
    CHECK(fixed_pieces(simulation).size() == pieces.pieces.size());
    simulation.apply(Release{});
    run(simulation, 0.2);
    CHECK(lowest(simulation) < height - 0.1f);
}

TEST_CASE("anchors: they hold the same pieces at any height of the mesh") {
    std::vector<std::vector<uint32_t>> held;
    for (const double height : {0.0, 0.7, 3.0}) {
        const FractureOptions options = pane({.height = height, .anchors = upper_corners});
        Simulation simulation(options.material);
        simulation.start(started(options), options.world);
        std::vector<uint32_t> anchored;
        for (uint32_t piece = 0; piece < simulation.piece_count(); ++piece)
            if (simulation.structure()->anchored(piece)) anchored.push_back(piece);
        CHECK(anchored.size() >= 2);
        CHECK(anchored.size() < simulation.piece_count() / 2);
        held.push_back(anchored);
    }
    CHECK(held[0] == held[1]);
    CHECK(held[0] == held[2]);
}

TEST_CASE("anchors: an anchor that touches nothing holds nothing, and anchors and ground hold together") {
    const FractureOptions nowhere = pane({.anchors = {{{5.0, 5.0, 5.0}, 0.5}}});
    Simulation loose(nowhere.material);
    loose.start(started(nowhere), nowhere.world);
    CHECK(fixed_pieces(loose).empty());
    const FractureOptions both = pane({.anchored = true, .anchors = upper_corners});
    Simulation simulation(both.material);
    simulation.start(started(both), both.world);
    std::set<uint32_t> anchored;
    for (uint32_t piece = 0; piece < simulation.piece_count(); ++piece)
        if (simulation.structure()->anchored(piece)) anchored.insert(piece);
    FractureOptions one = both;
    one.world.anchors.clear();
    Simulation foot(one.material);
    foot.start(started(one), one.world);
    size_t below = 0;
    for (uint32_t piece = 0; piece < foot.piece_count(); ++piece) below += foot.structure()->anchored(piece);
    CHECK(below >= 2);
    CHECK(anchored.size() > below);
}

TEST_CASE("anchors: the part of a shot breakable pane that still reaches an anchor hangs, and the rest falls") {
    FractureOptions options = pane({.height = 0.8, .breakable = true, .min_size = 0.02, .anchors = upper_corners});
    options.world.shots = {{.time = 0.1, .from = {0.1, 1.4, -2.0}, .velocity = {0.0, 0.0, 20.0}, .radius = 0.08}};
    const fracture::Fragments whole = started(options);
    REQUIRE(whole.pieces.size() == 1);
    Simulation simulation(options.material);
    simulation.start(whole, options.world);
    run(simulation, 0.05);
    CHECK(fixed_pieces(simulation) == std::set<uint32_t>{0});
    run(simulation, 2.0);
    const physics::Destruction& destruction = *simulation.destruction();
    const std::set<uint32_t> fixed = fixed_pieces(simulation);
    CHECK(destruction.pieces().size() > 10);
    CHECK(!fixed.empty());
    CHECK(fixed.size() < destruction.pieces().size());
    for (const physics::PieceId id : destruction.pieces()) {
        const physics::SolidPiece& piece = *destruction.solid(id);
        bool touches = false;
        for (const glm::vec3& p : piece.surface().positions)
            for (const Anchor& anchor : upper_corners)
                touches = touches
                          || glm::distance(glm::dvec3(p) + piece.mass.centre_of_mass,
                                           anchor.at + glm::dvec3(0.0, options.world.height, 0.0))
                                 < anchor.radius;
        if (touches) CHECK(fixed.contains(id.value));
        if (fixed.contains(id.value)) CHECK(piece.anchored);
    }
}

TEST_CASE("anchors: the command line accepts them and names the fault of an invalid one") {
    const test::Folder folder;
    const std::string start = "render shape:pane -n 20 --frames 1 --size 64x48 -o " + (folder / "a.png") + " ";
    CHECK(test::run_brittle(folder, start + "--anchor -1,1.5,0,0.2 --anchor 1,1.5,0,0.2").exit_code == 0);
    for (const char* bad : {"1,2,3", "1,2,3,x", "nan,0,0,1", "0,0,0,0", "0,0,0,11"}) {
        CAPTURE(bad);
        const test::Outcome outcome = test::run_brittle(folder, start + "--anchor " + bad);
        CHECK(outcome.exit_code == 2);
        CHECK(outcome.has("--anchor"));
    }
}

// Glue between the objects of a scene.
#include "tools/scenario/run/scene_glue.h"

#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "fracture/shapes/shapes.h"
#include "tests/glb_file.h"
#include "tests/tools/replays.h"
#include "tests/tools/support.h"
#include "tools/scenario/recipe/recipe.h"
#include "tools/scenario/run/scene.h"
#include "tools/scenario/run/state_export.h"

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

// A box, by its middle and half of its sides, and more keys of the object. shape:cube has sides of 2 m.
std::string box(const std::string& name, const std::string& middle, const std::string& half, const std::string& more) {
    return R"({"name": ")" + name + R"(", "mesh": "shape:cube", "translation": [)" + middle + R"(], "scale": [)" + half
           + "]" + (more.empty() ? "" : ", " + more) + "}";
}

const std::string pieces = R"("bonded": true, "material": "wood", "pattern": {"type": "grid", "count": 8})";
// A fixed wall whose front is the plane z = 0, and a shelf in front of it.
const std::string wall = box("wall", "0, 2, -0.1", "1, 1, 0.1", R"("fixed": true)");
const std::string shelf = box("shelf", "0, 2, 0.15", "0.5, 0.02, 0.15", pieces);
const std::string both = wall + ", " + shelf;
const std::string glue = R"(, "glue": [{"between": ["shelf", "wall"]}])";

// A run of a scene. Keeps the notes of load and start.
struct Run {
    LoadedScene scene;
    Simulation simulation;

    explicit Run(const FractureOptions& options) : scene(load_scene(options)) {
        simulation.start(prepare_scene(scene), scene.world);
    }
    void take(int steps) {
        for (int k = 0; k < steps; ++k) simulation.step();
    }
    // The pieces of an object.
    [[nodiscard]] std::vector<uint32_t> pieces_of(const std::string& name) const {
        std::vector<uint32_t> own;
        for (const physics::PieceId id : simulation.destruction()->pieces())
            if (simulation.members()[simulation.member_of(id.value)].name == name) own.push_back(id.value);
        return own;
    }
    [[nodiscard]] size_t bodies_of(const std::string& name) const {
        std::map<physics::BodyId, int> bodies;
        for (const uint32_t piece : pieces_of(name)) ++bodies[simulation.body_of(piece)];
        return bodies.size();
    }
    [[nodiscard]] double height_of(const std::string& name) const { // of its highest piece
        double height = -1e9;
        for (const uint32_t piece : pieces_of(name))
            height = std::max(height, static_cast<double>(simulation.pose_of(piece).position.y));
        return height;
    }
};

std::string note_of(const Run& run) {
    REQUIRE(run.scene.notes.size() == 1);
    return run.scene.notes[0];
}

} // namespace

TEST_CASE("scene glue: objects that do not touch are named, with their distance, and stay apart") {
    const auto note = [](const std::string& objects, const std::string& entry) {
        return note_of(Run(scene_of(objects, R"(, "glue": [)" + entry + "]")));
    };
    const auto check = [](const std::string& said, const char* says) {
        CAPTURE(said);
        CHECK(said.find(says) != std::string::npos);
    };
    const std::string far = box("far", "0, 2, 0.25", "0.5, 0.02, 0.15", pieces);
    check(note(wall + ", " + far, R"({"between": ["far", "wall"]})"),
          "/glue/0 glues nothing: 'far' and 'wall' have no faces against each other: the nearest corner of one is "
          "0.1 m from the other");
    // The nearest of several, and one that is turned, so that boxes touch where surfaces do not.
    check(note(wall + ", " + far + ", " + box("near", "0, 3, 0.2", "0.5, 0.02, 0.15", pieces),
               R"({"between": ["*ar", "wall"]})"),
          "'near' and 'wall' have no faces against each other: the nearest corner of one is 0.05 m");
    check(note(both, R"({"between": ["wall", "wall"]})"), "it takes two objects, and one of them that is not fixed");
    check(note(both, R"({"between": ["shelf", "shelf"]})"), "it takes two objects");
    // A wider gap than the tolerance, and one within it.
    const std::string gap = wall + ", " + box("shelf", "0, 2, 0.155", "0.5, 0.02, 0.15", pieces);
    check(note(gap, R"({"between": ["shelf", "wall"]})"), "0.005 m from the other");
    CHECK(Run(scene_of(gap, R"(, "glue": [{"between": ["shelf", "wall"], "tolerance": 0.006}])")).scene.notes.empty());
}

TEST_CASE("scene glue: an object that cannot be glued is refused, also one of a level") {
    const Folder folder;
    test_files::GlbFile glb;
    glb.add_mesh(fracture::cube(1.0));
    const std::string level =
        folder.write("level.glb", glb.bytes(R"("nodes": [{"name": "crate", "mesh": 0}])")).string();
    const auto message_of = [&](const std::string& then) -> std::string {
        FractureOptions options;
        read_recipe(folder.write("scene.json", R"({"brittle": 2, "level": {"mesh": ")" + level
                                                   + R"(", "rules": [{"then": {)" + then
                                                   + R"(}}]}, "glue": [{"between": ["crate", "floor"]}]})"),
                    options);
        try {
            return load_scene(options).notes.empty() ? "" : "noted";
        } catch (const Failure& failure) {
            CHECK(failure.code() == exit_input);
            return failure.what();
        }
    };
    CHECK(message_of(R"("shattered": true)").find("/glue/0/between/0: the object 'crate' is loose pieces") == 0);
    CHECK(message_of("").empty());
    CHECK(message_of(R"("fixed": true)").empty());
}

TEST_CASE("scene glue: a shelf hangs on a fixed wall, and falls without glue") {
    for (const bool is_glued : {true, false}) {
        CAPTURE(is_glued);
        Run run(scene_of(both, is_glued ? glue : ""));
        CHECK(run.scene.notes.empty());
        CHECK(run.bodies_of("shelf") == 1);
        const double before = run.height_of("shelf");
        run.take(240);
        CHECK((std::abs(run.height_of("shelf") - before) < 1e-6) == is_glued);
        CHECK(run.simulation.world().fixed(run.simulation.body_of(run.pieces_of("shelf")[0])) == is_glued);
        const auto structures = run.simulation.structures();
        REQUIRE(structures.size() == 1);
        if (!is_glued) continue;
        // The contact is 1 m wide and 0.04 m high, whatever the pieces at the wall.
        double area = 0.0;
        for (const auto& bond : structures[0]->graph().bonds())
            if (std::max(bond.a, bond.b) >= run.pieces_of("shelf").size()) area += bond.area;
        CHECK(area == doctest::Approx(0.04).epsilon(1e-6));
    }
}

TEST_CASE("scene glue: glue that is too weak for the weight breaks, and strong glue does not") {
    for (const bool is_weak : {true, false}) {
        Run run(scene_of(both, R"(, "glue": [{"between": ["shelf", "wall"], "strength": )"
                                   + std::string(is_weak ? "1e-5" : "10") + "}]"));
        const double before = run.height_of("shelf");
        run.take(240);
        CHECK((run.height_of("shelf") < before - 0.5) == is_weak);
    }
}

TEST_CASE("scene glue: the first entry that fits a pair decides") {
    const std::string weak = R"({"between": ["s*", "w*"], "strength": 1e-5})",
                      strong = R"({"between": ["shelf", "wall"]})";
    for (const bool weak_first : {true, false}) {
        Run run(scene_of(both, R"(, "glue": [)" + (weak_first ? weak + ", " + strong : strong + ", " + weak) + "]"));
        CHECK(run.scene.notes.empty()); // the other one fits the same pair
        const double before = run.height_of("shelf");
        run.take(240);
        CHECK((run.height_of("shelf") < before - 0.5) == weak_first);
    }
}

TEST_CASE("scene glue: objects that are glued move as one body, turned ones too, and split where the glue breaks") {
    // Two beams in one line, turned by 30 degrees about z, and the second one by 90 degrees about its own axis.
    const double along = 30.0 * std::numbers::pi / 180.0, apart = 0.8;
    const std::string second =
        std::to_string(apart * std::cos(along)) + ", " + std::to_string(2.0 + apart * std::sin(along));
    const auto objects = [&](const std::string& kind) {
        return box("a", "0, 2, 0", "0.4, 0.1, 0.1", kind + R"(, "rotation": [0, 0, 30])") + ", "
               + box("b", second + ", 0", "0.4, 0.1, 0.1", kind + R"(, "rotation": [90, 0, 30])");
    };
    const std::string between = R"(, "glue": [{"between": ["a", "b"]}])";
    for (const std::string& kind : {pieces, std::string(R"("breakable": false, "material": "wood")")}) {
        CAPTURE(kind);
        Run run(scene_of(objects(kind), between));
        CHECK(run.scene.notes.empty());
        Simulation& simulation = run.simulation;
        REQUIRE(simulation.structures().size() == 1);
        CHECK(simulation.body_of(run.pieces_of("a")[0]) == simulation.body_of(run.pieces_of("b")[0]));
        CHECK(simulation.world().body_count() == 1);
        // Each piece starts where its object has it.
        std::vector<physics::Pose> before;
        for (uint32_t piece = 0; piece < simulation.piece_count(); ++piece) before.push_back(simulation.pose_of(piece));
        Run loose(scene_of(objects(kind)));
        REQUIRE(loose.simulation.piece_count() == before.size());
        for (uint32_t piece = 0; piece < before.size(); ++piece) {
            const physics::Pose alone = loose.simulation.pose_of(piece);
            CHECK(glm::length(alone.position - before[piece].position) < 1e-5f);
            CHECK(std::abs(glm::dot(alone.orientation, before[piece].orientation)) == doctest::Approx(1.0f));
        }
        // The momentum book, of a fall with a push: gravity gives what it gives to the mass of both.
        simulation.apply(Push{0, {0.0, 2.0, 0.0}, {10.0, 0.0, 5.0}});
        const physics::Mechanics pushed = simulation.world().mechanics();
        run.take(20);
        const physics::Mechanics later = simulation.world().mechanics();
        CHECK(later.momentum.x == doctest::Approx(pushed.momentum.x).epsilon(1e-2)); // less the drag of the air
        const double mass = (later.momentum.y - pushed.momentum.y) / (-9.81 * 20.0 / 120.0);
        const double density = static_cast<double>(physics::material_preset("wood")->material.density);
        CHECK(mass == doctest::Approx(density * 2.0 * 0.8 * 0.2 * 0.2).epsilon(1e-2));
        // Broken by hand: two bodies, the same momentum.
        simulation.apply(Saw{{-1.0, 2.0, 0.0}, {1.0, 2.0, 0.0}, 5.0, 1.0});
        const glm::dvec3 momentum = simulation.world().mechanics().momentum;
        simulation.step();
        CHECK(simulation.world().body_count() == before.size());
        const glm::dvec3 broken = simulation.world().mechanics().momentum;
        CHECK(broken.x == doctest::Approx(momentum.x).epsilon(1e-3));
        CHECK(broken.z == doctest::Approx(momentum.z).epsilon(1e-3));
        for (const physics::Structure* structure : simulation.structures()) CHECK(structure->graph().live_count() == 0);
    }
}

TEST_CASE(
    "scene glue: a tower of three falls once its lowest object is loose, and a wall that breaks drops its shelf") {
    const std::string held =
        R"("bonded": true, "anchored": true, "material": "stone", "pattern": {"type": "grid", "count": 8})";
    const std::string tower = box("foot", "0, 0.5, 0", "0.3, 0.5, 0.3", held) + ", "
                              + box("middle", "0, 1.5, 0", "0.25, 0.5, 0.25", pieces) + ", "
                              + box("top", "0.4, 2.2, 0", "0.6, 0.2, 0.2", R"("breakable": false, "material": "wood")");
    Run run(scene_of(tower, R"(, "glue": [{"between": ["*", "*"]}])"));
    CHECK(run.scene.notes.empty());
    REQUIRE(run.simulation.structures().size() == 1);
    const physics::BodyId body = run.simulation.body_of(run.pieces_of("top")[0]);
    CHECK(run.simulation.body_of(run.pieces_of("foot")[0]) == body);
    CHECK(run.simulation.world().fixed(body));
    const double before = run.height_of("top");
    run.take(120);
    CHECK(std::abs(run.height_of("top") - before) < 1e-6); // its middle is beyond the edge of what it stands on
    run.simulation.apply(Saw{{-1.0, 0.99, 0.0}, {1.0, 0.99, 0.0}, 1.0, 1.0});
    run.take(1);
    CHECK_FALSE(run.simulation.world().fixed(run.simulation.body_of(run.pieces_of("top")[0])));
    run.take(240);
    CHECK(run.height_of("top") < before - 0.5);
}

TEST_CASE("scene glue: runs repeat with any number of threads, from their logs too, and are other runs without glue") {
    const std::string objects =
        box("wall", "0, 1, -0.1", "1, 1, 0.1",
            R"("bonded": true, "anchored": true, "material": "brick", "pattern": {"type": "bricks", "count": 60})")
        + ", " + box("shelf", "0, 1.5, 0.15", "0.5, 0.02, 0.15", pieces + R"(, "min_size": 0.02)") + ", "
        + box("bracket", "0, 1.38, 0.1", "0.02, 0.1, 0.1",
              R"("breakable": false, "material": "wood", "rotation": [0, 0, 0])")
        + ", " + box("vase", "-0.6, 1.5, 0.1", "0.1, 0.3, 0.1", R"("material": "ceramic", "min_size": 0.02)");
    const std::string shots =
        R"(, "world": {"shots": [{"time": 0.1, "from": [0.1, 1.5, 4], "velocity": [0, 0, -25], "radius": 0.12}]})";
    const std::string all =
        R"(, "glue": [{"between": ["shelf", "wall"]}, {"between": ["bracket", "*"], "strength": 0.5},
                       {"between": ["vase", "*"]}])";
    const Folder folder;
    const std::string log = folder / "run.log";
    const auto play = [&](const std::string& more, uint32_t threads, bool recorded) {
        FractureOptions options = scene_of(objects, more + shots);
        options.threads = threads;
        LoadedScene scene = load_scene(options);
        CHECK(scene.notes.empty());
        Simulation simulation;
        std::optional<Recorder> recorder;
        if (recorded) simulation.observe(&recorder.emplace(log, options));
        simulation.start(prepare_scene(scene), scene.world);
        CHECK(scene.notes.empty());
        while (simulation.steps() < 180) simulation.step();
        if (recorder) recorder->finish();
        return simulation.state_hash();
    };
    const uint64_t one = play(all, 1, true);
    CHECK(play(all, 2, false) == one);
    CHECK(play(all, 7, false) == one);
    CHECK(play("", 1, false) != one);
    const ReplayLog read = read_replay_log(log);
    CHECK(read.recipe.glue.size() == 3);
    for (const uint32_t threads : {1u, 7u}) {
        uint64_t steps = 0;
        const auto difference = replayed_scene(read, threads, steps);
        CHECK_FALSE(difference.has_value());
        CHECK(steps >= 180);
    }
}

TEST_CASE("scene glue: an object that starts whole hangs on a fixed one by joints, as strong as the glue") {
    const std::string block = box("block", "0, 2, 0.15", "0.3, 0.1, 0.15", R"("material": "stone")");
    // A cantilever of m = 0.6 * 0.2 * 0.3 m^3 * density: its moment m g 0.15 m breaks glue first.
    for (const double strength : {0.0, 1.0, 1e-3}) {
        CAPTURE(strength);
        Run run(scene_of(wall + ", " + block, strength > 0.0
                                                  ? R"(, "glue": [{"between": ["block", "wall"], "strength": )"
                                                        + std::to_string(strength) + "}]"
                                                  : ""));
        CHECK(run.scene.notes.empty());
        CHECK(run.simulation.structures().empty());
        double force = 0.0; // N, that the joints bear at most
        for (const physics::JointId joint : run.simulation.world().joints())
            force += static_cast<double>(run.simulation.world().joint(joint).max_force);
        const auto stone = static_cast<double>(physics::material_preset("stone")->material.tensile);
        CHECK(force == doctest::Approx(0.6 * 0.2 * 0.1 * stone * strength).epsilon(1e-4));
        const double before = run.height_of("block");
        run.take(120);
        CHECK((std::abs(run.height_of("block") - before) < 1e-4) == (strength == 1.0));
        CHECK((run.height_of("block") < before - 0.5) == (strength != 1.0));
    }
}

TEST_CASE("scene glue: what a blow leaves of an object stays glued where it was") {
    // A beam under a ceiling, glued along its length; a ball takes its middle.
    const std::string ceiling = box("ceiling", "0, 3.1, 0", "2, 0.1, 1", R"("fixed": true)");
    const std::string beam = box("beam", "0, 2.9, 0", "1.5, 0.1, 0.1", R"("material": "stone", "min_size": 0.03)");
    const std::string shot =
        R"(, "world": {"shots": [{"from": [0, 2.88, 3], "velocity": [0, 0, -40], "radius": 0.08, "density": 7800}]})";
    Run run(scene_of(ceiling + ", " + beam, R"(, "glue": [{"between": ["beam", "ceiling"], "strength": 3}])" + shot));
    CHECK(run.scene.notes.empty());
    const std::vector<uint32_t> whole = run.pieces_of("beam");
    REQUIRE(whole.size() == 1);
    CHECK(run.simulation.world().joints().size() == 2);
    run.take(240);
    const std::vector<uint32_t> pieces_left = run.pieces_of("beam");
    REQUIRE(pieces_left.size() > 2);
    double hanging = 0.0, all = 0.0; // m^3
    double left = 0.0, right = 0.0;  // m, how far what hangs reaches
    int fallen = 0;
    for (const uint32_t piece : pieces_left) {
        const physics::Pose pose = run.simulation.pose_of(piece);
        const double volume = run.simulation.destruction()->solid({piece})->mass.volume;
        all += volume;
        if (pose.position.y < 1.0f) ++fallen;
        if (pose.position.y < 2.7f) continue;
        hanging += volume;
        left = std::min(left, static_cast<double>(pose.position.x));
        right = std::max(right, static_cast<double>(pose.position.x));
    }
    CHECK(all == doctest::Approx(3.0 * 0.2 * 0.2).epsilon(1e-6));
    CHECK(fallen > 0);
    CHECK(hanging > 0.5 * all);
    CHECK(left < -0.5); // both ends
    CHECK(right > 0.5);
}

TEST_CASE("scene glue: two objects that start whole fall and roll as one, and part where the glue is weak") {
    const std::string objects =
        box("a", "0, 1, 0", "0.3, 0.1, 0.1", R"("material": "wood", "min_size": 0.3, "rotation": [0, 0, 20])") + ", "
        + box("b", "0.563816, 1.205212, 0", "0.3, 0.1, 0.1",
              R"("material": "wood", "min_size": 0.3, "rotation": [0, 0, 20])");
    for (const bool is_weak : {false, true}) {
        CAPTURE(is_weak);
        Run run(scene_of(objects, std::string(R"(, "glue": [{"between": ["a", "b"], "strength": )")
                                      + (is_weak ? "1e-4" : "10") + "}]"));
        CHECK(run.scene.notes.empty());
        CHECK(run.simulation.world().body_count() == 2);
        const auto apart = [&] {
            const physics::Pose a = run.simulation.pose_of(0), b = run.simulation.pose_of(1);
            return glm::conjugate(a.orientation) * (b.position - a.position);
        };
        const glm::vec3 start = apart();
        run.take(240);
        REQUIRE(run.simulation.piece_count() == 2);
        CHECK((glm::length(apart() - start) < 1e-3f) != is_weak);
    }
}

TEST_CASE("scene glue: an object on a wall of pieces has one joint a cell, not one a piece") {
    const std::string bricks =
        box("wall", "0, 1, -0.1", "1, 1, 0.1",
            R"("bonded": true, "anchored": true, "material": "brick", "pattern": {"type": "bricks", "count": 300})");
    const std::string board = box("board", "0, 1, 0.05", "0.6, 0.3, 0.05", R"("material": "wood")");
    Run run(scene_of(bricks + ", " + board, R"(, "glue": [{"between": ["board", "wall"]}])"));
    CHECK(run.scene.notes.empty());
    const size_t joints = run.simulation.world().joints().size();
    CHECK(joints == 2); // cells of 0.6 m
    double force = 0.0;
    for (const physics::JointId joint : run.simulation.world().joints())
        force += static_cast<double>(run.simulation.world().joint(joint).max_force);
    const auto tensile = static_cast<double>(physics::material_preset("brick")->material.tensile);
    CHECK(force == doctest::Approx(1.2 * 0.6 * 0.1 * tensile).epsilon(0.02)); // less what bricks leave between them
    const double before = run.height_of("board");
    run.take(120);
    CHECK(std::abs(run.height_of("board") - before) < 1e-4);
}

TEST_CASE("scene glue: too many joints of one group are refused, and many groups are not") {
    const auto blocks = [](double apart) {
        std::string all = box("floor", "0, -0.1, 0", "10, 0.1, 10", R"("fixed": true)");
        for (int k = 0; k < 40; ++k)
            for (const double y : {0.1, 0.3})
                all += ", "
                       + box("block " + std::to_string(2 * k + (y > 0.2)),
                             std::to_string(apart * k) + ", " + std::to_string(y) + ", 0", "0.1, 0.1, 0.1",
                             R"("material": "stone", "min_size": 0.5)");
        return all;
    };
    const std::string everything = R"(, "glue": [{"between": ["*", "*"]}])";
    CHECK(Run(scene_of(blocks(0.25), everything)).simulation.world().joints().size() == 2 * 40 * 4);
    // On something anchored each moves by itself, whichever comes first in the scene.
    std::string tiles;
    for (int k = 0; k < 120; ++k)
        tiles += (k > 0 ? ", " : "")
                 + box("tile " + std::to_string(k),
                       std::to_string(0.15 * (k % 12) - 0.9) + ", " + std::to_string(0.15 * (k / 12) + 0.2) + ", 0.01",
                       "0.05, 0.05, 0.01", R"("material": "ceramic", "min_size": 0.1)");
    const std::string board =
        box("board", "0, 1, -0.1", "1.1, 1, 0.1", R"("bonded": true, "anchored": true, "material": "wood")");
    for (const std::string& all : {tiles + ", " + board, board + ", " + tiles})
        CHECK(Run(scene_of(all, R"(, "glue": [{"between": ["tile*", "board"]}])")).simulation.world().joints().size()
              >= 120);
    std::string message;
    try {
        const Run refused(scene_of(blocks(0.2), everything));
    } catch (const Failure& failure) {
        CHECK(failure.code() == exit_input);
        message = failure.what();
    }
    CAPTURE(message);
    CHECK(message.find("/glue: 80 objects that start whole") == 0);
}

TEST_CASE("scene glue: a state of glued objects is exported with the bonds of each in its own coordinates") {
    Run glued(scene_of(box("a", "0, 2, 0", "0.2, 0.2, 0.2", pieces) + ", "
                           + box("b", "0, 2, 0.4", "0.2, 0.2, 0.2", pieces + R"(, "rotation": [0, 90, 0])"),
                       R"(, "glue": [{"between": ["a", "b"]}])"));
    const std::vector<Snapshot> states = object_snapshots(glued.simulation);
    REQUIRE(states.size() == 2);
    for (const Snapshot& state : states) {
        CHECK(state.pieces.size() == 8);
        REQUIRE(state.bonds.size() == 12); // of a cube in eight; the glue is of no single object
        for (const fracture::Bond& bond : state.bonds)
            for (int axis = 0; axis < 3; ++axis) CHECK(std::abs(bond.centroid[axis]) < 0.11);
    }
}

TEST_CASE("scene glue: the balcony hangs on its wall until a ball takes the bricks behind it") {
    FractureOptions options;
    read_recipe(BRITTLE_ASSETS "/worlds/balcony.json", options);
    Run run(options);
    CHECK(run.scene.notes.empty());
    CHECK(run.simulation.structures().size() == 1);
    run.take(58); // the first ball hits the parapet later
    CHECK(run.height_of("slab") > 1.5);
    CHECK(run.bodies_of("slab") == 1);
    run.take(92); // and the second one comes at 156
    CHECK(run.height_of("slab") > 1.5);
    CHECK(run.pieces_of("parapet front").size() > 3);
    run.take(330);
    CHECK(run.height_of("slab") < 0.6);
}

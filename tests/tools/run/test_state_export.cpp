// Export of the pieces of a run as blows have cut them. The simulation's own poses, bodies and bonds are the reference.
#include <algorithm>
#include <cstring>
#include <map>
#include <set>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <nlohmann/json.hpp>

#include "fracture/io/import.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/mesh/topology.h"
#include "tests/tools/support.h"
#include "tests/tools/wall.h"
#include "tools/brittle/stage/stage.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/run/state_export.h"

using namespace brittle;
using namespace brittle::tools;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

struct Run {
    FractureOptions options;
    Input source;
    std::shared_ptr<const fracture::Fragments> fragments;
    Simulation simulation;

    explicit Run(FractureOptions recipe) : options(std::move(recipe)), simulation(options.material) {
        source = load_input(options, true);
        fragments = std::make_shared<const fracture::Fragments>(
            break_input(placed_on_stage(source, options.world), options).fragments);
        simulation.start(*fragments, options.world);
    }
    void steps(int count) {
        for (int k = 0; k < count; ++k) simulation.step();
    }
    [[nodiscard]] StagePlacement placement() const { return placement_on_stage(source.model.mesh, options.world); }
    [[nodiscard]] Snapshot state() const { return snapshot(simulation, fragments); }
    std::vector<fs::path> write(const fs::path& file, PiecesAs as, ExportSettings settings = {}) const {
        settings.output = file.string();
        return write_state(settings, as, options, source, state());
    }
};

FractureOptions block() {
    FractureOptions options;
    options.mesh = "shape:lattice_cube";
    use_material("stone", options);
    options.world.breakable = true;
    options.world.blow_pieces = 20;
    return options;
}

// A mesh hit from two sides while it falls; it is still breaking at the end.
void strike_twice(Run& run) {
    run.steps(10);
    run.simulation.apply(Hammer{0, {0.3, 0.9, 0.4}, {0.0, 0.0, -4000.0}});
    run.steps(60);
    for (uint32_t piece = 0; piece < run.simulation.number_count(); ++piece)
        if (run.simulation.body_of(piece) != physics::BodyId{})
            run.simulation.apply(Hammer{piece, {-0.5, 0.6, -0.3}, {0.0, 0.0, 3000.0}});
    run.steps(40);
}

json document_of(const fs::path& glb) {
    const std::string bytes = test::read_text(glb);
    uint32_t size = 0;
    std::memcpy(&size, bytes.data() + 12, 4);
    return json::parse(bytes.substr(20, size));
}

double volume_of(const fs::path& file, bool* closed = nullptr) {
    const fracture::Model model = must(fracture::import_model(file));
    if (closed) *closed = fracture::check_topology(model.mesh.positions.size(), model.mesh.triangles).closed();
    return fracture::signed_volume(model.mesh.positions, model.mesh.triangles);
}

double input_volume(const Run& run) {
    return fracture::signed_volume(run.source.model.mesh.positions, run.source.model.mesh.triangles);
}

} // namespace

TEST_CASE("state export: pieces cut by blows are closed, volume is kept, and each body is written once at its place") {
    Run run(block());
    strike_twice(run);
    const Snapshot state = run.state();
    const physics::Destruction& destruction = *run.simulation.destruction();
    uint32_t deepest = 0;
    for (const physics::PieceId id : destruction.pieces()) deepest = std::max(deepest, destruction.depth(id));
    REQUIRE(deepest >= 2); // cuts of cuts
    REQUIRE(state.pieces.size() > 15);
    CHECK(state.pieces.size() == run.simulation.world().body_count());

    const StagePlacement placement = run.placement();
    const LivePieces live = live_pieces(state, placement);
    REQUIRE(live.fragments.pieces.size() == state.pieces.size());
    REQUIRE(live.poses.size() == state.pieces.size());
    std::set<physics::BodyId> bodies;
    double sum = 0.0;
    for (size_t p = 0; p < state.pieces.size(); ++p) {
        const fracture::Piece& piece = live.fragments.pieces[p];
        const auto positions = live.fragments.positions_of(piece);
        CHECK(fracture::check_topology(positions.size(), live.fragments.triangles_of(piece)).closed());
        const fracture::MassProperties mass = fracture::mass_properties(positions, live.fragments.triangles_of(piece));
        CHECK(mass.volume == doctest::Approx(piece.mass.volume).epsilon(1e-5));
        CHECK(mass.area == doctest::Approx(piece.mass.area).epsilon(1e-5));
        CHECK(mass.inertia[0][0] == doctest::Approx(piece.mass.inertia[0][0]).epsilon(1e-4));
        CHECK(glm::distance(mass.centre_of_mass, piece.mass.centre_of_mass) < 1e-6);
        sum += mass.volume;
        const physics::BodyId body = run.simulation.body_of(state.pieces[p].number);
        bodies.insert(body);
        const physics::Pose pose = run.simulation.world().pose(body);
        CHECK(glm::distance(placement.to_stage(live.poses[p].position), glm::dvec3(pose.position)) < 1e-6);
        CHECK(std::abs(glm::dot(live.poses[p].orientation, glm::normalize(glm::dquat(pose.orientation))))
              > 1.0 - 1e-12);
    }
    CHECK(bodies.size() == state.pieces.size());
    CHECK(sum == doctest::Approx(input_volume(run)).epsilon(1e-6)); // small pieces have single precision
}

TEST_CASE("state export: files of every format hold each piece as it lies or as it was made") {
    const test::Folder folder;
    Run run(block());
    strike_twice(run);
    const StagePlacement placement = run.placement();
    const Snapshot state = run.state();
    for (const std::string ending : {".glb", ".obj", ".ply", ".stl"}) {
        CAPTURE(ending);
        const auto lie = run.write(folder / ("lie" + ending), PiecesAs::they_lie, {.per_piece = true});
        const auto made = run.write(folder / ("made" + ending), PiecesAs::made, {.per_piece = true});
        REQUIRE(lie.size() == state.pieces.size());
        REQUIRE(made.size() == state.pieces.size());
        double sum = 0.0, turned = 0.0;
        for (size_t p = 0; p < lie.size(); ++p) {
            bool closed = false;
            sum += volume_of(lie[p], &closed);
            CHECK(closed);
            CHECK(volume_of(made[p]) == doctest::Approx(volume_of(lie[p])).epsilon(1e-4));
            // Both files list the same vertices in the same order, one moved by the pose of the body.
            const fracture::TriangleMesh a = must(fracture::import_mesh(made[p])),
                                         b = must(fracture::import_mesh(lie[p]));
            REQUIRE(a.triangles.size() == b.triangles.size());
            const physics::Pose pose = run.simulation.world().pose(run.simulation.body_of(state.pieces[p].number));
            const glm::dmat3 turn(glm::mat3_cast(pose.orientation));
            turned = std::max(turned, 1.0 - turn[1][1]);
            const glm::dvec3 centre = state.pieces[p].solid->mass.centre_of_mass;
            for (size_t t = 0; t < a.triangles.size(); ++t)
                for (int k = 0; k < 3; ++k) {
                    const glm::dvec3 from = placement.to_stage(a.positions[a.triangles[t][k]]) - centre;
                    const glm::dvec3 there = glm::dvec3(pose.position) + turn * from;
                    CHECK(glm::distance(placement.to_stage(b.positions[b.triangles[t][k]]), there) < 4e-6); // m, of 2 m
                }
        }
        CHECK(sum == doctest::Approx(input_volume(run)).epsilon(1e-5));
        CHECK(turned > 0.01); // rotation must matter
    }
    CHECK(run.write(folder / "split.stl", PiecesAs::they_lie).size() == state.pieces.size());
    CHECK(run.write(folder / "one.stl", PiecesAs::they_lie, {.one_file = true}).size() == 1);
    CHECK(run.write(folder / "one.ply", PiecesAs::they_lie).size() == 1);
}

TEST_CASE("state export: interiors, looks and hulls are written, with several hulls for a piece that is not convex") {
    const test::Folder folder;
    FractureOptions options;
    options.mesh = std::string(BRITTLE_CORPUS) + "/meshes/crate.glb";
    options.world.breakable = true;
    Run run(options);
    run.steps(1);
    run.simulation.apply(Hammer{0, {0.9, 1.0, 0.9}, {-2500.0, 0.0, -2500.0}});
    run.steps(10);
    const Snapshot state = run.state();
    REQUIRE(state.pieces.size() > 4);
    const fs::path file =
        run.write(folder / "crate.glb", PiecesAs::they_lie, {.hulls = "unreal", .rigid_bodies = true}).front();
    const json document = document_of(file);
    size_t pieces = 0, hulls = 0, cuts = 0;
    double mass = 0.0;
    for (const json& node : document["nodes"]) {
        const std::string name = node["name"];
        hulls += name.starts_with("UCX_crate_") ? 1 : 0;
        if (!node.contains("extras") || !node["extras"]["brittle"].contains("volume")) continue;
        ++pieces;
        cuts += node["extras"]["brittle"]["interior_triangles"].get<size_t>();
        mass += node["extensions"]["KHR_physics_rigid_bodies"]["motion"]["mass"].get<double>();
        CHECK(node.contains("rotation"));
        CHECK(node["children"].size() >= 1);
    }
    CHECK(pieces == state.pieces.size());
    CHECK(hulls >= pieces);
    CHECK(mass == doctest::Approx(double{physics::Material{}.density} * input_volume(run)).epsilon(1e-5));
    CHECK(document["images"].size() >= 1);
    const fracture::Model back = must(fracture::import_model(file));
    const auto interior =
        std::find_if(back.materials.begin(), back.materials.end(), [](const auto& m) { return m.name == "interior"; });
    REQUIRE(interior != back.materials.end());
    CHECK(std::count(back.material_of.begin(), back.material_of.end(),
                     static_cast<uint32_t>(interior - back.materials.begin()))
          == static_cast<std::ptrdiff_t>(cuts));
    REQUIRE(!back.uv[0].empty());
}

TEST_CASE("state export: hulls of rough pieces end where the pieces meet, whether bonds hold or not") {
    const test::Folder folder;
    FractureOptions options = test::wall_options();
    options.pattern.kind = fracture::PatternKind::uniform;
    options.rough = {.amount = 1.0, .detail = 2};
    options.world.anchored = false;
    Run run(options);
    REQUIRE(run.state().bonds.empty());
    double uncut = 0.0;
    for (const fracture::Piece& piece : run.fragments->pieces) {
        for (const fracture::TriangleMesh& hull : physics::hull_meshes(*run.fragments, piece, {}))
            uncut += fracture::signed_volume(hull.positions, hull.triangles);
    }
    double whole = 0.0;
    for (const fracture::Piece& piece : run.fragments->pieces) whole += piece.mass.volume;
    REQUIRE(uncut > 1.05 * whole);
    const double input = input_volume(run);
    const fs::path file = run.write(folder / "wall.glb", PiecesAs::made, {.hulls = "unreal"}).front();
    const double hulls = volume_of(file) - input; // the importer reads pieces and hulls
    CHECK(hulls > 0.9 * input);
    CHECK(hulls < 1.01 * input);
}

TEST_CASE("state export: unbroken bonds are written, and bonded pieces lie where their body moved them") {
    const test::Folder folder;
    for (const bool breakable : {false, true}) {
        CAPTURE(breakable);
        FractureOptions options = test::wall_options();
        options.world.bonded = true;
        options.world.breakable = breakable;
        Run run(options);
        const size_t all = run.state().bonds.size();
        CHECK(all == run.simulation.structure()->graph().live_count());
        run.simulation.apply(Shoot{{0.1, 1.2, 2.0}, {0.0, 0.0, -25.0}, 0.15, 7800.0});
        run.steps(60);
        const Snapshot state = run.state();
        REQUIRE(state.bonds.size() < all);
        CHECK(state.bonds.size() == run.simulation.structure()->graph().live_count());
        for (const fracture::Bond& bond : state.bonds) { // bonded pieces move together
            const auto &a = state.pieces[bond.a], &b = state.pieces[bond.b];
            CHECK(run.simulation.body_of(a.number) == run.simulation.body_of(b.number));
            CHECK(a.pose.orientation == b.pose.orientation);
        }
        std::set<physics::BodyId> bodies; // without the ball
        for (const Snapshot::Piece& piece : state.pieces) bodies.insert(run.simulation.body_of(piece.number));
        CHECK(bodies.size() + 1 == run.simulation.world().body_count());
        if (!breakable) CHECK(state.pieces.size() == run.fragments->pieces.size());

        const fs::path file = run.write(folder / "wall.glb", PiecesAs::they_lie).front();
        size_t bonds = 0;
        const json document = document_of(file);
        for (const json& node : document["nodes"])
            if (node.contains("extras") && node["extras"]["brittle"].contains("bonds"))
                bonds += node["extras"]["brittle"]["bonds"].size();
        CHECK(bonds == state.bonds.size());
        CHECK(volume_of(file) == doctest::Approx(input_volume(run)).epsilon(1e-5));
        // The pose of a piece of a body: the offset of its centre, rotated.
        const LivePieces live = live_pieces(state, run.placement());
        for (size_t p = 0; p < state.pieces.size(); ++p) {
            const auto number = state.pieces[p].number;
            const auto bonded = breakable ? run.simulation.destruction()->bonded({number}) : std::optional(number);
            if (!bonded) continue;
            const physics::Pose pose = run.simulation.world().pose(run.simulation.body_of(number));
            const glm::vec3 at =
                pose.position + glm::mat3_cast(pose.orientation) * run.simulation.structure()->offset(*bonded);
            CHECK(glm::distance(run.placement().to_stage(live.poses[p].position), glm::dvec3(at)) < 2e-6);
        }
    }
}

TEST_CASE("state export: before anything moves, pieces as they lie equal pieces as made") {
    const test::Folder folder;
    FractureOptions options;
    options.mesh = "shape:cube";
    options.pattern.count = 7;
    const Run run(options);
    const LivePieces live = live_pieces(run.state(), run.placement());
    const Broken made = break_input(run.source, options);
    REQUIRE(live.fragments.pieces.size() == made.fragments.pieces.size());
    REQUIRE(live.fragments.positions.size() == made.fragments.positions.size());
    for (size_t v = 0; v < made.fragments.positions.size(); ++v)
        CHECK(glm::distance(live.fragments.positions[v], made.fragments.positions[v]) < 1e-12);
    for (size_t p = 0; p < live.poses.size(); ++p) {
        CHECK(glm::distance(live.poses[p].position, made.fragments.pieces[p].mass.centre_of_mass) < 1e-6);
        CHECK(live.poses[p].orientation.w > 1.0 - 1e-12);
    }
}

TEST_CASE("state export: a failed or cancelled export leaves the old file, and a changed mesh is refused") {
    const test::Folder folder;
    Run run(block());
    strike_twice(run);
    const std::string file = folder.write("old.glb", "old");
    const auto refused = [&](ExportSettings settings, const Input& source, const std::function<bool()>& cancelled) {
        try {
            (void)write_state(settings, PiecesAs::they_lie, run.options, source, run.state(), cancelled);
        } catch (const Failure& failure) {
            return failure.code();
        }
        return exit_success;
    };
    CHECK(refused({.output = file}, run.source, [] { return true; }) == exit_interrupted);
    CHECK(refused({.output = file, .hulls = "unreal"}, run.source, [] { return true; }) == exit_interrupted);
    CHECK(refused({.output = file, .interior_texture = folder / "none.png"}, run.source, {}) != exit_success);
    CHECK(refused({.output = folder / "none/a.glb"}, run.source, {}) == exit_output);
    Input other = run.source;
    other.model.mesh.triangles.resize(1);
    CHECK(refused({.output = file}, other, {}) == exit_mesh);
    CHECK(test::read_text(file) == "old");
    CHECK(folder.files() == 1);
    CHECK(refused({.output = file}, run.source, [] { return false; }) == exit_success);
    CHECK(volume_of(file) == doctest::Approx(input_volume(run)).epsilon(1e-5));
    CHECK_THROWS_AS((void)pieces_as("lies"), Failure);
}

// Preparation of pieces for a stage outside its frames.
#include <cstdlib>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/shapes/shapes.h"
#include "physics/cutting/destruction.h"
#include "tests/engine/support.h"
#include "tests/folder.h"
#include "tools/brittle/base/device_failure.h"
#include "tools/brittle/stage/loading.h"
#include "tools/brittle/stage/stage.h"
#include "tools/scenario/base/failure.h"
#include "tools/scenario/recipe/recipe.h"
#include "tools/scenario/run/scene.h"

using namespace brittle;
using namespace brittle::tools;
using brittle::test_files::Folder;

namespace {

struct Theatre {
    std::unique_ptr<engine::Device> device = engine::test::make_device();
    std::unique_ptr<engine::Renderer> renderer = device ? must(engine::Renderer::create(*device)) : nullptr;
    Input input;
    FractureOptions options;

    explicit Theatre(bool breakable) {
        options.world.breakable = breakable;
        options.pattern.count = 4;
        input.model.mesh = fracture::icosphere(5); // 20,480 triangles
        input = placed_on_stage(std::move(input), options.world);
        input.sites = {{-0.5, 1.5, 0.0}, {0.5, 1.5, 0.0}};
    }
    [[nodiscard]] PreparedPieces prepare() const {
        const Broken broken = break_input(input, options);
        return prepare_pieces(*renderer, broken.fragments, options.world, options.material);
    }
    [[nodiscard]] engine::Bitmap draw(Stage& stage) const {
        engine::Scene scene = stage.scene();
        scene.camera = engine::look_at_bounds(stage.home_bounds(), 0.5f, 0.3f, 1.0f);
        return must(renderer->render(scene, {64, 64}));
    }
};

} // namespace

TEST_CASE("stage: new pieces are staged for the device ahead, whether cut beforehand or by a blow") {
    const Theatre cut(false), whole(true);
    if (!cut.device) return;
    const PreparedPieces pieces = cut.prepare();
    CHECK(pieces.batch.pieces().size() == 2);
    CHECK(pieces.batch.staged());

    const PreparedPieces solid = whole.prepare();
    REQUIRE(solid.object.bodies.solids.size() == 1);
    REQUIRE(solid.object.bodies.payloads.size() == 1);
    const auto* drawing = static_cast<const PieceDrawing*>(solid.object.bodies.payloads[0].get());
    REQUIRE(drawing);
    CHECK(drawing->batch.pieces().size() == drawing->made.size());
    CHECK(drawing->made.size() >= 5); // a part has 4,096 triangles at most
    CHECK(drawing->kept.empty());
    CHECK(drawing->batch.staged());
}

TEST_CASE("stage: a blow makes new parts of a large piece near it alone, and they draw each triangle once") {
    const Theatre theatre(true);
    if (!theatre.device) return;
    physics::BreakableDesc desc;
    desc.solid.min_size = 0.01;
    const physics::SolidPtr whole = must(physics::make_solid(theatre.input.model.mesh, desc.solid));
    const auto before = draw_piece(*whole, nullptr);
    const glm::dvec3 point = whole->surface().mesh.positions[0];
    const physics::Blow blow{point, glm::normalize(whole->mass.centre_of_mass - point), 1e3, 1e9};
    const physics::ImpactSites sites =
        physics::impact_sites(whole->clusters, whole->mass, blow, {0.1, 9, false}, {.seed = 3});
    const auto pieces = must(physics::break_solid(*whole, sites.sites, sites.groups, desc.solid));
    size_t large = 0;
    for (const physics::SolidPtr& piece : pieces) {
        const auto drawing = draw_piece(*piece, whole.get());
        if (!piece->is_clustered()) {
            CHECK(drawing->batch.pieces().size() == 1);
            CHECK(drawing->made.empty());
            continue;
        }
        ++large;
        CHECK(drawing->kept.size() >= before->made.size() / 2);
        CHECK(drawing->batch.bytes() < before->batch.bytes() / 2);
        size_t indices = drawing->batch.indices().size();
        for (const fracture::ClusterBranch& branch : drawing->kept) indices += 3 * branch.triangle_count();
        CHECK(indices == 3 * piece->triangle_count());
    }
    CHECK(large == 1);
}

TEST_CASE("stage: a batch of the whole mesh and its replacement are drawn equally, staged ahead or not") {
    const Theatre theatre(true);
    if (!theatre.device) return;
    Stage of_mesh(*theatre.renderer, theatre.input.model.mesh);
    const engine::Bitmap expected = theatre.draw(of_mesh);
    engine::PieceBatch batch = batch_of(theatre.input.model.mesh);
    const fracture::Box box = fracture::bounds(theatre.input.model.mesh);
    for (int staged = 0; staged < 2; ++staged) {
        Stage of_batch(*theatre.renderer, box, batch);
        CHECK(theatre.draw(of_batch).pixels == expected.pixels);
        theatre.renderer->stage(batch);
    }
    const Broken broken = break_input(theatre.input, theatre.options);
    of_mesh.stand(broken.fragments, theatre.options.world, theatre.prepare());
    CHECK(of_mesh.broken());
    CHECK(theatre.draw(of_mesh).pixels == expected.pixels);
}

namespace {

// The pieces as the stage draws them, and as they are drawn as a whole each.
void check_pictures(const Theatre& theatre, Stage& stage) {
    const physics::Destruction& destruction = *stage.simulation().destruction();
    engine::Scene scene = stage.scene();
    scene.camera = engine::look_at_bounds(stage.home_bounds(), 0.9f, 0.3f, 1.0f);
    scene.look.tint = 0.0f;
    std::vector<engine::PieceMesh> meshes;
    for (const physics::PieceId id : destruction.pieces()) {
        const physics::SolidSurface& surface = destruction.solid(id)->surface();
        meshes.push_back({.positions = surface.positions,
                          .triangles = surface.mesh.triangles,
                          .exterior_triangles = surface.exterior_triangles,
                          .body = destruction.slot(id)});
    }
    const std::unique_ptr<engine::Renderer> other = must(engine::Renderer::create(*theatre.device));
    (void)must(other->add_pieces(meshes));
    for (const bool smooth : {false, true}) {
        scene.smooth = smooth;
        const engine::Bitmap is = must(theatre.renderer->render(scene, {160, 160}));
        const engine::Bitmap should = must(other->render(scene, {160, 160}));
        size_t different = 0; // rounding moves edges, and a shaded vertex beside a crack may keep its former normal
        for (size_t i = 0; i < is.pixels.size(); ++i) different += std::abs(is.pixels[i] - should.pixels[i]) > 3;
        CAPTURE(smooth);
        CHECK(different < is.pixels.size() / 500);
    }
    const engine::IdImage ids = must(theatre.renderer->render_ids(scene, {160, 160}));
    for (const uint32_t id : ids.ids) REQUIRE((id == 0 || destruction.contains({id - 1})));
}

} // namespace

TEST_CASE("stage: a large piece in parts looks like the whole, however many blows come between two frames") {
    Theatre theatre(true);
    if (!theatre.device) return;
    for (int k = 0; k < 3; ++k) {
        const double side = k % 2 == 0 ? 1.0 : -1.0;
        theatre.options.world.shots.push_back(
            {.time = 0.2 * k, .from = {side * 0.2, 1.0, 4.0}, .velocity = {-side * 0.5, 0.3, -15.0}, .radius = 0.15});
    }
    theatre.options.material = "stone";
    for (const int frames_between : {1, 40}) {
        Stage stage(*theatre.renderer, theatre.input.model.mesh, theatre.options.material);
        const Broken broken = break_input(theatre.input, theatre.options);
        stage.stand(broken.fragments, theatre.options.world, theatre.prepare());
        uint32_t breaks = 0;
        for (int frame = 0; frame < 80; ++frame) {
            if (frame % frames_between != 0) {
                (void)stage.simulation().advance(1.0 / 60.0);
                continue;
            }
            stage.advance(1.0 / 60.0);
            const uint32_t now = stage.simulation().destruction()->statistics().breaks;
            if (now != breaks) check_pictures(theatre, stage);
            breaks = now;
        }
        CHECK(breaks >= 2);
    }
}

TEST_CASE("stage: copies of an object share its geometry, and look as if each had its own, whole, hidden and broken") {
    const Theatre theatre(true), other(true);
    if (!theatre.device) return;
    const Folder folder;
    FractureOptions options;
    read_recipe(folder.write("copies.json", R"({"brittle": 2, "objects": [
        {"name": "a", "mesh": "shape:statue", "material": "stone"},
        {"name": "step", "mesh": "shape:cube", "scale": [1, 0.1, 1], "translation": [0, 0, 2], "fixed": true},
        {"name": "b", "mesh": "shape:statue", "material": "stone", "translation": [1.2, 0, 0.4], "rotation": [0, 40, 0]},
        {"name": "c", "mesh": "shape:statue", "material": "stone", "translation": [2.4, 0, 0.8]},
        {"name": "vase", "mesh": "shape:vase", "material": "ceramic", "translation": [1, 0, 1.5]},
        {"name": "another step", "mesh": "shape:cube", "scale": [1, 0.1, 1], "translation": [3, 0, 2], "fixed": true},
        {"name": "another vase", "mesh": "shape:vase", "material": "ceramic", "translation": [3, 0, 1.5]}],
        "world": {"shots": [{"time": 0.05, "from": [1.2, 1.2, 4], "velocity": [0, 0, -25], "radius": 0.15},
                            {"time": 0.2, "from": [3, 0.3, 4], "velocity": [0, 0, -15], "radius": 0.1}]}})"),
                options);
    LoadedScene scene = load_scene(options, drawing_host());
    const DrawingMaker maker = payload_maker(*theatre.renderer), others_maker = payload_maker(*other.renderer);
    std::vector<PreparedObject> sharing = prepare_scene(scene, drawing_host(), maker), own;
    size_t payloads = 0;
    for (const PreparedObject& object : sharing) {
        own.push_back(copy_of(object, others_maker));
        own.back().placement = object.placement;
        for (const physics::PayloadPtr& payload : object.bodies.payloads) payloads += payload ? 1 : 0;
    }
    CHECK(payloads == 3); // a statue, a step and a vase
    // Without any payload, the stage makes one for each solid.
    std::vector<PreparedObject> bare;
    for (const PreparedObject& object : sharing) {
        bare.push_back(copy_of(object));
        bare.back().placement = object.placement;
    }
    Stage unprepared(*other.renderer, scene.home);
    unprepared.stand(std::move(bare), scene.world);
    const engine::Bitmap made_here = other.draw(unprepared);
    Stage stage(*theatre.renderer, scene.home), expected(*other.renderer, scene.home);
    stage.stand(std::move(sharing), scene.world);
    expected.stand(std::move(own), scene.world);
    CHECK(theatre.draw(stage).pixels == other.draw(expected).pixels);
    CHECK(theatre.draw(stage).pixels == made_here.pixels);
    stage.hide({true, false, true, false, false, false, false}); // one that others share, and a copy
    expected.hide({true, false, true, false, false, false, false});
    CHECK(theatre.draw(stage).pixels == other.draw(expected).pixels);
    stage.hide({});
    expected.hide({});
    for (int frame = 0; frame < 40; ++frame) {
        stage.advance(1.0 / 60.0);
        expected.advance(1.0 / 60.0);
        if (frame % 4 == 3) REQUIRE(theatre.draw(stage).pixels == other.draw(expected).pixels);
    }
    CHECK(stage.simulation().destruction()->statistics().breaks >= 2); // a statue that is a copy, and a vase
    CHECK(stage.simulation().state_hash() == expected.simulation().state_hash());
}

// Preparation of pieces for a stage outside its frames.
#include <doctest/doctest.h>

#include "fracture/shapes/shapes.h"
#include "physics/cutting/destruction.h"
#include "tests/engine/support.h"
#include "tools/brittle/base/failure.h"
#include "tools/brittle/run/stage.h"

using namespace brittle;
using namespace brittle::tools;

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
    REQUIRE(solid.bodies.solids.size() == 1);
    REQUIRE(solid.bodies.payloads.size() == 1);
    const auto* drawing = static_cast<const PieceDrawing*>(solid.bodies.payloads[0].get());
    REQUIRE(drawing);
    CHECK(drawing->batch.pieces().size() == 1);
    CHECK(drawing->batch.staged());
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

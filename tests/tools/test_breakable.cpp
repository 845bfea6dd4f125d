// Scenes of what is cut anew where it is hit: the statue that breaks again and again, and that no cut brings momentum.
#include <algorithm>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "tests/tools/scenes.h"
#include "tools/brittle/simulation.h"

using namespace brittle;
using namespace brittle::tools;
using namespace brittle::tools::test;

namespace {

// Around each update of the destruction.
struct Books : SimulationObserver {
    physics::Mechanics before;
    int cuts = 0;
    double worst = 0.0; // relative to all that moves

    void moved(const Simulation& simulation) override { before = simulation.world().mechanics(); }
    void updated(const Simulation& simulation, const physics::Structure::Changes&) override {
        const physics::World& world = simulation.world();
        const physics::Mechanics after = world.mechanics();
        const Motion all = motion_of(world);
        cuts += static_cast<int>(simulation.commits().size());
        worst = std::max({worst, glm::length(after.momentum - before.momentum) / all.momentum,
                          glm::length(after.angular_momentum - before.angular_momentum) / all.angular});
    }
};

} // namespace

TEST_CASE("breakable: the statue's pieces' pieces' pieces break, all are closed, and nothing is lost") {
    const FractureOptions options = recipe_of<scene::statue_broken_three_levels_deep>();
    const fracture::Fragments whole = started(options);
    REQUIRE(whole.pieces.size() == 1);
    Simulation simulation(options.material);
    simulation.start(whole, options.world);
    while (simulation.steps() < 2 * options.picture.frames) simulation.step();
    const physics::Destruction& destruction = *simulation.destruction();
    CHECK(destruction.statistics().retired == 0);
    uint32_t deepest = 0;
    for (const physics::PieceId id : destruction.pieces()) deepest = std::max(deepest, destruction.depth(id));
    CHECK(deepest >= 3);
    CHECK(destruction.pieces().size() > 100);
    check_pieces(destruction, whole.pieces[0].mass.volume);
}

namespace {

using CutAnew = std::tuple<scene::glass_pane_shot_by_a_ball, scene::pane_hangs_by_its_corners, scene::statue_broken_three_levels_deep>;

} // namespace

TEST_CASE_TEMPLATE_DEFINE("breakable: momentum and angular momentum are kept across every cut, to 1e-4", Scene, momentum_of_cuts) {
    FractureOptions options = recipe_of<Scene>();
    options.world.anchored = false; // what is held gives momentum to the ground
    options.world.anchors.clear();
    options.world.height = 0.0;
    Simulation simulation(options.material);
    Books books;
    simulation.observe(&books);
    simulation.start(started(options), options.world);
    while (simulation.steps() < 2 * options.picture.frames) simulation.step();
    MESSAGE(books.cuts, " cuts, worst ", books.worst);
    CHECK(books.cuts > 3);
    CHECK(books.worst < 1e-4);
}
TEST_CASE_TEMPLATE_APPLY(momentum_of_cuts, CutAnew);

TEST_CASE("breakable: momentum is looked at wherever things are cut anew") {
    CHECK(names_of<CutAnew>() == scenes_where([](const FractureOptions& options) { return options.world.breakable; }));
}

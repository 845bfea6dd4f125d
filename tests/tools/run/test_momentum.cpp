// Momentum and angular momentum across every break of every scene with breaking bonds.
//
// The sums are compared around Structure::update(), between two steps of the world. Free bodies get momentum from fixed
// ones (the ground, an anchored body) in one way only: contacts are undone and solved again, after which
// World::contacts() has the new impulses. So a break must change the sum only by the differences of impulses between a
// free and a fixed body.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "tests/tools/scenes.h"
#include "tools/brittle/run/simulation.h"

using namespace brittle;
using namespace brittle::tools;
using namespace brittle::tools::test;

namespace {

using Wrench = std::array<double, 6>; // momentum and angular momentum

Wrench wrench(const glm::dvec3& impulse, const glm::dvec3& point) {
    const glm::dvec3 turn = glm::cross(point, impulse);
    return {impulse.x, impulse.y, impulse.z, turn.x, turn.y, turn.z};
}

// The impulses that all free bodies got from fixed ones by the contacts of a step.
struct Books : SimulationObserver {
    physics::Mechanics before;
    std::vector<Wrench> got;    // of each contact; zero if both bodies are free
    int kept = 0, answered = 0; // breaks without and with impulses from fixed bodies
    double worst = 0.0;
    uint64_t worst_step = 0;

    static Wrench from_outside(const physics::World& world, const physics::Contact& contact) {
        const auto moves = [&](physics::BodyId body) { return world.contains(body) && !world.fixed(body); };
        const double a = moves(contact.a) ? 1.0 : 0.0, b = moves(contact.b) ? 1.0 : 0.0;
        return wrench((a - b) * glm::dvec3(contact.impulse * contact.normal + contact.friction),
                      glm::dvec3(contact.point));
    }
    static bool there(const physics::World& world, physics::BodyId body) {
        return body == physics::BodyId{} || world.contains(body);
    }

    void moved(const Simulation& simulation) override {
        const physics::World& world = simulation.world();
        before = world.mechanics();
        got.clear();
        for (const physics::Contact& contact : world.contacts()) got.push_back(from_outside(world, contact));
    }

    void updated(const Simulation& simulation, const physics::Structure::Changes& changes) override {
        if (changes.removed.empty()) return;
        const physics::World& world = simulation.world();
        const physics::Mechanics after = world.mechanics();
        const glm::dvec3 linear = after.momentum - before.momentum;
        const glm::dvec3 angular = after.angular_momentum - before.angular_momentum;
        Wrench change{linear.x, linear.y, linear.z, angular.x, angular.y, angular.z};
        bool outside = false;
        REQUIRE(world.contacts().size() == got.size());
        for (size_t i = 0; i < got.size(); ++i) {
            const physics::Contact& contact = world.contacts()[i];
            // Contacts of a removed body are unchanged.
            if (!there(world, contact.a) || !there(world, contact.b)) continue;
            const Wrench now = from_outside(world, contact);
            outside = outside || now != got[i];
            for (size_t k = 0; k < change.size(); ++k) change[k] -= now[k] - got[i][k];
        }
        const Motion all = motion_of(world);
        const double error = std::max(glm::length(glm::dvec3(change[0], change[1], change[2])) / all.momentum,
                                      glm::length(glm::dvec3(change[3], change[4], change[5])) / all.angular);
        ++(outside ? answered : kept);
        if (error > worst) worst_step = simulation.steps();
        worst = std::max(worst, error);
    }
};

} // namespace

namespace {

using BondsBreak =
    std::tuple<scene::arch_loses_a_column, scene::brick_wall_rammed, scene::bunny_dropped, scene::tower_collapses>;

} // namespace

TEST_CASE_TEMPLATE_DEFINE("scenes: momentum and angular momentum are kept across every break, to 1e-4", Scene,
                          momentum) {
    const FractureOptions options = recipe_of<Scene>();
    BRITTLE_RUN_OF(options);
    Simulation simulation(options.material);
    Books books;
    simulation.observe(&books);
    simulation.start(started(options), options.world);
    while (simulation.steps() < 2 * options.picture.frames) simulation.step();
    MESSAGE(books.kept, " breaks that changed nothing, ", books.answered, " with answers of what is fixed; worst ",
            books.worst, " at step ", books.worst_step);
    CHECK(books.worst < 1e-4);
    CHECK(books.answered > 0); // otherwise the test would have tested nothing
}
TEST_CASE_TEMPLATE_APPLY(momentum, BondsBreak);

TEST_CASE("scenes: every scene with breaking bonds has a momentum test") {
    CHECK(names_of<BondsBreak>() == scenes_where([](const FractureOptions& options) {
              return !options.world.breakable && holds_together(options.world); // test_breakable.cpp has the others
          }));
}

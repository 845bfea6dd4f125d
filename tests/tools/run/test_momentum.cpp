// Momentum and angular momentum across every break of every scene with breaking bonds.
//
// The sums are compared around Structure::update(), between two steps of the world. A rewound body moves anew, and its
// motion in a step is not parallel to its momentum after it (solver/row.h). So its angular momentum is taken at the
// position at the start of the step, where its impulses act, and that of all other bodies at the present one. Free bodies get momentum from fixed
// ones (the ground, an anchored body) in two ways: contacts are undone and solved again, after which World::contacts()
// has the new impulses; and strikers hit pieces on their way (Structure::Changes::held). So a break must change the sum
// only by the differences of impulses between a free and a fixed body, and by the latter.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "tests/tools/scenes.h"
#include "tools/scenario/run/simulation.h"

using namespace brittle;
using namespace brittle::tools;
using namespace brittle::tools::test;

namespace {

using Wrench = std::array<double, 6>; // momentum and angular momentum

Wrench wrench(const glm::dvec3& impulse, const glm::dvec3& point) {
    const glm::dvec3 turn = glm::cross(point, impulse);
    return {impulse.x, impulse.y, impulse.z, turn.x, turn.y, turn.z};
}

// The momentum and spin of a body, and its place at both ends of the step.
struct Moving {
    glm::dvec3 momentum, spin;
    glm::dvec3 start, end; // m

    Moving(const physics::World& world, physics::BodyId body)
        : start(world.previous_pose(body).position), end(world.pose(body).position) {
        const physics::Mechanics mechanics = world.mechanics(body);
        momentum = mechanics.momentum;
        spin = mechanics.angular_momentum - glm::cross(end, momentum);
    }
    void add_to(Wrench& sum, bool rewound, double times) const {
        const glm::dvec3 turn = spin + glm::cross(rewound ? start : end, momentum);
        for (int k = 0; k < 3; ++k) {
            sum[static_cast<size_t>(k)] += times * momentum[k];
            sum[static_cast<size_t>(k + 3)] += times * turn[k];
        }
    }
};

// The impulses that all free bodies got from fixed ones by the contacts of a step.
struct Books : SimulationObserver {
    std::map<physics::BodyId, Moving> before;
    std::vector<physics::BodyId> bodies; // before, of each piece
    std::vector<physics::Contact> contacts;
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
        before.clear();
        for (const physics::BodyId body : world.bodies()) before.emplace(body, Moving(world, body));
        bodies.clear();
        for (uint32_t piece = 0; piece < simulation.piece_count(); ++piece) bodies.push_back(simulation.body_of(piece));
        contacts.assign(world.contacts().begin(), world.contacts().end());
        got.clear();
        for (const physics::Contact& contact : contacts) got.push_back(from_outside(world, contact));
    }

    // The bodies with a contact that was solved again, and the parts that they broke into.
    [[nodiscard]] std::set<physics::BodyId> rewound_bodies(const Simulation& simulation) const {
        std::set<physics::BodyId> rewound;
        for (size_t i = 0; i < contacts.size(); ++i) {
            const physics::Contact &was = contacts[i], &is = simulation.world().contacts()[i];
            if (was.a != is.a || was.b != is.b || was.impulse != is.impulse || was.friction != is.friction)
                rewound.insert({was.a, was.b});
        }
        for (uint32_t piece = 0; piece < bodies.size(); ++piece)
            if (rewound.contains(bodies[piece])) rewound.insert(simulation.body_of(piece));
        return rewound;
    }

    void updated(const Simulation& simulation, const physics::Structure::Changes& changes) override {
        if (changes.removed.empty()) return;
        const physics::World& world = simulation.world();
        REQUIRE(world.contacts().size() == got.size());
        const std::set<physics::BodyId> rewound = rewound_bodies(simulation);
        Wrench change{};
        for (const auto& [body, moving] : before) moving.add_to(change, rewound.contains(body), -1.0);
        for (const physics::BodyId body : world.bodies())
            Moving(world, body).add_to(change, rewound.contains(body), 1.0);
        bool outside = false;
        for (size_t i = 0; i < got.size(); ++i) {
            const physics::Contact& contact = world.contacts()[i];
            // Contacts of a removed body are unchanged.
            if (!there(world, contact.a) || !there(world, contact.b)) continue;
            const Wrench now = from_outside(world, contact);
            outside = outside || now != got[i];
            for (size_t k = 0; k < change.size(); ++k) change[k] -= now[k] - got[i][k];
        }
        for (const physics::Structure::Changes::Held& held : changes.held) {
            const Wrench on_free = wrench(-glm::dvec3(held.impulse), glm::dvec3(held.point));
            for (size_t k = 0; k < change.size(); ++k) change[k] -= on_free[k];
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

using BondsBreak = std::tuple<scene::arch_loses_a_column, scene::brick_wall_rammed, scene::bunny_dropped,
                              scene::tower_collapses, scene::wrecking_ball_hits_a_wall>;

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

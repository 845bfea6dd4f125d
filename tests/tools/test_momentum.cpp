// Momentum and angular momentum across every break of every scene in which bonded things break.
//
// The books are kept around Structure::update(), between the step of the world and the next. What is free may get
// momentum from what is not (the ground, an anchored body) in one way only: contacts of a body that breaks are taken
// back, and solved anew between its islands and what they touched. The world says what those contacts were, and the
// structure which were taken back and what they are now (Changes::resolved); all else is summed up here. New impulses must press,
// along the contact's normal, and the contacts be such of a body that broke.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "tools/brittle/input.h"
#include "tools/brittle/recipe.h"
#include "tools/brittle/simulation.h"
#include "tools/brittle/stage.h"

using namespace brittle;
using namespace brittle::tools;
namespace fs = std::filesystem;

namespace {

using Wrench = std::array<double, 6>; // momentum and angular momentum

Wrench wrench(const glm::dvec3& impulse, const glm::dvec3& point) {
    const glm::dvec3 turn = glm::cross(point, impulse);
    return {impulse.x, impulse.y, impulse.z, turn.x, turn.y, turn.z};
}

void add(Wrench& to, const Wrench& what, double times) {
    for (size_t k = 0; k < 6; ++k) to[k] += times * what[k];
}

double length(const Wrench& w, size_t half) {
    return glm::length(glm::dvec3(w[3 * half], w[3 * half + 1], w[3 * half + 2]));
}

struct Books : SimulationObserver {
    struct Touch {
        Wrench normal, impulse;   // on a; of one N s, and as it was
        std::array<bool, 2> free; // a, b
        std::array<physics::BodyId, 2> bodies;
    };
    physics::Mechanics before;
    std::vector<Touch> touches;
    int breaks = 0, answered = 0; // answered: with impulses of what is fixed
    double worst = 0.0, most_answer = 0.0; // relative to all that moves
    uint64_t worst_step = 0;

    static bool is_free(const physics::World& world, physics::BodyId body) {
        return world.contains(body) && !world.fixed(body);
    }

    void moved(const Simulation& simulation) override {
        const physics::World& world = simulation.world();
        before = world.mechanics();
        touches.clear();
        for (const physics::Contact& contact : world.contacts())
            touches.push_back({wrench(glm::dvec3(contact.normal), glm::dvec3(contact.point)),
                               wrench(glm::dvec3(contact.impulse * contact.normal + contact.friction),
                                      glm::dvec3(contact.point)),
                               {is_free(world, contact.a), is_free(world, contact.b)},
                               {contact.a, contact.b}});
    }

    // What free bodies got from fixed ones.
    Wrench answers(const physics::World& world, const physics::Structure::Changes& changes) const {
        Wrench sum{};
        std::vector<uint32_t> seen;
        for (const physics::Structure::Resolved& resolved : changes.resolved) {
            REQUIRE(resolved.contact < touches.size());
            const Touch& touch = touches[resolved.contact];
            seen.push_back(resolved.contact);
            CHECK(resolved.impulse >= 0.0f);
            CHECK(std::ranges::any_of(touch.bodies, [&](physics::BodyId body) {
                return std::ranges::find(changes.removed, body) != changes.removed.end();
            }));
            if (touch.free[0] != touch.free[1]) add(sum, touch.impulse, touch.free[0] ? -1.0 : 1.0);
            const bool a = is_free(world, resolved.a), b = is_free(world, resolved.b);
            if (a != b) add(sum, touch.normal, (a ? 1.0 : -1.0) * static_cast<double>(resolved.impulse));
        }
        std::ranges::sort(seen);
        CHECK(std::ranges::adjacent_find(seen) == seen.end()); // each once
        return sum;
    }

    void updated(const Simulation& simulation, const physics::Structure::Changes& changes) override {
        if (changes.removed.empty()) return;
        const physics::World& world = simulation.world();
        const physics::Mechanics after = world.mechanics();
        const glm::dvec3 linear = after.momentum - before.momentum;
        const glm::dvec3 angular = after.angular_momentum - before.angular_momentum;
        Wrench rest{linear.x, linear.y, linear.z, angular.x, angular.y, angular.z};
        // Relative to all that moves, body by body: sums may cancel.
        std::array<double, 2> scale{1e-3, 1e-3};
        for (const physics::BodyId body : world.bodies()) {
            const physics::Mechanics own = world.mechanics(body);
            scale[0] += glm::length(own.momentum);
            scale[1] += glm::length(own.angular_momentum);
        }
        const Wrench outside = answers(world, changes);
        add(rest, outside, -1.0);
        ++breaks;
        const double answer = std::max(length(outside, 0) / scale[0], length(outside, 1) / scale[1]);
        if (answer > 1e-4) ++answered;
        most_answer = std::max(most_answer, answer);
        const double found = std::max(length(rest, 0) / scale[0], length(rest, 1) / scale[1]);
        if (found > worst) worst_step = simulation.steps();
        worst = std::max(worst, found);
    }
};

} // namespace

TEST_CASE("scenes: momentum and angular momentum are kept across every break, to 1e-4") {
    std::vector<fs::path> scenes;
    for (const auto& entry : fs::directory_iterator(BRITTLE_ASSETS "/scenes")) scenes.push_back(entry.path());
    std::sort(scenes.begin(), scenes.end());
    int tested = 0, answered = 0;
    for (const fs::path& scene : scenes) {
        FractureOptions options;
        read_recipe(scene, options);
        if (options.world.breakable || !holds_together(options.world)) continue; // test_breakable.cpp
        CAPTURE(scene.string());
        const Input input = placed_on_stage(load_input(options), options.world);
        Simulation simulation(options.material);
        Books books;
        simulation.observe(&books);
        simulation.start(break_input(input, options).fragments, options.world);
        while (simulation.steps() < 2 * options.picture.frames) simulation.step();
        MESSAGE(scene.stem().string(), ": ", books.breaks, " breaks, ", books.answered,
                " with impulses of what is fixed, of up to ", books.most_answer, "; worst ", books.worst, " at step ",
                books.worst_step);
        CHECK(books.worst < 1e-4);
        CHECK(books.breaks > 0);
        answered += books.answered;
        ++tested;
    }
    CHECK(tested >= 4);
    CHECK(answered > 0); // else nothing of the accounts was tried
}

// Momentum and angular momentum across every break of every scene in which bonded things break.
//
// The books are kept around Structure::update(), between the step of the world and the next. What is free may
// get momentum from what is not (the ground, an anchored body) in one way only: contacts of a body that
// breaks are taken back and solved anew for its islands. So a break must change the sum by nothing; or by the
// impulses of the contacts between free and fixed that are taken back, and by new impulses along the normals
// of those contacts that still have a fixed side.
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

double dot(const Wrench& a, const Wrench& b) {
    double sum = 0.0;
    for (size_t k = 0; k < 6; ++k) sum += a[k] * b[k];
    return sum;
}

void subtract(Wrench& from, const Wrench& what, double times) {
    for (size_t k = 0; k < 6; ++k) from[k] -= times * what[k];
}

// What is left of w where any amount of the directions may be taken from it.
Wrench outside(Wrench w, std::vector<Wrench> directions) {
    for (size_t k = 0; k < directions.size(); ++k) {
        const double length = std::sqrt(dot(directions[k], directions[k]));
        if (length < 1e-6) continue; // lies among those before; they had a length of one and more
        for (double& value : directions[k]) value /= length;
        subtract(w, directions[k], dot(w, directions[k]));
        for (size_t later = k + 1; later < directions.size(); ++later)
            subtract(directions[later], directions[k], dot(directions[later], directions[k]));
    }
    return w;
}

struct Books : SimulationObserver {
    struct Touch {
        Wrench normal, impulse;   // on a; of one N s, and as it was
        std::array<bool, 2> free; // a, b
        std::array<physics::BodyId, 2> bodies;
        std::array<int64_t, 2> pieces; // that touch; -1 for balls and the ground
    };
    physics::Mechanics before;
    std::vector<Touch> touches;
    // Breaks: nothing from what is fixed; a few contacts with it; so many contacts that they would explain
    // anything.
    int closed = 0, answered = 0, unknown = 0;
    double worst = 0.0;
    uint64_t worst_step = 0;

    void moved(const Simulation& simulation) override {
        const physics::World& world = simulation.world();
        before = world.mechanics();
        touches.clear();
        for (const physics::Contact& contact : world.contacts()) {
            Touch touch{wrench(glm::dvec3(contact.normal), glm::dvec3(contact.point)),
                        wrench(glm::dvec3(contact.impulse * contact.normal + contact.friction),
                               glm::dvec3(contact.point)),
                        {},
                        {contact.a, contact.b},
                        {-1, -1}};
            for (const size_t side : {0u, 1u}) {
                const physics::BodyId body = touch.bodies[side];
                touch.free[side] = world.contains(body) && !world.fixed(body);
                const std::vector<uint32_t> pieces = simulation.pieces_of(body);
                if (body != physics::BodyId{} && !pieces.empty())
                    touch.pieces[side] = pieces[side == 0 ? contact.part_a : contact.part_b];
            }
            touches.push_back(touch);
        }
    }

    void updated(const Simulation& simulation, const physics::Structure::Changes& changes) override {
        constexpr size_t most_broken = 6;
        if (changes.removed.empty()) return;
        const physics::World& world = simulation.world();
        const physics::Mechanics after = world.mechanics();
        const glm::dvec3 linear = after.momentum - before.momentum;
        const glm::dvec3 angular = after.angular_momentum - before.angular_momentum;
        const Wrench change{linear.x, linear.y, linear.z, angular.x, angular.y, angular.z};
        // Relative to all that moves, body by body: sums may cancel.
        double momentum = 1e-3, turn = 1e-3;
        for (const physics::BodyId body : world.bodies()) {
            const physics::Mechanics own = world.mechanics(body);
            momentum += glm::length(own.momentum);
            turn += glm::length(own.angular_momentum);
        }
        const auto error = [&](const Wrench& w) {
            return std::max(glm::length(glm::dvec3(w[0], w[1], w[2])) / momentum,
                            glm::length(glm::dvec3(w[3], w[4], w[5])) / turn);
        };
        // Of each broken body all contacts are taken back or none.
        double found = error(change);
        size_t most_answers = 0;
        const size_t choices = size_t{1} << std::min(changes.removed.size(), most_broken);
        for (size_t choice = 1; choice < choices; ++choice) {
            const auto taken = [&](physics::BodyId body) {
                const auto at = std::ranges::find(changes.removed, body) - changes.removed.begin();
                return at < static_cast<std::ptrdiff_t>(most_broken) && (choice >> at & 1) != 0;
            };
            Wrench rest = change;
            std::vector<Wrench> answers;
            for (const Touch& touch : touches) {
                if (!taken(touch.bodies[0]) && !taken(touch.bodies[1])) continue;
                if (touch.free[0] != touch.free[1]) subtract(rest, touch.impulse, touch.free[0] ? -1.0 : 1.0);
                std::array<bool, 2> free = touch.free;
                for (const size_t side : {0u, 1u})
                    if (touch.pieces[side] >= 0)
                        free[side] =
                            !world.fixed(simulation.body_of(static_cast<uint32_t>(touch.pieces[side])));
                if (free[0] != free[1]) answers.push_back(touch.normal);
            }
            most_answers = std::max(most_answers, answers.size());
            found = std::min(found, error(outside(rest, std::move(answers))));
        }
        const bool kept = error(change) < 1e-4; // whatever touches: nothing came from what is fixed
        if (!kept && (most_answers >= 6 || changes.removed.size() > most_broken)) {
            ++unknown;
            return;
        }
        ++(kept || most_answers == 0 ? closed : answered);
        if (found > worst) worst_step = simulation.steps();
        worst = std::max(worst, found);
    }
};

} // namespace

TEST_CASE("scenes: momentum and angular momentum are kept across every break, to 1e-4") {
    std::vector<fs::path> scenes;
    for (const auto& entry : fs::directory_iterator(BRITTLE_ASSETS "/scenes")) scenes.push_back(entry.path());
    std::sort(scenes.begin(), scenes.end());
    int tested = 0;
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
        MESSAGE(scene.stem().string(), ": ", books.closed, " breaks that changed nothing, ", books.answered,
                " with answers of what is fixed, ", books.unknown, " with too many to tell; worst ",
                books.worst, " at step ", books.worst_step);
        CHECK(books.worst < 1e-4);
        CHECK(books.closed + books.answered > 0);
        ++tested;
    }
    CHECK(tested >= 4);
}

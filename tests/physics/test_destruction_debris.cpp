// Debris: what goes when there is too much of it.
#include "physics/destruction.h"

#include <limits>

#include <doctest/doctest.h>

#include "bodies.h"
#include "destruction_fixture.h"
#include "fracture/shapes.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;
using namespace brittle::physics::test_destruction;

namespace {

constexpr double never = std::numeric_limits<double>::infinity();

} // namespace

TEST_CASE("what has faded does not go a second time where there is too much again in that step") {
    World world(empty_space);
    Destruction destruction({.latency = 1, .debris = {.most_pieces = 1, .sleep_seconds = never, .fade_seconds = 0.1}});
    bool seen = true;
    destruction.set_view([&](const glm::vec3&, float) { return seen; });
    const auto break_one = [&](float height) {
        const PieceId first = destruction.next_piece();
        BreakableDesc desc = desc_of(0.05);
        desc.motion.placement.position = {0.0f, height, 0.0f};
        must_add(destruction, world, fracture::cube(1.0), desc);
        REQUIRE(destruction.strike(world, first, {0.0f, height + 0.5f, 0.0f}, {0.0f, -1.0f, 0.0f}, 500.0));
    };
    break_one(0.0f);
    run(world, destruction, 12);
    CHECK(destruction.pieces().size() > 1);
    break_one(5.0f);
    seen = false;
    run(world, destruction, 1); // the last of the first's fading
    CHECK(destruction.pieces().size() == 1);
    CHECK(world.body_count() == 1);
    CHECK(destruction.statistics().retired + 1 == destruction.next_piece().value - 2);
}

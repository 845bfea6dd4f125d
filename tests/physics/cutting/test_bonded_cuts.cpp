// Cuts of pieces that are bonded to others: what stays bonded, and where the blow goes.
#include <algorithm>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/fracture.h"
#include "fracture/shapes/shapes.h"
#include "physics/cutting/destruction.h"
#include "tests/physics/bodies.h"
#include "tests/physics/destruction_fixture.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;
using namespace brittle::physics::test_destruction;

namespace {

// A beam of five blocks of 0.4 m along x, the outer ones anchored. Its bonds are strong, its blocks are not.
struct Beam {
    World world;
    Destruction destruction;
    ObjectId object;
    std::vector<PieceId> blocks;

    explicit Beam(std::vector<uint32_t> anchored, const WorldSettings& settings = empty_space) : world(settings) {
        std::vector<glm::dvec3> sites;
        for (int i = 0; i < 5; ++i) sites.emplace_back(-0.8 + 0.4 * i, 0.0, 0.0);
        const auto pieces = fracture::fracture(fracture::cuboid({2.0, 0.4, 0.4}), sites);
        REQUIRE(pieces.has_value());
        const Result<ObjectId> added = destruction.add(
            world, *pieces,
            {.material = weak, .anchored = std::move(anchored), .bond_strength = std::vector<float>(4, 1e8f)},
            desc_of(0.06));
        REQUIRE(added.has_value());
        object = *added;
        blocks = destruction.pieces();
    }
    // m^3 of the pieces in fixed bodies.
    [[nodiscard]] double held() const {
        double sum = 0.0;
        for (const PieceId piece : destruction.pieces())
            if (world.fixed(destruction.body(piece))) sum += destruction.solid(piece)->mass.volume;
        return sum;
    }
};

} // namespace

TEST_CASE("what is left of a bonded piece after a blow stays with its neighbours") {
    Beam beam({0, 4});
    REQUIRE(beam.destruction.strike(beam.world, beam.blocks[2], {0.0f, 0.2f, 0.0f}, {0.0f, -1.0f, 0.0f}, 30.0));
    CHECK(beam.world.body_count() == 1); // while the job runs the block stays where it is
    run(beam.world, beam.destruction, 1);
    CHECK(beam.destruction.contains(beam.blocks[2]));
    CHECK(beam.world.body_count() == 1);
    run(beam.world, beam.destruction, 10);
    REQUIRE_FALSE(beam.destruction.contains(beam.blocks[2]));
    CHECK(beam.world.body_count() > 1); // chips came off
    CHECK(volume_of(beam.destruction) == doctest::Approx(0.32).epsilon(1e-9));
    CHECK(beam.held() > 0.9 * 0.32);
    CHECK(beam.held() < 0.32);
    for (const uint32_t block : {0u, 1u, 3u, 4u}) CHECK(beam.world.fixed(beam.destruction.body(beam.blocks[block])));
    // Its largest part hangs between the two halves, and can be cut in its turn.
    PieceId part;
    for (const PieceId piece : beam.destruction.pieces())
        if (beam.destruction.depth(piece) == 1
            && (part == PieceId{}
                || beam.destruction.solid(piece)->mass.volume > beam.destruction.solid(part)->mass.volume))
            part = piece;
    REQUIRE(part != PieceId{});
    CHECK(beam.world.fixed(beam.destruction.body(part)));
    CHECK(beam.destruction.bonded(part).has_value());
    REQUIRE(beam.destruction.strike(beam.world, part, {0.0f, -0.2f, 0.0f}, {0.0f, 1.0f, 0.0f}, 30.0));
    run(beam.world, beam.destruction, 10);
    CHECK_FALSE(beam.destruction.contains(part));
    CHECK(beam.held() > 0.8 * 0.32);
    CHECK(volume_of(beam.destruction) == doctest::Approx(0.32).epsilon(1e-9));
    beam.destruction.remove(beam.world, beam.object);
    CHECK(beam.world.body_count() == 0);
    CHECK(beam.destruction.pieces().empty());
}

TEST_CASE("a ball that breaks a bonded piece does not bounce off, and pushes out what it hits") {
    for (const bool anchored : {true, false}) {
        CAPTURE(anchored);
        Beam beam(anchored ? std::vector<uint32_t>{0, 4} : std::vector<uint32_t>{});
        World& world = beam.world;
        const BodyId ball = shoot(world, 0.08f, 5.0f, {0.0f, 0.29f, 0.0f}, {0.0f, -12.0f, 0.0f});
        const Mechanics before = world.mechanics();
        const double energy = before.kinetic;
        const auto check_momentum = [&] {
            if (anchored) return;
            const glm::dvec3 change = world.mechanics().momentum - before.momentum;
            CHECK(glm::length(change) < 1e-3 * glm::length(before.momentum));
        };
        float fastest_back = 0.0f;
        int steps = 0;
        while (beam.destruction.contains(beam.blocks[2]) && ++steps < 30) {
            run(world, beam.destruction, 1);
            fastest_back = std::max(fastest_back, world.linear_velocity(ball).y);
            check_momentum();
            CHECK(world.mechanics().kinetic < energy * (1.0 + 1e-4));
        }
        REQUIRE(steps < 30);
        CHECK(fastest_back < 0.5f); // what pushes the ball out of the block, which it enters in one step
        CHECK(world.linear_velocity(ball).y < -4.0f);
        for (int k = 0; k < 20; ++k) {
            run(world, beam.destruction, 1);
            CHECK(world.mechanics().kinetic < energy * (1.0 + 1e-4));
        }
        CHECK(world.linear_velocity(ball).y < 0.5f); // it has stopped in the beam
        CHECK(beam.held() > (anchored ? 0.85 * 0.32 : -1.0));
        check_momentum();
        CHECK(volume_of(beam.destruction) == doctest::Approx(0.32).epsilon(1e-9));
    }
}

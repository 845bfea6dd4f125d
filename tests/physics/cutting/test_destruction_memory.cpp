// Memory of breaking: long runs do not grow, and large objects are freed on workers.
#include "physics/cutting/destruction.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include <malloc.h>

#include <doctest/doctest.h>

#include "fracture/shapes/shapes.h"
#include "tests/physics/bodies.h"
#include "tests/physics/destruction_fixture.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;
using namespace brittle::physics::test_destruction;

// Freeing a mesh of a million triangles, 50 MB, on the main thread would delay a frame.
TEST_CASE("destruction: large solids and unclaimed payloads are freed on other threads") {
    const std::thread::id here = std::this_thread::get_id();
    std::atomic<int> freed = 0, freed_here = 0;
    const auto note = [&] {
        freed_here += std::this_thread::get_id() == here;
        ++freed;
    };
    struct Noted : PiecePayload {
        explicit Noted(std::function<void()> end) : ended(std::move(end)) {}
        ~Noted() override { ended(); }
        std::function<void()> ended;
    };
    const auto wait_for = [&](int count) {
        while (freed < count) std::this_thread::yield();
        CHECK(freed == count);
        CHECK(freed_here == 0);
        freed = freed_here = 0;
    };
    BreakableDesc desc = desc_of(0.05);
    const fracture::TriangleMesh ball = fracture::icosphere(5, 0.25);
    const auto whole = [&] {
        SolidPtr made = *make_solid(ball, desc.solid);
        const SolidPiece* solid = made.get();
        return SolidPtr(solid, [&note, made = std::move(made)](const SolidPiece*) mutable {
            made.reset();
            note();
        });
    };
    World world(empty_space);
    Destruction destruction;
    const ObjectId broken = *destruction.add(world, whole(), desc);
    (void)destruction.take_events();
    REQUIRE(strike_from_above(world, destruction, destruction.pieces()[0], 20.0));
    run(world, destruction, 4);
    REQUIRE(destruction.statistics().breaks == 1);
    wait_for(1);
    destruction.remove(world, broken);

    const ObjectId claimed = *destruction.add(world, whole(), desc, std::make_unique<Noted>(note));
    DestructionEvents events = destruction.take_events();
    REQUIRE(events.added.size() == 1);
    const PayloadPtr payload = std::move(events.added[0].payload);
    events = {};
    destruction.remove(world, claimed);
    wait_for(1); // the solid; the payload has another owner

    desc.payload = [&](const SolidPiece& solid, const SolidPiece*) {
        return solid.triangle_count() > 15'000 ? std::make_unique<Noted>(note) : nullptr;
    };
    const ObjectId unclaimed = *destruction.add(world, whole(), desc);
    destruction.remove(world, unclaimed);
    wait_for(2);

    (void)*destruction.add(world, whole(), desc);
    const PayloadPtr first = std::move(destruction.take_events().added[0].payload);
    REQUIRE(strike_from_above(world, destruction, destruction.pieces()[0], 20.0));
    run(world, destruction, 4);
    wait_for(1);
    const auto made = destruction.take_events().added;
    REQUIRE(made.size() > 1); // the rest alone is large enough for a payload
    CHECK(std::ranges::count_if(made, [](const PieceAdded& added) { return added.payload != nullptr; }) == 1);
}

TEST_CASE("destruction: cycles of breaking and clearing leave nothing behind") {
    World world(empty_space);
    Destruction destruction({.latency = 1, .debris = {.max_pieces = 60, .fade_seconds = 0.0}});
    uint32_t slots = 0;
    for (int cycle = 0; cycle < 20; ++cycle) {
        const ObjectId object = must_add(destruction, world, fracture::cube(1.0), desc_of(0.1));
        for (int blow = 0; blow < 3; ++blow) {
            strike_from_above(world, destruction, largest(destruction), 200.0);
            run(world, destruction, 2);
        }
        CHECK(destruction.pieces().size() > 10);
        CHECK(destruction.pieces().size() < 140); // the limit, and the pieces of one blow before the next update
        destruction.remove(world, object);
        CHECK(destruction.take_events().added.empty());
        if (cycle == 10) slots = destruction.slot_count();
        if (cycle > 10) CHECK(destruction.slot_count() <= slots + 48);
        CHECK(world.body_count() == 0);
        CHECK(destruction.jobs_in_flight() == 0);
    }
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) // sanitizers have their own allocators
namespace {

// Bytes in use, over all threads.
double heap_in_use() {
    const struct mallinfo2 heap = mallinfo2();
    return static_cast<double>(heap.uordblks) + static_cast<double>(heap.hblkhd);
}

} // namespace

TEST_CASE("destruction: four hundred cycles of breaking, while pieces stay, do not grow the heap"
          * doctest::test_suite("long")) {
    constexpr int quarter = 100;
    World world;
    Destruction destruction({.latency = 1, .debris = {.max_pieces = 30, .fade_seconds = 0.05}});
    BreakableDesc desc = desc_of(0.1);
    desc.max_pieces = 8;
    const SolidPtr cube = *make_solid(fracture::cube(0.5), desc.solid);
    std::array<double, 4> mean{}; // bytes in use at the end of a cycle, by quarter
    size_t least = SIZE_MAX, most = 0;
    for (int cycle = 0; cycle < 4 * quarter; ++cycle) {
        const float angle = 2.4f * static_cast<float>(cycle);
        desc.motion.placement.position = {3.0f * std::cos(angle), 0.26f, 3.0f * std::sin(angle)};
        REQUIRE(destruction.add(world, cube, desc).has_value());
        const PieceId whole = destruction.pieces().back();
        const glm::vec3 top = desc.motion.placement.position + glm::vec3(0.0f, 0.25f, 0.0f);
        REQUIRE(destruction.strike(world, whole, top, {0.0f, -1.0f, 0.0f}, 200.0));
        run(world, destruction, 8);
        (void)destruction.take_events();
        mean[static_cast<size_t>(cycle / quarter)] += heap_in_use() / quarter;
        if (cycle < quarter) continue;
        least = std::min(least, destruction.pieces().size());
        most = std::max(most, destruction.pieces().size());
    }
    MESSAGE("in use ", mean[0] / 1024.0, ", ", mean[1] / 1024.0, ", ", mean[2] / 1024.0, " and ", mean[3] / 1024.0,
            " KB by quarter; ", least, " to ", most, " pieces, ", destruction.statistics().retired, " retired of ",
            destruction.next_piece().value);
    CHECK(least > 20);
    CHECK(most < 45); // the limit, the pieces of a blow and fading pieces
    CHECK(destruction.statistics().retired > 2000);
    CHECK(mean[3] < 1.01 * mean[1]); // a leak of 300 bytes a cycle exceeds this
}
#endif

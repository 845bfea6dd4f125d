// What breaking for long leaves on the heap while pieces live on and debris goes as more comes: nothing that grows.
#include "physics/destruction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <malloc.h>

#include <doctest/doctest.h>

#include "bodies.h"
#include "destruction_fixture.h"
#include "fracture/shapes.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_destruction;

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) // they have allocators of their own
namespace {

// Bytes that are in use, of all threads.
double heap_in_use() {
    const struct mallinfo2 heap = mallinfo2();
    return static_cast<double>(heap.uordblks) + static_cast<double>(heap.hblkhd);
}

} // namespace

TEST_CASE("four hundred cycles of breaking while pieces live on leave the heap as large as it was") {
    constexpr int quarter = 100;
    World world;
    Destruction destruction({.latency = 1, .debris = {.most_pieces = 30, .fade_seconds = 0.05}});
    BreakableDesc desc = desc_of(0.1);
    desc.most_pieces = 8;
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
    MESSAGE("in use ", mean[0] / 1024.0, ", ", mean[1] / 1024.0, ", ", mean[2] / 1024.0, " and ", mean[3] / 1024.0, " KB by quarter; ",
            least, " to ", most, " pieces, ", destruction.statistics().retired, " retired of ", destruction.next_piece().value);
    CHECK(least > 20);
    CHECK(most < 45); // the limit, a blow's pieces and what fades
    CHECK(destruction.statistics().retired > 2000);
    CHECK(mean[3] < 1.01 * mean[1]); // 300 bytes a cycle that nobody freed are more
}
#endif

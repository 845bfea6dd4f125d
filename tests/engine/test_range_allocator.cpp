// RangeAllocator, compared with an array that records the owner of each element.
#include <algorithm>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "engine/core/range_allocator.h"

using brittle::engine::RangeAllocator;

TEST_CASE("range allocator: without capacity, only empty ranges are allocated") {
    RangeAllocator space;
    CHECK_FALSE(space.allocate(1));
    CHECK(space.allocate(0));
    space.free(0, 0);
    space.grow(0);
    space.grow(4);
    CHECK(space.allocate(4) == 0u);
    CHECK_FALSE(space.allocate(1));
    CHECK(space.allocate(0));
    CHECK(space.used() == 4);
}

TEST_CASE("range allocator: adjacent free ranges are merged, in any order of freeing") {
    std::vector<uint32_t> order{0, 1, 2, 3};
    do {
        RangeAllocator space(8);
        for (uint32_t i = 0; i < 4; ++i) REQUIRE(space.allocate(2) == 2 * i);
        for (const uint32_t i : order) space.free(2 * i, 2);
        CHECK(space.used() == 0);
        CHECK(space.allocate(8) == 0u);
    } while (std::ranges::next_permutation(order).found);
}

TEST_CASE("range allocator: ranges may be freed in parts, and growth extends the last free range") {
    RangeAllocator space(6);
    REQUIRE(space.allocate(6) == 0u);
    space.free(2, 1);
    space.free(4, 2);
    space.grow(9);
    CHECK(space.allocate(5) == 4u);
    CHECK(space.allocate(1) == 2u);
    CHECK_FALSE(space.allocate(1));
}

TEST_CASE("range allocator: random ranges never overlap, and allocation succeeds exactly if a free range fits") {
    std::mt19937 random(7);
    struct Range {
        uint32_t begin, size;
    };
    RangeAllocator space;
    std::vector<bool> taken;
    std::vector<Range> ranges;
    for (int step = 0; step < 20000; ++step) {
        const uint32_t dice = random() % 100;
        if (dice == 0 && taken.size() < 300) {
            taken.resize(taken.size() + random() % 40);
            space.grow(static_cast<uint32_t>(taken.size()));
        } else if (dice < 50 && !ranges.empty()) {
            std::swap(ranges[random() % ranges.size()], ranges.back());
            const Range range = ranges.back();
            ranges.pop_back();
            space.free(range.begin, range.size);
            std::fill_n(taken.begin() + range.begin, range.size, false);
        } else {
            const uint32_t size = 1 + random() % 20;
            uint32_t row = 0, first = ~0u; // length of the present free run, and start of the first fit
            for (uint32_t i = 0; i < taken.size() && first == ~0u; ++i) {
                row = taken[i] ? 0 : row + 1;
                if (row == size) first = i + 1 - size;
            }
            const std::optional<uint32_t> at = space.allocate(size);
            REQUIRE(at.value_or(~0u) == first);
            if (!at) continue;
            std::fill_n(taken.begin() + *at, size, true);
            ranges.push_back({*at, size});
        }
        REQUIRE(space.used() == static_cast<uint32_t>(std::ranges::count(taken, true)));
    }
    CHECK(taken.size() >= 300);
}

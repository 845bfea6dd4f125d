#include "physics/cutting/job_threads.h"

#include <atomic>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include <doctest/doctest.h>

#if defined(__linux__)
#include <sys/resource.h>
#endif

#include "physics/cutting/background.h"

using namespace brittle::physics;

TEST_CASE("job threads: each item once, with any number of threads and of items") {
    for (const uint32_t threads : {0u, 1u, 2u, 7u})
        for (const size_t count : {size_t{0}, size_t{1}, size_t{3}, size_t{8}, size_t{1000}}) {
            std::vector<std::atomic<int>> calls(count);
            for_each_on(threads, count, [&](size_t k) { ++calls[k]; });
            for (const std::atomic<int>& n : calls) CHECK(n == 1);
        }
    CHECK(threads_of(3) == 3);
    CHECK(threads_of(0) >= 1);
    CHECK(threads_of(0) <= max_job_threads);
}

TEST_CASE("job threads: an exception ends the loop and reaches the caller") {
    for (const uint32_t threads : {1u, 4u}) {
        std::atomic<int> calls = 0;
        CHECK_THROWS_AS(for_each_on(threads, 100'000,
                                    [&](size_t k) {
                                        ++calls;
                                        if (k == 10) throw std::runtime_error("item 10");
                                    }),
                        std::runtime_error);
        CHECK(calls >= 11);
    }
}

TEST_CASE("job threads: threads of a job have its low priority, and later ones of the caller do not") {
#if defined(__linux__)
    const auto nice_of_thread = [] { return getpriority(PRIO_PROCESS, 0); };
    const int own = nice_of_thread();
    Background<bool> background;
    background.start(0, [&](const std::atomic<bool>&) {
        const int low = nice_of_thread();
        std::atomic<bool> all_low = true;
        for_each_on(4, 100, [&](size_t) { all_low = all_low && nice_of_thread() == low; });
        return all_low.load();
    });
    CHECK(background.take(0));
    std::atomic<bool> all_own = true;
    for_each_on(4, 100, [&](size_t) { all_own = all_own && nice_of_thread() == own; });
    CHECK(all_own);
#endif
}

#include <algorithm>
#include <atomic>
#include <thread>

#include <doctest/doctest.h>

#if defined(__linux__)
#include <sys/resource.h>
#endif

#include "physics/background.h"

using namespace brittle::physics;

TEST_CASE("a job that is called off is forgotten, and the others are had in any order") {
    Background<int> background(2);
    std::atomic<bool> begun = false, go = false, called_off = false;
    background.start(1, [&](const std::atomic<bool>& cancelled) {
        begun = true;
        while (!cancelled) std::this_thread::yield();
        called_off = true;
        return 1;
    });
    background.start(2, [&](const std::atomic<bool>&) {
        while (!go) std::this_thread::yield();
        return 2;
    });
    background.start(3, [](const std::atomic<bool>&) { return 3; });
    while (!begun) std::this_thread::yield();
    CHECK(!background.ready(1));
    CHECK(!background.ready(2));
    background.cancel(1);
    CHECK(background.take(3) == 3); // on the thread that is free now
    CHECK(called_off);
    CHECK(!background.ready(2));
    go = true;
    while (!background.ready(2)) std::this_thread::yield();
    CHECK(background.take(2) == 2);
}

TEST_CASE("jobs in the background give way to frames") {
#if defined(__linux__)
    const auto nice_of_thread = [] { return getpriority(PRIO_PROCESS, 0); };
    const int own = nice_of_thread();
    Background<int> background;
    background.start(0, [&](const std::atomic<bool>&) { return nice_of_thread(); });
    CHECK(background.take(0) == std::min(own + 10, 19));
    CHECK(nice_of_thread() == own);
#endif
}

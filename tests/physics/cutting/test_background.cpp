#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <new>
#include <thread>

#include <doctest/doctest.h>

#if defined(__linux__)
#include <sys/resource.h>
#endif

#include "physics/cutting/background.h"

using namespace brittle::physics;

TEST_CASE("background: a cancelled job is forgotten, and the others can be taken in any order") {
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
    CHECK(background.take(3) == 3); // runs on the worker that is free now
    CHECK(called_off);
    CHECK(!background.ready(2));
    go = true;
    while (!background.ready(2)) std::this_thread::yield();
    CHECK(background.take(2) == 2);
}

// An object whose deleter notes the thread it runs on.
static std::shared_ptr<const int> watched(std::atomic<std::thread::id>& freed_by) {
    return {new int(0), [&freed_by](const int* value) {
                delete value;
                freed_by = std::this_thread::get_id();
            }};
}

TEST_CASE("background: discarded objects, captures of jobs and results of cancelled jobs are destroyed on workers") {
    const std::thread::id nobody;
    std::atomic<std::thread::id> discarded, held, made;
    const auto wait = [&](const std::atomic<std::thread::id>& freed_by) {
        for (int i = 0; i < 10'000 && freed_by.load() == nobody; ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        REQUIRE(freed_by.load() != nobody);
        return freed_by.load();
    };
    Background<std::shared_ptr<const int>> background;
    background.discard(watched(discarded)); // without a job afterwards
    CHECK(wait(discarded) != std::this_thread::get_id());
    background.start(1, [holds = watched(held), &made](const std::atomic<bool>&) { return watched(made); });
    while (!background.ready(1)) std::this_thread::yield();
    CHECK(wait(held) != std::this_thread::get_id());
    CHECK(made.load() == nobody);
    background.cancel(1);
    CHECK(wait(made) != std::this_thread::get_id());
}

TEST_CASE("background: a job that is cancelled before it starts is destroyed on a worker") {
    std::atomic<std::thread::id> held;
    std::atomic<bool> begun = false, go = false;
    Background<int> background;
    background.start(1, [&](const std::atomic<bool>&) {
        begun = true;
        while (!go) std::this_thread::yield();
        return 1;
    });
    while (!begun) std::this_thread::yield();
    background.start(2, [holds = watched(held)](const std::atomic<bool>&) { return 2; });
    background.cancel(2);
    CHECK(held.load() == std::thread::id());
    go = true;
    CHECK(background.take(1) == 1);
    while (held.load() == std::thread::id()) std::this_thread::yield();
    CHECK(held.load() != std::this_thread::get_id());
}

TEST_CASE("background: what a job throws, take() throws, and the worker goes on") {
    Background<int> background;
    background.start(1, [](const std::atomic<bool>&) -> int { throw std::bad_alloc(); });
    background.start(2, [](const std::atomic<bool>&) { return 2; });
    CHECK_THROWS_AS(background.take(1), std::bad_alloc);
    CHECK(background.take(2) == 2);
    background.start(1, [](const std::atomic<bool>&) { return 3; }); // the number is free again
    CHECK(background.take(1) == 3);
    background.start(4, [](const std::atomic<bool>&) -> int { throw std::bad_alloc(); });
    while (!background.ready(4)) std::this_thread::yield();
    background.cancel(4);
}

TEST_CASE("background: workers run at a lower priority") {
#if defined(__linux__)
    const auto nice_of_thread = [] { return getpriority(PRIO_PROCESS, 0); };
    const int own = nice_of_thread();
    Background<int> background;
    background.start(0, [&](const std::atomic<bool>&) { return nice_of_thread(); });
    CHECK(background.take(0) == std::min(own + 10, 19));
    CHECK(nice_of_thread() == own);
#endif
}

// Loops in threads. A build with ThreadSanitizer has workers of its own in place of those of TBB (threads.cpp).
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iterator>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include "fracture/base/threads.h"

using namespace brittle::fracture;

namespace {

// Whether a loop over n items calls its body once for each.
bool covers_all(Threads& threads, uint32_t n, uint32_t min_size) {
    std::vector<uint32_t> calls(n);
    threads.for_chunks(n, min_size, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t k = begin; k < end; ++k) ++calls[k];
    });
    return std::all_of(calls.begin(), calls.end(), [](uint32_t count) { return count == 1; });
}

} // namespace

TEST_CASE("threads: a loop calls its body once for each item") {
    for (const uint32_t count : {1u, 2u, 5u, 256u, 4'000'000'000u}) {
        CAPTURE(count);
        Threads threads(count);
        CHECK(threads.count() == std::min(count, 256u));
        for (const uint32_t n : {0u, 1u, 2u, 3u, 1000u, 20'000u}) CHECK(covers_all(threads, n, 1));
        CHECK(covers_all(threads, 1000, 600));
    }
}

TEST_CASE("threads: a loop over nothing calls nothing and starts no thread") {
    const std::filesystem::path tasks = "/proc/self/task"; // of Linux
    const auto running = [&] {
        return std::filesystem::exists(tasks) ? std::distance(std::filesystem::directory_iterator(tasks), {}) : 0;
    };
    Threads threads(256);
    const auto before = running();
    threads.for_each(0, [](uint32_t) { FAIL("called"); });
    CHECK(running() <= before);
}

TEST_CASE("threads: loops of several threads at a time, and loops in loops") {
    std::atomic<uint32_t> failures = 0;
    {
        std::vector<std::jthread> callers;
        for (uint32_t caller = 0; caller < 4; ++caller) {
            callers.emplace_back([&failures, caller] {
                Threads threads(2 + caller);
                for (int round = 0; round < 50; ++round) {
                    if (!covers_all(threads, 5000, 16)) ++failures;
                    std::atomic<uint32_t> inner = 0;
                    threads.for_each(6, [&](uint32_t) {
                        Threads others(3);
                        others.for_each(10, [&](uint32_t k) { inner += k; });
                    });
                    if (inner != 6 * 45) ++failures;
                }
            });
        }
    }
    CHECK(failures == 0);
}

TEST_CASE("threads: an exception of any thread reaches the caller with its type, and the next loop runs") {
    Threads threads(4);
    for (uint32_t item = 0; item < 100; item += 9) {
        CAPTURE(item);
        std::string message;
        try {
            threads.for_each(100, [&](uint32_t k) {
                if (k == item) throw std::runtime_error(std::to_string(k));
            });
        } catch (const std::runtime_error& error) {
            message = error.what();
        }
        CHECK(message == std::to_string(item));
        CHECK_THROWS_AS(threads.for_each(100,
                                         [&](uint32_t k) {
                                             if (k >= item) throw std::bad_alloc();
                                         }),
                        std::bad_alloc);
        CHECK(covers_all(threads, 500, 1));
    }
}

TEST_CASE("threads: a question ends a loop early") {
    Threads threads(3);
    std::atomic<uint32_t> done = 0;
    const std::function<bool()> question = [&] { return done >= 10; };
    threads.cancel_by(question);
    CHECK_THROWS_AS(threads.for_each(100'000, [&](uint32_t) { ++done; }), Threads::Cancelled);
    CHECK(done < 100'000);
    threads.cancel_by({});
    CHECK(covers_all(threads, 1000, 1));
}

// A loop of a job on threads of its own, which end with the loop.
//
// Background (background.h) lowers the priority of the thread of a job. Threads that it starts inherit that, and those
// of fracture::Threads would keep it for all later loops of the program. The work of an item must exceed the tenth of a
// millisecond that the start of a thread costs.
//
//     for_each_on(threads_of(settings.hull_threads), count, [&](size_t k) { hulls[k] = ...; });
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace brittle::physics {

// The most threads of one loop where the number is 0: more would wait for the rest of the job.
inline constexpr uint32_t max_job_threads = 4;
// The least items of a thread.
inline constexpr size_t min_job_items = 4;

// Returns the number of threads that a setting asks for; 0 asks for one a core.
[[nodiscard]] inline uint32_t threads_of(uint32_t setting) {
    return setting > 0 ? setting : std::clamp(std::thread::hardware_concurrency(), 1u, max_job_threads);
}

// Calls body(k) for each k below count, in any order, on this thread and up to threads - 1 others. An exception of body
// ends the loop and is thrown again here. A thread that the system refuses is left out.
template<class Body>
void for_each_on(uint32_t threads, size_t count, Body&& body) {
    std::atomic<size_t> next = 0;
    std::exception_ptr failure;
    std::mutex failing;
    const auto work = [&] {
        try {
            for (size_t k = next++; k < count; k = next++) body(k);
        } catch (...) {
            const std::lock_guard lock(failing);
            if (!failure) failure = std::current_exception();
            next = count;
        }
    };
    {
        std::vector<std::jthread> others;
        const size_t wanted = std::min<size_t>(threads, count / min_job_items);
        try {
            while (others.size() + 1 < wanted) others.emplace_back(work);
        } catch (const std::system_error&) { // the threads that run take over its items
        }
        work();
    }
    if (failure) std::rethrow_exception(failure);
}

} // namespace brittle::physics

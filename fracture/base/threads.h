// Parallel loops over index ranges, split into chunks for the threads of one TBB arena; without
// BRITTLE_TBB, for std::thread.
//
// The number of chunks depends on the number of threads, so no result may depend on chunk boundaries: each phase writes
// to places that follow from the item index alone (prefix sums over chunks, in order). Only threads.cpp includes TBB.
//
//     Threads threads(4);
//     threads.for_chunks(n, 1024, [&](uint32_t, uint32_t begin, uint32_t end) { ... });
//
// A loop can be cancelled: cancel_by() sets a question, poll() asks it, and the loop ends with the exception Cancelled
// where the answer is yes. The exception stays inside the library: public functions return Status::cancelled.
//
// Not synchronised: one loop at a time.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <type_traits>

#include "fracture/base/work_log.h"

namespace brittle::fracture {

class Threads {
  public:
    explicit Threads(uint32_t count = 1); // 0 means one thread per core
    ~Threads();
    Threads(Threads&&) noexcept;
    Threads& operator=(Threads&&) noexcept;

    [[nodiscard]] uint32_t count() const { return count_; }

    struct Cancelled {}; // thrown by poll() and by loops

    // Sets the question that cancels later loops: true ends them. One thread at a time asks it. Empty: none. It must
    // outlive the loops. Must not be called while a loop runs.
    void cancel_by(const std::function<bool()>& question);
    // Asks the question and throws Cancelled where the answer is yes. Loops poll before each chunk.
    void poll() const;
    // Polls at every 256th item: for the bodies of long loops, from any thread.
    void poll(uint32_t item) const {
        if (item % 256 == 0) poll();
    }

    // Sets the log of all later loops; null for none. Must not be called while a loop runs.
    void log_to(WorkLog* log);
    // Sets the phase name that later loops log; a string literal.
    void name_step(const char* step) { step_ = step; }

    // Returns the number of chunks that for_chunks() splits n items into: 1 for a single thread, otherwise up to a few
    // per thread. Each has at least `min_size` items, unless it is the only one. At least 1, also for n = 0.
    [[nodiscard]] uint32_t chunks(uint32_t n, uint32_t min_size) const;

    // Calls body(chunk, begin, end) for each chunk of [0, n), in any order, and waits for all calls.
    template<class Body>
    void for_chunks(uint32_t n, uint32_t min_size, Body&& body) {
        run(n, chunks(n, min_size), &call<std::remove_reference_t<Body>>, &body);
    }

    // Calls body(k) for each k in [0, n), each as a task of its own, and waits for all calls.
    template<class Body>
    void for_each(uint32_t n, Body&& body) {
        const auto one = [&](uint32_t k, uint32_t, uint32_t) { body(k); };
        run(n, n, &call<const decltype(one)>, &one);
    }

  private:
    using Call = void (*)(void*, uint32_t, uint32_t, uint32_t);

    template<class Body>
    static void call(void* body, uint32_t chunk, uint32_t begin, uint32_t end) {
        (*static_cast<Body*>(body))(chunk, begin, end);
    }
    void run(uint32_t n, uint32_t count, Call invoke, const void* body);

    template<class Body>
    void each_chunk(uint32_t count, const Body& body); // body(chunk, thread)

    struct Arena;
    struct Question;
    uint32_t count_;
    const char* step_ = "";
    WorkLog* log_ = nullptr;
    std::unique_ptr<Arena> arena_;
    std::unique_ptr<Question> question_; // null for none
};

} // namespace brittle::fracture

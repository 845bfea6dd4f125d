// Loops over index ranges, split into chunks that the threads of one TBB arena take.
//
// Nothing here may influence a result: chunks differ with the number of threads, so every phase that uses
// them writes to places that depend on the index alone (prefix sums over chunks, in order). TBB appears in
// threads.cpp only.
#pragma once

#include <cstdint>
#include <memory>
#include <type_traits>

#include "fracture/base/work_log.h"

namespace brittle::fracture {

class Threads {
  public:
    explicit Threads(uint32_t count = 1); // 0 = one thread a core
    ~Threads();
    Threads(Threads&&) noexcept;
    Threads& operator=(Threads&&) noexcept;

    [[nodiscard]] uint32_t count() const { return count_; }

    // Where loops from here on are logged; null for nowhere. Not while a loop runs.
    void log_to(WorkLog* log);
    // What the loops from here on are part of, for the log; a string literal.
    void name_step(const char* step) { step_ = step; }

    // How many chunks for_chunks() makes of n items: one with a single thread, else a few for each thread,
    // none of them smaller than `least` (but for the only one). At least one, also for n = 0.
    [[nodiscard]] uint32_t chunks(uint32_t n, uint32_t least) const;

    // Calls body(chunk, begin, end) for each chunk of [0, n), in any order, and waits for all.
    template<class Body>
    void for_chunks(uint32_t n, uint32_t least, Body&& body) {
        run(n, chunks(n, least), &call<std::remove_reference_t<Body>>, &body);
    }

    // Calls body(k) for each k below n, each as a task of its own.
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
    uint32_t count_;
    const char* step_ = "";
    WorkLog* log_ = nullptr;
    std::unique_ptr<Arena> arena_;
};

} // namespace brittle::fracture

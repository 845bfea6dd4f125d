// What each thread did and when, for a time line:
//
//     WorkLog log;
//     settings.work_log = &log; // outlives the fracture; then fracture() as ever
//     for (size_t k = 0; k < log.threads(); ++k)
//         for (const WorkLog::Slice& slice : log.of_thread(k)) ...
//
// Threads write to lists of their own, so nothing is locked. Without a log a loop asks for it once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace brittle::fracture {

class WorkLog {
  public:
    struct Slice {
        const char* step;    // what the loop is part of, as Threads::name_step() had it last
        uint32_t begin, end; // the run of items: cells, triangles, ...
        int64_t from, to;    // nanoseconds of std::chrono::steady_clock
    };

    void clear(); // keeps the memory
    // All since clear(). A thread has a place in the loops' arena, not always one and the same thread of the system.
    [[nodiscard]] size_t threads() const { return slices_.size(); }
    [[nodiscard]] std::span<const Slice> of_thread(size_t k) const { return slices_[k]; } // in order of time

  private:
    friend class Threads;
    std::vector<std::vector<Slice>> slices_;
};

} // namespace brittle::fracture

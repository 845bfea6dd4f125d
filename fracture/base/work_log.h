// A time line of parallel loops: for each thread, the slices of work that it ran.
//
//     WorkLog log; // must outlive the fracture
//     settings.work_log = &log;
//     Result<Fragments> fragments = fracture(mesh, sites, settings);
//     for (size_t k = 0; k < log.threads(); ++k)
//         for (const WorkLog::Slice& slice : log.of_thread(k)) draw(k, slice);
//
// Each thread appends to a list of its own, without locks. Read the log after the loops have ended.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace brittle::fracture {

class WorkLog {
  public:
    struct Slice {
        const char* step;    // the phase, as last set by Threads::name_step(); a string literal
        uint32_t begin, end; // the range of item indices (cells, triangles, ...)
        int64_t from, to;    // start and end, nanoseconds of std::chrono::steady_clock
    };

    void clear(); // empties the lists and keeps their memory
    // The number of slots in the thread arena. Successive loops may run a slot on different system threads.
    [[nodiscard]] size_t threads() const { return slices_.size(); }
    // Returns the slices since clear(), by ascending start time.
    [[nodiscard]] std::span<const Slice> of_thread(size_t k) const { return slices_[k]; }

  private:
    friend class Threads;
    std::vector<std::vector<Slice>> slices_;
};

} // namespace brittle::fracture

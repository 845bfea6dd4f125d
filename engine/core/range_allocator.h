// Which stretches of an arena are free: first fit, in elements of the caller's choice. It holds numbers, no memory.
//
//     RangeAllocator space(1024);
//     std::optional<uint32_t> at = space.allocate(100); // 0; nothing where no stretch is long enough
//     space.grow(2048);
//     space.free(*at, 100);
//
// First fit from the start keeps what is used at the front. Free neighbours are one stretch, so that an arena in
// which nothing is left is one stretch again. Cost: linear in the stretches. Copies are cheap: a list of pairs.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace brittle::engine {

class RangeAllocator {
  public:
    explicit RangeAllocator(uint32_t capacity = 0);

    [[nodiscard]] uint32_t capacity() const { return capacity_; }
    [[nodiscard]] uint32_t used() const { return used_; }

    // Where the range begins. An empty range begins anywhere and need not be freed.
    [[nodiscard]] std::optional<uint32_t> allocate(uint32_t size);
    // Gives back a range, or any part of one, that allocate() gave.
    void free(uint32_t begin, uint32_t size);
    // To a capacity that is not less.
    void grow(uint32_t capacity);

  private:
    struct Range {
        uint32_t begin, end;
    };
    std::vector<Range> ranges_; // free, ascending, with a gap between any two
    uint32_t capacity_ = 0;
    uint32_t used_ = 0;
};

} // namespace brittle::engine

// A first-fit allocator of ranges in an arena. It keeps the list of free ranges and owns no memory; the caller chooses
// the element that offsets and sizes count.
//
//     RangeAllocator space(1024);
//     std::optional<uint32_t> begin = space.allocate(100); // 0; nullopt when no free range is long enough
//     space.grow(2048);
//     space.free(*begin, 100);
//
// First fit keeps allocations near the start of the arena. Adjacent free ranges are merged, so an empty arena is one
// free range. allocate() and free() are linear in the number of free ranges. Copies are cheap: one vector of pairs.
// Not thread-safe.
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

    // Returns the first element of an allocated range, or nullopt when no free range has `size` elements. An empty
    // range takes no space and need not be freed.
    [[nodiscard]] std::optional<uint32_t> allocate(uint32_t size);
    // Frees an allocated range, or a part of one.
    void free(uint32_t begin, uint32_t size);
    // Raises the capacity; `capacity` must not be below the present one.
    void grow(uint32_t capacity);

  private:
    struct Range {
        uint32_t begin, end;
    };
    std::vector<Range> ranges_; // free ranges, ascending, no two adjacent
    uint32_t capacity_ = 0;
    uint32_t used_ = 0;
};

} // namespace brittle::engine

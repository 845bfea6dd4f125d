#include "engine/core/range_allocator.h"

#include <algorithm>
#include <cassert>

namespace brittle::engine {

RangeAllocator::RangeAllocator(uint32_t capacity) {
    grow(capacity);
}

std::optional<uint32_t> RangeAllocator::allocate(uint32_t size) {
    if (size == 0) return 0;
    const auto fits = std::ranges::find_if(ranges_, [&](const Range& r) { return r.end - r.begin >= size; });
    if (fits == ranges_.end()) return std::nullopt;
    const uint32_t begin = fits->begin;
    fits->begin += size;
    if (fits->begin == fits->end) ranges_.erase(fits);
    used_ += size;
    return begin;
}

void RangeAllocator::free(uint32_t begin, uint32_t size) {
    if (size == 0) return;
    const uint32_t end = begin + size;
    assert(end <= capacity_ && size <= used_);
    const auto next = std::ranges::lower_bound(ranges_, begin, {}, &Range::begin);
    const bool joins_next = next != ranges_.end() && next->begin == end;
    const bool joins_previous = next != ranges_.begin() && std::prev(next)->end == begin;
    assert((next == ranges_.end() || end <= next->begin) && "freed twice");
    assert((next == ranges_.begin() || std::prev(next)->end <= begin) && "freed twice");
    used_ -= size;
    if (joins_next && joins_previous) {
        std::prev(next)->end = next->end;
        ranges_.erase(next);
    } else if (joins_next) {
        next->begin = begin;
    } else if (joins_previous) {
        std::prev(next)->end = end;
    } else {
        ranges_.insert(next, {begin, end});
    }
}

void RangeAllocator::grow(uint32_t capacity) {
    assert(capacity >= capacity_);
    if (capacity == capacity_) return;
    if (!ranges_.empty() && ranges_.back().end == capacity_)
        ranges_.back().end = capacity;
    else
        ranges_.push_back({capacity_, capacity});
    capacity_ = capacity;
}

} // namespace brittle::engine

// Counts what the program takes from the heap, by replacing operator new and delete. Link memory_meter.cpp
// into a program that wants to know; it costs a few nanoseconds an allocation.
#pragma once

#include <cstdint>

namespace brittle::tools {

struct HeapUse {
    uint64_t allocations = 0; // since the program started
    uint64_t live = 0;        // bytes
    uint64_t peak = 0;        // the most bytes that were live since reset_heap_peak()
};

[[nodiscard]] HeapUse heap_use();
void reset_heap_peak();

} // namespace brittle::tools

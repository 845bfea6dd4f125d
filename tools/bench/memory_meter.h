// Counts heap allocations by replacing operator new and delete in every program that links memory_meter.cpp. Costs a
// few nanoseconds an allocation.
#pragma once

#include <cstdint>

namespace brittle::tools {

struct HeapUse {
    uint64_t allocations = 0; // since the program started
    uint64_t live = 0;        // bytes
    uint64_t peak = 0;        // maximum of live bytes since reset_heap_peak()
};

[[nodiscard]] HeapUse heap_use();
void reset_heap_peak();

} // namespace brittle::tools

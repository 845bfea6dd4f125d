#include "tools/bench/memory_meter.h"

#include <atomic>
#include <cstdlib>
#include <malloc.h>
#include <new>

namespace brittle::tools {

namespace {

std::atomic<uint64_t> allocations{0};
std::atomic<uint64_t> live{0};
std::atomic<uint64_t> peak{0};

void* counted(void* memory) {
    if (!memory) throw std::bad_alloc();
    allocations.fetch_add(1, std::memory_order_relaxed);
    const uint64_t size = malloc_usable_size(memory);
    const uint64_t now = live.fetch_add(size, std::memory_order_relaxed) + size;
    uint64_t most = peak.load(std::memory_order_relaxed);
    while (most < now && !peak.compare_exchange_weak(most, now, std::memory_order_relaxed)) {
    }
    return memory;
}

void release(void* memory) {
    if (!memory) return;
    live.fetch_sub(malloc_usable_size(memory), std::memory_order_relaxed);
    std::free(memory);
}

} // namespace

HeapUse heap_use() {
    return {allocations.load(), live.load(), peak.load()};
}

void reset_heap_peak() {
    peak = live.load();
}

} // namespace brittle::tools

// The array and nothrow forms call these.
void* operator new(std::size_t size) {
    return brittle::tools::counted(std::malloc(size == 0 ? 1 : size));
}
void* operator new(std::size_t size, std::align_val_t alignment) {
    const auto step = static_cast<std::size_t>(alignment);
    return brittle::tools::counted(std::aligned_alloc(step, (size + step - 1) / step * step));
}
void operator delete(void* memory) noexcept {
    brittle::tools::release(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
    brittle::tools::release(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
    brittle::tools::release(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
    brittle::tools::release(memory);
}

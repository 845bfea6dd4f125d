// Prefetches memory ahead of its use.
//
// Bodies, hulls and contacts lie anywhere in memory, and those of two thousand bodies exceed a core's own cache: a loop
// over them mostly waits for memory. It therefore prefetches what it needs a few rounds later. Data behind a pointer
// takes two stages: first the pointer's holder, some rounds later the data.
//
// GCC drops the call of a function whose only effect is a prefetch, hence always_inline.
#pragma once

#include <cstddef>

namespace brittle::physics {

inline constexpr size_t prefetch_distance = 3; // rounds

[[gnu::always_inline]] inline void prefetch(const void* from, size_t bytes) {
    constexpr size_t cache_line = 64;
    for (size_t byte = 0; byte < bytes; byte += cache_line) __builtin_prefetch(static_cast<const char*>(from) + byte);
}

template<class Object>
[[gnu::always_inline]] inline void prefetch(const Object* object) {
    prefetch(object, sizeof(Object));
}

} // namespace brittle::physics

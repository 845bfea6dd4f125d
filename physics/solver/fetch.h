// Asks for memory before it is needed.
//
// Bodies, their hulls and their contacts lie anywhere in memory, and two thousand of them are more than a core's own cache holds: a loop
// over them mostly waits. So it asks for what it will need a few rounds later. Where that is found through a pointer,
// whoever holds the pointer is asked for some rounds before. Nothing else changes by it.
//
// GCC leaves out the call of a function that does nothing else, as one without effect: each is to be inlined.
#pragma once

#include <cstddef>

namespace brittle::physics {

inline constexpr size_t fetched_ahead = 3; // rounds before it is needed

[[gnu::always_inline]] inline void fetch(const void* from, size_t bytes) {
    constexpr size_t cache_line = 64;
    for (size_t byte = 0; byte < bytes; byte += cache_line) __builtin_prefetch(static_cast<const char*>(from) + byte);
}

template<class Object>
[[gnu::always_inline]] inline void fetch(const Object* object) {
    fetch(object, sizeof(Object));
}

} // namespace brittle::physics

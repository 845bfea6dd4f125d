// Lets the compiler emit a hot loop twice, for the baseline and for AVX2, and choose when the program is
// loaded.
//
// Without contraction both versions round alike, so results do not depend on the machine. Sanitizers run
// before the choice is made and cannot see through it; they get the baseline.
#pragma once

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define BRITTLE_SIMD
#endif
#endif
#if !defined(BRITTLE_SIMD) && defined(__x86_64__) && defined(__gnu_linux__) && !defined(__SANITIZE_ADDRESS__)          \
    && !defined(__SANITIZE_THREAD__)
#define BRITTLE_SIMD __attribute__((target_clones("avx2", "default")))
#endif
#if !defined(BRITTLE_SIMD)
#define BRITTLE_SIMD
#endif

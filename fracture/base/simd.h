// BRITTLE_SIMD: makes the compiler emit a function twice, for baseline x86-64 and for AVX2; the loader picks one.
//
// Floating-point contraction is off, so both versions round alike and results do not depend on the machine. The
// sanitizers get the baseline only: they run before the loader's choice and cannot follow it.
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

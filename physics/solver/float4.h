// Four floats in lanes: SSE2 where the compiler has it, as on every x86-64, plain loops elsewhere. Both give equal
// bits, because neither fuses multiplications with additions.
#pragma once

#include <cmath>
#include <cstdint>
#include <utility>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace brittle::physics {

// Loads and stores may be unaligned. min and max return the second operand in lanes where either is NaN.
#if defined(__SSE2__)

struct Float4 {
    __m128 v;

    static Float4 load(const float* from) { return {_mm_loadu_ps(from)}; }
    // Loads three floats and sets the last lane to 0. Reads a fourth float from memory.
    static Float4 load3(const float* from) {
        return {_mm_and_ps(_mm_loadu_ps(from), _mm_castsi128_ps(_mm_set_epi32(0, -1, -1, -1)))};
    }
    static Float4 all(float value) { return {_mm_set1_ps(value)}; }
    // Faster than load() of floats that were just written one by one, which fails store forwarding.
    static Float4 of(float a, float b, float c, float d) { return {_mm_setr_ps(a, b, c, d)}; }
    void store(float* to) const { _mm_storeu_ps(to, v); }

    friend Float4 operator+(Float4 a, Float4 b) { return {_mm_add_ps(a.v, b.v)}; }
    friend Float4 operator-(Float4 a, Float4 b) { return {_mm_sub_ps(a.v, b.v)}; }
    friend Float4 operator*(Float4 a, Float4 b) { return {_mm_mul_ps(a.v, b.v)}; }
    friend Float4 operator/(Float4 a, Float4 b) { return {_mm_div_ps(a.v, b.v)}; }
    friend Float4 min(Float4 a, Float4 b) { return {_mm_min_ps(a.v, b.v)}; }
    friend Float4 max(Float4 a, Float4 b) { return {_mm_max_ps(a.v, b.v)}; }
    friend Float4 sqrt(Float4 a) { return {_mm_sqrt_ps(a.v)}; }
    // Sum of the first three lanes: (0 + 1) + 2.
    friend float sum3(Float4 a) {
        const __m128 second = _mm_shuffle_ps(a.v, a.v, _MM_SHUFFLE(1, 1, 1, 1));
        const __m128 third = _mm_movehl_ps(a.v, a.v);
        return _mm_cvtss_f32(_mm_add_ss(_mm_add_ss(a.v, second), third));
    }
    // Bit i is set if a <= b, c <= d and e <= f in lane i.
    friend uint32_t all_less_equal(Float4 a, Float4 b, Float4 c, Float4 d, Float4 e, Float4 f) {
        return static_cast<uint32_t>(_mm_movemask_ps(
            _mm_and_ps(_mm_and_ps(_mm_cmple_ps(a.v, b.v), _mm_cmple_ps(c.v, d.v)), _mm_cmple_ps(e.v, f.v))));
    }
    // Bit i is set if a < b in lane i.
    friend uint32_t less(Float4 a, Float4 b) { return static_cast<uint32_t>(_mm_movemask_ps(_mm_cmplt_ps(a.v, b.v))); }
    // Selects `yes` in lanes where a < b, `no` elsewhere.
    friend Float4 where_less(Float4 a, Float4 b, Float4 yes, Float4 no) {
        const __m128 less = _mm_cmplt_ps(a.v, b.v);
        return {_mm_or_ps(_mm_and_ps(less, yes.v), _mm_andnot_ps(less, no.v))};
    }
    // Exchanges rows and columns.
    friend void transpose(Float4& a, Float4& b, Float4& c, Float4& d) { _MM_TRANSPOSE4_PS(a.v, b.v, c.v, d.v); }
    // Bit i is set if a == b in lane i.
    friend uint32_t equal(Float4 a, Float4 b) { return static_cast<uint32_t>(_mm_movemask_ps(_mm_cmpeq_ps(a.v, b.v))); }
};

#else

struct Float4 {
    float v[4];

    static Float4 load(const float* from) { return {{from[0], from[1], from[2], from[3]}}; }
    static Float4 load3(const float* from) { return {{from[0], from[1], from[2], 0.0f}}; }
    static Float4 all(float value) { return {{value, value, value, value}}; }
    static Float4 of(float a, float b, float c, float d) { return {{a, b, c, d}}; }
    void store(float* to) const {
        for (int i = 0; i < 4; ++i) to[i] = v[i];
    }

    static Float4 each(Float4 a, Float4 b, const auto& of) {
        return {{of(a.v[0], b.v[0]), of(a.v[1], b.v[1]), of(a.v[2], b.v[2]), of(a.v[3], b.v[3])}};
    }
    static uint32_t mask(Float4 a, Float4 b, const auto& of) {
        uint32_t bits = 0;
        for (int i = 0; i < 4; ++i) bits |= of(a.v[i], b.v[i]) ? 1u << i : 0u;
        return bits;
    }
    friend Float4 operator+(Float4 a, Float4 b) {
        return each(a, b, [](float x, float y) { return x + y; });
    }
    friend Float4 operator-(Float4 a, Float4 b) {
        return each(a, b, [](float x, float y) { return x - y; });
    }
    friend Float4 operator*(Float4 a, Float4 b) {
        return each(a, b, [](float x, float y) { return x * y; });
    }
    friend Float4 operator/(Float4 a, Float4 b) {
        return each(a, b, [](float x, float y) { return x / y; });
    }
    friend Float4 min(Float4 a, Float4 b) {
        return each(a, b, [](float x, float y) { return x < y ? x : y; });
    }
    friend Float4 max(Float4 a, Float4 b) {
        return each(a, b, [](float x, float y) { return x > y ? x : y; });
    }
    friend Float4 sqrt(Float4 a) {
        return each(a, a, [](float x, float) { return std::sqrt(x); });
    }
    friend float sum3(Float4 a) { return a.v[0] + a.v[1] + a.v[2]; }
    friend uint32_t all_less_equal(Float4 a, Float4 b, Float4 c, Float4 d, Float4 e, Float4 f) {
        const auto below = [](float x, float y) { return x <= y; };
        return mask(a, b, below) & mask(c, d, below) & mask(e, f, below);
    }
    friend uint32_t less(Float4 a, Float4 b) {
        return mask(a, b, [](float x, float y) { return x < y; });
    }
    friend Float4 where_less(Float4 a, Float4 b, Float4 yes, Float4 no) {
        Float4 chosen = no;
        for (int i = 0; i < 4; ++i)
            if (a.v[i] < b.v[i]) chosen.v[i] = yes.v[i];
        return chosen;
    }
    friend void transpose(Float4& a, Float4& b, Float4& c, Float4& d) {
        Float4* const rows[4] = {&a, &b, &c, &d};
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < i; ++j) std::swap(rows[i]->v[j], rows[j]->v[i]);
    }
    friend uint32_t equal(Float4 a, Float4 b) {
        return mask(a, b, [](float x, float y) { return x == y; });
    }
};

#endif

inline float min_of(Float4 a) {
    float lanes[4];
    a.store(lanes);
    const float low = lanes[0] < lanes[1] ? lanes[0] : lanes[1], high = lanes[2] < lanes[3] ? lanes[2] : lanes[3];
    return low < high ? low : high;
}
inline float max_of(Float4 a) {
    float lanes[4];
    a.store(lanes);
    const float low = lanes[0] > lanes[1] ? lanes[0] : lanes[1], high = lanes[2] > lanes[3] ? lanes[2] : lanes[3];
    return low > high ? low : high;
}

} // namespace brittle::physics

// Exact arithmetic on sums of doubles (Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast
// Robust Geometric Predicates", 1997): the arithmetic behind predicates.h.
//
// An Expansion is an unevaluated sum of nonzero doubles of growing magnitude, strongly nonoverlapping; zero
// has no terms. Sums, differences and products are exact as long as no term overflows and no product of two
// terms falls below 2^-1022 + the width of its low half; predicates.h states input ranges that guarantee
// both. On lattice and float data values stay one or two terms long, which is why this is chosen over
// fixed-width integers: cost follows the bits used.
//
// Capacity. Results longer than lazy_terms are compressed. The first, downward pass of compression leaves
// each term at most one unit in the last place of the next larger one: at least 52 binary exponents apart
// (the remainder q of a rounded sum Q has |q| <= ulp(Q)/2, is a multiple of the lowest bit already consumed,
// and all that is still to come is smaller than that bit: together less than ulp(Q)). The finite doubles span
// 2098 exponents, hence at most 41 terms, whatever was computed. No fallback is needed, and nothing is
// allocated.
#pragma once

#include <cfloat>

#ifdef __FAST_MATH__
#error "expansion arithmetic needs IEEE semantics: compile without fast-math"
#endif
static_assert(FLT_EVAL_METHOD == 0, "expansion arithmetic needs doubles without excess precision");

namespace brittle::fracture::exact {

class Expansion {
  public:
    static constexpr int capacity = 41;
    static constexpr int lazy_terms = 6; // up to here compression costs more than it saves

    Expansion() = default;
    explicit Expansion(double x) : size_(x != 0.0 ? 1 : 0) { terms_[0] = x; }
    Expansion(const Expansion& other) { *this = other; }
    Expansion& operator=(const Expansion& other); // copies the terms in use only

    // a - b, at most two terms. The commonest way in: exact coordinate differences.
    [[nodiscard]] static Expansion difference(double a, double b);
    // a * b, at most two terms.
    [[nodiscard]] static Expansion product(double a, double b);

    [[nodiscard]] int sign() const { return size_ == 0 ? 0 : (terms_[size_ - 1] > 0.0 ? 1 : -1); }
    [[nodiscard]] int size() const { return size_; }
    [[nodiscard]] const double* terms() const { return terms_; } // size() of them, smallest first

    // The nearest double, or one of its neighbours.
    [[nodiscard]] double approximation() const;

    // Exact for powers of two, the only factors allowed here.
    [[nodiscard]] Expansion scaled(double power_of_two) const;

    friend Expansion operator-(const Expansion& a) { return a.scaled(-1.0); }
    friend Expansion operator+(const Expansion& a, const Expansion& b) { return add(a, b, 1.0); }
    friend Expansion operator-(const Expansion& a, const Expansion& b) { return add(a, b, -1.0); }
    friend Expansion operator*(const Expansion& a, const Expansion& b);

  private:
    static Expansion add(const Expansion& a, const Expansion& b, double b_sign); // a + b_sign * b
    void assign(double* terms, int count); // compresses where needed; may overwrite its argument

    int size_ = 0;
    double terms_[capacity]; // NOLINT: only the first size_ are ever read
};

} // namespace brittle::fracture::exact

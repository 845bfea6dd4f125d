// Exact arithmetic on sums of doubles, for the predicates (Shewchuk, "Adaptive Precision Floating-Point Arithmetic and
// Fast Robust Geometric Predicates", 1997).
//
// An Expansion is an unevaluated sum of nonzero doubles of ascending magnitude, strongly nonoverlapping; zero has no
// terms. Sums, differences and products are exact if no term overflows and no product of two terms falls below 2^-1022
// + the width of its low half. predicates.h states ranges of input that guarantee both. On lattice and float data,
// values remain one or two terms long, so the cost follows the bits in use; fixed-width integers were rejected for that
// reason.
//
// Capacity. Results longer than lazy_terms are compressed. The first, downward pass of compression leaves each term at
// most one unit in the last place of the next larger one, at least 52 binary exponents apart: the remainder q of a
// rounded sum Q has |q| <= ulp(Q)/2 and is a multiple of the lowest bit consumed so far, and the remaining terms
// together are smaller than that bit, so the total is below ulp(Q). The finite doubles span 2098 exponents, so an
// expansion has at most 41 terms, whatever the computation. No fallback is needed and nothing is allocated.
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
    static constexpr int lazy_terms = 6; // below this length compression costs more than it saves

    Expansion() = default;
    explicit Expansion(double x) : size_(x != 0.0 ? 1 : 0) { terms_[0] = x; }
    Expansion(const Expansion& other) { *this = other; }
    Expansion& operator=(const Expansion& other); // copies only the terms in use

    // Returns a - b, in at most two terms. The most frequent way in: exact differences of coordinates.
    [[nodiscard]] static Expansion difference(double a, double b);
    // Returns a * b, in at most two terms.
    [[nodiscard]] static Expansion product(double a, double b);

    [[nodiscard]] int sign() const { return size_ == 0 ? 0 : (terms_[size_ - 1] > 0.0 ? 1 : -1); }
    [[nodiscard]] int size() const { return size_; }
    [[nodiscard]] const double* terms() const { return terms_; } // size() terms, smallest first

    // Returns the nearest double or one of its neighbours.
    [[nodiscard]] double approximation() const;

    // Returns the product with a power of two, which is exact; other factors are not allowed.
    [[nodiscard]] Expansion scaled(double power_of_two) const;

    friend Expansion operator-(const Expansion& a) { return a.scaled(-1.0); }
    friend Expansion operator+(const Expansion& a, const Expansion& b) { return add(a, b, 1.0); }
    friend Expansion operator-(const Expansion& a, const Expansion& b) { return add(a, b, -1.0); }
    friend Expansion operator*(const Expansion& a, const Expansion& b);

  private:
    static Expansion add(const Expansion& a, const Expansion& b, double b_sign); // a + b_sign * b
    void assign(double* terms, int count);                                       // compresses long arguments in place

    int size_ = 0;
    double terms_[capacity]; // NOLINT: only the first size_ are ever read
};

} // namespace brittle::fracture::exact

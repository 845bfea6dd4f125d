#include "fracture/arithmetic/expansion.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace brittle::fracture::exact {
namespace {

// sum + error = a + b exactly (Knuth).
inline double two_sum(double a, double b, double& error) {
    const double sum = a + b;
    const double b_virtual = sum - a;
    error = (a - (sum - b_virtual)) + (b - b_virtual);
    return sum;
}

// sum + error = a + b exactly, if |a| >= |b| (Dekker).
inline double fast_two_sum(double a, double b, double& error) {
    const double sum = a + b;
    error = b - (sum - a);
    return sum;
}

// product + error = a * b exactly (Dekker, Veltkamp's split; one fused instruction on targets that have it gives an
// equal result, because it is exact).
inline double two_product(double a, double b, double& error) {
    const double product = a * b;
#ifdef __FMA__
    error = __builtin_fma(a, b, -product);
#else
    constexpr double splitter = 0x1.0p+27 + 1.0;
    const double ca = splitter * a;
    const double a_high = ca - (ca - a);
    const double a_low = a - a_high;
    const double cb = splitter * b;
    const double b_high = cb - (cb - b);
    const double b_low = b - b_high;
    error = a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low);
#endif
    return product;
}

// FAST-EXPANSION-SUM with zero elimination: merges by magnitude, then sums upwards. Keeps "strongly nonoverlapping"
// under round-to-even. h needs room for m + n terms and must not alias e or f.
int sum(const double* e, int m, const double* f, int n, double f_sign, double* h) {
    int i = 0;
    int j = 0;
    const auto take_smaller = [&] {
        if (j == n || (i < m && std::abs(e[i]) < std::abs(f[j]))) return e[i++];
        return f_sign * f[j++];
    };
    int count = 0;
    if (m == 1 && n == 1) {
        double error;
        const double high = two_sum(e[0], f_sign * f[0], error);
        if (error != 0.0) h[count++] = error;
        if (high != 0.0) h[count++] = high;
        return count;
    }
    if (m + n == 0) return 0;
    double q = take_smaller();
    while (i < m || j < n) {
        double error;
        q = two_sum(q, take_smaller(), error);
        if (error != 0.0) h[count++] = error;
    }
    if (q != 0.0) h[count++] = q;
    return count;
}

// SCALE-EXPANSION with zero elimination. Keeps "strongly nonoverlapping" under round-to-even. h needs room for 2m
// terms.
int scale(const double* e, int m, double b, double* h) {
    int count = 0;
    double error;
    double q = two_product(e[0], b, error);
    if (error != 0.0) h[count++] = error;
    for (int i = 1; i < m; ++i) {
        double low;
        const double high = two_product(e[i], b, low);
        const double s = two_sum(q, low, error);
        if (error != 0.0) h[count++] = error;
        q = fast_two_sum(high, s, error);
        if (error != 0.0) h[count++] = error;
    }
    if (q != 0.0) h[count++] = q;
    return count;
}

// COMPRESS, in place. The result is nonadjacent, with at most Expansion::capacity terms (see the header).
int compress(double* e, int m) {
    double error;
    double q = e[m - 1];
    int bottom = m - 1;
    for (int i = m - 2; i >= 0; --i) {
        const double s = fast_two_sum(q, e[i], error);
        if (error != 0.0) {
            e[bottom--] = s;
            q = error;
        } else {
            q = s;
        }
    }
    e[bottom] = q;
    int top = 0;
    for (int i = bottom + 1; i < m; ++i) {
        q = fast_two_sum(e[i], q, error);
        if (error != 0.0) e[top++] = error;
    }
    e[top++] = q;
    return top;
}

} // namespace

Expansion& Expansion::operator=(const Expansion& other) {
    size_ = other.size_;
    std::copy_n(other.terms_, other.size_, terms_);
    return *this;
}

void Expansion::assign(double* terms, int count) {
    if (count > lazy_terms) count = compress(terms, count);
    assert(count <= capacity);
    size_ = count;
    std::copy_n(terms, count, terms_);
}

Expansion Expansion::difference(double a, double b) {
    Expansion result;
    double error;
    const double high = two_sum(a, -b, error);
    if (error != 0.0) result.terms_[result.size_++] = error;
    if (high != 0.0) result.terms_[result.size_++] = high;
    return result;
}

Expansion Expansion::product(double a, double b) {
    Expansion result;
    double error;
    const double high = two_product(a, b, error);
    if (error != 0.0) result.terms_[result.size_++] = error;
    if (high != 0.0) result.terms_[result.size_++] = high;
    return result;
}

double Expansion::approximation() const {
    double total = 0.0;
    for (int i = 0; i < size_; ++i) total += terms_[i];
    return total;
}

Expansion Expansion::scaled(double power_of_two) const {
    Expansion result;
    result.size_ = size_;
    for (int i = 0; i < size_; ++i) result.terms_[i] = power_of_two * terms_[i];
    return result;
}

Expansion Expansion::add(const Expansion& a, const Expansion& b, double b_sign) {
    Expansion result;
    if (a.size_ + b.size_ <= capacity) { // without a copy: the usual case, and on lattice data the only one
        result.size_ = sum(a.terms_, a.size_, b.terms_, b.size_, b_sign, result.terms_);
        if (result.size_ > lazy_terms) result.size_ = compress(result.terms_, result.size_);
        return result;
    }
    double terms[2 * capacity];
    result.assign(terms, sum(a.terms_, a.size_, b.terms_, b.size_, b_sign, terms));
    return result;
}

Expansion operator*(const Expansion& a, const Expansion& b) {
    if (a.size_ < b.size_) return b * a;
    if (b.size_ == 0) return {};
    if (a.size_ == 1) return Expansion::product(a.terms_[0], b.terms_[0]);
    double scaled[2 * Expansion::capacity];
    double terms[3 * Expansion::capacity];
    Expansion result;
    result.assign(scaled, scale(a.terms_, a.size_, b.terms_[0], scaled));
    for (int i = 1; i < b.size_; ++i) {
        const int count = scale(a.terms_, a.size_, b.terms_[i], scaled);
        result.assign(terms, sum(result.terms_, result.size_, scaled, count, 1.0, terms));
    }
    return result;
}

} // namespace brittle::fracture::exact

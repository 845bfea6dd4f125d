// Sums of two doubles carry about 104 bits (T. J. Dekker, "A floating-point technique for extending the available
// precision", 1971); a result is rounded once, at its end.
#include "fracture/base/rounded_math.h"

#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace brittle::fracture::rounded {
namespace {

struct Double2 {
    double high, low; // |low| is at most half a unit in the last place of high
};

Double2 quick_sum(double a, double b) { // |a| >= |b|, or a = 0
    const double sum = a + b;
    return {sum, b - (sum - a)};
}

Double2 exact_sum(double a, double b) {
    const double sum = a + b, part = sum - a;
    return {sum, (a - (sum - part)) + (b - part)};
}

Double2 exact_product(double a, double b) {
    const auto split = [](double x) {
        const double c = 134217729.0 * x, high = c - (c - x); // 2^27 + 1
        return Double2{high, x - high};
    };
    const Double2 p = split(a), q = split(b);
    const double product = a * b;
    return {product, ((p.high * q.high - product) + p.high * q.low + p.low * q.high) + p.low * q.low};
}

Double2 operator+(Double2 a, Double2 b) {
    const Double2 high = exact_sum(a.high, b.high), low = exact_sum(a.low, b.low);
    const Double2 sum = quick_sum(high.high, high.low + low.high);
    return quick_sum(sum.high, sum.low + low.low);
}

Double2 operator-(Double2 a) {
    return {-a.high, -a.low};
}

Double2 operator*(Double2 a, Double2 b) {
    const Double2 high = exact_product(a.high, b.high);
    return quick_sum(high.high, high.low + (a.high * b.low + a.low * b.high));
}

Double2 operator/(Double2 a, double b) {
    const double first = a.high / b;
    const Double2 rest = a + -exact_product(first, b);
    const double second = rest.high / b;
    const Double2 last = rest + -exact_product(second, b);
    return quick_sum(first, second) + Double2{last.high / b, 0.0};
}

Double2 operator/(Double2 a, Double2 b) {
    const double first = a.high / b.high;
    const Double2 rest = a + -(b * Double2{first, 0.0});
    return quick_sum(first, rest.high / b.high);
}

constexpr Double2 one{1.0, 0.0};
constexpr std::array half_pi{0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54, -0x1.f1976b7ed8fbcp-110};
constexpr std::array ln2{0x1.62e42fefa39efp-1, 0x1.abc9e3b39803fp-56, 0x1.7b57a079a1934p-111};

// x - k * (the sum of the parts); k is an integer below 2^26, and the first difference small beside x.
Double2 reduced(Double2 x, double k, const std::array<double, 3>& parts) {
    for (const double part : parts) x = x + -exact_product(k, part);
    return x;
}

// 1 / n!
const std::array<Double2, 32> inverse_factorials = [] {
    std::array<Double2, 32> out{one, one};
    for (size_t n = 2; n < out.size(); ++n) out[n] = out[n - 1] / static_cast<double>(n);
    return out;
}();

// The sum of x^n / n! for n = first, first + 2, ..., with alternating signs, |x| at most 0.8.
Double2 series(Double2 x, size_t first) {
    const Double2 square = -(x * x);
    size_t n = 28 + first;
    Double2 sum = inverse_factorials[n];
    while (n > first) {
        n -= 2;
        sum = sum * square + inverse_factorials[n];
    }
    return first == 1 ? sum * x : sum;
}

// The sine of x + quarters * pi / 2.
Double2 sine(double x, int quarters) {
    assert(std::abs(x) <= 1048576.0);
    const double k = std::nearbyint(x / half_pi[0]);
    const Double2 r = reduced({x, 0.0}, k, half_pi);
    const auto quarter = static_cast<uint32_t>(static_cast<int32_t>(k) + quarters) & 3;
    const Double2 value = series(r, quarter & 1 ? 0 : 1);
    return quarter & 2 ? -value : value;
}

Double2 exponential(Double2 x) {
    const double k = std::nearbyint(x.high / ln2[0]);
    const Double2 r = reduced(x, k, ln2) / 16.0;
    Double2 sum = inverse_factorials[17]; // of e^r - 1
    for (size_t n = 16; n > 0; --n) sum = sum * r + inverse_factorials[n];
    sum = sum * r;
    for (int n = 0; n < 4; ++n) sum = sum + sum + sum * sum; // e^2r - 1
    sum = one + sum;
    return {std::ldexp(sum.high, static_cast<int>(k)), std::ldexp(sum.low, static_cast<int>(k))};
}

// From the value of the C library, which is nearly right, by Newton's method for e^y = x.
Double2 logarithm(double x) {
    int exponent = 0;
    const double m = std::frexp(x, &exponent), k = exponent;
    const double y = std::log(m);
    const Double2 q = Double2{m, 0.0} * exponential({-y, 0.0}) + -one;
    const Double2 fine = Double2{y, 0.0} + (q + -(q * q / 2.0));
    return exact_product(k, ln2[0]) + exact_product(k, ln2[1]) + fine;
}

} // namespace

double sin(double x) {
    return sine(x, 0).high;
}

double cos(double x) {
    return sine(x, 1).high;
}

double acos(double x) {
    assert(std::abs(x) <= 1.0);
    const double y = std::acos(x);
    if (x == 1.0 || x == -1.0) return y;
    return (Double2{y, 0.0} + (sine(y, 1) + Double2{-x, 0.0}) / sine(y, 0)).high;
}

double log(double x) {
    assert(x > 0.0);
    return logarithm(x).high;
}

double cbrt(double x) {
    const double y = std::cbrt(x);
    if (x == 0.0) return y;
    const Double2 square = exact_product(y, y), error = square * Double2{y, 0.0} + Double2{-x, 0.0};
    return (Double2{y, 0.0} + -(error / (square + square + square))).high;
}

double hypot(double x, double y) {
    const Double2 square = exact_product(x, x) + exact_product(y, y);
    const double root = std::sqrt(square.high);
    if (root == 0.0) return root;
    const Double2 error = exact_product(root, root) + -square;
    return (Double2{root, 0.0} + -(error / (2.0 * root))).high;
}

double pow(double x, double y) {
    assert(x >= 0.0);
    if (x == 0.0 || x == 1.0 || y == 0.0) return std::pow(x, y);
    return exponential(logarithm(x) * Double2{y, 0.0}).high;
}

} // namespace brittle::fracture::rounded

#include "fracture/arithmetic/dyadic.h"

#include <bit>
#include <cmath>

namespace brittle::fracture::exact {

Dyadic::Dyadic(double x) {
    if (x == 0.0) return;
    int exponent = 0;
    const auto whole = static_cast<int64_t>(std::ldexp(std::frexp(x, &exponent), 53));
    const int zeros = std::countr_zero(static_cast<uint64_t>(whole));
    mantissa_ = whole / (int64_t{1} << zeros); // exact
    exponent_ = exponent - 53 + zeros;
}

Dyadic operator+(const Dyadic& a, const Dyadic& b) {
    if (a.mantissa_.is_zero()) return b;
    if (b.mantissa_.is_zero()) return a;
    if (a.exponent_ < b.exponent_) return b + a;
    Dyadic sum;
    sum.mantissa_ = (a.mantissa_ << static_cast<unsigned>(a.exponent_ - b.exponent_)) + b.mantissa_;
    sum.exponent_ = b.exponent_;
    return sum;
}

Dyadic operator*(const Dyadic& a, const Dyadic& b) {
    Dyadic product;
    product.mantissa_ = a.mantissa_ * b.mantissa_;
    product.exponent_ = a.exponent_ + b.exponent_;
    return product;
}

double Dyadic::over(const Dyadic& divisor) const {
    if (mantissa_.is_zero()) return 0.0;
    Integer n = abs(mantissa_);
    Integer d = abs(divisor.mantissa_);
    // The quotient of the shifted integers has 62 or 63 bits; its last bit stands for all further ones.
    const auto shift = 62 - (static_cast<int64_t>(msb(n)) - static_cast<int64_t>(msb(d)));
    if (shift > 0)
        n <<= static_cast<unsigned>(shift);
    else
        d <<= static_cast<unsigned>(-shift);
    Integer quotient, rest;
    divide_qr(n, d, quotient, rest);
    auto bits = static_cast<uint64_t>(quotient);
    if (!rest.is_zero()) bits |= 1;
    const double size = std::ldexp(static_cast<double>(bits), static_cast<int>(exponent_ - divisor.exponent_ - shift));
    return (sign() < 0) != (divisor.sign() < 0) ? -size : size;
}

} // namespace brittle::fracture::exact

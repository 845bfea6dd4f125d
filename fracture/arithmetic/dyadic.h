// Exact arithmetic on dyadic rationals, m * 2^e, for constructions of high degree.
//
// Every finite double is a dyadic rational, and sums, differences and products of such numbers are too. An Expansion
// (expansion.h) is faster for predicates of low degree; a Dyadic has neither overflow nor underflow. The integers are
// those of Boost.Multiprecision.
#pragma once

#include <cstdint>

#include <boost/multiprecision/cpp_int.hpp>

namespace brittle::fracture::exact {

class Dyadic {
  public:
    Dyadic() = default;
    explicit Dyadic(double x); // finite

    [[nodiscard]] int sign() const { return mantissa_.sign(); }

    // Returns the double next to this / divisor, rounded to nearest. The rounding is monotonic: of two quotients the
    // smaller one never gives the larger double. Precondition: the divisor is not zero and the result does not
    // overflow.
    [[nodiscard]] double over(const Dyadic& divisor) const;

    friend Dyadic operator-(Dyadic a) {
        a.mantissa_ = -a.mantissa_;
        return a;
    }
    friend Dyadic operator+(const Dyadic& a, const Dyadic& b);
    friend Dyadic operator-(const Dyadic& a, const Dyadic& b) { return a + -b; }
    friend Dyadic operator*(const Dyadic& a, const Dyadic& b);

  private:
    // Numbers up to 512 bits need no memory of their own: coordinates of crossing points of floats.
    using Backend = boost::multiprecision::cpp_int_backend<512, 0, boost::multiprecision::signed_magnitude,
                                                           boost::multiprecision::unchecked,
                                                           std::allocator<boost::multiprecision::limb_type>>;
    using Integer = boost::multiprecision::number<Backend, boost::multiprecision::et_off>;

    Integer mantissa_ = 0;
    int64_t exponent_ = 0;
};

} // namespace brittle::fracture::exact

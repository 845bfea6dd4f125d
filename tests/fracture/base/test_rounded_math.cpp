#include <cfloat>
#include <cmath>
#include <limits>
#include <numbers>

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <doctest/doctest.h>

#include "fracture/base/random.h"
#include "fracture/base/rounded_math.h"

namespace rounded = brittle::fracture::rounded;

namespace {

using Exact = boost::multiprecision::cpp_bin_float_50;

double nearest(const Exact& x) {
    return x.convert_to<double>();
}

} // namespace

TEST_CASE("rounded functions give the double next to the exact value") {
    brittle::fracture::Random random(3);
    const auto between = [&](double a, double b) { return a + (b - a) * random.uniform(); };
    for (int k = 0; k < 2000; ++k) {
        const double angle = between(-60.0, 60.0), share = between(-1.0, 1.0), above = between(1e-9, 3.0);
        const double size = std::exp(between(-200.0, 200.0)), power = between(-3.0, 3.0);
        CAPTURE(angle);
        CAPTURE(share);
        CAPTURE(above);
        CAPTURE(size);
        CAPTURE(power);
        REQUIRE(rounded::sin(angle) == nearest(sin(Exact(angle))));
        REQUIRE(rounded::cos(angle) == nearest(cos(Exact(angle))));
        REQUIRE(rounded::acos(share) == nearest(acos(Exact(share))));
        REQUIRE(rounded::log(above) == nearest(log(Exact(above))));
        REQUIRE(rounded::log(size) == nearest(log(Exact(size))));
        REQUIRE(rounded::cbrt(-size) == nearest(-cbrt(Exact(size))));
        REQUIRE(rounded::hypot(angle, above) == nearest(sqrt(Exact(angle) * angle + Exact(above) * above)));
        REQUIRE(rounded::pow(size, power) == nearest(pow(Exact(size), Exact(power))));
    }
}

TEST_CASE("rounded functions at their limits") {
    CHECK(rounded::sin(0.0) == 0.0);
    CHECK(rounded::cos(0.0) == 1.0);
    CHECK(rounded::sin(1048576.0) == nearest(sin(Exact(1048576.0))));
    CHECK(rounded::cos(-1048576.0) == nearest(cos(Exact(1048576.0))));
    // Near pi the result is what the argument lacks of pi, and all of its bits count.
    CHECK(rounded::sin(std::numbers::pi) == nearest(sin(Exact(std::numbers::pi))));
    CHECK(rounded::cos(std::numbers::pi / 2) == nearest(cos(Exact(std::numbers::pi / 2))));
    CHECK(rounded::acos(1.0) == 0.0);
    CHECK(rounded::acos(-1.0) == std::numbers::pi);
    CHECK(rounded::acos(std::nextafter(1.0, 0.0)) == nearest(acos(Exact(std::nextafter(1.0, 0.0)))));
    CHECK(rounded::log(1.0) == 0.0);
    CHECK(rounded::log(std::nextafter(1.0, 2.0)) == nearest(log(Exact(std::nextafter(1.0, 2.0)))));
    CHECK(rounded::log(std::numeric_limits<double>::denorm_min()) == nearest(-1074 * log(Exact(2))));
    CHECK(rounded::log(DBL_MAX) == nearest(log(Exact(DBL_MAX))));
    CHECK(rounded::cbrt(0.0) == 0.0);
    CHECK(rounded::cbrt(-27.0) == -3.0);
    CHECK(rounded::hypot(0.0, 0.0) == 0.0);
    CHECK(rounded::hypot(3.0, -4.0) == 5.0);
    CHECK(rounded::pow(0.0, 0.5) == 0.0);
    CHECK(rounded::pow(0.0, 0.0) == 1.0);
    CHECK(rounded::pow(7.0, 0.0) == 1.0);
    CHECK(rounded::pow(2.0, 10.0) == 1024.0);
    CHECK(rounded::pow(9.0, 0.5) == 3.0);
}

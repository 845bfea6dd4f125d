#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include <boost/multiprecision/cpp_int.hpp>

#include "fracture/arithmetic/dyadic.h"
#include "fracture/base/random.h"

using brittle::fracture::Random;
using brittle::fracture::exact::Dyadic;
using Rational = boost::multiprecision::cpp_rational;

TEST_CASE("dyadic: polynomials have the signs of rational numbers, over the whole range of doubles") {
    Random random(1);
    const auto number = [&] {
        const int kind = static_cast<int>(random.next() % 4);
        if (kind == 0) return 0.0;
        if (kind == 1) return static_cast<double>(static_cast<int>(random.next() % 9) - 4);
        return std::ldexp(2.0 * random.uniform() - 1.0,
                          static_cast<int>(random.next() % (kind == 2 ? 8 : 1900)) - (kind == 2 ? 4 : 1000));
    };
    for (int round = 0; round < 2000; ++round) {
        const double a = number(), b = number(), c = number(), d = number();
        const Dyadic x = Dyadic(a) * Dyadic(b) - Dyadic(c) * Dyadic(d) + Dyadic(a) * Dyadic(c) * Dyadic(d);
        const Rational y =
            Rational(a) * Rational(b) - Rational(c) * Rational(d) + Rational(a) * Rational(c) * Rational(d);
        CHECK(x.sign() == y.sign());
        CHECK((x - x).sign() == 0);
        CHECK((-x).sign() == -y.sign());
    }
}

TEST_CASE("dyadic: quotients are the nearest doubles, and keep their order") {
    Random random(2);
    for (int round = 0; round < 2000; ++round) {
        const double a = std::ldexp(random.uniform() - 0.5, static_cast<int>(random.next() % 100) - 50);
        const double b = std::ldexp(random.uniform() - 0.5, static_cast<int>(random.next() % 100) - 50);
        if (b == 0.0) continue;
        CHECK(Dyadic(a).over(Dyadic(b)) == a / b); // IEEE division rounds to nearest
        CHECK((Dyadic(a) * Dyadic(b)).over(Dyadic(b)) == a);
        const Dyadic next = Dyadic(a) + Dyadic(std::ldexp(1.0, -300));
        const double quotient = next.over(Dyadic(b));
        CHECK((b > 0.0 ? quotient >= a / b : quotient <= a / b));
    }
    CHECK(Dyadic(0.0).over(Dyadic(-3.0)) == 0.0);
    CHECK(Dyadic(1.0).over(Dyadic(3.0)) == 1.0 / 3.0);
    const double tiny = std::numeric_limits<double>::denorm_min();
    CHECK(Dyadic(tiny).over(Dyadic(1.0)) == tiny);
}

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include <boost/multiprecision/cpp_int.hpp>

#include "fracture/arithmetic/expansion.h"
#include "fracture/base/random.h"

using brittle::fracture::Random;
using brittle::fracture::exact::Expansion;
using Rational = boost::multiprecision::cpp_rational;

namespace {

Rational exact(const Expansion& e) {
    Rational total = 0;
    for (int i = 0; i < e.size(); ++i) total += Rational(e.terms()[i]);
    return total;
}

int sign(const Rational& r) {
    return r.sign();
}

// Returns the lowest bit set in x.
double lowest_bit(double x) {
    int exponent;
    const double mantissa = std::frexp(x, &exponent);
    auto bits = static_cast<int64_t>(std::ldexp(mantissa, 53));
    int shift = exponent - 53;
    while ((bits & 1) == 0) {
        bits /= 2;
        ++shift;
    }
    return std::ldexp(1.0, shift);
}

// Checks value, sign and the invariants that the next operation relies on.
void check(const Expansion& e, const Rational& expected) {
    REQUIRE(exact(e) == expected);
    REQUIRE(e.sign() == sign(expected));
    REQUIRE(e.size() <= Expansion::capacity);
    for (int i = 0; i < e.size(); ++i) {
        REQUIRE(e.terms()[i] != 0.0);
        if (i > 0) REQUIRE(std::abs(e.terms()[i - 1]) < lowest_bit(e.terms()[i]));
    }
    if (expected != 0) {
        const Rational error = abs(Rational(e.approximation()) - expected);
        REQUIRE(error <= abs(expected) * Rational(0x1.0p-52));
    }
}

// Returns a double whose mantissa stresses rounding (random, few bits, runs of ones), with an exponent within +-range.
double awkward(Random& random, int range) {
    double x;
    switch (random.next() % 4) {
    case 0:
        x = random.uniform();
        break;
    case 1:
        x = 1.0;
        break;
    case 2:
        x = std::nextafter(1.0, random.next() % 2 ? 0.0 : 2.0);
        break;
    default:
        x = static_cast<double>(random.next() % 16);
        break;
    }
    if (random.next() % 2) x = -x;
    const int exponent = range == 0 ? 0 : static_cast<int>(random.next() % (2 * range + 1)) - range;
    return std::ldexp(x, exponent);
}

} // namespace

TEST_CASE("an expansion of zero has no terms and no sign") {
    check(Expansion(), 0);
    check(Expansion(0.0), 0);
    check(Expansion(-0.0), 0);
    check(Expansion::difference(0.1, 0.1), 0);
    check(Expansion::product(0.0, 3.0), 0);
    const Expansion a = Expansion::difference(1.0, 0x1.0p-200);
    check(a - a, 0);
    check(a * Expansion(), 0);
    check(Expansion() * a, 0);
    check(Expansion() - a, -exact(a));
    CHECK(Expansion().approximation() == 0.0);
}

TEST_CASE("the sign of an expansion is exact after total cancellation of the leading parts") {
    const Expansion one(1.0);
    const Expansion tiny(0x1.0p-300);
    const Expansion square = (one + tiny) * (one + tiny);
    check(square - one - tiny.scaled(2.0), Rational(0x1.0p-300) * Rational(0x1.0p-300));
    check(-square + one, -(Rational(0x1.0p-299) + Rational(0x1.0p-300) * Rational(0x1.0p-300)));
}

TEST_CASE("random expressions agree with rational arithmetic and satisfy the invariants") {
    Random random(1);
    for (int run = 0; run < 3000; ++run) {
        const int range = run % 3 == 0 ? 0 : (run % 3 == 1 ? 40 : 100);
        std::vector<Expansion> values;
        std::vector<Rational> expected;
        for (int i = 0; i < 4; ++i) {
            const double a = awkward(random, range);
            const double b = awkward(random, range);
            values.push_back(Expansion::difference(a, b));
            expected.push_back(Rational(a) - Rational(b));
        }
        for (int step = 0; step < 6; ++step) {
            const size_t i = random.next() % values.size();
            const size_t j = random.next() % values.size();
            switch (random.next() % 4) {
            case 0:
                values.push_back(values[i] + values[j]);
                expected.push_back(expected[i] + expected[j]);
                break;
            case 1:
                values.push_back(values[i] - values[j]);
                expected.push_back(expected[i] - expected[j]);
                break;
            case 2:
                values.push_back(-values[i].scaled(2.0));
                expected.push_back(-2 * expected[i]);
                break;
            default:
                if (i >= 6 || j >= 6) continue; // limits the degree, and with it the exponents
                values.push_back(values[i] * values[j]);
                expected.push_back(expected[i] * expected[j]);
                break;
            }
            check(values.back(), expected.back());
        }
    }
}

TEST_CASE("terms across the whole range of doubles fit the proven capacity of an expansion") {
    Random random(2);
    int longest = 0;
    for (int run = 0; run < 20; ++run) {
        Expansion total;
        Rational expected = 0;
        for (int i = 0; i < 400; ++i) {
            const double x = awkward(random, 1010);
            total = total + Expansion(x);
            expected += Rational(x);
            longest = std::max(longest, total.size());
        }
        check(total, expected);
    }
    CHECK(longest > 30); // the input nearly reaches the bound of 41 terms

    Expansion a;
    Expansion b;
    for (int i = 0; i < 200; ++i) {
        a = a + Expansion(awkward(random, 460));
        b = b + Expansion(awkward(random, 460));
    }
    REQUIRE(a.size() > 15);
    check(a * b, exact(a) * exact(b));
}

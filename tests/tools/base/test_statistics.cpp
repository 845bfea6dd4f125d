#include <doctest/doctest.h>

#include "tools/brittle/base/statistics.h"

using brittle::tools::Statistics;
using brittle::tools::statistics;

TEST_CASE("no sample gives zeros") {
    const Statistics s = statistics({});
    CHECK(s.min == 0.0);
    CHECK(s.median == 0.0);
    CHECK(s.p95 == 0.0);
    CHECK(s.p99 == 0.0);
    CHECK(s.max == 0.0);
}

TEST_CASE("one sample is its own median, percentile and maximum") {
    const Statistics s = statistics({4.0});
    CHECK(s.min == 4.0);
    CHECK(s.median == 4.0);
    CHECK(s.p95 == 4.0);
    CHECK(s.p99 == 4.0);
    CHECK(s.max == 4.0);
}

TEST_CASE("the median of an even count is the mean of the middle two, in any order") {
    CHECK(statistics({4.0, 1.0, 3.0, 2.0}).median == 2.5);
    CHECK(statistics({9.0, 1.0, 5.0}).median == 5.0);
}

TEST_CASE("the 95th and 99th percentile are the nearest rank") {
    std::vector<double> samples;
    for (int i = 100; i >= 1; --i) samples.push_back(i);
    const Statistics s = statistics(samples);
    CHECK(s.p95 == 95.0);
    CHECK(s.p99 == 99.0);
    CHECK(s.min == 1.0);
    CHECK(s.max == 100.0);
    CHECK(statistics({1.0, 2.0, 3.0}).p95 == 3.0);
    CHECK(statistics({1.0, 2.0, 3.0}).p99 == 3.0);
    samples.push_back(101.0);
    CHECK(statistics(samples).p95 == 96.0); // rank ceil(0.95 * 101)
    CHECK(statistics(samples).p99 == 100.0);
}

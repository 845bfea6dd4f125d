#include "fracture/mesh/mesh.h"

#include <limits>
#include <vector>

#include <doctest/doctest.h>
#include <glm/common.hpp>

#include "fracture/base/random.h"

using namespace brittle::fracture;

TEST_CASE("bounds: no position, one position") {
    CHECK(bounds(std::span<const glm::dvec3>()).size() == glm::dvec3(0.0));
    const std::vector<glm::dvec3> one{{1.0, -2.0, 3.0}};
    CHECK(bounds(one).min == one[0]);
    CHECK(bounds(one).max == one[0]);
}

TEST_CASE("bounds: any number of random positions") {
    Random random(1);
    std::vector<glm::dvec3> positions;
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
    for (int count = 1; count < 70; ++count) {
        positions.push_back({random.uniform(), random.uniform(), random.uniform()});
        low = glm::min(low, positions.back());
        high = glm::max(high, positions.back());
        CAPTURE(count);
        CHECK(bounds(positions).min == low);
        CHECK(bounds(positions).max == high);
    }
}

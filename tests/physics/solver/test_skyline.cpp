#include "physics/solver/skyline.h"

#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

using Dense = std::vector<std::vector<double>>;

// Puts the lower half of a symmetric matrix, from its first entry in each row.
Skyline skyline_of(const Dense& matrix) {
    std::vector<uint32_t> firsts;
    for (uint32_t i = 0; i < matrix.size(); ++i) {
        uint32_t first = 0;
        while (first < i && matrix[i][first] == 0.0) ++first;
        firsts.push_back(first);
    }
    Skyline skyline;
    skyline.shape(firsts);
    for (uint32_t i = 0; i < matrix.size(); ++i)
        for (uint32_t j = firsts[i]; j <= i; ++j) skyline.at(i, j) = matrix[i][j];
    return skyline;
}

std::vector<double> times(const Dense& matrix, const std::vector<double>& x) {
    std::vector<double> product(x.size(), 0.0);
    for (size_t i = 0; i < x.size(); ++i)
        for (size_t j = 0; j < x.size(); ++j) product[i] += matrix[i][j] * x[j];
    return product;
}

} // namespace

TEST_CASE("skyline: an empty matrix, and a row of zeros") {
    Skyline skyline = skyline_of({});
    skyline.factor();
    std::vector<double> x;
    skyline.solve(x);
    CHECK(skyline.size() == 0);

    skyline = skyline_of({{4.0, 0.0, 2.0}, {0.0, 0.0, 0.0}, {2.0, 0.0, 2.0}});
    skyline.factor();
    x = {8.0, 5.0, 6.0};
    skyline.solve(x);
    CHECK(x[0] == doctest::Approx(1.0));
    CHECK(x[1] == 0.0);
    CHECK(x[2] == doctest::Approx(2.0));
}

TEST_CASE("skyline: a repeated row gets nothing, and the rest is solved") {
    Skyline skyline = skyline_of({{2.0, 2.0, 1.0}, {2.0, 2.0, 1.0}, {1.0, 1.0, 3.0}});
    skyline.factor();
    std::vector<double> x{5.0, 5.0, 10.0};
    skyline.solve(x);
    CHECK(x[0] == doctest::Approx(1.0));
    CHECK(x[1] == 0.0);
    CHECK(x[2] == doctest::Approx(3.0));
}

TEST_CASE("skyline: random sparse matrices, multiplied with the solution, give the right side") {
    test::Random random(7);
    for (int round = 0; round < 50; ++round) {
        const auto size = static_cast<size_t>(random.uniform(1.0, 30.0));
        // B B^T + 1, with rows of B that reach back by different lengths.
        Dense root(size, std::vector<double>(size, 0.0));
        for (size_t i = 0; i < size; ++i)
            for (size_t j = i - std::min(i, static_cast<size_t>(random.uniform(0.0, 5.0))); j <= i; ++j)
                root[i][j] = random.uniform(-1.0, 1.0);
        Dense matrix(size, std::vector<double>(size, 0.0));
        for (size_t i = 0; i < size; ++i)
            for (size_t j = 0; j < size; ++j) {
                for (size_t k = 0; k < size; ++k) matrix[i][j] += root[i][k] * root[j][k];
                if (i == j) matrix[i][j] += 1.0;
            }
        std::vector<double> right(size);
        for (double& value : right) value = random.uniform(-1.0, 1.0);
        Skyline skyline = skyline_of(matrix);
        skyline.factor();
        std::vector<double> x = right;
        skyline.solve(x);
        const std::vector<double> product = times(matrix, x);
        for (size_t i = 0; i < size; ++i) CHECK(std::abs(product[i] - right[i]) < 1e-10);
    }
}

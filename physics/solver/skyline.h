// L D L^T of a sparse symmetric positive semidefinite matrix whose entries lie near the diagonal (skyline storage).
//
// A row is stored from its first entry to the diagonal. The factor has the same skyline, so a chain of joints costs a
// time proportional to its length. A pivot below min_pivot of its diagonal entry is a row that depends on those before
// it: it is left out, and its unknown is 0. Double precision.
//
//     skyline.shape(firsts);                             // by row: the column of its first entry
//     skyline.at(i, j) = ...;                            // firsts[i] <= j <= i
//     skyline.factor();
//     skyline.solve(x);                                  // in: the right side, out: the solution
//
// A. George and J. Liu, "Computer Solution of Large Sparse Positive Definite Systems", 1981, chapter 4.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace brittle::physics {

class Skyline {
  public:
    // The square of the sine between a row of the Jacobian and the others, below which it is one of their sums. Hinges
    // whose axes are apart by less than 0.3 mm per metre still turn together.
    static constexpr double min_pivot = 1e-7;

    // Precondition: firsts[i] <= i. All entries become 0.
    void shape(std::span<const uint32_t> firsts) {
        firsts_.assign(firsts.begin(), firsts.end());
        starts_.clear();
        size_t size = 0;
        for (uint32_t i = 0; i < firsts.size(); ++i) {
            starts_.push_back(size - firsts[i]); // may wrap around; at() adds the column again
            size += i - firsts[i] + 1;
        }
        values_.assign(size, 0.0);
    }
    [[nodiscard]] uint32_t size() const { return static_cast<uint32_t>(firsts_.size()); }
    [[nodiscard]] uint32_t first(uint32_t row) const { return firsts_[row]; }
    [[nodiscard]] double& at(uint32_t row, uint32_t column) { return values_[starts_[row] + column]; }

    void factor() {
        inverse_pivots_.resize(size());
        for (uint32_t i = 0; i < size(); ++i) {
            for (uint32_t j = firsts_[i]; j < i; ++j)
                for (uint32_t k = std::max(firsts_[i], firsts_[j]); k < j; ++k) at(i, j) -= at(i, k) * at(j, k);
            const double diagonal = at(i, i);
            for (uint32_t j = firsts_[i]; j < i; ++j) {
                const double product = at(i, j);
                at(i, j) *= inverse_pivots_[j];
                at(i, i) -= product * at(i, j);
            }
            inverse_pivots_[i] = at(i, i) > min_pivot * diagonal ? 1.0 / at(i, i) : 0.0;
        }
    }
    // Precondition: factor() was called.
    void solve(std::span<double> x) {
        for (uint32_t i = 0; i < size(); ++i)
            for (uint32_t j = firsts_[i]; j < i; ++j) x[i] -= at(i, j) * x[j];
        for (uint32_t i = 0; i < size(); ++i) x[i] *= inverse_pivots_[i];
        for (uint32_t i = size(); i-- > 0;)
            for (uint32_t j = firsts_[i]; j < i; ++j) x[j] -= at(i, j) * x[i];
    }

  private:
    std::vector<uint32_t> firsts_;
    std::vector<size_t> starts_;
    std::vector<double> values_; // by row
    std::vector<double> inverse_pivots_;
};

} // namespace brittle::physics

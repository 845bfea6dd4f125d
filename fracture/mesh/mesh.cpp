#include "fracture/mesh/mesh.h"

#include <algorithm>
#include <array>

#include "fracture/base/simd.h"

namespace brittle::fracture {

static_assert(sizeof(glm::dvec3) == 3 * sizeof(double));

// Eight points at a time, as 24 coordinates in sequence.
BRITTLE_SIMD Box bounds(std::span<const glm::dvec3> positions) {
    constexpr size_t points = 8, lanes = 3 * points;
    if (positions.empty()) return {};
    std::array<double, lanes> low, high;
    for (size_t k = 0; k < lanes; ++k) low[k] = high[k] = positions[0][static_cast<int>(k % 3)];
    const double* const coordinates = &positions[0].x;
    const size_t whole = positions.size() / points * lanes;
    for (size_t i = 0; i < whole; i += lanes) {
        for (size_t k = 0; k < lanes; ++k) {
            low[k] = coordinates[i + k] < low[k] ? coordinates[i + k] : low[k];
            high[k] = coordinates[i + k] > high[k] ? coordinates[i + k] : high[k];
        }
    }
    for (size_t k = 0; k < 3 * positions.size() - whole; ++k) {
        low[k] = std::min(low[k], coordinates[whole + k]);
        high[k] = std::max(high[k], coordinates[whole + k]);
    }
    Box box{positions[0], positions[0]};
    for (size_t k = 0; k < lanes; ++k) {
        const int axis = static_cast<int>(k % 3);
        box.min[axis] = std::min(box.min[axis], low[k]);
        box.max[axis] = std::max(box.max[axis], high[k]);
    }
    return box;
}

} // namespace brittle::fracture

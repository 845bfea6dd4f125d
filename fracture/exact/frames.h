// The neighbours of each cell as arrays for vectorised tests: in the frame of site c, neighbour l is the
// plane h - n.y = 0 with n = s_l - s_c and h = (|n|^2 + W_c - W_l) / 2, positive on the side of c (predicates.h).
#pragma once

#include <vector>

#include "fracture/base/threads.h"
#include "fracture/exact/predicates.h"
#include "fracture/exact/voronoi.h"

namespace brittle::fracture::exact {

struct Frames {
    // A neighbour's place in the arrays. Each cell's run starts at a multiple of lane_count and is filled up with
    // planes that nothing is beyond.
    using Slot = uint32_t;
    static constexpr uint32_t lane_count = 8;
    // Slots that n neighbours take.
    [[nodiscard]] static constexpr uint32_t padded(uint32_t n) {
        return (n + lane_count - 1) / lane_count * lane_count;
    }

    struct Cell {
        glm::dvec3 site;
        double error;             // of a value anywhere in the box, in double
        float float_error;        // in float
        Slot begin, end;          // end without the filling
        uint32_t first_neighbour; // into VoronoiDiagram::neighbours
    };

    std::vector<Cell> cells;
    std::vector<double> nx, ny, nz, h;
    std::vector<float> fx, fy, fz, fh; // divided by |n|: values are distances
    std::vector<SiteId> site;

    [[nodiscard]] Bisector plane(Slot l) const { return {{nx[l], ny[l], nz[l]}, h[l], 0.0}; }
    [[nodiscard]] double value_at(Slot l, const glm::dvec3& y) const {
        return h[l] - (nx[l] * y.x + ny[l] * y.y + nz[l] * y.z);
    }

    void build(const Diagram& problem, const VoronoiDiagram& diagram, Threads& threads);
};

// Values of the planes [begin, begin + n) at y; n is a multiple of Frames::lane_count.
void plane_values_at(const Frames& frames, Frames::Slot begin, uint32_t n, const glm::dvec3& y, double* values);

// The least distance to the planes [begin, begin + n) from y, in float, and its slot; negative beyond the
// plane.
struct LeastDistance {
    float distance;
    Frames::Slot slot;
};
[[nodiscard]] LeastDistance min_distance_at(const Frames& frames, Frames::Slot begin, uint32_t n, float x, float y,
                                            float z);

} // namespace brittle::fracture::exact

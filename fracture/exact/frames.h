// The neighbours of each cell as arrays for vectorised tests. In the frame of site c, neighbour l is the plane h - n.y
// = 0 with n = s_l - s_c and h = (|n|^2 + W_c - W_l) / 2; its value is positive on the side of c (predicates.h).
#pragma once

#include <vector>

#include "fracture/base/threads.h"
#include "fracture/exact/predicates.h"
#include "fracture/exact/voronoi.h"

namespace brittle::fracture::exact {

struct Frames {
    // The index of a neighbour in the arrays. The run of each cell starts at a multiple of lane_count and is padded
    // with planes that no point lies beyond.
    using Slot = uint32_t;
    static constexpr uint32_t lane_count = 8;
    // The number of slots that n neighbours take, padding included.
    [[nodiscard]] static constexpr uint32_t padded(uint32_t n) {
        return (n + lane_count - 1) / lane_count * lane_count;
    }

    struct Cell {
        glm::dvec3 site;
        double error;             // bound of value_at() - exact value, for any point in the box
        float float_error;        // bound for the distances in float
        Slot begin, end;          // end: without the padding
        uint32_t first_neighbour; // into VoronoiDiagram::neighbours
    };

    std::vector<Cell> cells;
    std::vector<double> nx, ny, nz, h;
    std::vector<float> fx, fy, fz, fh; // divided by |n|, so values are distances
    std::vector<SiteId> site;

    [[nodiscard]] Bisector plane(Slot l) const { return {{nx[l], ny[l], nz[l]}, h[l], 0.0}; }
    [[nodiscard]] double value_at(Slot l, const glm::dvec3& y) const {
        return h[l] - (nx[l] * y.x + ny[l] * y.y + nz[l] * y.z);
    }

    void build(const Diagram& problem, const VoronoiDiagram& diagram, Threads& threads);
};

// Computes the values of the planes [begin, begin + n) at y; n is a multiple of Frames::lane_count.
void plane_values_at(const Frames& frames, Frames::Slot begin, uint32_t n, const glm::dvec3& y, double* values);

// The least signed distance from y to the planes [begin, begin + n), in float, with its slot; negative beyond a plane.
struct MinDistance {
    float distance;
    Frames::Slot slot;
};
[[nodiscard]] MinDistance min_distance_at(const Frames& frames, Frames::Slot begin, uint32_t n, float x, float y,
                                          float z);

} // namespace brittle::fracture::exact

#include "fracture/exact/frames.h"

#include <algorithm>
#include <cmath>

#include "fracture/base/simd.h"

namespace brittle::fracture::exact {

namespace {

constexpr uint32_t min_cells_per_chunk = 32;
constexpr double beyond_reach = 1e30; // the h of padding planes

// The factor of value_error() in float roundoffs, plus one for the rounding of y and one for the error in double.
constexpr double float_roundoff = 0xa.0p-24;

} // namespace

void Frames::build(const Diagram& problem, const VoronoiDiagram& diagram, Threads& threads) {
    const auto sites = static_cast<uint32_t>(problem.sites.size());
    cells.resize(sites);
    uint32_t slots = 0;
    for (SiteId c = 0; c < sites; ++c) {
        const uint32_t n = diagram.cell_begin[c + 1] - diagram.cell_begin[c];
        cells[c].begin = slots;
        cells[c].end = slots + n;
        cells[c].first_neighbour = diagram.cell_begin[c];
        slots += padded(n);
    }
    for (auto* array : {&nx, &ny, &nz, &h}) array->resize(slots);
    for (auto* array : {&fx, &fy, &fz, &fh}) array->resize(slots);
    site.resize(slots);
    threads.for_chunks(sites, min_cells_per_chunk, [&](uint32_t, uint32_t first, uint32_t last) {
        for (SiteId c = first; c < last; ++c) {
            Cell& cell = cells[c];
            cell.site = problem.sites[c];
            double longest = 0.0, weight = 0.0, highest = 0.0; // of |n|, |W_c - W_l|, and h / |n| before rounding
            const Slot filled = cell.begin + padded(cell.end - cell.begin);
            for (Slot l = cell.begin; l < filled; ++l) {
                Bisector plane{glm::dvec3(0.0), beyond_reach, 0.0};
                site[l] = VoronoiDiagram::none;
                if (l < cell.end) {
                    site[l] = diagram.neighbours[cell.first_neighbour + (l - cell.begin)].site;
                    plane = make_bisector(problem, c, site[l]);
                    longest = std::max(longest, plane.length);
                    weight = std::max(weight, plane.weight);
                    highest = std::max(highest, plane.magnitude() / plane.length);
                }
                const double unit = plane.length > 0.0 ? 1.0 / plane.length : 1.0;
                nx[l] = plane.n.x;
                ny[l] = plane.n.y;
                nz[l] = plane.n.z;
                h[l] = plane.h;
                fx[l] = static_cast<float>(plane.n.x * unit);
                fy[l] = static_cast<float>(plane.n.y * unit);
                fz[l] = static_cast<float>(plane.n.z * unit);
                fh[l] = static_cast<float>(plane.h * unit);
            }
            const glm::dvec3 far =
                glm::max(glm::abs(problem.box.min - cell.site), glm::abs(problem.box.max - cell.site));
            const double reach = glm::length(far);
            cell.error = value_error(longest, reach, weight);
            const double height = problem.weights.empty() ? 0.5 * longest : highest;
            cell.float_error = static_cast<float>(float_roundoff * (height + reach));
        }
    });
}

BRITTLE_SIMD void plane_values_at(const Frames& frames, Frames::Slot begin, uint32_t n, const glm::dvec3& y,
                                  double* values) {
    const double* nx = frames.nx.data() + begin;
    const double* ny = frames.ny.data() + begin;
    const double* nz = frames.nz.data() + begin;
    const double* h = frames.h.data() + begin;
    const double x = y.x, yy = y.y, z = y.z;
    for (uint32_t l = 0; l < n; ++l) values[l] = h[l] - (nx[l] * x + ny[l] * yy + nz[l] * z);
}

BRITTLE_SIMD MinDistance min_distance_at(const Frames& frames, Frames::Slot begin, uint32_t n, float x, float y,
                                         float z) {
    constexpr uint32_t lanes = Frames::lane_count;
    const float* nx = frames.fx.data() + begin;
    const float* ny = frames.fy.data() + begin;
    const float* nz = frames.fz.data() + begin;
    const float* h = frames.fh.data() + begin;
    float least[lanes];
    uint32_t block[lanes];
    for (uint32_t k = 0; k < lanes; ++k) {
        least[k] = h[k] - (nx[k] * x + ny[k] * y + nz[k] * z);
        block[k] = 0;
    }
    for (uint32_t b = lanes; b < n; b += lanes) {
        for (uint32_t k = 0; k < lanes; ++k) {
            const float g = h[b + k] - (nx[b + k] * x + ny[b + k] * y + nz[b + k] * z);
            block[k] = g < least[k] ? b : block[k];
            least[k] = g < least[k] ? g : least[k];
        }
    }
    MinDistance result{least[0], begin + block[0]};
    for (uint32_t k = 1; k < lanes; ++k) {
        if (least[k] < result.distance) result = {least[k], begin + block[k] + k};
    }
    return result;
}

} // namespace brittle::fracture::exact

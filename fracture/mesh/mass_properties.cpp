#include "fracture/mesh/mass_properties.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/base/simd.h"

namespace brittle::fracture {
namespace {

// The relative volume, in units of area x radius, below which the volume is rounding noise of its own sum and dividing
// by it would give an arbitrary centre of mass. A slab of relative thickness 1e-14 is still above it.
constexpr double volume_noise = 8.0 * std::numeric_limits<double>::epsilon();

// Triangles per block. Blocks are summed plainly and added to a compensated total: the error grows with the block
// instead of with the mesh, at almost no cost. Compensating every addition takes three times as long.
constexpr size_t block_size = 64;

// Neumaier's compensated sum of N quantities in parallel.
template<size_t N>
struct CompensatedSum {
    std::array<double, N> sum{};
    std::array<double, N> lost{};

    void add(const std::array<double, N>& terms) {
        for (size_t k = 0; k < N; ++k) {
            const double total = sum[k] + terms[k];
            const bool sum_is_larger = std::abs(sum[k]) >= std::abs(terms[k]);
            lost[k] += sum_is_larger ? (sum[k] - total) + terms[k] : (terms[k] - total) + sum[k];
            sum[k] = total;
        }
    }
    double operator[](size_t k) const { return sum[k] + lost[k]; }
};

// Bounds the corners of triangles instead of all positions: an unused vertex must not move the reference point.
Box box_of_corners(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles) {
    if (triangles.empty()) return {};
    glm::dvec3 low = positions[triangles[0].x];
    glm::dvec3 high = low;
    for (const Triangle& t : triangles) {
        assert(t.x < positions.size() && t.y < positions.size() && t.z < positions.size());
        for (const uint32_t v : {t.x, t.y, t.z}) {
            low = glm::min(low, positions[v]);
            high = glm::max(high, positions[v]);
        }
    }
    return {low, high};
}

// The reference point of the integrals.
glm::dvec3 origin_of(const Box& box) {
    return box.min + box.size() * 0.5;
}

glm::dvec3 mean_of_corners(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles,
                           const glm::dvec3& near) {
    glm::dvec3 sum(0.0);
    for (const Triangle& t : triangles) {
        sum += (positions[t.x] - near) + (positions[t.y] - near) + (positions[t.z] - near);
    }
    return near + sum / (3.0 * static_cast<double>(triangles.size()));
}

// Returns the two shorter edges of a triangle, in its orientation. Selects instead of branches: the longest edge is as
// good as random, and the loops below can be vectorised.
std::array<glm::dvec3, 2> shorter_edges(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const glm::dvec3 ab = b - a, bc = c - b, ca = a - c;
    const double ab2 = dot(ab, ab), bc2 = dot(bc, bc), ca2 = dot(ca, ca);
    const bool bc_is_longest = static_cast<bool>((bc2 >= ab2) & (bc2 >= ca2)), ca_exceeds_ab = ca2 >= ab2;
    const auto select = [&](double if_ab, double if_bc, double if_ca) {
        const double other = ca_exceeds_ab ? if_ca : if_ab;
        return bc_is_longest ? if_bc : other;
    };
    return {glm::dvec3(select(bc.x, ca.x, ab.x), select(bc.y, ca.y, ab.y), select(bc.z, ca.z, ab.z)),
            glm::dvec3(select(ca.x, ab.x, bc.x), select(ca.y, ab.y, bc.y), select(ca.z, ab.z, bc.z))};
}

// Returns the normal of a triangle with a length of twice its area, from its two shorter edges: in a needle, the
// rounding error of the product of two long edges is many times the area. The edges come from the original positions,
// because even a translation costs a needle some digits.
glm::dvec3 area_vector(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const auto edges = shorter_edges(a, b, c);
    return cross(edges[0], edges[1]);
}

// The corners of the triangles that one vectorised loop integrates: some triangles of each of `lanes` blocks.
constexpr size_t lanes = 4;
constexpr size_t steps = 16;
struct Batch {
    std::array<std::array<double, lanes * steps>, 9> corners; // x, y, z of the first, the second, the third
    // Per step and lane. Beyond the end of the triangles follow points, which add zero to each sum.
    void gather(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles) {
        const glm::dvec3& filler = positions[triangles[0].x];
        for (size_t lane = 0; lane < lanes; ++lane) {
            for (size_t step = 0; step < steps; ++step) {
                const size_t t = lane * block_size + step, j = step * lanes + lane;
                const bool there = t < triangles.size();
                for (int k = 0; k < 3; ++k) {
                    const glm::dvec3& p = there ? positions[triangles[t][k]] : filler;
                    for (int m = 0; m < 3; ++m) corners[static_cast<size_t>(3 * k + m)][j] = p[m];
                }
            }
        }
    }
    [[nodiscard]] glm::dvec3 corner(size_t k, size_t j) const {
        return {corners[3 * k][j], corners[3 * k + 1][j], corners[3 * k + 2][j]};
    }
};

// Sums the terms of all triangles, those of `lanes` blocks at a time. term() receives the corners relative to `origin`
// and the normal. Inlined into functions that are compiled for several processors (simd.h).
template<size_t N, class Term>
[[gnu::always_inline]] inline CompensatedSum<N> integrate(std::span<const glm::dvec3> positions,
                                                          std::span<const Triangle> triangles, const glm::dvec3& origin,
                                                          const Term& term) {
    CompensatedSum<N> total;
    Batch batch;
    std::array<std::array<double, lanes * steps>, N> terms;
    for (size_t begin = 0; begin < triangles.size(); begin += lanes * block_size) {
        std::array<std::array<double, lanes>, N> sums{};
        const size_t end = std::min(triangles.size(), begin + block_size);
        for (size_t first = begin; first < end; first += steps) {
            batch.gather(positions, triangles.subspan(first, std::min(triangles.size() - first, lanes * block_size)));
            for (size_t j = 0; j < lanes * steps; ++j) {
                const glm::dvec3 a = batch.corner(0, j), b = batch.corner(1, j), c = batch.corner(2, j);
                const std::array<double, N> of_triangle =
                    term(a - origin, b - origin, c - origin, area_vector(a, b, c));
                for (size_t k = 0; k < N; ++k) terms[k][j] = of_triangle[k];
            }
            for (size_t k = 0; k < N; ++k)
                for (size_t j = 0; j < lanes * steps; j += lanes)
                    for (size_t lane = 0; lane < lanes; ++lane) sums[k][lane] += terms[k][j + lane];
        }
        for (size_t lane = 0; lane < lanes && begin + lane * block_size < triangles.size(); ++lane) {
            std::array<double, N> block;
            for (size_t k = 0; k < N; ++k) block[k] = sums[k][lane];
            total.add(block);
        }
    }
    return total;
}

} // namespace

double signed_volume(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles) {
    const glm::dvec3 origin = origin_of(box_of_corners(positions, triangles));
    const auto sums = integrate<1>(positions, triangles, origin,
                                   [](const glm::dvec3& a, const glm::dvec3&, const glm::dvec3&,
                                      const glm::dvec3& normal) { return std::array<double, 1>{dot(a, normal)}; });
    return sums[0] / 6.0;
}

double volume_error_bound(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles) {
    // With u = 2^-53, the two edges of a normal carry 1u each and their cross product 6u of the product of their
    // lengths; the corner carries 1u and the dot product 3u; a block adds up to 63 terms. 1u more covers this sum.
    constexpr double u = 0x1.0p-53;
    const glm::dvec3 origin = origin_of(box_of_corners(positions, triangles));
    double sum = 0.0;
    for (const Triangle& t : triangles) {
        const auto edges = shorter_edges(positions[t.x], positions[t.y], positions[t.z]);
        const double normal = length(cross(edges[0], edges[1]));
        sum += length(positions[t.x] - origin) * (13.0 * length(edges[0]) * length(edges[1]) + block_size * normal);
    }
    return u * sum / 6.0;
}

namespace {

// With d = 6 x the signed volume of the tetrahedron (origin, a, b, c) and s = a + b + c, the integrals over it are
// 1: d/6,  x: d/24 s,  x x^T: d/120 (a a^T + b b^T + c c^T + s s^T). The normal comes from edges instead of b x c,
// so its rounding error shrinks with the triangle.
enum { six_volume, two_area, mx, my, mz, cxx, cyy, czz, cxy, cyz, czx, moments };

BRITTLE_SIMD CompensatedSum<moments> moments_of(std::span<const glm::dvec3> positions,
                                                std::span<const Triangle> triangles, const glm::dvec3& origin) {
    return integrate<moments>(
        positions, triangles, origin,
        [](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& normal) {
            const double d = dot(a, normal);
            const glm::dvec3 s = a + b + c;
            const auto product = [&](int i, int j) {
                return d * (a[i] * a[j] + b[i] * b[j] + c[i] * c[j] + s[i] * s[j]);
            };
            std::array<double, moments> terms;
            terms[six_volume] = d;
            terms[two_area] = length(normal);
            terms[mx] = d * s.x;
            terms[my] = d * s.y;
            terms[mz] = d * s.z;
            terms[cxx] = product(0, 0);
            terms[cyy] = product(1, 1);
            terms[czz] = product(2, 2);
            terms[cxy] = product(0, 1);
            terms[cyz] = product(1, 2);
            terms[czx] = product(2, 0);
            return terms;
        });
}

// Second moments about the centre of mass, as an inertia tensor.
glm::dmat3 inertia_of(double xx, double yy, double zz, double xy, double yz, double zx) {
    return glm::dmat3(yy + zz, -xy, -zx, -xy, zz + xx, -yz, -zx, -yz, xx + yy);
}

} // namespace

MassProperties mass_properties(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles) {
    return mass_properties(positions, triangles, box_of_corners(positions, triangles));
}

MassProperties mass_properties(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles,
                               const Box& box) {
    assert(box.min == box_of_corners(positions, triangles).min && box.max == box_of_corners(positions, triangles).max);
    MassProperties mass;
    if (triangles.empty()) return mass;
    const glm::dvec3 origin = origin_of(box);
    const auto sums = moments_of(positions, triangles, origin);
    mass.volume = sums[six_volume] / 6.0;
    mass.area = sums[two_area] / 2.0;
    const double radius = 0.5 * glm::length(box.size());
    if (std::abs(mass.volume) <= volume_noise * mass.area * radius) {
        mass.centre_of_mass = mean_of_corners(positions, triangles, origin);
        return mass;
    }

    const glm::dvec3 offset = glm::dvec3(sums[mx], sums[my], sums[mz]) / (24.0 * mass.volume);
    mass.centre_of_mass = origin + offset;
    // Parallel axis theorem: from the origin of the integrals to the centre of mass.
    const auto second = [&](int k, int i, int j) {
        return sums[static_cast<size_t>(k)] / 120.0 - mass.volume * offset[i] * offset[j];
    };
    mass.inertia = inertia_of(second(cxx, 0, 0), second(cyy, 1, 1), second(czz, 2, 2), second(cxy, 0, 1),
                              second(cyz, 1, 2), second(czx, 2, 0));
    return mass;
}

MassProperties exchange_triangles(const MassProperties& before, std::span<const glm::dvec3> removed_positions,
                                  std::span<const Triangle> removed, std::span<const glm::dvec3> added_positions,
                                  std::span<const Triangle> added) {
    const glm::dvec3& origin = before.centre_of_mass;
    const auto gone = moments_of(removed_positions, removed, origin), come = moments_of(added_positions, added, origin);
    const auto change = [&](size_t k) { return come[k] - gone[k]; };
    MassProperties after;
    after.volume = before.volume + change(six_volume) / 6.0;
    after.area = before.area + change(two_area) / 2.0;
    const glm::dvec3 offset = glm::dvec3(change(mx), change(my), change(mz)) / (24.0 * after.volume);
    after.centre_of_mass = origin + offset;
    const glm::dmat3& inertia = before.inertia;
    const double half_trace = 0.5 * (inertia[0][0] + inertia[1][1] + inertia[2][2]);
    const auto second = [&](size_t k, int i, int j) {
        const double old = i == j ? half_trace - inertia[i][i] : -inertia[i][j];
        return old + change(k) / 120.0 - after.volume * offset[i] * offset[j];
    };
    after.inertia = inertia_of(second(cxx, 0, 0), second(cyy, 1, 1), second(czz, 2, 2), second(cxy, 0, 1),
                               second(cyz, 1, 2), second(czx, 2, 0));
    return after;
}

} // namespace brittle::fracture

// The geometric predicates of the exact fracture: signs that are never wrong and, where the geometry needs a side,
// never zero.
//
// Setting. Site i has the perturbed distance P_i(x) = |x - s_i|^2 - W_i - w_i. W_i is its weight (zero except in power
// diagrams), and the w_i are infinitesimal symbolic weights w_0 >> w_1 >> w_2 >> ... > 0 (simulation of simplicity,
// Edelsbrunner and Muecke 1990; Levy 2014 for restricted diagrams). The cell of c is the region where P_c is smallest.
// Seen from c,
//
//     g_l(x) = P_l(x) - P_c(x) = |x - s_l|^2 - |x - s_c|^2 + (W_c - W_l) + (w_c - w_l)
//
// is positive on c's side of the bisector (c,l). Mesh and box are not perturbed. All answers are the true signs for all
// sufficiently small w_i, so they never contradict each other: a question about the same bisectors, posed from another
// site or with the edge or triangle in another order, has the same answer. Of equal sites the one of greatest weight
// owns the cell, then the one of lowest index: every point is on its side.
//
// Evaluation, in three stages. (1) A filter in double with a proven forward error bound. It is inline, works on values
// that the caller keeps in its own arrays, and returns 0 for an uncertain sign. (2) The exact sign, by floating-point
// expansions of the original coordinates. (3) Where that is zero, the sign of the first nonzero coefficient of w_0,
// w_1, ... Every determinant below is linear in the weights, because all perturbed rows move along one common vector,
// so the series has one level. It does not vanish: the coefficient of w_l is the denominator of the vertex itself.
//
//     once a cell:     const Bisector l = make_bisector(s_c, s_l);
//                      const double E = value_error(longest_n, reach);
//     per vertex:      const double g = value(l, q - s_c);
//                      int side = side1_filter(g, E);
//                      if (side == 0) side = side1_exact(diagram, c, l_id, q, stats);
//
// Where speed does not matter, side1(diagram, c, l_id, q, stats) does both.
//
// Input range. Every coordinate (sites, mesh, box) is finite, at most max_coordinate in magnitude, and an integer
// multiple of coordinate_granularity. Then no polynomial here (degree <= 7) overflows or underflows, and all answers
// hold without exception. To meet this, scale by a power of two so that the box is about [-1,1], and pass each
// coordinate through snap(), which changes only coordinates below 2^-98 (3e-30 of the box). The same holds for weights;
// a weight counts as two coordinates, so its magnitude may reach max_coordinate squared.
//
// Threads: all functions are pure, apart from the PredicateStats that the caller passes; give each thread its own.
// Compile without floating-point contraction and without fast-math.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture::exact {

inline constexpr double max_coordinate = 0x1.0p+100;
inline constexpr double coordinate_granularity = 0x1.0p-150;

// The nearest multiple of coordinate_granularity. The identity for |x| >= 2^-98.
[[nodiscard]] inline double snap(double x) {
    constexpr double magic = 0x1.8p-98; // its unit in the last place is coordinate_granularity
    return std::abs(x) < 0x1.0p-98 ? (x + magic) - magic : x;
}

[[nodiscard]] inline glm::dvec3 snap(const glm::dvec3& p) {
    return {snap(p.x), snap(p.y), snap(p.z)};
}

using SiteId = uint32_t;

// A plane of a cell: the index of a site (its bisector), or one of six values for the sides of the box.
using PlaneId = uint32_t;
inline constexpr PlaneId box_min_x = 0xfffffffau, box_max_x = 0xfffffffbu, box_min_y = 0xfffffffcu,
                         box_max_y = 0xfffffffdu, box_min_z = 0xfffffffeu, box_max_z = 0xffffffffu;
[[nodiscard]] constexpr bool is_box_plane(PlaneId p) {
    return p >= box_min_x;
}

// The sites, the box and the weights of a diagram. Sites may lie outside the box.
struct Diagram {
    std::span<const glm::dvec3> sites;
    Box box;
    std::span<const double> weights{}; // squared lengths, one per site; empty: all zero
};

using Corners = std::array<glm::dvec3, 3>; // of a mesh triangle, in scene coordinates

// Counts of the calls that the filters did not decide. One per thread; sum them afterwards.
struct PredicateStats {
    uint64_t side1_exact = 0;
    uint64_t side2_exact = 0;
    uint64_t side3_exact = 0;
    uint64_t side4_exact = 0;
    uint64_t pierce_exact = 0;      // pierce_order, pierce_direction
    uint64_t orientation_exact = 0; // cell_vertex_orientation
    uint64_t perturbed = 0;         // exact zeros, decided by the symbolic weights

    PredicateStats& operator+=(const PredicateStats& other);
    [[nodiscard]] uint64_t exact_calls() const {
        return side1_exact + side2_exact + side3_exact + side4_exact + pierce_exact + orientation_exact;
    }
};

// ---------------------------------------------------------------------------------------------------------------
// Filters. Notation of the bounds: u = 2^-53 (unit roundoff); a rounded operation is exact times (1 + d), |d| <= u. All
// values are in the frame of one site c: n = fl(s_l - s_c), y = fl(q - s_c). The bounds hold for any order of
// summation, so the loops may be vectorised.
// ---------------------------------------------------------------------------------------------------------------

// A plane in the frame of a site, with value(y) = h - n.y. For a bisector this is half of g: n = s_l - s_c,
// h = (|n|^2 + W_c - W_l) / 2. For a side of the box it is the distance inwards: n is the outward axis.
struct Bisector {
    glm::dvec3 n;
    double h;
    double length;       // |n|
    double weight = 0.0; // |W_c - W_l|

    // A bound on the terms that h is the rounded sum of: |n|^2 / 2 + weight / 2 for a bisector.
    [[nodiscard]] double magnitude() const { return std::abs(h) + weight; }
};

[[nodiscard]] inline Bisector make_bisector(const glm::dvec3& s_c, const glm::dvec3& s_l) {
    const glm::dvec3 n = s_l - s_c;
    const double squared = n.x * n.x + n.y * n.y + n.z * n.z;
    return {n, 0.5 * squared, std::sqrt(squared)};
}

[[nodiscard]] inline Bisector make_bisector(const Diagram& diagram, SiteId c, SiteId l) {
    Bisector plane = make_bisector(diagram.sites[c], diagram.sites[l]);
    if (diagram.weights.empty()) return plane;
    const double difference = diagram.weights[c] - diagram.weights[l];
    plane.h += 0.5 * difference;
    plane.weight = std::abs(difference);
    return plane;
}

[[nodiscard]] inline Bisector make_box_plane(const glm::dvec3& s_c, const Box& box, PlaneId p) {
    const int axis = static_cast<int>((p - box_min_x) / 2);
    const bool max = ((p - box_min_x) & 1u) != 0;
    Bisector plane{glm::dvec3(0.0), max ? box.max[axis] - s_c[axis] : s_c[axis] - box.min[axis], 1.0};
    plane.n[axis] = max ? 1.0 : -1.0;
    return plane;
}

// A plane of the cell of c: a bisector or a side of the box.
[[nodiscard]] inline Bisector make_plane(const Diagram& diagram, SiteId c, PlaneId p) {
    return is_box_plane(p) ? make_box_plane(diagram.sites[c], diagram.box, p) : make_bisector(diagram, c, p);
}

[[nodiscard]] inline double value(const Bisector& l, const glm::dvec3& y) {
    return l.h - (l.n.x * y.x + l.n.y * y.y + l.n.z * y.z);
}

// E, a bound on |value - exact value| for all bisectors with |n| <= longest, weights that differ by at most `weight`,
// and points with |y| <= reach. (Sides of the box are excluded: the mesh lies strictly inside the box and is never
// compared with them.) Each term of n.y carries the roundings of n, y, the product and two sums: 5u. Each term of h
// carries 5u as well, or 6u with a weight; the difference adds 1u. Together 7u (|n|^2 / 2 + weight / 2 + |n||y|); 8u
// leaves room for the rounding of longest, reach and of this line.
[[nodiscard]] inline double value_error(double longest, double reach, double weight = 0.0) {
    return 0x8.0p-53 * longest * (0.5 * longest + reach) + 0x4.0p-53 * weight;
}

// All filters return +1 or -1 where the sign is certain, and 0 where the exact function of the same name must decide.

// sign g_l(q), q a mesh vertex. g = value(l, q - s_c).
[[nodiscard]] inline int side1_filter(double g, double error) {
    return g > error ? 1 : (g < -error ? -1 : 0);
}

// sign g_l(x), where x, the point of edge q0q1 on the bisector (c,a), gives g_l(x) = (a0*l1 - a1*l0) / (a0 - a1).
//
// a0, a1: values of a at q0, q1; l0, l1: values of l; error: their common bound E. |numerator error| <=
// E(|a0|+|a1|+|l0|+|l1|) + 2E^2 + 3u(|a0 l1| + |a1 l0|); |denominator error| <= 2E + u|a0 - a1|.
[[nodiscard]] inline int side2_filter(double a0, double a1, double l0, double l1, double error) {
    const double p = a0 * l1;
    const double q = a1 * l0;
    const double numerator = p - q;
    const double denominator = a0 - a1;
    const double bound = 1.01 * error * (std::abs(a0) + std::abs(a1) + std::abs(l0) + std::abs(l1) + 2.0 * error)
                         + 0x5.0p-53 * (std::abs(p) + std::abs(q));
    if (!(std::abs(numerator) > bound && std::abs(denominator) > 2.1 * error)) return 0;
    return (numerator > 0.0) == (denominator > 0.0) ? 1 : -1;
}

[[nodiscard]] inline double largest_component(const glm::dvec3& v) {
    return std::max(std::max(std::abs(v.x), std::abs(v.y)), std::abs(v.z));
}

// sign g_l(x), where x, the point of the triangle on the bisectors (c,a) and (c,b), gives g_l(x) = det[A;B;L] /
// det[A;B;1].
//
// A, B, L: values of a, b, l at the three corners; error: their common bound E. With m_A = max|A_i| etc. and six
// products in a determinant: |numerator error| <= 6E(m_A m_B + m_A m_L + m_B m_L) + 6E^2(m_A + m_B + m_L) + 6E^3 + 31u
// m_A m_B m_L, |denominator error| <= 6E(m_A + m_B) + 6E^2 + 25u m_A m_B.
[[nodiscard]] inline int side3_filter(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& l, double error) {
    const double ma = largest_component(a);
    const double mb = largest_component(b);
    const double ml = largest_component(l);
    const double m0 = a.y * b.z - a.z * b.y;
    const double m1 = a.z * b.x - a.x * b.z;
    const double m2 = a.x * b.y - a.y * b.x;
    const double numerator = l.x * m0 + l.y * m1 + l.z * m2;
    const double denominator = m0 + m1 + m2;
    const double mab = ma * mb;
    const double numerator_bound =
        6.06 * error * (mab + ml * (ma + mb) + error * (ma + mb + ml + error)) + 0x24.0p-53 * mab * ml;
    const double denominator_bound = 6.06 * error * (ma + mb + error) + 0x1c.0p-53 * mab;
    if (!(std::abs(numerator) > numerator_bound && std::abs(denominator) > denominator_bound)) return 0;
    return (numerator > 0.0) == (denominator > 0.0) ? 1 : -1;
}

// The point where three planes of a cell meet, homogeneous: y = x / w with w > 0, in the frame of the site.
struct CellVertex {
    glm::dvec3 x;
    double w;
    double pw; // |n_a||n_b||n_d|; infinite where the sign of w is uncertain, so that every filter is uncertain too
    double px; // sum of magnitude |n||n|; infinite in that case too
};
// The planes may have any order. |w error| <= 8 sqrt(2) u pw: 1u for each n, 5u for products and sums.
[[nodiscard]] inline CellVertex make_cell_vertex(const Bisector& a, const Bisector& b, const Bisector& d) {
    const glm::dvec3 bd = glm::cross(b.n, d.n);
    CellVertex v;
    v.x = a.h * bd + b.h * glm::cross(d.n, a.n) + d.h * glm::cross(a.n, b.n);
    v.w = a.n.x * bd.x + a.n.y * bd.y + a.n.z * bd.z;
    v.pw = a.length * b.length * d.length;
    v.px =
        a.magnitude() * b.length * d.length + b.magnitude() * d.length * a.length + d.magnitude() * a.length * b.length;
    if (!(std::abs(v.w) > 0xc.0p-53 * v.pw)) {
        v.pw = v.px = std::numeric_limits<double>::infinity();
    } else if (v.w < 0.0) {
        v.w = -v.w;
        v.x = -v.x;
    }
    return v;
}

// sign g_l(v), with g_l(v) = (h_l w - n_l.x) / w. The permanent of three rows is at most 2/sqrt(3) times the product of
// their lengths (Carlen, Lieb and Loss 2006); this bound uses sqrt(2), by Cauchy-Schwarz. By counting roundings, h_l w
// carries 15u and n_l.x carries 17u, each 1u more with weights, where |h| is the magnitude of the plane: error <= 18
// sqrt(2) u (|h_l| pw + |n_l| px) < 26u(...).
[[nodiscard]] inline int side4_filter(const CellVertex& v, const Bisector& l) {
    const double g = l.h * v.w - (l.n.x * v.x.x + l.n.y * v.x.y + l.n.z * v.x.z);
    const double bound = 0x20.0p-53 * (l.magnitude() * v.pw + l.length * v.px);
    return g > bound ? 1 : (g < -bound ? -1 : 0);
}

// The point where the plane of a triangle meets the line of the bisectors (c,a) and (c,b): t = y.d with d = n_a x n_b,
// and a bound on its error (infinite where the triangle is nearly parallel to the line). Computed once per pierce
// point, compared often.
struct PiercePosition {
    double t;
    double error;
};
// a_values, b_values: values of a and b at the corners; error: their common bound; y: the corners in the frame of c.
[[nodiscard]] PiercePosition pierce_position(const Bisector& a, const Bisector& b, const Corners& y,
                                             const glm::dvec3& a_values, const glm::dvec3& b_values, double error);

// sign(t1 - t2): -1 where p1 comes first along d.
[[nodiscard]] inline int pierce_order_filter(const PiercePosition& p1, const PiercePosition& p2) {
    const double difference = p1.t - p2.t;
    const double bound = 1.0001 * (p1.error + p2.error);
    return difference > bound ? 1 : (difference < -bound ? -1 : 0);
}

// ---------------------------------------------------------------------------------------------------------------
// Exact signs. c, a, b, l are different sites; the planes a, b, d of a cell vertex may be sides of the box. "Perturbed"
// means: never 0, provided that the queried point exists in the perturbed diagram, which the caller's combinatorics
// guarantee. A violation asserts.
// ---------------------------------------------------------------------------------------------------------------

// sign g_l(q), perturbed. Formula: (s_l - s_c).(s_l + s_c - 2q) + W_c - W_l. Zero case: + if c < l, - otherwise.
[[nodiscard]] int side1_exact(const Diagram& diagram, SiteId c, SiteId l, const glm::dvec3& q, PredicateStats& stats);

// sign g_l(x), perturbed; x is the point where edge q0q1, with its ends on different sides, meets the bisector (c,a).
// Formula: (a0 l1 - a1 l0) / (a0 - a1). Zero case, coefficients of the numerator: w_a: -(l1 - l0); w_l: -(a0 - a1);
// w_c: (l1 - l0) + (a0 - a1).
[[nodiscard]] int side2_exact(const Diagram& diagram, SiteId c, SiteId a, SiteId l, const glm::dvec3& q0,
                              const glm::dvec3& q1, PredicateStats& stats);

// sign g_l(x), perturbed; x is the point where the plane of triangle q meets the Voronoi line (c,a,b), to which it is
// not parallel. Formula: det[A;B;L] / det[A;B;1]. Zero case, coefficients of the numerator: w_a: -det[1;B;L]; w_b:
// -det[A;1;L]; w_l: -det[A;B;1]; w_c: the negated sum of these three.
[[nodiscard]] int side3_exact(const Diagram& diagram, SiteId c, SiteId a, SiteId b, SiteId l, const Corners& q,
                              PredicateStats& stats);

// sign g_l(v), perturbed; v is the point where planes a, b, d of the cell of c meet (in any order), [abd] != 0.
// Formula, with rows (2n, H = |n|^2 + W_c - W_l) for sites and (axis, distance) for the box, [xyz] = the determinant of
// the n: (H_l [abd] - H_d [abl] + H_b [adl] - H_a [bdl]) / [abd]. Zero case, coefficients of the numerator: w_l:
// -[abd]; w_d: [abl]; w_b: -[adl]; w_a: [bdl]; w_c: the negated sum over sites; sides of the box have none.
[[nodiscard]] int side4_exact(const Diagram& diagram, SiteId c, PlaneId a, PlaneId b, PlaneId d, SiteId l,
                              PredicateStats& stats);

// The order of the points of two triangles along the Voronoi line (c,a,b) in the direction d = (s_a - s_c) x (s_b -
// s_c): -1 where the point of q1 comes first, +1 where that of q2 does, perturbed. Neither triangle is parallel to the
// line. d is equal for (c,a,b), (a,b,c), (b,c,a) and opposite for the other three orders.
//
// 0 if and only if the triangles lie in one plane: their pierce points coincide for every position of the line, so no
// weights can order them. The caller chooses, best so that the winding number stays valid. Two triangles of an embedded
// mesh never tie, because a perturbed line meets at most one of two coplanar triangles that do not overlap.
//
// Formula: the vertex (a,b,T1) against the plane T2, as in side4 with rows (N, N.(q - s_c)), N = (q1-q0) x (q2-q0);
// times -sign([abT2]). The degree is 7; a comparison of two quotients would have 11.
[[nodiscard]] int pierce_order_exact(const Diagram& diagram, SiteId c, SiteId a, SiteId b, const Corners& q1,
                                     const Corners& q2, PredicateStats& stats);

// sign(N.d), N = (q1-q0) x (q2-q0), d = (s_a - s_c) x (s_b - s_c), = sign det[A;B;1]. +1: the Voronoi edge, along d,
// leaves the solid through this triangle. Not perturbed, rightly: weights move the line without turning it, so 0 (the
// triangle is parallel to the line or has no area) means that no perturbed line pierces the triangle.
[[nodiscard]] int pierce_direction_exact(const Diagram& diagram, SiteId c, SiteId a, SiteId b, const Corners& q,
                                         PredicateStats& stats);

// sign [abd], the handedness of the outward normals of three planes of the cell of c. Not perturbed: 0 means that the
// planes meet in no single point under any weights.
[[nodiscard]] int cell_vertex_orientation_exact(const Diagram& diagram, SiteId c, PlaneId a, PlaneId b, PlaneId d,
                                                PredicateStats& stats);

// ---------------------------------------------------------------------------------------------------------------
// Filter and exact function in one call, from ids and coordinates alone.
// ---------------------------------------------------------------------------------------------------------------

[[nodiscard]] int side1(const Diagram& diagram, SiteId c, SiteId l, const glm::dvec3& q, PredicateStats& stats);
[[nodiscard]] int side2(const Diagram& diagram, SiteId c, SiteId a, SiteId l, const glm::dvec3& q0,
                        const glm::dvec3& q1, PredicateStats& stats);
[[nodiscard]] int side3(const Diagram& diagram, SiteId c, SiteId a, SiteId b, SiteId l, const Corners& q,
                        PredicateStats& stats);
[[nodiscard]] int side4(const Diagram& diagram, SiteId c, PlaneId a, PlaneId b, PlaneId d, SiteId l,
                        PredicateStats& stats);
[[nodiscard]] int pierce_order(const Diagram& diagram, SiteId c, SiteId a, SiteId b, const Corners& q1,
                               const Corners& q2, PredicateStats& stats);

// ---------------------------------------------------------------------------------------------------------------
// Constructions: positions of ill-conditioned points. Numerators and denominators are exact, then rounded; each number
// is within a few u of the true, unperturbed one. Well-conditioned points are computed in double by the caller. Pass
// arguments in canonical order (smallest site as c, sorted vertices), because rounding is not symmetric.

// The parameter t in [0,1] of the point q0 + t (q1 - q0) on the bisector (c,a); needs a0 != a1.
[[nodiscard]] double edge_parameter_exact(const Diagram& diagram, SiteId c, SiteId a, const glm::dvec3& q0,
                                          const glm::dvec3& q1);
// The barycentric weights of the pierce point of the Voronoi line (c,a,b), clamped to [0,1]; they sum to 1 up to
// rounding.
[[nodiscard]] glm::dvec3 pierce_weights_exact(const Diagram& diagram, SiteId c, SiteId a, SiteId b, const Corners& q);
// The Voronoi vertex in the frame of c: add s_c for the absolute position.
[[nodiscard]] glm::dvec3 cell_vertex_exact(const Diagram& diagram, SiteId c, PlaneId a, PlaneId b, PlaneId d);

} // namespace brittle::fracture::exact

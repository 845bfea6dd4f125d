// The two predicates of planar triangulation: orientation and in-circle.
//
// Formulas and filters after Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
// Predicates" (1997). Preconditions: contraction of a * b + c is off (-ffp-contract=off), coordinates are finite, and
// their products neither overflow nor underflow (|x| between 1e-140 and 1e150, or zero). Outside that range signs may
// be wrong.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include <glm/vec2.hpp>

namespace brittle::fracture {

namespace detail {

// Returns the exact orientation as the sum of its six products, each an exact pair of doubles. Only near-collinear
// points take this path.
inline double exact_orientation(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    std::array<double, 12> expansion{}; // non-overlapping, ascending; the last term has the sign of the sum
    size_t size = 0;
    const auto add = [&](double term) {
        size_t kept = 0;
        for (size_t i = 0; i < size; ++i) { // Shewchuk's GROW-EXPANSION with zero elimination
            const double e = expansion[i];
            const double sum = term + e;
            const double virtual_e = sum - term;
            const double error = (term - (sum - virtual_e)) + (e - virtual_e);
            if (error != 0.0) expansion[kept++] = error;
            term = sum;
        }
        if (term != 0.0) expansion[kept++] = term;
        size = kept;
    };
    const auto add_product = [&](double x, double y) {
        const double product = x * y;
        add(std::fma(x, y, -product));
        add(product);
    };
    add_product(a.x, b.y);
    add_product(-a.y, b.x);
    add_product(b.x, c.y);
    add_product(-b.y, c.x);
    add_product(c.x, a.y);
    add_product(-c.y, a.x);
    return size == 0 ? 0.0 : expansion[size - 1];
}

} // namespace detail

// Returns twice the signed area of the triangle, (a - c) x (b - c): positive if a, b, c are counter-clockwise. The sign
// is exact and zero means exactly collinear; the magnitude is approximate.
inline double orientation(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    const double left = (a.x - c.x) * (b.y - c.y);
    const double right = (a.y - c.y) * (b.x - c.x);
    const double determinant = left - right;
    constexpr double u = 0x1.0p-53;
    constexpr double bound = (3.0 + 16.0 * u) * u;
    if (std::abs(determinant) > bound * (std::abs(left) + std::abs(right))) return determinant;
    return detail::exact_orientation(a, b, c);
}

// Returns true if d certainly lies inside the circle through the counter-clockwise triangle a, b, c. Filtered only: a
// doubtful sign gives false, which keeps a sequence of edge flips from cycling.
inline bool certainly_in_circle(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& d) {
    const glm::dvec2 p = a - d, q = b - d, r = c - d;
    const double pq = p.x * q.y, qp = q.x * p.y;
    const double qr = q.x * r.y, rq = r.x * q.y;
    const double rp = r.x * p.y, pr = p.x * r.y;
    const double pp = p.x * p.x + p.y * p.y;
    const double qq = q.x * q.x + q.y * q.y;
    const double rr = r.x * r.x + r.y * r.y;
    const double determinant = pp * (qr - rq) + qq * (rp - pr) + rr * (pq - qp);
    const double permanent =
        (std::abs(qr) + std::abs(rq)) * pp + (std::abs(rp) + std::abs(pr)) * qq + (std::abs(pq) + std::abs(qp)) * rr;
    constexpr double u = 0x1.0p-53;
    constexpr double bound = (10.0 + 96.0 * u) * u;
    return determinant > bound * permanent;
}

} // namespace brittle::fracture

#include "fracture/unite/points.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <glm/geometric.hpp>

#include "fracture/arithmetic/plane_predicates.h"
#include "fracture/mesh/intersections.h"

namespace brittle::fracture::arrangement {
namespace {

using exact::Dyadic;

constexpr double unit_roundoff = 0x1.0p-53;

std::array<Dyadic, 3> difference(const glm::dvec3& a, const glm::dvec3& b) {
    return {Dyadic(a.x) - Dyadic(b.x), Dyadic(a.y) - Dyadic(b.y), Dyadic(a.z) - Dyadic(b.z)};
}

std::array<Dyadic, 3> cross(const std::array<Dyadic, 3>& a, const std::array<Dyadic, 3>& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Dyadic dot(const std::array<Dyadic, 3>& a, const std::array<Dyadic, 3>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Dyadic dot(const std::array<Dyadic, 3>& a, const glm::dvec3& b) {
    return a[0] * Dyadic(b.x) + a[1] * Dyadic(b.y) + a[2] * Dyadic(b.z);
}

ExactPoint with_positive_w(ExactPoint p) {
    if (p.w.sign() >= 0) return p;
    return {-p.x, -p.y, -p.z, -p.w};
}

glm::dvec2 flat(const glm::dvec3& p, int axis) {
    return {p[(axis + 1) % 3], p[(axis + 2) % 3]};
}

int sign(double x) {
    return x > 0.0 ? 1 : (x < 0.0 ? -1 : 0);
}

uint64_t mix(uint64_t x) {
    x ^= x >> 32;
    x *= 0x9e3779b97f4a7c15u;
    return x ^ (x >> 29);
}

uint64_t hash(const glm::dvec3& p) {
    uint64_t h = 0;
    for (int k = 0; k < 3; ++k) h = mix(h ^ std::bit_cast<uint64_t>(p[k] + 0.0)); // -0 and 0 are equal
    return h;
}

} // namespace

ExactPoint exact_point(const glm::dvec3& p) {
    return {Dyadic(p.x), Dyadic(p.y), Dyadic(p.z), Dyadic(1.0)};
}

ExactPlane plane_of(const Corners& triangle) {
    ExactPlane plane;
    plane.normal = cross(difference(triangle[1], triangle[0]), difference(triangle[2], triangle[0]));
    plane.offset = dot(plane.normal, triangle[0]);
    return plane;
}

ExactPlane plane_along(const glm::dvec3& p, const glm::dvec3& q, int axis) {
    ExactPlane plane;
    std::array<Dyadic, 3> unit;
    unit[static_cast<size_t>(axis)] = Dyadic(1.0);
    plane.normal = cross(difference(q, p), unit);
    plane.offset = dot(plane.normal, p);
    return plane;
}

ExactPoint on_line(const glm::dvec3& p, const glm::dvec3& q, const ExactPlane& plane) {
    const Dyadic at_p = dot(plane.normal, p) - plane.offset, at_q = dot(plane.normal, q) - plane.offset;
    const auto between = [&](int k) { return at_p * Dyadic(q[k]) - at_q * Dyadic(p[k]); };
    return with_positive_w({between(0), between(1), between(2), at_p - at_q});
}

ExactPoint common_point(const ExactPlane& a, const ExactPlane& b, const ExactPlane& c) {
    const auto bc = cross(b.normal, c.normal), ca = cross(c.normal, a.normal), ab = cross(a.normal, b.normal);
    const auto along = [&](size_t k) { return a.offset * bc[k] + b.offset * ca[k] + c.offset * ab[k]; };
    return with_positive_w({along(0), along(1), along(2), dot(a.normal, bc)});
}

Points::Points(std::span<const glm::dvec3> vertices)
    : vertices_(vertices.size()), positions_(vertices.begin(), vertices.end()) {
    first_.resize(vertices_);
    next_same_.assign(vertices_, no_index);
    table_.assign(std::bit_ceil(2 * vertices_ + 16), no_index);
    for (uint32_t v = 0; v < vertices_; ++v) {
        uint32_t& entry = table_[slot_of(positions_[v])];
        if (entry == no_index) {
            entry = v;
            ++used_;
        }
        first_[v] = entry;
    }
}

size_t Points::slot_of(const glm::dvec3& position) const {
    size_t slot = hash(position) & (table_.size() - 1);
    while (table_[slot] != no_index && positions_[table_[slot]] != position) slot = (slot + 1) & (table_.size() - 1);
    return slot;
}

void Points::grow() {
    std::vector<uint32_t> old = std::move(table_);
    table_.assign(2 * old.size(), no_index);
    for (const uint32_t point : old)
        if (point != no_index) table_[slot_of(positions_[point])] = point;
}

ExactPoint Points::exact(uint32_t point) const {
    return is_vertex(point) ? exact_point(positions_[point]) : exact_[point - vertices_];
}

uint32_t Points::add(const ExactPoint& p) {
    const glm::dvec3 position(p.x.over(p.w) + 0.0, p.y.over(p.w) + 0.0, p.z.over(p.w) + 0.0);
    if (2 * used_ >= table_.size()) grow();
    const size_t slot = slot_of(position);
    const auto point = static_cast<uint32_t>(positions_.size());
    uint32_t last = no_index;
    for (uint32_t other = table_[slot]; other != no_index; other = next_same_[other]) {
        const ExactPoint q = exact(other);
        const auto equal = [&](int k) { return (p[k] * q.w - q[k] * p.w).sign() == 0; };
        if (equal(0) && equal(1) && equal(2)) return other;
        last = other;
    }
    if (last == no_index) {
        table_[slot] = point;
        ++used_;
    } else {
        next_same_[last] = point;
    }
    first_.push_back(table_[slot]);
    next_same_.push_back(no_index);
    positions_.push_back(position);
    exact_.push_back(p);
    return point;
}

int Points::compare(uint32_t a, uint32_t b, int axis) const {
    // Rounding is monotonic, so positions that differ have the order of the points.
    const double p = positions_[a][axis], q = positions_[b][axis];
    if (p != q) return p < q ? -1 : 1;
    if (a == b || (is_vertex(a) && is_vertex(b))) return 0;
    const ExactPoint x = exact(a), y = exact(b);
    return (x[axis] * y.w - y[axis] * x.w).sign();
}

int Points::axis_between(uint32_t a, uint32_t b) const {
    const glm::dvec3 size = glm::abs(positions_[b] - positions_[a]);
    int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
    for (int k = 0; k < 2 && compare(a, b, axis) == 0; ++k) axis = (axis + 1) % 3; // rounded to one position
    return axis;
}

int Points::turn(uint32_t a, uint32_t b, uint32_t c, int axis) const {
    if (a == b || b == c || c == a) return 0;
    const glm::dvec2 p = flat(positions_[a], axis), q = flat(positions_[b], axis), r = flat(positions_[c], axis);
    if (is_vertex(a) && is_vertex(b) && is_vertex(c)) return sign(orientation(p, q, r));
    const glm::dvec2 u = p - r, v = q - r;
    const double determinant = u.x * v.y - u.y * v.x;
    // Each coordinate is off by unit_roundoff times its size, each difference by three times as much of the largest
    // coordinate; the determinant by four such errors times the largest difference, and by its own rounding.
    const double size =
        std::max({std::abs(p.x), std::abs(p.y), std::abs(q.x), std::abs(q.y), std::abs(r.x), std::abs(r.y)});
    const double extent = std::max({std::abs(u.x), std::abs(u.y), std::abs(v.x), std::abs(v.y)});
    if (std::abs(determinant) > 32.0 * unit_roundoff * size * extent) return sign(determinant);
    const ExactPoint x = exact(a), y = exact(b), z = exact(c);
    const int i = (axis + 1) % 3, j = (axis + 2) % 3;
    return (x.w * (y[i] * z[j] - y[j] * z[i]) + y.w * (z[i] * x[j] - z[j] * x[i]) + z.w * (x[i] * y[j] - x[j] * y[i]))
        .sign();
}

int side_of(const Corners& triangle, const glm::dvec3& p) {
    return -orientation(triangle[0], triangle[1], triangle[2], p);
}

int Points::side(const Corners& t, uint32_t point) const {
    const glm::dvec3& p = positions_[point];
    if (is_vertex(point)) return side_of(t, p);
    const glm::dvec3 u = t[1] - t[0], v = t[2] - t[0], w = p - t[0];
    const auto product = [&](int i, int j) { return u[i] * v[j] - u[j] * v[i]; };
    const auto magnitude = [&](int i, int j) { return std::abs(u[i] * v[j]) + std::abs(u[j] * v[i]); };
    const double height = product(1, 2) * w.x + product(2, 0) * w.y + product(0, 1) * w.z;
    // The bound of orientation(), and the rounding of the point's position.
    const auto error = [&](int i, int j, int k) {
        return magnitude(i, j) * (16.0 * std::abs(w[k]) + 2.0 * std::abs(p[k]));
    };
    if (std::abs(height) > unit_roundoff * (error(1, 2, 0) + error(2, 0, 1) + error(0, 1, 2))) return sign(height);
    const ExactPlane plane = plane_of(t);
    const ExactPoint q = exact(point);
    return (plane.normal[0] * q.x + plane.normal[1] * q.y + plane.normal[2] * q.z - plane.offset * q.w).sign();
}

int open_axis(const Corners& t) {
    const glm::dvec3 normal = glm::abs(glm::cross(t[1] - t[0], t[2] - t[0]));
    std::array<int, 3> axes{0, 1, 2};
    std::sort(axes.begin(), axes.end(),
              [&](int a, int b) { return normal[a] != normal[b] ? normal[a] > normal[b] : a < b; });
    for (const int axis : axes)
        if (orientation(flat(t[0], axis), flat(t[1], axis), flat(t[2], axis)) != 0.0) return axis;
    return -1;
}

} // namespace brittle::fracture::arrangement

#include "physics/cutting/polytope.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::physics {

namespace {

// Corners that are nearer to each other than this share of the polytope's size are one.
constexpr double same_corner = 1e-9;

// Grows with the angle of a vector, from 0 to 4 (Moret and Shapiro's substitute for the arc tangent).
double turn(double x, double y) {
    const double sum = std::abs(x) + std::abs(y);
    if (!(sum > 0.0)) return 0.0;
    const double part = y / sum;
    return x < 0.0 ? 2.0 - part : y < 0.0 ? 4.0 + part : part;
}

} // namespace

Polytope Polytope::of(const fracture::Box& box) {
    Polytope polytope;
    const auto corner = [&](int k) {
        return glm::dvec3(k & 1 ? box.max.x : box.min.x, k & 2 ? box.max.y : box.min.y, k & 4 ? box.max.z : box.min.z);
    };
    constexpr std::array<std::array<int, 4>, 6> sides{
        {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
    for (const auto& [a, b, c, d] : sides)
        polytope.add_face(std::array{corner(a), corner(b), corner(c), corner(d)}, 0.0);
    return polytope;
}

Polytope Polytope::around(const CollisionHull& hull, double beyond, const glm::dvec3& offset) {
    Polytope polytope;
    if (hull.points.empty()) return polytope;
    glm::dvec3 low(hull.points[0]), high(low);
    for (const glm::vec3& p : hull.points) {
        low = glm::min(low, glm::dvec3(p));
        high = glm::max(high, glm::dvec3(p));
    }
    polytope = of({low + (offset - beyond), high + (offset + beyond)});
    for (const HullPlane& plane : face_planes(hull, beyond, offset)) polytope.cut(plane);
    return polytope;
}

// Adds a face without corners that repeat, if anything is left of it.
void Polytope::add_face(std::span<const glm::dvec3> face, double tolerance) {
    const auto begin = static_cast<uint32_t>(corners_.size());
    for (const glm::dvec3& p : face)
        if (corners_.size() == begin || glm::distance(p, corners_.back()) > tolerance) corners_.push_back(p);
    while (corners_.size() > begin + 1 && glm::distance(corners_[begin], corners_.back()) <= tolerance)
        corners_.pop_back();
    if (corners_.size() < begin + 3)
        corners_.resize(begin);
    else
        ends_.push_back(static_cast<uint32_t>(corners_.size()));
}

void Polytope::cut(const HullPlane& plane) {
    if (empty()) return;
    const auto height = [&](const glm::dvec3& p) { return glm::dot(plane.normal, p) - plane.distance; };
    double highest = -std::numeric_limits<double>::infinity(), lowest = -highest, reach = 0.0;
    for (const glm::dvec3& p : corners_) {
        highest = std::max(highest, height(p));
        lowest = std::min(lowest, height(p));
        reach = std::max(reach, glm::distance(p, corners_[0]));
    }
    const double tolerance = same_corner * reach;
    if (highest <= tolerance) return;
    if (lowest >= -tolerance) {
        *this = {};
        return;
    }
    Polytope kept;
    kept.corners_.reserve(2 * corners_.size());
    kept.ends_.reserve(ends_.size() + 1);
    std::vector<glm::dvec3> part, lid;
    for (size_t f = 0; f < face_count(); ++f) {
        const std::span<const glm::dvec3> corners = face(f);
        part.clear();
        for (size_t k = 0; k < corners.size(); ++k) {
            const glm::dvec3 &p = corners[k], &q = corners[(k + 1) % corners.size()];
            const double at_p = height(p), at_q = height(q);
            if (at_p <= 0.0) part.push_back(p);
            if ((at_p <= 0.0) == (at_q <= 0.0)) continue;
            // From the lower end, so that both faces of an edge get the same point.
            const glm::dvec3 on =
                at_p <= 0.0 ? p + (at_p / (at_p - at_q)) * (q - p) : q + (at_q / (at_q - at_p)) * (p - q);
            part.push_back(on);
            lid.push_back(on);
        }
        kept.add_face(part, tolerance);
    }
    glm::dvec3 middle(0.0);
    for (const glm::dvec3& p : lid) middle += p / static_cast<double>(lid.size());
    const glm::dvec3 helper = std::abs(plane.normal.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 u = glm::normalize(glm::cross(helper, plane.normal)), v = glm::cross(plane.normal, u);
    std::vector<std::pair<double, glm::dvec3>> around;
    for (const glm::dvec3& p : lid) around.emplace_back(turn(glm::dot(u, p - middle), glm::dot(v, p - middle)), p);
    std::ranges::sort(around, {}, &std::pair<double, glm::dvec3>::first);
    lid.clear();
    for (const auto& [at, p] : around) lid.push_back(p);
    kept.add_face(lid, tolerance);
    *this = std::move(kept);
}

void Polytope::cut(std::span<const HullPlane> planes) {
    for (const HullPlane& plane : planes) cut(plane);
}

bool Polytope::is_beyond_one_of(std::span<const HullPlane> planes) const {
    return std::ranges::any_of(planes, [&](const HullPlane& plane) {
        return std::ranges::all_of(corners_,
                                   [&](const glm::dvec3& p) { return glm::dot(plane.normal, p) >= plane.distance; });
    });
}

double Polytope::volume() const {
    if (empty()) return 0.0;
    const glm::dvec3 origin = corners_[0];
    double sum = 0.0;
    for (size_t f = 0; f < face_count(); ++f) {
        const std::span<const glm::dvec3> corners = face(f);
        for (size_t k = 2; k < corners.size(); ++k)
            sum += glm::dot(corners[0] - origin, glm::cross(corners[k - 1] - origin, corners[k] - origin));
    }
    return sum / 6.0;
}

double Polytope::support(const glm::dvec3& direction) const {
    double farthest = -std::numeric_limits<double>::infinity();
    for (const glm::dvec3& p : corners_) farthest = std::max(farthest, glm::dot(direction, p));
    return farthest;
}

fracture::Box Polytope::box() const {
    return fracture::bounds(corners_);
}

glm::dvec3 Polytope::centre() const {
    glm::dvec3 sum(0.0);
    for (const glm::dvec3& p : corners_) sum += p / static_cast<double>(corners_.size());
    return sum;
}

std::vector<HullPlane> cell_planes(std::span<const glm::dvec3> sites, uint32_t cell) {
    std::vector<HullPlane> planes;
    for (uint32_t other = 0; other < sites.size(); ++other) {
        const glm::dvec3 apart = sites[other] - sites[cell];
        if (!(glm::length(apart) > 0.0)) continue; // itself, or a duplicate
        const glm::dvec3 normal = glm::normalize(apart);
        planes.push_back({normal, glm::dot(normal, 0.5 * (sites[other] + sites[cell]))});
    }
    const auto gap = [&](const HullPlane& plane) { return plane.distance - glm::dot(plane.normal, sites[cell]); };
    std::ranges::stable_sort(planes, {}, gap);
    return planes;
}

} // namespace brittle::physics

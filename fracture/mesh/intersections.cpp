#include "fracture/mesh/intersections.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/arithmetic/expansion.h"
#include "fracture/arithmetic/plane_predicates.h"
#include "fracture/mesh/triangle_tree.h"

namespace brittle::fracture {

int orientation(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d) {
    const glm::dvec3 p = a - d, q = b - d, r = c - d;
    const double yz = q.y * r.z, zy = q.z * r.y, zx = q.z * r.x, xz = q.x * r.z, xy = q.x * r.y, yx = q.y * r.x;
    const double determinant = p.x * (yz - zy) + p.y * (zx - xz) + p.z * (xy - yx);
    const double size = std::abs(p.x) * (std::abs(yz) + std::abs(zy)) + std::abs(p.y) * (std::abs(zx) + std::abs(xz))
                        + std::abs(p.z) * (std::abs(xy) + std::abs(yx));
    // Shewchuk's bound for the double stage is (7 + 56u)u times the sum of magnitudes, u = 2^-53.
    if (std::abs(determinant) > 0x8.0p-53 * size) return determinant > 0.0 ? 1 : -1;
    using exact::Expansion;
    const auto differences = [&](const glm::dvec3& v) {
        return std::array{Expansion::difference(v.x, d.x), Expansion::difference(v.y, d.y),
                          Expansion::difference(v.z, d.z)};
    };
    const auto u = differences(a), v = differences(b), w = differences(c);
    return (u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2])
            + u[2] * (v[0] * w[1] - v[1] * w[0]))
        .sign();
}

namespace {

using Corners = std::array<glm::dvec3, 3>;

int sign(double x) {
    return x > 0.0 ? 1 : (x < 0.0 ? -1 : 0);
}

glm::dvec2 without(const glm::dvec3& p, int axis) {
    return {p[(axis + 1) % 3], p[(axis + 2) % 3]};
}

// Returns an axis along which the triangle projects to a triangle with area; -1 for a triangle without area.
int open_axis(const Corners& t) {
    for (int axis = 0; axis < 3; ++axis)
        if (orientation(without(t[0], axis), without(t[1], axis), without(t[2], axis)) != 0.0) return axis;
    return -1;
}

bool overlap_on_line(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& d) {
    for (int k = 0; k < 2; ++k)
        if (std::max(a[k], b[k]) < std::min(c[k], d[k]) || std::max(c[k], d[k]) < std::min(a[k], b[k])) return false;
    return true;
}

bool segments_meet(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& d) {
    const int abc = sign(orientation(a, b, c)), abd = sign(orientation(a, b, d));
    const int cda = sign(orientation(c, d, a)), cdb = sign(orientation(c, d, b));
    if (abc * abd > 0 || cda * cdb > 0) return false;
    return abc != 0 || abd != 0 || overlap_on_line(a, b, c, d);
}

// Returns whether the segment pq, in the plane of the triangle, meets it.
bool meets_in_plane(const glm::dvec3& p, const glm::dvec3& q, const Corners& t, int axis) {
    std::array<glm::dvec2, 3> c{};
    for (size_t k = 0; k < 3; ++k) c[k] = without(t[k], axis);
    const glm::dvec2 a = without(p, axis), b = without(q, axis);
    int sides = 0;
    for (size_t k = 0; k < 3; ++k) {
        if (segments_meet(a, b, c[k], c[(k + 1) % 3])) return true;
        sides += sign(orientation(c[k], c[(k + 1) % 3], a));
    }
    return sides == 3 || sides == -3; // wholly inside
}

// Returns whether the segment pq meets the triangle; sp and sq are the sides of its plane on which p and q lie.
bool meets(const glm::dvec3& p, const glm::dvec3& q, int sp, int sq, const Corners& t, int axis) {
    if (sp * sq > 0) return false;
    if (sp == 0 && sq == 0) return meets_in_plane(p, q, t, axis);
    const int a = orientation(p, q, t[0], t[1]), b = orientation(p, q, t[1], t[2]);
    if (a * b < 0) return false;
    const int c = orientation(p, q, t[2], t[0]);
    return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
}

// A triangle, prepared for many tests against others.
struct Prepared {
    Corners corners{};
    glm::dvec3 low{0.0}, high{0.0}; // its box
    glm::dvec3 normal{0.0};
    double error = 0.0; // a bound on the error of side(), for each unit of distance
    int axis = -1;      // see open_axis()

    // The sign of orientation(corners, p); almost always the normal decides. With u = 2^-53 and L the product of the
    // largest components of two edges, a component of the normal is at most 2L and carries 8u L; the dot product with
    // the difference carries 4u of its terms. Together 16u L for each unit of the difference; 64u leaves room.
    [[nodiscard]] int side(const glm::dvec3& p) const {
        const glm::dvec3 d = p - corners[0];
        const double value = -(normal.x * d.x + normal.y * d.y + normal.z * d.z);
        if (std::abs(value) > error * (std::abs(d.x) + std::abs(d.y) + std::abs(d.z))) return sign(value);
        return orientation(corners[0], corners[1], corners[2], p);
    }
};

Prepared prepared(const Corners& c) {
    Prepared result{c, glm::min(c[0], glm::min(c[1], c[2])), glm::max(c[0], glm::max(c[1], c[2]))};
    const glm::dvec3 u = c[1] - c[0], v = c[2] - c[0];
    const auto largest = [](const glm::dvec3& e) { return std::max({std::abs(e.x), std::abs(e.y), std::abs(e.z)}); };
    result.normal = glm::cross(u, v);
    result.error = 0x40.0p-53 * largest(u) * largest(v);
    result.axis = open_axis(c);
    return result;
}

// Whether two triangles with area have a point in common besides shared vertices and edges.
bool have_common_points(const Triangle& u, const Prepared& a, const Triangle& v, const Prepared& b) {
    const Corners &p = a.corners, &q = b.corners;
    std::array<size_t, 3> own{}, other{}; // corners of s and t at shared vertices
    size_t shared = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (u[i] == v[j] && shared < 3) {
                own[shared] = static_cast<size_t>(i);
                other[shared++] = static_cast<size_t>(j);
            }
    if (shared == 3) return false;
    if (shared == 2) { // two shared vertices: the triangles intersect if they fold onto each other
        const size_t i = 3 - own[0] - own[1], j = 3 - other[0] - other[1];
        if (a.side(q[j]) != 0) return false;
        const auto side = [&](const glm::dvec3& at) {
            return sign(orientation(without(p[own[0]], a.axis), without(p[own[1]], a.axis), without(at, a.axis)));
        };
        return side(p[i]) == side(q[j]);
    }
    // The sides of the planes decide most pairs: all corners of one triangle on one side, apart from a shared one.
    std::array<int, 3> sp{}, sq{}; // of the corners of each triangle against the plane of the other
    const auto is_apart = [&](const Prepared& of, const Corners& corners, size_t common, std::array<int, 3>& sides) {
        int sum = 0;
        for (size_t k = 0; k < 3; ++k) {
            sides[k] = shared == 1 && k == common ? 0 : of.side(corners[k]);
            sum += sides[k];
        }
        return std::abs(sum) == static_cast<int>(3 - shared);
    };
    if (is_apart(a, q, other[0], sq) || is_apart(b, p, own[0], sp)) return false;
    const auto crosses = [](const Corners& ends, const std::array<int, 3>& sides, size_t k, const Prepared& of) {
        const size_t m = k == 2 ? 0 : k + 1;
        return meets(ends[k], ends[m], sides[k], sides[m], of.corners, of.axis);
    };
    if (shared == 1) return crosses(p, sp, (own[0] + 1) % 3, b) || crosses(q, sq, (other[0] + 1) % 3, a);
    for (size_t k = 0; k < 3; ++k)
        if (crosses(p, sp, k, b) || crosses(q, sq, k, a)) return true;
    return false;
}

class Finder {
  public:
    Finder(const TriangleMesh& mesh, uint64_t max_pairs, size_t max_listed)
        : mesh_(mesh), max_pairs_(max_pairs), max_listed_(max_listed), tree_(mesh, prepare()) {}

    Intersections run() {
        if (tree_.root() != no_index) join(tree_.root(), tree_.root());
        std::sort(result_.listed.begin(), result_.listed.end(), before);
        if (!result_.listed.empty()) result_.first = result_.listed.front();
        if (result_.listed.size() > max_listed_) result_.listed.resize(max_listed_);
        return std::move(result_);
    }

  private:
    static bool before(const glm::uvec2& a, const glm::uvec2& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; }

    // Fills prepared_. Returns the triangles with area.
    std::vector<uint32_t> prepare() {
        std::vector<uint32_t> triangles;
        prepared_.reserve(mesh_.triangles.size());
        for (uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
            const Triangle& c = mesh_.triangles[t];
            prepared_.push_back(prepared({mesh_.positions[c.x], mesh_.positions[c.y], mesh_.positions[c.z]}));
            if (prepared_.back().axis >= 0) triangles.push_back(t);
        }
        return triangles;
    }

    void join(uint32_t x, uint32_t y) {
        if (!result_.complete) return;
        const TriangleTree::Node &a = tree_[x], &b = tree_[y];
        for (int k = 0; k < 3; ++k)
            if (a.max[k] < b.min[k] || b.max[k] < a.min[k]) return;
        if (a.low == no_index && b.low == no_index) {
            for (uint32_t i = a.begin; i < a.end; ++i)
                for (uint32_t j = x == y ? i + 1 : b.begin; j < b.end; ++j) look_at(tree_.order()[i], tree_.order()[j]);
        } else if (x == y) {
            join(a.low, a.low);
            join(a.high, a.high);
            join(a.low, a.high);
        } else if (b.low == no_index || (a.low != no_index && a.end - a.begin >= b.end - b.begin)) {
            join(a.low, y);
            join(a.high, y);
        } else {
            join(x, b.low);
            join(x, b.high);
        }
    }

    void look_at(uint32_t s, uint32_t t) {
        if (!result_.complete) return;
        const Prepared &a = prepared_[s], &b = prepared_[t];
        for (int k = 0; k < 3; ++k)
            if (a.high[k] < b.low[k] || b.high[k] < a.low[k]) return;
        if (seen_++ == max_pairs_) {
            result_.complete = false;
            return;
        }
        if (!intersect(s, t)) return;
        ++result_.pairs;
        list({std::min(s, t), std::max(s, t)});
    }

    // Keeps the lowest pairs: at twice the requested count, the upper half is dropped.
    void list(const glm::uvec2& pair) {
        std::vector<glm::uvec2>& listed = result_.listed;
        listed.push_back(pair);
        const size_t keep = std::max<size_t>(max_listed_, 1);
        if (listed.size() < 2 * keep) return;
        std::nth_element(listed.begin(), listed.begin() + static_cast<std::ptrdiff_t>(keep), listed.end(), before);
        listed.resize(keep);
    }

    [[nodiscard]] bool intersect(uint32_t s, uint32_t t) const {
        return have_common_points(mesh_.triangles[s], prepared_[s], mesh_.triangles[t], prepared_[t]);
    }

    const TriangleMesh& mesh_;
    uint64_t max_pairs_, seen_ = 0;
    size_t max_listed_;
    std::vector<Prepared> prepared_; // per triangle
    TriangleTree tree_;
    Intersections result_;
};

} // namespace

Intersections find_intersections(const TriangleMesh& mesh, uint64_t max_pairs, size_t max_listed) {
    return Finder(mesh, max_pairs, max_listed).run();
}

bool intersect(std::span<const glm::dvec3> positions, const Triangle& s, const Triangle& t) {
    const auto of = [&](const Triangle& c) { return prepared({positions[c.x], positions[c.y], positions[c.z]}); };
    const Prepared a = of(s), b = of(t);
    return a.axis >= 0 && b.axis >= 0 && have_common_points(s, a, t, b);
}

} // namespace brittle::fracture

#include "fracture/mesh/convex_hull.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/arithmetic/plane_predicates.h"
#include "fracture/mesh/intersections.h"

namespace brittle::fracture {

namespace {

constexpr uint32_t none = UINT32_MAX;
// Differences of such coordinates are zero or above 1e-86, so products of three keep all their bits.
constexpr double min_coordinate = 1e-70, max_coordinate = 1e50;

bool in_range(double x) {
    return x == 0.0 || (std::abs(x) >= min_coordinate && std::abs(x) <= max_coordinate); // not for NaN
}

bool are_collinear(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    return orientation(glm::dvec2(a.x, a.y), {b.x, b.y}, {c.x, c.y}) == 0.0
           && orientation(glm::dvec2(a.y, a.z), {b.y, b.z}, {c.y, c.z}) == 0.0
           && orientation(glm::dvec2(a.z, a.x), {b.z, b.x}, {c.z, c.x}) == 0.0;
}

class Hull {
  public:
    explicit Hull(std::span<const glm::dvec3> points)
        : points_(points), next_(points.size(), none), face_from_(points.size(), none) {}

    TriangleMesh mesh() {
        if (const std::optional<std::array<uint32_t, 4>> corners = first_corners()) {
            begin(*corners);
            grow();
        }
        return surface();
    }

  private:
    struct Face {
        std::array<uint32_t, 3> corners;
        std::array<uint32_t, 3> across{none, none, none}; // by edge, from corners[k] to the next corner: the other face
        glm::dvec3 corner{0.0};                           // the first
        glm::dvec3 normal{0.0};                           // of the length of twice the area
        double error = 0.0;                               // bounds the error of a height, for each unit of distance
        uint32_t outside = none;                          // the first point that is listed as outside it; see next_
        uint32_t farthest = none;                         // of these
        double reach = 0.0;                               // height of the farthest one, with the length of the normal
        bool gone = false;
    };

    // Returns the corners of a tetrahedron that is positively oriented; nothing where all points lie in a plane.
    [[nodiscard]] std::optional<std::array<uint32_t, 4>> first_corners() const {
        const auto count = static_cast<uint32_t>(points_.size());
        if (count < 4) return std::nullopt;
        // The point of the greatest measure that passes a test; one with a rounded measure may fail it.
        const auto greatest = [&](auto&& measure, auto&& passes) {
            uint32_t best = none;
            double most = 0.0;
            for (uint32_t i = 0; i < count; ++i) {
                const double own = measure(points_[i]);
                if (best == none ? passes(points_[i]) : own > most && passes(points_[i])) {
                    best = i;
                    most = own;
                }
            }
            return best;
        };
        const glm::dvec3& a = points_[0];
        const auto squared = [](const glm::dvec3& v) { return glm::dot(v, v); };
        const uint32_t second =
            greatest([&](const glm::dvec3& p) { return squared(p - a); }, [&](const glm::dvec3& p) { return p != a; });
        if (second == none) return std::nullopt;
        const glm::dvec3& b = points_[second];
        const uint32_t third = greatest([&](const glm::dvec3& p) { return squared(glm::cross(p - a, b - a)); },
                                        [&](const glm::dvec3& p) { return !are_collinear(a, b, p); });
        if (third == none) return std::nullopt;
        const glm::dvec3& c = points_[third];
        const glm::dvec3 normal = glm::cross(b - a, c - a);
        const uint32_t fourth = greatest([&](const glm::dvec3& p) { return std::abs(glm::dot(p - a, normal)); },
                                         [&](const glm::dvec3& p) { return orientation(a, b, c, p) != 0; });
        if (fourth == none) return std::nullopt;
        if (orientation(a, b, c, points_[fourth]) > 0) return std::array{0u, second, third, fourth};
        return std::array{0u, third, second, fourth};
    }

    void begin(const std::array<uint32_t, 4>& t) {
        // `fourth` sees a, b, c clockwise: they are counter-clockwise from outside.
        faces_ = {face_of({t[0], t[1], t[2]}), face_of({t[0], t[3], t[1]}), face_of({t[1], t[3], t[2]}),
                  face_of({t[2], t[3], t[0]})};
        faces_[0].across = {1, 2, 3};
        faces_[1].across = {3, 2, 0};
        faces_[2].across = {1, 3, 0};
        faces_[3].across = {2, 1, 0};
        for (uint32_t i = 0; i < points_.size(); ++i)
            if (std::ranges::find(t, i) == t.end()) list(i, 0);
    }

    // Joins the farthest point outside of a face to the hull, as long as there is one.
    void grow() {
        for (uint32_t f = 0; f < faces_.size(); ++f)
            if (!faces_[f].gone && faces_[f].outside != none) join(f);
    }

    void join(uint32_t seen) {
        const uint32_t apex = faces_[seen].farthest;
        find_seen(seen, apex);
        const auto first_new = static_cast<uint32_t>(faces_.size());
        for (const auto& [face, edge] : horizon_) {
            const uint32_t from = faces_[face].corners[edge], to = faces_[face].corners[(edge + 1) % 3];
            const uint32_t beyond = faces_[face].across[edge];
            const auto made = static_cast<uint32_t>(faces_.size());
            faces_.push_back(face_of({from, to, apex}));
            faces_.back().across[0] = beyond;
            std::array<uint32_t, 3>& back = faces_[beyond].across;
            *std::ranges::find(back, face) = made;
            face_from_[from] = made;
        }
        for (uint32_t f = first_new; f < faces_.size(); ++f) {
            const uint32_t following = face_from_[faces_[f].corners[1]];
            faces_[f].across[1] = following;
            faces_[following].across[2] = f;
        }
        for (const uint32_t face : seen_) {
            for (uint32_t i = faces_[face].outside; i != none;) {
                const uint32_t following = next_[i];
                if (i != apex) list(i, first_new);
                i = following;
            }
        }
    }

    // Finds the faces that the apex is outside of, and the edges around them. Those faces are connected, and around them
    // runs one loop that meets no vertex twice, since all sides are exact.
    void find_seen(uint32_t start, uint32_t apex) {
        seen_ = {start};
        horizon_.clear();
        faces_[start].gone = true;
        for (size_t i = 0; i < seen_.size(); ++i) {
            const uint32_t face = seen_[i];
            for (uint32_t edge = 0; edge < 3; ++edge) {
                const uint32_t other = faces_[face].across[edge];
                if (faces_[other].gone) continue;
                if (double height = 0.0; is_outside(faces_[other], points_[apex], height)) {
                    faces_[other].gone = true;
                    seen_.push_back(other);
                }
            }
        }
        for (const uint32_t face : seen_)
            for (uint32_t edge = 0; edge < 3; ++edge)
                if (!faces_[faces_[face].across[edge]].gone) horizon_.emplace_back(face, edge);
    }

    // Lists a point with the first face, from `first` on, that it is outside of.
    void list(uint32_t point, uint32_t first) {
        for (uint32_t f = first; f < faces_.size(); ++f) {
            Face& face = faces_[f];
            double height = 0.0;
            if (!is_outside(face, points_[point], height)) continue;
            next_[point] = face.outside;
            face.outside = point;
            if (face.farthest == none || height > face.reach) {
                face.farthest = point;
                face.reach = height;
            }
            return;
        }
    }

    [[nodiscard]] Face face_of(const std::array<uint32_t, 3>& corners) const {
        const glm::dvec3& a = points_[corners[0]];
        const glm::dvec3 u = points_[corners[1]] - a, v = points_[corners[2]] - a;
        const auto largest = [](const glm::dvec3& e) {
            return std::max({std::abs(e.x), std::abs(e.y), std::abs(e.z)});
        };
        // With u = 2^-53 and L the product of the largest components of both edges, a component of the normal is at
        // most 2L and carries 8u L; the dot product of a height carries 4u of its terms. Together 16u L.
        return {
            .corners = corners, .corner = a, .normal = glm::cross(u, v), .error = 0x40.0p-53 * largest(u) * largest(v)};
    }

    // Sets `height` to the rounded height above the plane of the face, in units of the normal's length.
    [[nodiscard]] bool is_outside(const Face& face, const glm::dvec3& p, double& height) const {
        const glm::dvec3 d = p - face.corner;
        height = glm::dot(face.normal, d);
        if (std::abs(height) > face.error * (std::abs(d.x) + std::abs(d.y) + std::abs(d.z))) return height > 0.0;
        return orientation(face.corner, points_[face.corners[1]], points_[face.corners[2]], p) < 0;
    }

    [[nodiscard]] TriangleMesh surface() const {
        TriangleMesh mesh;
        std::vector<uint32_t> index(points_.size(), none);
        for (const Face& face : faces_)
            if (!face.gone)
                for (const uint32_t corner : face.corners) index[corner] = 0;
        for (size_t i = 0; i < points_.size(); ++i) {
            if (index[i] == none) continue;
            index[i] = static_cast<uint32_t>(mesh.positions.size());
            mesh.positions.push_back(points_[i]);
        }
        for (const Face& face : faces_)
            if (!face.gone)
                mesh.triangles.emplace_back(index[face.corners[0]], index[face.corners[1]], index[face.corners[2]]);
        return mesh;
    }

    std::span<const glm::dvec3> points_;
    std::vector<Face> faces_;         // also those that later points have replaced
    std::vector<uint32_t> next_;      // by point: the next one that is outside of the same face
    std::vector<uint32_t> face_from_; // by point: the new face whose edge on the horizon begins there
    std::vector<uint32_t> seen_;      // faces that the apex replaces
    std::vector<std::pair<uint32_t, uint32_t>> horizon_; // faces among them, and their edges to others
};

} // namespace

TriangleMesh convex_hull(std::span<const glm::dvec3> points) {
    if (!std::ranges::all_of(points,
                             [](const glm::dvec3& p) { return in_range(p.x) && in_range(p.y) && in_range(p.z); }))
        return {};
    return Hull(points).mesh();
}

TriangleMesh convex_hull(std::span<const glm::vec3> points) {
    return convex_hull(std::vector<glm::dvec3>(points.begin(), points.end()));
}

} // namespace brittle::fracture

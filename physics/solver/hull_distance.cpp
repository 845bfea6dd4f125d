#include "physics/solver/hull_distance.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace brittle::physics {

namespace {

using glm::dvec3;

// More than any pair of hulls of 32 points has needed (19 and 40). At the limit the best result so far is returned.
constexpr int max_gjk_rounds = 48, max_epa_rounds = 64;
// Hulls nearer than this part of their size count as overlapping: the direction between nearest points is rounding
// error.
constexpr double touching_part = 1e-5;
// GJK ends if no corner can reduce the squared distance by more than this part of it. The value is Bullet's: with a
// smaller one, nearly parallel faces always give the same corner, and manifolds take longer to fill with four points.
constexpr double near_enough = 1e-10;
// EPA ends if the next corner would move the face by at most this part of the hulls' size.
constexpr double face_part = 1e-5;

// A vertex of the Minkowski difference, first minus second, in the first hull's frame.
struct Corner {
    dvec3 at;
    uint16_t index_first, index_second;
};

dvec3 to_double(const glm::vec3& v) {
    return {v.x, v.y, v.z};
}
glm::vec3 to_single(const dvec3& v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

struct Difference {
    const HullShape& first;
    const HullShape& second;
    const Transform& frame; // of the second hull in the first hull's frame

    [[nodiscard]] dvec3 on_second(int index) const {
        return to_double(frame * second.points()[static_cast<size_t>(index)]);
    }
    [[nodiscard]] Corner corner(int index_first, int index_second) const {
        return {to_double(first.points()[static_cast<size_t>(index_first)]) - on_second(index_second),
                static_cast<uint16_t>(index_first), static_cast<uint16_t>(index_second)};
    }
    // The vertex farthest in a direction.
    [[nodiscard]] Corner support(const dvec3& direction) const {
        const glm::vec3 along = to_single(direction);
        return corner(first.support_index(along), second.support_index(-along * frame.basis));
    }
};

struct Simplex {
    std::array<Corner, 4> corners;
    std::array<double, 4> weights; // of the nearest point to the origin
    size_t count = 0;
    dvec3 nearest;

    [[nodiscard]] bool has(const Corner& corner) const {
        return std::any_of(corners.begin(), corners.begin() + static_cast<std::ptrdiff_t>(count), [&](const Corner& c) {
            return c.index_first == corner.index_first && c.index_second == corner.index_second;
        });
    }
    // Set the simplex to a corner, a segment or a triangle, with the weights of its point nearest to the origin.
    void set(const Corner& a) {
        corners[0] = a;
        weights[0] = 1.0;
        count = 1;
        nearest = a.at;
    }
    void set(const Corner& a, const Corner& b, double weight_b) {
        corners[0] = a, corners[1] = b;
        weights[0] = 1.0 - weight_b, weights[1] = weight_b;
        count = 2;
        nearest = weights[0] * a.at + weights[1] * b.at;
    }
    void set(const Corner& a, const Corner& b, const Corner& c, double weight_b, double weight_c) {
        corners[0] = a, corners[1] = b, corners[2] = c;
        weights[0] = 1.0 - weight_b - weight_c, weights[1] = weight_b, weights[2] = weight_c;
        count = 3;
        nearest = weights[0] * a.at + weights[1] * b.at + weights[2] * c.at;
    }
    [[nodiscard]] dvec3 on_second(const Difference& difference) const {
        dvec3 point(0.0);
        for (size_t i = 0; i < count; ++i) point += weights[i] * difference.on_second(corners[i].index_second);
        return point;
    }
};

void nearest_of_segment(Simplex& s, const Corner a, const Corner b) {
    const dvec3 side = b.at - a.at;
    const double along = -glm::dot(a.at, side), square = glm::dot(side, side);
    if (along <= 0.0) return s.set(a);
    if (along >= square) return s.set(b);
    s.set(a, b, along / square);
}

// Ericson 5.1.5, with the origin as the query point.
void nearest_of_triangle(Simplex& s, const Corner a, const Corner b, const Corner c) {
    const dvec3 ab = b.at - a.at, ac = c.at - a.at;
    const double d1 = -glm::dot(ab, a.at), d2 = -glm::dot(ac, a.at);
    if (d1 <= 0.0 && d2 <= 0.0) return s.set(a);
    const double d3 = -glm::dot(ab, b.at), d4 = -glm::dot(ac, b.at);
    if (d3 >= 0.0 && d4 <= d3) return s.set(b);
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return nearest_of_segment(s, a, b);
    const double d5 = -glm::dot(ab, c.at), d6 = -glm::dot(ac, c.at);
    if (d6 >= 0.0 && d5 <= d6) return s.set(c);
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return nearest_of_segment(s, a, c);
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) return nearest_of_segment(s, b, c);
    const double sum = va + vb + vc;
    if (!(sum > 0.0)) return nearest_of_segment(s, a, b); // no area: the new corner lies on a side
    s.set(a, b, c, vb / sum, vc / sum);
}

// Reduces the simplex to the face nearest to the origin and returns false; returns true and leaves it unchanged if the
// origin is inside.
bool inside_tetrahedron(Simplex& s) {
    const std::array<Corner, 4> corners = s.corners;
    Simplex best;
    double best_square = std::numeric_limits<double>::infinity();
    for (size_t apex = 0; apex < 4; ++apex) {
        const Corner &a = corners[(apex + 1) % 4], &b = corners[(apex + 2) % 4], &c = corners[(apex + 3) % 4];
        const dvec3 normal = glm::cross(b.at - a.at, c.at - a.at);
        const double of_apex = glm::dot(normal, corners[apex].at - a.at), of_origin = -glm::dot(normal, a.at);
        if (of_apex * of_origin > 0.0) continue; // origin and apex on one side of the face
        Simplex face;
        nearest_of_triangle(face, a, b, c);
        const double square = glm::dot(face.nearest, face.nearest);
        if (square < best_square) best = face, best_square = square;
    }
    if (best_square == std::numeric_limits<double>::infinity()) return true;
    s = best;
    return false;
}

// Reduces the simplex to the corners that span its point nearest to the origin. Returns whether the origin is inside
// the simplex.
bool reduce(Simplex& s) {
    const std::array<Corner, 4> c = s.corners;
    switch (s.count) {
    case 1:
        s.set(c[0]);
        return false;
    case 2:
        nearest_of_segment(s, c[0], c[1]);
        return false;
    case 3:
        nearest_of_triangle(s, c[0], c[1], c[2]);
        return false;
    default:
        return inside_tetrahedron(s);
    }
}

void remember(const Simplex& s, NearestCorners& corners) {
    corners.count = static_cast<uint32_t>(s.count);
    for (size_t i = 0; i < s.count; ++i) {
        corners.first[i] = s.corners[i].index_first;
        corners.second[i] = s.corners[i].index_second;
    }
}

// EPA's polytope: lies inside the Minkowski difference and grows until its face nearest to the origin lies on the
// difference's surface.
class Polytope {
  public:
    Polytope(const Difference& difference, double size) : difference_(difference), size_(size) {}

    // Starts from a simplex that contains the origin, possibly on its border. Returns false if the difference is flat.
    bool begin(Simplex simplex) {
        if (!make_tetrahedron(simplex)) return false;
        std::copy(simplex.corners.begin(), simplex.corners.end(), corners_.begin());
        corner_count_ = 4;
        for (const auto& [a, b, c, apex] : {std::array{0, 1, 2, 3}, {0, 3, 1, 2}, {0, 2, 3, 1}, {1, 3, 2, 0}}) {
            const bool outwards = side_of(corners_[apex].at, corners_[a].at, corners_[b].at, corners_[c].at) < 0.0;
            if (!add_face(a, outwards ? b : c, outwards ? c : b)) return false;
        }
        return true;
    }

    // Returns the overlap of least depth, and the corners that span it.
    [[nodiscard]] HullDistance least(NearestCorners& near) {
        double min_depth = std::numeric_limits<double>::infinity();
        Face found{};
        for (int round = 0; round < max_epa_rounds; ++round) {
            const auto face =
                std::ranges::min_element(faces_.begin(), faces_.begin() + face_count_, {}, &Face::distance);
            const Corner corner = difference_.support(face->normal);
            const double depth = glm::dot(face->normal, corner.at);
            const bool last = depth - face->distance <= face_part * size_;
            // The depth along any direction is an upper bound of the least depth, so an early end returns the best
            // direction so far.
            if (last || depth < min_depth) min_depth = depth, found = *face;
            if (last || !grow(corner)) break;
        }
        const Simplex at = nearest_to(found.normal * min_depth, found);
        remember(at, near);
        return {static_cast<float>(-min_depth), to_single(-found.normal), to_single(at.on_second(difference_))};
    }

  private:
    struct Face {
        std::array<uint8_t, 3> corner;
        dvec3 normal; // unit, outwards
        double distance;
    };

    // Six times the signed volume of (a, b, c, p): positive if p is on the side of the triangle's normal.
    static double side_of(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c) {
        return glm::dot(glm::cross(b - a, c - a), p - a);
    }

    bool make_tetrahedron(Simplex& s) {
        const auto add = [&](const dvec3& direction, const auto& measure, double least) {
            for (const double sign : {1.0, -1.0}) {
                const Corner corner = difference_.support(sign * direction);
                if (std::abs(measure(corner.at)) <= least) continue;
                s.corners[s.count++] = corner;
                return true;
            }
            return false;
        };
        const double small = 1e-4 * size_;
        if (s.count == 1) {
            const auto apart = [&](const dvec3& p) { return glm::length(p - s.corners[0].at); };
            if (!add({1, 0, 0}, apart, small) && !add({0, 1, 0}, apart, small) && !add({0, 0, 1}, apart, small))
                return false;
        }
        if (s.count == 2) {
            const dvec3 side = glm::normalize(s.corners[1].at - s.corners[0].at);
            const dvec3 across =
                glm::normalize(glm::cross(side, std::abs(side.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
            const auto apart = [&](const dvec3& p) { return glm::length(glm::cross(side, p - s.corners[0].at)); };
            if (!add(across, apart, small) && !add(glm::cross(side, across), apart, small)) return false;
        }
        if (s.count == 3) {
            const dvec3 normal = glm::cross(s.corners[1].at - s.corners[0].at, s.corners[2].at - s.corners[0].at);
            const double area = glm::length(normal);
            if (!(area > 0.0)) return false;
            const auto apart = [&](const dvec3& p) { return glm::dot(normal / area, p - s.corners[0].at); };
            if (!add(normal, apart, 1e-3 * small)) return false;
        }
        return true;
    }

    bool add_face(size_t a, size_t b, size_t c) {
        if (face_count_ == faces_.size()) return false;
        const dvec3 origin = corners_[a].at;
        const dvec3 normal = glm::cross(corners_[b].at - origin, corners_[c].at - origin);
        const double area = glm::length(normal);
        if (!(area > 0.0)) return false;
        faces_[face_count_++] = {{static_cast<uint8_t>(a), static_cast<uint8_t>(b), static_cast<uint8_t>(c)},
                                 normal / area,
                                 glm::dot(normal / area, origin)};
        return true;
    }

    // Replaces the faces visible from the corner by the cone over their horizon. Returns false if the arrays are full
    // or rounding leaves no valid horizon.
    bool grow(const Corner& corner) {
        if (corner_count_ == corners_.size()) return false;
        horizon_count_ = 0;
        for (size_t i = face_count_; i-- > 0;) {
            const Face face = faces_[i];
            if (glm::dot(face.normal, corner.at) - face.distance <= 1e-3 * face_part * size_) continue;
            for (size_t k = 0; k < 3; ++k)
                if (!toggle(face.corner[k], face.corner[(k + 1) % 3])) return false;
            faces_[i] = faces_[--face_count_];
        }
        if (horizon_count_ < 3) return false;
        corners_[corner_count_] = corner;
        for (size_t i = 0; i < horizon_count_; ++i)
            if (!add_face(horizon_[i][0], horizon_[i][1], corner_count_)) return false;
        ++corner_count_;
        return true;
    }

    // Adds a half-edge to the horizon, or removes its twin: an edge between two removed faces is not on the horizon.
    bool toggle(uint8_t from, uint8_t to) {
        for (size_t i = 0; i < horizon_count_; ++i) {
            if (horizon_[i][0] != to || horizon_[i][1] != from) continue;
            horizon_[i] = horizon_[--horizon_count_];
            return true;
        }
        if (horizon_count_ == horizon_.size()) return false;
        horizon_[horizon_count_++] = {from, to};
        return true;
    }

    // Returns the corners and weights of a point on the surface: in `face`, or in another face of its plane, because
    // rounding decides which coplanar face counts as nearest.
    [[nodiscard]] Simplex nearest_to(const dvec3& point, const Face& face) const {
        Simplex best;
        double best_square = std::numeric_limits<double>::infinity();
        const auto look = [&](const Face& at) {
            Corner c[3] = {corners_[at.corner[0]], corners_[at.corner[1]], corners_[at.corner[2]]};
            for (Corner& corner : c) corner.at -= point;
            Simplex s;
            nearest_of_triangle(s, c[0], c[1], c[2]);
            const double square = glm::dot(s.nearest, s.nearest);
            if (square < best_square) best = s, best_square = square;
        };
        look(face);
        for (size_t i = 0; i < face_count_; ++i)
            if (glm::dot(faces_[i].normal, point) > faces_[i].distance - 2.0 * face_part * size_) look(faces_[i]);
        return best;
    }

    const Difference& difference_;
    double size_;
    std::array<Corner, 4 + max_epa_rounds> corners_;
    std::array<Face, 2 * (4 + max_epa_rounds)> faces_;
    std::array<std::array<uint8_t, 2>, 2 * max_epa_rounds> horizon_;
    size_t corner_count_ = 0, face_count_ = 0, horizon_count_ = 0;
};

Simplex start(const Difference& difference, const NearestCorners& corners) {
    Simplex s;
    const auto known = [&](size_t i) {
        return corners.first[i] < difference.first.point_count() && corners.second[i] < difference.second.point_count();
    };
    for (size_t i = 0; i < corners.count; ++i)
        if (known(i)) s.corners[s.count++] = difference.corner(corners.first[i], corners.second[i]);
    if (s.count == 0) s.corners[s.count++] = difference.support(-to_double(difference.frame.origin));
    return s;
}

HullDistance touching(const Simplex& s, const Difference& difference) {
    const double distance = glm::length(s.nearest);
    return {static_cast<float>(distance), to_single(s.nearest / distance), to_single(s.on_second(difference))};
}

} // namespace

HullDistance hull_distance(const HullShape& first, const HullShape& second, const Transform& second_in_first,
                           float limit, NearestCorners& corners) {
    assert(first.point_count() <= 65536 && second.point_count() <= 65536);
    const Difference difference{first, second, second_in_first};
    const double size = static_cast<double>(first.radius()) + static_cast<double>(second.radius());
    const double touch = touching_part * size;
    Simplex s = start(difference, corners);
    bool inside = reduce(s);
    for (int round = 0; !inside && round < max_gjk_rounds; ++round) {
        const double square = glm::dot(s.nearest, s.nearest);
        if (square <= touch * touch) {
            inside = true;
            break;
        }
        const Corner corner = difference.support(-s.nearest);
        const double along = glm::dot(s.nearest, corner.at);
        if (along > 0.0 && along * along > static_cast<double>(limit) * static_cast<double>(limit) * square) {
            remember(s, corners);
            const double length = std::sqrt(square);
            return {static_cast<float>(along / length), to_single(s.nearest / length), {0.0f, 0.0f, 0.0f}};
        }
        // No corner is nearer except by rounding.
        if (s.has(corner) || square - along <= near_enough * square) break;
        Simplex next = s;
        next.corners[next.count++] = corner;
        inside = reduce(next);
        if (!inside && glm::dot(next.nearest, next.nearest) >= square) break;
        s = next;
    }
    if (!inside) {
        remember(s, corners);
        return touching(s, difference);
    }
    Polytope polytope(difference, size);
    if (polytope.begin(s)) return polytope.least(corners);
    corners.count = 0;
    HullDistance flat;
    const glm::vec3 apart = -second_in_first.origin;
    if (length_squared(apart) > 0.0f) flat.normal = apart * (1.0f / glm::length(apart));
    flat.point = to_single(difference.on_second(s.corners[0].index_second));
    return flat;
}

} // namespace brittle::physics

#include "physics/world/hull.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

// All that Brittle uses of Bullet outside physics/bullet: a convex hull in exact integer arithmetic.
#include <LinearMath/btConvexHullComputer.h>
#include <glm/geometric.hpp>

#include "fracture/base/simd.h"
#include "fracture/base/threads.h"
#include "fracture/mesh/principal_axes.h"

namespace brittle::physics {

namespace {

// Ratio of thinnest to longest extent below which a point set counts as flat (a flake, needle or point):
// single-precision contact code cannot separate its two sides.
constexpr double flat_ratio = 1e-3;
// Half thickness of a flat set, as a ratio of its longest extent; of a point, m.
constexpr double flat_half_thickness = 5e-5;
constexpr double point_half_thickness = 5e-5;
// Range of HullSettings::margin_fraction: a positive margin, and a core that is not empty.
constexpr double min_fraction = 1e-3, max_fraction = 0.45;
// Directions for which supporting points are found, 16 degrees apart; as many again are denser around the thin axes.
constexpr size_t even_directions = 160;
constexpr double golden_angle = 2.399963229728653; // rad, of Vogel's spiral
// Cosine of 3 degrees: faces at a smaller angle look like one.
constexpr double same_face = 0.9986;
// Corners that are nearer to a face's plane than this part of the hull's extent may belong to it.
constexpr double same_plane = 2e-3;

// Depths of a cut along a plane, as parts of the hull's length: less is the rounding of a flat contact, more would mean
// that the contact is not nearly plane.
constexpr double min_cut = 1e-6, max_cut = 0.25;

struct Plane {
    glm::dvec3 normal{0.0}; // outwards, unit
    double distance = 0.0;  // normal . x <= distance inside
};

struct FullHull {
    std::vector<glm::dvec3> vertices;
    std::vector<Plane> planes;
    glm::dvec3 centre{0.0}; // mean of the vertices
    double inradius = 0.0;  // smallest distance from the centre to a plane
    CrossSection section;
};

glm::dvec3 to_glm(const btVector3& v) {
    return {v.x(), v.y(), v.z()};
}

std::vector<glm::dvec3> finite_points(std::span<const glm::dvec3> points, const glm::dvec3& origin) {
    std::vector<glm::dvec3> kept;
    kept.reserve(points.size());
    for (const glm::dvec3& point : points) {
        const glm::dvec3 local = point - origin;
        if (std::isfinite(local.x) && std::isfinite(local.y) && std::isfinite(local.z)) kept.push_back(local);
    }
    return kept;
}

// Returns at most `count` points that span nearly the same hull: the extremes along the axes, then always the point
// farthest from the chosen ones. Distances are relative to the extents, so thin pieces keep both sides.
std::vector<glm::dvec3> farthest_point_subset(const std::vector<glm::dvec3>& points, size_t count) {
    if (points.size() <= count) return points;
    glm::dvec3 low = points[0], high = points[0];
    std::array<size_t, 6> extremes{};
    for (size_t i = 0; i < points.size(); ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            if (points[i][axis] < points[extremes[2 * axis]][axis]) extremes[2 * axis] = i;
            if (points[i][axis] > points[extremes[2 * axis + 1]][axis]) extremes[2 * axis + 1] = i;
        }
        low = glm::min(low, points[i]);
        high = glm::max(high, points[i]);
    }
    const glm::dvec3 scale = 1.0 / glm::max(high - low, glm::dvec3(1e-30));
    std::vector<double> gap(points.size(), std::numeric_limits<double>::infinity());
    std::vector<glm::dvec3> chosen;
    const auto choose = [&](size_t index) {
        if (gap[index] == 0.0) return;
        chosen.push_back(points[index]);
        for (size_t i = 0; i < points.size(); ++i) {
            const glm::dvec3 apart = (points[i] - points[index]) * scale;
            gap[i] = std::min(gap[i], glm::dot(apart, apart));
        }
    };
    for (const size_t index : extremes) choose(index);
    while (chosen.size() < count) {
        const auto farthest = std::max_element(gap.begin(), gap.end());
        if (*farthest == 0.0) break; // only duplicates are left
        choose(static_cast<size_t>(farthest - gap.begin()));
    }
    return chosen;
}

std::optional<FullHull> full_hull(const std::vector<glm::dvec3>& points) {
    btConvexHullComputer computer;
    computer.compute(&points[0].x, static_cast<int>(sizeof(glm::dvec3)), static_cast<int>(points.size()), 0.0f, 0.0f);
    if (computer.vertices.size() < 4 || computer.faces.size() < 4) return std::nullopt;
    FullHull hull;
    // btConvexHullComputer rounds coordinates to its grid: use the original points.
    for (int i = 0; i < computer.vertices.size(); ++i) {
        hull.vertices.push_back(points[static_cast<size_t>(computer.original_vertex_index[i])]);
        hull.centre += hull.vertices.back();
    }
    hull.centre /= static_cast<double>(hull.vertices.size());
    hull.inradius = std::numeric_limits<double>::infinity();
    std::vector<glm::dvec3> areas;
    for (int face = 0; face < computer.faces.size(); ++face) {
        const btConvexHullComputer::Edge* first = &computer.edges[computer.faces[face]];
        const glm::dvec3& apex = hull.vertices[static_cast<size_t>(first->getSourceVertex())];
        glm::dvec3 area(0.0);
        for (const auto* edge = first;; edge = edge->getNextEdgeOfFace()) {
            area += glm::cross(hull.vertices[static_cast<size_t>(edge->getSourceVertex())] - apex,
                               hull.vertices[static_cast<size_t>(edge->getTargetVertex())] - apex);
            if (edge->getNextEdgeOfFace() == first) break;
        }
        areas.push_back(0.5 * area);
        const double length = glm::length(area);
        if (!(length > 0.0)) continue; // its area vanishes without the rounding to the grid
        Plane plane{area / length, 0.0};
        if (glm::dot(plane.normal, apex - hull.centre) < 0.0) plane.normal = -plane.normal;
        // The supporting vertex may be a neighbour of the face that rounding to the grid put inside.
        plane.distance = glm::dot(plane.normal, apex);
        for (const glm::dvec3& vertex : hull.vertices)
            plane.distance = std::max(plane.distance, glm::dot(plane.normal, vertex));
        hull.inradius = std::min(hull.inradius, plane.distance - glm::dot(plane.normal, hull.centre));
        hull.planes.push_back(plane);
    }
    hull.section = section_of_faces(areas);
    return hull.planes.size() < 4 ? std::nullopt : std::optional(std::move(hull));
}

// Cuts the hull of the points along the planes that pass through it. Returns points whose hull lies inside both; their
// hull lacks the corner of three planes in its inside.
std::vector<glm::dvec3> cut_points(const std::vector<glm::dvec3>& points, std::span<const HullPlane> planes) {
    btConvexHullComputer computer;
    computer.compute(&points[0].x, static_cast<int>(sizeof(glm::dvec3)), static_cast<int>(points.size()), 0.0f, 0.0f);
    using Polygon = std::vector<glm::dvec3>;
    std::vector<Polygon> faces;
    for (int face = 0; face < computer.faces.size(); ++face) {
        const btConvexHullComputer::Edge* const first = &computer.edges[computer.faces[face]];
        Polygon& polygon = faces.emplace_back();
        for (const auto* edge = first;; edge = edge->getNextEdgeOfFace()) {
            polygon.push_back(points[static_cast<size_t>(computer.original_vertex_index[edge->getSourceVertex()])]);
            if (edge->getNextEdgeOfFace() == first) break;
        }
    }
    for (const HullPlane& plane : planes) {
        for (Polygon& polygon : faces) { // Sutherland and Hodgman, 1974
            Polygon kept;
            for (size_t k = 0; k < polygon.size(); ++k) {
                const glm::dvec3 &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
                const double over_a = glm::dot(plane.normal, a) - plane.distance;
                const double over_b = glm::dot(plane.normal, b) - plane.distance;
                if (over_a <= 0.0) kept.push_back(a);
                if ((over_a < 0.0 && over_b > 0.0) || (over_a > 0.0 && over_b < 0.0))
                    kept.push_back(a + (b - a) * (over_a / (over_a - over_b)));
            }
            polygon = std::move(kept);
        }
    }
    std::vector<glm::dvec3> left;
    for (const Polygon& polygon : faces) left.insert(left.end(), polygon.begin(), polygon.end());
    return left;
}

// The planes that cut something off the points, but not more than a quarter of their length.
std::vector<HullPlane> cutting_planes(const std::vector<glm::dvec3>& points, const glm::dvec3& origin,
                                      std::span<const HullPlane> planes, double length) {
    std::vector<HullPlane> cutting;
    for (const HullPlane& plane : planes) {
        const double distance = plane.distance - glm::dot(plane.normal, origin);
        double over = -std::numeric_limits<double>::infinity();
        for (const glm::dvec3& p : points) over = std::max(over, glm::dot(plane.normal, p) - distance);
        if (over > min_cut * length && over < max_cut * length) cutting.push_back({plane.normal, distance});
    }
    return cutting;
}

struct InnerHull {
    std::vector<glm::dvec3> vertices;
    double margin = 0.0; // smallest distance of a vertex to a plane of the full hull
};

// Moves the planes inwards by the margin. btConvexHullComputer works on a grid of about 10^4 cells an axis, so the
// margin is measured afterwards in double; returns nothing if it is below 0.7 of the requested one.
std::optional<InnerHull> offset_hull(const FullHull& hull, double margin) {
    btConvexHullComputer computer;
    const btScalar moved =
        computer.compute(&hull.vertices[0].x, static_cast<int>(sizeof(glm::dvec3)),
                         static_cast<int>(hull.vertices.size()), static_cast<btScalar>(margin), 0.0f);
    if (moved < 0.0f || computer.vertices.size() < 4) return std::nullopt;
    InnerHull inner{{}, margin};
    for (int i = 0; i < computer.vertices.size(); ++i) {
        inner.vertices.push_back(to_glm(computer.vertices[i]));
        for (const Plane& plane : hull.planes)
            inner.margin = std::min(inner.margin, plane.distance - glm::dot(plane.normal, inner.vertices.back()));
    }
    return inner.margin < 0.7 * margin ? std::nullopt : std::optional(std::move(inner));
}

// Scales the hull about its centre by s = 1 - margin / inradius: each plane at distance d >= inradius moves to
// s * d <= d - margin.
InnerHull scaled_hull(const FullHull& hull, double margin) {
    InnerHull inner{hull.vertices, margin};
    for (glm::dvec3& vertex : inner.vertices)
        vertex = hull.centre + (vertex - hull.centre) * (1.0 - margin / hull.inradius);
    return inner;
}

struct OrientedExtents {
    glm::dvec3 centre{0.0}; // midpoint of the extents
    glm::dmat3 axes{1.0};   // principal axes of the points' covariance
    glm::dvec3 half{0.0};   // half extents along the axes
};

OrientedExtents oriented_extents(const std::vector<glm::dvec3>& points) {
    OrientedExtents extents;
    if (points.empty()) return extents;
    glm::dvec3 mean(0.0);
    for (const glm::dvec3& point : points) mean += point / static_cast<double>(points.size());
    glm::dmat3 covariance(0.0);
    for (const glm::dvec3& point : points) covariance += glm::outerProduct(point - mean, point - mean);
    extents.axes = fracture::principal_axes(covariance).axes;
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
    for (const glm::dvec3& point : points) {
        const glm::dvec3 local = glm::transpose(extents.axes) * (point - mean);
        low = glm::min(low, local);
        high = glm::max(high, local);
    }
    extents.centre = mean + extents.axes * ((low + high) * 0.5);
    extents.half = (high - low) * 0.5;
    return extents;
}

CrossSection section_of(const OrientedExtents& extents) {
    return section_of_box(extents.half, {extents.axes[0], extents.axes[1], extents.axes[2]});
}

// Unit directions in the axes of the points, as structure of arrays in single precision for vectorised loops.
struct Directions {
    static constexpr size_t count = 2 * even_directions;
    std::array<float, count> x, y, z;
};

// The first half covers the sphere evenly (a spiral of equal areas). The second half is even once the piece is scaled
// to a cube: for a plate it concentrates around the normal, where a missing corner would tilt it.
Directions directions_for(const OrientedExtents& extents) {
    static const std::array<glm::dvec3, even_directions> even = [] {
        std::array<glm::dvec3, even_directions> sphere;
        for (size_t i = 0; i < even_directions; ++i) {
            const double y = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(even_directions);
            const double angle = golden_angle * static_cast<double>(i), around = std::sqrt(1.0 - y * y);
            sphere[i] = {around * std::cos(angle), y, around * std::sin(angle)};
        }
        return sphere;
    }();
    Directions directions;
    for (size_t i = 0; i < Directions::count; ++i) {
        const glm::dvec3& direction = even[i % even_directions];
        const glm::vec3 unit(i < even_directions ? direction
                                                 : glm::normalize(extents.axes * (direction / extents.half)));
        directions.x[i] = unit.x;
        directions.y[i] = unit.y;
        directions.z[i] = unit.z;
    }
    return directions;
}

// By direction: the largest coordinate of points, and the first point that has it.
struct Supports {
    std::array<float, Directions::count> reach;
    std::array<uint32_t, Directions::count> point;
};

BRITTLE_SIMD void find_supports(const glm::dvec3* points, uint32_t count, const Directions& directions,
                                Supports& supports) {
    for (uint32_t i = 0; i < count; ++i) {
        const auto x = static_cast<float>(points[i].x);
        const auto y = static_cast<float>(points[i].y);
        const auto z = static_cast<float>(points[i].z);
        for (size_t d = 0; d < Directions::count; ++d) {
            const float value = directions.x[d] * x + directions.y[d] * y + directions.z[d] * z;
            const bool farther = value > supports.reach[d];
            supports.point[d] = farther ? i : supports.point[d];
            supports.reach[d] = farther ? value : supports.reach[d];
        }
    }
}

// Returns the first direction in which the second supports fall short the most; nothing where they reach as far in all.
BRITTLE_SIMD std::optional<size_t> widest_gap(const Supports& full, const Supports& chosen) {
    constexpr size_t lanes = 16;
    static_assert(Directions::count % lanes == 0);
    std::array<float, lanes> widest{};
    for (size_t d = 0; d < Directions::count; d += lanes) {
        for (size_t k = 0; k < lanes; ++k) {
            const float gap = full.reach[d + k] - chosen.reach[d + k];
            widest[k] = gap > widest[k] ? gap : widest[k];
        }
    }
    const float most = *std::ranges::max_element(widest);
    if (!(most > 0.0f)) return std::nullopt;
    size_t d = 0;
    while (full.reach[d] - chosen.reach[d] != most) ++d;
    return d;
}

// Returns at most `count` points whose hull is close to that of all points. Each is the point farthest outside the
// hull of the points before it, over all directions: the depth at which it would penetrate a floor under that hull.
std::vector<glm::dvec3> supporting_subset(const std::vector<glm::dvec3>& points, const Directions& directions,
                                          size_t count) {
    if (points.size() <= count) return points;
    Supports full, chosen_supports;
    full.reach.fill(-std::numeric_limits<float>::infinity());
    full.point.fill(0);
    chosen_supports = full;
    find_supports(points.data(), static_cast<uint32_t>(points.size()), directions, full);
    std::vector<glm::dvec3> chosen;
    while (chosen.size() < count) {
        const std::optional<size_t> worst = widest_gap(full, chosen_supports);
        if (!worst) break;
        chosen.push_back(points[full.point[*worst]]);
        find_supports(&chosen.back(), 1, directions, chosen_supports);
    }
    return chosen;
}

// For flakes, needles and points: each thin axis gets a thickness, half of which is margin; the other axes keep their
// outline.
CollisionHull flat_hull(const std::vector<glm::dvec3>& points, const OrientedExtents& extents, size_t max_vertices) {
    const double longest = std::max({extents.half.x, extents.half.y, extents.half.z});
    const double thickness = longest > 0.0 ? 2.0 * longest * flat_half_thickness : point_half_thickness;
    glm::dmat3 flatten(0.0); // projection onto the axes that are not thin
    std::vector<glm::dvec3> offsets{glm::dvec3(0.0)};
    const double thinnest = std::min({extents.half.x, extents.half.y, extents.half.z});
    for (int axis = 0; axis < 3; ++axis) {
        if (extents.half[axis] > longest * flat_ratio && extents.half[axis] > thinnest) {
            flatten += glm::outerProduct(extents.axes[axis], extents.axes[axis]);
            continue;
        }
        const glm::dvec3 side = extents.axes[axis] * (thickness * 0.5);
        for (size_t i = offsets.size(); i-- > 0;) {
            offsets.push_back(offsets[i] - side);
            offsets[i] += side;
        }
    }
    std::vector<glm::dvec3> outline;
    for (const glm::dvec3& point : points)
        outline.push_back(flatten * (point - extents.centre) * (1.0 - 2.0 * flat_half_thickness));
    if (outline.empty()) outline.push_back(glm::dvec3(0.0));
    outline = farthest_point_subset(outline, std::max<size_t>(max_vertices / offsets.size(), 1));

    CollisionHull hull;
    hull.margin = static_cast<float>(thickness * 0.5);
    OrientedExtents thick = extents;
    thick.half = glm::max(thick.half, glm::dvec3(thickness * 0.5));
    hull.section = section_of(thick);
    for (const glm::dvec3& point : outline)
        for (const glm::dvec3& offset : offsets) hull.points.push_back(glm::vec3(extents.centre + point + offset));
    hull.faces = hull_faces(hull.points);
    return hull;
}

// A face as the hull computer returns it.
struct RawFace {
    std::vector<uint16_t> corners; // indices of points, once around
    glm::dvec3 area{0.0};          // m^2, outwards
};

// Returns the corners of the convex polygon that points span in a plane, counter-clockwise seen against the normal
// (monotone chain; A. Andrew, "Another efficient algorithm for convex hulls in two dimensions", 1979).
std::vector<uint16_t> outline_of(std::span<const glm::vec3> points, std::vector<uint16_t> corners,
                                 const glm::dvec3& normal) {
    const glm::dvec3 helper = std::abs(normal.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 u = glm::normalize(glm::cross(helper, normal)), v = glm::cross(normal, u);
    const auto flat = [&](uint16_t i) {
        const glm::dvec3 p(points[i]);
        return glm::dvec2(glm::dot(u, p), glm::dot(v, p));
    };
    std::ranges::sort(corners);
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    std::ranges::stable_sort(corners, [&](uint16_t a, uint16_t b) {
        const glm::dvec2 p = flat(a), q = flat(b);
        return p.x < q.x || (p.x == q.x && p.y < q.y);
    });
    std::vector<uint16_t> loop;
    const auto add = [&](uint16_t corner, size_t from) {
        const auto turns_left = [&] {
            const glm::dvec2 a = flat(loop[loop.size() - 2]), b = flat(loop.back()), c = flat(corner);
            const glm::dvec2 first = b - a, second = c - b;
            const double cross = first.x * second.y - first.y * second.x;
            return cross > 1e-4 * std::sqrt(glm::dot(first, first) * glm::dot(second, second));
        };
        while (loop.size() >= from + 2 && !turns_left()) loop.pop_back();
        loop.push_back(corner);
    };
    for (const uint16_t corner : corners) add(corner, 0);
    const size_t lower = loop.size() - 1;
    for (size_t i = corners.size() - 1; i-- > 0;) add(corners[i], lower);
    loop.pop_back();
    return loop;
}

} // namespace

HullFaces hull_faces(std::span<const glm::vec3> points) {
    HullFaces faces;
    if (points.size() < 4 || points.size() > UINT16_MAX) return faces;
    btConvexHullComputer computer;
    computer.compute(&points[0].x, static_cast<int>(sizeof(glm::vec3)), static_cast<int>(points.size()), 0.0f, 0.0f);
    if (computer.vertices.size() < 4 || computer.faces.size() < 4) return faces;
    const auto index_of = [&](int vertex) { return static_cast<uint16_t>(computer.original_vertex_index[vertex]); };
    std::vector<RawFace> raw(static_cast<size_t>(computer.faces.size()));
    std::vector<glm::dvec3> used; // vertices
    glm::dvec3 low(points[0]), high = low, middle(0.0);
    for (int vertex = 0; vertex < computer.vertices.size(); ++vertex) {
        const glm::dvec3 p(points[index_of(vertex)]);
        used.push_back(p);
        low = glm::min(low, p);
        high = glm::max(high, p);
        middle += p / static_cast<double>(computer.vertices.size());
    }
    for (size_t i = 0; i < raw.size(); ++i) {
        const btConvexHullComputer::Edge* const first = &computer.edges[computer.faces[static_cast<int>(i)]];
        const btConvexHullComputer::Edge* edge = first;
        do {
            raw[i].corners.push_back(index_of(edge->getSourceVertex()));
            edge = edge->getNextEdgeOfFace();
        } while (edge != first);
        const glm::dvec3 apex(points[raw[i].corners[0]]);
        for (size_t k = 2; k < raw[i].corners.size(); ++k)
            raw[i].area += 0.5
                           * glm::cross(glm::dvec3(points[raw[i].corners[k - 1]]) - apex,
                                        glm::dvec3(points[raw[i].corners[k]]) - apex);
        if (glm::dot(raw[i].area, apex - middle) < 0.0) raw[i].area = -raw[i].area; // the computer's winding varies
    }
    std::ranges::stable_sort(
        raw, [](const RawFace& a, const RawFace& b) { return glm::dot(a.area, a.area) > glm::dot(b.area, b.area); });
    const double tolerance = same_plane * std::max({high.x - low.x, high.y - low.y, high.z - low.z});
    std::vector<uint8_t> taken(raw.size(), 0);
    for (size_t i = 0; i < raw.size(); ++i) {
        const double length = glm::length(raw[i].area);
        if (taken[i] || !(length > 0.0)) continue;
        const glm::dvec3 normal = raw[i].area / length;
        const double distance = glm::dot(normal, glm::dvec3(points[raw[i].corners[0]]));
        // A sliver between nearly straight corners: the computer's grid tilts its plane into the hull.
        if (std::ranges::any_of(used, [&](const glm::dvec3& p) { return glm::dot(normal, p) > distance + tolerance; }))
            continue;
        std::vector<uint16_t> corners = raw[i].corners;
        for (size_t k = i + 1; k < raw.size(); ++k) {
            if (taken[k] || glm::dot(raw[k].area, normal) < same_face * glm::length(raw[k].area)) continue;
            if (std::ranges::any_of(raw[k].corners, [&](uint16_t corner) {
                    return std::abs(glm::dot(normal, glm::dvec3(points[corner])) - distance) > tolerance;
                }))
                continue;
            taken[k] = 1;
            corners.insert(corners.end(), raw[k].corners.begin(), raw[k].corners.end());
        }
        const std::vector<uint16_t> loop = outline_of(points, std::move(corners), normal);
        if (loop.size() < 3) continue;
        faces.corners.insert(faces.corners.end(), loop.begin(), loop.end());
        faces.ends.push_back(static_cast<uint16_t>(faces.corners.size()));
    }
    return faces;
}

CollisionHull collision_hull(std::span<const glm::dvec3> points, glm::dvec3 origin, const HullSettings& settings) {
    const std::vector<glm::dvec3> local = finite_points(points, origin);
    const OrientedExtents extents = oriented_extents(local);
    const double longest = std::max({extents.half.x, extents.half.y, extents.half.z});
    const double thinnest = std::min({extents.half.x, extents.half.y, extents.half.z});
    const bool crumb = 2.0 * longest < settings.crumb_size;
    const size_t max_vertices =
        std::max<size_t>(crumb ? std::min(settings.max_vertices, settings.crumb_vertices) : settings.max_vertices, 8);
    if (thinnest <= longest * flat_ratio) return flat_hull(local, extents, max_vertices);
    // The exact hull gets few points: at 700 points it costs two milliseconds, and offsetting its planes as much again.
    const Directions directions = directions_for(extents);
    std::vector<glm::dvec3> chosen = supporting_subset(local, directions, max_vertices);
    const std::vector<HullPlane> planes = cutting_planes(chosen, origin, settings.planes, 2.0 * longest);
    if (!planes.empty()) chosen = cut_points(chosen, planes);
    if (chosen.size() < 4) return flat_hull(local, extents, max_vertices);
    const std::optional<FullHull> full = full_hull(supporting_subset(chosen, directions, max_vertices));
    if (!full || full->inradius <= longest * flat_ratio * 0.1) return flat_hull(local, extents, max_vertices);

    const double fraction = std::clamp<double>(settings.margin_fraction, min_fraction, max_fraction);
    const double margin = std::min(std::max<double>(settings.max_margin, 1e-6), 2.0 * fraction * full->inradius);
    std::optional<InnerHull> inner = offset_hull(*full, margin);
    if (!inner) inner = scaled_hull(*full, margin);

    CollisionHull hull;
    hull.margin = static_cast<float>(inner->margin);
    hull.section = full->section;
    for (const glm::dvec3& vertex : supporting_subset(inner->vertices, directions, max_vertices))
        hull.points.push_back(glm::vec3(vertex));
    hull.faces = hull_faces(hull.points);
    return hull;
}

CollisionHull turned(const CollisionHull& hull, const glm::dquat& turn) {
    assert(!hull.facet);
    CollisionHull result = hull;
    for (glm::vec3& point : result.points) point = glm::vec3(turn * glm::dvec3(point));
    for (glm::vec3& side : result.section.sides) side = glm::vec3(turn * glm::dvec3(side));
    return result;
}

std::optional<CollisionHull> cut_hull(const CollisionHull& hull, const HullPlane& plane, const HullSettings& settings) {
    const auto margin = static_cast<double>(hull.margin);
    std::vector<glm::dvec3> points(hull.points.begin(), hull.points.end());
    if (points.size() < 4) return std::nullopt;
    points = cut_points(points, std::array{HullPlane{plane.normal, plane.distance - margin}});
    const OrientedExtents extents = oriented_extents(points);
    const double longest = std::max({extents.half.x, extents.half.y, extents.half.z});
    const double thinnest = std::min({extents.half.x, extents.half.y, extents.half.z});
    if (points.size() < 4 || thinnest <= longest * flat_ratio) return std::nullopt;
    const size_t max_vertices = std::max<size_t>(settings.max_vertices, 8);
    const std::optional<FullHull> full = full_hull(supporting_subset(points, directions_for(extents), max_vertices));
    if (!full || full->inradius <= longest * flat_ratio * 0.1) return std::nullopt;
    CollisionHull cut;
    cut.margin = hull.margin;
    for (const glm::dvec3& vertex : full->vertices) cut.points.push_back(glm::vec3(vertex));
    cut.faces = hull_faces(cut.points);
    cut.section = full->section;
    const double grown =
        1.0 + margin / full->inradius; // the margin's shell lies inside of a hull that is so much larger
    for (glm::vec3& side : cut.section.sides) side *= static_cast<float>(grown * grown);
    return cut;
}

std::vector<std::vector<HullPlane>> contact_planes(const fracture::Fragments& fragments) {
    std::vector<std::vector<HullPlane>> planes(fragments.pieces.size());
    for (const fracture::Bond& bond : fragments.bonds) {
        // A bond to a missing piece, or without area, holds nothing: it is broken from the start.
        if (bond.a >= planes.size() || bond.b >= planes.size() || !(bond.area > 0.0)) continue;
        const double distance = glm::dot(bond.normal, bond.centroid);
        planes[bond.a].push_back({bond.normal, distance});
        planes[bond.b].push_back({-bond.normal, -distance});
    }
    return planes;
}

PieceHulls collision_hulls(const fracture::Fragments& fragments, const HullSettings& settings, uint32_t threads) {
    PieceHulls hulls(fragments.pieces.size());
    const std::vector<std::vector<HullPlane>> planes = contact_planes(fragments);
    fracture::Threads pool(threads);
    pool.for_chunks(static_cast<uint32_t>(hulls.size()), 4, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t i = begin; i < end; ++i) {
            const fracture::Piece& piece = fragments.pieces[i];
            HullSettings own = settings;
            own.planes = planes[i];
            hulls[i] = std::make_shared<const CollisionHull>(
                collision_hull(fragments.positions_of(piece), piece.mass.centre_of_mass, own));
        }
    });
    return hulls;
}

std::vector<HullPlane> face_planes(const CollisionHull& hull, double beyond, const glm::dvec3& offset) {
    std::vector<HullPlane> planes;
    const HullFaces faces = hull.faces.count() > 0 ? hull.faces : hull_faces(hull.points);
    for (size_t f = 0; f < faces.count(); ++f) {
        const auto loop = faces.of(f);
        const glm::dvec3 apex(hull.points[loop[0]]);
        glm::dvec3 area(0.0);
        for (size_t k = 2; k < loop.size(); ++k)
            area += glm::cross(glm::dvec3(hull.points[loop[k - 1]]) - apex, glm::dvec3(hull.points[loop[k]]) - apex);
        if (!(glm::length(area) > 0.0)) continue;
        const glm::dvec3 normal = glm::normalize(area);
        planes.push_back({normal, glm::dot(normal, apex + offset) + beyond});
    }
    return planes;
}

CrossSection cross_section(std::span<const glm::vec3> points) {
    const std::vector<glm::dvec3> exact(points.begin(), points.end());
    if (exact.size() >= 4)
        if (const std::optional<FullHull> full = full_hull(exact)) return full->section;
    return section_of(oriented_extents(exact));
}

std::vector<HullEdge> hull_edges(std::span<const glm::vec3> points) {
    std::vector<HullEdge> edges;
    if (points.empty()) return edges;
    btConvexHullComputer computer;
    computer.compute(&points[0].x, static_cast<int>(sizeof(glm::vec3)), static_cast<int>(points.size()), 0.0f, 0.0f);
    const auto index_of = [&](int vertex) { return static_cast<uint32_t>(computer.original_vertex_index[vertex]); };
    // Returns the area vector of the face to the left of an edge; faces are planar polygons.
    const auto normal_of = [&](const btConvexHullComputer::Edge* first) {
        const glm::dvec3 apex(points[index_of(first->getSourceVertex())]);
        glm::dvec3 area(0.0);
        for (const auto* edge = first->getNextEdgeOfFace(); edge != first; edge = edge->getNextEdgeOfFace())
            area += glm::cross(glm::dvec3(points[index_of(edge->getSourceVertex())]) - apex,
                               glm::dvec3(points[index_of(edge->getTargetVertex())]) - apex);
        return area;
    };
    for (int i = 0; i < computer.edges.size(); ++i) {
        const btConvexHullComputer::Edge* edge = &computer.edges[i];
        const HullEdge ends(index_of(edge->getSourceVertex()), index_of(edge->getTargetVertex()));
        if (ends.first > ends.second) continue;
        const glm::dvec3 left = normal_of(edge), right = normal_of(edge->getReverseEdge());
        if (glm::dot(left, right) < same_face * glm::length(left) * glm::length(right)) edges.push_back(ends);
    }
    return edges;
}

} // namespace brittle::physics

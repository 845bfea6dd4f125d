#include "physics/solver/face_contact.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace brittle::physics {

namespace {

// Cosine of two degrees: the direction between nearest points of parallel faces is exact to a tenth of that.
constexpr float same_direction = 0.9994f;
// Cosine of 80 degrees: beyond it the height of a face over the plane across the normal is inexact.
constexpr float min_cosine = 0.17f;
// Marks the edges of the second face in a feature.
constexpr uint32_t of_second = 0x8000;

// A corner of the polygon that is clipped, in the plane across the normal. `height` is along the normal, on the first
// face. Edges are named by the place of their first corner among all corners of the hull's faces.
struct Corner {
    glm::vec2 at;
    float height;
    uint32_t edge_in, edge_out;
};

// The plane of a face as a height over the plane across the normal.
struct Slope {
    glm::vec2 gradient;
    float height;
    [[nodiscard]] float at(const glm::vec2& p) const { return height + gradient.x * p.x + gradient.y * p.y; }
};

float cross(const glm::vec2& a, const glm::vec2& b) {
    return a.x * b.y - a.y * b.x;
}

struct Plane2 {
    Tangents axes;
    glm::vec3 normal;

    [[nodiscard]] glm::vec2 flat(const glm::vec3& p) const {
        return {glm::dot(axes.first, p), glm::dot(axes.second, p)};
    }
    [[nodiscard]] glm::vec3 point(const glm::vec2& p, float height) const {
        return axes.first * p.x + axes.second * p.y + normal * height;
    }
    [[nodiscard]] Slope slope(const glm::vec3& face_normal, const glm::vec3& on_face) const {
        const float along = glm::dot(face_normal, normal);
        const glm::vec2 gradient = flat(face_normal) * (-1.0f / along);
        const glm::vec2 at = flat(on_face);
        return {gradient, glm::dot(normal, on_face) - gradient.x * at.x - gradient.y * at.y};
    }
};

} // namespace

FacingFaces facing_faces(const HullShape& first, const HullShape& second, const Transform& second_in_first,
                         const glm::vec3& direction) {
    FacingFaces faces{first.face_along(-direction), second.face_along(direction * second_in_first.basis), direction};
    if (faces.first < 0 || faces.second < 0) return faces;
    const glm::vec3 of_first = -first.normal_of(faces.first);
    const glm::vec3 of_second_face = second_in_first.basis * second.normal_of(faces.second);
    const float first_cosine = glm::dot(of_first, direction), second_cosine = glm::dot(of_second_face, direction);
    if (std::max(first_cosine, second_cosine) < same_direction) return faces;
    faces.normal = first_cosine >= second_cosine ? of_first : of_second_face;
    return faces;
}

void clip_faces(const HullShape& first, const HullShape& second, const Transform& second_in_first,
                const FacingFaces& faces, float tolerance, std::vector<FacePoint>& points) {
    points.clear();
    if (faces.first < 0 || faces.second < 0) return;
    const glm::vec3 first_normal = first.normal_of(faces.first);
    const glm::vec3 second_normal = second_in_first.basis * second.normal_of(faces.second);
    if (glm::dot(first_normal, faces.normal) > -min_cosine || glm::dot(second_normal, faces.normal) < min_cosine)
        return;
    const Plane2 plane{tangents_of(faces.normal), faces.normal};
    const std::span<const uint16_t> first_loop = first.corners_of(faces.first);
    const std::span<const uint16_t> second_loop = second.corners_of(faces.second);

    // The first face, reversed: it looks against the normal, so its loop runs clockwise in the plane.
    thread_local std::vector<Corner> polygon, clipped;
    thread_local std::vector<glm::vec2> bounds;
    polygon.clear();
    const uint32_t first_edge = first.first_corner_of(faces.first);
    const auto first_count = static_cast<uint32_t>(first_loop.size());
    for (uint32_t i = first_count; i-- > 0;) {
        const glm::vec3& p = first.points()[first_loop[i]];
        const uint32_t out = (i + first_count - 1) % first_count;
        polygon.push_back({plane.flat(p), glm::dot(faces.normal, p), first_edge + i, first_edge + out});
    }
    bounds.clear();
    for (const uint16_t corner : second_loop) bounds.push_back(plane.flat(second_in_first * second.points()[corner]));
    const uint32_t second_edge = of_second | second.first_corner_of(faces.second);
    for (size_t edge = 0; edge < bounds.size() && !polygon.empty(); ++edge) {
        const glm::vec2 from = bounds[edge], along = bounds[(edge + 1) % bounds.size()] - from;
        const float length = std::sqrt(glm::dot(along, along));
        if (!(length > 0.0f)) continue;
        const auto inside = [&](const Corner& corner) { return cross(along, corner.at - from) / length; };
        clipped.clear();
        const uint32_t name = second_edge + static_cast<uint32_t>(edge);
        float depth = inside(polygon.back());
        for (size_t i = 0; i < polygon.size(); ++i) {
            const Corner &before = polygon[(i + polygon.size() - 1) % polygon.size()], &corner = polygon[i];
            const float own = inside(corner);
            const bool was_in = depth >= -tolerance, is_in = own >= -tolerance;
            if (was_in != is_in) {
                const float part = std::clamp(depth / (depth - own), 0.0f, 1.0f);
                Corner crossing{before.at + (corner.at - before.at) * part,
                                before.height + (corner.height - before.height) * part, corner.edge_in, name};
                if (is_in) {
                    crossing.edge_in = name;
                    crossing.edge_out = corner.edge_in;
                }
                clipped.push_back(crossing);
            }
            if (is_in) clipped.push_back(corner);
            depth = own;
        }
        polygon.swap(clipped);
    }
    const Slope second_slope = plane.slope(second_normal, second_in_first * second.points()[second_loop[0]]);
    for (const Corner& corner : polygon) {
        const float height = second_slope.at(corner.at);
        points.push_back({plane.point(corner.at, corner.height), plane.point(corner.at, height), corner.height - height,
                          (corner.edge_in << 16) | corner.edge_out});
    }
}

} // namespace brittle::physics

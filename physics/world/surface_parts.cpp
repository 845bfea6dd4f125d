#include "physics/world/surface_parts.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "fracture/mesh/thickness.h"
#include "physics/world/hull.h"

namespace brittle::physics {

namespace {

using fracture::no_index;
using fracture::Triangle;

// Share of a facet's extent by which a corner may lie outside the plane of the facet, or a side bend outwards.
constexpr double flatness = 1e-5;
// Where the thickness under a corner is measured: this share of the way from the corner to the middle of the facet.
constexpr double from_corner = 0.05;

uint64_t edge_key(uint32_t from, uint32_t to) {
    return uint64_t{from} << 32 | to;
}

// Joins triangles to facets, each a loop of vertices, counter-clockwise seen from outside.
class Facets {
  public:
    Facets(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles, uint32_t max_corners)
        : positions_(positions), triangles_(triangles), max_corners_(max_corners), taken_(triangles.size()) {
        for (uint32_t t = 0; t < triangles.size(); ++t)
            for (int c = 0; c < 3; ++c) owner_.try_emplace(edge_key(triangles[t][c], triangles[t][(c + 1) % 3]), t);
    }

    // The facet that grows from a triangle; empty for a triangle that is taken or has no area.
    std::vector<uint32_t> grow(uint32_t first) {
        if (taken_[first]) return {};
        taken_[first] = true;
        const Triangle& seed = triangles_[first];
        normal_ = normal_of(first);
        if (normal_ == glm::dvec3(0.0)) return {};
        std::vector<uint32_t> loop{seed[0], seed[1], seed[2]};
        for (bool grown = true; grown;) {
            grown = false;
            for (size_t side = 0; side < loop.size() && loop.size() < max_corners_; ++side) grown |= take(loop, side);
        }
        return loop;
    }
    [[nodiscard]] const glm::dvec3& normal() const { return normal_; } // of the facet that grew last

    // The sides of the facet that grew last, with the facets beyond.
    [[nodiscard]] std::vector<SurfaceFacet::Side> sides_of(const std::vector<uint32_t>& loop) const {
        std::vector<SurfaceFacet::Side> sides;
        for (size_t side = 0; side < loop.size(); ++side) {
            const uint32_t from = loop[side], to = loop[(side + 1) % loop.size()];
            const auto beyond = owner_.find(edge_key(to, from));
            if (beyond == owner_.end()) continue;
            const glm::dvec3 other = normal_of(beyond->second);
            const glm::dvec3 outward = glm::cross(positions_[to] - positions_[from], normal_);
            if (other == glm::dvec3(0.0) || outward == glm::dvec3(0.0)) continue;
            const glm::dvec2 turned(glm::dot(other, normal_), glm::dot(other, glm::normalize(outward)));
            const glm::dvec2 angle = turned.y > 0.0 ? glm::normalize(turned) : glm::dvec2(1.0, 0.0); // else a valley
            sides.push_back({glm::normalize(outward), static_cast<float>(angle.x), static_cast<float>(angle.y)});
        }
        return sides;
    }

  private:
    // Unit; zero for a triangle without area.
    [[nodiscard]] glm::dvec3 normal_of(uint32_t triangle) const {
        const Triangle& t = triangles_[triangle];
        const glm::dvec3 across = glm::cross(positions_[t[1]] - positions_[t[0]], positions_[t[2]] - positions_[t[0]]);
        const double length = glm::length(across);
        return length > 0.0 ? across / length : glm::dvec3(0.0);
    }

    // Adds the triangle across a side of the loop, if it lies in the plane and leaves the loop convex.
    bool take(std::vector<uint32_t>& loop, size_t side) {
        const uint32_t from = loop[side], to = loop[(side + 1) % loop.size()];
        const auto found = owner_.find(edge_key(to, from));
        if (found == owner_.end() || taken_[found->second]) return false;
        const Triangle& t = triangles_[found->second];
        const uint32_t apex = t[0] != from && t[0] != to ? t[0] : t[1] != from && t[1] != to ? t[1] : t[2];
        if (std::ranges::find(loop, apex) != loop.end()) return false;
        const glm::dvec3& p = positions_[apex];
        const double length = glm::length(positions_[to] - positions_[from]);
        if (std::abs(glm::dot(p - positions_[from], normal_)) > flatness * length) return false;
        const uint32_t before = loop[(side + loop.size() - 1) % loop.size()], after = loop[(side + 2) % loop.size()];
        if (!turns_left(before, from, apex) || !turns_left(apex, to, after) || !turns_left(from, apex, to))
            return false;
        loop.insert(loop.begin() + static_cast<ptrdiff_t>(side) + 1, apex);
        taken_[found->second] = true;
        return true;
    }
    [[nodiscard]] bool turns_left(uint32_t a, uint32_t b, uint32_t c) const {
        const glm::dvec3 in = positions_[b] - positions_[a], out = positions_[c] - positions_[b];
        return glm::dot(glm::cross(in, out), normal_) >= -flatness * glm::length(in) * glm::length(out);
    }

    std::span<const glm::dvec3> positions_;
    std::span<const Triangle> triangles_;
    uint32_t max_corners_;
    std::vector<bool> taken_;
    std::unordered_map<uint64_t, uint32_t> owner_; // by directed edge; never iterated
    glm::dvec3 normal_{0.0};
};

// The faces of a slab whose first points are the loop of its top, and whose others lie below them.
HullFaces slab_faces(uint16_t corners) {
    HullFaces faces;
    const auto add = [&](std::initializer_list<int> of) {
        for (const int corner : of) faces.corners.push_back(static_cast<uint16_t>(corner));
    };
    const auto end = [&] { faces.ends.push_back(static_cast<uint16_t>(faces.corners.size())); };
    for (int c = 0; c < corners; ++c) add({c});
    end();
    for (int c = corners; c-- > 0;) add({corners + c});
    end();
    for (int c = 0; c < corners; ++c) {
        const int next = (c + 1) % corners;
        add({c, corners + c, corners + next, next});
        end();
    }
    return faces;
}

} // namespace

glm::vec3 SurfaceFacet::limit(glm::vec3 direction) const {
    if (glm::dot(direction, normal) < 0.0f) direction -= normal * glm::dot(direction, normal);
    for (const Side& side : sides) {
        const float up = glm::dot(direction, normal), out = glm::dot(direction, side.outward);
        if (!(out * side.cosine > up * side.sine)) continue; // within the angle
        const float length = std::sqrt(up * up + out * out);
        direction += normal * (length * side.cosine - up) + side.outward * (length * side.sine - out);
    }
    const float length = glm::length(direction);
    return length > 0.0f ? direction / length : normal;
}

std::vector<BodyPart> surface_parts(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles,
                                    const glm::dvec3& origin, const SurfacePartSettings& settings) {
    const fracture::TriangleMesh mesh{{positions.begin(), positions.end()}, {triangles.begin(), triangles.end()}};
    const fracture::Thickness thickness(mesh);
    Facets facets(positions, triangles, settings.max_corners);
    std::vector<BodyPart> parts;
    for (uint32_t t = 0; t < triangles.size(); ++t) {
        const std::vector<uint32_t> loop = facets.grow(t);
        if (loop.empty()) continue;
        glm::dvec3 middle(0.0);
        for (const uint32_t v : loop) middle += positions[v] / static_cast<double>(loop.size());
        double depth = settings.max_depth;
        const auto measure = [&](const glm::dvec3& at) {
            if (const std::optional<double> through = thickness.at(t, at)) depth = std::min(depth, 0.5 * *through);
        };
        measure(middle);
        for (const uint32_t v : loop) measure(positions[v] + from_corner * (middle - positions[v]));
        depth = std::max(depth, settings.min_depth);
        const glm::dvec3 inwards = -facets.normal();
        CollisionHull hull{.margin = static_cast<float>(settings.margin)};
        for (const double down : {settings.margin, depth})
            for (const uint32_t v : loop) hull.points.emplace_back(positions[v] + down * inwards - middle);
        hull.facet = std::make_shared<const SurfaceFacet>(
            SurfaceFacet{facets.normal(), static_cast<float>(depth), facets.sides_of(loop)});
        hull.faces = slab_faces(static_cast<uint16_t>(loop.size()));
        parts.push_back({std::make_shared<const CollisionHull>(std::move(hull)), glm::vec3(middle - origin)});
    }
    return parts;
}

} // namespace brittle::physics

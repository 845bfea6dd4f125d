#include "physics/bonds/bond_shares.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "fracture/sites/layout.h"
#include "physics/world/hull.h"

namespace brittle::physics {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr int grid = 20; // points along each side of the rectangle around a bond's area
// Distance of a hull from the plane of its bond, in square roots of the area: hulls leave out small corners.
constexpr double tolerance_share = 0.03;

// The hulls of a piece or part as half-spaces, their margins included.
class Hulls {
  public:
    explicit Hulls(const PlacedHulls& placed) : placed_(placed) {
        for (const BodyPart& part : placed.hulls) {
            const auto margin = static_cast<double>(part.hull->margin);
            hulls_.push_back(face_planes(*part.hull, margin, placed.centre + glm::dvec3(part.offset)));
            for (const glm::vec3& point : part.hull->points)
                radius_ = std::max(radius_, glm::length(glm::dvec3(part.offset) + glm::dvec3(point)) + margin);
        }
    }

    // The distance to the farthest plane of the nearest hull; at most 0 inside it. May be infinity where the hulls are
    // farther away than `limit`.
    [[nodiscard]] double height(const glm::dvec3& point, double limit = infinity) const {
        if (glm::distance(point, placed_.centre) - radius_ > limit) return infinity;
        double nearest = infinity;
        for (const std::vector<HullPlane>& hull : hulls_) {
            double farthest = hull.empty() ? infinity : -infinity;
            for (const HullPlane& plane : hull)
                farthest = std::max(farthest, glm::dot(plane.normal, point) - plane.distance);
            nearest = std::min(nearest, farthest);
        }
        return nearest;
    }

    // The bounds of the hulls along u and v of a frame at a point.
    void bounds(const glm::dvec3& from, const fracture::AxisFrame& frame, glm::dvec2& least, glm::dvec2& most) const {
        for (const BodyPart& part : placed_.hulls)
            for (const glm::vec3& point : part.hull->points) {
                const glm::dvec3 arm = placed_.centre + glm::dvec3(part.offset) + glm::dvec3(point) - from;
                const glm::dvec2 at(glm::dot(arm, frame.u), glm::dot(arm, frame.v));
                least = glm::min(least, at - static_cast<double>(part.hull->margin));
                most = glm::max(most, at + static_cast<double>(part.hull->margin));
            }
    }

    [[nodiscard]] bool empty() const { return hulls_.empty(); }

  private:
    PlacedHulls placed_;
    std::vector<std::vector<HullPlane>> hulls_;
    double radius_ = 0.0; // m, around the centre
};

// Points all over the area of a bond.
std::vector<glm::dvec3> points_on(const BondGraph::Bond& bond, const Hulls& piece, const Hulls& other) {
    const fracture::AxisFrame frame = fracture::axis_frame(bond.normal);
    const double tolerance = tolerance_share * std::sqrt(bond.area), disc = std::sqrt(bond.area / std::numbers::pi);
    glm::dvec2 least(-infinity), most(infinity);
    for (const Hulls* side : {&piece, &other}) {
        if (side->empty()) continue;
        glm::dvec2 from(infinity), to(-infinity);
        side->bounds(bond.centroid, frame, from, to);
        least = glm::max(least, from);
        most = glm::min(most, to);
    }
    std::vector<glm::dvec3> points;
    for (int i = 0; i < grid; ++i)
        for (int j = 0; j < grid; ++j) {
            const glm::dvec2 at = glm::mix(least, most, (glm::dvec2(i, j) + 0.5) / static_cast<double>(grid));
            const glm::dvec3 point = bond.centroid + at.x * frame.u + at.y * frame.v;
            const bool on_other = other.empty() ? glm::length(at) <= disc : other.height(point) <= tolerance;
            if (on_other && piece.height(point) <= tolerance) points.push_back(point);
        }
    if (points.empty()) points.push_back(bond.centroid);
    return points;
}

size_t nearest_of(std::span<const Hulls> parts, const glm::dvec3& point) {
    size_t nearest = 0;
    double least = infinity;
    for (size_t k = 0; k < parts.size(); ++k)
        if (const double height = parts[k].height(point, least); height < least) {
            least = height;
            nearest = k;
        }
    return nearest;
}

} // namespace

std::vector<BondShare> share_bonds(const BondGraph& graph, uint32_t piece,
                                   const std::function<PlacedHulls(uint32_t piece)>& hulls_of,
                                   std::span<const PlacedHulls> parts) {
    assert(!parts.empty());
    const Hulls whole(hulls_of(piece));
    const std::vector<Hulls> made(parts.begin(), parts.end());
    std::vector<BondShare> shares;
    for (const uint32_t index : graph.bonds_of(piece)) {
        const BondGraph::Bond& bond = graph.bonds()[index];
        if (!bond.live()) continue;
        const std::vector<glm::dvec3> points = points_on(bond, whole, Hulls(hulls_of(bond.other(piece))));
        std::vector<size_t> counts(parts.size(), 0);
        std::vector<glm::dvec3> sums(parts.size(), glm::dvec3(0.0));
        glm::dvec3 mean(0.0);
        for (const glm::dvec3& point : points) {
            const size_t part = nearest_of(made, point);
            ++counts[part];
            sums[part] += point;
            mean += point / static_cast<double>(points.size());
        }
        for (uint32_t part = 0; part < parts.size(); ++part)
            if (counts[part] > 0) // the shift keeps the centroid of the whole
                shares.push_back({index, part, static_cast<double>(counts[part]) / static_cast<double>(points.size()),
                                  sums[part] / static_cast<double>(counts[part]) + (bond.centroid - mean)});
    }
    return shares;
}

} // namespace brittle::physics

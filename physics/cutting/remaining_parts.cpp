#include "physics/cutting/remaining_parts.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/local/cluster_queries.h"
#include "physics/cutting/polytope.h"

namespace brittle::physics {

namespace {

// How far a corner is moved towards the middle before it is tested to lie in the solid: corners of hulls lie on it.
constexpr double pull = 0.02;
// Vertices of the surface that are looked at in a part that sticks out of the solid.
constexpr uint32_t max_samples = 200;

Polytope clipped(Polytope polytope, std::span<const HullPlane> planes) {
    if (polytope.is_beyond_one_of(planes)) return {};
    polytope.cut(planes);
    return polytope;
}

double hull_volume(std::span<const glm::dvec3> points, const glm::dvec3& centre) {
    std::vector<glm::vec3> corners;
    for (const glm::dvec3& p : points) corners.emplace_back(p - centre);
    const fracture::TriangleMesh full = hull_mesh(corners);
    return fracture::signed_volume(full.positions, full.triangles);
}

// Points whose hull holds nearly what the solid has in a polytope.
class Content {
  public:
    Content(const fracture::ClusterMesh& surface, const Polytope& polytope)
        : surface_(surface), polytope_(polytope), middle_(polytope.centre()) {}

    std::vector<glm::dvec3> points() {
        bool sticks_out = false;
        for (size_t f = 0; f < polytope_.face_count(); ++f) {
            const std::span<const glm::dvec3> face = polytope_.face(f);
            std::vector<uint8_t> inside;
            for (const glm::dvec3& p : face) inside.push_back(holds(p) ? 1 : 0);
            for (size_t k = 0; k < face.size(); ++k) {
                const size_t next = (k + 1) % face.size();
                sticks_out = sticks_out || !inside[k];
                if (inside[k] && !inside[next]) {
                    const glm::dvec3 from = pulled(face[k]), to = pulled(face[next]);
                    if (const auto hit = fracture::first_hit(surface_, from, to))
                        points_.push_back(face[k] + *hit * (face[next] - face[k]));
                }
            }
        }
        for (const auto& [corner, inside] : known_)
            if (inside) points_.push_back(corner);
        if (sticks_out) add_vertices();
        return std::move(points_);
    }

  private:
    [[nodiscard]] glm::dvec3 pulled(const glm::dvec3& p) const { return p + pull * (middle_ - p); }

    [[nodiscard]] bool holds(const glm::dvec3& corner) {
        for (const auto& [p, inside] : known_)
            if (p == corner) return inside;
        known_.emplace_back(corner, fracture::is_inside(surface_, pulled(corner)));
        return known_.back().second;
    }

    void add_vertices() {
        const fracture::Box box = polytope_.box();
        uint32_t clusters = 0;
        surface_.visit(box, [&](const fracture::ClusterPtr&) { ++clusters; });
        const uint32_t stride = std::max(1u, clusters * fracture::Cluster::max_triangles / 2 / max_samples);
        std::vector<HullPlane> planes;
        for (size_t f = 0; f < polytope_.face_count(); ++f) {
            const std::span<const glm::dvec3> face = polytope_.face(f);
            const glm::dvec3 normal = glm::cross(face[1] - face[0], face[2] - face[0]);
            if (glm::length(normal) > 0.0)
                planes.push_back({glm::normalize(normal), glm::dot(glm::normalize(normal), face[0])});
        }
        uint32_t at = 0;
        surface_.visit(box, [&](const fracture::ClusterPtr& cluster) {
            for (; at < cluster->positions.size(); at += stride) {
                const glm::dvec3& p = cluster->positions[at];
                if (std::ranges::all_of(
                        planes, [&](const HullPlane& plane) { return glm::dot(plane.normal, p) <= plane.distance; }))
                    points_.push_back(p);
            }
            at -= static_cast<uint32_t>(cluster->positions.size());
        });
    }

    const fracture::ClusterMesh& surface_;
    const Polytope& polytope_;
    glm::dvec3 middle_;
    std::vector<std::pair<glm::dvec3, bool>> known_;
    std::vector<glm::dvec3> points_;
};

} // namespace

namespace {

enum class Holds { nothing, something, all };

// How much of a hull's corners, pulled inwards, lies in the solid.
Holds holds(const fracture::ClusterMesh& surface, const CollisionHull& hull, const glm::dvec3& place) {
    glm::dvec3 middle(0.0);
    for (const glm::vec3& p : hull.points) middle += glm::dvec3(p) / static_cast<double>(hull.points.size());
    const auto is_held = [&](const glm::vec3& p) {
        return fracture::is_inside(surface, place + glm::dvec3(p) + pull * (middle - glm::dvec3(p)));
    };
    const auto held = static_cast<size_t>(std::ranges::count_if(hull.points, is_held));
    return held == 0 ? Holds::nothing : held < hull.points.size() ? Holds::something : Holds::all;
}

} // namespace

std::vector<BodyPart> remaining_parts(const FormerParts& before, const fracture::ClusterMesh& surface,
                                      bool is_one_of_many, const LostCells& cells, double least,
                                      const glm::dvec3& origin, const HullSettings& settings) {
    std::vector<BodyPart> parts;
    const auto add_content = [&](const Polytope& polytope) {
        if (!(polytope.volume() > least)) return;
        const std::vector<glm::dvec3> points = Content(surface, polytope).points();
        if (points.size() < 4) return;
        const glm::dvec3 centre = polytope.centre();
        if (!(hull_volume(points, centre) > least)) return;
        parts.push_back({std::make_shared<const CollisionHull>(collision_hull(points, centre, settings)),
                         glm::vec3(centre - origin)});
    };
    for (const BodyPart& part : before.parts) {
        const glm::dvec3 place = before.origin + glm::dvec3(part.offset);
        const Polytope whole = Polytope::around(*part.hull, static_cast<double>(part.hull->margin), place);
        bool is_reached = false;
        for (uint32_t site = 0; site < cells.planes.size() && !is_reached; ++site)
            is_reached = cells.lost[site] && clipped(whole, cells.planes[site]).volume() > 0.0;
        if (is_reached) {
            for (uint32_t site = 0; site < cells.planes.size(); ++site)
                if (!cells.lost[site]) add_content(clipped(whole, cells.planes[site]));
            continue;
        }
        const Holds held = is_one_of_many ? holds(surface, *part.hull, place) : Holds::all;
        if (held == Holds::all)
            parts.push_back({part.hull, glm::vec3(place - origin)});
        else if (held == Holds::something)
            add_content(whole);
    }
    return parts;
}

} // namespace brittle::physics

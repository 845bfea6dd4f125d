#include "physics/cutting/remaining_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/local/cluster_queries.h"
#include "fracture/mesh/convex_hull.h"
#include "physics/cutting/job_threads.h"
#include "physics/cutting/polytope.h"

namespace brittle::physics {

namespace {

// How far a corner is moved towards the middle before it is tested to lie in the solid: corners of hulls lie on it.
constexpr double pull = 0.02;
// Vertices of the surface that are looked at in a part that sticks out of the solid.
constexpr uint32_t max_samples = 200;
// The least share of a hull that is split off in one part.
constexpr double min_side = 0.5;
// m. Cells that have a face in common touch its plane up to rounding.
constexpr double touching = 1e-9;

Polytope clipped(Polytope polytope, std::span<const HullPlane> planes) {
    if (polytope.is_beyond_one_of(planes)) return {};
    polytope.cut(planes);
    return polytope;
}

double hull_volume(std::span<const glm::dvec3> points, const glm::dvec3& centre) {
    std::vector<glm::vec3> corners;
    for (const glm::dvec3& p : points) corners.emplace_back(p - centre);
    const fracture::TriangleMesh hull = fracture::convex_hull(corners);
    return fracture::signed_volume(hull.positions, hull.triangles);
}

// The plane of a face; nothing for one without area.
std::optional<HullPlane> plane_of(std::span<const glm::dvec3> face) {
    glm::dvec3 area(0.0);
    for (size_t k = 2; k < face.size(); ++k) area += glm::cross(face[k - 1] - face[0], face[k] - face[0]);
    if (!(glm::length(area) > 0.0)) return std::nullopt;
    const glm::dvec3 normal = glm::normalize(area);
    return HullPlane{normal, glm::dot(normal, face[0])};
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
        for (size_t f = 0; f < polytope_.face_count(); ++f)
            if (const std::optional<HullPlane> plane = plane_of(polytope_.face(f))) planes.push_back(*plane);
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

// Divides what a polytope has outside of holes, which are convex and inside it, into parts whose hulls meet no hole: a
// part lies beyond a plane that has all holes behind it, or it is a group of cells of sites that stay, and for each hole
// there is a plane between it and all of the group.
class Division {
  public:
    explicit Division(const LostCells& cells) : cells_(cells) {
        // Across the faces of the crater: from a lost site towards a site that stays.
        for (size_t site = 0; site < cells.sites.size(); ++site) {
            if (cells.lost[site]) continue;
            double nearest = std::numeric_limits<double>::infinity();
            glm::dvec3 way(0.0);
            for (size_t other = 0; other < cells.sites.size(); ++other) {
                const glm::dvec3 apart = cells.sites[site] - cells.sites[other];
                if (!cells.lost[other] || !(glm::dot(apart, apart) < nearest)) continue;
                nearest = glm::dot(apart, apart);
                way = apart;
            }
            if (nearest > 0.0 && std::isfinite(nearest)) normals_.push_back(glm::normalize(way));
        }
    }

    // By part: the cells that it is made of.
    std::vector<std::vector<Polytope>> groups(const Polytope& whole, std::span<const Polytope> holes) const {
        std::vector<std::vector<Polytope>> parts;
        add_groups(cells_of(whole), holes, parts);
        return parts;
    }
    // The plane that has all holes behind it and the most of a polytope beyond it. Nothing where that is less than half.
    std::optional<HullPlane> side_of_most(const Polytope& whole, std::span<const Polytope> holes) const {
        double most = min_side * whole.volume();
        std::optional<HullPlane> plane;
        for (const glm::dvec3& normal : normals_) {
            double distance = -std::numeric_limits<double>::infinity();
            for (const Polytope& hole : holes) distance = std::max(distance, hole.support(normal));
            Polytope beyond = whole;
            beyond.cut({-normal, -distance});
            if (const double volume = beyond.volume(); volume > most) {
                most = volume;
                plane = {normal, distance};
            }
        }
        return plane;
    }
    // The cells of the sites that stay, in a polytope.
    std::vector<Polytope> cells_of(const Polytope& whole) const {
        std::vector<Polytope> cells;
        for (size_t site = 0; site < cells_.sites.size(); ++site) {
            if (cells_.lost[site]) continue;
            if (Polytope cell = clipped(whole, cells_.planes[site]); !cell.empty()) cells.push_back(std::move(cell));
        }
        return cells;
    }

  private:
    // By hole: a bit for each of its faces that has all of a cell on its far side.
    using Beyond = std::vector<uint64_t>;

    static Beyond faces_before(const Polytope& cell, std::span<const Polytope> holes) {
        Beyond beyond;
        for (const Polytope& hole : holes) {
            uint64_t bits = 0;
            for (size_t f = 0; f < std::min<size_t>(hole.face_count(), 64); ++f) {
                const std::optional<HullPlane> plane = plane_of(hole.face(f));
                if (plane && -cell.support(-plane->normal) >= plane->distance - touching) bits |= uint64_t{1} << f;
            }
            beyond.push_back(bits);
        }
        return beyond;
    }

    static void add_groups(std::vector<Polytope> cells, std::span<const Polytope> holes,
                           std::vector<std::vector<Polytope>>& parts) {
        std::ranges::stable_sort(cells, std::greater<>(), &Polytope::volume);
        std::vector<Beyond> beyond;
        for (const Polytope& cell : cells) beyond.push_back(faces_before(cell, holes));
        std::vector<uint8_t> taken(cells.size(), 0);
        for (size_t first = 0; first < cells.size(); ++first) {
            if (taken[first]) continue;
            std::vector<std::pair<double, size_t>> others; // the nearest first
            for (size_t k = first + 1; k < cells.size(); ++k)
                if (!taken[k]) others.emplace_back(glm::distance(cells[k].centre(), cells[first].centre()), k);
            std::ranges::sort(others);
            std::vector<Polytope>& group = parts.emplace_back();
            group.push_back(cells[first]);
            Beyond common = beyond[first];
            for (const auto& [distance, k] : others) {
                Beyond joint = common;
                for (size_t hole = 0; hole < joint.size(); ++hole) joint[hole] &= beyond[k][hole];
                if (std::ranges::count(joint, uint64_t{0}) > 0) continue;
                common = std::move(joint);
                taken[k] = 1;
                group.push_back(cells[k]);
            }
        }
    }

    const LostCells& cells_;
    std::vector<glm::dvec3> normals_;
};

fracture::Box box_of(const CollisionHull& hull, const glm::dvec3& place) {
    glm::vec3 low(std::numeric_limits<float>::infinity()), high(-low);
    for (const glm::vec3& p : hull.points) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    return {place + glm::dvec3(low - hull.margin), place + glm::dvec3(high + hull.margin)};
}

// The convex regions that leave the solid, for a quick look at which of them a box may reach.
class LostRegions {
  public:
    LostRegions(const LostCells& cells, const fracture::Box& around) {
        for (size_t site = 0; site < cells.sites.size(); ++site)
            if (cells.lost[site]) add(cells.planes[site], around);
        for (const std::vector<HullPlane>& planes : cells.more) add(planes, around);
    }

    // What lies of a polytope in each region. A box around it costs less than its planes: pass it as a function.
    template<class MakePolytope>
    [[nodiscard]] std::vector<Polytope> in(const fracture::Box& box, MakePolytope&& make) const {
        std::vector<Polytope> inside;
        Polytope polytope;
        for (const Region& region : regions_) {
            if (!fracture::overlap(region.box, box)) continue;
            if (polytope.empty()) polytope = make();
            if (Polytope part = clipped(polytope, *region.planes); part.volume() > 0.0)
                inside.push_back(std::move(part));
        }
        return inside;
    }

  private:
    struct Region {
        const std::vector<HullPlane>* planes;
        fracture::Box box;
    };

    void add(const std::vector<HullPlane>& planes, const fracture::Box& around) {
        if (const Polytope region = clipped(Polytope::of(around), planes); !region.empty())
            regions_.push_back({&planes, region.box()});
    }

    std::vector<Region> regions_;
};

class PartMaker {
  public:
    PartMaker(const fracture::ClusterMesh& surface, double least, const glm::dvec3& origin,
              const HullSettings& settings)
        : surface_(surface), least_(least), origin_(origin), settings_(settings) {}

    // `place` is the origin of the hull's points.
    void add(std::shared_ptr<const CollisionHull> hull, const glm::dvec3& place) {
        parts_.push_back(part_of(std::move(hull), place));
        contents_.emplace_back();
    }

    // Adds a hull of what the solid has in polytopes, if that is enough.
    void add_content(std::vector<Polytope> polytopes) {
        parts_.emplace_back();
        contents_.push_back(std::move(polytopes));
    }

    // Adds hulls of what is left of a hull without the holes.
    void add_divided(const CollisionHull& hull, const glm::dvec3& place, const Division& division, Polytope whole,
                     std::span<const Polytope> holes) {
        if (const std::optional<HullPlane> plane = division.side_of_most(whole, holes)) {
            const HullPlane behind{-plane->normal, glm::dot(plane->normal, place) - plane->distance};
            if (std::optional<CollisionHull> beyond = cut_hull(hull, behind, settings_)) {
                add(std::make_shared<const CollisionHull>(*std::move(beyond)), place);
                whole.cut(*plane);
            }
        }
        for (std::vector<Polytope>& group : division.groups(whole, holes)) add_content(std::move(group));
    }

    // Makes the hulls of contents, nearly all of the work; the parts are in the order in which they were added.
    [[nodiscard]] std::vector<BodyPart> parts(uint32_t threads) && {
        std::vector<size_t> open;
        for (size_t k = 0; k < contents_.size(); ++k)
            if (!contents_[k].empty()) open.push_back(k);
        for_each_on(threads, open.size(), [&](size_t k) { parts_[open[k]] = hull_of(contents_[open[k]]); });
        std::erase_if(parts_, [](const BodyPart& part) { return !part.hull; });
        return std::move(parts_);
    }

  private:
    [[nodiscard]] BodyPart part_of(std::shared_ptr<const CollisionHull> hull, const glm::dvec3& place) const {
        return {std::move(hull), glm::vec3(place - origin_)};
    }

    // Without a hull where that is too little.
    [[nodiscard]] BodyPart hull_of(std::span<const Polytope> polytopes) const {
        double volume = 0.0;
        glm::dvec3 centre(0.0);
        for (const Polytope& polytope : polytopes) {
            const double own = polytope.volume();
            volume += own;
            centre += own * polytope.centre();
        }
        if (!(volume > least_)) return {};
        centre /= volume;
        std::vector<glm::dvec3> points;
        for (const Polytope& polytope : polytopes) {
            const std::vector<glm::dvec3> own = Content(surface_, polytope).points();
            points.insert(points.end(), own.begin(), own.end());
        }
        if (points.size() < 4 || !(hull_volume(points, centre) > least_)) return {};
        return part_of(std::make_shared<const CollisionHull>(collision_hull(points, centre, settings_)), centre);
    }

    const fracture::ClusterMesh& surface_;
    double least_;
    glm::dvec3 origin_;
    const HullSettings& settings_;
    std::vector<BodyPart> parts_;
    std::vector<std::vector<Polytope>> contents_; // by part: what its hull is made of; empty once it has one
};

} // namespace

std::vector<BodyPart> remaining_parts(const FormerParts& before, const fracture::ClusterMesh& surface,
                                      bool is_one_of_many, const LostCells& cells, double least,
                                      const glm::dvec3& origin, const HullSettings& settings, uint32_t threads) {
    fracture::Box all{glm::dvec3(std::numeric_limits<double>::infinity()),
                      glm::dvec3(-std::numeric_limits<double>::infinity())};
    std::vector<fracture::Box> boxes;
    for (const BodyPart& part : before.parts) {
        boxes.push_back(box_of(*part.hull, before.origin + glm::dvec3(part.offset)));
        all = {glm::min(all.min, boxes.back().min), glm::max(all.max, boxes.back().max)};
    }
    const LostRegions lost(cells, all);
    const Division division(cells);
    PartMaker maker(surface, least, origin, settings);
    for (size_t k = 0; k < before.parts.size(); ++k) {
        const std::shared_ptr<const CollisionHull>& hull = before.parts[k].hull;
        const glm::dvec3 place = before.origin + glm::dvec3(before.parts[k].offset);
        const auto whole = [&] { return Polytope::around(*hull, static_cast<double>(hull->margin), place); };
        const std::vector<Polytope> holes = lost.in(boxes[k], whole);
        if (!holes.empty() && is_one_of_many) { // a part of several cells may hold some of another solid
            for (Polytope& cell : division.cells_of(whole())) maker.add_content({std::move(cell)});
        } else if (!holes.empty()) {
            maker.add_divided(*hull, place, division, whole(), holes);
        } else {
            const Holds held = is_one_of_many ? holds(surface, *hull, place) : Holds::all;
            if (held == Holds::all)
                maker.add(hull, place);
            else if (held == Holds::something)
                maker.add_content({whole()});
        }
    }
    return std::move(maker).parts(threads);
}

} // namespace brittle::physics

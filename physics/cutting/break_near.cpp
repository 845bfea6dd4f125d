#include "physics/cutting/break_near.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <glm/geometric.hpp>

#include "fracture/base/threads.h"
#include "fracture/local/cluster_queries.h"
#include "fracture/local/local_cut.h"
#include "fracture/pieces/merge.h"
#include "physics/cutting/job_threads.h"
#include "physics/cutting/polytope.h"
#include "physics/cutting/remaining_parts.h"
#include "physics/cutting/solid_maker.h"

namespace brittle::physics {

namespace {

using fracture::Fragments;
using fracture::LocalCut;
using fracture::Piece;

// Hulls of what remains below this share of the minimum volume of a piece, or of the solid, are left out.
constexpr double min_part = 0.02, min_part_of_solid = 1e-4;

// A plane that has all of the points on its far side, seen from `from`.
HullPlane side_of(std::span<const glm::dvec3> points, const glm::dvec3& centre, const glm::dvec3& from) {
    const glm::dvec3 way = centre - from;
    HullPlane plane{glm::length(way) > 0.0 ? glm::normalize(way) : glm::dvec3(0.0, 1.0, 0.0),
                    std::numeric_limits<double>::infinity()};
    for (const glm::dvec3& p : points) plane.distance = std::min(plane.distance, glm::dot(plane.normal, p));
    return plane;
}

class NearBreak {
  public:
    NearBreak(const SolidPiece& solid, std::span<const glm::dvec3> sites, std::span<const uint32_t> groups,
              const SolidSettings& settings, const std::function<bool()>& cancelled, LocalCut&& cut)
        : solid_(solid), sites_(sites), groups_(groups), rest_(*std::ranges::max_element(groups)), settings_(settings),
          cancelled_(cancelled), cut_(std::move(cut)) {}

    std::optional<std::vector<SolidPtr>> run(CrackBudget* budget) {
        Fragments& cells = cut_.cells;
        goes_to_ = fracture::choose_mergers(cells, {groups_, cube(settings_.min_size), {}});
        if (budget) budget->surface = crack_surface(cells, goes_to_);
        if (budget && budget->exceeded()) return std::vector<SolidPtr>();
        parts_ = parts_of_cells(cells, settings_.parts, threads_of(settings_.hull_threads));
        for (const Piece& cell : cells.pieces) {
            centres_.push_back(cell.mass.centre_of_mass);
            sites_of_cells_.push_back(cell.site);
        }
        bound_cells();
        if (cancelled_ && cancelled_()) return std::nullopt;
        fracture::Threads threads(settings_.threads);
        fracture::merge_pieces(cells, goes_to_, threads);

        const CutTags tags(cells, cut_.tags(), solid_);
        std::vector<SolidPiece> remains = remains_of(tags);
        if (remains.empty()) return std::nullopt;
        std::vector<SolidPtr> pieces;
        std::optional<size_t> place; // of the remains among the pieces
        for_pieces([&](const Piece& piece, uint32_t first_cell) {
            const bool is_open = cut_.is_open(piece);
            SolidPiece closed;
            if (!is_open) closed = solid_from(cells, piece, tags, settings_, cancelled_);
            for_cells(first_cell, [&](uint32_t cell) {
                add_parts(parts_[cell], centres_[cell], is_open ? around(centres_[cell], remains) : closed);
            });
            if (!is_open)
                pieces.push_back(shared(std::move(closed)));
            else if (!place)
                place = pieces.size();
        });
        for (size_t k = 0; k < remains.size(); ++k) {
            if (!place || remains[k].parts.empty()) return std::nullopt;
            pieces.insert(pieces.begin() + static_cast<ptrdiff_t>(*place + k), shared(std::move(remains[k])));
        }
        return pieces;
    }

  private:
    static SolidPtr shared(SolidPiece&& piece) {
        if (!piece.breakable) piece.drop_cut_data();
        return std::make_shared<const SolidPiece>(std::move(piece));
    }

    // Calls act(piece, its first cell) for each merged piece.
    template<class Act>
    void for_pieces(Act&& act) const {
        uint32_t index = 0;
        for (uint32_t cell = 0; cell < goes_to_.size(); ++cell)
            if (goes_to_[cell] == cell) act(cut_.cells.pieces[index++], cell);
    }
    // Calls act(cell) for each cell of a merged piece.
    template<class Act>
    void for_cells(uint32_t first_cell, Act&& act) const {
        for (uint32_t cell = 0; cell < goes_to_.size(); ++cell)
            if (goes_to_[cell] == first_cell) act(cell);
    }

    [[nodiscard]] std::vector<HullPlane>& planes_of(uint32_t site) {
        return planes_[static_cast<size_t>(std::ranges::lower_bound(cut_.near_sites(), site)
                                           - cut_.near_sites().begin())];
    }

    // Finds the planes of the cells. Where two cells are in contact, that is the mean plane of the contact, along which
    // the hulls of both are cut; it differs from the bisector where cuts are rough.
    void bound_cells() {
        for (const uint32_t site : cut_.near_sites()) near_.push_back(sites_[site]);
        for (uint32_t site = 0; site < near_.size(); ++site) planes_.push_back(cell_planes(near_, site));
        const Fragments& cells = cut_.cells;
        if (cells.rough_triangles == 0) return;
        for (const fracture::Bond& bond : cells.bonds) {
            const uint32_t a = cells.pieces[bond.a].site, b = cells.pieces[bond.b].site;
            if (a == b || !(bond.area > 0.0)) continue;
            const double distance = glm::dot(bond.normal, bond.centroid);
            const auto exchange = [&](uint32_t site, uint32_t other, const HullPlane& plane) {
                const glm::dvec3 bisector = glm::normalize(sites_[other] - sites_[site]);
                for (HullPlane& known : planes_of(site))
                    if (known.normal == bisector) known = plane;
            };
            exchange(a, b, {bond.normal, distance});
            exchange(b, a, {-bond.normal, -distance});
        }
    }

    // What remains of the solid, with its hulls; the largest part first. Nothing where that needs a cut of the whole.
    std::vector<SolidPiece> remains_of(const CutTags& tags) {
        std::vector<LocalCut::Rest> left =
            cut_.rest(solid_.mass, [&](uint32_t t, bool exterior) { return tags.of(t, exterior); });
        std::vector<uint8_t> lost;
        for (const uint32_t site : cut_.near_sites()) lost.push_back(groups_[site] != rest_ ? 1 : 0);
        const double least = std::max(min_part * cube(settings_.min_size), min_part_of_solid * solid_.mass.volume);
        if (!left.empty()) cut_off_crumbs(left[0].mass.centre_of_mass);
        std::vector<SolidPiece> remains;
        for (LocalCut::Rest& part : left) {
            SolidPiece& solid = remains.emplace_back();
            solid.mass = part.mass;
            solid.clusters = std::move(part.mesh);
            solid.cut_limit = tags.limit(sites_.size());
            finish(solid, settings_);
            if (left.size() == 1) keep_blocks(solid);
            if (!solid.blocks) add_blocks(solid, settings_, cancelled_);
            // Inside of what remains, the surface of all remains is that of one part.
            solid.parts = remaining_parts({solid_.parts, solid_.mass.centre_of_mass}, solid.clusters, left.size() > 1,
                                          {near_, planes_, lost, crumbs_}, least, solid.mass.centre_of_mass,
                                          settings_.parts.hull, threads_of(settings_.hull_threads));
        }
        return remains;
    }

    // Blocks that tell of what remains nearly what they told of the solid.
    void keep_blocks(SolidPiece& rest) const {
        if (!solid_.blocks || !rest.anchored || !rest.breakable) return;
        const Fragments& cells = cut_.cells;
        fracture::TriangleMesh lost;
        for (const Piece& piece : cells.pieces) {
            if (cut_.is_open(piece)) continue;
            const auto positions = cells.positions_of(piece);
            const auto base = static_cast<uint32_t>(lost.positions.size());
            if (reaches(settings_.anchors, positions, cells.triangles_of(piece))) return;
            lost.positions.insert(lost.positions.end(), positions.begin(), positions.end());
            for (const fracture::Triangle& t : cells.triangles_of(piece)) lost.triangles.push_back(t + base);
        }
        rest.blocks = blocks_without(*solid_.blocks, lost, settings_.material.density, settings_.threads);
    }

    // A crumb of the rest, which nothing holds any more, takes its side of the cell, as far as it reaches; `centre` is
    // that of the rest.
    void cut_off_crumbs(const glm::dvec3& centre) {
        for_pieces([&](const Piece& crumb, uint32_t first_cell) {
            if (groups_[crumb.site] != rest_ || cut_.is_open(crumb)) return;
            const auto points = cut_.cells.positions_of(crumb);
            const HullPlane side = side_of(points, crumb.mass.centre_of_mass, centre);
            const fracture::Box box = fracture::bounds(points);
            for_cells(first_cell, [&](uint32_t cell) {
                std::vector<HullPlane>& planes = planes_of(sites_of_cells_[cell]);
                std::vector<HullPlane>& region = crumbs_.emplace_back(planes);
                region.push_back({-side.normal, -side.distance});
                for (int axis = 0; axis < 3; ++axis) {
                    glm::dvec3 along(0.0);
                    along[axis] = 1.0;
                    region.push_back({along, box.max[axis]});
                    region.push_back({-along, -box.min[axis]});
                }
                planes.push_back(side);
            });
        });
    }

    // The part of what remains that holds a point.
    static SolidPiece& around(const glm::dvec3& point, std::vector<SolidPiece>& remains) {
        for (SolidPiece& solid : remains)
            if (remains.size() > 1 && fracture::is_inside(solid.clusters, point)) return solid;
        return remains[0];
    }

    const SolidPiece& solid_;
    std::span<const glm::dvec3> sites_;
    std::span<const uint32_t> groups_; // by site
    uint32_t rest_;                    // the group of the cells that stay together
    const SolidSettings& settings_;
    const std::function<bool()>& cancelled_;
    LocalCut cut_;
    // By cell of the cut.
    std::vector<uint32_t> goes_to_;
    std::vector<std::vector<BodyPart>> parts_;
    std::vector<glm::dvec3> centres_;
    std::vector<uint32_t> sites_of_cells_;
    // By near site: its place, and what bounds its cell.
    std::vector<glm::dvec3> near_;
    std::vector<std::vector<HullPlane>> planes_;
    std::vector<std::vector<HullPlane>> crumbs_; // what bounds those of the rest
};

} // namespace

std::optional<std::vector<SolidPtr>> break_near(const SolidPiece& solid, std::span<const glm::dvec3> sites,
                                                std::span<const uint32_t> groups, const fracture::Roughness& rough,
                                                const SolidSettings& settings, const std::function<bool()>& cancelled,
                                                CrackBudget* budget) {
    if (!solid.is_clustered() || groups.empty()) return std::nullopt;
    std::optional<LocalCut> cut = LocalCut::make(solid.clusters, sites, groups, *std::ranges::max_element(groups),
                                                 {.threads = settings.threads, .rough = rough, .cancelled = cancelled});
    if (!cut) return std::nullopt;
    return NearBreak(solid, sites, groups, settings, cancelled, *std::move(cut)).run(budget);
}

} // namespace brittle::physics

#include "fracture/local/local_cut.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <unordered_map>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

#include "fracture/base/union_find.h"
#include "fracture/exact/exact.h"
#include "fracture/exact/voronoi.h"
#include "fracture/local/cluster_queries.h"
#include "fracture/local/face_collector.h"
#include "fracture/local/lids.h"
#include "fracture/pieces/merge.h"
#include "fracture/rough/rough.h"

namespace brittle::fracture {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
// The region grows by this share of its size, far more than the rounding of a Voronoi vertex.
constexpr double region_margin = 1e-2;
// The largest share of the clusters that a local cut may open.
constexpr double max_opened = 0.5;

const Box nowhere{glm::dvec3(infinity), glm::dvec3(-infinity)};

bool holds(const Box& box, const Box& other) {
    return glm::all(glm::lessThanEqual(box.min, other.min)) && glm::all(glm::greaterThanEqual(box.max, other.max));
}

void grow(Box& box, const glm::dvec3& p) {
    box.min = glm::min(box.min, p);
    box.max = glm::max(box.max, p);
}

// The region of the cells outside of a group, and the sites that bound it.
struct Region {
    Box box = nowhere;
    std::vector<uint32_t> sites;
};

// Nothing where the cells reach beyond the surroundings of the mesh.
std::optional<Region> region_of(const ClusterMesh& mesh, std::span<const glm::dvec3> sites,
                                std::span<const uint32_t> groups, uint32_t rest) {
    Box around = mesh.box();
    const glm::dvec3 beyond(glm::length(around.size()));
    around.min -= beyond;
    around.max += beyond;
    const Result<VoronoiDiagram> diagram = voronoi_diagram(sites, around, 1);
    if (!diagram) return std::nullopt;
    Region region;
    std::vector<uint8_t> used(sites.size(), 0);
    for (const VoronoiDiagram::Facet& facet : diagram->facets) {
        if (groups[facet.i] == rest && groups[facet.j] == rest) continue;
        used[facet.i] = used[facet.j] = 1;
        for (const VoronoiDiagram::Corner& corner : diagram->ring_of(facet)) {
            const VoronoiDiagram::Vertex& vertex = diagram->vertices[corner.vertex];
            if (vertex.on_box()) return std::nullopt;
            grow(region.box, vertex.position);
        }
    }
    for (uint32_t site = 0; site < sites.size(); ++site)
        if (used[site]) region.sites.push_back(site);
    if (region.sites.empty()) return std::nullopt;
    const glm::dvec3 margin = region_margin * region.box.size();
    region.box.min -= margin;
    region.box.max += margin;
    return region;
}

std::vector<glm::dvec3> warped(std::span<const glm::dvec3> points, const rough::Warp& warp) {
    std::vector<glm::dvec3> moved(points.begin(), points.end());
    warp.apply(moved);
    return moved;
}

uint64_t edge_key(uint32_t from, uint32_t to) {
    return uint64_t{from} << 32 | to;
}

Box box_of(const Cluster& cluster, size_t k) {
    Box box = nowhere;
    for (const uint8_t v : cluster.triangles[k]) grow(box, cluster.positions[v]);
    return box;
}

} // namespace

// Takes the triangles that may meet the region, and all that share a vertex with one: the border of the patch stays
// outside the region, and so do all parts of its outermost triangles.
bool LocalCut::take_patch(const ClusterMesh& mesh, const Box& region, TriangleMesh& patch) {
    NumberTable inner; // vertices
    Box reach = nowhere;
    uint32_t near = 0;
    mesh.visit(region, [&](const ClusterPtr& cluster) {
        ++near;
        std::array<bool, 256> is_inner{};
        for (size_t k = 0; k < cluster->triangles.size(); ++k) {
            const Box box = box_of(*cluster, k);
            if (!overlap(box, region)) continue;
            grow(reach, box.min);
            grow(reach, box.max);
            for (const uint8_t v : cluster->triangles[k]) is_inner[v] = true;
        }
        for (size_t v = 0; v < cluster->vertices.size(); ++v)
            if (is_inner[v]) inner.add(cluster->vertices[v]);
    });
    if (inner.size() == 0 || near > max_opened * mesh.cluster_count()) return false;
    FaceList faces;
    NumberTable numbers(2 * inner.size());
    FaceCollector taken(faces, numbers), kept(kept_, kept_number_);
    mesh.visit(reach, [&](const ClusterPtr& cluster) {
        std::array<bool, 256> is_inner{};
        bool any = false;
        for (size_t v = 0; v < cluster->vertices.size(); ++v)
            any = (is_inner[v] = inner.find(cluster->vertices[v]) != no_index) || any;
        if (!any) return;
        opened_.insert(cluster.get());
        taken.open(*cluster);
        kept.open(*cluster);
        for (size_t k = 0; k < cluster->triangles.size(); ++k) {
            const auto& [a, b, c] = cluster->triangles[k];
            const int inside = is_inner[a] + is_inner[b] + is_inner[c];
            if (inside == 0) {
                kept.add(k);
            } else {
                const Triangle triangle = taken.add(k);
                if (inside < 3) outer_.push_back(triangle);
            }
        }
    });
    if (opened_.size() > max_opened * mesh.cluster_count()) return false;
    patch.triangles = std::move(faces.triangles);
    patch.positions = std::move(faces.positions);
    numbers_ = std::move(faces.vertices);
    tags_ = std::move(faces.tags);
    inner_.resize(numbers_.size());
    for (size_t v = 0; v < numbers_.size(); ++v) inner_[v] = inner.find(numbers_[v]) != no_index ? 1 : 0;
    return true;
}

bool LocalCut::close_patch(const Box& region, TriangleMesh& patch) {
    const size_t own = patch.triangles.size();
    taken_ = patch;
    const std::vector<std::vector<uint32_t>> border = border_loops(outer_, inner_);
    std::vector<uint32_t> on_border(numbers_.size(), no_index);
    for (const std::vector<uint32_t>& loop : border)
        for (size_t k = 0; k < loop.size(); ++k) {
            if (on_border[loop[k]] == no_index) on_border[loop[k]] = border_size_++;
            border_edges_.insert(edge_key(numbers_[loop[k]], numbers_[loop[(k + 1) % loop.size()]]));
        }
    std::vector<uint32_t> original;
    if (!add_lids(patch, border, region, original)) return false;
    std::vector<uint32_t> numbers(original.size(), no_index);
    border_.assign(original.size(), no_index);
    for (size_t v = 0; v < original.size(); ++v) {
        if (original[v] == no_index) continue;
        numbers[v] = numbers_[original[v]];
        border_[v] = on_border[original[v]];
    }

    // The lids change the winding number in the region by a constant.
    const auto add_to = [](RayWinding& ray, const auto& positions, const Triangle& t) {
        ray.add(positions[t.x], positions[t.y], positions[t.z]);
    };
    RayWinding missing(region.centre()), added(region.centre());
    for (size_t t = own; t < patch.triangles.size(); ++t) add_to(added, patch.positions, patch.triangles[t]);
    for (const Triangle& t : kept_.triangles) add_to(missing, kept_.positions, t);
    mesh_.visit(missing.reach(mesh_.box()), [&](const ClusterPtr& cluster) {
        if (opened_.contains(cluster.get())) return;
        for (const auto& [a, b, c] : cluster->triangles)
            missing.add(cluster->positions[a], cluster->positions[b], cluster->positions[c]);
    });
    add_boxes(patch, missing.winding() - added.winding());
    numbers.resize(patch.positions.size(), no_index);
    border_.resize(patch.positions.size(), no_index);
    numbers_ = std::move(numbers);
    return true;
}

bool LocalCut::is_open(const Piece& piece) const {
    const auto first = cells.triangle_source.begin() + piece.triangles.begin;
    return std::any_of(first, first + piece.exterior_triangles,
                       [&](uint32_t source) { return source >= tags_.size(); });
}

bool LocalCut::cut_patch(const TriangleMesh& patch, const Box& region, std::span<const glm::dvec3> sites,
                         std::span<const uint32_t> groups, uint32_t rest, const Settings& settings) {
    std::vector<glm::dvec3> near;
    for (const uint32_t site : near_sites_) near.push_back(sites[site]);
    exact::Scratch scratch;
    Settings own = settings;
    own.merged_later.clear();
    for (const uint32_t site : near_sites_) own.merged_later.push_back(groups[site]);
    const auto mark_open = [&](const auto& source_of) {
        for (Piece& piece : cells.pieces)
            for (uint32_t t = piece.triangles.begin; t < piece.triangles.begin + piece.exterior_triangles; ++t)
                if (source_of(cells.triangle_source[t]) >= tags_.size()) piece.mass = {.volume = infinity};
    };
    const auto same = [](uint32_t source) { return source; };
    if (settings.rough.is_flat()) {
        if (!exact::fracture_exact(patch, near, own, scratch, cells)) return false;
        mark_open(same);
        const std::vector<uint8_t> flat = flat_pieces(cells, mesh_.box());
        if (!flat.empty()) {
            Threads threads(settings.threads);
            merge_pieces(cells, choose_mergers(cells, {.flat = flat}), threads);
        }
    } else {
        rough::RoughCut cut;
        std::vector<uint8_t> far(numbers_.size()); // the lids
        for (size_t v = 0; v < far.size(); ++v) far[v] = numbers_[v] == no_index ? 1 : 0;
        cut.start(mesh_.box(), sites.size(), own, far);
        const auto choose = [&](std::vector<uint8_t> flakes) {
            mark_open([&](uint32_t part) { return cut.source_of(part); });
            for (size_t p = 0; p < flakes.size(); ++p)
                if (std::isinf(cells.pieces[p].mass.volume)) flakes[p] = 0;
            const std::vector<uint8_t> flat = flat_pieces(cells, mesh_.box());
            if (flat.empty() && std::ranges::count(flakes, 1) == 0) return std::vector<uint32_t>();
            return choose_mergers(cells, {.flat = flat, .small = flakes});
        };
        if (!cut.run(patch, near, own, scratch, choose, cells)) return false;
        // Where the warp was calmed, the cells are others than at first.
        const std::optional<Region> last = region_of(mesh_, warped(near, cut.warp()), own.merged_later, rest);
        const double reach = 2.0 * cut.warp().reach();
        if (!last || !holds(region, {last->box.min - reach, last->box.max + reach})) return false;
    }
    mark_open(same);
    for (Piece& piece : cells.pieces) {
        for (uint32_t t = piece.triangles.begin + piece.exterior_triangles; t < piece.triangles.end; ++t)
            cells.triangle_source[t] = near_sites_[cells.triangle_source[t]];
        piece.site = near_sites_[piece.site];
    }
    // A piece without cuts that is inside out is a cavity. One with cuts is a splinter where the surface passes through
    // itself, as a cut of the whole mesh has it too; the rest of its cell outweighs it unless a lid is wrong.
    std::unordered_map<uint32_t, double> volumes; // by site
    for (const Piece& piece : cells.pieces) {
        if (!(piece.mass.volume > 0.0) && piece.exterior_triangles == piece.triangles.size()) return false;
        if (std::isinf(piece.mass.volume) && groups[piece.site] != rest) return false;
        volumes[piece.site] += piece.mass.volume;
    }
    return std::ranges::all_of(volumes, [](const auto& cell) { return cell.second > 0.0; });
}

std::optional<LocalCut> LocalCut::make(const ClusterMesh& mesh, std::span<const glm::dvec3> sites,
                                       std::span<const uint32_t> groups, uint32_t rest, const Settings& settings) {
    std::optional<Region> region = region_of(mesh, sites, groups, rest);
    if (!region) return std::nullopt;
    if (!settings.rough.is_flat()) {
        const rough::Warp warp(settings.rough, settings.rough.wavelength);
        const std::optional<Region> bent = region_of(mesh, warped(sites, warp), groups, rest);
        if (!bent) return std::nullopt;
        grow(region->box, bent->box.min);
        grow(region->box, bent->box.max);
        // The surface moves by the reach of the warp at most, and so do the lids.
        const double reach = 2.0 * warp.reach();
        region->box = {region->box.min - reach, region->box.max + reach};
        std::vector<uint32_t> either;
        std::ranges::set_union(region->sites, bent->sites, std::back_inserter(either));
        region->sites = either;
    }
    // Where no lids are found, those of a larger patch may be.
    for (const double growth : {0.0, 0.2, 0.5}) {
        const glm::dvec3 more = growth * region->box.size();
        const Box box{region->box.min - more, region->box.max + more};
        LocalCut cut;
        cut.mesh_ = mesh;
        cut.near_sites_ = region->sites;
        TriangleMesh patch;
        try {
            if (!cut.take_patch(mesh, box, patch)) return std::nullopt;
            if (!cut.close_patch(box, patch)) continue;
            if (!cut.cut_patch(patch, box, sites, groups, rest, settings)) return std::nullopt;
            return cut;
        } catch (const Threads::Cancelled&) {
            return std::nullopt;
        }
    }
    return std::nullopt;
}

// The parts of what remains. The mass of the largest is that of all less the others'.
std::vector<LocalCut::Rest> LocalCut::separated(Rest all) {
    std::vector<Rest> rests;
    for (ClusterMesh& part : all.mesh.parts()) rests.push_back({std::move(part), {}});
    rests[0].mass = all.mass;
    for (size_t k = 1; k < rests.size(); ++k) {
        const TriangleMesh flat = rests[k].mesh.flatten();
        rests[k].mass = mass_properties(flat.positions, flat.triangles);
        rests[0].mass = exchange_triangles(rests[0].mass, flat.positions, flat.triangles, {}, {});
    }
    if (!std::ranges::all_of(rests, [](const Rest& rest) { return rest.mass.volume > 0.0; })) return {};
    return rests;
}

std::vector<LocalCut::Rest> LocalCut::rest(const MassProperties& before,
                                           const std::function<uint32_t(uint32_t, bool)>& tag_of) const {
    FaceList faces = kept_;
    std::vector<uint32_t> at_border(border_size_, no_index); // indices in faces
    for (size_t v = 0; v < numbers_.size(); ++v)
        if (border_[v] != no_index) at_border[border_[v]] = kept_number_.find(numbers_[v]);
    std::vector<uint8_t> named(numbers_.size(), 0);
    uint32_t next_number = mesh_.vertex_limit();
    const auto first_new = static_cast<uint32_t>(faces.triangles.size());
    size_t border_edges = 0;
    for (const Piece& piece : cells.pieces) {
        if (!is_open(piece)) continue;
        std::vector<uint32_t> index(piece.vertices.size(), no_index); // in faces
        const auto vertex = [&](uint32_t local) {
            if (index[local] != no_index) return index[local];
            const uint32_t at = piece.vertices.begin + local, point = cells.vertex_point[at];
            const bool is_old = point < numbers_.size() && numbers_[point] != no_index;
            const bool is_border = is_old && border_[point] != no_index;
            if (is_border && at_border[border_[point]] != no_index) return index[local] = at_border[border_[point]];
            // A new point, or the second vertex at a point of the patch, gets a new number.
            const bool keeps = is_border || (is_old && !std::exchange(named[point], uint8_t{1}));
            index[local] = static_cast<uint32_t>(faces.vertices.size());
            if (is_border) at_border[border_[point]] = index[local];
            faces.vertices.push_back(keeps ? numbers_[point] : next_number++);
            faces.positions.push_back(cells.positions[at]);
            return index[local];
        };
        for (uint32_t t = piece.triangles.begin; t < piece.triangles.end; ++t) {
            const bool exterior = t < piece.triangles.begin + piece.exterior_triangles;
            if (exterior && cells.triangle_source[t] >= tags_.size()) continue; // a lid
            const Triangle& corners = cells.triangles[t];
            const Triangle face(vertex(corners.x), vertex(corners.y), vertex(corners.z));
            faces.triangles.push_back(face);
            faces.tags.push_back(tag_of(t, exterior));
            for (int k = 0; k < 3; ++k)
                border_edges +=
                    border_edges_.contains(edge_key(faces.vertices[face[k]], faces.vertices[face[(k + 1) % 3]]));
        }
    }
    if (border_edges != border_edges_.size()) return {}; // a cut of the rest has left a point on the border
    // All that was not cut has an edge in common with the new triangles, so it is one surface if these are.
    std::vector<uint32_t> parent(faces.vertices.size());
    std::iota(parent.begin(), parent.end(), 0u);
    for (size_t t = first_new; t < faces.triangles.size(); ++t) {
        unite(parent, faces.triangles[t].x, faces.triangles[t].y);
        unite(parent, faces.triangles[t].x, faces.triangles[t].z);
    }
    const auto root = [&](size_t t) { return root_of(parent, faces.triangles[t].x); };
    bool is_one = true;
    for (size_t t = first_new; t < faces.triangles.size(); ++t) is_one = is_one && root(t) == root(first_new);
    const auto added = std::span(faces.triangles).subspan(first_new);
    Rest all{mesh_.with(opened_, faces),
             exchange_triangles(before, taken_.positions, taken_.triangles, faces.positions, added)};
    if (!is_one) return separated(std::move(all));
    return {std::move(all)};
}

} // namespace brittle::fracture

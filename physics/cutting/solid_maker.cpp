#include "physics/cutting/solid_maker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <glm/geometric.hpp>

#include "fracture/base/threads.h"
#include "fracture/local/cluster_queries.h"
#include "physics/cutting/job_threads.h"

namespace brittle::physics {

namespace {

using fracture::Error;
using fracture::Fragments;
using fracture::Piece;
using fracture::Result;
using fracture::Status;
using fracture::Triangle;

// Limit of hulls for one cell of a cut solid. A cell is convex, so few parts are enough.
constexpr uint32_t max_parts_of_cell = 4;

// Solids with fewer triangles have no clusters: they are cut as a whole in no time.
constexpr size_t min_clustered = 4096;

// The points of a piece on its outside and where its cuts meet. Those inside a rough cut do not count for the hull, which
// is cut along the mean plane of the cut.
std::vector<glm::dvec3> outline_of(const Fragments& cells, const Piece& piece) {
    constexpr uint32_t none = 0xffffffffu, several = 0xfffffffeu;
    std::vector<uint32_t> cut(piece.vertices.size(), none);
    for (uint32_t k = 0; k < piece.triangles.size(); ++k) {
        const uint32_t t = piece.triangles.begin + k;
        const uint32_t source = k < piece.exterior_triangles ? several : cells.triangle_source[t];
        for (int c = 0; c < 3; ++c) {
            uint32_t& at = cut[cells.triangles[t][c]];
            at = at == none || at == source ? source : several;
        }
    }
    std::vector<glm::dvec3> outline;
    for (uint32_t v = 0; v < cut.size(); ++v)
        if (cut[v] == several) outline.push_back(cells.positions[piece.vertices.begin + v]);
    return outline;
}

} // namespace

Result<void> check(const SolidSettings& settings) {
    if (std::string fault = fault_of(settings.material); !fault.empty())
        return Error{Status::invalid_setting, std::move(fault)};
    if (!(settings.min_size > 0.0) || !std::isfinite(settings.min_size))
        return Error{Status::invalid_setting,
                     "the least size of a piece is " + std::to_string(settings.min_size) + " m; it must be positive"};
    return {};
}

namespace {

fracture::Box box_of(const AnchorRegion& region) {
    if (const auto* ball = std::get_if<Ball>(&region))
        return {ball->centre - ball->radius, ball->centre + ball->radius};
    if (const auto* box = std::get_if<fracture::Box>(&region)) return *box;
    constexpr double everywhere = std::numeric_limits<double>::max();
    return {glm::dvec3(-everywhere), glm::dvec3(everywhere)};
}

struct Extent {
    fracture::Box box;
    float radius = 0.0f; // m, around the centre of mass
    bool anchored = false;
};

Extent extent_of(const SolidSurface& surface, std::span<const AnchorRegion> anchors) {
    Extent extent{fracture::bounds(surface.mesh), 0.0f,
                  reaches(anchors, surface.mesh.positions, surface.mesh.triangles)};
    for (const glm::vec3& p : surface.positions) extent.radius = std::max(extent.radius, glm::length(p));
    return extent;
}

bool reaches(const AnchorRegion& region, const fracture::ClusterMesh& surface) {
    bool reached = false;
    surface.visit(box_of(region), [&](const fracture::ClusterPtr& cluster) {
        for (const auto& [a, b, c] : cluster->triangles)
            reached = reached || reaches(region, cluster->positions[a], cluster->positions[b], cluster->positions[c]);
    });
    return reached;
}

Extent extent_of(const fracture::ClusterMesh& surface, const glm::dvec3& centre,
                 std::span<const AnchorRegion> anchors) {
    return {surface.box(), static_cast<float>(fracture::farthest_from(surface, centre)),
            std::ranges::any_of(anchors, [&](const AnchorRegion& region) { return reaches(region, surface); })};
}

} // namespace

void finish(SolidPiece& solid, const SolidSettings& settings) {
    const Extent extent = solid.is_clustered() ? extent_of(solid.clusters, solid.mass.centre_of_mass, settings.anchors)
                                               : extent_of(solid.surface(), settings.anchors);
    solid.radius = extent.radius;
    Piece piece;
    piece.mass = solid.mass;
    const BodyMass exact = true_mass(piece, settings.material.density);
    const std::array corners{extent.box.min, extent.box.max};
    solid.body = is_possible(exact) ? exact : box_mass(corners, settings.material.density);
    solid.bearable = bearable_force(settings.material, solid.mass.volume, extent.box);
    solid.anchored = extent.anchored;
    solid.breakable = settings.breakable && solid.mass.volume >= 2.0 * cube(settings.min_size);
}

void add_blocks(SolidPiece& solid, const SolidSettings& settings, const std::function<bool()>& cancelled) {
    if (!settings.blocks.enabled || !solid.anchored || !solid.breakable) return;
    const auto anchored = [&](const Fragments& fragments, const Piece& piece) {
        return reaches(settings.anchors, fragments.positions_of(piece), fragments.triangles_of(piece));
    };
    solid.blocks = held_blocks(solid.surface().mesh, settings.material.density, settings.blocks, anchored,
                               settings.threads, cancelled);
}

void add_clusters(SolidPiece& solid, const SolidSettings& settings) {
    if (!solid.breakable || solid.triangle_count() < min_clustered) return;
    fracture::Threads threads(settings.threads);
    fracture::ClusterMesh clusters(solid.surface().mesh, tags_of(solid.surface()), threads);
    if (clusters.is_connected()) solid.clusters = std::move(clusters);
}

std::vector<uint32_t> tags_of(const SolidSurface& surface) {
    std::vector<uint32_t> tags(surface.source);
    for (const uint32_t cut : surface.cut) tags.push_back(cut | surface_tag::cut_bit);
    return tags;
}

SolidSurface surface_of(fracture::TriangleMesh mesh, std::span<const uint32_t> tags, const glm::dvec3& centre_of_mass) {
    SolidSurface surface;
    surface.mesh.positions = std::move(mesh.positions);
    surface.mesh.triangles.reserve(mesh.triangles.size());
    for (const bool exterior : {true, false})
        for (size_t t = 0; t < mesh.triangles.size(); ++t) {
            if (surface_tag::is_cut(tags[t]) == exterior) continue;
            surface.mesh.triangles.push_back(mesh.triangles[t]);
            (exterior ? surface.source : surface.cut).push_back(surface_tag::number(tags[t]));
        }
    surface.exterior_triangles = static_cast<uint32_t>(surface.source.size());
    surface.positions.reserve(surface.mesh.positions.size());
    for (const glm::dvec3& p : surface.mesh.positions) surface.positions.emplace_back(p - centre_of_mass);
    return surface;
}

void set_surface(SolidPiece& solid, fracture::TriangleMesh mesh, std::span<const uint32_t> tags) {
    SolidSurface surface = surface_of(std::move(mesh), tags, solid.mass.centre_of_mass);
    solid.cut_limit = surface.cut.empty() ? 0 : 1 + *std::ranges::max_element(surface.cut);
    solid.set_surface(std::move(surface));
}

SolidPiece solid_from(const Fragments& fragments, const Piece& piece, const CutTags& tags,
                      const SolidSettings& settings, const std::function<bool()>& cancelled) {
    const auto positions = fragments.positions_of(piece);
    const auto triangles = fragments.triangles_of(piece);
    std::vector<uint32_t> tag(triangles.size());
    for (uint32_t k = 0; k < tag.size(); ++k) tag[k] = tags.of(piece.triangles.begin + k, k < piece.exterior_triangles);
    SolidPiece solid;
    solid.mass = piece.mass;
    set_surface(solid, {{positions.begin(), positions.end()}, {triangles.begin(), triangles.end()}}, tag);
    finish(solid, settings);
    add_clusters(solid, settings);
    add_blocks(solid, settings, cancelled);
    return solid;
}

double crack_surface(const Fragments& cells, std::span<const uint32_t> goes_to) {
    double surface = 0.0;
    for (const fracture::Bond& bond : cells.bonds)
        if (goes_to[bond.a] != goes_to[bond.b]) surface += bond.area;
    return surface;
}

std::vector<std::vector<BodyPart>> parts_of_cells(const Fragments& cells, const ConvexPartSettings& settings,
                                                  uint32_t threads) {
    ConvexPartSettings few = settings;
    few.max_parts = std::min(settings.max_parts, max_parts_of_cell);
    const std::vector<std::vector<HullPlane>> planes = contact_planes(cells);
    std::vector<std::vector<BodyPart>> parts(cells.pieces.size());
    for_each_on(threads, parts.size(), [&](size_t cell) {
        const Piece& piece = cells.pieces[cell];
        if (std::isinf(piece.mass.volume)) return;
        ConvexPartSettings own = few;
        own.hull.planes = planes[cell];
        std::vector<glm::dvec3> outline;
        if (cells.rough_triangles > 0) outline = outline_of(cells, piece);
        own.points = outline;
        parts[cell] = convex_parts(cells.positions_of(piece), cells.triangles_of(piece), piece.mass.volume,
                                   piece.mass.centre_of_mass, own);
    });
    return parts;
}

void add_parts(const std::vector<BodyPart>& parts, const glm::dvec3& centre, SolidPiece& piece) {
    for (BodyPart part : parts) {
        part.offset += glm::vec3(centre - piece.mass.centre_of_mass);
        piece.parts.push_back(std::move(part));
    }
}

} // namespace brittle::physics

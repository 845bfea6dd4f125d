#include "physics/cutting/solid_maker.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <glm/geometric.hpp>

#include "fracture/base/threads.h"

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

void finish(SolidPiece& solid, const SolidSettings& settings) {
    const std::vector<glm::dvec3>& positions = solid.mesh.positions;
    solid.positions.reserve(positions.size());
    for (const glm::dvec3& p : positions) {
        solid.positions.emplace_back(p - solid.mass.centre_of_mass);
        solid.radius = std::max(solid.radius, glm::length(solid.positions.back()));
    }
    Piece piece;
    piece.mass = solid.mass;
    const BodyMass exact = true_mass(piece, settings.material.density);
    solid.body = is_possible(exact) ? exact : box_mass(positions, settings.material.density);
    solid.bearable = bearable_force(settings.material, solid.mass.volume, fracture::bounds(solid.mesh));
    solid.anchored = reaches(settings.anchors, positions, solid.mesh.triangles);
    solid.breakable = solid.mass.volume >= 2.0 * cube(settings.min_size);
}

void add_blocks(SolidPiece& solid, const SolidSettings& settings, const std::function<bool()>& cancelled) {
    if (!settings.blocks.enabled || !solid.anchored || !solid.breakable) return;
    const auto anchored = [&](const Fragments& fragments, const Piece& piece) {
        return reaches(settings.anchors, fragments.positions_of(piece), fragments.triangles_of(piece));
    };
    solid.blocks =
        held_blocks(solid.mesh, settings.material.density, settings.blocks, anchored, settings.threads, cancelled);
}

void add_clusters(SolidPiece& solid, const SolidSettings& settings) {
    if (!solid.breakable || solid.mesh.triangles.size() < min_clustered) return;
    fracture::Threads threads(settings.threads);
    fracture::ClusterMesh clusters(solid.mesh, tags_of(solid), threads);
    if (clusters.is_connected()) solid.clusters = std::move(clusters);
}

std::vector<uint32_t> tags_of(const SolidPiece& solid) {
    std::vector<uint32_t> tags(solid.source);
    for (const uint32_t cut : solid.cut) tags.push_back(cut | surface_tag::cut_bit);
    return tags;
}

void set_surface(SolidPiece& solid, fracture::TriangleMesh mesh, std::span<const uint32_t> tags) {
    const std::vector<Triangle> triangles = std::move(mesh.triangles);
    solid.mesh.positions = std::move(mesh.positions);
    solid.mesh.triangles.clear();
    solid.mesh.triangles.reserve(triangles.size());
    for (const bool exterior : {true, false})
        for (size_t t = 0; t < triangles.size(); ++t) {
            if (surface_tag::is_cut(tags[t]) == exterior) continue;
            solid.mesh.triangles.push_back(triangles[t]);
            (exterior ? solid.source : solid.cut).push_back(surface_tag::number(tags[t]));
        }
    solid.exterior_triangles = static_cast<uint32_t>(solid.source.size());
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

std::vector<std::vector<BodyPart>> parts_of_cells(const Fragments& cells, const ConvexPartSettings& settings) {
    ConvexPartSettings few = settings;
    few.max_parts = std::min(settings.max_parts, max_parts_of_cell);
    const std::vector<std::vector<HullPlane>> planes = contact_planes(cells);
    std::vector<std::vector<BodyPart>> parts;
    for (const Piece& piece : cells.pieces) {
        if (std::isinf(piece.mass.volume)) {
            parts.emplace_back();
            continue;
        }
        few.hull.planes = planes[parts.size()];
        std::vector<glm::dvec3> outline;
        if (cells.rough_triangles > 0) outline = outline_of(cells, piece);
        few.points = outline;
        parts.push_back(convex_parts(cells.positions_of(piece), cells.triangles_of(piece), piece.mass.volume,
                                     piece.mass.centre_of_mass, few));
    }
    return parts;
}

void add_parts(const std::vector<BodyPart>& parts, const glm::dvec3& centre, SolidPiece& piece) {
    for (BodyPart part : parts) {
        part.offset += glm::vec3(centre - piece.mass.centre_of_mass);
        piece.parts.push_back(std::move(part));
    }
}

} // namespace brittle::physics

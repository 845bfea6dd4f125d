#include "physics/cutting/solid_piece.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/base/threads.h"
#include "fracture/fracture.h"
#include "physics/cutting/solid_maker.h"
#include "physics/world/surface_parts.h"

namespace brittle::physics {

namespace {

using fracture::Box;
using fracture::Error;
using fracture::Fragments;
using fracture::Piece;
using fracture::Result;
using fracture::Status;

} // namespace

const SolidSurface& SolidPiece::surface() const {
    std::call_once(arrays_->made, [&] {
        std::vector<uint32_t> tags;
        fracture::TriangleMesh mesh = clusters.flatten(&tags);
        arrays_->surface = surface_of(std::move(mesh), tags, mass.centre_of_mass);
    });
    return arrays_->surface;
}

void SolidPiece::set_surface(SolidSurface surface) {
    arrays_ = std::make_shared<Arrays>();
    std::call_once(arrays_->made, [&] { arrays_->surface = std::move(surface); });
}

void SolidPiece::drop_cut_data() {
    (void)surface();
    arrays_->surface.mesh.positions = {};
    clusters = {};
}

size_t SolidPiece::triangle_count() const {
    return is_clustered() ? clusters.triangle_count() : surface().mesh.triangles.size();
}

size_t SolidPiece::vertex_count() const {
    return is_clustered() ? clusters.triangle_count() / 2 + 2 : surface().positions.size();
}

double bearable_force(const Material& material, double volume, const Box& box) {
    const double side = std::max({box.size().x, box.size().y, box.size().z});
    return side > 0.0 ? breaking_force(material, volume / side) : 0.0;
}

double new_surface(const SolidPiece& solid, std::span<const SolidPtr> pieces) {
    double surface = -solid.mass.area;
    for (const SolidPtr& piece : pieces) surface += piece->mass.area;
    return 0.5 * std::max(surface, 0.0);
}

Result<SolidPtr> make_solid(const fracture::TriangleMesh& mesh, const SolidSettings& settings) {
    if (const Result<void> valid = check(settings); !valid) return valid.error();
    // A fracture with one cell checks the mesh and separates solids that touch in a vertex, as every later cut does.
    const glm::dvec3 site = fracture::bounds(mesh).centre();
    const Result<Fragments> whole = fracture::fracture(mesh, {&site, 1}, {.threads = settings.threads, .groups = {0}});
    if (!whole) return whole.error();
    fracture::TriangleMesh surface;
    std::vector<uint32_t> source;
    for (const Piece& piece : whole->pieces) { // separate components form one object
        const auto positions = whole->positions_of(piece);
        const auto base = static_cast<uint32_t>(surface.positions.size());
        surface.positions.insert(surface.positions.end(), positions.begin(), positions.end());
        for (uint32_t t = piece.triangles.begin; t < piece.triangles.end; ++t) {
            surface.triangles.push_back(whole->triangles[t] + base);
            source.push_back(whole->triangle_source[t]);
        }
    }
    SolidPiece solid;
    solid.mass = fracture::mass_properties(surface.positions, surface.triangles);
    solid.parts = convex_parts(surface.positions, surface.triangles, solid.mass.volume, solid.mass.centre_of_mass,
                               settings.parts);
    set_surface(solid, std::move(surface), source);
    finish(solid, settings);
    add_clusters(solid, settings);
    add_blocks(solid, settings);
    return std::make_shared<const SolidPiece>(std::move(solid));
}

namespace {

// The solid of a piece, without parts and blocks.
SolidPiece copy_of(const Fragments& fragments, const Piece& piece, const SolidSettings& settings) {
    const auto positions = fragments.positions_of(piece);
    const auto triangles = fragments.triangles_of(piece);
    const auto source = fragments.triangle_source.begin() + piece.triangles.begin;
    std::vector<uint32_t> tags(source, source + piece.triangles.size());
    for (size_t k = piece.exterior_triangles; k < tags.size(); ++k) tags[k] |= surface_tag::cut_bit;
    SolidPiece solid;
    solid.mass = piece.mass;
    set_surface(solid, {{positions.begin(), positions.end()}, {triangles.begin(), triangles.end()}}, tags);
    finish(solid, settings);
    return solid;
}

} // namespace

SolidPtr solid_of(const Fragments& fragments, const Piece& piece, const SolidSettings& settings) {
    SolidPiece solid = copy_of(fragments, piece, settings);
    solid.parts.push_back({std::make_shared<const CollisionHull>(
        collision_hull(fragments.positions_of(piece), piece.mass.centre_of_mass, settings.parts.hull))});
    return std::make_shared<const SolidPiece>(std::move(solid));
}

Result<SolidPtr> fixed_solid(const fracture::TriangleMesh& mesh) {
    const Box box = fracture::bounds(mesh);
    SolidPiece solid;
    solid.mass.centre_of_mass = box.centre(); // of an open mesh there is no other
    solid.parts = surface_parts(mesh.positions, mesh.triangles, box.centre());
    if (solid.parts.empty()) return Error{Status::invalid_mesh, "no triangle of the mesh has an area"};
    solid.body = box_mass(std::array{box.min, box.max}, Material{}.density);
    std::vector<uint32_t> source(mesh.triangles.size());
    std::iota(source.begin(), source.end(), 0u);
    set_surface(solid, mesh, source);
    for (const glm::vec3& p : solid.surface().positions) solid.radius = std::max(solid.radius, glm::length(p));
    solid.anchored = true;
    return std::make_shared<const SolidPiece>(std::move(solid));
}

Result<std::vector<SolidPtr>> solids_of(const Fragments& fragments, const SolidSettings& settings, bool hollow,
                                        uint32_t threads) {
    if (const Result<void> valid = check(settings); !valid) return valid.error();
    std::vector<SolidPtr> solids(fragments.pieces.size());
    fracture::Threads pool(threads);
    const std::vector<std::vector<HullPlane>> planes = contact_planes(fragments);
    pool.for_chunks(static_cast<uint32_t>(solids.size()), 4, [&](uint32_t, uint32_t begin, uint32_t end) {
        SolidSettings own = settings;
        for (uint32_t i = begin; i < end; ++i) {
            const Piece& piece = fragments.pieces[i];
            own.parts.hull.planes = planes[i];
            if (!hollow) {
                solids[i] = solid_of(fragments, piece, own);
                continue;
            }
            SolidPiece solid = copy_of(fragments, piece, settings);
            solid.parts = convex_parts(fragments.positions_of(piece), fragments.triangles_of(piece), piece.mass.volume,
                                       piece.mass.centre_of_mass, own.parts);
            add_clusters(solid, own);
            add_blocks(solid, settings);
            solids[i] = std::make_shared<const SolidPiece>(std::move(solid));
        }
    });
    return solids;
}

} // namespace brittle::physics

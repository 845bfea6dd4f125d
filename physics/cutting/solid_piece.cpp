#include "physics/cutting/solid_piece.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/base/threads.h"
#include "fracture/fracture.h"
#include "fracture/pieces/merge.h"
#include "fracture/rough/rough.h"

namespace brittle::physics {

namespace {

using fracture::Box;
using fracture::Error;
using fracture::Fragments;
using fracture::Piece;
using fracture::Result;
using fracture::Status;
using fracture::Triangle;

// Limit of hulls for one cell of a cut solid. A cell is convex, so few parts are enough.
constexpr uint32_t max_parts_of_cell = 4;

// See Roughness::max_triangles.
constexpr uint64_t max_rough_triangles = 100'000;

// The least typical distance of the sites of a rough cut, in units of the minimum size of a piece.
constexpr double min_rough_pieces = 3.0;

double cube(double x) {
    return x * x * x;
}

// Fills in all members but parts and blocks, from mesh, exterior_triangles, source and mass.
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

// Makes the blocks of an anchored, breakable solid.
void add_blocks(SolidPiece& solid, const SolidSettings& settings, const std::function<bool()>& cancelled = {}) {
    if (!settings.blocks.enabled || !solid.anchored || !solid.breakable) return;
    const auto anchored = [&](const Fragments& fragments, const Piece& piece) {
        return reaches(settings.anchors, fragments.positions_of(piece), fragments.triangles_of(piece));
    };
    solid.blocks =
        held_blocks(solid.mesh, settings.material.density, settings.blocks, anchored, settings.threads, cancelled);
}

Result<void> check(const SolidSettings& settings) {
    if (std::string fault = fault_of(settings.material); !fault.empty())
        return Error{Status::invalid_setting, std::move(fault)};
    if (!(settings.min_size > 0.0) || !std::isfinite(settings.min_size))
        return Error{Status::invalid_setting,
                     "the least size of a piece is " + std::to_string(settings.min_size) + " m; it must be positive"};
    return {};
}

// The mesh of a piece. Its exterior triangles lie on exterior triangles of `from`; older cuts stay interior.
SolidPiece mesh_of(const SolidPiece& from, const Fragments& fragments, const Piece& piece) {
    SolidPiece solid;
    const auto positions = fragments.positions_of(piece);
    solid.mesh.positions.assign(positions.begin(), positions.end());
    solid.mass = piece.mass;
    solid.mesh.triangles.reserve(piece.triangles.size());
    const uint32_t first_new = from.cut.empty() ? 0 : 1 + *std::ranges::max_element(from.cut);
    for (const bool exterior : {true, false})
        for (uint32_t k = 0; k < piece.triangles.size(); ++k) {
            const uint32_t t = piece.triangles.begin + k;
            const bool outside = k < piece.exterior_triangles && fragments.triangle_source[t] < from.exterior_triangles;
            if (outside != exterior) continue;
            solid.mesh.triangles.push_back(fragments.triangles[t]);
            const uint32_t source = fragments.triangle_source[t];
            if (exterior)
                solid.source.push_back(from.source[source]);
            else
                solid.cut.push_back(k < piece.exterior_triangles ? from.cut[source - from.exterior_triangles]
                                                                 : first_new + source);
        }
    solid.exterior_triangles = static_cast<uint32_t>(solid.source.size());
    return solid;
}

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

std::vector<std::vector<BodyPart>> parts_of_cells(const Fragments& cells, const ConvexPartSettings& settings) {
    ConvexPartSettings few = settings;
    few.max_parts = std::min(settings.max_parts, max_parts_of_cell);
    const std::vector<std::vector<HullPlane>> planes = contact_planes(cells);
    std::vector<std::vector<BodyPart>> parts;
    for (const Piece& piece : cells.pieces) {
        few.hull.planes = planes[parts.size()];
        std::vector<glm::dvec3> outline;
        if (cells.rough_triangles > 0) outline = outline_of(cells, piece);
        few.points = outline;
        parts.push_back(convex_parts(cells.positions_of(piece), cells.triangles_of(piece), piece.mass.volume,
                                     piece.mass.centre_of_mass, few));
    }
    return parts;
}

Error cancelled_error() {
    return {Status::cancelled, "breaking a solid was cancelled"};
}

} // namespace

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
    SolidPiece solid;
    for (const Piece& piece : whole->pieces) { // separate components form one object
        const auto positions = whole->positions_of(piece);
        const auto base = static_cast<uint32_t>(solid.mesh.positions.size());
        solid.mesh.positions.insert(solid.mesh.positions.end(), positions.begin(), positions.end());
        for (uint32_t t = piece.triangles.begin; t < piece.triangles.end; ++t) {
            solid.mesh.triangles.push_back(whole->triangles[t] + base);
            solid.source.push_back(whole->triangle_source[t]);
        }
    }
    solid.exterior_triangles = static_cast<uint32_t>(solid.mesh.triangles.size());
    solid.mass = fracture::mass_properties(solid.mesh.positions, solid.mesh.triangles);
    finish(solid, settings);
    solid.parts = convex_parts(solid.mesh.positions, solid.mesh.triangles, solid.mass.volume, solid.mass.centre_of_mass,
                               settings.parts);
    add_blocks(solid, settings);
    return std::make_shared<const SolidPiece>(std::move(solid));
}

namespace {

// A blow must not wait for its cuts, and no one sees the bumps of crumbs: those are cut flat.
fracture::Roughness roughness_of_blow(const SolidPiece& solid, std::span<const glm::dvec3> sites,
                                      const SolidSettings& settings) {
    fracture::Roughness rough = settings.rough;
    rough.max_triangles = std::min<uint64_t>(rough.max_triangles, max_rough_triangles);
    if (!rough.is_flat() && fracture::rough::typical_distance(solid.mesh, sites) < min_rough_pieces * settings.min_size)
        rough.amount = 0.0;
    return rough;
}

// The pieces of a cut, joined by representative: goes_to[cell] is the first cell of the piece.
Result<std::vector<SolidPtr>> joined_pieces(const SolidPiece& solid, Fragments& cut,
                                            const std::vector<uint32_t>& goes_to, const SolidSettings& settings,
                                            const std::function<bool()>& cancelled) {
    const std::vector<std::vector<BodyPart>> parts = parts_of_cells(cut, settings.parts);
    if (cancelled && cancelled()) return cancelled_error();
    std::vector<glm::dvec3> centres;
    for (const Piece& cell : cut.pieces) centres.push_back(cell.mass.centre_of_mass);
    fracture::Threads threads(settings.threads);
    fracture::merge_pieces(cut, goes_to, threads);

    std::vector<SolidPtr> pieces;
    for (uint32_t cell = 0; cell < goes_to.size(); ++cell) {
        if (goes_to[cell] != cell) continue;
        if (cancelled && cancelled()) return cancelled_error();
        SolidPiece piece = mesh_of(solid, cut, cut.pieces[pieces.size()]);
        finish(piece, settings);
        add_blocks(piece, settings, cancelled);
        for (uint32_t other = 0; other < goes_to.size(); ++other) {
            if (goes_to[other] != cell) continue;
            for (BodyPart part : parts[other]) {
                part.offset += glm::vec3(centres[other] - piece.mass.centre_of_mass);
                piece.parts.push_back(std::move(part));
            }
        }
        if (!piece.breakable) piece.mesh.positions = {};
        pieces.push_back(std::make_shared<const SolidPiece>(std::move(piece)));
    }
    return pieces;
}

// By site: the island of its cell, or a number of its own where the cell holds blocks of several islands.
std::vector<uint32_t> islands_of_cells(const HeldBlocks& blocks, std::span<const uint32_t> islands) {
    const auto sites = static_cast<uint32_t>(blocks.sites.size());
    const uint32_t first_own = *std::ranges::max_element(islands) + 1;
    std::vector<uint32_t> by_cell(sites, first_own + sites);
    for (size_t node = 0; node < blocks.nodes.size(); ++node) {
        uint32_t& island = by_cell[blocks.cells[node]];
        if (island == first_own + sites)
            island = islands[node];
        else if (island != islands[node])
            island = first_own + blocks.cells[node];
    }
    return by_cell;
}

// By piece of a cut by the sites of blocks: the island of its block. Rough cuts need not divide a cell into the pieces
// that flat cuts do, so the block is the one of the piece's cell, or of all for a cell without a block, whose centre is
// nearest.
std::vector<uint32_t> islands_of_pieces(const Fragments& cut, const HeldBlocks& blocks,
                                        std::span<const uint32_t> islands) {
    std::vector<uint32_t> by_piece;
    for (const Piece& piece : cut.pieces) {
        const auto distance = [&](size_t node) {
            const glm::dvec3 apart = blocks.nodes[node].centre - piece.mass.centre_of_mass;
            return std::pair(blocks.cells[node] != piece.site, glm::dot(apart, apart));
        };
        size_t nearest = 0;
        for (size_t node = 1; node < blocks.nodes.size(); ++node)
            if (distance(node) < distance(nearest)) nearest = node;
        by_piece.push_back(islands[nearest]);
    }
    return by_piece;
}

// By piece: the first piece of its island, after islands below the minimum volume have joined the one they touch most.
std::vector<uint32_t> first_of_islands(const Fragments& cut, std::vector<uint32_t> island, double min_volume) {
    for (;;) {
        std::map<uint32_t, double> volumes;
        for (size_t i = 0; i < island.size(); ++i) volumes[island[i]] += cut.pieces[i].mass.volume;
        std::erase_if(volumes, [&](const auto& entry) { return entry.second >= min_volume; });
        std::map<std::pair<uint32_t, uint32_t>, double> contacts; // area by small island and neighbour, m^2
        for (const fracture::Bond& bond : cut.bonds)
            for (const auto& [from, to] : {std::pair(island[bond.a], island[bond.b]), {island[bond.b], island[bond.a]}})
                if (from != to && volumes.contains(from)) contacts[{from, to}] += bond.area;
        const auto widest = std::ranges::max_element(contacts, {}, [](const auto& entry) { return entry.second; });
        if (widest == contacts.end()) break;
        std::ranges::replace(island, widest->first.first, widest->first.second);
    }
    std::vector<uint32_t> first(island.size());
    for (size_t i = 0; i < island.size(); ++i)
        first[i] = static_cast<uint32_t>(std::ranges::find(island, island[i]) - island.begin());
    return first;
}

} // namespace

Result<std::vector<SolidPtr>> break_solid(const SolidPiece& solid, std::span<const glm::dvec3> sites,
                                          std::span<const uint32_t> groups, const SolidSettings& settings,
                                          const std::function<bool()>& cancelled) {
    Result<Fragments> cut = fracture::fracture(solid.mesh, sites,
                                               {.threads = settings.threads,
                                                .merged_later = {groups.begin(), groups.end()},
                                                .rough = roughness_of_blow(solid, sites, settings),
                                                .cancelled = cancelled});
    if (!cut) return cut.error();
    const std::vector<uint32_t> goes_to = fracture::choose_mergers(*cut, {groups, cube(settings.min_size), {}});
    return joined_pieces(solid, *cut, goes_to, settings, cancelled);
}

Result<std::vector<SolidPtr>> break_apart(const SolidPiece& solid, std::span<const uint32_t> islands,
                                          const SolidSettings& settings, const std::function<bool()>& cancelled) {
    assert(solid.blocks && islands.size() == solid.blocks->nodes.size());
    Result<Fragments> cut = fracture::fracture(solid.mesh, solid.blocks->sites,
                                               {.threads = settings.threads,
                                                .merged_later = islands_of_cells(*solid.blocks, islands),
                                                .rough = roughness_of_blow(solid, solid.blocks->sites, settings),
                                                .cancelled = cancelled});
    if (!cut) return cut.error();
    const std::vector<uint32_t> goes_to =
        first_of_islands(*cut, islands_of_pieces(*cut, *solid.blocks, islands), cube(settings.min_size));
    return joined_pieces(solid, *cut, goes_to, settings, cancelled);
}

namespace {

// The solid of a piece, without parts and blocks.
SolidPiece copy_of(const Fragments& fragments, const Piece& piece, const SolidSettings& settings) {
    SolidPiece solid;
    const auto positions = fragments.positions_of(piece);
    const auto triangles = fragments.triangles_of(piece);
    solid.mesh = {{positions.begin(), positions.end()}, {triangles.begin(), triangles.end()}};
    solid.exterior_triangles = piece.exterior_triangles;
    const auto source = fragments.triangle_source.begin() + piece.triangles.begin;
    solid.source.assign(source, source + piece.exterior_triangles);
    solid.cut.assign(source + piece.exterior_triangles, source + piece.triangles.size());
    solid.mass = piece.mass;
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
            add_blocks(solid, settings);
            solids[i] = std::make_shared<const SolidPiece>(std::move(solid));
        }
    });
    return solids;
}

} // namespace brittle::physics

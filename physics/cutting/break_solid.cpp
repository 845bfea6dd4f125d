// Cuts of solids: by the sites of a blow, and between the blocks of a held one.
#include <algorithm>
#include <cassert>
#include <limits>
#include <map>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/base/threads.h"
#include "fracture/fracture.h"
#include "fracture/pieces/merge.h"
#include "fracture/rough/rough.h"
#include "physics/cutting/break_near.h"
#include "physics/cutting/job_threads.h"
#include "physics/cutting/solid_maker.h"

namespace brittle::physics {

namespace {

using fracture::Error;
using fracture::Fragments;
using fracture::Piece;
using fracture::Result;
using fracture::Status;

// See Roughness::max_triangles.
constexpr uint64_t max_rough_triangles = 100'000;

// The least typical distance of the sites of a rough cut, in units of the minimum size of a piece.
constexpr double min_rough_pieces = 3.0;

Error cancelled_error() {
    return {Status::cancelled, "breaking a solid was cancelled"};
}

// Triangles all over a surface.
fracture::TriangleMesh sample_of(const fracture::ClusterMesh& clusters) {
    constexpr uint32_t enough = 64; // clusters
    fracture::TriangleMesh sample;
    clusters.visit_some(enough, [&](const fracture::ClusterPtr& cluster) {
        const auto base = static_cast<uint32_t>(sample.positions.size());
        sample.positions.insert(sample.positions.end(), cluster->positions.begin(), cluster->positions.end());
        for (const auto& [a, b, c] : cluster->triangles) sample.triangles.emplace_back(base + a, base + b, base + c);
    });
    return sample;
}

// A blow must not wait for its cuts, and no one sees the bumps of crumbs: those are cut flat.
fracture::Roughness roughness_of_blow(const SolidPiece& solid, std::span<const glm::dvec3> sites,
                                      const SolidSettings& settings) {
    fracture::Roughness rough = settings.rough;
    rough.max_triangles = std::min<uint64_t>(rough.max_triangles, max_rough_triangles);
    if (rough.is_flat()) return rough;
    const double distance = fracture::rough::typical_distance(
        solid.is_clustered() ? sample_of(solid.clusters) : solid.surface().mesh, sites);
    if (distance < min_rough_pieces * settings.min_size) rough.amount = 0.0;
    if (!(rough.wavelength > 0.0)) rough.wavelength = distance;
    return rough;
}

// The pieces of a cut, joined by representative: goes_to[cell] is the first cell of the piece.
Result<std::vector<SolidPtr>> joined_pieces(const SolidPiece& solid, Fragments& cut,
                                            const std::vector<uint32_t>& goes_to, const SolidSettings& settings,
                                            const std::function<bool()>& cancelled) {
    const std::vector<uint32_t> of_input = tags_of(solid.surface());
    const CutTags tags(cut, of_input, solid);
    const std::vector<std::vector<BodyPart>> parts =
        parts_of_cells(cut, settings.parts, threads_of(settings.hull_threads));
    if (cancelled && cancelled()) return cancelled_error();
    std::vector<glm::dvec3> centres;
    for (const Piece& cell : cut.pieces) centres.push_back(cell.mass.centre_of_mass);
    fracture::Threads threads(settings.threads);
    fracture::merge_pieces(cut, goes_to, threads);

    std::vector<SolidPtr> pieces;
    for (uint32_t cell = 0; cell < goes_to.size(); ++cell) {
        if (goes_to[cell] != cell) continue;
        if (cancelled && cancelled()) return cancelled_error();
        SolidPiece piece = solid_from(cut, cut.pieces[pieces.size()], tags, settings, cancelled);
        for (uint32_t other = 0; other < goes_to.size(); ++other)
            if (goes_to[other] == cell) add_parts(parts[other], centres[other], piece);
        if (!piece.breakable) piece.drop_cut_data();
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
                                          const std::function<bool()>& cancelled, CrackBudget* budget) {
    const fracture::Roughness rough = roughness_of_blow(solid, sites, settings);
    if (auto pieces = break_near(solid, sites, groups, rough, settings, cancelled, budget)) return *std::move(pieces);
    Result<Fragments> cut = fracture::fracture(solid.surface().mesh, sites,
                                               {.threads = settings.threads,
                                                .merged_later = {groups.begin(), groups.end()},
                                                .rough = rough,
                                                .cancelled = cancelled});
    if (!cut) return cut.error();
    const std::vector<uint32_t> goes_to = fracture::choose_mergers(*cut, {groups, cube(settings.min_size), {}});
    if (budget) budget->surface = crack_surface(*cut, goes_to);
    if (budget && budget->exceeded()) return std::vector<SolidPtr>();
    return joined_pieces(solid, *cut, goes_to, settings, cancelled);
}

Result<std::vector<SolidPtr>> break_apart(const SolidPiece& solid, std::span<const uint32_t> islands,
                                          const SolidSettings& settings, const std::function<bool()>& cancelled) {
    assert(solid.blocks && islands.size() == solid.blocks->nodes.size());
    Result<Fragments> cut = fracture::fracture(solid.surface().mesh, solid.blocks->sites,
                                               {.threads = settings.threads,
                                                .merged_later = islands_of_cells(*solid.blocks, islands),
                                                .rough = roughness_of_blow(solid, solid.blocks->sites, settings),
                                                .cancelled = cancelled});
    if (!cut) return cut.error();
    const std::vector<uint32_t> goes_to =
        first_of_islands(*cut, islands_of_pieces(*cut, *solid.blocks, islands), cube(settings.min_size));
    return joined_pieces(solid, *cut, goes_to, settings, cancelled);
}

} // namespace brittle::physics

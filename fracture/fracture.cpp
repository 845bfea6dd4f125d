#include "fracture/fracture.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include <glm/common.hpp>

#include "fracture/exact/exact.h"
#include "fracture/half_edge.h"
#include "fracture/islands.h"
#include "fracture/mass_properties.h"
#include "fracture/sequential.h"
#include "fracture/topology.h"

namespace brittle::fracture {

namespace {

// Coordinates beyond this overflow in the inertia tensor, of degree five; in metres.
constexpr double largest_coordinate = 1e50;

// Half-edges are counted in 32 bits, and cutting adds to them.
constexpr size_t most_triangles = size_t{1} << 28;

constexpr uint32_t most_threads = 1024;

// Below this share of area times size of the box a volume is rounding.
constexpr double least_volume = 1e-15;

bool in_range(const glm::dvec3& p) {
    // Comparisons with NaN are false.
    return std::abs(p.x) <= largest_coordinate && std::abs(p.y) <= largest_coordinate
           && std::abs(p.z) <= largest_coordinate;
}

std::string format(const glm::dvec3& p) {
    char text[128];
    std::snprintf(text, sizeof text, "(%g, %g, %g)", p.x, p.y, p.z);
    return text;
}

Error invalid_mesh(std::string message) {
    return {Status::invalid_mesh, std::move(message)};
}

Result<void> check_values(const TriangleMesh& mesh) {
    if (mesh.triangles.empty()) return Error{Status::empty_mesh, "the mesh has no triangles"};
    if (mesh.triangles.size() > most_triangles)
        return invalid_mesh("the mesh has " + std::to_string(mesh.triangles.size()) + " triangles; at most "
                            + std::to_string(most_triangles) + " can be cut");
    for (size_t i = 0; i < mesh.positions.size(); ++i)
        if (!in_range(mesh.positions[i]))
            return invalid_mesh("vertex " + std::to_string(i) + " is at " + format(mesh.positions[i])
                                + "; coordinates must be finite and at most 1e50");
    for (size_t i = 0; i < mesh.triangles.size(); ++i) {
        const Triangle& t = mesh.triangles[i];
        const uint32_t highest = std::max({t.x, t.y, t.z});
        if (highest >= mesh.positions.size())
            return invalid_mesh("triangle " + std::to_string(i) + " names vertex " + std::to_string(highest)
                                + ", but the mesh has only " + std::to_string(mesh.positions.size()));
    }
    return {};
}

Result<void> check_sites(std::span<const glm::dvec3> sites) {
    if (sites.empty()) return Error{Status::invalid_sites, "there are no sites; give at least one"};
    if (sites.size() >= no_index)
        return Error{Status::invalid_sites,
                     "there are " + std::to_string(sites.size()) + " sites, which is too many"};
    for (size_t i = 0; i < sites.size(); ++i)
        if (!in_range(sites[i]))
            return Error{Status::invalid_sites, "site " + std::to_string(i) + " is at " + format(sites[i])
                                                    + "; coordinates must be finite and at most 1e50"};
    return {};
}

Result<void> check_volume(const TriangleMesh& mesh) {
    const double diagonal = glm::length(bounds(mesh).size());
    // Most solids fill more than this of their box; the area, which costs more than the volume, need not be known.
    if (signed_volume(mesh.positions, mesh.triangles) > 1e-6 * diagonal * diagonal * diagonal) return {};
    const MassProperties mass = mass_properties(mesh.positions, mesh.triangles);
    if (std::abs(mass.volume) <= least_volume * mass.area * diagonal)
        return invalid_mesh("the mesh encloses no volume");
    if (mass.volume < 0.0)
        return invalid_mesh("the mesh is inside out: its volume is " + std::to_string(mass.volume)
                            + "; reverse its triangles");
    return {};
}

// Whether a face and its only neighbour are the two sides of one triangle: a component of no volume whose
// edges are paired, but the only kind of closed mesh in which a cut could leave a loop of two edges.
bool is_two_sided(const HalfEdgeMesh& mesh, uint32_t face) {
    const uint32_t a = mesh.faces[face];
    const uint32_t b = mesh[a].next;
    const uint32_t c = mesh[b].next;
    const uint32_t across = mesh[mesh[a].twin].face;
    return mesh[mesh[b].twin].face == across && mesh[mesh[c].twin].face == across;
}

Result<HalfEdgeMesh> build_solid(const TriangleMesh& mesh) {
    Result<HalfEdgeMesh> built = build_half_edges(mesh.positions, mesh.triangles);
    if (!built) return built;

    std::vector<uint32_t> solid;
    for (uint32_t face = 0; face < built->faces.size(); ++face)
        if (!is_two_sided(*built, face)) solid.push_back(face);
    if (solid.size() == built->faces.size()) return built;
    HalfEdgeMesh without;
    for (const glm::dvec3& p : built->positions) add_vertex(without, p);
    for (const uint32_t face : solid)
        if (add_face(without, corners(*built, face), built->sources[face]) != AddFace::added)
            return invalid_mesh("triangle " + std::to_string(face) + " is not manifold");
    return without;
}

// Removes pieces without volume: where a bisector runs along a face of the solid, symbolic perturbation may leave a
// sheet of no thickness in the cell across. Its neighbours are closed without it.
void drop_flat_pieces(Fragments& fragments, double extent) {
    std::vector<uint32_t> renumbered(fragments.pieces.size(), no_index);
    std::vector<Piece> kept;
    for (size_t i = 0; i < fragments.pieces.size(); ++i) {
        const Piece& piece = fragments.pieces[i];
        if (is_flat(piece.mass, fragments.positions_of(piece), extent)) continue;
        renumbered[i] = static_cast<uint32_t>(kept.size());
        kept.push_back(piece);
    }
    if (kept.size() == fragments.pieces.size()) return;

    Fragments packed;
    for (Piece& piece : kept) {
        const auto move = [](const auto& from, Range& range, auto& to) {
            const auto begin = static_cast<uint32_t>(to.size());
            to.insert(to.end(), from.begin() + range.begin, from.begin() + range.end);
            range = {begin, static_cast<uint32_t>(to.size())};
        };
        Range points = piece.vertices, sources = piece.triangles;
        move(fragments.vertex_point, points, packed.vertex_point);
        move(fragments.positions, piece.vertices, packed.positions);
        move(fragments.triangle_source, sources, packed.triangle_source);
        move(fragments.triangles, piece.triangles, packed.triangles);
    }
    for (Bond bond : fragments.bonds) {
        bond.a = renumbered[bond.a];
        bond.b = renumbered[bond.b];
        if (bond.a != no_index && bond.b != no_index) packed.bonds.push_back(bond);
    }
    packed.pieces = std::move(kept);
    packed.timings = std::move(fragments.timings);
    fragments = std::move(packed);
}

double largest_extent(const TriangleMesh& mesh) {
    const Box box = bounds(mesh);
    const glm::dvec3 furthest = glm::max(glm::abs(box.min), glm::abs(box.max));
    return std::max({furthest.x, furthest.y, furthest.z});
}

Result<Fragments> run_exact(const TriangleMesh& mesh, std::span<const glm::dvec3> sites, const Settings& settings) {
    Result<Fragments> fragments = exact::fracture_exact(mesh, sites, settings);
    if (fragments) drop_flat_pieces(*fragments, largest_extent(mesh));
    return fragments;
}

Result<Fragments> run_sequential(const TriangleMesh& mesh, std::span<const glm::dvec3> sites,
                                 const Settings& settings) {
    const Result<HalfEdgeMesh> solid = build_solid(mesh);
    if (!solid) return solid.error();
    return fracture_sequential(*solid, sites, settings);
}

} // namespace

Result<Fragments> fracture(const TriangleMesh& mesh, std::span<const glm::dvec3> sites, const Settings& settings) {
    const auto start = std::chrono::steady_clock::now();
    if (settings.threads > most_threads)
        return Error{Status::invalid_setting, "threads is " + std::to_string(settings.threads) + "; at most "
                                                  + std::to_string(most_threads) + ", or 0 for one a core"};
    if (Result<void> checked = check_values(mesh); !checked) return checked.error();
    if (Result<void> checked = check_sites(sites); !checked) return checked.error();
    const TopologyReport report = check_topology(mesh.positions.size(), mesh.triangles);
    if (!report.closed()) return invalid_mesh("the mesh does not bound a solid: " + describe(report));
    if (Result<void> checked = check_volume(mesh); !checked) return checked.error();
    // Solids that touch in a vertex are cut as if they did not.
    const TriangleMesh split = report.manifold() ? TriangleMesh{} : split_fans(mesh);
    const TriangleMesh& manifold = report.manifold() ? mesh : split;
    const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - start;

    const auto run = settings.algorithm == Algorithm::exact ? run_exact : run_sequential;
    Result<Fragments> fragments = run(manifold, sites, settings);
    if (fragments) fragments->timings.insert(fragments->timings.begin(), {"validate", elapsed.count()});
    return fragments;
}

} // namespace brittle::fracture

#include "tools/stress/check_local.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <optional>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/fracture.h"
#include "fracture/local/local_cut.h"
#include "fracture/mesh/topology.h"
#include "fracture/pieces/merge.h"

namespace brittle::stress {

using namespace fracture;

namespace {

constexpr size_t enough_triangles = 4000, max_triangles = 40'000;
constexpr size_t max_sites = 40;
constexpr uint32_t shell_sites = 32;
constexpr double share = 0.08; // radius of the cut part by the size of the mesh

// Each triangle becomes four, by the middles of its edges.
TriangleMesh divided(const TriangleMesh& mesh) {
    TriangleMesh fine{mesh.positions, {}};
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
    const auto middle = [&](uint32_t a, uint32_t b) {
        const auto [at, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<uint32_t>(fine.positions.size()));
        if (is_new) fine.positions.push_back(0.5 * (mesh.positions[a] + mesh.positions[b]));
        return at->second;
    };
    for (const Triangle& t : mesh.triangles) {
        const uint32_t xy = middle(t.x, t.y), yz = middle(t.y, t.z), zx = middle(t.z, t.x);
        for (const Triangle& part :
             {Triangle(t.x, xy, zx), Triangle(t.y, yz, xy), Triangle(t.z, zx, yz), Triangle(xy, yz, zx)})
            fine.triangles.push_back(part);
    }
    return fine;
}

std::string mismatch(const char* what, double one, double other) {
    char text[160];
    std::snprintf(text, sizeof text, "near the blow: %s %.17g, of the whole cut %.17g", what, one, other);
    return text;
}

} // namespace

std::string local_complaint(const Case& c) {
    if (!c.simple || c.expect != Expect::pieces || c.mesh.triangles.size() > max_triangles / 4) return {};
    TriangleMesh mesh = c.mesh;
    while (mesh.triangles.size() < enough_triangles) mesh = divided(mesh);
    const TopologyReport report = check_topology(mesh.positions.size(), mesh.triangles);
    if (!report.manifold()) return {};
    Threads threads(1);
    const ClusterMesh clusters(mesh, std::vector<uint32_t>(mesh.triangles.size(), 0), threads);
    if (!clusters.is_connected()) return {};

    const Box box = bounds(mesh);
    const double size = glm::length(box.size());
    const glm::dvec3 at = mesh.positions[mesh.triangles[mesh.triangles.size() / 2].x];
    std::vector<glm::dvec3> sites;
    std::vector<uint32_t> groups;
    double reach = 0.0;
    for (const glm::dvec3& site : c.sites) reach = std::max(reach, glm::distance(site, box.centre()));
    for (size_t k = 0; k < std::min(c.sites.size(), max_sites); ++k) {
        sites.push_back(at + (c.sites[k] - box.centre()) * (share * size / std::max(reach, 1e-300)));
        groups.push_back(static_cast<uint32_t>(k));
    }
    const auto rest = static_cast<uint32_t>(sites.size());
    for (uint32_t k = 0; k < shell_sites; ++k) {
        const double z = 1.0 - (2.0 * k + 1.0) / shell_sites, r = std::sqrt(1.0 - z * z);
        const double angle = std::numbers::pi * (3.0 - std::sqrt(5.0)) * k;
        sites.push_back(at + 1.5 * share * size * glm::dvec3(r * std::cos(angle), r * std::sin(angle), z));
        groups.push_back(rest);
    }

    std::optional<LocalCut> cut = LocalCut::make(clusters, sites, groups, rest, {.threads = 1});
    if (!cut) return {};
    const Result<Fragments> whole = fracture::fracture(mesh, sites, {.threads = 1});
    if (!whole) return {};
    const MassProperties before = mass_properties(mesh.positions, mesh.triangles);
    const glm::dvec3 furthest = glm::max(glm::abs(box.min), glm::abs(box.max));
    const double rounding =
        1e-12 * before.volume + 64 * 0x1p-53 * before.area * std::max({furthest.x, furthest.y, furthest.z});
    std::vector<double> near(sites.size(), 0.0), all(sites.size(), 0.0); // volumes by site
    for (const Piece& piece : cut->cells.pieces) near[piece.site] += piece.mass.volume;
    for (const Piece& piece : whole->pieces) all[piece.site] += piece.mass.volume;
    for (size_t k = 0; k < rest; ++k)
        if (std::abs(near[k] - all[k]) > rounding) return mismatch("a cell has the volume", near[k], all[k]);

    merge_pieces(cut->cells, choose_mergers(cut->cells, {.group_of_site = groups}), threads);
    double taken = 0.0;
    for (const Piece& piece : cut->cells.pieces) {
        if (cut->is_open(piece)) continue;
        if (!check_topology(piece.vertices.size(), cut->cells.triangles_of(piece)).closed())
            return "near the blow: a piece is not closed";
        taken += piece.mass.volume;
    }
    const std::vector<LocalCut::Rest> remains = cut->rest(before, [](uint32_t, bool) { return 0u; });
    if (remains.empty()) return {};
    double left = 0.0;
    for (const LocalCut::Rest& part : remains) {
        const TriangleMesh flat = part.mesh.flatten();
        if (!check_topology(flat.positions.size(), flat.triangles).closed())
            return "near the blow: what remains is not closed";
        const double volume = signed_volume(flat.positions, flat.triangles);
        if (std::abs(volume - part.mass.volume) > rounding)
            return mismatch("what remains has the volume", part.mass.volume, volume);
        left += volume;
    }
    if (std::abs(left + taken - before.volume) > rounding)
        return mismatch("all pieces have the volume", left + taken, before.volume);
    return {};
}

} // namespace brittle::stress

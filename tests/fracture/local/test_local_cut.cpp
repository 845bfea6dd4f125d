#include "fracture/local/local_cut.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/base/random.h"
#include "fracture/fracture.h"
#include "fracture/local/lids.h"
#include "fracture/mesh/topology.h"
#include "fracture/pieces/merge.h"
#include "fracture/shapes/shapes.h"

using namespace brittle::fracture;

namespace {

ClusterMesh clusters_of(const TriangleMesh& mesh) {
    std::vector<uint32_t> tags(mesh.triangles.size());
    std::iota(tags.begin(), tags.end(), 0u);
    Threads threads(1);
    return {mesh, tags, threads};
}

struct Blow {
    std::vector<glm::dvec3> sites;
    std::vector<uint32_t> groups; // by site; those of the shell are the rest
    uint32_t rest = 0;
};

glm::dvec3 direction(Random& random) {
    const double z = 2.0 * random.uniform() - 1.0, angle = 2.0 * std::numbers::pi * random.uniform();
    const double r = std::sqrt(1.0 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
}

// Sites in a ball around a point, and a shell of sites of the rest around them.
Blow blow_at(const glm::dvec3& point, double radius, uint32_t pieces, Random& random) {
    Blow blow;
    for (uint32_t k = 0; k < pieces; ++k) {
        const glm::dvec3 to = direction(random);
        blow.sites.push_back(point + radius * std::cbrt(random.uniform()) * to);
        blow.groups.push_back(k);
    }
    blow.rest = pieces;
    for (uint32_t k = 0; k < 32; ++k) {
        const double z = 1.0 - (2.0 * k + 1.0) / 32.0, r = std::sqrt(1.0 - z * z), angle = 2.399963 * k;
        blow.sites.push_back(point + 1.5 * radius * glm::dvec3(r * std::cos(angle), r * std::sin(angle), z));
        blow.groups.push_back(blow.rest);
    }
    return blow;
}

std::vector<double> volumes_of(const Fragments& fragments, const Blow& blow, const LocalCut* cut) {
    std::vector<double> volumes;
    for (const Piece& piece : fragments.pieces)
        if (blow.groups[piece.site] != blow.rest && !(cut && cut->is_open(piece))) volumes.push_back(piece.mass.volume);
    std::ranges::sort(volumes);
    return volumes;
}

// Cuts near the blow and as a whole, and compares. Returns what remains; nothing where only the whole can be cut.
std::vector<LocalCut::Rest> compare(const ClusterMesh& clusters, const TriangleMesh& mesh, const Blow& blow,
                                    double min_volume = 0.0, const Roughness& rough = {}) {
    std::optional<LocalCut> cut =
        LocalCut::make(clusters, blow.sites, blow.groups, blow.rest, {.threads = 1, .rough = rough});
    if (!cut) return {};
    Threads threads(1);
    const MergeRules rules{blow.groups, min_volume, {}, {}};
    merge_pieces(cut->cells, choose_mergers(cut->cells, rules), threads);
    Result<Fragments> whole =
        brittle::fracture::fracture(mesh, blow.sites, {.threads = 1, .merged_later = blow.groups, .rough = rough});
    REQUIRE(whole.has_value());
    merge_pieces(*whole, choose_mergers(*whole, rules), threads);

    const std::vector<double> near = volumes_of(cut->cells, blow, &*cut), all = volumes_of(*whole, blow, nullptr);
    REQUIRE(near.size() == all.size());
    const double tolerance = rough.is_flat() ? 1e-9 : 1e-3; // the points inside of rough cuts lie elsewhere
    for (size_t k = 0; k < all.size(); ++k) CHECK(near[k] == doctest::Approx(all[k]).epsilon(tolerance));
    double taken = 0.0;
    for (const Piece& piece : cut->cells.pieces) {
        if (cut->is_open(piece)) continue;
        const TopologyReport report = check_topology(piece.vertices.size(), cut->cells.triangles_of(piece));
        CHECK(report.closed());
        taken += piece.mass.volume;
    }
    const MassProperties before = mass_properties(mesh.positions, mesh.triangles);
    const auto rest = cut->rest(before, [&](uint32_t t, bool exterior) {
        return exterior ? cut->tags()[cut->cells.triangle_source[t]] : 0x80000000u;
    });
    if (rest.empty()) return {};
    double left = 0.0;
    for (const LocalCut::Rest& part : rest) {
        const TriangleMesh flat = part.mesh.flatten();
        CHECK(describe(check_topology(flat.positions.size(), flat.triangles)) == "");
        CHECK(part.mesh.is_connected());
        const MassProperties mass = mass_properties(flat.positions, flat.triangles);
        left += mass.volume;
        CHECK(part.mass.volume == doctest::Approx(mass.volume).epsilon(1e-10));
        CHECK(part.mass.area == doctest::Approx(mass.area).epsilon(1e-9));
        CHECK(glm::distance(part.mass.centre_of_mass, mass.centre_of_mass) < 1e-9);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                CHECK(std::abs(part.mass.inertia[i][j] - mass.inertia[i][j]) < 1e-9 * glm::length(before.inertia[0]));
    }
    CHECK(left + taken == doctest::Approx(before.volume).epsilon(1e-12));
    return rest;
}

} // namespace

TEST_CASE("local cut: pieces are those of a cut of the whole mesh, and the rest is a closed manifold") {
    const std::vector<TriangleMesh> meshes{icosphere(5), torus(120, 80), four_legged_animal(64),
                                           torus_knot(2, 3, 400, 24)};
    Random random(3);
    int cuts = 0, tries = 0;
    for (const TriangleMesh& mesh : meshes) {
        const ClusterMesh clusters = clusters_of(mesh);
        const double size = glm::length(bounds(mesh).size());
        for (const double share : {0.03, 0.06, 0.1})
            for (int k = 0; k < 6; ++k) {
                const auto at = static_cast<size_t>(random.uniform() * static_cast<double>(mesh.positions.size()));
                const Blow blow = blow_at(mesh.positions[at], share * size, 10, random);
                ++tries;
                cuts += compare(clusters, mesh, blow).empty() ? 0 : 1;
            }
    }
    CHECK(cuts > tries / 2);
}

TEST_CASE("local cut: blow after blow, each to what the one before has left") {
    Random random(11);
    for (TriangleMesh mesh : {icosphere(5), torus(120, 80)}) {
        ClusterMesh clusters = clusters_of(mesh);
        int cuts = 0;
        for (int k = 0; k < 25; ++k) {
            const auto at = static_cast<size_t>(random.uniform() * static_cast<double>(mesh.positions.size()));
            const Blow blow = blow_at(mesh.positions[at], 0.12, 8, random);
            const auto rest = compare(clusters, mesh, blow, k % 2 == 0 ? 1e-5 : 0.0);
            if (rest.empty()) continue;
            ++cuts;
            clusters = rest[0].mesh;
            mesh = clusters.flatten();
        }
        CHECK(cuts > 15);
    }
}

TEST_CASE("local cut: a solid that falls apart leaves several parts, and a cavity calls for a cut of the whole") {
    // A ring without a piece of it is one part; without another one, it is two.
    TriangleMesh mesh = torus(240, 60, 1.0, 0.15);
    ClusterMesh clusters = clusters_of(mesh);
    Random random(29);
    std::vector<LocalCut::Rest> rest;
    for (const double x : {1.0, -1.0}) {
        const Box box = bounds(mesh);
        glm::dvec3 at(x > 0.0 ? box.max.x : box.min.x, box.centre().y, box.centre().z);
        const double thick = box.size().y; // of the tube
        at.x -= x * 0.5 * thick;
        rest = compare(clusters, mesh, blow_at(at, 0.75 * thick, 12, random));
        REQUIRE(rest.size() == (x > 0.0 ? 1 : 2));
        clusters = rest[0].mesh;
        mesh = clusters.flatten();
    }
    CHECK(rest[0].mesh.triangle_count() >= rest[1].mesh.triangle_count());
    CHECK(rest[0].mass.volume == doctest::Approx(rest[1].mass.volume).epsilon(0.3));
    // Pieces around a point deep inside leave a cavity.
    const TriangleMesh ball = icosphere(5);
    const Blow inside = blow_at(glm::dvec3(0.7, 0.0, 0.0), 0.12, 8, random);
    CHECK(compare(clusters_of(ball), ball, inside).empty());
}

TEST_CASE("local cut: rough cuts, on dense and on coarse surfaces") {
    Random random(17);
    for (const TriangleMesh& mesh : {icosphere(5), torus(120, 80), icosphere(4)}) {
        const ClusterMesh clusters = clusters_of(mesh);
        int cuts = 0;
        for (int k = 0; k < 8; ++k) {
            const auto at = static_cast<size_t>(random.uniform() * static_cast<double>(mesh.positions.size()));
            const Blow blow = blow_at(mesh.positions[at], 0.12, 8, random);
            const Roughness rough{.amount = k % 2 == 0 ? 0.3 : 0.8, .wavelength = 0.1, .seed = 5u + k};
            cuts += compare(clusters, mesh, blow, 1e-6, rough).empty() ? 0 : 1;
        }
        CHECK(cuts >= 4);
    }
}

TEST_CASE("local cut: sites in special position") {
    // A lattice of sites whose bisectors run through vertices, edges and faces of a lattice of triangles.
    TriangleMesh plate;
    constexpr uint32_t side = 64;
    const auto vertex = [](uint32_t layer, uint32_t x, uint32_t y) {
        return (layer * (side + 1) + y) * (side + 1) + x;
    };
    for (uint32_t layer = 0; layer < 2; ++layer)
        for (uint32_t y = 0; y <= side; ++y)
            for (uint32_t x = 0; x <= side; ++x) plate.positions.emplace_back(x, 4.0 * layer, y);
    const auto quad = [&](uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
        plate.triangles.emplace_back(a, b, c);
        plate.triangles.emplace_back(a, c, d);
    };
    for (uint32_t y = 0; y < side; ++y)
        for (uint32_t x = 0; x < side; ++x) {
            quad(vertex(1, x, y), vertex(1, x, y + 1), vertex(1, x + 1, y + 1), vertex(1, x + 1, y));
            quad(vertex(0, x, y), vertex(0, x + 1, y), vertex(0, x + 1, y + 1), vertex(0, x, y + 1));
        }
    for (uint32_t k = 0; k < side; ++k) {
        quad(vertex(0, k, side), vertex(0, k + 1, side), vertex(1, k + 1, side), vertex(1, k, side));
        quad(vertex(0, k + 1, 0), vertex(0, k, 0), vertex(1, k, 0), vertex(1, k + 1, 0));
        quad(vertex(0, side, k + 1), vertex(0, side, k), vertex(1, side, k), vertex(1, side, k + 1));
        quad(vertex(0, 0, k), vertex(0, 0, k + 1), vertex(1, 0, k + 1), vertex(1, 0, k));
    }
    REQUIRE(check_topology(plate.positions.size(), plate.triangles).manifold());
    Blow blow;
    for (int x = -2; x <= 2; ++x)
        for (int y = -2; y <= 2; ++y)
            for (int z = -2; z <= 2; ++z) {
                const bool inner = std::max({std::abs(x), std::abs(y), std::abs(z)}) < 2;
                blow.sites.emplace_back(30 + 2 * x, 4 + 2 * y, 30 + 2 * z);
                blow.groups.push_back(inner ? static_cast<uint32_t>(blow.groups.size()) : 1000u);
            }
    blow.rest = 1000;
    CHECK(compare(clusters_of(plate), plate, blow).size() == 1);
}

TEST_CASE("local cut: where the cells reach over the mesh, or out of its surroundings, the whole is to be cut") {
    const TriangleMesh mesh = icosphere(5);
    const ClusterMesh clusters = clusters_of(mesh);
    Random random(5);
    const Blow wide = blow_at(mesh.positions[0], 1.5, 8, random);
    CHECK_FALSE(LocalCut::make(clusters, wide.sites, wide.groups, wide.rest, {}).has_value());
    Blow open = blow_at(mesh.positions[0], 0.1, 8, random);
    for (size_t k = 8; k < open.sites.size(); ++k)
        open.sites[k] = mesh.positions[0] - 0.1 * double(k) * glm::dvec3(1.0);
    CHECK_FALSE(LocalCut::make(clusters, open.sites, open.groups, open.rest, {}).has_value());
    const Blow miss = blow_at(glm::dvec3(1.6, 0.0, 0.0), 0.1, 8, random);
    CHECK_FALSE(LocalCut::make(clusters, miss.sites, miss.groups, miss.rest, {}).has_value());
    const Blow small = blow_at(mesh.positions[0], 0.1, 8, random);
    CHECK(LocalCut::make(clusters, small.sites, small.groups, small.rest, {}).has_value());
    CHECK_FALSE(LocalCut::make(clusters, small.sites, small.groups, small.rest, {.cancelled = [] { return true; }})
                    .has_value());
}

TEST_CASE("lids: they close a patch, also where its border touches itself, and stay outside the region") {
    // Of a plane of triangles: two squares that touch in a corner.
    TriangleMesh patch;
    std::vector<uint8_t> inner;
    for (int y = 0; y <= 8; ++y)
        for (int x = 0; x <= 8; ++x) {
            patch.positions.emplace_back(x, 0.0, y);
            inner.push_back(0);
        }
    for (uint32_t y = 0; y < 8; ++y)
        for (uint32_t x = 0; x < 8; ++x) {
            if ((x < 4) != (y < 4)) continue;
            const uint32_t a = 9 * y + x;
            patch.triangles.emplace_back(a, a + 9, a + 10);
            patch.triangles.emplace_back(a, a + 10, a + 1);
        }
    const auto border = border_loops(patch.triangles, inner);
    size_t edges = 0;
    for (const auto& loop : border) edges += loop.size();
    CHECK(edges == 32);
    const TriangleMesh open = patch;
    std::vector<uint32_t> original;
    const Box region{{1.0, -1.0, 1.0}, {3.0, 1.0, 3.0}};
    REQUIRE(add_lids(patch, border, region, original));
    CHECK(check_topology(patch.positions.size(), patch.triangles).manifold());
    REQUIRE(original.size() == patch.positions.size());
    for (size_t t = 0; t < open.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            CHECK(original[patch.triangles[t][k]] == open.triangles[t][k]);
            CHECK(patch.positions[patch.triangles[t][k]] == open.positions[open.triangles[t][k]]);
        }
    const glm::dvec3 size = bounds(patch).size();
    add_boxes(patch, -2);
    CHECK(check_topology(patch.positions.size(), patch.triangles).manifold());
    for (int k = 0; k < 3; ++k) CHECK(bounds(patch).size()[k] > size[k]);
}

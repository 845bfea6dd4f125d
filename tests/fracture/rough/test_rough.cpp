// Rough cuts: the same promises as flat ones, checked without their code.
#include "fracture/rough/rough.h"

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/base/random.h"
#include "fracture/fracture.h"
#include "fracture/mesh/intersections.h"
#include "fracture/pieces/certificate.h"
#include "fracture/pieces/merge.h"
#include "fracture/rough/crossings.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"

using namespace brittle::fracture;

namespace {

Fragments rough_pieces(const TriangleMesh& mesh, std::span<const glm::dvec3> sites, const Settings& settings) {
    auto pieces = brittle::fracture::fracture(mesh, sites, settings);
    REQUIRE_MESSAGE(pieces, (pieces ? "" : pieces.error().message));
    return *std::move(pieces);
}

uint64_t crossings(const Fragments& pieces) {
    uint64_t sum = 0;
    for (const Piece& piece : pieces.pieces) {
        TriangleMesh mesh;
        const auto positions = pieces.positions_of(piece);
        const auto triangles = pieces.triangles_of(piece);
        mesh.positions.assign(positions.begin(), positions.end());
        mesh.triangles.assign(triangles.begin(), triangles.end());
        sum += find_intersections(mesh, 10'000'000).pairs;
    }
    return sum;
}

// Every triangle of a cut occurs twice, in opposite orientations, with equal bits.
bool cuts_pair_up(const Fragments& pieces) {
    using Point = std::array<double, 3>;
    std::map<std::array<Point, 3>, int> sides;
    for (const Piece& piece : pieces.pieces) {
        const auto positions = pieces.positions_of(piece);
        for (const Triangle& t : pieces.triangles_of(piece).subspan(piece.exterior_triangles)) {
            std::array<Point, 3> corners;
            for (int k = 0; k < 3; ++k) corners[k] = {positions[t[k]].x, positions[t[k]].y, positions[t[k]].z};
            std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
            const bool turned = corners[2] < corners[1];
            if (turned) std::swap(corners[1], corners[2]);
            sides[corners] += turned ? -1 : 1;
        }
    }
    return std::all_of(sides.begin(), sides.end(), [](const auto& side) { return side.second == 0; });
}

// Exterior triangles lie in the plane of their source, face its way, and together cover it.
void check_outside(const TriangleMesh& mesh, const Fragments& pieces) {
    std::vector<double> area(mesh.triangles.size(), 0.0);
    const auto normal = [&](const Triangle& t) {
        const glm::dvec3& a = mesh.positions[t.x];
        return glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a);
    };
    const double size = glm::length(bounds(mesh).size());
    double furthest = 0.0;
    for (const Piece& piece : pieces.pieces) {
        const auto positions = pieces.positions_of(piece);
        for (uint32_t k = 0; k < piece.exterior_triangles; ++k) {
            const uint32_t source = pieces.triangle_source[piece.triangles.begin + k];
            REQUIRE(source < mesh.triangles.size());
            const Triangle& t = pieces.triangles_of(piece)[k];
            const glm::dvec3 n = glm::normalize(normal(mesh.triangles[source]));
            const glm::dvec3 &a = positions[t.x], &b = positions[t.y], &c = positions[t.z];
            area[source] += 0.5 * glm::dot(glm::cross(b - a, c - a), n);
            for (const glm::dvec3& p : {a, b, c})
                furthest = std::max(furthest, std::abs(glm::dot(n, p - mesh.positions[mesh.triangles[source].x])));
        }
    }
    CHECK(furthest < 1e-13 * size);
    double missing = 0.0;
    for (size_t t = 0; t < area.size(); ++t)
        missing = std::max(missing, std::abs(area[t] - 0.5 * glm::length(normal(mesh.triangles[t]))));
    CHECK(missing < 1e-12 * size * size);
}

void check_pieces(const TriangleMesh& mesh, const Fragments& pieces) {
    const Certificate certificate = certify(mesh, pieces);
    CHECK(certificate.closed);
    CHECK(certificate.negative_pieces == 0);
    CHECK(certificate.volume_error < 1e-12);
    CHECK(pieces.crossings == 0);
    CHECK(crossings(pieces) == 0);
    CHECK(cuts_pair_up(pieces));
    check_outside(mesh, pieces);
}

} // namespace

TEST_CASE("rough cuts: closed, whole and without crossings on every shape") {
    Random random(1);
    for (const char* name : {"cube", "lattice_cube", "icosphere", "torus", "torus_knot", "hollow_sphere", "pane",
                             "wall", "statue", "arch", "tower"}) {
        for (const double amount : {0.3, 1.0}) {
            CAPTURE(name);
            CAPTURE(amount);
            const TriangleMesh mesh = *shape(name);
            const uint64_t site_count = 5 + random.next() % 30;
            const auto sites = uniform_sites(bounds(mesh), static_cast<uint32_t>(site_count), random.next());
            Settings settings;
            settings.rough = {.amount = amount, .detail = 1 + static_cast<uint32_t>(random.next() % 2)};
            settings.rough.seed = random.next();
            check_pieces(mesh, rough_pieces(mesh, sites, settings));
        }
    }
}

TEST_CASE("rough cuts: the triangles that roughness added are those that the flat pieces do not have") {
    const TriangleMesh box = cuboid({2.0, 2.0, 2.0});
    const std::vector<glm::dvec3> slabs{{0, 0, -0.7}, {0, 0, 0.1}, {0, 0, 0.8}};
    for (const double amount : {0.05, 0.3}) {
        for (const auto& sites : {slabs, uniform_sites(bounds(box), 6, 2)}) {
            Settings settings;
            const Fragments flat = rough_pieces(box, sites, settings);
            CHECK(flat.rough_triangles == 0);
            settings.rough = {.amount = amount, .wavelength = 0.8};
            const Fragments rough = rough_pieces(box, sites, settings);
            CHECK(rough.rough_triangles > 500);
            CHECK(rough.triangles.size() - rough.rough_triangles == flat.triangles.size());
        }
    }
}

TEST_CASE("rough cuts: sites in special position, slabs, lattices, touching solids, thin plates") {
    const TriangleMesh box = cuboid({2.0, 2.0, 2.0});
    Settings settings;
    settings.rough = {.amount = 0.8, .wavelength = 0.5};
    std::vector<glm::dvec3> lattice;
    for (int i = 0; i < 27; ++i) lattice.push_back(glm::dvec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1) * 0.66);
    check_pieces(box, rough_pieces(box, lattice, settings));

    const std::vector<glm::dvec3> slabs{{0, 0, -0.7}, {0, 0, 0.1}, {0, 0, 0.1}, {0, 0, 0.8}};
    check_pieces(box, rough_pieces(box, slabs, settings));

    // Two boxes that share a vertex: each is cut as if the vertex were its own.
    TriangleMesh touching = box;
    const auto corner = static_cast<uint32_t>(
        std::max_element(box.positions.begin(), box.positions.end(),
                         [](const auto& a, const auto& b) { return a.x + a.y + a.z < b.x + b.y + b.z; })
        - box.positions.begin());
    const auto first = static_cast<uint32_t>(touching.positions.size());
    uint32_t opposite = 0;
    for (uint32_t v = 0; v < box.positions.size(); ++v) {
        touching.positions.push_back(box.positions[v] + 2.0 * box.positions[corner]);
        if (box.positions[v] == -box.positions[corner]) opposite = v;
    }
    for (Triangle t : box.triangles) {
        for (int k = 0; k < 3; ++k) t[k] = t[k] == opposite ? corner : t[k] + first;
        touching.triangles.push_back(t);
    }
    check_pieces(touching, rough_pieces(touching, uniform_sites(bounds(touching), 12, 4), settings));

    settings.rough.wavelength = 0.0;
    const TriangleMesh plate = cuboid({2.0, 0.01, 2.0});
    check_pieces(plate, rough_pieces(plate, uniform_sites(bounds(plate), 25, 5), settings));
}

TEST_CASE("rough cuts: roughness 0 gives today's pieces, and threads and workspaces change no bit") {
    const TriangleMesh mesh = torus(48, 24);
    const auto sites = uniform_sites(bounds(mesh), 30, 6);
    const uint64_t flat = hash(rough_pieces(mesh, sites, {}));
    Settings settings;
    settings.rough = {.amount = 0.0, .wavelength = 0.3, .detail = 2};
    CHECK(hash(rough_pieces(mesh, sites, settings)) == flat);

    settings.rough.amount = 0.7;
    Workspace workspace;
    Fragments pieces;
    std::vector<uint64_t> hashes;
    for (const uint32_t threads : {1u, 2u, 7u, 1u}) {
        settings.threads = threads;
        REQUIRE(brittle::fracture::fracture(mesh, sites, settings, workspace, pieces));
        hashes.push_back(hash(pieces));
    }
    CHECK(std::count(hashes.begin(), hashes.end(), hashes[0]) == 4);
    CHECK(hashes[0] != flat);
    settings.rough.amount = 0.0;
    REQUIRE(brittle::fracture::fracture(mesh, sites, settings, workspace, pieces));
    CHECK(hash(pieces) == flat);
}

TEST_CASE("rough cuts: triangles that no cut crosses leave as they came, and the border of a cut bends") {
    const TriangleMesh box = cuboid({4.0, 1.0, 1.0});
    const std::vector<glm::dvec3> sites{{-0.5, 0.0, 0.0}, {0.5, 0.0, 0.0}};
    Settings settings;
    settings.rough = {.amount = 1.0, .wavelength = 0.4};
    const Fragments pieces = rough_pieces(box, sites, settings);
    check_pieces(box, pieces);
    REQUIRE(pieces.pieces.size() == 2);
    // The two ends of the box are four triangles.
    int whole = 0;
    for (const Piece& piece : pieces.pieces) {
        for (uint32_t k = 0; k < piece.exterior_triangles; ++k) {
            const Triangle& source = box.triangles[pieces.triangle_source[piece.triangles.begin + k]];
            const Triangle& t = pieces.triangles_of(piece)[k];
            bool same = true;
            for (int m = 0; m < 3; ++m) {
                same = same && pieces.vertex_point[piece.vertices.begin + t[m]] == source[m];
                same = same && pieces.positions_of(piece)[t[m]] == box.positions[source[m]];
            }
            whole += same ? 1 : 0;
        }
    }
    CHECK(whole == 4);
    // A flat cut has four corners on the surface, at x = 0.
    double least = 0.0, most = 0.0;
    const Piece& piece = pieces.pieces[0];
    for (uint32_t k = 0; k < piece.exterior_triangles; ++k) {
        for (int m = 0; m < 3; ++m) {
            const glm::dvec3& p = pieces.positions_of(piece)[pieces.triangles_of(piece)[k][m]];
            if (p.x < -1.9) continue;
            least = std::min(least, p.x);
            most = std::max(most, p.x);
        }
    }
    CHECK(most - least > 0.02);
    REQUIRE(pieces.bonds.size() == 1);
    CHECK(pieces.bonds[0].area > 1.005); // the flat contact has 1 m^2
    CHECK(pieces.bonds[0].area < 1.6);
    CHECK(glm::dot(pieces.bonds[0].normal, glm::dvec3(1.0, 0.0, 0.0)) > 0.98);
    CHECK(std::abs(pieces.bonds[0].centroid.x) < 0.1);
}

TEST_CASE("rough cuts: groups, weights and a minimum volume") {
    const TriangleMesh mesh = lattice_cube(2, 2.0);
    const auto sites = uniform_sites(bounds(mesh), 40, 8);
    Settings settings;
    settings.rough = {.amount = 0.6};
    for (uint32_t s = 0; s < sites.size(); ++s) settings.groups.push_back(s % 5);
    const Fragments grouped = rough_pieces(mesh, sites, settings);
    const Certificate certificate = certify(mesh, grouped);
    CHECK(certificate.closed);
    CHECK(certificate.volume_error < 1e-12);
    for (const Bond& bond : grouped.bonds)
        CHECK(settings.groups[grouped.pieces[bond.a].site] != settings.groups[grouped.pieces[bond.b].site]);

    settings.groups.clear();
    settings.min_volume = 0.15;
    const Fragments large = rough_pieces(mesh, sites, settings);
    check_pieces(mesh, large);
    CHECK(large.pieces.size() < 40);
    for (const Piece& piece : large.pieces) CHECK(piece.mass.volume > 0.13); // weighed before the triangles are joined

    settings.min_volume = 0.0;
    Random random(3);
    for (size_t s = 0; s < sites.size(); ++s) settings.weights.push_back(0.1 * random.uniform());
    check_pieces(mesh, rough_pieces(mesh, sites, settings));
}

TEST_CASE("rough cuts: groups that are merged later are as whole as groups, and their own cuts stay coarse") {
    const TriangleMesh mesh = torus(48, 24);
    const auto sites = uniform_sites(bounds(mesh), 60, 5);
    Settings settings;
    settings.rough = {.amount = 0.7, .detail = 2};
    const Fragments all = rough_pieces(mesh, sites, settings);
    for (uint32_t s = 0; s < sites.size(); ++s) settings.merged_later.push_back(sites[s].x < 0.0 ? 0 : 1);
    Fragments later = rough_pieces(mesh, sites, settings);
    CHECK(later.pieces.size() > 30);
    CHECK(certify(mesh, later).closed);
    CHECK(2 * later.triangles.size() < all.triangles.size());

    Threads threads(2);
    merge_pieces(later, choose_mergers(later, {settings.merged_later, 0.0, {}, {}}), threads);
    const Certificate certificate = certify(mesh, later);
    CHECK(certificate.closed);
    CHECK(certificate.volume_error < 1e-12);
    CHECK(cuts_pair_up(later));
    CHECK(crossings(later) == 0);
    for (const Bond& bond : later.bonds)
        CHECK(settings.merged_later[later.pieces[bond.a].site] != settings.merged_later[later.pieces[bond.b].site]);

    // As flat cuts do, merging makes the same pieces as groups do.
    settings.groups = std::exchange(settings.merged_later, {});
    const Fragments grouped = rough_pieces(mesh, sites, settings);
    REQUIRE(grouped.pieces.size() == later.pieces.size());
    for (size_t p = 0; p < later.pieces.size(); ++p)
        CHECK(later.pieces[p].mass.volume == doctest::Approx(grouped.pieces[p].mass.volume).epsilon(1e-3));
}

TEST_CASE("rough cuts: groups of many sites, most of whose cells lie outside the solid") {
    const TriangleMesh mesh = torus(48, 24);
    const auto sites = uniform_sites(bounds(mesh), 400, 5);
    Settings settings;
    settings.rough = {.amount = 0.5};
    for (const glm::dvec3& site : sites) settings.merged_later.push_back(site.x < 0.0 ? 0 : 1);
    for (const bool merged_later : {true, false}) {
        if (!merged_later) settings.groups = std::exchange(settings.merged_later, {});
        const Certificate certificate = certify(mesh, rough_pieces(mesh, sites, settings));
        CHECK(certificate.closed);
        CHECK(certificate.volume_error < 1e-12);
    }
}

TEST_CASE("rough cuts: cut again and again, a piece does not fall into ever finer triangles") {
    TriangleMesh mesh = cube(1.0);
    for (glm::dvec3& p : mesh.positions) p *= glm::dvec3(4.0, 2.0, 0.3);
    const Box box = bounds(mesh);
    std::vector<uint32_t> groups(40, 10); // the largest piece keeps most cells
    for (uint32_t s = 0; s < 10; ++s) groups[s] = s;
    size_t first = 0;
    for (uint64_t level = 0; level < 6; ++level) {
        CAPTURE(level);
        Settings settings;
        settings.groups = groups;
        settings.rough = {.amount = 0.4};
        const Fragments pieces = rough_pieces(mesh, uniform_sites(box, 40, 30 + level), settings);
        const auto largest =
            std::max_element(pieces.pieces.begin(), pieces.pieces.end(),
                             [](const auto& a, const auto& b) { return a.mass.volume < b.mass.volume; });
        mesh.positions.assign(pieces.positions_of(*largest).begin(), pieces.positions_of(*largest).end());
        mesh.triangles.assign(pieces.triangles_of(*largest).begin(), pieces.triangles_of(*largest).end());
        if (level == 0) first = mesh.triangles.size();
        CHECK(mesh.triangles.size() < (level + 2) * first); // without points inside its polygons: 50 times as many
    }
}

TEST_CASE("rough cuts: crossings that calming leaves are counted") {
    // A crowd of cells far smaller than the bumps.
    TriangleMesh mesh = cube(1.0);
    for (glm::dvec3& p : mesh.positions) p *= glm::dvec3(4.0, 2.0, 0.3);
    const Box crowd{{-0.2, -0.2, -0.15}, {0.2, 0.2, 0.15}};
    uint32_t with_crossings = 0;
    for (uint64_t seed = 1; seed <= 6; ++seed) {
        CAPTURE(seed);
        Settings settings;
        settings.rough = {.amount = 1.0, .wavelength = 1.5, .seed = seed};
        const Fragments pieces = rough_pieces(mesh, uniform_sites(crowd, 200, seed), settings);
        CHECK(certify(mesh, pieces).closed);
        CHECK((pieces.crossings > 0) == (crossings(pieces) > 0));
        with_crossings += pieces.crossings > 0 ? 1 : 0;
    }
    CHECK(with_crossings > 0);
}

TEST_CASE("rough cuts: crossings are found again, and also in pieces that had none, once these change") {
    const TriangleMesh box = cuboid({2.0, 2.0, 2.0});
    Settings settings;
    settings.rough = {.amount = 0.3, .wavelength = 0.6};
    Fragments pieces = rough_pieces(box, std::vector<glm::dvec3>{{-0.5, 0.0, 0.0}, {0.5, 0.0, 0.0}}, settings);
    REQUIRE(pieces.pieces.size() == 2);
    // Moves a point of the cut that is next to its border far out of the box. Both sides of the cut have it.
    const auto pull = [&](uint32_t p) {
        const Piece& piece = pieces.pieces[p];
        std::vector<bool> outside(piece.vertices.size());
        for (uint32_t k = 0; k < piece.exterior_triangles; ++k)
            for (int m = 0; m < 3; ++m) outside[pieces.triangles_of(piece)[k][m]] = true;
        for (const Triangle& t : pieces.triangles_of(piece).subspan(piece.exterior_triangles)) {
            if (!outside[t.x] && !outside[t.y] && !outside[t.z]) continue;
            for (int m = 0; m < 3; ++m) {
                if (outside[t[m]]) continue;
                pieces.positions[piece.vertices.begin + t[m]].x *= 20.0;
                pieces.positions[piece.vertices.begin + t[m]].x += p == 0 ? -5.0 : 5.0;
                return;
            }
        }
    };
    Threads threads(1);
    const auto crossing_pieces = [&](rough::CrossingFinder& finder) {
        std::vector<uint32_t> found;
        for (const rough::Crossing& crossing : finder.run(pieces, {}, threads)) found.push_back(crossing.piece);
        return found;
    };
    rough::CrossingFinder finder, fresh;
    CHECK(crossing_pieces(finder).empty());
    pull(0);
    const std::vector<uint32_t> first = crossing_pieces(finder);
    CHECK(!first.empty());
    CHECK(std::count(first.begin(), first.end(), 0u) == static_cast<int64_t>(first.size()));
    CHECK(crossing_pieces(finder) == first);
    pull(1);
    const std::vector<uint32_t> both = crossing_pieces(finder);
    CHECK(std::count(both.begin(), both.end(), 1u) > 0);
    CHECK(both == crossing_pieces(fresh));
    finder.forget();
    CHECK(both == crossing_pieces(finder));
}

TEST_CASE("rough cuts: the triangle budget and the detail bound what is added") {
    const TriangleMesh box = cuboid({1.0, 1.0, 1.0});
    const auto sites = uniform_sites(bounds(box), 20, 9);
    Settings settings;
    settings.rough = {.amount = 0.5, .wavelength = 0.1, .detail = 3};
    const uint64_t fine = certify(box, rough_pieces(box, sites, settings)).triangles_out;
    settings.rough.max_triangles = 20'000;
    const uint64_t bounded = certify(box, rough_pieces(box, sites, settings)).triangles_out;
    settings.rough.max_triangles = 10;
    const uint64_t none = certify(box, rough_pieces(box, sites, settings)).triangles_out;
    settings.rough.amount = 0.0;
    const uint64_t flat = certify(box, rough_pieces(box, sites, settings)).triangles_out;
    CHECK(fine > 60'000);
    CHECK(bounded < 40'000);
    CHECK(bounded > 3'000);
    CHECK(none < 3 * flat);
}

TEST_CASE("rough cuts: refusals name the value, and faults of the mesh are those of the flat cut") {
    const TriangleMesh box = cuboid({1.0, 1.0, 1.0});
    const auto sites = uniform_sites(bounds(box), 5, 1);
    const auto status_of = [&](const Roughness& roughness) -> std::string {
        Settings settings;
        settings.rough = roughness;
        const auto pieces = brittle::fracture::fracture(box, sites, settings);
        return pieces ? "none" : to_string(pieces.error().status);
    };
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    for (const double amount : {-0.1, 1.1, nan}) CHECK(status_of({.amount = amount}) == "invalid_setting");
    for (const double length : {-1.0, nan})
        CHECK(status_of({.amount = 0.5, .wavelength = length}) == "invalid_setting");
    CHECK(status_of({.amount = 0.5, .grain = {0.0, 17.0, 0.0}}) == "invalid_setting");
    CHECK(status_of({.amount = 0.5, .grain = {0.0, nan, 0.0}}) == "invalid_setting");
    CHECK(status_of({.amount = 0.5, .detail = 0}) == "invalid_setting");
    CHECK(status_of({.amount = 0.5, .detail = 7}) == "invalid_setting");
    CHECK(status_of({.amount = 0.5, .wavelength = 1e-30}) == "none"); // too short to change anything

    Settings settings;
    settings.rough.amount = 0.5;
    settings.algorithm = Algorithm::sequential;
    CHECK(brittle::fracture::fracture(box, sites, settings).error().status == Status::invalid_setting);
    settings.algorithm = Algorithm::exact;
    TriangleMesh open = box;
    open.triangles.pop_back();
    CHECK(brittle::fracture::fracture(open, sites, settings).error().message
          == brittle::fracture::fracture(open, sites).error().message);
    open.triangles.back().x = 99;
    CHECK(brittle::fracture::fracture(open, sites, settings).error().message
          == brittle::fracture::fracture(open, sites).error().message);
    TriangleMesh bad = box;
    bad.positions[3].y = nan;
    CHECK(brittle::fracture::fracture(bad, sites, settings).error().status == Status::invalid_mesh);
    CHECK(!brittle::fracture::fracture(TriangleMesh{}, sites, settings));
    CHECK(!brittle::fracture::fracture(box, std::vector<glm::dvec3>{}, settings));
    settings.cancelled = [] { return true; };
    CHECK(brittle::fracture::fracture(box, sites, settings).error().status == Status::cancelled);
}

TEST_CASE("rough cuts: one site and equal sites cut nothing") {
    const TriangleMesh box = cuboid({1.0, 1.0, 1.0});
    Settings settings;
    settings.rough.amount = 1.0;
    for (const auto& sites : {std::vector<glm::dvec3>{{0.1, 0.2, 0.3}}, std::vector<glm::dvec3>(3, glm::dvec3(0.1))}) {
        const Fragments pieces = rough_pieces(box, sites, settings);
        REQUIRE(pieces.pieces.size() == 1);
        CHECK(pieces.triangles == box.triangles);
    }
}

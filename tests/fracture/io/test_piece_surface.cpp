#include "fracture/io/piece_surface.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/fracture.h"
#include "fracture/mesh/nearest.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"

using namespace brittle;
using namespace brittle::fracture;

namespace {

struct Rough {
    Model model;
    std::vector<glm::dvec3> sites;
    Fragments pieces;
};

std::vector<uint32_t> all_triangles(const TriangleMesh& mesh) {
    std::vector<uint32_t> all(mesh.triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    return all;
}

const Rough& rough_box() {
    static const Rough result = [] {
        Model model;
        model.mesh = cuboid({2.0, 1.0, 1.5});
        std::vector<glm::dvec3> sites = uniform_sites(bounds(model.mesh), 9, 4);
        Settings settings;
        settings.rough = {.amount = 0.5, .detail = 2};
        Result<Fragments> pieces = brittle::fracture::fracture(model.mesh, sites, settings);
        REQUIRE(pieces);
        return Rough{std::move(model), std::move(sites), std::move(*pieces)};
    }();
    return result;
}

DrawnPart interior_of(const Rough& rough, const Piece& piece, SurfaceSettings settings) {
    settings.rough = true;
    std::vector<DrawnPart> parts = drawn_parts(rough.pieces, piece, settings);
    REQUIRE(!parts.empty());
    REQUIRE(parts.back().interior);
    return std::move(parts.back());
}

} // namespace

TEST_CASE("piece surface: normals of rough cuts are smooth within a cut and sharp at its border") {
    const Rough& rough = rough_box();
    size_t inner = 0, border = 0;
    for (const Piece& piece : rough.pieces.pieces) {
        const DrawnPart part = interior_of(rough, piece, {});
        REQUIRE(part.indices.size() == 3 * (piece.triangles.size() - piece.exterior_triangles));
        const auto positions = rough.pieces.positions_of(piece);
        std::map<uint32_t, std::set<uint32_t>> cuts_at; // per vertex: the cells across
        for (uint32_t t = piece.exterior_triangles; t < piece.triangles.size(); ++t)
            for (int k = 0; k < 3; ++k)
                cuts_at[rough.pieces.triangles_of(piece)[t][k]].insert(
                    rough.pieces.triangle_source[piece.triangles.begin + t]);
        std::map<uint32_t, std::vector<glm::vec3>> normals_at;
        for (size_t v = 0; v < part.vertices.size(); ++v) {
            CHECK(glm::length(part.normals[v]) == doctest::Approx(1.0f));
            normals_at[part.vertices[v]].push_back(part.normals[v]);
        }
        for (const auto& [vertex, normals] : normals_at) {
            CHECK(normals.size() >= cuts_at[vertex].size());
            // A bend beyond the crease is rare at half roughness; everywhere else a cut has one normal at a point.
            inner += normals.size() == cuts_at[vertex].size() ? 1 : 0;
            ++border;
        }
        // No normal leans from its triangle by more than the crease allows.
        for (size_t k = 0; k < part.indices.size(); k += 3) {
            const auto corner = [&](size_t m) { return positions[part.vertices[part.indices[k + m]]]; };
            const glm::dvec3 area = glm::cross(corner(1) - corner(0), corner(2) - corner(0));
            if (glm::length(area) < 1e-9) continue;
            for (size_t m = 0; m < 3; ++m)
                CHECK(glm::dot(glm::normalize(area), glm::dvec3(part.normals[part.indices[k + m]])) > 0.49);
        }
    }
    CHECK(inner > border * 9 / 10);
}

TEST_CASE("piece surface: depth of rough cuts is the distance to the outside, 0 on it") {
    const Rough& rough = rough_box();
    const TriangleTree outside(rough.model.mesh, all_triangles(rough.model.mesh));
    size_t deep = 0;
    for (const Piece& piece : rough.pieces.pieces) {
        const DrawnPart part =
            interior_of(rough, piece, {.source = &rough.model, .sites = rough.sites, .outside = &outside});
        REQUIRE(part.uv[1].size() == part.vertices.size());
        std::set<uint32_t> on_outside;
        for (uint32_t t = 0; t < piece.exterior_triangles; ++t)
            for (int k = 0; k < 3; ++k) on_outside.insert(rough.pieces.triangles_of(piece)[t][k]);
        for (size_t v = 0; v < part.vertices.size(); ++v) {
            const glm::dvec3& p = rough.pieces.positions_of(piece)[part.vertices[v]];
            CHECK(double(part.uv[1][v].x)
                  == doctest::Approx(glm::distance(p, nearest_on(rough.model.mesh, p))).scale(1.0).epsilon(1e-6));
            if (on_outside.contains(part.vertices[v])) CHECK(part.uv[1][v].x == 0.0f);
            deep += part.uv[1][v].x > 0.1f ? 1 : 0;
        }
    }
    CHECK(deep > 20);
}

TEST_CASE("piece surface: texture coordinates of rough cuts are metres along the cut, equal on both sides") {
    const Rough& rough = rough_box();
    std::map<std::array<uint32_t, 3>, glm::vec2> seen; // both sites and the point
    size_t paired = 0;
    for (const Piece& piece : rough.pieces.pieces) {
        const DrawnPart part = interior_of(rough, piece, {.sites = rough.sites});
        CHECK(part.uv[1].empty());
        const auto positions = rough.pieces.positions_of(piece);
        for (size_t k = 0; k < part.indices.size(); k += 3) {
            for (size_t m = 0; m < 3; ++m) {
                const uint32_t a = part.indices[k + m], b = part.indices[k + (m + 1) % 3];
                const double in_space = glm::distance(positions[part.vertices[a]], positions[part.vertices[b]]);
                const double in_texture = glm::distance(part.uv[0][a], part.uv[0][b]);
                CHECK(in_texture < in_space + 1e-6);
            }
            // A triangle leans by at most 60 degrees from the plane of its coordinates: its area shrinks by half at most.
            const auto corner = [&](size_t m) { return positions[part.vertices[part.indices[k + m]]]; };
            const auto uv = [&](size_t m) { return glm::dvec2(part.uv[0][part.indices[k + m]]); };
            const double area = glm::length(glm::cross(corner(1) - corner(0), corner(2) - corner(0)));
            const glm::dvec2 x = uv(1) - uv(0), y = uv(2) - uv(0);
            CHECK(std::abs(x.x * y.y - x.y * y.x) > 0.499 * area - 1e-6);
        }
        // Inner points of a cut belong to one cut only: their coordinates can be compared across.
        std::map<uint32_t, std::set<uint32_t>> cuts_at;
        for (uint32_t t = piece.exterior_triangles; t < piece.triangles.size(); ++t)
            for (int k = 0; k < 3; ++k)
                cuts_at[rough.pieces.triangles_of(piece)[t][k]].insert(
                    rough.pieces.triangle_source[piece.triangles.begin + t]);
        std::map<uint32_t, int> copies;
        for (const uint32_t v : part.vertices) ++copies[v];
        for (size_t v = 0; v < part.vertices.size(); ++v) {
            const std::set<uint32_t>& cuts = cuts_at[part.vertices[v]];
            if (cuts.size() != 1 || copies[part.vertices[v]] != 1) continue;
            const uint32_t other = *cuts.begin();
            const std::array<uint32_t, 3> key{std::min(piece.site, other), std::max(piece.site, other),
                                              rough.pieces.vertex_point[piece.vertices.begin + part.vertices[v]]};
            const auto [known, is_new] = seen.emplace(key, part.uv[0][v]);
            if (is_new) continue;
            CHECK(glm::distance(known->second, part.uv[0][v]) < 1e-5f);
            ++paired;
        }
    }
    CHECK(paired > 100);
}

TEST_CASE("piece surface: flat cuts are drawn as if they were not rough, up to rounding") {
    const TriangleMesh mesh = cuboid({2.0, 1.0, 1.5});
    const auto sites = uniform_sites(bounds(mesh), 9, 4);
    const Result<Fragments> pieces = brittle::fracture::fracture(mesh, sites);
    REQUIRE(pieces);
    for (const Piece& piece : pieces->pieces) {
        const DrawnPart flat = drawn_parts(*pieces, piece, {.uv_by_plane = true}).back();
        const DrawnPart smooth = drawn_parts(*pieces, piece, {.uv_by_plane = true, .rough = true}).back();
        REQUIRE(flat.indices.size() == smooth.indices.size());
        for (size_t k = 0; k < flat.indices.size(); ++k) {
            const uint32_t a = flat.indices[k], b = smooth.indices[k];
            CHECK(flat.vertices[a] == smooth.vertices[b]);
            CHECK(glm::distance(flat.normals[a], smooth.normals[b]) < 1e-5f);
            CHECK(glm::distance(flat.uv[0][a], smooth.uv[0][b]) < 1e-5f);
        }
    }
}

// Checks that hold for every exact fracture, and inputs that several tests share.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/exact/exact.h"
#include "fracture/mesh/topology.h"
#include "fracture/pieces/certificate.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"

namespace brittle::fracture::test {

using exact::fracture_exact;
using Sites = std::vector<glm::dvec3>;

inline TriangleMesh moved(TriangleMesh mesh, const glm::dvec3& offset, double scale = 1.0) {
    for (glm::dvec3& p : mesh.positions) p = p * scale + offset;
    return mesh;
}

inline TriangleMesh together(TriangleMesh a, const TriangleMesh& b) {
    const auto base = static_cast<uint32_t>(a.positions.size());
    a.positions.insert(a.positions.end(), b.positions.begin(), b.positions.end());
    for (const Triangle& t : b.triangles) a.triangles.push_back(t + base);
    return a;
}

inline TriangleMesh inside_out(TriangleMesh mesh) {
    for (Triangle& t : mesh.triangles) std::swap(t.y, t.z);
    return mesh;
}

inline Sites lattice_sites(uint32_t n, double edge = 2.0) {
    Sites sites;
    for (uint32_t z = 0; z < n; ++z)
        for (uint32_t y = 0; y < n; ++y)
            for (uint32_t x = 0; x < n; ++x) {
                sites.push_back(((glm::dvec3(x, y, z) + 0.5) / static_cast<double>(n) - 0.5) * edge);
            }
    return sites;
}

inline uint64_t topology_faults(const Fragments& fragments) {
    uint64_t faults = 0;
    for (const Piece& piece : fragments.pieces) {
        const TopologyReport report = check_topology(piece.vertices.size(), fragments.triangles_of(piece));
        if (report.manifold() && report.vertices == piece.vertices.size()) continue;
        ++faults;
        if (faults == 1) MESSAGE("site ", piece.site, ": ", describe(report));
    }
    return faults;
}

// Checks that equal point numbers have equal positions in all pieces, that no piece has a point twice, and that numbers
// below 2^30 are vertices of the input.
inline void check_points(const TriangleMesh& mesh, const Fragments& f) {
    REQUIRE(f.vertex_point.size() == f.positions.size());
    std::map<uint32_t, glm::dvec3> positions;
    for (const Piece& piece : f.pieces) {
        std::set<uint32_t> points;
        for (uint32_t v = piece.vertices.begin; v < piece.vertices.end; ++v) {
            const uint32_t point = f.vertex_point[v];
            REQUIRE(points.insert(point).second);
            REQUIRE(positions.emplace(point, f.positions[v]).first->second == f.positions[v]);
            if (point < 1u << 30) REQUIRE(mesh.positions.at(point) == f.positions[v]);
        }
    }
}

// Checks that both sides of a facet have the same cap triangles, reversed and bit-equal.
inline void check_caps_match(const Fragments& f) {
    using Corner = std::array<double, 3>;
    using Key = std::array<Corner, 3>;
    struct Side {
        Key key;
        uint32_t here, there;
    };
    const auto keys = [&](bool lower) {
        std::vector<Side> sides;
        for (const Piece& piece : f.pieces) {
            for (uint32_t t = piece.triangles.begin + piece.exterior_triangles; t < piece.triangles.end; ++t) {
                const uint32_t other = f.triangle_source[t];
                if ((piece.site < other) != lower) continue;
                Key key{};
                for (int k = 0; k < 3; ++k) {
                    const glm::dvec3& p = f.positions[piece.vertices.begin + f.triangles[t][k]];
                    key[static_cast<size_t>(k)] = {p.x, p.y, p.z};
                }
                if (!lower) std::swap(key[1], key[2]);
                std::rotate(key.begin(), std::min_element(key.begin(), key.end()), key.end());
                sides.push_back({key, std::min(piece.site, other), std::max(piece.site, other)});
            }
        }
        std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
            return std::tie(a.here, a.there, a.key) < std::tie(b.here, b.there, b.key);
        });
        return sides;
    };
    const auto one = keys(true), two = keys(false);
    REQUIRE(one.size() == two.size());
    for (size_t k = 0; k < one.size(); ++k) {
        REQUIRE(one[k].key == two[k].key);
        REQUIRE(one[k].here == two[k].here);
        REQUIRE(one[k].there == two[k].there);
    }
}

// Fractures a mesh with paired edges and checks: pieces are closed, oriented, manifold and without unused vertices,
// arrays are consistent, volumes sum to that of the mesh, and the result is bit-equal for any number of threads.
inline Fragments check_fracture(const TriangleMesh& mesh, const Sites& sites, double tolerance = 1e-12) {
    const Result<Fragments> result = fracture_exact(mesh, sites, {.threads = 1});
    REQUIRE_MESSAGE(result, (result ? std::string() : result.error().message));
    const Fragments& f = *result;
    CHECK(topology_faults(f) == 0);
    check_points(mesh, f);
    REQUIRE(f.triangle_source.size() == f.triangles.size());
    uint32_t vertex = 0, triangle = 0;
    double volume = 0.0, scale = 0.0;
    for (const Piece& piece : f.pieces) {
        REQUIRE(piece.vertices.begin == vertex);
        REQUIRE(piece.triangles.begin == triangle);
        vertex = piece.vertices.end;
        triangle = piece.triangles.end;
        REQUIRE(piece.exterior_triangles <= piece.triangles.size());
        for (uint32_t t = 0; t < piece.triangles.size(); ++t) {
            const uint32_t source = f.triangle_source[piece.triangles.begin + t];
            REQUIRE(source < (t < piece.exterior_triangles ? mesh.triangles.size() : sites.size()));
        }
        volume += piece.mass.volume;
        scale += std::abs(piece.mass.volume);
    }
    REQUIRE(vertex == f.positions.size());
    REQUIRE(triangle == f.triangles.size());
    const double expected = mass_properties(mesh.positions, mesh.triangles).volume;
    CHECK(std::abs(volume - expected) <= tolerance * std::max(std::abs(expected), scale));
    for (const uint32_t threads : {2u, 4u}) {
        const Result<Fragments> again = fracture_exact(mesh, sites, {.threads = threads});
        REQUIRE(again);
        CHECK(hash(*again) == hash(f));
        CHECK(again->vertex_point == f.vertex_point);
    }
    check_caps_match(f);
    for (size_t k = 0; k < f.bonds.size(); ++k) {
        const Bond& bond = f.bonds[k];
        REQUIRE(bond.a < f.pieces.size());
        REQUIRE(bond.b < f.pieces.size());
        REQUIRE(f.pieces[bond.a].site < f.pieces[bond.b].site);
        REQUIRE(bond.area > 0.0);
        REQUIRE(std::abs(glm::length(bond.normal) - 1.0) < 1e-12);
        if (k > 0) {
            REQUIRE((f.bonds[k - 1].a < bond.a || (f.bonds[k - 1].a == bond.a && f.bonds[k - 1].b < bond.b)));
        }
    }
    return *result;
}

// Returns the smallest height of a triangle with a vertex that a cut made.
inline double thinnest_cut(const Fragments& f) {
    double least = std::numeric_limits<double>::infinity();
    for (const Piece& piece : f.pieces) {
        const auto positions = f.positions_of(piece);
        for (const Triangle& t : f.triangles_of(piece)) {
            const auto cut = [&](uint32_t v) { return f.vertex_point[piece.vertices.begin + v] >= 1u << 30; };
            if (!cut(t.x) && !cut(t.y) && !cut(t.z)) continue;
            const glm::dvec3 &a = positions[t.x], &b = positions[t.y], &c = positions[t.z];
            const double longest = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
            least = std::min(least, longest == 0.0 ? 0.0 : glm::length(glm::cross(b - a, c - a)) / longest);
        }
    }
    return least;
}

// Reads positions and faces of a plain OBJ file and welds vertices by position. Returns an empty mesh if there is no
// file.
inline TriangleMesh read_obj(const char* path) {
    TriangleMesh mesh;
    std::map<std::array<double, 3>, uint32_t> known;
    std::vector<uint32_t> vertex;
    std::ifstream in(path);
    for (std::string line, word; std::getline(in, line);) {
        std::istringstream words(line);
        words >> word;
        if (word == "v") {
            std::array<double, 3> p{};
            words >> p[0] >> p[1] >> p[2];
            const auto [at, added] = known.try_emplace(p, static_cast<uint32_t>(mesh.positions.size()));
            if (added) mesh.positions.push_back({p[0], p[1], p[2]});
            vertex.push_back(at->second);
        } else if (word == "f") {
            Triangle t{};
            for (int k = 0; k < 3; ++k) {
                words >> word;
                t[k] = vertex[std::stoul(word) - 1];
            }
            mesh.triangles.push_back(t);
        }
    }
    return mesh;
}

} // namespace brittle::fracture::test

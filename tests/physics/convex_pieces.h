// Fragments for the physics tests: boxes in a grid, and boxes cut by random planes. Their mass properties are sums over
// tetrahedra, independent of the library.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "fracture/pieces/fragments.h"

namespace brittle::test {

using Polygon = std::vector<glm::dvec3>; // counter-clockwise from outside
using Polyhedron = std::vector<Polygon>; // convex and closed

// A linear congruential generator, equal on every platform.
class Random {
  public:
    explicit Random(uint64_t seed) : state_(seed * 2 + 1) {}
    double uniform(double low, double high) {
        state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
        return low + (high - low) * static_cast<double>(state_ >> 11) * 0x1p-53;
    }
    glm::dvec3 point(const glm::dvec3& low, const glm::dvec3& high) {
        const double x = uniform(low.x, high.x), y = uniform(low.y, high.y), z = uniform(low.z, high.z);
        return {x, y, z};
    }
    glm::dvec3 direction() {
        for (;;) {
            const glm::dvec3 v = point(glm::dvec3(-1.0), glm::dvec3(1.0));
            const double square = glm::dot(v, v);
            if (square > 0.01 && square <= 1.0) return v / std::sqrt(square);
        }
    }

  private:
    uint64_t state_;
};

inline Polyhedron box_polyhedron(const glm::dvec3& low, const glm::dvec3& high) {
    const auto at = [&](int x, int y, int z) {
        return glm::dvec3(x ? high.x : low.x, y ? high.y : low.y, z ? high.z : low.z);
    };
    return {{at(0, 0, 0), at(0, 0, 1), at(0, 1, 1), at(0, 1, 0)}, {at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1)},
            {at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1)}, {at(0, 1, 0), at(0, 1, 1), at(1, 1, 1), at(1, 1, 0)},
            {at(0, 0, 0), at(0, 1, 0), at(1, 1, 0), at(1, 0, 0)}, {at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)}};
}

// The part of the polyhedron with normal . x <= distance, possibly empty. Precondition: no vertex lies on the plane.
inline Polyhedron clipped(const Polyhedron& polyhedron, const glm::dvec3& normal, double distance) {
    Polyhedron kept;
    Polygon cap;
    for (const Polygon& face : polyhedron) {
        Polygon inside;
        for (size_t i = 0; i < face.size(); ++i) {
            const glm::dvec3& from = face[i];
            const glm::dvec3& to = face[(i + 1) % face.size()];
            const double a = glm::dot(normal, from) - distance, b = glm::dot(normal, to) - distance;
            if (a <= 0.0) inside.push_back(from);
            if ((a <= 0.0) != (b <= 0.0)) {
                inside.push_back(from + (to - from) * (a / (a - b)));
                cap.push_back(inside.back());
            }
        }
        if (inside.size() >= 3) kept.push_back(inside);
    }
    if (cap.size() < 3 || kept.empty()) return kept;
    glm::dvec3 centre(0.0);
    for (const glm::dvec3& point : cap) centre += point / static_cast<double>(cap.size());
    const glm::dvec3 u = glm::normalize(cap[0] - centre), v = glm::cross(normal, u);
    std::sort(cap.begin(), cap.end(), [&](const glm::dvec3& a, const glm::dvec3& b) {
        return std::atan2(glm::dot(a - centre, v), glm::dot(a - centre, u))
               < std::atan2(glm::dot(b - centre, v), glm::dot(b - centre, u));
    });
    kept.push_back(cap);
    return kept;
}

inline fracture::MassProperties mass_of(const Polyhedron& polyhedron) {
    fracture::MassProperties mass;
    const glm::dvec3 apex = polyhedron[0][0];
    glm::dvec3 first(0.0);
    glm::dmat3 second(0.0); // integral of x x^T about the apex
    for (const Polygon& face : polyhedron)
        for (size_t i = 1; i + 1 < face.size(); ++i) {
            const glm::dvec3 a = face[0] - apex, b = face[i] - apex, c = face[i + 1] - apex, sum = a + b + c;
            const double volume = glm::dot(a, glm::cross(b, c)) / 6.0;
            mass.volume += volume;
            mass.area += 0.5 * glm::length(glm::cross(b - a, c - a));
            first += volume * sum / 4.0;
            second += volume / 20.0
                      * (glm::outerProduct(a, a) + glm::outerProduct(b, b) + glm::outerProduct(c, c)
                         + glm::outerProduct(sum, sum));
        }
    const glm::dvec3 centre = first / mass.volume;
    second -= mass.volume * glm::outerProduct(centre, centre);
    mass.centre_of_mass = apex + centre;
    mass.inertia = glm::dmat3(second[0][0] + second[1][1] + second[2][2]) - second;
    return mass;
}

inline void append_piece(fracture::Fragments& fragments, const Polyhedron& polyhedron) {
    fracture::Piece piece;
    piece.site = static_cast<uint32_t>(fragments.pieces.size());
    piece.vertices.begin = static_cast<uint32_t>(fragments.positions.size());
    piece.triangles.begin = static_cast<uint32_t>(fragments.triangles.size());
    for (const Polygon& face : polyhedron) {
        const auto first = static_cast<uint32_t>(fragments.positions.size()) - piece.vertices.begin;
        fragments.positions.insert(fragments.positions.end(), face.begin(), face.end());
        for (uint32_t i = 1; i + 1 < face.size(); ++i) {
            fragments.triangles.push_back({first, first + i, first + i + 1});
            fragments.triangle_source.push_back(0);
        }
    }
    piece.vertices.end = static_cast<uint32_t>(fragments.positions.size());
    piece.triangles.end = static_cast<uint32_t>(fragments.triangles.size());
    piece.mass = mass_of(polyhedron);
    fragments.pieces.push_back(piece);
}

inline fracture::Fragments fragments_of(const std::vector<Polyhedron>& polyhedra) {
    fracture::Fragments fragments;
    for (const Polyhedron& polyhedron : polyhedra) append_piece(fragments, polyhedron);
    return fragments;
}

// The box cut into x * y * z equal boxes.
inline fracture::Fragments grid_pieces(const glm::dvec3& low, const glm::dvec3& high, int x, int y, int z) {
    std::vector<Polyhedron> boxes;
    const glm::dvec3 cell = (high - low) / glm::dvec3(x, y, z);
    for (int i = 0; i < x; ++i)
        for (int j = 0; j < y; ++j)
            for (int k = 0; k < z; ++k)
                boxes.push_back(
                    box_polyhedron(low + cell * glm::dvec3(i, j, k), low + cell * glm::dvec3(i + 1, j + 1, k + 1)));
    return fragments_of(boxes);
}

// As grid_pieces(), with bonds between neighbours along the axes.
inline fracture::Fragments bonded_grid(const glm::dvec3& low, const glm::dvec3& high, int x, int y, int z) {
    fracture::Fragments fragments = grid_pieces(low, high, x, y, z);
    const glm::dvec3 cell = (high - low) / glm::dvec3(x, y, z);
    const auto index = [&](int i, int j, int k) { return static_cast<uint32_t>((i * y + j) * z + k); };
    for (int i = 0; i < x; ++i)
        for (int j = 0; j < y; ++j)
            for (int k = 0; k < z; ++k) {
                const auto bond = [&](int to_i, int to_j, int to_k) {
                    if (to_i >= x || to_j >= y || to_k >= z) return;
                    const glm::dvec3 normal(to_i - i, to_j - j, to_k - k);
                    const double area = cell.x * cell.y * cell.z / glm::dot(cell, normal);
                    const glm::dvec3 centre = low + cell * (glm::dvec3(i, j, k) + 0.5 + 0.5 * normal);
                    fragments.bonds.push_back({index(i, j, k), index(to_i, to_j, to_k), area, centre, normal});
                };
                bond(i, j, k + 1), bond(i, j + 1, k), bond(i + 1, j, k);
            }
    return fragments;
}

// The box cut into the Voronoi cells of random sites.
inline fracture::Fragments voronoi_pieces(const glm::dvec3& low, const glm::dvec3& high, int count, uint64_t seed) {
    Random random(seed);
    std::vector<glm::dvec3> sites;
    for (int i = 0; i < count; ++i) sites.push_back(random.point(low, high));
    std::vector<Polyhedron> cells;
    for (size_t i = 0; i < sites.size(); ++i) {
        Polyhedron cell = box_polyhedron(low, high);
        for (size_t j = 0; j < sites.size(); ++j) {
            if (j == i) continue;
            const glm::dvec3 normal = glm::normalize(sites[j] - sites[i]);
            cell = clipped(cell, normal, glm::dot(normal, (sites[i] + sites[j]) * 0.5));
        }
        cells.push_back(cell);
    }
    return fragments_of(cells);
}

// The box cut by complete planes, one after the other; some pieces are wedges and flakes.
inline fracture::Fragments wedge_pieces(const glm::dvec3& low, const glm::dvec3& high, int planes, uint64_t seed) {
    Random random(seed);
    std::vector<Polyhedron> pieces{box_polyhedron(low, high)};
    for (int i = 0; i < planes; ++i) {
        const glm::dvec3 normal = random.direction();
        const double distance = glm::dot(normal, random.point(low, high));
        std::vector<Polyhedron> next;
        for (const Polyhedron& piece : pieces)
            for (Polyhedron part : {clipped(piece, normal, distance), clipped(piece, -normal, -distance)})
                if (part.size() >= 4) next.push_back(std::move(part));
        pieces = std::move(next);
    }
    return fragments_of(pieces);
}

} // namespace brittle::test

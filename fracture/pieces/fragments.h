// The result of a fracture: watertight pieces in shared arrays, ready for upload to a GPU and for physics.
//
// Layout. The vertices of piece p are positions[p.vertices.begin .. p.vertices.end), its triangles are
// triangles[p.triangles.begin .. p.triangles.end), with indices relative to p.vertices.begin. Within a piece the
// exterior triangles (parts of the surface of the input) precede the interior ones (caps on Voronoi facets).
//
// Positions at which two pieces meet are equal bit for bit. Algorithm::sequential guarantees this only for points at
// which one plane cuts the surface of the input; where several planes meet, positions are equal up to rounding
// (sequential.h).
//
// Coordinates are those of the input: right-handed, Y up, metres. Plain data, not synchronised.
//
//     for (const Piece& piece : fragments.pieces)
//         upload(fragments.positions_of(piece), fragments.triangles_of(piece));
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/mesh/mass_properties.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

struct Range {
    uint32_t begin = 0;
    uint32_t end = 0;

    [[nodiscard]] uint32_t size() const { return end - begin; }
};

// Appends a range of one array to another. Returns the range that it occupies there.
template<class T>
Range append_range(const std::vector<T>& from, const Range& range, std::vector<T>& to) {
    const auto begin = static_cast<uint32_t>(to.size());
    to.insert(to.end(), from.begin() + range.begin, from.begin() + range.end);
    return {begin, static_cast<uint32_t>(to.size())};
}

struct Piece {
    uint32_t site = 0;               // the site of the cell that holds this piece; one cell may hold several pieces
    Range vertices;                  // range of Fragments::positions
    Range triangles;                 // range of Fragments::triangles and triangle_source
    uint32_t exterior_triangles = 0; // the count of exterior triangles, which come first
    MassProperties mass;             // at density 1, in the coordinates of the input
};

// The contact of two pieces: the caps that they share.
struct Bond {
    uint32_t a = 0; // indices into Fragments::pieces, a < b
    uint32_t b = 0;
    double area = 0.0;        // m^2
    glm::dvec3 centroid{0.0}; // centroid of the contact, m
    glm::dvec3 normal{0.0};   // unit normal, from a to b
};

struct Milliseconds {
    std::string phase; // name of a phase, for example "cells", "clip", "caps" or "islands"
    double milliseconds = 0.0;
};

// The verified properties of a result. certify() (certificate.h) computes them from the pieces alone and does not trust
// the algorithm that made them.
struct Certificate {
    uint32_t pieces = 0;          // pieces in the result
    uint32_t cells = 0;           // count of sites with at least one piece
    bool closed = false;          // every piece is closed, manifold and consistently oriented
    uint32_t open_pieces = 0;     // count of pieces that are not closed
    uint32_t negative_pieces = 0; // count of pieces whose volume is not positive
    double volume_input = 0.0;    // m^3
    double volume_sum = 0.0;      // sum over all pieces, m^3
    double volume_error = 0.0;    // |volume_sum - volume_input| / |volume_input|
    double smallest_piece = 0.0;  // the smallest volume of a piece, m^3
    uint64_t triangles_in = 0;
    uint64_t triangles_out = 0;
    uint64_t cap_triangles = 0; // count of interior triangles; both sides of a cap count
    uint64_t hash = 0;          // of all positions, triangles and piece ranges; equal on every machine
};

struct Fragments {
    std::vector<glm::dvec3> positions;
    // Per vertex, the number of the point of the cut at which it lies. Vertices of several pieces with equal numbers
    // are one point and have positions that are equal bit for bit. A number below 2^30 is the index of that vertex of
    // the input; larger numbers have no meaning beyond equality.
    std::vector<uint32_t> vertex_point;
    std::vector<Triangle> triangles;
    // Per triangle: the index of the input triangle that holds it (exterior), or the site on the other side of the cap
    // (interior).
    std::vector<uint32_t> triangle_source;
    std::vector<Piece> pieces; // ordered by site, then by first vertex
    std::vector<Bond> bonds;   // ordered by (a, b); empty if the algorithm finds no bonds
    // Triangles of rough cuts that cross another triangle of their piece, see Settings::rough. Usually 0.
    uint32_t crossings = 0;
    uint64_t rough_triangles = 0; // the triangles that roughness added: two for each point that it added to a piece
    std::vector<Milliseconds> timings;

    [[nodiscard]] std::span<const glm::dvec3> positions_of(const Piece& piece) const {
        return std::span(positions).subspan(piece.vertices.begin, piece.vertices.size());
    }
    [[nodiscard]] std::span<const Triangle> triangles_of(const Piece& piece) const {
        return std::span(triangles).subspan(piece.triangles.begin, piece.triangles.size());
    }
};

} // namespace brittle::fracture

// What comes out of a fracture: watertight pieces in one shared arena, ready for upload and for physics.
//
// Layout: the vertices of piece p are positions[vertices.begin .. vertices.end), its triangles are
// triangles[triangles.begin .. triangles.end) with indices relative to vertices.begin. Within a piece the exterior
// triangles (parts of the input's surface) come first, then the interior ones (caps on Voronoi facets).
// Positions where two pieces meet are equal bit for bit. Algorithm::sequential promises that only for points where one
// plane cuts the input's surface; where several meet it is equal up to rounding (sequential.h).
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

// Appends a range of one array to another; returns where it is there.
template<class T>
Range append_range(const std::vector<T>& from, const Range& range, std::vector<T>& to) {
    const auto begin = static_cast<uint32_t>(to.size());
    to.insert(to.end(), from.begin() + range.begin, from.begin() + range.end);
    return {begin, static_cast<uint32_t>(to.size())};
}

struct Piece {
    uint32_t site = 0;               // the site whose cell this piece is part of; a cell may give several pieces
    Range vertices;                  // into Fragments::positions
    Range triangles;                 // into Fragments::triangles and triangle_source
    uint32_t exterior_triangles = 0; // the first so many of triangles are exterior
    MassProperties mass;             // at density 1, in the coordinates of the input
};

// Where two pieces touch: the caps that they share.
struct Bond {
    uint32_t a = 0; // indices into Fragments::pieces, a < b
    uint32_t b = 0;
    double area = 0.0;        // m^2
    glm::dvec3 centroid{0.0}; // of the contact, m
    glm::dvec3 normal{0.0};   // unit, from a to b
};

struct Milliseconds {
    std::string phase; // e.g. "cells", "clip", "caps", "islands"
    double milliseconds = 0.0;
};

// What a fracture can prove about its result. Filled by certify() (certificate.h) from the pieces alone, so that it
// does not trust the algorithm that made them.
struct Certificate {
    uint32_t pieces = 0;         // pieces in the result
    uint32_t cells = 0;          // sites whose cell holds at least one piece
    bool closed = false;         // every piece is closed, manifold and consistently oriented
    uint32_t open_pieces = 0;    // pieces that are not
    double volume_input = 0.0;   // m^3
    double volume_sum = 0.0;     // m^3, over pieces
    double volume_error = 0.0;   // |volume_sum - volume_input| / |volume_input|
    double smallest_piece = 0.0; // m^3, the least volume of a piece
    uint64_t triangles_in = 0;
    uint64_t triangles_out = 0;
    uint64_t cap_triangles = 0; // interior triangles, both sides of each cap counted
    uint64_t hash = 0;          // of all positions, triangles and piece ranges; equal on every machine
};

struct Fragments {
    std::vector<glm::dvec3> positions;
    // Which point of the cut each vertex is: vertices of equal points in two pieces are the same point, and bit-equal.
    // A number below 2^30 is that vertex of the input; others only compare.
    std::vector<uint32_t> vertex_point;
    std::vector<Triangle> triangles;
    // For an exterior triangle the index of the input triangle it is part of; for an interior one the site on the
    // other side of the cap.
    std::vector<uint32_t> triangle_source;
    std::vector<Piece> pieces; // ordered by site, then by first vertex
    std::vector<Bond> bonds;   // ordered by (a, b); empty where the algorithm does not find them
    std::vector<Milliseconds> timings;

    [[nodiscard]] std::span<const glm::dvec3> positions_of(const Piece& piece) const {
        return std::span(positions).subspan(piece.vertices.begin, piece.vertices.size());
    }
    [[nodiscard]] std::span<const Triangle> triangles_of(const Piece& piece) const {
        return std::span(triangles).subspan(piece.triangles.begin, piece.triangles.size());
    }
};

} // namespace brittle::fracture

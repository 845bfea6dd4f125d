// The Voronoi diagram of a set of sites inside a box: cells, facets, edges, vertices and who neighbours whom.
//
//     Result<VoronoiDiagram> diagram = voronoi_diagram(sites, box);
//     for (const auto& facet : diagram->facets)
//         for (const auto& corner : diagram->ring_of(facet))
//         line_to(diagram->vertices[corner.vertex].position);
//
// The combinatorics are exact. Where sites are in special position (four in a plane and on a circle, five on
// a sphere, ...) ties are broken by perturbing the sites' weights symbolically, lower indices winning, so the
// diagram is always simple: three facets meet in an edge, six in a vertex, and a facet or an edge may have no
// extent. All cells agree about what they share, because each item exists once. The same diagram is what the
// exact fracture cuts with.
//
// Planes are named by a number: a site (the bisector with it), or one of six values for the sides of the box,
// which are larger than any site. Thread-safe to read. Coordinates are those of the input.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/base/error.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

struct VoronoiDiagram {
    // Sides of the box, as planes: min x, max x, min y, max y, min z, max z from here on.
    static constexpr uint32_t first_box_plane = 0xfffffffau;
    static constexpr uint32_t none = 0xffffffffu;

    // Where four cells meet, or three, or two, at a face, an edge or a corner of the box.
    struct Vertex {
        std::array<uint32_t, 4> planes; // ascending; the first two at least are sites
        glm::dvec3 position;

        [[nodiscard]] bool on_box() const { return planes[3] >= first_box_plane; }
    };

    // Where three cells meet, or two at a side of the box. Directed along (s_j - s_i) x (s_k - s_i), or along
    // (s_j - s_i) x (the outward axis): seen against that direction, the cells i, j, k are counter-clockwise.
    struct Edge {
        std::array<uint32_t, 3> planes; // i < j < k; i and j are sites
        uint32_t start;                 // vertices
        uint32_t end;

        [[nodiscard]] bool on_box() const { return planes[2] >= first_box_plane; }
    };

    struct Facet {
        uint32_t i, j; // sites, i < j
        uint32_t ring_begin, ring_end;
    };

    // One side of a facet and the vertex at its end. Rings run counter-clockwise seen from outside cell i,
    // that is from the side of j; an edge is run along its direction exactly where (i, j, third) is an even
    // permutation. A ring starts at its least third.
    struct Corner {
        uint32_t third; // the plane on the other side of the edge
        uint32_t edge;
        uint32_t vertex;
    };

    struct Neighbour {
        uint32_t site;
        uint32_t facet;
    };

    std::vector<Vertex> vertices; // without those where a cell touches nothing but the box
    std::vector<Edge> edges;
    std::vector<Facet> facets; // ordered by (i, j)
    std::vector<Corner> rings;
    std::vector<uint32_t> cell_begin;   // one more than sites; into neighbours
    std::vector<Neighbour> neighbours;  // of each cell, ascending
    std::vector<uint8_t> cell_is_empty; // duplicates, cells outside the box, and what heavier sites leave nothing

    [[nodiscard]] std::span<const Corner> ring_of(const Facet& facet) const {
        return std::span(rings).subspan(facet.ring_begin, facet.ring_end - facet.ring_begin);
    }
    [[nodiscard]] std::span<const Neighbour> neighbours_of(uint32_t site) const {
        return std::span(neighbours).subspan(cell_begin[site], cell_begin[site + 1] - cell_begin[site]);
    }
    // The facet between two cells, in either order, or none.
    [[nodiscard]] uint32_t facet_between(uint32_t a, uint32_t b) const;
};

// With weights (m^2, one a site) it is the power diagram: a site reaches as far as a ball of that squared radius around it
// would, and may be left with nothing. Of duplicate sites the heaviest owns the cell, then the lowest index. Sites may lie outside the box. threads = 0: one a core;
// the result does not depend on it. Errors: invalid_sites (none, not finite), invalid_setting for a box that
// is not finite or has no volume, and for weights that are not finite or not one a site.
[[nodiscard]] Result<VoronoiDiagram> voronoi_diagram(std::span<const glm::dvec3> sites, const Box& box,
                                                     uint32_t threads = 0, std::span<const double> weights = {});

} // namespace brittle::fracture

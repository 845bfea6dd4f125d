// The Voronoi diagram of a set of sites inside a box: cells, facets, edges, vertices and adjacency.
//
//     Result<VoronoiDiagram> diagram = voronoi_diagram(sites, box);
//     for (const auto& facet : diagram->facets)
//         for (const auto& corner : diagram->ring_of(facet))
//             line_to(diagram->vertices[corner.vertex].position);
//
// The combinatorics are exact. Where sites are in special position (four in a plane and on a circle, five on a sphere,
// ...) a symbolic perturbation of the sites' weights breaks the tie; lower indices win. So the diagram is always
// simple: three facets meet in an edge and six in a vertex, and a facet or an edge may have no extent. Each item exists
// once, so all cells agree about their common items. The exact fracture cuts with this diagram.
//
// A number identifies a plane: the index of a site (its bisector), or one of six values above any site index for the
// sides of the box. Coordinates are those of the input. Concurrent reads are safe.
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
    // The sides of the box, as planes: min x, max x, min y, max y, min z, max z, from this value on.
    static constexpr uint32_t first_box_plane = 0xfffffffau;
    static constexpr uint32_t none = 0xffffffffu;

    // The common point of four cells, or of three cells on a face of the box, or of two on an edge of it.
    struct Vertex {
        std::array<uint32_t, 4> planes; // ascending; the first two at least are sites
        glm::dvec3 position;

        [[nodiscard]] bool on_box() const { return planes[3] >= first_box_plane; }
    };

    // The common edge of three cells, or of two on a side of the box. Directed along (s_j - s_i) x (s_k - s_i), or
    // along (s_j - s_i) x (outward axis): seen against that direction, the cells i, j, k follow counter-clockwise.
    struct Edge {
        std::array<uint32_t, 3> planes; // i < j < k; i and j are sites
        uint32_t start;                 // the vertices at both ends
        uint32_t end;

        [[nodiscard]] bool on_box() const { return planes[2] >= first_box_plane; }
    };

    struct Facet {
        uint32_t i, j;                 // sites, i < j
        uint32_t ring_begin, ring_end; // into rings
    };

    // One side of a facet and the vertex at its end. A ring is counter-clockwise as seen from outside cell i, from the
    // side of j; it runs an edge along its direction exactly where (i, j, third) is an even permutation. A ring starts
    // at its least third.
    struct Corner {
        uint32_t third; // the plane that bounds the facet at this edge
        uint32_t edge;
        uint32_t vertex;
    };

    struct Neighbour {
        uint32_t site;
        uint32_t facet;
    };

    std::vector<Vertex> vertices; // without those where a cell meets nothing but the box
    std::vector<Edge> edges;
    std::vector<Facet> facets; // ordered by (i, j)
    std::vector<Corner> rings;
    std::vector<uint32_t> cell_begin;   // per site, and the end: into neighbours
    std::vector<Neighbour> neighbours;  // of each cell, in ascending order of sites
    std::vector<uint8_t> cell_is_empty; // duplicates, cells outside the box, cells that heavier sites take over

    [[nodiscard]] std::span<const Corner> ring_of(const Facet& facet) const {
        return std::span(rings).subspan(facet.ring_begin, facet.ring_end - facet.ring_begin);
    }
    [[nodiscard]] std::span<const Neighbour> neighbours_of(uint32_t site) const {
        return std::span(neighbours).subspan(cell_begin[site], cell_begin[site + 1] - cell_begin[site]);
    }
    // The facet between two cells, in either order; none where there is none.
    [[nodiscard]] uint32_t facet_between(uint32_t a, uint32_t b) const;
};

// Computes the diagram of the sites within the box. Sites may lie outside the box.
//
// With weights (m^2, one per site) it is the power diagram: a weight extends the reach of a site like a ball of that
// squared radius around it, and a site may be left without a cell. Of duplicate sites the heaviest owns the cell, then
// the lowest index. threads = 0: one per core; the result does not depend on the number.
//
// Errors: invalid_sites (no site, or one that is not finite); invalid_setting for a box that is not finite or has no
// volume, for weights that are not finite, and where their number differs from that of the sites.
[[nodiscard]] Result<VoronoiDiagram> voronoi_diagram(std::span<const glm::dvec3> sites, const Box& box,
                                                     uint32_t threads = 0, std::span<const double> weights = {});

} // namespace brittle::fracture

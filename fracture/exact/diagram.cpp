#include "fracture/exact/diagram.h"

#include <algorithm>
#include <cassert>

#include <glm/common.hpp>

namespace brittle::fracture::exact {

namespace {

constexpr uint32_t min_cells_per_chunk = 4;

// Below this ratio of the determinant to its permanent a position has lost two digits, and is computed exactly instead,
// then rounded. Lost digits move the position off its planes, which bends the caps of a thin solid that meet there.
constexpr double well_conditioned = 1e-2;

void exclusive_sum(std::vector<uint32_t>& counts) {
    uint32_t sum = 0;
    for (uint32_t& n : counts) {
        const uint32_t here = n;
        n = sum;
        sum += here;
    }
}

template<size_t N>
std::array<PlaneId, N> sorted(std::array<PlaneId, N> planes) {
    for (size_t i = 1; i < N; ++i) {
        for (size_t k = i; k > 0 && planes[k] < planes[k - 1]; --k) std::swap(planes[k], planes[k - 1]);
    }
    return planes;
}

} // namespace

glm::dvec3 vertex_position(const Diagram& problem, const std::array<PlaneId, 4>& planes) {
    const SiteId c = planes[0];
    const CellVertex v = make_cell_vertex(make_plane(problem, c, planes[1]), make_plane(problem, c, planes[2]),
                                          make_plane(problem, c, planes[3]));
    const glm::dvec3 y =
        v.w > well_conditioned * v.pw ? v.x / v.w : cell_vertex_exact(problem, c, planes[1], planes[2], planes[3]);
    return glm::clamp(problem.sites[c] + y, problem.box.min, problem.box.max);
}

PredicateStats DiagramBuilder::stats() const {
    PredicateStats sum;
    for (const Chunk& chunk : chunks_) sum += chunk.builder.stats;
    return sum;
}

void DiagramBuilder::build(const Diagram& problem, Threads& threads, VoronoiDiagram& out) {
    const auto sites = static_cast<uint32_t>(problem.sites.size());
    build_cells(problem, threads, out);
    number_facets(out);
    number_items(out);
    threads.for_chunks(sites, min_cells_per_chunk,
                       [&](uint32_t, uint32_t begin, uint32_t end) { fill_owned(problem, begin, end, out); });
    threads.for_chunks(sites, min_cells_per_chunk, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        link_rings(chunks_[chunk], begin, end, out);
    });
}

void DiagramBuilder::build_cells(const Diagram& problem, Threads& threads, VoronoiDiagram& out) {
    const auto sites = static_cast<uint32_t>(problem.sites.size());
    tree_.build(problem.sites, problem.weights);
    cells_.resize(sites);
    out.cell_is_empty.resize(sites);
    chunks_.resize(std::max<size_t>(chunks_.size(), threads.chunks(sites, min_cells_per_chunk)));
    for (Chunk& chunk : chunks_) chunk.builder.stats = {};
    threads.for_chunks(sites, min_cells_per_chunk, [&](uint32_t k, uint32_t begin, uint32_t end) {
        Chunk& chunk = chunks_[k];
        chunk.planes.clear();
        chunk.rings.clear();
        chunk.ring_sizes.clear();
        for (SiteId c = begin; c < end; ++c) {
            threads.poll(c);
            out.cell_is_empty[c] = chunk.builder.build(problem, tree_, c) ? 0 : 1;
            CellRef& cell = cells_[c];
            cell.chunk = k;
            cell.planes_begin = static_cast<uint32_t>(chunk.planes.size());
            const auto planes = chunk.builder.planes();
            chunk.planes.insert(chunk.planes.end(), planes.begin(), planes.end());
            collect_rings(c, chunk);
            cell.planes_end = static_cast<uint32_t>(chunk.planes.size());
        }
    });
}

void DiagramBuilder::number_facets(VoronoiDiagram& out) {
    const auto sites = static_cast<uint32_t>(cells_.size());
    out.cell_begin.assign(sites + 1, 0);
    facet_begin_.assign(sites + 1, 0);
    for (SiteId c = 0; c < sites; ++c) {
        const CellRef& cell = cells_[c];
        const PlaneId* planes = chunks_[cell.chunk].planes.data();
        for (uint32_t p = cell.planes_begin; p < cell.planes_end && !is_box_plane(planes[p]); ++p) {
            ++out.cell_begin[c];
            if (planes[p] > c) ++facet_begin_[c];
        }
    }
    exclusive_sum(out.cell_begin);
    exclusive_sum(facet_begin_);
    out.neighbours.resize(out.cell_begin[sites]);
    out.facets.resize(facet_begin_[sites]);
    // Facet ids ascend with (i,j), and so do the neighbours below j in the list of j: one cursor per cell finds the
    // place of each facet.
    std::vector<uint32_t>& cursor = edge_begin_; // its memory is free until number_items()
    cursor.assign(out.cell_begin.begin(), out.cell_begin.end());
    for (SiteId c = 0; c < sites; ++c) {
        const CellRef& cell = cells_[c];
        const PlaneId* planes = chunks_[cell.chunk].planes.data();
        uint32_t facet = facet_begin_[c];
        for (uint32_t p = cell.planes_begin; p < cell.planes_end && !is_box_plane(planes[p]); ++p) {
            const SiteId j = planes[p];
            if (j < c) continue;
            out.facets[facet] = {c, j, 0, 0};
            out.neighbours[cursor[c]++] = {j, facet};
            out.neighbours[cursor[j]++] = {c, facet};
            ++facet;
        }
    }
}

// Collects the rings of the facets that the cell owns, while the builder still holds its vertices. Keeping the vertices
// of all cells would take more memory than the diagram itself.
void DiagramBuilder::collect_rings(SiteId c, Chunk& chunk) {
    const std::span planes = chunk.builder.planes();
    const std::span vertices = chunk.builder.vertices();
    // The fan of a plane: for each of its vertices, the plane before and the plane after.
    chunk.fan_begin.assign(planes.size() + 2, 0);
    for (const auto& v : vertices) {
        for (const uint32_t p : v) ++chunk.fan_begin[p + 2];
    }
    for (size_t p = 2; p < chunk.fan_begin.size(); ++p) chunk.fan_begin[p] += chunk.fan_begin[p - 1];
    chunk.fan.resize(3 * vertices.size());
    for (const auto& [a, b, d] : vertices) {
        chunk.fan[chunk.fan_begin[a + 1]++] = {b, d};
        chunk.fan[chunk.fan_begin[b + 1]++] = {d, a};
        chunk.fan[chunk.fan_begin[d + 1]++] = {a, b};
    }
    for (uint32_t p = 0; p < planes.size() && !is_box_plane(planes[p]); ++p) {
        if (planes[p] < c) continue;
        const std::span fan(chunk.fan.data() + chunk.fan_begin[p], chunk.fan_begin[p + 1] - chunk.fan_begin[p]);
        // A ring starts at its least third, so that it does not depend on the order of clipping.
        uint32_t at = (*std::min_element(fan.begin(), fan.end()))[0];
        for (size_t step = 0; step < fan.size(); ++step) {
            chunk.rings.push_back(at);
            const auto next = std::find_if(fan.begin(), fan.end(), [&](const auto& f) { return f[0] == at; });
            assert(next != fan.end());
            at = next == fan.end() ? at : (*next)[1];
        }
        chunk.ring_sizes.push_back(static_cast<uint32_t>(fan.size()));
    }
}

void DiagramBuilder::number_items(VoronoiDiagram& out) {
    const auto facets = static_cast<uint32_t>(out.facets.size());
    // Chunks hold consecutive cells, hence consecutive facets, so their rings are read in sequence.
    uint32_t ring = 0;
    uint32_t chunk_index = box_min_x;
    const uint32_t* size = nullptr;
    for (VoronoiDiagram::Facet& facet : out.facets) {
        if (cells_[facet.i].chunk != chunk_index) {
            chunk_index = cells_[facet.i].chunk;
            size = chunks_[chunk_index].ring_sizes.data();
        }
        facet.ring_begin = ring;
        ring += *size++;
        facet.ring_end = ring;
    }
    out.rings.resize(ring);
    edge_begin_.assign(facets + 1, 0);
    vertex_begin_.assign(facets + 1, 0);
    uint32_t f = 0;
    chunk_index = box_min_x;
    const uint32_t* third = nullptr;
    for (; f < facets; ++f) {
        const VoronoiDiagram::Facet& facet = out.facets[f];
        if (cells_[facet.i].chunk != chunk_index) {
            chunk_index = cells_[facet.i].chunk;
            third = chunks_[chunk_index].rings.data();
        }
        const uint32_t n = facet.ring_end - facet.ring_begin;
        const PlaneId* const planes = chunks_[chunk_index].planes.data() + cells_[facet.i].planes_begin;
        for (uint32_t m = 0; m < n; ++m) {
            const bool here = planes[third[m]] > facet.j;
            const bool next = planes[third[m + 1 == n ? 0 : m + 1]] > facet.j;
            edge_begin_[f] += here ? 1 : 0;
            vertex_begin_[f] += here && next ? 1 : 0;
            out.rings[facet.ring_begin + m].third = planes[third[m]];
        }
        third += n;
    }
    exclusive_sum(edge_begin_);
    exclusive_sum(vertex_begin_);
    out.edges.resize(edge_begin_[facets]);
    out.vertices.resize(vertex_begin_[facets]);
}

void DiagramBuilder::fill_owned(const Diagram& problem, SiteId begin, SiteId end, VoronoiDiagram& out) const {
    for (uint32_t f = facet_begin_[begin]; f < facet_begin_[end]; ++f) {
        const VoronoiDiagram::Facet& facet = out.facets[f];
        uint32_t e = edge_begin_[f];
        uint32_t v = vertex_begin_[f];
        for (uint32_t m = facet.ring_begin; m < facet.ring_end; ++m) {
            const PlaneId here = out.rings[m].third;
            const PlaneId next = out.rings[m + 1 == facet.ring_end ? facet.ring_begin : m + 1].third;
            if (here < facet.j) continue;
            out.edges[e++] = {{facet.i, facet.j, here}, VoronoiDiagram::none, VoronoiDiagram::none};
            if (next < facet.j) continue;
            out.vertices[v].planes = {facet.i, facet.j, std::min(here, next), std::max(here, next)};
            out.vertices[v].position = vertex_position(problem, out.vertices[v].planes);
            ++v;
        }
    }
}

uint32_t DiagramBuilder::edge_of(const VoronoiDiagram& d, uint32_t facet, PlaneId third) const {
    for (uint32_t e = edge_begin_[facet]; e < edge_begin_[facet + 1]; ++e) {
        if (d.edges[e].planes[2] == third) return e;
    }
    assert(false && "two cells disagree about an edge");
    return VoronoiDiagram::none;
}

uint32_t DiagramBuilder::vertex_of(const VoronoiDiagram& d, uint32_t facet, PlaneId a, PlaneId b) const {
    for (uint32_t v = vertex_begin_[facet]; v < vertex_begin_[facet + 1]; ++v) {
        if (d.vertices[v].planes[2] == a && d.vertices[v].planes[3] == b) return v;
    }
    assert(false && "two cells disagree about a vertex");
    return VoronoiDiagram::none;
}

// Finds edges and vertices through the facet of their two lowest sites. One of these sites is nearly always the cell
// itself, and then the facet is in the neighbour list of the cell.
void DiagramBuilder::link_rings(const Chunk& chunk, SiteId begin, SiteId end, VoronoiDiagram& out) const {
    const uint32_t* third = chunk.rings.data();
    for (uint32_t f = facet_begin_[begin]; f < facet_begin_[end]; ++f) {
        const VoronoiDiagram::Facet& facet = out.facets[f];
        const VoronoiDiagram::Neighbour* const around = out.neighbours.data() + out.cell_begin[facet.i];
        const uint32_t n = facet.ring_end - facet.ring_begin;
        for (uint32_t m = 0; m < n; ++m) {
            VoronoiDiagram::Corner& corner = out.rings[facet.ring_begin + m];
            const uint32_t next = m + 1 == n ? 0 : m + 1;
            const PlaneId k = corner.third, l = out.rings[facet.ring_begin + next].third;
            corner.edge = k > facet.j ? edge_of(out, f, k) : edge_of(out, around[third[m]].facet, facet.j);
            const auto [low, high] = std::minmax(k, l);
            const auto planes = sorted<4>({facet.i, facet.j, k, l});
            uint32_t owner = f;
            if (high < facet.i)
                owner = out.facet_between(low, high);
            else if (low < facet.j)
                owner = around[third[low == k ? m : next]].facet;
            corner.vertex = vertex_of(out, owner, planes[2], planes[3]);
        }
        third += n;
        // The edges that the facet owns have thirds above j, so the ring runs along their direction.
        for (uint32_t m = facet.ring_begin; m < facet.ring_end; ++m) {
            const VoronoiDiagram::Corner& corner = out.rings[m];
            if (corner.third < facet.j) continue;
            VoronoiDiagram::Edge& edge = out.edges[corner.edge];
            edge.start = out.rings[(m == facet.ring_begin ? facet.ring_end : m) - 1].vertex;
            edge.end = corner.vertex;
        }
    }
}

} // namespace brittle::fracture::exact

namespace brittle::fracture {

uint32_t VoronoiDiagram::facet_between(uint32_t a, uint32_t b) const {
    const auto around = neighbours_of(a);
    const auto at = std::lower_bound(around.begin(), around.end(), b,
                                     [](const Neighbour& n, uint32_t site) { return n.site < site; });
    return at != around.end() && at->site == b ? at->facet : none;
}

} // namespace brittle::fracture

#include "fracture/exact/diagram.h"

#include <algorithm>
#include <atomic>
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

void DiagramBuilder::build(const Diagram& problem, Threads& threads, const SolidGrid* solid, VoronoiDiagram& out) {
    build_cells(problem, solid, threads, out);
    number_facets(out);
    number_items(out);
    if (solid) add_outside(out);
    const std::span<const SiteId> built = chosen_;
    const auto count = static_cast<uint32_t>(built.size());
    threads.for_chunks(count, min_cells_per_chunk, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (const SiteId c : built.subspan(begin, end - begin)) fill_owned(problem, c, out);
    });
    threads.for_chunks(count, min_cells_per_chunk, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (const SiteId c : built.subspan(begin, end - begin)) link_rings(c, out);
    });
}

void DiagramBuilder::build_cells(const Diagram& problem, const SolidGrid* solid, Threads& threads,
                                 VoronoiDiagram& out) {
    const auto sites = static_cast<uint32_t>(problem.sites.size());
    tree_.build(problem.sites, problem.weights);
    cells_.assign(sites, {});
    out.cell_is_empty.assign(sites, 1);
    for (Chunk& chunk : chunks_) {
        chunk.builder.stats = {};
        chunk.planes.clear();
        chunk.rings.clear();
        chunk.ring_sizes.clear();
    }
    choose_cells(solid);
    for (size_t built = 0; built < chosen_.size();) {
        const std::span<const SiteId> wave = std::span(chosen_).subspan(built);
        built = chosen_.size();
        const auto count = static_cast<uint32_t>(wave.size());
        const uint32_t parts = threads.chunks(count, min_cells_per_chunk);
        chunks_.resize(std::max<size_t>(chunks_.size(), parts));
        threads.for_chunks(count, min_cells_per_chunk, [&](uint32_t k, uint32_t begin, uint32_t end) {
            chunks_[k].found.clear();
            for (uint32_t at = begin; at < end; ++at) {
                threads.poll(at);
                build_cell(problem, solid, wave[at], k, out);
            }
        });
        for (uint32_t k = 0; k < parts; ++k)
            chosen_.insert(chosen_.end(), chunks_[k].found.begin(), chunks_[k].found.end());
    }
}

// Chooses the cells to start with: all of them, or the cells of the sites in the solid and one for each part of it.
void DiagramBuilder::choose_cells(const SolidGrid* solid) {
    chosen_.clear();
    is_chosen_.assign(cells_.size(), solid ? 0 : 1);
    if (!solid) {
        chosen_.assign(tree_.order().begin(), tree_.order().end());
        return;
    }
    const auto choose = [&](SiteId c) {
        if (!is_chosen_[c]) chosen_.push_back(c);
        is_chosen_[c] = 1;
    };
    tree_.visit([&](SiteId c, const glm::dvec3& position) {
        if (solid->covers(position)) choose(c);
    });
    for (const glm::dvec3& point : solid->group_points()) tree_.visit_nearest(point, choose);
}

void DiagramBuilder::build_cell(const Diagram& problem, const SolidGrid* solid, SiteId c, uint32_t chunk_index,
                                VoronoiDiagram& out) {
    Chunk& chunk = chunks_[chunk_index];
    out.cell_is_empty[c] = chunk.builder.build(problem, tree_, c) ? 0 : 1;
    const std::span<const PlaneId> planes = chunk.builder.planes();
    CellRef& cell = cells_[c];
    cell.chunk = chunk_index;
    cell.rings_begin = static_cast<uint32_t>(chunk.rings.size());
    cell.ring_sizes_begin = static_cast<uint32_t>(chunk.ring_sizes.size());
    cell.planes_begin = static_cast<uint32_t>(chunk.planes.size());
    chunk.planes.insert(chunk.planes.end(), planes.begin(), planes.end());
    cell.planes_end = static_cast<uint32_t>(chunk.planes.size());
    collect_rings(c, chunk);
    // The solid continues beyond each facet that it may meet.
    for (uint32_t p = 0; p < planes.size() && !is_box_plane(planes[p]); ++p) {
        std::atomic_ref<uint8_t> is_chosen(is_chosen_[planes[p]]);
        if (is_chosen.load(std::memory_order_relaxed) || !solid->meets(chunk.builder.facet_box(p))) continue;
        if (is_chosen.exchange(1, std::memory_order_relaxed) == 0) chunk.found.push_back(planes[p]);
    }
}

// Calls visit(facet, thirds) for each facet that a cell owns.
template<class Visit>
void DiagramBuilder::visit_owned(SiteId c, const Visit& visit) const {
    const CellRef& cell = cells_[c];
    const Chunk& chunk = chunks_[cell.chunk];
    const uint32_t* third = chunk.rings.data() + cell.rings_begin;
    const uint32_t* size = chunk.ring_sizes.data() + cell.ring_sizes_begin;
    uint32_t facet = facet_begin_[c];
    for (const PlaneId j : neighbours_of(c)) {
        if (j < c) continue;
        if (is_chosen_[j]) visit(facet++, std::span(third, *size));
        third += *size++;
    }
}

std::span<const PlaneId> DiagramBuilder::neighbours_of(SiteId c) const {
    const CellRef& cell = cells_[c];
    const std::span planes(chunks_[cell.chunk].planes.data() + cell.planes_begin, cell.planes_end - cell.planes_begin);
    return planes.first(
        static_cast<size_t>(std::lower_bound(planes.begin(), planes.end(), box_min_x) - planes.begin()));
}

void DiagramBuilder::number_facets(VoronoiDiagram& out) {
    const auto sites = static_cast<uint32_t>(cells_.size());
    out.cell_begin.assign(sites + 1, 0);
    facet_begin_.assign(sites + 1, 0);
    for (SiteId c = 0; c < sites; ++c) {
        for (const PlaneId j : neighbours_of(c)) {
            ++out.cell_begin[c];
            if (j > c && is_chosen_[j]) ++facet_begin_[c];
        }
    }
    exclusive_sum(out.cell_begin);
    exclusive_sum(facet_begin_);
    out.neighbours.resize(out.cell_begin[sites]);
    out.facets.resize(facet_begin_[sites]);
    for (SiteId c = 0; c < sites; ++c) {
        uint32_t at = out.cell_begin[c];
        for (const PlaneId j : neighbours_of(c)) out.neighbours[at++] = {j, VoronoiDiagram::none};
    }
    // Facet ids ascend with (i,j), and so do the neighbours below j in the list of j: one cursor per cell finds the
    // place of each facet.
    std::vector<uint32_t>& cursor = edge_begin_; // its memory is free until number_items()
    cursor.assign(out.cell_begin.begin(), out.cell_begin.end());
    uint32_t facet = 0;
    for (SiteId c = 0; c < sites; ++c) {
        for (uint32_t at = out.cell_begin[c]; at < out.cell_begin[c + 1]; ++at) {
            const SiteId j = out.neighbours[at].site;
            if (j < c || !is_chosen_[j]) continue;
            while (out.neighbours[cursor[j]].site != c) ++cursor[j];
            out.neighbours[at].facet = out.neighbours[cursor[j]].facet = facet;
            out.facets[facet++] = {c, j, 0, 0};
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
    edge_begin_.assign(facets + 1, 0);
    vertex_begin_.assign(facets + 1, 0);
    out.rings.clear();
    for (SiteId c = 0; c < cells_.size(); ++c) {
        const PlaneId* const planes = chunks_[cells_[c].chunk].planes.data() + cells_[c].planes_begin;
        visit_owned(c, [&](uint32_t f, std::span<const uint32_t> thirds) {
            VoronoiDiagram::Facet& facet = out.facets[f];
            facet.ring_begin = static_cast<uint32_t>(out.rings.size());
            bool here = owns(facet, planes[thirds.front()]);
            for (size_t m = 0; m < thirds.size(); ++m) {
                const bool next = owns(facet, planes[thirds[m + 1 == thirds.size() ? 0 : m + 1]]);
                edge_begin_[f] += here ? 1 : 0;
                vertex_begin_[f] += here && next ? 1 : 0;
                out.rings.push_back({planes[thirds[m]], 0, 0});
                here = next;
            }
            facet.ring_end = static_cast<uint32_t>(out.rings.size());
        });
    }
    exclusive_sum(edge_begin_);
    exclusive_sum(vertex_begin_);
    out.edges.resize(edge_begin_[facets]);
    out.vertices.resize(vertex_begin_[facets]);
}

// Adds the vertex and the edge that stand for all vertices and edges of cells that were not built. They count as parts
// of the box, because they lie outside the solid. The edge names a site that exists, so that readers may look it up.
void DiagramBuilder::add_outside(VoronoiDiagram& out) {
    constexpr PlaneId none = VoronoiDiagram::none;
    outside_vertex_ = static_cast<uint32_t>(out.vertices.size());
    outside_edge_ = static_cast<uint32_t>(out.edges.size());
    out.vertices.push_back({{none, none, none, none}, glm::dvec3(0.0)});
    out.edges.push_back({{0, 0, none}, outside_vertex_, outside_vertex_});
}

void DiagramBuilder::fill_owned(const Diagram& problem, SiteId c, VoronoiDiagram& out) const {
    for (uint32_t f = facet_begin_[c]; f < facet_begin_[c + 1]; ++f) {
        const VoronoiDiagram::Facet& facet = out.facets[f];
        uint32_t e = edge_begin_[f];
        uint32_t v = vertex_begin_[f];
        for (uint32_t m = facet.ring_begin; m < facet.ring_end; ++m) {
            const PlaneId here = out.rings[m].third;
            const PlaneId next = out.rings[m + 1 == facet.ring_end ? facet.ring_begin : m + 1].third;
            if (!owns(facet, here)) continue;
            out.edges[e++] = {{facet.i, facet.j, here}, VoronoiDiagram::none, VoronoiDiagram::none};
            if (!owns(facet, next)) continue;
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
void DiagramBuilder::link_rings(SiteId c, VoronoiDiagram& out) const {
    const VoronoiDiagram::Neighbour* const around = out.neighbours.data() + out.cell_begin[c];
    visit_owned(c, [&](uint32_t f, std::span<const uint32_t> thirds) {
        const VoronoiDiagram::Facet& facet = out.facets[f];
        uint32_t own_edge = edge_begin_[f], own_vertex = vertex_begin_[f]; // in the order of fill_owned()
        for (size_t m = 0; m < thirds.size(); ++m) {
            VoronoiDiagram::Corner& corner = out.rings[facet.ring_begin + m];
            const size_t next = m + 1 == thirds.size() ? 0 : m + 1;
            const PlaneId k = corner.third, l = out.rings[facet.ring_begin + next].third;
            corner.edge = outside_edge_;
            corner.vertex = outside_vertex_;
            if (!is_built(k)) continue;
            corner.edge = k > facet.j ? own_edge++ : edge_of(out, around[thirds[m]].facet, facet.j);
            if (!is_built(l)) continue;
            const auto [low, high] = std::minmax(k, l);
            if (low > facet.j) {
                corner.vertex = own_vertex++;
                continue;
            }
            const auto planes = sorted<4>({facet.i, facet.j, k, l});
            const uint32_t owner =
                high < facet.i ? out.facet_between(low, high) : around[thirds[low == k ? m : next]].facet;
            corner.vertex = vertex_of(out, owner, planes[2], planes[3]);
        }
        // The edges that the facet owns have thirds above j, so the ring runs along their direction.
        for (uint32_t m = facet.ring_begin; m < facet.ring_end; ++m) {
            const VoronoiDiagram::Corner& corner = out.rings[m];
            if (!owns(facet, corner.third)) continue;
            VoronoiDiagram::Edge& edge = out.edges[corner.edge];
            edge.start = out.rings[(m == facet.ring_begin ? facet.ring_end : m) - 1].vertex;
            edge.end = corner.vertex;
        }
    });
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

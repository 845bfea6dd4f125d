#include "fracture/exact/winding.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace brittle::fracture::exact {

namespace {

constexpr uint32_t min_edges_per_chunk = 512;
constexpr int32_t unknown_winding = 0x7fffffff;

int32_t change_along(const PiercePoint& point) {
    return point.leaves ? -1 : 1;
}

// Pierce points that the predicate cannot order lie in one plane, so any order is right. Alternating between entering
// and leaving keeps the sheets of the solid apart.
void alternate(std::span<uint32_t> tied, const Cut& cut, int32_t winding) {
    for (size_t k = 0; k < tied.size(); ++k) {
        const int32_t wanted = winding >= 1 ? -1 : 1;
        for (size_t m = k; m < tied.size(); ++m) {
            if (change_along(cut.pierce_points[tied[m]]) == wanted) {
                std::swap(tied[k], tied[m]);
                break;
            }
        }
        winding += change_along(cut.pierce_points[tied[k]]);
    }
}

} // namespace

void Winding::group_by_edge(const VoronoiDiagram& diagram, const Cut& cut) {
    pierce_begin.assign(diagram.edges.size() + 2, 0);
    for (const PiercePoint& point : cut.pierce_points) ++pierce_begin[point.voronoi_edge + 2];
    for (size_t e = 2; e < pierce_begin.size(); ++e) pierce_begin[e] += pierce_begin[e - 1];
    pierces.resize(cut.pierce_points.size());
    for (uint32_t p = 0; p < cut.pierce_points.size(); ++p) {
        pierces[pierce_begin[cut.pierce_points[p].voronoi_edge + 1]++] = p;
    }
}

void Winding::spread(const VoronoiDiagram& diagram, const Cut& cut) {
    const auto vertices = static_cast<uint32_t>(diagram.vertices.size());
    edge_of_vertex_begin_.assign(vertices + 2, 0);
    for (const auto& edge : diagram.edges) {
        ++edge_of_vertex_begin_[edge.start + 2];
        ++edge_of_vertex_begin_[edge.end + 2];
    }
    for (uint32_t v = 2; v < vertices + 2; ++v) edge_of_vertex_begin_[v] += edge_of_vertex_begin_[v - 1];
    edges_of_vertex_.resize(2 * diagram.edges.size());
    for (uint32_t e = 0; e < diagram.edges.size(); ++e) {
        edges_of_vertex_[edge_of_vertex_begin_[diagram.edges[e].start + 1]++] = e;
        edges_of_vertex_[edge_of_vertex_begin_[diagram.edges[e].end + 1]++] = e;
    }

    of_vertex.assign(vertices, unknown_winding);
    consistent = true;
    queue_.clear();
    for (uint32_t v = 0; v < vertices; ++v) {
        if (diagram.vertices[v].on_box()) {
            of_vertex[v] = 0;
            queue_.push_back(v);
        }
    }
    for (size_t at = 0; at < queue_.size(); ++at) {
        const uint32_t v = queue_[at];
        for (uint32_t m = edge_of_vertex_begin_[v]; m < edge_of_vertex_begin_[v + 1]; ++m) {
            const uint32_t e = edges_of_vertex_[m];
            const VoronoiDiagram::Edge& edge = diagram.edges[e];
            int32_t change = 0;
            for (const uint32_t p : pierces_of(e)) change += change_along(cut.pierce_points[p]);
            const bool along = edge.start == v;
            const uint32_t other = along ? edge.end : edge.start;
            const int32_t w = of_vertex[v] + (along ? change : -change);
            if (of_vertex[other] == unknown_winding) {
                of_vertex[other] = w;
                queue_.push_back(other);
            } else if (of_vertex[other] != w) {
                consistent = false;
            }
        }
    }
    assert(queue_.size() == vertices);
}

void Winding::make_nodes(const VoronoiDiagram& diagram, Cut& cut) {
    const auto vertices = static_cast<uint32_t>(diagram.vertices.size());
    first_node.resize(vertices + 1);
    cut.nodes.clear();
    for (uint32_t v = 0; v < vertices; ++v) {
        first_node[v] = static_cast<uint32_t>(cut.nodes.size());
        if (of_vertex[v] == unknown_winding) of_vertex[v] = 0;
        const Node node{diagram.vertices[v].planes, diagram.vertices[v].position, {}};
        cut.nodes.insert(cut.nodes.end(), static_cast<size_t>(std::abs(of_vertex[v])), node);
    }
    first_node[vertices] = static_cast<uint32_t>(cut.nodes.size());
}

void Winding::sort_edge(const Scene& scene, const VoronoiDiagram& diagram, std::span<const Triangle> triangles,
                        const Cut& cut, uint32_t voronoi_edge, PredicateStats& stats) {
    const std::span<uint32_t> points = std::span(pierces).subspan(
        pierce_begin[voronoi_edge], pierce_begin[voronoi_edge + 1] - pierce_begin[voronoi_edge]);
    if (points.size() < 2) return;
    const std::array<PlaneId, 3>& cells = diagram.edges[voronoi_edge].planes;
    const Diagram problem = scene.diagram();
    const auto corners = [&](uint32_t p) {
        const Triangle& t = triangles[cut.pierce_points[p].triangle];
        return Corners{scene.positions[t.x], scene.positions[t.y], scene.positions[t.z]};
    };
    const auto order = [&](uint32_t a, uint32_t b) {
        return pierce_order(problem, cells[0], cells[1], cells[2], corners(a), corners(b), stats);
    };
    if (points.size() == 2) { // by far the most frequent case
        if (order(points[0], points[1]) > 0) std::swap(points[0], points[1]);
    } else {
        std::stable_sort(points.begin(), points.end(), [&](uint32_t a, uint32_t b) { return order(a, b) < 0; });
    }
    int32_t winding = of_vertex[diagram.edges[voronoi_edge].start];
    for (size_t first = 0; first < points.size();) {
        size_t last = first + 1;
        while (last < points.size() && order(points[first], points[last]) == 0) ++last;
        if (last - first > 1) alternate(points.subspan(first, last - first), cut, winding);
        for (; first < last; ++first) winding += change_along(cut.pierce_points[points[first]]);
    }
}

void Winding::compute(const Scene& scene, const VoronoiDiagram& diagram, std::span<const Triangle> triangles, Cut& cut,
                      Threads& threads, PredicateStats& stats) {
    group_by_edge(diagram, cut);
    spread(diagram, cut);
    make_nodes(diagram, cut);
    const auto edges = static_cast<uint32_t>(diagram.edges.size());
    std::vector<PredicateStats> part(threads.chunks(edges, min_edges_per_chunk));
    threads.for_chunks(edges, min_edges_per_chunk, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        for (uint32_t e = begin; e < end; ++e) {
            threads.poll(e);
            sort_edge(scene, diagram, triangles, cut, e, part[chunk]);
        }
    });
    for (const PredicateStats& p : part) stats += p;
}

} // namespace brittle::fracture::exact

#include "fracture/exact/assemble.h"

#include <algorithm>
#include <cassert>

namespace brittle::fracture::exact {

namespace {

constexpr uint32_t min_vertices_per_chunk = 8192;
constexpr uint32_t min_triangles_per_chunk = TriangleSorter::min_triangles_per_chunk;
constexpr uint32_t min_points_per_chunk = 2048;

uint32_t size_of(const auto& array) {
    return static_cast<uint32_t>(array.size());
}

template<size_t N>
uint32_t place_of(SiteId cell, const std::array<uint32_t, N>& cells) {
    return static_cast<uint32_t>(std::find(cells.begin(), cells.end(), cell) - cells.begin());
}

glm::dvec3 position_of(const TriangleMesh& mesh, const Cut& cut, double to_input, VertexId id) {
    switch (id.kind()) {
    case VertexId::mesh:
        return mesh.positions[id.index()];
    case VertexId::edge:
        return cut.edge_positions[id.index()] * to_input;
    default:
        return cut.pierce_positions[id.index()] * to_input;
    }
}

double distance2(const glm::dvec3& a, const glm::dvec3& b) {
    const glm::dvec3 d = a - b;
    return d.x * d.x + d.y * d.y + d.z * d.z;
}

} // namespace

uint32_t Assembler::local_index(const Input& input, VertexId id, SiteId cell) const {
    switch (id.kind()) {
    case VertexId::mesh:
        return local_of_mesh_[id.index()];
    case VertexId::edge: {
        const EdgePoint& point = input.cut.edge_points[id.index()];
        return point.local[point.cells[0] == cell ? 0 : 1];
    }
    case VertexId::pierce: {
        const PiercePoint& point = input.cut.pierce_points[id.index()];
        return point.local[place_of(cell, point.cells)];
    }
    case VertexId::node:
        break;
    }
    const Node& node = input.cut.nodes[id.index()];
    return node.local[place_of(cell, node.cells)];
}

void Assembler::count_vertices(const Input& input, Threads& threads) {
    const Cut& cut = input.cut;
    const uint32_t cells = size_of(input.scene.sites), vertices = size_of(input.cell_of);
    const uint32_t points = size_of(cut.edge_points), pierces = size_of(cut.pierce_points);
    const uint32_t nodes = size_of(cut.nodes);

    edge_row_ = threads.chunks(vertices, min_vertices_per_chunk);
    pierce_row_ = edge_row_ + threads.chunks(points, min_points_per_chunk);
    node_row_ = pierce_row_ + threads.chunks(pierces, min_points_per_chunk);
    vertex_table_.reset(node_row_ + threads.chunks(nodes, min_points_per_chunk), cells);
    threads.for_chunks(vertices, min_vertices_per_chunk, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        uint32_t* const row = vertex_table_.row(chunk);
        const auto& component = input.surface.components();
        for (uint32_t v = begin; v < end; ++v) row[input.cell_of[v]] += component[v] != no_index ? 1 : 0;
    });
    threads.for_chunks(points, min_points_per_chunk, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        uint32_t* const row = vertex_table_.row(edge_row_ + chunk);
        for (uint32_t p = begin; p < end; ++p) {
            for (const uint32_t c : cut.edge_points[p].cells) ++row[c];
        }
    });
    threads.for_chunks(pierces, min_points_per_chunk, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        uint32_t* const row = vertex_table_.row(pierce_row_ + chunk);
        for (uint32_t p = begin; p < end; ++p) {
            for (const uint32_t c : cut.pierce_points[p].cells) ++row[c];
        }
    });
    threads.for_chunks(nodes, min_points_per_chunk, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        uint32_t* const row = vertex_table_.row(node_row_ + chunk);
        for (uint32_t n = begin; n < end; ++n) {
            for (const uint32_t c : cut.nodes[n].cells) {
                if (c != no_index) ++row[c];
            }
        }
    });
}

void Assembler::count_triangles(const Input& input, Threads& threads) {
    const Cut& cut = input.cut;
    const uint32_t cells = size_of(input.scene.sites), triangles = size_of(input.cell_of_triangle);
    polygon_row_ = threads.chunks(triangles, min_triangles_per_chunk);
    cap_row_ = polygon_row_ + cut.chunk_count;
    triangle_table_.reset(cap_row_ + size_of(input.caps), cells);
    for (uint32_t k = 0; k < polygon_row_; ++k)
        std::copy_n(input.whole_triangles.row(k), cells, triangle_table_.row(k));
    threads.for_chunks(cut.chunk_count, 1, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t k = begin; k < end; ++k) {
            uint32_t* const row = triangle_table_.row(polygon_row_ + k);
            for (const Polygon& polygon : cut.chunks[k].polygons) row[polygon.cell] += polygon.end - polygon.begin - 2;
        }
    });
    threads.for_chunks(size_of(input.caps), 1, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t k = begin; k < end; ++k) {
            uint32_t* const row = triangle_table_.row(cap_row_ + k);
            for (const Cap& cap : input.caps[k].caps) {
                const VoronoiDiagram::Facet& facet = input.diagram.facets[cap.facet];
                row[facet.i] += cap.triangles_end - cap.triangles_begin;
                row[facet.j] += cap.triangles_end - cap.triangles_begin;
            }
        }
    });
}

void Assembler::lay_out(const Input& input, Threads& threads, Fragments& out) {
    vertex_table_.scan(threads, vertex_total_);
    triangle_table_.scan(threads, triangle_total_);
    const uint32_t cells = size_of(input.scene.sites);
    cells_.resize(cells);
    uint32_t vertices = 0, triangles = 0;
    // The first row of a kind starts at the number of items of all kinds before it.
    const uint32_t* const first_edge_point = vertex_table_.row(edge_row_);
    const uint32_t* const first_polygon = triangle_table_.row(polygon_row_);
    const uint32_t* const first_cap = input.caps.empty() ? triangle_total_.data() : triangle_table_.row(cap_row_);
    for (SiteId c = 0; c < cells; ++c) {
        CellRun& cell = cells_[c];
        cell.vertices = {vertices, vertices + vertex_total_[c]};
        cell.triangles = {triangles, triangles + triangle_total_[c]};
        cell.mesh_vertices = first_edge_point[c];
        cell.whole_triangles = first_polygon[c];
        cell.exterior = first_cap[c];
        vertices = cell.vertices.end;
        triangles = cell.triangles.end;
    }
    out.positions.resize(vertices);
    out.vertex_point.resize(vertices);
    out.triangles.resize(triangles);
    out.triangle_source.resize(triangles);
}

void Assembler::place_vertices(const Input& input, Threads& threads, Fragments& out) {
    Cut& cut = input.cut;
    const double to_input = input.scene.to_input;
    const auto put = [&](SiteId cell, uint32_t local, VertexId id, const glm::dvec3& position) {
        const uint32_t at = cells_[cell].vertices.begin + local;
        out.positions[at] = position;
        out.vertex_point[at] = id.bits();
    };
    local_of_mesh_.resize(input.cell_of.size());
    threads.for_chunks(size_of(input.cell_of), min_vertices_per_chunk,
                       [&](uint32_t chunk, uint32_t begin, uint32_t end) {
                           uint32_t* const row = vertex_table_.row(chunk);
                           const auto& component = input.surface.components();
                           for (uint32_t v = begin; v < end; ++v) {
                               if (component[v] == no_index) continue;
                               const SiteId c = input.cell_of[v];
                               local_of_mesh_[v] = row[c]++;
                               put(c, local_of_mesh_[v], {VertexId::mesh, v}, input.mesh.positions[v]);
                           }
                       });
    const auto place = [&](uint32_t* row, auto& local, const auto& cells, VertexId id, const glm::dvec3& position) {
        for (size_t k = 0; k < cells.size() && cells[k] != no_index; ++k) {
            local[k] = row[cells[k]]++;
            put(cells[k], local[k], id, position * to_input);
        }
    };
    threads.for_chunks(size_of(cut.edge_points), min_points_per_chunk,
                       [&](uint32_t chunk, uint32_t begin, uint32_t end) {
                           uint32_t* const row = vertex_table_.row(edge_row_ + chunk);
                           for (uint32_t p = begin; p < end; ++p) {
                               EdgePoint& point = cut.edge_points[p];
                               place(row, point.local, point.cells, {VertexId::edge, p}, cut.edge_positions[p]);
                           }
                       });
    threads.for_chunks(size_of(cut.pierce_points), min_points_per_chunk,
                       [&](uint32_t chunk, uint32_t begin, uint32_t end) {
                           uint32_t* const row = vertex_table_.row(pierce_row_ + chunk);
                           for (uint32_t p = begin; p < end; ++p) {
                               PiercePoint& point = cut.pierce_points[p];
                               place(row, point.local, point.cells, {VertexId::pierce, p}, cut.pierce_positions[p]);
                           }
                       });
    threads.for_chunks(size_of(cut.nodes), min_points_per_chunk, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        uint32_t* const row = vertex_table_.row(node_row_ + chunk);
        for (uint32_t n = begin; n < end; ++n) {
            Node& node = cut.nodes[n];
            place(row, node.local, node.cells, {VertexId::node, n}, node.position);
        }
    });
}

void Assembler::place_whole(const Input& input, Threads& threads, Fragments& out) {
    threads.for_chunks(
        size_of(input.cell_of_triangle), min_triangles_per_chunk, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
            uint32_t* const row = triangle_table_.row(chunk);
            for (uint32_t t = begin; t < end; ++t) {
                const SiteId c = input.cell_of_triangle[t];
                if (c == no_index) continue;
                const uint32_t at = cells_[c].triangles.begin + row[c]++;
                const Triangle& corners = input.mesh.triangles[t];
                out.triangles[at] = {local_of_mesh_[corners.x], local_of_mesh_[corners.y], local_of_mesh_[corners.z]};
                out.triangle_source[at] = t;
            }
        });
}

void Assembler::place_polygons(const Input& input, Threads& threads, Fragments& out) {
    const Cut& cut = input.cut;
    threads.for_chunks(cut.chunk_count, 1, [&](uint32_t, uint32_t first, uint32_t last) {
        for (uint32_t k = first; k < last; ++k) {
            uint32_t* const row = triangle_table_.row(polygon_row_ + k);
            std::vector<uint32_t> local;
            for (const Polygon& polygon : cut.chunks[k].polygons) {
                const VertexId* const ids = cut.chunks[k].corners.data() + polygon.begin;
                const uint32_t n = polygon.end - polygon.begin;
                local.resize(n);
                for (uint32_t m = 0; m < n; ++m) local[m] = local_index(input, ids[m], polygon.cell);
                uint32_t at = cells_[polygon.cell].triangles.begin + row[polygon.cell];
                row[polygon.cell] += n - 2;
                const auto emit = [&](uint32_t a, uint32_t b, uint32_t c) {
                    out.triangles[at] = {local[a], local[b], local[c]};
                    out.triangle_source[at] = polygon.triangle;
                    ++at;
                };
                // A zigzag strip. Quads, the most frequent polygons, are cut along the shorter diagonal.
                uint32_t low = 0, high = n - 1;
                if (n == 4) {
                    const auto p = [&](uint32_t m) {
                        return position_of(input.mesh, cut, input.scene.to_input, ids[m]);
                    };
                    if (distance2(p(0), p(2)) < distance2(p(1), p(3))) {
                        emit(0, 1, 2);
                        emit(0, 2, 3);
                        continue;
                    }
                }
                while (high - low >= 2) {
                    emit(low, low + 1, high);
                    if (++low; high - low < 2) break;
                    emit(low, high - 1, high);
                    --high;
                }
            }
        }
    });
}

void Assembler::place_caps(const Input& input, Threads& threads, Fragments& out) {
    threads.for_chunks(size_of(input.caps), 1, [&](uint32_t, uint32_t first, uint32_t last) {
        std::vector<uint32_t> local;
        for (uint32_t k = first; k < last; ++k) {
            uint32_t* const row = triangle_table_.row(cap_row_ + k);
            const CapChunk& chunk = input.caps[k];
            for (const Cap& cap : chunk.caps) {
                const VoronoiDiagram::Facet& facet = input.diagram.facets[cap.facet];
                const uint32_t n = cap.triangles_end - cap.triangles_begin;
                for (const bool far_side : {false, true}) {
                    const SiteId c = far_side ? facet.j : facet.i;
                    local.clear();
                    for (uint32_t m = cap.corners_begin; m < cap.corners_end; ++m) {
                        local.push_back(local_index(input, chunk.corners[m], c));
                    }
                    uint32_t at = cells_[c].triangles.begin + row[c];
                    row[c] += n;
                    for (uint32_t t = cap.triangles_begin; t < cap.triangles_end; ++t, ++at) {
                        const Triangle& corners = chunk.triangles[t];
                        const uint32_t a = local[corners.x], b = local[corners.y], d = local[corners.z];
                        out.triangles[at] = far_side ? Triangle{a, d, b} : Triangle{a, b, d};
                        out.triangle_source[at] = far_side ? facet.i : facet.j;
                    }
                }
            }
        }
    });
}

void Assembler::run(const Input& input, Threads& threads, Fragments& out) {
    count_vertices(input, threads);
    count_triangles(input, threads);
    lay_out(input, threads, out);
    place_vertices(input, threads, out);
    place_whole(input, threads, out);
    place_polygons(input, threads, out);
    place_caps(input, threads, out);
}

} // namespace brittle::fracture::exact

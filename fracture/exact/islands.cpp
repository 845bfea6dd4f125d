#include "fracture/exact/islands.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <glm/geometric.hpp>

#include "fracture/base/union_find.h"
#include "fracture/mesh/islands.h"
#include "fracture/mesh/mass_properties.h"

namespace brittle::fracture::exact {

namespace {

constexpr uint32_t min_cells_per_chunk = 4;

void unite(std::vector<uint32_t>& parent, const Triangle& t) {
    const uint32_t a = root_of(parent, t.x), b = root_of(parent, t.y), c = root_of(parent, t.z);
    const uint32_t least = std::min({a, b, c});
    parent[a] = parent[b] = parent[c] = least;
}

} // namespace

void IslandSplitter::count_uncut_components(const Assembler::Input& input) {
    uncut_.assign(input.scene.sites.size(), 0);
    const auto& component = input.surface.components();
    if (input.surface.component_count() == 1 && !input.cut.crossing.empty()) return;
    component_is_cut_.assign(component.size(), 0);
    for (const CrossingTriangle& crossing : input.cut.crossing) {
        component_is_cut_[component[input.mesh.triangles[crossing.triangle].x]] = 1;
    }
    for (uint32_t v = 0; v < component.size(); ++v) {
        if (component[v] == v && !component_is_cut_[v]) ++uncut_[input.cell_of[v]];
    }
}

// Counts the groups of united vertices with a cut vertex, each by its root, and the components that no bisector meets.
// Stops at 2.
uint32_t IslandSplitter::count_groups(SiteId c, const CellRun& cell, Chunk& chunk) const {
    uint32_t groups = uncut_[c];
    chunk.label.assign(cell.vertices.size(), 0);
    for (uint32_t v = cell.mesh_vertices; v < cell.vertices.size() && groups < 2; ++v) {
        uint32_t& seen = chunk.label[root_of(chunk.parent, v)];
        groups += seen == 0 ? 1 : 0;
        seen = 1;
    }
    return groups;
}

// Returns the number of islands. Where there are several, labels the vertices of the cell with islands, which are
// numbered by their lowest vertex.
uint32_t IslandSplitter::find_islands(SiteId c, const CellRun& cell, std::span<const Triangle> triangles,
                                      Chunk& chunk) const {
    const uint32_t vertices = cell.vertices.size();
    chunk.parent.resize(vertices);
    std::iota(chunk.parent.begin(), chunk.parent.end(), 0u);
    const auto caps = triangles.subspan(cell.exterior);
    const auto polygons = triangles.first(cell.exterior).subspan(cell.whole_triangles);
    for (const std::span<const Triangle> part : {caps, polygons}) {
        for (const Triangle& t : part) unite(chunk.parent, t);
        const uint32_t groups = count_groups(c, cell, chunk);
        if (groups < 2) return groups;
    }
    for (const Triangle& t : triangles.first(cell.whole_triangles)) unite(chunk.parent, t);
    uint32_t islands = 0;
    for (uint32_t v = 0; v < vertices; ++v) { // a root is the lowest vertex of its set
        const uint32_t r = root_of(chunk.parent, v);
        chunk.label[v] = r == v ? islands++ : chunk.label[r];
    }
    return islands;
}

uint32_t IslandSplitter::attach_cavities(const CellRun& cell, const Fragments& out, uint32_t islands, Chunk& chunk) {
    const std::span positions(out.positions.data() + cell.vertices.begin, cell.vertices.size());
    const std::span triangles(out.triangles.data() + cell.triangles.begin, cell.triangles.size());
    chunk.volume.assign(islands, 0.0);
    const glm::dvec3 origin = positions[0];
    for (const Triangle& t : triangles) {
        const glm::dvec3 a = positions[t.x] - origin, b = positions[t.y] - origin, c = positions[t.z] - origin;
        chunk.volume[chunk.label[t.x]] += glm::dot(a, glm::cross(b, c));
    }
    const auto is_cavity = [&](uint32_t k) { return chunk.volume[k] < 0.0; };
    if (std::none_of(chunk.volume.begin(), chunk.volume.end(), [](double v) { return v < 0.0; })) return islands;

    std::vector<std::vector<Triangle>> of_island(islands);
    for (const Triangle& t : triangles) of_island[chunk.label[t.x]].push_back(t);
    std::vector<uint32_t> home(islands);
    std::iota(home.begin(), home.end(), 0u);
    for (uint32_t k = 0; k < islands; ++k) {
        if (!is_cavity(k)) continue;
        for (uint32_t m = 0; m < islands; ++m) {
            const bool smaller = home[k] == k || chunk.volume[m] < chunk.volume[home[k]];
            if (is_cavity(m) || chunk.volume[m] < -chunk.volume[k] || !smaller) continue;
            if (encloses(positions, of_island[m], positions, of_island[k])) home[k] = m;
        }
    }
    // Number the remaining islands by their lowest vertex again.
    std::vector<uint32_t> number(islands, no_index);
    uint32_t remaining = 0;
    for (uint32_t& label : chunk.label) {
        uint32_t& n = number[home[label]];
        if (n == no_index) n = remaining++;
        label = n;
    }
    return remaining;
}

// Sorts vertices and triangles by island. Stable.
void IslandSplitter::reorder(const CellRun& cell, uint32_t islands, Chunk& chunk, Fragments& out) {
    const std::span positions(out.positions.data() + cell.vertices.begin, cell.vertices.size());
    const std::span points(out.vertex_point.data() + cell.vertices.begin, cell.vertices.size());
    const std::span triangles(out.triangles.data() + cell.triangles.begin, cell.triangles.size());
    const std::span sources(out.triangle_source.data() + cell.triangles.begin, cell.triangles.size());
    const auto first = static_cast<uint32_t>(chunk.pieces.size()) - islands;

    std::vector<uint32_t>& cursor = chunk.island_begin;
    cursor.assign(islands + 1, 0);
    for (const uint32_t label : chunk.label) ++cursor[label + 1];
    for (uint32_t k = 0; k < islands; ++k) {
        cursor[k + 1] += cursor[k];
        chunk.pieces[first + k].vertices = {cell.vertices.begin + cursor[k], cell.vertices.begin + cursor[k + 1]};
    }
    chunk.positions.assign(positions.begin(), positions.end());
    chunk.points.assign(points.begin(), points.end());
    chunk.vertex_order.resize(positions.size());
    std::vector<uint32_t> begin(cursor.begin(), cursor.end() - 1);
    for (size_t v = 0; v < positions.size(); ++v) {
        const uint32_t at = cursor[chunk.label[v]]++;
        positions[at] = chunk.positions[v];
        points[at] = chunk.points[v];
        chunk.vertex_order[v] = at - begin[chunk.label[v]];
    }

    cursor.assign(islands + 1, 0);
    for (const Triangle& t : triangles) ++cursor[chunk.label[t.x] + 1];
    for (uint32_t k = 0; k < islands; ++k) {
        cursor[k + 1] += cursor[k];
        chunk.pieces[first + k].triangles = {cell.triangles.begin + cursor[k], cell.triangles.begin + cursor[k + 1]};
    }
    chunk.triangles.assign(triangles.begin(), triangles.end());
    chunk.sources.assign(sources.begin(), sources.end());
    for (uint32_t t = 0; t < triangles.size(); ++t) {
        const Triangle& corners = chunk.triangles[t];
        const uint32_t island = chunk.label[corners.x];
        const uint32_t at = cursor[island]++;
        triangles[at] = {chunk.vertex_order[corners.x], chunk.vertex_order[corners.y], chunk.vertex_order[corners.z]};
        sources[at] = chunk.sources[t];
        if (t < cell.exterior) ++chunk.pieces[first + island].exterior_triangles;
    }
}

void IslandSplitter::split_cell(SiteId c, const CellRun& cell, Chunk& chunk, Fragments& out) {
    if (cell.triangles.size() == 0) return;
    const std::span<const Triangle> triangles(out.triangles.data() + cell.triangles.begin, cell.triangles.size());
    uint32_t islands = find_islands(c, cell, triangles, chunk);
    if (islands > 1) islands = attach_cavities(cell, out, islands, chunk);
    if (islands <= 1) {
        chunk.pieces.push_back({c, cell.vertices, cell.triangles, cell.exterior, {}});
        return;
    }
    chunk.pieces.resize(chunk.pieces.size() + islands);
    for (size_t k = chunk.pieces.size() - islands; k < chunk.pieces.size(); ++k) chunk.pieces[k].site = c;
    reorder(cell, islands, chunk, out);
}

void IslandSplitter::run(const Assembler::Input& input, std::span<const CellRun> cells, Threads& threads,
                         Fragments& out) {
    count_uncut_components(input);
    const auto count = static_cast<uint32_t>(cells.size());
    const uint32_t parts = threads.chunks(count, min_cells_per_chunk);
    if (chunks_.size() < parts) chunks_.resize(parts);
    threads.for_chunks(count, min_cells_per_chunk, [&](uint32_t k, uint32_t begin, uint32_t end) {
        Chunk& chunk = chunks_[k];
        chunk.pieces.clear();
        for (SiteId c = begin; c < end; ++c) {
            threads.poll(c);
            split_cell(c, cells[c], chunk, out);
        }
        for (Piece& piece : chunk.pieces) {
            const auto positions = out.positions_of(piece); // all are corners of triangles
            piece.mass = mass_properties(positions, out.triangles_of(piece), bounds(positions));
        }
    });
    out.pieces.clear();
    for (uint32_t k = 0; k < parts; ++k)
        out.pieces.insert(out.pieces.end(), chunks_[k].pieces.begin(), chunks_[k].pieces.end());
}

} // namespace brittle::fracture::exact

#include "fracture/mesh/half_edge.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>

#include "fracture/base/union_find.h"

namespace brittle::fracture {

namespace {

using Corner3 = std::array<uint32_t, 3>;

constexpr int following(int corner) {
    return (corner + 1) % 3;
}

void link(HalfEdgeMesh& mesh, uint32_t half_edge, uint32_t next) {
    mesh[half_edge].next = next;
    mesh[next].prev = half_edge;
}

uint32_t add_edge(HalfEdgeMesh& mesh, uint32_t from, uint32_t to) {
    const auto forward = static_cast<uint32_t>(mesh.half_edges.size());
    mesh.half_edges.push_back({.origin = from, .twin = forward + 1});
    mesh.half_edges.push_back({.origin = to, .twin = forward});
    return forward;
}

// Makes the BORDER half-edge `out` the successor of `in`. Both meet in a vertex, but belong to different fans. The fans
// between them move to the gap at the far end of the fan that begins with `out`. Returns false if the only gap is the
// one between `in` and `out`: closing it would separate those fans from a complete one.
bool bring_together(HalfEdgeMesh& mesh, uint32_t in, uint32_t out) {
    uint32_t gap = mesh[out].twin;
    do {
        gap = mesh[mesh[gap].next].twin;
    } while (!mesh.is_border(gap));
    if (gap == in) return false;
    const uint32_t after_gap = mesh[gap].next;
    const uint32_t first_moved = mesh[in].next;
    const uint32_t last_moved = mesh[out].prev;
    link(mesh, gap, first_moved);
    link(mesh, last_moved, after_gap);
    link(mesh, in, out);
    return true;
}

// The successor links of a new face, written once all its corners have been read.
struct Links {
    std::array<std::pair<uint32_t, uint32_t>, 9> pairs;
    size_t count = 0;

    void add(uint32_t half_edge, uint32_t next) { pairs[count++] = {half_edge, next}; }
};

// Merges the border at the corner between edges `in` and `out` of a new face (section 2.1.1).
void merge_border(HalfEdgeMesh& mesh, uint32_t in, bool in_is_new, uint32_t out, bool out_is_new, Links& links) {
    const uint32_t vertex = mesh[out].origin;
    const uint32_t outer_in = mesh[out].twin; // the BORDER half-edges on the outside of the new edges
    const uint32_t outer_out = mesh[in].twin;
    if (in_is_new && out_is_new) {
        const uint32_t border = mesh.outgoing[vertex];
        if (border == no_index) {
            links.add(outer_in, outer_out);
        } else {
            links.add(mesh[border].prev, outer_out);
            links.add(outer_in, border);
        }
        mesh.outgoing[vertex] = outer_out;
    } else if (in_is_new) {
        links.add(mesh[out].prev, outer_out);
        mesh.outgoing[vertex] = outer_out;
    } else if (out_is_new) {
        mesh.outgoing[vertex] = mesh[in].next;
        links.add(outer_in, mesh[in].next);
    }
    links.add(in, out);
}

// Returns a BORDER half-edge that leaves the vertex of `start`, or `start` if there is none.
uint32_t border_around(const HalfEdgeMesh& mesh, uint32_t start) {
    uint32_t half_edge = start;
    do {
        if (mesh.is_border(half_edge)) return half_edge;
        half_edge = mesh[mesh[half_edge].twin].next;
    } while (half_edge != start);
    return start;
}

std::string describe(AddFace status, uint32_t index, const Triangle& t) {
    const std::string where = "triangle " + std::to_string(index) + " (vertices " + std::to_string(t.x) + ", "
                              + std::to_string(t.y) + ", " + std::to_string(t.z) + ") ";
    switch (status) {
    case AddFace::added:
        return {};
    case AddFace::repeated_vertex:
        return where + "names a vertex twice; remove it";
    case AddFace::taken_edge:
        return where
               + "has an edge that another triangle uses in the same direction; reverse one of the two, "
                 "or remove one if three triangles share the edge";
    case AddFace::taken_vertex:
        return where + "touches a vertex that other triangles already surround; give it a copy of the vertex";
    }
    return where;
}

bool links_are_valid(const HalfEdgeMesh& mesh, uint32_t index) {
    const size_t count = mesh.half_edges.size();
    const HalfEdge& h = mesh[index];
    if (h.origin >= mesh.positions.size() || h.twin >= count || h.next >= count || h.prev >= count) return false;
    const HalfEdge& twin = mesh[h.twin];
    const HalfEdge& next = mesh[h.next];
    if (h.twin == index || twin.twin != index || twin.origin == h.origin) return false;
    if (next.prev != index || mesh[h.prev].next != index) return false;
    if (next.origin != twin.origin || next.face != h.face) return false;
    if (h.face == no_index) return twin.face != no_index;
    return h.face < mesh.faces.size() && mesh[next.next].next == index && h.next != index;
}

} // namespace

uint32_t add_vertex(HalfEdgeMesh& mesh, const glm::dvec3& position) {
    mesh.positions.push_back(position);
    mesh.outgoing.push_back(no_index);
    return static_cast<uint32_t>(mesh.positions.size() - 1);
}

uint32_t find_half_edge(const HalfEdgeMesh& mesh, uint32_t from, uint32_t to) {
    const uint32_t first_out = mesh.outgoing[from];
    const uint32_t first_back = mesh.outgoing[to];
    if (first_out == no_index || first_back == no_index) return no_index;
    // Walks around both ends at once: the cost is that of the smaller fan. Fans of a hundred thousand triangles occur.
    uint32_t out = first_out;
    uint32_t back = first_back;
    do {
        if (mesh.target(out) == to) return out;
        if (mesh.target(back) == from) return mesh[back].twin;
        out = mesh[mesh[out].twin].next;
        back = mesh[mesh[back].twin].next;
    } while (out != first_out && back != first_back);
    return no_index;
}

AddFace add_face(HalfEdgeMesh& mesh, const Triangle& triangle, FaceSource source) {
    const Corner3 v{triangle.x, triangle.y, triangle.z};
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) return AddFace::repeated_vertex;

    // Find the existing edges and check that their sides are free.
    Corner3 edge{};
    std::array<bool, 3> is_new{};
    for (int i = 0; i < 3; ++i) {
        edge[i] = find_half_edge(mesh, v[i], v[following(i)]);
        is_new[i] = edge[i] == no_index;
        if (!is_new[i] && !mesh.is_border(edge[i])) return AddFace::taken_edge;
    }
    for (const uint32_t vertex : v)
        if (mesh.outgoing[vertex] != no_index && !mesh.is_border(mesh.outgoing[vertex])) return AddFace::taken_vertex;

    // Make existing edges that meet in a corner neighbours in their chain.
    for (int i = 0; i < 3; ++i) {
        const uint32_t in = edge[i];
        const uint32_t out = edge[following(i)];
        if (is_new[i] || is_new[following(i)] || mesh[in].next == out) continue;
        if (!bring_together(mesh, in, out)) return AddFace::taken_vertex;
    }

    // Nothing fails from here on.
    for (int i = 0; i < 3; ++i)
        if (is_new[i]) edge[i] = add_edge(mesh, v[i], v[following(i)]);
    Links links;
    std::array<bool, 3> look_for_border{};
    for (int i = 0; i < 3; ++i) {
        const uint32_t in = edge[i];
        const uint32_t out = edge[following(i)];
        look_for_border[i] = !is_new[i] && !is_new[following(i)] && mesh.outgoing[mesh[out].origin] == out;
        merge_border(mesh, in, is_new[i], out, is_new[following(i)], links);
    }
    for (size_t i = 0; i < links.count; ++i) link(mesh, links.pairs[i].first, links.pairs[i].second);
    const auto face = static_cast<uint32_t>(mesh.faces.size());
    mesh.faces.push_back(edge[0]);
    mesh.sources.push_back(source);
    for (const uint32_t half_edge : edge) mesh[half_edge].face = face;
    for (int i = 0; i < 3; ++i) {
        const uint32_t out = edge[following(i)];
        if (look_for_border[i]) mesh.outgoing[mesh[out].origin] = border_around(mesh, out);
    }
    return AddFace::added;
}

Result<HalfEdgeMesh> build_half_edges(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles) {
    HalfEdgeMesh mesh;
    mesh.positions.assign(positions.begin(), positions.end());
    mesh.outgoing.assign(positions.size(), no_index);
    mesh.half_edges.reserve(3 * triangles.size());
    mesh.faces.reserve(triangles.size());
    mesh.sources.reserve(triangles.size());
    for (uint32_t i = 0; i < triangles.size(); ++i) {
        const Triangle& t = triangles[i];
        if (const uint32_t highest = std::max({t.x, t.y, t.z}); highest >= positions.size())
            return Error{Status::invalid_mesh, "triangle " + std::to_string(i) + " names vertex "
                                                   + std::to_string(highest) + ", but there are only "
                                                   + std::to_string(positions.size())};
        const AddFace status = add_face(mesh, t, {.index = i});
        if (status != AddFace::added) return Error{Status::invalid_mesh, describe(status, i, t)};
    }
    return mesh;
}

TriangleMesh split_fans(const TriangleMesh& mesh) {
    // Union-find over corners, three per triangle: a paired edge unites the corners at each of its ends in one fan.
    const size_t corner_count = 3 * mesh.triangles.size();
    std::vector<uint32_t> parent(corner_count);
    std::iota(parent.begin(), parent.end(), 0u);

    struct Use { // the use of an undirected edge by the triangle of `corner`, where the edge begins
        uint32_t low, high, corner;
        bool forward;
    };
    std::vector<Use> uses;
    uses.reserve(corner_count);
    auto vertex_at = [&](uint32_t corner) { return mesh.triangles[corner / 3][static_cast<int>(corner % 3)]; };
    auto corner_after = [](uint32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; };
    for (uint32_t corner = 0; corner < corner_count; ++corner) {
        const uint32_t from = vertex_at(corner);
        const uint32_t to = vertex_at(corner_after(corner));
        uses.push_back({std::min(from, to), std::max(from, to), corner, from < to});
    }
    std::sort(uses.begin(), uses.end(), [](const Use& a, const Use& b) {
        return std::tie(a.low, a.high, a.corner) < std::tie(b.low, b.high, b.corner);
    });
    for (size_t i = 0; i + 1 < uses.size(); ++i) {
        const Use& a = uses[i];
        const Use& b = uses[i + 1];
        if (a.low != b.low || a.high != b.high || a.forward == b.forward) continue;
        unite(parent, a.corner, corner_after(b.corner));
        unite(parent, corner_after(a.corner), b.corner);
    }

    TriangleMesh split = mesh;
    std::vector<uint32_t> copy(corner_count, no_index); // per root of the forest
    std::vector<bool> taken(mesh.positions.size(), false);
    for (uint32_t corner = 0; corner < corner_count; ++corner) {
        const uint32_t fan = root_of(parent, corner);
        const uint32_t vertex = vertex_at(corner);
        if (copy[fan] == no_index) {
            copy[fan] = taken[vertex] ? static_cast<uint32_t>(split.positions.size()) : vertex;
            if (taken[vertex]) split.positions.push_back(mesh.positions[vertex]);
            taken[vertex] = true;
        }
        split.triangles[corner / 3][static_cast<int>(corner % 3)] = copy[fan];
    }
    return split;
}

Triangle corners(const HalfEdgeMesh& mesh, uint32_t face) {
    const uint32_t first = mesh.faces[face];
    const uint32_t second = mesh[first].next;
    return {mesh[first].origin, mesh[second].origin, mesh[mesh[second].next].origin};
}

std::vector<Triangle> triangle_list(const HalfEdgeMesh& mesh) {
    std::vector<Triangle> triangles(mesh.faces.size());
    for (uint32_t face = 0; face < mesh.faces.size(); ++face) triangles[face] = corners(mesh, face);
    return triangles;
}

std::vector<std::vector<uint32_t>> border_loops(const HalfEdgeMesh& mesh) {
    std::vector<std::vector<uint32_t>> loops;
    std::vector<bool> seen(mesh.half_edges.size(), false);
    for (uint32_t first = 0; first < mesh.half_edges.size(); ++first) {
        if (seen[first] || !mesh.is_border(first)) continue;
        std::vector<uint32_t>& loop = loops.emplace_back();
        for (uint32_t h = first; !seen[h]; h = mesh[h].next) {
            seen[h] = true;
            loop.push_back(h);
        }
    }
    return loops;
}

bool is_closed(const HalfEdgeMesh& mesh) {
    return std::none_of(mesh.half_edges.begin(), mesh.half_edges.end(),
                        [](const HalfEdge& h) { return h.face == no_index; });
}

bool is_valid(const HalfEdgeMesh& mesh) {
    if (mesh.outgoing.size() != mesh.positions.size() || mesh.sources.size() != mesh.faces.size()) return false;
    for (uint32_t h = 0; h < mesh.half_edges.size(); ++h)
        if (!links_are_valid(mesh, h)) return false;
    size_t half_edges_with_face = 0;
    std::vector<uint32_t> leaving(mesh.positions.size(), 0);
    std::vector<bool> has_border(mesh.positions.size(), false);
    for (uint32_t h = 0; h < mesh.half_edges.size(); ++h) {
        ++leaving[mesh[h].origin];
        if (mesh.is_border(h))
            has_border[mesh[h].origin] = true;
        else
            ++half_edges_with_face;
    }
    if (half_edges_with_face != 3 * mesh.faces.size()) return false;
    for (uint32_t face = 0; face < mesh.faces.size(); ++face)
        if (mesh.faces[face] >= mesh.half_edges.size() || mesh[mesh.faces[face]].face != face) return false;
    for (uint32_t vertex = 0; vertex < mesh.positions.size(); ++vertex) {
        const uint32_t first = mesh.outgoing[vertex];
        if (first == no_index) {
            if (leaving[vertex] != 0) return false;
            continue;
        }
        if (first >= mesh.half_edges.size() || mesh[first].origin != vertex) return false;
        if (has_border[vertex] && !mesh.is_border(first)) return false;
        uint32_t met = 0;
        uint32_t h = first;
        do {
            ++met;
            h = mesh[mesh[h].twin].next;
        } while (h != first && met <= leaving[vertex]);
        if (met != leaving[vertex]) return false;
    }
    return true;
}

} // namespace brittle::fracture

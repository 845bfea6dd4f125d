#include "fracture/sequential/clip.h"

#include <algorithm>
#include <cassert>
#include <tuple>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

#include "fracture/triangulation/triangulate.h"

namespace brittle::fracture {

namespace {

// Clips the faces of one mesh to one side of a plane, before the caps. Every half-edge of the input leaves at most one
// part in the output, and the parts of twins are twins again, so neighbours are linked without a search.
class FaceCutter {
  public:
    FaceCutter(const HalfEdgeMesh& in, const Bisector& plane, uint32_t site)
        : in_(in), plane_(plane), kept_(in.positions.size()), vertex_(in.positions.size(), no_index),
          cut_vertex_(in.half_edges.size(), no_index), part_(in.half_edges.size(), no_index) {
        for (size_t i = 0; i < kept_.size(); ++i) kept_[i] = plane.keeps(site, plane.value(in.positions[i]));
    }

    // The kept part of every face, with BORDER half-edges along the plane, linked into chains.
    HalfEdgeMesh run() {
        for (uint32_t face = 0; face < in_.faces.size(); ++face) cut_face(face);
        for (uint32_t h = 0; h < part_.size(); ++h)
            if (part_[h] != no_index) out_[part_[h]].twin = part_[in_[h].twin];
        add_border();
        for (uint32_t h = 0; h < out_.half_edges.size(); ++h) // border half-edges come last and win
            out_.outgoing[out_[h].origin] = h;
        return std::move(out_);
    }

  private:
    void cut_face(uint32_t face) {
        const uint32_t a = in_.faces[face]; // the half-edge that leaves corner a
        const uint32_t b = in_[a].next;
        const uint32_t c = in_[b].next;
        const auto kept = [&](uint32_t half_edge) { return kept_[in_[half_edge].origin]; };
        switch (cut_case(kept(a), kept(b), kept(c))) {
        case CutCase::none:
            break;
        case CutCase::a:
            keep_corner(a);
            break;
        case CutCase::b:
            keep_corner(b);
            break;
        case CutCase::ab:
            keep_two_corners(a);
            break;
        case CutCase::c:
            keep_corner(c);
            break;
        case CutCase::ca:
            keep_two_corners(c);
            break;
        case CutCase::bc:
            keep_two_corners(b);
            break;
        case CutCase::abc:
            keep_face(a, b, c);
            break;
        }
    }

    void keep_face(uint32_t a, uint32_t b, uint32_t c) {
        const uint32_t first = add_triangle({vertex_of(a), vertex_of(b), vertex_of(c)}, source_of(a));
        part_[a] = first;
        part_[b] = first + 1;
        part_[c] = first + 2;
    }

    // Keeps only the origin u of the half-edge: the triangle u, x, y with x and y on the plane.
    void keep_corner(uint32_t out) {
        const uint32_t back = in_[out].prev;
        const uint32_t first = add_triangle({vertex_of(out), cut_vertex(out), cut_vertex(back)}, source_of(out));
        part_[out] = first;
        part_[back] = first + 2;
        on_plane_.push_back(first + 1);
    }

    // Keeps both ends u, v of the half-edge: the quad u, v, x, y with x and y on the plane, as two triangles.
    void keep_two_corners(uint32_t side) {
        const uint32_t right = in_[side].next;
        const uint32_t left = in_[side].prev;
        const uint32_t u = vertex_of(side);
        const uint32_t v = vertex_of(right);
        const uint32_t x = cut_vertex(right);
        const uint32_t y = cut_vertex(left);
        const auto& p = out_.positions;
        const FaceSource source = source_of(side);
        if (cut_along_first_diagonal(p[u], p[v], p[x], p[y])) {
            const uint32_t first = add_triangle({u, v, x}, source);
            const uint32_t second = add_triangle({u, x, y}, source);
            pair(first + 2, second);
            part_[side] = first;
            part_[right] = first + 1;
            part_[left] = second + 2;
            on_plane_.push_back(second + 1);
        } else {
            const uint32_t first = add_triangle({u, v, y}, source);
            const uint32_t second = add_triangle({v, x, y}, source);
            pair(first + 1, second + 2);
            part_[side] = first;
            part_[right] = second;
            part_[left] = first + 2;
            on_plane_.push_back(second + 1);
        }
    }

    // The walk of section 2.3. Adds a BORDER half-edge beside each half-edge on the plane. Its next half-edge is found
    // by turning around their common vertex, prev and pair in turn, until the pair has no face.
    void add_border() {
        const auto first_border = static_cast<uint32_t>(out_.half_edges.size());
        for (const uint32_t inner : on_plane_) {
            const uint32_t origin = out_[out_[inner].next].origin;
            out_.half_edges.push_back({.origin = origin});
            pair(inner, static_cast<uint32_t>(out_.half_edges.size() - 1));
        }
        for (uint32_t border = first_border; border < out_.half_edges.size(); ++border) {
            uint32_t next = out_[border].twin;
            do {
                next = out_[out_[next].prev].twin;
            } while (!out_.is_border(next));
            out_[border].next = next;
            out_[next].prev = border;
        }
    }

    uint32_t vertex_of(uint32_t half_edge) {
        const uint32_t origin = in_[half_edge].origin;
        if (vertex_[origin] == no_index) vertex_[origin] = add_vertex(out_, in_.positions[origin]);
        return vertex_[origin];
    }

    // The new vertex of a crossing edge, shared by both of its triangles.
    uint32_t cut_vertex(uint32_t half_edge) {
        const uint32_t twin = in_[half_edge].twin;
        if (cut_vertex_[half_edge] == no_index) {
            const glm::dvec3& p = in_.positions[in_[half_edge].origin];
            const glm::dvec3& q = in_.positions[in_[twin].origin];
            cut_vertex_[half_edge] = cut_vertex_[twin] = add_vertex(out_, intersection(p, q, plane_));
        }
        return cut_vertex_[half_edge];
    }

    FaceSource source_of(uint32_t half_edge) const { return in_.sources[in_[half_edge].face]; }

    // Adds the half-edges first, first + 1 and first + 2 of the three corners. Their twins are set later.
    uint32_t add_triangle(const Triangle& t, FaceSource source) {
        const auto first = static_cast<uint32_t>(out_.half_edges.size());
        const auto face = static_cast<uint32_t>(out_.faces.size());
        out_.half_edges.push_back({.origin = t.x, .next = first + 1, .prev = first + 2, .face = face});
        out_.half_edges.push_back({.origin = t.y, .next = first + 2, .prev = first, .face = face});
        out_.half_edges.push_back({.origin = t.z, .next = first, .prev = first + 1, .face = face});
        out_.faces.push_back(first);
        out_.sources.push_back(source);
        return first;
    }

    void pair(uint32_t a, uint32_t b) {
        out_[a].twin = b;
        out_[b].twin = a;
    }

    const HalfEdgeMesh& in_;
    const Bisector& plane_;
    HalfEdgeMesh out_;
    std::vector<uint8_t> kept_;        // per input vertex
    std::vector<uint32_t> vertex_;     // input vertex -> output vertex
    std::vector<uint32_t> cut_vertex_; // crossing input half-edge -> output vertex
    std::vector<uint32_t> part_;       // input half-edge -> output half-edge, its kept part
    std::vector<uint32_t> on_plane_;   // output half-edges along the plane
};

using DirectedEdge = std::pair<uint32_t, uint32_t>;

// Whether the triangles close the hole: their directed edges are each loop edge once and every other edge once in each
// direction, and they form one fan around each point.
bool closes(std::span<const Loop> loops, std::span<const Triangle> triangles, size_t point_count) {
    std::vector<DirectedEdge> have;
    for (const Triangle& t : triangles)
        for (int i = 0; i < 3; ++i) have.emplace_back(t[i], t[(i + 1) % 3]);
    std::vector<DirectedEdge> want; // the reverse of each triangle edge, and the loop edges
    for (const DirectedEdge& edge : have) want.emplace_back(edge.second, edge.first);
    for (const Loop& loop : loops) {
        for (size_t i = 0; i < loop.size(); ++i) {
            const uint32_t from = loop[i];
            const uint32_t to = loop[(i + 1) % loop.size()];
            want.emplace_back(from, to);
            have.emplace_back(to, from);
        }
    }
    std::sort(have.begin(), have.end());
    std::sort(want.begin(), want.end());
    if (have != want || std::adjacent_find(have.begin(), have.end()) != have.end()) return false;
    const TriangleMesh cap{std::vector<glm::dvec3>(point_count), {triangles.begin(), triangles.end()}};
    return split_fans(cap).positions.size() == point_count;
}

// A cap that closes any loops, whatever their geometry: a fan around the middle of each loop. Holes get fans of
// negative area, so the volume is right even where the fans overlap. This is the fallback for a failed triangulation.
std::vector<Triangle> fans(HalfEdgeMesh& mesh, std::span<const Loop> loops) {
    std::vector<Triangle> triangles;
    for (const Loop& loop : loops) {
        glm::dvec3 middle(0.0);
        for (const uint32_t vertex : loop) middle += mesh.positions[vertex] / static_cast<double>(loop.size());
        const uint32_t hub = add_vertex(mesh, middle);
        for (size_t i = 0; i < loop.size(); ++i) triangles.emplace_back(loop[i], loop[(i + 1) % loop.size()], hub);
    }
    return triangles;
}

// Section 2.4. The BORDER half-edges of a hole run in the direction of the half-edges of the cap.
void add_caps(HalfEdgeMesh& mesh, const glm::dvec3& outward, FaceSource source) {
    std::vector<Loop> loops;      // in vertices of the mesh
    std::vector<Loop> flat_loops; // in flat points
    std::vector<glm::dvec2> flat;
    std::vector<uint32_t> vertex_of; // flat point -> vertex
    for (const std::vector<uint32_t>& border : border_loops(mesh)) {
        Loop& loop = loops.emplace_back();
        Loop& flat_loop = flat_loops.emplace_back();
        for (const uint32_t half_edge : border) {
            const uint32_t vertex = mesh[half_edge].origin;
            loop.push_back(vertex);
            flat_loop.push_back(static_cast<uint32_t>(flat.size()));
            vertex_of.push_back(vertex);
            // Relative to one of the points, so that no digits are lost far from the origin.
            flat.push_back(project(mesh.positions[vertex] - mesh.positions[vertex_of.front()], outward));
        }
    }
    if (loops.empty()) return;

    std::vector<Triangle> triangles = triangulate(flat, flat_loops).triangles;
    if (closes(flat_loops, triangles, flat.size())) {
        for (Triangle& t : triangles) t = {vertex_of[t.x], vertex_of[t.y], vertex_of[t.z]};
    } else {
        triangles = fans(mesh, loops);
    }
    for (const Triangle& t : triangles) {
        [[maybe_unused]] const AddFace status = add_face(mesh, t, source);
        assert(status == AddFace::added);
    }
    assert(is_closed(mesh));
}

bool lexicographically_less(const glm::dvec3& a, const glm::dvec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

} // namespace

glm::dvec3 intersection(const glm::dvec3& p, const glm::dvec3& q, const Bisector& plane) {
    if (lexicographically_less(q, p)) return intersection(q, p, plane);
    const double g_p = plane.value(p);
    const double g_q = plane.value(q);
    const double lambda = std::clamp(g_p / (g_p - g_q), 0.0, 1.0);
    return p * (1.0 - lambda) + q * lambda; // exact at both ends
}

bool cut_along_first_diagonal(const glm::dvec3& p, const glm::dvec3& q, const glm::dvec3& r, const glm::dvec3& s) {
    // With alpha the angle at q and beta the angle at s, pr is the Delaunay diagonal if alpha + beta <= pi, which is
    // sin(alpha + beta) >= 0. Sines and cosines are multiplied by the lengths of the sides, which are positive.
    const double sin_q = glm::length(glm::cross(p - q, r - q));
    const double cos_q = glm::dot(p - q, r - q);
    const double sin_s = glm::length(glm::cross(r - s, p - s));
    const double cos_s = glm::dot(r - s, p - s);
    return sin_q * cos_s + cos_q * sin_s >= 0.0;
}

HalfEdgeMesh clip(const HalfEdgeMesh& mesh, const Bisector& plane, uint32_t site) {
    assert(site == plane.low || site == plane.high);
    HalfEdgeMesh kept = FaceCutter(mesh, plane, site).run();
    const glm::dvec3 outward = site == plane.low ? plane.normal : -plane.normal;
    add_caps(kept, outward, {.index = plane.other(site), .interior = true});
    return kept;
}

} // namespace brittle::fracture

#include "fracture/pieces/sewing.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

#include "fracture/base/union_find.h"
#include "fracture/mesh/nearest.h"
#include "fracture/pieces/merge.h"

namespace brittle::fracture {

namespace {

constexpr uint32_t first_cut_point = 1u << 30; // see Fragments::vertex_point

// Returns the input triangle of a sheet that is nearest to a triangle of its neighbour; no_index if the sheet has no
// exterior triangle.
uint32_t nearest_source(const Fragments& fragments, const Piece& of, uint32_t t, const Piece& sheet) {
    const Triangle& c = fragments.triangles[t];
    const auto own = fragments.positions_of(of);
    const glm::dvec3 centre = (own[c.x] + own[c.y] + own[c.z]) / 3.0;
    const auto positions = fragments.positions_of(sheet);
    uint32_t nearest = no_index;
    double least = std::numeric_limits<double>::infinity();
    for (uint32_t s = sheet.triangles.begin; s < sheet.triangles.begin + sheet.exterior_triangles; ++s) {
        const Triangle& e = fragments.triangles[s];
        const glm::dvec3 off = centre - nearest_on_triangle(centre, positions[e.x], positions[e.y], positions[e.z]);
        const double square = glm::dot(off, off);
        if (square >= least) continue;
        least = square;
        nearest = fragments.triangle_source[s];
    }
    return nearest;
}

// Sews one set of pieces. Half-edge 3t + k runs from corner k of triangle t to the next corner.
class Sewing {
  public:
    Sewing(const SewingPlan& plan, std::span<const uint32_t> pieces)
        : fragments_(plan.fragments), representative_(plan.representative), caps_(plan.caps),
          parts_of_source_(plan.parts_of_source) {
        for (const uint32_t piece : pieces) {
            first_triangle_.push_back(static_cast<uint32_t>(triangles_.size()));
            add(piece);
        }
        remove_caps(pieces);
        sew();
        find_vertices();
    }

    Piece write(uint32_t next_point, Fragments& out) {
        find_whole_sources();
        if (!is_simple()) {
            for (Patch& patch : patches_) patch.whole = false;
            halve_repeated_edges(next_point);
        }
        Piece piece;
        piece.vertices.begin = static_cast<uint32_t>(out.positions.size());
        piece.triangles.begin = static_cast<uint32_t>(out.triangles.size());
        local_.assign(triangles_.size() * 6, no_index);
        const auto emit = [&](const std::array<Corner, 3>& corners, uint32_t source) {
            glm::uvec3 t;
            for (int k = 0; k < 3; ++k) t[k] = vertex(corners[static_cast<size_t>(k)].h, piece, out);
            out.triangles.push_back(t);
            out.triangle_source.push_back(source);
        };
        for_each_triangle(true, emit);
        piece.exterior_triangles = static_cast<uint32_t>(out.triangles.size()) - piece.triangles.begin;
        for_each_triangle(false, emit);
        piece.vertices.end = static_cast<uint32_t>(out.positions.size());
        piece.triangles.end = static_cast<uint32_t>(out.triangles.size());
        return piece;
    }

  private:
    struct Part {
        std::array<uint32_t, 3> vertex; // indices of Fragments::positions
        uint32_t triangle;              // index of Fragments::triangles
        uint32_t source;
        bool exterior;
        bool removed = false;
        bool was_cap = false; // exterior now, because the sheet that covered it was dropped
    };
    // A corner of a polygon to triangulate: the half-edge that leaves it, or twin_.size() + h for the midpoint of
    // half-edge h. A point that is no corner of the triangle lies on one of its sides.
    struct Corner {
        uint32_t h;
        bool is_corner;
    };
    // The parts of one input triangle.
    struct Patch {
        uint32_t source;
        uint32_t parts_begin, parts_end; // range of parts_
        uint32_t rim_begin, rim_end;     // range of rims_: the half-edges around it, in the end those that remain
        bool whole = false;
    };

    [[nodiscard]] static uint32_t after(uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
    [[nodiscard]] uint32_t from(uint32_t h) const { return triangles_[h / 3].vertex[h % 3]; }
    [[nodiscard]] uint32_t point(uint32_t h) const { return fragments_.vertex_point[from(h)]; }

    void add(uint32_t index) {
        const Piece& piece = fragments_.pieces[index];
        const auto first = static_cast<uint32_t>(triangles_.size());
        for (uint32_t t = piece.triangles.begin; t < piece.triangles.end; ++t) {
            const glm::uvec3 v = fragments_.triangles[t] + glm::uvec3(piece.vertices.begin);
            Part part{{v.x, v.y, v.z},
                      t,
                      fragments_.triangle_source[t],
                      t < piece.triangles.begin + piece.exterior_triangles};
            if (const uint32_t across = caps_.across(t); across != no_index) find_source(piece, across, part);
            triangles_.push_back(part);
        }
        // The twin of a half-edge is one of the half-edges that leave its target vertex.
        const uint32_t vertices = piece.vertices.size(), begin = 3 * first;
        leaving_begin_.assign(vertices + 2, 0);
        const auto local = [&](uint32_t h) { return from(h) - piece.vertices.begin; };
        const auto end = static_cast<uint32_t>(3 * triangles_.size());
        for (uint32_t h = begin; h < end; ++h) ++leaving_begin_[local(h) + 2];
        for (uint32_t v = 2; v < vertices + 2; ++v) leaving_begin_[v] += leaving_begin_[v - 1];
        leaving_.resize(end - begin);
        for (uint32_t h = begin; h < end; ++h) leaving_[leaving_begin_[local(h) + 1]++] = h;
        twin_.resize(end, no_index);
        for (uint32_t h = begin; h < end; ++h) {
            if (twin_[h] != no_index) continue;
            const uint32_t to = local(after(h));
            for (uint32_t k = leaving_begin_[to]; k < leaving_begin_[to + 1]; ++k) {
                const uint32_t g = leaving_[k];
                if (from(after(g)) != from(h) || twin_[g] != no_index) continue;
                twin_[h] = g;
                twin_[g] = h;
                break;
            }
        }
    }

    // Finds the source of a cap triangle after the merge: another piece, or the surface of the input.
    void find_source(const Piece& piece, uint32_t across, Part& part) const {
        const uint32_t beyond = caps_.piece_of(across);
        if (representative_[beyond] != dropped) {
            part.source = fragments_.pieces[representative_[beyond]].site;
            return;
        }
        const uint32_t source = nearest_source(fragments_, piece, part.triangle, fragments_.pieces[beyond]);
        if (source == no_index) return;
        part.source = source;
        part.exterior = part.was_cap = true;
    }

    void remove_caps(std::span<const uint32_t> pieces) {
        partner_.assign(triangles_.size(), no_index);
        for (uint32_t t = 0; t < triangles_.size(); ++t) {
            const uint32_t across = caps_.across(triangles_[t].triangle);
            if (across == no_index) continue;
            const auto beyond = std::lower_bound(pieces.begin(), pieces.end(), caps_.piece_of(across));
            if (beyond == pieces.end() || *beyond != caps_.piece_of(across)) continue;
            const uint32_t first = first_triangle_[static_cast<size_t>(beyond - pieces.begin())];
            partner_[t] = first + across - fragments_.pieces[*beyond].triangles.begin;
            triangles_[t].removed = true;
        }
    }

    // Returns the opposite half-edge on the other side of a removed cap.
    [[nodiscard]] uint32_t through(uint32_t h) const {
        const uint32_t other = partner_[h / 3];
        for (uint32_t g = 3 * other; g < 3 * other + 3; ++g)
            if (point(g) == point(after(h))) return g;
        return no_index; // unreachable: both sides have equal points
    }

    void sew() {
        sewn_.assign(twin_.size(), no_index);
        for (uint32_t h = 0; h < twin_.size(); ++h) {
            if (triangles_[h / 3].removed) continue;
            uint32_t g = twin_[h];
            while (triangles_[g / 3].removed) g = twin_[through(g)];
            sewn_[h] = g;
        }
    }

    // Two half-edges leave one vertex if a walk around the vertex leads from one to the other.
    void find_vertices() {
        vertex_of_.resize(twin_.size());
        std::iota(vertex_of_.begin(), vertex_of_.end(), 0u);
        for (uint32_t h = 0; h < twin_.size(); ++h) {
            if (sewn_[h] == no_index) continue;
            const uint32_t a = root_of(vertex_of_, h), b = root_of(vertex_of_, after(sewn_[h]));
            vertex_of_[std::max(a, b)] = std::min(a, b);
        }
    }

    uint32_t vertex(uint32_t h, const Piece& piece, Fragments& out) {
        const auto half_edges = static_cast<uint32_t>(twin_.size());
        const bool middle = h >= half_edges;
        const uint32_t edge = middle ? std::min(h - half_edges, sewn_[h - half_edges]) : h;
        uint32_t& local = local_[middle ? half_edges + edge : root_of(vertex_of_, h)];
        if (local == no_index) {
            local = static_cast<uint32_t>(out.positions.size()) - piece.vertices.begin;
            const glm::dvec3& here = fragments_.positions[from(edge)];
            out.positions.push_back(middle ? 0.5 * (here + fragments_.positions[from(after(edge))]) : here);
            out.vertex_point.push_back(middle ? middle_[edge] : point(h));
        }
        return local;
    }

    template<class Emit>
    void for_each_triangle(bool exterior, const Emit& emit) {
        for (uint32_t t = 0; t < triangles_.size(); ++t) {
            const Part& part = triangles_[t];
            if (part.removed || part.exterior != exterior || patch_of(t) != no_index) continue;
            polygon_.clear();
            for (uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
                polygon_.push_back({h, true});
                if (!middle_.empty() && middle_[std::min(h, sewn_[h])] != no_index)
                    polygon_.push_back({static_cast<uint32_t>(twin_.size()) + h, false});
            }
            triangulate(part.source, emit);
        }
        if (!exterior) return;
        for (const Patch& patch : patches_) {
            if (!patch.whole) continue;
            polygon_.clear();
            for (uint32_t k = patch.rim_begin; k < patch.rim_end; ++k)
                polygon_.push_back({rims_[k], point(rims_[k]) < first_cut_point});
            triangulate(patch.source, emit);
        }
    }

    // Returns whether no two edges have equal ends. Sewing solids that touch in their cuts may create such a pair.
    bool is_simple() {
        leaving_begin_.assign(twin_.size() + 1, 0);
        const auto each_edge = [&](const auto& visit) {
            const auto edges = [&](const std::array<Corner, 3>& corners, uint32_t) {
                std::array<uint32_t, 3> v{};
                for (size_t k = 0; k < 3; ++k) v[k] = root_of(vertex_of_, corners[k].h);
                for (size_t k = 0; k < 3; ++k) visit(v[k], v[(k + 1) % 3]);
            };
            for_each_triangle(true, edges);
            for_each_triangle(false, edges);
        };
        each_edge([&](uint32_t a, uint32_t) { ++leaving_begin_[a + 1]; });
        for (size_t v = 1; v < leaving_begin_.size(); ++v) leaving_begin_[v] += leaving_begin_[v - 1];
        leaving_.resize(leaving_begin_.back());
        std::vector<uint32_t> leaving_end(leaving_begin_.begin(), leaving_begin_.end());
        bool simple = true;
        each_edge([&](uint32_t a, uint32_t b) {
            const auto begin = leaving_.begin() + leaving_begin_[a], end = leaving_.begin() + leaving_end[a]++;
            simple = simple && std::find(begin, end, b) == end;
            *end = b;
        });
        return simple;
    }

    // Gives all but one of the edges with equal ends a midpoint. Edges of caps come last, because the neighbours share
    // them.
    void halve_repeated_edges(uint32_t next_point) {
        struct Edge {
            uint32_t from, to;
            bool exterior;
            uint32_t h;
        };
        std::vector<Edge> edges;
        for (uint32_t h = 0; h < twin_.size(); ++h) {
            if (sewn_[h] == no_index) continue;
            const uint32_t a = root_of(vertex_of_, h), b = root_of(vertex_of_, after(h));
            if (a < b) edges.push_back({a, b, triangles_[h / 3].exterior && triangles_[sewn_[h] / 3].exterior, h});
        }
        std::sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
            return std::tie(x.from, x.to, x.exterior, x.h) < std::tie(y.from, y.to, y.exterior, y.h);
        });
        middle_.assign(twin_.size(), no_index);
        for (size_t k = 1; k < edges.size(); ++k) {
            if (edges[k].from != edges[k - 1].from || edges[k].to != edges[k - 1].to) continue;
            middle_[std::min(edges[k].h, sewn_[edges[k].h])] = next_point++;
        }
    }

    // Returns the patch that replaces this triangle by a whole input triangle; no_index if the triangle remains a part.
    [[nodiscard]] uint32_t patch_of(uint32_t t) const {
        return patch_of_[t] != no_index && patches_[patch_of_[t]].whole ? patch_of_[t] : no_index;
    }

    void find_whole_sources() {
        for (uint32_t t = 0; t < triangles_.size(); ++t) {
            const Part& part = triangles_[t];
            if (part.exterior && !part.was_cap && parts_of_source_[part.source] > 1) parts_.push_back(t);
        }
        std::sort(parts_.begin(), parts_.end(), [&](uint32_t x, uint32_t y) {
            return std::tie(triangles_[x].source, x) < std::tie(triangles_[y].source, y);
        });
        patch_of_.assign(triangles_.size(), no_index);
        const auto count = static_cast<uint32_t>(parts_.size());
        for (uint32_t begin = 0, end = 0; begin < count; begin = end) {
            const uint32_t source = triangles_[parts_[begin]].source;
            while (end < count && triangles_[parts_[end]].source == source) ++end;
            if (end - begin != parts_of_source_[source]) continue;
            for (uint32_t k = begin; k < end; ++k) patch_of_[parts_[k]] = static_cast<uint32_t>(patches_.size());
            patches_.push_back({source, begin, end, 0, 0});
        }
        for (Patch& patch : patches_) patch.whole = walk_rim(patch);
        for (Patch& patch : patches_) {
            if (patch.whole) drop_points(patch);
        }
    }

    [[nodiscard]] bool is_rim(uint32_t h) const { return patch_of_[sewn_[h] / 3] != patch_of_[h / 3]; }

    // Returns whether the parts form a disc with the three corners of the input triangle on its rim.
    bool walk_rim(Patch& patch) {
        uint32_t rims = 0, first = no_index;
        for (uint32_t k = patch.parts_begin; k < patch.parts_end; ++k) {
            for (uint32_t h = 3 * parts_[k]; h < 3 * parts_[k] + 3; ++h) {
                if (!is_rim(h)) continue;
                ++rims;
                if (first == no_index) first = h;
            }
        }
        patch.rim_begin = patch.rim_end = static_cast<uint32_t>(rims_.size());
        if (first == no_index) return false;
        uint32_t corners = 0;
        uint32_t h = first;
        do {
            rims_.push_back(h);
            corners += point(h) < first_cut_point ? 1 : 0;
            h = after(h);
            while (!is_rim(h)) h = after(sewn_[h]);
        } while (h != first && rims_.size() - patch.rim_begin <= rims);
        patch.rim_end = static_cast<uint32_t>(rims_.size());
        return patch.rim_end - patch.rim_begin == rims && corners == 3;
    }

    // Drops the points on a side towards another input triangle that is whole again: neither needs them.
    void drop_points(Patch& patch) {
        const auto whole_beyond = [&](uint32_t h) { return patch_of(sewn_[h] / 3); };
        const std::span rim(rims_.data() + patch.rim_begin, patch.rim_end - patch.rim_begin);
        uint32_t kept = 0, before = whole_beyond(rim.back());
        for (const uint32_t h : rim) {
            const uint32_t beyond = whole_beyond(h);
            const bool needed = point(h) < first_cut_point || beyond == no_index || beyond != before;
            before = beyond;
            if (needed) rim[kept++] = h;
        }
        patch.rim_end = patch.rim_begin + kept;
    }

    // Triangulates polygon_, a triangle with points on its sides. Ears at corners beside these points are cut first, so
    // that no triangle is flat.
    template<class Emit>
    void triangulate(uint32_t source, const Emit& emit) {
        while (polygon_.size() > 3) {
            const size_t n = polygon_.size();
            size_t ear = 0; // any corner, if all points are corners
            for (size_t k = 0; k < n; ++k) {
                if (!polygon_[k].is_corner || (polygon_[(k + 1) % n].is_corner && polygon_[(k + n - 1) % n].is_corner))
                    continue;
                ear = k;
                break;
            }
            const size_t previous = (ear + n - 1) % n, next = (ear + 1) % n;
            emit({polygon_[previous], polygon_[ear], polygon_[next]}, source);
            polygon_[previous].is_corner = polygon_[next].is_corner = true;
            polygon_.erase(polygon_.begin() + static_cast<std::ptrdiff_t>(ear));
        }
        emit({polygon_[0], polygon_[1], polygon_[2]}, source);
    }

    const Fragments& fragments_;
    std::span<const uint32_t> representative_;
    const CapPairs& caps_;
    std::span<const uint32_t> parts_of_source_;
    std::vector<Part> triangles_;
    std::vector<uint32_t> first_triangle_; // per piece
    std::vector<uint32_t> twin_;           // per half-edge: its twin within its own piece
    std::vector<uint32_t> partner_;        // per removed triangle: its other side
    std::vector<uint32_t> sewn_;           // per half-edge: its twin in the new piece
    std::vector<uint32_t> vertex_of_;      // union-find over half-edges that leave one vertex
    // Per root of vertex_of_, then per midpoint of a half-edge: the vertex of the new piece.
    std::vector<uint32_t> local_;
    std::vector<uint32_t> middle_; // per edge, at its lower half-edge: the number of its midpoint; may be empty
    std::vector<Corner> polygon_;
    std::vector<Patch> patches_;
    std::vector<uint32_t> patch_of_; // per triangle
    std::vector<uint32_t> parts_, rims_;
    std::vector<uint32_t> leaving_begin_, leaving_; // scratch: edges by their first vertex
};

} // namespace

Piece sew_pieces(const SewingPlan& plan, std::span<const uint32_t> pieces, uint32_t next_point, Fragments& out) {
    return Sewing(plan, pieces).write(next_point, out);
}

} // namespace brittle::fracture

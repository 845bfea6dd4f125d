#include "fracture/merge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <queue>
#include <tuple>
#include <utility>

#include <glm/geometric.hpp>

namespace brittle::fracture {

namespace {

constexpr uint32_t none = 0xffffffffu;
constexpr uint32_t first_cut_point = 1u << 30; // see Fragments::vertex_point

// Up to rounding.
constexpr double whole_side = 1.0 - 1e-6;

uint32_t root_of(std::vector<uint32_t>& parent, uint32_t v) {
    while (parent[v] != v) {
        parent[v] = parent[parent[v]];
        v = parent[v];
    }
    return v;
}

// The two sides of cap triangles.
class Caps {
  public:
    // Of caps between sites of which `wanted` says yes, to (lower, higher).
    template<class Wanted>
    Caps(const Fragments& fragments, const Wanted& wanted)
        : piece_of_(fragments.triangles.size()), across_(fragments.triangles.size(), none) {
        std::vector<Side> sides;
        for (uint32_t p = 0; p < fragments.pieces.size(); ++p) {
            const Piece& piece = fragments.pieces[p];
            for (uint32_t t = piece.triangles.begin; t < piece.triangles.end; ++t) {
                piece_of_[t] = p;
                if (t < piece.triangles.begin + piece.exterior_triangles) continue;
                const uint32_t other = fragments.triangle_source[t];
                if (wanted(std::min(piece.site, other), std::max(piece.site, other)))
                    sides.push_back(side(fragments, piece, t));
            }
        }
        pair(sides);
    }

    [[nodiscard]] uint32_t piece_of(uint32_t triangle) const { return piece_of_[triangle]; }
    // The other side of a cap triangle; none for what is no cap or has none.
    [[nodiscard]] uint32_t across(uint32_t triangle) const { return across_[triangle]; }

  private:
    struct Side {
        std::array<uint32_t, 5> key; // sites, points from the least on, as seen from the lower site
        bool upper;
        uint32_t triangle;
    };

    static Side side(const Fragments& fragments, const Piece& piece, uint32_t t) {
        const uint32_t other = fragments.triangle_source[t];
        std::array<uint32_t, 3> points{};
        for (int k = 0; k < 3; ++k)
            points[static_cast<size_t>(k)] =
                fragments.vertex_point[piece.vertices.begin + fragments.triangles[t][k]];
        const bool upper = piece.site > other;
        if (upper) std::swap(points[1], points[2]);
        std::rotate(points.begin(), std::min_element(points.begin(), points.end()), points.end());
        return {{std::min(piece.site, other), std::max(piece.site, other), points[0], points[1], points[2]}, upper, t};
    }

    void pair(std::vector<Side>& sides) {
        std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) {
            return std::tie(x.key, x.upper, x.triangle) < std::tie(y.key, y.upper, y.triangle);
        });
        for (size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
            size_t lower = 0;
            for (; end < sides.size() && sides[end].key == sides[begin].key; ++end) lower += sides[end].upper ? 0 : 1;
            for (size_t k = begin; k < begin + lower && k + lower < end; ++k) {
                across_[sides[k].triangle] = sides[k + lower].triangle;
                across_[sides[k + lower].triangle] = sides[k].triangle;
            }
        }
    }

    std::vector<uint32_t> piece_of_, across_;
};

// Sets of pieces, with volumes and contacts.
class PieceSets {
  public:
    explicit PieceSets(const Fragments& fragments)
        : parent_(fragments.pieces.size()), name_(parent_.size()), contacts_(parent_.size()) {
        std::iota(parent_.begin(), parent_.end(), 0u);
        std::iota(name_.begin(), name_.end(), 0u);
        volume_.reserve(parent_.size());
        for (const Piece& piece : fragments.pieces) {
            volume_.push_back(piece.mass.volume);
            area_.push_back(piece.mass.area);
        }
        for (const Bond& bond : fragments.bonds) {
            contacts_[bond.a][bond.b] += bond.area;
            contacts_[bond.b][bond.a] += bond.area;
        }
    }

    uint32_t root(uint32_t piece) { return root_of(parent_, piece); }
    // Of roots:
    [[nodiscard]] double volume(uint32_t root) const { return volume_[root]; }
    [[nodiscard]] uint32_t name(uint32_t root) const { return name_[root]; } // one of its pieces
    // The set with the largest contact; none without contacts.
    [[nodiscard]] uint32_t neighbour(uint32_t root) const {
        uint32_t best = none;
        double area = 0.0;
        for (const auto& [other, contact] : contacts_[root]) {
            if (contact > area || (contact == area && best != none && name_[other] < name_[best])) {
                area = contact;
                best = other;
            }
        }
        return best;
    }

    [[nodiscard]] const std::map<uint32_t, double>& contacts(uint32_t root) const { return contacts_[root]; }
    [[nodiscard]] double area(uint32_t root) const { return area_[root]; } // of the surface

    // Two roots; returns the new one, which is that of the set with more neighbours.
    uint32_t unite(uint32_t a, uint32_t b, uint32_t name) {
        const auto between = contacts_[a].find(b);
        const double contact = between == contacts_[a].end() ? 0.0 : between->second;
        contacts_[a].erase(b);
        contacts_[b].erase(a);
        const bool a_stays = contacts_[a].size() >= contacts_[b].size();
        const uint32_t stays = a_stays ? a : b, goes = a_stays ? b : a;
        parent_[goes] = stays;
        name_[stays] = name;
        volume_[stays] += volume_[goes];
        area_[stays] += area_[goes] - 2.0 * contact;
        for (const auto& [other, area] : contacts_[goes]) {
            contacts_[other].erase(goes);
            contacts_[other][stays] = contacts_[stays][other] += area;
        }
        contacts_[goes].clear();
        return stays;
    }

  private:
    std::vector<uint32_t> parent_, name_;
    std::vector<double> volume_, area_;
    std::vector<std::map<uint32_t, double>> contacts_; // of roots, by root
};

} // namespace

namespace {

double exterior_area(const Fragments& fragments, const Piece& piece) {
    const auto positions = fragments.positions_of(piece);
    double sum = 0.0;
    for (const Triangle& t : fragments.triangles_of(piece).first(piece.exterior_triangles))
        sum += 0.5 * glm::length(glm::cross(positions[t.y] - positions[t.x], positions[t.z] - positions[t.x]));
    return sum;
}

} // namespace

std::vector<uint32_t> choose_mergers(const Fragments& fragments, const MergeRules& rules) {
    const auto count = static_cast<uint32_t>(fragments.pieces.size());
    PieceSets sets(fragments);
    if (!rules.group_of_site.empty()) {
        const Caps caps(fragments, [&](uint32_t a, uint32_t b) {
            return rules.group_of_site[a] == rules.group_of_site[b];
        });
        for (uint32_t t = 0; t < fragments.triangles.size(); ++t) {
            if (caps.across(t) == none) continue;
            const uint32_t a = sets.root(caps.piece_of(t)), b = sets.root(caps.piece_of(caps.across(t)));
            if (a != b) sets.unite(a, b, std::min(sets.name(a), sets.name(b)));
        }
    }
    std::vector<uint8_t> flat(count, rules.flat.empty() ? 0 : 1); // of roots: all of it is
    for (uint32_t p = 0; p < rules.flat.size(); ++p)
        if (!rules.flat[p]) flat[sets.root(p)] = 0;

    // A sheet on the outside of several neighbours would stick out from the one that takes it.
    const auto sticks_out = [&](uint32_t root, uint32_t other) {
        double outside = 0.0;
        for (uint32_t p = 0; p < count; ++p)
            if (sets.root(p) == root) outside += exterior_area(fragments, fragments.pieces[p]);
        // Half of a sheet's surface is outside, less where the input folds it; nothing of a speck inside the solid.
        return outside >= 0.25 * sets.area(root)
               && sets.contacts(root).at(other) < 0.5 * whole_side * sets.area(root);
    };
    const auto find_mate = [&](uint32_t root) {
        if (rules.group_of_site.empty()) return none;
        const auto group = [&](uint32_t r) { return rules.group_of_site[fragments.pieces[sets.name(r)].site]; };
        for (const auto& [other, contact] : sets.contacts(root))
            if (group(other) == group(root)) return other;
        return none;
    };
    using Entry = std::tuple<double, uint32_t, uint32_t>; // volume, name, root
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> smallest;
    const auto enqueue = [&](uint32_t root) {
        const double volume = std::abs(sets.volume(root));
        if (flat[root] || volume < rules.min_volume) smallest.push({volume, sets.name(root), root});
    };
    for (uint32_t p = 0; p < count; ++p)
        if (sets.root(p) == p) enqueue(p);
    while (!smallest.empty()) {
        const auto [volume, name, root] = smallest.top();
        smallest.pop();
        if (sets.root(root) != root || volume != std::abs(sets.volume(root)) || name != sets.name(root)) continue;
        const uint32_t other = sets.neighbour(root);
        if (other == none || (flat[root] && sticks_out(root, other))) continue;
        const uint8_t both_flat = flat[root] & flat[other];
        uint32_t united = sets.unite(root, other, sets.name(other));
        flat[united] = both_flat;
        // What lay between two pieces of a group may be gone.
        for (uint32_t mate = find_mate(united); mate != none; mate = find_mate(united)) {
            const uint8_t flat_too = flat[united] & flat[mate];
            united = sets.unite(united, mate, std::min(sets.name(united), sets.name(mate)));
            flat[united] = flat_too;
        }
        enqueue(united);
    }
    std::vector<uint32_t> representative(count);
    for (uint32_t p = 0; p < count; ++p) {
        const uint32_t root = sets.root(p);
        representative[p] = flat[root] ? dropped : sets.name(root);
    }
    return representative;
}

namespace {

double distance2_to_triangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const auto to_segment = [&](const glm::dvec3& from, const glm::dvec3& to) {
        const glm::dvec3 d = to - from;
        const double length2 = glm::dot(d, d);
        const double t = length2 > 0.0 ? std::clamp(glm::dot(p - from, d) / length2, 0.0, 1.0) : 0.0;
        const glm::dvec3 off = p - from - t * d;
        return glm::dot(off, off);
    };
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    const double normal2 = glm::dot(normal, normal);
    const auto inside = [&](const glm::dvec3& from, const glm::dvec3& to) {
        return glm::dot(glm::cross(to - from, p - from), normal) >= 0.0;
    };
    if (normal2 > 0.0 && inside(a, b) && inside(b, c) && inside(c, a)) {
        const double off = glm::dot(p - a, normal);
        return off * off / normal2;
    }
    return std::min({to_segment(a, b), to_segment(b, c), to_segment(c, a)});
}

// The input triangle of a sheet that lies where a triangle of its neighbour is; none where the sheet has none.
uint32_t source_beyond(const Fragments& fragments, const Piece& of, uint32_t t, const Piece& sheet) {
    const Triangle& c = fragments.triangles[t];
    const auto own = fragments.positions_of(of);
    const glm::dvec3 centre = (own[c.x] + own[c.y] + own[c.z]) / 3.0;
    const auto positions = fragments.positions_of(sheet);
    uint32_t nearest = none;
    double least = std::numeric_limits<double>::infinity();
    for (uint32_t s = sheet.triangles.begin; s < sheet.triangles.begin + sheet.exterior_triangles; ++s) {
        const Triangle& e = fragments.triangles[s];
        const double distance2 = distance2_to_triangle(centre, positions[e.x], positions[e.y], positions[e.z]);
        if (distance2 >= least) continue;
        least = distance2;
        nearest = fragments.triangle_source[s];
    }
    return nearest;
}

// One set of pieces under the needle. Half-edge 3t + k runs from corner k of triangle t to the next.
class Sewing {
  public:
    // Pieces ascend. parts_of_source: of how many exterior triangles of all fragments each input triangle is the source.
    Sewing(const Fragments& fragments, std::span<const uint32_t> representative, const Caps& caps,
           std::span<const uint32_t> pieces, std::span<const uint32_t> parts_of_source)
        : fragments_(fragments), representative_(representative), caps_(caps), parts_of_source_(parts_of_source) {
        for (const uint32_t piece : pieces) {
            first_triangle_.push_back(static_cast<uint32_t>(triangles_.size()));
            add(piece);
        }
        take_out_caps(pieces);
        sew();
        find_vertices();
    }

    // Appends the piece to `out`, without mass. next_point: an unused vertex_point.
    Piece write(Fragments& out, uint32_t& next_point) {
        find_whole_sources();
        if (!is_simple()) {
            for (Patch& patch : patches_) patch.whole = false;
            halve_repeated_edges(next_point);
        }
        Piece piece;
        piece.vertices.begin = static_cast<uint32_t>(out.positions.size());
        piece.triangles.begin = static_cast<uint32_t>(out.triangles.size());
        local_.assign(triangles_.size() * 6, none);
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
        std::array<uint32_t, 3> vertex; // into Fragments::positions
        uint32_t triangle;              // of the fragments
        uint32_t source;
        bool exterior;
        bool gone = false;
        bool was_cap = false; // exterior now, because a sheet before it was dropped
    };
    // Of a polygon to be triangulated: the half-edge that leaves it, or twin_.size() + h for the middle of half-edge h. A
    // point that is no corner lies on a side.
    struct Corner {
        uint32_t h;
        bool is_corner;
    };
    // The parts of an input triangle that was cut.
    struct Patch {
        uint32_t source;
        uint32_t parts_begin, parts_end; // into parts_
        uint32_t rim_begin, rim_end;     // into rims_: half-edges around it; in the end those that stay
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
            Part part{{v.x, v.y, v.z}, t, fragments_.triangle_source[t],
                      t < piece.triangles.begin + piece.exterior_triangles};
            if (const uint32_t across = caps_.across(t); across != none) look_beyond(piece, across, part);
            triangles_.push_back(part);
        }
        // A half-edge's twin is among those that leave the vertex where it ends.
        const uint32_t vertices = piece.vertices.size(), begin = 3 * first;
        leaving_begin_.assign(vertices + 2, 0);
        const auto local = [&](uint32_t h) { return from(h) - piece.vertices.begin; };
        const auto end = static_cast<uint32_t>(3 * triangles_.size());
        for (uint32_t h = begin; h < end; ++h) ++leaving_begin_[local(h) + 2];
        for (uint32_t v = 2; v < vertices + 2; ++v) leaving_begin_[v] += leaving_begin_[v - 1];
        leaving_.resize(end - begin);
        for (uint32_t h = begin; h < end; ++h) leaving_[leaving_begin_[local(h) + 1]++] = h;
        twin_.resize(end, none);
        for (uint32_t h = begin; h < end; ++h) {
            if (twin_[h] != none) continue;
            const uint32_t to = local(after(h));
            for (uint32_t k = leaving_begin_[to]; k < leaving_begin_[to + 1]; ++k) {
                const uint32_t g = leaving_[k];
                if (from(after(g)) != from(h) || twin_[g] != none) continue;
                twin_[h] = g;
                twin_[g] = h;
                break;
            }
        }
    }

    // What a cap's triangle faces once all pieces have changed: another piece, or the open.
    void look_beyond(const Piece& piece, uint32_t across, Part& part) const {
        const uint32_t beyond = caps_.piece_of(across);
        if (representative_[beyond] != dropped) {
            part.source = fragments_.pieces[representative_[beyond]].site;
            return;
        }
        const uint32_t source = source_beyond(fragments_, piece, part.triangle, fragments_.pieces[beyond]);
        if (source == none) return;
        part.source = source;
        part.exterior = part.was_cap = true;
    }

    void take_out_caps(std::span<const uint32_t> pieces) {
        partner_.assign(triangles_.size(), none);
        for (uint32_t t = 0; t < triangles_.size(); ++t) {
            const uint32_t across = caps_.across(triangles_[t].triangle);
            if (across == none) continue;
            const auto beyond = std::lower_bound(pieces.begin(), pieces.end(), caps_.piece_of(across));
            if (beyond == pieces.end() || *beyond != caps_.piece_of(across)) continue;
            const uint32_t first = first_triangle_[static_cast<size_t>(beyond - pieces.begin())];
            partner_[t] = first + across - fragments_.pieces[*beyond].triangles.begin;
            triangles_[t].gone = true;
        }
    }

    // The same edge on the other side of a cap that was taken out, in the other direction.
    [[nodiscard]] uint32_t through(uint32_t h) const {
        const uint32_t other = partner_[h / 3];
        for (uint32_t g = 3 * other; g < 3 * other + 3; ++g)
            if (point(g) == point(after(h))) return g;
        return none; // unreachable: the two have the same points
    }

    void sew() {
        sewn_.assign(twin_.size(), none);
        for (uint32_t h = 0; h < twin_.size(); ++h) {
            if (triangles_[h / 3].gone) continue;
            uint32_t g = twin_[h];
            while (triangles_[g / 3].gone) g = twin_[through(g)];
            sewn_[h] = g;
        }
    }

    // Half-edges leave the same vertex when going around it leads from one to the other.
    void find_vertices() {
        vertex_of_.resize(twin_.size());
        std::iota(vertex_of_.begin(), vertex_of_.end(), 0u);
        for (uint32_t h = 0; h < twin_.size(); ++h) {
            if (sewn_[h] == none) continue;
            const uint32_t a = root_of(vertex_of_, h), b = root_of(vertex_of_, after(sewn_[h]));
            vertex_of_[std::max(a, b)] = std::min(a, b);
        }
    }

    uint32_t vertex(uint32_t h, const Piece& piece, Fragments& out) {
        const auto half_edges = static_cast<uint32_t>(twin_.size());
        const bool middle = h >= half_edges;
        const uint32_t edge = middle ? std::min(h - half_edges, sewn_[h - half_edges]) : h;
        uint32_t& local = local_[middle ? half_edges + edge : root_of(vertex_of_, h)];
        if (local == none) {
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
            if (part.gone || part.exterior != exterior || patch_of(t) != none) continue;
            polygon_.clear();
            for (uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
                polygon_.push_back({h, true});
                if (!middle_.empty() && middle_[std::min(h, sewn_[h])] != none)
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

    // Whether no two edges have the same ends. Solids that touch in their cuts may be sewn so.
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

    // All but one of the edges with the same ends get a point in the middle; those of caps last, as the neighbours have
    // them too.
    void halve_repeated_edges(uint32_t& next_point) {
        struct Edge {
            uint32_t from, to;
            bool exterior;
            uint32_t h;
        };
        std::vector<Edge> edges;
        for (uint32_t h = 0; h < twin_.size(); ++h) {
            if (sewn_[h] == none) continue;
            const uint32_t a = root_of(vertex_of_, h), b = root_of(vertex_of_, after(h));
            if (a < b) edges.push_back({a, b, triangles_[h / 3].exterior && triangles_[sewn_[h] / 3].exterior, h});
        }
        std::sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
            return std::tie(x.from, x.to, x.exterior, x.h) < std::tie(y.from, y.to, y.exterior, y.h);
        });
        middle_.assign(twin_.size(), none);
        for (size_t k = 1; k < edges.size(); ++k) {
            if (edges[k].from != edges[k - 1].from || edges[k].to != edges[k - 1].to) continue;
            middle_[std::min(edges[k].h, sewn_[edges[k].h])] = next_point++;
        }
    }

    // Of the input triangle that this triangle will be part of again as a whole; none where it stays a part.
    [[nodiscard]] uint32_t patch_of(uint32_t t) const {
        return patch_of_[t] != none && patches_[patch_of_[t]].whole ? patch_of_[t] : none;
    }

    void find_whole_sources() {
        for (uint32_t t = 0; t < triangles_.size(); ++t) {
            const Part& part = triangles_[t];
            if (part.exterior && !part.was_cap && parts_of_source_[part.source] > 1) parts_.push_back(t);
        }
        std::sort(parts_.begin(), parts_.end(), [&](uint32_t x, uint32_t y) {
            return std::tie(triangles_[x].source, x) < std::tie(triangles_[y].source, y);
        });
        patch_of_.assign(triangles_.size(), none);
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

    // Whether the parts form a disc with the three corners of the input triangle on its rim.
    bool walk_rim(Patch& patch) {
        uint32_t rims = 0, first = none;
        for (uint32_t k = patch.parts_begin; k < patch.parts_end; ++k) {
            for (uint32_t h = 3 * parts_[k]; h < 3 * parts_[k] + 3; ++h) {
                if (!is_rim(h)) continue;
                ++rims;
                if (first == none) first = h;
            }
        }
        patch.rim_begin = patch.rim_end = static_cast<uint32_t>(rims_.size());
        if (first == none) return false;
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

    // Points on the side towards another input triangle that is whole again are needed by neither.
    void drop_points(Patch& patch) {
        const auto whole_beyond = [&](uint32_t h) { return patch_of(sewn_[h] / 3); };
        const std::span rim(rims_.data() + patch.rim_begin, patch.rim_end - patch.rim_begin);
        uint32_t kept = 0, before = whole_beyond(rim.back());
        for (const uint32_t h : rim) {
            const uint32_t beyond = whole_beyond(h);
            const bool needed = point(h) < first_cut_point || beyond == none || beyond != before;
            before = beyond;
            if (needed) rim[kept++] = h;
        }
        patch.rim_end = patch.rim_begin + kept;
    }

    // Triangulates polygon_, a triangle with points on its sides: ears at corners beside such points first, so that
    // none is flat.
    template<class Emit>
    void triangulate(uint32_t source, const Emit& emit) {
        while (polygon_.size() > 3) {
            const size_t n = polygon_.size();
            size_t ear = 0; // where all are corners, any
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
    const Caps& caps_;
    std::span<const uint32_t> parts_of_source_;
    std::vector<Part> triangles_;
    std::vector<uint32_t> first_triangle_; // of each piece
    std::vector<uint32_t> twin_;      // in the half-edge's own piece
    std::vector<uint32_t> partner_;   // of triangles that are gone
    std::vector<uint32_t> sewn_;      // twins in the new piece
    std::vector<uint32_t> vertex_of_; // a forest over half-edges
    std::vector<uint32_t> local_;     // of the roots of vertex_of_, then of half-edges' middles
    std::vector<uint32_t> middle_;    // of the lower half-edge of each edge: the point in its middle; or empty
    std::vector<Corner> polygon_;
    std::vector<Patch> patches_;
    std::vector<uint32_t> patch_of_; // of triangles
    std::vector<uint32_t> parts_, rims_;
    std::vector<uint32_t> leaving_begin_, leaving_; // scratch: edges by the vertex that they leave
};

void copy_piece(const Fragments& from, Piece piece, Fragments& to) {
    const auto append = [](const auto& source, const Range& range, auto& target) {
        const auto begin = static_cast<uint32_t>(target.size());
        target.insert(target.end(), source.begin() + range.begin, source.begin() + range.end);
        return Range{begin, static_cast<uint32_t>(target.size())};
    };
    append(from.vertex_point, piece.vertices, to.vertex_point);
    append(from.triangle_source, piece.triangles, to.triangle_source);
    piece.vertices = append(from.positions, piece.vertices, to.positions);
    piece.triangles = append(from.triangles, piece.triangles, to.triangles);
    to.pieces.push_back(piece);
}

std::vector<Bond> merge_bonds(std::span<const Bond> bonds, std::span<const uint32_t> new_index) {
    std::map<std::pair<uint32_t, uint32_t>, Bond> merged;
    for (const Bond& bond : bonds) {
        const uint32_t a = new_index[bond.a], b = new_index[bond.b];
        if (a == b || a == none || b == none) continue;
        Bond& sum = merged.try_emplace(std::minmax(a, b), Bond{std::min(a, b), std::max(a, b)}).first->second;
        sum.area += bond.area;
        sum.centroid += bond.area * bond.centroid;
        sum.normal += (a < b ? bond.area : -bond.area) * bond.normal;
    }
    std::vector<Bond> result;
    for (auto& [ends, bond] : merged) {
        bond.centroid /= bond.area;
        const double length = glm::length(bond.normal);
        // One piece all around the other: no direction is right.
        bond.normal = length > 1e-9 * bond.area ? bond.normal / length : glm::dvec3(0.0, 1.0, 0.0);
        result.push_back(bond);
    }
    return result;
}

} // namespace

void merge_pieces(Fragments& fragments, std::span<const uint32_t> representative, Threads& threads) {
    const auto count = static_cast<uint32_t>(fragments.pieces.size());
    std::vector<std::vector<uint32_t>> members(count);
    bool any = false;
    for (uint32_t p = 0; p < count; ++p) {
        any = any || representative[p] != p;
        if (representative[p] != dropped) members[representative[p]].push_back(p);
    }
    if (!any) return;

    std::vector<uint32_t> parts_of_source;
    for (const Piece& piece : fragments.pieces) {
        for (uint32_t t = piece.triangles.begin; t < piece.triangles.begin + piece.exterior_triangles; ++t) {
            const uint32_t source = fragments.triangle_source[t];
            if (source >= parts_of_source.size()) parts_of_source.resize(size_t{source} + 1, 0);
            ++parts_of_source[source];
        }
    }
    std::vector<uint8_t> changes; // by site: whether a piece of it is not what it was
    for (const Piece& piece : fragments.pieces)
        if (piece.site >= changes.size()) changes.resize(size_t{piece.site} + 1, 0);
    for (uint32_t p = 0; p < count; ++p)
        if (representative[p] != p) changes[fragments.pieces[p].site] = 1;
    const Caps caps(fragments, [&](uint32_t a, uint32_t b) {
        return (a < changes.size() && changes[a]) || (b < changes.size() && changes[b]);
    });
    const auto is_as_before = [&](uint32_t p) {
        if (members[p].size() > 1) return false;
        const Range& triangles = fragments.pieces[p].triangles;
        for (uint32_t t = triangles.begin + fragments.pieces[p].exterior_triangles; t < triangles.end; ++t) {
            const uint32_t across = caps.across(t);
            if (across != none && representative[caps.piece_of(across)] != caps.piece_of(across)) return false;
        }
        return true;
    };
    // Sets are sewn side by side, each into fragments of its own, and with points of its own for halved edges.
    struct Set {
        uint32_t piece;
        uint32_t next_point;
        Fragments sewn{};
    };
    std::vector<Set> sets;
    uint32_t next_point = 1 + *std::max_element(fragments.vertex_point.begin(), fragments.vertex_point.end());
    for (uint32_t p = 0; p < count; ++p) {
        if (members[p].empty() || is_as_before(p)) continue;
        sets.push_back({p, next_point});
        for (const uint32_t member : members[p]) next_point += 3 * fragments.pieces[member].triangles.size();
    }
    threads.for_chunks(static_cast<uint32_t>(sets.size()), 1, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t k = begin; k < end; ++k) {
            auto& [piece, point, sewn] = sets[k];
            sewn.pieces = {Sewing(fragments, representative, caps, members[piece], parts_of_source).write(sewn, point)};
            sewn.pieces[0].site = fragments.pieces[piece].site;
            sewn.pieces[0].mass = mass_properties(sewn.positions, sewn.triangles);
        }
    });
    Fragments merged;
    std::vector<uint32_t> new_index(count, none);
    auto set = sets.begin();
    for (uint32_t p = 0; p < count; ++p) {
        if (members[p].empty()) continue;
        for (const uint32_t member : members[p]) new_index[member] = static_cast<uint32_t>(merged.pieces.size());
        const bool is_sewn = set != sets.end() && set->piece == p;
        const Fragments& from = is_sewn ? set->sewn : fragments;
        copy_piece(from, is_sewn ? from.pieces[0] : from.pieces[p], merged);
        if (is_sewn) ++set;
    }
    merged.bonds = merge_bonds(fragments.bonds, new_index);
    merged.timings = std::move(fragments.timings);
    fragments = std::move(merged);
}

} // namespace brittle::fracture

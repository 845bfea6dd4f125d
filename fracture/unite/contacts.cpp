// The segments in which two triangles meet, by the signs of orientations alone.
#include <algorithm>
#include <optional>

#include "fracture/arithmetic/plane_predicates.h"
#include "fracture/mesh/intersections.h"
#include "fracture/unite/arrangement.h"

namespace brittle::fracture::arrangement {
namespace {

// Where in a triangle a point lies: 0 to 2 for a corner, 3 to 5 for the edge that begins at corner 0 to 2, else inside.
using Place = int;
constexpr Place inside = 6;

bool is_on_edge(Place place, int edge) {
    return place == edge || place == (edge + 1) % 3 || place == edge + 3;
}

// Returns an edge of the triangle on which both places lie, or -1.
int common_edge(Place a, Place b) {
    for (int edge = 0; edge < 3; ++edge)
        if (is_on_edge(a, edge) && is_on_edge(b, edge)) return edge;
    return -1;
}

// A point that two triangles have in common. Index 0 is of the first triangle, 1 of the second.
struct Meeting {
    uint32_t point;
    std::array<Place, 2> place;
};

int sign(double x) {
    return x > 0.0 ? 1 : (x < 0.0 ? -1 : 0);
}

// Returns the place in a triangle of a point in its plane, from the signs with which the point lies to the left of the
// edges; nothing outside.
std::optional<Place> place_of(const std::array<int, 3>& left) {
    if (left[0] < 0 || left[1] < 0 || left[2] < 0) return std::nullopt;
    for (int k = 0; k < 3; ++k)
        if (left[static_cast<size_t>(k)] == 0 && left[static_cast<size_t>((k + 2) % 3)] == 0) return k;
    for (int k = 0; k < 3; ++k)
        if (left[static_cast<size_t>(k)] == 0) return k + 3;
    return inside;
}

// Two triangles and the signs that tell how they lie to each other. Of the two, `own` is 0 or 1 and 1 - own the other.
class TrianglePair {
  public:
    enum class Relation { apart, equal, in_plane, crossing };

    TrianglePair(const Arrangement& arrangement, uint32_t s, uint32_t t)
        : all_(&arrangement), triangle_{s, t}, corners_{arrangement.corners(s), arrangement.corners(t)},
          relation_(relate()) {}

    // apart: no segment in common, but for a common edge. equal: the same corners. The others may have segments.
    [[nodiscard]] Relation relation() const { return relation_; }
    [[nodiscard]] uint32_t triangle(size_t own) const { return triangle_[own]; }
    [[nodiscard]] uint32_t vertex(size_t own, int k) const { return all_->corner(triangle_[own], k); }
    [[nodiscard]] const glm::dvec3& at(size_t own, int k) const { return corners_[own][static_cast<size_t>(k)]; }
    [[nodiscard]] const Corners& corners(size_t own) const { return corners_[own]; }
    [[nodiscard]] uint64_t edge_key(size_t own, int k) const {
        return Arrangement::edge_key(vertex(own, k), vertex(own, (k + 1) % 3));
    }
    // The sign of the height of corner k over the plane of the other triangle.
    [[nodiscard]] int height(size_t own, int k) const { return height_[own][static_cast<size_t>(k)]; }

    // The place, in the other triangle, of a corner that lies in the other one's plane.
    [[nodiscard]] std::optional<Place> place_of_corner(size_t own, int k) const {
        const size_t other = 1 - own;
        for (int j = 0; j < 3; ++j)
            if (vertex(other, j) == vertex(own, k)) return j;
        std::array<int, 3> left{};
        for (int j = 0; j < 3; ++j)
            left[static_cast<size_t>(j)] = turn(other, at(other, j), at(other, (j + 1) % 3), at(own, k));
        return place_of(left);
    }

    // Where edge k, which crosses the plane of the other triangle, meets that triangle.
    [[nodiscard]] std::optional<Place> place_of_edge(size_t own, int k) const {
        const size_t other = 1 - own;
        std::array<int, 3> left{};
        for (int j = 0; j < 3; ++j)
            left[static_cast<size_t>(j)] =
                -height(own, k) * side_of({at(own, k), at(other, j), at(other, (j + 1) % 3)}, at(own, (k + 1) % 3));
        return place_of(left);
    }

    // 1 where corner j of the other triangle, in this one's plane, lies on the left of edge k.
    [[nodiscard]] int left_of_edge(size_t own, int k, int j) const {
        const uint32_t v = vertex(1 - own, j);
        if (v == vertex(own, k) || v == vertex(own, (k + 1) % 3)) return 0;
        return turn(own, at(own, k), at(own, (k + 1) % 3), at(1 - own, j));
    }

  private:
    Relation relate() {
        int shared = 0;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) shared += vertex(0, i) == vertex(1, j) ? 1 : 0;
        if (shared == 3) return Relation::equal;
        for (size_t own = 2; own-- > 0;) {
            for (int k = 0; k < 3; ++k) height_[own][static_cast<size_t>(k)] = find_height(own, k);
            const auto [low, high] = std::minmax({height(own, 0), height(own, 1), height(own, 2)});
            if (low > 0 || high < 0) return Relation::apart;
            if (low == 0 && high == 0) return is_beside(0) || is_beside(1) ? Relation::apart : Relation::in_plane;
            if (shared == 2) return Relation::apart;
        }
        for (const size_t own : {0, 1})
            for (int k = 0; k < 3; ++k)
                if (meets_beyond_corners(own, k)) return Relation::crossing;
        return Relation::apart;
    }

    // Whether corner k, unless it is a common one, or edge k has a point in the other triangle.
    [[nodiscard]] bool meets_beyond_corners(size_t own, int k) const {
        if (height(own, k) == 0) {
            for (int j = 0; j < 3; ++j)
                if (vertex(1 - own, j) == vertex(own, k)) return false;
            return place_of_corner(own, k).has_value();
        }
        return height(own, k) * height(own, (k + 1) % 3) < 0 && place_of_edge(own, k).has_value();
    }

    [[nodiscard]] int find_height(size_t own, int k) const {
        for (int j = 0; j < 3; ++j)
            if (vertex(1 - own, j) == vertex(own, k)) return 0;
        return side_of(corners_[1 - own], at(own, k));
    }

    // Whether an edge, in one plane with the other triangle, separates it from this one, up to a point or that edge.
    [[nodiscard]] bool is_beside(size_t own) const {
        for (int k = 0; k < 3; ++k) {
            int on_line = 0, on_left = 0, at_ends = 0;
            for (int j = 0; j < 3; ++j) {
                const uint32_t v = vertex(1 - own, j);
                at_ends += v == vertex(own, k) || v == vertex(own, (k + 1) % 3) ? 1 : 0;
                const int left = left_of_edge(own, k, j);
                on_line += left == 0 ? 1 : 0;
                on_left += left > 0 ? 1 : 0;
            }
            if (on_left == 0 && (at_ends == 2 || on_line <= 1)) return true;
        }
        return false;
    }

    // The turn of three points in the plane of a triangle: 1 as its corners turn.
    [[nodiscard]] int turn(size_t own, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) const {
        const int axis = all_->axis[triangle_[own]];
        const auto flat = [axis](const glm::dvec3& p) { return glm::dvec2(p[(axis + 1) % 3], p[(axis + 2) % 3]); };
        const auto in_projection = [&](const glm::dvec3& p, const glm::dvec3& q, const glm::dvec3& r) {
            return sign(orientation(flat(p), flat(q), flat(r)));
        };
        return in_projection(at(own, 0), at(own, 1), at(own, 2)) * in_projection(a, b, c);
    }

    const Arrangement* all_;
    std::array<uint32_t, 2> triangle_;
    std::array<Corners, 2> corners_;
    std::array<std::array<int, 3>, 2> height_{};
    Relation relation_;
};

class Finder {
  public:
    explicit Finder(Arrangement& arrangement) : all_(arrangement) {}

    void look_at(const TrianglePair& pair) {
        switch (pair.relation()) {
        case TrianglePair::Relation::apart:
            return;
        case TrianglePair::Relation::equal: // no segment is new
            for (const size_t own : {0, 1}) all_.cuts[all_.cut(pair.triangle(own))].is_covered = true;
            return;
        case TrianglePair::Relation::in_plane:
            for (const size_t own : {0, 1})
                for (int k = 0; k < 3; ++k) {
                    meetings_.clear();
                    meet_in_plane(pair, own, k);
                    if (meetings_.size() == 2) add_segment_in_plane(pair, own, k);
                }
            return;
        case TrianglePair::Relation::crossing:
            meetings_.clear();
            for (const size_t own : {0, 1}) pierce(pair, own);
            if (meetings_.size() == 2) add_segment(pair);
            return;
        }
    }

  private:
    // Finds the points in which the boundary of `own` meets the other triangle, where the planes are not the same.
    void pierce(const TrianglePair& pair, size_t own) {
        for (int k = 0; k < 3; ++k) {
            if (pair.height(own, k) == 0)
                if (const auto place = pair.place_of_corner(own, k)) meet(own, pair.vertex(own, k), k, *place);
            if (pair.height(own, k) * pair.height(own, (k + 1) % 3) >= 0) continue;
            const auto place = pair.place_of_edge(own, k);
            if (!place) continue;
            const size_t other = 1 - own;
            const auto plane = [&] { return plane_of(pair.corners(other)); };
            const uint32_t point = *place < 3 ? pair.vertex(other, *place)
                                   : *place < inside
                                       ? crossing(pair, own, k, pair.edge_key(other, *place - 3), true, plane)
                                       : crossing(pair, own, k, pair.triangle(other), false, plane);
            meet(own, point, k + 3, *place);
        }
    }

    // Finds the points of edge k of `own` that bound its part in the other triangle, in one plane.
    void meet_in_plane(const TrianglePair& pair, size_t own, int k) {
        const size_t other = 1 - own;
        const int next = (k + 1) % 3;
        for (const int end : {k, next})
            if (const auto place = pair.place_of_corner(own, end)) meet(own, pair.vertex(own, end), end, *place);
        std::array<int, 3> left{};
        for (int j = 0; j < 3; ++j) left[static_cast<size_t>(j)] = pair.left_of_edge(own, k, j);
        for (int j = 0; j < 3; ++j) {
            const int j_next = (j + 1) % 3;
            if (left[static_cast<size_t>(j)] == 0 && is_between(pair.at(own, k), pair.at(own, next), pair.at(other, j)))
                meet(own, pair.vertex(other, j), k + 3, j);
            if (left[static_cast<size_t>(j)] * left[static_cast<size_t>(j_next)] >= 0) continue;
            if (pair.left_of_edge(other, j, k) * pair.left_of_edge(other, j, next) >= 0) continue;
            const auto plane = [&] {
                return plane_along(pair.at(other, j), pair.at(other, j_next), all_.axis[pair.triangle(other)]);
            };
            meet(own, crossing(pair, own, k, pair.edge_key(other, j), true, plane), k + 3, j + 3);
        }
    }

    // Whether r, on the line pq, lies strictly between p and q.
    static bool is_between(const glm::dvec3& p, const glm::dvec3& q, const glm::dvec3& r) {
        for (int axis = 0; axis < 3; ++axis)
            if (p[axis] != q[axis])
                return (p[axis] < r[axis] && r[axis] < q[axis]) || (q[axis] < r[axis] && r[axis] < p[axis]);
        return false;
    }

    // The point in which edge k of `own` meets a triangle, or an edge, whose plane is made only for a new point.
    template<class MakePlane>
    uint32_t crossing(const TrianglePair& pair, size_t own, int k, uint64_t partner, bool is_edge, MakePlane&& plane) {
        const uint64_t edge = pair.edge_key(own, k);
        const Key key =
            is_edge ? Key{std::min(edge, partner), std::max(edge, partner), true} : Key{edge, partner, false};
        const auto [entry, is_new] = known_.try_emplace(key, 0u);
        if (is_new) entry->second = all_.points.add(on_line(pair.at(own, k), pair.at(own, (k + 1) % 3), plane()));
        return entry->second;
    }

    void meet(size_t own, uint32_t point, Place in_own, Place in_other) {
        for (const Meeting& known : meetings_)
            if (known.point == point) return;
        Meeting meeting{point, {}};
        meeting.place[own] = in_own;
        meeting.place[1 - own] = in_other;
        meetings_.push_back(meeting);
    }

    // Adds the ends of a segment to the edges on which they lie.
    void divide_edges(const TrianglePair& pair) {
        for (const Meeting& meeting : meetings_)
            for (const size_t own : {0, 1}) {
                const Place place = meeting.place[own];
                if (place < 3 || place == inside) continue;
                std::vector<uint32_t>& points = all_.carriers[all_.edge_carrier(pair.triangle(own), place - 3)].points;
                if (std::find(points.begin(), points.end(), meeting.point) == points.end())
                    points.push_back(meeting.point);
            }
    }

    void add_portion(uint32_t triangle, uint32_t carrier) {
        const uint32_t cut = all_.cut(triangle);
        if (all_.carriers[carrier].is_edge()) // both triangles of the edge lead here
            for (const Portion& portion : all_.cuts[cut].portions)
                if (portion.carrier == carrier) return;
        all_.cuts[cut].portions.push_back({carrier, meetings_[0].point, meetings_[1].point});
        all_.carriers[carrier].cuts.push_back(cut);
    }

    // Adds the segment in which two triangles of different planes meet.
    void add_segment(const TrianglePair& pair) {
        divide_edges(pair);
        std::array<int, 2> edge{};
        for (const size_t own : {0, 1}) edge[own] = common_edge(meetings_[0].place[own], meetings_[1].place[own]);
        if (edge[0] < 0 && edge[1] < 0) {
            const auto carrier = static_cast<uint32_t>(all_.carriers.size());
            all_.carriers.push_back({meetings_[0].point, meetings_[1].point, {pair.triangle(0), pair.triangle(1)}});
            for (const size_t own : {0, 1}) add_portion(pair.triangle(own), carrier);
            return;
        }
        if (is_same_edge(pair, edge)) return;
        for (const size_t own : {0, 1})
            if (edge[own] >= 0) add_portion(pair.triangle(1 - own), all_.edge_carrier(pair.triangle(own), edge[own]));
    }

    // Adds the part of edge k of `own` that lies in the other triangle.
    void add_segment_in_plane(const TrianglePair& pair, size_t own, int k) {
        divide_edges(pair);
        for (const size_t of : {0, 1}) all_.cuts[all_.cut(pair.triangle(of))].is_covered = true;
        std::array<int, 2> edge{};
        edge[own] = k;
        edge[1 - own] = common_edge(meetings_[0].place[1 - own], meetings_[1].place[1 - own]);
        if (!is_same_edge(pair, edge)) add_portion(pair.triangle(1 - own), all_.edge_carrier(pair.triangle(own), k));
    }

    [[nodiscard]] static bool is_same_edge(const TrianglePair& pair, const std::array<int, 2>& edge) {
        return edge[0] >= 0 && edge[1] >= 0 && pair.edge_key(0, edge[0]) == pair.edge_key(1, edge[1]);
    }

    struct Key {
        uint64_t edge, partner; // the partner is another edge or a triangle
        bool is_crossing;       // of two edges
        bool operator==(const Key&) const = default;
    };
    struct KeyHash {
        size_t operator()(const Key& key) const {
            uint64_t h = key.edge * 0x9e3779b97f4a7c15u;
            h ^= h >> 31;
            h = (h + key.partner + (key.is_crossing ? 1 : 0)) * 0xbf58476d1ce4e5b9u;
            return static_cast<size_t>(h ^ (h >> 29));
        }
    };

    Arrangement& all_;
    std::unordered_map<Key, uint32_t, KeyHash> known_; // points on edges
    std::vector<Meeting> meetings_;                    // of the pair in hand
};

} // namespace

Arrangement::Arrangement(const TriangleMesh& input) : mesh(input), points(input.positions) {
    for (Triangle& t : mesh.triangles) t = {points.first_at(t.x), points.first_at(t.y), points.first_at(t.z)};
    axis.reserve(mesh.triangles.size());
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) axis.push_back(static_cast<int8_t>(open_axis(corners(t))));
    cut_of.assign(mesh.triangles.size(), no_index);
}

Corners Arrangement::corners(uint32_t triangle) const {
    const Triangle& t = mesh.triangles[triangle];
    return {mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]};
}

uint64_t Arrangement::edge_key(uint32_t a, uint32_t b) {
    return (uint64_t{std::min(a, b)} << 32) | std::max(a, b);
}

uint32_t Arrangement::edge_carrier(uint32_t triangle, int k) {
    const uint32_t a = corner(triangle, k), b = corner(triangle, (k + 1) % 3);
    const auto [entry, is_new] = carrier_of_edge.try_emplace(edge_key(a, b), static_cast<uint32_t>(carriers.size()));
    if (is_new) carriers.push_back({std::min(a, b), std::max(a, b), {no_index, no_index}});
    return entry->second;
}

uint32_t Arrangement::cut(uint32_t triangle) {
    if (cut_of[triangle] == no_index) {
        cut_of[triangle] = static_cast<uint32_t>(cuts.size());
        cuts.push_back({triangle});
    }
    return cut_of[triangle];
}

const BoxTree& Arrangement::tree(Threads& threads) {
    if (!tree_) {
        std::vector<uint32_t> solid; // triangles with area
        for (uint32_t t = 0; t < mesh.triangles.size(); ++t)
            if (axis[t] >= 0) solid.push_back(t);
        tree_.emplace(mesh, solid, threads);
    }
    return *tree_;
}

void find_contacts(Arrangement& arrangement, const std::vector<uint8_t>& is_fresh, Threads& threads) {
    const auto may_meet = [&](uint32_t s, uint32_t t) {
        return TrianglePair(arrangement, s, t).relation() != TrianglePair::Relation::apart;
    };
    std::vector<uint32_t> fresh, old;
    for (uint32_t t = 0; t < is_fresh.size(); ++t)
        if (arrangement.axis[t] >= 0) (is_fresh[t] ? fresh : old).push_back(t);
    std::vector<glm::uvec2> pairs;
    if (old.empty()) {
        pairs = arrangement.tree(threads).pairs(may_meet, threads);
    } else {
        const BoxTree few(arrangement.mesh, fresh, threads);
        pairs = few.pairs(may_meet, threads);
        const std::vector<glm::uvec2> others = few.pairs(BoxTree(arrangement.mesh, old, threads), may_meet, threads);
        pairs.insert(pairs.end(), others.begin(), others.end());
    }
    Finder finder(arrangement);
    for (const glm::uvec2& pair : pairs) finder.look_at(TrianglePair(arrangement, pair.x, pair.y));
}

} // namespace brittle::fracture::arrangement

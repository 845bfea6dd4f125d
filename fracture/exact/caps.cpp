#include "fracture/exact/caps.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <glm/geometric.hpp>

namespace brittle::fracture::exact {

namespace {

constexpr uint32_t min_facets_per_chunk = 4;

// A stop of the walk around a facet: a pierce point, where the winding number changes, or a Voronoi vertex.
struct Stop {
    VertexId pierce;     // none at a Voronoi vertex
    uint32_t vertex = 0; // of the diagram
    int32_t before = 0, after = 0;
    uint32_t interval = 0;  // of the Voronoi edge, between the stop before and this one (edge_nodes.h)
    bool along_edge = true; // the walk follows the direction of the Voronoi edge there
};

// The axis that is furthest from a direction.
glm::dvec3 other_axis(const glm::dvec3& direction) {
    const glm::dvec3 size = glm::abs(direction);
    if (size.x <= size.y && size.x <= size.z) return {1.0, 0.0, 0.0};
    return size.y <= size.z ? glm::dvec3(0.0, 1.0, 0.0) : glm::dvec3(0.0, 0.0, 1.0);
}

bool even(uint32_t a, uint32_t b, uint32_t c) {
    return (a < b && b < c) || (b < c && c < a) || (c < a && a < b);
}

} // namespace

glm::dvec3 cap_position(const Cut& cut, VertexId id) {
    switch (id.kind()) {
    case VertexId::edge:
        return cut.edge_positions[id.index()];
    case VertexId::pierce:
        return cut.pierce_positions[id.index()];
    case VertexId::node:
        return cut.nodes[id.index()].position;
    case VertexId::mesh:
        break;
    }
    assert(false && "a mesh vertex never lies on a bisector");
    return glm::dvec3(0.0);
}

class Capper::Worker {
  public:
    struct Context {
        const Scene& scene;
        const VoronoiDiagram& diagram;
        const Winding& winding;
        const EdgeNodes& edge_nodes;
        double spacing; // of points inside a facet, 0 for none
        const CapLattice& lattice;
        std::span<const InteriorPoints::Normals> edge_normals, pierce_normals;
        const Cut& cut;
        std::span<uint8_t> visited;
    };

    void start() {
        forced_ears = 0;
        closed = true;
    }
    void cap(const Context& context, uint32_t facet, std::span<const uint32_t> edge_points, CapChunk& out);

    uint64_t forced_ears = 0;
    bool closed = true;

  private:
    bool walk_around(const Context& context, const VoronoiDiagram::Facet& facet);
    void find_strands(const Context& context, int32_t sheet);
    void add_edge_nodes(const Context& context, const Stop& stop, int32_t sheet);
    void trace_strands(const Context& context, const VoronoiDiagram::Facet& facet, CapChunk& out);
    void trace_chains(const Context& context, std::span<const uint32_t> edge_points, CapChunk& out);
    bool follow_chain(const Context& context, const VoronoiDiagram::Facet& facet, VertexId& at, CapChunk& out);
    void begin_loop(const CapChunk& out) { loop_begin_ = out.corners.size(); }
    void end_loop(CapChunk& out);
    void triangulate_loops(const Context& context, const VoronoiDiagram::Facet& facet, Cap& cap, CapChunk& out);

    void find_sides(const Context& context, const VoronoiDiagram::Facet& facet, const Cap& cap, const CapChunk& out);
    void split_diagonals_along_sides(const Context& context, Cap& cap, CapChunk& out);
    void separate_fans(const Context& context, Cap& cap, CapChunk& out);
    uint32_t add_node(const Context& context, const glm::dvec3& position, Cap& cap, CapChunk& out);

    std::vector<Stop> stops_;
    std::vector<std::array<uint32_t, 2>> sides_; // per corner of the cap: the Voronoi edges that contain it
    std::vector<std::array<uint32_t, 2>> along_; // directed edges of triangles with both ends on one Voronoi edge
    struct FanTriangle {                         // of the fan around a corner; next and previous are its other corners
        uint32_t next, previous;
        uint32_t triangle;
        bool visited;
    };
    std::vector<FanTriangle> fans_;
    std::vector<uint32_t> fan_begin_; // per corner of the cap
    struct Strand {
        uint32_t begin, end; // into strand_corners_
        bool used;
    };
    std::vector<Strand> strands_;
    std::vector<VertexId> strand_corners_;
    size_t loop_begin_ = 0;
    size_t cap_begin_ = 0;
    size_t loop_count_ = 0;
    std::vector<Loop> loops_; // the first loop_count_ belong to the current cap
    std::vector<glm::dvec2> flat_;
    Triangulator triangulator_;
    InteriorPoints interior_points_;
    std::vector<InteriorPoints::Normals> normals_;
    std::vector<Triangle> divided_;
};

Capper::Capper() = default;
Capper::~Capper() = default;

bool Capper::Worker::walk_around(const Context& context, const VoronoiDiagram::Facet& facet) {
    const auto ring = context.diagram.ring_of(facet);
    stops_.clear();
    int32_t w = context.winding.of_vertex[ring.back().vertex];
    bool any = w != 0;
    for (const VoronoiDiagram::Corner& corner : ring) {
        const auto pierces = context.winding.pierces_of(corner.edge);
        const bool along = even(facet.i, facet.j, corner.third);
        const uint32_t first = EdgeNodes::first_interval(context.winding, corner.edge);
        const auto interval = [&](size_t k) { return first + static_cast<uint32_t>(along ? k : pierces.size() - k); };
        for (size_t k = 0; k < pierces.size(); ++k) {
            const uint32_t p = along ? pierces[k] : pierces[pierces.size() - 1 - k];
            const int32_t change = (context.cut.pierce_points[p].leaves != 0) == along ? -1 : 1;
            stops_.push_back({{VertexId::pierce, p}, 0, w, w + change, interval(k), along});
            w += change;
            any = true;
        }
        stops_.push_back({VertexId{}, corner.vertex, w, w, interval(pierces.size()), along});
        if (w != context.winding.of_vertex[corner.vertex]) closed = false;
        any = any || w != 0;
    }
    return any;
}

// Adds the nodes of a sheet between the stop before and this one.
void Capper::Worker::add_edge_nodes(const Context& context, const Stop& stop, int32_t sheet) {
    const uint32_t count = context.edge_nodes.count(stop.interval);
    if (count == 0) return;
    const uint32_t first = context.edge_nodes.first(stop.interval, sheet);
    for (uint32_t k = 0; k < count; ++k)
        strand_corners_.push_back({VertexId::node, stop.along_edge ? first + k : first + count - 1 - k});
}

void Capper::Worker::find_strands(const Context& context, int32_t sheet) {
    const size_t n = stops_.size();
    const auto has = [sheet](int32_t w) { return Winding::has_sheet(w, sheet); };
    size_t first = 0;
    while (first < n && !(!has(stops_[first].before) && has(stops_[first].after))) ++first;
    const auto begin = static_cast<uint32_t>(strand_corners_.size());
    if (first == n) { // the sheet is absent, or covers the whole facet, whose sides are a loop then
        if (!has(stops_[0].before)) return;
        for (const Stop& stop : stops_) {
            add_edge_nodes(context, stop, sheet);
            if (stop.pierce.is_none())
                strand_corners_.push_back({VertexId::node, context.winding.node(stop.vertex, sheet)});
        }
        if (sheet <= 0) std::reverse(strand_corners_.begin() + begin, strand_corners_.end());
        strands_.push_back({begin, static_cast<uint32_t>(strand_corners_.size()), false});
        return;
    }
    uint32_t strand_begin = begin;
    for (size_t k = 0; k < n; ++k) {
        const Stop& stop = stops_[(first + k) % n];
        const bool before = has(stop.before), after = has(stop.after);
        if (before) add_edge_nodes(context, stop, sheet);
        if (stop.pierce.is_none()) {
            if (after) strand_corners_.push_back({VertexId::node, context.winding.node(stop.vertex, sheet)});
        } else if (before != after) {
            if (after) strand_begin = static_cast<uint32_t>(strand_corners_.size());
            strand_corners_.push_back(stop.pierce);
            if (after) continue;
            if (sheet <= 0) std::reverse(strand_corners_.begin() + strand_begin, strand_corners_.end());
            strands_.push_back({strand_begin, static_cast<uint32_t>(strand_corners_.size()), false});
        }
    }
}

// Follows the chain from a pierce point to the next one and writes all points except the last. False where it breaks
// off.
bool Capper::Worker::follow_chain(const Context& context, const VoronoiDiagram::Facet& facet, VertexId& at,
                                  CapChunk& out) {
    const PiercePoint& from = context.cut.pierce_points[at.index()];
    const auto place = [&](uint32_t site) {
        return static_cast<uint32_t>(std::find(from.cells.begin(), from.cells.end(), site) - from.cells.begin());
    };
    out.corners.push_back(at);
    at = from.next[pair_index(place(facet.i), place(facet.j))];
    while (!at.is_none() && at.kind() == VertexId::edge) {
        if (context.visited[at.index()]) return false;
        context.visited[at.index()] = 1;
        out.corners.push_back(at);
        at = context.cut.edge_points[at.index()].next;
    }
    return !at.is_none() && at.kind() == VertexId::pierce;
}

void Capper::Worker::trace_strands(const Context& context, const VoronoiDiagram::Facet& facet, CapChunk& out) {
    for (Strand& first : strands_) {
        if (first.used) continue;
        begin_loop(out);
        for (Strand* strand = &first;;) {
            strand->used = true;
            const std::span corners(strand_corners_.data() + strand->begin, strand->end - strand->begin);
            if (corners.front().kind() == VertexId::node) { // all around the facet
                out.corners.insert(out.corners.end(), corners.begin(), corners.end());
                break;
            }
            out.corners.insert(out.corners.end(), corners.begin(), corners.end() - 1);
            VertexId at = corners.back();
            if (!follow_chain(context, facet, at, out)) {
                closed = false;
                break;
            }
            const auto next = std::find_if(strands_.begin(), strands_.end(),
                                           [&](const Strand& s) { return strand_corners_[s.begin] == at; });
            if (next == strands_.end() || (next->used && &*next != &first)) {
                closed = false;
                break;
            }
            if (&*next == &first) break;
            strand = &*next;
        }
        end_loop(out);
    }
}

void Capper::Worker::trace_chains(const Context& context, std::span<const uint32_t> edge_points, CapChunk& out) {
    for (const uint32_t first : edge_points) {
        if (context.visited[first]) continue;
        begin_loop(out);
        VertexId at(VertexId::edge, first);
        while (!at.is_none() && at.kind() == VertexId::edge && !context.visited[at.index()]) {
            context.visited[at.index()] = 1;
            out.corners.push_back(at);
            at = context.cut.edge_points[at.index()].next;
        }
        if (at != VertexId(VertexId::edge, first)) closed = false;
        end_loop(out);
    }
}

void Capper::Worker::end_loop(CapChunk& out) {
    const size_t n = out.corners.size() - loop_begin_;
    // Two triangles back to back leave a loop of two corners. It has no area, and its edges pair up without a cap.
    if (n < 3) {
        out.corners.resize(loop_begin_);
        return;
    }
    if (loops_.size() == loop_count_) loops_.emplace_back();
    Loop& loop = loops_[loop_count_++];
    loop.resize(n);
    for (size_t k = 0; k < n; ++k) loop[k] = static_cast<uint32_t>(loop_begin_ - cap_begin_ + k);
}

void Capper::Worker::triangulate_loops(const Context& context, const VoronoiDiagram::Facet& facet, Cap& cap,
                                       CapChunk& out) {
    const glm::dvec3& site = context.scene.sites[facet.i];
    const glm::dvec3 normal = context.scene.sites[facet.j] - site;
    const auto loops = std::span(loops_).first(loop_count_);
    flat_.clear();
    if (!(context.spacing > 0.0) || !context.lattice.is_bent(facet.i, facet.j)) {
        for (uint32_t k = cap.corners_begin; k < cap.corners_end; ++k)
            flat_.push_back(project(cap_position(context.cut, out.corners[k]), normal));
        const Triangulation& done = triangulator_.run_simple(flat_, loops);
        forced_ears += done.forced_ears;
        out.triangles.insert(out.triangles.end(), done.triangles.begin(), done.triangles.end());
        return;
    }
    // Lengths in the plane are true here, so that points can be placed at equal distances.
    const glm::dvec3 z = glm::normalize(normal), x = glm::normalize(glm::cross(other_axis(z), z)), y = glm::cross(z, x);
    const glm::dvec3 origin = cap_position(context.cut, out.corners[cap.corners_begin]);
    for (uint32_t k = cap.corners_begin; k < cap.corners_end; ++k) {
        const glm::dvec3 p = cap_position(context.cut, out.corners[k]) - origin;
        flat_.push_back({glm::dot(p, x), glm::dot(p, y)});
    }
    const Triangulation& done = triangulator_.run_simple(flat_, loops);
    forced_ears += done.forced_ears;
    divided_.assign(done.triangles.begin(), done.triangles.end());
    if (done.forced_ears == 0) {
        const size_t border = flat_.size();
        normals_.assign(border, {});
        for (size_t k = 0; k < border; ++k) {
            const VertexId id = out.corners[cap.corners_begin + k];
            if (id.kind() == VertexId::edge) normals_[k] = context.edge_normals[id.index()];
            if (id.kind() == VertexId::pierce) normals_[k] = context.pierce_normals[id.index()];
        }
        interior_points_.run(loops, context.spacing, normals_, flat_, divided_);
        for (size_t k = border; k < flat_.size(); ++k)
            add_node(context, origin + flat_[k].x * x + flat_[k].y * y, cap, out);
    }
    out.triangles.insert(out.triangles.end(), divided_.begin(), divided_.end());
}

void Capper::Worker::find_sides(const Context& context, const VoronoiDiagram::Facet& facet, const Cap& cap,
                                const CapChunk& out) {
    const auto ring = context.diagram.ring_of(facet);
    sides_.assign(cap.corners_end - cap.corners_begin, {no_index, no_index});
    for (uint32_t k = 0; k < sides_.size(); ++k) {
        const VertexId id = out.corners[cap.corners_begin + k];
        if (id.kind() == VertexId::pierce) {
            sides_[k][0] = context.cut.pierce_points[id.index()].voronoi_edge;
        } else if (id.kind() == VertexId::node && id.index() >= context.winding.first_node.back()) {
            // A node on a Voronoi edge, or one inside the facet, which no side contains.
            const bool on_edge = id.index() < context.cut.nodes.size();
            if (!on_edge) continue;
            const auto& cells = context.cut.nodes[id.index()].cells;
            for (const VoronoiDiagram::Corner& corner : ring)
                for (const uint32_t c : std::span(cells).first(3)) // the planes of its edge
                    if (c != facet.i && c != facet.j && c == corner.third) sides_[k][0] = corner.edge;
        } else if (id.kind() == VertexId::node) {
            for (size_t m = 0; m < ring.size(); ++m) {
                const uint32_t first = context.winding.first_node[ring[m].vertex];
                const uint32_t last = context.winding.first_node[ring[m].vertex + 1];
                if (id.index() < first || id.index() >= last) continue;
                sides_[k] = {ring[m].edge, ring[m + 1 == ring.size() ? 0 : m + 1].edge};
            }
        }
    }
}

// Adds a corner that belongs to this facet alone. Returns its index in the cap.
uint32_t Capper::Worker::add_node(const Context& context, const glm::dvec3& position, Cap& cap, CapChunk& out) {
    const auto id = static_cast<uint32_t>(context.cut.nodes.size() + out.added_nodes.size());
    out.added_nodes.push_back({cap.facet, position});
    out.corners.push_back({VertexId::node, id});
    return cap.corners_end++ - cap.corners_begin;
}

// Loops that cross each other force triangulate() to fold the cap: it may put triangles all around a corner besides the
// fan between the corner's two sides. That second fan gets its own corner, in the same place.
void Capper::Worker::separate_fans(const Context& context, Cap& cap, CapChunk& out) {
    fan_begin_.assign(cap.corners_end - cap.corners_begin + 2, 0);
    for (size_t t = cap.triangles_begin; t < out.triangles.size(); ++t) {
        for (int m = 0; m < 3; ++m) ++fan_begin_[out.triangles[t][m] + 2];
    }
    for (size_t v = 2; v < fan_begin_.size(); ++v) fan_begin_[v] += fan_begin_[v - 1];
    fans_.resize(fan_begin_.back());
    for (uint32_t t = cap.triangles_begin; t < out.triangles.size(); ++t) {
        const Triangle& c = out.triangles[t];
        for (int m = 0; m < 3; ++m) fans_[fan_begin_[c[m] + 1]++] = {c[(m + 1) % 3], c[(m + 2) % 3], t, false};
    }
    for (size_t k = 0; k < loop_count_; ++k) {
        const uint32_t first = loops_[k].front(), n = static_cast<uint32_t>(loops_[k].size());
        for (uint32_t v = first; v < first + n; ++v) {
            const std::span fan(fans_.data() + fan_begin_[v], fan_begin_[v + 1] - fan_begin_[v]);
            const auto walk = [&](uint32_t from, uint32_t corner) {
                for (;;) {
                    const auto at = std::find_if(fan.begin(), fan.end(),
                                                 [&](const FanTriangle& f) { return f.next == from && !f.visited; });
                    if (at == fan.end()) return;
                    at->visited = true;
                    from = at->previous;
                    Triangle& c = out.triangles[at->triangle];
                    for (int m = 0; m < 3; ++m) c[m] = c[m] == v ? corner : c[m];
                }
            };
            walk(v + 1 == first + n ? first : v + 1, v);
            for (const FanTriangle& f : fan) {
                if (f.visited) continue;
                const glm::dvec3 here = cap_position(context.cut, out.corners[cap.corners_begin + v]);
                walk(f.next, add_node(context, here, cap, out));
            }
        }
    }
}

void Capper::Worker::split_diagonals_along_sides(const Context& context, Cap& cap, CapChunk& out) {
    along_.clear();
    const auto share_side = [&](uint32_t a, uint32_t b) {
        for (const uint32_t side : sides_[a]) {
            if (side != no_index && (side == sides_[b][0] || side == sides_[b][1])) return true;
        }
        return false;
    };
    for (size_t t = cap.triangles_begin; t < out.triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const uint32_t a = out.triangles[t][k], b = out.triangles[t][(k + 1) % 3];
            if (share_side(a, b)) along_.push_back({a, b});
        }
    }
    // A side of the cap occurs in one direction only, a diagonal in both.
    std::sort(along_.begin(), along_.end());
    for (const auto& [a, b] : along_) {
        if (a > b || !std::binary_search(along_.begin(), along_.end(), std::array<uint32_t, 2>{b, a})) continue;
        const glm::dvec3 p = cap_position(context.cut, out.corners[cap.corners_begin + a]);
        const glm::dvec3 q = cap_position(context.cut, out.corners[cap.corners_begin + b]);
        const uint32_t middle = add_node(context, 0.5 * (p + q), cap, out);
        const size_t count = out.triangles.size();
        for (size_t t = cap.triangles_begin; t < count; ++t) {
            for (int k = 0; k < 3; ++k) {
                const int next = (k + 1) % 3;
                Triangle& whole = out.triangles[t];
                const bool holds = (whole[k] == a && whole[next] == b) || (whole[k] == b && whole[next] == a);
                if (!holds) continue;
                Triangle half = whole;
                half[k] = middle;
                whole[next] = middle;
                out.triangles.push_back(half);
                break;
            }
        }
    }
}

void Capper::Worker::cap(const Context& context, uint32_t f, std::span<const uint32_t> edge_points, CapChunk& out) {
    const VoronoiDiagram::Facet& facet = context.diagram.facets[f];
    const bool strands = walk_around(context, facet);
    if (!strands && edge_points.empty()) return;
    cap_begin_ = out.corners.size();
    loop_count_ = 0;
    if (strands) {
        int32_t most = 0, least = 0;
        for (const Stop& stop : stops_) {
            most = std::max(most, stop.after);
            least = std::min(least, stop.after);
        }
        strands_.clear();
        strand_corners_.clear();
        for (int32_t sheet = least + 1; sheet <= most; ++sheet) find_strands(context, sheet);
        trace_strands(context, facet, out);
    }
    trace_chains(context, edge_points, out);
    if (loop_count_ == 0) return;
    Cap cap{f, static_cast<uint32_t>(cap_begin_), static_cast<uint32_t>(out.corners.size()),
            static_cast<uint32_t>(out.triangles.size()), 0};
    const uint64_t forced_before = forced_ears;
    triangulate_loops(context, facet, cap, out);
    if (forced_ears > forced_before) separate_fans(context, cap, out);
    if (strands) {
        find_sides(context, facet, cap, out);
        split_diagonals_along_sides(context, cap, out);
    }
    cap.triangles_end = static_cast<uint32_t>(out.triangles.size());
    out.caps.push_back(cap);
}

void Capper::group_by_facet(const VoronoiDiagram& diagram, const Cut& cut) {
    points_begin_.assign(diagram.facets.size() + 2, 0);
    for (const EdgePoint& point : cut.edge_points) ++points_begin_[point.facet + 2];
    for (size_t f = 2; f < points_begin_.size(); ++f) points_begin_[f] += points_begin_[f - 1];
    points_.resize(cut.edge_points.size());
    for (uint32_t p = 0; p < cut.edge_points.size(); ++p) {
        points_[points_begin_[cut.edge_points[p].facet + 1]++] = p;
    }
    visited_.assign(cut.edge_points.size(), 0);
}

// Finds the normals, after the bend, of the surface at each point of the border of a cap.
void Capper::find_normals(std::span<const Triangle> triangles, const CapLattice& lattice, const Cut& cut) {
    edge_normals_.assign(cut.edge_points.size(), {});
    pierce_normals_.assign(cut.pierce_points.size(), {});
    const auto normal = [&](uint32_t triangle) {
        const Triangle& t = triangles[triangle];
        const glm::dvec3& a = lattice.places[t.x];
        const glm::dvec3 n = glm::cross(lattice.places[t.y] - a, lattice.places[t.z] - a);
        const double length = glm::length(n);
        return length > 0.0 ? n / length : glm::dvec3(0.0);
    };
    for (const CrossingTriangle& crossing : cut.crossing) {
        const glm::dvec3 n = normal(crossing.triangle);
        for (int k = 0; k < 3; ++k) {
            const bool rising = triangles[crossing.triangle][k] < triangles[crossing.triangle][(k + 1) % 3];
            for (uint32_t p = crossing.first[k]; p < crossing.first[k] + crossing.count[k]; ++p)
                edge_normals_[p][rising ? 0 : 1] = n;
        }
    }
    for (size_t p = 0; p < cut.pierce_points.size(); ++p) pierce_normals_[p][0] = normal(cut.pierce_points[p].triangle);
}

// Makes the ids of added nodes unique: every worker numbered its nodes from the same first id.
void Capper::number_added_nodes(const VoronoiDiagram& diagram, Cut& cut) {
    const auto first = static_cast<uint32_t>(cut.nodes.size());
    for (uint32_t k = 0; k < chunk_count_; ++k) {
        CapChunk& chunk = chunks_[k];
        if (chunk.added_nodes.empty()) continue;
        const auto shift = static_cast<uint32_t>(cut.nodes.size()) - first;
        for (VertexId& id : chunk.corners) {
            if (id.kind() == VertexId::node && id.index() >= first) id = {VertexId::node, id.index() + shift};
        }
        for (const CapChunk::AddedNode& node : chunk.added_nodes) {
            const VoronoiDiagram::Facet& facet = diagram.facets[node.facet];
            cut.nodes.push_back({{facet.i, facet.j, no_index, no_index}, node.position, {}});
        }
    }
}

bool Capper::run(const Scene& scene, const VoronoiDiagram& diagram, const Winding& winding,
                 std::span<const Triangle> triangles, const CapLattice& lattice, Cut& cut, Threads& threads) {
    const double spacing = lattice.spacing * scene.to_scene;
    edge_nodes_.run(diagram, winding, spacing, lattice.groups, cut);
    if (spacing > 0.0) find_normals(triangles, lattice, cut);
    group_by_facet(diagram, cut);
    const auto facets = static_cast<uint32_t>(diagram.facets.size());
    chunk_count_ = threads.chunks(facets, min_facets_per_chunk);
    if (chunks_.size() < chunk_count_) chunks_.resize(chunk_count_);
    if (workers_.size() < chunk_count_) workers_.resize(chunk_count_);
    const Worker::Context context{scene,   diagram,       winding,         edge_nodes_, spacing,
                                  lattice, edge_normals_, pierce_normals_, cut,         visited_};
    threads.for_chunks(facets, min_facets_per_chunk, [&](uint32_t k, uint32_t begin, uint32_t end) {
        CapChunk& out = chunks_[k];
        out.caps.clear();
        out.added_nodes.clear();
        out.corners.clear();
        out.triangles.clear();
        workers_[k].start();
        for (uint32_t f = begin; f < end; ++f) {
            threads.poll(f);
            workers_[k].cap(context, f,
                            std::span(points_).subspan(points_begin_[f], points_begin_[f + 1] - points_begin_[f]), out);
        }
    });
    number_added_nodes(diagram, cut);
    bool closed = winding.consistent;
    for (uint32_t k = 0; k < chunk_count_; ++k) closed = closed && workers_[k].closed;
    return closed;
}

uint64_t Capper::forced_ears() const {
    uint64_t sum = 0;
    for (uint32_t k = 0; k < chunk_count_; ++k) sum += workers_[k].forced_ears;
    return sum;
}

} // namespace brittle::fracture::exact

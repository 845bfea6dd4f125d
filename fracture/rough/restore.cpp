#include "fracture/rough/restore.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "fracture/mesh/mass_properties.h"
#include "fracture/pieces/attributes.h"

namespace brittle::fracture::rough {

using exact::VertexId;

namespace {

constexpr uint32_t min_points_per_chunk = 512;
constexpr uint32_t min_vertices_per_chunk = 8192;

using Edge = std::array<uint32_t, 2>; // the lower end first

Edge edge_between(uint32_t a, uint32_t b) {
    return {std::min(a, b), std::max(a, b)};
}

uint32_t size_of(const auto& array) {
    return static_cast<uint32_t>(array.size());
}

} // namespace

void Restorer::place_surface_points(Threads& threads) {
    const exact::Cut& cut = *cut_;
    const exact::Scene& scene = *scene_;
    const Surface& surface = *surface_;
    edge_places_.resize(cut.edge_points.size());
    threads.for_chunks(size_of(cut.crossing), min_points_per_chunk, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t c = begin; c < end; ++c) {
            const exact::CrossingTriangle& crossing = cut.crossing[c];
            const Triangle& t = surface.warped.triangles[crossing.triangle];
            for (int k = 0; k < 3; ++k) {
                const uint32_t from = t[k], to = t[(k + 1) % 3];
                if (from > to) continue; // the other triangle of the edge runs from its lower vertex
                const glm::dvec3 &a = scene.positions[from], side = scene.positions[to] - a;
                for (uint32_t p = crossing.first[k]; p < crossing.first[k] + crossing.count[k]; ++p) {
                    const double along = glm::dot(cut.edge_positions[p] - a, side) / glm::dot(side, side);
                    const double share = along >= 0.0 ? std::min(along, 1.0) : 0.0;
                    edge_places_[p] =
                        surface.positions[from] + share * (surface.positions[to] - surface.positions[from]);
                }
            }
        }
    });
    pierce_places_.resize(cut.pierce_points.size());
    threads.for_chunks(size_of(cut.pierce_points), min_points_per_chunk, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t p = begin; p < end; ++p) {
            const Triangle& t = surface.warped.triangles[cut.pierce_points[p].triangle];
            const glm::dvec3 share = barycentrics({scene.positions[t.x], scene.positions[t.y], scene.positions[t.z]},
                                                  cut.pierce_positions[p]);
            pierce_places_[p] =
                share.x * surface.positions[t.x] + share.y * surface.positions[t.y] + share.z * surface.positions[t.z];
        }
    });
}

void Restorer::place_nodes(Threads& threads) {
    node_places_.resize(cut_->nodes.size());
    threads.for_chunks(size_of(node_places_), min_points_per_chunk, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t n = begin; n < end; ++n) node_places_[n] = cut_->nodes[n].position * scene_->to_input;
        warp_->inverse(std::span(node_places_).subspan(begin, end - begin));
    });
}

// Moves the nodes beside the surface by the error of the surface there: the mean over their neighbours, weighted by the
// inverse square of the distance, and fading over one spacing.
void Restorer::follow_surface(const Fragments& pieces, Threads& threads) {
    const auto errors = [&](const std::vector<glm::dvec3>& places, const std::vector<glm::dvec3>& warped) {
        std::vector<glm::dvec3> error(places);
        threads.for_chunks(size_of(places), min_points_per_chunk, [&](uint32_t, uint32_t begin, uint32_t end) {
            warp_->apply(std::span(error).subspan(begin, end - begin));
            // To first order, the distance from the inverse warp of the point to its place.
            for (uint32_t p = begin; p < end; ++p) error[p] -= warped[p] * scene_->to_input;
        });
        return error;
    };
    const std::vector<glm::dvec3> edge_errors = errors(edge_places_, cut_->edge_positions);
    const std::vector<glm::dvec3> pierce_errors = errors(pierce_places_, cut_->pierce_positions);
    struct Sum {
        glm::dvec3 error{0.0};
        double weight = 0.0;
    };
    std::vector<Sum> sums(node_places_.size());
    for (const Piece& piece : pieces.pieces) {
        const auto points = std::span(pieces.vertex_point).subspan(piece.vertices.begin, piece.vertices.size());
        const auto positions = pieces.positions_of(piece);
        for (uint32_t t = piece.triangles.begin + piece.exterior_triangles; t < piece.triangles.end; ++t) {
            if (pieces.triangle_source[t] < piece.site) continue; // the other side of the cut
            for (int k = 0; k < 3; ++k) {
                const uint32_t from = pieces.triangles[t][k], to = pieces.triangles[t][(k + 1) % 3];
                for (const auto& [node, rim] : {std::pair(from, to), std::pair(to, from)}) {
                    const uint32_t kind = points[rim] >> 30, index = points[rim] & 0x3fffffffu;
                    if (points[node] >> 30 != VertexId::node || kind == VertexId::node) continue;
                    const glm::dvec3 d = positions[rim] - positions[node];
                    const double weight = 1.0 / std::max(glm::dot(d, d), 1e-12 * spacing_ * spacing_);
                    Sum& sum = sums[points[node] & 0x3fffffffu];
                    sum.weight += weight + 1.0 / (spacing_ * spacing_);
                    if (kind == VertexId::edge) sum.error += weight * edge_errors[index];
                    if (kind == VertexId::pierce) sum.error += weight * pierce_errors[index];
                }
            }
        }
    }
    for (size_t n = 0; n < sums.size(); ++n)
        if (sums[n].weight > 0.0) node_places_[n] += sums[n].error / sums[n].weight;
}

// Fills is_inner_.
void Restorer::find_inner_edge_points() {
    is_inner_.assign(cut_->edge_points.size(), 0);
    if (surface_->source.empty()) return;
    std::vector<uint32_t> beside(is_inner_.size(), no_index); // the input triangle on one side
    for (const exact::CrossingTriangle& crossing : cut_->crossing) {
        const uint32_t source = surface_->source[crossing.triangle];
        for (int k = 0; k < 3; ++k) {
            for (uint32_t p = crossing.first[k]; p < crossing.first[k] + crossing.count[k]; ++p) {
                is_inner_[p] = beside[p] == source ? 1 : 0;
                beside[p] = source;
            }
        }
    }
}

// Counts two triangles for each point of a piece that roughness added: by Euler's formula, that is how many a point adds
// to a closed surface. Points from `first_added` on were added by the joining.
uint64_t Restorer::count_added(const Fragments& fragments, uint32_t first_added) const {
    const auto added = [&](uint32_t point) {
        const uint32_t kind = point >> 30, index = point & 0x3fffffffu;
        if (point >= first_added) return true;
        if (kind == VertexId::edge) return index < is_inner_.size() && is_inner_[index] != 0;
        // Four cells meet in a Voronoi vertex.
        return kind == VertexId::node && index < cut_->nodes.size() && cut_->nodes[index].cells[3] == no_index;
    };
    uint64_t triangles = 0;
    for (const uint32_t point : fragments.vertex_point) triangles += added(point) ? 2 : 0;
    return triangles;
}

void Restorer::start(const Surface& surface, const exact::Cut& cut, const exact::Scene& scene, const Warp& warp,
                     double spacing, const Fragments& pieces, Threads& threads) {
    surface_ = &surface;
    cut_ = &cut;
    scene_ = &scene;
    warp_ = &warp;
    spacing_ = spacing;
    place_surface_points(threads);
    place_nodes(threads);
    find_inner_edge_points();
    if (spacing > 0.0) follow_surface(pieces, threads);
}

std::vector<glm::dvec3> Restorer::places(const Fragments& fragments, Threads& threads) const {
    std::vector<glm::dvec3> places(fragments.positions.size());
    threads.for_chunks(size_of(places), min_vertices_per_chunk, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t v = begin; v < end; ++v) {
            const uint32_t kind = fragments.vertex_point[v] >> 30, index = fragments.vertex_point[v] & 0x3fffffffu;
            const glm::dvec3& at = fragments.positions[v];
            // Merging may have added points in the middle of edges; their numbers mean nothing here.
            const auto is = [&](uint32_t k, const std::vector<glm::dvec3>& all, const glm::dvec3* positions) {
                return kind == k && index < all.size() && positions[index] * scene_->to_input == at;
            };
            if (kind == VertexId::mesh)
                places[v] = surface_->positions[index];
            else if (is(VertexId::edge, edge_places_, cut_->edge_positions.data()))
                places[v] = edge_places_[index];
            else if (is(VertexId::pierce, pierce_places_, cut_->pierce_positions.data()))
                places[v] = pierce_places_[index];
            else if (kind == VertexId::node && index < node_places_.size()
                     && cut_->nodes[index].position * scene_->to_input == at)
                places[v] = node_places_[index];
            else
                places[v] = warp_->inverse(at);
        }
    });
    return places;
}

// Joins the triangles of one piece after the other.
class Restorer::Joiner {
  public:
    Joiner(const TriangleMesh& input, const Surface& surface, std::span<const uint32_t> parts_of_source, double spacing)
        : input_(input), surface_(surface), parts_of_source_(parts_of_source), spacing_(spacing) {}

    // Appends the joined piece to `out`. New points have the number no_index.
    void join(const Fragments& from, const Piece& piece, Fragments& out);

  private:
    struct Group { // the parts of one input triangle
        uint32_t source;
        uint32_t begin, end;                       // into order_
        bool kept = false;                         // the parts stay as they are
        uint32_t joined_begin = 0, joined_end = 0; // into joined_
    };

    void find_groups(const Fragments& from, const Piece& piece);
    void find_droppable(const Fragments& from, const Piece& piece);
    bool join_group(const Fragments& from, const Piece& piece, Group& group);
    bool triangulate_polygon(const Fragments& from, const Piece& piece, const Triangle& source);
    void keep(std::span<const Triangle> triangles, Group& group);
    void trace_border(std::span<const Triangle> triangles, const Group& group);
    void find_repeated_edges(const Fragments& from, const Piece& piece);
    bool lengthen_repeated_edges();
    bool keep_open_groups(std::span<const Triangle> triangles);
    void split_repeated_diagonals(const Fragments& from, const Piece& piece);
    [[nodiscard]] bool is_divided(const Fragments& from, const Piece& piece, uint32_t t) const {
        return parts_of_source_[surface_.source[from.triangle_source[piece.triangles.begin + t]]] > 1;
    }

    const TriangleMesh& input_;
    const Surface& surface_;
    std::span<const uint32_t> parts_of_source_;
    double spacing_; // of points inside polygons

    std::vector<uint32_t> order_; // exterior triangles of the piece, those of a divided input triangle by source
    std::vector<Group> groups_;
    std::vector<uint8_t> droppable_; // per vertex of the piece
    std::vector<Triangle> joined_;
    std::vector<std::array<uint32_t, 4>> edges_; // lower end, upper end, start, end
    std::vector<std::array<uint32_t, 2>> border_;
    std::vector<uint8_t> used_;
    std::vector<Loop> loops_;
    std::vector<glm::dvec2> flat_;
    std::vector<glm::dvec3> added_; // positions of new vertices
    struct Shortened {              // an edge of a border from which vertices were dropped
        Edge ends;
        uint32_t dropped; // one of them, the lowest
    };
    std::vector<Shortened> shortened_;
    std::vector<Edge> new_edges_, repeated_, open_;
    std::vector<uint32_t> number_;
    Triangulator triangulator_;
    InteriorPoints interior_points_;
    std::vector<uint32_t> numbers_; // per point of flat_: its vertex
    std::vector<Triangle> triangles_;
    std::vector<InteriorPoints::Normals> no_normals_;
};

// Fills order_ and groups_. Triangles that were not divided form no group and come first.
void Restorer::Joiner::find_groups(const Fragments& from, const Piece& piece) {
    order_.clear();
    groups_.clear();
    const auto source = [&](uint32_t t) { return surface_.source[from.triangle_source[piece.triangles.begin + t]]; };
    for (uint32_t t = 0; t < piece.exterior_triangles; ++t)
        if (is_divided(from, piece, t)) order_.push_back(t);
    std::stable_sort(order_.begin(), order_.end(), [&](uint32_t a, uint32_t b) { return source(a) < source(b); });
    for (uint32_t k = 0; k < order_.size(); ++k) {
        if (groups_.empty() || groups_.back().source != source(order_[k])) groups_.push_back({source(order_[k]), k, k});
        groups_.back().end = k + 1;
    }
}

// A vertex can be dropped if a division made it and no cut touches it.
void Restorer::Joiner::find_droppable(const Fragments& from, const Piece& piece) {
    const size_t first_new = input_.positions.size();
    droppable_.assign(piece.vertices.size(), 0);
    for (uint32_t v = 0; v < droppable_.size(); ++v) {
        const uint32_t point = from.vertex_point[piece.vertices.begin + v];
        droppable_[v] = point >> 30 == VertexId::mesh && point >= first_new ? 1 : 0;
    }
    const auto triangles = from.triangles_of(piece);
    for (const Triangle& t : triangles.subspan(piece.exterior_triangles))
        droppable_[t.x] = droppable_[t.y] = droppable_[t.z] = 0;
}

void Restorer::Joiner::keep(std::span<const Triangle> triangles, Group& group) {
    group.kept = true;
    for (uint32_t k = group.begin; k < group.end; ++k) {
        const Triangle& t = triangles[order_[k]];
        droppable_[t.x] = droppable_[t.y] = droppable_[t.z] = 0;
    }
}

// Fills loops_ with the border of a group, without droppable vertices.
void Restorer::Joiner::trace_border(std::span<const Triangle> triangles, const Group& group) {
    edges_.clear();
    for (uint32_t k = group.begin; k < group.end; ++k) {
        const Triangle& t = triangles[order_[k]];
        for (int m = 0; m < 3; ++m) {
            const uint32_t a = t[m], b = t[(m + 1) % 3];
            edges_.push_back({std::min(a, b), std::max(a, b), a, b});
        }
    }
    std::sort(edges_.begin(), edges_.end());
    border_.clear();
    for (size_t k = 0; k < edges_.size(); ++k) {
        const bool paired = k + 1 < edges_.size() && edges_[k][0] == edges_[k + 1][0]
                            && edges_[k][1] == edges_[k + 1][1] && edges_[k][2] != edges_[k + 1][2];
        if (paired)
            ++k;
        else
            border_.push_back({edges_[k][2], edges_[k][3]});
    }
    std::sort(border_.begin(), border_.end());
    used_.assign(border_.size(), 0);
    loops_.clear();
    for (size_t first = 0; first < border_.size(); ++first) {
        if (used_[first]) continue;
        Loop& loop = loops_.emplace_back();
        uint32_t dropped = no_index, dropped_at_start = no_index;
        for (size_t at = first;;) {
            used_[at] = 1;
            const auto [from, to] = border_[at];
            if (droppable_[from]) {
                dropped = std::min(dropped, from);
            } else {
                if (dropped != no_index && !loop.empty())
                    shortened_.push_back({edge_between(loop.back(), from), dropped});
                if (loop.empty()) dropped_at_start = dropped;
                dropped = no_index;
                loop.push_back(from);
            }
            at = std::lower_bound(border_.begin(), border_.end(), std::array<uint32_t, 2>{to, 0}) - border_.begin();
            while (at < border_.size() && border_[at][0] == to && used_[at]) ++at;
            if (at == border_.size() || border_[at][0] != to) break;
        }
        dropped = std::min(dropped, dropped_at_start);
        if (dropped != no_index && !loop.empty())
            shortened_.push_back({edge_between(loop.back(), loop.front()), dropped});
    }
}

// Triangulates the polygon of loops_, which lies on an input triangle, with points inside. Without them a border of many
// points would leave thin triangles across the polygon, and the next rough cut a point on each of these: triangles
// would become smaller with every cut of a piece. Returns false where the border is not simple.
bool Restorer::Joiner::triangulate_polygon(const Fragments& from, const Piece& piece, const Triangle& source) {
    // Lengths in the plane are true here, so that points can be placed at equal distances.
    const glm::dvec3 &a = input_.positions[source.x], &b = input_.positions[source.y], &c = input_.positions[source.z];
    const glm::dvec3 x = glm::normalize(b - a), z = glm::normalize(glm::cross(b - a, c - a)), y = glm::cross(z, x);
    if (!std::isfinite(glm::dot(z, z))) return false;
    numbers_.clear();
    flat_.clear();
    for (Loop& loop : loops_) {
        for (uint32_t& v : loop) {
            const glm::dvec3 p = from.positions[piece.vertices.begin + v] - a;
            flat_.push_back({glm::dot(p, x), glm::dot(p, y)});
            numbers_.push_back(v);
            v = size_of(flat_) - 1;
        }
    }
    const Triangulation& done = triangulator_.run(flat_, loops_);
    if (done.forced_ears > 0) return false;
    const size_t border = flat_.size();
    triangles_.assign(done.triangles.begin(), done.triangles.end());
    no_normals_.assign(border, {});
    interior_points_.run(loops_, spacing_, no_normals_, flat_, triangles_);
    for (size_t k = border; k < flat_.size(); ++k) {
        numbers_.push_back(piece.vertices.size() + size_of(added_));
        added_.push_back(a + flat_[k].x * x + flat_[k].y * y);
    }
    for (const Triangle& t : triangles_) joined_.push_back({numbers_[t.x], numbers_[t.y], numbers_[t.z]});
    return true;
}

// Triangulates a group. Returns false where its border is not simple.
bool Restorer::Joiner::join_group(const Fragments& from, const Piece& piece, Group& group) {
    trace_border(from.triangles_of(piece), group);
    for (const Loop& loop : loops_)
        if (loop.size() < 3) return false;
    const Triangle& source = input_.triangles[group.source];
    group.joined_begin = size_of(joined_);
    if (loops_.size() == 1 && loops_[0].size() == 3) {
        Loop& loop = loops_[0]; // a triangle that no cut crosses begins at its first corner again
        const auto first = std::find_if(loop.begin(), loop.end(), [&](uint32_t v) {
            return from.vertex_point[piece.vertices.begin + v] == source.x;
        });
        if (first != loop.end()) std::rotate(loop.begin(), first, loop.end());
        joined_.push_back({loop[0], loop[1], loop[2]});
    } else if (!triangulate_polygon(from, piece, source)) {
        return false;
    }
    group.joined_end = size_of(joined_);
    return true;
}

// Fills repeated_ with the edges between two points that more than two triangles would have: a new edge of a joined
// triangle may have both ends on the border of a cut, and the cap may have an edge between them, too. Fills open_ with
// those that one triangle would have: where a sheet without volume has merged with a piece, the parts of a triangle may
// lie on each other, and their border is not that of a polygon.
void Restorer::Joiner::find_repeated_edges(const Fragments& from, const Piece& piece) {
    used_.assign(piece.vertices.size() + added_.size(), 0); // vertices with a new edge
    for (const Shortened& edge : shortened_) used_[edge.ends[0]] = used_[edge.ends[1]] = 1;
    for (const Group& group : groups_) {
        if (group.kept || group.joined_end - group.joined_begin < 2) continue;
        for (uint32_t k = group.joined_begin; k < group.joined_end; ++k)
            for (int m = 0; m < 3; ++m) used_[joined_[k][m]] = 1;
    }
    new_edges_.clear();
    const auto add = [&](const Triangle& t) {
        for (int m = 0; m < 3; ++m)
            if (used_[t[m]] && used_[t[(m + 1) % 3]]) new_edges_.push_back(edge_between(t[m], t[(m + 1) % 3]));
    };
    const auto triangles = from.triangles_of(piece);
    for (uint32_t t = 0; t < piece.exterior_triangles; ++t)
        if (!is_divided(from, piece, t)) add(triangles[t]);
    for (const Triangle& t : triangles.subspan(piece.exterior_triangles)) add(t);
    for (const Group& group : groups_) {
        if (group.kept)
            for (uint32_t k = group.begin; k < group.end; ++k) add(triangles[order_[k]]);
        else
            for (uint32_t k = group.joined_begin; k < group.joined_end; ++k) add(joined_[k]);
    }
    std::sort(new_edges_.begin(), new_edges_.end());
    repeated_.clear();
    open_.clear();
    for (size_t k = 0, end = 0; k < new_edges_.size(); k = end) {
        while (end < new_edges_.size() && new_edges_[end] == new_edges_[k]) ++end;
        if (end - k > 2) repeated_.push_back(new_edges_[k]);
        if (end - k == 1) open_.push_back(new_edges_[k]);
    }
}

// Leaves the parts of those triangles as they are whose joined triangles have open edges. Returns whether there are any.
bool Restorer::Joiner::keep_open_groups(std::span<const Triangle> triangles) {
    if (open_.empty()) return false;
    const auto has_open_edge = [&](const Triangle& t) {
        for (int m = 0; m < 3; ++m)
            if (std::binary_search(open_.begin(), open_.end(), edge_between(t[m], t[(m + 1) % 3]))) return true;
        return false;
    };
    bool any = false;
    for (Group& group : groups_) {
        const auto first = joined_.begin() + group.joined_begin, last = joined_.begin() + group.joined_end;
        if (group.kept || std::none_of(first, last, has_open_edge)) continue;
        keep(triangles, group);
        any = true;
    }
    return any;
}

// Brings back a vertex of each repeated edge from which vertices were dropped. Returns whether there is such an edge.
bool Restorer::Joiner::lengthen_repeated_edges() {
    bool any = false;
    for (const Shortened& edge : shortened_) {
        if (!std::binary_search(repeated_.begin(), repeated_.end(), edge.ends)) continue;
        droppable_[edge.dropped] = 0;
        any = true;
    }
    return any;
}

// Halves the diagonals of joined triangles that are repeated edges.
void Restorer::Joiner::split_repeated_diagonals(const Fragments& from, const Piece& piece) {
    if (repeated_.empty()) return;
    const auto position = [&](uint32_t v) {
        return v < piece.vertices.size() ? from.positions[piece.vertices.begin + v] : added_[v - piece.vertices.size()];
    };
    std::vector<Triangle> split;
    for (Group& group : groups_) {
        if (group.kept) continue;
        std::vector<Triangle> work(joined_.begin() + group.joined_begin, joined_.begin() + group.joined_end);
        for (const Edge& edge : repeated_) {
            uint32_t middle = no_index;
            const size_t count = work.size();
            for (size_t t = 0; t < count; ++t) {
                for (int m = 0; m < 3; ++m) {
                    const int next = (m + 1) % 3;
                    if (edge_between(work[t][m], work[t][next]) != edge) continue;
                    // Only a diagonal, which two triangles of the group share.
                    const auto holds = [&](const Triangle& other) {
                        for (int n = 0; n < 3; ++n)
                            if (other[n] == work[t][next] && other[(n + 1) % 3] == work[t][m]) return true;
                        return false;
                    };
                    if (middle == no_index && std::none_of(work.begin(), work.end(), holds)) break;
                    if (middle == no_index) {
                        middle = piece.vertices.size() + size_of(added_);
                        added_.push_back(0.5 * (position(edge[0]) + position(edge[1])));
                    }
                    Triangle half = work[t];
                    half[m] = middle;
                    work[t][next] = middle;
                    work.push_back(half);
                    break;
                }
            }
        }
        group.joined_begin = size_of(split);
        split.insert(split.end(), work.begin(), work.end());
        group.joined_end = size_of(split);
    }
    joined_ = split;
}

void Restorer::Joiner::join(const Fragments& from, const Piece& piece, Fragments& out) {
    const auto triangles = from.triangles_of(piece);
    find_groups(from, piece);
    find_droppable(from, piece);
    // Keeping the parts of one triangle brings back vertices that its neighbours had dropped.
    for (bool changed = true; changed;) {
        changed = false;
        joined_.clear();
        added_.clear();
        shortened_.clear();
        for (Group& group : groups_) {
            if (group.kept || join_group(from, piece, group)) continue;
            keep(triangles, group);
            changed = true;
        }
        if (changed) continue;
        find_repeated_edges(from, piece);
        changed = keep_open_groups(triangles) || lengthen_repeated_edges();
    }
    split_repeated_diagonals(from, piece);

    Piece result = piece;
    result.vertices.begin = size_of(out.positions);
    result.triangles.begin = size_of(out.triangles);
    const auto source_of = [&](uint32_t t) { return from.triangle_source[piece.triangles.begin + t]; };
    const auto emit = [&](const Triangle& t, uint32_t source) {
        out.triangles.push_back(t);
        out.triangle_source.push_back(source);
    };
    for (uint32_t t = 0; t < piece.exterior_triangles; ++t)
        if (!is_divided(from, piece, t)) emit(triangles[t], surface_.source[source_of(t)]);
    for (const Group& group : groups_) {
        if (group.kept)
            for (uint32_t k = group.begin; k < group.end; ++k) emit(triangles[order_[k]], group.source);
        else
            for (uint32_t k = group.joined_begin; k < group.joined_end; ++k) emit(joined_[k], group.source);
    }
    result.exterior_triangles = size_of(out.triangles) - result.triangles.begin;
    for (uint32_t t = piece.exterior_triangles; t < triangles.size(); ++t) emit(triangles[t], source_of(t));
    result.triangles.end = size_of(out.triangles);

    number_.assign(piece.vertices.size() + added_.size(), no_index);
    for (uint32_t t = result.triangles.begin; t < result.triangles.end; ++t)
        for (const uint32_t v : {out.triangles[t].x, out.triangles[t].y, out.triangles[t].z}) number_[v] = 0;
    uint32_t count = 0;
    for (uint32_t v = 0; v < number_.size(); ++v) {
        if (number_[v] == no_index) continue;
        number_[v] = count++;
        const bool is_old = v < piece.vertices.size();
        out.positions.push_back(is_old ? from.positions[piece.vertices.begin + v] : added_[v - piece.vertices.size()]);
        out.vertex_point.push_back(is_old ? from.vertex_point[piece.vertices.begin + v] : no_index);
    }
    for (uint32_t t = result.triangles.begin; t < result.triangles.end; ++t) {
        Triangle& c = out.triangles[t];
        c = {number_[c.x], number_[c.y], number_[c.z]};
    }
    result.vertices.end = size_of(out.positions);
    out.pieces.push_back(result);
}

void Restorer::join_triangles(const TriangleMesh& input, Threads& threads, Fragments& fragments) {
    uint32_t next_point = 0;
    for (const uint32_t point : fragments.vertex_point) next_point = std::max(next_point, point + 1);
    if (surface_->source.empty()) {
        fragments.rough_triangles = count_added(fragments, next_point);
        return;
    }
    std::vector<uint32_t> parts_of_source(input.triangles.size(), 0);
    for (const uint32_t source : surface_->source) ++parts_of_source[source];
    const uint32_t pieces = size_of(fragments.pieces);
    std::vector<Fragments> parts(threads.chunks(pieces, 1));
    threads.for_chunks(pieces, 1, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        Joiner joiner(input, *surface_, parts_of_source, 2.0 * spacing_);
        for (uint32_t p = begin; p < end; ++p) joiner.join(fragments, fragments.pieces[p], parts[chunk]);
    });
    Fragments joined;
    const uint32_t first_new = size_of(input.positions);
    uint32_t next_added = next_point + size_of(surface_->positions) - first_new;
    for (Fragments& part : parts) {
        for (uint32_t& point : part.vertex_point) {
            if (point == no_index)
                point = next_added++;
            else if (point >> 30 == VertexId::mesh && point >= first_new)
                point = next_point + point - first_new;
        }
        const uint32_t vertices = size_of(joined.positions), triangles = size_of(joined.triangles);
        for (Piece piece : part.pieces) {
            piece.vertices = {piece.vertices.begin + vertices, piece.vertices.end + vertices};
            piece.triangles = {piece.triangles.begin + triangles, piece.triangles.end + triangles};
            joined.pieces.push_back(piece);
        }
        append_range(part.positions, {0, size_of(part.positions)}, joined.positions);
        append_range(part.vertex_point, {0, size_of(part.vertex_point)}, joined.vertex_point);
        append_range(part.triangles, {0, size_of(part.triangles)}, joined.triangles);
        append_range(part.triangle_source, {0, size_of(part.triangle_source)}, joined.triangle_source);
    }
    joined.bonds = std::move(fragments.bonds);
    joined.timings = std::move(fragments.timings);
    joined.rough_triangles = count_added(joined, next_point);
    fragments = std::move(joined);
}

} // namespace brittle::fracture::rough

#include "fracture/exact/clip.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "fracture/classifier.h"

namespace brittle::fracture::exact {

namespace {

constexpr uint32_t min_triangles_per_chunk = 256;
constexpr double well_conditioned = 1e7; // as in edges.cpp

bool even(uint32_t a, uint32_t b, uint32_t c) {
    return (a < b && b < c) || (b < c && c < a) || (c < a && a < b);
}

// The edge of a facet that it shares with a third cell; none where the three cells do not meet.
uint32_t find_voronoi_edge(const VoronoiDiagram& diagram, uint32_t facet, SiteId third) {
    for (const VoronoiDiagram::Corner& corner : diagram.ring_of(diagram.facets[facet])) {
        if (corner.third == third) return corner.edge;
    }
    return VoronoiDiagram::none;
}

} // namespace

// Cuts one chunk of the crossing triangles.
class TriangleCutter::Worker {
  public:
    struct Context {
        const VoronoiDiagram& diagram;
        const Frames& frames;
        std::span<const glm::dvec3> positions;
        Diagram problem;
        Cut& cut;
    };

    void start(PolygonChunk& out) {
        out_ = &out;
        out.polygons.clear();
        out.corners.clear();
        pierce_points.clear();
        pierce_positions.clear();
        links.clear();
        stats = {};
    }

    void cut_simple(const CrossingTriangle& crossing, const Triangle& t, std::span<const SiteId> cell_of, Cut& cut);
    // Cuts a triangle with exactly one point inside it where three cells meet. Returns false, with nothing done, for
    // any other triangle.
    [[nodiscard]] bool cut_around_point(const Context& context, const CrossingTriangle& crossing, const Triangle& t,
                                        std::span<const SiteId> cell_of);
    void cut_general(const Context& context, const CrossingTriangle& crossing, const Triangle& t,
                     std::span<const SiteId> cell_of);

    // The new pierce points. Their ids count from 0 in each worker; TriangleCutter::run() adds the worker's base.
    std::vector<PiercePoint> pierce_points;
    std::vector<glm::dvec3> pierce_positions;
    struct Link {
        uint32_t edge_point, pierce_point;
    };
    std::vector<Link> links; // edge points with one of the new pierce points as `next`
    PredicateStats stats;
    uint32_t base = 0;

  private:
    // A line that bounds a polygon: 0 to 2 for an edge of the triangle, 3 + k for planes_[k].
    using Line = uint32_t;

    // A bisector of the current cell that may cut the triangle, with its values at the corners of the triangle.
    struct ClipPlane {
        Frames::Slot slot;
        SiteId site;
        uint32_t facet;
        glm::dvec3 at;
    };

    void begin(const Context& context, const CrossingTriangle& crossing, const Triangle& t);
    // The first corner of the third polygon of cut_around_point(). It is the corner that cut_general() starts with, so
    // that both functions give the same bits.
    enum class Start { edge, centre, unknown };
    [[nodiscard]] Start start_of_third(const Context& context, SiteId a, SiteId b, SiteId c);
    bool clip_by_cell(const Context& context, SiteId c);
    void find_planes(const Context& context, SiteId c);
    [[nodiscard]] int side(const Context& context, SiteId c, Line in, Line out, const ClipPlane& plane);
    [[nodiscard]] VertexId vertex_at(const Context& context, SiteId c, Line in, Line out);
    [[nodiscard]] VertexId pierce_point(const Context& context, SiteId c, SiteId a, SiteId b, uint32_t facet);
    [[nodiscard]] glm::dvec3 pierce_position(const Context& context, const std::array<SiteId, 3>& cells);
    void emit(const Context& context, SiteId c);
    void link(Cut& cut, uint32_t facet, VertexId from, VertexId to, const VoronoiDiagram::Facet& sites);

    PolygonChunk* out_ = nullptr;
    const CrossingTriangle* crossing_ = nullptr;
    std::array<uint32_t, 3> corners_{};
    Corners corner_positions_{};
    uint32_t first_pierce_ = 0; // of this triangle
    std::vector<SiteId> queue_;
    std::vector<ClipPlane> planes_;
    std::vector<Line> lines_, clipped_;
    std::vector<int8_t> signs_;
    std::vector<VertexId> ids_;
};

TriangleCutter::TriangleCutter() = default;
TriangleCutter::~TriangleCutter() = default;

void TriangleCutter::Worker::cut_simple(const CrossingTriangle& crossing, const Triangle& t,
                                        std::span<const SiteId> cell_of, Cut& cut) {
    // Let corner `a` be the one alone in its cell: the points lie on the edge that leaves it and on the edge that
    // returns to it.
    const uint32_t uncut = crossing.count[0] == 0 ? 0 : (crossing.count[1] == 0 ? 1 : 2);
    const uint32_t a = (uncut + 2) % 3;
    const auto corner = [&](uint32_t k) { return VertexId(VertexId::mesh, t[static_cast<int>((a + k) % 3)]); };
    const uint32_t p = crossing.first[a];           // on the edge that leaves a
    const uint32_t q = crossing.first[(a + 2) % 3]; // on the edge that returns to a
    const SiteId alone = cell_of[t[static_cast<int>(a)]], others = cell_of[t[static_cast<int>((a + 1) % 3)]];
    const VertexId id_p(VertexId::edge, p), id_q(VertexId::edge, q);

    auto& corners = out_->corners;
    const auto begin = static_cast<uint32_t>(corners.size());
    for (const VertexId id : {corner(0), id_p, id_q, id_p, corner(1), corner(2), id_q}) corners.push_back(id);
    out_->polygons.push_back({alone, crossing.triangle, begin, begin + 3});
    out_->polygons.push_back({others, crossing.triangle, begin + 3, begin + 7});
    // The polygon of the lower cell runs p -> q (alone) or q -> p (others). The cap runs in the opposite direction.
    if (alone < others)
        cut.edge_points[q].next = id_p;
    else
        cut.edge_points[p].next = id_q;
}

void TriangleCutter::Worker::begin(const Context& context, const CrossingTriangle& crossing, const Triangle& t) {
    crossing_ = &crossing;
    corners_ = {t.x, t.y, t.z};
    for (size_t k = 0; k < 3; ++k) corner_positions_[k] = context.positions[corners_[k]];
    first_pierce_ = static_cast<uint32_t>(pierce_points.size());
}

// No fourth cell meets the triangle: its polygon would meet no edge of the triangle and have a corner on each of the
// three lines from the common point to the edges, and so contain that point.
bool TriangleCutter::Worker::cut_around_point(const Context& context, const CrossingTriangle& crossing,
                                              const Triangle& t, std::span<const SiteId> cell_of) {
    constexpr std::array<uint32_t, 3> one_each{1, 1, 1};
    if ((crossing.known & Classifier::point_alone) == 0 || crossing.count != one_each) return false;
    const SiteId a = cell_of[t.x], b = cell_of[t.y], c = cell_of[t.z];
    std::array<uint32_t, 3> facets{};
    std::array<VertexId, 3> on_edge;
    for (size_t e = 0; e < 3; ++e) {
        on_edge[e] = {VertexId::edge, crossing.first[e]};
        facets[e] = context.cut.edge_points[crossing.first[e]].facet;
    }
    if (find_voronoi_edge(context.diagram, facets[0], c) == VoronoiDiagram::none) return false; // a wrong guess
    begin(context, crossing, t);
    const Start start = start_of_third(context, a, b, c);
    if (start == Start::unknown) return false;
    const VertexId centre = pierce_point(context, a, b, c, facets[0]);

    auto& corners = out_->corners;
    const auto polygon = [&](SiteId cell, const std::array<VertexId, 4>& ids) {
        const auto first = static_cast<uint32_t>(corners.size());
        corners.insert(corners.end(), ids.begin(), ids.end());
        out_->polygons.push_back({cell, crossing.triangle, first, first + 4});
    };
    const auto corner = [&](size_t k) { return VertexId(VertexId::mesh, corners_[k]); };
    polygon(a, {corner(0), on_edge[0], centre, on_edge[2]});
    polygon(b, {on_edge[0], corner(1), on_edge[1], centre});
    if (start == Start::edge)
        polygon(c, {on_edge[1], corner(2), on_edge[2], centre});
    else
        polygon(c, {centre, on_edge[1], corner(2), on_edge[2]});
    const std::array<SiteId, 3> cells{a, b, c};
    for (size_t e = 0; e < 3; ++e) { // the cap runs opposite to the polygon of the lower cell
        const bool forward = cells[e] < cells[(e + 1) % 3];
        link(context.cut, facets[e], forward ? centre : on_edge[e], forward ? on_edge[e] : centre,
             context.diagram.facets[facets[e]]);
    }
    return true;
}

// Clipping keeps the lines in their order, so the polygons of the first two cells begin with edge 0. The polygon of the
// third cell c has lost edge 0 and begins with edge 1, unless the line of b took the place of edge 0. This happens
// where b comes before a in the list of planes and the first corner, still there, lies on c's side of the bisector of
// b.
TriangleCutter::Worker::Start TriangleCutter::Worker::start_of_third(const Context& context, SiteId a, SiteId b,
                                                                     SiteId c) {
    const Frames& frames = context.frames;
    const Frames::Cell& cell = frames.cells[c];
    const glm::dvec3 y = corner_positions_[0] - cell.site;
    bool corner_is_there = true;
    for (Frames::Slot l = cell.begin; l < cell.end; ++l) {
        if (frames.site[l] == a) return Start::edge;
        const double at = frames.value_at(l, y);
        if (frames.site[l] != b) {
            corner_is_there = corner_is_there && at > cell.error;
            continue;
        }
        bool on_side_of_b = (crossing_->known & Classifier::sign_first(1)) != 0;
        if ((crossing_->known & Classifier::sign_known(1)) == 0) {
            const int certain = side1_filter(at, cell.error);
            on_side_of_b =
                (certain != 0 ? certain : side1_exact(context.problem, c, b, corner_positions_[0], stats)) < 0;
        }
        if (on_side_of_b) return Start::edge;
        return corner_is_there ? Start::centre : Start::unknown;
    }
    return Start::unknown;
}

void TriangleCutter::Worker::cut_general(const Context& context, const CrossingTriangle& crossing, const Triangle& t,
                                         std::span<const SiteId> cell_of) {
    begin(context, crossing, t);
    queue_.assign(1, cell_of[t.x]);
    for (size_t at = 0; at < queue_.size(); ++at) {
        const SiteId c = queue_[at];
        if (clip_by_cell(context, c)) emit(context, c);
    }
}

void TriangleCutter::Worker::find_planes(const Context& context, SiteId c) {
    const Frames& frames = context.frames;
    const Frames::Cell& cell = frames.cells[c];
    const glm::dvec3 y0 = corner_positions_[0] - cell.site, y1 = corner_positions_[1] - cell.site,
                     y2 = corner_positions_[2] - cell.site;
    planes_.clear();
    for (Frames::Slot l = cell.begin; l < cell.end; ++l) {
        const glm::dvec3 at(frames.value_at(l, y0), frames.value_at(l, y1), frames.value_at(l, y2));
        if (std::min({at.x, at.y, at.z}) > cell.error) continue; // the triangle is on c's side
        const uint32_t neighbour = cell.first_neighbour + (l - cell.begin);
        planes_.push_back({l, frames.site[l], context.diagram.neighbours[neighbour].facet, at});
    }
}

int TriangleCutter::Worker::side(const Context& context, SiteId c, Line in, Line out, const ClipPlane& plane) {
    const double error = context.frames.cells[c].error;
    if (in < 3 && out < 3) {
        const int certain = side1_filter(plane.at[static_cast<int>(out)], error);
        return certain != 0 ? certain : side1_exact(context.problem, c, plane.site, corner_positions_[out], stats);
    }
    if (in < 3 || out < 3) {
        const Line edge = std::min(in, out);
        const ClipPlane& a = planes_[std::max(in, out) - 3];
        const int k0 = static_cast<int>(edge), k1 = (k0 + 1) % 3;
        const int certain = side2_filter(a.at[k0], a.at[k1], plane.at[k0], plane.at[k1], error);
        return certain != 0 ? certain
                            : side2_exact(context.problem, c, a.site, plane.site, corner_positions_[edge],
                                          corner_positions_[static_cast<size_t>(k1)], stats);
    }
    const ClipPlane &a = planes_[in - 3], &b = planes_[out - 3];
    const int certain = side3_filter(a.at, b.at, plane.at, error);
    return certain != 0 ? certain
                        : side3_exact(context.problem, c, a.site, b.site, plane.site, corner_positions_, stats);
}

// Sutherland and Hodgman's clipping, on lines instead of points. Returns false where nothing is left.
bool TriangleCutter::Worker::clip_by_cell(const Context& context, SiteId c) {
    find_planes(context, c);
    lines_ = {0, 1, 2};
    for (uint32_t k = 0; k < planes_.size(); ++k) {
        const size_t n = lines_.size();
        signs_.resize(n); // of the corner before each line
        bool any_inside = false, any_outside = false;
        for (size_t m = 0; m < n; ++m) {
            const Line in = lines_[m == 0 ? n - 1 : m - 1];
            signs_[m] = static_cast<int8_t>(side(context, c, in, lines_[m], planes_[k]));
            (signs_[m] > 0 ? any_inside : any_outside) = true;
        }
        if (!any_outside) continue;
        if (!any_inside) return false;
        clipped_.clear();
        for (size_t m = 0; m < n; ++m) {
            const bool from = signs_[m] > 0, to = signs_[m + 1 == n ? 0 : m + 1] > 0;
            if (from || to) clipped_.push_back(lines_[m]);
            if (from && !to) clipped_.push_back(3 + k);
        }
        lines_.swap(clipped_);
    }
    return true;
}

VertexId TriangleCutter::Worker::vertex_at(const Context& context, SiteId c, Line in, Line out) {
    if (in < 3 && out < 3) return {VertexId::mesh, corners_[out]};
    if (in >= 3 && out >= 3) {
        const ClipPlane &a = planes_[in - 3], &b = planes_[out - 3];
        return pierce_point(context, c, a.site, b.site, a.facet);
    }
    const Line edge = std::min(in, out);
    const SiteId other = planes_[std::max(in, out) - 3].site;
    const uint32_t first = crossing_->first[edge];
    for (uint32_t p = first; p < first + crossing_->count[edge]; ++p) {
        const auto& cells = context.cut.edge_points[p].cells;
        if ((cells[0] == c && cells[1] == other) || (cells[0] == other && cells[1] == c)) {
            return {VertexId::edge, p};
        }
    }
    assert(false && "the walk along the edge missed an edge point");
    return {};
}

// Seen from outside the mesh, the cells around the point are, counter-clockwise: c, then a beyond the incoming line,
// then b beyond the outgoing line. The facet lies between c and a.
VertexId TriangleCutter::Worker::pierce_point(const Context& context, SiteId c, SiteId a, SiteId b, uint32_t facet) {
    std::array<SiteId, 3> cells{c, a, b};
    std::sort(cells.begin(), cells.end());
    for (auto p = first_pierce_; p < pierce_points.size(); ++p) {
        if (pierce_points[p].cells == cells) return {VertexId::pierce, p};
    }
    PiercePoint point{};
    point.cells = cells;
    point.triangle = crossing_->triangle;
    point.leaves = even(c, a, b) ? 1 : 0;
    point.voronoi_edge = find_voronoi_edge(context.diagram, facet, b);
    assert(point.voronoi_edge != VoronoiDiagram::none);
    pierce_points.push_back(point);
    pierce_positions.push_back(pierce_position(context, cells));
    return {VertexId::pierce, static_cast<uint32_t>(pierce_points.size()) - 1};
}

glm::dvec3 TriangleCutter::Worker::pierce_position(const Context& context, const std::array<SiteId, 3>& cells) {
    const glm::dvec3& site = context.problem.sites[cells[0]];
    const Bisector a = make_bisector(context.problem, cells[0], cells[1]);
    const Bisector b = make_bisector(context.problem, cells[0], cells[2]);
    glm::dvec3 at_a, at_b;
    double reach2 = 0.0, most = 0.0;
    for (int k = 0; k < 3; ++k) {
        const glm::dvec3 y = corner_positions_[static_cast<size_t>(k)] - site;
        at_a[k] = value(a, y);
        at_b[k] = value(b, y);
        reach2 = std::max(reach2, y.x * y.x + y.y * y.y + y.z * y.z);
        most = std::max({most, std::abs(at_a[k]), std::abs(at_b[k])});
    }
    const double error = value_error(std::max(a.length, b.length), std::sqrt(reach2), std::max(a.weight, b.weight));
    // The barycentric weights are the cofactors of the third row of det[A;B;1].
    glm::dvec3 weights(at_a.y * at_b.z - at_a.z * at_b.y, at_a.z * at_b.x - at_a.x * at_b.z,
                       at_a.x * at_b.y - at_a.y * at_b.x);
    const double sum = weights.x + weights.y + weights.z;
    if (std::abs(sum) > well_conditioned * 14.0 * most * error) {
        weights = glm::clamp(weights / sum, 0.0, 1.0);
    } else {
        weights = pierce_weights_exact(context.problem, cells[0], cells[1], cells[2], corner_positions_);
    }
    const auto& [q0, q1, q2] = corner_positions_;
    const glm::dvec3 p = q0 + (weights.y * (q1 - q0) + weights.z * (q2 - q0));
    return glm::clamp(p, glm::min(q0, glm::min(q1, q2)), glm::max(q0, glm::max(q1, q2)));
}

void TriangleCutter::Worker::link(Cut& cut, uint32_t facet, VertexId from, VertexId to,
                                  const VoronoiDiagram::Facet& sites) {
    if (from.kind() == VertexId::edge) {
        assert(cut.edge_points[from.index()].facet == facet);
        if (cut.edge_points[from.index()].facet != facet) return;
        if (to.kind() == VertexId::pierce)
            links.push_back({from.index(), to.index()});
        else
            cut.edge_points[from.index()].next = to;
    } else if (from.kind() == VertexId::pierce) {
        PiercePoint& point = pierce_points[from.index()];
        const auto place = [&](SiteId s) {
            return static_cast<uint32_t>(std::find(point.cells.begin(), point.cells.end(), s) - point.cells.begin());
        };
        point.next[pair_index(place(sites.i), place(sites.j))] = to;
    }
}

void TriangleCutter::Worker::emit(const Context& context, SiteId c) {
    const size_t n = lines_.size();
    ids_.resize(n); // the corner before each line
    for (size_t m = 0; m < n; ++m) ids_[m] = vertex_at(context, c, lines_[m == 0 ? n - 1 : m - 1], lines_[m]);
    auto& corners = out_->corners;
    const auto begin = static_cast<uint32_t>(corners.size());
    corners.insert(corners.end(), ids_.begin(), ids_.end());
    out_->polygons.push_back({c, crossing_->triangle, begin, static_cast<uint32_t>(corners.size())});
    for (size_t m = 0; m < n; ++m) {
        if (lines_[m] < 3) continue;
        const ClipPlane& plane = planes_[lines_[m] - 3];
        if (plane.site > c) { // the cap runs opposite to the polygon of the lower cell
            link(context.cut, plane.facet, ids_[m + 1 == n ? 0 : m + 1], ids_[m], context.diagram.facets[plane.facet]);
        }
        if (std::find(queue_.begin(), queue_.end(), plane.site) == queue_.end()) queue_.push_back(plane.site);
    }
}

void TriangleCutter::run(const Scene& scene, const VoronoiDiagram& diagram, const Frames& frames,
                         std::span<const Triangle> triangles, std::span<const SiteId> cell_of, Threads& threads,
                         Cut& cut, PredicateStats& stats) {
    const auto count = static_cast<uint32_t>(cut.crossing.size());
    const uint32_t parts = threads.chunks(count, min_triangles_per_chunk);
    if (workers_.size() < parts) workers_.resize(parts);
    if (cut.chunks.size() < parts) cut.chunks.resize(parts);
    cut.chunk_count = parts;
    const Worker::Context context{diagram, frames, scene.positions, scene.diagram(), cut};
    threads.for_chunks(count, min_triangles_per_chunk, [&](uint32_t k, uint32_t begin, uint32_t end) {
        Worker& worker = workers_[k];
        worker.start(cut.chunks[k]);
        for (uint32_t x = begin; x < end; ++x) {
            threads.poll(x);
            const CrossingTriangle& crossing = cut.crossing[x];
            const Triangle& t = triangles[crossing.triangle];
            if (crossing.count[0] + crossing.count[1] + crossing.count[2] == 2) {
                worker.cut_simple(crossing, t, cell_of, cut);
            } else if (!worker.cut_around_point(context, crossing, t, cell_of)) {
                worker.cut_general(context, crossing, t, cell_of);
            }
        }
    });

    uint32_t points = 0;
    for (uint32_t k = 0; k < parts; ++k) {
        workers_[k].base = points;
        points += static_cast<uint32_t>(workers_[k].pierce_points.size());
        stats += workers_[k].stats;
    }
    cut.pierce_points.resize(points);
    cut.pierce_positions.resize(points);
    threads.for_chunks(count, min_triangles_per_chunk, [&](uint32_t k, uint32_t, uint32_t) {
        Worker& worker = workers_[k];
        const uint32_t base = worker.base;
        const auto moved = [base](VertexId id) {
            return id.kind() == VertexId::pierce ? VertexId(VertexId::pierce, id.index() + base) : id;
        };
        for (PiercePoint& point : worker.pierce_points) {
            for (VertexId& next : point.next) {
                if (!next.is_none()) next = moved(next);
            }
        }
        std::copy(worker.pierce_points.begin(), worker.pierce_points.end(), cut.pierce_points.begin() + base);
        std::copy(worker.pierce_positions.begin(), worker.pierce_positions.end(), cut.pierce_positions.begin() + base);
        for (const auto& [edge_point, pierce] : worker.links) {
            cut.edge_points[edge_point].next = {VertexId::pierce, pierce + base};
        }
        if (base != 0) {
            for (VertexId& id : cut.chunks[k].corners) id = moved(id);
        }
    });
}

} // namespace brittle::fracture::exact

#include "fracture/mesh/topology.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <numeric>
#include <utility>

#include "fracture/base/union_find.h"

namespace brittle::fracture {
namespace {

// The corner at vertex v of the triangle (v, next, prev).
struct Corner {
    uint32_t next;
    uint32_t prev;
};

bool is_degenerate(const Triangle& t) {
    return t.x == t.y || t.y == t.z || t.z == t.x;
}

// The corners of all non-degenerate triangles, bucketed by vertex: those of v are corners[begin[v] .. begin[v + 1]).
// Rejected alternative: sorting the edges. Buckets take linear time, and a vertex is then checked within one or two
// cache lines.
struct CornerTable {
    std::vector<uint32_t> begin;
    std::vector<Corner> corners;

    CornerTable(size_t vertex_count, std::span<const Triangle> triangles) : begin(vertex_count + 2, 0) {
        assert(triangles.size() <= std::numeric_limits<uint32_t>::max() / 3);
        for (const Triangle& t : triangles) {
            assert(t.x < vertex_count && t.y < vertex_count && t.z < vertex_count);
            if (is_degenerate(t)) continue;
            ++begin[t.x + size_t{2}];
            ++begin[t.y + size_t{2}];
            ++begin[t.z + size_t{2}];
        }
        std::partial_sum(begin.begin(), begin.end(), begin.begin());
        corners.resize(begin.back());
        // While filling, begin serves as the write cursor, shifted by one entry; filling moves it into place.
        for (const Triangle& t : triangles) {
            if (is_degenerate(t)) continue;
            corners[begin[t.x + size_t{1}]++] = {t.y, t.z};
            corners[begin[t.y + size_t{1}]++] = {t.z, t.x};
            corners[begin[t.z + size_t{1}]++] = {t.x, t.y};
        }
        begin.pop_back();
    }

    std::span<Corner> of(size_t v) { return std::span(corners).subspan(begin[v], begin[v + 1] - begin[v]); }
};

// The count of corners above which sorting is faster than the quadratic walk of is_one_closed_fan().
constexpr size_t max_quadratic_fan = 24;

// Returns whether the corners form exactly one ring around the vertex that visits each neighbour once. Then all edges
// at the vertex are paired and its fan is single. Sorts the corners into ring order.
bool is_one_closed_fan(std::span<Corner> fan) {
    const uint32_t first = fan[0].next;
    for (size_t placed = 1; placed < fan.size(); ++placed) {
        const uint32_t wanted = fan[placed - 1].prev;
        if (wanted == first) return false;
        size_t found = 0;
        uint32_t matches = 0;
        for (size_t k = placed; k < fan.size(); ++k) {
            if (fan[k].next == wanted) {
                found = k;
                ++matches;
            }
        }
        if (matches != 1) return false;
        std::swap(fan[placed], fan[found]);
    }
    return fan.back().prev == first;
}

std::vector<uint32_t> connect_vertices(size_t vertex_count, std::span<const Triangle> triangles) {
    std::vector<uint32_t> parent(vertex_count);
    std::iota(parent.begin(), parent.end(), 0u);
    for (const Triangle& t : triangles) {
        assert(t.x < vertex_count && t.y < vertex_count && t.z < vertex_count);
        unite(parent, t.x, t.y);
        unite(parent, t.x, t.z);
    }
    return parent;
}

// Classifies a vertex that failed is_one_closed_fan(). The buffers are members, so a mesh with many bad vertices
// allocates them once.
class VertexClassifier {
  public:
    explicit VertexClassifier(TopologyReport& report) : report_(report) {}

    void classify(uint32_t v, std::span<const Corner> fan) {
        collect_neighbours(fan);
        classify_edges(v, fan);
        count_fans(v, fan);
    }

  private:
    void collect_neighbours(std::span<const Corner> fan) {
        neighbours_.clear();
        for (const Corner& c : fan) {
            neighbours_.push_back(c.next);
            neighbours_.push_back(c.prev);
        }
        std::sort(neighbours_.begin(), neighbours_.end());
        neighbours_.erase(std::unique(neighbours_.begin(), neighbours_.end()), neighbours_.end());
    }

    uint32_t slot(uint32_t neighbour) const {
        const auto at = std::lower_bound(neighbours_.begin(), neighbours_.end(), neighbour);
        return static_cast<uint32_t>(at - neighbours_.begin());
    }

    // Each edge is classified at its lower vertex only.
    void classify_edges(uint32_t v, std::span<const Corner> fan) {
        uses_.assign(neighbours_.size(), {0, 0});
        for (const Corner& c : fan) {
            ++uses_[slot(c.next)].first;
            ++uses_[slot(c.prev)].second;
        }
        for (size_t i = 0; i < neighbours_.size(); ++i) {
            if (neighbours_[i] < v) continue;
            ++report_.edges;
            const auto [out, in] = uses_[i];
            const glm::uvec2 edge(v, neighbours_[i]);
            if (out + in == 1) {
                ++report_.open_edges;
                if (!report_.first_open_edge) report_.first_open_edge = edge;
            } else if (out + in > 2) {
                ++report_.non_manifold_edges;
                if (!report_.first_non_manifold_edge) report_.first_non_manifold_edge = edge;
            } else if (out != in) {
                ++report_.misoriented_edges;
                if (!report_.first_misoriented_edge) report_.first_misoriented_edge = edge;
            }
        }
    }

    void count_fans(uint32_t v, std::span<const Corner> fan) {
        parent_.resize(neighbours_.size());
        std::iota(parent_.begin(), parent_.end(), 0u);
        for (const Corner& c : fan) unite(parent_, slot(c.next), slot(c.prev));
        size_t fans = 0;
        for (uint32_t i = 0; i < parent_.size(); ++i) fans += parent_[i] == i;
        if (fans < 2) return;
        ++report_.non_manifold_vertices;
        if (report_.some_non_manifold_vertices.size() < TopologyReport::max_listed_vertices)
            report_.some_non_manifold_vertices.push_back(v);
        if (!report_.first_non_manifold_vertex) report_.first_non_manifold_vertex = v;
    }

    TopologyReport& report_;
    std::vector<uint32_t> neighbours_;
    std::vector<std::pair<uint32_t, uint32_t>> uses_; // per neighbour: uses of the edge, outward and inward
    std::vector<uint32_t> parent_;
};

std::string count_of(uint64_t count, const char* singular, const char* plural) {
    return std::to_string(count) + ' ' + (count == 1 ? singular : plural);
}

std::string between(const glm::uvec2& edge) {
    return ", the first between vertices " + std::to_string(edge.x) + " and " + std::to_string(edge.y);
}

} // namespace

TopologyReport check_topology(size_t vertex_count, std::span<const Triangle> triangles) {
    TopologyReport report;
    report.triangles = triangles.size();
    for (size_t i = 0; i < triangles.size(); ++i) {
        if (!is_degenerate(triangles[i])) continue;
        if (report.degenerate_triangles++ == 0) report.first_degenerate_triangle = static_cast<uint32_t>(i);
    }

    const std::vector<uint32_t> parent = connect_vertices(vertex_count, triangles);
    // A root is an unused vertex or the lowest vertex of a component; used roots count the components.
    std::vector<uint8_t> used(vertex_count, 0);
    for (const Triangle& t : triangles) used[t.x] = used[t.y] = used[t.z] = 1;
    for (size_t v = 0; v < vertex_count; ++v) {
        report.vertices += used[v];
        report.components += used[v] && parent[v] == v;
    }

    CornerTable table(vertex_count, triangles);
    VertexClassifier classifier(report);
    for (uint32_t v = 0; v < vertex_count; ++v) {
        const std::span<Corner> fan = table.of(v);
        if (fan.empty()) continue;
        if (fan.size() <= max_quadratic_fan && is_one_closed_fan(fan)) {
            for (const Corner& c : fan) report.edges += c.next > v;
        } else {
            classifier.classify(v, fan);
        }
    }
    return report;
}

std::string describe(const TopologyReport& report) {
    std::vector<std::string> faults; // gravest first; only the first is located
    const auto add = [&](uint64_t count, const char* singular, const char* plural, auto&& where) {
        if (count == 0) return;
        faults.push_back(count_of(count, singular, plural) + (faults.empty() ? where() : std::string()));
    };
    add(report.open_edges, "open edge", "open edges", [&] { return between(*report.first_open_edge); });
    add(report.non_manifold_edges, "edge used by three triangles or more", "edges used by three triangles or more",
        [&] { return between(*report.first_non_manifold_edge); });
    add(report.misoriented_edges, "edge whose two triangles face opposite ways",
        "edges whose two triangles face opposite ways", [&] { return between(*report.first_misoriented_edge); });
    add(report.degenerate_triangles, "triangle that names a vertex twice", "triangles that name a vertex twice",
        [&] { return ", the first is triangle " + std::to_string(*report.first_degenerate_triangle); });
    add(report.non_manifold_vertices, "vertex where separate parts of the surface touch",
        "vertices where separate parts of the surface touch",
        [&] { return ", the first is vertex " + std::to_string(*report.first_non_manifold_vertex); });

    std::string sentence;
    for (size_t i = 0; i < faults.size(); ++i) {
        if (i == 1) sentence += "; also ";
        if (i > 1) sentence += i + 1 == faults.size() ? " and " : ", ";
        sentence += faults[i];
    }
    return sentence;
}

Status status_of(const TopologyReport& report) {
    assert(!report.manifold());
    if (report.open_edges > 0) return Status::not_closed;
    if (report.non_manifold_edges > 0) return Status::non_manifold;
    if (report.misoriented_edges > 0) return Status::not_oriented;
    if (report.degenerate_triangles > 0) return Status::invalid_mesh;
    return Status::non_manifold;
}

std::vector<uint32_t> triangle_components(size_t vertex_count, std::span<const Triangle> triangles) {
    std::vector<uint32_t> parent = connect_vertices(vertex_count, triangles);
    constexpr uint32_t unnumbered = std::numeric_limits<uint32_t>::max();
    std::vector<uint32_t> number(vertex_count, unnumbered);
    std::vector<uint32_t> component(triangles.size());
    uint32_t count = 0;
    for (size_t i = 0; i < triangles.size(); ++i) {
        uint32_t& n = number[root_of(parent, triangles[i].x)];
        if (n == unnumbered) n = count++;
        component[i] = n;
    }
    return component;
}

} // namespace brittle::fracture

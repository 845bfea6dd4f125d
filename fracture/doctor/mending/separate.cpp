// Separates parts that only touch: in edges of more than two triangles, and in vertices with several fans.
#include <algorithm>
#include <numeric>
#include <utility>

#include "fracture/doctor/mending/edge_order.h"
#include "fracture/doctor/mending/steps.h"

namespace brittle::fracture::mending {
namespace {

// The sides of two triangles that form one edge of the surface.
struct Pair {
    uint32_t a, b; // corners
};

// Pairs the triangles around an edge. Solid begins at a triangle that runs backward and ends at one that runs forward;
// where several solids overlap, these match like brackets.
void pair_brackets(const TriangleMesh& mesh, std::span<const EdgeUse> uses, std::vector<Pair>& pairs) {
    const std::vector<uint32_t> order = around_edge(mesh, uses);
    std::vector<uint8_t> paired(uses.size(), 0);
    std::vector<uint32_t> begun;
    for (size_t k = 0; k < 2 * order.size(); ++k) { // twice around, because the order has an arbitrary start
        const uint32_t use = order[k % order.size()];
        if (paired[use]) continue;
        if (!uses[use].forward) {
            if (k < order.size()) begun.push_back(use);
        } else if (!begun.empty()) {
            pairs.push_back({uses[begun.back()].corner, uses[use].corner});
            paired[begun.back()] = paired[use] = 1;
            begun.pop_back();
        }
    }
}

class Separator {
  public:
    explicit Separator(Work& work) : work_(work), table_(work.mesh.triangles) {}

    bool run() {
        find_pairs();
        const bool split = split_fans();
        const bool halved = halve_edges();
        return split || halved;
    }

  private:
    void find_pairs() {
        for (size_t e = 0; e < table_.size(); ++e) {
            const auto uses = table_[e];
            if (uses.size() > 2) {
                pair_brackets(work_.mesh, uses, pairs_);
                crowded_.push_back(e);
            } else if (uses.size() == 2 && uses[0].forward != uses[1].forward) {
                pairs_.push_back({uses[0].corner, uses[1].corner});
            }
        }
    }

    // Splits vertices with several fans. A fan is a set of corners at a vertex, connected over pairs. Where all fans
    // are closed the first one keeps the vertex, otherwise the open ones do: they need a weld or a fill next, not a
    // copy.
    bool split_fans() {
        const size_t corners = 3 * work_.mesh.triangles.size();
        std::vector<uint32_t> parent(corners);
        std::iota(parent.begin(), parent.end(), 0u);
        std::vector<uint8_t> is_paired(corners, 0);
        for (const Pair& pair : pairs_) {
            unite(parent, pair.a, next_corner(pair.b));
            unite(parent, next_corner(pair.a), pair.b);
            is_paired[pair.a] = is_paired[pair.b] = 1;
        }
        std::vector<uint8_t> is_open(corners, 0); // per root
        for (uint32_t c = 0; c < corners; ++c) {
            if (is_paired[c]) continue;
            is_open[root_of(parent, c)] = is_open[root_of(parent, next_corner(c))] = 1;
        }
        std::vector<uint32_t> keeper(work_.mesh.positions.size(),
                                     no_index); // the fan that keeps a vertex, or `corners` for all open fans
        for (uint32_t c = 0; c < corners; ++c) {
            const uint32_t v = vertex_at(work_.mesh, c), fan = root_of(parent, c);
            if (is_open[fan])
                keeper[v] = static_cast<uint32_t>(corners);
            else if (keeper[v] == no_index)
                keeper[v] = fan;
        }
        std::vector<uint32_t> vertex_of(corners, no_index); // per root
        bool any = false;
        for (uint32_t c = 0; c < corners; ++c) {
            const uint32_t fan = root_of(parent, c);
            const uint32_t v = vertex_at(work_.mesh, c); // unchanged so far: each corner is renamed once
            if (vertex_of[fan] == no_index) {
                const bool keeps = keeper[v] == fan || is_open[fan];
                vertex_of[fan] = keeps ? v : work_.copy_vertex(v);
                if (!keeps) work_.report.split_vertices.add(work_.origin[v]);
                any = any || !keeps;
            }
            work_.mesh.triangles[c / 3][static_cast<int>(c % 3)] = vertex_of[fan];
        }
        for (const size_t e : crowded_) {
            const EdgeUse& first = table_[e][0];
            const bool apart = std::any_of(table_[e].begin(), table_[e].end(),
                                           [&](const EdgeUse& use) { return ends(use.corner) != ends(first.corner); });
            if (apart) work_.report.split_edges.add(work_.origin[first.low]);
        }
        return any;
    }

    [[nodiscard]] std::pair<uint32_t, uint32_t> ends(uint32_t corner) const {
        const uint32_t a = vertex_at(work_.mesh, corner), b = vertex_at(work_.mesh, next_corner(corner));
        return {std::min(a, b), std::max(a, b)};
    }

    // Halves edges. Two edges of the surface can have the same ends although each end has one fan: the first keeps
    // them, and each other one gets a vertex in the middle. A triangle is cut once per round.
    bool halve_edges() {
        if (crowded_.empty()) return false;
        std::vector<std::pair<std::pair<uint32_t, uint32_t>, Pair>> by_ends;
        std::vector<uint8_t> in_crowd(3 * work_.mesh.triangles.size(), 0);
        for (const size_t e : crowded_)
            for (const EdgeUse& use : table_[e]) in_crowd[use.corner] = 1;
        for (const Pair& pair : pairs_)
            if (in_crowd[pair.a]) by_ends.push_back({ends(pair.a), pair});
        std::sort(by_ends.begin(), by_ends.end(), [](const auto& x, const auto& y) {
            return x.first != y.first ? x.first < y.first : x.second.a < y.second.a;
        });
        std::vector<uint8_t> cut(work_.mesh.triangles.size(), 0);
        bool any = false;
        for (size_t k = 1; k < by_ends.size(); ++k) {
            const auto& [ends, pair] = by_ends[k];
            if (ends != by_ends[k - 1].first || cut[pair.a / 3] || cut[pair.b / 3]) continue;
            const uint32_t middle = work_.copy_vertex(ends.first);
            work_.mesh.positions[middle] =
                0.5 * work_.mesh.positions[ends.first] + 0.5 * work_.mesh.positions[ends.second];
            work_.report.halved_edges.add(work_.origin[ends.first]);
            for (const uint32_t corner : {pair.a, pair.b}) {
                cut[corner / 3] = 1;
                const Triangle whole = work_.mesh.triangles[corner / 3];
                const int from = static_cast<int>(corner % 3), to = (from + 1) % 3;
                Triangle rest = whole;
                rest[from] = middle;
                work_.mesh.triangles[corner / 3][to] = middle;
                work_.append(rest, work_.source[corner / 3], work_.turned[corner / 3] != 0);
            }
            any = true;
        }
        return any;
    }

    Work& work_;
    EdgeTable table_; // of the mesh before the changes
    std::vector<Pair> pairs_;
    std::vector<size_t> crowded_; // edges of more than two triangles
};

} // namespace

bool separate(Work& work) {
    return Separator(work).run();
}

} // namespace brittle::fracture::mending

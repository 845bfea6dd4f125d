#include "fracture/repair.h"

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <vector>

namespace brittle::fracture {
namespace {

// An undirected edge and how often it is used in each direction.
struct Edge {
    int forward = 0; // from the lower vertex index to the higher
    int backward = 0;

    [[nodiscard]] bool joins() const { return forward + backward == 2; }
    [[nodiscard]] bool paired() const { return forward == 1 && backward == 1; }
};

struct EdgeTable {
    std::vector<Edge> edges;
    std::vector<uint32_t> of_corner; // the edge from corner k of triangle t to the next one, at 3 t + k
};

struct Patch {
    std::vector<uint32_t> triangles;
    bool misoriented = false;
};

EdgeTable edge_table(const std::vector<Triangle>& triangles) {
    // Corners sorted by the ends of their edges, lower end first.
    struct Use {
        uint64_t ends;
        uint32_t corner;
        bool forward;
    };
    std::vector<Use> uses;
    uses.reserve(triangles.size() * 3);
    for (const Triangle& t : triangles) {
        for (int k = 0; k < 3; ++k) {
            const uint32_t from = t[k];
            const uint32_t to = t[(k + 1) % 3];
            const uint64_t ends = uint64_t{std::min(from, to)} << 32 | std::max(from, to);
            uses.push_back({ends, static_cast<uint32_t>(uses.size()), from < to});
        }
    }
    std::sort(uses.begin(), uses.end(), [](const Use& a, const Use& b) { return a.ends < b.ends; });

    EdgeTable table;
    table.of_corner.resize(uses.size());
    for (size_t k = 0; k < uses.size(); ++k) {
        if (k == 0 || uses[k].ends != uses[k - 1].ends) table.edges.emplace_back();
        Edge& edge = table.edges.back();
        ++(uses[k].forward ? edge.forward : edge.backward);
        table.of_corner[uses[k].corner] = static_cast<uint32_t>(table.edges.size() - 1);
    }
    return table;
}

// Connected over edges that are used exactly twice.
std::vector<Patch> find_patches(size_t triangle_count, const EdgeTable& table) {
    std::vector<uint32_t> parent(triangle_count);
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](uint32_t t) {
        while (parent[t] != t) t = parent[t] = parent[parent[t]];
        return t;
    };
    constexpr uint32_t none = ~0u;
    std::vector<uint32_t> first_triangle(table.edges.size(), none);
    for (uint32_t corner = 0; corner < table.of_corner.size(); ++corner) {
        const uint32_t edge = table.of_corner[corner];
        if (!table.edges[edge].joins()) continue;
        if (first_triangle[edge] == none) {
            first_triangle[edge] = corner / 3;
        } else {
            const uint32_t a = root(first_triangle[edge]);
            const uint32_t b = root(corner / 3);
            parent[std::max(a, b)] = std::min(a, b);
        }
    }

    std::vector<Patch> patches;
    std::vector<uint32_t> patch_of(triangle_count, none);
    for (uint32_t t = 0; t < triangle_count; ++t) {
        const uint32_t r = root(t);
        if (patch_of[r] == none) {
            patch_of[r] = static_cast<uint32_t>(patches.size());
            patches.emplace_back();
        }
        Patch& patch = patches[patch_of[r]];
        patch.triangles.push_back(t);
        for (uint32_t k = 0; k < 3; ++k) {
            const Edge& edge = table.edges[table.of_corner[3 * t + k]];
            patch.misoriented = patch.misoriented || (edge.joins() && !edge.paired());
        }
    }
    return patches;
}

class PatchRemover {
  public:
    explicit PatchRemover(const TriangleMesh& mesh) : mesh_(mesh), table_(edge_table(mesh.triangles)) {
        for (const Edge& edge : table_.edges) joined_.push_back(edge.joins());
    }

    Repair run() {
        std::vector<Patch> patches = find_patches(mesh_.triangles.size(), table_);
        std::sort(patches.begin(), patches.end(), [](const Patch& a, const Patch& b) {
            if (a.misoriented != b.misoriented) return a.misoriented;
            if (a.triangles.size() != b.triangles.size()) return a.triangles.size() < b.triangles.size();
            return a.triangles.front() > b.triangles.front();
        });
        Repair repair{{mesh_.positions, {}}, 0, 0};
        std::vector<bool> removed(mesh_.triangles.size(), false);
        for (const Patch& patch : patches) {
            if (!remove_if_spare(patch)) continue;
            for (const uint32_t t : patch.triangles) removed[t] = true;
            repair.removed_triangles += static_cast<uint32_t>(patch.triangles.size());
            ++repair.removed_patches;
        }
        for (size_t t = 0; t < removed.size(); ++t) {
            if (!removed[t]) repair.mesh.triangles.push_back(mesh_.triangles[t]);
        }
        return repair;
    }

  private:
    // Takes the patch's uses off the counts, and puts them back where it is not spare.
    bool remove_if_spare(const Patch& patch) {
        std::vector<uint32_t> rim; // a rim edge that the patch itself uses twice appears twice
        for (const uint32_t t : patch.triangles) {
            for (uint32_t k = 0; k < 3; ++k) {
                const uint32_t edge = table_.of_corner[3 * t + k];
                if (!joined_[edge]) rim.push_back(edge);
            }
        }
        std::sort(rim.begin(), rim.end());
        if (rim.empty() || std::adjacent_find(rim.begin(), rim.end()) != rim.end()) return false;

        const int before = imbalance(rim);
        count(patch, -1);
        const bool covered = std::all_of(rim.begin(), rim.end(), [&](uint32_t edge) {
            return table_.edges[edge].forward > 0 && table_.edges[edge].backward > 0;
        });
        if (covered && imbalance(rim) < before) return true;
        count(patch, +1);
        return false;
    }

    [[nodiscard]] int imbalance(const std::vector<uint32_t>& rim) const {
        int sum = 0;
        for (const uint32_t edge : rim)
            sum += std::abs(table_.edges[edge].forward - table_.edges[edge].backward);
        return sum;
    }

    void count(const Patch& patch, int change) {
        for (const uint32_t t : patch.triangles) {
            for (uint32_t k = 0; k < 3; ++k) {
                Edge& edge = table_.edges[table_.of_corner[3 * t + k]];
                const Triangle& triangle = mesh_.triangles[t];
                const bool forward = triangle[static_cast<int>(k)] < triangle[static_cast<int>((k + 1) % 3)];
                (forward ? edge.forward : edge.backward) += change;
            }
        }
    }

    const TriangleMesh& mesh_;
    EdgeTable table_;          // its counts are of the triangles not yet removed
    std::vector<bool> joined_; // the edges inside patches
};

} // namespace

Repair remove_spare_patches(const TriangleMesh& mesh) {
    return PatchRemover(mesh).run();
}

} // namespace brittle::fracture

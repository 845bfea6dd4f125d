#include "fracture/doctor/mending/spare_patches.h"

#include <algorithm>
#include <cstdlib>
#include <numeric>

#include "fracture/doctor/mending/work.h"

namespace brittle::fracture::mending {
namespace {

// The uses of an undirected edge in each direction.
struct Edge {
    int forward = 0; // from the lower vertex to the higher
    int backward = 0;

    [[nodiscard]] bool joins() const { return forward + backward == 2; }
    [[nodiscard]] bool paired() const { return forward == 1 && backward == 1; }
};

struct Patch {
    std::vector<uint32_t> triangles;
    bool misoriented = false;
};

class PatchFinder {
  public:
    explicit PatchFinder(const TriangleMesh& mesh) : mesh_(mesh), table_(mesh.triangles), edges_(table_.size()) {
        for (size_t e = 0; e < table_.size(); ++e) {
            for (const EdgeUse& use : table_[e]) ++(use.forward ? edges_[e].forward : edges_[e].backward);
            joined_.push_back(edges_[e].joins());
        }
    }

    SparePatches run() {
        SparePatches spare{std::vector<uint8_t>(mesh_.triangles.size(), 0)};
        std::vector<Patch> patches = find_patches();
        std::sort(patches.begin(), patches.end(), [](const Patch& a, const Patch& b) {
            if (a.misoriented != b.misoriented) return a.misoriented;
            if (a.triangles.size() != b.triangles.size()) return a.triangles.size() < b.triangles.size();
            return a.triangles.front() > b.triangles.front();
        });
        for (const Patch& patch : patches) {
            if (!remove_if_spare(patch)) continue;
            for (const uint32_t t : patch.triangles) spare.is_spare[t] = 1;
            spare.triangles += static_cast<uint32_t>(patch.triangles.size());
            ++spare.patches;
        }
        return spare;
    }

  private:
    // Patches are connected over edges that are used exactly twice.
    [[nodiscard]] std::vector<Patch> find_patches() const {
        std::vector<uint32_t> parent(mesh_.triangles.size());
        std::iota(parent.begin(), parent.end(), 0u);
        for (size_t e = 0; e < table_.size(); ++e)
            if (joined_[e]) unite(parent, table_[e][0].corner / 3, table_[e][1].corner / 3);

        std::vector<Patch> patches;
        std::vector<uint32_t> patch_of(mesh_.triangles.size(), no_index);
        for (uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
            const uint32_t r = root_of(parent, t);
            if (patch_of[r] == no_index) {
                patch_of[r] = static_cast<uint32_t>(patches.size());
                patches.emplace_back();
            }
            Patch& patch = patches[patch_of[r]];
            patch.triangles.push_back(t);
            for (uint32_t k = 0; k < 3; ++k) {
                const Edge& edge = edges_[table_.of_corner(3 * t + k)];
                patch.misoriented = patch.misoriented || (edge.joins() && !edge.paired());
            }
        }
        return patches;
    }

    // Subtracts the uses of the patch from the counts, and restores them where the patch is not spare.
    bool remove_if_spare(const Patch& patch) {
        std::vector<uint32_t> rim; // an edge that the patch itself uses twice appears twice
        for (const uint32_t t : patch.triangles) {
            for (uint32_t k = 0; k < 3; ++k) {
                const uint32_t edge = table_.of_corner(3 * t + k);
                if (!joined_[edge]) rim.push_back(edge);
            }
        }
        std::sort(rim.begin(), rim.end());
        if (rim.empty() || std::adjacent_find(rim.begin(), rim.end()) != rim.end()) return false;

        const int before = imbalance(rim);
        count(patch, -1);
        const bool covered = std::all_of(rim.begin(), rim.end(), [&](uint32_t edge) {
            return edges_[edge].forward > 0 && edges_[edge].backward > 0;
        });
        if (covered && imbalance(rim) < before) return true;
        count(patch, +1);
        return false;
    }

    [[nodiscard]] int imbalance(const std::vector<uint32_t>& rim) const {
        int sum = 0;
        for (const uint32_t edge : rim) sum += std::abs(edges_[edge].forward - edges_[edge].backward);
        return sum;
    }

    void count(const Patch& patch, int change) {
        for (const uint32_t t : patch.triangles) {
            for (uint32_t corner = 3 * t; corner < 3 * t + 3; ++corner) {
                Edge& edge = edges_[table_.of_corner(corner)];
                const bool forward = vertex_at(mesh_, corner) < vertex_at(mesh_, next_corner(corner));
                (forward ? edge.forward : edge.backward) += change;
            }
        }
    }

    const TriangleMesh& mesh_;
    EdgeTable table_;
    std::vector<Edge> edges_;  // of the triangles not yet removed
    std::vector<bool> joined_; // the edges inside patches
};

} // namespace

SparePatches find_spare_patches(const TriangleMesh& mesh) {
    return PatchFinder(mesh).run();
}

} // namespace brittle::fracture::mending

// Drops degenerate and duplicate triangles.
#include <algorithm>
#include <array>
#include <numeric>

#include "fracture/doctor/mending/spare_patches.h"
#include "fracture/doctor/mending/steps.h"

namespace brittle::fracture::mending {
namespace {

// A group: all triangles with the same three vertices.
struct Group {
    std::vector<uint32_t> triangles; // ascending
};

// Whether the corners follow each other cyclically in ascending order.
bool ascends(const Triangle& t) {
    return (t.x < t.y) + (t.y < t.z) + (t.z < t.x) == 2;
}

std::vector<Group> groups_of(const std::vector<Triangle>& triangles) {
    std::vector<std::array<uint32_t, 4>> sorted; // three vertices in ascending order, then the triangle
    sorted.reserve(triangles.size());
    for (uint32_t t = 0; t < triangles.size(); ++t) {
        std::array<uint32_t, 3> c = {triangles[t].x, triangles[t].y, triangles[t].z};
        std::sort(c.begin(), c.end());
        sorted.push_back({c[0], c[1], c[2], t});
    }
    std::sort(sorted.begin(), sorted.end());
    std::vector<Group> groups;
    for (size_t begin = 0, end = 0; begin < sorted.size(); begin = end) {
        while (end < sorted.size() && std::equal(sorted[end].begin(), sorted[end].begin() + 3, sorted[begin].begin()))
            ++end;
        if (end - begin == 1) continue;
        Group group;
        for (size_t k = begin; k < end; ++k) group.triangles.push_back(sorted[k][3]);
        groups.push_back(std::move(group));
    }
    return groups;
}

// Decides about groups with both orientations. A wall between two solids is dropped with both its sides; where a
// surface exists twice, once in each orientation, one of the two must stay. So groups that are connected over edges of
// no other triangles are judged together, as a region.
class Backs {
  public:
    Backs(const std::vector<Triangle>& triangles, const std::vector<Group>& groups)
        : triangles_(triangles), groups_(groups), table_(triangles), group_of_(triangles.size(), no_index) {
        for (uint32_t g = 0; g < groups.size(); ++g)
            for (const uint32_t t : groups[g].triangles) group_of_[t] = g;
    }

    // Returns for each group the triangle that stays, or no_index.
    std::vector<uint32_t> run() {
        std::vector<uint32_t> parent(groups_.size());
        std::iota(parent.begin(), parent.end(), 0u);
        for (size_t e = 0; e < table_.size(); ++e) {
            if (others(e) > 0) continue;
            for (const EdgeUse& use : table_[e]) unite(parent, group_of(table_[e][0]), group_of(use));
        }
        struct Region {
            uint64_t open_with = 0, open_without = 0; // open edges if one layer of the region stays, and if none does
            bool is_closed = true;
        };
        std::vector<Region> regions(groups_.size()); // at the root of the region
        for (size_t e = 0; e < table_.size(); ++e) {
            std::vector<uint32_t> own; // the groups at this edge
            for (const EdgeUse& use : table_[e])
                if (group_of(use) != no_index) own.push_back(group_of(use));
            std::sort(own.begin(), own.end());
            own.erase(std::unique(own.begin(), own.end()), own.end());
            const size_t rest = others(e);
            for (size_t k = 0; k < own.size(); ++k) {
                Region& region = regions[root_of(parent, own[k])];
                const bool odd = rest == 0 ? own.size() % 2 == 1 : rest % 2 == 0;
                if (rest > 0 || k == 0) {
                    region.open_with += odd ? 1 : 0;
                    region.open_without += rest % 2;
                }
                region.is_closed = region.is_closed && !odd;
            }
        }
        std::vector<uint32_t> kept(groups_.size(), no_index);
        for (uint32_t g = 0; g < groups_.size(); ++g) {
            const Region& region = regions[root_of(parent, g)];
            if (region.open_with < region.open_without || region.is_closed) kept[g] = best(groups_[g]);
        }
        return kept;
    }

  private:
    [[nodiscard]] uint32_t group_of(const EdgeUse& use) const { return group_of_[use.corner / 3]; }

    // The number of uses of the edge by triangles without a group.
    [[nodiscard]] size_t others(size_t edge) const {
        const auto uses = table_[edge];
        return static_cast<size_t>(
            std::count_if(uses.begin(), uses.end(), [&](const EdgeUse& use) { return group_of(use) == no_index; }));
    }

    // The triangle of the group that agrees best with its neighbours; the first one where all agree equally.
    [[nodiscard]] uint32_t best(const Group& group) const {
        uint32_t best = no_index;
        int most = 0;
        for (const uint32_t t : group.triangles) {
            int agreeing = 0;
            for (uint32_t corner = 3 * t; corner < 3 * t + 3; ++corner) {
                const uint32_t edge = table_.of_corner(corner);
                const uint32_t from = triangles_[t][static_cast<int>(corner % 3)];
                for (const EdgeUse& use : table_[edge])
                    if (group_of(use) == no_index) agreeing += use.forward == (from == use.low) ? -1 : 1;
            }
            if (best != no_index && agreeing <= most) continue;
            best = t;
            most = agreeing;
        }
        return best;
    }

    const std::vector<Triangle>& triangles_;
    const std::vector<Group>& groups_;
    EdgeTable table_;
    std::vector<uint32_t> group_of_; // per triangle
};

} // namespace

bool drop_degenerate(Work& work) {
    std::vector<uint8_t> gone(work.mesh.triangles.size(), 0);
    bool any = false;
    for (uint32_t t = 0; t < gone.size(); ++t) {
        if (!is_degenerate(work.mesh.triangles[t])) continue;
        gone[t] = 1;
        any = true;
        work.report.degenerate_triangles.add(work.source[t]);
    }
    if (any) work.drop(gone);
    return any;
}

bool drop_duplicates(Work& work) {
    bool any = false;
    const auto drop_all_of = [&](const std::vector<Group>& groups, const auto& stays) {
        std::vector<uint8_t> gone(work.mesh.triangles.size(), 0);
        size_t count = 0;
        for (uint32_t g = 0; g < groups.size(); ++g) {
            for (const uint32_t t : groups[g].triangles) {
                if (stays(g, t)) continue;
                gone[t] = 1;
                ++count;
                work.report.duplicate_triangles.add(work.source[t]);
            }
        }
        if (count > 0) work.drop(gone);
        any = any || count > 0;
    };
    // Copies are dropped first, so that the surroundings of groups with both orientations exist once.
    const std::vector<Triangle>& triangles = work.mesh.triangles;
    const std::vector<Group> copies = groups_of(triangles);
    if (copies.empty()) return false;
    drop_all_of(copies, [&](uint32_t g, uint32_t t) {
        const auto& own = copies[g].triangles;
        return t == *std::find_if(own.begin(), own.end(), [&](uint32_t other) {
                   return ascends(triangles[other]) == ascends(triangles[t]);
               });
    });
    const std::vector<Group> backs = groups_of(triangles);
    if (backs.empty()) return any;
    const std::vector<uint32_t> kept = Backs(triangles, backs).run();
    drop_all_of(backs, [&](uint32_t g, uint32_t t) { return t == kept[g]; });
    return any;
}

bool drop_spare_patches(Work& work) {
    const SparePatches spare = find_spare_patches(work.mesh);
    if (spare.triangles == 0) return false;
    for (uint32_t t = 0; t < spare.is_spare.size(); ++t)
        if (spare.is_spare[t]) work.report.spare_triangles.add(work.source[t]);
    work.report.spare_patches += spare.patches;
    work.drop(spare.is_spare);
    return true;
}

} // namespace brittle::fracture::mending

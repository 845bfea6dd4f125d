// A uniform grid over the sites, to visit them roughly in order of distance from one of them.
//
// Duplicates (equal coordinates) are left out: only the lowest index of each position owns a cell.
#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/exact/predicates.h"
#include "fracture/mesh.h"

namespace brittle::fracture::exact {

class SiteGrid {
  public:
    // Reuses memory. The box decides only the resolution: sites may lie anywhere.
    void build(std::span<const glm::dvec3> sites, const Box& box);

    // False for a duplicate of a site with a lower index.
    [[nodiscard]] bool owns_cell(SiteId c) const { return owns_cell_[c] != 0; }

    struct Candidate {
        double distance2;
        SiteId site;
        friend bool operator<(const Candidate& a, const Candidate& b) {
            return a.distance2 != b.distance2 ? a.distance2 < b.distance2 : a.site < b.site;
        }
    };

    // What a site must be near to matter: within a distance of c, and within a box around it.
    struct Reach {
        double radius2;
        glm::dvec3 low, high; // relative to c
    };

    // Walks over the other sites in batches, nearest batch first; inside a batch they are sorted. Sites out
    // of reach at the time of the batch are left out.
    //
    //     SiteGrid::Walk walk(grid, sites, c, memory);
    //     while (walk.next(reach)) for (const auto& candidate : walk.batch()) ...
    class Walk {
      public:
        // `memory` is scratch that outlives the walk.
        Walk(const SiteGrid& grid, std::span<const glm::dvec3> sites, SiteId c,
             std::vector<Candidate>& memory);
        // False when no unvisited site is within reach (which may be infinite).
        bool next(const Reach& reach);
        [[nodiscard]] std::span<const Candidate> batch() const { return batch_; }

      private:
        void visit_bin(int x, int y, int z, const Reach& reach);

        const SiteGrid& grid_;
        std::span<const glm::dvec3> sites_;
        SiteId c_;
        std::vector<Candidate>& batch_;
        glm::ivec3 home_{0};
        glm::dvec3 origin_{0.0}; // the point of the grid's region nearest to c
        double slack_ = 0.0;
        int ring_ = 0;
    };

  private:
    void find_duplicates(std::span<const glm::dvec3> sites);
    [[nodiscard]] glm::ivec3 bin_of(const glm::dvec3& p) const;
    [[nodiscard]] uint32_t bin_index(int x, int y, int z) const {
        return static_cast<uint32_t>((z * bins_.y + y) * bins_.x + x);
    }

    Box region_;
    glm::ivec3 bins_{1};
    glm::dvec3 bin_size_{1.0};
    std::vector<uint8_t> owns_cell_;
    std::vector<uint32_t> bin_begin_; // bins + 1, into bin_sites_
    std::vector<SiteId> bin_sites_;
    std::vector<uint32_t> scratch_;
};

} // namespace brittle::fracture::exact

// A k-d tree over the sites, to visit them roughly in order of distance from one of them.
//
// A tree and not a grid: patterns cluster sites around an impact, and a grid whose bins fit the whole puts
// the cluster into a few of them. Duplicates (equal coordinates) are left out: only one site of each
// position owns a cell.
#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/exact/predicates.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture::exact {

class SiteTree {
  public:
    // Reuses memory. `weights` as in Diagram.
    void build(std::span<const glm::dvec3> sites, std::span<const double> weights);

    // False for a duplicate of a site with a greater weight, or an equal one and a lower index.
    [[nodiscard]] bool owns_cell(SiteId c) const { return owns_cell_[c] != 0; }

    [[nodiscard]] double greatest_weight() const { return greatest_weight_; }

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

    // Scratch of a walk, to be kept for the next one.
    struct WalkMemory {
        struct Entry {
            double distance2; // of the node's box
            uint32_t node;
        };
        std::vector<Entry> heap; // nearest first
        std::vector<Candidate> batch;
    };

    // Walks over the other sites in batches (leaves), nearest batch first; inside a batch they are sorted.
    // Sites out of reach at the time of the batch are left out.
    //
    //     SiteTree::Walk walk(tree, position_of_c, c, memory);
    //     while (walk.next(reach)) for (const auto& candidate : walk.batch()) ...
    class Walk {
      public:
        Walk(const SiteTree& tree, const glm::dvec3& position, SiteId c, WalkMemory& memory);
        // False when no unvisited site is within reach (which may be infinite).
        bool next(const Reach& reach);
        [[nodiscard]] std::span<const Candidate> batch() const { return memory_.batch; }

      private:
        void visit_leaf(uint32_t begin, uint32_t end, const Reach& reach);
        void push(uint32_t node, const Reach& reach);

        const SiteTree& tree_;
        const glm::dvec3 position_;
        const SiteId c_;
        WalkMemory& memory_;
    };

  private:
    struct Node {
        glm::dvec3 low, high; // the smallest box around its sites
        uint32_t begin, end;  // into order_
        uint32_t first_child; // the second follows it; 0 for a leaf
    };

    void find_duplicates(std::span<const glm::dvec3> sites, std::span<const double> weights);

    double greatest_weight_ = 0.0;
    std::vector<uint8_t> owns_cell_;
    std::vector<SiteId> order_;
    std::vector<glm::dvec3> positions_; // in that order
    std::vector<Node> nodes_;           // root first
    std::vector<uint32_t> slots_;       // hash table of find_duplicates()
};

} // namespace brittle::fracture::exact

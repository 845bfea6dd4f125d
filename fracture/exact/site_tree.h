// A k-d tree over the sites, which visits them roughly in order of distance from one of them.
//
// The rejected alternative is a uniform grid: patterns cluster sites around an impact, and a grid whose bins fit the
// whole box puts the cluster into a few bins. The tree omits duplicates (equal coordinates), because only one site of
// each position owns a cell.
#pragma once

#include <span>
#include <vector>

#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "fracture/exact/predicates.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture::exact {

class SiteTree {
  public:
    // Builds the tree and reuses its memory. `weights` as in Diagram.
    void build(std::span<const glm::dvec3> sites, std::span<const double> weights);

    // False for a duplicate of a site with a greater weight, or with an equal weight and a lower index.
    [[nodiscard]] bool owns_cell(SiteId c) const { return owns_cell_[c] != 0; }

    // The sites that own a cell, leaf by leaf: consecutive sites are close to each other.
    [[nodiscard]] std::span<const SiteId> order() const { return order_; }

    // Calls visit(site, position) for the sites that own a cell, leaf by leaf.
    template<class Visit>
    void visit(const Visit& visit) const {
        for (size_t k = 0; k < order_.size(); ++k) visit(order_[k], positions_[k]);
    }

    // Calls visit(site) for the sites of which rounding leaves open which one is nearest to a point. Hardly ever they are
    // more than one.
    template<class Visit>
    void visit_nearest(const glm::dvec3& point, const Visit& visit) const {
        const double most = bound_of_nearest(point);
        const auto search = [&](const auto& self, const Node& node) -> void {
            if (distance2(node, point) > most) return;
            if (node.first_child != 0) {
                self(self, nodes_[node.first_child]);
                self(self, nodes_[node.first_child + 1]);
                return;
            }
            for (uint32_t k = node.begin; k < node.end; ++k)
                if (distance2(positions_[k], point) <= most) visit(order_[k]);
        };
        search(search, nodes_[0]);
    }

    [[nodiscard]] double max_weight() const { return max_weight_; }

    struct Candidate {
        double distance2;
        SiteId site;
        friend bool operator<(const Candidate& a, const Candidate& b) {
            return a.distance2 != b.distance2 ? a.distance2 < b.distance2 : a.site < b.site;
        }
    };

    // The region in which another site can still cut the cell: within a distance of c, and within a box around it.
    struct Reach {
        double radius2;
        glm::dvec3 low, high; // relative to c
    };

    // The memory of a walk, kept for the next one.
    struct WalkMemory {
        struct Entry {
            double distance2; // squared distance to the node's box
            uint32_t node;
        };
        std::vector<Entry> nodes; // to visit, nearest last: few, so that insertion takes less time than a heap
        std::vector<Candidate> batch;
    };

    // Visits the other sites in batches (leaves), nearest batch first, each batch sorted by distance. A site outside
    // the reach that is passed for its batch is skipped.
    //
    //     SiteTree::Walk walk(tree, position_of_c, c, memory);
    //     while (walk.next(reach)) for (const auto& candidate : walk.batch()) ...
    class Walk {
      public:
        Walk(const SiteTree& tree, const glm::dvec3& position, SiteId c, WalkMemory& memory);
        // Returns false when no unvisited site is within reach. The reach may be infinite.
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
        glm::dvec3 low, high; // bounding box of its sites
        uint32_t begin, end;  // into order_
        uint32_t first_child; // the second child follows it; 0 for a leaf
    };

    void find_duplicates(std::span<const glm::dvec3> sites, std::span<const double> weights);
    // Squared distances round monotonically: that of a node's box is at most that of each of its sites.
    [[nodiscard]] static double distance2(const Node& node, const glm::dvec3& point) {
        const glm::dvec3 gap = glm::max(glm::max(node.low - point, point - node.high), glm::dvec3(0.0));
        return gap.x * gap.x + gap.y * gap.y + gap.z * gap.z;
    }
    [[nodiscard]] static double distance2(const glm::dvec3& position, const glm::dvec3& point) {
        const glm::dvec3 d = position - point;
        return d.x * d.x + d.y * d.y + d.z * d.z;
    }
    // The rounded squared distance that no nearest site exceeds.
    [[nodiscard]] double bound_of_nearest(const glm::dvec3& point) const;

    double max_weight_ = 0.0;
    std::vector<uint8_t> owns_cell_;
    std::vector<SiteId> order_;
    std::vector<glm::dvec3> positions_; // in the order of order_
    std::vector<Node> nodes_;           // root first
    std::vector<uint32_t> slots_;       // hash table of find_duplicates()
};

} // namespace brittle::fracture::exact

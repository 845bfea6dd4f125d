// The data of an ear clipper: the nodes of a ring, a grid of its reflex nodes, and a set of edges. Internal to
// triangulate.cpp. All reuse their memory for the next ring.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/vec2.hpp>

#include "fracture/triangulation/loop_nesting.h"

namespace brittle::fracture::triangulation {

// A set of undirected edges between point indices, as a growing hash table with open addressing.
class EdgeSet {
  public:
    void clear() { // keeps the memory but not the size: resetting a large table for each small region would be slow
        slots_.clear();
        size_ = 0;
    }
    void insert(uint32_t a, uint32_t b) {
        if (2 * (size_ + 1) > slots_.size()) grow();
        uint64_t& slot = slots_[find(key(a, b))];
        size_ += slot == empty;
        slot = key(a, b);
    }
    [[nodiscard]] bool contains(uint32_t a, uint32_t b) const {
        return !slots_.empty() && slots_[find(key(a, b))] != empty;
    }

  private:
    static constexpr uint64_t empty = std::numeric_limits<uint64_t>::max();

    static uint64_t key(uint32_t a, uint32_t b) { return static_cast<uint64_t>(std::min(a, b)) << 32 | std::max(a, b); }
    [[nodiscard]] size_t find(uint64_t wanted) const {
        const size_t mask = slots_.size() - 1;
        size_t at = static_cast<size_t>((wanted * 0x9e3779b97f4a7c15ull) >> 32) & mask;
        while (slots_[at] != empty && slots_[at] != wanted) at = (at + 1) & mask;
        return at;
    }
    void grow() {
        slots_.swap(old_);
        slots_.assign(std::max<size_t>(64, old_.size() * 2), empty);
        for (const uint64_t k : old_) {
            if (k != empty) slots_[find(k)] = k;
        }
    }

    std::vector<uint64_t> slots_, old_;
    size_t size_ = 0;
};

// A corner of the ring. A point has several nodes at both ends of a bridge and where loops touch.
struct Node {
    glm::dvec2 p{0.0};
    uint32_t id = 0;
    uint32_t prev = no_index;
    uint32_t next = no_index;
    uint32_t outer = no_index;   // the other side of the edge to next: no_index, a half-edge of a triangle, or a bridge
    uint32_t waiting = no_index; // head of the list of nodes whose ear this node blocks
    bool reflex = false;         // whether the interior angle is 180 degrees or more
    bool queued = false;
    bool cut = false;
};

struct Wait {
    uint32_t node;
    uint32_t next;
};

// The reflex nodes in a uniform grid, for the query which of them lie in the box of a triangle. Nodes that are no
// longer reflex are skipped; rebuilding the grid after half of them are gone drops them.
class ReflexGrid {
  public:
    void build(const std::vector<Node>& nodes) {
        members_.clear();
        late_.clear();
        glm::dvec2 low(0.0), high(0.0);
        for (uint32_t i = 0; i < nodes.size(); ++i) {
            if (nodes[i].cut || !nodes[i].reflex) continue;
            low = members_.empty() ? nodes[i].p : glm::min(low, nodes[i].p);
            high = members_.empty() ? nodes[i].p : glm::max(high, nodes[i].p);
            members_.push_back(i);
        }
        live_ = built_ = members_.size();
        // A linear scan is faster for few nodes.
        side_ = live_ < 48 ? 1 : std::min(1024u, static_cast<uint32_t>(2.0 * std::sqrt(static_cast<double>(live_))));
        origin_ = low;
        const glm::dvec2 size = high - low;
        per_unit_ = {size.x > 0.0 ? side_ / size.x : 0.0, size.y > 0.0 ? side_ / size.y : 0.0};
        begin_.assign(size_t{side_} * side_ + 1, 0);
        for (const uint32_t i : members_) ++begin_[cell(nodes[i].p) + 1];
        std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
        sorted_.resize(members_.size());
        cursor_.assign(begin_.begin(), begin_.end() - 1);
        for (const uint32_t i : members_) sorted_[cursor_[cell(nodes[i].p)]++] = i;
    }

    void remove() { --live_; }
    // Only a forced cut turns a convex node reflex.
    void add(uint32_t node) {
        late_.push_back(node);
        ++live_;
    }
    [[nodiscard]] bool is_stale() const { return (built_ >= 48 && live_ * 2 < built_) || late_.size() > 64; }

    // Returns the first reflex node in the box for which accept() is true, or no_index.
    template<class Accept>
    uint32_t find(const glm::dvec2& low, const glm::dvec2& high, Accept&& accept) const {
        for (const uint32_t i : late_) {
            if (accept(i)) return i;
        }
        const uint32_t x0 = column(low.x), x1 = column(high.x);
        const uint32_t y0 = row(low.y), y1 = row(high.y);
        for (uint32_t y = y0; y <= y1; ++y) {
            const size_t base = size_t{y} * side_;
            for (uint32_t k = begin_[base + x0]; k < begin_[base + x1 + 1]; ++k) {
                if (accept(sorted_[k])) return sorted_[k];
            }
        }
        return no_index;
    }

  private:
    // NaN gives the first cell.
    [[nodiscard]] uint32_t clamp_cell(double at) const {
        if (!(at > 0.0)) return 0;
        return at >= side_ ? side_ - 1 : static_cast<uint32_t>(at);
    }
    [[nodiscard]] uint32_t column(double x) const { return clamp_cell((x - origin_.x) * per_unit_.x); }
    [[nodiscard]] uint32_t row(double y) const { return clamp_cell((y - origin_.y) * per_unit_.y); }
    [[nodiscard]] size_t cell(const glm::dvec2& p) const { return size_t{row(p.y)} * side_ + column(p.x); }

    std::vector<uint32_t> members_, begin_, cursor_, sorted_, late_;
    glm::dvec2 origin_{0.0}, per_unit_{0.0};
    uint32_t side_ = 1;
    size_t live_ = 0, built_ = 0;
};

} // namespace brittle::fracture::triangulation

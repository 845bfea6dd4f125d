// Splits the loops of a region at points that they visit twice, and nests them: finds the outer loop of each hole.
// Internal to triangulate.cpp. Reuses its memory for the next region.
#pragma once

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/arithmetic/plane_predicates.h"
#include "fracture/triangulation/triangulate.h"

namespace brittle::fracture::triangulation {

inline bool lexicographically_less(const glm::dvec2& a, const glm::dvec2& b) {
    return a.x < b.x || (a.x == b.x && a.y < b.y);
}

inline bool on_segment(const glm::dvec2& p, const glm::dvec2& a, const glm::dvec2& b) {
    return p.x >= std::min(a.x, b.x) && p.x <= std::max(a.x, b.x) && p.y >= std::min(a.y, b.y)
           && p.y <= std::max(a.y, b.y) && orientation(a, b, p) == 0.0;
}

struct LoopInfo {
    std::vector<uint32_t> ids;
    double area = 0.0; // twice the signed area
    glm::dvec2 low{0.0}, high{0.0};
    uint32_t hole_of = no_index; // the outer loop to which this hole is bridged; no_index for an outer loop
};

enum class Side { outside, boundary, inside };

class Nesting {
  public:
    void run(std::span<const glm::dvec2> points, std::span<const Loop> loops) {
        points_ = points;
        count_ = 0;
        if (position_.size() < points.size()) position_.resize(points.size(), no_index);
        for (const Loop& loop : loops) {
            assert(loop.size() >= 3);
            split(loop);
        }
        for (LoopInfo& loop : all()) measure(loop);
        if (count_ > 1) nest();
    }

    [[nodiscard]] std::span<const LoopInfo> loops() const { return {loops_.data(), count_}; }

  private:
    // Splits a loop that visits a point twice into loops that touch there. Parts of fewer than three points (there and
    // back again) bound no area and their edges cancel.
    void split(const Loop& loop) {
        path_.clear(); // position_ is the inverse of path_ and has no other entries
        for (const uint32_t id : loop) {
            const uint32_t at = position_[id];
            if (at == no_index) {
                position_[id] = static_cast<uint32_t>(path_.size());
                path_.push_back(id);
                continue;
            }
            keep(std::span(path_).subspan(at));
            for (size_t k = at + 1; k < path_.size(); ++k) position_[path_[k]] = no_index;
            path_.resize(at + 1);
        }
        keep(path_);
        for (const uint32_t id : path_) position_[id] = no_index;
    }

    void keep(std::span<const uint32_t> ids) {
        if (ids.size() < 3) return;
        if (loops_.size() == count_) loops_.emplace_back();
        LoopInfo& info = loops_[count_++];
        info.ids.assign(ids.begin(), ids.end());
        info.area = 0.0;
        info.hole_of = no_index;
    }

    void measure(LoopInfo& loop) const {
        const glm::dvec2 origin = points_[loop.ids[0]];
        loop.low = loop.high = origin;
        glm::dvec2 previous = points_[loop.ids.back()] - origin;
        for (const uint32_t id : loop.ids) {
            const glm::dvec2 current = points_[id] - origin;
            loop.area += previous.x * current.y - previous.y * current.x;
            loop.low = glm::min(loop.low, points_[id]);
            loop.high = glm::max(loop.high, points_[id]);
            previous = current;
        }
        if (!std::isfinite(loop.area)) loop.area = 0.0;
    }

    // Nests the loops by containment. Along a path of the containment tree, loops match like parentheses: a loop either
    // closes the innermost open loop of the opposite direction, and is then its hole, or opens. This also matches
    // islands in holes, layers over layers (self-intersecting input) and inside-out input, whose outermost loops run
    // clockwise.
    void nest() {
        order_.resize(count_);
        std::iota(order_.begin(), order_.end(), 0u);
        std::sort(order_.begin(), order_.end(), [&](uint32_t a, uint32_t b) {
            const double area_a = std::abs(loops_[a].area), area_b = std::abs(loops_[b].area);
            return area_a > area_b || (area_a == area_b && a < b);
        });
        innermost_open_.assign(count_, no_index);
        open_around_.assign(count_, no_index);
        for (size_t k = 0; k < order_.size(); ++k) {
            LoopInfo& loop = loops_[order_[k]];
            if (loop.area == 0.0) break; // the remaining loops bound no area: each is an outer loop
            uint32_t top = no_index;
            for (size_t j = k; j-- > 0;) {
                if (!contains(loops_[order_[j]], loop)) continue;
                top = innermost_open_[order_[j]];
                break;
            }
            if (top != no_index && (loops_[top].area > 0.0) != (loop.area > 0.0)) {
                loop.hole_of = top;
                innermost_open_[order_[k]] = open_around_[top];
            } else {
                open_around_[order_[k]] = top;
                innermost_open_[order_[k]] = order_[k];
            }
        }
    }

    [[nodiscard]] Side locate(const glm::dvec2& p, const LoopInfo& loop) const {
        bool inside = false;
        glm::dvec2 a = points_[loop.ids.back()];
        for (const uint32_t id : loop.ids) {
            const glm::dvec2 b = points_[id];
            if (on_segment(p, a, b)) return Side::boundary;
            if ((a.y > p.y) != (b.y > p.y) && (orientation(a, b, p) > 0.0) == (b.y > a.y)) inside = !inside;
            a = b;
        }
        return inside ? Side::inside : Side::outside;
    }

    // Returns whether `outer` contains `inner`. Loops may touch, so the first vertex off the boundary of `outer`
    // decides, then the first midpoint of an edge.
    [[nodiscard]] bool contains(const LoopInfo& outer, const LoopInfo& inner) const {
        if (inner.low.x < outer.low.x || inner.low.y < outer.low.y || inner.high.x > outer.high.x
            || inner.high.y > outer.high.y) {
            return false;
        }
        for (const uint32_t id : inner.ids) {
            const Side side = locate(points_[id], outer);
            if (side != Side::boundary) return side == Side::inside;
        }
        for (size_t k = 0; k < inner.ids.size(); ++k) {
            const glm::dvec2 a = points_[inner.ids[k]];
            const glm::dvec2 b = points_[inner.ids[(k + 1) % inner.ids.size()]];
            const Side side = locate((a + b) * 0.5, outer);
            if (side != Side::boundary) return side == Side::inside;
        }
        return true;
    }

    [[nodiscard]] std::span<LoopInfo> all() { return {loops_.data(), count_}; }

    std::span<const glm::dvec2> points_;
    std::vector<LoopInfo> loops_; // the first count_ entries are in use
    size_t count_ = 0;
    std::vector<uint32_t> path_;
    std::vector<uint32_t> position_;       // per point: its index in path_, or no_index
    std::vector<uint32_t> order_;          // loops by descending area
    std::vector<uint32_t> innermost_open_; // per loop: the innermost open loop around its direct interior
    std::vector<uint32_t> open_around_;    // per opening loop: the next open loop outwards
};

} // namespace brittle::fracture::triangulation

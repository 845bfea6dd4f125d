// The loops of a region, split where they visit a point twice and nested: which loop is a hole of which. Internal to
// triangulate.cpp, which cuts the ears.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/plane_predicates.h"
#include "fracture/triangulate.h"

namespace brittle::fracture::triangulation {

constexpr uint32_t none = std::numeric_limits<uint32_t>::max();

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
    uint32_t hole_of = none; // the loop whose ring this one is bridged to
};

enum class Side { outside, boundary, inside };

class Nesting {
  public:
    Nesting(std::span<const glm::dvec2> points, std::span<const Loop> loops) : points_(points) {
        for (const Loop& loop : loops) {
            assert(loop.size() >= 3);
            split(loop);
        }
        for (LoopInfo& loop : loops_) measure(loop);
        if (loops_.size() > 1) nest();
    }

    [[nodiscard]] const std::vector<LoopInfo>& loops() const { return loops_; }

  private:
    // A loop that visits a point twice is two loops that touch there. Parts of fewer than three points (there
    // and back again) bound nothing and their edges cancel.
    void split(const Loop& loop) {
        std::unordered_map<uint32_t, size_t> position; // on the open path
        std::vector<uint32_t> path;
        path.reserve(loop.size());
        position.reserve(loop.size());
        for (const uint32_t id : loop) {
            const auto [at, is_new] = position.try_emplace(id, path.size());
            if (!is_new) {
                const auto begin = path.begin() + static_cast<std::ptrdiff_t>(at->second);
                keep(std::vector<uint32_t>(begin, path.end()));
                for (auto k = begin + 1; k != path.end(); ++k) position.erase(*k);
                path.erase(begin + 1, path.end());
                continue;
            }
            path.push_back(id);
        }
        keep(std::move(path));
    }

    void keep(std::vector<uint32_t>&& ids) {
        if (ids.size() < 3) return;
        LoopInfo info;
        info.ids = std::move(ids);
        loops_.push_back(std::move(info));
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

    // Along a path of the containment tree, loops match like parentheses: a loop closes the innermost open
    // one of the other direction, and is then its hole, or else opens. So islands in holes, layers over
    // layers (self-intersecting input) and inside-out input, where the outermost loops run clockwise, all
    // find their match.
    void nest() {
        std::vector<uint32_t> order(loops_.size());
        std::iota(order.begin(), order.end(), 0u);
        std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
            return std::abs(loops_[a].area) > std::abs(loops_[b].area);
        });
        std::vector<uint32_t> innermost_open(loops_.size(), none); // for what lies directly inside this loop
        std::vector<uint32_t> open_around(loops_.size(),
                                          none); // of an opening loop: the next open one outwards
        for (size_t k = 0; k < order.size(); ++k) {
            LoopInfo& loop = loops_[order[k]];
            if (loop.area == 0.0) break; // the rest of the order bounds no area: rings of their own
            uint32_t top = none;
            for (size_t j = k; j-- > 0;) {
                if (!contains(loops_[order[j]], loop)) continue;
                top = innermost_open[order[j]];
                break;
            }
            if (top != none && (loops_[top].area > 0.0) != (loop.area > 0.0)) {
                loop.hole_of = top;
                innermost_open[order[k]] = open_around[top];
            } else {
                open_around[order[k]] = top;
                innermost_open[order[k]] = order[k];
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

    // Loops may touch: the first vertex, then the first edge midpoint, off the outer boundary decides.
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

    std::span<const glm::dvec2> points_;
    std::vector<LoopInfo> loops_;
};

} // namespace brittle::fracture::triangulation

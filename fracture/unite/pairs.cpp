#include "fracture/unite/pairs.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include <glm/common.hpp>

namespace brittle::fracture::arrangement {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr FloatBox nothing{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
constexpr uint32_t min_tasks = 64; // pairs of subtrees that the threads share

FloatBox around(const FloatBox& a, const FloatBox& b) {
    FloatBox box{};
    for (size_t k = 0; k < 3; ++k) {
        box.low[k] = std::min(a.low[k], b.low[k]);
        box.high[k] = std::max(a.high[k], b.high[k]);
    }
    return box;
}

// Spreads 21 bits to every third bit.
uint64_t spread(uint64_t x) {
    x &= 0x1fffff;
    x = (x | x << 32) & 0x1f00000000ffff;
    x = (x | x << 16) & 0x1f0000ff0000ff;
    x = (x | x << 8) & 0x100f00f00f00f00f;
    x = (x | x << 4) & 0x10c30c30c30c30c3;
    return (x | x << 2) & 0x1249249249249249;
}

bool ascending(const glm::uvec2& a, const glm::uvec2& b) {
    return a.x != b.x ? a.x < b.x : a.y < b.y;
}

} // namespace

FloatBox float_box(const glm::dvec3& low, const glm::dvec3& high) {
    FloatBox box{};
    for (int k = 0; k < 3; ++k) {
        // Coordinates beyond the floats become infinite, which is further out.
        auto l = static_cast<float>(low[k]), h = static_cast<float>(high[k]);
        if (static_cast<double>(l) > low[k]) l = std::nextafter(l, -infinity);
        if (static_cast<double>(h) < high[k]) h = std::nextafter(h, infinity);
        box.low[static_cast<size_t>(k)] = l;
        box.high[static_cast<size_t>(k)] = h;
    }
    return box;
}

BoxTree::BoxTree(const TriangleMesh& mesh, std::span<const uint32_t> triangles, Threads& threads) {
    const auto count = static_cast<uint32_t>(triangles.size());
    const Box all = bounds(mesh);
    const glm::dvec3 size = all.size();
    const double scale = 2097151.0 / std::max({size.x, size.y, size.z, std::numeric_limits<double>::min()});
    std::vector<std::pair<uint64_t, uint32_t>> order(count); // curve, triangle
    threads.for_chunks(count, 4096, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t k = begin; k < end; ++k) {
            const Triangle& t = mesh.triangles[triangles[k]];
            const glm::dvec3 &a = mesh.positions[t.x], &b = mesh.positions[t.y], &c = mesh.positions[t.z];
            const glm::dvec3 middle = ((a - all.min) + (b - all.min) + (c - all.min)) * (scale / 3.0);
            order[k] = {spread(static_cast<uint64_t>(middle.x)) | spread(static_cast<uint64_t>(middle.y)) << 1
                            | spread(static_cast<uint64_t>(middle.z)) << 2,
                        triangles[k]};
        }
    });
    std::sort(order.begin(), order.end());
    triangles_.resize(count);
    boxes_.resize(count);
    const uint32_t blocks = (count + block - 1) / block;
    leaves_ = std::bit_ceil(std::max(blocks, 1u));
    nodes_.assign(2 * size_t{leaves_}, nothing);
    threads.for_chunks(blocks, 256, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t leaf = begin; leaf < end; ++leaf)
            for (uint32_t k = leaf * block; k < std::min((leaf + 1) * block, count); ++k) {
                triangles_[k] = order[k].second;
                const Triangle& t = mesh.triangles[triangles_[k]];
                const glm::dvec3 &a = mesh.positions[t.x], &b = mesh.positions[t.y], &c = mesh.positions[t.z];
                boxes_[k] = float_box(glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c)));
                nodes_[leaves_ + leaf] = around(nodes_[leaves_ + leaf], boxes_[k]);
            }
    });
    for (uint32_t node = leaves_ - 1; node > 0; --node) nodes_[node] = around(nodes_[2 * node], nodes_[2 * node + 1]);
}

// Descends into two trees at once. A tree and itself: each pair of subtrees once.
struct BoxTree::Search {
    const BoxTree &a, &b;
    const std::function<bool(uint32_t, uint32_t)>& may_meet;

    [[nodiscard]] bool is_self() const { return &a == &b; }

    // Calls visit for the pairs of subtrees below a pair, of which one at least is divided.
    template<class Visit>
    void divide(uint32_t x, uint32_t y, Visit&& visit) const {
        const bool x_ends = x >= a.leaves_, y_ends = y >= b.leaves_;
        if (is_self() && x == y) {
            visit(2 * x, 2 * x);
            visit(2 * x + 1, 2 * x + 1);
            visit(2 * x, 2 * x + 1);
        } else if (y_ends || (!x_ends && x <= y)) {
            visit(2 * x, y);
            visit(2 * x + 1, y);
        } else {
            visit(x, 2 * y);
            visit(x, 2 * y + 1);
        }
    }

    [[nodiscard]] bool are_leaves(uint32_t x, uint32_t y) const { return x >= a.leaves_ && y >= b.leaves_; }

    void run(uint32_t x, uint32_t y, std::vector<glm::uvec2>& found) const {
        if (!a.nodes_[x].meets(b.nodes_[y])) return;
        if (!are_leaves(x, y)) {
            divide(x, y, [&](uint32_t u, uint32_t v) { run(u, v, found); });
            return;
        }
        for (uint32_t i = a.first(x); i < a.last(x); ++i) {
            const FloatBox& box = a.boxes_[i];
            if (!box.meets(b.nodes_[y])) continue;
            for (uint32_t j = is_self() && x == y ? i + 1 : b.first(y); j < b.last(y); ++j) {
                if (!box.meets(b.boxes_[j])) continue;
                const uint32_t s = a.triangles_[i], t = b.triangles_[j];
                if (may_meet(s, t)) found.push_back({std::min(s, t), std::max(s, t)});
            }
        }
    }

    [[nodiscard]] std::vector<glm::uvec2> on(Threads& threads) const {
        if (a.triangles_.empty() || b.triangles_.empty()) return {};
        std::vector<glm::uvec2> tasks{{1, 1}};
        while (tasks.size() < min_tasks) {
            std::vector<glm::uvec2> finer;
            for (const glm::uvec2& task : tasks) {
                if (are_leaves(task.x, task.y))
                    finer.push_back(task);
                else
                    divide(task.x, task.y, [&](uint32_t x, uint32_t y) {
                        if (a.nodes_[x].meets(b.nodes_[y])) finer.push_back({x, y});
                    });
            }
            if (finer.size() <= tasks.size() && finer == tasks) break;
            tasks = std::move(finer);
            if (tasks.empty()) return {};
        }
        std::vector<std::vector<glm::uvec2>> found(tasks.size());
        threads.for_each(static_cast<uint32_t>(tasks.size()),
                         [&](uint32_t k) { run(tasks[k].x, tasks[k].y, found[k]); });
        std::vector<glm::uvec2> all;
        for (const std::vector<glm::uvec2>& part : found) all.insert(all.end(), part.begin(), part.end());
        std::sort(all.begin(), all.end(), ascending);
        return all;
    }
};

std::vector<glm::uvec2> BoxTree::pairs(const std::function<bool(uint32_t, uint32_t)>& may_meet,
                                       Threads& threads) const {
    return Search{*this, *this, may_meet}.on(threads);
}

std::vector<glm::uvec2> BoxTree::pairs(const BoxTree& other, const std::function<bool(uint32_t, uint32_t)>& may_meet,
                                       Threads& threads) const {
    return Search{*this, other, may_meet}.on(threads);
}

} // namespace brittle::fracture::arrangement

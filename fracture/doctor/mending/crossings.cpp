#include "fracture/doctor/mending/crossings.h"

#include <numeric>
#include <vector>

#include <glm/common.hpp>

#include "fracture/mesh/intersections.h"

namespace brittle::fracture::mending {
namespace {

std::vector<uint32_t> all_of(const TriangleMesh& mesh) {
    std::vector<uint32_t> all(mesh.triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    return all;
}

constexpr uint64_t max_pairs = 20'000'000;

bool boxes_meet(const Box& a, const Box& b) {
    for (int k = 0; k < 3; ++k)
        if (a.max[k] < b.min[k] || b.max[k] < a.min[k]) return false;
    return true;
}

Box box_of(const TriangleMesh& mesh, const Triangle& t) {
    const glm::dvec3 &a = mesh.positions[t.x], &b = mesh.positions[t.y], &c = mesh.positions[t.z];
    return {glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))};
}

} // namespace

Crossings::Crossings(const TriangleMesh& mesh) : mesh_(mesh), tree_(mesh, all_of(mesh)) {}

std::optional<uint64_t> Crossings::count(std::span<const Triangle> fill) {
    uint64_t crossings = 0;
    for (size_t i = 0; i < fill.size() && pairs_ < max_pairs; ++i) {
        const Box box = box_of(mesh_, fill[i]);
        if (tree_.root() != no_index) crossings += count_below(tree_.root(), fill[i], box);
        for (size_t j = i + 1; j < fill.size(); ++j)
            if (boxes_meet(box, box_of(mesh_, fill[j]))) crossings += compare(fill[i], fill[j]);
    }
    return pairs_ < max_pairs ? std::optional(crossings) : std::nullopt;
}

uint64_t Crossings::count_below(uint32_t node, const Triangle& t, const Box& box) {
    const TriangleTree::Node& n = tree_[node];
    if (pairs_ >= max_pairs || !boxes_meet(box, {n.min, n.max})) return 0;
    if (n.low != no_index) return count_below(n.low, t, box) + count_below(n.high, t, box);
    uint64_t crossings = 0;
    for (uint32_t k = n.begin; k < n.end; ++k) {
        const Triangle& other = mesh_.triangles[tree_.order()[k]];
        if (boxes_meet(box, box_of(mesh_, other))) crossings += compare(t, other);
    }
    return crossings;
}

uint64_t Crossings::compare(const Triangle& s, const Triangle& t) {
    ++pairs_;
    return intersect(mesh_.positions, s, t) ? 1 : 0;
}

} // namespace brittle::fracture::mending

#include "fracture/exact/site_tree.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include <glm/common.hpp>

namespace brittle::fracture::exact {

namespace {

// Fewer sites per leaf cost more steps down the tree; more sites per leaf sort more sites that are too far away.
constexpr uint32_t max_sites_per_leaf = 16;

// Two squared distances of which the greater exceeds the other by less than this factor may be equal. Each is a sum of
// squares of rounded differences: its relative error is below four times that of a number.
constexpr double nearest_rounding = 1.0 + 16.0 * std::numeric_limits<double>::epsilon();

uint64_t hash_of(const glm::dvec3& p) {
    uint64_t h = 0;
    for (int k = 0; k < 3; ++k) {
        const double x = p[k] + 0.0; // -0 equals +0
        uint64_t bits;
        std::memcpy(&bits, &x, sizeof bits);
        h = (h ^ bits) * 0x9e3779b97f4a7c15ull;
        h ^= h >> 29;
    }
    return h;
}

// Orders the nodes to visit, nearest last. Ties are broken by index, so that a walk does not depend on the order of
// insertion.
bool is_farther(const SiteTree::WalkMemory::Entry& a, const SiteTree::WalkMemory::Entry& b) {
    return a.distance2 != b.distance2 ? a.distance2 > b.distance2 : a.node > b.node;
}

} // namespace

void SiteTree::find_duplicates(std::span<const glm::dvec3> sites, std::span<const double> weights) {
    const size_t size = std::bit_ceil(2 * sites.size());
    slots_.assign(size, no_index);
    owns_cell_.assign(sites.size(), 1);
    for (uint32_t i = 0; i < sites.size(); ++i) { // in index order, so the lowest index wins
        size_t slot = hash_of(sites[i]) & (size - 1);
        while (slots_[slot] != no_index && sites[slots_[slot]] != sites[i]) slot = (slot + 1) & (size - 1);
        if (slots_[slot] == no_index) {
            slots_[slot] = i;
        } else if (!weights.empty() && weights[i] > weights[slots_[slot]]) {
            owns_cell_[slots_[slot]] = 0;
            slots_[slot] = i;
        } else {
            owns_cell_[i] = 0;
        }
    }
}

void SiteTree::build(std::span<const glm::dvec3> sites, std::span<const double> weights) {
    find_duplicates(sites, weights);
    max_weight_ = weights.empty() ? 0.0 : *std::max_element(weights.begin(), weights.end());
    order_.clear();
    for (uint32_t i = 0; i < sites.size(); ++i) {
        if (owns_cell_[i]) order_.push_back(i);
    }
    nodes_.clear();
    nodes_.push_back({{}, {}, 0, static_cast<uint32_t>(order_.size()), 0});
    for (size_t n = 0; n < nodes_.size(); ++n) { // children follow their parents
        Node& node = nodes_[n];
        node.low = node.high = sites[order_[node.begin]];
        for (uint32_t k = node.begin + 1; k < node.end; ++k) {
            node.low = glm::min(node.low, sites[order_[k]]);
            node.high = glm::max(node.high, sites[order_[k]]);
        }
        const uint32_t count = node.end - node.begin;
        if (count <= max_sites_per_leaf) continue;
        const glm::dvec3 size = node.high - node.low;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
        const auto begin = order_.begin() + node.begin;
        std::nth_element(begin, begin + count / 2, begin + count, [&](SiteId a, SiteId b) {
            return sites[a][axis] != sites[b][axis] ? sites[a][axis] < sites[b][axis] : a < b;
        });
        node.first_child = static_cast<uint32_t>(nodes_.size());
        const uint32_t middle = node.begin + count / 2;
        const Node left{{}, {}, node.begin, middle, 0}, right{{}, {}, middle, node.end, 0};
        nodes_.push_back(left);
        nodes_.push_back(right);
    }
    positions_.resize(order_.size());
    for (size_t k = 0; k < order_.size(); ++k) positions_[k] = sites[order_[k]];
}

double SiteTree::bound_of_nearest(const glm::dvec3& point) const {
    double least = std::numeric_limits<double>::infinity();
    const auto search = [&](const auto& self, uint32_t n) -> void {
        const Node& node = nodes_[n];
        if (node.first_child != 0) {
            const uint32_t first = node.first_child, second = first + 1;
            const double to_first = distance2(nodes_[first], point), to_second = distance2(nodes_[second], point);
            const bool swap = to_second < to_first;
            if (std::min(to_first, to_second) < least) self(self, swap ? second : first);
            if (std::max(to_first, to_second) < least) self(self, swap ? first : second);
            return;
        }
        for (uint32_t k = node.begin; k < node.end; ++k) least = std::min(least, distance2(positions_[k], point));
    };
    search(search, 0);
    return least * nearest_rounding + std::numeric_limits<double>::min();
}

SiteTree::Walk::Walk(const SiteTree& tree, const glm::dvec3& position, SiteId c, WalkMemory& memory)
    : tree_(tree), position_(position), c_(c), memory_(memory) {
    memory_.nodes.assign(1, {0.0, 0});
}

void SiteTree::Walk::visit_leaf(uint32_t begin, uint32_t end, const Reach& reach) {
    for (uint32_t k = begin; k < end; ++k) {
        const glm::dvec3 n = tree_.positions_[k] - position_;
        const double d2 = n.x * n.x + n.y * n.y + n.z * n.z;
        const bool near = d2 <= reach.radius2 && n.x >= reach.low.x && n.x <= reach.high.x && n.y >= reach.low.y
                          && n.y <= reach.high.y && n.z >= reach.low.z && n.z <= reach.high.z;
        if (near && tree_.order_[k] != c_) memory_.batch.push_back({d2, tree_.order_[k]});
    }
}

// Differences and squares round monotonically, so the bounds of a box hold for each site in it without slack.
void SiteTree::Walk::push(uint32_t node, const Reach& reach) {
    const glm::dvec3 low = tree_.nodes_[node].low - position_, high = tree_.nodes_[node].high - position_;
    if (low.x > reach.high.x || low.y > reach.high.y || low.z > reach.high.z || high.x < reach.low.x
        || high.y < reach.low.y || high.z < reach.low.z)
        return;
    const glm::dvec3 gap = glm::max(glm::max(low, -high), glm::dvec3(0.0));
    const double distance2 = gap.x * gap.x + gap.y * gap.y + gap.z * gap.z;
    if (distance2 > reach.radius2) return;
    std::vector<WalkMemory::Entry>& nodes = memory_.nodes;
    const WalkMemory::Entry entry{distance2, node};
    size_t at = nodes.size();
    nodes.push_back(entry);
    for (; at > 0 && is_farther(entry, nodes[at - 1]); --at) nodes[at] = nodes[at - 1];
    nodes[at] = entry;
}

bool SiteTree::Walk::next(const Reach& reach) {
    memory_.batch.clear();
    while (memory_.batch.empty()) {
        if (memory_.nodes.empty()) return false;
        const WalkMemory::Entry nearest = memory_.nodes.back();
        memory_.nodes.pop_back();
        if (nearest.distance2 > reach.radius2) return false;
        const Node& node = tree_.nodes_[nearest.node];
        if (node.first_child == 0) {
            visit_leaf(node.begin, node.end, reach);
        } else {
            push(node.first_child, reach);
            push(node.first_child + 1, reach);
        }
    }
    std::sort(memory_.batch.begin(), memory_.batch.end());
    return true;
}

} // namespace brittle::fracture::exact

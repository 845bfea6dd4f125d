#include "fracture/triangulation/ring.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <tuple>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/arithmetic/plane_predicates.h"

namespace brittle::fracture::triangulation {
namespace {

// Flag in Node::outer: the edge is one side of a bridge; the other bits are the index of the bridge.
constexpr uint32_t bridge_bit = 0x80000000u;

// The count of nodes that a forced cut compares: all of a small ring, but a bounded count of a large one, where a loop
// of n crossings would otherwise take n^2 time.
constexpr uint32_t forced_window = 256;

// The count of bridge candidates that are tested before the nearest one is taken untested; only tangled input has so
// many.
constexpr uint32_t max_bridge_tries = 1024;

// Returns whether the edge a -> b of the ring obstructs the segment from m to q, a vertex of the ring.
bool blocks(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& m, const glm::dvec2& q) {
    if (a == q || b == q) return false; // opens_towards() decides these
    if (std::max(a.x, b.x) < std::min(m.x, q.x) || std::min(a.x, b.x) > std::max(m.x, q.x)
        || std::max(a.y, b.y) < std::min(m.y, q.y) || std::min(a.y, b.y) > std::max(m.y, q.y)) {
        return false;
    }
    if (on_segment(m, a, b)) return orientation(a, b, q) <= 0.0; // the hole touches this edge
    const double side_a = orientation(m, q, a), side_b = orientation(m, q, b);
    if ((side_a > 0.0 && side_b > 0.0) || (side_a < 0.0 && side_b < 0.0)) return false;
    const double side_m = orientation(a, b, m), side_q = orientation(a, b, q);
    return !((side_m > 0.0 && side_q > 0.0) || (side_m < 0.0 && side_q < 0.0));
}

} // namespace

void Ring::start(std::span<const glm::dvec2> points, EdgeSet* edges) {
    points_ = points;
    edges_ = edges;
    nodes_.clear();
    start_ = no_index;
    count_ = 0;
    reversed_ = false;
    queue_.clear();
    head_ = 0;
    waits_.clear();
    forced_ = 0;
    vertex_tests_ = 0;
    triangles_.clear();
    bridge_half_edge_.clear();
}

void Ring::set_outer(const LoopInfo& loop) {
    reversed_ = loop.area < 0.0;
    start_ = add_loop(loop);
    count_ = static_cast<uint32_t>(loop.ids.size());
}

void Ring::bridge_holes(std::span<const LoopInfo> loops, uint32_t outer) {
    tips_.clear();
    for (const LoopInfo& hole : loops) {
        if (hole.hole_of != outer) continue;
        const uint32_t first = add_loop(hole);
        uint32_t tip = first;
        for (uint32_t i = first; i < nodes_.size(); ++i) {
            if (lexicographically_less(nodes_[tip].p, nodes_[i].p)) tip = i;
        }
        tips_.push_back(tip);
        count_ += static_cast<uint32_t>(hole.ids.size());
    }
    if (tips_.size() > 1) {
        std::stable_sort(tips_.begin(), tips_.end(),
                         [&](uint32_t a, uint32_t b) { return lexicographically_less(nodes_[b].p, nodes_[a].p); });
    }
    for (const uint32_t tip : tips_) bridge(tip, find_bridge(tip));
}

void Ring::clip() {
    triangles_.corners.reserve(count_ - 2);
    triangles_.twin.reserve(size_t{3} * (count_ - 2));
    if (!edges_ && is_convex()) {
        clip_convex();
        return;
    }
    start_clipping();
    while (count_ > 3) {
        if (head_ == queue_.size()) {
            cut_and_update(min_bad_ear());
            ++forced_;
            continue;
        }
        const uint32_t t = queue_[head_++];
        nodes_[t].queued = false;
        if (nodes_[t].cut || nodes_[t].reflex || !is_ear(t)) continue;
        if (may_join(nodes_[nodes_[t].prev], nodes_[nodes_[t].next])) {
            cut_and_update(t);
        } else {
            close_off_around(t);
        }
    }
    if (count_ == 3) cut_last(); // otherwise an edge there and back remains
}

void Ring::emit(Triangulation& out) const {
    for (const Triangle& t : triangles_.corners) {
        const uint32_t a = nodes_[t.x].id, b = nodes_[t.y].id, c = nodes_[t.z].id;
        out.triangles.push_back(reversed_ ? Triangle(a, c, b) : Triangle(a, b, c));
    }
    out.forced_ears += forced_;
    out.vertex_tests += vertex_tests_;
}

uint32_t Ring::add_loop(const LoopInfo& loop) {
    const auto first = static_cast<uint32_t>(nodes_.size());
    const auto n = static_cast<uint32_t>(loop.ids.size());
    for (uint32_t k = 0; k < n; ++k) {
        Node node;
        node.id = loop.ids[reversed_ ? n - 1 - k : k];
        node.p = points_[node.id];
        node.prev = first + (k + n - 1) % n;
        node.next = first + (k + 1) % n;
        nodes_.push_back(node);
    }
    return first;
}

double Ring::turn_at(const Node& n) const {
    return orientation(nodes_[n.prev].p, n.p, nodes_[n.next].p);
}

// --- bridges

// Returns whether p lies in the ring's interior angle at this node.
bool Ring::opens_towards(const Node& n, const glm::dvec2& p) const {
    const bool left_of_in = orientation(nodes_[n.prev].p, n.p, p) > 0.0;
    const bool left_of_out = orientation(n.p, nodes_[n.next].p, p) > 0.0;
    return turn_at(n) > 0.0 ? left_of_in && left_of_out : left_of_in || left_of_out;
}

bool Ring::is_bridge(const Node& m, const Node& q) const {
    if (q.p == m.p) return opens_towards(q, nodes_[m.next].p) || opens_towards(q, nodes_[m.prev].p);
    if (q.id == m.id || (edges_ && edges_->contains(q.id, m.id))) return false;
    if (!opens_towards(q, m.p)) return false;
    uint32_t i = start_;
    do {
        const Node& a = nodes_[i];
        if (blocks(a.p, nodes_[a.next].p, m.p, q.p)) return false;
        i = a.next;
    } while (i != start_);
    return true;
}

// Returns the nearest node of the ring that sees the hole's rightmost vertex (`tip`).
uint32_t Ring::find_bridge(uint32_t tip) {
    const Node& m = nodes_[tip];
    std::vector<std::pair<double, uint32_t>>& candidates = candidates_;
    candidates.clear();
    uint32_t i = start_;
    do {
        const glm::dvec2 d = nodes_[i].p - m.p;
        const double distance = dot(d, d);
        if (!lexicographically_less(nodes_[i].p, m.p) && std::isfinite(distance)) {
            candidates.emplace_back(distance, i);
        }
        i = nodes_[i].next;
    } while (i != start_);
    if (candidates.empty()) return start_; // the hole lies outside the ring
    std::make_heap(candidates.begin(), candidates.end(), std::greater<>());
    const uint32_t nearest = candidates.front().second;
    for (uint32_t tries = 0; tries < max_bridge_tries && !candidates.empty(); ++tries) {
        const uint32_t q = candidates.front().second;
        if (is_bridge(m, nodes_[q])) return q;
        std::pop_heap(candidates.begin(), candidates.end(), std::greater<>());
        candidates.pop_back();
    }
    return nearest;
}

void Ring::bridge(uint32_t m, uint32_t q) {
    if (nodes_[m].id == nodes_[q].id) { // the loops touch: exchange their successors, no bridge is needed
        std::swap(nodes_[m].next, nodes_[q].next);
        std::swap(nodes_[m].outer, nodes_[q].outer);
        nodes_[nodes_[m].next].prev = m;
        nodes_[nodes_[q].next].prev = q;
        return;
    }
    // q -> m -> (hole) -> m2 -> q2 -> (rest)
    const auto m2 = static_cast<uint32_t>(nodes_.size());
    const uint32_t q2 = m2 + 1;
    nodes_.push_back(nodes_[m]);
    nodes_.push_back(nodes_[q]);
    nodes_[nodes_[m2].prev].next = m2;
    nodes_[nodes_[q2].next].prev = q2;
    nodes_[m2].next = q2;
    nodes_[q2].prev = m2;
    nodes_[q].next = m;
    nodes_[m].prev = q;
    const auto token = bridge_bit | static_cast<uint32_t>(bridge_half_edge_.size());
    nodes_[q].outer = nodes_[m2].outer = token;
    bridge_half_edge_.push_back(no_index);
    if (edges_) edges_->insert(nodes_[m].id, nodes_[q].id);
    count_ += 2;
}

// --- triangles and their neighbours

// Links half-edge h with the half-edge, or with the bridge, on its other side.
void Ring::link(uint32_t h, uint32_t across) {
    if (across != no_index && (across & bridge_bit) != 0) {
        uint32_t& first = bridge_half_edge_[across & ~bridge_bit];
        across = std::exchange(first, h);
    }
    triangles_.twin[h] = across;
    if (across != no_index) triangles_.twin[across] = h;
}

// Adds the triangle of three consecutive nodes whose three edges are all edges of the ring.
void Ring::add_triangle(uint32_t a, uint32_t b, uint32_t c) {
    const auto h = static_cast<uint32_t>(triangles_.twin.size());
    triangles_.corners.emplace_back(a, b, c);
    triangles_.twin.resize(triangles_.twin.size() + 3, no_index);
    link(h, nodes_[a].outer);
    link(h + 1, nodes_[b].outer);
    link(h + 2, nodes_[c].outer);
}

// Cuts the ear at t without a test.
void Ring::cut(uint32_t t) {
    const uint32_t p = nodes_[t].prev, n = nodes_[t].next;
    const auto h = static_cast<uint32_t>(triangles_.twin.size());
    triangles_.corners.emplace_back(p, t, n);
    triangles_.twin.resize(triangles_.twin.size() + 3, no_index);
    link(h, nodes_[p].outer);
    link(h + 1, nodes_[t].outer);
    nodes_[p].outer = h + 2;
    nodes_[p].next = n;
    nodes_[n].prev = p;
    start_ = n;
    --count_;
    if (edges_) edges_->insert(nodes_[p].id, nodes_[n].id);
}

void Ring::cut_last() {
    const uint32_t a = start_, b = nodes_[a].next, c = nodes_[b].next;
    add_triangle(a, b, c);
    if (!(orientation(nodes_[a].p, nodes_[b].p, nodes_[c].p) > 0.0)) ++forced_;
}

// --- ears

// Returns whether the ring turns strictly left at every node and winds around once.
bool Ring::is_convex() const {
    uint32_t changes = 0;
    uint32_t i = start_;
    do {
        const Node& n = nodes_[i];
        if (!(turn_at(n) > 0.0)) return false;
        const bool rose = lexicographically_less(nodes_[n.prev].p, n.p);
        const bool rises = lexicographically_less(n.p, nodes_[n.next].p);
        changes += rose != rises;
        i = n.next;
    } while (i != start_);
    return changes == 2;
}

// Cuts a convex ring into a zigzag strip, which needs fewer flips than a fan.
void Ring::clip_convex() {
    uint32_t left = start_, right = nodes_[start_].next;
    for (bool cut_right = true; count_ > 3; cut_right = !cut_right) {
        if (cut_right) {
            const uint32_t next = nodes_[right].next;
            cut(right);
            right = next;
        } else {
            const uint32_t previous = nodes_[left].prev;
            cut(left);
            left = previous;
        }
    }
    cut_last();
}

void Ring::start_clipping() {
    uint32_t i = start_;
    do {
        nodes_[i].reflex = !(turn_at(nodes_[i]) > 0.0);
        if (!nodes_[i].reflex) push(i);
        i = nodes_[i].next;
    } while (i != start_);
    grid_.build(nodes_);
}

void Ring::push(uint32_t i) {
    if (nodes_[i].queued) return;
    nodes_[i].queued = true;
    queue_.push_back(i);
}

bool Ring::may_join(const Node& a, const Node& b) const {
    return a.id != b.id && !(edges_ && edges_->contains(a.id, b.id));
}

// Returns whether t is a strict ear: convex, without other vertices in the closed triangle. Only reflex vertices need a
// test (ElGindy et al.). A vertex that coincides with a corner does not block the ear, because its own sector of the
// plane is another one. A node that is not an ear is queued at the node that blocks it, so no node is tested twice in
// vain.
bool Ring::is_ear(uint32_t t) {
    const Node& tip = nodes_[t];
    const uint32_t p = tip.prev, n = tip.next;
    const glm::dvec2 a = nodes_[p].p, b = tip.p, c = nodes_[n].p;
    if (nodes_[p].id == nodes_[n].id) return false;
    const glm::dvec2 low = glm::min(a, glm::min(b, c)), high = glm::max(a, glm::max(b, c));
    const uint32_t blocker = grid_.find(low, high, [&](uint32_t r) {
        ++vertex_tests_;
        const Node& node = nodes_[r];
        if (node.cut || !node.reflex || r == p || r == n) return false;
        const glm::dvec2& x = node.p;
        if (x.x < low.x || x.x > high.x || x.y < low.y || x.y > high.y) return false;
        if (x == a || x == b || x == c) return false;
        return orientation(a, b, x) >= 0.0 && orientation(b, c, x) >= 0.0 && orientation(c, a, x) >= 0.0;
    });
    if (blocker == no_index) return true;
    waits_.push_back({t, nodes_[blocker].waiting});
    nodes_[blocker].waiting = static_cast<uint32_t>(waits_.size() - 1);
    return false;
}

void Ring::release_waiting(uint32_t blocker) {
    for (uint32_t w = std::exchange(nodes_[blocker].waiting, no_index); w != no_index; w = waits_[w].next) {
        const Node& node = nodes_[waits_[w].node];
        if (!node.cut && !node.reflex) push(waits_[w].node);
    }
}

void Ring::cut_and_update(uint32_t t) {
    const uint32_t p = nodes_[t].prev, n = nodes_[t].next;
    cut(t);
    forget(t);
    update(p);
    update(n);
    if (grid_.is_stale()) grid_.build(nodes_);
}

void Ring::forget(uint32_t i) {
    nodes_[i].cut = true;
    if (nodes_[i].reflex) grid_.remove();
    release_waiting(i);
}

void Ring::update(uint32_t i) {
    const bool was_reflex = nodes_[i].reflex;
    nodes_[i].reflex = !(turn_at(nodes_[i]) > 0.0);
    if (was_reflex && !nodes_[i].reflex) {
        grid_.remove();
        release_waiting(i);
    }
    if (!was_reflex && nodes_[i].reflex) grid_.add(i);
    if (!nodes_[i].reflex) push(i);
}

// Handles a strict ear whose third edge already exists. Where loops touch in several vertices the ring pinches off a
// triangle, f -> b -> c -> g, where f and g are nodes of one point. Emits that triangle with its three ring edges; f
// takes over the successor of g.
void Ring::close_off_around(uint32_t t) {
    const uint32_t p = nodes_[t].prev, n = nodes_[t].next;
    uint32_t f = no_index;
    if (nodes_[nodes_[p].prev].id == nodes_[n].id) {
        f = nodes_[p].prev;
    } else if (nodes_[nodes_[n].next].id == nodes_[p].id) {
        f = p;
    } else {
        return; // its neighbours' ears or a forced cut resolve this node
    }
    const uint32_t b = nodes_[f].next, c = nodes_[b].next, g = nodes_[c].next;
    add_triangle(f, b, c);
    nodes_[f].outer = nodes_[g].outer;
    nodes_[f].next = nodes_[g].next;
    nodes_[nodes_[f].next].prev = f;
    start_ = f;
    count_ -= 3;
    for (const uint32_t i : {b, c, g}) forget(i);
    if (count_ >= 3) update(f);
}

// Returns the best node to cut in a ring without strict ears: a ring of zero area or one that crosses itself. The order
// of preference: neighbours that may be joined; a triangle that is not inside out; a small triangle (flat ones first,
// and among them those whose tip lies between its neighbours). Neighbours with equal ids are cut only as a last resort.
uint32_t Ring::min_bad_ear() const {
    using Badness = std::tuple<int, bool, double, bool>;
    uint32_t best = no_index;
    Badness least;
    uint32_t i = start_;
    for (uint32_t k = 0; k < std::min(count_, forced_window); ++k, i = nodes_[i].next) {
        const Node& t = nodes_[i];
        const Node& p = nodes_[t.prev];
        const Node& n = nodes_[t.next];
        const double turn = turn_at(t);
        const int clash = p.id == n.id ? 2 : may_join(p, n) ? 0 : 1;
        const double size = std::isfinite(turn) ? std::abs(turn) : std::numeric_limits<double>::max();
        const Badness badness{clash, turn<0.0, size, dot(p.p - t.p, n.p - t.p)> 0.0};
        if (best == no_index || badness < least) {
            best = i;
            least = badness;
        }
    }
    return best;
}

} // namespace brittle::fracture::triangulation

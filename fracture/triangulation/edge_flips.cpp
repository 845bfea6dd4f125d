#include "fracture/triangulation/edge_flips.h"

#include "fracture/arithmetic/plane_predicates.h"

namespace brittle::fracture::triangulation {
namespace {

// The sequence of flips is finite; the bound prevents quadratic time on adversarial input.
constexpr size_t max_flips_per_triangle = 32;

} // namespace

void EdgeFlips::run(std::span<const Node> nodes, RingTriangles& triangles, EdgeSet* edges, bool overlapping) {
    if (!edges && overlapping) {
        own_edges_.clear();
        for (const Triangle& t : triangles.corners) {
            for (int k = 0; k < 3; ++k) own_edges_.insert(nodes[t[k]].id, nodes[t[(k + 1) % 3]].id);
        }
        edges = &own_edges_;
    }
    const std::vector<uint32_t>& twin = triangles.twin;
    stack_.clear();
    for (uint32_t h = 0; h < twin.size(); ++h) {
        if (twin[h] != no_index && h < twin[h]) stack_.push_back(h);
    }
    size_t flips_left = max_flips_per_triangle * triangles.corners.size();
    while (!stack_.empty() && flips_left > 0) {
        const uint32_t h = stack_.back();
        stack_.pop_back();
        if (twin[h] == no_index) continue;
        const Quad q = quad_at(triangles, h);
        if (!should_flip(nodes, q, edges)) continue;
        --flips_left;
        // The old edge stays in the set: a flip too few is harmless, a repeated edge is not.
        if (flip(triangles, h, q) && edges) edges->insert(nodes[q.c].id, nodes[q.d].id);
    }
}

EdgeFlips::Quad EdgeFlips::quad_at(const RingTriangles& triangles, uint32_t h) {
    const uint32_t g = triangles.twin[h];
    const auto corner = [&](uint32_t half_edge, uint32_t step) {
        return triangles.corners[half_edge / 3][static_cast<int>((half_edge % 3 + step) % 3)];
    };
    return {corner(h, 0), corner(h, 1), corner(h, 2), corner(g, 2)};
}

bool EdgeFlips::should_flip(std::span<const Node> nodes, const Quad& q, const EdgeSet* edges) {
    const glm::dvec2 &a = nodes[q.a].p, &b = nodes[q.b].p, &c = nodes[q.c].p, &d = nodes[q.d].p;
    const bool sound = orientation(a, b, c) > 0.0 && orientation(b, a, d) > 0.0;
    if (sound && !certainly_in_circle(a, b, c, d)) return false;
    if (!(orientation(a, d, c) > 0.0 && orientation(d, b, c) > 0.0)) return false;
    const uint32_t from = nodes[q.c].id, to = nodes[q.d].id;
    return from != to && !(edges && edges->contains(from, to));
}

bool EdgeFlips::flip(RingTriangles& triangles, uint32_t h, const Quad& q) {
    std::vector<uint32_t>& twin = triangles.twin;
    const uint32_t g = twin[h];
    const auto next = [](uint32_t e) { return e - e % 3 + (e + 1) % 3; };
    const uint32_t across_bc = twin[next(h)], across_ca = twin[next(next(h))];
    const uint32_t across_ad = twin[next(g)], across_db = twin[next(next(g))];
    const uint32_t s = h / 3, t = g / 3;
    for (const uint32_t across : {across_bc, across_ca, across_ad, across_db}) {
        if (across != no_index && (across / 3 == s || across / 3 == t)) return false;
    }
    triangles.corners[s] = {q.a, q.d, q.c};
    triangles.corners[t] = {q.d, q.b, q.c};
    const auto join = [&](uint32_t e, uint32_t across) {
        twin[e] = across;
        if (across == no_index) return;
        twin[across] = e;
        stack_.push_back(e);
    };
    join(3 * s, across_ad);
    join(3 * s + 2, across_ca);
    join(3 * t, across_db);
    join(3 * t + 1, across_bc);
    twin[3 * s + 1] = 3 * t + 2;
    twin[3 * t + 2] = 3 * s + 1;
    return true;
}

} // namespace brittle::fracture::triangulation

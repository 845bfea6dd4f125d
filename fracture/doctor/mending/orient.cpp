// Orients triangles consistently, and closed parts outwards.
#include <algorithm>
#include <cmath>
#include <numeric>

#include <glm/geometric.hpp>

#include "fracture/doctor/mending/edge_order.h"
#include "fracture/doctor/mending/nesting.h"
#include "fracture/doctor/mending/steps.h"
#include "fracture/mesh/topology.h"

namespace brittle::fracture::mending {
namespace {

// The limit of fracture(): a volume above rounding, as a share of area times diagonal.
constexpr double min_volume = 1e-15;

// A union-find forest of triangles with a parity: for two triangles of one tree, whether both must be turned or exactly
// one of them.
class Agreement {
  public:
    explicit Agreement(size_t triangles) : parent_(triangles), opposed_(triangles, 0) {
        std::iota(parent_.begin(), parent_.end(), 0u);
    }

    // Returns the root, and whether the triangle is opposed to it.
    std::pair<uint32_t, uint8_t> find(uint32_t t) {
        uint32_t root = t;
        uint8_t opposed = 0;
        for (; parent_[root] != root; root = parent_[root]) opposed ^= opposed_[root];
        for (uint8_t rest = opposed; parent_[t] != root && t != root;) {
            const uint32_t next = parent_[t];
            const uint8_t own = opposed_[t];
            parent_[t] = root;
            opposed_[t] = rest;
            rest ^= own;
            t = next;
        }
        return {root, opposed};
    }

    // Joins two trees. Does nothing where both triangles are in one tree already.
    void join(uint32_t a, uint32_t b, bool opposed) {
        auto [root_a, a_opposed] = find(a);
        auto [root_b, b_opposed] = find(b);
        if (root_a == root_b) return;
        if (root_a > root_b) std::swap(root_a, root_b);
        parent_[root_b] = root_a;
        opposed_[root_b] = static_cast<uint8_t>(a_opposed ^ b_opposed ^ (opposed ? 1 : 0));
    }

  private:
    std::vector<uint32_t> parent_;
    std::vector<uint8_t> opposed_; // to the parent
};

Agreement across_pairs(const EdgeTable& table, size_t triangles) {
    Agreement agreement(triangles);
    for (size_t e = 0; e < table.size(); ++e) {
        const auto uses = table[e];
        if (uses.size() == 2)
            agreement.join(uses[0].corner / 3, uses[1].corner / 3, uses[0].forward == uses[1].forward);
    }
    return agreement;
}

// Joins triangles across edges of four triangles and more. Where both directions are used equally often, by parts that
// only touch there, their orientations stay. Otherwise solid and void must alternate around the edge.
void join_across_crowded(const TriangleMesh& mesh, const EdgeTable& table, Agreement& agreement) {
    std::vector<size_t> unequal;
    for (size_t e = 0; e < table.size(); ++e) {
        const auto uses = table[e];
        if (uses.size() < 4 || uses.size() % 2 == 1) continue;
        if (table.surplus(e) != 0)
            unequal.push_back(e);
        else
            for (const EdgeUse& use : uses) agreement.join(uses[0].corner / 3, use.corner / 3, false);
    }
    for (const size_t e : unequal) {
        const auto uses = table[e];
        const std::vector<uint32_t> order = around_edge(mesh, uses);
        for (size_t k = 0; k + 1 < order.size(); ++k) {
            const EdgeUse &a = uses[order[k]], &b = uses[order[k + 1]];
            agreement.join(a.corner / 3, b.corner / 3, a.forward == b.forward);
        }
    }
}

// Turns the smaller half of each tree; of equal halves, the one without the first triangle.
bool turn_fewer(Work& work, Agreement& agreement) {
    std::vector<int64_t> excess(work.mesh.triangles.size(),
                                0); // per root: triangles that agree with it, minus the others
    for (uint32_t t = 0; t < excess.size(); ++t) {
        const auto [root, opposed] = agreement.find(t);
        excess[root] += opposed ? -1 : 1;
    }
    bool any = false;
    for (uint32_t t = 0; t < excess.size(); ++t) {
        const auto [root, opposed] = agreement.find(t);
        if ((opposed != 0) == (excess[root] < 0)) continue;
        work.turn(t);
        any = true;
    }
    return any;
}

struct Part {
    double volume = 0.0, area = 0.0;
    bool closed = true;
};

std::vector<Part> measure(const TriangleMesh& mesh, const std::vector<uint32_t>& part_of, size_t count) {
    std::vector<Part> parts(count);
    std::vector<uint32_t> first(count, no_index);
    for (uint32_t t = 0; t < part_of.size(); ++t) {
        Part& part = parts[part_of[t]];
        if (first[part_of[t]] == no_index) first[part_of[t]] = t;
        const Triangle& c = mesh.triangles[t];
        const glm::dvec3& o = mesh.positions[mesh.triangles[first[part_of[t]]].x];
        const glm::dvec3 a = mesh.positions[c.x] - o, b = mesh.positions[c.y] - o, d = mesh.positions[c.z] - o;
        part.volume += glm::dot(a, glm::cross(b, d)) / 6.0;
        part.area += glm::length(glm::cross(b - a, d - a)) * 0.5;
    }
    if (check_topology(mesh.positions.size(), mesh.triangles).closed()) return parts; // ten times faster than the table
    const EdgeTable table(mesh.triangles);
    for (size_t e = 0; e < table.size(); ++e)
        if (table.surplus(e) != 0) parts[part_of[table[e][0].corner / 3]].closed = false;
    return parts;
}

} // namespace

bool orient_neighbours(Work& work) {
    const EdgeTable table(work.mesh.triangles);
    bool agree = true, crowded = false;
    for (size_t e = 0; e < table.size(); ++e) {
        agree = agree && table.surplus(e) == 0;
        crowded = crowded || table[e].size() > 3;
    }
    if (agree) return false;
    Agreement patches = across_pairs(table, work.mesh.triangles.size());
    const bool any = turn_fewer(work, patches);
    if (!crowded) return any;

    const EdgeTable turned(work.mesh.triangles);
    Agreement parts = across_pairs(turned, work.mesh.triangles.size());
    join_across_crowded(work.mesh, turned, parts);
    return turn_fewer(work, parts) || any;
}

bool turn_parts(Work& work, bool cavities) {
    const TriangleMesh& mesh = work.mesh;
    const std::vector<uint32_t> part_of = triangle_components(mesh.positions.size(), mesh.triangles);
    const size_t count = part_of.empty() ? 0 : *std::max_element(part_of.begin(), part_of.end()) + size_t{1};
    const std::vector<Part> parts = measure(mesh, part_of, count);
    const double diagonal = glm::length(bounds(mesh).size());
    std::vector<uint8_t> has_volume(count, 0);
    for (size_t k = 0; k < count; ++k)
        has_volume[k] = parts[k].closed && std::abs(parts[k].volume) > min_volume * parts[k].area * diagonal;
    const std::vector<uint32_t> depth = nesting_depths(mesh, part_of, has_volume);

    bool any = false;
    for (uint32_t t = 0; t < part_of.size(); ++t) {
        const uint32_t part = part_of[t];
        const bool nested = depth[part] % 2 == 1;
        if (!has_volume[part] || (parts[part].volume < 0.0) == nested || (nested && !cavities)) continue;
        work.turn(t);
        any = true;
    }
    return any;
}

} // namespace brittle::fracture::mending

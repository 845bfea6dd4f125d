#include "fracture/io/weld.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <numeric>
#include <tuple>
#include <utility>

#include "fracture/base/threads.h"
#include "fracture/base/union_find.h"
#include "fracture/mesh/manifold_check.h"
#include "fracture/mesh/topology.h"

namespace brittle::fracture {
namespace {

// Words that are equal exactly where two positions and their numbers are.
struct Key {
    uint64_t x, y, z;
    uint32_t point;
    bool operator==(const Key&) const = default;
};

Key key_of(const glm::dvec3& p, uint32_t point) {
    // Adding +0 turns -0 into +0 and changes no other value.
    return {std::bit_cast<uint64_t>(p.x + 0.0), std::bit_cast<uint64_t>(p.y + 0.0), std::bit_cast<uint64_t>(p.z + 0.0),
            point};
}

// Coordinates read as floats have zeros in their low bits, so every word is mixed first.
uint64_t mix(uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
}

uint64_t hash(const Key& key) {
    return mix(mix(mix(key.x) + key.y) + key.z + key.point);
}

// Returns for each vertex the first one with its position and number. Without numbers, positions alone count.
std::vector<uint32_t> first_of_same(const std::vector<glm::dvec3>& positions, std::span<const uint32_t> point) {
    // Open addressing with linear probing, at most half full. The result does not depend on the order of slots.
    const size_t slots = std::bit_ceil(positions.size() * 2 + 1);
    std::vector<uint32_t> table(slots, no_index);
    std::vector<uint32_t> first(positions.size());
    for (uint32_t v = 0; v < positions.size(); ++v) {
        const auto key_at = [&](uint32_t w) { return key_of(positions[w], point.empty() ? 0 : point[w]); };
        const Key key = key_at(v);
        size_t slot = hash(key) & (slots - 1);
        while (table[slot] != no_index && key_at(table[slot]) != key) slot = (slot + 1) & (slots - 1);
        if (table[slot] == no_index) table[slot] = v;
        first[v] = table[slot];
    }
    return first;
}

// Returns the mesh in which `first` replaces each vertex, without triangles that name a vertex twice and without unused
// vertices. `kept` receives the index in `mesh` of each remaining triangle.
TriangleMesh replaced(const TriangleMesh& mesh, std::span<const uint32_t> first, std::vector<uint32_t>& kept) {
    TriangleMesh result;
    result.triangles.reserve(mesh.triangles.size());
    std::vector<bool> used(mesh.positions.size(), false);
    kept.clear();
    for (const Triangle& t : mesh.triangles) {
        assert(t.x < first.size() && t.y < first.size() && t.z < first.size());
        const Triangle welded{first[t.x], first[t.y], first[t.z]};
        if (welded.x == welded.y || welded.y == welded.z || welded.z == welded.x) continue;
        for (int k = 0; k < 3; ++k) used[welded[k]] = true;
        result.triangles.push_back(welded);
        kept.push_back(static_cast<uint32_t>(&t - mesh.triangles.data()));
    }

    std::vector<uint32_t> renumbered(mesh.positions.size(), no_index);
    for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
        if (!used[v]) continue;
        renumbered[v] = static_cast<uint32_t>(result.positions.size());
        result.positions.push_back(mesh.positions[v]);
    }
    for (Triangle& t : result.triangles) t = {renumbered[t.x], renumbered[t.y], renumbered[t.z]};
    return result;
}

// One use of an undirected edge by a triangle.
struct EdgeUse {
    uint32_t low, high, triangle;
    [[nodiscard]] bool is_along(const EdgeUse& other) const { return low == other.low && high == other.high; }
};

// Divides the vertices of edges of three triangles or more into fans: the corners at a vertex that are connected across
// edges of two triangles, or that are one vertex of the file.
class FanDivider {
  public:
    // `own` is the vertex of the file at each corner of `welded`.
    FanDivider(const TriangleMesh& welded, std::span<const std::array<uint32_t, 3>> own) : welded_(welded), own_(own) {
        for (uint32_t t = 0; t < welded.triangles.size(); ++t)
            for (int k = 0; k < 3; ++k) {
                const uint32_t a = welded.triangles[t][k], b = welded.triangles[t][(k + 1) % 3];
                uses_.push_back({std::min(a, b), std::max(a, b), t});
            }
        std::sort(uses_.begin(), uses_.end(), [](const EdgeUse& a, const EdgeUse& b) {
            return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
        });
    }

    TriangleMesh run() {
        divided_.assign(welded_.positions.size(), 0);
        for_each_edge([&](std::span<const EdgeUse> uses) {
            if (uses.size() > 2) divided_[uses[0].low] = divided_[uses[0].high] = 1;
        });
        unite_corners();
        return divide();
    }

  private:
    template<class Visit>
    void for_each_edge(const Visit& visit) const {
        for (size_t begin = 0, end = 0; begin < uses_.size(); begin = end) {
            while (end < uses_.size() && uses_[end].is_along(uses_[begin])) ++end;
            visit(std::span(uses_).subspan(begin, end - begin));
        }
    }

    [[nodiscard]] uint32_t corner_at(uint32_t triangle, uint32_t vertex) const {
        const Triangle& t = welded_.triangles[triangle];
        return 3 * triangle + (t.x == vertex ? 0 : (t.y == vertex ? 1 : 2));
    }

    void unite_corners() {
        parent_.resize(3 * welded_.triangles.size());
        std::iota(parent_.begin(), parent_.end(), 0u);
        for_each_edge([&](std::span<const EdgeUse> uses) {
            if (uses.size() != 2) return;
            for (const uint32_t v : {uses[0].low, uses[0].high})
                if (divided_[v]) unite(parent_, corner_at(uses[0].triangle, v), corner_at(uses[1].triangle, v));
        });
        std::vector<std::pair<uint32_t, uint32_t>> corners; // vertex of the file, corner
        for (uint32_t t = 0; t < welded_.triangles.size(); ++t)
            for (uint32_t k = 0; k < 3; ++k)
                if (divided_[welded_.triangles[t][static_cast<int>(k)]]) corners.push_back({own_[t][k], 3 * t + k});
        std::sort(corners.begin(), corners.end());
        for (size_t k = 1; k < corners.size(); ++k)
            if (corners[k].first == corners[k - 1].first) unite(parent_, corners[k].second, corners[k - 1].second);
    }

    // The first fan of a vertex keeps it; the others get copies.
    TriangleMesh divide() {
        TriangleMesh result = welded_;
        std::vector<uint32_t> fan(welded_.positions.size(), no_index); // the root of the first one
        std::vector<uint32_t> copy(parent_.size(), no_index);          // by root
        for (uint32_t corner = 0; corner < parent_.size(); ++corner) {
            uint32_t& v = result.triangles[corner / 3][static_cast<int>(corner % 3)];
            if (!divided_[v]) continue;
            const uint32_t root = root_of(parent_, corner);
            if (fan[v] == no_index) fan[v] = root;
            if (fan[v] == root) continue;
            if (copy[root] == no_index) {
                copy[root] = static_cast<uint32_t>(result.positions.size());
                result.positions.push_back(welded_.positions[v]);
            }
            v = copy[root];
        }
        return result;
    }

    const TriangleMesh& welded_;
    std::span<const std::array<uint32_t, 3>> own_;
    std::vector<EdgeUse> uses_;
    std::vector<uint8_t> divided_; // per vertex
    std::vector<uint32_t> parent_; // per corner
};

bool is_closed(const TriangleMesh& mesh) {
    return !mesh.triangles.empty() && check_topology(mesh.positions.size(), mesh.triangles).closed();
}

} // namespace

TriangleMesh weld(const TriangleMesh& mesh, std::vector<uint32_t>* kept) {
    assert(mesh.positions.size() < no_index);
    std::vector<uint32_t> unwanted;
    return replaced(mesh, first_of_same(mesh.positions, {}), kept ? *kept : unwanted);
}

TriangleMesh weld_surface(const TriangleMesh& mesh, std::span<const uint32_t> point, std::vector<uint32_t>& kept) {
    TriangleMesh welded = weld(mesh, &kept);
    Threads threads(0);
    if (ManifoldCheck().run(welded.positions.size(), welded.triangles, threads)) return welded;
    std::vector<uint32_t> first(mesh.positions.size());
    std::iota(first.begin(), first.end(), 0u);
    if (!point.empty()) first = first_of_same(mesh.positions, point);
    std::vector<uint32_t> kept_own;
    TriangleMesh own = replaced(mesh, first, kept_own);
    if (is_closed(own)) {
        kept = std::move(kept_own);
        return own;
    }

    std::vector<std::array<uint32_t, 3>> corners;
    for (const uint32_t t : kept) {
        const Triangle& c = mesh.triangles[t];
        corners.push_back({first[c.x], first[c.y], first[c.z]});
    }
    TriangleMesh divided = FanDivider(welded, corners).run();
    return is_closed(divided) ? divided : welded;
}

} // namespace brittle::fracture

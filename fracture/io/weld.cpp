#include "fracture/io/weld.h"

#include <bit>
#include <cassert>

namespace brittle::fracture {
namespace {

// Three words that are equal exactly where two positions are.
struct Key {
    uint64_t x, y, z;
    bool operator==(const Key&) const = default;
};

Key key_of(const glm::dvec3& p) {
    // Adding +0 turns -0 into +0 and changes no other value.
    return {std::bit_cast<uint64_t>(p.x + 0.0), std::bit_cast<uint64_t>(p.y + 0.0), std::bit_cast<uint64_t>(p.z + 0.0)};
}

// Coordinates read as floats have zeros in their low bits, so every word is mixed first.
uint64_t mix(uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
}

uint64_t hash(const Key& key) {
    return mix(mix(mix(key.x) + key.y) + key.z);
}

// Returns for each vertex the first one at its position.
std::vector<uint32_t> first_at_same_position(const std::vector<glm::dvec3>& positions) {
    // Open addressing with linear probing, at most half full. The result does not depend on the order of slots.
    const size_t slots = std::bit_ceil(positions.size() * 2 + 1);
    std::vector<uint32_t> table(slots, no_index);
    std::vector<uint32_t> first(positions.size());
    for (uint32_t v = 0; v < positions.size(); ++v) {
        const Key key = key_of(positions[v]);
        size_t slot = hash(key) & (slots - 1);
        while (table[slot] != no_index && key_of(positions[table[slot]]) != key) slot = (slot + 1) & (slots - 1);
        if (table[slot] == no_index) table[slot] = v;
        first[v] = table[slot];
    }
    return first;
}

} // namespace

TriangleMesh weld(const TriangleMesh& mesh, std::vector<uint32_t>* kept) {
    assert(mesh.positions.size() < no_index);
    const std::vector<uint32_t> first = first_at_same_position(mesh.positions);

    TriangleMesh result;
    result.triangles.reserve(mesh.triangles.size());
    std::vector<bool> used(mesh.positions.size(), false);
    if (kept) kept->clear();
    for (const Triangle& t : mesh.triangles) {
        assert(t.x < first.size() && t.y < first.size() && t.z < first.size());
        const Triangle welded{first[t.x], first[t.y], first[t.z]};
        if (welded.x == welded.y || welded.y == welded.z || welded.z == welded.x) continue;
        for (int k = 0; k < 3; ++k) used[welded[k]] = true;
        result.triangles.push_back(welded);
        if (kept) kept->push_back(static_cast<uint32_t>(&t - mesh.triangles.data()));
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

} // namespace brittle::fracture

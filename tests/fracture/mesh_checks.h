// Oracles for mesh tests, independent of the code under test and as plain as possible.
#pragma once

#include <map>
#include <span>
#include <utility>

#include <glm/geometric.hpp>

#include "fracture/mesh/mesh.h"
#include "tests/folder.h"

namespace brittle::fracture::test {

using brittle::test_files::Folder;
using brittle::test_files::read_text;

// Returns whether every edge is used exactly once in each direction.
inline bool is_closed(std::span<const Triangle> triangles) {
    std::map<std::pair<uint32_t, uint32_t>, int> uses;
    for (const Triangle& t : triangles) {
        for (int k = 0; k < 3; ++k) ++uses[{t[k], t[(k + 1) % 3]}];
    }
    for (const auto& [edge, count] : uses) {
        const auto twin = uses.find({edge.second, edge.first});
        if (count != 1 || twin == uses.end() || twin->second != 1) return false;
    }
    return !triangles.empty();
}

inline double signed_volume(const TriangleMesh& mesh) {
    double six_volumes = 0.0;
    for (const Triangle& t : mesh.triangles) {
        six_volumes += glm::dot(mesh.positions[t.x], glm::cross(mesh.positions[t.y], mesh.positions[t.z]));
    }
    return six_volumes / 6.0;
}

} // namespace brittle::fracture::test

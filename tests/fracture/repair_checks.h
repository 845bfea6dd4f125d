// Checks that hold for every repair, and small meshes to damage.
#pragma once

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "fracture/doctor/repair.h"
#include "fracture/mesh/topology.h"
#include "tests/fracture/mesh_checks.h"

namespace brittle::fracture::test {

// A cube of edge 2 around the origin. The bits of a vertex index are x y z, with 0 for -1.
inline TriangleMesh plain_cube() {
    TriangleMesh mesh;
    for (int v = 0; v < 8; ++v) mesh.positions.emplace_back(v & 4 ? 1 : -1, v & 2 ? 1 : -1, v & 1 ? 1 : -1);
    mesh.triangles = {{4, 6, 7}, {4, 7, 5}, {0, 1, 3}, {0, 3, 2}, {2, 3, 7}, {2, 7, 6},
                      {0, 4, 5}, {0, 5, 1}, {1, 5, 7}, {1, 7, 3}, {0, 2, 6}, {0, 6, 4}};
    return mesh;
}

inline bool same(const TriangleMesh& a, const TriangleMesh& b) {
    return a.positions == b.positions && a.triangles == b.triangles;
}

inline bool is_manifold(const TriangleMesh& mesh) {
    return check_topology(mesh.positions.size(), mesh.triangles).manifold();
}

// Returns the positions of the triangle's corners, equal for its three cyclic orders.
inline std::array<glm::dvec3, 3> corners_of(const TriangleMesh& mesh, uint32_t t) {
    std::array<glm::dvec3, 3> c;
    for (int k = 0; k < 3; ++k) c[static_cast<size_t>(k)] = mesh.positions[mesh.triangles[t][k]];
    const auto less = [](const glm::dvec3& a, const glm::dvec3& b) {
        return a.x != b.x ? a.x < b.x : (a.y != b.y ? a.y < b.y : a.z < b.z);
    };
    std::rotate(c.begin(), std::min_element(c.begin(), c.end(), less), c.end());
    return c;
}

// Checks the guarantees of every repair, for any input.
inline void check_promises(const TriangleMesh& input, const Repaired& repaired, const RepairSettings& settings = {}) {
    const TriangleMesh& mesh = repaired.mesh;
    REQUIRE(repaired.source_triangle.size() == mesh.triangles.size());
    REQUIRE(mesh.positions.size() >= input.positions.size());
    CHECK(std::equal(input.positions.begin(), input.positions.end(), mesh.positions.begin()));
    for (const Triangle& t : mesh.triangles) REQUIRE(std::max({t.x, t.y, t.z}) < mesh.positions.size());
    for (const uint32_t source : repaired.source_triangle)
        REQUIRE((source == no_index || source < input.triangles.size()));
    CHECK(describe(repaired.report).empty() <= !repaired.report.changed());
    if (!repaired.report.changed()) CHECK(same(input, mesh));
    const Repaired again = repair(mesh, settings);
    CHECK(same(again.mesh, mesh));
    CHECK(!again.report.changed());
}

// Repairs a mesh and checks that the result is a closed manifold of the given volume.
inline Repaired check_solid(const TriangleMesh& input, double volume, const RepairSettings& settings,
                            double tolerance = 1e-12) {
    const Repaired repaired = repair(input, settings);
    check_promises(input, repaired);
    INFO(describe(repaired.report));
    CHECK(is_manifold(repaired.mesh));
    CHECK(signed_volume(repaired.mesh) == doctest::Approx(volume).epsilon(tolerance));
    return repaired;
}

inline Repaired check_solid(const TriangleMesh& input, double volume, double tolerance = 1e-12) {
    return check_solid(input, volume, {}, tolerance);
}

// Checks that the remaining triangles lie where their sources did, reversed or not.
inline void check_sources(const TriangleMesh& input, const Repaired& repaired, bool turned_too = false) {
    for (uint32_t t = 0; t < repaired.mesh.triangles.size(); ++t) {
        const uint32_t source = repaired.source_triangle[t];
        if (source == no_index) continue;
        auto own = corners_of(repaired.mesh, t);
        const auto expected = corners_of(input, source);
        if (turned_too && own != expected) std::swap(own[1], own[2]);
        CHECK(own == expected);
    }
}

inline void turn(Triangle& t) {
    std::swap(t.y, t.z);
}

inline void append(TriangleMesh& mesh, const TriangleMesh& other, const glm::dvec3& shift = glm::dvec3(0.0)) {
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    for (const glm::dvec3& p : other.positions) mesh.positions.push_back(p + shift);
    for (const Triangle& t : other.triangles) mesh.triangles.push_back(t + first);
}

inline TriangleMesh without(TriangleMesh mesh, const std::vector<uint32_t>& triangles) {
    std::vector<Triangle> rest;
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t)
        if (std::find(triangles.begin(), triangles.end(), t) == triangles.end()) rest.push_back(mesh.triangles[t]);
    mesh.triangles = rest;
    return mesh;
}

} // namespace brittle::fracture::test

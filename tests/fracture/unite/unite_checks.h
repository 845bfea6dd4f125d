// Oracles for unions of meshes, independent of the code under test.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <vector>

#include <glm/geometric.hpp>

#include "fracture/mesh/intersections.h"
#include "fracture/mesh/topology.h"
#include "fracture/unite/unite.h"
#include "tests/fracture/mesh_checks.h"
#include "tools/stress/check_union.h"

namespace brittle::fracture::test {

inline void append(TriangleMesh& mesh, const TriangleMesh& other, const glm::dvec3& offset = glm::dvec3(0.0)) {
    const auto base = static_cast<uint32_t>(mesh.positions.size());
    for (const glm::dvec3& p : other.positions) mesh.positions.push_back(p + offset);
    for (const Triangle& t : other.triangles) mesh.triangles.push_back(t + base);
}

// A box between two corners.
inline TriangleMesh box_mesh(const glm::dvec3& low, const glm::dvec3& high) {
    TriangleMesh mesh;
    for (uint32_t i = 0; i < 8; ++i)
        mesh.positions.push_back({i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z});
    mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                      {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    return mesh;
}

inline void turn_inside_out(TriangleMesh& mesh) {
    for (Triangle& t : mesh.triangles) std::swap(t.y, t.z);
}

// The mesh in which vertices at one position are one.
inline TriangleMesh weld_equal(const TriangleMesh& mesh) {
    std::map<std::tuple<double, double, double>, uint32_t> known;
    TriangleMesh welded{mesh.positions, mesh.triangles};
    std::vector<uint32_t> first;
    for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
        const glm::dvec3& p = mesh.positions[v];
        first.push_back(known.try_emplace({p.x, p.y, p.z}, v).first->second);
    }
    for (Triangle& t : welded.triangles) t = {first[t.x], first[t.y], first[t.z]};
    return welded;
}

// Whether an edge of the first triangle passes through the inside of the second.
inline bool pierces(const TriangleMesh& mesh, const Triangle& first, const Triangle& second) {
    const auto at = [&](uint32_t v) -> const glm::dvec3& { return mesh.positions[v]; };
    for (int k = 0; k < 3; ++k) {
        const glm::dvec3 &p = at(first[k]), &q = at(first[(k + 1) % 3]);
        if (orientation(at(second.x), at(second.y), at(second.z), p)
                * orientation(at(second.x), at(second.y), at(second.z), q)
            >= 0)
            continue;
        int sum = 0;
        for (int j = 0; j < 3; ++j) sum += orientation(p, q, at(second[j]), at(second[(j + 1) % 3]));
        if (sum == 3 || sum == -3) return true;
    }
    return false;
}

// The number of pairs of triangles that pass through each other. Those that only touch do not count.
inline uint64_t crossings(const TriangleMesh& mesh) {
    const TriangleMesh welded = weld_equal(mesh);
    uint64_t count = 0;
    for (const glm::uvec2& pair : find_intersections(welded, 100'000'000, 1'000'000).listed) {
        const Triangle &s = welded.triangles[pair.x], &t = welded.triangles[pair.y];
        count += pierces(welded, s, t) || pierces(welded, t, s) ? 1 : 0;
    }
    return count;
}

// What holds for the union of any mesh.
inline United check_union(const TriangleMesh& mesh) {
    United united = unite(mesh, 1);
    const TopologyReport topology = check_topology(united.mesh.positions.size(), united.mesh.triangles);
    CHECK_MESSAGE(topology.manifold(), describe(topology));
    REQUIRE(united.source_triangle.size() == united.mesh.triangles.size());
    for (const uint32_t source : united.source_triangle) REQUIRE(source < mesh.triangles.size());
    CHECK(crossings(united.mesh) == 0);
    CHECK(united.report.complete);
    TriangleMesh near = united.mesh; // far from the origin the oracle loses its digits
    for (glm::dvec3& p : near.positions) p -= united.mesh.positions[0];
    CHECK(united.report.volume_after == doctest::Approx(signed_volume(near)).epsilon(1e-9));
    if (!united.report.changed()) {
        CHECK(united.mesh.positions == mesh.positions);
        CHECK(united.mesh.triangles == mesh.triangles);
    }
    const United again = unite(united.mesh, 1);
    CHECK_FALSE(again.report.changed());
    CHECK(again.mesh.positions == united.mesh.positions);
    CHECK(again.mesh.triangles == united.mesh.triangles);
    return united;
}

// Checks that a point is inside the union where the surface winds around it at least once.
inline void check_points(const TriangleMesh& mesh, const TriangleMesh& united, const std::vector<glm::dvec3>& points) {
    for (const glm::dvec3& p : points) {
        const double around = stress::winding_number(mesh, p), in_union = stress::winding_number(united, p);
        CAPTURE(p.x);
        CAPTURE(p.y);
        CAPTURE(p.z);
        CHECK(std::abs(around - std::round(around)) < 1e-6);
        CHECK(in_union == doctest::Approx(around > 0.5 ? 1.0 : 0.0).epsilon(1e-6));
    }
}

} // namespace brittle::fracture::test

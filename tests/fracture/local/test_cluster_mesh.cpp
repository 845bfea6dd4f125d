#include "fracture/local/cluster_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/base/random.h"
#include "fracture/local/cluster_queries.h"
#include "fracture/mesh/islands.h"
#include "fracture/mesh/nearest.h"
#include "fracture/mesh/topology.h"
#include "fracture/mesh/triangle_tree.h"
#include "fracture/shapes/shapes.h"

using namespace brittle::fracture;

namespace {

// 0, 1, ... by triangle.
std::vector<uint32_t> numbers(const TriangleMesh& mesh) {
    std::vector<uint32_t> all(mesh.triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    return all;
}

ClusterMesh clusters_of(const TriangleMesh& mesh, uint32_t thread_count = 1) {
    Threads threads(thread_count);
    return {mesh, numbers(mesh), threads};
}

std::vector<TriangleMesh> shapes() {
    return {cube(), icosphere(4), torus(60, 40), four_legged_animal(48), hollow_sphere(3)};
}

glm::dvec3 place_near(const Box& box, Random& random) {
    const double x = random.uniform(), y = random.uniform(), z = random.uniform();
    return box.min + (1.4 * glm::dvec3(x, y, z) - 0.2) * box.size();
}

} // namespace

TEST_CASE("cluster mesh: an empty mesh has no clusters and answers every question") {
    const ClusterMesh empty = clusters_of({});
    CHECK(empty.triangle_count() == 0);
    CHECK(empty.flatten().triangles.empty());
    CHECK(empty.is_connected());
    CHECK_FALSE(is_inside(empty, glm::dvec3(0.0)));
    CHECK_FALSE(first_hit(empty, glm::dvec3(0.0), glm::dvec3(1.0)).has_value());
    CHECK(nearest_on(empty, glm::dvec3(1.0)) == glm::dvec3(1.0));
    CHECK(farthest_from(empty, glm::dvec3(1.0)) == 0.0);
    CHECK(empty.with({}, {}).triangle_count() == 0);
    CHECK(empty.branches(1000).empty());
    empty.visit_some(10, [](const ClusterPtr&) { FAIL("there is none"); });
}

TEST_CASE("cluster mesh: branches divide the mesh, as large as the limit allows") {
    for (const TriangleMesh& mesh : shapes())
        for (const uint32_t limit : {1u, 128u, 1000u, 1'000'000u}) {
            const ClusterMesh clusters = clusters_of(mesh);
            std::vector<const Cluster*> found, all;
            clusters.for_each([&](const ClusterPtr& cluster) { all.push_back(cluster.get()); });
            uint32_t before = 0;
            for (const ClusterBranch& branch : clusters.branches(limit)) {
                const size_t first = found.size();
                uint32_t triangles = 0;
                branch.for_each([&](const ClusterPtr& cluster) {
                    found.push_back(cluster.get());
                    triangles += static_cast<uint32_t>(cluster->triangles.size());
                    CHECK(overlap(cluster->box, branch.box()));
                });
                CHECK(triangles == branch.triangle_count());
                CHECK((triangles <= limit || found.size() - first == 1));
                if (limit > 1) CHECK((before == 0 || before + triangles > limit / 4)); // the tree is balanced
                before = triangles;
            }
            CHECK(found == all);
        }
}

TEST_CASE("cluster mesh: a few clusters are taken from all over the mesh, or all of a small one") {
    const ClusterMesh clusters = clusters_of(icosphere(6));
    for (const uint32_t count : {1u, 10u, 64u, 100'000u}) {
        uint32_t taken = 0;
        Box box{glm::dvec3(2.0), glm::dvec3(-2.0)};
        clusters.visit_some(count, [&](const ClusterPtr& cluster) {
            ++taken;
            box = {glm::min(box.min, cluster->box.min), glm::max(box.max, cluster->box.max)};
        });
        CHECK(taken >= std::min(count, clusters.cluster_count()));
        CHECK(taken <= std::min(2 * count, clusters.cluster_count()));
        if (count >= 64) CHECK(glm::length(box.size()) > 0.9 * glm::length(clusters.box().size()));
    }
}

TEST_CASE("cluster mesh: the flat mesh has each triangle once, with its tag, whatever the number of threads") {
    for (const TriangleMesh& mesh : shapes()) {
        const ClusterMesh clusters = clusters_of(mesh);
        CHECK(clusters.triangle_count() == mesh.triangles.size());
        uint32_t counted = 0, number = 0;
        clusters.for_each([&](const ClusterPtr& cluster) {
            ++number;
            counted += static_cast<uint32_t>(cluster->triangles.size());
            CHECK(cluster->triangles.size() <= Cluster::max_triangles);
            CHECK(cluster->positions.size() <= 256);
            for (const glm::dvec3& p : cluster->positions) CHECK(overlap({p, p}, cluster->box));
        });
        CHECK(counted == mesh.triangles.size());
        CHECK(number == clusters.cluster_count());
        std::vector<uint32_t> tags;
        const TriangleMesh flat = clusters.flatten(&tags);
        REQUIRE(flat.triangles.size() == mesh.triangles.size());
        CHECK(flat.positions.size() == mesh.positions.size());
        std::vector<uint32_t> sorted = tags;
        std::ranges::sort(sorted);
        for (uint32_t t = 0; t < sorted.size(); ++t) REQUIRE(sorted[t] == t);
        for (size_t t = 0; t < tags.size(); ++t)
            for (int k = 0; k < 3; ++k)
                REQUIRE(flat.positions[flat.triangles[t][k]] == mesh.positions[mesh.triangles[tags[t]][k]]);
        for (const uint32_t threads : {2u, 7u}) {
            const TriangleMesh again = clusters_of(mesh, threads).flatten();
            CHECK(again.positions == flat.positions);
            CHECK(again.triangles == flat.triangles);
        }
    }
}

TEST_CASE("cluster mesh: a large mesh divided by several threads has the clusters of one thread") {
    const TriangleMesh mesh = icosphere(6);
    const TriangleMesh one = clusters_of(mesh, 1).flatten();
    for (const uint32_t threads : {2u, 3u, 8u}) CHECK(clusters_of(mesh, threads).flatten().triangles == one.triangles);
}

TEST_CASE("cluster mesh: exchanged clusters leave the others shared, and nothing of the mesh before changes") {
    const TriangleMesh mesh = icosphere(5);
    const ClusterMesh before = clusters_of(mesh);
    const Box corner{glm::dvec3(0.2), glm::dvec3(2.0)};
    ClusterSet opened;
    FaceList faces;
    before.visit(corner, [&](const ClusterPtr& cluster) {
        opened.insert(cluster.get());
        for (size_t k = 0; k < cluster->triangles.size(); ++k) {
            for (const uint8_t v : cluster->triangles[k]) {
                faces.positions.push_back(cluster->positions[v]);
                faces.vertices.push_back(cluster->vertices[v]);
            }
            const auto last = static_cast<uint32_t>(faces.positions.size());
            faces.triangles.emplace_back(last - 3, last - 2, last - 1);
            faces.tags.push_back(cluster->tags[k] + 1'000'000);
        }
    });
    REQUIRE(!opened.empty());
    REQUIRE(opened.size() < before.cluster_count());
    const ClusterMesh after = before.with(opened, faces);
    CHECK(after.triangle_count() == before.triangle_count());
    uint32_t shared = 0;
    after.for_each([&](const ClusterPtr& cluster) {
        CHECK_FALSE(opened.contains(cluster.get()));
        before.visit(cluster->box, [&](const ClusterPtr& old) { shared += old == cluster ? 1 : 0; });
    });
    CHECK(shared == before.cluster_count() - opened.size());
    std::set<const void*> old_branches;
    for (const ClusterBranch& branch : before.branches(512)) old_branches.insert(branch.key());
    uint32_t kept = 0; // triangles
    for (const ClusterBranch& branch : after.branches(512))
        if (old_branches.contains(branch.key())) kept += branch.triangle_count();
    CHECK(kept > before.triangle_count() / 2);
    const TriangleMesh flat = after.flatten();
    CHECK(check_topology(flat.positions.size(), flat.triangles).manifold());
    CHECK(before.flatten().triangles == clusters_of(mesh).flatten().triangles);
    CHECK(after.box().min == before.box().min);
    CHECK(after.with(opened, {}).triangle_count() == after.triangle_count()); // they are gone already
}

TEST_CASE("cluster mesh: two solids apart are not connected, a solid with a cavity is not either") {
    CHECK(clusters_of(icosphere(4)).is_connected());
    CHECK(clusters_of(torus(60, 40)).is_connected());
    CHECK_FALSE(clusters_of(hollow_sphere(3)).is_connected());
    CHECK(clusters_of(icosphere(4)).parts().size() == 1);
    const ClusterMesh both = clusters_of(hollow_sphere(3));
    const std::vector<ClusterMesh> parts = both.parts();
    REQUIRE(parts.size() == 2);
    CHECK(parts[0].triangle_count() + parts[1].triangle_count() == both.triangle_count());
    for (const ClusterMesh& part : parts) {
        CHECK(part.is_connected());
        CHECK(part.vertex_limit() == both.vertex_limit());
        const TriangleMesh flat = part.flatten();
        CHECK(check_topology(flat.positions.size(), flat.triangles).manifold());
    }
}

TEST_CASE("cluster queries: inside, nearest point, hits and extents agree with those of the whole mesh") {
    Random random(7);
    for (const TriangleMesh& mesh : shapes()) {
        const ClusterMesh clusters = clusters_of(mesh);
        const Box box = bounds(mesh);
        const TriangleTree tree(mesh, numbers(mesh));
        for (int k = 0; k < 60; ++k) {
            const glm::dvec3 p = place_near(box, random), q = place_near(box, random);
            CHECK(is_inside(clusters, p) == (winding_number(p, mesh.positions, mesh.triangles) > 0.5));
            const glm::dvec3 nearest = nearest_on(mesh, p);
            CHECK(glm::distance(nearest_on(clusters, p), p) == doctest::Approx(glm::distance(nearest, p)));
            const auto hit = first_hit(clusters, p, q);
            const auto expected = tree.first_hit(p, q - p, no_index);
            const bool hits = expected.has_value() && *expected <= 1.0;
            REQUIRE(hit.has_value() == hits);
            if (hits) CHECK(*hit == doctest::Approx(*expected));
            double along = -1e300, from = 0.0;
            for (const glm::dvec3& v : mesh.positions) {
                along = std::max(along, glm::dot(v - p, q));
                from = std::max(from, glm::distance(v, p));
            }
            CHECK(farthest_along(clusters, p, q) == along);
            CHECK(farthest_from(clusters, p) == from);
        }
    }
}

TEST_CASE("cluster queries: segments along axes, through vertices and without length") {
    Random random(8);
    for (const TriangleMesh& mesh : shapes()) {
        const ClusterMesh clusters = clusters_of(mesh);
        const Box box = bounds(mesh);
        const TriangleTree tree(mesh, numbers(mesh));
        for (int k = 0; k < 60; ++k) {
            glm::dvec3 p = place_near(box, random);
            const int axis = k % 3;
            p[axis] = box.min[axis] - 1.0;
            glm::dvec3 q = p;
            q[axis] = box.max[axis] + 1.0;
            for (const auto& [from, to] : {std::pair(p, q), std::pair(q, p)}) {
                const auto hit = first_hit(clusters, from, to);
                const auto expected = tree.first_hit(from, to - from, no_index);
                REQUIRE(hit.has_value() == expected.has_value());
                if (hit) CHECK(*hit == doctest::Approx(*expected));
            }
            CHECK_FALSE(first_hit(clusters, p, p).has_value());
            // A hit of the segment to a vertex is at the vertex or before it, and on the surface.
            const glm::dvec3& vertex = mesh.positions[random.next() % mesh.positions.size()];
            const glm::dvec3 beyond = p + 1.5 * (vertex - p);
            if (const auto hit = first_hit(clusters, p, beyond)) {
                const glm::dvec3 at = p + *hit * (beyond - p);
                CHECK(glm::distance(nearest_on(mesh, at), at) < 1e-9);
            }
            // A ray through a vertex, so that its coordinates are equal to some.
            const glm::dvec3 level(p.x + random.uniform() * (box.max.x + 1.0 - p.x), vertex.y, vertex.z);
            if (glm::distance(nearest_on(mesh, level), level) > 1e-6)
                CHECK(is_inside(clusters, level) == (winding_number(level, mesh.positions, mesh.triangles) > 0.5));
        }
    }
}

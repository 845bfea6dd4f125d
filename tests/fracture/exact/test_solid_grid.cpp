#include "fracture/exact/solid_grid.h"

#include <algorithm>
#include <span>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/exact/diagram.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"

using namespace brittle::fracture;
using namespace brittle::fracture::exact;

namespace {

Box box_around(const TriangleMesh& mesh) {
    const Box box = bounds(mesh);
    return {box.min - 0.1, box.max + 0.1};
}

SolidGrid grid_of(const TriangleMesh& mesh, uint32_t bins, uint32_t threads = 1) {
    Threads pool(threads);
    SolidGrid grid;
    grid.build(mesh.positions, mesh.triangles, box_around(mesh), bins, pool);
    return grid;
}

Box around(const glm::dvec3& point) {
    return {point - 1e-6, point + 1e-6};
}

} // namespace

TEST_CASE("solid grid: one bin covers everything") {
    const SolidGrid grid = grid_of(cube(), 1);
    CHECK(grid.covers(bounds(cube()).centre()));
    CHECK(grid.group_points().size() == 1);
    CHECK_FALSE(grid.covers(glm::dvec3(100.0)));
}

TEST_CASE("solid grid: the inside of a ball is covered, the corners of its box are not") {
    const TriangleMesh ball = icosphere(4);
    const Box box = bounds(ball);
    for (const uint32_t threads : {1u, 2u}) {
        const SolidGrid grid = grid_of(ball, 24, threads);
        CHECK(grid.covers(box.centre()));
        CHECK(grid.meets(around(box.centre())));
        CHECK_FALSE(grid.covers(box.min));
        CHECK_FALSE(grid.meets(around(box.max)));
        CHECK(grid.group_points().size() == 1);
        for (const glm::dvec3& p : ball.positions) CHECK(grid.meets(around(p)));
    }
}

TEST_CASE("solid grid: the hole of a torus is outside, two balls are two groups") {
    const TriangleMesh ring = torus();
    CHECK_FALSE(grid_of(ring, 32).covers(bounds(ring).centre()));

    TriangleMesh two = icosphere(3);
    const auto count = static_cast<uint32_t>(two.positions.size());
    const size_t triangles = two.triangles.size();
    const double apart = 3.0 * bounds(two).size().x;
    for (uint32_t v = 0; v < count; ++v) two.positions.push_back(two.positions[v] + glm::dvec3(apart, 0.0, 0.0));
    for (size_t t = 0; t < triangles; ++t) two.triangles.push_back(two.triangles[t] + count);
    CHECK(grid_of(two, 40).group_points().size() == 2);
}

TEST_CASE("a diagram without the cells outside a solid equals the whole diagram inside") {
    const TriangleMesh ring = torus();
    const Box box = box_around(ring);
    const std::vector<glm::dvec3> sites = uniform_sites(box, 1000, 3);
    for (const uint32_t threads : {1u, 2u}) {
        Threads pool(threads);
        DiagramBuilder whole_builder, builder;
        VoronoiDiagram whole, part;
        whole_builder.build({sites, box}, pool, nullptr, whole);
        const SolidGrid grid = grid_of(ring, 30);
        builder.build({sites, box}, pool, &grid, part);

        const auto built = std::count(part.cell_is_empty.begin(), part.cell_is_empty.end(), uint8_t{0});
        CHECK(built > 20);
        CHECK(built < 900);
        for (const glm::dvec3& p : ring.positions)
            builder.tree().visit_nearest(p, [&](SiteId site) { CHECK_FALSE(part.cell_is_empty[site]); });
        for (const VoronoiDiagram::Facet& facet : part.facets) {
            const auto ring_of_part = part.ring_of(facet);
            const auto ring_of_whole = whole.ring_of(whole.facets[whole.facet_between(facet.i, facet.j)]);
            REQUIRE(ring_of_part.size() == ring_of_whole.size());
            for (size_t m = 0; m < ring_of_part.size(); ++m) {
                CHECK(ring_of_part[m].third == ring_of_whole[m].third);
                const VoronoiDiagram::Vertex& vertex = part.vertices[ring_of_part[m].vertex];
                if (vertex.planes[0] == VoronoiDiagram::none) continue; // it stands for vertices outside
                CHECK(vertex.planes == whole.vertices[ring_of_whole[m].vertex].planes);
                CHECK(vertex.position == whole.vertices[ring_of_whole[m].vertex].position);
            }
        }
    }
}

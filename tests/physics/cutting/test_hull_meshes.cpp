#include "physics/cutting/hull_meshes.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/fracture.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/mesh/topology.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"

using namespace brittle;
using namespace brittle::physics;
using fracture::TriangleMesh;

namespace {

struct Cut {
    TriangleMesh mesh;
    std::vector<glm::dvec3> sites;
    fracture::Fragments fragments;
};

Cut cut(const std::string& shape, size_t sites) {
    Cut made;
    made.mesh = *fracture::shape(shape);
    made.sites = fracture::uniform_sites(fracture::bounds(made.mesh), sites, 1);
    made.fragments = *fracture::fracture(made.mesh, made.sites);
    return made;
}

double volume_of(const std::vector<TriangleMesh>& hulls) {
    double sum = 0.0;
    for (const TriangleMesh& hull : hulls) sum += fracture::signed_volume(hull.positions, hull.triangles);
    return sum;
}

// Returns how far the point lies beyond the bisector of its own site and the nearest other one, m.
double beyond_cell(const glm::dvec3& point, size_t own, std::span<const glm::dvec3> sites) {
    double most = -1e300;
    for (size_t other = 0; other < sites.size(); ++other) {
        if (other == own) continue;
        const glm::dvec3 across = sites[other] - sites[own];
        const double length = glm::length(across);
        most = std::max(most, glm::dot(point - 0.5 * (sites[other] + sites[own]), across) / length);
    }
    return most;
}

double longest_side(const TriangleMesh& mesh) {
    const glm::dvec3 size = fracture::bounds(mesh).size();
    return std::max({size.x, size.y, size.z});
}

} // namespace

TEST_CASE("hull meshes: a flake, a needle and a piece without volume have a closed hull") {
    for (const glm::dvec3 size : {glm::dvec3(1.0, 1.0, 1e-9), glm::dvec3(1.0, 1e-7, 1e-7), glm::dvec3(1e-9)}) {
        CAPTURE(size.x);
        const TriangleMesh box = fracture::cuboid(size);
        const glm::dvec3 site(0.0);
        const auto whole = fracture::fracture(box, {&site, 1});
        REQUIRE(whole);
        for (const std::vector<TriangleMesh>& hulls : hull_meshes(*whole)) {
            REQUIRE(hulls.size() == 1);
            CHECK(fracture::check_topology(hulls[0].positions.size(), hulls[0].triangles).closed());
            for (const glm::dvec3& p : hulls[0].positions) CHECK(glm::length(p) < 1.0);
        }
    }
    CHECK(hull_meshes(fracture::Fragments{}).empty());
}

TEST_CASE("hull meshes: they are full, stay in the cells of their pieces, and have no corner beside another") {
    struct Case {
        const char* shape;
        size_t sites;
    };
    for (const Case& tried : {Case{"cube", 20},
                              {"hollow_sphere", 30},
                              {"menger_sponge", 40},
                              {"vase", 40},
                              {"torus_knot", 6},
                              {"tower", 10}}) {
        CAPTURE(tried.shape);
        const Cut made = cut(tried.shape, tried.sites);
        const HullMeshSettings settings{.max_parts = 64};
        const std::vector<std::vector<TriangleMesh>> all = hull_meshes(made.fragments, settings, 2);
        REQUIRE(all.size() == made.fragments.pieces.size());
        for (size_t p = 0; p < all.size(); ++p) {
            const fracture::Piece& piece = made.fragments.pieces[p];
            CAPTURE(p);
            CHECK(volume_of(all[p]) > 0.9 * piece.mass.volume);
            if (all[p].size() < settings.max_parts) CHECK(volume_of(all[p]) < 1.3 * piece.mass.volume);
            for (const TriangleMesh& hull : all[p]) {
                CHECK(fracture::check_topology(hull.positions.size(), hull.triangles).closed());
                double beyond = -1e300, nearest = 1e300;
                for (size_t k = 0; k < hull.positions.size(); ++k) {
                    beyond = std::max(beyond, beyond_cell(hull.positions[k], piece.site, made.sites));
                    for (size_t other = 0; other < k; ++other)
                        nearest = std::min(nearest, glm::length(hull.positions[k] - hull.positions[other]));
                }
                CHECK(beyond < 1e-6);
                CHECK(nearest > 0.0049 * longest_side(hull));
            }
        }
    }
}

TEST_CASE("hull meshes: max_parts bounds their number, and threads change nothing") {
    const Cut made = cut("vase", 10);
    size_t most = 0;
    for (const auto& hulls : hull_meshes(made.fragments, {.max_parts = 1})) CHECK(hulls.size() == 1);
    for (const auto& hulls : hull_meshes(made.fragments, {.max_parts = 5})) most = std::max(most, hulls.size());
    CHECK(most == 5);
    const auto one = hull_meshes(made.fragments, {}, 1), three = hull_meshes(made.fragments, {}, 3);
    REQUIRE(one.size() == three.size());
    for (size_t p = 0; p < one.size(); ++p) {
        REQUIRE(one[p].size() == three[p].size());
        for (size_t k = 0; k < one[p].size(); ++k) CHECK(one[p][k].positions == three[p][k].positions);
    }
}

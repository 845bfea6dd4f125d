#include "physics/cutting/polytope.h"

#include <cmath>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/base/random.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

CollisionHull box_hull(const glm::vec3& half) {
    CollisionHull hull;
    for (int k = 0; k < 8; ++k) hull.points.push_back(half * glm::vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1));
    hull.faces = hull_faces(hull.points);
    return hull;
}

} // namespace

TEST_CASE("polytope: no points give an empty one, which stays empty") {
    Polytope none = Polytope::around({}, 0.1, glm::dvec3(0.0));
    CHECK(none.empty());
    none.cut({{1, 0, 0}, 0.0});
    CHECK(none.volume() == 0.0);
}

TEST_CASE("polytope: that of a box has its volume, its box and its support") {
    const fracture::Box box{{-1.0, 2.0, 0.5}, {2.0, 4.0, 1.0}};
    const Polytope whole = Polytope::of(box);
    CHECK(whole.face_count() == 6);
    CHECK(whole.volume() == doctest::Approx(3.0));
    CHECK(whole.box().min == box.min);
    CHECK(whole.box().max == box.max);
    CHECK(whole.support({1, 0, 0}) == 2.0);
    CHECK(whole.support({0, -1, 0}) == -2.0);
    CHECK(whole.support({1, 1, -2}) == doctest::Approx(5.0));
    CHECK(std::isinf(Polytope().support({1, 0, 0})));
}

TEST_CASE("polytope: a box moved outwards and cut by planes has the volume that is left") {
    const CollisionHull hull = box_hull({0.5f, 1.0f, 1.5f});
    const glm::dvec3 at(3.0, -2.0, 1.0);
    const Polytope whole = Polytope::around(hull, 0.1, at);
    CHECK(whole.volume() == doctest::Approx(1.2 * 2.2 * 3.2));
    CHECK(glm::distance(whole.centre(), at) < 1e-9);
    Polytope half = whole;
    half.cut({{0, 1, 0}, at.y});
    CHECK(half.volume() == doctest::Approx(0.6 * 2.2 * 3.2));
    half.cut({{0, 1, 0}, at.y}); // again, along the new face
    CHECK(half.volume() == doctest::Approx(0.6 * 2.2 * 3.2));
    Polytope corner = whole; // the plane through the middles of three edges at a corner
    const glm::dvec3 normal = glm::normalize(glm::dvec3(1.0 / 0.6, 1.0 / 1.1, 1.0 / 1.6));
    corner.cut({normal, glm::dot(normal, at + glm::dvec3(0.0, 1.1, 1.6))});
    CHECK(whole.volume() - corner.volume() == doctest::Approx(1.2 * 2.2 * 3.2 / 48.0));
    Polytope touched = whole; // along a face: nothing is cut off, or everything
    touched.cut({{1, 0, 0}, at.x + 0.6});
    CHECK(touched.volume() == doctest::Approx(whole.volume()));
    touched.cut({{-1, 0, 0}, -(at.x + 0.6)});
    CHECK(touched.empty());
    CHECK(whole.is_beyond_one_of(std::vector<HullPlane>{{{1, 0, 0}, at.x}, {{0, 0, 1}, at.z - 2.0}}));
    CHECK_FALSE(whole.is_beyond_one_of(std::vector<HullPlane>{{{1, 0, 0}, at.x}}));
}

TEST_CASE("polytope: the cells of sites divide a box") {
    fracture::Random random(2);
    const auto place = [&] {
        const double x = random.uniform(), y = random.uniform(), z = random.uniform();
        return 2.0 * glm::dvec3(x, y, z) - 1.0;
    };
    for (int round = 0; round < 20; ++round) {
        std::vector<glm::dvec3> sites;
        for (int k = 0; k < 12; ++k) sites.push_back(place());
        sites.push_back(sites[3]); // a duplicate has the same cell
        const Polytope whole = Polytope::around(box_hull(glm::vec3(1.0f)), 0.0, glm::dvec3(0.0));
        double sum = 0.0;
        for (uint32_t cell = 0; cell < 12; ++cell) {
            Polytope part = whole;
            part.cut(cell_planes(sites, cell));
            sum += part.volume();
            if (!part.empty()) {
                const glm::dvec3 inside = part.centre();
                for (const glm::dvec3& site : sites)
                    CHECK(glm::distance(inside, sites[cell]) <= glm::distance(inside, site) + 1e-12);
            }
        }
        CHECK(sum == doctest::Approx(8.0));
    }
}

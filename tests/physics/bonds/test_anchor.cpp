#include "physics/bonds/anchor.h"

#include <algorithm>
#include <array>

#include <doctest/doctest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/base/random.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

// Returns a lower bound of a point's distance from a region, m; 0 inside. For boxes the largest of the three axis
// distances.
double distance_to(const AnchorRegion& region, const glm::dvec3& p) {
    if (const Ball* ball = std::get_if<Ball>(&region))
        return std::max(0.0, glm::distance(ball->centre, p) - ball->radius);
    const fracture::Box& box = std::get<fracture::Box>(region);
    const glm::dvec3 out = glm::max(box.min - p, p - box.max);
    return std::max({0.0, out.x, out.y, out.z});
}

} // namespace

TEST_CASE("reaches() agrees with a fine sampling of the triangle") {
    fracture::Random random(11);
    const fracture::Box around{{-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}};
    for (const AnchorRegion& region : {AnchorRegion(fracture::Box{{-0.3, -0.2, -0.1}, {0.3, 0.2, 0.1}}),
                                       AnchorRegion(Ball{{0.1, -0.1, 0.0}, 0.25})}) {
        CAPTURE(region.index());
        int hits = 0, misses = 0, unsure = 0;
        for (int i = 0; i < 300; ++i) {
            const glm::dvec3 a = random.uniform_in(around), b = random.uniform_in(around),
                             c = random.uniform_in(around);
            constexpr int n = 60;
            const double slack = 3.0 / n; // sample spacing on sides below 3.5 m
            double nearest = 10.0;
            for (int u = 0; u <= n; ++u)
                for (int v = 0; v + u <= n; ++v)
                    nearest = std::min(nearest, distance_to(region, a + (b - a) * (static_cast<double>(u) / n)
                                                                        + (c - a) * (static_cast<double>(v) / n)));
            if (nearest == 0.0) CHECK(reaches(region, a, b, c));
            if (nearest > slack) CHECK_FALSE(reaches(region, a, b, c));
            (nearest == 0.0 ? hits : nearest > slack ? misses : unsure) += 1;
        }
        CHECK(hits > 30);
        CHECK(misses > 30);
    }
}

TEST_CASE("a ball of radius 0 is a point, and triangles without area reach regions that they touch") {
    const glm::dvec3 a(0.0), b(1.0, 0.0, 0.0), c(0.0, 1.0, 0.0);
    CHECK(reaches(Ball{{0.25, 0.25, 0.0}, 0.0}, a, b, c));
    CHECK_FALSE(reaches(Ball{{0.25, 0.25, 1e-9}, 0.0}, a, b, c));
    CHECK(reaches(Ball{{0.5, 0.1, 0.0}, 0.1}, a, b, b)); // a segment
    CHECK(reaches(Ball{{0.0, 0.0, 0.5}, 0.5}, a, a, a)); // a point
    CHECK_FALSE(reaches(Ball{{0.0, 0.0, 0.5}, 0.49}, a, a, a));
    CHECK_FALSE(reaches(std::span<const AnchorRegion>(), std::array{a, b, c}, std::array{fracture::Triangle(0, 1, 2)}));
}

TEST_CASE("anchors are found by region, by height above the ground and by predicate") {
    const fracture::Fragments fragments = test::bonded_grid(glm::dvec3(0.0), glm::dvec3(1.0), 2, 4, 1);
    CHECK(anchor_to_ground(fragments) == std::vector<uint32_t>{0, 4});
    CHECK(anchor_to_ground(fragments, {}, 0.0f, 0.3f) == std::vector<uint32_t>{0, 1, 4, 5});
    CHECK(anchor_to_ground(fragments, {{0.0f, 1.0f, 0.0f}, {1.0f, 0.0f, 0.0f, 0.0f}}).empty());
    const glm::quat upside_down(0.0f, 0.0f, 0.0f, 1.0f);
    CHECK(anchor_to_ground(fragments, {{0.0f, 1.0f, 0.0f}, upside_down}) == std::vector<uint32_t>{3, 7});
    CHECK(anchor_where(fragments, [](const fracture::Piece& piece) { return piece.mass.centre_of_mass.x > 0.5; })
          == std::vector<uint32_t>{4, 5, 6, 7});
    // A ball at an upper corner, and a box along the top of the other column.
    const std::vector<AnchorRegion> corner{Ball{{0.0, 1.0, 0.0}, 0.2}};
    CHECK(anchor_to(fragments, corner) == std::vector<uint32_t>{3});
    const std::vector<AnchorRegion> both{Ball{{0.0, 1.0, 0.0}, 0.2}, fracture::Box{{0.6, 0.95, 0.0}, {1.0, 1.05, 1.0}}};
    CHECK(anchor_to(fragments, both) == std::vector<uint32_t>{3, 7});
    CHECK(anchor_to(fragments, {}).empty());
    CHECK(anchor_to({}, both).empty());
}

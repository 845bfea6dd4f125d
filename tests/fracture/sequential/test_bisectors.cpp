#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "fracture/base/random.h"
#include "fracture/sequential/bisectors.h"
#include "fracture/sites/sites.h"

using namespace brittle::fracture;

namespace {

const Box unit{glm::dvec3(-1.0), glm::dvec3(1.0)};

uint32_t nearest(std::span<const glm::dvec3> sites, const glm::dvec3& point) {
    uint32_t best = 0;
    for (uint32_t i = 1; i < sites.size(); ++i)
        if (glm::distance(sites[i], point) < glm::distance(sites[best], point)) best = i;
    return best;
}

bool inside(const CellBounds& cell, uint32_t site, const glm::dvec3& point) {
    return !cell.empty && std::all_of(cell.bisectors.begin(), cell.bisectors.end(), [&](const Bisector& plane) {
        return plane.keeps(site, plane.value(point));
    });
}

} // namespace

TEST_CASE("a single site has no bisectors and keeps everything") {
    const std::vector<glm::dvec3> sites{{0.3, 0.2, 0.1}};
    const CellBounds cell = cell_bounds(sites, 0, unit);
    CHECK_FALSE(cell.empty);
    CHECK(cell.bisectors.empty());
}

TEST_CASE("of duplicate sites the one with the lowest index owns the cell") {
    const std::vector<glm::dvec3> sites{{0.5, 0, 0}, {-0.5, 0, 0}, {0.5, 0, 0}, {0.5, 0, 0}};
    CHECK_FALSE(cell_bounds(sites, 0, unit).empty);
    CHECK(cell_bounds(sites, 0, unit).bisectors.size() == 1);
    CHECK_FALSE(cell_bounds(sites, 1, unit).empty);
    CHECK(cell_bounds(sites, 2, unit).empty);
    CHECK(cell_bounds(sites, 3, unit).empty);
}

TEST_CASE("a cell that does not meet the box is empty") {
    const std::vector<glm::dvec3> sites{{0, 0, 0}, {10, 0, 0}};
    CHECK_FALSE(cell_bounds(sites, 0, unit).empty);
    CHECK(cell_bounds(sites, 0, unit).bisectors.empty());
    CHECK(cell_bounds(sites, 1, unit).empty);
}

TEST_CASE("a box without thickness has valid cells") {
    const std::vector<glm::dvec3> sites{{0, 0, 0}, {1, 0, 0}};
    CHECK(cell_bounds(sites, 0, {{0, 0, 0}, {1, 1, 0}}).bisectors.size() == 1);
    CHECK_NOTHROW((void)cell_bounds(sites, 0, {glm::dvec3(0.2), glm::dvec3(0.2)}));
}

TEST_CASE("the plane between two sites is the same from both sides") {
    const std::vector<glm::dvec3> sites{{0.1, 0.7, -0.3}, {0.4, -0.2, 0.9}};
    const Bisector a = bisector(sites, 0, 1);
    const Bisector b = bisector(sites, 1, 0);
    CHECK(a.low == 0);
    CHECK(a.high == 1);
    CHECK(a.normal == b.normal);
    CHECK(a.midpoint == b.midpoint);
    CHECK(a.value(sites[0]) < 0.0);
    CHECK(a.value(sites[1]) > 0.0);
    CHECK(a.other(0) == 1);
    CHECK(a.other(1) == 0);
    // A point on the plane belongs to the lower site only.
    CHECK(a.keeps(0, 0.0));
    CHECK_FALSE(a.keeps(1, 0.0));
}

TEST_CASE("the plane between sites that almost coincide does not underflow") {
    const std::vector<glm::dvec3> sites{{5e-324, 0, 0}, {-5e-324, 0, 0}, {1e40, 3e40, 0}};
    CHECK(bisector(sites, 0, 1).value({1e-3, 0, 0}) < -1e-4);
    CHECK(bisector(sites, 0, 1).value({-1e-3, 0, 0}) > 1e-4);
    CHECK(bisector(sites, 0, 2).value({0, 0, 0}) < -1e39);
    CHECK(bisector(sites, 0, 2).normal.x * 3.0 == doctest::Approx(bisector(sites, 0, 2).normal.y));
}

TEST_CASE("many sites in a heap a billionth of the box wide still share the box among them") {
    // The cells are cones from almost one point: their corners are far coarser than their middle.
    std::vector<glm::dvec3> sites = uniform_sites(unit, 40, 5);
    for (glm::dvec3& s : sites) s = sites[0] + (s - sites[0]) * 1e-9;
    std::vector<CellBounds> cells;
    for (uint32_t i = 0; i < sites.size(); ++i) cells.push_back(cell_bounds(sites, i, unit));
    Random random(6);
    for (int k = 0; k < 300; ++k) {
        const glm::dvec3 point = random.uniform_in(unit);
        uint32_t owners = 0;
        for (uint32_t i = 0; i < sites.size(); ++i) owners += inside(cells[i], i, point) ? 1 : 0;
        CHECK(owners == 1);
    }
}

TEST_CASE("the bisectors of a cell hold exactly the points nearest to its site") {
    for (const uint64_t seed : {1, 2, 3}) {
        const auto sites = uniform_sites(unit, 60, seed);
        std::vector<CellBounds> cells;
        for (uint32_t i = 0; i < sites.size(); ++i) cells.push_back(cell_bounds(sites, i, unit));
        Random random(seed + 100);
        for (int k = 0; k < 500; ++k) {
            const glm::dvec3 point = random.uniform_in(unit);
            const uint32_t owner = nearest(sites, point);
            for (uint32_t i = 0; i < sites.size(); ++i) {
                CAPTURE(i);
                REQUIRE(inside(cells[i], i, point) == (i == owner));
            }
        }
    }
}

TEST_CASE("few bisectors are left of many sites") {
    const auto sites = uniform_sites(unit, 1000, 5);
    size_t sum = 0;
    for (uint32_t i = 0; i < 50; ++i) {
        const CellBounds cell = cell_bounds(sites, i, unit);
        sum += cell.bisectors.size();
        const auto distance = [&](const Bisector& plane) { return glm::distance(sites[i], sites[plane.other(i)]); };
        CHECK(std::is_sorted(cell.bisectors.begin(), cell.bisectors.end(),
                             [&](const Bisector& a, const Bisector& b) { return distance(a) < distance(b); }));
    }
    CHECK(sum >= 50 * 10);
    CHECK(sum <= 50 * 20); // the mean of a Poisson-Voronoi cell is 15.5
}

TEST_CASE("the middle cell of a lattice is bounded by its six neighbours, and possibly by touching ones") {
    std::vector<glm::dvec3> sites;
    for (int x = -2; x <= 2; ++x)
        for (int y = -2; y <= 2; ++y)
            for (int z = -2; z <= 2; ++z) sites.emplace_back(x, y, z);
    const CellBounds cell = cell_bounds(sites, 62, {glm::dvec3(-3.0), glm::dvec3(3.0)});
    CHECK_FALSE(cell.empty);
    CHECK(cell.bisectors.size() >= 6);
    CHECK(cell.bisectors.size() <= 26);
    for (size_t i = 0; i < 6; ++i) CHECK(glm::distance(sites[62], sites[cell.bisectors[i].other(62)]) == 1.0);
}

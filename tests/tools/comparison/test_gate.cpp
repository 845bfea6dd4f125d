// The oracle and the gate of tools/compare, against closed forms and against pieces with one fault each.
#include <algorithm>
#include <cmath>
#include <numeric>

#include <doctest/doctest.h>

#include "tools/comparison/gate/checks.h"
#include "tools/comparison/gate/oracle.h"

using namespace brittle::comparison;

namespace {

constexpr uint64_t all_exact = 1'000'000;

Part box(const Point& low, const Point& high) {
    Part part;
    for (int k = 0; k < 8; ++k)
        part.points.push_back({(k & 1 ? high : low)[0], (k & 2 ? high : low)[1], (k & 4 ? high : low)[2]});
    part.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                      {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    return part;
}

void append(Part& to, const Part& from, bool inside_out = false) {
    const auto offset = static_cast<uint32_t>(to.points.size());
    to.points.insert(to.points.end(), from.points.begin(), from.points.end());
    for (const Corners& t : from.triangles) {
        to.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
        if (inside_out) std::swap(to.triangles.back()[1], to.triangles.back()[2]);
    }
}

// A lattice of sites in the cube from -1 to 1, and its boxes.
std::vector<Point> lattice(int n) {
    std::vector<Point> sites;
    for (int k = 0; k < n * n * n; ++k)
        sites.push_back({(2.0 * (k % n) + 1.0) / n - 1.0, (2.0 * (k / n % n) + 1.0) / n - 1.0,
                         (2.0 * (k / n / n) + 1.0) / n - 1.0});
    return sites;
}
std::vector<Part> octants() {
    std::vector<Part> parts;
    for (const Point& s : lattice(2))
        parts.push_back(box({s[0] - 0.5, s[1] - 0.5, s[2] - 0.5}, {s[0] + 0.5, s[1] + 0.5, s[2] + 0.5}));
    return parts;
}

double sum(const CellVolumes& volumes) {
    return std::accumulate(volumes.cells.begin(), volumes.cells.end(), 0.0,
                           [](double total, const CellVolume& cell) { return total + cell.volume; });
}

Verdict check_octants(const std::vector<Part>& parts) {
    static const Part cube = box({-1, -1, -1}, {1, 1, 1});
    static const std::vector<Point> sites = lattice(2);
    static const std::vector<double> volumes(8, 1.0);
    return Gate(cube, sites, volumes).check(parts);
}

} // namespace

TEST_CASE("oracle: one site, sites at one place, and sites far away") {
    const Part cube = box({-1, -1, -1}, {1, 1, 1});
    const std::vector<Point> one{{5, 5, 5}};
    CHECK(cell_volumes(cube, one, all_exact).cells[0].volume == 8.0);
    const std::vector<Point> same{{0.1, 0, 0}, {0.1, 0, 0}, {0.1, 0, 0}};
    const CellVolumes volumes = cell_volumes(cube, same, all_exact);
    CHECK(volumes.cells[0].volume == 8.0);
    CHECK(volumes.cells[1].volume == 0.0);
    CHECK(volumes.cells[2].volume == 0.0);
    const std::vector<Point> outside{{0, 0, 0}, {100, 0, 0}};
    CHECK(cell_volumes(cube, outside, all_exact).cells[1].volume == 0.0);
}

TEST_CASE("oracle: bisectors through vertices, along edges and in faces") {
    const Part cube = box({-1, -1, -1}, {1, 1, 1});
    for (const int n : {2, 3, 4}) {
        const CellVolumes volumes = cell_volumes(cube, lattice(n), all_exact);
        for (const CellVolume& cell : volumes.cells) {
            CHECK(cell.exact);
            CHECK(cell.volume == doctest::Approx(8.0 / (n * n * n)).epsilon(1e-15));
        }
    }
    const std::vector<Point> mirrored{{0.5, 0, 0}, {1.5, 0, 0}, {0.5, 2, 0}};
    const CellVolumes volumes = cell_volumes(cube, mirrored, all_exact);
    CHECK(volumes.cells[0].volume == 8.0);
    CHECK(volumes.cells[1].volume == 0.0);
    CHECK(volumes.cells[2].volume == 0.0);
}

TEST_CASE("oracle: a tetrahedron cut at a third, a box with a cavity, two boxes apart") {
    const Part tetrahedron{{{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {0, 0, 3}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
    const std::vector<Point> along_z{{0, 0, 0.5},
                                     {0, 0, 1.5}}; // the plane z = 1: a similar tetrahedron of two thirds above
    const CellVolumes cut = cell_volumes(tetrahedron, along_z, all_exact);
    CHECK(cut.cells[1].volume == doctest::Approx(4.5 * 8.0 / 27.0).epsilon(1e-15));
    CHECK(cut.cells[0].volume == doctest::Approx(4.5 * 19.0 / 27.0).epsilon(1e-15));
    CHECK(cut.deviation < 1e-14);

    Part hollow = box({-1, -1, -1}, {1, 1, 1});
    append(hollow, box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}), true);
    for (const CellVolume& cell : cell_volumes(hollow, lattice(2), all_exact).cells) CHECK(cell.volume == 0.875);

    Part apart = box({0, 0, 0}, {1, 1, 1});
    append(apart, box({2, 0, 0}, {3, 1, 1}));
    const std::vector<Point> across{{1.5, 0.25, 0.5}, {1.5, 0.75, 0.5}};
    for (const CellVolume& cell : cell_volumes(apart, across, all_exact).cells) CHECK(cell.volume == 1.0);
}

TEST_CASE("oracle: doubles agree with rational numbers on random sites, and the sum is the solid") {
    const Part solid{{{0, 0, 0}, {3, 0.25, 0}, {0.5, 2.75, 0.1}, {0.3, 0.7, 2.9}},
                     {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
    std::vector<Point> sites;
    uint32_t state = 1;
    const auto next = [&] { return 3.0 * (state = state * 1664525u + 1013904223u) / 4294967296.0; };
    for (int k = 0; k < 60; ++k) {
        Point& site = sites.emplace_back();
        for (double& x : site) x = next();
    }
    const double whole = cell_volumes(solid, std::vector<Point>{{0, 0, 0}}, all_exact).cells[0].volume;
    const CellVolumes exact = cell_volumes(solid, sites, all_exact), rounded = cell_volumes(solid, sites, 1);
    CHECK(exact.deviation < 1e-14);
    CHECK(sum(exact) == doctest::Approx(whole).epsilon(1e-15));
    CHECK(sum(rounded) == doctest::Approx(whole).epsilon(1e-14));
    CHECK(std::ranges::count_if(rounded.cells, [](const CellVolume& cell) { return cell.exact; }) < 5);
}

TEST_CASE("cells for others: closed boxes of a lattice, around the mesh") {
    const Part cube = box({-1, -1, -1}, {1, 1, 1});
    const std::vector<Part> cells = voronoi_cells(cube, lattice(3));
    REQUIRE(cells.size() == 27);
    for (const Part& cell : cells) {
        CHECK(cell.points.size() == 8);
        CHECK(cell.triangles.size() == 12);
    }
}

TEST_CASE("gate: sound pieces pass") {
    std::vector<Part> parts = octants();
    const Verdict verdict = check_octants(parts);
    CHECK(verdict.reason() == "");
    CHECK(verdict.pieces == 8);
    CHECK(verdict.equal_caps == 1.0);
    CHECK(verdict.volume_error < 1e-15);
    // The other diagonal on one side of one of twelve caps.
    parts[0].triangles[10] = {1, 3, 5};
    parts[0].triangles[11] = {3, 7, 5};
    CHECK(check_octants(parts).reason() == "");
    CHECK(check_octants(parts).equal_caps == doctest::Approx(11.0 / 12.0));
}

TEST_CASE("gate: vertices that differ by less than the tolerance are one") {
    std::vector<Part> parts = octants();
    Part soup;
    for (const Corners& t : parts[0].triangles) {
        for (const uint32_t v : t) {
            soup.points.push_back(parts[0].points[v]);
            soup.points.back()[0] += 1e-8 * static_cast<double>(soup.points.size());
        }
        const auto count = static_cast<uint32_t>(soup.points.size());
        soup.triangles.push_back({count - 3, count - 2, count - 1});
    }
    parts[0] = soup;
    const Verdict verdict = check_octants(parts);
    CHECK(verdict.reason() == "");
    CHECK(verdict.open_exactly == 1);
}

TEST_CASE("gate: each fault is found, and named") {
    std::vector<Part> parts = octants();
    SUBCASE("no pieces") {
        CHECK(check_octants({}).reason() == "no pieces");
    }
    SUBCASE("a triangle is missing") {
        parts[3].triangles.pop_back();
        CHECK(check_octants(parts).open == 1);
    }
    SUBCASE("a piece is inside out") {
        Part turned;
        append(turned, parts[5], true);
        parts[5] = turned;
        CHECK(check_octants(parts).negative == 1);
        CHECK(check_octants(parts).wrong_cells == 1);
    }
    SUBCASE("a piece is missing") {
        parts.erase(parts.begin() + 2);
        const Verdict verdict = check_octants(parts);
        CHECK(verdict.wrong_cells == 1);
        CHECK(verdict.wrong_caps == 3);
    }
    SUBCASE("a cut lies a thousandth too far") {
        for (Point& p : parts[0].points) p[0] = p[0] == 0.0 ? 1e-3 : p[0];
        const Verdict verdict = check_octants(parts);
        CHECK(verdict.wrong_cells == 1);
        CHECK(verdict.wrong_caps == 3);
        CHECK(verdict.worst_cell == doctest::Approx(1e-3));
    }
    SUBCASE("two parts of a cell are one piece") {
        parts[7] = box({0, 0, 0}, {1, 1, 0.25});
        append(parts[7], box({0, 0, 0.5}, {1, 1, 1}));
        CHECK(check_octants(parts).joined_islands == 1);
    }
    SUBCASE("a vertex is pulled through the opposite side") {
        parts[6].points[0] = {-0.4, 0.6, 2.0};
        CHECK(check_octants(parts).crossing == 1);
    }
    SUBCASE("a cap has a dent on one side only") {
        Part& piece = parts[0]; // its side x = 0 is the triangles 10 and 11
        piece.points.push_back({-0.25, -0.5, -0.5});
        piece.triangles.resize(10);
        for (const auto& [a, b] : {std::pair{1u, 3u}, {3u, 7u}, {7u, 5u}, {5u, 1u}})
            piece.triangles.push_back({a, b, 8});
        const Verdict verdict = check_octants(parts);
        CHECK(verdict.open == 0);
        CHECK(verdict.wrong_cells == 1);
        CHECK(verdict.wrong_caps == 1);
    }
}

TEST_CASE("gate: a surface in the plane of a bisector is no cap") {
    const Part cube = box({-1, -1, -1}, {1, 1, 1});
    const std::vector<Point> mirrored{{0.5, 0, 0}, {1.5, 0, 0}};
    const std::vector<double> volumes{8.0, 0.0};
    CHECK(Gate(cube, mirrored, volumes).check({cube}).reason() == "");
}

TEST_CASE("gate: pieces may cross themselves along the crossings of the input, and nowhere else") {
    Part input = box({-1, -1, -1}, {1, 1, 1});
    append(input, box({0.2, -2, 0.3}, {0.7, 2, 1.6}));
    const std::vector<Point> sites{{0, -1, 0}, {0, 1.2, 0}}; // cut at y = 0.1
    const std::vector<double> volumes{1.0, 1.0};             // not asked here
    const Gate gate(input, sites, volumes);
    const auto below = [](double moved) {
        Part piece = box({-1, -1, -1}, {1, 0.1, 1});
        append(piece, box({0.2 + moved, -2, 0.3}, {0.7 + moved, 0.1, 1.6}));
        return piece;
    };
    CHECK(gate.check({below(0.0)}).crossing == 0);
    CHECK(gate.check({below(0.02)}).crossing == 1);
}

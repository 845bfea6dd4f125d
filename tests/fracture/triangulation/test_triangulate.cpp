#include "fracture/triangulation/triangulate.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <numbers>
#include <sstream>
#include <string>
#include <utility>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/arithmetic/plane_predicates.h"
#include "fracture/base/random.h"

using namespace brittle::fracture;
using std::numbers::pi;

namespace {

struct Polygons {
    std::string name;
    std::vector<glm::dvec2> points;
    std::vector<Loop> loops;
    double area = 0.0;
    bool simple = false;
};

// Reads a corpus polygon: lines of `x y`, a blank line between loops, `#` comments. `# simple: yes|no` and `# area: A`
// state the expected result; a simple region needs no forced ear.
Polygons read_polygons(const std::filesystem::path& file) {
    Polygons p;
    p.name = file.stem().string();
    std::ifstream in(file);
    std::string line;
    bool fresh = true;
    while (std::getline(in, line)) {
        std::istringstream words(line);
        std::string hash, key, value;
        if (line.starts_with('#')) {
            words >> hash >> key >> value;
            if (key == "simple:") p.simple = value == "yes";
            if (key == "area:") p.area = std::stod(value);
            continue;
        }
        glm::dvec2 point;
        if (!(words >> point.x >> point.y)) {
            fresh = true;
            continue;
        }
        if (fresh) p.loops.emplace_back();
        fresh = false;
        p.loops.back().push_back(static_cast<uint32_t>(p.points.size()));
        p.points.push_back(point);
    }
    return p;
}

std::vector<Polygons> corpus() {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(BRITTLE_CORPUS "/polygons")) {
        files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    std::vector<Polygons> all;
    for (const auto& file : files) all.push_back(read_polygons(file));
    return all;
}

// Returns the loops with one id per position, so that loops touch themselves and each other by id.
Polygons welded(Polygons p) {
    std::map<std::pair<double, double>, uint32_t> first;
    for (Loop& loop : p.loops) {
        for (uint32_t& id : loop) id = first.try_emplace({p.points[id].x, p.points[id].y}, id).first->second;
    }
    return p;
}

double twice_area(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

double area_of(const Polygons& p, bool absolute = false) {
    const Triangulation t = triangulate(p.points, p.loops);
    double sum = 0.0;
    for (const Triangle& tri : t.triangles) {
        const double a = 0.5 * twice_area(p.points[tri.x], p.points[tri.y], p.points[tri.z]);
        sum += absolute ? std::abs(a) : a;
    }
    return sum;
}

double area_of_loops(const Polygons& p) {
    double sum = 0.0;
    for (const Loop& loop : p.loops) {
        for (size_t k = 1; k + 1 < loop.size(); ++k) {
            sum += 0.5 * twice_area(p.points[loop[0]], p.points[loop[k]], p.points[loop[k + 1]]);
        }
    }
    return sum;
}

using EdgeCounts = std::map<std::pair<uint32_t, uint32_t>, int>;

void add_edges(EdgeCounts& counts, std::initializer_list<uint32_t> cycle) {
    for (auto at = cycle.begin(); at != cycle.end(); ++at) {
        const uint32_t to = at + 1 == cycle.end() ? *cycle.begin() : *(at + 1);
        if (*at != to) ++counts[{*at, to}];
    }
}

// Checks the contract: every loop edge appears once in its direction, every other edge once in each direction. If ids
// repeat, loop edges may cancel each other, and only the balance of directions is checked.
void check_edges(const Polygons& p, const Triangulation& t) {
    EdgeCounts have, want;
    for (const Triangle& tri : t.triangles) add_edges(have, {tri.x, tri.y, tri.z});
    std::vector<uint32_t> ids;
    for (const Loop& loop : p.loops) {
        for (size_t k = 0; k < loop.size(); ++k) {
            const uint32_t a = loop[k], b = loop[(k + 1) % loop.size()];
            if (a != b) ++want[{a, b}];
        }
        ids.insert(ids.end(), loop.begin(), loop.end());
    }
    std::sort(ids.begin(), ids.end());
    const bool distinct = std::adjacent_find(ids.begin(), ids.end()) == ids.end();
    const auto count = [](const EdgeCounts& counts, uint32_t a, uint32_t b) {
        const auto at = counts.find({a, b});
        return at == counts.end() ? 0 : at->second;
    };
    int unbalanced = 0, repeated = 0, missing = 0;
    for (const EdgeCounts* counts : {&have, &want}) {
        for (const auto& [edge, n] : *counts) {
            const auto [a, b] = edge;
            unbalanced += count(have, a, b) - count(have, b, a) != count(want, a, b) - count(want, b, a);
            repeated += distinct && count(have, a, b) > 1;
            missing += distinct && count(want, a, b) > count(have, a, b);
        }
    }
    CHECK(unbalanced == 0);
    CHECK(repeated == 0);
    CHECK(missing == 0);
}

Triangulation check(const Polygons& p) {
    CAPTURE(p.name);
    const Triangulation t = triangulate(p.points, p.loops);
    check_edges(p, t);
    const double area = area_of_loops(p);
    const double scale = std::max(1.0, std::abs(area));
    CHECK(std::abs(area_of(p) - area) < 1e-12 * scale);
    if (p.simple) {
        CHECK(t.forced_ears == 0);
        int not_positive = 0;
        const bool one_direction = std::abs(area_of(p, true) - std::abs(area)) < 1e-12 * scale;
        for (const Triangle& tri : t.triangles) {
            not_positive += orientation(p.points[tri.x], p.points[tri.y], p.points[tri.z]) == 0.0;
        }
        CHECK(not_positive == 0);
        if (p.name != "hole_outside") CHECK(one_direction);
    }
    return t;
}

Polygons single(std::string name, std::vector<glm::dvec2> points, bool simple) {
    Polygons p;
    p.name = std::move(name);
    p.loops.emplace_back();
    for (uint32_t i = 0; i < points.size(); ++i) p.loops[0].push_back(i);
    p.points = std::move(points);
    p.simple = simple;
    return p;
}

// A star-shaped, hence simple polygon: random radii at increasing angles.
std::vector<glm::dvec2> random_star(Random& random, uint32_t n, double low, double high) {
    std::vector<glm::dvec2> points;
    for (uint32_t i = 0; i < n; ++i) {
        const double angle = 2 * pi * (i + 0.8 * random.uniform()) / n;
        const double radius = low + (high - low) * random.uniform();
        points.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
    }
    return points;
}

} // namespace

TEST_CASE("no loops give no triangles") {
    CHECK(triangulate({}, {}).triangles.empty());
}

TEST_CASE("loops that only go there and back give no triangles") {
    const std::vector<glm::dvec2> points = {{0, 0}, {1, 0}, {2, 0}};
    for (const Loop& loop : {Loop{0, 1, 0, 1}, Loop{0, 0, 0}, Loop{0, 1, 2, 1}, Loop{0, 1, 0, 2}}) {
        CHECK(triangulate(points, std::vector<Loop>{loop}).triangles.empty());
    }
}

TEST_CASE("every corpus polygon closes, keeps its area and needs forced ears only if it is not simple") {
    const std::vector<Polygons> all = corpus();
    REQUIRE(all.size() >= 30);
    for (const Polygons& p : all) {
        CAPTURE(p.name);
        check(p);
        CHECK(area_of(p) == doctest::Approx(p.area).epsilon(1e-9));
        check(welded(p));
    }
}

TEST_CASE("a loop of n points gives n - 2 triangles whatever its geometry") {
    for (const Polygons& p : corpus()) {
        if (p.loops.size() != 1) continue;
        CAPTURE(p.name);
        CHECK(triangulate(p.points, p.loops).triangles.size() == p.loops[0].size() - 2);
    }
}

TEST_CASE("a loop that touches itself in a vertex is two loops and needs no forced ears") {
    const Polygons p{"figure eight", {{0, 0}, {2, 0}, {1, 1}, {2, 2}, {0, 2}}, {{0, 1, 2, 4, 3, 2}}, 0.0, false};
    const Triangulation t = check(p);
    CHECK(t.triangles.size() == 2);
    CHECK(t.forced_ears == 0);
}

TEST_CASE("loops that touch in a shared vertex need no bridge and no forced ears") {
    for (Polygons p : corpus()) {
        if (p.name != "hole_touches_vertex" && p.name != "hole_inscribed" && p.name != "keyhole") continue;
        CAPTURE(p.name);
        p = welded(p);
        p.simple = true;
        check(p);
    }
}

TEST_CASE("loops that cross and share points give no triangle that names a point twice") {
    std::vector<glm::dvec2> points; // a grid of 3 x 3
    for (int k = 0; k < 9; ++k) points.emplace_back(k % 3, k / 3);
    const std::vector<std::vector<Loop>> cases = {
        {{6, 3, 5}, {5, 0, 6}}, {{6, 0, 5}, {5, 0, 3}},    {{2, 7, 6}, {8, 2, 6}},    {{6, 5, 3}, {5, 6, 0}},
        {{0, 3, 1}, {2, 3, 0}}, {{4, 5, 8, 2}, {5, 4, 2}}, {{4, 3, 8}, {3, 4, 2, 8}}, {{7, 5, 0, 4}, {4, 0, 5}}};
    for (size_t k = 0; k < cases.size(); ++k) {
        CAPTURE(k);
        const Polygons p{"crossing loops with common points", points, cases[k], 0.0, false};
        for (const Triangle& t : check(p).triangles) CHECK((t.x != t.y && t.y != t.z && t.z != t.x));
    }
}

TEST_CASE("points that are not finite give the documented count of triangles") {
    const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
    const std::vector<glm::dvec2> points = {{0, 0}, {nan, 0}, {1, inf},  {nan, nan}, {-inf, 2},
                                            {0, 1}, {.2, .2}, {.4, nan}, {.3, .3}};
    const std::vector<Loop> loops = {{0, 1, 2, 3, 4, 5}, {6, 7, 8}};
    Polygons p{"not finite", points, loops, 0.0, false};
    const Triangulation t = triangulate(points, loops);
    check_edges(p, t);
}

TEST_CASE("a convex loop becomes a Delaunay triangulation") {
    // No point lies inside the circumcircle of any triangle, tested by distances to circumcentres in long double.
    Random random(9);
    std::vector<glm::dvec2> points;
    for (int i = 0; i < 60; ++i) {
        const double a = 2 * pi * (i + 0.5 * random.uniform()) / 60;
        points.emplace_back(3 * std::cos(a), std::sin(a));
    }
    const Polygons p = single("ellipse", points, true);
    const Triangulation t = check(p);
    for (const Triangle& tri : t.triangles) {
        const glm::dvec2 a = points[tri.x], b = points[tri.y] - a, c = points[tri.z] - a;
        const double d = 2 * (b.x * c.y - b.y * c.x);
        const glm::dvec2 centre(c.y * dot(b, b) - b.y * dot(c, c), b.x * dot(c, c) - c.x * dot(b, b));
        const double radius = length(centre / d);
        for (const glm::dvec2& q : points) CHECK(length(q - a - centre / d) > radius * (1 - 1e-9));
    }
}

TEST_CASE("random star polygons of any size are triangulated without forced ears") {
    Random random(1);
    for (uint32_t n = 3; n < 60; ++n) {
        for (int round = 0; round < 10; ++round) {
            check(single("star " + std::to_string(n), random_star(random, n, 0.05, 1.0), true));
        }
    }
}

TEST_CASE("random stars with random holes and islands are triangulated without forced ears") {
    Random random(2);
    for (int round = 0; round < 100; ++round) {
        Polygons p;
        p.name = "holes " + std::to_string(round);
        p.simple = true;
        const auto add = [&](std::vector<glm::dvec2> loop, glm::dvec2 centre, double scale, bool hole) {
            if (hole) std::reverse(loop.begin(), loop.end());
            p.loops.emplace_back();
            for (const glm::dvec2& q : loop) {
                p.loops.back().push_back(static_cast<uint32_t>(p.points.size()));
                p.points.push_back(centre + q * scale);
            }
        };
        add(random_star(random, 40, 8.0, 12.0), {0, 0}, 1.0, false);
        for (int x = -2; x <= 2; ++x) {
            for (int y = -2; y <= 2; ++y) {
                const auto corners = static_cast<uint32_t>(3 + random.next() % 20);
                add(random_star(random, corners, 0.5, 1.0), glm::dvec2(x, y) * 2.2, 1.0, true);
                if (corners < 8) continue;
                add(random_star(random, 7, 0.5, 1.0), glm::dvec2(x, y) * 2.2, 0.3, false);
            }
        }
        // Nested loops may come in any order.
        for (size_t i = p.loops.size(); i > 1; --i) std::swap(p.loops[i - 1], p.loops[random.next() % i]);
        check(p);
    }
}

TEST_CASE("a reused triangulator gives the triangles of a new one") {
    Triangulator used;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    std::vector<Polygons> all = corpus();
    for (const Polygons& p : corpus()) all.push_back(welded(p));
    all.push_back({"nothing", {}, {}, 0.0, false});
    all.push_back({"not finite", {{0, 0}, {nan, 0}, {1, nan}, {2, 2}}, {{0, 1, 2, 3}}, 0.0, false});
    // Twice, the second time in reverse order: large regions after small ones, and small after large.
    for (int pass = 0; pass < 2; ++pass) {
        for (const Polygons& p : all) {
            CAPTURE(p.name);
            const Triangulation fresh = triangulate(p.points, p.loops);
            const Triangulation& again = used.run(p.points, p.loops);
            CHECK(again.triangles == fresh.triangles);
            CHECK(again.forced_ears == fresh.forced_ears);
            CHECK(again.vertex_tests == fresh.vertex_tests);
        }
        std::reverse(all.begin(), all.end());
    }
}

TEST_CASE("random tangled loops on a coarse lattice always close") {
    Random random(3);
    for (int round = 0; round < 3000; ++round) {
        Polygons p;
        p.name = "tangle " + std::to_string(round);
        const uint64_t lattice = 2 + random.next() % 6;
        const uint64_t loops = 1 + random.next() % 4;
        for (uint64_t l = 0; l < loops; ++l) {
            p.loops.emplace_back();
            for (uint64_t k = 3 + random.next() % 12; k > 0; --k) {
                p.loops.back().push_back(static_cast<uint32_t>(p.points.size()));
                p.points.emplace_back(static_cast<double>(random.next() % lattice),
                                      static_cast<double>(random.next() % lattice));
            }
        }
        check(p);
        check(welded(p));
    }
}

TEST_CASE("the count of vertex tests is near linear in the size of large loops") {
    Random random(8);
    for (const uint32_t n : {1000u, 10'000u, 40'000u}) {
        CAPTURE(n);
        // Noise much larger than the spacing: about half of the corners are reflex, in deep notches.
        const Polygons noisy = single("noisy", random_star(random, n, 0.9, 1.0), true);
        CHECK(triangulate(noisy.points, noisy.loops).vertex_tests < 60 * n); // quadratic would be 20,000 n

        // A comb: all tips block each other's large triangles.
        std::vector<glm::dvec2> comb;
        for (uint32_t k = 0; k < n / 2; ++k) {
            comb.emplace_back(k, 0.1 * random.uniform());
            comb.emplace_back(k + 0.5, 0.8 * n);
        }
        comb.emplace_back(n / 2, -1.0);
        comb.emplace_back(-1.0, -1.0);
        std::reverse(comb.begin(), comb.end());
        const Polygons teeth = single("comb", comb, false);
        const Triangulation t = triangulate(teeth.points, teeth.loops);
        CHECK(t.forced_ears == 0);
        CHECK(t.vertex_tests < 60 * n);
    }
}

TEST_CASE("points rounded to a line, one unit in the last place apart, are triangulated without forced ears") {
    // Collinear up to rounding: only exact signs decide which triangles are positive.
    Random random(4);
    for (int round = 0; round < 200; ++round) {
        std::vector<glm::dvec2> points;
        const glm::dvec2 a(random.uniform(), random.uniform()), b(random.uniform() + 1.0, random.uniform());
        for (int k = 0; k <= 12; ++k) points.push_back(a + (b - a) * (k / 12.0));
        points.emplace_back(b.x, b.y + 1.0);
        points.emplace_back(a.x, a.y + 1.0);
        check(single("nearly straight", points, true));
    }
}

TEST_CASE("projection keeps loops counter-clockwise as seen against the normal") {
    Random random(6);
    for (int round = 0; round < 300; ++round) {
        const Box box{glm::dvec3(-1), glm::dvec3(1)};
        const glm::dvec3 a = random.uniform_in(box), b = random.uniform_in(box), c = random.uniform_in(box);
        const glm::dvec3 normal = cross(b - a, c - a);
        CHECK(twice_area(project(a, normal), project(b, normal), project(c, normal)) > 0.0);
        CHECK(twice_area(project(a, -normal), project(b, -normal), project(c, -normal)) < 0.0);
    }
    CHECK(project({1, 2, 3}, {0, 0, 1}) == glm::dvec2(1, 2));
    CHECK(project({1, 2, 3}, {1, 0, 0}) == glm::dvec2(2, 3));
    CHECK(project({1, 2, 3}, {0, 1, 0}) == glm::dvec2(3, 1));
}

TEST_CASE("orientation is exact where doubles round") {
    // Kettner et al., "Classroom examples of robustness problems": points one ulp apart near a diagonal.
    const glm::dvec2 q(12, 12), r(24, 24);
    for (int i = 0; i < 64; ++i) {
        for (int j = 0; j < 64; ++j) {
            const glm::dvec2 p(0.5 + i * 0x1p-53, 0.5 + j * 0x1p-53);
            const double sign = orientation(p, q, r);
            CHECK((sign > 0.0) == (p.y > p.x));
            CHECK((sign < 0.0) == (p.y < p.x));
            CHECK((orientation(q, p, r) > 0.0) == (sign < 0.0));
        }
    }
}

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <boost/multiprecision/cpp_int.hpp>

#include "fracture/exact/predicates.h"
#include "fracture/random.h"

using namespace brittle::fracture;
using namespace brittle::fracture::exact;
using glm::dvec3;
using Rational = boost::multiprecision::cpp_rational;

namespace {

// ---- The oracle: definitions in rational numbers, absolute coordinates, weights as actual numbers
// -------------

struct Vec {
    Rational x, y, z;
};
Vec vec(const dvec3& p) {
    return {Rational(p.x), Rational(p.y), Rational(p.z)};
}
Vec operator-(const Vec& a, const Vec& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
Rational dot(const Vec& a, const Vec& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
Vec cross(const Vec& a, const Vec& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// n.x = k
struct Plane {
    Vec n;
    Rational k;
};

// The point of three planes by Cramer's rule; false where there is none.
bool meet(const Plane& a, const Plane& b, const Plane& c, Vec& point) {
    const Vec bc = cross(b.n, c.n);
    const Vec ca = cross(c.n, a.n);
    const Vec ab = cross(a.n, b.n);
    const Rational w = dot(a.n, bc);
    if (w == 0) return false;
    point = {(a.k * bc.x + b.k * ca.x + c.k * ab.x) / w, (a.k * bc.y + b.k * ca.y + c.k * ab.y) / w,
             (a.k * bc.z + b.k * ca.z + c.k * ab.z) / w};
    return true;
}

// Sites with weights w_i = e^(r + 1), r the rank of i among the sites involved, e = 2^-bits; bits = 0: no
// weights.
struct Oracle {
    const Diagram* diagram;
    std::vector<SiteId> involved;
    unsigned bits = 0;

    Rational weight(SiteId i) const {
        if (bits == 0) return 0;
        unsigned rank = 1;
        for (const SiteId j : involved) rank += j < i;
        return Rational(1, boost::multiprecision::cpp_int(1) << (bits * rank));
    }
    Vec site(SiteId i) const { return vec(diagram->sites[i]); }
    Rational power(SiteId i, const Vec& x) const {
        const Vec d = x - site(i);
        return dot(d, d) - weight(i);
    }
    Rational g(SiteId c, SiteId l, const Vec& x) const { return power(l, x) - power(c, x); }
    Plane plane(SiteId c, PlaneId p) const {
        if (is_box_plane(p)) {
            const int axis = static_cast<int>((p - kBoxMinX) / 2);
            dvec3 n(0.0);
            n[axis] = 1.0;
            return {vec(n), Rational((p - kBoxMinX) % 2 ? diagram->box.max[axis] : diagram->box.min[axis])};
        }
        const Vec n = site(p) - site(c);
        return {{2 * n.x, 2 * n.y, 2 * n.z},
                dot(site(p), site(p)) - weight(p) - dot(site(c), site(c)) + weight(c)};
    }
    static Plane plane(const Corners& q) {
        const Vec n = cross(vec(q[1]) - vec(q[0]), vec(q[2]) - vec(q[0]));
        return {n, dot(n, vec(q[0]))};
    }

    // Each: false where the point does not exist, else the value whose sign is asked for.
    bool side1(SiteId c, SiteId l, const dvec3& q, Rational& result) const {
        result = g(c, l, vec(q));
        return true;
    }
    bool side2(SiteId c, SiteId a, SiteId l, const dvec3& q0, const dvec3& q1, Rational& result) const {
        const Rational f0 = g(c, a, vec(q0));
        const Rational f1 = g(c, a, vec(q1));
        if (f0 == f1) return false;
        const Rational t = f0 / (f0 - f1);
        const Vec p0 = vec(q0);
        const Vec e = vec(q1) - p0;
        result = g(c, l, {p0.x + t * e.x, p0.y + t * e.y, p0.z + t * e.z});
        return true;
    }
    bool side3(SiteId c, SiteId a, SiteId b, SiteId l, const Corners& q, Rational& result) const {
        Vec x;
        if (!meet(plane(c, a), plane(c, b), plane(q), x)) return false;
        result = g(c, l, x);
        return true;
    }
    bool side4(SiteId c, PlaneId a, PlaneId b, PlaneId d, SiteId l, Rational& result) const {
        Vec x;
        if (!meet(plane(c, a), plane(c, b), plane(c, d), x)) return false;
        result = g(c, l, x);
        return true;
    }
    bool pierce_order(SiteId c, SiteId a, SiteId b, const Corners& q1, const Corners& q2,
                      Rational& result) const {
        Vec x1, x2;
        if (!meet(plane(c, a), plane(c, b), plane(q1), x1)) return false;
        if (!meet(plane(c, a), plane(c, b), plane(q2), x2)) return false;
        result = dot(x1 - x2, cross(site(a) - site(c), site(b) - site(c)));
        return true;
    }
};

// The sign for infinitesimal weights; 2 where the point does not exist. Weights enter only where their
// absence gives zero, and are then made so small that the order of magnitudes is settled: halving the
// exponent must not change the sign.
template<class Ask>
int oracle_sign(const Diagram& diagram, std::vector<SiteId> involved, unsigned bits, bool& perturbed,
                Ask ask) {
    Oracle oracle{&diagram, std::move(involved), 0};
    Rational result;
    perturbed = false;
    if (!ask(oracle, result)) return 2;
    if (result != 0) return result.sign();
    perturbed = true;
    oracle.bits = bits;
    REQUIRE(ask(oracle, result));
    const int sign = result.sign();
    oracle.bits = 2 * bits;
    REQUIRE(ask(oracle, result));
    REQUIRE(result.sign() == sign);
    return sign;
}

// ---- Inputs
// ---------------------------------------------------------------------------------------------------

struct Scene {
    std::string name;
    std::vector<dvec3> sites;
    std::vector<dvec3> points;
    Box box{dvec3(-1.0), dvec3(1.0)};
    unsigned bits; // per infinitesimal, enough for the coordinates at hand
    int cases;     // per predicate
    int zeros = 0; // at least so many in a thousand answers are exact zeros, in every predicate
};

dvec3 lattice_point(Random& random, int size) {
    const auto pick = [&] { return (static_cast<double>(random.next() % (2 * size + 1)) - size) / size; };
    const double x = pick();
    const double y = pick();
    return {x, y, pick()};
}

constexpr Box kUnitBox{dvec3(-1.0), dvec3(1.0)};

Scene random_scene(Random& random) {
    Scene scene{"random", {}, {}, kUnitBox, 600, 300};
    for (int i = 0; i < 40; ++i) scene.sites.push_back(random.uniform_in(kUnitBox));
    for (int i = 0; i < 60; ++i) scene.points.push_back(random.uniform_in(kUnitBox));
    return scene;
}

Scene lattice_scene(Random& random, int size) {
    Scene scene{"lattice", {}, {}, kUnitBox, 120, 2000, size < 4 ? 20 : 1};
    for (int i = 0; i < 40; ++i) scene.sites.push_back(lattice_point(random, size)); // duplicates occur
    for (int i = 0; i < 60; ++i) scene.points.push_back(lattice_point(random, size));
    return scene;
}

// The 48 points (+-1,+-2,+-3)/4 in every order and their centre; mesh points are the centre, as often as not,
// and points of the symmetry planes.
Scene cospherical_scene(Random& random) {
    Scene scene{"cospherical", {dvec3(0.0)}, {}, kUnitBox, 120, 2000, 20};
    std::array<double, 3> p{0.25, 0.5, 0.75};
    do {
        for (int s = 0; s < 8; ++s) {
            scene.sites.emplace_back(s & 1 ? p[0] : -p[0], s & 2 ? p[1] : -p[1], s & 4 ? p[2] : -p[2]);
        }
    } while (std::next_permutation(p.begin(), p.end()));
    for (size_t i = scene.sites.size(); i > 1; --i)
        std::swap(scene.sites[i - 1], scene.sites[random.next() % i]);
    for (int i = 0; i < 60; ++i) {
        scene.points.push_back(i % 3 == 0 ? dvec3(0.0) : lattice_point(random, i % 3 == 1 ? 1 : 4));
    }
    return scene;
}

// Sites that mirror each other in a mesh vertex v, in edges and in faces through it: bisectors contain them.
// The images are exact, because everything is a multiple of 2^-20.
Scene mirrored_scene(Random& random) {
    Scene scene{"mirrored", {}, {}, kUnitBox, 400, 1000, 20};
    const auto dyadic = [&] { return std::round((random.uniform() - 0.5) * 0x1.0p+20) * 0x1.0p-20; };
    const auto point = [&] {
        const double x = dyadic();
        const double y = dyadic();
        return dvec3(x, y, dyadic());
    };
    const dvec3 v = point();
    for (int orbit = 0; orbit < 2; ++orbit) {
        const dvec3 offset = point() * 0.5;
        for (int s = 0; s < 8; ++s) {
            scene.sites.push_back(v + offset * dvec3(s & 1 ? 1 : -1, s & 2 ? 1 : -1, s & 4 ? 1 : -1));
        }
    }
    for (int i = 0; i < 15; ++i) {
        scene.points.push_back(v);
        dvec3 on_edge = v;
        on_edge[i % 3] = dyadic();
        scene.points.push_back(on_edge);
        dvec3 on_face = on_edge;
        on_face[(i + 1) % 3] = dyadic();
        scene.points.push_back(on_face);
        if (i % 3 == 0) scene.points.push_back(point());
    }
    return scene;
}

// Any scene with a third of its coordinates moved by one unit in the last place.
Scene shaken(Scene scene, Random& random) {
    const auto shake = [&](std::vector<dvec3>& points) {
        for (dvec3& p : points) {
            for (int i = 0; i < 3; ++i) {
                if (random.next() % 3 == 0) p[i] = snap(std::nextafter(p[i], random.next() % 2 ? 2.0 : -2.0));
            }
        }
    };
    shake(scene.sites);
    shake(scene.points);
    scene.name = "shaken by one ulp";
    scene.bits = 3000; // zeros next to 2^-150 occur
    scene.cases = 300;
    scene.zeros = 0;
    return scene;
}

std::vector<Scene> all_scenes() {
    Random random(7);
    std::vector<Scene> scenes{lattice_scene(random, 1),  lattice_scene(random, 2), lattice_scene(random, 4),
                              cospherical_scene(random), mirrored_scene(random),   random_scene(random)};
    scenes.push_back(shaken(lattice_scene(random, 2), random));
    scenes.push_back(shaken(cospherical_scene(random), random));
    scenes.push_back(shaken(mirrored_scene(random), random));
    return scenes;
}

// Draws arguments from a scene: different sites, different points.
struct Draw {
    const Scene& scene;
    Random random;

    std::vector<SiteId> sites(int count) {
        std::vector<SiteId> result;
        while (static_cast<int>(result.size()) < count) {
            const auto id = static_cast<SiteId>(random.next() % scene.sites.size());
            if (std::find(result.begin(), result.end(), id) == result.end()) result.push_back(id);
        }
        return result;
    }
    dvec3 point() { return scene.points[random.next() % scene.points.size()]; }
    Corners corners() {
        const dvec3 a = point();
        const dvec3 b = point();
        return {a, b, point()};
    }
    PlaneId box_plane() { return kBoxMinX + static_cast<PlaneId>(random.next() % 6); }
};

// How a scene's cases came out, so that a test can require that it tested something.
struct Tally {
    int asked = 0;
    int perturbed = 0;
    int ties = 0;
};

struct Expected {
    int sign;
    bool exists() const { return sign != 2; }
};

template<class Ask>
Expected expect(const Scene& scene, const std::vector<SiteId>& involved, Tally& tally, Ask ask) {
    const Diagram diagram{scene.sites, scene.box};
    bool perturbed;
    const int sign = oracle_sign(diagram, involved, scene.bits, perturbed, ask);
    tally.asked += sign != 2;
    tally.perturbed += perturbed;
    tally.ties += sign == 0;
    return {sign};
}

} // namespace

TEST_CASE("snap moves only coordinates below the documented magnitude") {
    CHECK(snap(0.0) == 0.0);
    CHECK(snap(0.1) == 0.1);
    CHECK(snap(-0x1.fffffffffffffp-98) == -0x1.fffffffffffffp-98);
    CHECK(snap(0x1.0p-150) == 0x1.0p-150);
    CHECK(snap(-0x1.0p-150) == -0x1.0p-150);
    CHECK(snap(0x1.0p-152) == 0.0);
    CHECK(snap(5e-324) == 0.0);
    const double x = snap(1e-31);
    CHECK(std::abs(x - 1e-31) <= 0x1.0p-151);
    CHECK(std::fmod(x, kGranularity) == 0.0);
}

TEST_CASE("of equal sites the lower index owns every point") {
    const std::vector<dvec3> sites{dvec3(0.25), dvec3(0.25), dvec3(0.25)};
    const Diagram diagram{sites, kUnitBox};
    PredicateStats stats;
    for (const dvec3& q : {dvec3(0.0), dvec3(0.25), dvec3(0.1, 0.2, 0.3)}) {
        CHECK(side1(diagram, 0, 1, q, stats) == 1);
        CHECK(side1(diagram, 1, 0, q, stats) == -1);
        CHECK(side1(diagram, 1, 2, q, stats) == 1);
    }
    CHECK(stats.perturbed == 9);
    CHECK(stats.exact_calls() == 9);
}

TEST_CASE("the four sides of a simple cell are what a drawing shows") {
    // The cell of site 0 at the origin: x < 0.25, y < 0.25, z < 0.25.
    const std::vector<dvec3> sites{dvec3(0.0),       dvec3(0.5, 0, 0),     dvec3(0, 0.5, 0),
                                   dvec3(0, 0, 0.5), dvec3(0.5, 0.5, 0.5), dvec3(0.4, 0.4, 0.4)};
    const Diagram diagram{sites, kUnitBox};
    PredicateStats stats;
    CHECK(side1(diagram, 0, 1, dvec3(0.2, 0.9, 0), stats) == 1);
    CHECK(side1(diagram, 0, 1, dvec3(0.3, -0.9, 0), stats) == -1);
    CHECK(side2(diagram, 0, 1, 2, dvec3(0, 0.2, 0), dvec3(1, 0.2, 0), stats) == 1);
    CHECK(side2(diagram, 0, 1, 2, dvec3(0, 0.3, 0), dvec3(1, 0.3, 0), stats) == -1);
    const Corners low{dvec3(-1, -1, 0.2), dvec3(1, -1, 0.2), dvec3(0, 1, 0.2)};
    const Corners high{dvec3(-1, -1, 0.3), dvec3(1, -1, 0.3), dvec3(0, 1, 0.3)};
    CHECK(side3(diagram, 0, 1, 2, 3, low, stats) == 1);
    CHECK(side3(diagram, 0, 1, 2, 3, high, stats) == -1);
    CHECK(pierce_order(diagram, 0, 1, 2, low, high, stats) == -1);
    CHECK(pierce_order(diagram, 0, 2, 1, low, high, stats) == 1);
    CHECK(pierce_direction_exact(diagram, 0, 1, 2, low, stats) == 1);
    CHECK(pierce_direction_exact(diagram, 0, 1, 3, low, stats) == 0);
    CHECK(cell_vertex_orientation_exact(diagram, 0, 1, 2, 3, stats) == 1);
    CHECK(cell_vertex_orientation_exact(diagram, 0, 1, kBoxMinY, 3, stats) == -1);
    CHECK(cell_vertex_orientation_exact(diagram, 0, 1, kBoxMinX, 3, stats) == 0);
    CHECK(side4(diagram, 0, 1, 2, 3, 5, stats) == -1);
    CHECK(side4(diagram, 0, 1, 2, kBoxMinZ, 5, stats) == 1);
    // Cube corner: site 4 is exactly as far as the other four, and loses to site 0.
    CHECK(side4(diagram, 0, 1, 2, 3, 4, stats) == side4(diagram, 1, 0, 2, 3, 4, stats));
    CHECK(edge_parameter_exact(diagram, 0, 1, dvec3(0.0), dvec3(1, 0, 0)) == 0.25);
    CHECK(cell_vertex_exact(diagram, 0, 1, 2, 3) == dvec3(0.25));
    CHECK(cell_vertex_exact(diagram, 1, 0, 2, kBoxMinZ) == dvec3(-0.25, 0.25, -1.0));
    const dvec3 weights = pierce_weights_exact(diagram, 0, 1, 2, low);
    CHECK(weights.x * low[0] + weights.y * low[1] + weights.z * low[2] == dvec3(0.25, 0.25, 0.2));
}

TEST_CASE("side1 agrees with rational arithmetic") {
    for (const Scene& scene : all_scenes()) {
        CAPTURE(scene.name);
        Draw draw{scene, Random(11)};
        const Diagram diagram{scene.sites, scene.box};
        PredicateStats stats;
        Tally tally;
        for (int i = 0; i < scene.cases; ++i) {
            const auto s = draw.sites(2);
            const dvec3 q = draw.point();
            const Expected e = expect(
                scene, s, tally, [&](const Oracle& o, Rational& r) { return o.side1(s[0], s[1], q, r); });
            REQUIRE(side1(diagram, s[0], s[1], q, stats) == e.sign);
            REQUIRE(side1_exact(diagram, s[0], s[1], q, stats) == e.sign);
            REQUIRE(side1(diagram, s[1], s[0], q, stats) == -e.sign);
        }
        CHECK(tally.ties == 0);
        CHECK(1000 * tally.perturbed >= scene.zeros * tally.asked);
    }
}

TEST_CASE("side2 agrees with rational arithmetic from both sites and both ends") {
    for (const Scene& scene : all_scenes()) {
        CAPTURE(scene.name);
        Draw draw{scene, Random(12)};
        const Diagram diagram{scene.sites, scene.box};
        PredicateStats stats;
        Tally tally;
        for (int i = 0; i < scene.cases; ++i) {
            const auto s = draw.sites(3);
            const dvec3 q0 = draw.point();
            const dvec3 q1 = draw.point();
            const Expected e = expect(scene, s, tally, [&](const Oracle& o, Rational& r) {
                return o.side2(s[0], s[1], s[2], q0, q1, r);
            });
            if (!e.exists()) continue;
            REQUIRE(side2(diagram, s[0], s[1], s[2], q0, q1, stats) == e.sign);
            REQUIRE(side2_exact(diagram, s[0], s[1], s[2], q0, q1, stats) == e.sign);
            REQUIRE(side2(diagram, s[1], s[0], s[2], q0, q1, stats) == e.sign);
            REQUIRE(side2(diagram, s[1], s[0], s[2], q1, q0, stats) == e.sign);
        }
        CHECK(tally.asked > scene.cases / 4);
        CHECK(tally.ties == 0);
        CHECK(1000 * tally.perturbed >= scene.zeros * tally.asked);
    }
}

TEST_CASE("side3 agrees with rational arithmetic from every site and corner order") {
    for (const Scene& scene : all_scenes()) {
        CAPTURE(scene.name);
        Draw draw{scene, Random(13)};
        const Diagram diagram{scene.sites, scene.box};
        PredicateStats stats;
        Tally tally;
        for (int i = 0; i < scene.cases; ++i) {
            auto s = draw.sites(4);
            const Corners q = draw.corners();
            const Expected e = expect(scene, s, tally, [&](const Oracle& o, Rational& r) {
                return o.side3(s[0], s[1], s[2], s[3], q, r);
            });
            if (!e.exists()) {
                REQUIRE(pierce_direction_exact(diagram, s[0], s[1], s[2], q, stats) == 0);
                continue;
            }
            REQUIRE(pierce_direction_exact(diagram, s[0], s[1], s[2], q, stats) != 0);
            REQUIRE(side3(diagram, s[0], s[1], s[2], s[3], q, stats) == e.sign);
            std::sort(s.begin(), s.begin() + 3);
            do {
                REQUIRE(side3_exact(diagram, s[0], s[1], s[2], s[3], q, stats) == e.sign);
            } while (std::next_permutation(s.begin(), s.begin() + 3));
            REQUIRE(side3(diagram, s[2], s[0], s[1], s[3], {q[1], q[0], q[2]}, stats) == e.sign);
            REQUIRE(side3(diagram, s[1], s[0], s[2], s[3], {q[2], q[0], q[1]}, stats) == e.sign);
        }
        CHECK(tally.asked > scene.cases / 4);
        CHECK(tally.ties == 0);
        CHECK(1000 * tally.perturbed >= scene.zeros * tally.asked);
    }
}

TEST_CASE("side4 agrees with rational arithmetic from every site") {
    for (const Scene& scene : all_scenes()) {
        CAPTURE(scene.name);
        Draw draw{scene, Random(14)};
        const Diagram diagram{scene.sites, scene.box};
        PredicateStats stats;
        Tally tally;
        for (int i = 0; i < scene.cases; ++i) {
            auto s = draw.sites(5);
            const SiteId l = s[4];
            s.pop_back();
            // A third of the cases has one to three box planes in place of sites.
            const size_t box_planes = i % 3 == 0 ? 1 + (i / 3) % 3 : 0;
            for (size_t k = 0; k < box_planes; ++k) s[3 - k] = draw.box_plane();
            std::vector<SiteId> involved{l};
            for (const PlaneId p : s) {
                if (!is_box_plane(p)) involved.push_back(p);
            }
            const Expected e = expect(scene, involved, tally, [&](const Oracle& o, Rational& r) {
                return o.side4(s[0], s[1], s[2], s[3], l, r);
            });
            const int orientation = cell_vertex_orientation_exact(diagram, s[0], s[1], s[2], s[3], stats);
            REQUIRE((orientation != 0) == e.exists());
            if (!e.exists()) continue;
            REQUIRE(side4(diagram, s[0], s[1], s[2], s[3], l, stats) == e.sign);
            std::sort(s.begin(), s.end()); // box planes last: the first is always a site
            do {
                if (is_box_plane(s[0])) continue;
                REQUIRE(side4_exact(diagram, s[0], s[1], s[2], s[3], l, stats) == e.sign);
                REQUIRE(side4(diagram, s[0], s[1], s[2], s[3], l, stats) == e.sign);
            } while (std::next_permutation(s.begin(), s.end()));
        }
        CHECK(tally.asked > scene.cases / 4);
        CHECK(tally.ties == 0);
        CHECK(1000 * tally.perturbed >= scene.zeros * tally.asked);
    }
}

TEST_CASE("pierces are ordered as rational arithmetic orders them, and tie only in one plane") {
    for (const Scene& scene : all_scenes()) {
        CAPTURE(scene.name);
        Draw draw{scene, Random(15)};
        const Diagram diagram{scene.sites, scene.box};
        PredicateStats stats;
        Tally tally;
        for (int i = 0; i < scene.cases; ++i) {
            const auto s = draw.sites(3);
            const Corners q1 = draw.corners();
            Corners q2 = draw.corners();
            if (i % 3 == 1) q2[0] = q1[2];                     // a common corner
            if (i % 3 == 2) q2 = {q1[1], q1[0], draw.point()}; // a common edge
            const Expected e = expect(scene, s, tally, [&](const Oracle& o, Rational& r) {
                return o.pierce_order(s[0], s[1], s[2], q1, q2, r);
            });
            if (!e.exists()) continue;
            for (const auto& [c, a, b] :
                 {std::array{s[0], s[1], s[2]}, {s[1], s[2], s[0]}, {s[2], s[0], s[1]}}) {
                REQUIRE(pierce_order(diagram, c, a, b, q1, q2, stats) == e.sign);
                REQUIRE(pierce_order_exact(diagram, c, a, b, q1, q2, stats) == e.sign);
                REQUIRE(pierce_order(diagram, c, b, a, q1, q2, stats) == -e.sign);
                REQUIRE(pierce_order(diagram, c, a, b, q2, q1, stats) == -e.sign);
            }
            if (e.sign == 0) {
                const Plane p1 = Oracle::plane(q1);
                for (const dvec3& q : q2) REQUIRE(dot(p1.n, vec(q)) == p1.k);
            }
        }
        CHECK(tally.asked > scene.cases / 4);
        CHECK(1000 * tally.perturbed >= scene.zeros * tally.asked);
    }
}

// Each predicate is a quotient of two determinants; the perturbed numerator changes sign whenever any two of
// its sites are exchanged, the one asked about included. This ties together the answers for different points.
TEST_CASE("numerators are antisymmetric in all their sites") {
    for (const Scene& scene : all_scenes()) {
        CAPTURE(scene.name);
        Draw draw{scene, Random(17)};
        const Diagram diagram{scene.sites, scene.box};
        PredicateStats stats;
        for (int i = 0; i < 40; ++i) {
            const auto s = draw.sites(5);
            const Corners q = draw.corners();
            const auto numerator = [&](const std::array<int, 5>& p, int count) {
                const std::array<SiteId, 5> t{s[p[0]], s[p[1]], s[p[2]], s[p[3]], s[p[4]]};
                if (count == 5) {
                    const int w = cell_vertex_orientation_exact(diagram, t[0], t[1], t[2], t[3], stats);
                    return w == 0 ? 0 : w * side4(diagram, t[0], t[1], t[2], t[3], t[4], stats);
                }
                const int w = pierce_direction_exact(diagram, t[0], t[1], t[2], q, stats);
                return w == 0 ? 0 : w * side3(diagram, t[0], t[1], t[2], t[3], q, stats);
            };
            for (const int count : {4, 5}) {
                std::array<int, 5> p{0, 1, 2, 3, 4};
                int expected = 0; // of the identity, as soon as one order has a point to ask about
                do {
                    int inversions = 0;
                    for (int a = 0; a < count; ++a) {
                        for (int b = a + 1; b < count; ++b) inversions += p[a] > p[b];
                    }
                    const int sign = (inversions % 2 ? -1 : 1) * numerator(p, count);
                    if (expected == 0) expected = sign;
                    if (sign != 0) REQUIRE(sign == expected);
                } while (std::next_permutation(p.begin(), p.begin() + count));
            }
        }
    }
}

TEST_CASE("the nearest site by side1 is a total order of the sites at every point") {
    Random random(3);
    const Scene scene = lattice_scene(random, 1);
    const Diagram diagram{scene.sites, scene.box};
    PredicateStats stats;
    for (const dvec3& q : scene.points) {
        std::vector<int> beaten;
        for (SiteId c = 0; c < scene.sites.size(); ++c) {
            int count = 0;
            for (SiteId l = 0; l < scene.sites.size(); ++l) {
                if (l != c) count += side1(diagram, c, l, q, stats) > 0;
            }
            beaten.push_back(count);
        }
        std::sort(beaten.begin(), beaten.end());
        for (size_t i = 0; i < beaten.size(); ++i) REQUIRE(beaten[i] == static_cast<int>(i));
    }
}

TEST_CASE("answers hold at the ends of the documented range of coordinates") {
    Random random(4);
    // Exponents anywhere between the granularity and the largest coordinate, in one and the same question.
    const auto coordinate = [&] {
        const int exponent = static_cast<int>(random.next() % 251) - 150;
        double x = std::ldexp(static_cast<double>(random.next() >> 11) * 0x1.0p-53, exponent);
        if (random.next() % 3 == 0) x = std::ldexp(1.0, exponent);
        if (random.next() % 8 == 0) x = 0.0;
        x = snap(x);
        return random.next() % 2 ? x : -x;
    };
    const auto point = [&] {
        const double x = coordinate();
        const double y = coordinate();
        return dvec3(x, y, coordinate());
    };
    PredicateStats stats;
    int asked = 0;
    for (int i = 0; i < 300; ++i) {
        std::vector<dvec3> sites;
        for (int k = 0; k < 5; ++k) sites.push_back(point());
        const Diagram diagram{sites, {dvec3(-kLargestCoordinate), dvec3(kLargestCoordinate)}};
        const Corners q1{point(), point(), point()};
        const Corners q2{q1[0], point(), point()};
        const Oracle oracle{&diagram, {}, 0};
        Rational r;
        const auto check = [&](bool exists, auto&& predicate, auto&& exact_predicate) {
            if (!exists || r == 0) return;
            ++asked;
            REQUIRE(predicate() == r.sign());
            REQUIRE(exact_predicate() == r.sign());
        };
        check(
            oracle.side1(0, 1, q1[0], r), [&] { return side1(diagram, 0, 1, q1[0], stats); },
            [&] { return side1_exact(diagram, 0, 1, q1[0], stats); });
        check(
            oracle.side2(0, 1, 2, q1[0], q1[1], r),
            [&] { return side2(diagram, 0, 1, 2, q1[0], q1[1], stats); },
            [&] { return side2_exact(diagram, 0, 1, 2, q1[0], q1[1], stats); });
        check(
            oracle.side3(0, 1, 2, 3, q1, r), [&] { return side3(diagram, 0, 1, 2, 3, q1, stats); },
            [&] { return side3_exact(diagram, 0, 1, 2, 3, q1, stats); });
        check(
            oracle.side4(0, 1, 2, 3, 4, r), [&] { return side4(diagram, 0, 1, 2, 3, 4, stats); },
            [&] { return side4_exact(diagram, 0, 1, 2, 3, 4, stats); });
        check(
            oracle.pierce_order(0, 1, 2, q1, q2, r),
            [&] { return pierce_order(diagram, 0, 1, 2, q1, q2, stats); },
            [&] { return pierce_order_exact(diagram, 0, 1, 2, q1, q2, stats); });
    }
    CHECK(asked > 1000);
}

TEST_CASE("the error bounds of values and pierce positions contain the true error") {
    Random random(5);
    double worst_value = 0.0;
    double worst_pierce = 0.0;
    for (int i = 0; i < 2000; ++i) {
        // Far from the origin differences are few bits; near it they round.
        const double offset = i % 2 ? 0.0 : 1e3;
        const double size = i % 3 ? 1.0 : 1e-3;
        const auto point = [&] { return (random.uniform_in(kUnitBox) + offset) * size; };
        const std::vector<dvec3> sites{point(), point(), point()};
        const Diagram diagram{sites, kUnitBox};
        const Oracle oracle{&diagram, {}, 0};
        const Bisector a = make_bisector(sites[0], sites[1]);
        const Bisector b = make_bisector(sites[0], sites[2]);
        const Corners q{point(), point(), point()};
        Corners y;
        double reach = 0.0;
        dvec3 va, vb;
        for (int k = 0; k < 3; ++k) {
            y[k] = q[k] - sites[0];
            reach = std::max(reach, glm::length(y[k]));
        }
        const double error = value_error(std::max(a.length, b.length), reach);
        for (int k = 0; k < 3; ++k) {
            va[k] = value(a, y[k]);
            vb[k] = value(b, y[k]);
            const Rational difference = abs(Rational(va[k]) - oracle.g(0, 1, vec(q[k])) / 2);
            REQUIRE(difference <= Rational(error));
            worst_value = std::max(worst_value, static_cast<double>(difference) / error);
        }
        const PiercePosition p = pierce_position(a, b, y, va, vb, error);
        if (!std::isfinite(p.error)) continue;
        Vec x;
        REQUIRE(meet(oracle.plane(0, 1), oracle.plane(0, 2), Oracle::plane(q), x));
        const Vec d = cross(vec(sites[1]) - vec(sites[0]), vec(sites[2]) - vec(sites[0]));
        const Rational difference = abs(Rational(p.t) - dot(x - vec(sites[0]), d));
        REQUIRE(difference <= Rational(p.error));
        worst_pierce = std::max(worst_pierce, static_cast<double>(difference) / p.error);
    }
    // Not needlessly wide either.
    CHECK(worst_value > 0.05);
    CHECK(worst_pierce > 0.005);
}

TEST_CASE("on random input the filters decide all but a few questions in ten thousand") {
    Random random(6);
    Scene scene = random_scene(random);
    const Diagram diagram{scene.sites, scene.box};
    Draw draw{scene, Random(16)};
    PredicateStats stats;
    constexpr int rounds = 20000;
    for (int i = 0; i < rounds; ++i) {
        const auto s = draw.sites(5);
        const Corners q = draw.corners();
        const Corners r = draw.corners();
        if (q[0] == q[1] || q[1] == q[2] || q[0] == q[2] || r[0] == r[1] || r[1] == r[2] || r[0] == r[2]
            || q == r) {
            continue;
        }
        int sum = side1(diagram, s[0], s[1], q[0], stats)
                  + side2(diagram, s[0], s[1], s[2], q[0], q[1], stats)
                  + side3(diagram, s[0], s[1], s[2], s[3], q, stats)
                  + side4(diagram, s[0], s[1], s[2], s[3], s[4], stats);
        (void)sum;
        (void)pierce_order(diagram, s[0], s[1], s[2], q, r, stats);
    }
    CHECK(stats.side1_exact <= 2);
    CHECK(stats.side2_exact <= 4);
    CHECK(stats.side3_exact <= 8);
    CHECK(stats.side4_exact <= 8);
    CHECK(stats.pierce_exact <= 200); // triangles that share a corner where the line passes are not excluded
}

TEST_CASE("exact constructions are within a few ulp of the true positions, however ill-conditioned") {
    Random random(8);
    for (int i = 0; i < 500; ++i) {
        // Almost dependent bisectors: sites almost on a line.
        const dvec3 base = random.uniform_in(kUnitBox);
        const dvec3 step = random.uniform_in(kUnitBox) * 0.1;
        std::vector<dvec3> sites;
        const double noise = std::ldexp(1.0, -static_cast<int>(random.next() % 45));
        for (int k = 0; k < 4; ++k)
            sites.push_back(base + static_cast<double>(k) * step + random.uniform_in(kUnitBox) * noise);
        const Diagram diagram{sites, kUnitBox};
        const Oracle oracle{&diagram, {}, 0};
        const auto close = [](double x, const Rational& exact, const Rational& scale) {
            return abs(Rational(x) - exact) <= scale * Rational(0x10.0p-53);
        };
        Vec x;
        if (meet(oracle.plane(0, 1), oracle.plane(0, 2), oracle.plane(0, 3), x)) {
            x = x - vec(sites[0]);
            const dvec3 v = cell_vertex_exact(diagram, 0, 1, 2, 3);
            REQUIRE(close(v.x, x.x, abs(x.x)));
            REQUIRE(close(v.y, x.y, abs(x.y)));
            REQUIRE(close(v.z, x.z, abs(x.z)));
        }
        const dvec3 q0 = random.uniform_in(kUnitBox);
        const dvec3 q1 = random.uniform_in(kUnitBox);
        const Rational f0 = oracle.g(0, 1, vec(q0));
        const Rational f1 = oracle.g(0, 1, vec(q1));
        if (f0.sign() * f1.sign() < 0) {
            const Rational t = f0 / (f0 - f1);
            REQUIRE(close(edge_parameter_exact(diagram, 0, 1, q0, q1), t, t));
        }
        const Corners q{q0, q1, random.uniform_in(kUnitBox)};
        if (meet(oracle.plane(0, 1), oracle.plane(0, 2), Oracle::plane(q), x)) {
            const dvec3 w = pierce_weights_exact(diagram, 0, 1, 2, q);
            if (w.x == 0.0 || w.y == 0.0 || w.z == 0.0)
                continue; // clamped: the pierce is outside the triangle
            const Vec p = vec(w.x * q[0] + w.y * q[1] + w.z * q[2]);
            REQUIRE(close(0.0, p.x - x.x, 1));
            REQUIRE(close(0.0, p.y - x.y, 1));
            REQUIRE(close(0.0, p.z - x.z, 1));
        }
    }
}

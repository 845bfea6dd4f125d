// The oracle of the exact predicates in rational numbers, and the scenes that the tests evaluate them on.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <boost/multiprecision/cpp_int.hpp>

#include "fracture/base/random.h"
#include "fracture/exact/predicates.h"

namespace brittle::fracture::exact::test {

using glm::dvec3;
using Rational = boost::multiprecision::cpp_rational;

// ---- The oracle: definitions in rational numbers, absolute coordinates, weights as actual numbers

struct Vec {
    Rational x, y, z;
};
inline Vec vec(const dvec3& p) {
    return {Rational(p.x), Rational(p.y), Rational(p.z)};
}
inline Vec operator-(const Vec& a, const Vec& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Rational dot(const Vec& a, const Vec& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec cross(const Vec& a, const Vec& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// n.x = k
struct Plane {
    Vec n;
    Rational k;
};

// Computes the intersection of three planes by Cramer's rule. Returns false if there is none.
inline bool meet(const Plane& a, const Plane& b, const Plane& c, Vec& point) {
    const Vec bc = cross(b.n, c.n);
    const Vec ca = cross(c.n, a.n);
    const Vec ab = cross(a.n, b.n);
    const Rational w = dot(a.n, bc);
    if (w == 0) return false;
    point = {(a.k * bc.x + b.k * ca.x + c.k * ab.x) / w, (a.k * bc.y + b.k * ca.y + c.k * ab.y) / w,
             (a.k * bc.z + b.k * ca.z + c.k * ab.z) / w};
    return true;
}

// Sites with weights w_i = e^(r + 1), where r is the rank of i among the sites involved and e = 2^-bits. bits = 0 means
// no weights.
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
            const int axis = static_cast<int>((p - box_min_x) / 2);
            dvec3 n(0.0);
            n[axis] = 1.0;
            return {vec(n), Rational((p - box_min_x) % 2 ? diagram->box.max[axis] : diagram->box.min[axis])};
        }
        const Vec n = site(p) - site(c);
        return {{2 * n.x, 2 * n.y, 2 * n.z}, dot(site(p), site(p)) - weight(p) - dot(site(c), site(c)) + weight(c)};
    }
    static Plane plane(const Corners& q) {
        const Vec n = cross(vec(q[1]) - vec(q[0]), vec(q[2]) - vec(q[0]));
        return {n, dot(n, vec(q[0]))};
    }

    // Each returns false if the point does not exist, and otherwise the value whose sign is tested.
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
    bool pierce_order(SiteId c, SiteId a, SiteId b, const Corners& q1, const Corners& q2, Rational& result) const {
        Vec x1, x2;
        if (!meet(plane(c, a), plane(c, b), plane(q1), x1)) return false;
        if (!meet(plane(c, a), plane(c, b), plane(q2), x2)) return false;
        result = dot(x1 - x2, cross(site(a) - site(c), site(b) - site(c)));
        return true;
    }
};

// Returns the sign for infinitesimal weights; 2 if the point does not exist. Weights enter only if their absence gives
// zero. They are then small enough to settle the order of magnitudes: halving the exponent must not change the sign.
template<class Ask>
int oracle_sign(const Diagram& diagram, std::vector<SiteId> involved, unsigned bits, bool& perturbed, Ask ask) {
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

struct Scene {
    std::string name;
    std::vector<dvec3> sites;
    std::vector<dvec3> points;
    Box box{dvec3(-1.0), dvec3(1.0)};
    unsigned bits; // per infinitesimal; enough for the scene's coordinates
    int cases;     // per predicate
    int zeros = 0; // minimum count of exact zeros per thousand answers, for every predicate
};

inline dvec3 lattice_point(Random& random, int size) {
    const auto pick = [&] { return (static_cast<double>(random.next() % (2 * size + 1)) - size) / size; };
    const double x = pick();
    const double y = pick();
    return {x, y, pick()};
}

constexpr Box unit_box{dvec3(-1.0), dvec3(1.0)};

inline Scene random_scene(Random& random) {
    Scene scene{"random", {}, {}, unit_box, 600, 300};
    for (int i = 0; i < 40; ++i) scene.sites.push_back(random.uniform_in(unit_box));
    for (int i = 0; i < 60; ++i) scene.points.push_back(random.uniform_in(unit_box));
    return scene;
}

inline Scene lattice_scene(Random& random, int size) {
    Scene scene{"lattice", {}, {}, unit_box, 120, 2000, size < 4 ? 20 : 1};
    for (int i = 0; i < 40; ++i) scene.sites.push_back(lattice_point(random, size)); // duplicates occur
    for (int i = 0; i < 60; ++i) scene.points.push_back(lattice_point(random, size));
    return scene;
}

// The 48 points (+-1,+-2,+-3)/4 in every order and their centre. Half of the mesh points are the centre, the others lie
// in the symmetry planes.
inline Scene cospherical_scene(Random& random) {
    Scene scene{"cospherical", {dvec3(0.0)}, {}, unit_box, 120, 2000, 20};
    std::array<double, 3> p{0.25, 0.5, 0.75};
    do {
        for (int s = 0; s < 8; ++s) {
            scene.sites.emplace_back(s & 1 ? p[0] : -p[0], s & 2 ? p[1] : -p[1], s & 4 ? p[2] : -p[2]);
        }
    } while (std::next_permutation(p.begin(), p.end()));
    for (size_t i = scene.sites.size(); i > 1; --i) std::swap(scene.sites[i - 1], scene.sites[random.next() % i]);
    for (int i = 0; i < 60; ++i) {
        scene.points.push_back(i % 3 == 0 ? dvec3(0.0) : lattice_point(random, i % 3 == 1 ? 1 : 4));
    }
    return scene;
}

// Sites that mirror each other in a mesh vertex v and in edges and faces through v, so bisectors contain these. The
// images are exact, because all coordinates are multiples of 2^-20.
inline Scene mirrored_scene(Random& random) {
    Scene scene{"mirrored", {}, {}, unit_box, 400, 1000, 20};
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

// A scene with a third of its coordinates moved by one unit in the last place.
inline Scene shaken(Scene scene, Random& random) {
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

inline std::vector<Scene> all_scenes() {
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
    PlaneId box_plane() { return box_min_x + static_cast<PlaneId>(random.next() % 6); }
};

// Counts the outcomes of a scene's cases, so that a test can require a minimum of informative ones.
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

} // namespace brittle::fracture::exact::test

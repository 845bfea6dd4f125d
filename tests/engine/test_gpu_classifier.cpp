#include "engine/compute/gpu_classifier.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "engine/compute/site_bins.h"
#include "fracture/base/random.h"
#include "fracture/fracture.h"
#include "fracture/io/import.h"
#include "fracture/pieces/certificate.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "tests/engine/support.h"

using namespace brittle;
using namespace brittle::fracture;
using engine::GpuClassifier;

namespace {

using Sites = std::vector<glm::dvec3>;

std::unique_ptr<GpuClassifier> make_classifier(engine::Device& device) {
    auto made = GpuClassifier::create(device);
    REQUIRE_MESSAGE(made, (made ? std::string() : made.error().message));
    return std::move(*made);
}

using Vec = glm::tvec3<long double>;

long double distance2(const Vec& x, const glm::dvec3& s) {
    const Vec d = x - Vec(s);
    return d.x * d.x + d.y * d.y + d.z * d.z;
}

// Checks a classifier's sign pattern of a crossing triangle against all sites in extended precision.
class PatternCheck {
  public:
    PatternCheck(const TriangleMesh& mesh, const Sites& sites) : mesh_(mesh), sites_(sites) {}

    size_t edges = 0, edges_alone = 0, points = 0, points_alone = 0, signs = 0, signs_known = 0;

    void check(const Triangle& t, const glm::uvec3& cells, uint32_t answer) {
        const bool certain = ((cells.x | cells.y | cells.z) & Classifier::uncertain) == 0;
        const bool three = certain && cells.x != cells.y && cells.y != cells.z && cells.z != cells.x;
        uint32_t may_be = Classifier::crossing; // the bits that may be set for this triangle
        for (uint32_t e = 0; e < 3; ++e) {
            const auto from = static_cast<int>(e), to = (from + 1) % 3, third = (from + 2) % 3;
            const uint32_t a = cells[from], b = cells[to];
            if (((a | b) & Classifier::uncertain) != 0 || a == b) continue;
            if (t[from] < t[to]) {
                may_be |= Classifier::edge_alone(e);
                ++edges;
                if (answer & Classifier::edge_alone(e)) {
                    ++edges_alone;
                    require_alone(where_equal(corner(t, from), corner(t, to), a, b), {a, b, a});
                }
            }
            if (!three) continue;
            may_be |= Classifier::sign_known(e) | Classifier::sign_first(e);
            ++signs;
            if ((answer & Classifier::sign_known(e)) == 0) continue;
            ++signs_known;
            const bool first = difference(corner(t, third), a, b) > 0.0L;
            REQUIRE(first == ((answer & Classifier::sign_first(e)) != 0));
        }
        if (three) {
            may_be |= Classifier::point_alone;
            ++points;
        }
        REQUIRE((answer & ~may_be) == 0);
        if ((answer & Classifier::point_alone) == 0) return;
        ++points_alone;
        require_alone(where_equal(t, cells), cells);
    }

  private:
    [[nodiscard]] Vec corner(const Triangle& t, int k) const { return Vec(mesh_.positions[t[k]]); }
    // Positive if x is nearer to a than to b.
    [[nodiscard]] long double difference(const Vec& x, uint32_t a, uint32_t b) const {
        return distance2(x, sites_[b]) - distance2(x, sites_[a]);
    }
    [[nodiscard]] Vec where_equal(const Vec& p, const Vec& q, uint32_t a, uint32_t b) const {
        const long double at_p = difference(p, a, b), at_q = difference(q, a, b);
        REQUIRE(at_p > 0.0L);
        REQUIRE(at_q < 0.0L);
        return p + (at_p / (at_p - at_q)) * (q - p);
    }
    [[nodiscard]] Vec where_equal(const Triangle& t, const glm::uvec3& cells) const {
        Vec f(0.0L), g(0.0L);
        for (int k = 0; k < 3; ++k) {
            f[k] = difference(corner(t, k), cells.x, cells.y);
            g[k] = difference(corner(t, k), cells.x, cells.z);
        }
        const Vec w = glm::cross(f, g);
        return (w.x * corner(t, 0) + w.y * corner(t, 1) + w.z * corner(t, 2)) / (w.x + w.y + w.z);
    }
    void require_alone(const Vec& x, const glm::uvec3& cells) const {
        const long double own = distance2(x, sites_[cells.x]);
        for (uint32_t s = 0; s < sites_.size(); ++s)
            REQUIRE((s == cells.x || s == cells.y || s == cells.z || distance2(x, sites_[s]) > own));
    }

    const TriangleMesh& mesh_;
    const Sites& sites_;
};

// Checks a classifier's certain answers against all sites in extended precision.
struct Answers {
    std::vector<uint32_t> vertices, triangles;
    size_t uncertain = 0;
};

Answers check_answers(GpuClassifier& classifier, const TriangleMesh& mesh, const Sites& sites,
                      PatternCheck* patterns = nullptr) {
    Answers answers{std::vector<uint32_t>(mesh.positions.size()), std::vector<uint32_t>(mesh.triangles.size())};
    REQUIRE_MESSAGE(classifier.start({mesh.positions, mesh.triangles, sites, bounds(mesh)}), classifier.error());
    REQUIRE_MESSAGE(classifier.finish(answers.vertices, answers.triangles), classifier.error());
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        const uint32_t site = answers.vertices[v] & ~Classifier::uncertain;
        REQUIRE(site < sites.size());
        if (answers.vertices[v] & Classifier::uncertain) {
            ++answers.uncertain;
            continue;
        }
        const Vec x(mesh.positions[v]);
        const long double claimed = distance2(x, sites[site]);
        for (size_t s = 0; s < sites.size(); ++s) REQUIRE((s == site || distance2(x, sites[s]) > claimed));
    }
    PatternCheck own(mesh, sites);
    PatternCheck& check = patterns ? *patterns : own;
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Triangle& c = mesh.triangles[t];
        const glm::uvec3 cells(answers.vertices[c.x], answers.vertices[c.y], answers.vertices[c.z]);
        const bool whole = cells.x == cells.y && cells.x == cells.z && (cells.x & Classifier::uncertain) == 0;
        if (whole) {
            REQUIRE(answers.triangles[t] == cells.x);
        } else {
            REQUIRE((answers.triangles[t] & Classifier::crossing) != 0);
            check.check(c, cells, answers.triangles[t]);
        }
    }
    return answers;
}

uint64_t hash_of(const TriangleMesh& mesh, const Sites& sites, Classifier* classifier) {
    Settings settings;
    settings.classifier = classifier;
    const auto fragments = fracture::fracture(mesh, sites, settings);
    REQUIRE_MESSAGE(fragments, (fragments ? std::string() : fragments.error().message));
    return hash(*fragments);
}

} // namespace

TEST_CASE("GPU classifier: certain answers are right") {
    const auto device = engine::test::make_device();
    if (!device) return;
    const auto classifier = make_classifier(*device);
    const TriangleMesh ball = icosphere(4), cubes = lattice_cube(8);
    SUBCASE("one site") {
        CHECK(check_answers(*classifier, ball, {{0.3, 0.0, 0.0}}).uncertain == 0);
    }
    SUBCASE("duplicates are never sure") {
        const Answers answers = check_answers(*classifier, ball, {{0.1, 0.0, 0.0}, {0.1, 0.0, 0.0}});
        CHECK(answers.uncertain == ball.positions.size());
    }
    SUBCASE("a bisector through rows of vertices") {
        const Answers answers = check_answers(*classifier, cubes, {{-0.25, 0.1, 0.1}, {0.25, 0.1, 0.1}});
        CHECK(answers.uncertain >= 32); // the vertices in the bisector's plane
        CHECK(answers.uncertain < cubes.positions.size() / 2);
    }
    SUBCASE("few and many sites") {
        for (const uint32_t count : {2u, 10u, 100u, 3000u}) {
            CAPTURE(count);
            const Answers answers = check_answers(*classifier, ball, uniform_sites(bounds(ball), count, count));
            CHECK(answers.uncertain < ball.positions.size() / 50);
        }
    }
    SUBCASE("sites far outside, at wildly different distances, and all in one bin") {
        Sites far, crowd;
        Random random(4);
        for (int k = 0; k < 60; ++k) {
            const glm::dvec3 p(random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5);
            far.push_back(p * std::pow(10.0, k / 2.0));
            crowd.push_back(glm::dvec3(0.7) + p * 1e-5);
        }
        (void)check_answers(*classifier, ball, far);
        (void)check_answers(*classifier, ball, crowd);
        (void)check_answers(*classifier, ball, {{1e30, 0.0, 0.0}, {-1e30, 0.0, 0.0}});
    }
    CHECK(device->validation_messages().empty());
}

TEST_CASE("GPU classifier: the signs of nearly all crossing triangles are decided, and right") {
    const auto device = engine::test::make_device();
    if (!device) return;
    const auto classifier = make_classifier(*device);
    for (const TriangleMesh& mesh : {icosphere(5), torus_knot()}) {
        for (const uint32_t count : {10u, 100u, 1000u}) {
            CAPTURE(mesh.triangles.size());
            CAPTURE(count);
            const Sites sites = uniform_sites(bounds(mesh), count, 3);
            PatternCheck patterns(mesh, sites);
            (void)check_answers(*classifier, mesh, sites, &patterns);
            MESSAGE(mesh.triangles.size(), " triangles, ", count, " sites: alone ", patterns.edges_alone, " of ",
                    patterns.edges, " edges, ", patterns.points_alone, " of ", patterns.points,
                    " points of three cells; signs ", patterns.signs_known, " of ", patterns.signs);
            CHECK(patterns.edges > 0);
            CHECK(patterns.edges_alone > patterns.edges * 3 / 4);
            CHECK(patterns.signs_known >= patterns.signs - patterns.signs / 50);
            if (patterns.points > 20) CHECK(patterns.points_alone > patterns.points / 4);
        }
    }
    CHECK(device->validation_messages().empty());
}

TEST_CASE("GPU classifier: the answers do not depend on subgroup ballots") {
    engine::FaultInjector faults;
    faults.hide("subgroupBallot");
    const auto plain = engine::test::make_device(&faults);
    if (!plain) return;
    CHECK_FALSE(plain->has_ballots());
    const auto device = engine::test::make_device();
    const TriangleMesh ball = icosphere(4);
    const Sites sites = uniform_sites(bounds(ball), 200, 5);
    const Answers one = check_answers(*make_classifier(*plain), ball, sites);
    const Answers two = check_answers(*make_classifier(*device), ball, sites);
    CHECK(one.vertices == two.vertices);
    CHECK(one.triangles == two.triangles);
    CHECK(plain->validation_messages().empty());
}

TEST_CASE("GPU classifier: pieces are equal with and without it") {
    const auto device = engine::test::make_device();
    if (!device) return;
    const auto classifier = make_classifier(*device);
    for (const TriangleMesh& mesh :
         {icosphere(4), torus(64, 32), torus_knot(), hollow_sphere(3), lattice_cube(8), four_legged_animal()}) {
        CAPTURE(mesh.triangles.size());
        for (const uint32_t count : {1u, 30u, 300u}) {
            const Sites sites = uniform_sites(bounds(mesh), count, 7);
            CHECK(hash_of(mesh, sites, classifier.get()) == hash_of(mesh, sites, nullptr));
        }
        // Bisectors through vertices: the device marks these vertices as uncertain.
        Sites own(mesh.positions.begin(), mesh.positions.begin() + 40);
        own.push_back(own.front());
        CHECK(hash_of(mesh, own, classifier.get()) == hash_of(mesh, own, nullptr));
    }
    CHECK(device->validation_messages().empty());
}

// The meshes of tools/bench/bench.cpp, the largest with fewer triangles, because a CPU driver is slow.
TEST_CASE("GPU classifier: pieces of the benchmark's meshes are equal with and without it") {
    const auto device = engine::test::make_device();
    if (!device) return;
    const auto classifier = make_classifier(*device);
    const auto bunny = import_mesh("/usr/share/glmark2/models/bunny.obj");
    std::vector<TriangleMesh> meshes{icosphere(5), icosphere(6), torus_knot(2, 3, 2048, 40)};
    if (bunny) meshes.push_back(*bunny);
    for (const TriangleMesh& mesh : meshes) {
        CAPTURE(mesh.triangles.size());
        for (const uint32_t count : {10u, 100u, 1000u}) {
            CAPTURE(count);
            const Sites sites = uniform_sites(bounds(mesh), count, 1);
            CHECK(hash_of(mesh, sites, classifier.get()) == hash_of(mesh, sites, nullptr));
        }
    }
    CHECK(device->validation_messages().empty());
}

TEST_CASE("GPU classifier: meshes of any size may follow each other") {
    const auto device = engine::test::make_device();
    if (!device) return;
    const auto classifier = make_classifier(*device);
    for (const uint32_t subdivisions : {1u, 4u, 2u, 5u, 0u}) {
        const TriangleMesh ball = icosphere(subdivisions);
        (void)check_answers(*classifier, ball, uniform_sites(bounds(ball), 20, subdivisions));
    }
    const TriangleMesh ball = icosphere(1);
    std::vector<uint32_t> vertices(ball.positions.size()), triangles(ball.triangles.size());
    CHECK_FALSE(classifier->finish(vertices, triangles)); // without start()
    CHECK_FALSE(classifier->error().empty());
    CHECK(device->validation_messages().empty());
}

TEST_CASE("site bins: each site is in its bin, and a site outside the grid in the nearest one") {
    const Box box{glm::dvec3(-1.0), glm::dvec3(1.0)};
    Sites sites = uniform_sites(box, 500, 1);
    sites.push_back({9.0, 0.1, -7.0});
    engine::SiteBins bins;
    bins.build(sites, box);
    const glm::uvec4 n = bins.grid.bins;
    REQUIRE(bins.begin.size() == n.x * n.y * n.z + 1);
    CHECK(bins.begin.back() == sites.size());
    std::vector<int> seen(sites.size(), 0);
    for (uint32_t bin = 0; bin + 1 < bins.begin.size(); ++bin) {
        const glm::uvec3 at(bin % n.x, bin / n.x % n.y, bin / n.x / n.y);
        for (uint32_t k = bins.begin[bin]; k < bins.begin[bin + 1]; ++k) {
            const uint32_t site = std::bit_cast<uint32_t>(bins.sites[k].w);
            REQUIRE(site < sites.size());
            ++seen[site];
            const glm::dvec3 inside = glm::clamp(sites[site], box.min, box.max);
            for (int axis = 0; axis < 3; ++axis) {
                const double low = bins.grid.low[axis] + at[axis] * bins.grid.bin_size[axis];
                CHECK(inside[axis] >= low - 1e-5);
                CHECK(inside[axis] <= low + bins.grid.bin_size[axis] + 1e-5);
            }
        }
    }
    CHECK(std::all_of(seen.begin(), seen.end(), [](int n_seen) { return n_seen == 1; }));
}

#include "tests/fracture/exact_checks.h"

#include <algorithm>
#include <array>
#include <limits>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/base/random.h"
#include "fracture/classifier.h"
#include "fracture/pieces/certificate.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"

using namespace brittle::fracture;
using namespace brittle::fracture::test;

namespace {

double distance2(const glm::dvec3& a, const glm::dvec3& b) {
    return glm::dot(a - b, a - b);
}

// A test classifier that compares all sites in double. Depending on the mode it reports how triangles cross, omits
// that, answers anything and marks it uncertain, or gives up.
class TestClassifier : public Classifier {
  public:
    enum class Mood { right, silent, wild, refuses, fails };
    explicit TestClassifier(Mood mood) : mood_(mood) {}
    uint32_t edges_known = 0, points_known = 0;

    bool start(const Problem& problem) override {
        problem_ = problem;
        return mood_ != Mood::refuses;
    }
    bool finish(std::span<uint32_t> site_of_vertex, std::span<uint32_t> site_of_triangle) override {
        REQUIRE(mood_ != Mood::refuses);
        REQUIRE(site_of_vertex.size() == problem_.positions.size());
        REQUIRE(site_of_triangle.size() == problem_.triangles.size());
        Random random(1);
        for (uint32_t& site : site_of_vertex) {
            const glm::dvec3& x = problem_.positions[static_cast<size_t>(&site - site_of_vertex.data())];
            site = mood_ == Mood::right || mood_ == Mood::silent
                       ? nearest(x)
                       : static_cast<uint32_t>(random.next() % problem_.sites.size()) | uncertain;
        }
        for (size_t t = 0; t < site_of_triangle.size(); ++t) {
            const Triangle& c = problem_.triangles[t];
            const std::array<uint32_t, 3> cells{site_of_vertex[c.x], site_of_vertex[c.y], site_of_vertex[c.z]};
            const bool certain = ((cells[0] | cells[1] | cells[2]) & uncertain) == 0;
            const bool whole = certain && cells[0] == cells[1] && cells[1] == cells[2];
            site_of_triangle[t] = whole                             ? cells[0]
                                  : certain && mood_ == Mood::right ? crossing | pattern(c, cells)
                                                                    : crossing;
        }
        return mood_ != Mood::fails;
    }

  private:
    static constexpr double room = 1e-6; // squared distances with a smaller difference are uncertain

    [[nodiscard]] uint32_t nearest(const glm::dvec3& x) const {
        uint32_t best = 0;
        double second = std::numeric_limits<double>::infinity(), first = second;
        for (uint32_t s = 0; s < problem_.sites.size(); ++s) {
            const double d = distance2(x, problem_.sites[s]);
            if (d < first) best = s;
            second = std::min(second, std::max(first, d));
            first = std::min(first, d);
        }
        return best | (second - first < room ? uncertain : 0u);
    }

    // No site is as near as those of the three cells.
    [[nodiscard]] bool alone(const glm::dvec3& x, const std::array<uint32_t, 3>& cells) const {
        for (uint32_t s = 0; s < problem_.sites.size(); ++s) {
            if (std::find(cells.begin(), cells.end(), s) != cells.end()) continue;
            if (distance2(x, problem_.sites[s]) < distance2(x, problem_.sites[cells[0]]) + room) return false;
        }
        return true;
    }

    uint32_t pattern(const Triangle& t, const std::array<uint32_t, 3>& cells) {
        uint32_t bits = 0;
        const auto nearer = [&](const glm::dvec3& x, uint32_t a, uint32_t b) { // positive on the side of a
            return distance2(x, problem_.sites[b]) - distance2(x, problem_.sites[a]);
        };
        for (uint32_t e = 0; e < 3; ++e) {
            const uint32_t a = cells[e], b = cells[(e + 1) % 3];
            if (a == b) continue;
            const glm::dvec3 &from = problem_.positions[t[static_cast<int>(e)]],
                             &to = problem_.positions[t[static_cast<int>((e + 1) % 3)]];
            const double at_from = nearer(from, a, b), at_to = nearer(to, a, b);
            if (alone(from + at_from / (at_from - at_to) * (to - from), {a, b, a})) {
                bits |= edge_alone(e);
                ++edges_known;
            }
            const double third = nearer(problem_.positions[t[static_cast<int>((e + 2) % 3)]], a, b);
            if (std::abs(third) > room) bits |= sign_known(e) | (third > 0.0 ? sign_first(e) : 0u);
        }
        if (cells[0] == cells[1] || cells[1] == cells[2] || cells[2] == cells[0]) return bits;
        const glm::dvec3 &p = problem_.positions[t.x], &q = problem_.positions[t.y], &r = problem_.positions[t.z];
        const glm::dvec3 f(nearer(p, cells[0], cells[1]), nearer(q, cells[0], cells[1]), nearer(r, cells[0], cells[1]));
        const glm::dvec3 g(nearer(p, cells[0], cells[2]), nearer(q, cells[0], cells[2]), nearer(r, cells[0], cells[2]));
        const glm::dvec3 w = glm::cross(f, g);
        const double sum = w.x + w.y + w.z;
        if (std::abs(sum) < room * glm::length(w)) return bits;
        if (alone((w.x * p + w.y * q + w.z * r) / sum, cells)) {
            bits |= point_alone;
            ++points_known;
        }
        return bits;
    }

    Mood mood_;
    Problem problem_;
};

} // namespace

TEST_CASE("exact: any classifier, or none, gives the same bits") {
    const TriangleMesh mesh = icosphere(4);
    const Sites sites = uniform_sites(bounds(mesh), 100, 3);
    const auto none = fracture_exact(mesh, sites, {.threads = 1});
    using Mood = TestClassifier::Mood;
    for (const Mood mood : {Mood::right, Mood::silent, Mood::wild, Mood::refuses, Mood::fails}) {
        CAPTURE(static_cast<int>(mood));
        TestClassifier classifier(mood);
        Settings settings;
        settings.classifier = &classifier;
        const auto guessed = fracture_exact(mesh, sites, settings);
        REQUIRE(guessed);
        CHECK(hash(*guessed) == hash(*none));
    }
}

TEST_CASE("exact: the flags of a classifier for crossing triangles change no bit") {
    for (const TriangleMesh& mesh : {icosphere(1), icosphere(3), torus(48, 24), hollow_sphere(3), torus_knot()}) {
        for (const uint32_t count : {3u, 10u, 60u, 400u}) {
            CAPTURE(mesh.triangles.size());
            CAPTURE(count);
            for (const uint64_t seed : {1u, 2u, 3u}) {
                const Sites sites = uniform_sites(bounds(mesh), count, seed);
                TestClassifier classifier(TestClassifier::Mood::right);
                const auto none = fracture_exact(mesh, sites, {.threads = 1});
                const auto guessed = fracture_exact(mesh, sites, {.threads = 2, .classifier = &classifier});
                REQUIRE(none);
                REQUIRE(guessed);
                CHECK(hash(*guessed) == hash(*none));
                CHECK(guessed->triangles == none->triangles);
                CHECK(guessed->vertex_point == none->vertex_point);
                CHECK(classifier.edges_known > 0);
                if (count == 60) CHECK(classifier.points_known > 0);
            }
        }
    }
}

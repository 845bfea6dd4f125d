#include "engine/compute/gpu_classifier.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>
#include <glm/common.hpp>

#include "engine/compute/site_bins.h"
#include "fracture/certificate.h"
#include "fracture/fracture.h"
#include "fracture/random.h"
#include "fracture/shapes.h"
#include "fracture/sites.h"
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

// Answers of a classifier that it is sure of are right, by comparing all sites in extended precision.
struct Answers {
    std::vector<uint32_t> vertices, triangles;
    size_t uncertain = 0;
};

Answers check_answers(GpuClassifier& classifier, const TriangleMesh& mesh, const Sites& sites) {
    Answers answers{std::vector<uint32_t>(mesh.positions.size()),
                    std::vector<uint32_t>(mesh.triangles.size())};
    REQUIRE_MESSAGE(classifier.start({mesh.positions, mesh.triangles, sites, bounds(mesh)}),
                    classifier.error());
    REQUIRE_MESSAGE(classifier.finish(answers.vertices, answers.triangles), classifier.error());
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        const uint32_t site = answers.vertices[v] & ~Classifier::uncertain;
        REQUIRE(site < sites.size());
        if (answers.vertices[v] & Classifier::uncertain) {
            ++answers.uncertain;
            continue;
        }
        const auto distance2 = [&](const glm::dvec3& s) {
            long double sum = 0.0L;
            for (int k = 0; k < 3; ++k) {
                const long double d = static_cast<long double>(mesh.positions[v][k]) - s[k];
                sum += d * d;
            }
            return sum;
        };
        const long double claimed = distance2(sites[site]);
        for (size_t s = 0; s < sites.size(); ++s) REQUIRE((s == site || distance2(sites[s]) > claimed));
    }
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Triangle& c = mesh.triangles[t];
        const uint32_t a = answers.vertices[c.x];
        const bool whole =
            a == answers.vertices[c.y] && a == answers.vertices[c.z] && (a & Classifier::uncertain) == 0;
        REQUIRE(answers.triangles[t] == (whole ? a : Classifier::crossing));
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

TEST_CASE("the device's answers are right where it is sure") {
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
        CHECK(answers.uncertain >= 32); // those in the plane
        CHECK(answers.uncertain < cubes.positions.size() / 2);
    }
    SUBCASE("few and many sites") {
        for (const uint32_t count : {2u, 10u, 100u, 3000u}) {
            CAPTURE(count);
            const Answers answers =
                check_answers(*classifier, ball, uniform_sites(bounds(ball), count, count));
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

TEST_CASE("pieces are the same with the device's help and without") {
    const auto device = engine::test::make_device();
    if (!device) return;
    const auto classifier = make_classifier(*device);
    for (const TriangleMesh& mesh : {icosphere(4), torus(64, 32), torus_knot(), hollow_sphere(3),
                                     lattice_cube(8), four_legged_animal()}) {
        CAPTURE(mesh.triangles.size());
        for (const uint32_t count : {1u, 30u, 300u}) {
            const Sites sites = uniform_sites(bounds(mesh), count, 7);
            CHECK(hash_of(mesh, sites, classifier.get()) == hash_of(mesh, sites, nullptr));
        }
        // Bisectors through vertices: the device cannot tell, and says so.
        Sites own(mesh.positions.begin(), mesh.positions.begin() + 40);
        own.push_back(own.front());
        CHECK(hash_of(mesh, own, classifier.get()) == hash_of(mesh, own, nullptr));
    }
    CHECK(device->validation_messages().empty());
}

TEST_CASE("a mesh that is smaller or larger than the one before is classified as well") {
    const auto device = engine::test::make_device();
    if (!device) return;
    const auto classifier = make_classifier(*device);
    for (const uint32_t subdivisions : {1u, 4u, 2u, 5u, 0u}) {
        const TriangleMesh ball = icosphere(subdivisions);
        (void)check_answers(*classifier, ball, uniform_sites(bounds(ball), 20, subdivisions));
    }
    const TriangleMesh ball = icosphere(1);
    std::vector<uint32_t> vertices(ball.positions.size()), triangles(ball.triangles.size());
    CHECK_FALSE(classifier->finish(vertices, triangles)); // nothing was started
    CHECK_FALSE(classifier->error().empty());
    CHECK(device->validation_messages().empty());
}

TEST_CASE("sites are sorted into the bins that they lie in, those outside into the nearest") {
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

// Blows to large solids, of which only the part that a blow reaches is cut.
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/base/random.h"
#include "fracture/local/cluster_queries.h"
#include "fracture/mesh/convex_hull.h"
#include "fracture/mesh/inside.h"
#include "fracture/mesh/topology.h"
#include "fracture/shapes/shapes.h"
#include "physics/cutting/impact_pattern.h"
#include "physics/cutting/polytope.h"
#include "physics/cutting/solid_piece.h"
#include "tests/physics/destruction_fixture.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

SolidSettings settings() {
    return {.material = material_preset("stone")->material, .min_size = 0.01};
}

SolidPtr solid_of(const fracture::TriangleMesh& mesh) {
    const fracture::Result<SolidPtr> solid = make_solid(mesh, settings());
    REQUIRE(solid.has_value());
    return *solid;
}

// The solid without clusters, which is always cut as a whole.
SolidPiece without_clusters(const SolidPiece& solid) {
    (void)solid.surface(); // made from the clusters
    SolidPiece copy = solid;
    copy.clusters = {};
    return copy;
}

ImpactSites sites_at(const SolidPiece& solid, const glm::dvec3& point, double radius, uint64_t seed) {
    const Blow blow{point, glm::normalize(solid.mass.centre_of_mass - point), 1e3, 1e9};
    const Damage damage{radius, 9, false};
    return solid.is_clustered() ? impact_sites(solid.clusters, solid.mass, blow, damage, {.seed = seed})
                                : impact_sites(solid.surface().mesh, solid.mass, blow, damage, {.seed = seed});
}

const SolidPiece& largest(const std::vector<SolidPtr>& pieces) {
    return **std::ranges::max_element(pieces, {}, [](const SolidPtr& piece) { return piece->mass.volume; });
}

} // namespace

TEST_CASE("local blow: pieces have the order, volumes, masses and surfaces of a cut of the whole solid") {
    for (const fracture::TriangleMesh& mesh : {fracture::icosphere(5), fracture::torus(160, 80)}) {
        const SolidPtr solid = solid_of(mesh);
        REQUIRE(solid->clusters.triangle_count() == mesh.triangles.size());
        int local = 0;
        for (uint64_t seed = 1; seed <= 6; ++seed) {
            const glm::dvec3 point = mesh.positions[seed * 997 % mesh.positions.size()];
            const ImpactSites sites = sites_at(*solid, point, 0.15, seed);
            const auto near = break_solid(*solid, sites.sites, sites.groups, settings());
            const auto whole = break_solid(without_clusters(*solid), sites.sites, sites.groups, settings());
            REQUIRE(near.has_value());
            REQUIRE(whole.has_value());
            REQUIRE(near->size() == whole->size());
            local += largest(*near).parts.size() != largest(*whole).parts.size() ? 1 : 0;
            for (size_t k = 0; k < near->size(); ++k) {
                const SolidPiece &a = *(*near)[k], &b = *(*whole)[k];
                CHECK(a.mass.volume == doctest::Approx(b.mass.volume).epsilon(1e-9));
                CHECK(a.mass.area == doctest::Approx(b.mass.area).epsilon(1e-9));
                CHECK(glm::distance(a.mass.centre_of_mass, b.mass.centre_of_mass) < 1e-9);
                CHECK(a.body.mass == doctest::Approx(b.body.mass));
                CHECK(a.bearable == doctest::Approx(b.bearable));
                CHECK(a.radius == doctest::Approx(b.radius));
                CHECK(a.breakable == b.breakable);
                CHECK(a.surface().exterior_triangles + a.surface().cut.size() == a.surface().mesh.triangles.size());
                CHECK(a.surface().source.size() == a.surface().exterior_triangles);
                const fracture::TopologyReport report =
                    fracture::check_topology(a.surface().positions.size(), a.surface().mesh.triangles);
                CHECK(fracture::describe(report) == "");
                if (a.surface().mesh.positions.empty()) continue;
                for (uint32_t t = 0; t < a.surface().exterior_triangles; ++t) // on the triangle that it came from
                    for (int c = 0; c < 3; ++c) {
                        const fracture::Triangle& source = mesh.triangles[a.surface().source[t]];
                        const glm::dvec3& corner = mesh.positions[source.x];
                        const glm::dvec3 normal = glm::normalize(
                            glm::cross(mesh.positions[source.y] - corner, mesh.positions[source.z] - corner));
                        REQUIRE(std::abs(glm::dot(a.surface().mesh.positions[a.surface().mesh.triangles[t][c]] - corner,
                                                  normal))
                                < 1e-9);
                    }
            }
        }
        CHECK(local >= 4);
    }
}

TEST_CASE("local blow: hulls of what remains stay inside the hulls before, out of the lost cells, and fill the solid") {
    const fracture::TriangleMesh mesh = fracture::torus(160, 80);
    SolidPtr solid = solid_of(mesh);
    fracture::Random random(4);
    for (uint64_t seed = 1; seed <= 5; ++seed) {
        const glm::dvec3 point = solid->surface().mesh.positions[seed * 3331 % solid->surface().mesh.positions.size()];
        const ImpactSites sites = sites_at(*solid, point, 0.2, seed);
        const auto pieces = break_solid(*solid, sites.sites, sites.groups, settings());
        REQUIRE(pieces.has_value());
        REQUIRE(pieces->size() > 1);
        const SolidPiece& rest = largest(*pieces);
        REQUIRE(rest.clusters.triangle_count() == rest.surface().mesh.triangles.size());
        // No point of a hull of the rest lies deeper than a margin in the cell of a piece that left.
        for (const BodyPart& part : rest.parts)
            for (const glm::vec3& p : part.hull->points) {
                const glm::dvec3 at = rest.mass.centre_of_mass + glm::dvec3(part.offset + p);
                size_t nearest = 0;
                for (size_t k = 1; k < sites.sites.size(); ++k)
                    if (glm::distance(at, sites.sites[k]) < glm::distance(at, sites.sites[nearest])) nearest = k;
                CHECK(sites.groups[nearest] == sites.rest);
            }
        // The hulls hold most of the solid, and little else.
        const fracture::InsideTest inside(rest.surface().mesh);
        const fracture::Box box = fracture::bounds(rest.surface().mesh);
        std::vector<Polytope> hulls;
        for (const BodyPart& part : rest.parts)
            hulls.push_back(Polytope::around(*part.hull, static_cast<double>(part.hull->margin),
                                             rest.mass.centre_of_mass + glm::dvec3(part.offset)));
        int solid_points = 0, held = 0, air = 0;
        for (int k = 0; k < 4000; ++k) {
            const double x = random.uniform(), y = random.uniform(), z = random.uniform();
            const glm::dvec3 p = box.min + glm::dvec3(x, y, z) * box.size();
            const bool in_hull = std::ranges::any_of(hulls, [&](const Polytope& hull) {
                for (size_t f = 0; f < hull.face_count(); ++f) {
                    const auto face = hull.face(f);
                    if (glm::dot(glm::cross(face[1] - face[0], face[2] - face[0]), p - face[0]) > 0.0) return false;
                }
                return true;
            });
            solid_points += inside(p) ? 1 : 0;
            held += inside(p) && in_hull ? 1 : 0;
            air += !inside(p) && in_hull ? 1 : 0;
        }
        CHECK(held > 0.9 * solid_points);
        CHECK(air < 0.25 * solid_points);
        for (const SolidPtr& piece : *pieces)
            if (piece.get() == &rest) {
                solid = piece;
                break;
            }
    }
}

TEST_CASE("local blow: forty blows all stay local, add few hulls, and none of these reaches into a piece that left") {
    const fracture::TriangleMesh mesh = fracture::torus(160, 80);
    struct Case {
        bool one_place;
        double roughness;
    };
    for (const Case& one : {Case{false, 0.0}, {true, 0.0}, {false, 0.3}}) {
        CAPTURE(one.one_place);
        CAPTURE(one.roughness);
        SolidSettings own = settings();
        own.rough.amount = one.roughness;
        SolidPtr solid = *make_solid(mesh, own);
        const double volume = solid->mass.volume;
        double lost = 0.0;
        std::vector<SolidPtr> left;
        fracture::Random random(9);
        size_t blows = 0;
        for (uint64_t seed = 1; seed <= 40; ++seed) {
            const double x = random.uniform() - 0.5, y = random.uniform() - 0.5, z = random.uniform() - 0.5;
            const glm::dvec3 way = one.one_place ? glm::dvec3(1.0, 0.1, 0.2) : glm::dvec3(x, y, z);
            const glm::dvec3 point = fracture::nearest_on(solid->clusters, 3.0 * glm::normalize(way));
            const ImpactSites sites = sites_at(*solid, point, 0.12, seed);
            const auto pieces = break_solid(*solid, sites.sites, sites.groups, own);
            REQUIRE(pieces.has_value());
            fracture::ClusterSet before;
            solid->clusters.for_each([&](const fracture::ClusterPtr& cluster) { before.insert(cluster.get()); });
            const SolidPtr rest =
                *std::ranges::max_element(*pieces, {}, [](const SolidPtr& piece) { return piece->mass.volume; });
            size_t kept = 0;
            rest->clusters.for_each(
                [&](const fracture::ClusterPtr& cluster) { kept += before.contains(cluster.get()) ? 1 : 0; });
            CHECK(kept > before.size() / 2); // a cut of the whole mesh makes all clusters anew
            blows += pieces->size() > 1 ? 1 : 0;
            for (const SolidPtr& piece : *pieces)
                if (piece != rest) {
                    lost += piece->mass.volume;
                    left.push_back(piece);
                }
            solid = rest;
        }
        CHECK(blows >= 35);
        CHECK(solid->mass.volume + lost == doctest::Approx(volume).epsilon(1e-9));
        CHECK(solid->parts.size() < 24 + 12 * blows);
        // Hulls and margins, as planes from an independent hull of their points.
        struct Convex {
            std::vector<HullPlane> planes; // of the points alone
            glm::dvec3 place;
        };
        std::vector<Convex> hulls;
        for (const BodyPart& part : solid->parts) {
            Convex& convex = hulls.emplace_back();
            convex.place = solid->mass.centre_of_mass + glm::dvec3(part.offset);
            const fracture::TriangleMesh full = fracture::convex_hull(part.hull->points);
            for (const fracture::Triangle& t : full.triangles) {
                const glm::dvec3& a = full.positions[t.x];
                const glm::dvec3 area = glm::cross(full.positions[t.y] - a, full.positions[t.z] - a);
                if (glm::length(area) > 0.0)
                    convex.planes.push_back({glm::normalize(area), glm::dot(glm::normalize(area), a)});
            }
        }
        const auto holds = [](const Convex& convex, const glm::dvec3& p, double depth) {
            return std::ranges::all_of(convex.planes, [&](const HullPlane& plane) {
                return glm::dot(plane.normal, p - convex.place) <= plane.distance - depth;
            });
        };
        // The corners of the pieces that left, and points between them.
        int reached = 0;
        const double depth = 5e-3; // half a margin: hulls that are cut again have corners where margins were round
        for (const SolidPtr& piece : left)
            for (const BodyPart& part : piece->parts) {
                const glm::dvec3 place = piece->mass.centre_of_mass + glm::dvec3(part.offset);
                glm::dvec3 middle(0.0);
                for (const glm::vec3& p : part.hull->points)
                    middle += glm::dvec3(p) / static_cast<double>(part.hull->points.size());
                for (const glm::vec3& p : part.hull->points)
                    for (const double share : {0.0, 0.5, 1.0})
                        for (const Convex& convex : hulls)
                            reached += holds(convex, place + middle + share * (glm::dvec3(p) - middle), depth) ? 1 : 0;
            }
        CHECK(reached == 0);
        // The hulls hold most of the solid, and little else.
        const fracture::InsideTest inside(solid->surface().mesh);
        const fracture::Box box = fracture::bounds(solid->surface().mesh);
        int solid_points = 0, held = 0, air = 0;
        for (int k = 0; k < 8000; ++k) {
            const double x = random.uniform(), y = random.uniform(), z = random.uniform();
            const glm::dvec3 p = box.min + glm::dvec3(x, y, z) * box.size();
            const bool in_hull = std::ranges::any_of(hulls, [&](const Convex& hull) { return holds(hull, p, -0.01); });
            solid_points += inside(p) ? 1 : 0;
            held += inside(p) && in_hull ? 1 : 0;
            air += !inside(p) && in_hull ? 1 : 0;
        }
        MESSAGE(solid->parts.size(), " hulls, ", held, " of ", solid_points, " points held, ", air, " in air");
        CHECK(held > 0.9 * solid_points);
        CHECK(air < 0.25 * solid_points);
    }
}

TEST_CASE("local blow: pieces of flat and rough blows, one after the other, do not push apart at birth"
          * doctest::test_suite("long")) {
    const fracture::TriangleMesh thick = fracture::torus(160, 80), thin = fracture::torus(240, 60, 1.0, 0.15);
    struct Case {
        const fracture::TriangleMesh* mesh;
        double amount;
    };
    for (const Case& one : {Case{&thick, 0.0}, {&thick, 0.3}, {&thick, 0.8}, {&thin, 0.0}, {&thin, 0.3}}) {
        const fracture::TriangleMesh& mesh = *one.mesh;
        const double amount = one.amount;
        CAPTURE(amount);
        World world(
            {.gravity = glm::vec3(0.0f), .ground_height = std::nullopt, .air_density = 0.0f, .sleeping = false});
        Destruction destruction({.latency = 1});
        BreakableDesc desc = test_destruction::desc_of(0.02);
        desc.solid.rough.amount = amount;
        (void)test_destruction::must_add(destruction, world, mesh, desc);
        for (size_t blow = 0; blow < 4; ++blow) {
            PieceId largest = destruction.pieces()[0];
            for (const PieceId piece : destruction.pieces())
                if (destruction.solid(piece)->mass.volume > destruction.solid(largest)->mass.volume) largest = piece;
            const SolidPtr solid = destruction.solid(largest);
            REQUIRE(solid->clusters.triangle_count() > 0);
            const glm::vec3 at = solid->surface().positions[(blow + 1) * 2711 % solid->surface().positions.size()];
            const glm::vec3 centre = world.pose(destruction.body(largest)).position;
            const size_t before = destruction.pieces().size();
            destruction.strike(world, largest, centre + at, -glm::normalize(at), 300.0);
            test_destruction::run(world, destruction, 10);
            CHECK(destruction.pieces().size() > before + 2);
        }
        test_destruction::run(world, destruction, 120);
        float fastest = 0.0f;
        for (const PieceId piece : destruction.pieces())
            fastest = std::max(fastest, glm::length(world.linear_velocity(destruction.body(piece))));
        CHECK(fastest < 0.005f);
        CHECK(test_destruction::volume_of(destruction)
              == doctest::Approx(fracture::mass_properties(mesh.positions, mesh.triangles).volume).epsilon(1e-9));
    }
}

TEST_CASE("local blow: a ring that is broken through twice falls into two solids, each with its own hulls") {
    SolidPtr solid = solid_of(fracture::torus(240, 60, 1.0, 0.15));
    std::vector<SolidPtr> pieces;
    for (const double x : {1.0, -1.0}) {
        const ImpactSites sites = sites_at(*solid, {1.15 * x, 0.0, 0.0}, 0.45, 3);
        const auto broken = break_solid(*solid, sites.sites, sites.groups, settings());
        REQUIRE(broken.has_value());
        pieces = *broken;
        std::ranges::sort(pieces, std::greater<>(), [](const SolidPtr& piece) { return piece->mass.volume; });
        solid = pieces[0];
        REQUIRE(solid->clusters.triangle_count() > 0);
    }
    REQUIRE(pieces.size() > 3);
    CHECK(pieces[1]->mass.volume > 0.6 * pieces[0]->mass.volume);
    CHECK(pieces[2]->mass.volume < 0.2 * pieces[0]->mass.volume);
    for (size_t k = 0; k < 2; ++k) {
        const SolidPiece &own = *pieces[k], &other = *pieces[1 - k];
        const fracture::InsideTest in_other(other.surface().mesh);
        CHECK(own.parts.size() >= 3);
        for (const BodyPart& part : own.parts)
            for (const glm::vec3& p : part.hull->points)
                CHECK_FALSE(in_other(own.mass.centre_of_mass + glm::dvec3(part.offset + p)));
    }
}

TEST_CASE("local blow: blows into one crater stay local, and keep the blocks of a held solid") {
    SolidSettings held = settings();
    held.anchors = {fracture::Box{glm::dvec3(-9.0), glm::dvec3(9.0, -0.9, 9.0)}};
    const fracture::TriangleMesh mesh = fracture::icosphere(5);
    SolidPtr solid = *make_solid(mesh, held);
    REQUIRE(solid->blocks);
    const std::shared_ptr<const HeldBlocks> first = solid->blocks;
    double lost = 0.0;
    for (uint64_t seed = 1; seed <= 6; ++seed) {
        const glm::dvec3 point = fracture::nearest_on(solid->clusters, glm::dvec3(1.0, 0.0, 0.0));
        const ImpactSites sites = sites_at(*solid, point, 0.2, seed);
        const auto pieces = break_solid(*solid, sites.sites, sites.groups, held);
        REQUIRE(pieces.has_value());
        const SolidPiece& rest = largest(*pieces);
        REQUIRE(rest.is_clustered());
        REQUIRE(rest.blocks);
        CHECK(rest.blocks->sites == first->sites); // not divided anew
        lost = solid_of(mesh)->mass.volume - rest.mass.volume;
        double mass = 0.0;
        for (const StressNode& node : rest.blocks->nodes) mass += node.mass;
        CHECK(mass == doctest::Approx(rest.body.mass));
        solid = *std::ranges::max_element(*pieces, {}, [](const SolidPtr& piece) { return piece->mass.volume; });
    }
    CHECK(lost > 0.01);
}

TEST_CASE("local blow: a budget knows the surface of the cracks, and ends a cut that exceeds it") {
    for (const fracture::TriangleMesh& mesh : {fracture::icosphere(5), fracture::cube(1.0)}) {
        const SolidPtr solid = solid_of(mesh);
        const ImpactSites sites = sites_at(*solid, mesh.positions[5], 0.2, 2);
        for (const double roughness : {0.0, 0.4}) {
            SolidSettings own = settings();
            own.rough = {.amount = roughness};
            CrackBudget ample{.limit = 1e9};
            const auto pieces = break_solid(*solid, sites.sites, sites.groups, own, {}, &ample);
            REQUIRE(pieces.has_value());
            CHECK(pieces->size() > 2);
            CHECK(ample.surface == doctest::Approx(new_surface(*solid, *pieces)).epsilon(1e-6));
            CHECK_FALSE(ample.exceeded());
            CrackBudget tight{.limit = 0.99 * ample.surface};
            const auto none = break_solid(*solid, sites.sites, sites.groups, own, {}, &tight);
            REQUIRE(none.has_value());
            CHECK(none->empty());
            CHECK(tight.exceeded());
            CHECK(tight.surface == ample.surface);
        }
    }
}

TEST_CASE("local blow: hulls do not depend on the number of threads that make them") {
    const fracture::TriangleMesh mesh = fracture::torus(160, 80);
    std::vector<std::vector<SolidPtr>> by_threads;
    for (const uint32_t threads : {1u, 2u, 5u}) {
        SolidSettings own = settings();
        own.hull_threads = threads;
        SolidPtr solid = solid_of(mesh);
        std::vector<SolidPtr>& all = by_threads.emplace_back();
        for (uint64_t seed = 1; seed <= 3; ++seed) {
            const ImpactSites sites = sites_at(*solid, mesh.positions[seed * 3331 % mesh.positions.size()], 0.2, seed);
            const auto pieces = break_solid(*solid, sites.sites, sites.groups, own);
            REQUIRE(pieces.has_value());
            REQUIRE(pieces->size() > 1);
            all.insert(all.end(), pieces->begin(), pieces->end());
            solid = *std::ranges::max_element(*pieces, {}, [](const SolidPtr& p) { return p->mass.volume; });
        }
    }
    for (const std::vector<SolidPtr>& other : by_threads) {
        REQUIRE(other.size() == by_threads[0].size());
        for (size_t k = 0; k < other.size(); ++k) {
            const std::vector<BodyPart>&a = by_threads[0][k]->parts, &b = other[k]->parts;
            REQUIRE(a.size() == b.size());
            for (size_t part = 0; part < a.size(); ++part) {
                CHECK(a[part].offset == b[part].offset);
                CHECK(a[part].hull->points == b[part].hull->points);
                CHECK(a[part].hull->margin == b[part].hull->margin);
                CHECK(a[part].hull->faces.corners == b[part].hull->faces.corners);
            }
        }
    }
}

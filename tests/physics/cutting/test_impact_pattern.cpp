#include "physics/cutting/impact_pattern.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/mesh/mass_properties.h"
#include "fracture/shapes/shapes.h"

using namespace brittle;
using namespace brittle::physics;
using fracture::PatternKind;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

const Blow top{.point = {0.0, 1.0, 0.0}, .normal = {0.0, -1.0, 0.0}, .energy = 100.0};

ImpactSites sites_of(const fracture::TriangleMesh& mesh, const Blow& blow, const Damage& damage,
                     const ImpactPattern& pattern) {
    return impact_sites(mesh, fracture::mass_properties(mesh.positions, mesh.triangles), blow, damage, pattern);
}

// The sites of pieces, without those of the rest.
std::vector<glm::dvec3> inner(const ImpactSites& cut) {
    std::vector<glm::dvec3> sites;
    for (size_t i = 0; i < cut.sites.size(); ++i)
        if (cut.groups[i] != cut.rest) sites.push_back(cut.sites[i]);
    return sites;
}

} // namespace

TEST_CASE("impact pattern: a blow without energy, point or direction does no damage") {
    const Material material;
    for (const double energy : {0.0, -1.0, not_a_number, infinity})
        CHECK(damage_of({top.point, top.normal, energy}, material, 1.0).pieces == 0);
    CHECK(damage_of({{not_a_number, 0.0, 0.0}, top.normal, 1.0}, material, 1.0).pieces == 0);
    CHECK(damage_of({top.point, {0.0, infinity, 0.0}, 1.0}, material, 1.0).pieces == 0);
    CHECK(damage_of({top.point, glm::dvec3(0.0), 1.0}, material, 1.0).pieces == 0);
    for (const double volume : {0.0, -1.0, not_a_number, infinity}) CHECK(damage_of(top, material, volume).pieces == 0);
    CHECK(sites_of(fracture::cube(), top, {}, {}).sites.empty());
}

TEST_CASE("impact pattern: the energy for a radius gives damage of that radius") {
    const Material material;
    for (const double value : {0.0, -1.0, not_a_number, infinity}) {
        CHECK(energy_of(value, material, 1.0, 40) == 0.0);
        CHECK(energy_of(0.1, material, value, 40) == 0.0);
    }
    for (const uint32_t most : {0u, 1u, 10u, 48u, 1000u})
        for (const double volume : {1e-6, 1e-3, 1.0, 50.0})
            for (double radius = 1e-3; radius < 10.0; radius *= 1.9) {
                CAPTURE(radius);
                const double energy = energy_of(radius, material, volume, most);
                const DamageLimits limits{.max_pieces = most};
                // The radius jumps where the number of pieces does; energy_of() finds the least energy that reaches it.
                CHECK(damage_of({top.point, top.normal, energy * (1.0 + 1e-9)}, material, volume, limits).radius
                      >= radius * (1.0 - 1e-9));
                CHECK(damage_of({top.point, top.normal, energy * (1.0 - 1e-6)}, material, volume, limits).radius
                      <= radius * (1.0 + 1e-9));
            }
}

TEST_CASE("impact pattern: damage grows and refines with energy, within the limits of number and size") {
    const Material material;
    double radius = 0.0;
    uint32_t pieces = 0;
    for (double energy = 1e-3; energy < 1e7; energy *= 1.7) {
        const Damage damage = damage_of({top.point, top.normal, energy}, material, 8.0, {.max_pieces = 40});
        CHECK(damage.radius > radius);
        CHECK(damage.pieces >= std::max(pieces, 1u));
        CHECK(damage.pieces <= 40);
        radius = damage.radius;
        pieces = damage.pieces;
    }
    CHECK(pieces == 40);
    // Within the limits of n, the surface between the cubes of the header's formula takes the whole energy.
    const Blow blow{top.point, top.normal, 2000.0};
    const Damage damage = damage_of(blow, material, 8.0);
    const double volume = 2.0 / 3.0 * 3.14159265358979 * std::pow(damage.radius, 3.0);
    const double surface = 3.0 * volume / std::cbrt(volume / damage.pieces);
    CHECK(surface * material.fracture_energy == doctest::Approx(2000.0).epsilon(1e-9));

    CHECK(damage_of(blow, material, 8.0, {.min_volume = 4.1}).pieces == 0);
    const double least = volume / 3.5;
    CHECK(damage_of(blow, material, 8.0, {.min_volume = least}).pieces == 3);
}

TEST_CASE("impact pattern: a blow that the solid bears damages no farther than the crack of its contact reaches") {
    const Material material;
    const DamageLimits limits{.max_pieces = 40, .bearable = 1e6};
    const auto damage_by = [&](double energy, double force) {
        return damage_of({top.point, top.normal, energy, force}, material, 8.0, limits);
    };
    for (const double force : {0.0, -1.0, not_a_number}) CHECK(damage_by(100.0, force).pieces == 0);
    for (const double energy : {1e-3, 1.0, 100.0, 1e4, 1e6}) {
        const Damage whole = damage_by(energy, infinity);
        CHECK_FALSE(whole.local);
        Damage before;
        for (double force = 1.0; force <= 1e6; force *= 2.1) {
            const Damage damage = damage_by(energy, force);
            CAPTURE(energy);
            CAPTURE(force);
            CHECK(damage.local);
            CHECK(damage.radius <= contact_crack(material, force));
            CHECK(damage.radius <= whole.radius);
            CHECK(damage.radius >= before.radius);
            CHECK(damage.pieces >= std::max(before.pieces, 4u));
            CHECK(damage.pieces <= whole.pieces);
            before = damage;
        }
        CHECK(damage_by(energy, 1.01e6).radius == whole.radius);
    }
}

TEST_CASE("impact pattern: pieces lie around the contact inside the solid, the rest beyond") {
    const fracture::TriangleMesh mesh = fracture::icosphere(4);
    for (const PatternKind kind : {PatternKind::uniform, PatternKind::clustered, PatternKind::radial,
                                   PatternKind::splinters, PatternKind::thickness}) {
        const Damage damage{.radius = 0.3, .pieces = 30};
        const ImpactSites cut = sites_of(mesh, top, damage, {.kind = kind, .seed = 3});
        REQUIRE(cut.groups.size() == cut.sites.size());
        const std::vector<glm::dvec3> pieces = inner(cut);
        CHECK(pieces.size() == 30);
        const double stretch = kind == PatternKind::splinters ? 4.0 : 1.0; // 8^(2/3)
        for (const glm::dvec3& site : pieces) {
            CHECK(glm::distance(site, top.point) <= 0.3 * stretch);
            if (kind != PatternKind::splinters) CHECK(glm::dot(site - top.point, top.normal) >= -1e-12);
        }
        if (kind != PatternKind::splinters)
            for (size_t i = 0; i < cut.sites.size(); ++i)
                if (cut.groups[i] == cut.rest) CHECK(glm::distance(cut.sites[i], top.point) > 0.3);
        const ImpactSites again = sites_of(mesh, top, damage, {.kind = kind, .seed = 3});
        CHECK(again.sites == cut.sites);
        CHECK(sites_of(mesh, top, damage, {.kind = kind, .seed = 4}).sites != cut.sites);
    }
}

// The nearest site owns the cell of a point.
TEST_CASE("impact pattern: the contact lies in a piece, for any pattern and number of pieces") {
    const fracture::TriangleMesh wall = fracture::cuboid({2.0, 1.2, 0.2}), ball = fracture::icosphere(4);
    const Blow front{.point = {0.0, 0.2, 0.1}, .normal = {0.0, 0.0, -1.0}, .energy = 1.0};
    const auto comes_off = [](const ImpactSites& cut, const glm::dvec3& place) {
        size_t nearest = 0;
        for (size_t k = 1; k < cut.sites.size(); ++k)
            if (glm::distance(cut.sites[k], place) < glm::distance(cut.sites[nearest], place)) nearest = k;
        return cut.groups[nearest] != cut.rest;
    };
    for (const PatternKind kind : {PatternKind::uniform, PatternKind::clustered, PatternKind::radial,
                                   PatternKind::splinters, PatternKind::thickness})
        for (const uint32_t pieces : {4u, 6u, 8u, 12u, 16u, 24u, 32u, 48u, 100u})
            for (uint64_t seed = 1; seed <= 5; ++seed) {
                CAPTURE(static_cast<int>(kind));
                CAPTURE(pieces);
                CAPTURE(seed);
                const Damage damage{.radius = 0.25, .pieces = pieces};
                CHECK(comes_off(sites_of(wall, front, damage, {.kind = kind, .seed = seed}), front.point));
                CHECK(comes_off(sites_of(ball, top, damage, {.kind = kind, .seed = seed}), top.point));
                if (kind != PatternKind::splinters) continue;
                // Along the grain, X, over half of the length of the damage: r * 8^(2/3) to both sides.
                const ImpactSites cut = sites_of(wall, front, damage, {.kind = kind, .seed = seed});
                for (double along = -0.5; along <= 0.5; along += 0.02)
                    CHECK(comes_off(cut, front.point + glm::dvec3(along, 0.0, 0.0)));
            }
}

TEST_CASE("impact pattern: shards lie across the blow, splinters along the grain, and sites inside a thin pane") {
    const fracture::TriangleMesh pane = fracture::cuboid({2.0, 1.4, 0.03});
    const Blow front{.point = {0.1, 0.2, 0.015}, .normal = {0.0, 0.0, -1.0}, .energy = 1.0};
    for (const glm::dvec3& site : inner(sites_of(pane, front, {0.4, 24}, {.kind = PatternKind::radial})))
        CHECK(std::abs(site.z - 0.015) < 1e-12);
    for (const glm::dvec3& site : inner(sites_of(pane, front, {0.4, 24}, {.kind = PatternKind::uniform})))
        CHECK(std::abs(site.z) <= 0.015 + 1e-12);

    const fracture::TriangleMesh beam = fracture::cuboid({0.2, 3.0, 0.2}); // its grain runs along Y
    const Blow side{.point = {0.1, 0.5, 0.0}, .normal = {-1.0, 0.0, 0.0}, .energy = 1.0};
    const auto splinters =
        inner(sites_of(beam, side, {0.2, 32}, {.kind = PatternKind::splinters, .slenderness = 27.0}));
    for (const glm::dvec3& site : splinters) {
        CHECK(std::abs(site.y - 0.5) <= 0.2 * 9.0);
        CHECK(std::hypot(site.x - 0.1, site.z) <= 0.2 / 3.0);
    }
}

TEST_CASE("impact pattern: a given diagram is fitted to the solid, and only its cells near the blow come off") {
    const fracture::TriangleMesh mesh = fracture::cube(2.0);
    ImpactPattern pattern;
    for (int x = 0; x < 5; ++x)
        for (int y = 0; y < 5; ++y)
            for (int z = 0; z < 5; ++z) pattern.diagram.emplace_back(100.0 + 10.0 * x, 10.0 * y, 10.0 * z);
    const ImpactSites cut = sites_of(mesh, top, {.radius = 0.8, .pieces = 1}, pattern);
    REQUIRE(cut.sites.size() == 125);
    size_t pieces = 0;
    for (size_t i = 0; i < 125; ++i) {
        CHECK(std::abs(cut.sites[i].y) <= 1.0 + 1e-9); // turned about Y only, and fitted to the cube's height
        const bool near = glm::distance(cut.sites[i], top.point) <= 0.8;
        CHECK((cut.groups[i] != cut.rest) == near);
        pieces += near ? 1u : 0u;
    }
    CHECK(pieces > 4);
    CHECK(pieces < 60);
}

TEST_CASE("impact pattern: spread points are vertices far from each other") {
    CHECK(spread_points({}, 5).empty());
    const std::vector<glm::dvec3> same(10, glm::dvec3(1.0));
    CHECK(spread_points(same, 5).size() == 1);
    const fracture::TriangleMesh ball = fracture::icosphere(3);
    const std::vector<glm::dvec3> points = spread_points(ball.positions, 12, std::vector{glm::dvec3(0.0, 1.0, 0.0)});
    REQUIRE(points.size() == 12);
    for (size_t i = 0; i < points.size(); ++i) {
        CHECK(std::ranges::find(ball.positions, points[i]) != ball.positions.end());
        CHECK(glm::distance(points[i], glm::dvec3(0.0, 1.0, 0.0)) > 0.5);
        for (size_t j = 0; j < i; ++j)
            CHECK(glm::distance(points[i], points[j]) > 0.5); // 12 caps of radius 0.6 cover the sphere
    }
}

TEST_CASE("impact pattern: the energy that breaks a solid does, and a little less does not") {
    const Material material = material_preset("stone")->material;
    const double volume = 0.125;
    const DamageLimits limits{.max_pieces = 24, .min_volume = 1e-4, .bearable = 5e4};
    CHECK(breaking_energy({.energy = 0.0, .force = 1.0}, 0.0, material, volume, limits)
          == std::numeric_limits<double>::infinity());
    CHECK(breaking_energy({.energy = 1.0, .force = 1.0}, 0.0, material, 0.0, limits)
          == std::numeric_limits<double>::infinity());
    CHECK(breaking_energy({.energy = 2.0, .force = 10.0}, 0.0, material, volume, limits) // a thousand times is too weak
          == std::numeric_limits<double>::infinity());
    for (const double force : {1e3, 1e4, 1e5, 1e7})
        for (const double bounce : {0.0, 0.6}) {
            CAPTURE(force);
            CAPTURE(bounce);
            const Blow blow{.energy = 2.0, .force = force};
            const double needed = breaking_energy(blow, bounce, material, volume, limits);
            REQUIRE(std::isfinite(needed));
            const auto pieces_at = [&](double energy) {
                Blow other = blow;
                other.force *= std::sqrt(energy / blow.energy);
                other.energy = other.force > limits.bearable ? energy : (1.0 - bounce) * energy;
                return damage_of(other, material, volume, limits).pieces;
            };
            CHECK(pieces_at(1.001 * needed) > 0);
            CHECK(pieces_at(0.999 * needed) == 0);
        }
}

#include "physics/world/pieces.h"

#include <cmath>
#include <limits>
#include <string>

#include <doctest/doctest.h>

#include "fracture/fracture.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "physics/bonds/structure.h"
#include "tests/physics/bodies.h"
#include "tests/physics/convex_pieces.h"
#include "tests/physics/run_log.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;

namespace {

constexpr float max_drift = 1e-6f; // m, of bodies that do not overlap; at most 1e-16 was observed

std::vector<BodyId> must_add(World& world, const fracture::Fragments& fragments, const Material& material = {},
                             const PlacedMotion& motion = {}) {
    Result<std::vector<BodyId>> bodies = add_pieces(world, fragments, material, motion);
    REQUIRE_MESSAGE(bodies.has_value(), (bodies ? std::string() : bodies.error().message));
    REQUIRE(bodies->size() == fragments.pieces.size());
    return *bodies;
}

// All bodies collide, however small.
WorldSettings space_for_all() {
    WorldSettings settings = empty_space;
    settings.debris_size = 0.0f;
    settings.max_colliding = 0;
    return settings;
}

// Adds pieces without sibling numbers, as contacts of siblings in formation are not searched for. Hulls are scaled.
Drift drift_of_strangers(const fracture::Fragments& fragments, float factor = 1.0f) {
    PieceHulls hulls = collision_hulls(fragments);
    if (factor != 1.0f)
        for (auto& hull : hulls) hull = inflated(*hull, factor);
    const Result<PieceForms> forms = piece_forms(fragments, {}, hulls);
    REQUIRE(forms.has_value());
    std::vector<BodyDesc> bodies(forms->size());
    for (size_t i = 0; i < bodies.size(); ++i) {
        bodies[i].form = (*forms)[i];
        bodies[i].pose.position = glm::vec3(fragments.pieces[i].mass.centre_of_mass);
    }
    World world(space_for_all());
    REQUIRE(world.add_bodies(bodies).has_value());
    return drift(world, 10);
}

// Checks that new pieces do not overlap, and that the check would notice hulls enlarged by a twentieth.
void check_that_they_stay(const fracture::Fragments& fragments) {
    World world(space_for_all());
    must_add(world, fragments);
    for (const Drift& stayed : {drift(world, 120), drift_of_strangers(fragments)}) {
        CHECK(stayed.speed < 1e-3f);
        CHECK(stayed.way < max_drift);
    }
    CHECK(drift_of_strangers(fragments, 1.05f).way > 100.0f * max_drift);
}

// Returns the height of the lowest vertex of all pieces, of the meshes rather than the hulls.
float lowest_vertex(const World& world, const fracture::Fragments& fragments, const std::vector<BodyId>& bodies) {
    float lowest = std::numeric_limits<float>::infinity();
    for (size_t i = 0; i < bodies.size(); ++i) {
        const Pose pose = world.pose(bodies[i]);
        for (const glm::dvec3& p : fragments.positions_of(fragments.pieces[i])) {
            const glm::vec3 local(p - fragments.pieces[i].mass.centre_of_mass);
            lowest = std::min(lowest, (pose.position + pose.orientation * local).y);
        }
    }
    return lowest;
}

} // namespace

TEST_CASE("no pieces give no bodies") {
    World world;
    CHECK(must_add(world, fracture::Fragments{}).empty());
}

TEST_CASE("invalid fragments are refused, the piece is named, and nothing is added") {
    const fracture::Fragments good = test::grid_pieces(glm::dvec3(0.0), glm::dvec3(1.0), 2, 1, 1);
    World world;
    fracture::Fragments bad = good;
    bad.positions[30].x = std::numeric_limits<double>::quiet_NaN();
    Result<std::vector<BodyId>> result = add_pieces(world, bad);
    REQUIRE_FALSE(result.has_value());
    CHECK(result.error().status == fracture::Status::invalid_mesh);
    CHECK(result.error().message.find("piece 1") != std::string::npos);
    CHECK(result.error().message.find("vertex 30") != std::string::npos);

    bad = good;
    bad.pieces[1].vertices.end = 1000;
    result = add_pieces(world, bad);
    REQUIRE_FALSE(result.has_value());
    CHECK(result.error().message.find("1000") != std::string::npos);

    bad = good;
    bad.pieces[0].mass.centre_of_mass.z = std::numeric_limits<double>::infinity();
    CHECK_FALSE(add_pieces(world, bad).has_value());
    for (const float density : {0.0f, -1.0f, std::numeric_limits<float>::quiet_NaN(), 1e38f}) {
        CAPTURE(density);
        CHECK_FALSE(add_pieces(world, good, {.density = density}).has_value());
    }
    CHECK_FALSE(add_pieces(world, good, {.restitution = 7.0f}).has_value());
    CHECK_FALSE(add_pieces(world, good, {}, {.linear_velocity = {NAN, 0.0f, 0.0f}}).has_value());
    CHECK(world.body_count() == 0);
}

TEST_CASE("pieces without volume, needles, crumbs and giants give no NaN") {
    for (const double size : {1e-4, 1e-2, 1.0, 1e3}) {
        std::vector<test::Polyhedron> shapes{
            test::box_polyhedron({0, 2, 0}, {1, 2.000001, 1}), // a flake
            test::box_polyhedron({0, 3, 0}, {1, 3.0001, 0.0001}),
            test::box_polyhedron({0, 4, 0}, {1, 5, 1}),
        };
        fracture::Fragments fragments = test::fragments_of(shapes);
        test::append_piece(fragments, {{{0, 6, 0}, {1, 6, 0}, {0, 6, 1}}}); // one triangle, no volume
        fragments.pieces.back().mass.centre_of_mass = {0.3, 6.0, 0.3};
        test::append_piece(fragments, {{{0, 7, 0}, {0, 7, 0}, {0, 7, 0}}}); // a point
        fragments.pieces.back().mass.centre_of_mass = {0.0, 7.0, 0.0};
        fracture::Piece nothing;
        nothing.mass.centre_of_mass = {0.0, 8.0, 0.0};
        fragments.pieces.push_back(nothing);
        for (glm::dvec3& position : fragments.positions) position *= size;
        for (fracture::Piece& piece : fragments.pieces) {
            piece.mass.volume *= size * size * size;
            piece.mass.centre_of_mass *= size;
            piece.mass.inertia *= std::pow(size, 5.0);
        }
        CAPTURE(size);
        World world;
        must_add(world, fragments);
        for (int step = 0; step < 360; ++step) world.step();
        CHECK(all_finite(world));
        for (const BodyId id : world.bodies()) CHECK(world.pose(id).position.y > -0.01 * size - 1e-3);
        std::vector<DebugLine> lines;
        world.debug_lines(lines, {.hulls = true, .contacts = true});
        for (const DebugLine& line : lines) CHECK(std::isfinite(line.from.x + line.to.y));
    }
}

TEST_CASE("mass and inertia equal the closed forms") {
    // A box with sides 0.2, 0.4, 0.6.
    World world(empty_space);
    const auto boxes = test::fragments_of({test::box_polyhedron({1.0, 2.0, 3.0}, {1.2, 2.4, 3.6})});
    const PlacedMotion spinning{.placement = {{-1.1f, -2.2f, -3.3f}, {1.0f, 0.0f, 0.0f, 0.0f}},
                                .linear_velocity = glm::cross(glm::vec3(1.1f, 2.2f, 3.3f), glm::vec3(0.0f)),
                                .angular_velocity = {}};
    const std::vector<BodyId> body = must_add(world, boxes, {.density = 1000.0f}, spinning);
    CHECK(world.mass(body[0]) == doctest::Approx(48.0));
    CHECK(glm::length(world.pose(body[0]).position) < 1e-6f);
    for (int axis = 0; axis < 3; ++axis) {
        glm::vec3 arm(0.0f), push(0.0f);
        arm[(axis + 1) % 3] = 1.0f;
        push[(axis + 2) % 3] = 1.0f; // a couple: torque of 2 about the axis without force
        const glm::vec3 before = world.angular_velocity(body[0]);
        world.apply_impulse(body[0], push, arm);
        world.apply_impulse(body[0], -push, -arm);
        const double square[3] = {0.04, 0.16, 0.36};
        const double moment = 48.0 / 12.0 * (square[(axis + 1) % 3] + square[(axis + 2) % 3]);
        CHECK((world.angular_velocity(body[0]) - before)[axis]
              == doctest::Approx(2.0 / moment).epsilon(1e-5).scale(0.0));
    }

    // A sphere of 64 x 128 faces: 2/5 m r^2 up to the error of the facets.
    test::Polyhedron sphere;
    const int rings = 64, segments = 128;
    const auto at = [&](int ring, int segment) {
        const double polar = M_PI * ring / rings, angle = 2.0 * M_PI * (segment % segments) / segments;
        return glm::dvec3(std::sin(polar) * std::cos(angle), std::cos(polar), -std::sin(polar) * std::sin(angle)) * 0.5;
    };
    for (int ring = 0; ring < rings; ++ring)
        for (int s = 0; s < segments; ++s)
            sphere.push_back({at(ring, s), at(ring + 1, s), at(ring + 1, s + 1), at(ring, s + 1)});
    World second(empty_space);
    const std::vector<BodyId> ball = must_add(second, test::fragments_of({sphere}), {.density = 1000.0f});
    const double mass = 1000.0 * 4.0 / 3.0 * M_PI * 0.125;
    CHECK(second.mass(ball[0]) == doctest::Approx(mass).epsilon(2e-3).scale(0.0));
    second.apply_impulse(ball[0], {0.0f, 1.0f, 0.0f}, {1.0f, 0.0f, 0.0f});
    CHECK(second.angular_velocity(ball[0]).z == doctest::Approx(1.0 / (0.4 * mass * 0.25)).epsilon(4e-3).scale(0.0));
}

TEST_CASE("pieces inherit the motion of the solid that broke") {
    World world(empty_space);
    const auto fragments = test::voronoi_pieces(glm::dvec3(-0.5), glm::dvec3(0.5), 20, 3);
    PlacedMotion motion;
    motion.placement = {{1.0f, 2.0f, 3.0f}, glm::angleAxis(0.7f, glm::normalize(glm::vec3(1.0f, 2.0f, -1.0f)))};
    motion.linear_velocity = {0.5f, 0.0f, -1.0f};
    motion.angular_velocity = {0.3f, 2.0f, 0.1f};
    const std::vector<BodyId> bodies = must_add(world, fragments, {.density = 1000.0f}, motion);
    // A unit cube of 1000 kg: momentum m v, and the rotational energy and angular momentum of the whole.
    const Mechanics sum = world.mechanics();
    CHECK(glm::length(sum.momentum - 1000.0 * glm::dvec3(motion.linear_velocity)) < 1e-2);
    const glm::dvec3 orbital =
        glm::cross(glm::dvec3(motion.placement.position), 1000.0 * glm::dvec3(motion.linear_velocity));
    const glm::dvec3 own = 1000.0 / 6.0 * glm::dvec3(motion.angular_velocity);
    CHECK(glm::length(sum.angular_momentum - orbital - own) < 1e-2);
    for (size_t i = 0; i < bodies.size(); ++i) {
        const glm::vec3 centre(fragments.pieces[i].mass.centre_of_mass);
        const Pose pose = world.pose(bodies[i]);
        CHECK(glm::length(pose.position - motion.placement.position - motion.placement.orientation * centre) < 1e-5f);
        CHECK(std::abs(glm::dot(pose.orientation, motion.placement.orientation)) == doctest::Approx(1.0f));
    }
}

TEST_CASE("pieces do not push apart at birth") {
    const glm::dvec3 low(-0.5, 0.0, -0.5), high(0.5, 1.0, 0.5);
    const std::vector<fracture::Fragments> sets{
        test::grid_pieces(low, high, 2, 1, 1),
        test::grid_pieces(low, high, 2, 2, 2),
        test::grid_pieces(low, high, 3, 3, 3),
        test::voronoi_pieces(low, high, 100, 1),
        test::voronoi_pieces(low, high, 30, 2),
        test::wedge_pieces(low, high, 6, 1),
        test::wedge_pieces(low, high, 8, 2),
        test::voronoi_pieces(low * 0.05, high * 0.05, 40, 4),
        test::voronoi_pieces(low * 20.0, high * 20.0, 40, 5),
    };
    for (size_t i = 0; i < sets.size(); ++i) {
        CAPTURE(i);
        check_that_they_stay(sets[i]);
    }
}

TEST_CASE("pieces of rough cuts do not push apart at birth") {
    for (const char* name : {"cube", "wall", "statue"}) {
        for (const double amount : {0.3, 1.0}) {
            CAPTURE(name);
            CAPTURE(amount);
            const fracture::TriangleMesh mesh = *fracture::shape(name);
            fracture::Settings settings;
            settings.rough = {.amount = amount, .detail = 2};
            const auto pieces =
                fracture::fracture(mesh, fracture::uniform_sites(fracture::bounds(mesh), 30, 5), settings);
            REQUIRE(pieces);
            check_that_they_stay(*pieces);
        }
    }
}

TEST_CASE("hulls that are not shrunk push their neighbours apart") {
    // With hulls at full size the grid overlaps by two margins, which suffices.
    const auto fragments = test::grid_pieces(glm::dvec3(-0.5), glm::dvec3(0.5), 2, 2, 2);
    World world(empty_space);
    for (const fracture::Piece& piece : fragments.pieces) {
        BodyDesc desc;
        for (const glm::dvec3& p : fragments.positions_of(piece))
            desc.hull.points.push_back(glm::vec3(p - piece.mass.centre_of_mass));
        desc.hull.margin = 0.01f;
        desc.mass = 300.0f;
        desc.inertia = glm::mat3(12.5f);
        desc.pose.position = glm::vec3(piece.mass.centre_of_mass);
        REQUIRE(world.add_body(desc).has_value());
    }
    run(world, 1.0f);
    const glm::vec3 first(fragments.pieces[0].mass.centre_of_mass);
    CHECK(glm::length(world.pose(world.bodies()[0]).position - first) > 5e-3f);
}

TEST_CASE("a wall of boxes stands for two seconds") {
    World world;
    const auto fragments = test::grid_pieces({-0.4, 0.0, -0.1}, {0.4, 1.0, 0.1}, 4, 5, 1);
    const std::vector<BodyId> bodies = must_add(world, fragments);
    run(world, 2.0f);
    for (size_t i = 0; i < bodies.size(); ++i) {
        const glm::vec3 start(fragments.pieces[i].mass.centre_of_mass);
        CHECK(glm::length(world.pose(bodies[i]).position - start) < 5e-3f);
    }
    CHECK(lowest_vertex(world, fragments, bodies) > -1e-3f);
}

TEST_CASE("a cube of a hundred pieces falls, rests on the ground and falls asleep within ten seconds") {
    World world;
    RunLog log("a hundred pieces of a cube, seed 11");
    INFO(log);
    const auto fragments = test::voronoi_pieces({-0.25, 0.5, -0.25}, {0.25, 1.0, 0.25}, 100, 11);
    const std::vector<BodyId> bodies = must_add(world, fragments);
    EnergyBooks energy(world);
    float lowest = 1.0f;
    float asleep_after = -1.0f;
    for (int step = 0; step < 1200 && asleep_after < 0.0f; ++step) {
        world.step();
        log.look(world);
        energy.look(world);
        if (step % 10 == 0) lowest = std::min(lowest, lowest_vertex(world, fragments, bodies));
        if (world.awake_count() == 0) asleep_after = static_cast<float>(step) / 120.0f;
    }
    MESSAGE("asleep after " << asleep_after << " s; lowest vertex " << lowest << " m; energy rose by "
                            << energy.risen / energy.start << " of the start in all, above the least before by "
                            << energy.max_above_min / energy.start);
    CHECK(asleep_after > 0.0f);
    CHECK(all_finite(world));
    CHECK(energy.risen < 1e-4 * energy.start);         // observed: 1.9e-5
    CHECK(energy.max_above_min < 5e-5 * energy.start); // observed: 1.1e-5
    CHECK(lowest > -0.06f);                            // one step at the impact speed
    CHECK(lowest_vertex(world, fragments, bodies) > -5e-3f);
    CHECK(lowest_vertex(world, fragments, bodies) < 5e-3f);
}

TEST_CASE("pieces of non-convex solids stay where they are born") {
    for (const char* name : {"animal", "torus_knot", "hollow_sphere"}) {
        CAPTURE(name);
        const fracture::TriangleMesh mesh = *fracture::shape(name);
        const auto fragments = fracture::fracture(mesh, fracture::uniform_sites(fracture::bounds(mesh), 60, 1));
        REQUIRE(fragments);
        REQUIRE(fragments->pieces.size() > 20);
        check_that_they_stay(*fragments);
    }
}

TEST_CASE("splinters dropped from two metres do not go through the ground") {
    World world;
    const auto fragments = test::wedge_pieces({-0.2, 2.0, -0.2}, {0.2, 2.4, 0.2}, 7, 6);
    const std::vector<BodyId> bodies = must_add(world, fragments);
    REQUIRE(bodies.size() > 40);
    run(world, 4.0f);
    CHECK(all_finite(world));
    for (const BodyId id : bodies) {
        CHECK(world.pose(id).position.y > -1e-3f);
        CHECK(world.pose(id).position.y < 0.5f);
    }
}

TEST_CASE("precomputed hulls give an equal world, and a wrong number of them is refused") {
    const auto fragments = test::voronoi_pieces({-0.25, 0.5, -0.25}, {0.25, 1.0, 0.25}, 30, 8);
    PieceHulls hulls = collision_hulls(fragments, {}, 1);
    World plain, ahead;
    must_add(plain, fragments);
    REQUIRE(add_pieces(ahead, fragments, {}, {}, hulls).has_value());
    run(plain, 0.5f), run(ahead, 0.5f);
    CHECK(plain.state_hash() == ahead.state_hash());

    World empty;
    hulls.back() = nullptr;
    const Result<std::vector<BodyId>> missing = add_pieces(empty, fragments, {}, {}, hulls);
    REQUIRE_FALSE(missing.has_value());
    CHECK(missing.error().message.find("piece 29") != std::string::npos);
    hulls.pop_back();
    CHECK_FALSE(add_pieces(empty, fragments, {}, {}, hulls).has_value());
    CHECK_FALSE(Structure::create(empty, fragments, {.hulls = hulls}).has_value());
    CHECK(empty.body_count() == 0);
}

TEST_CASE("precomputed forms give an equal world, and a wrong number of them is refused") {
    const auto fragments =
        test::voronoi_pieces({-0.25, 0.5, -0.25}, {0.25, 1.0, 0.25}, 150, 8); // enough for several threads
    const PieceHulls hulls = collision_hulls(fragments, {}, 1);
    World now, ahead, empty;
    Result<PieceForms> forms = piece_forms(fragments, {}, hulls, 2);
    REQUIRE(forms.has_value());
    REQUIRE(add_pieces(now, fragments, {}, {}, hulls).has_value());
    REQUIRE(add_pieces(ahead, fragments, {}, {}, *forms).has_value());
    run(now, 0.5f), run(ahead, 0.5f);
    CHECK(now.state_hash() == ahead.state_hash());

    const auto fault_of = [&] {
        const Result<std::vector<BodyId>> added = add_pieces(empty, fragments, {}, {}, *forms);
        return added ? std::string() : added.error().message;
    };
    forms->at(7) = nullptr;
    CHECK(fault_of() == "piece 7 has no form");
    forms->pop_back();
    CHECK(fault_of()
          == std::to_string(forms->size()) + " forms were given for " + std::to_string(forms->size() + 1) + " pieces");
    CHECK(empty.body_count() == 0);
}

TEST_CASE("a thousand new pieces in empty space stay where they are" * doctest::test_suite("long")) {
    check_that_they_stay(test::voronoi_pieces(glm::dvec3(-0.5), glm::dvec3(0.5), 1000, 6));
}

TEST_CASE("two runs of one fracture give equal states") {
    const auto play = [] {
        World world;
        must_add(world, test::voronoi_pieces({-0.25, 0.5, -0.25}, {0.25, 1.0, 0.25}, 60, 8));
        run(world, 1.5f);
        return world.state_hash();
    };
    CHECK(play() == play());
}

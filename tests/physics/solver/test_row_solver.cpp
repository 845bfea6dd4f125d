// The solution of contacts: momentum, the cone of friction and its direction, and the same solution on every path that
// rows can take.
#include "physics/solver/row_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

const glm::vec3 up(0.0f, 1.0f, 0.0f);

RowSolver::Step step_of(int sweeps) {
    return {.seconds = 1.0f / 60.0f,
            .substeps = {.count = 4,
                         .first = sweeps,
                         .second = sweeps,
                         .last = sweeps,
                         .bounce = sweeps,
                         .seconds = 1.0f / 240.0f,
                         .gravity = {0.0f, -9.81f, 0.0f},
                         .push_part = 0.125f,
                         .static_push_part = 0.125f},
            .separation_speed = 3.0f,
            .min_bounce_speed = 0.2f};
}

struct Box : Body {
    Box(uint32_t at, const glm::vec3& half, float kilograms) {
        index = at;
        std::vector<glm::vec3> corners;
        for (int i = 0; i < 8; ++i) corners.push_back(half * glm::vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
        auto shaped = std::make_shared<SolverForm>();
        shaped->shape = HullShape(corners, 0.0f);
        form = std::move(shaped);
        friction = 1.0f;
        inverse_mass = 1.0f / kilograms;
        const glm::vec3 square = half * half;
        inverse_moments =
            3.0f * inverse_mass / glm::vec3(square.y + square.z, square.x + square.z, square.x + square.y);
        set_frame({});
    }
};

// A box on the ground or on another body.
class OnFloor {
  public:
    // How the rows of the box are solved; `swapped`: it is the second body of its manifold.
    enum class Path { lone, static_rows, swapped, in_bundle, scalar };

    OnFloor(uint64_t seed, Path path, float mu) : path_(path), random_(seed) {
        const glm::vec3 half(random_.point(glm::dvec3(0.05), glm::dvec3(0.3)));
        box = std::make_unique<Box>(0, half, static_cast<float>(random_.uniform(0.2, 4.0)));
        floor = std::make_unique<Box>(1, glm::vec3(5.0f), 1.0f);
        other = std::make_unique<Box>(2, half, 1.0f);
        box->frame = floor->frame = other->frame = {};
        box->set_frame(
            {matrix_of(glm::angleAxis(static_cast<float>(random_.uniform(-3, 3)), up)), {0.3f, half.y, 0.1f}});
        floor->set_frame({glm::mat3(1.0f), {0.0f, -5.0f, 0.0f}});
        other->set_frame({glm::mat3(1.0f), {0.0f, 50.0f, 0.0f}});
        box->velocity.linear = glm::vec3(random_.point({-3, -2, -3}, {3, 0.5, 3}));
        box->velocity.angular = glm::vec3(random_.point(glm::dvec3(-4), glm::dvec3(4)));
        box->friction = mu;
        box->restitution = seed % 2 == 0 ? 0.0f : 0.4f;
        floor->restitution = 1.0f;
        floor->fixed = path != Path::lone && path != Path::scalar;
        floor->resting = path == Path::scalar;
        for (size_t i = 0; i < 4; ++i) {
            const glm::vec3 corner = box->frame * (half * glm::vec3(i & 1 ? 1 : -1, -1, i & 2 ? 1 : -1));
            places[i] = {corner.x, 0.0f, corner.z};
            gaps[i] = static_cast<float>(random_.uniform(-0.002, 0.004));
        }
    }

    void solve(const RowSolver::Step& step, fracture::Threads& threads) {
        const bool swapped = path_ == Path::swapped;
        const auto swap = [swapped](const PointImpulse& impulse) {
            return PointImpulse{impulse.normal, swapped ? -impulse.friction : impulse.friction};
        };
        Manifold manifold(swapped ? *floor : *box, swapped ? *box : *floor), apart(*box, *other);
        GroundManifold ground;
        ground.body = box.get();
        ground.count = 4;
        ground.friction = combined_friction(box->friction, floor->friction);
        ground.restitution = manifold.restitution();
        ground.slop = manifold.slop();
        for (size_t i = 0; i < 4; ++i) {
            ContactPoint point = manifold.point_at(swapped ? -up : up, places[i], 0.0f);
            point.distance = gaps[i];
            point.start = swap(starts[i]);
            manifold.add(point);
            ground.all[i].position = places[i];
            ground.all[i].distance = gaps[i];
            ground.all[i].start = starts[i];
        }
        apart.add(apart.point_at(-up, {0.0f, 25.0f, 0.0f}, 20.0f)); // never touches
        std::vector<Body*> bodies{box.get()};
        std::vector<AnyManifold> manifolds;
        if (path_ == Path::lone)
            manifolds.emplace_back(ground);
        else
            manifolds.emplace_back(manifold);
        if (path_ == Path::scalar) bodies.push_back(floor.get());
        if (path_ == Path::in_bundle) {
            bodies.push_back(other.get());
            manifolds.emplace_back(apart);
        }
        before = box->velocity;
        RowSolver solver;
        Joints joints;
        solver.solve(bodies, manifolds, joints, step, threads);
        for (size_t i = 0; i < 4; ++i) {
            last[i] = path_ == Path::lone ? ground.all[i].last : swap(manifold.points()[i].last);
            starts[i] = path_ == Path::lone ? ground.all[i].start : swap(manifold.points()[i].start);
        }
    }

    std::unique_ptr<Box> box, floor, other;
    std::array<glm::vec3, 4> places;
    std::array<float, 4> gaps;
    std::array<PointImpulse, 4> starts{}, last{};
    Velocity before;

  private:
    Path path_;
    test::Random random_;
};

float kinetic(const Body& body, const Velocity& velocity) {
    const glm::vec3 local = velocity.angular * body.frame.basis;
    const glm::vec3 moments = 1.0f / body.inverse_moments;
    return 0.5f * (glm::dot(velocity.linear, velocity.linear) / body.inverse_mass + glm::dot(local * moments, local));
}

constexpr std::array all_paths{OnFloor::Path::lone, OnFloor::Path::static_rows, OnFloor::Path::swapped,
                               OnFloor::Path::in_bundle, OnFloor::Path::scalar};

} // namespace

TEST_CASE("row solver: no bodies, and bodies without contacts, fall along their parabola") {
    fracture::Threads threads(1);
    RowSolver solver;
    Joints joints;
    solver.solve({}, {}, joints, step_of(2), threads);
    CHECK(solver.solved().empty());
    Box box(0, glm::vec3(0.1f), 2.0f);
    box.velocity.linear = {1.0f, 2.0f, 3.0f};
    Body* const bodies[] = {&box};
    solver.solve(bodies, {}, joints, step_of(2), threads);
    CHECK(glm::length(box.velocity.linear - glm::vec3(1.0f, 2.0f - 9.81f / 60.0f, 3.0f)) < 1e-6f);
    CHECK(glm::length(box.motion.linear - glm::vec3(1.0f, 2.0f - 9.81f / 120.0f, 3.0f)) < 1e-6f);
}

TEST_CASE("row solver: a box on a floor has the same solution on every path of its rows") {
    fracture::Threads threads(1);
    for (uint64_t seed = 0; seed < 300; ++seed) {
        CAPTURE(seed);
        OnFloor lone(seed, OnFloor::Path::lone, 0.4f);
        std::vector<std::unique_ptr<OnFloor>> others;
        for (const OnFloor::Path path : all_paths) others.push_back(std::make_unique<OnFloor>(seed, path, 0.4f));
        for (int step = 0; step < 2; ++step) { // the second starts from the impulses of the first
            lone.solve(step_of(3), threads);
            for (const auto& other : others) {
                other->solve(step_of(3), threads);
                const Body &expected = *lone.box, &found = *other->box;
                CHECK(glm::length(found.velocity.linear - expected.velocity.linear) < 1e-4f);
                CHECK(glm::length(found.velocity.angular - expected.velocity.angular) < 2e-3f);
                CHECK(glm::length(found.motion.linear - expected.motion.linear) < 1e-4f);
                for (size_t i = 0; i < 4; ++i) {
                    CHECK(std::abs(other->last[i].normal - lone.last[i].normal) < 2e-4f);
                    CHECK(glm::length(other->last[i].friction - lone.last[i].friction) < 2e-4f);
                    CHECK(std::abs(other->starts[i].normal - lone.starts[i].normal) < 2e-4f);
                }
            }
        }
    }
}

TEST_CASE("row solver: impulses at the points change the momenta as much as the velocities say") {
    fracture::Threads threads(1);
    for (uint64_t seed = 0; seed < 200; ++seed)
        for (const OnFloor::Path path : all_paths) {
            CAPTURE(seed);
            OnFloor scene(seed, path, 0.6f);
            const RowSolver::Step step = step_of(4);
            scene.solve(step, threads);
            const Body& box = *scene.box;
            glm::vec3 impulse = step.substeps.gravity * step.seconds / box.inverse_mass, torque(0.0f);
            for (size_t i = 0; i < 4; ++i) {
                const glm::vec3 push = up * scene.last[i].normal + scene.last[i].friction;
                impulse += push;
                torque += glm::cross(scene.places[i] - box.frame.origin, push);
            }
            CHECK(scene.last[0].normal >= 0.0f);
            const glm::vec3 linear = box.velocity.linear - scene.before.linear;
            const glm::vec3 angular = box.velocity.angular - scene.before.angular;
            const glm::vec3 turned = box.inverse_inertia * torque;
            CHECK(glm::length(linear - impulse * box.inverse_mass) < 1e-3f);
            CHECK(glm::length(angular - turned) < 1e-2f);
        }
}

TEST_CASE("row solver: overlap is corrected down to the slop without a velocity, and a smaller one stays") {
    fracture::Threads threads(1);
    for (uint64_t seed = 0; seed < 100; ++seed)
        for (const OnFloor::Path path : all_paths)
            for (const float part : {0.5f, 1.0f, 3.0f}) { // of the slop
                CAPTURE(seed);
                CAPTURE(part);
                OnFloor scene(seed, path, 0.5f);
                scene.box->velocity = {};
                const float slop = Manifold(*scene.box, *scene.floor).slop(), deep = part * slop;
                scene.gaps.fill(-deep);
                RowSolver::Step step = step_of(4);
                step.substeps.gravity = {};
                scene.solve(step, threads);
                CHECK(scene.box->velocity.linear == glm::vec3(0.0f));
                CHECK(scene.box->velocity.angular == glm::vec3(0.0f));
                for (const PointImpulse& impulse : scene.last) CHECK(impulse.normal == 0.0f);
                for (size_t i = 0; i < 4; ++i) {
                    const glm::vec3 arm = scene.places[i] - scene.box->frame.origin;
                    const float rise = scene.box->motion.at(arm).y * step.seconds;
                    if (part > 1.0f) {
                        CHECK(rise > step.substeps.push_part * (deep - slop));
                        CHECK(rise <= (deep - slop) * 1.0001f);
                    } else {
                        CHECK(rise == 0.0f);
                    }
                }
            }
}

TEST_CASE("row solver: a body that its contacts do not reach keeps its parabola") {
    fracture::Threads threads(1);
    for (uint64_t seed = 0; seed < 100; ++seed)
        for (const OnFloor::Path path : all_paths) {
            CAPTURE(seed);
            OnFloor scene(seed, path, 0.5f);
            scene.gaps.fill(1.0f);
            const RowSolver::Step step = step_of(4);
            scene.solve(step, threads);
            const glm::vec3 fall = step.substeps.gravity * step.seconds;
            CHECK(scene.box->velocity.linear == scene.before.linear + fall);
            CHECK(scene.box->motion.linear == scene.before.linear + 0.5f * fall);
            CHECK(scene.box->velocity.angular == scene.before.angular);
            CHECK(scene.box->motion.angular == scene.before.angular);
        }
}

TEST_CASE("row solver: a blow starts the next step with no more than its growth allows") {
    fracture::Threads threads(1);
    size_t limited = 0;
    for (uint64_t seed = 0; seed < 100; ++seed)
        for (const OnFloor::Path path : all_paths) {
            CAPTURE(seed);
            OnFloor scene(seed, path, 0.5f);
            scene.box->velocity = {.linear = {0.0f, -2.0f, 0.0f}};
            scene.gaps.fill(0.0f);
            scene.solve(step_of(4), threads);
            float most = 0.0f; // of each point, whose effective mass is the body's mass at most
            for (int substep = 0; substep < 4; ++substep)
                most = start_growth * most + start_speed / scene.box->inverse_mass;
            for (size_t i = 0; i < 4; ++i) {
                CHECK(scene.starts[i].normal <= most * 1.0001f);
                CHECK(glm::length(scene.starts[i].friction) <= scene.box->friction * scene.starts[i].normal * 1.0001f);
                limited += scene.last[i].normal > most ? 1 : 0;
            }
        }
    CHECK(limited > 1000);
}

TEST_CASE("row solver: friction stays in its cone in every direction, and takes energy") {
    fracture::Threads threads(1);
    size_t on_cone = 0, inside = 0;
    for (uint64_t seed = 0; seed < 300; ++seed)
        for (const OnFloor::Path path : all_paths) {
            const float mu = static_cast<float>(seed % 7) * 0.2f;
            CAPTURE(seed);
            CAPTURE(mu);
            OnFloor scene(seed, path, mu);
            scene.box->restitution = 0.0f;
            RowSolver::Step step = step_of(8);
            step.substeps.gravity = {};
            for (int again = 0; again < 3; ++again) {
                scene.solve(step, threads);
                for (size_t i = 0; i < 4; ++i) {
                    for (const PointImpulse& impulse : {scene.last[i], scene.starts[i]}) {
                        CHECK(impulse.normal >= 0.0f);
                        CHECK(glm::dot(impulse.friction, up) == 0.0f);
                        CHECK(glm::length(impulse.friction) <= mu * impulse.normal * 1.0001f);
                    }
                    if (scene.last[i].normal > 0.0f && mu > 0.0f)
                        ++(glm::length(scene.last[i].friction) > 0.99f * mu * scene.last[i].normal ? on_cone : inside);
                }
                const float energy = kinetic(*scene.box, scene.before);
                CHECK(kinetic(*scene.box, scene.box->velocity) <= energy * 1.0001f + 1e-6f);
            }
        }
    CHECK(on_cone > 500);
    CHECK(inside > 100);
}

// One point below the centre of a body, whose inertia differs along the tangents: sliding changes direction.
TEST_CASE("row solver: friction is opposite to the sliding velocity that it leaves, or stops the sliding") {
    fracture::Threads threads(1);
    test::Random random(6);
    size_t slides = 0, sticks = 0;
    for (int i = 0; i < 2000; ++i) {
        CAPTURE(i);
        Box box(0, glm::vec3(random.point(glm::dvec3(0.05), glm::dvec3(0.5))), 1.0f);
        Box floor(1, glm::vec3(5.0f), 1.0f);
        floor.fixed = i % 2 == 0;
        floor.resting = !floor.fixed;
        box.friction = static_cast<float>(random.uniform(0.05, 1.0));
        const glm::quat turn = glm::angleAxis(static_cast<float>(random.uniform(-3, 3)), glm::vec3(random.direction()));
        box.set_frame({matrix_of(turn), {0.0f, 0.4f, 0.0f}});
        box.velocity.linear = glm::vec3(random.point({-2, -3, -2}, {2, -1, 2}));
        Manifold manifold(box, floor);
        manifold.add(manifold.point_at(up, glm::vec3(random.point({-0.1, 0, -0.1}, {0.1, 0, 0.1})), 0.0f));
        const ContactPoint& point = manifold.points()[0];
        std::vector<Body*> bodies{&box};
        if (!floor.fixed) bodies.push_back(&floor);
        const std::vector<AnyManifold> manifolds{AnyManifold(manifold)};
        RowSolver::Step step = step_of(200);
        step.substeps.count = 1;
        step.substeps.gravity = {};
        step.substeps.seconds = step.seconds;
        RowSolver solver;
        Joints joints;
        solver.solve(bodies, manifolds, joints, step, threads);
        const float bound = box.friction * point.last.normal, size = glm::length(point.last.friction);
        CHECK(point.last.normal > 0.0f);
        CHECK(size <= bound * 1.0001f);
        const glm::vec3 at = box.velocity_at(point.on_a), sliding = at - up * glm::dot(up, at);
        CHECK(std::abs(at.y) < 1e-3f);
        if (size < 0.999f * bound) {
            CHECK(glm::length(sliding) < 2e-3f);
            ++sticks;
        } else if (glm::length(sliding) > 0.02f) {
            CHECK(glm::dot(glm::normalize(sliding), glm::normalize(point.last.friction)) < -0.9995f);
            ++slides;
        }
    }
    CHECK(slides > 300);
    CHECK(sticks > 300);
}

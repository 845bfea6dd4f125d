#include "physics/cutting/suspended_contact.h"

#include <cmath>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "tests/physics/bodies.h"

using namespace brittle;
using namespace brittle::physics;
using namespace brittle::physics::test_bodies;

namespace {

// A striker of 1 kg that fell onto a piece of 3 kg at 4 m/s, just after a central collision with restitution 1/2.
struct Collision {
    static constexpr float speed = 4.0f, striker_mass = 1.0f, piece_mass = 3.0f;
    static constexpr float stopping = speed * striker_mass * piece_mass / (striker_mass + piece_mass); // N s, inelastic
    static constexpr float common = speed * striker_mass / (striker_mass + piece_mass);                // m/s, after it

    World world{empty_space};
    BodyId piece, striker;
    SuspendedContact contact;

    explicit Collision(bool fixed = false) {
        BodyDesc below = box(glm::vec3(0.5f), piece_mass, glm::vec3(0.0f));
        below.fixed = fixed;
        piece = must_add(world, below);
        striker = must_add(world, box(glm::vec3(0.1f), striker_mass, {0.0f, 0.6f, 0.0f}));
        const float impulse = 1.5f * (fixed ? speed * striker_mass : stopping);
        world.set_velocity(striker, {0.0f, impulse / striker_mass - speed, 0.0f}, glm::vec3(0.0f));
        if (!fixed) world.set_velocity(piece, {0.0f, -impulse / piece_mass, 0.0f}, glm::vec3(0.0f));
        contact = {.striker = striker, .normal_impulse = {0.0f, -impulse, 0.0f}, .arm = {0.0f, -0.1f, 0.0f}};
        contact.lost = 0.5 * static_cast<double>(fixed ? speed * striker_mass : stopping) * double{speed};
    }
    [[nodiscard]] float of(BodyId body) const { return world.linear_velocity(body).y; }
    [[nodiscard]] float momentum() const { return striker_mass * of(striker) + piece_mass * of(piece); }
    void check_velocities(float of_striker, float of_piece) const {
        CHECK(of(striker) == doctest::Approx(of_striker).epsilon(1e-5));
        CHECK(of(piece) == doctest::Approx(of_piece).epsilon(1e-5));
    }
};

} // namespace

TEST_CASE("suspended contact: without an impulse or a striker nothing moves") {
    for (const bool gone : {false, true}) {
        Collision now;
        now.contact.normal_impulse = glm::vec3(0.0f);
        if (gone) {
            now.contact.normal_impulse.y = -1.0f;
            now.world.remove_body(now.striker);
        }
        const float before = now.of(now.piece);
        if (!gone) suspend(now.world, now.piece, now.contact);
        restore(now.world, now.piece, 0.0, now.contact);
        solve_again(now.world, now.piece, now.contact);
        CHECK(now.contact.empty());
        CHECK(now.of(now.piece) == before);
    }
}

TEST_CASE("suspended contact: suspended bodies move as one, restored ones as before the collision") {
    Collision now;
    suspend(now.world, now.piece, now.contact);
    now.check_velocities(-Collision::common, -Collision::common);
    CHECK(glm::length(now.contact.normal_impulse) == doctest::Approx(Collision::stopping));
    restore(now.world, now.piece, 0.0, now.contact);
    now.check_velocities(-Collision::speed, 0.0f);
    solve_again(now.world, now.piece, now.contact);
    now.check_velocities(-Collision::common, -Collision::common);
    CHECK(now.momentum() == doctest::Approx(-Collision::speed * Collision::striker_mass));
    CHECK(now.contact.lost == doctest::Approx(0.5 * double{Collision::stopping * Collision::speed}));
}

TEST_CASE("suspended contact: cracks keep their share of the energy") {
    Collision now;
    suspend(now.world, now.piece, now.contact);
    restore(now.world, now.piece, 0.75, now.contact); // a quarter of the energy returns, by half of the impulse
    CHECK(glm::length(now.contact.normal_impulse) == doctest::Approx(0.5f * Collision::stopping));
    CHECK(now.momentum() == doctest::Approx(-Collision::speed * Collision::striker_mass));
    const double relative = double{now.of(now.piece) - now.of(now.striker)}; // m/s, of approach
    CHECK(0.5 * 0.75 * relative * relative == doctest::Approx(0.25 * 0.5 * 0.75 * 16.0).epsilon(1e-5));
}

TEST_CASE("suspended contact: no more energy returns than the contact dissipated") {
    Collision now;
    suspend(now.world, now.piece, now.contact);
    const double before = now.world.mechanics().kinetic;
    const glm::vec3 faster(0.0f, -2.0f, 0.0f); // the striker has gained speed meanwhile
    now.world.set_velocity(now.striker, now.world.linear_velocity(now.striker) + faster, glm::vec3(0.0f));
    const double gained = now.world.mechanics().kinetic - before;
    restore(now.world, now.piece, 0.0, now.contact);
    CHECK(now.world.mechanics().kinetic <= before + gained + now.contact.lost * (1.0 + 1e-5));
    CHECK(glm::length(now.contact.normal_impulse) < Collision::stopping);
}

TEST_CASE("suspended contact: the striker of a fixed piece gets its impulse back, friction included") {
    Collision now(true);
    suspend(now.world, now.piece, now.contact);
    now.check_velocities(0.0f, 0.0f);
    const glm::vec3 friction(0.5f, 0.0f, 0.0f);
    now.world.set_velocity(now.striker, -friction / Collision::striker_mass, glm::vec3(0.0f));
    add_friction(now.world, now.piece, friction, now.contact);
    restore(now.world, now.piece, 0.0, now.contact);
    CHECK(now.of(now.piece) == 0.0f);
    CHECK(now.of(now.striker) < -0.9f * Collision::speed);
    CHECK(now.world.linear_velocity(now.striker).x > -0.1f);
}

TEST_CASE("suspended contact: a free piece and its striker get back the velocities from before, friction included") {
    Collision now;
    suspend(now.world, now.piece, now.contact);
    const double before = 0.5 * double{Collision::striker_mass * Collision::speed * Collision::speed};
    const glm::vec3 point = now.world.pose(now.striker).position + now.contact.arm, friction(0.5f, 0.0f, 0.0f);
    now.world.apply_impulse(now.piece, friction, point);
    now.world.apply_impulse(now.striker, -friction, point);
    now.contact.lost = before; // more than the contact dissipated
    const double dissipated = before - now.world.mechanics().kinetic;
    add_friction(now.world, now.piece, friction, now.contact);
    CHECK(now.contact.lost == doctest::Approx(dissipated).epsilon(1e-5));
    restore(now.world, now.piece, 0.0, now.contact);
    now.check_velocities(-Collision::speed, 0.0f);
    for (const BodyId body : {now.piece, now.striker}) {
        CHECK(std::abs(now.world.linear_velocity(body).x) < 1e-6f);
        CHECK(glm::length(now.world.angular_velocity(body)) < 1e-5f);
    }
}

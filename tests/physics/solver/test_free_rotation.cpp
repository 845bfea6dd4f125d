// Free rotation against what it conserves and a closed form; principal axes of the inertia tensors that it starts from.
#include "physics/solver/free_rotation.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <initializer_list>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include "fracture/mesh/principal_axes.h"

using namespace brittle::physics;

namespace {

double largest_difference(const glm::dmat3& a, const glm::dmat3& b) {
    double most = 0.0;
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) most = std::max(most, std::abs(a[column][row] - b[column][row]));
    return most;
}

glm::dmat3 diagonal(double x, double y, double z) {
    glm::dmat3 result(0.0);
    result[0][0] = x, result[1][1] = y, result[2][2] = z;
    return result;
}

glm::dvec3 angular_momentum(const Spin& spin, const glm::dvec3& moments) {
    return spin.orientation * (moments * (glm::conjugate(spin.orientation) * spin.velocity));
}

} // namespace

TEST_CASE("principal axes: the zero tensor has the coordinate axes and zero moments") {
    const brittle::fracture::PrincipalAxes principal = brittle::fracture::principal_axes(glm::dmat3(0.0));
    CHECK(principal.axes == glm::dmat3(1.0));
    CHECK(principal.moments == glm::dvec3(0.0));
}

TEST_CASE("principal axes: a diagonal tensor keeps its axes and their order") {
    const brittle::fracture::PrincipalAxes principal = brittle::fracture::principal_axes(diagonal(3.0, 1.0, 2.0));
    CHECK(principal.axes == glm::dmat3(1.0));
    CHECK(principal.moments == glm::dvec3(3.0, 1.0, 2.0));
}

TEST_CASE("principal axes: axes and moments give back a symmetric tensor of any scale") {
    for (const double scale : {1.0, 1e-25, 1e20}) {
        for (int i = 0; i < 50; ++i) {
            const auto at = [&](int k) { return std::sin(12.9898 * (i * 6 + k + 1)) * scale; };
            glm::dmat3 tensor;
            tensor[0] = {at(0), at(1), at(2)};
            tensor[1] = {at(1), at(3), at(4)};
            tensor[2] = {at(2), at(4), at(5)};
            const brittle::fracture::PrincipalAxes principal = brittle::fracture::principal_axes(tensor);
            const glm::dmat3 again = principal.axes
                                     * diagonal(principal.moments.x, principal.moments.y, principal.moments.z)
                                     * glm::transpose(principal.axes);
            CHECK(largest_difference(again, tensor) < 1e-13 * scale);
            CHECK(largest_difference(glm::transpose(principal.axes) * principal.axes, glm::dmat3(1.0)) < 1e-14);
            CHECK(glm::determinant(principal.axes) == doctest::Approx(1.0));
        }
    }
}

TEST_CASE("principal axes: axes and moments equal those of rotations written as matrix products, bit for bit") {
    // Textbook cyclic Jacobi; the tensors include zeros of either sign, equal moments and needles.
    const auto by_products = [](glm::dmat3 work) {
        work[0][1] = work[1][0], work[0][2] = work[2][0], work[1][2] = work[2][1];
        double scale = 0.0;
        for (int i = 0; i < 9; ++i) scale = std::max(scale, std::abs(work[i / 3][i % 3]));
        work /= scale;
        glm::dmat3 axes(1.0);
        for (int turn = 0; turn < 36; ++turn) {
            if (turn % 3 == 0 && std::abs(work[1][0]) + std::abs(work[2][0]) + std::abs(work[2][1]) < 1e-15) break;
            const int p = turn % 3 == 2 ? 1 : 0, q = turn % 3 == 0 ? 1 : 2;
            if (work[q][p] == 0.0) continue;
            const double theta = (work[q][q] - work[p][p]) / (2.0 * work[q][p]);
            const double tangent = std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
            glm::dmat3 rotation(1.0);
            rotation[p][p] = rotation[q][q] = 1.0 / std::sqrt(tangent * tangent + 1.0);
            rotation[q][p] = tangent * rotation[p][p];
            rotation[p][q] = -rotation[q][p];
            work = glm::transpose(rotation) * work * rotation;
            work[p][q] = work[q][p] = 0.0;
            axes = axes * rotation;
        }
        return brittle::fracture::PrincipalAxes{axes, glm::dvec3(work[0][0], work[1][1], work[2][2]) * scale};
    };
    const auto bits = [](const brittle::fracture::PrincipalAxes& found) {
        return std::bit_cast<std::array<uint64_t, 12>>(found);
    };
    for (int i = 0; i < 3000; ++i) {
        const auto at = [&](int k) { return std::sin(78.233 * (i * 6 + k + 1)); };
        glm::dmat3 tensor(0.0);
        for (int axis = 0; axis < 3; ++axis) tensor[axis][axis] = 2.0 + (i % 4 == 0 ? 0.0 : at(axis));
        tensor[1][0] = i % 3 == 0 ? 0.0 : at(3);
        tensor[2][0] = i % 5 == 0 ? -0.0 : at(4) * (i % 7 == 0 ? 1e-12 : 1.0);
        tensor[2][1] = i % 2 == 0 ? at(5) : 0.5 * at(5);
        if (i % 11 == 0) tensor[0][0] = 1e-9;
        tensor *= std::pow(10.0, i % 41 - 20);
        CHECK(bits(brittle::fracture::principal_axes(tensor)) == bits(by_products(tensor)));
    }
}

TEST_CASE("free rotation: a body at rest stays at rest") {
    const Spin spin = free_spin({}, {1.0, 2.0, 2.5}, 0.01);
    CHECK(spin.velocity == glm::dvec3(0.0));
    CHECK(spin.orientation == glm::dquat(1.0, 0.0, 0.0, 0.0));
}

TEST_CASE(
    "free rotation: tumbling about the middle axis conserves angular momentum and energy for a thousand seconds") {
    const glm::dvec3 moments(1.0, 2.0, 2.9);
    Spin spin{.orientation = glm::normalize(glm::dquat(0.3, 0.5, -0.2, 0.7)), .velocity = {0.1, 7.0, -0.2}};
    const glm::dvec3 momentum = angular_momentum(spin, moments);
    const double energy = glm::dot(momentum, spin.velocity);
    bool flipped = false;
    const double before = (glm::conjugate(spin.orientation) * spin.velocity).y;
    for (int step = 0; step < 120000; ++step) {
        spin = free_spin(spin, moments, 1.0 / 120.0);
        flipped = flipped || before * (glm::conjugate(spin.orientation) * spin.velocity).y < 0.0;
    }
    CHECK(glm::length(angular_momentum(spin, moments) - momentum) < 1e-9 * glm::length(momentum));
    CHECK(glm::dot(angular_momentum(spin, moments), spin.velocity) == doctest::Approx(energy).epsilon(1e-9).scale(0.0));
    CHECK(flipped); // the tennis racket effect, which damping would end
}

TEST_CASE("free rotation: a symmetric top precesses at the rate of the closed form") {
    // Moments A, A, C: in the body's axes the angular velocity precesses about z at (C - A) / A * w_z.
    const double a = 2.0, c = 3.0, spin_rate = 4.0;
    Spin spin{.velocity = {0.5, 0.0, spin_rate}};
    const double seconds = 1.0;
    const int steps = 2000;
    for (int step = 0; step < steps; ++step) spin = free_spin(spin, {a, a, c}, seconds / steps);
    const glm::dvec3 body = glm::conjugate(spin.orientation) * spin.velocity;
    const double angle = (c - a) / a * spin_rate * seconds;
    CHECK(body.x == doctest::Approx(0.5 * std::cos(angle)).epsilon(1e-4).scale(0.0));
    CHECK(body.y == doctest::Approx(0.5 * std::sin(angle)).epsilon(1e-4).scale(0.0));
    CHECK(body.z == doctest::Approx(spin_rate));
}

TEST_CASE("free rotation: a spin of more turns a step than an integer holds moves like the fastest one") {
    const double fastest = 0.5 * 16 * 120.0;
    const auto moved = [](double speed) {
        return free_spin({.velocity = {0.0, speed, 0.0}}, glm::dvec3(1.0), 1.0 / 120.0);
    };
    for (const double speed : {1e6, 1e13, 1e150}) {
        CHECK(moved(speed).velocity.y == doctest::Approx(fastest));
        CHECK(moved(speed).orientation.w == doctest::Approx(moved(fastest).orientation.w));
        CHECK(moved(speed).orientation.y == doctest::Approx(moved(fastest).orientation.y));
    }
}

TEST_CASE("free rotation: a needle that spins faster than a step can follow is slowed down and stays finite") {
    const glm::dvec3 moments(1e-4, 1.0, 1.0);
    Spin spin{.velocity = {5000.0, 3000.0, 100.0}};
    for (int step = 0; step < 1000; ++step) spin = free_spin(spin, moments, 1.0 / 120.0);
    CHECK(glm::length(spin.velocity) <= 0.5 * 16 * 120.0 * 1.001);
    CHECK(glm::length(spin.orientation) == doctest::Approx(1.0));
    const Spin later = free_spin(spin, moments, 1.0 / 120.0);
    CHECK(glm::length(angular_momentum(later, moments) - angular_momentum(spin, moments))
          < 1e-6 * glm::length(angular_momentum(spin, moments)));
}

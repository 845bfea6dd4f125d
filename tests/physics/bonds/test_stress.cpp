#include "physics/bonds/stress.h"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <doctest/doctest.h>

#include "fracture/fracture.h"
#include "fracture/shapes/shapes.h"
#include "fracture/sites/sites.h"
#include "tests/physics/convex_pieces.h"

using namespace brittle;
using namespace brittle::physics;

namespace {

constexpr double density = 2000.0, gravity = 9.81;

struct Model {
    std::vector<StressNode> nodes;
    std::vector<StressBond> bonds;
    std::vector<NodeLoad> weights;

    [[nodiscard]] double weight() const {
        double sum = 0.0;
        for (const NodeLoad& load : weights) sum -= load.force.y;
        return sum;
    }
};

template<class Fixed>
Model model_of(const fracture::Fragments& fragments, const Fixed& fixed) {
    Model model;
    for (const fracture::Piece& piece : fragments.pieces) {
        const glm::dvec3 centre = piece.mass.centre_of_mass;
        model.nodes.push_back({centre, density * piece.mass.volume, density * piece.mass.inertia, fixed(centre)});
        model.weights.push_back({{0.0, -gravity * density * piece.mass.volume, 0.0}, {}});
    }
    for (const fracture::Bond& bond : fragments.bonds)
        model.bonds.push_back({bond.a, bond.b, bond.area, bond.centroid, bond.normal});
    return model;
}

StressSolver solved(const Model& model, uint32_t most = 2000) {
    StressSolver solver(model.nodes, model.bonds);
    solver.set_loads(model.weights);
    CHECK(solver.solve(most, 1e-6));
    return solver;
}

fracture::Fragments broken_cube(int count) {
    const fracture::TriangleMesh mesh = fracture::cube(1.0);
    const auto sites = fracture::uniform_sites(fracture::bounds(mesh), static_cast<uint32_t>(count), 3);
    fracture::Result<fracture::Fragments> fragments = fracture::fracture(mesh, sites);
    REQUIRE(fragments.has_value());
    return std::move(*fragments);
}

} // namespace

TEST_CASE("an empty solver and a single falling node converge at once") {
    StressSolver solver;
    CHECK(solver.solve(10));
    StressSolver alone(std::array{StressNode{{}, 1.0, glm::dmat3(1.0), false}}, {});
    alone.set_loads(std::array{NodeLoad{{0.0, -9.81, 0.0}, {}}});
    CHECK(alone.solve(10));
}

TEST_CASE("a cantilever has the shear and bending moment of the closed form along its length") {
    for (const int blocks : {2, 5, 20, 60}) {
        const double side = 0.1;
        const fracture::Fragments beam =
            test::bonded_grid({0.0, 0.0, 0.0}, {side * (blocks + 1), side, side}, blocks + 1, 1, 1);
        const Model model = model_of(beam, [&](const glm::dvec3& at) { return at.x < side; });
        const StressSolver solver = solved(model);
        CAPTURE(blocks);
        MESSAGE(blocks, " blocks: ", solver.iterations(), " iterations");
        const double block = density * side * side * side * gravity;
        for (int i = 0; i < blocks; ++i) {
            const double beyond = blocks - i, moment = block * beyond * beyond * side * 0.5;
            const auto bond = static_cast<uint32_t>(i);
            const BondLoad load = solver.load(bond);
            CHECK(load.force.y == doctest::Approx(block * beyond).epsilon(1e-3)); // upwards, on the outer part
            CHECK(load.moment.z == doctest::Approx(moment).epsilon(1e-3));
            CHECK(std::abs(load.moment.x) + std::abs(load.moment.y) < 1e-6 * moment);
            const BondStress stress = solver.stress(bond);
            const double modulus =
                std::pow(side, 3.0) / (4.0 * std::sqrt(std::numbers::pi)); // section modulus of a disc of that area
            CHECK(stress.bending == doctest::Approx(moment / modulus).epsilon(1e-3));
            CHECK(stress.shear == doctest::Approx(block * beyond / (side * side)).epsilon(1e-3));
            CHECK(stress.tension + stress.compression < 1e-3 * stress.bending);
        }
        const NodeLoad wall = solver.reaction(0);
        CHECK(wall.force.y == doctest::Approx(model.weight()).epsilon(1e-3));
    }
}

TEST_CASE("a standing column has the compression density * gravity * height, and a hanging one that tension") {
    for (const bool hanging : {false, true}) {
        const fracture::Fragments column = test::bonded_grid({0, 0, 0}, {0.3, 2.1, 0.3}, 1, 21, 1);
        const Model model = model_of(column, [&](const glm::dvec3& at) { return hanging ? at.y > 2.0 : at.y < 0.1; });
        const StressSolver solver = solved(model);
        for (uint32_t i = 0; i < 20; ++i) {
            const double height = 0.1 * (hanging ? i + 1 : 20 - i), pressure = density * gravity * height;
            const BondStress stress = solver.stress(i);
            CHECK((hanging ? stress.tension : stress.compression) == doctest::Approx(pressure).epsilon(1e-3));
            CHECK((hanging ? stress.compression : stress.tension) == 0.0);
            CHECK(stress.bending + stress.shear < 1e-3 * pressure);
        }
    }
}

TEST_CASE("the legs of a table share its weight, and an eccentric load by the lever rule") {
    // A top of 3 x 3 blocks of 1 m on legs under its corners. Thin legs act as pins.
    fracture::Fragments table;
    const auto add = [&](const glm::dvec3& low, const glm::dvec3& high) {
        test::append_piece(table, test::box_polyhedron(low, high));
        return static_cast<uint32_t>(table.pieces.size() - 1);
    };
    std::vector<uint32_t> tops, legs;
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) tops.push_back(add({i, 2.0, k}, {i + 1, 3.0, k + 1}));
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
            const auto at = [&](int x, int z) { return tops[static_cast<size_t>(x * 3 + z)]; };
            if (i < 2) table.bonds.push_back({at(i, k), at(i + 1, k), 1.0, {i + 1.0, 2.5, k + 0.5}, {1, 0, 0}});
            if (k < 2) table.bonds.push_back({at(i, k), at(i, k + 1), 1.0, {i + 0.5, 2.5, k + 1.0}, {0, 0, 1}});
        }
    const double thin = 0.05;
    std::array<uint32_t, 4> bonds{};
    for (int corner = 0; corner < 4; ++corner) {
        const double x = corner % 2 ? 2.5 : 0.5, z = corner / 2 ? 2.5 : 0.5;
        const uint32_t leg = add({x - thin, 0.0, z - thin}, {x + thin, 2.0, z + thin});
        legs.push_back(leg);
        bonds[static_cast<size_t>(corner)] = static_cast<uint32_t>(table.bonds.size());
        table.bonds.push_back({leg,
                               tops[static_cast<size_t>((corner % 2) * 6 + (corner / 2) * 2)],
                               4.0 * thin * thin,
                               {x, 2.0, z},
                               {0, 1, 0}});
    }
    Model model = model_of(table, [](const glm::dvec3& at) { return at.y < 1.5; });
    StressSolver solver = solved(model);
    const double top = 9.0 * density * gravity;
    for (const uint32_t bond : bonds) {
        CHECK(solver.load(bond).force.y == doctest::Approx(top / 4.0).epsilon(1e-3));
        CHECK(solver.stress(bond).compression == doctest::Approx(top / 4.0 / (4.0 * thin * thin)).epsilon(1e-3));
    }
    // Without one leg, and with a load above the opposite leg, the table is statically determinate: the diagonal's two
    // legs carry half of the top's weight each, and the third leg carries the load.
    solver.remove_bonds(std::array{bonds[3]});
    model.weights[tops[0]].force.y -= 1000.0;
    solver.set_loads(model.weights);
    CHECK(solver.solve(2000, 1e-6));
    CHECK(solver.load(bonds[0]).force.y == doctest::Approx(1000.0).epsilon(0.05).scale(top));
    CHECK(solver.load(bonds[1]).force.y == doctest::Approx(top / 2.0).epsilon(0.01));
    CHECK(solver.load(bonds[2]).force.y == doctest::Approx(top / 2.0).epsilon(0.01));
    CHECK(solver.load(bonds[3]).force.y == 0.0);
}

TEST_CASE("reactions balance the weight in force and in moment for random piles of pieces") {
    const fracture::Fragments cube = broken_cube(200);
    const Model model = model_of(cube, [](const glm::dvec3& at) { return at.y < -0.4; });
    const StressSolver solver = solved(model);
    glm::dvec3 force(0.0), torque(0.0);
    for (uint32_t i = 0; i < model.nodes.size(); ++i) {
        const NodeLoad reaction = solver.reaction(i);
        CHECK((model.nodes[i].fixed || glm::length(reaction.force) == 0.0));
        force += reaction.force + model.weights[i].force;
        torque += reaction.torque + glm::cross(model.nodes[i].centre, reaction.force + model.weights[i].force);
    }
    CHECK(glm::length(force) < 1e-4 * model.weight());
    CHECK(glm::length(torque) < 1e-4 * model.weight());
}

TEST_CASE("free fall causes no stress, and a push accelerates the pieces behind it") {
    const fracture::Fragments bar = test::bonded_grid({0, 0, 0}, {1.0, 0.1, 0.1}, 10, 1, 1);
    Model model = model_of(bar, [](const glm::dvec3&) { return false; });
    StressSolver solver = solved(model);
    for (uint32_t i = 0; i < 9; ++i) CHECK(load_ratio(solver.stress(i), Material{}) < 1e-9);
    // Each bond transmits the force less a tenth for each accelerated piece before it.
    model.weights[0].force.x = 100.0;
    solver.set_loads(model.weights);
    CHECK(solver.solve(200, 1e-6));
    for (uint32_t i = 0; i < 9; ++i)
        CHECK(solver.stress(i).compression == doctest::Approx(100.0 * (9 - i) / 10.0 / 0.01).epsilon(1e-3));
}

TEST_CASE("the solver continues where it stopped, and starts warm after a change") {
    const fracture::Fragments cube = broken_cube(300);
    const Model model = model_of(cube, [](const glm::dvec3& at) { return at.y < -0.4; });
    StressSolver at_once(model.nodes, model.bonds), in_steps(model.nodes, model.bonds);
    at_once.set_loads(model.weights);
    in_steps.set_loads(model.weights);
    CHECK(at_once.solve(1000));
    int calls = 1;
    while (!in_steps.solve(7)) ++calls;
    CHECK(calls > 1);
    CHECK(in_steps.iterations() == at_once.iterations());
    CHECK(in_steps.load(100).force == at_once.load(100).force);
    const uint64_t cold = at_once.iterations();
    at_once.remove_bonds(std::array{100u});
    CHECK_FALSE(at_once.converged());
    CHECK(at_once.solve(1000));
    MESSAGE("cold ", cold, " iterations, after one bond ", at_once.iterations() - cold);
    CHECK(at_once.iterations() - cold < cold);
    CHECK(at_once.load(100).force == glm::dvec3(0.0));
}

TEST_CASE("bonds break by tension, compression and shear, and compression counteracts bending") {
    const Material material{.tensile = 1e6f, .compressive = 1e7f, .shear = 2e6f};
    CHECK(load_ratio({.tension = 1e6}, material) == doctest::Approx(1.0));
    CHECK(load_ratio({.compression = 1e6}, material) == doctest::Approx(0.1));
    CHECK(load_ratio({.shear = 1e6}, material) == doctest::Approx(0.5));
    CHECK(load_ratio({.bending = 1e6}, material) == doctest::Approx(1.0));
    CHECK(load_ratio({.compression = 1e6, .bending = 1e6}, material) == doctest::Approx(0.2));
}

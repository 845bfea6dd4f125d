// Static stresses in the bonds of an object: how forces reach its supports.
//
// Pieces are rigid nodes with six degrees of freedom; bonds are short elastic beams between them. A bond of area A
// between centres at distance L has an axial stiffness A / L, a shear stiffness 0.4 A / L, a bending stiffness I / L
// and a torsional stiffness 0.8 I / L at its centroid, where I = A^2 / (4 pi) is the second moment of a disc of that
// area. All bonds are of one material, so Young's modulus cancels out of the forces and is left out. Conjugate
// gradients solve for the displacements. The preconditioner is the inverse of each node's diagonal block plus a coarse
// correction by the rigid motions of groups of neighbouring nodes.
//
// Fixed nodes support their island (connected component). An island without a fixed node is taken to accelerate as a
// whole (d'Alembert): gravity alone causes no stress in it, as in free fall.
//
// Blocks, bonds and an iterative solver over them are also how NVIDIA Blast finds stresses (documented in its user
// guide). The disc, the beam and the formulas are in any textbook of mechanics of materials (e.g. Gere and
// Timoshenko).
//
// SI units, one coordinate system for everything. No bodies, no time. Deterministic. Not thread-safe; distinct solvers
// are independent. The cost of an iteration is linear in bonds and nodes.
//
//     StressSolver solver(nodes, bonds);
//     solver.set_loads(loads);
//     while (!solver.solve(20)) {}        // or a few iterations a frame: each call continues the previous one
//     BondStress stress = solver.stress(bond);
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "physics/material.h"

namespace brittle::physics {

struct StressNode {
    glm::dvec3 centre{0.0};  // of mass, m
    double mass = 0.0;       // kg
    glm::dmat3 inertia{0.0}; // kg m^2, about the centre
    bool fixed = false;
};

struct StressBond {
    uint32_t a = 0, b = 0; // nodes
    double area = 0.0;     // m^2; a bond without area is ignored
    glm::dvec3 centroid{0.0};
    glm::dvec3 normal{0.0}; // unit, from a to b
};

struct NodeLoad {
    glm::dvec3 force{0.0};  // N
    glm::dvec3 torque{0.0}; // N m, about the centre
};

// The load of a bond: force and moment that node a exerts on node b, at the centroid. In tension, force . normal < 0.
struct BondLoad {
    glm::dvec3 force{0.0};  // N
    glm::dvec3 moment{0.0}; // N m
};

// Pa, none negative, at the most stressed edge of the disc. Compression or tension is zero.
struct BondStress {
    double compression = 0.0;
    double tension = 0.0;
    double shear = 0.0; // from transverse force and torsion
    double bending = 0.0;
};

// Returns the utilisation of a bond's strength; 1 and above break it. Bending adds tension at one edge and compression
// at the other. The result is the largest of (tension + bending - compression) / tensile strength, (compression +
// bending - tension) / compressive strength, and shear / shear strength.
[[nodiscard]] double load_ratio(const BondStress& stress, const Material& material);

class StressSolver {
  public:
    StressSolver() = default;
    // Asserts that bonds of positive area name existing nodes.
    StressSolver(std::span<const StressNode> nodes, std::span<const StressBond> bonds);

    // Replaces the loads, one a node. The displacements so far are the initial guess. Loads on fixed nodes go to the
    // support.
    void set_loads(std::span<const NodeLoad> loads);
    // Removes bonds. The displacements so far are the initial guess.
    void remove_bonds(std::span<const uint32_t> bonds);
    // Replaces a node by parts, whose numbers begin at node_count(). The node itself stays, without bonds and load.
    // `bonds` are all bonds from now on, in the order so far, new ones last. The parts start with the displacement of
    // the node, and without load.
    void divide(uint32_t node, std::span<const StressNode> parts, std::span<const StressBond> bonds);
    // Makes fixed nodes free.
    void release(std::span<const uint32_t> nodes);

    // Takes at most `iterations` more. Returns whether the residual is below tolerance times the loads, and the energy
    // of the error below tolerance^2 times that of the solution.
    bool solve(uint32_t iterations, double tolerance = 1e-3);
    [[nodiscard]] bool converged() const { return converged_; }
    [[nodiscard]] uint64_t iterations() const { return iterations_; } // of all solve() calls

    [[nodiscard]] BondLoad load(uint32_t bond) const; // zero for a removed bond
    [[nodiscard]] BondStress stress(uint32_t bond) const;
    // Returns the force and torque of the support on a fixed node; zero for a free node.
    [[nodiscard]] NodeLoad reaction(uint32_t node) const;
    [[nodiscard]] size_t node_count() const { return nodes_.size(); }
    [[nodiscard]] const StressNode& node(size_t index) const { return nodes_[index]; }

  private:
    struct NodeVector { // of one node: a displacement (linear part, rotation vector) or a residual (force, torque)
        glm::dvec3 linear{0.0};
        glm::dvec3 angular{0.0};
    };
    using NodeVectors = std::vector<NodeVector>;
    using Block = std::array<double, 36>;
    struct Spring {
        uint32_t a, b, bond;
        glm::dvec3 arm_a, arm_b, normal;
        double axial, shear, bending, torsion; // stiffness over the elastic modulus: m, m, m^3, m^3
    };

    void build(const std::vector<uint8_t>& changed);
    void build_coarse();
    void remove_acceleration(std::vector<NodeLoad>& loads) const;
    void apply(const NodeVectors& x, NodeVectors& out) const;
    void precondition(const NodeVectors& r, NodeVectors& z) const;
    void restart();
    [[nodiscard]] BondLoad load_of(const Spring& spring) const;
    void find_groups();

    std::vector<StressNode> nodes_;
    std::vector<StressBond> bonds_; // area 0: removed
    std::vector<Spring> springs_;   // one per bond of positive area
    std::vector<uint32_t> spring_of_bond_;
    std::vector<uint32_t> island_of_;       // by node
    std::vector<uint8_t> island_fixed_;     // by island: 1 if it has a fixed node
    std::vector<NodeLoad> applied_, loads_; // as set, and without the acceleration of free islands
    std::vector<Block> inverse_;            // of each node's diagonal block of the stiffness matrix
    // The coarse correction: groups of nodes, and the lower Cholesky factor of the stiffness of their rigid motions.
    std::vector<uint32_t> group_of_;
    std::vector<glm::dvec3> group_centre_;
    std::vector<double> coarse_factor_;
    // Conjugate gradients: displacement, residual, preconditioned residual, search direction, and stiffness *
    // direction.
    NodeVectors x_, r_, z_, p_, q_;
    mutable std::vector<double> coarse_solution_; // right-hand side, then solution; scratch of precondition()
    double rz_ = 0.0, load_size_ = 0.0;           // r . z; sum of squared loads of free nodes
    bool converged_ = true, restarted_ = true;
    uint64_t iterations_ = 0;
};

} // namespace brittle::physics

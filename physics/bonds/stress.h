// Stresses in the bonds of an object at rest: who carries the weight.
//
// Pieces are rigid nodes with six degrees of freedom, bonds are short elastic beams between them: a bond of area A
// between centres that are L apart resists being pulled (A / L), sheared (0.4 A / L), bent (I / L) and twisted (0.8 I
// / L) at its centroid, where I = A^2 / (4 pi) is the second moment of a disc of that area. All are of one material,
// so its elasticity cancels: forces do not depend on it. Displacements are solved for by conjugate gradients; the
// preconditioner is the inverse of each node's own block plus a coarse correction by the rigid motions of groups of
// neighbouring nodes.
//
// Fixed nodes hold what hangs together with them. A group of nodes that nothing holds is taken to accelerate as a whole
// (d'Alembert): gravity alone then gives no stress in it, as in a fall.
//
// Blocks, bonds and an iterative solver over them are also how NVIDIA Blast finds stresses (documented in its user
// guide); the disc, the beam and the formulas are those of any textbook of mechanics of materials (e.g. Gere and
// Timoshenko).
//
// SI units, one coordinate system for everything. No bodies, no time, no threads; deterministic. Cost of an iteration
// is linear in bonds and nodes.
//
//     StressSolver solver(nodes, bonds);
//     solver.set_loads(loads);
//     while (!solver.solve(20)) {}        // or some iterations a frame: it goes on where it stopped
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
    glm::dmat3 inertia{0.0}; // kg m^2 about the centre
    bool fixed = false;
};

struct StressBond {
    uint32_t a = 0, b = 0; // nodes
    double area = 0.0;     // m^2; without area it is no bond
    glm::dvec3 centroid{0.0};
    glm::dvec3 normal{0.0}; // unit, from a to b
};

struct NodeLoad {
    glm::dvec3 force{0.0};  // N
    glm::dvec3 torque{0.0}; // N m, about the centre
};

// What goes through a bond: force and moment that a gives to b, at the centroid. Pulled apart, force . normal is
// negative.
struct BondLoad {
    glm::dvec3 force{0.0};  // N
    glm::dvec3 moment{0.0}; // N m
};

// Pa, none negative; at the edge of the disc where it is worst. Of compression and tension one is zero.
struct BondStress {
    double compression = 0.0;
    double tension = 0.0;
    double shear = 0.0; // across, and from twist
    double bending = 0.0;
};

// How near to breaking, 1: breaks. Bending pulls one edge and presses the other: tension + bending - compression
// against the tensile strength, compression + bending - tension against the compressive one, shear against that for
// shear; the worst counts.
[[nodiscard]] double load_ratio(const BondStress& stress, const Material& material);

class StressSolver {
  public:
    StressSolver() = default;
    // Asserts that bonds name nodes.
    StressSolver(std::span<const StressNode> nodes, std::span<const StressBond> bonds);

    // One load a node; those of before count as a start. Loads on fixed nodes go to the support.
    void set_loads(std::span<const NodeLoad> loads);
    // Takes bonds away, and starts from the displacements of before.
    void remove_bonds(std::span<const uint32_t> bonds);
    // Fixed nodes become free.
    void release(std::span<const uint32_t> nodes);

    // At most so many iterations more. True where what is left of the loads is below tolerance times the loads.
    bool solve(uint32_t iterations, double tolerance = 1e-3);
    [[nodiscard]] bool converged() const { return converged_; }
    [[nodiscard]] uint64_t iterations() const { return iterations_; } // of all calls

    [[nodiscard]] BondLoad load(uint32_t bond) const; // nothing for a bond that was removed
    [[nodiscard]] BondStress stress(uint32_t bond) const;
    // Force and torque that the world gives to a fixed node.
    [[nodiscard]] NodeLoad reaction(uint32_t node) const;
    [[nodiscard]] size_t node_count() const { return nodes_.size(); }
    [[nodiscard]] const StressNode& node(size_t index) const { return nodes_[index]; }

  private:
    struct NodeVector { // of a node, a step or a residual of it
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

    void build();
    void build_coarse();
    void remove_acceleration(std::vector<NodeLoad>& loads) const;
    void apply(const NodeVectors& x, NodeVectors& out) const;
    void precondition(const NodeVectors& r, NodeVectors& z) const;
    void restart();
    [[nodiscard]] BondLoad load_of(const Spring& spring) const;
    void find_groups();

    std::vector<StressNode> nodes_;
    std::vector<StressBond> bonds_; // area 0 once removed
    std::vector<Spring> springs_;   // live ones
    std::vector<uint32_t> spring_of_bond_;
    std::vector<uint32_t> island_of_;   // by node: connected part
    std::vector<uint8_t> island_fixed_; // by island
    std::vector<NodeLoad> applied_, loads_;
    std::vector<Block> inverse_; // of each node's own block
    // The coarse correction: nodes in groups, and the lower Cholesky factor of the stiffness of their rigid motions.
    std::vector<uint32_t> group_of_;
    std::vector<glm::dvec3> group_centre_;
    std::vector<double> coarse_factor_;
    NodeVectors x_, r_, z_, p_, q_;
    mutable std::vector<double> coarse_solution_; // scratch of one call
    double rz_ = 0.0, load_size_ = 0.0;
    bool converged_ = true, restarted_ = true;
    uint64_t iterations_ = 0;
};

} // namespace brittle::physics

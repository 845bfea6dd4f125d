// The rows of joints that share moving bodies (a system), and their solution. row.h has the equations; comments here
// use its letters.
//
//     ball      three rows along the world's axes: p_a - p_b = 0, p the anchors
//     hinge     these, and two rows t . s = 0: s the axis on b, t two directions on a across its axis
//     fixed     six rows: t . s = 0 for three pairs of directions
//     distance  one row along the line between the anchors: |p_a - p_b| = length, or a bound of it
//
// - A system is solved directly, by the factor of J M^-1 J^T (skyline.h), and not row by row: a chain of any length
//   holds a load of any mass in the first sweep of a substep. The sweeps repeat the solution, in turn with contacts.
//   Both solutions of a substep have the same targets.
// - A bound (rope, strut) is a row while it is reached. The rows that are reached are found by the active-set method: a
//   row whose impulse would push where it may only pull leaves, a violated one enters.
// - v_target: the anchors meet at the end of the substep, not at its start:
//       v_target = -(C(x + h v) - C(x) - h J v) / h,
//   C the constraint, x the pose at the start of the step plus the displacement since, and v the velocity after the
//   solution, found by fixed-point iteration in the first sweep. It is the SHAKE rule, which is symplectic: pendulums
//   keep their energy. With v_target = 0 they lose (w h)^2 of it a substep. I is that of the start of the step: the
//   angular momentum of a body, I w, changes only by impulses.
// - Position errors C(x) change no velocity. correct() moves the bodies after the step, by Newton's method with the
//   same rows: lambda = -(J M^-1 J^T)^-1 C, dx = M^-1 J^T lambda.
// - Light links: a link under tension turns back faster than substeps can follow if h^2 k > I, k the tension times the
//   arms. Such a link gets as much more inertia across its length as makes them equal, without the momentum of it: the
//   rule of implicit integration, M' v' = M v + J^T lambda. It damps the link. Bodies of like mass never do.
// - Redundant rows get no impulse: see Skyline::min_pivot. Those of fixed joints share the load: they yield a little,
//   the stronger the less: J v + softness lambda = v_target. A millionth to a ten thousandth of what one row alone yields.
//
// J.-P. Ryckaert, G. Ciccotti and H. Berendsen, "Numerical Integration of the Cartesian Equations of Motion of a System
// with Constraints", 1977 (SHAKE). M. Cline and D. Pai, "Post-Stabilization for Rigid Body Simulation with Contact and
// Constraints", 2003. S. Andrews, M. Teichmann and P. Kry, "Geometric Stiffness for Real-Time Constrained Multibody
// Dynamics", 2017 (light links). D. Baraff, "Linear-Time Dynamics using Lagrange Multipliers", 1996 (chains in linear
// time).
//
// Metres, seconds, kilograms, in double precision. Not thread-safe; different systems may be solved at the same time.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "physics/solver/body.h"
#include "physics/solver/row.h"
#include "physics/solver/skyline.h"
#include "physics/world/joint.h"

namespace brittle::physics {

// A joint of the solver. Points and directions are in the frame of the side's body, or in the world's.
struct SolverJoint {
    JointId id;
    JointKind kind = JointKind::ball;
    Body *a = nullptr, *b = nullptr; // null: the world
    glm::vec3 anchor_a{0.0f}, anchor_b{0.0f};
    glm::vec3 axis_a{0.0f}, axis_b{0.0f}; // of a hinge and a fixed joint
    glm::vec3 up_a{0.0f}, up_b{0.0f};     // of a fixed joint
    float min_length = 0.0f, max_length = 0.0f, max_force = 0.0f, max_torque = 0.0f;
    bool bears_pressure = false, collide = false;
    // Results of the last step.
    float force = 0.0f; // N
    bool broken = false;
};

// Whether a joint can move the body in this step.
[[nodiscard]] inline bool is_driven(const Body* body) {
    return body && !body->fixed && body->awake();
}

class JointSystem {
  public:
    struct Step {
        float seconds = 0.0f, substep_seconds = 0.0f;
    };

    // Takes the joints of a system, each with a driven body. Their order does not matter, except among redundant ones.
    void take(std::span<SolverJoint* const> joints);
    // Starts a step. `indices` holds the places of bodies in changes and displacements, by Body::index.
    void start(std::span<const uint32_t> indices, const Step& step);
    // Builds the rows of a substep, where the bodies are at its start.
    void start_substep(const VelocityChange* changes, const Displacement* moved);
    // One sweep. In the second solution a joint breaks that needs more than its greatest force; it has given this much
    // in the step, and gives nothing in the rest of it.
    void solve(VelocityChange* changes, Solution solution);
    void finish_substep();
    // Writes force and broken of the joints, and adds their impulses to Body::unhindered.
    void store() const;
    // Moves the bodies until the joints are closed.
    void correct();

    [[nodiscard]] std::span<SolverJoint* const> joints() const { return joints_; }

  private:
    static constexpr uint32_t none = UINT32_MAX;
    // Which impulses a row may have.
    enum class Bound : uint8_t { equal, at_most, at_least };

    struct DrivenBody {
        Body* body;
        uint32_t index = 0; // in the changes
        double inverse_mass = 0.0;
        double added_inertia = 0.0; // kg m^2, about the axes across `tension`: see stiffen()
        glm::dvec3 tension{0.0};    // unit, in the body's frame
        glm::dvec3 damping{0.0};    // rad/s, that the added inertia takes from the angular velocity
        glm::dmat3 inverse_inertia{0.0};
        glm::dvec3 linear{0.0}, angular{0.0};               // v, of the start of the step
        glm::dvec3 linear_before{0.0}, angular_before{0.0}; // v + dv at the start of the substep, without its gravity
        glm::dvec3 linear_now{0.0}, angular_now{0.0};       // v + dv
        glm::dvec3 way{0.0}, rotation{0.0};                 // displacement at the start of the substep, m and rad
        glm::dvec3 linear_given{0.0}, angular_given{0.0};   // change of velocity by the joints, in the substeps before
    };
    // What a joint gives a: N s, and N m s about the anchor.
    struct Push {
        glm::dvec3 impulse{0.0}, moment{0.0};
    };
    // J of a row; its parts for b belong to a speed against a's. `linear` acts on a, and against it on b.
    struct JointRow {
        glm::dvec3 linear{0.0}, angular_a{0.0}, angular_b{0.0};
        glm::dvec3 inverse_inertia_angular_a{0.0}, inverse_inertia_angular_b{0.0};
        double error = 0.0;    // C
        double gap = 0.0;      // m/s: the speed at which a bound that is not reached may close
        double bend = 0.0;     // m/s: v_target of a joint without a gap
        double before = 0.0;   // m/s: J v of the velocity before the step's gravity
        double target = 0.0;   // v_target, m/s or rad/s
        double impulse = 0.0;  // lambda
        double softness = 0.0; // of a fixed joint, m/s or rad/s by impulse; of active rows
        Bound bound = Bound::equal;
        bool active = true;
        bool frozen = false; // of a broken joint: the impulse stays
    };
    struct Placed {
        uint32_t a = none, b = none;                   // driven bodies
        uint32_t first = 0, count = 0;                 // rows
        glm::dvec3 arm_a{0.0}, arm_b{0.0}, apart{0.0}; // from the centres to the anchors; from b's anchor to a's
        // Of the frames of the bodies, before their displacement: arms, and t and s of the angular rows.
        glm::dvec3 frame_arm_a{0.0}, frame_arm_b{0.0};
        std::array<glm::dvec3, 3> frame_on_a{}, frame_on_b{};
        glm::dvec3 axis{0.0}; // of a fixed joint, on b
        Push given;           // in the substeps before
    };

    void order();
    void soften();
    void reset();
    void place_all();
    void place(uint32_t joint);
    void put_row(uint32_t row, const Placed& placed, const glm::dvec3& linear, const glm::dvec3& angular_a,
                 const glm::dvec3& angular_b, double error);
    void factor();
    void load(const VelocityChange* changes);
    void sweep_rows(Solution solution);
    bool stiffen();
    void find_bends();
    void set_targets();
    bool activate_violated();
    bool release_pushing();
    bool break_overloaded();
    [[nodiscard]] double speed_of(const Placed& placed, const JointRow& row) const;
    [[nodiscard]] double closing_of(uint32_t row) const;
    void apply(const Placed& placed, const JointRow& row, double impulse);
    [[nodiscard]] Push push_of(const Placed& placed) const;
    [[nodiscard]] double load_share(const SolverJoint& joint, const Placed& placed, const Push& push) const;
    [[nodiscard]] glm::dvec3 turn_of(uint32_t side, const glm::dvec3& rotation) const;

    std::vector<SolverJoint*> joints_;
    std::vector<DrivenBody> bodies_;
    std::vector<Placed> placed_; // by joint
    std::vector<JointRow> rows_;
    std::vector<uint32_t> joint_of_row_;
    std::vector<double> softness_; // by joint: the share by which the diagonal entries of its rows grow
    std::vector<uint32_t> firsts_; // by row
    std::vector<double> solution_, steady_, bending_; // by row: change of impulse; parts of it
    double bend_share_ = 1.0;
    Skyline matrix_;
    bool fresh_ = false; // whether the substep has had no sweep
    bool factored_ = false;
    double step_seconds_ = 0.0, seconds_ = 0.0; // h is that of a substep
};

} // namespace brittle::physics

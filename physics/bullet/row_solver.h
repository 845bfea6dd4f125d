// The sweeps of the solver: projected Gauss-Seidel over contacts and friction, as Bullet's own, on rows of half the size.
//
// Bullet's package is built without SIMD, and solves the points of one contact after the other: each row waits for the one
// before, as both change the same two bodies. Here the first points of all pairs come first, then all second ones, so that
// rows beside each other have nothing to do with each other, and the processor works on several at a time. What has a body
// that never moves still comes behind all others (piece_solver.h says why). A sweep over contacts is followed by one over
// their friction, and before all of them overlap is undone by moving (split impulses).
//
// Bullet makes the rows and takes the results; this is between. One friction direction a contact; no joints, no rolling
// friction.
//
// E. Catto, "Iterative Dynamics with Temporal Coherence", 2005.
#pragma once

#include <cstdint>
#include <vector>

#include <btBulletDynamicsCommon.h>

namespace brittle::physics {

class RowSolver {
  public:
    // Sweeps over all rows so many times, and leaves impulses in the rows and changes of velocity in the bodies.
    void solve(btAlignedObjectArray<btSolverBody>& bodies, btConstraintArray& contacts, btConstraintArray& frictions,
               int sweeps);

  private:
    // Of a contact or of its friction. Vectors lie without gaps; four floats can be read at each.
    struct Row {
        float normal[3];            // from b to a
        float arm_a[3], arm_b[3];   // arm x normal; of b with -normal
        float turn_a[3], turn_b[3]; // what a unit of impulse does to the angular velocity
        float wanted;               // impulse that brings the velocity that is wanted, from that before the sweeps
        float gain;                 // impulse a unit of velocity
        float softness;
        float impulse;
        float friction;         // coefficient
        float light_a, light_b; // inverse masses
        uint32_t a, b;          // bodies; if one never moves it is b
    };
    struct Motion {
        float linear[4], angular[4]; // changes so far; the last of four is 0
    };

    void order(const btAlignedObjectArray<btSolverBody>& bodies, const btConstraintArray& contacts);
    static Row row_of(const btSolverConstraint& from, const btAlignedObjectArray<btSolverBody>& bodies);
    static size_t first_held(const std::vector<Row>& rows);
    static void resolve(Row& row, Motion* motions, float low, float high);
    static void resolve_held(Row& row, Motion* motions, float low, float high);
    void press(); // one sweep over contacts_
    void rub();   // and one over frictions_
    void move_apart(btAlignedObjectArray<btSolverBody>& bodies, btConstraintArray& contacts, int sweeps);

    std::vector<uint32_t> order_;    // indices of contacts in the order in which they are solved
    std::vector<uint32_t> keys_, starts_; // scratch of order()
    std::vector<uint32_t> place_;    // of a contact in order_
    std::vector<Row> contacts_, frictions_;
    size_t held_ = 0; // from here on contacts_ are with what never moves
    std::vector<uint32_t> of_friction_; // place of the contact it belongs to
    std::vector<uint32_t> deep_;        // contacts whose overlap is undone
    std::vector<Motion> motions_;
};

} // namespace brittle::physics

// What is solved in a step, and what is told of it.
#pragma once

#include <memory>
#include <vector>

#include <btBulletDynamicsCommon.h>

#include "physics/bullet/body_record.h"
#include "physics/bullet/row_solver.h"
#include "physics/world.h"

namespace brittle::physics {

// Bullet's solver with sweeps of our own, two changes to what it is given, and a report of what it did.
//
// Contacts with the ground and with fixed bodies come last, so that each sweep ends with nothing going into
// the ground. In Bullet's own order, a heavy piece presses a light one beneath it millimetres deep and holds
// it there; what is left over now is overlap between the two, inside the pile.
//
// Overlap between bodies counts only as far as may be undone in one step: see
// WorldSettings::separation_speed. The true distances are found anew before the next step, at whose beginning bodies are
// moved apart: with the velocities of before, so that in between, where things break, angular momentum is that of the impulses.
class PieceSolver final : public btSequentialImpulseConstraintSolver {
  public:
    PieceSolver(const WorldSettings& settings, const std::vector<std::unique_ptr<BodyRecord>>& bodies)
        : separation_speed_(settings.separation_speed), bodies_(bodies) {}

    std::vector<Contact> contacts; // of this step, appended by each call

    btScalar solveGroup(btCollisionObject** bodies, int body_count, btPersistentManifold** manifolds,
                        int manifold_count, btTypedConstraint** constraints, int constraint_count,
                        const btContactSolverInfo& info, btIDebugDraw* drawer,
                        btDispatcher* dispatcher) override;

    // Of bodies that sleep, which nobody solves: what they pressed when they last were awake.
    void report_sleeping(btDispatcher& dispatcher);

  protected:
    // The sweeps are ours: row_solver.h.
    btScalar solveGroupCacheFriendlyIterations(btCollisionObject** bodies, int body_count,
                                               btPersistentManifold** manifolds, int manifold_count,
                                               btTypedConstraint** constraints, int constraint_count,
                                               const btContactSolverInfo& info, btIDebugDraw* drawer) override;

  private:
    // Whether others rest than when it was last asked.
    bool find_resting();
    void note_speeds();
    void prepare_contacts(btScalar deepest); // Bullet's units
    void put_off_repairs(btCollisionObject** bodies, int body_count);
    void report_contacts();
    [[nodiscard]] Contact contact_of(const btPersistentManifold& manifold, const btManifoldPoint& point,
                                     float speed) const;

    struct Resting {
        BodyId id;
        bool is;
        friend bool operator==(const Resting&, const Resting&) = default;
    };
    RowSolver rows_;
    std::vector<Resting> resting_; // in body order, when contacts of those that sleep were last told
    std::vector<Contact> resting_contacts_;
    float separation_speed_;
    const std::vector<std::unique_ptr<BodyRecord>>& bodies_;
    std::vector<btPersistentManifold*> ordered_; // scratch of one call
    std::vector<float> speeds_;                  // likewise: m/s, of all points of ordered_
};

} // namespace brittle::physics

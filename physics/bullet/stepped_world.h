// Bullet's world with two of its parts replaced: the rotation of free bodies and the rule for falling asleep.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include <btBulletDynamicsCommon.h>

#include "physics/bullet/body_record.h"
#include "physics/bullet/step_stops.h"
#include "physics/rotation.h"
#include "physics/world.h"

namespace brittle::physics {

class SteppedWorld final : public btDiscreteDynamicsWorld {
  public:
    // Settings and bodies are looked at in each step; the bodies' user indices point into them.
    SteppedWorld(btDispatcher* dispatcher, btBroadphaseInterface* broadphase, btConstraintSolver* solver,
                 btCollisionConfiguration* configuration, const WorldSettings& settings,
                 const std::vector<std::unique_ptr<BodyRecord>>& bodies)
        : btDiscreteDynamicsWorld(dispatcher, broadphase, solver, configuration), settings_(settings),
          bodies_(bodies), stops_(bodies, *broadphase) {}

    // Moves one body by its velocity, as the end of a step does.
    void move_on(BodyRecord& body, btScalar seconds);

  protected:
    // Notes the velocities that bodies would have without contacts.
    void solveConstraints(btContactSolverInfo& info) override;
    // Orientation and angular velocity of Bullet's own integration are replaced; see rotation.h.
    void integrateTransforms(btScalar seconds) override;
    // Bullet lets a body sleep when it is slower than 0.8 m/s for two seconds, wherever it is, and lets piles
    // jitter for ever. Here it must touch something, be really slow, and is damped on its way to rest. That
    // islands sleep and wake as a whole remains Bullet's.
    void updateActivationState(btScalar seconds) override;

  private:
    static void lose_fall(BodyRecord& body, btScalar seconds);
    void find_touching();
    // Whether a body has long been where it is.
    bool rocks_in_place(BodyRecord& body, btScalar seconds);
    void find_quiet(btScalar seconds);

    const WorldSettings& settings_;
    const std::vector<std::unique_ptr<BodyRecord>>& bodies_;
    StepStops stops_;
    struct Island {
        float mass = 0.0f, calm_mass = 0.0f; // kg
        bool fast = false;                   // one of it is on its way
    };
    std::vector<Island> islands_; // by island tag; scratch of one step
};

} // namespace brittle::physics

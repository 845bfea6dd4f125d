// Bullet's world with a step of its own: who is awake, how free bodies turn (rotation.h), islands, and when they fall asleep.
// Bodies that sleep are not looked at but for one flag each.
#pragma once

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <btBulletDynamicsCommon.h>

#include "fracture/base/parallel.h"
#include "physics/solver/body_record.h"
#include "physics/solver/islands.h"
#include "physics/solver/piece_solver.h"
#include "physics/solver/rotation.h"
#include "physics/solver/siblings.h"
#include "physics/solver/step_stops.h"
#include "physics/solver/sweep_broadphase.h"
#include "physics/world/world.h"

namespace brittle::physics {

class SteppedWorld final : public btDiscreteDynamicsWorld {
  public:
    // Settings and bodies are looked at in each step; the bodies' user indices point into them.
    SteppedWorld(btDispatcher* dispatcher, SweepBroadphase* broadphase, PieceSolver* solver,
                 btCollisionConfiguration* configuration, const WorldSettings& settings,
                 const std::vector<std::unique_ptr<BodyRecord>>& bodies, fracture::Threads& threads)
        : btDiscreteDynamicsWorld(dispatcher, broadphase, nullptr, configuration), broadphase_(*broadphase),
          solver_(*solver), settings_(settings), bodies_(bodies), threads_(threads),
          stops_(bodies, *broadphase, threads) {}

    // In place of Bullet's own, whose lists of bodies nobody reads. Does not look at the body itself.
    void put_in(NewBody& body);
    // User indices of the bodies, not the ground, that it had contacts with; until the next call.
    std::span<const int> take_out(BodyRecord& body);

    // In place of Bullet's own step. The solver then has the contacts of the step.
    void step(btScalar seconds);
    // Who was awake at any time of the last step, in no order; nobody else has moved.
    [[nodiscard]] const std::vector<BodyRecord*>& stepped() const { return stepped_; }

    // Those that have come since the last step.
    [[nodiscard]] Siblings& siblings() { return siblings_; }

    // Moves one body by its velocity, as the end of a step does.
    void move_on(BodyRecord& body, btScalar seconds);

  private:
    // Side by side, in no order.
    void for_each_body(std::span<BodyRecord* const> bodies, const auto& visit);
    // Manifolds with contacts, likewise; what a body keeps of them is written by several threads.
    void for_each_contact(const auto& visit);
    void find_pairs(btScalar seconds);
    // Around the body for all of the step.
    void set_box(BodyRecord& body, btScalar seconds);
    void find_islands();
    void find_company(); // for those that rest: whom each touches
    // An island sleeps when all of it is ready to, but a large heap is never ready at once: the solver leaves every body some
    // creep, and every few seconds a piece that has crept far enough falls and keeps all others awake and creeping. So who is
    // ready is held where it is, as though it had no end of mass, until something disturbs it: what it touches moves and is
    // not ready itself, or is gone. Not where anything of the island is fast, as blows are taken by all, or waits to come up
    // from the ground, as all must give way.
    void let_rest(BodyRecord& body, btScalar seconds) const;
    void solve(btScalar seconds);
    // Bullet lets a body sleep when it is slower than 0.8 m/s for two seconds, wherever it is, and lets piles
    // jitter for ever. Here it must touch something, be really slow, and is damped on its way to rest.
    void find_who_settles(btScalar seconds);
    void move_all(btScalar seconds);
    void lose_fall(BodyRecord& body, btScalar seconds);
    void find_touching(btScalar seconds);
    [[nodiscard]] float speed_of(const btRigidBody& body) const;
    [[nodiscard]] float waited(const BodyRecord& body) const; // s
    [[nodiscard]] bool rises(const BodyRecord& body) const;   // out of the ground, into which it was pressed
    [[nodiscard]] static bool is_ready(const btRigidBody& body) {
        return body.getActivationState() == WANTS_DEACTIVATION;
    }                                                         // to sleep
    [[nodiscard]] bool is_fast(const BodyRecord& body) const; // too fast for a tremble
    // Whether a body has long been where it is.
    bool rocks_in_place(BodyRecord& body, btScalar seconds);
    void count_still(BodyRecord& body, btScalar seconds);
    void find_calm(); // by island
    void count_quiet(BodyRecord& body, btScalar seconds) const;

    SweepBroadphase& broadphase_;
    PieceSolver& solver_;
    const WorldSettings& settings_;
    const std::vector<std::unique_ptr<BodyRecord>>& bodies_;
    fracture::Threads& threads_;
    Siblings siblings_;
    Islands islands_;
    StepStops stops_;
    std::vector<BodyRecord*> stepped_;
    struct Calm {
        float mass = 0.0f, calm_mass = 0.0f; // kg
        bool fast = false;                   // one of it is on its way
    };
    std::vector<Calm> calm_; // by island; scratch of one step
    struct Company {
        uint32_t fours = 0;     // of contacts with the others, of each as many as it takes
        bool pressed = false;   // in the last step
        bool disturbed = false; // by what it touches
        bool busy = false;      // by island: nobody rests
    };
    std::vector<Company> company_; // by body; scratch of one step
    struct Touch {
        bool any = false, sunk = false; // BodyRecord::touching and sunk
    };
    std::vector<Touch> touches_; // likewise
    std::vector<int> touched_;   // of one call
};

} // namespace brittle::physics

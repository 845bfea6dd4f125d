// What is solved in a step, and what is told of it.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include <btBulletDynamicsCommon.h>

#include "physics/solver/any_manifold.h"
#include "physics/solver/body_record.h"
#include "physics/solver/row_solver.h"
#include "physics/world/world.h"

namespace brittle::physics {

// Solves the contacts of a step (row_solver.h) and reports them.
//
// Overlap between bodies counts only as far as may be undone in one step: see
// WorldSettings::separation_speed. The true distances are found anew before the next step, at whose beginning bodies are
// moved apart: with the velocities of before, so that in between, where things break, angular momentum is that of the impulses.
class PieceSolver {
  public:
    PieceSolver(const WorldSettings& settings, const std::vector<std::unique_ptr<BodyRecord>>& bodies,
                const GroundContacts& ground)
        : settings_(settings), bodies_(bodies), ground_(ground) {}

    // Of bodies that are awake, and all contacts that any of them has; those must stay until they are told or a body goes.
    void solve(std::span<BodyRecord* const> awake, std::span<const AnyManifold> manifolds, fracture::Threads& threads);
    // Those of the last step that were solved, in the order of manifolds. They are told when they are first asked for, as not
    // everybody wants them: that must be before a body goes.
    [[nodiscard]] std::span<const Contact> solved_contacts();
    // The same, and behind them those of bodies that sleep now, as they pressed when they last were awake; as they were
    // when first asked for since the step.
    [[nodiscard]] std::span<const Contact> contacts(btDispatcher& dispatcher);
    void amend_contact(size_t index, const Contact& contact) { contacts_[index] = contact; }
    // A body came or goes.
    void forget_sleeping() { resting_known_ = false; }

  private:
    void report_solved();
    void report_sleeping(btDispatcher& dispatcher);
    [[nodiscard]] Contact contact_between(const btPersistentManifold& manifold, const btManifoldPoint& point) const;
    [[nodiscard]] Contact contact_on_ground(const GroundManifold& manifold, const GroundPoint& point, float impulse,
                                            float friction) const;

    RowSolver rows_;
    const WorldSettings& settings_;
    const std::vector<std::unique_ptr<BodyRecord>>& bodies_;
    const GroundContacts& ground_;
    std::span<const AnyManifold> manifolds_; // of the last step
    std::vector<Contact> contacts_;
    size_t solved_count_ = 0;                                // of contacts_: they come first
    enum class Told { none, solved, all } told_ = Told::all; // what of the last step contacts_ has
    std::vector<BodyRecord*> awake_;
    // What presses among those that sleep, and who did not sleep then.
    bool resting_known_ = false;
    std::vector<Contact> resting_contacts_;
    std::vector<BodyRecord*> not_resting_;
};

} // namespace brittle::physics

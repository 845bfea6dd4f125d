// Solves the contacts of a step (row_solver.h) and reports them as World::contacts().
//
// Overlap between bodies counts only as far as one step may correct it (WorldSettings::separation_speed). Distances
// are found anew before the next step, which begins by moving the bodies apart. Until then they keep their places, so
// that the angular momentum in a report is that of its impulses.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "physics/solver/body.h"
#include "physics/solver/manifold.h"
#include "physics/solver/row_solver.h"
#include "physics/solver/sweep_broadphase.h"
#include "physics/world/world.h"

namespace brittle::physics {

class ContactSolver {
  public:
    ContactSolver(const WorldSettings& settings, const std::vector<std::unique_ptr<Body>>& bodies,
                  const SweepBroadphase& broadphase)
        : settings_(settings), bodies_(bodies), broadphase_(broadphase) {}

    // Awake bodies, and all contacts of theirs, which must stay until they are reported or a body is removed.
    void solve(std::span<Body* const> awake, std::span<const AnyManifold> manifolds, fracture::Threads& threads);
    // The contacts that the last step solved, in the order of manifolds. The report is made when it is first asked
    // for, which must be before a body is removed.
    [[nodiscard]] std::span<const Contact> solved_contacts();
    // These, and behind them the contacts between sleeping bodies, as they pressed when they were last awake.
    [[nodiscard]] std::span<const Contact> contacts();
    void amend_contact(size_t index, const Contact& contact) { contacts_[index] = contact; }
    // After a body has come or before one goes.
    void forget_sleeping() { sleeping_known_ = false; }

  private:
    void report_solved();
    void report_sleeping();
    [[nodiscard]] Contact report_of(const Manifold& manifold, const ContactPoint& point) const;
    [[nodiscard]] Contact report_of(const GroundManifold& manifold, const GroundPoint& point, float impulse,
                                    float friction) const;

    const WorldSettings& settings_;
    const std::vector<std::unique_ptr<Body>>& bodies_;
    const SweepBroadphase& broadphase_;
    RowSolver rows_;
    std::span<const AnyManifold> manifolds_; // of the last step
    std::vector<Contact> contacts_;
    size_t solved_count_ = 0; // of contacts_: they come first
    enum class Reported { none, solved, all } reported_ = Reported::all;
    std::vector<Body*> awake_;
    // Contacts between sleeping bodies, and the bodies that were awake when they were found.
    bool sleeping_known_ = false;
    std::vector<Contact> sleeping_contacts_;
    std::vector<Body*> were_awake_;
};

} // namespace brittle::physics

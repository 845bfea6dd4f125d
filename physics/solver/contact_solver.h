// Solves the contacts of a step (row_solver.h) and reports them as World::contacts().
//
// A reported overlap is limited to what one step may correct (WorldSettings::separation_speed).
#pragma once

#include <span>
#include <vector>

#include "physics/solver/body.h"
#include "physics/solver/debris_solver.h"
#include "physics/solver/manifold.h"
#include "physics/solver/row_solver.h"
#include "physics/solver/sweep_broadphase.h"
#include "physics/world/world.h"

namespace brittle::physics {

class ContactSolver {
  public:
    ContactSolver(const WorldSettings& settings, const SweepBroadphase& broadphase)
        : settings_(settings), broadphase_(broadphase) {}

    // Solves all contacts and joints of the awake bodies. The manifolds must live until they are reported or a body is
    // removed.
    void solve(std::span<Body* const> awake, std::span<const AnyManifold> manifolds, Joints& joints,
               fracture::Threads& threads);
    // The contacts that the last step solved, in the order of manifolds. The first call makes the report; it must
    // precede the removal of a body.
    [[nodiscard]] std::span<const Contact> solved_contacts();
    // solved_contacts(), followed by the contacts between sleeping bodies with their last impulses.
    [[nodiscard]] std::span<const Contact> contacts();
    void amend_contact(size_t index, const Contact& contact) { contacts_[index] = contact; }
    // Call it after a body is added and before one is removed.
    void forget_sleeping() { sleeping_known_ = false; }

  private:
    void report_solved();
    void report_solved(std::span<const AnyManifold> manifolds, std::span<const RowSolver::Solved> all);
    void report_sleeping();
    [[nodiscard]] Contact report_of(const Manifold& manifold, const ContactPoint& point) const;
    [[nodiscard]] Contact report_of(const EllipsoidManifold& manifold, const EllipsoidPoint& point) const;
    [[nodiscard]] Contact report_of(const GroundManifold& manifold, const GroundPoint& point) const;

    const WorldSettings& settings_;
    const SweepBroadphase& broadphase_;
    RowSolver rows_;
    DebrisSolver debris_;
    std::vector<Contact> contacts_;
    size_t solved_count_ = 0; // number of solved contacts, the first in contacts_
    enum class Reported { none, solved, all } reported_ = Reported::all;
    std::vector<Body*> awake_;
    // Contacts between sleeping bodies, and the bodies that were awake when they were found.
    bool sleeping_known_ = false;
    std::vector<Contact> sleeping_contacts_;
    std::vector<Body*> were_awake_;
};

} // namespace brittle::physics

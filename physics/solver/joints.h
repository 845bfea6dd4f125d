// The joints of a solver: which bodies they connect, and their part of a step.
//
//  1. Islands::find() unites the bodies of pairs().
//  2. start() groups the joints of awake bodies into systems (joint_rows.h): joints that share a body that they can
//     move.
//  3. RowSolver joins the bodies of a system into one bundle. It calls start_substep() and finish_substep() for it in
//     each substep, and solve() in each sweep.
//  4. store() writes forces and removes the joints that broke.
//  5. correct(), after the bodies have moved, closes the gaps that are left.
//
// Joints are in the order of their handles. Not thread-safe, except the functions of a bundle for different bundles.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "fracture/base/threads.h"
#include "physics/solver/body.h"
#include "physics/solver/bundles.h"
#include "physics/solver/joint_rows.h"
#include "physics/solver/row.h"
#include "physics/world/joint.h"

namespace brittle::physics {

class Joints {
  public:
    void add(const SolverJoint& joint);
    // Returns the joint that was removed.
    SolverJoint remove(JointId id);
    [[nodiscard]] const SolverJoint& at(JointId id) const;
    [[nodiscard]] std::span<const std::unique_ptr<SolverJoint>> all() const { return joints_; }
    // The two bodies of each joint between bodies that are not fixed.
    using Pair = std::pair<Body*, Body*>;
    [[nodiscard]] std::span<const Pair> pairs() const { return pairs_; }

    // Call it after the islands are found.
    void start(const JointSystem::Step& step, size_t bodies);
    // Hooks of RowSolver. `indices` holds the places of awake bodies among the solver bodies, by Body::index.
    void join(Bundles& bundles, std::span<const uint32_t> indices) const;
    void touch(std::span<uint32_t> manifolds, std::span<const uint32_t> indices) const;
    void make(const Bundles& bundles, std::span<const uint32_t> indices);
    void mark_jointed(std::span<uint8_t> is_jointed, std::span<const uint32_t> indices) const;
    // Call it before gravity is added.
    void start_substep(uint32_t bundle, const VelocityChange* changes, const Displacement* moved);
    void solve(uint32_t bundle, VelocityChange* changes, Solution solution);
    void finish_substep(uint32_t bundle);
    void store();
    void correct(fracture::Threads& threads);
    [[nodiscard]] std::span<const JointId> broken() const { return broken_; } // in the last step, ascending

  private:
    [[nodiscard]] size_t find(JointId id) const;
    void update_pairs();
    // Calls visit for each system of the bundle.
    void for_each_of(uint32_t bundle, const auto& visit);

    std::vector<std::unique_ptr<SolverJoint>> joints_;
    std::vector<Pair> pairs_;
    std::vector<JointId> broken_;
    // Of one step.
    JointSystem::Step step_;
    std::vector<JointSystem> systems_;
    size_t system_count_ = 0;
    std::vector<std::pair<uint32_t, uint32_t>> by_bundle_; // bundle and system, ascending
};

} // namespace brittle::physics

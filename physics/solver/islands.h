// Which bodies can push each other, directly or through others; they sleep and wake together.
//
// Bodies whose boxes overlap are in one island; what never moves joins nobody. An island of which no body wants to be awake
// falls asleep as a whole, and wakes as a whole when a body that is awake comes to it. Of those that sleep only such islands
// are looked at, and of pairs those with a body that is awake or in one of these.
//
// - Contacts come in the order of their pairs, which is that of the bodies: nothing depends on addresses or on what happened
//   before.
// - Not thread-safe, but collects contacts on several threads itself.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <btBulletDynamicsCommon.h>

#include "fracture/base/parallel.h"
#include "physics/solver/any_manifold.h"
#include "physics/solver/body_record.h"
#include "physics/solver/sweep_broadphase.h"

namespace brittle::physics {

class Islands {
  public:
    // Bodies are in the order of their user indices. Nobody is awake but some of those given for that, in the same order. Lets islands fall
    // asleep and wakes them.
    void find(const std::vector<std::unique_ptr<BodyRecord>>& bodies, std::span<BodyRecord* const> awake,
              SweepBroadphase& broadphase, fracture::Threads& threads);

    // In body order.
    [[nodiscard]] const std::vector<BodyRecord*>& awake() const { return awake_; }
    [[nodiscard]] const std::vector<BodyRecord*>& woken() const { return woken_; }          // slept until now
    [[nodiscard]] const std::vector<BodyRecord*>& fallen_asleep() const { return asleep_; } // were awake until now
    // With at least one body that is awake.
    [[nodiscard]] const std::vector<AnyManifold>& manifolds() const { return manifolds_; }
    // The user index of one of the bodies of the island, the same for all of them. Of bodies that are awake.
    [[nodiscard]] uint32_t of(const BodyRecord& body) const {
        return parents_[static_cast<size_t>(body.rigid->getUserIndex())];
    }

  private:
    // Of what is touched: who sleeps with it becomes a member. All pairs that are to be looked at then.
    std::span<const int> add_touched(SweepBroadphase& broadphase);
    void unite(const btBroadphasePair& pair);
    void settle(const std::vector<std::unique_ptr<BodyRecord>>& bodies);
    void collect(const SweptPairs& pairs, std::span<const int> looked_at, fracture::Threads& threads);

    std::vector<uint32_t> parents_; // by body; after find() the root itself
    std::vector<uint8_t> lively_;   // by root: whether one of the island wants to be awake
    std::vector<uint32_t> members_; // bodies that are looked at, ascending
    std::vector<uint32_t> touched_; // ranks of bodies that sleep and touch one that does not
    std::vector<int> with_touched_; // pairs that have a box that was set, or one of theirs
    std::vector<BodyRecord*> awake_, woken_, asleep_;
    std::vector<AnyManifold> manifolds_;
};

} // namespace brittle::physics

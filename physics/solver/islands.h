// Islands: bodies that can push each other, directly or through others. They sleep and wake together.
//
// Moving bodies with overlapping bounds or with a joint between them are in one island; fixed bodies and the ground are
// in none. An island whose bodies are all ready to sleep falls asleep as a whole, and wakes as a whole when an awake
// body touches it. Only these sleeping islands are visited, and only the pairs of awake bodies or of such islands.
//
// - Contacts are in the order of their pairs, which is that of the bodies: nothing depends on addresses or on earlier
//   steps.
// - Not thread-safe; collects contacts on several threads itself.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "physics/solver/body.h"
#include "physics/solver/joints.h"
#include "physics/solver/manifold.h"
#include "physics/solver/sweep_broadphase.h"

namespace brittle::physics {

class Islands {
  public:
    // Finds the islands, puts them to sleep and wakes them. `awake` holds the awake bodies in body order, `joints` the
    // pairs of moving bodies that a joint connects.
    void find(const std::vector<std::unique_ptr<Body>>& bodies, std::span<Body* const> awake,
              std::span<const Joints::Pair> joints, SweepBroadphase& broadphase, fracture::Threads& threads);

    // In body order.
    [[nodiscard]] const std::vector<Body*>& awake() const { return awake_; }
    [[nodiscard]] const std::vector<Body*>& woken() const { return woken_; }          // asleep before find()
    [[nodiscard]] const std::vector<Body*>& fallen_asleep() const { return asleep_; } // awake before find()
    // The manifolds of pairs with at least one awake body.
    [[nodiscard]] const std::vector<AnyManifold>& manifolds() const { return manifolds_; }
    // The index of the body that represents the island of an awake body.
    [[nodiscard]] uint32_t of(const Body& body) const { return parents_[body.index]; }

  private:
    // Adds the sleeping bodies that are connected with a touched one to members_; returns the pairs to visit.
    std::span<const uint32_t> add_touched(std::span<const Joints::Pair> joints, SweepBroadphase& broadphase);
    void unite(const SweptPair& pair);
    void settle(const std::vector<std::unique_ptr<Body>>& bodies);
    void collect(const SweptPairs& pairs, std::span<const uint32_t> visited, fracture::Threads& threads);

    std::vector<uint32_t> parents_;      // by body; after find() the root itself
    std::vector<uint8_t> stays_awake_;   // by root
    std::vector<uint32_t> members_;      // bodies that are visited, ascending
    std::vector<uint32_t> touched_;      // ranks of sleeping bodies that an awake one touches
    std::vector<uint32_t> with_touched_; // pairs with bounds that were set, or of a body connected with a touched one
    std::vector<Body*> awake_, woken_, asleep_;
    std::vector<AnyManifold> manifolds_;
};

} // namespace brittle::physics

// Islands: bodies that can push each other, directly or through others. They sleep and wake together.
//
// Bodies whose bounds overlap are in one island; fixed bodies and the ground are in none. An island without a body
// that wants to stay awake falls asleep as a whole, and wakes as a whole when an awake body comes to it. Of sleeping
// bodies only such islands are visited, and of pairs those with an awake body or in such an island.
//
// - Contacts come in the order of their pairs, which is that of the bodies: nothing depends on addresses or on
//   earlier steps.
// - Not thread-safe, but collects contacts on several threads itself.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "physics/solver/body.h"
#include "physics/solver/manifold.h"
#include "physics/solver/sweep_broadphase.h"

namespace brittle::physics {

class Islands {
  public:
    // Bodies by their index; the awake bodies among them, in the same order. Lets islands fall asleep and wakes them.
    void find(const std::vector<std::unique_ptr<Body>>& bodies, std::span<Body* const> awake,
              SweepBroadphase& broadphase, fracture::Threads& threads);

    // In body order.
    [[nodiscard]] const std::vector<Body*>& awake() const { return awake_; }
    [[nodiscard]] const std::vector<Body*>& woken() const { return woken_; }          // slept until now
    [[nodiscard]] const std::vector<Body*>& fallen_asleep() const { return asleep_; } // were awake until now
    // With at least one body that is awake.
    [[nodiscard]] const std::vector<AnyManifold>& manifolds() const { return manifolds_; }
    // The index of one body of the island, the same for all bodies in it. Of an awake body.
    [[nodiscard]] uint32_t of(const Body& body) const { return parents_[body.index]; }

  private:
    // Makes the sleeping bodies that are connected with a touched one members; returns the pairs to visit then.
    std::span<const uint32_t> add_touched(SweepBroadphase& broadphase);
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

// Which boxes overlap, found anew in each step by sweeping along one axis.
//
// Bullet's tree swells boxes so that it need not look in every step, and keeps a hash of all pairs that come out of it. In a
// heap of pieces that are as small as their slack, that is three times as many pairs as there are overlaps, and while things
// fall, every box leaves its slack in every step. Here boxes are as tight as they are given. Those whose box was set since the
// last time, which are the bodies that are awake, are sorted along the axis on which they spread most and compared with each
// other and with those that were not, four at a time; pairs of two that were not stay as they are. Debris, which meets no debris,
// has lists of its own, awake and asleep, compared neither with themselves nor with each other. Of others that it overlaps it has no pair with
// those that are too small for it (SweptProxy::min_partner).
//
// - Pairs come in the order of their proxies, and those in the order in which they were made: nothing depends on addresses or
//   on what happened before.
// - What a pair keeps (its collision algorithm) lives as long as the boxes overlap in each step, and is freed at once when
//   one of the two is removed.
// - Bodies that sleep cost a comparison of one coordinate each.
// - The work grows with the pairs that overlap along the axis: n to the power of 5/3 for n pieces of one object. A
//   thousand take 0.4 ms, three thousand 1.2 ms.
// - Not thread-safe, but sweeps on several threads itself.
//
// Sweep and prune: D. Baraff, "Dynamic Simulation of Non-Penetrating Rigid Bodies", 1992.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include <btBulletDynamicsCommon.h>

#include "fracture/base/parallel.h"
#include "physics/solver/float4.h"

namespace brittle::physics {

// Proxies are numbered by rank: their place among all, in the order in which they came.
struct SweptProxy final : btBroadphaseProxy {
    uint32_t rank = 0;
    btScalar size = BT_LARGE_FLOAT, min_partner = 0.0f; // see make_proxy()
};

// Pairs of boxes in the order of their ranks.
class SweptPairs final : public btOverlappingPairCache {
  public:
    using Key = uint64_t; // lower rank, higher rank
    // What became of a box since pairs were last found.
    enum class Change : uint8_t { none, set, gone };

    SweptPairs() = default;
    SweptPairs(const SweptPairs&) = delete;
    SweptPairs& operator=(const SweptPairs&) = delete;

    // Keeps, of the pairs with a box that was set, those that are found, adds what is new and drops what is not. Keys are
    // ascending; changes by rank, nobody gone.
    void update(const std::vector<Key>& found, const std::vector<std::unique_ptr<SweptProxy>>& proxies,
                const std::vector<Change>& changes, btDispatcher* dispatcher);
    // Drops the pairs of boxes that are gone, which have been cleaned, and gives the others their new ranks, by the old ones.
    void forget_gone(const std::vector<Change>& changes, const std::vector<uint32_t>& ranks);

    void cleanOverlappingPair(btBroadphasePair& pair, btDispatcher* dispatcher) override;
    void cleanProxyFromPairs(btBroadphaseProxy* proxy, btDispatcher* dispatcher) override;
    void processAllOverlappingPairs(btOverlapCallback* callback, btDispatcher* dispatcher) override;
    btBroadphasePair* findPair(btBroadphaseProxy* first, btBroadphaseProxy* second) override;

    // Indices of the pairs of which a box was set when pairs were last found, in their order.
    [[nodiscard]] const std::vector<int>& set() const { return set_; }
    [[nodiscard]] std::span<const Key> keys() const { return keys_; } // of all pairs
    [[nodiscard]] const btBroadphasePair& at(int index) const { return pairs_->at(index); }
    [[nodiscard]] uint32_t higher_rank(int index) const {
        return static_cast<uint32_t>(keys_[static_cast<size_t>(index)]);
    }
    // Of those of one box, in their order; until the next call.
    [[nodiscard]] const std::vector<int>& pairs_of(const btBroadphaseProxy& proxy);

    btBroadphasePair* getOverlappingPairArrayPtr() override { return pairs_->size() > 0 ? &pairs_->at(0) : nullptr; }
    const btBroadphasePair* getOverlappingPairArrayPtr() const override {
        return pairs_->size() > 0 ? &pairs_->at(0) : nullptr;
    }
    btBroadphasePairArray& getOverlappingPairArray() override { return *pairs_; } // until pairs are next found
    int getNumOverlappingPairs() const override { return pairs_->size(); }

    // Of Bullet's interface, but only asked for by its own broadphases.
    bool needsBroadphaseCollision(btBroadphaseProxy*, btBroadphaseProxy*) const override { return true; }
    btBroadphasePair* addOverlappingPair(btBroadphaseProxy*, btBroadphaseProxy*) override { return nullptr; }
    void* removeOverlappingPair(btBroadphaseProxy*, btBroadphaseProxy*, btDispatcher*) override { return nullptr; }
    void removeOverlappingPairsContainingProxy(btBroadphaseProxy*, btDispatcher*) override {}
    btOverlapFilterCallback* getOverlapFilterCallback() override { return nullptr; }
    void setOverlapFilterCallback(btOverlapFilterCallback*) override {}
    void setInternalGhostPairCallback(btOverlappingPairCallback*) override {}
    void sortOverlappingPairs(btDispatcher*) override {}
    bool hasDeferredRemoval() override { return true; }

  private:
    std::array<btBroadphasePairArray, 2> arrays_; // take turns: to swap two of Bullet's is to copy them
    btBroadphasePairArray *pairs_ = arrays_.data(), *next_ = pairs_ + 1;
    std::vector<Key> keys_, next_keys_; // of the pairs: proxies lie anywhere in memory
    std::vector<int> set_, of_one_;
};

class SweepBroadphase final : public btBroadphaseInterface {
  public:
    explicit SweepBroadphase(fracture::Threads& threads) : threads_(threads) {}

    btBroadphaseProxy* createProxy(const btVector3& low, const btVector3& high, int shape, void* object, int group,
                                   int mask, btDispatcher* dispatcher) override;
    // One that is in no broadphase yet: made on any thread. It is so large, and meets only what is at least so large.
    [[nodiscard]] static std::unique_ptr<SweptProxy> make_proxy(const btVector3& low, const btVector3& high,
                                                                void* object, int group, int mask,
                                                                btScalar size = BT_LARGE_FLOAT,
                                                                btScalar min_partner = 0.0f);
    // Behind all others.
    void put_in(std::unique_ptr<SweptProxy> proxy);
    // Whether two meet where they overlap: as their groups and their sizes say.
    [[nodiscard]] bool may_meet(const btBroadphaseProxy& a, const btBroadphaseProxy& b) const;
    void destroyProxy(btBroadphaseProxy* proxy, btDispatcher* dispatcher) override;
    void setAabb(btBroadphaseProxy* proxy, const btVector3& low, const btVector3& high,
                 btDispatcher* dispatcher) override;
    void getAabb(btBroadphaseProxy* proxy, btVector3& low, btVector3& high) const override;
    // Boxes that a ray, or a box along it, may hit; in the order of ranks.
    void rayTest(const btVector3& from, const btVector3& to, btBroadphaseRayCallback& callback, const btVector3& low,
                 const btVector3& high) override;
    void aabbTest(const btVector3& low, const btVector3& high, btBroadphaseAabbCallback& callback) override;
    void calculateOverlappingPairs(btDispatcher* dispatcher) override;
    // Pairs of boxes that were set since pairs were last found with all that they overlap, ascending; until the next call. None may have
    // been destroyed since then.
    [[nodiscard]] std::span<const SweptPairs::Key> find_set();
    // Ranks of all boxes that overlap some given ones, each once, directly or through others, and the pairs that they have; ascending.
    // All of them pass, as those given do. As pairs were last found; until the next call.
    struct Reached {
        std::vector<uint32_t> ranks;
        std::vector<int> pairs;
    };
    using Passes = std::function<bool(const btBroadphaseProxy&)>;
    [[nodiscard]] const Reached& reach(std::span<const uint32_t> ranks, const Passes& passes);
    [[nodiscard]] const btBroadphaseProxy& proxy(uint32_t rank) const { return *proxies_[rank]; }
    btOverlappingPairCache* getOverlappingPairCache() override { return &pairs_; }
    const btOverlappingPairCache* getOverlappingPairCache() const override { return &pairs_; }
    [[nodiscard]] SweptPairs& pairs() { return pairs_; }
    void getBroadphaseAabb(btVector3& low, btVector3& high) const override;
    void printStats() override {}

  private:
    // One box four times over.
    struct Box4 {
        std::array<Float4, 3> low, high;
    };
    static Box4 four_times(const btVector3& from, const btVector3& to);
    // Boxes side by side; behind the last one three that overlap nothing, so that four can be read anywhere.
    struct Boxes {
        std::array<std::vector<float>, 3> low, high;
        std::vector<float> size, min_partner; // see make_proxy()
        void resize(size_t count);
        void set(size_t place, const btVector3& from, const btVector3& to);
        void copy(size_t place, Boxes& to, size_t to_place) const;
        [[nodiscard]] Box4 four_times(size_t place) const;
        // Bit i of the result: whether the box at first + i overlaps the given one.
        [[nodiscard]] uint32_t overlaps(size_t first, const Box4& box) const;
        // Likewise: whether both are as large as the other one asks for; the given one's in all four lanes.
        [[nodiscard]] uint32_t large_enough(size_t first, Float4 own_size, Float4 own_least_partner) const;
    };
    // Boxes in ascending order of where they begin on the axis.
    struct Sorted {
        std::vector<uint32_t> ranks;
        Boxes boxes;
        void resize(size_t count);
    };
    // Of a proxy: whom it meets, whatever their sizes.
    struct Filter {
        int group, partners;
        [[nodiscard]] bool meets(const Filter& other) const;
    };

    // Those that were not set when pairs were last found.
    struct Still {
        Sorted boxes;
        std::vector<uint32_t> ranks, known; // ascending: of boxes; in find_moving() those of the last time
    };

    void forget_gone(); // boxes that were destroyed
    void forget_gone(Still& still, const std::vector<uint32_t>& ranks);
    // The axis on which boxes that were set spread most; one that is about as good is kept.
    [[nodiscard]] int widest_axis() const;
    void sort(Sorted& sorted);
    // Sorts boxes that were set, and puts the others in order.
    void find_moving();
    void put_in_order(Still& still, bool turned); // turned: along another axis than the last time
    // From those of the last time and who has come to rest since.
    void merge(Still& still);
    [[nodiscard]] bool is_set(uint32_t rank) const { return changes_[rank] == SweptPairs::Change::set; }
    // Two ways to do the same: one by one, false where there are many; and for all ranks.
    bool reach_few(std::span<const uint32_t> ranks, const Passes& passes);
    void reach_many(std::span<const uint32_t> ranks, const Passes& passes);
    // One of those that do not meet each other.
    [[nodiscard]] bool is_debris(uint32_t rank) const;
    // These find pairs: within a list; of one of each, where so wanted the second one not set; of a box with others from a place on
    // that begin before it ends.
    void sweep(const Sorted& boxes);
    void sweep(const Sorted& boxes, const Sorted& others, bool skip_set);
    void sweep_one(uint32_t rank, const Sorted& others, size_t from, bool skip_set,
                   std::vector<SweptPairs::Key>& found) const;
    // On several threads: sweep(begin, end, found) for parts of so many boxes.
    void sweep_parts(size_t count, const auto& sweep);
    void sort_found();

    fracture::Threads& threads_;
    std::vector<std::unique_ptr<SweptProxy>> proxies_; // by rank, as are the next three
    std::vector<SweptPairs::Change> changes_;
    std::vector<Filter> filters_;
    Boxes boxes_;
    SweptPairs pairs_;
    int next_uid_ = 0;
    bool some_gone_ = false;
    int axis_ = 0;               // along which boxes are sorted
    Sorted moving_, debris_;     // when pairs were last found: boxes that were set, of debris and not
    Still still_, still_debris_; // and the others, likewise
    Sorted set_;                 // since then
    Sorted come_, merged_;       // of merge(): who is new there, and what becomes of it
    std::vector<std::vector<SweptPairs::Key>> parts_; // of one call, as are the next
    std::vector<SweptPairs::Key> found_, scratch_, order_;
    std::vector<uint32_t> starts_;
    Reached reached_; // of one call of reach(), as are the next, by rank
    std::vector<uint32_t> parents_;
    std::vector<uint8_t> passes_, is_reached_;
};

} // namespace brittle::physics

// The broadphase: pairs of bounds that overlap, found anew in each step by sweeping along one axis (sweep and prune).
//
// Bounds are tight: in a heap of pieces, bounds with the slack that a dynamic tree needs give three times as many
// pairs. The bounds that were set since the last step are those of bodies that are awake. They are sorted along the
// axis on which they spread most, and compared with each other and with the bounds that were not set, four at a time.
// Pairs of two that were not set stay as they are. Debris has lists of its own, awake and asleep, which are neither
// compared with themselves nor with each other, because debris does not collide with debris.
//
// - Pairs come in the order of their proxies' ranks, and ranks in the order in which proxies were added: nothing
//   depends on addresses or on earlier steps.
// - The contacts that a pair keeps live as long as the two overlap in every step, and end when one of them is removed.
// - A body that sleeps costs the comparison of one coordinate.
// - The work grows with the pairs that overlap along the axis: n^(5/3) for n pieces of one object.
// - Not thread-safe, but sweeps on several threads itself.
//
// D. Baraff, "Dynamic Simulation of Non-Penetrating Rigid Bodies", 1992 (sweep and prune).
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/base/threads.h"
#include "physics/solver/float4.h"
#include "physics/solver/pair_contacts.h"
#include "physics/solver/transform.h"

namespace brittle::physics {

struct Body;

// Bodies of two kinds collide, and two that are moving; two that are fixed, or two that are debris, do not.
enum class Collides : uint8_t { fixed, moving, debris };

// An entry of the broadphase: the bounds of a body or of the ground.
struct SweptProxy {
    Body* body = nullptr; // null: the ground
    Bounds bounds;
    Collides collides = Collides::moving;
    // m. Two collide only if each is at least as large as the other's min_partner.
    float size = unbounded, min_partner = 0.0f;
    uint32_t rank = 0; // its place among all proxies, in the order in which they were added
};

// Two proxies whose bounds overlap, the lower rank first, and their contacts.
struct SweptPair {
    SweptProxy *a, *b;
    std::unique_ptr<PairContacts> contacts; // null until the narrow phase needs some
};

// The pairs, in the order of their ranks.
class SweptPairs {
  public:
    using Key = uint64_t; // lower rank, higher rank
    // Of a proxy since pairs were last found.
    enum class Change : uint8_t { none, set, gone };

    SweptPairs() = default;
    SweptPairs(const SweptPairs&) = delete;
    SweptPairs& operator=(const SweptPairs&) = delete;

    // Of the pairs with bounds that were set, keeps those that were found, adds new ones and drops the others. Keys are
    // ascending; changes by rank, none of them gone.
    void update(const std::vector<Key>& found, const std::vector<std::unique_ptr<SweptProxy>>& proxies,
                const std::vector<Change>& changes);
    // Drops the pairs of proxies that are gone and gives the others their new ranks, by the old ones.
    void forget_gone(const std::vector<Change>& changes, const std::vector<uint32_t>& ranks);

    [[nodiscard]] size_t size() const { return pairs_.size(); }
    [[nodiscard]] SweptPair& at(uint32_t index) { return pairs_[index]; }
    [[nodiscard]] const SweptPair& at(uint32_t index) const { return pairs_[index]; }
    [[nodiscard]] std::span<const SweptPair> all() const { return pairs_; }
    [[nodiscard]] std::span<const Key> keys() const { return keys_; }
    // Indices of the pairs of which bounds were set when pairs were last found, ascending.
    [[nodiscard]] const std::vector<uint32_t>& set() const { return set_; }
    // Indices of the pairs of one proxy, ascending; valid until the next call.
    [[nodiscard]] const std::vector<uint32_t>& pairs_of(const SweptProxy& proxy);

  private:
    std::vector<SweptPair> pairs_, next_;
    std::vector<Key> keys_, next_keys_; // of the pairs: proxies lie anywhere in memory
    std::vector<uint32_t> set_, of_one_;
};

class SweepBroadphase {
  public:
    explicit SweepBroadphase(fracture::Threads& threads) : threads_(threads) {}

    // Behind all others.
    void add(std::unique_ptr<SweptProxy> proxy);
    // In constant time; its contacts end at once, the proxy with the next find_pairs().
    void remove(SweptProxy& proxy);
    void set_bounds(SweptProxy& proxy, const Bounds& bounds);
    void find_pairs();

    [[nodiscard]] SweptPairs& pairs() { return pairs_; }
    [[nodiscard]] const SweptPairs& pairs() const { return pairs_; }
    [[nodiscard]] const SweptProxy& proxy(uint32_t rank) const { return *proxies_[rank]; }
    // Whether two collide where they overlap: by their kinds and their sizes.
    [[nodiscard]] static bool may_collide(const SweptProxy& a, const SweptProxy& b);
    // Calls visit(proxy) for each proxy whose bounds overlap the given ones, in the order of ranks.
    void for_each_overlap(const Bounds& bounds, const std::function<void(const SweptProxy&)>& visit) const;

    // Pairs of bounds that were set since pairs were last found with all that they overlap, ascending; valid until
    // the next call. No proxy may have been removed since then.
    [[nodiscard]] std::span<const SweptPairs::Key> find_set();

    // The ranks of all proxies that are connected with some given ones by pairs, each once, and the pairs that they
    // have; ascending. Connections lead through proxies for which `passes` holds, as it does for the given ones. By
    // the pairs that were last found; valid until the next call.
    struct Connected {
        std::vector<uint32_t> ranks;
        std::vector<uint32_t> pairs;
    };
    using Passes = std::function<bool(const SweptProxy&)>;
    [[nodiscard]] const Connected& connected(std::span<const uint32_t> ranks, const Passes& passes);

  private:
    // One box in all four lanes.
    struct Box4 {
        std::array<Float4, 3> low, high;
    };
    static Box4 four_times(const Bounds& bounds);
    // Boxes side by side; behind the last one three that overlap nothing, so that four can be read anywhere.
    struct Boxes {
        std::array<std::vector<float>, 3> low, high;
        std::vector<float> size, min_partner; // of the proxies
        void resize(size_t count);
        void set(size_t place, const Bounds& bounds);
        void copy(size_t place, Boxes& to, size_t to_place) const;
        [[nodiscard]] Box4 four_times(size_t place) const;
        // Bit i: whether the box at first + i overlaps the given one.
        [[nodiscard]] uint32_t overlaps(size_t first, const Box4& box) const;
        // Bit i: whether that box and the given one are as large as each other's min_partner.
        [[nodiscard]] uint32_t large_enough(size_t first, Float4 own_size, Float4 own_min_partner) const;
    };
    // Boxes in ascending order of their low ends on the axis.
    struct Sorted {
        std::vector<uint32_t> ranks;
        Boxes boxes;
        void resize(size_t count);
    };

    // Boxes that were not set when pairs were last found.
    struct Still {
        Sorted boxes;
        std::vector<uint32_t> ranks, known; // ascending: of boxes; in sort_proxies() those of the last time
    };

    void forget_gone();
    void forget_gone(Still& still, const std::vector<uint32_t>& ranks);
    // The axis on which boxes that were set spread most; the present one if it is about as good.
    [[nodiscard]] int widest_axis() const;
    void sort(Sorted& sorted);
    // Sorts the boxes that were set, and brings the order of the others up to date.
    void sort_proxies();
    void put_in_order(Still& still, bool other_axis);
    // Merges those of the last time with those that have come to rest since.
    void merge(Still& still);
    [[nodiscard]] bool is_set(uint32_t rank) const { return changes_[rank] == SweptPairs::Change::set; }
    // Two ways to find what is connected: one proxy after the other, false where there are many; and over all pairs.
    bool connect_few(std::span<const uint32_t> ranks, const Passes& passes);
    void connect_many(std::span<const uint32_t> ranks, const Passes& passes);
    // These add pairs to found_: within a list; of two lists, optionally without those of the second that were set;
    // of one box with the boxes from a place on that begin before it ends.
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
    std::vector<Collides> collides_;
    Boxes boxes_;
    SweptPairs pairs_;
    bool some_gone_ = false;
    int axis_ = 0;               // along which boxes are sorted
    Sorted moving_, debris_;     // when pairs were last found: boxes that were set, without debris and of debris
    Still still_, still_debris_; // and the others
    Sorted set_;                 // since then
    Sorted new_, merged_;        // scratch of merge()
    std::vector<std::vector<SweptPairs::Key>> parts_; // scratch of one call, as are the next
    std::vector<SweptPairs::Key> found_, scratch_, order_;
    std::vector<uint32_t> starts_;
    Connected connected_; // of one call of connected(), as are the next, by rank
    std::vector<uint32_t> parents_;
    std::vector<uint8_t> passes_, is_connected_;
};

} // namespace brittle::physics

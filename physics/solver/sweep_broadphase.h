// The broadphase: finds the pairs of overlapping bounds in each step by sweep and prune along one axis.
//
// Bounds are tight: in a heap of pieces, bounds with the slack that a dynamic tree needs give three times as many
// pairs. The bounds of awake bodies are set in each step. They are sorted along the axis on which they spread most, and
// compared with each other and with the bounds that were not set (still bounds), four at a time. A pair of still bounds
// stays as it is.
//
// - Pairs are ordered by the ranks of their proxies, and ranks are in order of addition: nothing depends on addresses
//   or on earlier steps.
// - The contacts of a pair live as long as its bounds overlap in every step, and end when one of its proxies is
//   removed.
// - A sleeping body costs the comparison of one coordinate.
// - Time is proportional to the pairs that overlap along the axis: n^(5/3) for n pieces of one object.
// - Not thread-safe; sweeps on several threads itself.
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

// An entry of the broadphase: the bounds of a body or of the ground.
struct SweptProxy {
    Body* body = nullptr; // null: the ground
    Bounds bounds;
    bool fixed = false; // two fixed proxies make no pair
    uint32_t rank = 0;  // index among all proxies, in order of addition
};

// Two proxies with overlapping bounds, the lower rank first, and their contacts.
struct SweptPair {
    SweptProxy *a, *b;
    std::unique_ptr<PairContacts> contacts; // null until the narrow phase makes them
};

// The pairs, sorted by their keys.
class SweptPairs {
  public:
    using Key = uint64_t; // lower rank in the high half, higher rank in the low half
    // Change of a proxy since pairs were last found.
    enum class Change : uint8_t { none, set, gone };

    SweptPairs() = default;
    SweptPairs(const SweptPairs&) = delete;
    SweptPairs& operator=(const SweptPairs&) = delete;

    // Updates the pairs with bounds that were set to the keys that were found, in ascending order: keeps, adds and
    // drops pairs. Changes are by rank; none is `gone`.
    void update(const std::vector<Key>& found, const std::vector<std::unique_ptr<SweptProxy>>& proxies,
                const std::vector<Change>& changes);
    // Drops the pairs of removed proxies and renumbers the others; `ranks` holds the new rank by old rank.
    void forget_gone(const std::vector<Change>& changes, const std::vector<uint32_t>& ranks);

    [[nodiscard]] size_t size() const { return pairs_.size(); }
    [[nodiscard]] SweptPair& at(uint32_t index) { return pairs_[index]; }
    [[nodiscard]] const SweptPair& at(uint32_t index) const { return pairs_[index]; }
    [[nodiscard]] std::span<const SweptPair> all() const { return pairs_; }
    [[nodiscard]] std::span<const Key> keys() const { return keys_; }
    // Indices of the pairs with bounds that were set when pairs were last found, ascending.
    [[nodiscard]] const std::vector<uint32_t>& set() const { return set_; }
    // Indices of the pairs of one proxy, ascending; valid until the next call.
    [[nodiscard]] const std::vector<uint32_t>& pairs_of(const SweptProxy& proxy);

  private:
    std::vector<SweptPair> pairs_, next_;
    std::vector<Key> keys_, next_keys_; // of pairs_: reading proxies would miss the cache
    std::vector<uint32_t> set_, of_one_;
};

class SweepBroadphase {
  public:
    explicit SweepBroadphase(fracture::Threads& threads) : threads_(threads) {}

    // Adds a proxy with the highest rank.
    void add(std::unique_ptr<SweptProxy> proxy);
    // Ends the proxy's contacts at once; find_pairs() then drops the proxy.
    void remove(SweptProxy& proxy);
    void set_bounds(SweptProxy& proxy, const Bounds& bounds);
    void find_pairs();

    [[nodiscard]] SweptPairs& pairs() { return pairs_; }
    [[nodiscard]] const SweptPairs& pairs() const { return pairs_; }
    [[nodiscard]] const SweptProxy& proxy(uint32_t rank) const { return *proxies_[rank]; }
    // Calls visit(proxy) for each proxy whose bounds overlap the given ones, in the order of ranks.
    void for_each_overlap(const Bounds& bounds, const std::function<void(const SweptProxy&)>& visit) const;

    // Returns the pairs of bounds that were set since the last find_pairs(), with all bounds that they overlap,
    // ascending; valid until the next call. Precondition: no proxy was removed since then.
    [[nodiscard]] std::span<const SweptPairs::Key> find_set();

    // Returns the ranks of all proxies that pairs connect with the given ones, and all pairs of these proxies;
    // ascending, without repetition. Connections lead through proxies for which `passes` returns true, as it must for
    // the given ones. Uses the pairs that were last found. Valid until the next call.
    struct Connected {
        std::vector<uint32_t> ranks;
        std::vector<uint32_t> pairs;
    };
    using Passes = std::function<bool(const SweptProxy&)>;
    [[nodiscard]] const Connected& connected(std::span<const uint32_t> ranks, const Passes& passes);

  private:
    // One box, repeated in four lanes.
    struct Box4 {
        std::array<Float4, 3> low, high;
    };
    static Box4 four_times(const Bounds& bounds);
    // Boxes as arrays of coordinates. Three boxes that overlap nothing follow the last one, so four can be read at any
    // index.
    struct Boxes {
        std::array<std::vector<float>, 3> low, high;
        void resize(size_t count);
        void set(size_t place, const Bounds& bounds);
        void copy(size_t place, Boxes& to, size_t to_place) const;
        [[nodiscard]] Box4 four_times(size_t place) const;
        // Sets bit i if the box at first + i overlaps the given one.
        [[nodiscard]] uint32_t overlaps(size_t first, const Box4& box) const;
    };
    // Boxes in ascending order of their low ends along the axis.
    struct Sorted {
        std::vector<uint32_t> ranks;
        Boxes boxes;
        void resize(size_t count);
    };

    // Boxes that were not set when pairs were last found.
    struct Still {
        Sorted boxes;
        std::vector<uint32_t> ranks, known; // ascending: of this step and of the last one
    };

    void forget_gone();
    void forget_gone(Still& still, const std::vector<uint32_t>& ranks);
    // Returns the axis on which the boxes that were set spread most; the present axis unless another is clearly better.
    [[nodiscard]] int widest_axis() const;
    void sort(Sorted& sorted);
    // Sorts the boxes that were set, and brings the order of the others up to date.
    void sort_proxies();
    // Merges the still boxes of the last step with those that became still since.
    void merge(Still& still);
    [[nodiscard]] bool is_set(uint32_t rank) const { return changes_[rank] == SweptPairs::Change::set; }
    // Two algorithms for connected(): a search from proxy to proxy, which returns false if there are many; and
    // union-find over all pairs.
    bool connect_few(std::span<const uint32_t> ranks, const Passes& passes);
    void connect_many(std::span<const uint32_t> ranks, const Passes& passes);
    // Add pairs to found_: within a list; between two lists, optionally without boxes of the second that were set; of
    // one box with the boxes from `from` on that begin before it ends.
    void sweep(const Sorted& boxes);
    void sweep(const Sorted& boxes, const Sorted& others, bool skip_set);
    void sweep_one(uint32_t rank, const Sorted& others, size_t from, bool skip_set,
                   std::vector<SweptPairs::Key>& found) const;
    // Calls sweep(begin, end, found) for parts of `count` boxes, on several threads.
    void sweep_parts(size_t count, const auto& sweep);
    void sort_found();

    fracture::Threads& threads_;
    std::vector<std::unique_ptr<SweptProxy>> proxies_; // by rank, as are the next three
    std::vector<SweptPairs::Change> changes_;
    std::vector<uint8_t> fixed_;
    Boxes boxes_;
    SweptPairs pairs_;
    bool some_gone_ = false;
    int axis_ = 0;                                    // of sorting
    Sorted moving_;                                   // boxes that were set when pairs were last found
    Still still_;                                     // the remaining boxes
    Sorted set_;                                      // boxes that were set since then
    Sorted new_, merged_;                             // scratch of merge()
    std::vector<std::vector<SweptPairs::Key>> parts_; // scratch of one call, with the next two lines
    std::vector<SweptPairs::Key> found_, scratch_, order_;
    std::vector<uint32_t> starts_;
    Connected connected_; // scratch of connected(), with the next two lines; by rank
    std::vector<uint32_t> parents_;
    std::vector<uint8_t> passes_, is_connected_;
};

} // namespace brittle::physics

#include "physics/solver/sweep_broadphase.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

#include "fracture/base/union_find.h"

namespace brittle::physics {

namespace {

// The axis changes only if boxes spread this many times as much along another one, because a change discards the sorted
// order.
constexpr float worth_another_axis = 1.25f;

// Fewer boxes than this are not worth waking another thread for.
constexpr uint32_t min_boxes = 128;

constexpr float infinite = std::numeric_limits<float>::infinity();

SweptPairs::Key key_of(uint32_t first, uint32_t second) {
    return static_cast<SweptPairs::Key>(std::min(first, second)) << 32 | std::max(first, second);
}

// Returns an integer that orders as the number does. Precondition: the number is not NaN.
uint32_t ascending_bits(float value) {
    const auto bits = std::bit_cast<uint32_t>(value + 0.0f); // -0 is 0
    return (bits & 0x80000000u) != 0 ? ~bits : bits | 0x80000000u;
}

} // namespace

void SweptPairs::update(const std::vector<Key>& found, const std::vector<std::unique_ptr<SweptProxy>>& proxies,
                        const std::vector<Change>& changes) {
    next_.clear();
    next_keys_.clear();
    set_.clear();
    const auto keep = [&](SweptPair&& pair, Key key) {
        next_.push_back(std::move(pair));
        next_keys_.push_back(key);
    };
    size_t old = 0;
    // Passes the old pairs before a key; pairs of two still boxes stay.
    const auto pass = [&](Key until) {
        for (; old < pairs_.size() && keys_[old] < until; ++old) {
            const Key key = keys_[old];
            if (changes[key >> 32] == Change::none && changes[static_cast<uint32_t>(key)] == Change::none)
                keep(std::move(pairs_[old]), key);
        }
    };
    for (const Key key : found) {
        pass(key);
        set_.push_back(static_cast<uint32_t>(next_.size()));
        if (old < pairs_.size() && keys_[old] == key)
            keep(std::move(pairs_[old++]), key);
        else
            keep({proxies[key >> 32].get(), proxies[static_cast<uint32_t>(key)].get(), nullptr}, key);
    }
    pass(std::numeric_limits<Key>::max());
    std::swap(pairs_, next_);
    std::swap(keys_, next_keys_);
    next_.clear(); // frees the contacts of dropped pairs
}

void SweptPairs::forget_gone(const std::vector<Change>& changes, const std::vector<uint32_t>& ranks) {
    size_t left = 0;
    for (size_t i = 0; i < pairs_.size(); ++i) {
        const Key key = keys_[i];
        const auto first = static_cast<uint32_t>(key >> 32), second = static_cast<uint32_t>(key);
        if (changes[first] == Change::gone || changes[second] == Change::gone) continue;
        if (left != i) pairs_[left] = std::move(pairs_[i]);
        keys_[left++] = key_of(ranks[first], ranks[second]);
    }
    pairs_.resize(left);
    keys_.resize(left);
}

// The proxy's pairs with higher ranks are consecutive in key order; its pairs with lower ranks are scattered over all
// keys before them. Few of those keys match, so they are compared in blocks.
const std::vector<uint32_t>& SweptPairs::pairs_of(const SweptProxy& proxy) {
    constexpr size_t at_once = 64;
    const uint32_t rank = proxy.rank;
    const auto own = static_cast<size_t>(std::ranges::lower_bound(keys_, key_of(rank, rank)) - keys_.begin());
    of_one_.clear();
    for (size_t first = 0; first < own; first += at_once) {
        const size_t end = std::min(first + at_once, own);
        uint32_t some = 0;
        for (size_t i = first; i < end; ++i) some |= static_cast<uint32_t>(keys_[i]) == rank ? 1u : 0u;
        if (some == 0) continue;
        for (size_t i = first; i < end; ++i)
            if (static_cast<uint32_t>(keys_[i]) == rank) of_one_.push_back(static_cast<uint32_t>(i));
    }
    for (size_t i = own; i < keys_.size() && keys_[i] >> 32 == rank; ++i) of_one_.push_back(static_cast<uint32_t>(i));
    return of_one_;
}

void SweepBroadphase::Boxes::resize(size_t count) {
    for (size_t axis = 0; axis < 3; ++axis) {
        low[axis].resize(count);
        high[axis].resize(count);
        low[axis].resize(count + 3, infinite);
        high[axis].resize(count + 3, -infinite);
    }
}

void SweepBroadphase::Boxes::copy(size_t place, Boxes& to, size_t to_place) const {
    for (size_t axis = 0; axis < 3; ++axis) {
        to.low[axis][to_place] = low[axis][place];
        to.high[axis][to_place] = high[axis][place];
    }
}

void SweepBroadphase::Sorted::resize(size_t count) {
    ranks.resize(count);
    boxes.resize(count);
}

void SweepBroadphase::Boxes::set(size_t place, const Bounds& bounds) {
    for (size_t axis = 0; axis < 3; ++axis) {
        low[axis][place] = bounds.low[static_cast<int>(axis)];
        high[axis][place] = bounds.high[static_cast<int>(axis)];
    }
}

SweepBroadphase::Box4 SweepBroadphase::Boxes::four_times(size_t place) const {
    Box4 box;
    for (size_t axis = 0; axis < 3; ++axis) {
        box.low[axis] = Float4::all(low[axis][place]);
        box.high[axis] = Float4::all(high[axis][place]);
    }
    return box;
}

SweepBroadphase::Box4 SweepBroadphase::four_times(const Bounds& bounds) {
    Box4 box;
    for (size_t axis = 0; axis < 3; ++axis) {
        box.low[axis] = Float4::all(bounds.low[static_cast<int>(axis)]);
        box.high[axis] = Float4::all(bounds.high[static_cast<int>(axis)]);
    }
    return box;
}

uint32_t SweepBroadphase::Boxes::overlaps(size_t first, const Box4& box) const {
    const auto begins = [&](size_t axis) { return Float4::load(low[axis].data() + first); };
    const auto ends = [&](size_t axis) { return Float4::load(high[axis].data() + first); };
    return all_less_equal(begins(0), box.high[0], begins(1), box.high[1], begins(2), box.high[2])
           & all_less_equal(box.low[0], ends(0), box.low[1], ends(1), box.low[2], ends(2));
}

void SweepBroadphase::add(std::unique_ptr<SweptProxy> proxy) {
    proxy->rank = static_cast<uint32_t>(proxies_.size());
    changes_.push_back(SweptPairs::Change::set);
    fixed_.push_back(proxy->fixed);
    if (proxies_.empty()) boxes_.resize(0);
    for (size_t axis = 0; axis < 3; ++axis) {
        boxes_.low[axis].push_back(infinite);
        boxes_.high[axis].push_back(-infinite);
    }
    boxes_.set(proxy->rank, proxy->bounds);
    proxies_.push_back(std::move(proxy));
}

void SweepBroadphase::remove(SweptProxy& proxy) {
    for (const uint32_t index : pairs_.pairs_of(proxy)) pairs_.at(index).contacts.reset();
    changes_[proxy.rank] = SweptPairs::Change::gone;
    boxes_.set(proxy.rank, {glm::vec3(infinite), glm::vec3(-infinite)});
    some_gone_ = true;
}

void SweepBroadphase::set_bounds(SweptProxy& proxy, const Bounds& bounds) {
    proxy.bounds = bounds;
    changes_[proxy.rank] = SweptPairs::Change::set;
    boxes_.set(proxy.rank, bounds);
}

void SweepBroadphase::for_each_overlap(const Bounds& bounds,
                                       const std::function<void(const SweptProxy&)>& visit) const {
    const Box4 around = four_times(bounds);
    for (size_t first = 0; first < proxies_.size(); first += 4)
        for (uint32_t lanes = boxes_.overlaps(first, around); lanes != 0; lanes &= lanes - 1)
            visit(*proxies_[first + static_cast<size_t>(std::countr_zero(lanes))]);
}

void SweepBroadphase::find_pairs() {
    if (some_gone_) forget_gone();
    sort_proxies();
    found_.clear();
    sweep(moving_);
    sweep(moving_, still_.boxes, false);
    sort_found();
    pairs_.update(found_, proxies_, changes_);
    std::ranges::fill(changes_, SweptPairs::Change::none);
}

void SweepBroadphase::forget_gone() {
    const auto gone = [this](uint32_t rank) { return changes_[rank] == SweptPairs::Change::gone; };
    std::vector<uint32_t> ranks; // new rank by old rank
    uint32_t left = 0;
    for (uint32_t rank = 0; rank < proxies_.size(); ++rank) {
        ranks.push_back(left);
        if (gone(rank)) continue;
        if (left != rank) {
            proxies_[left] = std::move(proxies_[rank]);
            proxies_[left]->rank = left;
            fixed_[left] = fixed_[rank];
            boxes_.copy(rank, boxes_, left);
        }
        ++left;
    }
    forget_gone(still_, ranks);
    pairs_.forget_gone(changes_, ranks);
    std::erase(changes_, SweptPairs::Change::gone);
    proxies_.resize(left);
    fixed_.resize(left);
    boxes_.resize(left);
    some_gone_ = false;
}

// Keeps the order and assigns the new ranks; `ranks` holds them by old rank.
void SweepBroadphase::forget_gone(Still& still, const std::vector<uint32_t>& ranks) {
    const auto gone = [this](uint32_t rank) { return changes_[rank] == SweptPairs::Change::gone; };
    uint32_t left = 0;
    Sorted& sorted = still.boxes;
    for (uint32_t place = 0; place < sorted.ranks.size(); ++place) {
        if (gone(sorted.ranks[place])) continue;
        sorted.boxes.copy(place, sorted.boxes, left);
        sorted.ranks[left++] = ranks[sorted.ranks[place]];
    }
    sorted.resize(left);
    std::erase_if(still.ranks, gone);
    for (uint32_t& rank : still.ranks) rank = ranks[rank];
}

int SweepBroadphase::widest_axis() const {
    std::array<float, 3> spread{};
    for (size_t axis = 0; axis < 3; ++axis) {
        float low = infinite, high = -infinite; // of twice the middles
        for (const uint32_t rank : moving_.ranks) {
            const float middle = boxes_.low[axis][rank] + boxes_.high[axis][rank];
            low = std::min(low, middle);
            high = std::max(high, middle);
        }
        spread[axis] = high - low;
    }
    const auto widest = std::ranges::max_element(spread);
    return *widest > worth_another_axis * spread[static_cast<size_t>(axis_)] ? static_cast<int>(widest - spread.begin())
                                                                             : axis_;
}

void SweepBroadphase::sort(Sorted& sorted) {
    const std::vector<float>& begin = boxes_.low[static_cast<size_t>(axis_)];
    order_.clear();
    for (const uint32_t rank : sorted.ranks)
        order_.push_back(static_cast<uint64_t>(ascending_bits(begin[rank])) << 32 | rank);
    std::ranges::sort(order_);
    sorted.resize(order_.size());
    for (size_t place = 0; place < order_.size(); ++place) {
        sorted.ranks[place] = static_cast<uint32_t>(order_[place]);
        boxes_.copy(sorted.ranks[place], sorted.boxes, place);
    }
}

// Both lists are sorted: the still boxes of the last step, and the new ones.
void SweepBroadphase::merge(Still& still) {
    new_.ranks.clear();
    std::ranges::set_difference(still.ranks, still.known, std::back_inserter(new_.ranks));
    sort(new_);
    merged_.resize(still.ranks.size());
    const auto axis = static_cast<size_t>(axis_);
    const Sorted& before = still.boxes;
    size_t merged = 0, added = 0;
    const auto take = [&](const Sorted& from, size_t place) {
        merged_.ranks[merged] = from.ranks[place];
        from.boxes.copy(place, merged_.boxes, merged++);
    };
    for (size_t place = 0; place < before.ranks.size(); ++place) {
        if (is_set(before.ranks[place])) continue;
        while (added < new_.ranks.size() && new_.boxes.low[axis][added] < before.boxes.low[axis][place])
            take(new_, added++);
        take(before, place);
    }
    while (added < new_.ranks.size()) take(new_, added++);
    std::swap(still.boxes, merged_);
}

void SweepBroadphase::sort_proxies() {
    moving_.ranks.clear();
    std::swap(still_.ranks, still_.known);
    still_.ranks.clear();
    for (uint32_t rank = 0; rank < proxies_.size(); ++rank)
        (is_set(rank) ? moving_.ranks : still_.ranks).push_back(rank);
    const int axis = widest_axis();
    const bool other_axis = std::exchange(axis_, axis) != axis;
    sort(moving_);
    if (other_axis) {
        still_.boxes.ranks = still_.ranks;
        sort(still_.boxes);
    } else if (still_.ranks != still_.known) {
        merge(still_);
    }
}

std::span<const SweptPairs::Key> SweepBroadphase::find_set() {
    assert(!some_gone_);
    set_.ranks.clear();
    for (uint32_t rank = 0; rank < proxies_.size(); ++rank)
        if (is_set(rank)) set_.ranks.push_back(rank);
    sort(set_);
    found_.clear();
    sweep(set_);
    for (const Sorted* others : {&moving_, &still_.boxes}) sweep(set_, *others, true);
    sort_found();
    return found_;
}

const SweepBroadphase::Connected& SweepBroadphase::connected(std::span<const uint32_t> ranks, const Passes& passes) {
    if (!connect_few(ranks, passes)) connect_many(ranks, passes);
    return connected_;
}

bool SweepBroadphase::connect_few(std::span<const uint32_t> ranks, const Passes& passes) {
    constexpr size_t few = 12; // beyond this, connect_many() is faster among twenty thousand pairs
    connected_.pairs.clear();
    connected_.ranks.assign(ranks.begin(), ranks.end());
    is_connected_.assign(proxies_.size(), 0);
    for (const uint32_t rank : ranks) is_connected_[rank] = 1;
    for (size_t i = 0; i < connected_.ranks.size(); ++i) {
        if (connected_.ranks.size() > few) return false;
        const uint32_t rank = connected_.ranks[i];
        for (const uint32_t index : pairs_.pairs_of(*proxies_[rank])) {
            const SweptPairs::Key key = pairs_.keys()[index];
            const auto first = static_cast<uint32_t>(key >> 32),
                       other = first == rank ? static_cast<uint32_t>(key) : first;
            connected_.pairs.push_back(index);
            if (is_connected_[other] != 0 || !passes(*proxies_[other])) continue;
            is_connected_[other] = 1;
            connected_.ranks.push_back(other);
        }
    }
    std::ranges::sort(connected_.ranks);
    std::ranges::sort(connected_.pairs);
    connected_.pairs.erase(std::unique(connected_.pairs.begin(), connected_.pairs.end()), connected_.pairs.end());
    return true;
}

void SweepBroadphase::connect_many(std::span<const uint32_t> ranks, const Passes& passes) {
    const auto count = static_cast<uint32_t>(proxies_.size());
    passes_.resize(count);
    for (uint32_t rank = 0; rank < count; ++rank) passes_[rank] = passes(*proxies_[rank]);
    parents_.resize(count);
    std::iota(parents_.begin(), parents_.end(), 0u);
    const std::span<const SweptPairs::Key> keys = pairs_.keys();
    for (const SweptPairs::Key key : keys) {
        const auto first = static_cast<uint32_t>(key >> 32), second = static_cast<uint32_t>(key);
        if ((passes_[first] & passes_[second]) != 0) fracture::unite(parents_, first, second);
    }
    is_connected_.assign(count, 0);
    for (const uint32_t rank : ranks) is_connected_[fracture::root_of(parents_, rank)] = 1;
    connected_.ranks.clear();
    for (uint32_t rank = 0; rank < count; ++rank) { // a root has the lowest rank of its set
        is_connected_[rank] = is_connected_[fracture::root_of(parents_, rank)];
        if (is_connected_[rank] != 0) connected_.ranks.push_back(rank);
    }
    connected_.pairs.clear();
    for (size_t i = 0; i < keys.size(); ++i)
        if ((is_connected_[keys[i] >> 32] | is_connected_[static_cast<uint32_t>(keys[i])]) != 0)
            connected_.pairs.push_back(static_cast<uint32_t>(i));
}

void SweepBroadphase::sweep_parts(size_t count, const auto& sweep) {
    parts_.resize(std::max<size_t>(parts_.size(), threads_.chunks(static_cast<uint32_t>(count), min_boxes)));
    for (auto& part : parts_) part.clear();
    threads_.for_chunks(static_cast<uint32_t>(count), min_boxes,
                        [&](uint32_t chunk, uint32_t begin, uint32_t end) { sweep(begin, end, parts_[chunk]); });
    for (const auto& part : parts_) found_.insert(found_.end(), part.begin(), part.end());
}

void SweepBroadphase::sweep(const Sorted& boxes) {
    sweep_parts(boxes.ranks.size(), [&](size_t begin, size_t end, std::vector<SweptPairs::Key>& found) {
        for (size_t i = begin; i < end; ++i) sweep_one(boxes.ranks[i], boxes, i + 1, false, found);
    });
}

// Of two overlapping boxes, one begins inside the other along the axis: the first loop finds pairs where the box of
// `others` begins inside, the second loop the remaining pairs.
void SweepBroadphase::sweep(const Sorted& boxes, const Sorted& others, bool skip_set) {
    if (boxes.ranks.empty() || others.ranks.empty()) return;
    const auto axis = static_cast<size_t>(axis_);
    const auto begins_of = [axis](const Sorted& of) { return std::span(of.boxes.low[axis]).first(of.ranks.size()); };
    const std::span<const float> begins = begins_of(boxes), other_begins = begins_of(others);
    sweep_parts(boxes.ranks.size(), [&](size_t begin, size_t end, std::vector<SweptPairs::Key>& found) {
        auto from = std::ranges::lower_bound(other_begins, begins[begin]);
        for (size_t i = begin; i < end; ++i) {
            while (from != other_begins.end() && *from < begins[i]) ++from;
            if (from == other_begins.end()) return; // no later box has partners either
            sweep_one(boxes.ranks[i], others, static_cast<size_t>(from - other_begins.begin()), skip_set, found);
        }
    });
    sweep_parts(others.ranks.size(), [&](size_t begin, size_t end, std::vector<SweptPairs::Key>& found) {
        auto from = std::ranges::upper_bound(begins, other_begins[begin]);
        for (size_t i = begin; i < end; ++i) {
            while (from != begins.end() && *from <= other_begins[i]) ++from;
            if (from == begins.end()) return;
            if (!skip_set || !is_set(others.ranks[i]))
                sweep_one(others.ranks[i], boxes, static_cast<size_t>(from - begins.begin()), false, found);
        }
    });
}

void SweepBroadphase::sweep_one(uint32_t rank, const Sorted& others, size_t from, bool skip_set,
                                std::vector<SweptPairs::Key>& found) const {
    const std::vector<float>& begin = others.boxes.low[static_cast<size_t>(axis_)];
    const float end = boxes_.high[static_cast<size_t>(axis_)][rank];
    if (from >= others.ranks.size() || begin[from] > end) return;
    const bool fixed = fixed_[rank] != 0;
    const Box4 box = boxes_.four_times(rank);
    for (size_t first = from; first < others.ranks.size() && begin[first] <= end; first += 4) {
        uint32_t lanes = others.boxes.overlaps(first, box);
        for (; lanes != 0; lanes &= lanes - 1) {
            const uint32_t other = others.ranks[first + static_cast<size_t>(std::countr_zero(lanes))];
            if (!(fixed && fixed_[other] != 0) && !(skip_set && is_set(other))) found.push_back(key_of(rank, other));
        }
    }
}

// A radix sort by counting: first by the higher ranks, then by the lower ones.
void SweepBroadphase::sort_found() {
    scratch_.resize(found_.size());
    for (const uint32_t shift : {0u, 32u}) {
        const auto rank_of = [shift](SweptPairs::Key key) { return static_cast<uint32_t>(key >> shift); };
        starts_.assign(proxies_.size() + 1, 0);
        for (const SweptPairs::Key key : found_) ++starts_[rank_of(key) + 1];
        for (size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
        for (const SweptPairs::Key key : found_) scratch_[starts_[rank_of(key)]++] = key;
        std::swap(found_, scratch_);
    }
}

} // namespace brittle::physics

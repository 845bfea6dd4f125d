#include "physics/solver/islands.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <functional>
#include <numeric>

#include "fracture/base/union_find.h"

namespace brittle::physics {

namespace {

// Fewer pairs than this are not worth waking another thread for.
constexpr uint32_t min_pairs = 512;

bool moves(const SweptProxy& proxy) {
    return proxy.body && !proxy.body->fixed;
}
bool sleeps(const SweptProxy& proxy) {
    return !proxy.body->awake();
}
bool is_at_rest(const SweptProxy& proxy) {
    return !moves(proxy) || sleeps(proxy);
}

bool sleeps(const Body& body) {
    return body.activity == Activity::asleep;
}

// Returns whether the pair joins an awake body and a sleeping one.
bool wakes(const SweptPair& pair) {
    return moves(*pair.a) && moves(*pair.b) && sleeps(*pair.a) != sleeps(*pair.b);
}

} // namespace

void Islands::find(const std::vector<std::unique_ptr<Body>>& bodies, std::span<Body* const> awake,
                   std::span<const Joints::Pair> joints, SweepBroadphase& broadphase, fracture::Threads& threads) {
    const SweptPairs& pairs = broadphase.pairs();
    members_.clear();
    for (const Body* body : awake)
        if (body->awake()) members_.push_back(body->index);
    touched_.clear();
    for (const uint32_t index : pairs.set())
        if (const SweptPair& pair = pairs.at(index); wakes(pair))
            touched_.push_back(sleeps(*pair.a) ? pair.a->rank : pair.b->rank);
    for (const auto& [a, b] : joints)
        if ((sleeps(*a) && b->awake()) || (sleeps(*b) && a->awake()))
            touched_.push_back((sleeps(*a) ? a : b)->proxy->rank);
    std::span<const uint32_t> visited = pairs.set();
    if (!touched_.empty()) visited = add_touched(joints, broadphase);

    assert(std::ranges::adjacent_find(members_, std::greater_equal<uint32_t>{}) == members_.end()); // each once
    parents_.resize(bodies.size());
    std::iota(parents_.begin(), parents_.end(), 0u);
    stays_awake_.assign(bodies.size(), 0);
    for (const uint32_t index : visited) unite(pairs.at(index));
    for (const auto& [a, b] : joints) fracture::unite(parents_, a->index, b->index);
    settle(bodies);
    collect(pairs, visited, threads);
}

// Islands of sleeping bodies are not stored; they are found again when one of their bodies is touched.
std::span<const uint32_t> Islands::add_touched(std::span<const Joints::Pair> joints, SweepBroadphase& broadphase) {
    const auto passes = [](const SweptProxy& proxy) { return moves(proxy) && sleeps(proxy); };
    const auto connect = [&]() -> const SweepBroadphase::Connected& {
        std::ranges::sort(touched_);
        touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
        return broadphase.connected(touched_, passes);
    };
    // Joints lead on from the bodies that were found, to bodies with pairs of their own.
    const auto touch_jointed = [&](const SweepBroadphase::Connected& found) {
        const size_t before = touched_.size();
        const auto has = [&](const Body& body) { return std::ranges::binary_search(found.ranks, body.proxy->rank); };
        for (const auto& [a, b] : joints)
            if (sleeps(*a) && sleeps(*b) && has(*a) != has(*b)) touched_.push_back((has(*a) ? b : a)->proxy->rank);
        return touched_.size() > before;
    };
    while (touch_jointed(connect())) {
    }
    const SweepBroadphase::Connected& connected = connect();
    const auto awake = static_cast<std::ptrdiff_t>(members_.size());
    for (const uint32_t rank : connected.ranks) members_.push_back(broadphase.proxy(rank).body->index);
    std::ranges::sort(members_.begin() + awake, members_.end());
    std::ranges::inplace_merge(members_, members_.begin() + awake);
    const std::vector<uint32_t>& set = broadphase.pairs().set();
    with_touched_.resize(set.size() + connected.pairs.size());
    with_touched_.erase(std::ranges::set_union(set, connected.pairs, with_touched_.begin()).out, with_touched_.end());
    return with_touched_;
}

void Islands::settle(const std::vector<std::unique_ptr<Body>>& bodies) {
    for (const uint32_t member : members_) {
        parents_[member] = fracture::root_of(parents_, member);
        const Activity activity = bodies[member]->activity;
        if (activity == Activity::awake || activity == Activity::never_sleeps) stays_awake_[parents_[member]] = 1;
    }
    awake_.clear();
    woken_.clear();
    asleep_.clear();
    for (const uint32_t member : members_) {
        Body& body = *bodies[member];
        const bool slept = !body.awake(), stays_awake = stays_awake_[parents_[member]] != 0;
        if (stays_awake) awake_.push_back(&body);
        if (stays_awake != slept) continue;
        body.set_activity(stays_awake ? Activity::ready : Activity::asleep);
        (stays_awake ? woken_ : asleep_).push_back(&body);
    }
}

void Islands::unite(const SweptPair& pair) {
    if (moves(*pair.a) && moves(*pair.b)) fracture::unite(parents_, pair.a->body->index, pair.b->body->index);
}

void Islands::collect(const SweptPairs& pairs, std::span<const uint32_t> visited, fracture::Threads& threads) {
    const auto count = static_cast<uint32_t>(visited.size());
    std::vector<std::vector<AnyManifold>> parts(threads.chunks(count, min_pairs));
    threads.for_chunks(count, min_pairs, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        for (const uint32_t index : visited.subspan(begin, end - begin)) {
            const SweptPair& pair = pairs.at(index);
            if (pair.contacts && !(is_at_rest(*pair.a) && is_at_rest(*pair.b))) pair.contacts->collect(parts[chunk]);
        }
    });
    manifolds_.clear();
    for (const std::vector<AnyManifold>& part : parts) manifolds_.insert(manifolds_.end(), part.begin(), part.end());
}

} // namespace brittle::physics

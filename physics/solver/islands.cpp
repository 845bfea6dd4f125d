#include "physics/solver/islands.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <functional>
#include <numeric>

#include "fracture/base/union_find.h"
#include "physics/solver/narrow_phase.h"

namespace brittle::physics {

namespace {

const btCollisionObject& object_of(const btBroadphaseProxy* proxy) {
    return *static_cast<const btCollisionObject*>(proxy->m_clientObject);
}
bool moves(const btCollisionObject& object) {
    return !object.isStaticOrKinematicObject();
}
bool sleeps(const btCollisionObject& object) {
    return !object.isActive();
}
bool wants_to_be_awake(const btCollisionObject& object) {
    return object.getActivationState() == ACTIVE_TAG || object.getActivationState() == DISABLE_DEACTIVATION;
}

// One that is awake has come to one that sleeps.
bool wakes(const btBroadphasePair& pair) {
    const btCollisionObject &first = object_of(pair.m_pProxy0), &second = object_of(pair.m_pProxy1);
    return moves(first) && moves(second) && sleeps(first) != sleeps(second);
}

uint32_t index_of(const btCollisionObject& object) {
    return static_cast<uint32_t>(object.getUserIndex());
}
uint32_t rank_of(const btBroadphaseProxy* proxy) {
    return static_cast<const SweptProxy*>(proxy)->rank;
}

// Fewer pairs than this are not worth waking another thread for.
constexpr uint32_t min_pairs = 512;

} // namespace

void Islands::find(const std::vector<std::unique_ptr<BodyRecord>>& bodies, std::span<BodyRecord* const> awake,
                   SweepBroadphase& broadphase, fracture::Threads& threads) {
    const SweptPairs& pairs = broadphase.pairs();
    members_.clear();
    for (const BodyRecord* body : awake)
        if (!sleeps(*body->rigid)) members_.push_back(index_of(*body->rigid));
    touched_.clear();
    for (const int index : pairs.set())
        if (const btBroadphasePair& pair = pairs.at(index); wakes(pair))
            touched_.push_back(rank_of(sleeps(object_of(pair.m_pProxy0)) ? pair.m_pProxy0 : pair.m_pProxy1));
    std::span<const int> looked_at = pairs.set();
    if (!touched_.empty()) looked_at = add_touched(broadphase);

    assert(std::ranges::adjacent_find(members_, std::greater_equal{}) == members_.end()); // each once
    parents_.resize(bodies.size());
    std::iota(parents_.begin(), parents_.end(), 0u);
    lively_.assign(bodies.size(), 0);
    for (const int index : looked_at) unite(pairs.at(index));
    settle(bodies);
    collect(pairs, looked_at, threads);
}

// Who belongs to whom among those that sleep is not kept: it is found again when one of them is touched.
std::span<const int> Islands::add_touched(SweepBroadphase& broadphase) {
    std::ranges::sort(touched_);
    touched_.erase(std::ranges::unique(touched_).begin(), touched_.end());
    const auto passes = [](const btBroadphaseProxy& proxy) {
        return moves(object_of(&proxy)) && sleeps(object_of(&proxy));
    };
    const SweepBroadphase::Reached& reached = broadphase.reach(touched_, passes);
    const auto awake = static_cast<std::ptrdiff_t>(members_.size());
    for (const uint32_t rank : reached.ranks) members_.push_back(index_of(object_of(&broadphase.proxy(rank))));
    std::ranges::sort(members_.begin() + awake, members_.end());
    std::ranges::inplace_merge(members_, members_.begin() + awake);
    const std::vector<int>& set = broadphase.pairs().set();
    with_touched_.resize(set.size() + reached.pairs.size());
    with_touched_.erase(std::ranges::set_union(set, reached.pairs, with_touched_.begin()).out, with_touched_.end());
    return with_touched_;
}

void Islands::settle(const std::vector<std::unique_ptr<BodyRecord>>& bodies) {
    for (const uint32_t member : members_) {
        parents_[member] = fracture::root_of(parents_, member);
        if (wants_to_be_awake(*bodies[member]->rigid)) lively_[parents_[member]] = 1;
    }
    awake_.clear();
    woken_.clear();
    asleep_.clear();
    for (const uint32_t member : members_) {
        BodyRecord& body = *bodies[member];
        const bool slept = sleeps(*body.rigid), lively = lively_[parents_[member]] != 0;
        if (lively) awake_.push_back(&body);
        if (lively == !slept) continue;
        body.rigid->setActivationState(lively ? WANTS_DEACTIVATION : ISLAND_SLEEPING);
        (lively ? woken_ : asleep_).push_back(&body);
    }
}

void Islands::unite(const btBroadphasePair& pair) {
    const btCollisionObject &first = object_of(pair.m_pProxy0), &second = object_of(pair.m_pProxy1);
    if (moves(first) && moves(second)) fracture::unite(parents_, index_of(first), index_of(second));
}

void Islands::collect(const SweptPairs& pairs, std::span<const int> looked_at, fracture::Threads& threads) {
    const auto count = static_cast<uint32_t>(looked_at.size());
    std::vector<std::vector<AnyManifold>> parts(threads.chunks(count, min_pairs));
    threads.for_chunks(count, min_pairs, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        for (const int index : looked_at.subspan(begin, end - begin)) {
            const btBroadphasePair& pair = pairs.at(index);
            const btCollisionObject &first = object_of(pair.m_pProxy0), &second = object_of(pair.m_pProxy1);
            const bool rest = (!moves(first) || sleeps(first)) && (!moves(second) || sleeps(second));
            if (!rest) collect_manifolds(pair, parts[chunk]);
        }
    });
    manifolds_.clear();
    for (const std::vector<AnyManifold>& part : parts) manifolds_.insert(manifolds_.end(), part.begin(), part.end());
}

} // namespace brittle::physics

#include "physics/bullet/islands.h"

#include <utility>

#include "physics/bullet/narrow_phase.h"

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

// Fewer pairs than this are not worth waking another thread for.
constexpr uint32_t least_pairs = 512;

uint32_t count_of(const SweptPairs& pairs, bool all) {
    return static_cast<uint32_t>(all ? static_cast<size_t>(pairs.getNumOverlappingPairs()) : pairs.set().size());
}

// Of all pairs, or those with a box that was set, some.
void for_each(const SweptPairs& pairs, bool all, uint32_t begin, uint32_t end, const auto& visit) {
    const btBroadphasePair* const array = pairs.getOverlappingPairArrayPtr();
    for (uint32_t i = begin; i < end; ++i) visit(array[all ? static_cast<int>(i) : pairs.set()[i]]);
}

} // namespace

void Islands::find(const std::vector<std::unique_ptr<BodyRecord>>& bodies, std::span<BodyRecord* const> awake, const SweptPairs& pairs,
                   fracture::Threads& threads) {
    // Who belongs to whom among those that sleep is not kept: it is found again when one of them wakes.
    bool all = false;
    for_each(pairs, false, 0, count_of(pairs, false), [&](const btBroadphasePair& pair) { all = all || wakes(pair); });
    members_.clear();
    parents_.resize(bodies.size());
    lively_.assign(bodies.size(), 0);
    if (all) {
        for (uint32_t i = 0; i < bodies.size(); ++i)
            if (!bodies[i]->fixed) members_.push_back(i);
    } else {
        for (const BodyRecord* body : awake)
            if (!sleeps(*body->rigid)) members_.push_back(static_cast<uint32_t>(body->rigid->getUserIndex()));
    }
    for (const uint32_t member : members_) parents_[member] = member;
    for_each(pairs, all, 0, count_of(pairs, all), [this](const btBroadphasePair& pair) { unite(pair); });
    settle(bodies);
    collect(pairs, all, threads);
}

void Islands::settle(const std::vector<std::unique_ptr<BodyRecord>>& bodies) {
    for (const uint32_t member : members_) {
        parents_[member] = root(member);
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

uint32_t Islands::root(uint32_t body) {
    while (parents_[body] != body) body = parents_[body] = parents_[parents_[body]];
    return body;
}

// The lowest index becomes the root.
void Islands::unite(const btBroadphasePair& pair) {
    const btCollisionObject &first = object_of(pair.m_pProxy0), &second = object_of(pair.m_pProxy1);
    if (!moves(first) || !moves(second)) return;
    uint32_t a = root(static_cast<uint32_t>(first.getUserIndex())), b = root(static_cast<uint32_t>(second.getUserIndex()));
    if (a > b) std::swap(a, b);
    parents_[b] = a;
}

void Islands::collect(const SweptPairs& pairs, bool all, fracture::Threads& threads) {
    const uint32_t count = count_of(pairs, all);
    std::vector<std::vector<AnyManifold>> parts(threads.chunks(count, least_pairs));
    threads.for_chunks(count, least_pairs, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        for_each(pairs, all, begin, end, [&](const btBroadphasePair& pair) {
            const btCollisionObject &first = object_of(pair.m_pProxy0), &second = object_of(pair.m_pProxy1);
            const bool rest = (!moves(first) || sleeps(first)) && (!moves(second) || sleeps(second));
            if (!rest) collect_manifolds(pair, parts[chunk]);
        });
    });
    manifolds_.clear();
    for (const std::vector<AnyManifold>& part : parts) manifolds_.insert(manifolds_.end(), part.begin(), part.end());
}

} // namespace brittle::physics

#include "physics/bullet/narrow_phase.h"

#include <cstddef>
#include <vector>

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

namespace brittle::physics {

namespace {

// Fewer pairs than this are not worth waking another thread for.
constexpr uint32_t least_pairs = 128;
// Pairs lie anywhere in memory: so many ahead of the one at hand are fetched, with so much of what each keeps, in bytes.
constexpr size_t fetched_ahead = 4, fetched_bytes = 320, cache_line = 64;

btCollisionObject& object_of(const btBroadphaseProxy* proxy) {
    return *static_cast<btCollisionObject*>(proxy->m_clientObject);
}

void fetch(const btBroadphasePair& pair) {
    for (const void* const at : {static_cast<const void*>(pair.m_algorithm), static_cast<const void*>(pair.m_pProxy1->m_clientObject)})
        for (size_t byte = 0; at && byte < fetched_bytes; byte += cache_line)
            __builtin_prefetch(static_cast<const char*>(at) + byte);
}

bool hulls_or_ground(const btCollisionObject& first, const btCollisionObject& second) {
    return !first.getCollisionShape()->isCompound() && !second.getCollisionShape()->isCompound();
}

// Makes the algorithm of a pair that is new, where it can be followed.
void prepare(btBroadphasePair& pair, btCollisionDispatcher& dispatcher) {
    const btCollisionObject &first = object_of(pair.m_pProxy0), &second = object_of(pair.m_pProxy1);
    if (!hulls_or_ground(first, second) || !dispatcher.needsCollision(&first, &second)) return;
    const btCollisionObjectWrapper a(nullptr, first.getCollisionShape(), &first, first.getWorldTransform(), -1, -1);
    const btCollisionObjectWrapper b(nullptr, second.getCollisionShape(), &second, second.getWorldTransform(), -1, -1);
    pair.m_algorithm = dispatcher.findAlgorithm(&a, &b, nullptr, BT_CONTACT_POINT_ALGORITHMS);
    pair.m_internalInfo1 = static_cast<FollowedContacts*>(pair.m_algorithm);
}

// False where the dispatcher is needed.
bool follow(btBroadphasePair& pair, const btDispatcherInfo& info) {
    auto* const contacts = static_cast<FollowedContacts*>(pair.m_internalInfo1);
    if (!contacts) return false;
    const btCollisionObject &first = object_of(pair.m_pProxy0), &second = object_of(pair.m_pProxy1);
    if (!first.isActive() && !second.isActive()) return true;
    return contacts->follow({nullptr, first.getCollisionShape(), &first, first.getWorldTransform(), -1, -1},
                            {nullptr, second.getCollisionShape(), &second, second.getWorldTransform(), -1, -1}, info);
}

} // namespace

void find_contacts(SweptPairs& pairs, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info,
                   fracture::Threads& threads) {
    const std::vector<int>& set = pairs.set();
    btBroadphasePair* const array = pairs.getOverlappingPairArrayPtr();
    const auto count = static_cast<uint32_t>(set.size());
    for (const int index : set)
        if (!array[index].m_algorithm) prepare(array[index], dispatcher);
    std::vector<std::vector<int>> left(threads.chunks(count, least_pairs)); // to be done one by one, in order
    threads.for_chunks(count, least_pairs, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        for (size_t i = begin; i < end; ++i) {
            if (i + fetched_ahead < end) fetch(array[set[i + fetched_ahead]]);
            if (!follow(array[set[i]], info)) left[chunk].push_back(set[i]);
        }
    });
    for (const std::vector<int>& some : left)
        for (const int index : some) dispatcher.getNearCallback()(array[index], dispatcher, info);
}

} // namespace brittle::physics

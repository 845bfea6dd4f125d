#include "physics/solver/narrow_phase.h"

#include <cstddef>
#include <span>
#include <vector>

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

#include "physics/solver/fetch.h"
#include "physics/solver/ground_contact.h"
#include "physics/solver/hull_shape.h"

namespace brittle::physics {

namespace {

// Fewer pairs than this are not worth waking another thread for.
constexpr uint32_t min_pairs = 128;

btCollisionObject& object_of(const btBroadphaseProxy* proxy) {
    return *static_cast<btCollisionObject*>(proxy->m_clientObject);
}

// For who follows pairs in turn, at the first one's next: what each keeps and its second body, as the first is that of many in turn,
// then that body's shape, and its points.
[[gnu::always_inline]] inline void fetch_next(const btBroadphasePair* array, std::span<const int> next) {
    constexpr size_t points_ahead = 2, shape_ahead = 4, pair_ahead = 8, max_kept = 320;
    const auto shape_of = [&](size_t i) { return object_of(array[next[i]].m_pProxy1).getCollisionShape(); };
    if (next.size() > pair_ahead) {
        const btBroadphasePair& pair = array[next[pair_ahead]];
        if (pair.m_algorithm) fetch(pair.m_algorithm, max_kept);
        fetch(pair.m_pProxy1->m_clientObject, max_kept);
    }
    if (next.size() > shape_ahead) fetch(shape_of(shape_ahead), sizeof(HullShape));
    if (next.size() <= points_ahead || shape_of(points_ahead)->getShapeType() != CONVEX_HULL_SHAPE_PROXYTYPE) return;
    const std::span<const btScalar> points = static_cast<const HullShape*>(shape_of(points_ahead))->groups();
    fetch(points.data(), points.size_bytes());
}

// The bodies of a pair, and what takes their contacts. There a hull of a compound has its index, and the only hull of a body
// -1, which Bullet leaves out.
struct Meeting {
    const btCollisionObject &a, &b;
    const btCollisionObjectWrapper first{nullptr, a.getCollisionShape(), &a, a.getWorldTransform(), -1, -1};
    const btCollisionObjectWrapper second{nullptr, b.getCollisionShape(), &b, b.getWorldTransform(), -1, -1};
    btManifoldResult contacts{&first, &second};

    explicit Meeting(const btBroadphasePair& pair) : a(object_of(pair.m_pProxy0)), b(object_of(pair.m_pProxy1)) {
        contacts.setShapeIdentifiersA(-1, -1);
        contacts.setShapeIdentifiersB(-1, -1);
    }
};

bool both_compound(const btCollisionObject& first, const btCollisionObject& second) {
    return first.getCollisionShape()->isCompound() && second.getCollisionShape()->isCompound();
}

bool is_ground(const btCollisionObject& object) {
    return object.getCollisionShape()->getShapeType() == STATIC_PLANE_PROXYTYPE;
}

bool is_with_ground(const btBroadphasePair& pair) {
    return is_ground(object_of(pair.m_pProxy0)) || is_ground(object_of(pair.m_pProxy1));
}

// The ground's box holds all others: nothing is kept of a hull that has not come near it.
bool is_far_above_ground(const btBroadphasePair& pair, btScalar seconds) {
    const bool ground_first = is_ground(object_of(pair.m_pProxy0));
    const btCollisionObject& ground = object_of(ground_first ? pair.m_pProxy0 : pair.m_pProxy1);
    const auto& body = static_cast<const btRigidBody&>(object_of(ground_first ? pair.m_pProxy1 : pair.m_pProxy0));
    return is_ground(ground) && body.getCollisionShape()->getShapeType() == CONVEX_HULL_SHAPE_PROXYTYPE
           && GroundContacts::is_out_of_reach(body, ground, seconds);
}

// Makes the algorithm of a pair.
void find_algorithm(btBroadphasePair& pair, const Meeting& met, btCollisionDispatcher& dispatcher) {
    pair.m_algorithm = dispatcher.findAlgorithm(&met.first, &met.second, nullptr, BT_CONTACT_POINT_ALGORITHMS);
    if (!both_compound(met.a, met.b)) pair.m_internalInfo1 = static_cast<FollowedContacts*>(pair.m_algorithm);
}

// Of a pair that is new, where it can be followed.
void prepare(btBroadphasePair& pair, btCollisionDispatcher& dispatcher) {
    const Meeting met(pair);
    if (!both_compound(met.a, met.b) && dispatcher.needsCollision(&met.a, &met.b))
        find_algorithm(pair, met, dispatcher);
}

// False where the dispatcher is needed.
bool follow(btBroadphasePair& pair, const btDispatcherInfo& info) {
    auto* const followed = static_cast<FollowedContacts*>(pair.m_internalInfo1);
    if (!followed) return !pair.m_algorithm && is_far_above_ground(pair, info.m_timeStep);
    Meeting met(pair);
    if (!met.a.isActive() && !met.b.isActive()) return true;
    return followed->follow(met.first, met.second, info, met.contacts);
}

void process(btBroadphasePair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info) {
    Meeting met(pair);
    if (!dispatcher.needsCollision(&met.a, &met.b)) return;
    if (!pair.m_algorithm) find_algorithm(pair, met, dispatcher);
    pair.m_algorithm->processCollision(&met.first, &met.second, info, &met.contacts);
}

// Valid until the thread's next call.
btManifoldArray& manifolds_of(btCollisionAlgorithm& algorithm) {
    thread_local btManifoldArray manifolds;
    manifolds.resize(0);
    algorithm.getAllContactManifolds(manifolds);
    return manifolds;
}

void add_manifolds(btCollisionAlgorithm& algorithm, std::vector<AnyManifold>& to) {
    const btManifoldArray& manifolds = manifolds_of(algorithm);
    for (int i = 0; i < manifolds.size(); ++i) to.emplace_back(*manifolds[i]);
}

} // namespace

void FollowedContacts::refresh(btManifoldResult& result) {
    const btManifoldArray& manifolds = manifolds_of(*this);
    for (int i = 0; i < manifolds.size(); ++i) {
        result.setPersistentManifold(manifolds[i]);
        result.refreshContactPoints();
    }
    result.setPersistentManifold(nullptr);
}

void FollowedContacts::collect(std::vector<AnyManifold>& to) {
    add_manifolds(*this, to);
}

void collect_manifolds(const btBroadphasePair& pair, std::vector<AnyManifold>& to) {
    if (auto* const followed = static_cast<FollowedContacts*>(pair.m_internalInfo1))
        followed->collect(to);
    else if (pair.m_algorithm)
        add_manifolds(*pair.m_algorithm, to);
}

void find_contacts(SweptPairs& pairs, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info,
                   fracture::Threads& threads) {
    const std::vector<int>& set = pairs.set();
    btBroadphasePair* const array = pairs.getOverlappingPairArrayPtr();
    const auto count = static_cast<uint32_t>(set.size());
    for (const int index : set)
        if (!array[index].m_algorithm && !is_with_ground(array[index])) prepare(array[index], dispatcher);
    std::vector<std::vector<int>> left(threads.chunks(count, min_pairs)); // to be done one by one, in order
    threads.for_chunks(count, min_pairs, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        for (size_t i = begin; i < end; ++i) {
            fetch_next(array, std::span(set).subspan(i, end - i));
            if (!follow(array[set[i]], info)) left[chunk].push_back(set[i]);
        }
    });
    for (const std::vector<int>& some : left)
        for (const int index : some) process(array[index], dispatcher, info);
}

} // namespace brittle::physics

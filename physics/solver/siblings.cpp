#include "physics/solver/siblings.h"

#include <algorithm>
#include <map>

#include "physics/solver/convert.h"

namespace brittle::physics {

namespace {

// Velocities that differ by less than this, in m/s, are those of one body: what rounding leaves of them.
constexpr float same_speed = 1e-3f;

bool move_as_one(const btRigidBody& a, const btRigidBody& b) {
    const btVector3 arm = b.getCenterOfMassPosition() - a.getCenterOfMassPosition();
    const btVector3 turned = b.getAngularVelocity() - a.getAngularVelocity();
    const btVector3 apart = a.getVelocityInLocalPoint(arm) - b.getLinearVelocity();
    return apart.length() < same_speed * bullet_units && turned.length() * arm.length() < same_speed * bullet_units;
}

const btCollisionObject& object_of(const btBroadphaseProxy* proxy) {
    return *static_cast<const btCollisionObject*>(proxy->m_clientObject);
}

} // namespace

void Siblings::remove(const btRigidBody& body) {
    if (body.getUserIndex2() != none) std::erase(bodies_, &body);
}

void Siblings::check(const SweptPairs& pairs, std::optional<btScalar> ground_height) {
    if (bodies_.empty()) return;
    apart_.clear();
    std::map<int, const btRigidBody*> firsts;
    const btRigidBody* first = nullptr; // of the number that came last, as most have that of the one before
    uint32_t min_rank = UINT32_MAX;
    for (const btRigidBody* body : bodies_) {
        const int number = body->getUserIndex2();
        const auto& proxy = static_cast<const SweptProxy&>(*body->getBroadphaseProxy());
        if (!first || first->getUserIndex2() != number) first = firsts.try_emplace(number, body).first->second;
        const bool low = ground_height && proxy.m_aabbMin.y() <= *ground_height;
        if (low || !move_as_one(*first, *body)) apart_.push_back(number);
        min_rank = std::min(min_rank, proxy.rank);
    }
    const btBroadphasePair* const array = pairs.getOverlappingPairArrayPtr();
    for (const int index : pairs.set()) {
        if (pairs.higher_rank(index) < min_rank) continue; // both were there
        const btCollisionObject &a = object_of(array[index].m_pProxy0), &b = object_of(array[index].m_pProxy1);
        const bool ground = a.getUserIndex() < 0 || b.getUserIndex() < 0; // its box holds all others
        if (ground || a.getUserIndex2() == b.getUserIndex2()) continue;
        apart_.insert(apart_.end(), {a.getUserIndex2(), b.getUserIndex2()});
    }
    std::ranges::sort(apart_);
    std::erase_if(bodies_, [this](btRigidBody* body) {
        if (!std::ranges::binary_search(apart_, body->getUserIndex2())) return false;
        body->setUserIndex2(none);
        return true;
    });
}

void Siblings::forget() {
    for (btRigidBody* body : bodies_) body->setUserIndex2(none);
    bodies_.clear();
}

} // namespace brittle::physics

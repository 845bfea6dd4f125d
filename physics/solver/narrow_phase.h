// Contacts of all pairs of boxes that overlap, on several threads.
//
// Most pairs were there in the last step, and what is found of them changes only what they keep themselves: those are
// followed side by side. What asks for something of the dispatcher's, which is not thread-safe, comes one by one
// in the order of pairs: algorithms of new pairs before; first contacts and last ones, algorithms of hulls that have come down to
// the ground and their first contacts, and pairs of two compounds, behind. So nothing depends on the number of threads.
#pragma once

#include <new>
#include <utility>
#include <vector>

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <btBulletDynamicsCommon.h>

#include "fracture/base/parallel.h"
#include "physics/solver/any_manifold.h"
#include "physics/solver/sweep_broadphase.h"

namespace brittle::physics {

// An algorithm for pairs of bodies that can bring its contacts up to date beside others.
class FollowedContacts : public btCollisionAlgorithm {
  public:
    using btCollisionAlgorithm::btCollisionAlgorithm;

    // Does what processCollision() does, without the dispatcher and what else pairs share. False where that is needed: then
    // processCollision() must follow.
    virtual bool follow(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second,
                        const btDispatcherInfo& info, btManifoldResult& result) = 0;
    // Contacts that it has follow the bodies, and those that have come apart go. Of a hull of a compound, before others are
    // looked for.
    virtual void refresh(btManifoldResult& result);
    // Adds what it has.
    virtual void collect(std::vector<AnyManifold>& to);
};

// Of any algorithm of the dispatcher's; adds its manifolds.
void collect_manifolds(const btBroadphasePair& pair, std::vector<AnyManifold>& to);

// Makes an Algorithm(info, first, second) of two objects, the other way round where they come swapped.
template<class Algorithm>
struct CreateContacts final : btCollisionAlgorithmCreateFunc {
    explicit CreateContacts(bool swapped) { m_swapped = swapped; }

    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* first,
                                                   const btCollisionObjectWrapper* second) override {
        if (m_swapped) std::swap(first, second);
        void* place = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(Algorithm));
        return new (place) Algorithm(info, first->getCollisionObject(), second->getCollisionObject());
    }
};

// Of the pairs of which a box was set when they were last found.
void find_contacts(SweptPairs& pairs, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info,
                   fracture::Threads& threads);

} // namespace brittle::physics

#include "physics/bullet/ground_contact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <btBulletDynamicsCommon.h>

namespace brittle::physics {

namespace {

// Corners nearer to the ground than this part of the hull's radius count as touching, so that a body at rest
// keeps its contacts while it trembles. Bullet's own value.
constexpr btScalar resting_distance = 0.02f;

struct Corner {
    btVector3 position; // of the point on the hull, margin included
    btScalar distance;  // above the ground
    int index;
};

// The four of the corners that carry a body best, in place: the deepest, the one farthest from it, the one
// farthest from the line through both, and the one farthest on that line's other side.
void keep_best_four(std::vector<Corner>& corners) {
    if (corners.size() <= 4) return;
    const auto take = [&](size_t place, auto&& score) {
        const auto begin = corners.begin() + static_cast<std::ptrdiff_t>(place);
        const auto best = std::max_element(
            begin, corners.end(), [&](const Corner& a, const Corner& b) { return score(a) < score(b); });
        std::iter_swap(begin, best);
    };
    take(0, [](const Corner& c) { return -c.distance; });
    const btVector3 first = corners[0].position;
    take(1, [&](const Corner& c) { return (c.position - first).length2(); });
    const btVector3 line = corners[1].position - first;
    const auto side = [&](const Corner& c) { return line.cross(c.position - first).y(); };
    take(2, [&](const Corner& c) { return std::abs(side(c)); });
    const btScalar sign = side(corners[2]) > 0.0f ? -1.0f : 1.0f;
    take(3, [&](const Corner& c) { return sign * side(c); });
    corners.resize(4);
}

class HullOnPlane final : public btCollisionAlgorithm {
  public:
    HullOnPlane(const btCollisionAlgorithmConstructionInfo& info, const btCollisionObject* hull,
                const btCollisionObject* plane)
        : btCollisionAlgorithm(info), manifold_(m_dispatcher->getNewManifold(hull, plane)) {}
    ~HullOnPlane() override { m_dispatcher->releaseManifold(manifold_); }

    void processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                          const btDispatcherInfo& info, btManifoldResult* result) override {
        result->setPersistentManifold(manifold_);
        const bool hull_first = first->getCollisionObject() == manifold_->getBody0();
        const btCollisionObjectWrapper& hull = *(hull_first ? first : second);
        find_corners(hull, *(hull_first ? second : first)->getCollisionObject(), info.m_timeStep);
        keep_best_four(corners_);
        replace_contacts(hull.m_index);
    }

    // Only asked for objects that sweep; ours do not.
    btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                   btManifoldResult*) override {
        return 1.0f;
    }
    void getAllContactManifolds(btManifoldArray& manifolds) override { manifolds.push_back(manifold_); }

  private:
    // The hull is the body's own or, with a frame of its own, one of a compound's.
    void find_corners(const btCollisionObjectWrapper& hull, const btCollisionObject& plane,
                      btScalar seconds) {
        corners_.clear();
        const auto& shape = static_cast<const btConvexHullShape&>(*hull.getCollisionShape());
        const btScalar height =
            static_cast<const btStaticPlaneShape&>(*plane.getCollisionShape()).getPlaneConstant()
            + plane.getWorldTransform().getOrigin().y();
        const btRigidBody* body = btRigidBody::upcast(hull.getCollisionObject());
        const btVector3 velocity = body->getLinearVelocity() + body->getGravity() * seconds;
        const btTransform& frame = hull.getWorldTransform();
        const btVector3 origin = frame.getOrigin() - body->getCenterOfMassPosition();
        const btScalar resting = resting_distance * shape.getAngularMotionDisc();
        for (int i = 0; i < shape.getNumPoints(); ++i) {
            const btVector3 arm =
                frame.getBasis() * shape.getUnscaledPoints()[i] - btVector3(0, shape.getMargin(), 0);
            const btVector3 position = frame.getOrigin() + arm;
            const btScalar approach = -(velocity + body->getAngularVelocity().cross(origin + arm)).y();
            const btScalar distance = position.y() - height;
            if (distance < resting + std::max<btScalar>(approach, 0.0f) * seconds)
                corners_.push_back({position, distance, i});
        }
    }

    // A corner that was a contact before keeps the impulses that the solver starts from.
    void replace_contacts(int part) {
        const btCollisionObject* hull = manifold_->getBody0();
        const btCollisionObject* plane = manifold_->getBody1();
        std::array<btManifoldPoint, MANIFOLD_CACHE_SIZE> old;
        const int old_count = manifold_->getNumContacts();
        for (int i = 0; i < old_count; ++i) old[static_cast<size_t>(i)] = manifold_->getContactPoint(i);
        manifold_->clearManifold();
        for (const Corner& corner : corners_) {
            const btVector3 below = corner.position - btVector3(0, corner.distance, 0);
            btManifoldPoint point(hull->getWorldTransform().invXform(corner.position),
                                  plane->getWorldTransform().invXform(below), btVector3(0, 1, 0),
                                  corner.distance);
            point.m_positionWorldOnA = corner.position;
            point.m_positionWorldOnB = below;
            point.m_combinedFriction = btManifoldResult::calculateCombinedFriction(hull, plane);
            point.m_combinedRestitution = btManifoldResult::calculateCombinedRestitution(hull, plane);
            point.m_index0 = corner.index;
            point.m_partId0 = part;
            for (int i = 0; i < old_count; ++i) {
                const btManifoldPoint& before = old[static_cast<size_t>(i)];
                if (before.m_index0 != corner.index) continue;
                point.m_appliedImpulse = before.m_appliedImpulse;
                point.m_appliedImpulseLateral1 = before.m_appliedImpulseLateral1;
                point.m_appliedImpulseLateral2 = before.m_appliedImpulseLateral2;
                point.m_lifeTime = before.m_lifeTime + 1;
            }
            manifold_->addManifoldPoint(point);
        }
    }

    btPersistentManifold* manifold_;
    std::vector<Corner> corners_; // scratch of one call
};

struct CreateHullOnPlane final : btCollisionAlgorithmCreateFunc {
    explicit CreateHullOnPlane(bool plane_first) { m_swapped = plane_first; }

    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* first,
                                                   const btCollisionObjectWrapper* second) override {
        void* place = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(HullOnPlane));
        return new (place) HullOnPlane(info, (m_swapped ? second : first)->getCollisionObject(),
                                       (m_swapped ? first : second)->getCollisionObject());
    }
};

} // namespace

struct GroundContacts::Impl {
    CreateHullOnPlane hull_first{false};
    CreateHullOnPlane plane_first{true};
};

GroundContacts::GroundContacts(btCollisionDispatcher& dispatcher) : impl_(std::make_unique<Impl>()) {
    dispatcher.registerCollisionCreateFunc(CONVEX_HULL_SHAPE_PROXYTYPE, STATIC_PLANE_PROXYTYPE,
                                           &impl_->hull_first);
    dispatcher.registerCollisionCreateFunc(STATIC_PLANE_PROXYTYPE, CONVEX_HULL_SHAPE_PROXYTYPE,
                                           &impl_->plane_first);
}
GroundContacts::~GroundContacts() = default;

int GroundContacts::pair_size() {
    return static_cast<int>(sizeof(HullOnPlane));
}

} // namespace brittle::physics

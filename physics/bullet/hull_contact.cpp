#include "physics/bullet/hull_contact.h"

#include <algorithm>
#include <cmath>

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <btBulletDynamicsCommon.h>

#include "physics/bullet/hull_distance.h"
#include "physics/bullet/hull_shape.h"

namespace brittle::physics {

namespace {

// Hulls that touch are looked at again when they have moved against each other by this part of the distance
// at which contacts begin: a two-hundredth of the smaller one's radius. More saves time while a heap settles;
// much more and contacts lag behind corners that tilt.
constexpr btScalar still_part = 0.25f;
// A hull with a radius so many times that of the other is a floor or a wall to it: the smaller one must not sink into it
// corner by corner. Among pieces of like size that costs more than it brings.
constexpr btScalar larger_factor = 3.0f;
// Contacts of hulls that move stay up to this part of the smaller one's radius. Bullet takes points that are nearer to each
// other for one and the same.
constexpr btScalar kept_part = 0.2f;
// Contacts begin at this part of the smaller one's radius, as in Bullet.
constexpr btScalar near_part = 0.02f;

const HullShape& hull_of(const btCollisionObjectWrapper& object) {
    return static_cast<const HullShape&>(*object.getCollisionShape());
}

// The farthest that the hull, without margin, reaches in a direction of the world.
btScalar reach(const HullShape& hull, const btTransform& frame, const btVector3& direction) {
    return hull.reach(direction * frame.getBasis()) + direction.dot(frame.getOrigin());
}

// Bullet hands over its own objects as const; they are the world's.
MovingHull moving(const btCollisionObjectWrapper& object) {
    auto* body = const_cast<btRigidBody*>(btRigidBody::upcast(object.getCollisionObject()));
    return {&hull_of(object), body->getWorldTransform().inverseTimes(object.getWorldTransform()), body};
}

class HullPair final : public btCollisionAlgorithm {
  public:
    HullPair(const btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* first,
             const btCollisionObjectWrapper* second, std::vector<Meeting>& meetings)
        : btCollisionAlgorithm(info), meetings_(meetings), manifold_(info.m_manifold), own_(!info.m_manifold) {
        const HullShape& a = hull_of(*first);
        const HullShape& b = hull_of(*second);
        const btScalar radius_a = a.radius(), radius_b = b.radius();
        first_moves_ = radius_a < radius_b;
        radius_ = std::min(radius_a, radius_b);
        margins_ = a.getMargin() + b.getMargin();
        near_ = contact_distance(a, b);
        still_ = still_part * near_;
        bearable_ = bearable_depth(a, b);
        turn_a_ = a.getAngularMotionDisc(), turn_b_ = b.getAngularMotionDisc();
        on_larger_ = std::max(radius_a, radius_b) > larger_factor * radius_;
        axis_ = (first->getWorldTransform().getOrigin() - second->getWorldTransform().getOrigin())
                * first->getWorldTransform().getBasis();
        if (axis_.fuzzyZero()) axis_ = {0, 1, 0};
        axis_.normalize();
    }
    ~HullPair() override { release(); }

    void processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                          const btDispatcherInfo& info, btManifoldResult* result) override {
        const btTransform& a = first->getWorldTransform();
        const btTransform& b = second->getWorldTransform();
        const btTransform relative = first_moves_ ? b.inverseTimes(a) : a.inverseTimes(b);
        if (manifold_ && own_) keep_contacts(*first, *second, info.m_timeStep);
        const btScalar moved = moved_since(relative);
        if (!(moved < free_)) {
            seen_ = relative;
            free_ = look(*first, *second, *result);
            note_meeting(*first, *second, std::max<btScalar>(free_, 0.0f), info.m_timeStep);
        } else {
            note_meeting(*first, *second, free_ - moved, info.m_timeStep);
        }
        if (!own_ || !manifold_) return;
        result->setPersistentManifold(manifold_);
        result->refreshContactPoints();
        if (manifold_->getNumContacts() == 0)
            release();
        else
            add_corners(*first, *second, info.m_timeStep);
    }

    // Only asked for objects that sweep; ours do not.
    btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                   btManifoldResult*) override {
        return 1.0f;
    }
    void getAllContactManifolds(btManifoldArray& manifolds) override {
        if (manifold_ && own_) manifolds.push_back(manifold_);
    }

  private:
    // How far any point of the smaller hull can have moved in the frame of the other one.
    [[nodiscard]] btScalar moved_since(const btTransform& relative) const {
        btScalar turned =
            0.0f; // the square of the Frobenius norm bounds what the difference does to a vector
        for (int row = 0; row < 3; ++row)
            turned += (relative.getBasis()[row] - seen_.getBasis()[row]).length2();
        return (relative.getOrigin() - seen_.getOrigin()).length() + std::sqrt(turned) * radius_;
    }

    // A hull that rocks lifts one corner while it comes down on another. The lifted one stays a contact, made ahead, as far
    // as a step may take it: without, each corner sinks before it is found again.
    void keep_contacts(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second,
                       btScalar seconds) {
        if (!on_larger_) return;
        const btScalar way = closing_bound(moving(first), moving(second)) * seconds;
        manifold_->setContactBreakingThreshold(std::min(near_ + way, std::max(near_, kept_part * radius_)));
    }

    // One contact turns a fast body, and its next corner comes down within the same step. The corners of the smaller hull
    // that may, beyond those that are contacts, are contacts ahead of time: the ones farthest from all others first.
    void add_corners(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second, btScalar seconds) {
        if (!on_larger_) return;
        const btManifoldPoint& known = manifold_->getContactPoint(0);
        const btScalar way = closing_bound(moving(first), moving(second), known.m_normalWorldOnB) * seconds;
        if (way <= bearable_) return;
        const btCollisionObjectWrapper& smaller = first_moves_ ? first : second;
        const btConvexHullShape& hull = hull_of(smaller);
        while (manifold_->getNumContacts() < MANIFOLD_CACHE_SIZE) {
            btScalar farthest = kept_part * kept_part * radius_ * radius_;
            btVector3 corner;
            bool is = false;
            for (int i = 0; i < hull.getNumPoints(); ++i) {
                const btVector3 point = smaller.getWorldTransform() * hull.getUnscaledPoints()[i];
                if (height_over(known, point) > way) continue;
                const btScalar apart = nearest_contact(point);
                if (apart > farthest) farthest = apart, corner = point, is = true;
            }
            if (!is || !add_corner(first, second, corner, way)) return;
        }
    }

    // Of a corner of the smaller hull over the plane of a contact, margins taken off.
    [[nodiscard]] btScalar height_over(const btManifoldPoint& contact, const btVector3& corner) const {
        return (first_moves_ ? (corner - contact.getPositionWorldOnB()).dot(contact.m_normalWorldOnB)
                             : (contact.getPositionWorldOnA() - corner).dot(contact.m_normalWorldOnB))
               - margins_;
    }

    // The square of the distance from a point to the nearest contact, on the smaller hull.
    [[nodiscard]] btScalar nearest_contact(const btVector3& point) const {
        btScalar nearest = BT_LARGE_FLOAT;
        for (int i = 0; i < manifold_->getNumContacts(); ++i) {
            const btManifoldPoint& contact = manifold_->getContactPoint(i);
            const btVector3& at = first_moves_ ? contact.getPositionWorldOnA() : contact.getPositionWorldOnB();
            nearest = std::min(nearest, (at - point).length2());
        }
        return nearest;
    }

    // The contact of a corner of the smaller hull with the other one; false if that is farther than near or overlaps.
    bool add_corner(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second,
                    const btVector3& corner, btScalar near) {
        HullShape tip;
        tip.addPoint({0, 0, 0}, false);
        tip.setMargin(hull_of(first_moves_ ? first : second).getMargin());
        tip.finish();
        const btTransform at(btMatrix3x3::getIdentity(), corner);
        const btTransform& a = first_moves_ ? at : first.getWorldTransform();
        const btTransform& b = first_moves_ ? second.getWorldTransform() : at;
        const HullShape& hull_b = first_moves_ ? hull_of(second) : tip;
        NearCorners nowhere;
        const HullDistance found = hull_distance(first_moves_ ? tip : hull_of(first), hull_b, a.inverseTimes(b),
                                                 margins_ + near, nowhere);
        const btScalar distance = found.distance - margins_;
        if (found.distance <= 0.0f || distance > near) return false;
        const btVector3 on_second = a * (found.point + found.normal * hull_b.getMargin());
        // Over the face of the known contact the normal is the face's: that of a search from a point so far off is rounded.
        const btManifoldPoint& known = manifold_->getContactPoint(0);
        const bool over_face = std::abs(distance - height_over(known, corner)) < near_;
        const btVector3 normal = over_face ? known.m_normalWorldOnB : a.getBasis() * found.normal;
        const btVector3 on_first = on_second + normal * distance;
        btManifoldPoint point(first.getCollisionObject()->getWorldTransform().invXform(on_first),
                              second.getCollisionObject()->getWorldTransform().invXform(on_second), normal, distance);
        point.m_positionWorldOnA = on_first;
        point.m_positionWorldOnB = on_second;
        point.m_combinedFriction =
            btManifoldResult::calculateCombinedFriction(first.getCollisionObject(), second.getCollisionObject());
        point.m_combinedRestitution =
            btManifoldResult::calculateCombinedRestitution(first.getCollisionObject(), second.getCollisionObject());
        point.m_partId0 = first.m_partId, point.m_partId1 = second.m_partId;
        point.m_index0 = first.m_index, point.m_index1 = second.m_index;
        manifold_->addManifoldPoint(point);
        return true;
    }

    // Two bodies of one hull each, apart by at least this, that may be deep in each other when the step ends.
    void note_meeting(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second, btScalar apart,
                      btScalar seconds) {
        if (first.m_parent || second.m_parent || (manifold_ && manifold_->getNumContacts() > 0)) return;
        const auto& a = *btRigidBody::upcast(first.getCollisionObject());
        const auto& b = *btRigidBody::upcast(second.getCollisionObject());
        const btScalar bound = (a.getLinearVelocity() - b.getLinearVelocity()).length()
                               + a.getAngularVelocity().length() * turn_a_ + b.getAngularVelocity().length() * turn_b_;
        if (bound * seconds <= apart + bearable_) return;
        const Meeting meeting{moving(first), moving(second), near_};
        // The direction that separated them last often tells as much as a search would.
        const btVector3 direction = first.getWorldTransform().getBasis() * axis_;
        if (closing_bound(meeting.first, meeting.second, direction) * seconds
            > gap(first, second, direction) - near_ + bearable_)
            meetings_.push_back(meeting);
    }

    // The gap between the hulls in a direction from the second to the first: what separates them at least.
    [[nodiscard]] btScalar gap(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second,
                               const btVector3& direction) const {
        return -reach(hull_of(first), first.getWorldTransform(), -direction)
               - reach(hull_of(second), second.getWorldTransform(), direction) - margins_;
    }

    // Finds a contact, if there is one, and says by how much the hulls may move until it must be called
    // again.
    btScalar look(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second,
                  btManifoldResult& result) {
        const btTransform& a = first.getWorldTransform();
        const btScalar known = gap(first, second, a.getBasis() * axis_) - near_;
        if (known > 0.0f) return known;

        const int before = manifold_ ? manifold_->getNumContacts() : 0;
        const HullShape& hull_b = hull_of(second);
        const HullDistance found =
            hull_distance(hull_of(first), hull_b, a.inverseTimes(second.getWorldTransform()), margins_ + near_, corners_);
        axis_ = found.normal;
        const btScalar distance = found.distance - margins_;
        if (distance > near_) return distance - near_;
        if (!manifold_)
            manifold_ = m_dispatcher->getNewManifold(first.getCollisionObject(), second.getCollisionObject());
        result.setPersistentManifold(manifold_);
        result.addContactPoint(a.getBasis() * found.normal, a * (found.point + found.normal * hull_b.getMargin()), distance);
        return manifold_->getNumContacts() == before ? still_ : -1.0f;
    }

    void release() {
        if (own_ && manifold_) m_dispatcher->releaseManifold(manifold_);
        manifold_ = own_ ? nullptr : manifold_;
    }

    std::vector<Meeting>& meetings_;
    btPersistentManifold* manifold_; // of our own: only while there are contacts
    bool own_;
    bool first_moves_;      // what is looked at as moving: the smaller one
    btScalar radius_;       // of it
    btScalar margins_;      // of both
    btScalar near_;         // closer is a contact
    btScalar bearable_;     // depth
    btScalar turn_a_, turn_b_; // how far each reaches from its centre
    bool on_larger_;        // one of them is much larger
    btScalar still_;        // movement that contacts bear
    btScalar free_ = -1.0f; // movement from seen_ that needs no look; negative: always look
    btTransform seen_ = btTransform::getIdentity(); // of the smaller in the other's frame
    NearCorners corners_;
    btVector3 axis_; // unit, from second to first, in the first's frame: separated them last
};

struct CreateHullPair final : btCollisionAlgorithmCreateFunc {
    std::vector<Meeting> meetings;

    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* first,
                                                   const btCollisionObjectWrapper* second) override {
        void* place = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(HullPair));
        return new (place) HullPair(info, first, second, meetings);
    }
};

} // namespace

btScalar contact_distance(const btConvexHullShape& first, const btConvexHullShape& second) {
    return std::min(first.getContactBreakingThreshold(near_part), second.getContactBreakingThreshold(near_part));
}

struct HullContacts::Impl {
    CreateHullPair create;
};

HullContacts::HullContacts(btCollisionDispatcher& dispatcher) : impl_(std::make_unique<Impl>()) {
    dispatcher.registerCollisionCreateFunc(CONVEX_HULL_SHAPE_PROXYTYPE, CONVEX_HULL_SHAPE_PROXYTYPE,
                                           &impl_->create);
}
HullContacts::~HullContacts() = default;

std::vector<Meeting>& HullContacts::meetings() {
    return impl_->create.meetings;
}

int HullContacts::pair_size() {
    return static_cast<int>(sizeof(HullPair));
}

} // namespace brittle::physics

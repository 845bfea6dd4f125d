#include "physics/solver/hull_contact.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <btBulletDynamicsCommon.h>

#include "physics/solver/first_touch.h"
#include "physics/solver/hull_distance.h"
#include "physics/solver/hull_shape.h"
#include "physics/solver/narrow_phase.h"
#include "physics/solver/siblings.h"
#include "physics/solver/step_stops.h"

namespace brittle::physics {

namespace {

// Hulls that touch are looked at again when they have moved against each other by this part of the distance
// at which contacts begin: a two-hundredth of the smaller one's radius. More saves time while a heap settles;
// much more and contacts lag behind corners that tilt.
constexpr btScalar still_part = 0.25f;
// Pieces of one cut that fly as one are looked at when they have moved against each other by this part of the smaller one's
// radius: more than rounding moves them.
constexpr btScalar together_part = 1e-4f;
// Contacts of what is much lighter are made ahead when the heavier body moves in a step by this part of the smaller one's radius.
// Not while both fly on together, and move against each other by less than the second part of it.
constexpr btScalar passing_part = 0.5f, apart_part = 0.05f;
// Contacts of two of like mass when they come closer by this part of the thinner one's thickness in a step.
constexpr btScalar sinking_part = 0.25f;
// Contacts begin at this part of the smaller one's radius, as in Bullet.
constexpr btScalar near_part = 0.02f;

// Corners of the smaller one that are higher above it than this part of the thickness are not its lower ones.
constexpr btScalar low_part = 0.5f;
// Contacts on it that are nearer to each other than this part of the smaller one's radius count as one.
constexpr btScalar same_part = 0.2f;

// Contacts whose normals have less than this cosine between them are not of the same two surfaces.
constexpr btScalar same_way = 0.9f;
// Hulls that meet on straight ways do so after a few advances.
constexpr int max_advances = 16;

const HullShape& hull_of(const btCollisionObjectWrapper& object) {
    return static_cast<const HullShape&>(*object.getCollisionShape());
}

// The farthest that the hull, without margin, reaches in a direction of the world.
btScalar reach(const HullShape& hull, const btTransform& frame, const btVector3& direction) {
    return hull.reach(direction * frame.getBasis()) + direction.dot(frame.getOrigin());
}

bool is_debris(const btCollisionObjectWrapper& object) {
    return object.getCollisionObject()->getBroadphaseHandle()->m_collisionFilterGroup
           == btBroadphaseProxy::DebrisFilter;
}

HullShape point_hull() {
    HullShape point;
    point.addPoint({0, 0, 0}, false);
    point.setMargin(0.0f);
    point.finish();
    return point;
}

// Whether both move, and the first does not stop the second on its way (step_stops.h): it is pushed instead, by a contact that
// is made ahead.
bool much_lighter(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second) {
    const btScalar light = btRigidBody::upcast(first.getCollisionObject())->getInvMass();
    const btScalar heavy = btRigidBody::upcast(second.getCollisionObject())->getInvMass();
    return heavy > 0.0f && heavy < StepStops::light_part * light;
}

class HullPair final : public FollowedContacts {
  public:
    HullPair(const btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* first,
             const btCollisionObjectWrapper* second)
        : FollowedContacts(info), manifold_(info.m_manifold), own_(!info.m_manifold) {
        const HullShape& a = hull_of(*first);
        const HullShape& b = hull_of(*second);
        const btScalar radius_a = a.radius(), radius_b = b.radius();
        in_compound_ = first->m_index >= 0;
        first_moves_ = radius_a < radius_b;
        radius_ = std::min(radius_a, radius_b);
        margins_ = a.getMargin() + b.getMargin();
        near_ = std::min(a.getContactBreakingThreshold(near_part), b.getContactBreakingThreshold(near_part));
        still_ = still_part * near_;
        looks_ahead_ = is_debris(*first) || is_debris(*second);
        pushed_by_first_ = much_lighter(*second, *first);
        pushed_by_second_ = much_lighter(*first, *second);
        alike_ = !first->getCollisionObject()->isStaticObject() && !second->getCollisionObject()->isStaticObject()
                 && !looks_ahead_ && !pushed_by_first_ && !pushed_by_second_;
        thinner_ = std::min(thickness(a), thickness(b));
        on_larger_ = std::max(radius_a, radius_b) > StepStops::larger_factor * radius_;
        axis_ = (first->getWorldTransform().getOrigin() - second->getWorldTransform().getOrigin())
                * first->getWorldTransform().getBasis();
        if (axis_.fuzzyZero()) axis_ = {0, 1, 0};
        axis_.normalize();
        if (!Siblings::fly_as_one(*first->getCollisionObject(), *second->getCollisionObject())) return;
        seen_ = relative_of(*first, *second);
        free_ = together_part * radius_;
    }
    ~HullPair() override { release(); }

    void processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                          const btDispatcherInfo& info, btManifoldResult* result) override {
        (void)update(*first, *second, info, *result, true);
    }
    bool follow(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second,
                const btDispatcherInfo& info, btManifoldResult& result) override {
        return update(first, second, info, result, false);
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
    // What following found when the manifold must come or go. A compound's hull goes on from there, as if it had been allowed to;
    // two bodies are judged anew, now along the axis that was found, and looked at anew where their contacts have gone.
    struct Left {
        std::optional<HullDistance> touch; // none: no contact is left
        bool pushed;
    };

    // False, and to be done again, where the manifold must come or go and that is not allowed.
    bool update(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second,
                const btDispatcherInfo& info, btManifoldResult& result, bool may_come_and_go) {
        const btTransform relative = relative_of(first, second);
        const std::optional<Left> left = std::exchange(left_, std::nullopt);
        const bool pushed = left && in_compound_ ? left->pushed : may_be_pushed(first, second, info.m_timeStep);
        const btScalar ahead = looks_ahead_ || pushed ? approach(first, second) * info.m_timeStep : 0.0f;
        const btScalar near = near_ + ahead;
        if (left) {
            if (left->touch) add_contact(first, second, *left->touch, near, result);
        } else if (!(moved_since(relative) + ahead < free_)) {
            seen_ = relative;
            const std::optional<HullDistance> touch = look(first, second, near);
            if (touch && !manifold_ && pushed && !touch_ahead(first, second, info.m_timeStep)) {
                free_ = -1.0f; // near, but passing
                return true;
            }
            if (touch && !manifold_ && !may_come_and_go) {
                left_ = {touch, pushed};
                return false;
            }
            if (touch) add_contact(first, second, *touch, near, result);
        }
        if (!own_ || !manifold_) return true;
        result.setPersistentManifold(manifold_);
        result.refreshContactPoints();
        if (manifold_->getNumContacts() > 0) {
            if (pushed)
                meet_ahead(first, second, info.m_timeStep);
            else if (on_larger_)
                add_corners(first, second, info.m_timeStep, result);
        }
        if (manifold_->getNumContacts() > 0) return true;
        if (!may_come_and_go) {
            if (in_compound_) left_ = {std::nullopt, pushed};
            return false;
        }
        release();
        return true;
    }

    // The frame of the smaller hull in that of the other one.
    [[nodiscard]] btTransform relative_of(const btCollisionObjectWrapper& first,
                                          const btCollisionObjectWrapper& second) const {
        const btTransform &a = first.getWorldTransform(), &b = second.getWorldTransform();
        return first_moves_ ? b.inverseTimes(a) : a.inverseTimes(b);
    }

    // How far any point of the smaller hull can have moved in the frame of the other one.
    [[nodiscard]] btScalar moved_since(const btTransform& relative) const {
        btScalar turned = 0.0f; // the square of the Frobenius norm bounds what the difference does to a vector
        for (int row = 0; row < 3; ++row) turned += (relative.getBasis()[row] - seen_.getBasis()[row]).length2();
        return (relative.getOrigin() - seen_.getOrigin()).length() + std::sqrt(turned) * radius_;
    }

    static btVector3 velocity_of(const btCollisionObjectWrapper& object) {
        return btRigidBody::upcast(object.getCollisionObject())->getLinearVelocity();
    }

    // Whether one may get into or past the other in a step, and nobody looks at them on their way (step_stops.cpp).
    [[nodiscard]] bool may_be_pushed(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second,
                                     btScalar seconds) const {
        const btVector3 against = velocity_of(second) - velocity_of(first);
        // Along what separates them now they get no deeper than they come closer.
        if (alike_)
            return against.dot(first.getWorldTransform().getBasis() * axis_) * seconds > sinking_part * thinner_;
        if (!pushed_by_first_ && !pushed_by_second_) return false;
        const btScalar heavy = velocity_of(pushed_by_first_ ? first : second).length();
        return heavy * seconds > passing_part * radius_ && against.length() * seconds > apart_part * radius_;
    }

    // How fast the hulls can come closer.
    [[nodiscard]] btScalar approach(const btCollisionObjectWrapper& first,
                                    const btCollisionObjectWrapper& second) const {
        const btCollisionObject& a = *first.getCollisionObject();
        const btCollisionObject& b = *second.getCollisionObject();
        const btRigidBody& body_a = *btRigidBody::upcast(&a);
        const btRigidBody& body_b = *btRigidBody::upcast(&b);
        const btVector3 middle = (first_moves_ ? first : second).getWorldTransform().getOrigin();
        const btVector3 apart = body_a.getVelocityInLocalPoint(middle - body_a.getCenterOfMassPosition())
                                - body_b.getVelocityInLocalPoint(middle - body_b.getCenterOfMassPosition());
        const btVector3 turning = body_a.getAngularVelocity() - body_b.getAngularVelocity();
        return apart.length() + turning.length() * radius_;
    }

    // The gap between the hulls in a direction from the second to the first: what separates them at least.
    [[nodiscard]] btScalar gap(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second,
                               const btVector3& direction) const {
        return -reach(hull_of(first), first.getWorldTransform(), -direction)
               - reach(hull_of(second), second.getWorldTransform(), direction) - margins_;
    }

    // Finds a contact, if there is one, and by how much the hulls may move until they must be looked at again.
    std::optional<HullDistance> look(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second,
                                     btScalar near) {
        const btTransform& a = first.getWorldTransform();
        free_ = gap(first, second, a.getBasis() * axis_) - near;
        if (free_ > 0.0f) return std::nullopt;
        const HullDistance found = hull_distance(hull_of(first), hull_of(second),
                                                 a.inverseTimes(second.getWorldTransform()), margins_ + near, corners_);
        axis_ = found.normal;
        free_ = found.distance - margins_ - near;
        return free_ > 0.0f ? std::nullopt : std::optional(found);
    }

    void add_contact(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second,
                     const HullDistance& touch, btScalar near, btManifoldResult& result) {
        const btTransform& a = first.getWorldTransform();
        if (!manifold_)
            manifold_ = m_dispatcher->getNewManifold(first.getCollisionObject(), second.getCollisionObject());
        if (near > near_) manifold_->setContactBreakingThreshold(near);
        const int before = manifold_->getNumContacts();
        result.setPersistentManifold(manifold_);
        result.addContactPoint(a.getBasis() * touch.normal,
                               a * (touch.point + touch.normal * hull_of(second).getMargin()),
                               touch.distance - margins_);
        free_ = manifold_->getNumContacts() == before ? still_ : -1.0f;
    }

    // On a floor or a wall each corner of the smaller hull that the step may bring down is a contact, as on the ground
    // (ground_contact.h): with the deepest one only, the body turns on it, comes down on the next, and goes in corner by corner.
    void add_corners(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second, btScalar seconds,
                     btManifoldResult& result) {
        if (approach(first, second) * seconds <= still_) return;
        const btCollisionObjectWrapper& smaller = first_moves_ ? first : second;
        const btCollisionObjectWrapper& larger = first_moves_ ? second : first;
        const HullShape& hull = hull_of(smaller);
        const btManifoldPoint known = manifold_->getContactPoint(0);
        const btVector3 away = first_moves_ ? known.m_normalWorldOnB : -known.m_normalWorldOnB;
        const btScalar highest = low_part * thickness(hull);
        const btVector3 foot = first_moves_ ? known.getPositionWorldOnB() : known.getPositionWorldOnA();
        for (int i = 0; i < hull.getNumPoints(); ++i) {
            const btVector3 corner = smaller.getWorldTransform() * hull.getUnscaledPoints()[i];
            const btScalar height = (corner - foot).dot(away) - hull.getMargin();
            const btScalar down = -velocity_against(first, second, corner).dot(away) * seconds;
            if (height > std::min(near_ + std::max<btScalar>(down, 0.0f), highest)) continue;
            // Farther than the threshold is no contact, and what is nearer to another one than that would replace it.
            const btScalar threshold = std::max(near_, height);
            const btVector3 on_smaller = corner - away * hull.getMargin();
            if (has_contact_near(on_smaller, std::max(threshold, same_part * radius_))) continue;
            if (!is_over(hull_of(larger), larger.getWorldTransform(), corner, height)) continue;
            manifold_->setContactBreakingThreshold(threshold);
            result.addContactPoint(known.m_normalWorldOnB, first_moves_ ? on_smaller - away * height : on_smaller,
                                   height);
        }
        manifold_->setContactBreakingThreshold(near_);
    }

    // Where the two will be when they touch, on the way that they have in the step, turning left out.
    struct Touch {
        btTransform first, second; // the second as far on as both move against each other
        btVector3 way{0, 0, 0};    // by so much
        btVector3 normal{0, 0, 0}, on_second{0, 0, 0};
        btScalar distance = 0.0f; // that is left
    };
    std::optional<Touch> touch_ahead(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second,
                                     btScalar seconds) {
        const btVector3 middle = (first_moves_ ? first : second).getWorldTransform().getOrigin();
        const btVector3 against = velocity_against(first, second, middle);
        const btVector3 whole = (first_moves_ ? -against : against) * seconds;
        const HullShape& hull = hull_of(second);
        Touch touch{.first = first.getWorldTransform(), .second = second.getWorldTransform()};
        btScalar part = 0.0f;
        for (int advance = 0; advance < max_advances; ++advance) {
            const HullDistance found =
                hull_distance(hull_of(first), hull, touch.first.inverseTimes(touch.second), BT_LARGE_FLOAT, corners_);
            touch.distance = found.distance - margins_;
            touch.normal = touch.first.getBasis() * found.normal;
            touch.on_second = touch.first * (found.point + found.normal * hull.getMargin());
            if (touch.distance < near_) return touch;
            const btScalar closing = touch.normal.dot(whole);
            if (!(closing > 0.0f)) return std::nullopt;
            part += (touch.distance - 0.5f * near_) / closing;
            if (part > 1.0f) return std::nullopt;
            touch.way = whole * part;
            touch.second.setOrigin(second.getWorldTransform().getOrigin() + touch.way);
        }
        return touch;
    }

    // The points that are nearest now are not where the two will meet, and only one of those of surfaces that come down on each
    // other: what is light, pushed there, would get a part of the speed and spin. In their place come the point of touch, the
    // middle of the lower corners of the smaller hull then, and those of them that are farthest from each other; where the
    // other hull is.
    void meet_ahead(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second, btScalar seconds) {
        const btManifoldPoint known = manifold_->getContactPoint(0);
        const std::optional<Touch> touch = touch_ahead(first, second, seconds);
        manifold_->clearManifold();
        manifold_->setContactBreakingThreshold(near_);
        if (!touch) return;
        const HullShape& hull = hull_of(first_moves_ ? first : second);
        const HullShape& other = hull_of(first_moves_ ? second : first);
        const btTransform &frame = first_moves_ ? touch->first : touch->second,
                          &other_frame = first_moves_ ? touch->second : touch->first;
        const btVector3 away = first_moves_ ? touch->normal : -touch->normal;
        const btVector3 on_other = first_moves_ ? touch->on_second : touch->on_second + touch->normal * touch->distance;
        thread_local std::vector<btVector3> low; // corners
        low.clear();
        btVector3 middle(0, 0, 0);
        for (int i = 0; i < hull.getNumPoints(); ++i) {
            const btVector3 corner = frame * hull.getUnscaledPoints()[i];
            if ((corner - frame.getOrigin()).dot(away) > 0.0f) continue;
            middle += corner;
            low.push_back(corner);
        }
        const auto add = [&](const btVector3& corner) {
            const Below below = below_of(other, other_frame, corner);
            if (below.away.dot(away) < same_way) return;
            const btVector3 on_smaller = corner - below.away * hull.getMargin();
            const btManifoldPoint point = ahead_of(known, *touch, on_smaller, below);
            if (!has_contact_near(first_moves_ ? point.getPositionWorldOnA() : point.getPositionWorldOnB(),
                                  same_part * radius_))
                manifold_->addManifoldPoint(point);
        };
        if (!low.empty())
            add(middle / static_cast<btScalar>(low.size())); // solved first, so that it turns only if it must
        manifold_->addManifoldPoint(
            ahead_of(known, *touch, on_other + away * touch->distance, {away, touch->distance}));
        while (!low.empty() && manifold_->getNumContacts() < MANIFOLD_CACHE_SIZE) {
            const auto farthest = std::ranges::max_element(low, {}, [&](const btVector3& corner) {
                return to_contacts(first_moves_ ? corner : corner - touch->way);
            });
            add(*farthest);
            low.erase(farthest);
        }
    }

    // The other hull below a point of the smaller one's core: the way from it, and the gap.
    struct Below {
        btVector3 away;
        btScalar distance;
    };
    [[nodiscard]] Below below_of(const HullShape& other, const btTransform& frame, const btVector3& corner,
                                 btScalar most = BT_LARGE_FLOAT) const {
        static const HullShape tip = point_hull();
        NearCorners nowhere;
        const HullDistance found = hull_distance(
            tip, other, btTransform(btMatrix3x3::getIdentity(), corner).inverseTimes(frame), most, nowhere);
        return {found.normal, found.distance - margins_};
    }

    // The contact, as it is now, of a point that the smaller hull will have so far from the other one. It lies where the light
    // body has it: on the heavy one arms matter less.
    [[nodiscard]] btManifoldPoint ahead_of(btManifoldPoint point, const Touch& touch, const btVector3& on_smaller,
                                           const Below& below) const {
        const bool light_is_second = pushed_by_first_, light_is_smaller = light_is_second != first_moves_;
        const btVector3 then = light_is_smaller ? on_smaller : on_smaller - below.away * below.distance;
        const btVector3 on_light = light_is_second ? then - touch.way : then;
        point.m_normalWorldOnB = first_moves_ ? below.away : -below.away;
        point.m_distance1 = below.distance + point.m_normalWorldOnB.dot(touch.way);
        const btVector3 gap = point.m_normalWorldOnB * point.m_distance1;
        point.m_positionWorldOnA = light_is_second ? on_light + gap : on_light;
        point.m_positionWorldOnB = light_is_second ? on_light : on_light - gap;
        point.m_localPointA = manifold_->getBody0()->getWorldTransform().invXform(point.m_positionWorldOnA);
        point.m_localPointB = manifold_->getBody1()->getWorldTransform().invXform(point.m_positionWorldOnB);
        point.m_appliedImpulse = point.m_appliedImpulseLateral1 = point.m_appliedImpulseLateral2 = 0.0f;
        point.m_lifeTime = 0;
        return point;
    }

    // The square of how far the nearest contact is.
    [[nodiscard]] btScalar to_contacts(const btVector3& on_smaller) const {
        btScalar least = BT_LARGE_FLOAT;
        for (int i = 0; i < manifold_->getNumContacts(); ++i) {
            const btManifoldPoint& known = manifold_->getContactPoint(i);
            const btVector3& at = first_moves_ ? known.getPositionWorldOnA() : known.getPositionWorldOnB();
            least = std::min(least, (at - on_smaller).length2());
        }
        return least;
    }

    [[nodiscard]] bool has_contact_near(const btVector3& on_smaller, btScalar distance) const {
        for (int i = 0; i < manifold_->getNumContacts(); ++i) {
            const btManifoldPoint& known = manifold_->getContactPoint(i);
            const btVector3& at = first_moves_ ? known.getPositionWorldOnA() : known.getPositionWorldOnB();
            if ((at - on_smaller).length2() < distance * distance) return true;
        }
        return false;
    }

    // Velocity of the smaller hull against the other one at a point of the world.
    [[nodiscard]] btVector3 velocity_against(const btCollisionObjectWrapper& first,
                                             const btCollisionObjectWrapper& second, const btVector3& point) const {
        const auto velocity = [&](const btCollisionObjectWrapper& object) {
            const btRigidBody& body = *btRigidBody::upcast(object.getCollisionObject());
            return body.getVelocityInLocalPoint(point - body.getCenterOfMassPosition());
        };
        const btVector3 apart = velocity(first) - velocity(second);
        return first_moves_ ? apart : -apart;
    }

    // Whether a corner of the smaller hull is as far from the larger one as from the plane of a contact: over the same face.
    [[nodiscard]] bool is_over(const HullShape& larger, const btTransform& frame, const btVector3& corner,
                               btScalar height) const {
        const btScalar most = margins_ + near_ + std::max<btScalar>(height, 0.0f);
        return std::abs(below_of(larger, frame, corner, most).distance - height) < near_;
    }

    void release() {
        if (own_ && manifold_) m_dispatcher->releaseManifold(manifold_);
        manifold_ = own_ ? nullptr : manifold_;
    }

    btPersistentManifold* manifold_; // of our own: only while there are contacts
    bool own_;
    bool in_compound_;                              // the first is one of several hulls
    bool first_moves_;                              // what is looked at as moving: the smaller one
    btScalar radius_;                               // of it
    btScalar margins_;                              // of both
    btScalar near_;                                 // closer is a contact
    bool looks_ahead_;                              // debris
    bool pushed_by_first_, pushed_by_second_;       // which is much heavier
    bool alike_;                                    // both move, none is much lighter
    btScalar thinner_;                              // thickness of the thinner one
    bool on_larger_;                                // one of them is much larger
    btScalar still_;                                // movement that contacts bear
    btScalar free_ = -1.0f;                         // movement from seen_ that needs no look; negative: always look
    btTransform seen_ = btTransform::getIdentity(); // of the smaller in the other's frame
    NearCorners corners_;
    std::optional<Left> left_;
    btVector3 axis_; // unit, from second to first, in the first's frame: separated them last
};

struct CreateHullPair final : btCollisionAlgorithmCreateFunc {
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* first,
                                                   const btCollisionObjectWrapper* second) override {
        void* place = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(HullPair));
        return new (place) HullPair(info, first, second);
    }
};

} // namespace

struct HullContacts::Impl {
    CreateHullPair create;
};

HullContacts::HullContacts(btCollisionDispatcher& dispatcher) : impl_(std::make_unique<Impl>()) {
    dispatcher.registerCollisionCreateFunc(CONVEX_HULL_SHAPE_PROXYTYPE, CONVEX_HULL_SHAPE_PROXYTYPE, &impl_->create);
}
HullContacts::~HullContacts() = default;

int HullContacts::pair_size() {
    return static_cast<int>(sizeof(HullPair));
}

} // namespace brittle::physics

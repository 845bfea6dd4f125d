#include "physics/solver/ground_contact.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <deque>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <btBulletDynamicsCommon.h>

#include "physics/solver/convert.h"
#include "physics/solver/fetch.h"
#include "physics/solver/float4.h"
#include "physics/solver/hull_shape.h"
#include "physics/solver/narrow_phase.h"

namespace brittle::physics {

namespace {

// Corners nearer to the ground than this part of the hull's radius count as touching, so that a body at rest
// keeps its contacts while it trembles. Bullet's own value.
constexpr btScalar resting_distance = 0.02f;

// Contacts of one hull: so many corners carry it, and so many more may be kept from sinking.
constexpr size_t max_corners = GroundManifold::max_points;
constexpr size_t carrying_corners = 4;
// A corner that would be deeper than this at the end of the step, in metres, has a contact of its own even where
// four others carry the body. Left out, it sinks while the body rocks on them.
constexpr btScalar sunk_depth = 1e-4f;
// The impact of one corner turns the body, and another comes down faster than it did: a rod's other end by half.
constexpr btScalar turned_approach = 2.0f;

struct Corner {
    btVector3 position; // of the point on the hull, margin included
    btScalar distance;  // above the ground
    btScalar ahead;     // distance at the end of the step if nothing stops it
    btScalar apart;     // squared, from the nearest of those that are kept
    int index;
};

// Moves the corner of the highest score to a place, from among those at and behind it; the first of several.
void take(std::vector<Corner>& corners, size_t place, const auto& score) {
    size_t best = place;
    btScalar most = score(corners[place]);
    for (size_t i = place + 1; i < corners.size(); ++i) {
        const btScalar own = score(corners[i]);
        if (most < own) {
            most = own;
            best = i;
        }
    }
    std::swap(corners[place], corners[best]);
}

// Those that carry a body best, in front: the one that comes down deepest, the one farthest from it, the one
// farthest from the line through both, the one farthest on that line's other side.
void find_carrying(std::vector<Corner>& corners) {
    take(corners, 0, [](const Corner& c) { return -c.ahead; });
    const btVector3 first = corners[0].position;
    take(corners, 1, [&](const Corner& c) { return (c.position - first).length2(); });
    const btVector3 line = corners[1].position - first;
    const auto side = [&](const Corner& c) { return line.cross(c.position - first).y(); };
    take(corners, 2, [&](const Corner& c) { return std::abs(side(c)); });
    const btScalar sign = side(corners[2]) > 0.0f ? -1.0f : 1.0f;
    take(corners, 3, [&](const Corner& c) { return sign * side(c); });
}

// Leaves the carrying corners, and of those that would sink the ones farthest from all that are left already.
void keep_best(std::vector<Corner>& corners) {
    if (corners.size() <= carrying_corners) return;
    find_carrying(corners);
    const auto others = corners.begin() + carrying_corners;
    corners.erase(
        std::remove_if(others, corners.end(), [](const Corner& c) { return c.ahead > -sunk_depth * bullet_units; }),
        corners.end());
    for (size_t i = carrying_corners; i < corners.size(); ++i) corners[i].apart = BT_LARGE_FLOAT;
    const auto keep_away = [&](const btVector3& from, size_t behind) {
        for (size_t i = behind; i < corners.size(); ++i)
            corners[i].apart = std::min(corners[i].apart, (corners[i].position - from).length2());
    };
    for (size_t i = 0; i < carrying_corners; ++i) keep_away(corners[i].position, carrying_corners);
    const size_t kept = std::min(corners.size(), max_corners);
    for (size_t place = carrying_corners; place < kept; ++place) {
        take(corners, place, [](const Corner& c) { return c.apart; });
        keep_away(corners[place].position, place + 1);
    }
    corners.resize(kept);
}

// Manifolds stay where they are. Not thread-safe.
class Manifolds {
  public:
    GroundManifold* take() {
        if (free_.empty()) free_.push_back(&store_.emplace_back());
        GroundManifold* const taken = free_.back();
        free_.pop_back();
        taken->place = static_cast<uint32_t>(used_.size());
        taken->count = 0;
        used_.push_back(taken);
        return taken;
    }
    void give_back(GroundManifold* manifold) {
        used_[manifold->place] = used_.back();
        used_[manifold->place]->place = manifold->place;
        used_.pop_back();
        free_.push_back(manifold);
    }
    [[nodiscard]] std::span<GroundManifold* const> used() const { return used_; }

  private:
    std::deque<GroundManifold> store_;
    std::vector<GroundManifold*> used_, free_;
};

// What a contact keeps for the next step.
struct Memory {
    int corner;
    float impulse, friction;
    std::array<float, 3> along;
};

btScalar height_of(const btCollisionObject& plane) {
    return static_cast<const btStaticPlaneShape&>(*plane.getCollisionShape()).getPlaneConstant()
           + plane.getWorldTransform().getOrigin().y();
}

// How high above the ground a corner may be at most and have a contact, of a hull whose centre is so far from the body's.
btScalar highest_contact(const HullShape& hull, const btRigidBody& body, btScalar arm, btScalar seconds) {
    const btScalar falling = body.getLinearVelocity().y() + body.getGravity().y() * seconds;
    const btScalar fastest = std::abs(falling) + body.getAngularVelocity().length() * (arm + hull.radius());
    return resting_distance * hull.getAngularMotionDisc() + turned_approach * fastest * seconds;
}

class HullOnPlane final : public FollowedContacts {
  public:
    HullOnPlane(const btCollisionAlgorithmConstructionInfo& info, const btCollisionObject* hull,
                const btCollisionObject* plane, Manifolds& manifolds)
        : FollowedContacts(info), hull_(hull), plane_(plane), manifolds_(manifolds),
          threshold_(hull->getCollisionShape()->getContactBreakingThreshold(gContactBreakingThreshold)) {}
    ~HullOnPlane() override {
        if (manifold_) manifolds_.give_back(manifold_);
    }

    void processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                          const btDispatcherInfo& info, btManifoldResult* result) override {
        if (follow(*first, *second, info, *result)) return;
        manifold_ = manifolds_.take();
        (void)follow(*first, *second, info, *result);
    }
    bool follow(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second,
                const btDispatcherInfo& info, btManifoldResult&) override {
        if (manifold_) fetch(manifold_); // the corners come first
        const btCollisionObjectWrapper& hull = first.getCollisionObject() == hull_ ? first : second;
        std::vector<Corner>& corners = find_corners(hull, info.m_timeStep);
        keep_best(corners);
        if (!manifold_ && !corners.empty()) return false;
        if (manifold_) replace_contacts(corners, hull.m_index);
        return true;
    }
    // As Bullet does with manifolds: what has come too far from where it was is no contact any more.
    void refresh(btManifoldResult&) override {
        if (!manifold_) return;
        const btTransform& frame = hull_->getWorldTransform();
        const auto gone = [&](const GroundPoint& point) {
            const btVector3 now = frame * unpacked(point.local);
            const btVector3 below = unpacked(point.position) - btVector3(0, point.distance, 0);
            const btScalar distance = now.y() - below.y();
            const btVector3 aside = below - (now - btVector3(0, distance, 0));
            return distance > threshold_ || aside.length2() > threshold_ * threshold_;
        };
        const std::span<GroundPoint> points = manifold_->points();
        manifold_->count = static_cast<uint32_t>(std::remove_if(points.begin(), points.end(), gone) - points.begin());
    }
    void collect(std::vector<AnyManifold>& to) override {
        if (manifold_ && manifold_->count > 0) to.emplace_back(*manifold_);
    }

    // Only asked for objects that sweep; ours do not.
    btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                   btManifoldResult*) override {
        return 1.0f;
    }
    void getAllContactManifolds(btManifoldArray&) override {} // none of Bullet's

  private:
    // The hull is the body's own or, with a frame of its own, one of a compound's. Valid until the thread's next call.
    std::vector<Corner>& find_corners(const btCollisionObjectWrapper& hull, btScalar seconds) const {
        thread_local std::vector<Corner> corners;
        corners.clear();
        const auto& shape = static_cast<const HullShape&>(*hull.getCollisionShape());
        const btScalar height = height_of(*plane_);
        const btRigidBody* body = btRigidBody::upcast(hull.getCollisionObject());
        const btVector3 velocity = body->getLinearVelocity() + body->getGravity() * seconds;
        const btTransform& frame = hull.getWorldTransform();
        const btVector3 origin = frame.getOrigin() - body->getCenterOfMassPosition();
        const btScalar resting = resting_distance * shape.getAngularMotionDisc();
        // Most bodies that are in the air are so high that none of their corners can come down in the step.
        const btScalar above = frame.getOrigin().y() - height;
        const btScalar highest = highest_contact(shape, *body, origin.length(), seconds);
        if (above - shape.radius() > highest) return corners;
        const bool touched = manifold_ && manifold_->count > 0; // seldom so high then; the corners say the same
        if (!touched && above - shape.reach(-frame.getBasis()[1]) - shape.getMargin() > highest) return corners;
        const btVector3 &at = frame.getOrigin(), &spin = body->getAngularVelocity();
        const std::span<const btScalar> groups = shape.groups();
        for (size_t i = 0; i < groups.size(); i += HullShape::group_size) {
            const auto turned = [&](int axis) { return HullShape::along(&groups[i], frame.getBasis()[axis]); };
            const Float4 y = turned(1) - Float4::all(shape.getMargin());
            const Float4 distance = (Float4::all(at.y()) + y) - Float4::all(height);
            if (less(distance, Float4::all(highest)) == 0) continue; // no corner is reached from higher
            const Float4 x = turned(0), z = turned(2);
            const Float4 turning = Float4::all(spin.z()) * (Float4::all(origin.x()) + x)
                                   - Float4::all(spin.x()) * (Float4::all(origin.z()) + z);
            const Float4 none = Float4::all(0.0f), approach = none - (Float4::all(velocity.y()) + turning);
            const Float4 reached =
                Float4::all(resting) + Float4::all(turned_approach) * max(none, approach) * Float4::all(seconds);
            const auto first = static_cast<int>(i / HullShape::group_size) * 4;
            const uint32_t points = 0xfu >> std::max(first + 4 - shape.getNumPoints(), 0); // that are no repetitions
            uint32_t low = less(distance, reached) & points;
            if (low == 0) continue;
            std::array<std::array<float, 4>, 5> lanes;
            for (const auto& [to, from] : {std::pair(&lanes[0], Float4::all(at.x()) + x),
                                           {&lanes[1], Float4::all(at.y()) + y},
                                           {&lanes[2], Float4::all(at.z()) + z},
                                           {&lanes[3], distance},
                                           {&lanes[4], distance - approach * Float4::all(seconds)}})
                from.store(to->data());
            for (; low != 0; low &= low - 1) {
                const auto k = static_cast<size_t>(std::countr_zero(low));
                corners.push_back({{lanes[0][k], lanes[1][k], lanes[2][k]},
                                   lanes[3][k],
                                   lanes[4][k],
                                   0.0f,
                                   first + static_cast<int>(k)});
            }
        }
        return corners;
    }

    // A corner that was a contact before keeps the impulses that the solver starts from.
    void replace_contacts(const std::vector<Corner>& corners, int hull) {
        GroundManifold& manifold = *manifold_;
        std::array<Memory, max_corners> old;
        const size_t known = manifold.count;
        std::ranges::transform(manifold.points(), old.begin(), [](const GroundPoint& point) {
            return Memory{point.corner, point.kept_impulse(), point.kept_friction(), point.along};
        });
        manifold.body = btRigidBody::upcast(hull_);
        manifold.hull = hull;
        manifold.friction = btManifoldResult::calculateCombinedFriction(hull_, plane_);
        manifold.restitution = btManifoldResult::calculateCombinedRestitution(hull_, plane_);
        manifold.count = static_cast<uint32_t>(corners.size());
        const btVector3& at = hull_->getWorldTransform().getOrigin();
        const btMatrix3x3 to_hull = hull_->getWorldTransform().getBasis().transpose();
        const std::span<const Memory> memories = std::span(old).first(known);
        for (size_t i = 0; i < corners.size(); ++i) {
            const Corner& corner = corners[i];
            GroundPoint& point = manifold.all[i];
            const auto same = std::ranges::find(memories, corner.index, &Memory::corner);
            const Memory before = same != memories.end() ? *same : Memory{};
            // Member by member, each of them: the copy of a whole point waits until its members are written (store forwarding).
            point.position = packed(corner.position);
            point.local = hull >= 0 ? packed(to_hull * (corner.position - at)) : std::array<float, 3>{};
            point.distance = corner.distance;
            point.corner = corner.index;
            point.speed = 0.0f;
            point.impulse = before.impulse;
            point.friction = before.friction;
            point.along = before.along;
            point.blow = false;
        }
    }

    const btCollisionObject* hull_;
    const btCollisionObject* plane_;
    Manifolds& manifolds_;
    GroundManifold* manifold_ = nullptr; // since the first corner that touched
    btScalar threshold_;                 // of what counts as one contact from step to step
};

struct CreateHullOnPlane final : btCollisionAlgorithmCreateFunc {
    explicit CreateHullOnPlane(Manifolds& manifolds, bool swapped) : manifolds_(manifolds) { m_swapped = swapped; }

    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* first,
                                                   const btCollisionObjectWrapper* second) override {
        if (m_swapped) std::swap(first, second);
        void* place = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(HullOnPlane));
        return new (place) HullOnPlane(info, first->getCollisionObject(), second->getCollisionObject(), manifolds_);
    }

  private:
    Manifolds& manifolds_;
};

} // namespace

struct GroundContacts::Impl {
    Manifolds manifolds;
    CreateHullOnPlane hull_first{manifolds, false}, plane_first{manifolds, true};
};

GroundContacts::GroundContacts(btCollisionDispatcher& dispatcher) : impl_(std::make_unique<Impl>()) {
    dispatcher.registerCollisionCreateFunc(CONVEX_HULL_SHAPE_PROXYTYPE, STATIC_PLANE_PROXYTYPE, &impl_->hull_first);
    dispatcher.registerCollisionCreateFunc(STATIC_PLANE_PROXYTYPE, CONVEX_HULL_SHAPE_PROXYTYPE, &impl_->plane_first);
}
GroundContacts::~GroundContacts() = default;

bool GroundContacts::is_out_of_reach(const btRigidBody& body, const btCollisionObject& plane, float seconds) {
    const auto& hull = static_cast<const HullShape&>(*body.getCollisionShape());
    const btScalar above = body.getWorldTransform().getOrigin().y() - height_of(plane);
    return above - hull.radius() > highest_contact(hull, body, 0.0f, seconds);
}

std::span<GroundManifold* const> GroundContacts::manifolds() const {
    return impl_->manifolds.used();
}

int GroundContacts::pair_size() {
    return static_cast<int>(sizeof(HullOnPlane));
}

} // namespace brittle::physics

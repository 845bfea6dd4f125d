#include "physics/bullet/ground_contact.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <btBulletDynamicsCommon.h>

#include "physics/bullet/convert.h"
#include "physics/bullet/float4.h"
#include "physics/bullet/hull_shape.h"
#include "physics/bullet/narrow_phase.h"

namespace brittle::physics {

namespace {

// Corners nearer to the ground than this part of the hull's radius count as touching, so that a body at rest
// keeps its contacts while it trembles. Bullet's own value.
constexpr btScalar resting_distance = 0.02f;

// Contacts of one hull: so many corners carry it, and so many more may be kept from sinking.
constexpr size_t most_corners = 12;
constexpr size_t carrying_corners = 4;
// A corner that would be deeper than this at the end of the step, in metres, has a contact of its own even where
// four others carry the body. Left out, it sinks while the body rocks on them.
constexpr btScalar sunk_depth = 1e-4f;
// The impact of one corner turns the body, and another comes down faster than it did: a rod's other end by half.
constexpr btScalar turned_approach = 2.0f;
// This part of a corner's depth is undone in a step. The ground yields to nobody, so it may be more than between
// bodies, where each piece that is lifted lifts others.
constexpr btScalar undone_part = 0.6f;

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
    corners.erase(std::remove_if(others, corners.end(),
                                 [](const Corner& c) { return c.ahead > -sunk_depth * bullet_units; }),
                  corners.end());
    for (size_t i = carrying_corners; i < corners.size(); ++i) corners[i].apart = BT_LARGE_FLOAT;
    const auto keep_away = [&](const btVector3& from, size_t behind) {
        for (size_t i = behind; i < corners.size(); ++i)
            corners[i].apart = std::min(corners[i].apart, (corners[i].position - from).length2());
    };
    for (size_t i = 0; i < carrying_corners; ++i) keep_away(corners[i].position, carrying_corners);
    const size_t kept = std::min(corners.size(), most_corners);
    for (size_t place = carrying_corners; place < kept; ++place) {
        take(corners, place, [](const Corner& c) { return c.apart; });
        keep_away(corners[place].position, place + 1);
    }
    corners.resize(kept);
}

// What a contact keeps for the next step.
struct Memory {
    int index;
    btScalar impulse, friction;
    btVector3 direction; // of friction
};

class HullOnPlane final : public FollowedContacts {
  public:
    HullOnPlane(const btCollisionAlgorithmConstructionInfo& info, const btCollisionObject* hull,
                const btCollisionObject* plane)
        : FollowedContacts(info), hull_(hull), plane_(plane) {}
    ~HullOnPlane() override { keep_manifolds(0); }

    void processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                          const btDispatcherInfo& info, btManifoldResult*) override {
        const btCollisionObjectWrapper& hull = *(first->getCollisionObject() == hull_ ? first : second);
        std::vector<Corner>& corners = find_corners(hull, info.m_timeStep);
        keep_best(corners);
        replace_contacts(corners, hull.m_index);
    }
    bool follow(const btCollisionObjectWrapper& first, const btCollisionObjectWrapper& second,
                const btDispatcherInfo& info, btManifoldResult&) override {
        const btCollisionObjectWrapper& hull = first.getCollisionObject() == hull_ ? first : second;
        std::vector<Corner>& corners = find_corners(hull, info.m_timeStep);
        keep_best(corners);
        if (manifolds_for(corners) != manifold_count_) return false;
        replace_contacts(corners, hull.m_index);
        return true;
    }

    // Only asked for objects that sweep; ours do not.
    btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                   btManifoldResult*) override {
        return 1.0f;
    }
    void getAllContactManifolds(btManifoldArray& manifolds) override {
        for (size_t i = 0; i < manifold_count_; ++i) manifolds.push_back(manifolds_[i]);
    }

  private:
    // The hull is the body's own or, with a frame of its own, one of a compound's. Valid until the thread's next call.
    std::vector<Corner>& find_corners(const btCollisionObjectWrapper& hull, btScalar seconds) const {
        thread_local std::vector<Corner> corners;
        corners.clear();
        const auto& shape = static_cast<const HullShape&>(*hull.getCollisionShape());
        const btScalar height =
            static_cast<const btStaticPlaneShape&>(*plane_->getCollisionShape()).getPlaneConstant()
            + plane_->getWorldTransform().getOrigin().y();
        const btRigidBody* body = btRigidBody::upcast(hull.getCollisionObject());
        const btVector3 velocity = body->getLinearVelocity() + body->getGravity() * seconds;
        const btTransform& frame = hull.getWorldTransform();
        const btVector3 origin = frame.getOrigin() - body->getCenterOfMassPosition();
        const btScalar resting = resting_distance * shape.getAngularMotionDisc();
        // Most bodies that are in the air are so high that none of their corners can come down in the step.
        const btScalar above = frame.getOrigin().y() - height;
        const btScalar fastest =
            std::abs(velocity.y()) + body->getAngularVelocity().length() * (origin.length() + shape.radius());
        const btScalar reached_at_most = resting + turned_approach * fastest * seconds;
        if (above - shape.radius() > reached_at_most
            || above - shape.reach(-frame.getBasis()[1]) - shape.getMargin() > reached_at_most)
            return corners;
        const btVector3 &at = frame.getOrigin(), &spin = body->getAngularVelocity();
        const std::span<const btScalar> groups = shape.groups();
        for (size_t i = 0; i < groups.size(); i += HullShape::group_size) {
            const auto turned = [&](int axis) { return HullShape::along(&groups[i], frame.getBasis()[axis]); };
            const Float4 x = turned(0), y = turned(1) - Float4::all(shape.getMargin()), z = turned(2);
            const Float4 distance = (Float4::all(at.y()) + y) - Float4::all(height);
            const Float4 turning = Float4::all(spin.z()) * (Float4::all(origin.x()) + x)
                                   - Float4::all(spin.x()) * (Float4::all(origin.z()) + z);
            const Float4 none = Float4::all(0.0f), approach = none - (Float4::all(velocity.y()) + turning);
            const Float4 reached = Float4::all(resting)
                                   + Float4::all(turned_approach) * max(none, approach) * Float4::all(seconds);
            const auto first = static_cast<int>(i / HullShape::group_size) * 4;
            const uint32_t points = 0xfu >> std::max(first + 4 - shape.getNumPoints(), 0); // that are no repetitions
            uint32_t low = less(distance, reached) & points;
            if (low == 0) continue;
            std::array<std::array<float, 4>, 5> lanes;
            for (const auto& [to, from] : {std::pair(&lanes[0], Float4::all(at.x()) + x), {&lanes[1], Float4::all(at.y()) + y},
                                           {&lanes[2], Float4::all(at.z()) + z}, {&lanes[3], distance},
                                           {&lanes[4], distance - approach * Float4::all(seconds)}})
                from.store(to->data());
            for (; low != 0; low &= low - 1) {
                const auto k = static_cast<size_t>(std::countr_zero(low));
                corners.push_back({{lanes[0][k], lanes[1][k], lanes[2][k]}, lanes[3][k], lanes[4][k], 0.0f,
                                   first + static_cast<int>(k)});
            }
        }
        return corners;
    }

    static size_t manifolds_for(const std::vector<Corner>& corners) {
        return (corners.size() + MANIFOLD_CACHE_SIZE - 1) / MANIFOLD_CACHE_SIZE;
    }

    // A corner that was a contact before keeps the impulses that the solver starts from.
    void replace_contacts(const std::vector<Corner>& corners, int part) {
        std::array<Memory, most_corners> old;
        size_t count = 0;
        for (size_t m = 0; m < manifold_count_; ++m)
            for (int i = 0; i < manifolds_[m]->getNumContacts(); ++i) {
                const btManifoldPoint& point = manifolds_[m]->getContactPoint(i);
                old[count++] = {point.m_index0, point.m_appliedImpulse, point.m_appliedImpulseLateral1,
                                point.m_lateralFrictionDir1};
            }
        keep_manifolds(manifolds_for(corners));
        for (size_t m = 0; m < manifold_count_; ++m) {
            const size_t left = corners.size() - m * MANIFOLD_CACHE_SIZE;
            manifolds_[m]->setNumContacts(static_cast<int>(std::min<size_t>(left, MANIFOLD_CACHE_SIZE)));
        }
        put_contacts(corners, std::span(old).first(count), part);
    }

    // Written where they are to be: a point has 200 bytes.
    void put_contacts(const std::vector<Corner>& corners, std::span<const Memory> old, int part) {
        const btVector3 &hull_at = hull_->getWorldTransform().getOrigin(), &plane_at = plane_->getWorldTransform().getOrigin();
        const btMatrix3x3 to_hull = hull_->getWorldTransform().getBasis().transpose();
        const btMatrix3x3 to_plane = plane_->getWorldTransform().getBasis().transpose();
        const btScalar friction = btManifoldResult::calculateCombinedFriction(hull_, plane_);
        const btScalar restitution = btManifoldResult::calculateCombinedRestitution(hull_, plane_);
        for (size_t i = 0; i < corners.size(); ++i) {
            const Corner& corner = corners[i];
            const btVector3 below = corner.position - btVector3(0, corner.distance, 0);
            btManifoldPoint& point = *std::construct_at(
                &manifolds_[i / MANIFOLD_CACHE_SIZE]->getContactPoint(static_cast<int>(i % MANIFOLD_CACHE_SIZE)),
                to_hull * (corner.position - hull_at), to_plane * (below - plane_at), btVector3(0, 1, 0), corner.distance);
            point.m_positionWorldOnA = corner.position;
            point.m_positionWorldOnB = below;
            point.m_combinedFriction = friction;
            point.m_combinedRestitution = restitution;
            point.m_contactPointFlags |= BT_CONTACT_FLAG_HAS_CONTACT_ERP;
            point.m_contactERP = undone_part;
            point.m_index0 = corner.index;
            point.m_partId0 = part;
            for (const Memory& before : old) {
                if (before.index != corner.index) continue;
                point.m_appliedImpulse = before.impulse;
                point.m_appliedImpulseLateral1 = before.friction;
                point.m_lateralFrictionDir1 = before.direction;
            }
        }
    }

    void keep_manifolds(size_t count) {
        while (manifold_count_ > count) m_dispatcher->releaseManifold(manifolds_[--manifold_count_]);
        while (manifold_count_ < count)
            manifolds_[manifold_count_++] = m_dispatcher->getNewManifold(hull_, plane_);
    }

    const btCollisionObject* hull_;
    const btCollisionObject* plane_;
    std::array<btPersistentManifold*, most_corners / MANIFOLD_CACHE_SIZE> manifolds_{}; // four contacts each
    size_t manifold_count_ = 0;
};

} // namespace

struct GroundContacts::Impl {
    CreateContacts<HullOnPlane> hull_first{false}, plane_first{true};
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

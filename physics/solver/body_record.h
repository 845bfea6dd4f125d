// A body of the world as Bullet has it: shapes and rigid body, and what Bullet does not keep.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <btBulletDynamicsCommon.h>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "physics/solver/air_drag.h"
#include "physics/solver/convert.h"
#include "physics/solver/hull_shape.h"
#include "physics/solver/sweep_broadphase.h"
#include "physics/world/hull.h"
#include "physics/world/world.h"

namespace brittle::physics {

// A hull that bodies may share: Bullet's copy in the hull's own axes.
struct SharedShape {
    std::shared_ptr<const CollisionHull> hull;
    HullShape shape;
    std::vector<HullEdge> edges; // for debug lines; filled when first asked for
};

// Bullet's units.
struct Velocity {
    btVector3 linear{0, 0, 0}, angular{0, 0, 0};
};

// What a step asks of a body. Bullet's frame has the same origin as ours and the principal axes as its own.
struct BodyMeasures {
    glm::quat to_principal{1.0f, 0.0f, 0.0f, 0.0f}; // body axes = to_principal * principal axes
    glm::dvec3 moments{1.0};                        // principal, kg m^2
    float mass = 0.0f;                              // kg, as given
    bool fixed = false;
    // Bullet's units: from the centre of mass; of the thinnest of its hulls; the longest side of the box in its own axes.
    float reach = 0.0f, thickness = 0.0f, longest = 0.0f;
};

// What does not depend on where and in which world a body is; bodies share it.
struct BodyForm : BodyMeasures {
    AirDrag drag;                   // of a fixed body that of a vacuum
    std::optional<HullShape> shape; // of a body with one hull; none for a compound
};

// One body. Every member has an initialiser: see make_body().
struct BodyRecord : BodyMeasures {
    BodyRecord() = default;
    BodyRecord(BodyRecord&&) = delete; // Bullet keeps where its body is

    BodyId id;
    bool debris = false;
    std::shared_ptr<const BodyForm> form; // the measures are copies of its own
    Pose previous;
    btTransform stepped_from = btTransform::getIdentity(); // Bullet's frame as the step began, after the repair
    bool was_repaired = false;                             // as the step began
    btTransform repair = btTransform::getIdentity(); // of overlaps found in the last step, due at the next: turn, way
    bool repaired = false;                           // whether there is any
    // What World::rewind() goes back to. Bullet's frame, and the time that the body then moved on without touching anything.
    btTransform blow_frame = btTransform::getIdentity();
    float left_seconds = 0.0f;
    float moving_seconds = 0.0f;                   // of the last step: less than all where it stopped at another body
    Velocity unhindered, solved;                   // before contacts, with the step's gravity; and after them
    float still_seconds = 0.0f;                    // how long it has been slow while touching something
    float quiet_seconds = 0.0f;                    // how long nearly all of what it touches, directly or not, has been
    btTransform rest = btTransform::getIdentity(); // where it was when it last had moved away
    float rest_seconds = 0.0f;                     // how long it has touched something near there
    bool touching = false;                         // in the last step
    bool sunk = false;                             // likewise, and after the repair: in the ground, too deep to sleep
    bool resting = false;                          // in this step: held where it is, see SteppedWorld::let_rest()
    float unmoved_seconds = 0.0f;                  // how long nothing has kept it from that
    uint32_t resting_on = 0;     // fours of contacts that it had when it came to rest, or in the last step
    std::vector<HullEdge> edges; // for debug lines, indices into the points of shape; filled when first asked for
    std::vector<std::shared_ptr<SharedShape>> shared; // of a compound, in the order of its parts
    std::unique_ptr<btCompoundShape> compound;        // null for a body with one hull
    std::optional<btRigidBody> rigid;                 // made once; none until then

    // Bullet, which does not say so, leaves shapes as they are.
    [[nodiscard]] btCollisionShape* collision_shape() const {
        return compound ? static_cast<btCollisionShape*>(compound.get()) : const_cast<HullShape*>(&*form->shape);
    }

    // Moves it out of overlaps, unless it sleeps, and notes where it is.
    void start_step();
    [[nodiscard]] bool has_moved() const { return was_repaired || !(rigid->getWorldTransform() == stepped_from); }
    [[nodiscard]] Velocity velocity() const { return {rigid->getLinearVelocity(), rigid->getAngularVelocity()}; }
    [[nodiscard]] bool awake() const { return !fixed && rigid->isActive(); }
    [[nodiscard]] Pose pose() const { return pose_in(rigid->getWorldTransform()); }
    // With Bullet's frame there.
    [[nodiscard]] Pose pose_in(const btTransform& frame) const {
        return {metres_from_bullet(frame.getOrigin()), to_glm(frame.getRotation()) * glm::conjugate(to_principal)};
    }
};

// A body that is in no world yet, and what it will be among the others' boxes.
struct NewBody {
    std::unique_ptr<BodyRecord> record;
    std::unique_ptr<SweptProxy> proxy;  // null until the rigid body is made
    bool sibling = false;               // Siblings::mark()
    bool awake = false, debris = false; // as the record
};

// What can be made of a description outside of a world, on any thread: all but its number and place there. Of several hulls the
// shape is left out, as bodies share hulls, and what make_rigid() makes of it. The error says what is wrong, but not of whom.
[[nodiscard]] Result<NewBody> make_body(const BodyDesc& desc, const WorldSettings& settings);

// The form of a compound, its lengths and what the air does to it; the shape must be known.
void finish_compound(BodyRecord& body, std::span<const BodyPart> parts);

// A rigid body of a kilogram without a shape, to be copied. Bullet counts bodies as it makes them, which no two threads may do, but not
// copies. Who copies it gives the copy all that Bullet would.
[[nodiscard]] const btRigidBody& blank_body();

// Bullet's rigid body with the pose and velocity that the record begins with, and its proxy; the shape must be known. On any thread.
void make_rigid(NewBody& body, const BodyDesc& desc, const WorldSettings& settings);

// Who meets whom (SweepBroadphase::may_meet()), first for Bullet's filter: fixed bodies do not meet each other, debris does not
// either.
[[nodiscard]] int group_of(bool fixed, bool debris);
[[nodiscard]] int partners_of(bool fixed, bool debris);
// Of what moves, debris meets what is at least so long (BodyMeasures::longest), others meet all; where it comes into a crowd, so long
// times crowding(). The same factor for what is debris by its size and by its number: contacts with its like cost as much of either.
[[nodiscard]] float min_partner_of(const BodyRecord& body);

// Sums of one body; see World::mechanics().
[[nodiscard]] Mechanics mechanics_of(const BodyRecord& body, const glm::vec3& gravity);

} // namespace brittle::physics

// The rigid-body world: bodies of one or several convex hulls, a ground plane, a fixed time step.
//
// Right-handed, Y up, metres, kilograms, seconds, radians. Vectors are in world coordinates unless stated.
//
// WorldSettings::engine chooses between two engines: Brittle's own solver, the default, for which all of the following
// holds, and stock Bullet as a reference (bullet/bullet_engine.h lists its differences).
//
// - A body's frame has its origin at the centre of mass. Its pose maps body coordinates to the world:
//   world = position + orientation * local. The inertia tensor may be any symmetric one in that frame.
// - Bodies keep the order in which they were added; bodies() and visit_poses() follow it.
// - Time advances in fixed steps only. The same calls on a new or cleared World give the same states bit for bit
//   (state_hash()), with any number of threads and every compiler that keeps to IEEE arithmetic without contraction.
// - Several hulls make one rigid body (a compound). They may touch and overlap each other.
// - Continuous collision: no body passes through a fixed one, however fast and thin. Two moving bodies do not pass
//   through each other either, except for crumbs and rare cases of similar mass. A fast body stops at its time of
//   impact (solver/continuous_collision.h), or its contact is made before the touch (solver/hull_contact.h).
// - contacts() lists the contacts of the last step with their impulses.
// - Air slows moving bodies (WorldSettings::air_density); it deflects and reverses none.
// - Without air, a free body conserves angular momentum and energy, for any inertia (solver/free_rotation.h).
// - A World is not thread-safe; several Worlds may be used at once on several threads. A step itself works on several
//   threads (WorldSettings::threads).
//
//     World world({.ground_height = 0.0f});
//     Result<std::vector<BodyId>> bodies = add_pieces(world, fragments, {});   // pieces.h
//     each frame:
//         float alpha = world.advance(frame_seconds);
//         world.visit_poses(alpha, 0, [&](size_t i, const Pose& pose) { instances[i] = pose; });
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "fracture/base/error.h"
#include "physics/world/hull.h"

namespace brittle::physics {

using fracture::Result;

enum class EngineKind {
    solver, // Brittle's own
    bullet  // stock Bullet, the reference
};

// The name as on the command line and in recipes.
[[nodiscard]] constexpr const char* to_string(EngineKind engine) {
    return engine == EngineKind::bullet ? "bullet" : "solver";
}

struct WorldSettings {
    EngineKind engine = EngineKind::solver;
    glm::vec3 gravity{0.0f, -9.81f, 0.0f};     // m/s^2
    float step = 1.0f / 120.0f;                // s; longer steps let piles sag, shorter ones cost in proportion
    uint32_t threads = 0;                      // of a step; 0: one per core. Results do not depend on their number
    uint32_t max_substeps = 4;                 // steps that one advance() may take; time beyond them is dropped
    std::optional<float> ground_height = 0.0f; // m, a plane y = height, solid below; nothing: no ground
    float ground_friction = 0.6f;              // Coulomb coefficient, multiplied by a body's friction
    float ground_restitution = 0.3f;           // multiplied by a body's restitution
    float linear_damping = 0.0f;               // fraction of velocity lost in one second, 0 .. 1
    float angular_damping = 0.0f;              // fraction of angular velocity lost in one second, 0 .. 1
    // kg/m^3. Still air slows a body's translation and rotation with the square of its speed and in proportion to its
    // cross section (solver/air_drag.h). Drag below a thirtieth of gravity is left out. 1000: water, but nothing
    // floats. 0: a vacuum.
    float air_density = 1.2f;
    // Substeps in which a step solves its contacts (solver/row.h). More hold up taller stacks and larger ratios of mass;
    // two more cost a twentieth of a step.
    uint32_t solver_substeps = 8;
    // m/s, upper bound of the speed at which overlapping hulls are moved apart. Hulls of pieces that are not convex
    // overlap their neighbours from the start: a high speed drives them apart visibly, a low one lets hard impacts
    // overlap for longer. The correction leaves velocities as they are.
    float separation_speed = 0.2f;
    // m. A moving body whose longest side is below this is debris: it meets moving bodies of its size as an ellipsoid
    // (solver/ellipsoid_contact.h), and everything that it connects is solved by fewer and simpler steps
    // (solver/debris_solver.h). 0: no debris.
    float debris_size = 0.02f;
    // Limit on awake bodies that are no debris. Beyond it the smaller pieces of a broken object are added as debris,
    // whatever their size (crowd.h): a heap of debris costs two fifths of a heap of hulls. A piece's kind is decided
    // when it is added and does not change. 0: no limit, for runs that need not be real-time.
    uint32_t max_colliding = 500;
    // A body that touches something and stays below both speeds comes to rest: after half of the time its remaining
    // jitter is damped, after all of it the body sleeps, together with all bodies that it touches, until something
    // disturbs it. A body that only rocks in place, or trembles in a heap with nine tenths of its mass at rest,
    // sleeps after two to three times as long. A body that touches nothing never sleeps.
    bool sleeping = true;
    float sleep_linear_speed = 0.08f; // m/s
    float sleep_angular_speed = 0.8f; // rad/s
    float sleep_seconds = 0.5f;       // s
};

// Checks settings that come from outside (a recipe, a command line). The error names the field, its value and its
// range.
[[nodiscard]] Result<void> validate(const WorldSettings& settings);

// The handle of a body of one World. Never reused within a World: the handle of a removed body stays invalid.
struct BodyId {
    uint32_t value = UINT32_MAX; // the default names no body

    friend auto operator<=>(BodyId, BodyId) = default;
};
std::ostream& operator<<(std::ostream& stream, BodyId id);

// The handle of a joint of one World; never reused within it. joint.h has the manual of joints.
struct JointId {
    uint32_t value = UINT32_MAX; // the default names no joint

    friend auto operator<=>(JointId, JointId) = default;
};
std::ostream& operator<<(std::ostream& stream, JointId id);
enum class JointKind : uint8_t { ball, hinge, distance, fixed };
struct Joint;
struct JointDesc;
struct LooseJoint;

struct Pose {
    glm::vec3 position{0.0f};                      // of the centre of mass, m
    glm::quat orientation{1.0f, 0.0f, 0.0f, 0.0f}; // w, x, y, z; unit
};

// One of the hulls of a compound. Any number of parts and bodies may share a hull, which is then prepared once, so
// that a body that breaks is rebuilt quickly. It must not change while it is in use.
struct BodyPart {
    std::shared_ptr<const CollisionHull> hull{}; // relative to an origin of its own, in body axes
    glm::vec3 offset{0.0f};                      // of that origin from the centre of mass, in body axes, m
};

struct BodyForm; // body_form.h; see make_form()

struct BodyDesc {
    CollisionHull hull{};          // relative to the centre of mass, in body axes
    std::vector<BodyPart> parts{}; // if any, these are the body's hulls, in place of hull
    // If not null, it replaces hull, parts, fixed, mass and inertia, which are then not read; bodies may share it.
    std::shared_ptr<const BodyForm> form{};
    // Never moves. Fixed bodies collide neither with each other nor with the ground, and are never awake. Velocities
    // and inertia are not read, and mechanics() is zero.
    bool fixed = false;
    bool debris = false; // whatever its size (WorldSettings::debris_size); a fixed body never is
    // Number of the cut, from World::new_siblings(), for pieces of one cut that are added between two steps and do not
    // overlap; 0: none. While they move as one rigid body, the narrow phase skips the pairs between them.
    uint32_t siblings = 0;
    float mass = 1.0f;       // kg, > 0
    glm::mat3 inertia{1.0f}; // kg m^2 about the centre of mass in body axes; symmetric
    Pose pose{};
    std::optional<Pose> previous{};   // a step ago, for interpolation; empty: equal to pose
    glm::vec3 linear_velocity{0.0f};  // m/s, of the centre of mass
    glm::vec3 angular_velocity{0.0f}; // rad/s, world axes
    float friction = 0.6f;            // Coulomb coefficient; those of two bodies are multiplied
    float restitution = 0.3f;         // 0: inelastic, 1: elastic; multiplied
};

// Computes, on any thread, the part of a body that does not depend on its place and its world: most of the cost of
// adding it. Null for several hulls, which bodies share in a world. Fails as add_body().
[[nodiscard]] Result<std::shared_ptr<const BodyForm>> make_form(const BodyDesc& desc);

// One point at which two bodies pressed on each other in the last step.
struct Contact {
    BodyId a;
    BodyId b;            // the default for the ground
    uint32_t part_a = 0; // index into BodyDesc::parts; 0 for one hull
    uint32_t part_b = 0;
    glm::vec3 point{0.0f};    // m
    glm::vec3 normal{0.0f};   // unit, from b towards a
    float impulse = 0.0f;     // N s, on a along the normal, and on b against it; never below 0
    glm::vec3 friction{0.0f}; // N s, on a across the normal, and on b against it
    // N s along the normal, of the solution before either body broke: equal to impulse unless the contact was solved
    // again for the parts (Structure). Breaking is decided by it.
    float blow = 0.0f;
    float gap = 0.0f;   // m, at the start of the step; negative: overlap
    float speed = 0.0f; // m/s, approach along the normal before the step; negative: separation
};

// A hull that World::cast() meets.
struct CastHit {
    uint32_t part = 0;    // index into BodyDesc::parts of the target; 0 for one hull
    float seconds = 0.0f; // from now until the two meet
    // World, m, at the target's present pose: the middle of the part of the target's hull that lies in the way, across
    // the motion.
    glm::vec3 point{0.0f};
    glm::vec3 direction{0.0f}; // unit, of the cast body's motion against the target
};

// The straight way from one point to another.
struct Ray {
    glm::vec3 from{0.0f}, to{0.0f}; // m
};

// Where a ray first enters a body or the ground (World::cast_ray()).
struct RayHit {
    BodyId body{};          // the default for the ground
    uint32_t part = 0;      // index into BodyDesc::parts; 0 for one hull
    float share = 0.0f;     // of the way, 0 to 1
    glm::vec3 point{0.0f};  // m
    glm::vec3 normal{0.0f}; // unit, of the surface, against the ray
};

// Sums over one or all bodies, in double so that differences between steps are meaningful.
struct Mechanics {
    double kinetic = 0.0;             // J, of translation and rotation
    double potential = 0.0;           // J, in the world's gravity; zero at the origin
    glm::dvec3 momentum{0.0};         // kg m/s
    glm::dvec3 angular_momentum{0.0}; // kg m^2/s, about the world's origin
};

struct DebugLine {
    glm::vec3 from;
    glm::vec3 to;
    glm::vec3 colour; // linear RGB, 0 .. 1
};

struct DebugDraw {
    bool hulls = true;     // red: awake, dark red: asleep
    bool contacts = false; // yellow: 5 cm along the normal at each contact point
    bool joints = true;    // green: between the anchors, and 10 cm along the axis of a hinge
};

class World {
  public:
    // Asserts that the settings are valid: see validate().
    explicit World(const WorldSettings& settings = {});
    ~World();
    World(World&&) noexcept;
    World& operator=(World&&) noexcept;

    [[nodiscard]] const WorldSettings& settings() const;

    // Appends a body. Fails (invalid_setting) on non-finite values, a mass or inertia that no body can have, an
    // orientation without length, a part without a hull, or a hull of fewer than 4 points; the world is then
    // unchanged. Eigenvalues of the inertia below a ten-thousandth of the largest (needles, flakes) are raised to it,
    // which keeps the solver stable.
    Result<BodyId> add_body(const BodyDesc& desc);
    // Appends several bodies, all or none. The state equals that after add_body() for each in turn, bit for bit, and
    // an error is that of the first body that is refused. Bodies of one hull are made on several threads.
    Result<std::vector<BodyId>> add_bodies(std::span<const BodyDesc> descs);
    // Calls describe(i) for each body as it is made: on several threads, in any order, and twice for bodies of
    // several hulls. Equal calls must return equal descriptions and leave the world alone.
    Result<std::vector<BodyId>> add_bodies(size_t count, const std::function<BodyDesc(size_t)>& describe);
    // Returns a number for BodyDesc::siblings that was never returned before.
    uint32_t new_siblings();
    // Removes a body and its joints, and wakes the bodies that touched it or were jointed to it; later bodies move up
    // by one in body order. Returns false if the handle names no body.
    bool remove_body(BodyId id);

    // Adds a joint and wakes its bodies. Fails (invalid_setting) on a body that does not exist or is on both sides,
    // non-finite values, an axis without length, or lengths or a force out of range; the message names the field.
    Result<JointId> add_joint(const JointDesc& desc);
    // Removes a joint and wakes its bodies. Returns false if the handle names no joint.
    bool remove_joint(JointId id);
    [[nodiscard]] bool has_joint(JointId id) const;
    [[nodiscard]] std::span<const JointId> joints() const; // ascending
    [[nodiscard]] std::vector<JointId> joints_of(BodyId body) const;
    [[nodiscard]] const Joint& joint(JointId id) const; // precondition: has_joint(id)
    // The point of one side, m; b for `second`. Precondition: has_joint(id).
    [[nodiscard]] glm::vec3 joint_anchor(JointId id, bool second) const;
    // N, that the joint exerted in the last step, on average. Precondition: has_joint(id).
    [[nodiscard]] float joint_force(JointId id) const;
    // The joints that broke in the last step, ascending. They are removed.
    [[nodiscard]] std::span<const JointId> broken_joints() const;
    // For a body that its pieces are about to replace: removes its joints and returns them. put_joint() then adds each
    // one again, with its handle, to the piece that holds the anchor; it returns false if the other body is gone too,
    // or is the same.
    [[nodiscard]] std::vector<LooseJoint> take_joints(BodyId body);
    bool put_joint(const LooseJoint& loose, BodyId piece);

    // Removes all bodies, joints and the history: the world then behaves like a new one. Handles are not reused.
    void clear();
    // Continues with other settings, which must be valid.
    void clear(const WorldSettings& settings);

    [[nodiscard]] size_t body_count() const;
    [[nodiscard]] uint64_t removed_count() const; // since the world was made, by clear() too
    [[nodiscard]] bool contains(BodyId id) const;
    [[nodiscard]] std::span<const BodyId> bodies() const; // in body order

    // Advances by exactly settings().step.
    void step();
    // Takes as many steps as fit into the time since the last call, at most max_substeps. Returns the alpha of
    // visit_poses(): the position, 0 .. 1, of the remaining time between the previous poses and the current ones.
    // Negative and non-finite seconds count as none. Calls after_step, if any, after each step: reactions to contacts
    // belong there.
    float advance(double seconds, const std::function<void()>& after_step = {});
    [[nodiscard]] uint64_t steps_taken() const;

    // Calls visit for each body in body order, with its index in bodies() and its interpolated_pose(). Bodies with
    // last_moved_step() < since are skipped: a caller that keeps poses passes the steps_taken() of its previous
    // visit, and passes 0 after a removal, which shifts the indices of later bodies.
    using PoseVisitor = std::function<void(size_t index, const Pose& pose)>;
    void visit_poses(float alpha, uint64_t since, const PoseVisitor& visit) const;
    // The value of steps_taken() after the last step that changed the pose, or when the body was added.
    [[nodiscard]] uint64_t last_moved_step(BodyId id) const;

    // Of one body, which must exist. Velocities are those after the last step.
    [[nodiscard]] Pose pose(BodyId id) const;
    [[nodiscard]] Pose previous_pose(BodyId id) const; // before the last step
    // From previous_pose() (alpha 0) to pose() (alpha 1): positions linearly, orientations spherically. Exactly
    // pose() for alpha >= 1 and for a body that the last step did not move.
    [[nodiscard]] Pose interpolated_pose(BodyId id, float alpha) const;
    [[nodiscard]] glm::vec3 linear_velocity(BodyId id) const;
    [[nodiscard]] glm::vec3 angular_velocity(BodyId id) const;
    [[nodiscard]] float mass(BodyId id) const; // kg; of a fixed body too
    [[nodiscard]] bool fixed(BodyId id) const;
    [[nodiscard]] bool debris(BodyId id) const;
    [[nodiscard]] bool awake(BodyId id) const;
    [[nodiscard]] Mechanics mechanics(BodyId id) const;

    // Applies an impulse, N s, at a point, and wakes the body. No effect on a fixed one.
    void apply_impulse(BodyId id, glm::vec3 impulse, glm::vec3 point);
    // Replaces both velocities (m/s of the centre of mass; rad/s) by finite ones and wakes the body. No effect on a
    // fixed one.
    void set_velocity(BodyId id, glm::vec3 linear, glm::vec3 angular);

    // Undoes the contacts of the last step for a body that breaks in it (Structure): restores the pose at the start of
    // the step and the velocity of that time plus a step of gravity and the impulses of joints, and returns the time,
    // s, that the body still has to move. The caller applies impulses anew and then calls move_on(). It must amend all
    // contacts of the body and undo their effects on other bodies. Other changes of velocity since the step remain. A
    // fixed body is unchanged; a body that was added after the step has no time left.
    float rewind(BodyId id);
    // The body at which continuous collision ended the last step of a moving body early; BodyId{} for none.
    [[nodiscard]] BodyId stopped_by(BodyId id) const;
    // Moves a body for `seconds` at its velocity, without contacts.
    void move_on(BodyId id, float seconds);
    // Replaces an entry of contacts(), which must have been called since the step.
    void amend_contact(size_t index, const Contact& contact);

    // Returns the hulls of `target` that a body of one hull would meet within `seconds`, each as if the others were not
    // there, if both went on at their velocities. In order of time, then of part. Empty for a body of several hulls.
    [[nodiscard]] std::vector<CastHit> cast(BodyId id, BodyId target, float seconds) const;

    // Returns where a ray first enters a hull or the ground; nothing where it meets none, and for a ray without length or
    // with a coordinate that is not finite. The hulls are where pose() has their bodies, with their margins; all bodies
    // count: fixed, sleeping and debris. A hull that contains the start, or has it on its surface, is not met, nor is the
    // ground from below. Of hulls that are entered at the same point, the first in body order counts, then the lowest
    // part. Changes nothing.
    // The margin moves each face outwards and leaves edges sharp; a ray may pass the tip of a very sharp corner, beyond
    // the margin from the points. On Bullet, edges are round, and the point is exact to a centimetre.
    [[nodiscard]] std::optional<RayHit> cast_ray(const Ray& ray) const;
    // As cast_ray() for each ray, with as many hits. Rays that are near each other share the search for bodies: one call
    // for many rays is several times as fast as a call for each.
    void cast_rays(std::span<const Ray> rays, std::span<std::optional<RayHit>> hits) const;

    // The speed, m/s, that an impulse of 1 N s along a unit direction gives the body's point along it: the inverse of
    // the effective mass there. 0 for a fixed body.
    [[nodiscard]] float response(BodyId id, glm::vec3 point, glm::vec3 direction) const;
    // The inverse of the inertia, 1/(kg m^2), in world axes; zero for a fixed body.
    [[nodiscard]] glm::mat3 inverse_inertia(BodyId id) const;
    void wake_all();

    // The contacts of the last step, in a fixed order. Contacts between sleeping bodies have the impulses of the time
    // when the bodies fell asleep. The velocities of the bodies include these impulses. Contacts of bodies that were
    // removed since the step stay in the list; those of bodies that a removal woke appear again after the next step.
    // Valid until the next step.
    [[nodiscard]] std::span<const Contact> contacts() const;
    // The first part of contacts(): the contacts with an awake body, the only ones that the step changed. With
    // thousands of sleeping bodies it costs a tenth of contacts(). Valid until contacts() is called, or the next step.
    [[nodiscard]] std::span<const Contact> solved_contacts() const;

    [[nodiscard]] Mechanics mechanics() const;
    // Each step counts these bodies; the calls take constant time.
    [[nodiscard]] size_t awake_count() const;
    [[nodiscard]] size_t colliding_count() const; // awake bodies without debris
    [[nodiscard]] size_t contact_count() const;   // contact points that touch

    // Hash of all poses, velocities and sleeping states in body order.
    [[nodiscard]] uint64_t state_hash() const;

    // Appends the edges of the collision hulls (the paper's figure 10). They lie a margin inside the pieces, so draw
    // them without a depth test. The ground is left out.
    void debug_lines(std::vector<DebugLine>& out, const DebugDraw& draw = {}) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace brittle::physics

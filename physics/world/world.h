// The rigid-body world: bodies of one or several convex hulls, a ground plane, a fixed time step.
//
// Right-handed, Y up, metres, kilograms, seconds. The engine behind it is Bullet, which appears in
// physics/bullet/ and in .cpp files only.
//
// - A body's frame has its origin at the centre of mass. Its pose maps body coordinates to the world:
//   world = position + orientation * local. The inertia tensor may be any symmetric one in that frame: that
//   Bullet wants principal axes is hidden here.
// - Bodies keep the order in which they were added; visit_poses() follows it.
// - Time advances in fixed steps only. The same calls on a new (or cleared) World give the same state bit for
// bit
//   (state_hash()) with one build on one machine.
// - Several hulls make one rigid body (a compound). They may touch and overlap each other.
// - However fast and thin, bodies do not pass through fixed ones, nor, but for crumbs and rare cases among those of like mass,
//   through each other: who would ends its step where they touch, and the next step has the contact with all of its speed
//   (solver/step_stops.h), or the two have their contact before they touch (solver/hull_contact.h).
// - After each step, contacts() tells who pressed on whom, where, and how hard.
// - Air brakes what moves (WorldSettings::air_density); nothing is turned or reversed by it.
// - Without air, angular momentum and energy of a freely spinning body are conserved (rotation.h), for any inertia.
// - Not thread-safe, and two Worlds must not step at the same time: Bullet keeps globals. A step itself works on several
//   threads (WorldSettings::threads); what happens does not depend on how many, bit for bit.
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

struct WorldSettings {
    glm::vec3 gravity{0.0f, -9.81f, 0.0f};     // m/s^2
    float step = 1.0f / 120.0f;                // s; longer steps let piles sag, shorter ones cost in proportion
    uint32_t threads = 0;                      // that share a step; 0: one a core. Results do not depend on it
    uint32_t max_substeps = 4;                 // steps one advance() may take; time beyond them is dropped
    std::optional<float> ground_height = 0.0f; // m, a plane y = height, solid below; nothing: no ground
    float ground_friction = 0.6f;              // multiplied with a body's friction
    float ground_restitution = 0.3f;           // multiplied with a body's restitution
    float linear_damping = 0.0f;               // fraction of velocity lost in one second, 0 .. 1
    float angular_damping = 0.0f;              // fraction of angular velocity lost in one second, 0 .. 1
    // kg/m^3, of air that stands still and brakes what moves with the square of its speed, and its spin likewise, by the shadow
    // that its hulls throw (solver/air_drag.h); what it takes of less than a thirtieth of gravity is left out. 1000: water, but nothing
    // floats. 0: a vacuum.
    float air_density = 1.2f;
    uint32_t solver_iterations = 20; // more: stiffer piles; 10 more cost about a tenth of a step
    // How fast overlapping hulls are moved apart, m/s. Pieces that are not convex overlap their neighbours
    // with their hulls at birth: a high speed blows them apart, a low one lets hard impacts overlap for
    // longer. Moving apart gives no velocity.
    float separation_speed = 0.2f;
    // Bodies whose longest extent is below this, m, are debris: of what moves they collide with large bodies only, which are no
    // debris and at least twice as long (or BodyDesc::large). They lie on the ground and on what is fixed, but not on each
    // other and their like. What a blow leaves by the hundred then costs a tenth. Where debris comes by the thousand, what it meets
    // must be longer yet (crowding() in crowd.h). 0: no debris.
    float debris_size = 0.02f;
    // Awake bodies that collide with each other, at most, as far as pieces of what breaks add to them: where there would be
    // more, the smaller ones of those that come are debris, too, however large (crowd.h). It keeps a step from growing with
    // every break: with a thousand more that meet it takes two to three times as long, with as much debris a third more. The default
    // is what two cores of 2.3 GHz bear within 8 ms as a bunny of a thousand pieces lands; a thousand take 13. What it
    // costs is that such pieces lie in each other and in their like. Decided when a piece comes, and it stays so; results
    // repeat as ever. 0: no limit, for who bakes what nobody waits for.
    uint32_t max_colliding = 500;
    // Sleeping. A body that touches something and stays below both speeds is coming to rest: after half of
    // the time its remaining jitter is damped away, after the whole time it sleeps, together with all it
    // touches, until something disturbs it. What only rocks in place, or trembles in a heap of which nine tenths of the
    // mass are at rest, sleeps after two to three times as long. A body that touches nothing never sleeps.
    bool sleeping = true;
    float sleep_linear_speed = 0.08f; // m/s
    float sleep_angular_speed = 0.8f; // rad/s
    float sleep_seconds = 0.5f;       // s
};

// What is wrong with settings that came from outside (a recipe, a command line): the field, its value, its
// range.
[[nodiscard]] Result<void> validate(const WorldSettings& settings);

// Names a body of one World. Never reused within a World, so a handle of a removed body is recognised as
// such.
struct BodyId {
    uint32_t value = UINT32_MAX; // the default names no body

    friend auto operator<=>(BodyId, BodyId) = default;
};
std::ostream& operator<<(std::ostream& stream, BodyId id);

struct Pose {
    glm::vec3 position{0.0f};                      // of the centre of mass, m
    glm::quat orientation{1.0f, 0.0f, 0.0f, 0.0f}; // w, x, y, z; unit
};

// One of the hulls of a body. A hull may be shared by any number of parts and bodies: what Bullet needs to know of
// it is then made once, so that a body that breaks is rebuilt quickly. It must not change while it is in use.
struct BodyPart {
    std::shared_ptr<const CollisionHull> hull{}; // relative to an origin of its own, in body axes
    glm::vec3 offset{0.0f};                      // of that origin from the centre of mass, in body axes, m
};

struct BodyForm; // see make_form()

struct BodyDesc {
    CollisionHull hull{};          // relative to the centre of mass, in body axes
    std::vector<BodyPart> parts{}; // if any, these are the body's hulls, in place of hull
    // If any, made of the hull or part, fixed, mass and inertia, which are then not looked at again; bodies may share it.
    std::shared_ptr<const BodyForm> form{};
    // Held by the world: never moves, whatever pushes it. Fixed bodies do not collide with each other and the ground, and
    // are never awake; velocities and inertia are not looked at, and mechanics() counts them as nothing.
    bool fixed = false;
    bool debris = false; // also if it is not small (WorldSettings::debris_size); a fixed body never is
    bool large = false;  // debris collides with it however small it is, unless it is debris itself: a ball that is shot
    // Bodies that come between the same two steps with the same number, if it is one of World::new_siblings(), do not overlap:
    // pieces of one cut. While they fly as one, nobody looks for contacts between them.
    uint32_t siblings = 0;
    float mass = 1.0f;       // kg, > 0
    glm::mat3 inertia{1.0f}; // kg m^2 about the centre of mass in body axes; symmetric
    Pose pose{};
    std::optional<Pose> previous{};   // where it was a step ago, to interpolate from; nothing: as pose
    glm::vec3 linear_velocity{0.0f};  // m/s, of the centre of mass
    glm::vec3 angular_velocity{0.0f}; // rad/s, world axes
    float friction = 0.6f;            // Coulomb coefficients of two bodies are multiplied
    float restitution = 0.3f;         // 0: dead, 1: elastic; multiplied likewise; fast falls bounce less
};

// All of a body of one hull that does not depend on where and in which world it is, the greater part of what adding it costs: made
// ahead, on any thread. Of several hulls it is null, as their bodies share hulls in the world. Fails as add_body() does.
[[nodiscard]] Result<std::shared_ptr<const BodyForm>> make_form(const BodyDesc& desc);

// Two bodies that pressed on each other in the last step, at one point.
struct Contact {
    BodyId a;
    BodyId b;            // the default if it is the ground
    uint32_t part_a = 0; // which of the body's hulls: index into BodyDesc::parts, 0 where there are none
    uint32_t part_b = 0;
    glm::vec3 point{0.0f};    // world, m
    glm::vec3 normal{0.0f};   // unit, world, from b towards a
    float impulse = 0.0f;     // N s, never below 0: what a got along the normal, and b against it
    glm::vec3 friction{0.0f}; // N s, across the normal: what a got, and b against it
    // N s along the normal for which a and b were asked before either broke: impulse, unless that was solved anew for their
    // parts (Structure). It is what breaks them.
    float blow = 0.0f;
    float gap = 0.0f;   // m between a and b when the step began, which it may have closed; below 0: overlap
    float speed = 0.0f; // m/s at which a and b approached there before the step, along the normal; below 0: parting
};

// Sums over all bodies (or of one), in double so that differences between steps mean something.
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
};

class World {
  public:
    // Asserts that the settings are valid: see validate().
    explicit World(const WorldSettings& settings = {});
    ~World();
    World(World&&) noexcept;
    World& operator=(World&&) noexcept;

    [[nodiscard]] const WorldSettings& settings() const;

    // Adds a body behind all others. Fails (invalid_setting) on non-finite values, a mass or inertia that no
    // body can have, an orientation of no length, a part without hull or a hull of fewer than 4 points; the world is
    // then unchanged. Eigenvalues of the inertia below a ten-thousandth of the largest (needles, flakes) are
    // raised to it, for the solver's sake.
    Result<BodyId> add_body(const BodyDesc& desc);
    // Adds them one behind the other, all or none: the same state, bit for bit, as add_body() for each in turn, and the error
    // that it would give for the first that is refused. Bodies of one hull are made side by side
    // (WorldSettings::threads).
    Result<std::vector<BodyId>> add_bodies(std::span<const BodyDesc> descs);
    // The same, each described as it is made: on several threads at once, in any order, and once more, alike, where it has several
    // hulls. Describing must leave the world alone.
    Result<std::vector<BodyId>> add_bodies(size_t count, const std::function<BodyDesc(size_t)>& describe);
    // A number for BodyDesc::siblings that was not given before.
    uint32_t new_siblings();
    // Removes a body and wakes what it touched; later bodies move up by one in body order. False if there is
    // none.
    bool remove_body(BodyId id);
    // Removes all bodies and forgets the history: the world behaves as a new one does. Handles stay unused.
    void clear();
    // The same, and goes on under other settings; asserts that they are valid.
    void clear(const WorldSettings& settings);

    [[nodiscard]] size_t body_count() const;
    [[nodiscard]] uint64_t removed_count() const; // bodies that were removed so far, cleared ones among them
    [[nodiscard]] bool contains(BodyId id) const;
    [[nodiscard]] std::span<const BodyId> bodies() const; // in body order

    // Advances by exactly settings().step.
    void step();
    // Takes as many steps as fit into the time gone by, at most max_substeps, and returns how far, 0 .. 1, the rest
    // of it reaches from the previous pose to the current: the alpha of visit_poses(). Negative and non-finite
    // seconds count as none. Calls after_step, if any, after each step: what answers to contacts belongs there.
    float advance(double seconds, const std::function<void()>& after_step = {});
    [[nodiscard]] uint64_t steps_taken() const;

    // Calls visit for each body in body order, with its index in bodies() and its interpolated_pose(). Bodies with
    // last_moved_step() < since are skipped: a caller that keeps poses passes the steps_taken() of its previous visit, and
    // passes 0 after a removal, which shifts the indices of later bodies.
    using PoseVisitor = std::function<void(size_t index, const Pose& pose)>;
    void visit_poses(float alpha, uint64_t since, const PoseVisitor& visit) const;
    // The last step in which the pose changed, counted as steps_taken() after it, or the steps taken when it was added.
    [[nodiscard]] uint64_t last_moved_step(BodyId id) const;

    // One body; each asserts that it exists. A velocity is that after the last step.
    [[nodiscard]] Pose pose(BodyId id) const;
    [[nodiscard]] Pose previous_pose(BodyId id) const; // before the last step
    // From previous_pose() (alpha 0) to pose() (alpha 1): positions linearly, orientations spherically. Exactly pose() for
    // alpha >= 1 and for a body that the last step did not move.
    [[nodiscard]] Pose interpolated_pose(BodyId id, float alpha) const;
    [[nodiscard]] glm::vec3 linear_velocity(BodyId id) const;
    [[nodiscard]] glm::vec3 angular_velocity(BodyId id) const;
    [[nodiscard]] float mass(BodyId id) const; // as given, also of a fixed body
    [[nodiscard]] bool fixed(BodyId id) const;
    [[nodiscard]] bool debris(BodyId id) const;
    [[nodiscard]] bool awake(BodyId id) const;
    [[nodiscard]] Mechanics mechanics(BodyId id) const;

    // Changes momentum at once: impulse in N s, applied at a point in world coordinates. Wakes the
    // body. A fixed one stays as it is.
    void apply_impulse(BodyId id, glm::vec3 impulse, glm::vec3 point);
    // Replaces both velocities (m/s of the centre of mass; rad/s, world axes) and wakes the body. Finite ones are
    // asserted; a fixed body keeps none.
    void set_velocity(BodyId id, glm::vec3 linear, glm::vec3 angular);
    // For who replaces bodies that break in a step, after it: takes back what the step's contacts did to a body. It is then
    // where the step began, with the velocity it had there and a step of gravity; returns how long, s, it has yet to move on,
    // which must follow, when impulses have been given anew. All contacts of the body must be amended, and what they did to
    // others taken back, too. Other changes of velocity since the step stay. A fixed body stays where it
    // is; one that came after the step has nothing to move on.
    float rewind(BodyId id);
    // Moves a body at its velocity, as though it touched nothing, for what rewind() returned or the body it came of.
    void move_on(BodyId id, float seconds);
    // Replaces one of contacts(), which was asked for since the step, by what became of it.
    void amend_contact(size_t index, const Contact& contact);

    // How fast a point (world coordinates) would move along a unit direction after an impulse of 1 N s there along it, in
    // m/s: one over the mass that is felt there. 0 for a fixed body.
    [[nodiscard]] float response(BodyId id, glm::vec3 point, glm::vec3 direction) const;
    void wake_all();

    // Who pressed on whom in the last step, in a fixed order. Sleeping bodies press as they did when they fell
    // asleep; what a body that was removed woke is told of again after the next step. The velocities of the bodies have these
    // impulses in them already. Bodies that were removed since are still named. Valid until the next step.
    [[nodiscard]] std::span<const Contact> contacts() const;
    // The first of them: those in which someone who was awake took part. All that is new; where thousands sleep, it is had for
    // a tenth of the time. Valid until contacts() is called, or the next step.
    [[nodiscard]] std::span<const Contact> solved_contacts() const;

    [[nodiscard]] Mechanics mechanics() const;
    // Both are kept: asking costs nothing.
    [[nodiscard]] size_t awake_count() const;
    [[nodiscard]] size_t colliding_count() const; // awake, and no debris
    [[nodiscard]] size_t contact_count() const;   // points that touch (not those that are merely near)

    // Of all poses and velocities, and of who sleeps, in body order.
    [[nodiscard]] uint64_t state_hash() const;

    // Appends the edges of the hulls that bodies collide with (the paper's figure 10). They lie a margin
    // inside the pieces, so draw them without depth test. The ground is left out.
    void debug_lines(std::vector<DebugLine>& out, const DebugDraw& draw = {}) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace brittle::physics

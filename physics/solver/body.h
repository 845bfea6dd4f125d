// A rigid body of the solver: its shape and mass, its state, and what a step remembers of it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "physics/solver/air_drag.h"
#include "physics/solver/compound_shape.h"
#include "physics/solver/hull_shape.h"
#include "physics/solver/sweep_broadphase.h"
#include "physics/solver/transform.h"
#include "physics/solver/velocity.h"
#include "physics/world/body_form.h"
#include "physics/world/hull.h"
#include "physics/world/world.h"

namespace brittle::physics {

// The properties of a body that a step reads. The solver's frame of a body has its origin at the centre of mass and its
// axes along the principal axes of inertia.
struct BodyMeasures {
    glm::quat to_principal{1.0f, 0.0f, 0.0f, 0.0f}; // body axes = to_principal * principal axes
    glm::dvec3 moments{1.0};                        // principal moments of inertia, kg m^2
    float mass = 0.0f;                              // kg; of a fixed body as given
    bool fixed = false;
    float reach = 0.0f;     // m, of the farthest point from the centre of mass
    float thickness = 0.0f; // m, of the thinnest hull
    float longest = 0.0f;   // m, the longest side of the bounds in the body's own axes
};

// What the solver computes ahead of a body; of a compound, for that one body.
struct SolverForm final : BodyForm {
    BodyMeasures measures;
    AirDrag drag;                   // that of a vacuum for a fixed body
    std::optional<HullShape> shape; // of a body with one hull; none for a compound
};

enum class Activity : uint8_t {
    awake,
    ready,        // to sleep, as soon as its whole island is
    asleep,       // also every fixed body
    never_sleeps, // WorldSettings::sleeping is off
    astray        // beyond all bounds: it stays where it is
};

struct Body : BodyMeasures {
    BodyId id;
    uint32_t index = 0; // in body order
    bool debris = false;
    Activity activity = Activity::awake;
    float friction = 0.0f, restitution = 0.0f;
    float inverse_mass = 0.0f;       // 1/kg; 0 of a fixed body
    glm::vec3 inverse_moments{0.0f}; // 1/(kg m^2), principal
    glm::mat3 inverse_inertia{0.0f}; // in world axes
    Transform frame;                 // of the principal axes in the world
    Velocity velocity;
    SweptProxy* proxy = nullptr;             // in the broadphase
    uint32_t siblings = 0;                   // pieces of one cut that fly as one (siblings.h); 0: none
    std::shared_ptr<const SolverForm> form;  // the measures are copies of its own
    std::unique_ptr<CompoundShape> compound; // null for a body with one hull
    std::vector<HullEdge> edges;             // of the one hull, for debug lines; filled when they are first drawn

    // The step.
    Transform step_start;            // the frame as the step began, after the correction of overlap
    bool corrected_at_start = false; // whether that correction moved it
    Transform correction; // of overlap found in the last step, due as the next begins: rotation and translation
    bool has_correction = false;
    float moving_seconds = 0.0f; // of the last step: less than all of it where continuous collision stopped the body
    Velocity unhindered, solved; // before contacts, with the step's gravity, and after them
    Transform rewind_frame;      // what World::rewind() goes back to,
    float rewind_seconds = 0.0f; // and the time that the body then moved without touching anything

    // Rest (sleeping.h).
    float still_seconds = 0.0f;       // how long it has been slow while it touches something
    float quiet_seconds = 0.0f;       // how long nearly all of its island has been still
    Transform rest;                   // the last place that it has moved away to
    float rest_seconds = 0.0f;        // how long it has touched something near that place
    bool touching = false;            // anything, in the last step
    bool sunk = false;                // in the ground after the last step, too deep to sleep
    bool resting = false;             // in this step: it has infinite mass
    float undisturbed_seconds = 0.0f; // how long nothing has kept it from resting
    uint32_t resting_on = 0;          // groups of four contacts that it had when it came to rest, or in the last step

    [[nodiscard]] bool awake() const { return activity != Activity::asleep && activity != Activity::astray; }
    // Neither of these leaves never_sleeps and astray.
    void set_activity(Activity to) {
        if (activity != Activity::never_sleeps && activity != Activity::astray) activity = to;
    }
    [[nodiscard]] const HullShape& hull() const { return *form->shape; } // the only one
    [[nodiscard]] Bounds bounds(const Transform& at) const {
        return compound ? compound->bounds(at) : form->shape->bounds(at);
    }
    [[nodiscard]] float rotation_radius() const {
        return compound ? physics::rotation_radius(compound->bounds({})) : form->shape->rotation_radius();
    }
    [[nodiscard]] glm::vec3 velocity_at(const glm::vec3& point) const { return velocity.at(point - frame.origin); }

    void set_frame(const Transform& to);
    // Applies the correction of overlap, unless the body sleeps, and notes where the step begins.
    void start_step();
    [[nodiscard]] bool has_moved() const { return corrected_at_start || !(frame == step_start); }
    [[nodiscard]] Pose pose() const { return pose_in(frame); }
    [[nodiscard]] Pose pose_in(const Transform& at) const {
        return {at.origin, rotation_of(at.basis) * glm::conjugate(to_principal)};
    }
};

// A body that is in no world yet, and its entry in the broadphase.
struct NewBody {
    std::unique_ptr<Body> body;
    std::unique_ptr<SweptProxy> proxy; // null until the shape is known
};

// Makes all of a body that does not depend on its world, on any thread: everything but its number and its place
// there. For several hulls the shape is left out, because bodies share hulls; finish_compound() then makes the rest.
// The error says what is wrong, but not of which body.
[[nodiscard]] Result<NewBody> make_body(const BodyDesc& desc, const WorldSettings& settings);
void finish_compound(NewBody& made, std::unique_ptr<CompoundShape> shape, const BodyDesc& desc,
                     const WorldSettings& settings);

[[nodiscard]] Mechanics mechanics_of(const Body& body, const glm::vec3& gravity);

} // namespace brittle::physics

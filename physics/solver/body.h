// A rigid body of the solver: shape, mass, state, and results of the last step.
#pragma once

#include <algorithm>
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
    float mass = 0.0f;                              // kg; a fixed body keeps the given mass
    bool fixed = false;
    float reach = 0.0f;                // m, distance of the farthest point from the centre of mass
    float thickness = 0.0f;            // m, of the thinnest hull
    float longest = 0.0f;              // m, longest side of the bounds in the body's own axes
    glm::vec3 squared_semi_axes{0.0f}; // m^2, of its ellipsoid along the axes of its frame (ellipsoid_contact.h)
};

// The solver's BodyForm: the part of a body that is computed ahead.
struct SolverForm final : BodyForm {
    BodyMeasures measures;
    AirDrag drag;                   // none for a fixed body
    std::optional<HullShape> shape; // of a body with one hull; empty for a compound
};

enum class Activity : uint8_t {
    awake,
    ready,        // to sleep, once its whole island is ready
    asleep,       // also every fixed body
    never_sleeps, // WorldSettings::sleeping is off
    astray        // left the range of coordinates: it stays where it is
};

struct Body : BodyMeasures {
    BodyId id;
    uint32_t index = 0; // in body order
    bool debris = false;
    Activity activity = Activity::awake;
    float friction = 0.0f, restitution = 0.0f;
    float inverse_mass = 0.0f;       // 1/kg; 0 for a fixed body
    glm::vec3 inverse_moments{0.0f}; // 1/(kg m^2), principal
    glm::mat3 inverse_inertia{0.0f}; // in world axes
    Transform frame;                 // of the principal axes in the world
    Velocity velocity;
    SweptProxy* proxy = nullptr;             // in the broadphase
    uint32_t cut = 0;                        // number of its cut (BodyDesc::siblings); 0: none
    uint32_t siblings = 0;                   // the same while its pieces move as one (siblings.h), then 0
    std::shared_ptr<const SolverForm> form;  // source of the measures
    std::unique_ptr<CompoundShape> compound; // null for a body with one hull
    std::vector<HullEdge> edges;             // of the one hull, for debug lines; filled when they are first drawn

    // Results of the last step.
    Transform step_start;        // frame at the start of the step
    float moving_seconds = 0.0f; // s, less than the step if continuous collision stopped the body
    Velocity motion;             // with which the body moves in the step: before its bounce (row_solver.h)
    BodyId stopped_by;           // at which continuous collision did so
    Velocity unhindered, solved; // before contacts, with the step's gravity; and after contacts
    Transform rewind_frame;      // the frame that World::rewind() restores
    float rewind_seconds = 0.0f; // s, time that the body moved from there without a contact

    uint32_t joints = 0;            // number of its joints (joints.h)
    std::vector<const Body*> apart; // bodies that it makes no contacts with, because joints connect them

    // Rest (sleeping.h).
    float still_seconds = 0.0f;       // s, of being slow while it touches something
    float quiet_seconds = 0.0f;       // s, of its island being calm
    Transform rest;                   // the place from which rocking is measured
    float rest_seconds = 0.0f;        // s, of touching something near that place
    bool touching = false;            // whether it touched anything in the last step
    bool sunk = false;                // too deep in the ground to sleep
    bool resting = false;             // has infinite mass in this step
    float undisturbed_seconds = 0.0f; // s, without anything that keeps it from resting
    uint32_t resting_on = 0;          // groups of contacts when it came to rest, else in the last step

    [[nodiscard]] bool awake() const { return activity != Activity::asleep && activity != Activity::astray; }
    // Has no effect on a body that never sleeps or is astray.
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

    [[nodiscard]] bool is_apart_from(const Body& other) const {
        return std::ranges::find(apart, &other) != apart.end();
    }
    void set_frame(const Transform& to);
    [[nodiscard]] bool has_moved() const { return !(frame == step_start); }
    [[nodiscard]] Pose pose() const { return pose_in(frame); }
    [[nodiscard]] Pose pose_in(const Transform& at) const {
        return {at.origin, rotation_of(at.basis) * glm::conjugate(to_principal)};
    }
};

// A body before it is added, and its entry in the broadphase.
struct NewBody {
    std::unique_ptr<Body> body;
    std::unique_ptr<SweptProxy> proxy; // null until the shape is known
};

// Makes a body except for its number and index in the world. Thread-safe. A compound has no shape yet, because bodies
// of a world share hulls; finish_compound() completes it. The error does not name the body.
[[nodiscard]] Result<NewBody> make_body(const BodyDesc& desc, const WorldSettings& settings);
void finish_compound(NewBody& made, std::unique_ptr<CompoundShape> shape, const BodyDesc& desc,
                     const WorldSettings& settings);

[[nodiscard]] Mechanics mechanics_of(const Body& body, const glm::vec3& gravity);

} // namespace brittle::physics

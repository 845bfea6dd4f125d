// The engine of a World: the interface that stores bodies, finds their contacts and takes one step. World adds handles,
// time and interpolation.
//
// Two engines implement it: Brittle's own solver (solver/solver.h), the default, and stock Bullet
// (bullet/bullet_engine.h). A body is named by its index in body order; remove() moves later bodies up by one. World
// coordinates, SI units. Not thread-safe; engines of different Worlds may run at the same time.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "physics/world/joint.h"
#include "physics/world/state_hash.h"
#include "physics/world/world.h"

namespace brittle::physics {

// Numbers of awake bodies.
struct AwakeCount {
    size_t colliding = 0; // without debris
    size_t debris = 0;

    [[nodiscard]] size_t& of(bool is_debris) { return is_debris ? debris : colliding; }
};

class Engine {
  public:
    Engine() = default;
    Engine(const Engine&) = delete;
    Engine& operator=(const Engine&) = delete;
    virtual ~Engine() = default;

    // Describes a body of a batch: returns the description, for which the call may fill `storage`. Called on several
    // threads, and again for the same body, with the same answer.
    using Describe = std::function<const BodyDesc&(size_t body, BodyDesc& storage)>;
    // Appends `count` bodies, all or none, with the handles first, first + 1, ...; writes the pose of each one
    // step ago. Fails as World::add_body().
    virtual Result<void> add(size_t count, BodyId first, const Describe& describe, std::span<Pose> previous) = 0;
    // Removes a body and wakes the bodies that touch it.
    virtual void remove(size_t body) = 0;

    // Advances by WorldSettings::step.
    virtual void step() = 0;
    // By body: whether the last step changed its pose. Valid until bodies are added or removed.
    [[nodiscard]] virtual std::span<const uint8_t> moved() const = 0;
    [[nodiscard]] virtual AwakeCount awake_count() const = 0;

    [[nodiscard]] virtual Pose pose(size_t body) const = 0;
    // Writes the poses of the bodies whose last moved step is `since` or later.
    virtual void write_poses(std::span<const uint64_t> moved_steps, uint64_t since, std::span<Pose> out) const = 0;
    [[nodiscard]] virtual glm::vec3 linear_velocity(size_t body) const = 0;
    [[nodiscard]] virtual glm::vec3 angular_velocity(size_t body) const = 0;
    [[nodiscard]] virtual float mass(size_t body) const = 0;
    [[nodiscard]] virtual bool fixed(size_t body) const = 0;
    [[nodiscard]] virtual bool debris(size_t body) const = 0;
    [[nodiscard]] virtual bool awake(size_t body) const = 0;
    [[nodiscard]] virtual Mechanics mechanics(size_t body) const = 0;
    // As World::stopped_by(), for a body that is not fixed.
    [[nodiscard]] virtual BodyId stopped_by(size_t body) const = 0;
    // As World::response() and World::inverse_inertia(), for a body that is not fixed.
    [[nodiscard]] virtual float response(size_t body, const glm::vec3& point, const glm::vec3& direction) const = 0;
    [[nodiscard]] virtual glm::mat3 inverse_inertia(size_t body) const = 0;

    // As the functions of World with these names, for bodies that are not fixed.
    virtual void wake(size_t body) = 0;
    virtual void apply_impulse(size_t body, const glm::vec3& impulse, const glm::vec3& point) = 0;
    virtual void set_velocity(size_t body, const glm::vec3& linear, const glm::vec3& angular) = 0;
    virtual float rewind(size_t body) = 0;
    virtual void move_on(size_t body, float seconds) = 0;
    [[nodiscard]] virtual std::vector<CastHit> cast(size_t body, size_t target, float seconds) const = 0;
    // As World::cast_rays(), without the ground. Both spans are equally long; the hits are empty at the call. Rays that
    // can_be_cast() refuses meet nothing.
    virtual void cast_rays(std::span<const Ray> rays, std::span<std::optional<RayHit>> hits) const = 0;

    // The bodies of a joint, by index; `none` for the world.
    struct JointBodies {
        static constexpr size_t none = SIZE_MAX;
        size_t a = none, b = none;
    };
    // Adds a joint that World has checked, and wakes its bodies. At least one of them is given.
    virtual void add_joint(JointId id, const Joint& joint, const JointBodies& bodies) = 0;
    // Removes a joint and wakes its bodies. World removes a body's joints before the body.
    virtual void remove_joint(JointId id) = 0;
    [[nodiscard]] virtual float joint_force(JointId id) const = 0;
    // The joints that the last step broke, ascending; the engine no longer has them.
    [[nodiscard]] virtual std::span<const JointId> broken_joints() const = 0;

    [[nodiscard]] virtual std::span<const Contact> contacts() = 0;
    [[nodiscard]] virtual std::span<const Contact> solved_contacts() = 0;
    virtual void amend_contact(size_t index, const Contact& contact) = 0;
    [[nodiscard]] virtual size_t contact_count() const = 0;

    // Adds every pose, velocity and sleeping state in body order.
    virtual void add_state(StateHash& hash) const = 0;
    virtual void debug_lines(std::vector<DebugLine>& out, const DebugDraw& draw) = 0;
};

// Makes the engine that WorldSettings::engine names. Precondition: the settings are valid. physics/engines.cpp defines
// it, so that World depends on neither engine.
[[nodiscard]] std::unique_ptr<Engine> make_engine(const WorldSettings& settings);

// Whether a ray is finite and has a length.
[[nodiscard]] inline bool can_be_cast(const Ray& ray) {
    const glm::vec3 along = ray.to - ray.from;
    return std::isfinite(along.x) && std::isfinite(along.y) && std::isfinite(along.z) && along != glm::vec3(0.0f);
}

// m; contact points with a larger gap do not count as touching (World::contact_count(), debug lines).
inline constexpr float touching_distance = 1e-3f;

// Colours and lines of World::debug_lines().
inline constexpr glm::vec3 joint_colour{0.1f, 0.9f, 0.2f};
inline constexpr float joint_axis_length = 0.1f; // m
[[nodiscard]] inline glm::vec3 hull_colour(bool awake) {
    return awake ? glm::vec3(1.0f, 0.1f, 0.1f) : glm::vec3(0.35f, 0.05f, 0.05f);
}
[[nodiscard]] inline DebugLine contact_line(const glm::vec3& at, const glm::vec3& normal) {
    constexpr float length = 0.05f; // m
    return {at, at + normal * length, {1.0f, 0.85f, 0.1f}};
}

} // namespace brittle::physics

// Brittle's rigid-body engine: contacts of convex hulls, solved by projected Gauss-Seidel.
//
// One step, in this order (Solver::step()):
//  1. bodies: damping; bounds of the path ahead
//  2. broadphase (sweep_broadphase.h), siblings (siblings.h), air drag (air_drag.h)
//  3. narrow phase (narrow_phase.h): contacts of hulls (hull_contact.h), with the ground (ground_contact.h), of
//     compounds
//  4. islands (islands.h), which wake and fall asleep; resting bodies (sleeping.h)
//  5. joints, contacts and friction, in substeps (contact_solver.h, row_solver.h, joints.h)
//  6. continuous collision (continuous_collision.h), then all bodies move, and joints close; free rotation conserves
//     energy and angular momentum (free_rotation.h)
//  7. sleeping (sleeping.h)
//
// Metres, kilograms, seconds. A step works on several threads; results do not depend on their number.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "fracture/base/threads.h"
#include "physics/solver/body.h"
#include "physics/solver/body_cast.h"
#include "physics/solver/compound_shape.h"
#include "physics/solver/contact_solver.h"
#include "physics/solver/continuous_collision.h"
#include "physics/solver/islands.h"
#include "physics/solver/joints.h"
#include "physics/solver/ray_cast.h"
#include "physics/solver/siblings.h"
#include "physics/solver/sleeping.h"
#include "physics/solver/sweep_broadphase.h"
#include "physics/world/engine.h"

namespace brittle::physics {

class Solver final : public Engine {
  public:
    explicit Solver(const WorldSettings& settings);

    Result<void> add(size_t count, BodyId first, const Describe& describe, std::span<Pose> previous) override;
    void remove(size_t body) override;

    void step() override;
    [[nodiscard]] std::span<const uint8_t> moved() const override { return moved_; }
    [[nodiscard]] AwakeCount awake_count() const override { return awake_; }

    [[nodiscard]] Pose pose(size_t body) const override { return bodies_[body]->pose(); }
    void write_poses(std::span<const uint64_t> moved_steps, uint64_t since, std::span<Pose> out) const override;
    [[nodiscard]] glm::vec3 linear_velocity(size_t body) const override { return bodies_[body]->velocity.linear; }
    [[nodiscard]] glm::vec3 angular_velocity(size_t body) const override { return bodies_[body]->velocity.angular; }
    [[nodiscard]] float mass(size_t body) const override { return bodies_[body]->mass; }
    [[nodiscard]] bool fixed(size_t body) const override { return bodies_[body]->fixed; }
    [[nodiscard]] bool debris(size_t body) const override { return bodies_[body]->debris; }
    [[nodiscard]] bool awake(size_t body) const override { return bodies_[body]->awake(); }
    [[nodiscard]] Mechanics mechanics(size_t body) const override {
        return mechanics_of(*bodies_[body], settings_.gravity);
    }
    [[nodiscard]] float response(size_t body, const glm::vec3& point, const glm::vec3& direction) const override;
    [[nodiscard]] BodyId stopped_by(size_t body) const override { return bodies_[body]->stopped_by; }
    [[nodiscard]] glm::mat3 inverse_inertia(size_t body) const override { return bodies_[body]->inverse_inertia; }

    void wake(size_t body) override { wake(*bodies_[body]); }
    void apply_impulse(size_t body, const glm::vec3& impulse, const glm::vec3& point) override;
    void set_velocity(size_t body, const glm::vec3& linear, const glm::vec3& angular) override;
    float rewind(size_t body) override;
    void move_on(size_t body, float seconds) override;
    [[nodiscard]] std::vector<CastHit> cast(size_t body, size_t target, float seconds) const override {
        return cast_body(*bodies_[body], *bodies_[target], seconds);
    }
    void cast_rays(std::span<const Ray> rays, std::span<std::optional<RayHit>> hits) const override;

    void add_joint(JointId id, const Joint& joint, const JointBodies& bodies) override;
    void remove_joint(JointId id) override;
    [[nodiscard]] float joint_force(JointId id) const override { return joints_.at(id).force; }
    [[nodiscard]] std::span<const JointId> broken_joints() const override { return joints_.broken(); }

    [[nodiscard]] std::span<const Contact> contacts() override { return contacts_.contacts(); }
    [[nodiscard]] std::span<const Contact> solved_contacts() override { return contacts_.solved_contacts(); }
    void amend_contact(size_t index, const Contact& contact) override { contacts_.amend_contact(index, contact); }
    [[nodiscard]] size_t contact_count() const override;

    void add_state(StateHash& hash) const override;
    void debug_lines(std::vector<DebugLine>& out, const DebugDraw& draw) override;

  private:
    std::shared_ptr<SharedHull> shared_hull(const std::shared_ptr<const CollisionHull>& hull);
    [[nodiscard]] std::unique_ptr<CompoundShape> compound_of(const Body& body, const BodyDesc& desc);
    void wake(Body& body);

    // The parts of a step.
    void start_bodies();
    void set_bounds(Body& body);
    void brake_by_air();
    void find_islands();
    void solve_contacts();
    void move_bodies();
    static void move(Body& body, float seconds);
    void lose_fall(Body& body, float seconds) const;
    void note_moved();

    WorldSettings settings_;
    mutable fracture::Threads threads_;         // mutable: the split of a loop changes no result
    std::vector<std::unique_ptr<Body>> bodies_; // in body order
    std::vector<uint8_t> moved_;                // by body
    AwakeCount awake_;
    // Hulls that bodies share, by address: an entry holds its hull, so that an address names one hull.
    std::unordered_map<const CollisionHull*, std::shared_ptr<SharedHull>> shared_hulls_;
    size_t max_shared_hulls_ = 64; // beyond that, hulls without a body are dropped
    SweepBroadphase broadphase_{threads_};
    Siblings siblings_;
    Joints joints_;
    Islands islands_;
    ContactSolver contacts_{settings_, broadphase_};
    ContinuousCollision continuous_collision_{bodies_, broadphase_, threads_};
    Sleeping sleeping_{settings_, bodies_, islands_, threads_};
    std::vector<Body*> moved_on_; // since the step, by move_on(): they may have left their bounds
    std::vector<Body*> stepped_;  // bodies that were awake at any time of the step
};

// Precondition: the settings are valid.
[[nodiscard]] std::unique_ptr<Engine> make_solver(const WorldSettings& settings);

} // namespace brittle::physics

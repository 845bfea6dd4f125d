// Contact manifolds: the points at which two hulls, or a hull and the ground, touch or will touch in this step.
//
// A manifold of two hulls keeps up to four points from step to step, with the impulses that the solver starts from
// (warm starting). A point belongs to the same contact as long as it stays within the breaking threshold.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "physics/solver/body.h"
#include "physics/solver/prefetch.h"

namespace brittle::physics {

// m/s. A contact that closed faster is a blow: the next solution does not start from its impulse. The impulse that
// stops a blow is a hundred times the impulse of the next step, and the part that the sweeps do not take back would add
// energy.
inline constexpr float blow_speed = 0.2f;

// Returns the friction coefficient of two bodies, or of a body and the ground.
[[nodiscard]] inline float combined_friction(float a, float b) {
    constexpr float max_friction = 10.0f; // a higher one changes nothing but slows convergence
    return std::min(a * b, max_friction);
}

// World coordinates, m; the normal points from b to a.
struct ContactPoint {
    glm::vec3 local_a{0.0f}, local_b{0.0f}; // in the bodies' frames
    glm::vec3 on_a{0.0f}, on_b{0.0f};       // on the surfaces, margin included
    glm::vec3 normal{0.0f};
    float distance = 0.0f;           // along the normal; below 0: overlap
    uint32_t part_a = 0, part_b = 0; // hulls of compounds
    // Results of the last solution.
    float normal_impulse = 0.0f, friction_impulse = 0.0f; // N s, on a; 0 after a blow
    glm::vec3 tangent{0.0f};                              // unit direction of friction on a
};

// The points between two bodies, or between one hull of each.
class Manifold {
  public:
    static constexpr uint32_t max_points = 4;

    Manifold(const Body& a, const Body& b);

    [[nodiscard]] const Body& a() const { return *a_; }
    [[nodiscard]] const Body& b() const { return *b_; }
    [[nodiscard]] std::span<ContactPoint> points() { return std::span(points_).first(count_); }
    [[nodiscard]] std::span<const ContactPoint> points() const { return std::span(points_).first(count_); }
    [[nodiscard]] uint32_t count() const { return count_; }
    [[nodiscard]] float friction() const { return combined_friction(a_->friction, b_->friction); }
    [[nodiscard]] float restitution() const { return a_->restitution * b_->restitution; }

    // m. A point ends beyond this distance along the normal or across it. Points of a body that are nearer to each
    // other than this are one contact.
    [[nodiscard]] float breaking_threshold() const { return breaking_threshold_; }
    void set_breaking_threshold(float threshold) { breaking_threshold_ = threshold; }

    // Adds the contact at a point on b, or moves a contact within the threshold, which keeps its impulses. Of five
    // points the new one and the deepest stay, with those that span the largest area with them. Has no effect beyond the
    // threshold.
    void add(const glm::vec3& normal, const glm::vec3& on_b, float distance, uint32_t part_a, uint32_t part_b);
    void add(const ContactPoint& point);
    // Moves the points with the bodies and drops those beyond the threshold.
    void refresh();
    void clear() { count_ = 0; }

  private:
    [[nodiscard]] uint32_t place_of(const ContactPoint& point) const;

    const Body *a_, *b_;
    float breaking_threshold_;
    uint32_t count_ = 0;
    std::array<ContactPoint, max_points> points_;
};

// A hull's corner that touches the ground or may come to it in this step.
struct alignas(64) GroundPoint {
    glm::vec3 position{0.0f}; // m, world, when contacts were found; on the hull, margin included
    glm::vec3 local{0.0f};    // m, position in the body's frame; compounds only
    float distance = 0.0f;    // m, above the ground
    int corner = 0;           // of the hull
    // Results of the last solution.
    float speed = 0.0f;                                   // m/s, approach speed
    float normal_impulse = 0.0f, friction_impulse = 0.0f; // N s, on the hull
    glm::vec3 tangent{0.0f};                              // unit direction of friction
    bool blow = false;                                    // whether speed > blow_speed

    void take(float normal, float friction) {
        normal_impulse = normal;
        friction_impulse = friction;
        blow = speed > blow_speed;
    }
    // Warm starting: the impulses from which the next solution starts.
    [[nodiscard]] float warm_normal_impulse() const { return blow ? 0.0f : normal_impulse; }
    [[nodiscard]] float warm_friction_impulse() const { return blow ? 0.0f : friction_impulse; }
};

// All contacts of a hull with the ground.
struct GroundManifold {
    static constexpr uint32_t max_points = 12;

    const Body* body = nullptr;
    uint32_t part = 0; // of a compound
    uint32_t count = 0;
    float friction = 0.0f, restitution = 0.0f; // combined with the ground's
    std::array<GroundPoint, max_points> all{};

    [[nodiscard]] std::span<GroundPoint> points() { return std::span(all).first(count); }
    [[nodiscard]] std::span<const GroundPoint> points() const { return std::span(all).first(count); }
};

// Either kind of manifold, with copies of the members that most loops over contacts read: they touch neither the
// manifold nor its bodies.
struct AnyManifold {
    static constexpr uint32_t none = UINT32_MAX;

    Manifold* between = nullptr;
    GroundManifold* ground = nullptr;
    uint32_t a = none, b = none; // indices of the bodies; none: the ground
    bool a_moves = true, b_moves = false;
    uint32_t count = 0; // of points

    explicit AnyManifold(Manifold& of)
        : between(&of), a(of.a().index), b(of.b().index), a_moves(!of.a().fixed), b_moves(!of.b().fixed),
          count(of.count()) {}
    explicit AnyManifold(GroundManifold& of)
        : ground(&of), a(of.body->index), a_moves(!of.body->fixed), count(of.count) {}

    // Prefetch in two stages: the body of a ground manifold one round after its contacts.
    [[gnu::always_inline]] void prefetch_contacts() const {
        prefetch(ground ? static_cast<const void*>(ground) : between, 512); // covers the points of most manifolds
    }
    [[gnu::always_inline]] void prefetch_body() const {
        if (ground) prefetch(ground->body, sizeof(Body));
    }
};

} // namespace brittle::physics

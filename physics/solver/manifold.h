// Contact manifolds: the points in which two hulls, or a hull and the ground, touch or are about to.
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

// Contacts that closed faster than this, m/s, are blows: the next solution does not start from their impulse. What
// stopped a blow is a hundred times what is needed a step later, and what the sweeps do not take back would be energy
// from nothing.
inline constexpr float blow_speed = 0.2f;

// Of two bodies, or of a body and the ground.
[[nodiscard]] inline float combined_friction(float a, float b) {
    constexpr float max_friction = 10.0f; // more holds nothing better and makes sweeps converge slower
    return std::min(a * b, max_friction);
}

// World coordinates, m; the normal points from b to a.
struct ContactPoint {
    glm::vec3 local_a{0.0f}, local_b{0.0f}; // in the bodies' frames
    glm::vec3 on_a{0.0f}, on_b{0.0f};       // on the surfaces, margin included
    glm::vec3 normal{0.0f};
    float distance = 0.0f;           // along the normal; below 0: overlap
    uint32_t part_a = 0, part_b = 0; // hulls of compounds
    // Of the last solution.
    float normal_impulse = 0.0f, friction_impulse = 0.0f; // N s, on a; 0 after a blow
    glm::vec3 tangent{0.0f};                              // in which friction acted on a
};

// The points between two bodies, or between two hulls of theirs.
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

    // Distance, along the normal and across it, beyond which a point is no contact any more; points of a body that are
    // nearer to each other than this are one.
    [[nodiscard]] float breaking_threshold() const { return breaking_threshold_; }
    void set_breaking_threshold(float threshold) { breaking_threshold_ = threshold; }

    // Adds the contact at a point on b, or moves the contact that is near it, which keeps its impulses. Of five
    // points the new one, the deepest and those stay that span the largest area with them. Beyond the threshold
    // nothing is added.
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
    glm::vec3 position{0.0f}; // on the hull, margin included, as contacts were found; world
    glm::vec3 local{0.0f};    // the same in the body's frame; of a compound only
    float distance = 0.0f;    // above the ground
    int corner = 0;           // of the hull
    // Of the last solution.
    float speed = 0.0f;                                   // m/s, at which it came down
    float normal_impulse = 0.0f, friction_impulse = 0.0f; // N s, on the hull
    glm::vec3 tangent{0.0f};                              // in which friction acted
    bool blow = false;                                    // faster than blow_speed

    void take(float normal, float friction) {
        normal_impulse = normal;
        friction_impulse = friction;
        blow = speed > blow_speed;
    }
    // What the next solution starts from.
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

// Either manifold, with the facts that most loops over contacts need: they read neither the manifold nor its bodies.
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

    // In two stages: the body of a ground manifold a round after its contacts.
    [[gnu::always_inline]] void prefetch_contacts() const {
        prefetch(ground ? static_cast<const void*>(ground) : between, 512); // as many points as most have
    }
    [[gnu::always_inline]] void prefetch_body() const {
        if (ground) prefetch(ground->body, sizeof(Body));
    }
};

} // namespace brittle::physics

// Contact manifolds: the points at which two hulls, or a hull and the ground, touch or will touch in this step.
//
// A manifold of two hulls keeps up to four points from step to step, with the impulses that the solver starts from
// (warm starting). A point is known again by its feature, or by its place on body a.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "physics/solver/body.h"
#include "physics/solver/face_contact.h"
#include "physics/solver/prefetch.h"

namespace brittle::physics {

// Overlap that stays, as a part of the rotation radius: the correction of a smaller one makes stacks sway.
inline constexpr float slop_part = 0.002f;

// Impulse at a contact point.
struct PointImpulse {
    float normal = 0.0f;      // N s, on a along the normal
    glm::vec3 friction{0.0f}; // N s, on a across it
};

// Returns the friction coefficient of two bodies, or of a body and the ground.
[[nodiscard]] inline float combined_friction(float a, float b) {
    constexpr float max_friction = 10.0f; // a higher one changes nothing but slows convergence
    return std::min(a * b, max_friction);
}

// World coordinates, m; the normal points from b to a.
struct ContactPoint {
    glm::vec3 local_a{0.0f}, local_b{0.0f}; // in the bodies' frames
    glm::vec3 local_normal{0.0f};           // in the frame of a
    glm::vec3 on_a{0.0f}, on_b{0.0f};       // on the surfaces, margin included
    glm::vec3 normal{0.0f};
    float distance = 0.0f;           // along the normal; below 0: overlap
    uint32_t part_a = 0, part_b = 0; // hulls of compounds
    uint32_t feature = no_feature;   // the edges that cross here (face_contact.h)
    PointImpulse last;               // of the last step
    PointImpulse start;              // from which the next substep starts; limited after a blow (row.h)
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

    // m; overlap that stays.
    [[nodiscard]] float slop() const { return slop_; }
    // m. A point ends beyond this distance along the normal or across it. A new point without a known feature continues
    // the nearest old one within this distance.
    [[nodiscard]] float breaking_threshold() const { return breaking_threshold_; }
    void set_breaking_threshold(float threshold) { breaking_threshold_ = threshold; }

    // Makes a point on b at a distance from a along the normal.
    [[nodiscard]] ContactPoint point_at(const glm::vec3& normal, const glm::vec3& on_b, float distance) const;
    // Replaces all points by the best four candidates: the deepest, and those that span the largest area with it. They
    // keep the impulses of the old points that they continue.
    void replace(std::span<ContactPoint> candidates);
    // Precondition: less than max_points points.
    void add(const ContactPoint& point) { points_[count_++] = point; }
    // Moves the points with the bodies and drops those beyond the threshold.
    void refresh();
    void clear() { count_ = 0; }

  private:
    const Body *a_, *b_;
    float breaking_threshold_, slop_;
    uint32_t count_ = 0;
    std::array<ContactPoint, max_points> points_;
};

// A hull's corner that touches the ground or may come to it in this step.
struct alignas(64) GroundPoint {
    glm::vec3 position{0.0f}; // m, world, when contacts were found; on the hull, margin included
    glm::vec3 local{0.0f};    // m, position in the body's frame; compounds only
    float distance = 0.0f;    // m, above the ground
    int corner = 0;           // of the hull
    float speed = 0.0f;       // m/s, approach speed before the last step
    PointImpulse last, start; // as in ContactPoint
};

// All contacts of a hull with the ground.
struct GroundManifold {
    static constexpr uint32_t max_points = 12;

    const Body* body = nullptr;
    uint32_t part = 0; // of a compound
    uint32_t count = 0;
    float friction = 0.0f, restitution = 0.0f; // combined with the ground's
    float slop = 0.0f;                         // m; overlap that stays
    std::array<GroundPoint, max_points> all{};

    [[nodiscard]] std::span<GroundPoint> points() { return std::span(all).first(count); }
    [[nodiscard]] std::span<const GroundPoint> points() const { return std::span(all).first(count); }
};

// The point where debris touches a body as ellipsoids (ellipsoid_contact.h).
struct EllipsoidPoint {
    glm::vec3 position{0.0f}; // m, world
    glm::vec3 normal{0.0f};   // from b to a
    float distance = 0.0f;    // m; below 0: overlap
    float speed = 0.0f;       // m/s, approach speed before the last step
    PointImpulse last, start; // as in ContactPoint
    glm::vec3 rolling{0.0f};  // N m s, on a: the rolling friction from which the next substep starts
};
struct EllipsoidManifold {
    const Body *a = nullptr, *b = nullptr;
    uint32_t count = 0; // of points, 0 or 1
    float friction = 0.0f, restitution = 0.0f;
    float slop = 0.0f;        // m; overlap that stays
    float rolling_arm = 0.0f; // m; the rolling friction is at most this times the normal impulse
    EllipsoidPoint point;

    [[nodiscard]] std::span<EllipsoidPoint> points() { return std::span(&point, count); }
    [[nodiscard]] std::span<const EllipsoidPoint> points() const { return std::span(&point, count); }
};

// A manifold of any kind, with copies of the members that most loops over contacts read: they touch neither the
// manifold nor its bodies.
struct AnyManifold {
    static constexpr uint32_t none = UINT32_MAX;

    Manifold* between = nullptr;
    GroundManifold* ground = nullptr;
    EllipsoidManifold* ellipsoids = nullptr;
    uint32_t a = none, b = none; // indices of the bodies; none: the ground
    bool a_moves = true, b_moves = false;
    uint32_t count = 0; // of points

    explicit AnyManifold(Manifold& of)
        : between(&of), a(of.a().index), b(of.b().index), a_moves(!of.a().fixed), b_moves(!of.b().fixed),
          count(of.count()) {}
    explicit AnyManifold(EllipsoidManifold& of)
        : ellipsoids(&of), a(of.a->index), b(of.b->index), a_moves(true), b_moves(true), count(of.count) {}
    explicit AnyManifold(GroundManifold& of)
        : ground(&of), a(of.body->index), a_moves(!of.body->fixed), count(of.count) {}

    // Calls visit() with the manifold.
    auto visit(const auto& visit) const {
        return ellipsoids ? visit(*ellipsoids) : ground ? visit(*ground) : visit(*between);
    }
    // The product of the friction coefficients.
    [[nodiscard]] float friction() const {
        return ellipsoids ? ellipsoids->friction : ground ? ground->friction : between->friction();
    }

    // The product of the restitutions.
    [[nodiscard]] float restitution() const {
        return ellipsoids ? ellipsoids->restitution : ground ? ground->restitution : between->restitution();
    }

    // Prefetch in two stages: the body of a ground manifold one round after its contacts.
    [[gnu::always_inline]] void prefetch_contacts() const {
        if (ellipsoids)
            prefetch(ellipsoids, sizeof(EllipsoidManifold));
        else
            prefetch(ground ? static_cast<const void*>(ground) : between, 512); // covers the points of most manifolds
    }
    [[gnu::always_inline]] void prefetch_body() const {
        if (ground) prefetch(ground->body, sizeof(Body));
    }
};

} // namespace brittle::physics

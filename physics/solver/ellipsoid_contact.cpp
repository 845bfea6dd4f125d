#include "physics/solver/ellipsoid_contact.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/solver/manifold.h"
#include "physics/solver/siblings.h"

namespace brittle::physics {

namespace {

// Bodies meet with their hulls if one has this many times the volume of the other: the corners that stick out of its
// ellipsoid would swallow the smaller one.
constexpr float hull_factor = 4.0f;
// Part of the semi-axes of the ellipsoid of equal volume. Packed ellipsoids leave a third of the space free, packed
// pieces less.
constexpr float size_part = 0.95f;
// Bounds of the ratio of semi-axes to half the sides of the bounds; that of a box is 1.24.
constexpr float min_ratio = 0.5f, max_ratio = 1.25f;
// Parts of the smaller body's least semi-axis: contacts reach so far ahead of bodies at rest; a pair that comes closer
// by more in a step has the normal of its predicted touch; and the slop.
constexpr float near_part = 0.02f, fast_part = 0.25f, slop_of_axis = 0.01f;
// Lever arm of the rolling friction, as a part of the smaller body's mean semi-axis. Heaps of debris then have the
// radius of heaps of hulls.
constexpr float rolling_part = 0.5f;

float least(const glm::vec3& v) {
    return std::min({v.x, v.y, v.z});
}

// In proportion to the volume of the ellipsoid.
float volume_of(const Body& body) {
    const glm::vec3& squares = body.squared_semi_axes;
    return std::sqrt(squares.x * squares.y * squares.z);
}

// The matrix of an ellipsoid, R diag(a^2) R^T: its support along a unit n is the root of n . M n.
glm::mat3 matrix_of_ellipsoid(const Body& body) {
    const glm::mat3& axes = body.frame.basis;
    const glm::vec3& squares = body.squared_semi_axes;
    return glm::mat3(axes[0] * squares.x, axes[1] * squares.y, axes[2] * squares.z) * glm::transpose(axes);
}

// Solves a symmetric system by its adjugate.
glm::vec3 solved(const glm::mat3& m, const glm::vec3& v) {
    const glm::vec3 x = glm::cross(m[1], m[2]), y = glm::cross(m[2], m[0]), z = glm::cross(m[0], m[1]);
    return (x * v.x + y * v.y + z * v.z) * (1.0f / glm::dot(m[0], x));
}

class EllipsoidContacts final : public PairContacts {
  public:
    EllipsoidContacts(const Body& a, const Body& b) {
        manifold_.a = &a;
        manifold_.b = &b;
        manifold_.restitution = a.restitution * b.restitution;
        manifold_.friction = combined_friction(a.friction, b.friction);
        const glm::vec3 axes = glm::sqrt((volume_of(a) < volume_of(b) ? a : b).squared_semi_axes);
        min_axis_ = least(axes);
        manifold_.rolling_arm = rolling_part * (axes.x + axes.y + axes.z) / 3.0f;
    }

    void update(const ContactStep& step) override {
        const Body &a = *manifold_.a, &b = *manifold_.b;
        const uint32_t before = std::exchange(manifold_.count, 0u);
        const float min_slop = slop_of_axis * min_axis_;
        const bool first = std::exchange(is_new_, false), siblings = a.cut != 0 && a.cut == b.cut;
        if (!first && Siblings::fly_as_one(a, b)) return;
        matrix_a_ = matrix_of_ellipsoid(a);
        matrix_b_ = matrix_of_ellipsoid(b);
        const glm::vec3 way = a.frame.origin - b.frame.origin;
        const glm::vec3 relative = a.velocity.linear - b.velocity.linear;
        const float rotation = (glm::length(a.velocity.angular) * a.reach + glm::length(b.velocity.angular) * b.reach)
                               * step.seconds; // bound of how far the surfaces come closer by it
        const float near = near_part * min_axis_ + std::min(rotation, min_axis_);
        Touch touch = touch_along(way, near + glm::length(relative) * step.seconds);
        const float approach = std::max(0.0f, -glm::dot(relative, touch.normal)) * step.seconds;
        if (approach > fast_part * min_axis_ && touch.distance > 0.0f) {
            // The moment of touch of two balls that touch along this normal.
            const float reach = touch.support, square = length_squared(relative), along = glm::dot(way, relative);
            const float inside = along * along - square * (length_squared(way) - reach * reach);
            if (inside < 0.0f) return; // they pass each other
            const float seconds = std::clamp((-along - std::sqrt(inside)) / square, 0.0f, step.seconds);
            touch = touch_along(way + relative * seconds, unbounded);
            touch.distance = glm::dot(touch.normal, way) - touch.support;
        }
        if (first && siblings) manifold_.slop = std::max(0.0f, -touch.distance);
        manifold_.slop = std::clamp(-touch.distance, min_slop, std::max(manifold_.slop, min_slop));
        if (Siblings::fly_as_one(a, b)) return;
        if (touch.distance > approach + near) return;
        EllipsoidPoint& point = manifold_.point;
        if (before == 0) point.last = point.start = {}, point.rolling = glm::vec3(0.0f);
        point.normal = touch.normal;
        point.distance = touch.distance;
        point.position = 0.5f * ((a.frame.origin - touch.arm_a) + (b.frame.origin + touch.arm_b));
        manifold_.count = 1;
    }
    void refresh() override {}
    void collect(std::vector<AnyManifold>& to) const override {
        if (manifold_.count > 0) to.emplace_back(manifold_);
    }

  private:
    struct Touch {
        glm::vec3 normal;
        float distance, support;
        glm::vec3 arm_a, arm_b; // M n / h(n) of each
    };

    [[nodiscard]] Touch supports(const glm::vec3& way, const glm::vec3& normal) const {
        const glm::vec3 a = matrix_a_ * normal, b = matrix_b_ * normal;
        const float height_a = std::sqrt(glm::dot(normal, a)), height_b = std::sqrt(glm::dot(normal, b));
        return {.normal = normal,
                .distance = glm::dot(normal, way) - height_a - height_b,
                .support = height_a + height_b,
                .arm_a = a * (1.0f / height_a),
                .arm_b = b * (1.0f / height_b)};
    }
    // Maximizes the distance over the normal. It starts from (A + B)^-1 way, which is exact for balls and for similar
    // ellipsoids; each iteration is a step of Newton's method along the gradient. It ends early at a distance beyond
    // `far`.
    [[nodiscard]] Touch touch_along(const glm::vec3& way, float far) const {
        constexpr int iterations = 2;
        constexpr float longest_turn = 0.5f;
        glm::vec3 normal = solved(matrix_a_ + matrix_b_, way);
        const float length = glm::length(normal);
        normal = length > 0.0f && std::isfinite(length) ? normal * (1.0f / length) : glm::vec3(0, 1, 0);
        Touch touch = supports(way, normal);
        for (int i = 0; i < iterations && touch.distance <= far; ++i) {
            const glm::vec3 between = way - touch.arm_a - touch.arm_b;
            const glm::vec3 gradient = between - normal * glm::dot(normal, between);
            const float steepness = glm::length(gradient);
            if (!(steepness > 1e-3f * min_axis_)) break;
            const glm::vec3 along = gradient * (1.0f / steepness);
            const auto curvature = [&](const glm::mat3& matrix, const glm::vec3& arm) {
                const float slope = glm::dot(along, arm);
                return (glm::dot(along, matrix * along) - slope * slope) / glm::dot(normal, arm);
            };
            const float radius = curvature(matrix_a_, touch.arm_a) + curvature(matrix_b_, touch.arm_b);
            const float turn = std::min(steepness / std::max(touch.distance + radius, 0.5f * radius), longest_turn);
            normal = glm::normalize(normal + along * turn);
            const Touch next = supports(way, normal);
            if (next.distance <= touch.distance) break;
            touch = next;
        }
        return touch;
    }

    mutable EllipsoidManifold manifold_; // mutable: its owner is shared by the lists that the solver writes through
    glm::mat3 matrix_a_{1.0f}, matrix_b_{1.0f};
    float min_axis_ = 0.0f;
    bool is_new_ = true;
};

} // namespace

glm::vec3 squared_semi_axes(const Bounds& bounds, float volume) {
    const glm::vec3 half = 0.5f * (bounds.high - bounds.low);
    const float ball = 4.1887902f * half.x * half.y * half.z;
    const float ratio = volume > 0.0f && ball > 0.0f ? std::cbrt(volume / ball) : 1.0f;
    const glm::vec3 axes = half * (size_part * std::clamp(ratio, min_ratio, max_ratio));
    return axes * axes;
}

bool touch_as_ellipsoids(const Body& a, const Body& b) {
    if (a.fixed || b.fixed || !(a.debris || b.debris)) return false;
    const float size_a = volume_of(a), size_b = volume_of(b);
    return std::max(size_a, size_b) < hull_factor * std::min(size_a, size_b);
}

std::unique_ptr<PairContacts> make_ellipsoid_contacts(const Body& a, const Body& b) {
    return std::make_unique<EllipsoidContacts>(a, b);
}

} // namespace brittle::physics

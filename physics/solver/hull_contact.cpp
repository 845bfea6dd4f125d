#include "physics/solver/hull_contact.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "physics/solver/body.h"
#include "physics/solver/continuous_collision.h"
#include "physics/solver/face_contact.h"
#include "physics/solver/hull_distance.h"
#include "physics/solver/hull_shape.h"
#include "physics/solver/manifold.h"
#include "physics/solver/siblings.h"
#include "physics/solver/time_of_impact.h"
#include "physics/world/surface_parts.h"

namespace brittle::physics {

namespace {

// Contacts begin at this part of the smaller hull's rotation radius, m.
constexpr float near_part = 0.02f;
// Hulls that touch are searched again when they have moved against each other by this part of that distance: a
// two-hundredth of the smaller one's radius. A larger part saves time while a heap settles, but contacts lag behind
// corners that tilt.
constexpr float still_part = 0.25f;
// Speculative contacts with a much lighter body begin when the heavier one moves in a step by this part of the smaller
// one's radius, and both move against each other by the second part of it.
constexpr float passing_part = 0.5f, apart_part = 0.05f;
// Speculative contacts of two bodies of similar mass begin when they come closer in a step by this part of the thinner
// one's thickness.
constexpr float sinking_part = 0.25f;
// Corners of one face that stick out of the other by less than this part of the distance at which contacts begin count
// as inside it.
constexpr float aligned_part = 0.1f;
// Hulls on straight paths meet after a few advances.
constexpr int max_advances = 16;

// Whether both move and the first is too light to stop the second (continuous_collision.h): it is pushed instead.
bool much_lighter(const Body& first, const Body& second) {
    return second.inverse_mass > 0.0f && second.inverse_mass < ContinuousCollision::light_part * first.inverse_mass;
}

class HullContacts final : public PairContacts {
  public:
    HullContacts(const HullOf& a, const HullOf& b) : a_(a), b_(b) {
        const HullShape &hull_a = *a.shape, &hull_b = *b.shape;
        of_compound_ = a.local || b.local;
        a_is_smaller_ = hull_a.radius() < hull_b.radius();
        radius_ = std::min(hull_a.radius(), hull_b.radius());
        margins_ = hull_a.margin() + hull_b.margin();
        near_ = near_part * std::min(hull_a.rotation_radius(), hull_b.rotation_radius());
        still_ = still_part * near_;
        debris_ = a.body->debris || b.body->debris;
        a_pushes_b_ = much_lighter(*b.body, *a.body);
        b_pushes_a_ = much_lighter(*a.body, *b.body);
        similar_mass_ = !a.body->fixed && !b.body->fixed && !debris_ && !a_pushes_b_ && !b_pushes_a_;
        min_thickness_ = std::min(thickness(hull_a), thickness(hull_b));
        const Frames now{a.frame(), b.frame()};
        axis_ = (now.a.origin - now.b.origin) * now.a.basis;
        if (length_squared(axis_) < epsilon * epsilon) axis_ = {0, 1, 0};
        axis_ *= 1.0f / glm::length(axis_);
    }

    void update(const ContactStep& step) override {
        const Frames now{a_.frame(), b_.frame()};
        // The contacts may have ended because the separating axis changed: search once more.
        if (find(now, step.seconds) || (!of_compound_ && find(now, step.seconds))) return;
        manifold_.reset();
    }

    void refresh() override {
        if (manifold_) manifold_->refresh();
    }
    void collect(std::vector<AnyManifold>& to) const override {
        if (manifold_) to.emplace_back(const_cast<Manifold&>(*manifold_));
    }

  private:
    static constexpr float epsilon = std::numeric_limits<float>::epsilon();

    struct Frames {
        Transform a, b;
    };

    // Updates the contacts; returns false if there were contacts and none is left.
    bool find(const Frames& now, float seconds) {
        if (Siblings::fly_as_one(*a_.body, *b_.body)) return true;
        const Transform relative_now = relative(now);
        bool pushed = may_be_pushed(now, seconds);
        float ahead = reach_ahead(now, seconds, pushed);
        if (!(moved_since(relative_now) + ahead < free_)) {
            searched_at_ = relative_now;
            const std::optional<HullDistance> touch = search(now, near_ + ahead);
            if (touch && !manifold_ && passes(now, *touch, pushed, seconds)) {
                free_ = -1.0f;
                return true;
            }
            if (touch && !manifold_ && !of_compound_) { // along the axis that was found
                pushed = may_be_pushed(now, seconds);
                ahead = reach_ahead(now, seconds, pushed);
            }
            if (touch) find_points({.at = now, .found = *touch}, near_ + ahead, seconds);
        }
        if (!manifold_) return true;
        manifold_->refresh();
        if (manifold_->count() > 0 && pushed) {
            const std::optional<Touch> touch = touch_ahead(now, seconds, near_);
            if (touch)
                find_points(*touch, near_, seconds);
            else
                manifold_->clear();
        }
        return manifold_->count() > 0;
    }

    // The frame of the smaller hull in that of the other one.
    [[nodiscard]] Transform relative(const Frames& now) const {
        return a_is_smaller_ ? now.b.to_local(now.a) : now.a.to_local(now.b);
    }

    // Upper bound of the motion of any point of the smaller hull in the other hull's frame since the last search, m.
    [[nodiscard]] float moved_since(const Transform& now) const {
        float turned = 0.0f; // the square of the Frobenius norm bounds what the difference does to a vector
        for (int axis = 0; axis < 3; ++axis)
            turned += length_squared(row(now.basis, axis) - row(searched_at_.basis, axis));
        return glm::length(now.origin - searched_at_.origin) + std::sqrt(turned) * radius_;
    }

    // Whether one may get into or past the other in a step, in a pair that continuous collision skips.
    [[nodiscard]] bool may_be_pushed(const Frames& now, float seconds) const {
        const glm::vec3 relative_velocity = b_.body->velocity.linear - a_.body->velocity.linear;
        // Along the current separating axis, the depth is at most the approach.
        if (similar_mass_)
            return glm::dot(relative_velocity, now.a.basis * axis_) * seconds > sinking_part * min_thickness_;
        if (!a_pushes_b_ && !b_pushes_a_) return false;
        const float heavy = glm::length((a_pushes_b_ ? a_ : b_).body->velocity.linear);
        return heavy * seconds > passing_part * radius_
               && glm::length(relative_velocity) * seconds > apart_part * radius_;
    }

    // An upper bound of the speed at which the hulls come closer.
    [[nodiscard]] float approach_speed(const Frames& now) const {
        const glm::vec3& middle = (a_is_smaller_ ? now.a : now.b).origin;
        const glm::vec3 apart = a_.body->velocity_at(middle) - b_.body->velocity_at(middle);
        const glm::vec3 turning = a_.body->velocity.angular - b_.body->velocity.angular;
        return glm::length(apart) + glm::length(turning) * radius_;
    }

    // How far ahead contacts are made: as far as the hulls can come closer in the step. Hulls that pass each other's
    // edges would be deflected, so the distance is limited to a part of the thinner one's thickness, beyond which
    // continuous collision acts.
    [[nodiscard]] float reach_ahead(const Frames& now, float seconds, bool pushed) const {
        const float ahead = approach_speed(now) * seconds;
        return debris_ || pushed ? ahead : std::min(ahead, sinking_part * min_thickness_);
    }

    // Velocity of the smaller hull against the other one at a point of the world.
    [[nodiscard]] glm::vec3 velocity_against(const glm::vec3& point) const {
        const glm::vec3 apart = a_.body->velocity_at(point) - b_.body->velocity_at(point);
        return a_is_smaller_ ? apart : -apart;
    }

    // The gap between the hulls along a unit direction from b to a: a lower bound of their distance.
    [[nodiscard]] float gap(const Frames& now, const glm::vec3& direction) const {
        return -support(*a_.shape, now.a, -direction) - support(*b_.shape, now.b, direction) - margins_;
    }

    // Searches for a contact, and sets free_.
    std::optional<HullDistance> search(const Frames& now, float near) {
        free_ = gap(now, now.a.basis * axis_) - near;
        if (free_ > 0.0f) return std::nullopt;
        HullDistance found = hull_distance(*a_.shape, *b_.shape, now.a.to_local(now.b), margins_ + near, simplex_);
        axis_ = found.normal;
        free_ = found.distance - margins_ - near;
        if (free_ > 0.0f) return std::nullopt;
        face_only_ = limit_to_facets(now, found);
        return found;
    }

    // Turns the direction of a contact to one that the facets of surfaces allow. Returns whether it turned: the nearest
    // points then are none of the contact.
    bool limit_to_facets(const Frames& now, HullDistance& found) const {
        glm::vec3 normal = found.normal;
        if (a_.facet) normal = -limited(*a_.facet, -normal, now.a.to_local(now.b).origin, found);
        if (b_.facet) {
            const Transform a_in_b = now.b.to_local(now.a);
            normal = limited(*b_.facet, a_in_b.basis * normal, a_in_b.origin, found) * a_in_b.basis;
        }
        constexpr float same = 0.9999f; // cosine of 0.8 degrees
        if (glm::dot(normal, found.normal) > same) return false;
        found.normal = normal;
        found.distance = gap(now, now.a.basis * normal) + margins_;
        return true;
    }

    // `direction` is that to the other hull, whose middle is at `other`, in the axes of the facet. A hull that is apart
    // from the slab of the facet, or has its middle below it, may be at its back.
    static glm::vec3 limited(const SurfaceFacet& facet, const glm::vec3& direction, const glm::vec3& other,
                             const HullDistance& found) {
        const bool behind = glm::dot(direction, facet.normal) < 0.0f
                            && (found.distance > 0.0f || glm::dot(other, facet.normal) < -facet.depth);
        return behind ? direction : facet.limit(direction);
    }

    // The hulls now, or at the predicted moment of touch within the step, without rotation.
    struct Touch {
        Frames at;
        glm::vec3 translation{0.0f}; // m, of b in `at` from where it is now
        HullDistance found{};        // in a's frame
    };

    // Replaces the contacts by the points at which the two facing faces are near, or come near in this step, and the
    // nearest point if it is none of these. The hulls are at the frames of `touch`.
    void find_points(const Touch& touch, float near, float seconds) {
        if (!manifold_) manifold_.emplace(*a_.body, *b_.body);
        thread_local std::vector<FacePoint> corners;
        thread_local std::vector<ContactPoint> candidates;
        candidates.clear();
        const Transform& in_a = touch.at.a;
        const Transform b_in_a = in_a.to_local(touch.at.b);
        const FacingFaces faces = facing_faces(*a_.shape, *b_.shape, b_in_a, touch.found.normal);
        clip_faces(*a_.shape, *b_.shape, b_in_a, faces, aligned_part * near_, corners);
        float farthest = near_;
        const auto add = [&](const glm::vec3& normal, const glm::vec3& on_b, float gap, uint32_t feature) {
            candidates.push_back(present(touch, in_a.basis * normal, in_a * (on_b + normal * b_.shape->margin()), gap));
            candidates.back().part_a = a_.part;
            candidates.back().part_b = b_.part;
            candidates.back().feature = feature;
            farthest = std::max(farthest, candidates.back().distance);
        };
        float deepest = unbounded;
        for (const FacePoint& corner : corners) {
            // The corners of a face may lie below its plane, but no points are nearer than the nearest ones.
            const float nearest = touch.found.distance;
            const float gap = (nearest > 0.0f ? std::max(corner.gap, nearest) : corner.gap) - margins_;
            const glm::vec3 normal = in_a.basis * faces.normal, at = in_a * corner.on_second;
            const float closing = glm::dot(b_.body->velocity_at(at) - a_.body->velocity_at(at), normal);
            if (gap > std::max(near, near_ + closing * seconds)) continue;
            deepest = std::min(deepest, gap);
            add(faces.normal, corner.on_second, gap, corner.feature);
        }
        const float gap = touch.found.distance - margins_;
        if (!face_only_ && deepest > gap + still_) add(touch.found.normal, touch.found.point, gap, no_feature);
        manifold_->set_breaking_threshold(std::max(near, farthest));
        manifold_->replace(candidates);
        free_ = still_;
    }

    // The present contact of two points that have this gap between them at the frames of `touch`. It is placed on the
    // light body, because an inexact lever arm matters less on the heavy one.
    [[nodiscard]] ContactPoint present(const Touch& touch, const glm::vec3& normal, const glm::vec3& on_b,
                                       float gap) const {
        const float distance = gap + glm::dot(normal, touch.translation);
        const bool on_a = touch.translation != glm::vec3(0.0f) && !a_pushes_b_;
        return manifold_->point_at(normal, on_a ? on_b + normal * (gap - distance) : on_b - touch.translation,
                                   distance);
    }

    // Whether the hulls that were just found come near each other in this step without touching. The normal of their
    // nearest points is that of an edge, and a contact along it would deflect them.
    bool passes(const Frames& now, const HullDistance& found, bool pushed, float seconds) {
        if (pushed) return !touch_ahead(now, seconds, near_);
        if (debris_ || found.distance - margins_ < near_) return false;
        // Other contacts may change the velocities.
        const auto is_steady = [&](const Body& body) {
            return !body.touching || glm::length(body.velocity.linear) * seconds < still_;
        };
        if (!is_steady(*a_.body) || !is_steady(*b_.body)) return false;
        const glm::vec3 turning = a_.body->velocity.angular - b_.body->velocity.angular;
        return !touch_ahead(now, seconds, still_ + glm::length(turning) * radius_ * seconds);
    }

    // Conservative advancement along the relative velocity, up to a gap; empty for hulls that pass or part.
    std::optional<Touch> touch_ahead(const Frames& now, float seconds, float near) {
        const glm::vec3 against = velocity_against((a_is_smaller_ ? now.a : now.b).origin);
        const glm::vec3 whole = (a_is_smaller_ ? -against : against) * seconds;
        Touch touch{.at = now};
        float part = 0.0f;
        for (int advance = 0; advance < max_advances; ++advance) {
            touch.found = hull_distance(*a_.shape, *b_.shape, touch.at.a.to_local(touch.at.b), unbounded, simplex_);
            const float gap = touch.found.distance - margins_;
            if (gap < near) return touch;
            const float closing = glm::dot(touch.at.a.basis * touch.found.normal, whole);
            if (!(closing > 0.0f)) return std::nullopt;
            part += (gap - 0.5f * near) / closing;
            if (part > 1.0f) return std::nullopt;
            touch.translation = whole * part;
            touch.at.b.origin = now.b.origin + touch.translation;
        }
        return touch;
    }

    HullOf a_, b_;
    std::optional<Manifold> manifold_;
    bool of_compound_;
    bool a_is_smaller_;
    float radius_;                 // of the smaller hull
    float margins_;                // of both
    float near_;                   // closer is a contact
    bool debris_;                  // one of the two: its contacts are speculative
    bool a_pushes_b_, b_pushes_a_; // the first is much heavier
    bool similar_mass_;            // both move, and none is much lighter
    float min_thickness_;
    bool face_only_ = false; // the direction of the contact is not that of the nearest points
    float still_;            // relative movement up to which complete contacts stay as they are
    float free_ = -1.0f;     // relative movement up to which no search is needed; negative: always
    Transform searched_at_;  // of the smaller hull in the other's frame
    NearestCorners simplex_; // that GJK ended with
    glm::vec3 axis_;         // unit, from b to a, in a's frame: it separated the two last
};

} // namespace

Transform HullOf::frame() const {
    return local ? body->frame * *local : body->frame;
}

std::unique_ptr<PairContacts> make_hull_contacts(const HullOf& a, const HullOf& b) {
    return std::make_unique<HullContacts>(a, b);
}

} // namespace brittle::physics

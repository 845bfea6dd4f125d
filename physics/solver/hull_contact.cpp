#include "physics/solver/hull_contact.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "physics/solver/body.h"
#include "physics/solver/continuous_collision.h"
#include "physics/solver/hull_distance.h"
#include "physics/solver/hull_shape.h"
#include "physics/solver/manifold.h"
#include "physics/solver/siblings.h"
#include "physics/solver/time_of_impact.h"

namespace brittle::physics {

namespace {

// Contacts begin at this part of the smaller hull's rotation radius, m.
constexpr float near_part = 0.02f;
// Hulls that touch are searched again when they have moved against each other by this part of that distance: a
// two-hundredth of the smaller one's radius. A larger part saves time while a heap settles, but contacts lag behind
// corners that tilt.
constexpr float still_part = 0.25f;
// Siblings are searched when they have moved against each other by this part of the smaller one's radius: rounding
// moves them by less.
constexpr float together_part = 1e-4f;
// Speculative contacts with a much lighter body begin when the heavier one moves in a step by this part of the smaller
// one's radius, and both move against each other by the second part of it.
constexpr float passing_part = 0.5f, apart_part = 0.05f;
// Speculative contacts of two bodies of similar mass begin when they come closer in a step by this part of the thinner
// one's thickness.
constexpr float sinking_part = 0.25f;
// Corners of the smaller hull that are higher above a floor than this part of its thickness are not its lower corners.
constexpr float low_part = 0.5f;
// Contacts that are nearer to each other than this part of the smaller hull's radius are one.
constexpr float same_part = 0.2f;
// Contacts whose normals have a smaller cosine between them are of different surfaces.
constexpr float same_way = 0.9f;
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
        on_larger_ = std::max(hull_a.radius(), hull_b.radius()) > ContinuousCollision::larger_factor * radius_;
        const Frames now{a.frame(), b.frame()};
        axis_ = (now.a.origin - now.b.origin) * now.a.basis;
        if (length_squared(axis_) < epsilon * epsilon) axis_ = {0, 1, 0};
        axis_ *= 1.0f / glm::length(axis_);
        if (!Siblings::fly_as_one(*a.body, *b.body)) return;
        searched_at_ = relative(now);
        free_ = together_part * radius_;
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
        const Transform relative_now = relative(now);
        bool pushed = may_be_pushed(now, seconds);
        float ahead = debris_ || pushed ? approach_speed(now) * seconds : 0.0f;
        if (!(moved_since(relative_now) + ahead < free_)) {
            searched_at_ = relative_now;
            const std::optional<HullDistance> touch = search(now, near_ + ahead);
            if (touch && !manifold_ && pushed && !touch_ahead(now, seconds)) {
                free_ = -1.0f; // near, but passing
                return true;
            }
            if (touch && !manifold_ && !of_compound_) { // along the axis that was found
                pushed = may_be_pushed(now, seconds);
                ahead = debris_ || pushed ? approach_speed(now) * seconds : 0.0f;
            }
            if (touch) add_contact(now, *touch, near_ + ahead);
        }
        if (!manifold_) return true;
        manifold_->refresh();
        if (manifold_->count() > 0) {
            if (pushed)
                meet_ahead(now, seconds);
            else if (on_larger_)
                add_corners(now, seconds);
        }
        return manifold_->count() > 0;
    }

    [[nodiscard]] const HullShape& smaller() const { return a_is_smaller_ ? *a_.shape : *b_.shape; }
    [[nodiscard]] const HullShape& larger() const { return a_is_smaller_ ? *b_.shape : *a_.shape; }
    [[nodiscard]] const glm::vec3& on_smaller(const ContactPoint& p) const { return a_is_smaller_ ? p.on_a : p.on_b; }

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
        const HullDistance found =
            hull_distance(*a_.shape, *b_.shape, now.a.to_local(now.b), margins_ + near, simplex_);
        axis_ = found.normal;
        free_ = found.distance - margins_ - near;
        return free_ > 0.0f ? std::nullopt : std::optional(found);
    }

    void add_contact(const Frames& now, const HullDistance& touch, float near) {
        if (!manifold_) manifold_.emplace(*a_.body, *b_.body);
        if (near > near_) manifold_->set_breaking_threshold(near);
        const uint32_t before = manifold_->count();
        manifold_->add(now.a.basis * touch.normal, now.a * (touch.point + touch.normal * b_.shape->margin()),
                       touch.distance - margins_, a_.part, b_.part);
        free_ = manifold_->count() == before ? still_ : -1.0f;
    }

    // On a floor or a wall: adds a contact for each corner of the smaller hull that the step may bring down, as
    // ground_contact.h does.
    void add_corners(const Frames& now, float seconds) {
        if (approach_speed(now) * seconds <= still_) return;
        const Transform& frame = a_is_smaller_ ? now.a : now.b;
        const HullShape& hull = smaller();
        const ContactPoint known = manifold_->points()[0];
        const glm::vec3 away = a_is_smaller_ ? known.normal : -known.normal;
        const float highest = low_part * thickness(hull);
        const glm::vec3 foot = a_is_smaller_ ? known.on_b : known.on_a;
        for (const glm::vec3& local : hull.points()) {
            const glm::vec3 corner = frame * local;
            const float height = glm::dot(corner - foot, away) - hull.margin();
            const float down = -glm::dot(velocity_against(corner), away) * seconds;
            if (height > std::min(near_ + std::max(down, 0.0f), highest)) continue;
            // A point beyond the threshold is no contact, and one nearer to another than the threshold would replace
            // it.
            const float threshold = std::max(near_, height);
            const glm::vec3 on_surface = corner - away * hull.margin();
            if (has_contact_near(on_surface, std::max(threshold, same_part * radius_))) continue;
            if (!is_over(a_is_smaller_ ? now.b : now.a, corner, height)) continue;
            manifold_->set_breaking_threshold(threshold);
            manifold_->add(known.normal, a_is_smaller_ ? on_surface - away * height : on_surface, height, a_.part,
                           b_.part);
        }
        manifold_->set_breaking_threshold(near_);
    }

    // The hulls at the predicted moment of touch within the step, without rotation.
    struct Touch {
        Frames at;                   // b translated by the relative motion
        glm::vec3 translation{0.0f}; // m, of b
        glm::vec3 normal{0.0f}, on_b{0.0f};
        float distance = 0.0f; // m, remaining
    };
    // Conservative advancement along the relative velocity; empty for hulls that pass or part.
    std::optional<Touch> touch_ahead(const Frames& now, float seconds) {
        const glm::vec3 against = velocity_against((a_is_smaller_ ? now.a : now.b).origin);
        const glm::vec3 whole = (a_is_smaller_ ? -against : against) * seconds;
        Touch touch{.at = now};
        float part = 0.0f;
        for (int advance = 0; advance < max_advances; ++advance) {
            const HullDistance found =
                hull_distance(*a_.shape, *b_.shape, touch.at.a.to_local(touch.at.b), unbounded, simplex_);
            touch.distance = found.distance - margins_;
            touch.normal = touch.at.a.basis * found.normal;
            touch.on_b = touch.at.a * (found.point + found.normal * b_.shape->margin());
            if (touch.distance < near_) return touch;
            const float closing = glm::dot(touch.normal, whole);
            if (!(closing > 0.0f)) return std::nullopt;
            part += (touch.distance - 0.5f * near_) / closing;
            if (part > 1.0f) return std::nullopt;
            touch.translation = whole * part;
            touch.at.b.origin = now.b.origin + touch.translation;
        }
        return touch;
    }

    // Replaces the contacts at the nearest points by contacts of the predicted moment of touch:
    // the middle of the smaller hull's lower corners, the point of touch, and the lower corners that are farthest
    // from these.
    void meet_ahead(const Frames& now, float seconds) {
        const std::optional<Touch> touch = touch_ahead(now, seconds);
        manifold_->clear();
        manifold_->set_breaking_threshold(near_);
        if (!touch) return;
        const HullShape& hull = smaller();
        const Transform& frame = a_is_smaller_ ? touch->at.a : touch->at.b;
        const Transform& other_frame = a_is_smaller_ ? touch->at.b : touch->at.a;
        const glm::vec3 away = a_is_smaller_ ? touch->normal : -touch->normal;
        const glm::vec3 on_other = a_is_smaller_ ? touch->on_b : touch->on_b + touch->normal * touch->distance;
        thread_local std::vector<glm::vec3> low; // corners
        low.clear();
        glm::vec3 middle(0.0f);
        for (const glm::vec3& local : hull.points()) {
            const glm::vec3 corner = frame * local;
            if (glm::dot(corner - frame.origin, away) > 0.0f) continue;
            middle += corner;
            low.push_back(corner);
        }
        const auto add = [&](const glm::vec3& corner) {
            const Below below = below_of(other_frame, corner);
            if (glm::dot(below.away, away) < same_way) return;
            const ContactPoint point = predicted(*touch, corner - below.away * hull.margin(), below);
            if (!has_contact_near(on_smaller(point), same_part * radius_)) manifold_->add(point);
        };
        if (!low.empty())
            add(middle * (1.0f / static_cast<float>(low.size()))); // solved first: the body turns only if it must
        manifold_->add(predicted(*touch, on_other + away * touch->distance, {away, touch->distance}));
        while (!low.empty() && manifold_->count() < Manifold::max_points) {
            const auto farthest = std::ranges::max_element(low, {}, [&](const glm::vec3& corner) {
                return to_contacts(a_is_smaller_ ? corner : corner - touch->translation);
            });
            add(*farthest);
            low.erase(farthest);
        }
    }

    // The larger hull relative to a point of the smaller hull's core: the direction away from it, and the gap.
    struct Below {
        glm::vec3 away;
        float distance;
    };
    [[nodiscard]] Below below_of(const Transform& larger_frame, const glm::vec3& corner,
                                 float limit = unbounded) const {
        static const HullShape tip({glm::vec3(0.0f)}, 0.0f);
        NearestCorners nowhere;
        const HullDistance found =
            hull_distance(tip, larger(), Transform{glm::mat3(1.0f), corner}.to_local(larger_frame), limit, nowhere);
        return {found.normal, found.distance - margins_};
    }

    // The present contact of a point that will be at that gap from the larger hull. It is placed on the light body,
    // because an inexact lever arm matters less on the heavy one.
    [[nodiscard]] ContactPoint predicted(const Touch& touch, const glm::vec3& on_surface, const Below& below) const {
        const bool b_is_light = a_pushes_b_, light_is_smaller = b_is_light != a_is_smaller_;
        const glm::vec3 then = light_is_smaller ? on_surface : on_surface - below.away * below.distance;
        const glm::vec3 on_light = b_is_light ? then - touch.translation : then;
        ContactPoint point;
        point.normal = a_is_smaller_ ? below.away : -below.away;
        point.distance = below.distance + glm::dot(point.normal, touch.translation);
        const glm::vec3 gap = point.normal * point.distance;
        point.on_a = b_is_light ? on_light + gap : on_light;
        point.on_b = b_is_light ? on_light : on_light - gap;
        point.local_a = a_.body->frame.to_local(point.on_a);
        point.local_b = b_.body->frame.to_local(point.on_b);
        point.part_a = a_.part;
        point.part_b = b_.part;
        point.tangent = tangents_of(point.normal).first;
        return point;
    }

    // The square of the distance to the nearest contact.
    [[nodiscard]] float to_contacts(const glm::vec3& on_surface) const {
        float least = unbounded;
        for (const ContactPoint& known : manifold_->points())
            least = std::min(least, length_squared(on_smaller(known) - on_surface));
        return least;
    }

    [[nodiscard]] bool has_contact_near(const glm::vec3& on_surface, float distance) const {
        return std::ranges::any_of(manifold_->points(), [&](const ContactPoint& known) {
            return length_squared(on_smaller(known) - on_surface) < distance * distance;
        });
    }

    // Whether a corner of the smaller hull is over the face of a contact: its distances from the larger hull and from
    // the contact's plane are equal.
    [[nodiscard]] bool is_over(const Transform& larger_frame, const glm::vec3& corner, float height) const {
        const float limit = margins_ + near_ + std::max(height, 0.0f);
        return std::abs(below_of(larger_frame, corner, limit).distance - height) < near_;
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
    bool on_larger_;         // one hull is much larger
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

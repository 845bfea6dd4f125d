#include "physics/solver/sleeping.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "physics/solver/manifold.h"
#include "physics/solver/parallel_loops.h"

namespace brittle::physics {

namespace {

// The part of its velocity that a body keeps per second while it settles: half a second reduces jitter to nothing.
constexpr float settling_kept_per_second = 1e-6f;
// A settling body above the sleeping speeds, but below this multiple of them, trembles: its time counts down instead of
// starting anew.
constexpr float tremble_factor = 4.0f;
// If this part of an island's mass is still and nothing is faster than a tremble, its other bodies count as still after
// this multiple of the sleeping time.
constexpr float calm_part = 0.9f;
constexpr float quiet_factor = 2.0f;
// A body rocks in place, at any speed, if for this multiple of the sleeping time it has stayed within this part of the
// distance and angle that the sleeping speeds cover in the sleeping time (4 cm and 0.4 rad).
constexpr float place_factor = 2.0f;
constexpr float place_part = 1.0f;
// s, without disturbance, until a body rests: by then a body that has lost its support is moving, and contact forces
// are steady.
constexpr float undisturbed_seconds = 0.1f;
// Upper bound of the time that counts, as a multiple of the sleeping time: a body that waits for its neighbours
// survives a tremble.
constexpr float patience = 1.5f;
// A body that is deeper than this in the ground, m, does not fall asleep until it has risen, or has been in one place
// for this multiple of the sleeping time: a crumb under a body hundreds of times as heavy never rises.
constexpr float sunk_depth = 1e-3f;
constexpr float sunk_factor = 8.0f;

// Friction below this part of its bound holds. A body that no contact holds slides if it is faster than this part of
// the sleeping speed: it gains speed on a slope that is steeper than the angle of repose.
constexpr float holding_part = 0.98f, sliding_part = 0.05f;

// Sets a flag that several threads may set.
void note(bool& fact) {
    std::atomic_ref(fact).store(true, std::memory_order_relaxed);
}

// Returns the angle between two orientations, rad.
float angle_between(const glm::quat& a, const glm::quat& b) {
    const auto dot = [](const glm::quat& p, const glm::quat& q) {
        return p.x * q.x + p.y * q.y + p.z * q.z + p.w * q.w;
    };
    const float cosine = std::abs(dot(a, b)) / std::sqrt(dot(a, a) * dot(b, b));
    return std::acos(std::min(cosine, 1.0f)) * 2.0f;
}

struct Hold {
    bool loaded = false, holds = false; // as in Touching
};
// Sums the impulses of a manifold's points.
Hold hold_of(const auto& points, float coefficient) {
    float normal = 0.0f, friction = 0.0f;
    for (const auto& point : points) {
        normal += point.last.normal;
        friction += glm::length(point.last.friction);
    }
    return {normal > 0.0f, friction < holding_part * coefficient * normal};
}

bool is_ready(const Body& body) {
    return body.activity == Activity::ready;
}

} // namespace

void Sleeping::update_resting(float seconds) {
    find_contact_states();
    for_each_body(islands_.awake(), threads_, [&](Body& body) { update_resting(body, seconds); });
}

void Sleeping::find_contact_states() {
    contact_states_.assign(bodies_.size(), {});
    for_each_body(islands_.awake(), threads_, [&](const Body& body) {
        if (is_fast(body) || (rises(body) && waited(body) >= settings_.sleep_seconds))
            note(contact_states_[islands_.of(body)].busy);
    });
    const auto note_contacts = [&](uint32_t body, uint32_t groups, bool is_loaded) -> ContactState& {
        ContactState& state = contact_states_[body];
        std::atomic_ref(state.contact_groups).fetch_add(groups, std::memory_order_relaxed);
        if (is_loaded) note(state.is_loaded);
        return state;
    };
    for_each_contact(islands_.manifolds(), threads_, [&](const AnyManifold& manifold) {
        if (const GroundManifold* const ground = manifold.ground) {
            const bool is_loaded =
                std::ranges::any_of(ground->points(), [](const GroundPoint& p) { return p.last.normal > 0.0f; });
            note_contacts(manifold.a, (ground->count + Manifold::max_points - 1) / Manifold::max_points, is_loaded);
            return;
        }
        const bool is_loaded = manifold.visit([](const auto& of) {
            return std::ranges::any_of(of.points(), [](const auto& p) { return p.last.normal > 0.0f; });
        });
        const auto note_other = [&](uint32_t body, uint32_t other, bool other_moves) {
            ContactState& state = note_contacts(body, 1, is_loaded);
            if (!other_moves) return;
            const Body& touched = *bodies_[other];
            if (!is_ready(touched) && speed_of(touched) > 1.0f) note(state.disturbed);
        };
        if (manifold.a_moves) note_other(manifold.a, manifold.b, manifold.b_moves);
        if (manifold.b_moves) note_other(manifold.b, manifold.a, manifold.a_moves);
    });
}

void Sleeping::update_resting(Body& body, float seconds) const {
    const ContactState& state = contact_states_[body.index];
    const bool lost_contacts = state.contact_groups < body.resting_on;
    const bool kept_awake = contact_states_[islands_.of(body)].busy || state.disturbed || lost_contacts
                            || !is_ready(body) || body.joints > 0;
    // Excludes falling bodies: they are fast after their first step, and have no contact impulse.
    const bool carried = body.resting || (state.is_loaded && speed_of(body) <= 1.0f);
    body.undisturbed_seconds = kept_awake ? 0.0f : body.undisturbed_seconds + seconds;
    const bool rests = body.undisturbed_seconds >= undisturbed_seconds && carried;
    if (!body.resting || !rests) body.resting_on = state.contact_groups;
    body.resting = rests;
    if (rests) body.velocity = {};
}

void Sleeping::settle(float seconds) {
    find_touching(seconds);
    for_each_body(islands_.awake(), threads_, [&](Body& body) {
        body.touching = touching_[body.index].any || body.joints > 0;
        body.sunk = touching_[body.index].sunk;
        count_still(body, seconds);
    });
    find_calm();
    const float kept = std::pow(settling_kept_per_second, seconds);
    for_each_body(islands_.awake(), threads_, [&](Body& body) {
        count_quiet(body, seconds);
        if (waited(body) > 0.5f * settings_.sleep_seconds) {
            body.velocity.linear *= kept;
            body.velocity.angular *= kept;
        }
        const bool ready = waited(body) >= settings_.sleep_seconds && body.touching && !rises(body);
        body.set_activity(ready ? Activity::ready : Activity::awake);
    });
}

void Sleeping::find_touching(float seconds) {
    touching_.assign(bodies_.size(), {});
    for_each_contact(islands_.manifolds(), threads_, [&](const AnyManifold& manifold) {
        const Hold hold = manifold.visit([&](const auto& of) { return hold_of(of.points(), manifold.friction()); });
        const auto note_touch = [&](Touching& of) {
            note(of.any);
            if (hold.loaded) note(of.loaded);
            if (hold.holds) note(of.holds);
        };
        note_touch(touching_[manifold.a]);
        if (!manifold.ground) return note_touch(touching_[manifold.b]);
        const Body& body = *bodies_[manifold.a];
        // Depth in the pose in which the body would sleep: after the motion of the step.
        for (const GroundPoint& point : manifold.ground->points()) {
            const glm::vec3 arm = point.position - body.rewind_frame.origin;
            const float rise = body.motion.at(arm).y * seconds;
            if (point.distance + rise < -sunk_depth) note(touching_[manifold.a].sunk);
        }
    });
}

void Sleeping::count_still(Body& body, float seconds) const {
    const float speed = speed_of(body);
    const Touching& touching = touching_[body.index];
    const bool slides = touching.loaded && !touching.holds
                        && glm::length(body.velocity.linear) > sliding_part * settings_.sleep_linear_speed;
    const bool in_place = rocks_in_place(body, seconds) && !slides;
    // A tremble counts the time down instead of resetting it.
    if (!in_place && (!body.touching || slides || speed > tremble_factor))
        body.still_seconds = 0.0f;
    else
        body.still_seconds = std::clamp(body.still_seconds + (in_place || speed < 1.0f ? seconds : -seconds), 0.0f,
                                        patience * settings_.sleep_seconds);
}

bool Sleeping::rocks_in_place(Body& body, float seconds) const {
    const float near = place_part * settings_.sleep_seconds;
    const float moved = glm::length(body.frame.origin - body.rest.origin);
    const float rotated = angle_between(rotation_of(body.frame.basis), rotation_of(body.rest.basis));
    if (moved > near * settings_.sleep_linear_speed || rotated > near * settings_.sleep_angular_speed) {
        body.rest = body.frame;
        body.rest_seconds = 0.0f;
    }
    if (body.touching) body.rest_seconds += seconds;
    return body.rest_seconds > place_factor * settings_.sleep_seconds;
}

void Sleeping::find_calm() {
    calm_.assign(bodies_.size(), {});
    for (const Body* body : islands_.awake()) {
        Calm& island = calm_[islands_.of(*body)];
        island.mass += body->mass;
        if (body->still_seconds >= 0.5f * settings_.sleep_seconds) island.still_mass += body->mass;
        island.fast = island.fast || is_fast(*body);
    }
}

// The body counts how long its island has been calm, because islands are found anew in each step.
void Sleeping::count_quiet(Body& body, float seconds) const {
    const Calm& island = calm_[islands_.of(body)];
    const bool quiet = !island.fast && island.still_mass >= calm_part * island.mass;
    body.quiet_seconds =
        quiet ? std::min(body.quiet_seconds + seconds, patience * quiet_factor * settings_.sleep_seconds) : 0.0f;
}

bool Sleeping::rises(const Body& body) const {
    return body.sunk && body.rest_seconds < sunk_factor * settings_.sleep_seconds;
}

float Sleeping::waited(const Body& body) const {
    return std::max(body.still_seconds, body.quiet_seconds / quiet_factor);
}

bool Sleeping::is_fast(const Body& body) const {
    return glm::length(body.velocity.linear) > tremble_factor * settings_.sleep_linear_speed;
}

// A sleeping speed may be 0: a body that moves then has an infinite multiple.
float Sleeping::speed_of(const Body& body) const {
    return std::max(glm::length(body.velocity.linear) / (settings_.sleep_linear_speed),
                    glm::length(body.velocity.angular) / settings_.sleep_angular_speed);
}

} // namespace brittle::physics

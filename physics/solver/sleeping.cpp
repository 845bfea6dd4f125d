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
// A settling body that trembles above the sleeping speeds, but not by this factor, waits longer instead of anew.
constexpr float tremble_factor = 4.0f;
// Where this part of an island's mass is still and nothing is faster than a tremble, the rest counts as still after
// this multiple of the sleeping time.
constexpr float calm_part = 0.9f;
constexpr float quiet_factor = 2.0f;
// A body that after this multiple of the sleeping time still is within this part of what the sleeping speeds make of
// the sleeping time (4 cm and 0.4 rad) from where it was rocks in place, however fast.
constexpr float place_factor = 2.0f;
constexpr float place_part = 1.0f;
// A body rests once nothing has disturbed it for so long, s: a body that has lost its support is on its way by then,
// and contacts press as they will go on to.
constexpr float undisturbed_seconds = 0.1f;
// Waiting counts up to this multiple of the sleeping time, so that a tremble does not at once wake a body that waits
// for its neighbours.
constexpr float patience = 1.5f;
// A body that is deeper than this in the ground, m, does not fall asleep before it has come up, or has been where it
// is for this multiple of the sleeping time: a crumb under a body of hundreds of times its mass never comes up.
constexpr float sunk_depth = 1e-3f;
constexpr float sunk_factor = 8.0f;

// Several threads may note the same fact.
void note(bool& fact) {
    std::atomic_ref(fact).store(true, std::memory_order_relaxed);
}

// Of two orientations, rad.
float angle_between(const glm::quat& a, const glm::quat& b) {
    const auto dot = [](const glm::quat& p, const glm::quat& q) {
        return p.x * q.x + p.y * q.y + p.z * q.z + p.w * q.w;
    };
    const float cosine = std::abs(dot(a, b)) / std::sqrt(dot(a, a) * dot(b, b));
    return std::acos(std::min(cosine, 1.0f)) * 2.0f;
}

bool is_ready(const Body& body) {
    return body.activity == Activity::ready;
}

} // namespace

void Sleeping::let_rest(float seconds) {
    find_company();
    for_each_body(islands_.awake(), threads_, [&](Body& body) { let_rest(body, seconds); });
}

void Sleeping::find_company() {
    company_.assign(bodies_.size(), {});
    for_each_body(islands_.awake(), threads_, [&](const Body& body) {
        if (is_fast(body) || (rises(body) && waited(body) >= settings_.sleep_seconds))
            note(company_[islands_.of(body)].busy);
    });
    const auto note_contacts = [&](uint32_t body, uint32_t groups, bool pressed) -> Company& {
        Company& company = company_[body];
        std::atomic_ref(company.contact_groups).fetch_add(groups, std::memory_order_relaxed);
        if (pressed) note(company.pressed);
        return company;
    };
    for_each_contact(islands_.manifolds(), threads_, [&](const AnyManifold& manifold) {
        if (const GroundManifold* const ground = manifold.ground) {
            const bool pressed = std::ranges::any_of(
                ground->points(), [](const GroundPoint& p) { return p.warm_normal_impulse() > 0.0f; });
            note_contacts(manifold.a, (ground->count + Manifold::max_points - 1) / Manifold::max_points, pressed);
            return;
        }
        const bool pressed = std::ranges::any_of(std::as_const(*manifold.between).points(),
                                                 [](const ContactPoint& p) { return p.normal_impulse > 0.0f; });
        const auto note_other = [&](uint32_t body, uint32_t other, bool other_moves) {
            Company& company = note_contacts(body, 1, pressed);
            if (!other_moves) return;
            const Body& touched = *bodies_[other];
            if (!is_ready(touched) && speed_of(touched) > 1.0f) note(company.disturbed);
        };
        if (manifold.a_moves) note_other(manifold.a, manifold.b, manifold.b_moves);
        if (manifold.b_moves) note_other(manifold.b, manifold.a, manifold.a_moves);
    });
}

void Sleeping::let_rest(Body& body, float seconds) const {
    const Company& company = company_[body.index];
    const bool lost_contacts = company.contact_groups < body.resting_on;
    const bool kept_awake = company_[islands_.of(body)].busy || company.disturbed || lost_contacts || !is_ready(body);
    // A falling body is too fast after its first step, and nothing presses on it.
    const bool carried = body.resting || (company.pressed && speed_of(body) <= 1.0f);
    body.undisturbed_seconds = kept_awake ? 0.0f : body.undisturbed_seconds + seconds;
    const bool rests = body.undisturbed_seconds >= undisturbed_seconds && carried;
    if (!body.resting || !rests) body.resting_on = company.contact_groups;
    body.resting = rests;
    if (rests) body.velocity = {};
}

void Sleeping::settle(float seconds) {
    find_touching(seconds);
    for_each_body(islands_.awake(), threads_, [&](Body& body) {
        body.touching = touching_[body.index].any;
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
        note(touching_[manifold.a].any);
        if (!manifold.ground) return note(touching_[manifold.b].any);
        const Body& body = *bodies_[manifold.a];
        // Where it would sleep: after the step, which may have turned a corner down, and the correction of overlap
        // that is due.
        for (const GroundPoint& point : manifold.ground->points()) {
            const glm::vec3 arm = point.position - body.rewind_frame.origin;
            float rise = body.velocity.at(arm).y * seconds;
            if (body.has_correction) rise += (body.correction * arm - arm).y;
            if (point.distance + rise < -sunk_depth) note(touching_[manifold.a].sunk);
        }
    });
}

void Sleeping::count_still(Body& body, float seconds) const {
    const float speed = speed_of(body);
    const bool in_place = rocks_in_place(body, seconds);
    // One tremble that is soon over does not start the wait anew.
    if (!in_place && (!body.touching || speed > tremble_factor))
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

// How long its island has been quiet is counted in the body, as islands come and go.
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

// The sleeping speeds may be 0.
float Sleeping::speed_of(const Body& body) const {
    return std::max(glm::length(body.velocity.linear) / (settings_.sleep_linear_speed),
                    glm::length(body.velocity.angular) / settings_.sleep_angular_speed);
}

} // namespace brittle::physics

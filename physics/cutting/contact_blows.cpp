#include "physics/cutting/contact_blows.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "physics/world/body_motion.h"

namespace brittle::physics {

namespace {

// Velocity of the point at `arm`, in world axes; zero for the ground.
glm::vec3 velocity_at(const World& world, BodyId body, const glm::vec3& arm) {
    if (!world.contains(body)) return glm::vec3(0.0f);
    return world.linear_velocity(body) + glm::cross(world.angular_velocity(body), arm);
}

// m/s at which the other body approaches along the normal, away from the body where negative.
float approach_speed(const World& world, const BodyBlow& blow, const glm::vec3& normal) {
    const glm::vec3 arm(to_world_axes(world.pose(blow.body), glm::dvec3(blow.point)));
    return glm::dot(velocity_at(world, blow.other, blow.arm) - velocity_at(world, blow.body, arm), normal);
}

} // namespace

float bounce_energy(const World& world, const BodyBlow& blow) {
    return 0.5f * blow.impulse * std::max(-approach_speed(world, blow, blow.normal), 0.0f);
}

std::vector<BodyBlow> BlowTracker::update(const World& world, float speed, const std::function<bool(BodyId)>& filter) {
    std::vector<Running> now = blows_of_step(world, speed, filter);
    std::vector<BodyBlow> over;
    for (const Running& before : running_) {
        if (!world.contains(before.blow.body) || !filter(before.blow.body)) continue;
        const auto next = std::ranges::find_if(now, [&](const Running& running) {
            return running.blow.body == before.blow.body && running.blow.other == before.blow.other;
        });
        if (next == now.end())
            over.push_back(ended(before));
        else
            join(*next, before);
    }
    running_.clear();
    for (const Running& running : now)
        if (running.steps < max_steps && continues(world, running, speed))
            running_.push_back(running);
        else
            over.push_back(ended(running));
    return over;
}

// Contact points belong to the poses at the start of the step.
std::vector<BlowTracker::Running> BlowTracker::blows_of_step(const World& world, float speed,
                                                             const std::function<bool(BodyId)>& filter) {
    std::vector<Running> blows;
    for (const Contact& contact : world.solved_contacts()) {
        if (!(contact.speed > speed && contact.impulse > 0.0f)) continue;
        for (const bool first : {true, false}) {
            const BodyId own = first ? contact.a : contact.b, other = first ? contact.b : contact.a;
            if (!world.contains(own) || !filter(own)) continue;
            auto at = std::ranges::find_if(
                blows, [&](const Running& known) { return known.blow.body == own && known.blow.other == other; });
            if (at == blows.end()) at = blows.insert(blows.end(), Running{.blow = {.body = own, .other = other}});
            at->total_impulse += contact.impulse;
            BodyBlow& blow = at->blow;
            const float part = contact.impulse / at->total_impulse;
            const Pose pose = world.previous_pose(own);
            blow.point += (glm::vec3(to_body_axes(pose, contact.point - pose.position)) - blow.point) * part;
            if (world.contains(other))
                blow.arm += (contact.point - world.previous_pose(other).position - blow.arm) * part;
            blow.normal += contact.impulse * (first ? contact.normal : -contact.normal);
            blow.friction += first ? contact.friction : -contact.friction;
            blow.energy += 0.5f * contact.impulse * contact.speed;
        }
    }
    for (Running& running : blows) running.speed = 2.0f * running.blow.energy / running.total_impulse;
    return blows;
}

// The remaining approach is slower than the first, but the same mass takes part: the first speed gives the energy.
void BlowTracker::join(Running& now, const Running& before) {
    const float part = before.total_impulse / (before.total_impulse + now.total_impulse);
    now.blow.energy = std::max(now.blow.energy, 0.5f * now.total_impulse * before.speed) + before.blow.energy;
    now.blow.point += (before.blow.point - now.blow.point) * part;
    now.blow.arm += (before.blow.arm - now.blow.arm) * part;
    now.blow.normal += before.blow.normal;
    now.blow.friction += before.blow.friction;
    now.total_impulse += before.total_impulse;
    now.speed = before.speed;
    now.steps = before.steps + 1;
}

bool BlowTracker::continues(const World& world, const Running& running, float speed) {
    const BodyBlow& blow = running.blow;
    const float length = glm::length(blow.normal);
    if (!(length > 0.0f)) return false;
    return approach_speed(world, blow, blow.normal / length) > speed;
}

BodyBlow BlowTracker::ended(const Running& running) {
    BodyBlow blow = running.blow;
    blow.impulse = glm::length(blow.normal);
    if (blow.impulse > 0.0f) blow.normal /= blow.impulse;
    const float mean_speed = 2.0f * blow.energy / running.total_impulse;
    blow.equivalent_impulse = blow.impulse > 0.0f ? blow.impulse * std::cbrt(mean_speed / blow.impulse) : 0.0f;
    return blow;
}

} // namespace brittle::physics

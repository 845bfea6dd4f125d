#include "tools/brittle/stage/particles.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>

#include "fracture/base/random.h"

namespace brittle::tools {

namespace {

using fracture::Random;

// All chosen by eye, for objects of some decimetres to some metres.
constexpr float splinters_a_square_metre = 400.0f, max_splinters_of_crack = 24.0f;
constexpr float puffs_a_square_metre = 110.0f, max_puffs_of_crack = 6.0f;
constexpr float splinter_life = 5.0f, puff_life = 2.4f; // s, the longest
constexpr float shrinking = 0.8f;                       // s, the end of a splinter's life in which it shrinks
constexpr float gravity = 9.81f;                        // m/s^2
constexpr float restitution = 0.3f, friction = 0.6f;    // of a splinter on a surface
constexpr float rest_speed = 0.25f;                     // m/s; a slower splinter on a surface comes to rest,
constexpr float max_support_speed = 0.05f;              // m/s, unless the surface is faster than this
constexpr float min_rest_normal = 0.7f;                 // or steeper: the least upward part of its normal
constexpr float support_slack = 0.002f;                 // m; a support that sinks by more between two looks is gone
constexpr float free_seconds = 0.1f;                    // s, of a new particle in which it meets no obstacle
constexpr float look_beyond = 0.01f;                    // m, beyond the way: an obstacle may come nearer
constexpr float min_gap = 5e-4f;                        // m; a particle that is nearer to a surface is moved off it
constexpr float puff_drag = 2.6f;                       // 1/s
constexpr float puff_growth = 1.3f;                     // of its radius in its life, as a share
constexpr float puff_sinks = 0.06f;                     // m/s

float between(Random& random, float low, float high) {
    return low + (high - low) * static_cast<float>(random.uniform());
}

// A point of the unit ball.
glm::vec3 in_ball(Random& random) {
    for (;;) {
        const float x = between(random, -1.0f, 1.0f), y = between(random, -1.0f, 1.0f);
        const glm::vec3 p(x, y, between(random, -1.0f, 1.0f));
        if (glm::dot(p, p) <= 1.0f) return p;
    }
}

glm::quat turned(const glm::quat& rotation, const glm::vec3& by) {
    const float angle = glm::length(by);
    return angle > 0.0f ? glm::normalize(glm::angleAxis(angle, by / angle) * rotation) : rotation;
}

// How many of an expected number, of which there is room for some: the number or the next one, at random.
size_t some(Random& random, float expected, size_t present, size_t most) {
    const float room = 1.0f - static_cast<float>(present) / static_cast<float>(most);
    const auto number = static_cast<size_t>(expected * room + static_cast<float>(random.uniform()));
    return std::min(number, most - present);
}

glm::vec3 velocity_against(const glm::vec3& velocity, const std::optional<Obstacle>& obstacle) {
    return obstacle ? velocity - obstacle->velocity : velocity;
}

// The way, and as far beyond as a particle is thick and an obstacle may come towards it.
Way longer(const Way& way, float thickness) {
    const float length = glm::distance(way.from, way.to);
    return length > 0.0f ? Way{way.from, way.to + (thickness + look_beyond) / length * (way.to - way.from)} : way;
}

// The gap that a particle keeps from an obstacle; one that is nearer already stays there.
float gap_of(const glm::vec3& at, const Obstacle& obstacle, float wanted) {
    return std::min(wanted, std::max(glm::dot(at - obstacle.point, obstacle.normal), min_gap));
}

} // namespace

void Particles::set_ground(bool exists, float height) {
    has_ground_ = exists;
    ground_ = height;
}

void Particles::clear() {
    splinters_.clear();
    puffs_.clear();
    bursts_ = 0;
}

void Particles::burst(const Crack& crack, const ParticleLook& look, uint64_t seed) {
    Random random(seed);
    const float area = std::max(crack.area, 0.0f);
    const float side = std::sqrt(area); // of a square as large as the crack
    const uint32_t look_in = 1 + bursts_++ % look_steps;
    // Across the crack particles come from a thin layer; they leave mostly along it.
    const auto in_crack = [&](const glm::vec3& p, float across) {
        return p - (1.0f - across) * glm::dot(p, crack.normal) * crack.normal;
    };
    const float splinters = std::min(splinters_a_square_metre * area, max_splinters_of_crack) * look.splinters;
    for (size_t k = some(random, splinters, splinters_.size(), max_splinters); k > 0; --k) {
        FlyingSplinter& one = splinters_.emplace_back();
        one.look_in = look_in;
        const glm::vec3 from = in_ball(random);
        one.at = crack.at + 0.5f * side * in_crack(from, 0.1f);
        const glm::vec3 away = in_crack(from, 0.5f) + 0.6f * in_ball(random);
        one.velocity =
            crack.velocity + between(random, 0.4f, 2.0f) * away + glm::vec3(0.0f, between(random, 0.0f, 0.8f), 0.0f);
        one.life = splinter_life * between(random, 0.5f, 1.0f);
        const float spread = between(random, 0.0f, 1.0f);
        one.length = std::clamp(side * (0.015f + 0.07f * spread * spread * spread), 0.0015f, 0.03f) * look.length;
        one.width = look.width * between(random, 0.5f, 1.0f);
        one.spin = 20.0f * in_ball(random);
        one.rotation = turned({1.0f, 0.0f, 0.0f, 0.0f}, glm::pi<float>() * in_ball(random));
        one.colour = look.splinter_colour * between(random, 0.75f, 1.1f);
    }
    const float puffs = std::min(puffs_a_square_metre * area, max_puffs_of_crack) * look.dust;
    for (size_t k = some(random, puffs, puffs_.size(), max_puffs); k > 0; --k) {
        FlyingPuff& one = puffs_.emplace_back();
        one.look_in = look_in;
        const glm::vec3 from = in_ball(random);
        one.at = crack.at + 0.4f * side * in_crack(from, 0.2f);
        one.velocity =
            0.6f * crack.velocity + between(random, 0.2f, 1.0f) * in_crack(from, 0.6f) + 0.15f * in_ball(random);
        one.life = puff_life * between(random, 0.4f, 1.0f);
        one.radius = std::clamp(0.6f * side, 0.03f, 0.25f) * between(random, 0.7f, 1.3f);
        one.opacity = between(random, 0.3f, 0.65f);
        one.colour = look.dust_colour * between(random, 0.9f, 1.05f);
        one.pattern = static_cast<uint32_t>(random.next());
    }
}

// While it flies: where it will be, against the obstacle that it met last, and a little beyond. At rest: towards its
// support.
Way Particles::way_of(const FlyingSplinter& splinter, float seconds) {
    if (splinter.rests) return {splinter.at, splinter.at - (splinter.gap + support_slack) * splinter.ahead->normal};
    constexpr float steps = look_steps, falls = 0.5f * steps * (steps + 1.0f);
    const glm::vec3 way = steps * seconds * velocity_against(splinter.velocity, splinter.ahead)
                          - glm::vec3(0.0f, falls * gravity * seconds * seconds, 0.0f);
    return longer({splinter.at, splinter.at + way}, splinter.length * splinter.width);
}

Way Particles::way_of(const FlyingPuff& puff, float seconds) {
    const glm::vec3 way = look_steps * seconds * velocity_against(puff.velocity, puff.ahead);
    return longer({puff.at, puff.at + way}, 0.5f * puff.radius);
}

void Particles::take(FlyingSplinter& splinter, const std::optional<Obstacle>& met) {
    if (splinter.rests) {
        if (met && glm::length(met->velocity) <= max_support_speed) {
            splinter.ahead = met;
            splinter.at = met->point + splinter.gap * met->normal; // follows a slow one
            splinter.look_in = support_steps;
            return;
        }
        splinter.rests = false; // and looks again in the next step
        splinter.look_in = 1;
    }
    splinter.ahead = met;
    if (met) splinter.gap = gap_of(splinter.at, *met, 0.5f * splinter.length * splinter.width);
}

void Particles::take(FlyingPuff& puff, const std::optional<Obstacle>& met) {
    puff.ahead = met;
    if (met) puff.gap = gap_of(puff.at, *met, 0.5f * puff.radius);
}

void Particles::look(auto& all, float seconds, const Obstacles& obstacles) {
    ways_.clear();
    looking_.clear();
    for (size_t k = 0; k < all.size(); ++k) {
        auto& one = all[k];
        if (one.look_in > 0) --one.look_in;
        if (one.look_in > 0) continue;
        one.look_in = look_steps;
        if (!obstacles || one.age < free_seconds) {
            one.rests = one.rests && !one.ahead; // on the ground
            one.ahead.reset();
        } else if (!one.rests || one.ahead) {
            ways_.push_back(way_of(one, seconds));
            looking_.push_back(k);
        }
    }
    if (ways_.empty()) return;
    met_.assign(ways_.size(), std::nullopt);
    obstacles(ways_, met_);
    for (size_t k = 0; k < looking_.size(); ++k) take(all[looking_[k]], met_[k]);
}

// Bounces off a surface, then lies on it.
void Particles::bounce(FlyingSplinter& splinter, const Obstacle& obstacle, float gap) {
    const float height = glm::dot(splinter.at - obstacle.point, obstacle.normal);
    if (height > gap) return;
    splinter.at += (gap - height) * obstacle.normal;
    const glm::vec3 relative = splinter.velocity - obstacle.velocity;
    const float away = glm::dot(relative, obstacle.normal);
    const glm::vec3 along = relative - away * obstacle.normal,
                    after = friction * along + (away < 0.0f ? -restitution : 1.0f) * away * obstacle.normal;
    splinter.velocity = obstacle.velocity + after;
    splinter.spin *= friction;
    splinter.rests = glm::length(after) < rest_speed && obstacle.normal.y >= min_rest_normal
                     && glm::length(obstacle.velocity) <= max_support_speed;
}

void Particles::move(FlyingSplinter& splinter, float seconds) const {
    if (splinter.rests) {
        if (splinter.ahead) splinter.at += seconds * splinter.ahead->velocity;
        return;
    }
    splinter.velocity.y -= gravity * seconds;
    splinter.at += seconds * splinter.velocity;
    splinter.rotation = turned(splinter.rotation, seconds * splinter.spin);
    if (splinter.ahead) {
        splinter.ahead->point += seconds * splinter.ahead->velocity;
        bounce(splinter, *splinter.ahead, splinter.gap);
    }
    if (splinter.rests || !has_ground_) return;
    const Obstacle ground{glm::vec3(0.0f, ground_, 0.0f), glm::vec3(0.0f, 1.0f, 0.0f)};
    bounce(splinter, ground, 0.5f * splinter.length * splinter.width);
    if (splinter.rests) splinter.ahead.reset();
}

void Particles::move(FlyingPuff& puff, float seconds) const {
    const glm::vec3 sinking(0.0f, -puff_sinks, 0.0f);
    puff.velocity = sinking + (puff.velocity - sinking) * std::exp(-puff_drag * seconds);
    puff.at += seconds * puff.velocity;
    const auto stop = [&](const Obstacle& obstacle, float gap) {
        const float height = glm::dot(puff.at - obstacle.point, obstacle.normal);
        if (height > gap) return;
        puff.at += (gap - height) * obstacle.normal;
        puff.velocity -= std::min(glm::dot(puff.velocity - obstacle.velocity, obstacle.normal), 0.0f) * obstacle.normal;
    };
    if (puff.ahead) {
        puff.ahead->point += seconds * puff.ahead->velocity;
        stop(*puff.ahead, puff.gap);
    }
    if (has_ground_) stop({glm::vec3(0.0f, ground_, 0.0f), glm::vec3(0.0f, 1.0f, 0.0f)}, 0.5f * puff.radius);
}

void Particles::step(float seconds, const Obstacles& obstacles) {
    seconds_ = seconds;
    const auto step_all = [&](auto& all) {
        look(all, seconds, obstacles);
        for (auto& one : all) {
            one.age += seconds;
            move(one, seconds);
        }
        std::erase_if(all, [](const Flying& one) { return one.age >= one.life; });
    };
    step_all(splinters_);
    step_all(puffs_);
}

void Particles::draw(float alpha, std::vector<engine::Splinter>& splinters, std::vector<engine::DustPuff>& dust) const {
    const float before = (1.0f - alpha) * seconds_; // s between the moment drawn and the last step
    for (const FlyingSplinter& one : splinters_) {
        const float left = one.life - one.age + before;
        const float size = std::min(left / shrinking, 1.0f);
        const float back = one.rests ? 0.0f : before;
        splinters.push_back({.rotation = turned(one.rotation, -back * one.spin),
                             .centre = one.at - back * one.velocity,
                             .length = one.length * size,
                             .colour = one.colour,
                             .width = one.width});
    }
    for (const FlyingPuff& one : puffs_) {
        const float share = std::clamp((one.age - before) / one.life, 0.0f, 1.0f);
        // Grows fast at first, and thins out as it grows.
        const float grown = 1.0f + puff_growth * (1.0f - (1.0f - share) * (1.0f - share));
        dust.push_back({.centre = one.at - before * one.velocity,
                        .radius = one.radius * grown,
                        .colour = one.colour,
                        .opacity = one.opacity * (1.0f - share) * std::min(12.0f * share + 0.2f, 1.0f),
                        .pattern = one.pattern});
    }
}

} // namespace brittle::tools

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
constexpr float bounce = 0.3f, friction = 0.6f;         // of a splinter on the ground
constexpr float rest_speed = 0.25f;                     // m/s; a slower splinter on the ground comes to rest
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

} // namespace

void Particles::set_ground(bool exists, float height) {
    has_ground_ = exists;
    ground_ = height;
}

void Particles::clear() {
    splinters_.clear();
    puffs_.clear();
}

void Particles::burst(const Crack& crack, const ParticleLook& look, uint64_t seed) {
    Random random(seed);
    const float area = std::max(crack.area, 0.0f);
    const float side = std::sqrt(area); // of a square as large as the crack
    // Across the crack particles come from a thin layer; they leave mostly along it.
    const auto in_crack = [&](const glm::vec3& p, float across) {
        return p - (1.0f - across) * glm::dot(p, crack.normal) * crack.normal;
    };
    const float splinters = std::min(splinters_a_square_metre * area, max_splinters_of_crack) * look.splinters;
    for (size_t k = some(random, splinters, splinters_.size(), max_splinters); k > 0; --k) {
        FlyingSplinter& one = splinters_.emplace_back();
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

// Bounces off the ground, then lies on it.
void Particles::move(FlyingSplinter& splinter, float seconds) const {
    if (splinter.rests) return;
    splinter.velocity.y -= gravity * seconds;
    splinter.at += seconds * splinter.velocity;
    splinter.rotation = turned(splinter.rotation, seconds * splinter.spin);
    const float lowest = ground_ + 0.5f * splinter.length * splinter.width;
    if (!has_ground_ || splinter.at.y > lowest) return;
    splinter.at.y = lowest;
    splinter.velocity = glm::vec3(friction, -bounce, friction) * splinter.velocity;
    splinter.spin *= friction;
    splinter.rests = glm::length(splinter.velocity) < rest_speed;
}

void Particles::move(FlyingPuff& puff, float seconds) const {
    const glm::vec3 sinking(0.0f, -puff_sinks, 0.0f);
    puff.velocity = sinking + (puff.velocity - sinking) * std::exp(-puff_drag * seconds);
    puff.at += seconds * puff.velocity;
    const float lowest = ground_ + 0.5f * puff.radius;
    if (!has_ground_ || puff.at.y > lowest) return;
    puff.at.y = lowest;
    puff.velocity.y = std::max(puff.velocity.y, 0.0f);
}

void Particles::step(float seconds) {
    seconds_ = seconds;
    const auto step_all = [&](auto& all) {
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

#include "physics/solver/siblings.h"

#include <algorithm>
#include <map>

namespace brittle::physics {

namespace {

// Velocities of one rigid body may differ by less than this, m/s: rounding.
constexpr float same_speed = 1e-3f;

bool move_as_one(const Body& a, const Body& b) {
    const glm::vec3 arm = b.frame.origin - a.frame.origin;
    const glm::vec3 turning = b.velocity.angular - a.velocity.angular;
    const glm::vec3 apart = a.velocity.at(arm) - b.velocity.linear;
    return glm::length(apart) < same_speed && glm::length(turning) * glm::length(arm) < same_speed;
}

} // namespace

void Siblings::remove(const Body& body) {
    if (body.siblings != 0) std::erase(bodies_, &body);
}

void Siblings::check(const SweptPairs& pairs, std::optional<float> ground_height) {
    if (bodies_.empty()) return;
    apart_.clear();
    std::map<uint32_t, const Body*> firsts;
    const Body* first = nullptr; // first body of the current number; neighbours mostly share a number
    uint32_t min_rank = UINT32_MAX;
    for (const Body* body : bodies_) {
        if (!first || first->siblings != body->siblings) first = firsts.try_emplace(body->siblings, body).first->second;
        const bool low = ground_height && body->proxy->bounds.low.y <= *ground_height;
        if (low || body->joints > 0 || !move_as_one(*first, *body)) apart_.push_back(body->siblings);
        min_rank = std::min(min_rank, body->proxy->rank);
    }
    for (const uint32_t index : pairs.set()) {
        const SweptPair& pair = pairs.at(index);
        const bool both_old = pair.b->rank < min_rank,
                   ground = !pair.a->body || !pair.b->body; // the bounds of the ground contain all others
        if (both_old || ground || pair.a->body->siblings == pair.b->body->siblings) continue;
        apart_.insert(apart_.end(), {pair.a->body->siblings, pair.b->body->siblings});
    }
    std::ranges::sort(apart_);
    std::erase_if(bodies_, [this](Body* body) {
        if (!std::ranges::binary_search(apart_, body->siblings)) return false;
        body->siblings = 0;
        return true;
    });
}

} // namespace brittle::physics

#include "physics/contact_blows.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace brittle::physics {

std::vector<BodyBlow> find_blows(std::span<const Contact> contacts, float speed,
                                 const std::function<bool(BodyId)>& wanted) {
    std::vector<BodyBlow> blows;
    std::vector<float> sums; // of impulses, whatever their directions
    for (const Contact& contact : contacts) {
        if (!(contact.speed > speed && contact.impulse > 0.0f)) continue;
        for (const bool first : {true, false}) {
            const BodyId own = first ? contact.a : contact.b, other = first ? contact.b : contact.a;
            if (own == BodyId{} || !wanted(own)) continue;
            auto blow = std::ranges::find_if(
                blows, [&](const BodyBlow& known) { return known.body == own && known.other == other; });
            if (blow == blows.end()) {
                blow = blows.insert(blows.end(), {.body = own, .other = other});
                sums.push_back(0.0f);
            }
            float& sum = sums[static_cast<size_t>(blow - blows.begin())];
            sum += contact.impulse;
            blow->point += (contact.point - blow->point) * (contact.impulse / sum);
            blow->normal += contact.impulse * (first ? contact.normal : -contact.normal);
            blow->energy += 0.5f * contact.impulse * contact.speed;
        }
    }
    for (size_t i = 0; i < blows.size(); ++i) {
        BodyBlow& blow = blows[i];
        blow.impulse = glm::length(blow.normal);
        if (blow.impulse > 0.0f) blow.normal /= blow.impulse;
        const float mean_speed = 2.0f * blow.energy / sums[i];
        blow.sharp = blow.impulse > 0.0f ? blow.impulse * std::cbrt(mean_speed / blow.impulse) : 0.0f;
    }
    return blows;
}

} // namespace brittle::physics

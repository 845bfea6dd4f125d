// Structure::update(): blows, wear, and the splitting of bodies.
#include "physics/bonds/structure.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include <glm/geometric.hpp>

#include "physics/world/body_motion.h"

namespace brittle::physics {

namespace {

constexpr int rewound_sweeps = 10; // Gauss-Seidel sweeps over rewound contacts
// Contacts of one group that are solved again, at most: half a millisecond.
constexpr size_t max_rewound_contacts = 256;

bool is_movable(const World& world, BodyId body) {
    return world.contains(body) && !world.fixed(body);
}

// Returns the approach speed, m/s, that remains at a contact after the step; 0 for a contact that was amended after a
// break, as the velocities of its parts no longer belong to it.
float remaining_approach(const World& world, const Contact& contact) {
    if (contact.impulse != contact.blow) return 0.0f;
    return velocity_along(world, contact.b, contact.point, contact.normal)
           - velocity_along(world, contact.a, contact.point, contact.normal);
}

} // namespace

// Sums the fast contacts of the step into one blow per piece and striker.
std::vector<BondBlows::StepBlow> Structure::find_blows(const World& world) const {
    std::vector<BondBlows::StepBlow> blows;
    for (const Contact& contact : world.solved_contacts()) {
        if (!(contact.speed > desc_.impact_speed && contact.blow > 0.0f)) continue;
        for (const bool first : {true, false}) {
            const uint32_t piece = first ? piece_at(contact.a, contact.part_a) : piece_at(contact.b, contact.part_b);
            if (piece == none || !exists(world, pieces_[piece].body)) continue;
            const BodyId other = first ? contact.b : contact.a;
            auto at = std::ranges::find_if(blows, [&](const BondBlows::StepBlow& known) {
                return known.blow.piece == piece && known.blow.other == other;
            });
            if (at == blows.end()) at = blows.insert(blows.end(), {.blow = {.piece = piece, .other = other}});
            Impact& blow = at->blow;
            const float sum = blow.impulse + contact.blow;
            blow.point += (contact.point - blow.point) * (contact.blow / sum);
            if (contact.blow > 0.5f * sum) blow.normal = first ? contact.normal : -contact.normal;
            at->remaining_approach +=
                (remaining_approach(world, contact) - at->remaining_approach) * (contact.blow / sum);
            blow.impulse = sum;
            blow.energy += 0.5f * contact.blow * contact.speed;
        }
    }
    return blows;
}

// Damages the bonds. A blow above what the piece itself bears is reported once, with the energy that the bonds left of
// it.
void Structure::apply_blow(const World& world, const BondBlows::JudgedBlow& judged) {
    const Impact& blow = judged.blow;
    const PieceState& piece = pieces_[blow.piece];
    if (!exists(world, piece.body)) return;
    const double speed = 2.0 * static_cast<double>(blow.energy / blow.impulse),
                 sharpness = static_cast<double>(blow.sharpness);
    const glm::dquat to_fragments = glm::conjugate(glm::dquat(world.pose(body_of(blow.piece)).orientation));
    const double new_impulse = static_cast<double>(judged.new_impulse), available = 0.5 * new_impulse * speed;
    const double spent = graph_.blow(blow.piece, to_fragments * glm::dvec3(blow.normal) * new_impulse * sharpness,
                                     available, piece.mass * speed * sharpness);
    const double before = static_cast<double>(judged.judged_impulse);
    const bool reported = before > 0.0 && before * std::cbrt(speed / before) > piece.impact_threshold;
    if (reported || !(spent < available) || !(static_cast<double>(blow.impulse) * sharpness > piece.impact_threshold))
        return;
    changes_.impacts.push_back(blow);
    changes_.impacts.back().energy *= static_cast<float>(1.0 - spent / available);
}

const Structure::Changes& Structure::update(World& world) {
    changes_ = {};
    new_step_ = world.steps_taken() != steps_seen_;
    steps_seen_ = world.steps_taken();
    if (new_step_)
        for (const BondBlows::JudgedBlow& judged : blows_.update(find_blows(world))) apply_blow(world, judged);
    if (new_step_ && desc_.wear.enabled) wear_bonds(world);
    changes_.broken = graph_.take_broken();
    for (const uint32_t bond : changes_.broken)
        for (const uint32_t piece : {graph_.bonds()[bond].a, graph_.bonds()[bond].b})
            if (pieces_[piece].body != none) dirty_[pieces_[piece].body] = 1;
    if (desc_.wear.enabled) wear_.remove_bonds(changes_.broken);
    split(world);
    return changes_;
}

// Free bodies get contact loads only: gravity accelerates all their pieces alike and causes no stress.
void Structure::wear_bonds(const World& world) {
    weights_.assign(pieces_.size(), {});
    contact_loads_.assign(pieces_.size(), {});
    const double seconds = world.settings().step;
    for (const BodyState& body : bodies_) {
        if (!body.fixed || !world.contains(body.id)) continue;
        const glm::dquat to_fragments = glm::conjugate(glm::dquat(world.pose(body.id).orientation));
        const glm::dvec3 gravity = to_fragments * glm::dvec3(world.settings().gravity);
        for (const uint32_t piece : body.pieces) weights_[piece].force = pieces_[piece].mass * gravity;
    }
    for (const Contact& contact : world.contacts()) {
        if (contact.speed > desc_.impact_speed) continue;
        for (const bool first : {true, false}) {
            const uint32_t piece = first ? piece_at(contact.a, contact.part_a) : piece_at(contact.b, contact.part_b);
            if (piece == none || !exists(world, pieces_[piece].body)) continue;
            const BodyState& body = bodies_[pieces_[piece].body];
            const Pose pose = world.pose(body.id);
            const glm::dquat to_fragments = glm::conjugate(glm::dquat(pose.orientation));
            const float load = blows_.load_part(piece, first ? contact.b : contact.a, contact.impulse);
            if (!(load > 0.0f)) continue;
            const glm::dvec3 impulse = static_cast<double>(load / contact.impulse)
                                       * glm::dvec3(contact.impulse * contact.normal + contact.friction);
            const glm::dvec3 force = to_fragments * (impulse * ((first ? 1.0 : -1.0) / seconds));
            const glm::dvec3 point =
                to_fragments * (glm::dvec3(contact.point) - glm::dvec3(pose.position)) + body.centre;
            contact_loads_[piece].force += force;
            contact_loads_[piece].torque += glm::cross(point - pieces_[piece].centre, force);
        }
    }
    wear_.step(graph_, weights_, contact_loads_, seconds);
}

void Structure::split(World& world) {
    std::vector<std::pair<uint32_t, std::vector<std::vector<uint32_t>>>> breaks;
    std::vector<uint8_t> breaking(bodies_.size(), 0);
    for (uint32_t i = 0; i < bodies_.size(); ++i) {
        if (!std::exchange(dirty_[i], uint8_t{0}) || !exists(world, i)) continue;
        auto islands = graph_.islands(bodies_[i].pieces);
        const bool lost_anchors = bodies_[i].fixed && std::ranges::none_of(bodies_[i].pieces, [&](uint32_t piece) {
                                      return pieces_[piece].anchored;
                                  });
        if (islands.size() < 2 && !lost_anchors) continue;
        breaking[i] = 1;
        breaks.emplace_back(i, std::move(islands));
    }
    if (breaks.empty()) return;

    std::vector<RewoundContact> rewound;
    std::map<BodyId, float> seconds_left; // s that each body has yet to move
    for (const size_t index : contacts_to_rewind(world, breaking)) {
        const Contact& contact = world.contacts()[index];
        rewound.push_back({index, contact, piece_at(contact.a, contact.part_a), piece_at(contact.b, contact.part_b)});
        for (const BodyId body : {contact.a, contact.b})
            if (world.contains(body)) seconds_left.emplace(body, 0.0f);
    }
    for (auto& [body, seconds] : seconds_left) seconds = world.rewind(body);
    for (const auto& [index, islands] : breaks) {
        const Motion motion = motion_of(world, bodies_[index]);
        const BodyId old = bodies_[index].id;
        world.remove_body(old);
        changes_.removed.push_back(old);
        body_of_id_.erase(old.value);
        bodies_[index].id = {};
        for (const uint32_t piece : std::exchange(bodies_[index].pieces, {})) pieces_[piece].body = none;
        const std::vector<uint8_t> debris = debris_of_islands(world, islands);
        const size_t first = bodies_.size();
        [[maybe_unused]] const Result<void> added = add_islands(world, islands, motion, debris);
        assert(added && "an island of a valid body is a valid body");
        if (const auto parent = seconds_left.find(old); parent != seconds_left.end())
            for (const BodyState& body : std::span(bodies_).subspan(first))
                seconds_left.emplace(body.id, parent->second);
    }
    solve_rewound(world, rewound);
    for (const auto& [body, seconds] : seconds_left)
        if (world.contains(body)) world.move_on(body, seconds);
}

// Projected Gauss-Seidel, inelastic and without friction: the cracks took the energy of a bounce. Each impulse reduces
// the kinetic energy that the bodies had before the contacts, so energy cannot rise.
void Structure::solve_rewound(World& world, std::span<const RewoundContact> rewound) const {
    // The bonds were tested with the impulse `blow`, so a contact between pieces or movable bodies transmits no more
    // now. The rest arrives as a blow in the next step and may break more bonds.
    const auto max_impulse = [&](const RewoundContact& contact) {
        const auto is_limited = [&](uint32_t piece, BodyId body) { return piece != none || is_movable(world, body); };
        return is_limited(contact.piece_a, contact.original.a) && is_limited(contact.piece_b, contact.original.b)
                   ? contact.original.blow
                   : std::numeric_limits<float>::infinity();
    };
    std::vector<float> impulses(rewound.size(), 0.0f), responses;
    std::vector<std::array<BodyId, 2>> sides; // bodies a and b after the break
    for (const RewoundContact& contact : rewound) {
        const glm::vec3 &point = contact.original.point, &normal = contact.original.normal;
        const auto& [a, b] =
            sides.emplace_back(std::array{contact.piece_a != none ? body_of(contact.piece_a) : contact.original.a,
                                          contact.piece_b != none ? body_of(contact.piece_b) : contact.original.b});
        responses.push_back(response_at(world, a, point, normal) + response_at(world, b, point, normal));
    }
    for (int sweep = 0; sweep < rewound_sweeps; ++sweep)
        for (size_t i = 0; i < rewound.size(); ++i) {
            if (!(responses[i] > 0.0f)) continue;
            const RewoundContact& contact = rewound[i];
            const auto& [a, b] = sides[i];
            const glm::vec3 &point = contact.original.point, &normal = contact.original.normal;
            // The speed that closes the gap within the step.
            const float closing = std::max(contact.original.gap, 0.0f) / world.settings().step;
            const float approach =
                velocity_along(world, b, point, normal) - velocity_along(world, a, point, normal) - closing;
            const float before = std::exchange(
                impulses[i], std::clamp(impulses[i] + approach / responses[i], 0.0f, max_impulse(contact)));
            const glm::vec3 impulse = (impulses[i] - before) * normal;
            apply_impulse(world, a, impulse, point);
            apply_impulse(world, b, -impulse, point);
        }
    for (size_t i = 0; i < rewound.size(); ++i) {
        Contact contact = rewound[i].original;
        contact.impulse = impulses[i];
        contact.friction = glm::vec3(0.0f);
        locate(rewound[i].piece_a, contact.a, contact.part_a);
        locate(rewound[i].piece_b, contact.b, contact.part_b);
        world.amend_contact(rewound[i].index, contact);
    }
}

// Sets the body and hull index to those of a piece of this structure.
void Structure::locate(uint32_t piece, BodyId& body, uint32_t& part) const {
    if (piece == none) return;
    const std::vector<uint32_t>& pieces = bodies_[pieces_[piece].body].pieces;
    body = body_of(piece);
    part = static_cast<uint32_t>(std::ranges::find(pieces, piece) - pieces.begin());
}

// Returns all contacts in the groups of touching bodies in which a blow breaks a body. The whole group is rewound: an
// impulse that is taken back while its reaction stays would throw a body into the air. A group with more than
// max_rewound_contacts, or with a contact of a body that was removed, is left as it is.
std::vector<size_t> Structure::contacts_to_rewind(const World& world, const std::vector<uint8_t>& breaking) const {
    std::vector<size_t> contacts;
    if (!new_step_) return contacts;
    const auto breaks = [&](BodyId id) {
        const uint32_t body = index_of(id);
        return body != none && breaking[body];
    };
    const auto hits = [&](const Contact& contact) {
        return contact.speed > desc_.impact_speed && (breaks(contact.a) || breaks(contact.b));
    };
    // Blows are among the solved contacts, which spares building the list of all contacts of sleeping bodies.
    if (std::ranges::none_of(world.solved_contacts(), hits)) return contacts;
    const std::span<const Contact> all = world.contacts();
    const std::span<const BodyId> bodies = world.bodies();
    const auto place_of = [&](BodyId id) {
        const auto at = std::ranges::lower_bound(bodies, id);
        return at != bodies.end() && *at == id ? static_cast<uint32_t>(at - bodies.begin()) : none;
    };
    std::vector<uint8_t> conducts;
    for (const BodyId id : bodies) conducts.push_back(is_movable(world, id) || breaks(id));
    std::vector<uint32_t> groups(bodies.size()); // union-find: bodies connected by contacts
    std::iota(groups.begin(), groups.end(), 0u);
    const auto group_of = [&](uint32_t body) {
        while (groups[body] != body) body = groups[body] = groups[groups[body]];
        return body;
    };
    std::vector<uint32_t> touching; // by contact: a body of its group, or none
    for (const Contact& contact : all) {
        const uint32_t a = place_of(contact.a), b = place_of(contact.b);
        const bool from_a = a != none && conducts[a], from_b = b != none && conducts[b];
        if (from_a && from_b) groups[group_of(a)] = group_of(b);
        touching.push_back(from_a ? a : from_b ? b : none);
    }
    struct Group {
        bool blown = false, has_removed = false;
        size_t contacts = 0;
    };
    std::vector<Group> group_states(bodies.size());
    for (size_t i = 0; i < all.size(); ++i) {
        if (touching[i] == none) continue;
        Group& group = group_states[group_of(touching[i])];
        ++group.contacts;
        group.blown = group.blown || hits(all[i]);
        for (const BodyId body : {all[i].a, all[i].b})
            group.has_removed = group.has_removed || (body != BodyId{} && place_of(body) == none);
    }
    for (size_t i = 0; i < all.size(); ++i) {
        if (touching[i] == none) continue;
        const Group& group = group_states[group_of(touching[i])];
        if (group.blown && !group.has_removed && group.contacts <= max_rewound_contacts) contacts.push_back(i);
    }
    return contacts;
}

} // namespace brittle::physics

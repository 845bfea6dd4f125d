// Structure::update(): blows, wear, and the splitting of bodies.
#include "physics/bonds/structure.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <span>
#include <utility>

#include <glm/geometric.hpp>

#include "fracture/mesh/nearest.h"
#include "physics/bonds/rewound_contacts.h"
#include "physics/world/body_motion.h"

namespace brittle::physics {

namespace {

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
    split(world);
    if (desc_.wear.enabled) wear_.remove_bonds(changes_.broken);
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
    std::vector<Break> breaks;
    std::vector<uint8_t> breaking(bodies_.size(), 0);
    for (uint32_t i = 0; i < bodies_.size(); ++i) {
        if (!std::exchange(dirty_[i], uint8_t{0}) || !exists(world, i)) continue;
        auto islands = graph_.islands(bodies_[i].pieces);
        const bool lost_anchors = bodies_[i].fixed && std::ranges::none_of(bodies_[i].pieces, [&](uint32_t piece) {
                                      return pieces_[piece].anchored;
                                  });
        if (islands.size() < 2 && !lost_anchors) continue;
        breaking[i] = 1;
        breaks.push_back({i, std::move(islands)});
    }
    if (breaks.empty()) return;

    std::vector<SolvedContact> solved;
    std::map<BodyId, float> seconds_left; // s that each body has yet to move
    for (const size_t index : contacts_to_rewind(world, breaking)) {
        const Contact& contact = world.contacts()[index];
        solved.push_back({index, contact, piece_at(contact.a, contact.part_a), piece_at(contact.b, contact.part_b)});
        for (const BodyId body : {contact.a, contact.b})
            if (world.contains(body)) seconds_left.emplace(body, 0.0f);
    }
    for (auto& [body, seconds] : seconds_left) {
        seconds = world.rewind(body);
        // What stopped the body was the whole of a body that has broken since.
        const uint32_t stopper = index_of(world.stopped_by(body));
        if (stopper != none && breaking[stopper]) seconds = world.settings().step;
    }
    const std::vector<Push> pushes = break_ways(world, solved, breaking, seconds_left);
    for (Break& broken : breaks) {
        if (!pushes.empty()) broken.islands = graph_.islands(bodies_[broken.body].pieces);
        const BodyId old = bodies_[broken.body].id;
        const size_t first = bodies_.size();
        replace(world, broken);
        if (const auto parent = seconds_left.find(old); parent != seconds_left.end())
            for (const BodyState& body : std::span(bodies_).subspan(first))
                seconds_left.emplace(body.id, parent->second);
    }
    for (const Push& push : pushes) apply_impulse(world, body_of(push.piece), push.impulse, push.point);
    solve_again(world, solved);
    for (const auto& [body, seconds] : seconds_left)
        if (world.contains(body)) world.move_on(body, seconds);
}

// Takes the joints of a body, each with the piece that is nearest to its anchor.
std::vector<Structure::HeldJoint> Structure::take_joints(World& world, uint32_t body) const {
    std::vector<HeldJoint> held;
    const Pose pose = world.pose(bodies_[body].id);
    for (const LooseJoint& joint : world.take_joints(bodies_[body].id)) {
        const glm::dvec3 anchor =
            bodies_[body].centre + to_body_axes(pose, joint.anchor - pose.position); // in the fragments
        HeldJoint& made = held.emplace_back(HeldJoint{joint});
        double nearest = std::numeric_limits<double>::infinity();
        for (const uint32_t piece : bodies_[body].pieces) {
            for (const BodyPart& part : pieces_[piece].parts) {
                const glm::dvec3 local = anchor - pieces_[piece].centre - glm::dvec3(part.offset);
                const double distance = fracture::distance_to_hull(part.hull->points, local);
                if (!(distance < nearest)) continue;
                nearest = distance;
                made.piece = piece;
            }
        }
    }
    return held;
}

// Replaces a body by its islands.
void Structure::replace(World& world, const Break& broken) {
    BodyState& body = bodies_[broken.body];
    const Motion motion = motion_of(world, body);
    const std::vector<HeldJoint> joints = take_joints(world, broken.body);
    world.remove_body(body.id);
    changes_.removed.push_back(body.id);
    body_of_id_.erase(std::exchange(body.id, {}).value);
    for (const uint32_t piece : std::exchange(body.pieces, {})) pieces_[piece].body = none;
    const std::vector<std::vector<uint32_t>> islands = with_bodies(broken.islands);
    const std::vector<uint8_t> debris = debris_of_islands(world, islands);
    [[maybe_unused]] const Result<void> added = add_islands(world, islands, motion, debris);
    assert(added && "an island of a valid body is a valid body");
    for (const HeldJoint& held : joints) world.put_joint(held.joint, body_of(held.piece));
}

// The contacts of a step hold only the pieces that a striker has reached. What it meets in the rest of the step is
// struck here; the world would find it inside the striker in the next step, without a way out along the motion.
std::vector<Structure::Push> Structure::break_ways(World& world, std::span<const SolvedContact> solved,
                                                   std::span<const uint8_t> breaking,
                                                   const std::map<BodyId, float>& seconds_left) {
    std::set<std::pair<BodyId, uint32_t>> strikes; // striker and body
    std::set<std::pair<BodyId, uint32_t>> touched; // striker and piece
    for (const SolvedContact& contact : solved)
        for (const bool first : {true, false}) {
            const uint32_t piece = first ? contact.piece_a : contact.piece_b;
            const BodyId striker = first ? contact.original.b : contact.original.a;
            if (piece == none || !breaking[pieces_[piece].body] || !is_movable(world, striker)) continue;
            touched.emplace(striker, piece);
            if (contact.original.speed > desc_.impact_speed) strikes.emplace(striker, pieces_[piece].body);
        }
    std::vector<Push> pushes;
    for (const auto& [striker, body] : strikes)
        for (const CastHit& hit : world.cast(striker, bodies_[body].id, seconds_left.at(striker)))
            if (const uint32_t piece = pieces_by_part(bodies_[body])[hit.part]; !touched.contains({striker, piece}))
                if (const Push push = strike(world, striker, piece, hit); push.piece != none) pushes.push_back(push);
    const std::vector<uint32_t> broken = graph_.take_broken();
    changes_.broken.insert(changes_.broken.end(), broken.begin(), broken.end());
    return pushes;
}

// A perfectly inelastic impact along the striker's motion: between its neighbours a piece cannot move aside.
// If the bonds bear the impulse that stops the striker at the whole body, or its energy does not pay for them, they
// hold. Otherwise the body gets the impulse that they bear, and the rest is between the striker and the free piece.
Structure::Push Structure::strike(World& world, BodyId striker, uint32_t piece, const CastHit& hit) {
    const PieceState& state = pieces_[piece];
    const BodyState& body = bodies_[state.body];
    const auto approach = [&] {
        return static_cast<double>(velocity_along(world, striker, hit.point, hit.direction)
                                   - velocity_along(world, body.id, hit.point, hit.direction));
    };
    const double speed = approach();
    if (!(speed > 0.0)) return {};
    const double of_striker = static_cast<double>(response_at(world, striker, hit.point, hit.direction)),
                 of_body = static_cast<double>(response_at(world, body.id, hit.point, hit.direction));
    const glm::dmat3 axes(glm::mat3_cast(glm::dquat(world.pose(body.id).orientation)));
    const glm::dvec3 direction = glm::dvec3(hit.direction) * axes; // in the fragments
    const double stopping = speed / (of_striker + of_body);
    const double bearing = graph_.bearing(piece, direction) * std::cbrt(stopping / speed);
    const bool holds =
        state.anchored || !(stopping > bearing) || 0.5 * stopping * speed < graph_.breaking_energy(piece);
    const auto take = [&](double impulse) { // from the striker
        const glm::vec3 taken = static_cast<float>(impulse) * hit.direction;
        apply_impulse(world, striker, -taken, hit.point);
        return taken;
    };
    const glm::vec3 on_body = take(holds ? stopping : bearing);
    apply_impulse(world, body.id, on_body, hit.point);
    if (body.fixed) changes_.held.push_back({on_body, hit.point});
    if (holds) return {};
    isolate(piece);
    const glm::dvec3 centre = glm::dvec3(world.pose(body.id).position) + axes * (state.centre - body.centre);
    const glm::dvec3 turn = glm::cross((glm::dvec3(hit.point) - centre) * axes, direction);
    const double of_piece = 1.0 / state.mass + glm::dot(turn, glm::inverse(state.inertia) * turn);
    return {piece, take(std::max(approach(), 0.0) / (of_striker + of_piece)), hit.point};
}

// The bonds of a piece were tested with the impulse `blow`, so a contact of a piece that is still bonded transmits no
// more now. The rest arrives as a blow in the next step and may break more bonds.
void Structure::solve_again(World& world, std::span<const SolvedContact> solved) const {
    const auto max_impulse = [&](const Contact& contact, uint32_t piece) {
        const bool bonded = piece != none && (anchored(piece) || pieces_of_body(piece).size() > 1);
        return bonded ? contact.blow : std::numeric_limits<float>::infinity();
    };
    std::vector<RewoundContact> contacts;
    for (const auto& [index, original, piece_a, piece_b] : solved)
        contacts.push_back({.a = piece_a != none ? body_of(piece_a) : original.a,
                            .b = piece_b != none ? body_of(piece_b) : original.b,
                            .point = original.point,
                            .normal = original.normal,
                            .closing = std::max(original.gap, 0.0f) / world.settings().step,
                            .max_impulse = std::min(max_impulse(original, piece_a), max_impulse(original, piece_b))});
    solve_rewound(world, contacts);
    for (size_t i = 0; i < solved.size(); ++i) {
        Contact contact = solved[i].original;
        contact.impulse = contacts[i].impulse;
        contact.friction = glm::vec3(0.0f);
        locate(solved[i].piece_a, contact.a, contact.part_a);
        locate(solved[i].piece_b, contact.b, contact.part_b);
        world.amend_contact(solved[i].index, contact);
    }
}

// Sets the body and hull index to those of a piece of this structure.
void Structure::locate(uint32_t piece, BodyId& body, uint32_t& part) const {
    if (piece == none) return;
    const std::vector<uint32_t>& pieces = pieces_by_part(bodies_[pieces_[piece].body]);
    body = body_of(piece);
    part = static_cast<uint32_t>(std::ranges::find(pieces, piece) - pieces.begin());
}

// Returns all contacts in the groups of touching bodies in which a blow breaks a body. The whole group is rewound: an
// impulse that is taken back while its reaction stays would throw a body into the air. A group with a contact of a body
// that was removed is left as it is.
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
    };
    std::vector<Group> group_states(bodies.size());
    for (size_t i = 0; i < all.size(); ++i) {
        if (touching[i] == none) continue;
        Group& group = group_states[group_of(touching[i])];
        group.blown = group.blown || hits(all[i]);
        for (const BodyId body : {all[i].a, all[i].b})
            group.has_removed = group.has_removed || (body != BodyId{} && place_of(body) == none);
    }
    for (size_t i = 0; i < all.size(); ++i) {
        if (touching[i] == none) continue;
        const Group& group = group_states[group_of(touching[i])];
        if (group.blown && !group.has_removed) contacts.push_back(i);
    }
    return contacts;
}

} // namespace brittle::physics

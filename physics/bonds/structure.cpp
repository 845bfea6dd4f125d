#include "physics/bonds/structure.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include <glm/geometric.hpp>

#include "fracture/base/threads.h"
#include "physics/bonds/bond_shares.h"
#include "physics/world/body_motion.h"
#include "physics/world/crowd.h"
#include "physics/world/state_hash.h"

namespace brittle::physics {

namespace {

using fracture::Error;
using fracture::Fragments;
using fracture::Piece;
using fracture::Status;

// Pieces per chunk below which waking another thread costs more than it saves.
constexpr uint32_t min_forms = 64;

} // namespace

Result<void> Structure::check(const Fragments& fragments, const StructureDesc& desc) {
    if (const Result<void> checked = check_pieces(fragments, desc.material); !checked) return checked.error();
    for (const uint32_t piece : desc.anchored)
        if (piece >= fragments.pieces.size())
            return Error{Status::invalid_setting, "anchored piece " + std::to_string(piece)
                                                      + " does not exist: there are "
                                                      + std::to_string(fragments.pieces.size()) + " pieces"};
    if (!desc.hulls.empty() && desc.hulls.size() != fragments.pieces.size())
        return Error{Status::invalid_setting, std::to_string(desc.hulls.size()) + " hulls were given for "
                                                  + std::to_string(fragments.pieces.size()) + " pieces"};
    return check_assembly(fragments, desc);
}

Result<Structure> Structure::create(World& world, const Fragments& fragments, const StructureDesc& desc) {
    if (const Result<void> checked = check(fragments, desc); !checked) return checked.error();
    const PieceHulls hulls = !desc.piece_parts.empty() ? PieceHulls(fragments.pieces.size())
                             : desc.hulls.empty()      ? collision_hulls(fragments, desc.hull)
                                                       : desc.hulls;
    Structure structure;
    structure.desc_ = desc;
    structure.desc_.anchored.clear();
    structure.desc_.hulls.clear();
    structure.desc_.piece_materials.clear();
    structure.desc_.bond_strength.clear();
    structure.desc_.piece_parts.clear();
    structure.desc_.supports.clear();
    structure.desc_.piece_objects.clear();
    structure.steps_seen_ = world.steps_taken();
    structure.graph_ = BondGraph(fragments, bond_materials(fragments, desc));
    std::vector<uint32_t> all;
    for (const Piece& piece : fragments.pieces) {
        const Material& material =
            desc.piece_materials.empty() ? desc.material : desc.piece_materials[structure.pieces_.size()];
        const auto index = static_cast<uint32_t>(all.size());
        structure.pieces_.push_back(
            state_of(piece.mass.centre_of_mass, piece_mass(fragments, piece, material.density), material,
                     desc.piece_parts.empty() ? std::vector<BodyPart>{{hulls[index]}} : desc.piece_parts[index]));
        all.push_back(index);
    }
    for (const uint32_t piece : desc.anchored) structure.pieces_[piece].anchored = true;
    for (const uint32_t piece : desc.supports) {
        PieceState& state = structure.pieces_[piece];
        state.anchored = true;
        state.mass = 0.0;
        state.inertia = glm::dmat3(0.0);
        state.parts.clear();
    }
    structure.make_forms(world.settings().threads);
    const Motion motion{desc.motion.placement, desc.motion.placement, desc.motion.linear_velocity,
                        desc.motion.angular_velocity, glm::dvec3(0.0)};
    const std::vector<std::vector<uint32_t>> islands = structure.with_bodies(structure.graph_.islands(all));
    const Result<void> added = structure.add_islands(world, islands, motion, std::vector<uint8_t>(islands.size(), 0));
    if (!added) return added.error();
    structure.changes_ = {};
    const auto object_of = [&](uint32_t piece) { return desc.piece_objects.empty() ? 0 : desc.piece_objects[piece]; };
    for (const BodyState& body : structure.bodies_) {
        std::map<uint32_t, double> counts;
        for (const uint32_t piece : body.pieces) counts[object_of(piece)] += structure.pieces_[piece].count;
        for (const uint32_t piece : body.pieces) structure.pieces_[piece].initial_pieces = counts[object_of(piece)];
    }
    if (!desc.wear.enabled) return structure;
    std::vector<StressNode> nodes;
    for (const PieceState& piece : structure.pieces_) nodes.push_back(stress_node(piece));
    structure.wear_ = Wear(nodes, structure.graph_, desc.wear);
    return structure;
}

Result<void> Structure::check_assembly(const Fragments& fragments, const StructureDesc& desc) {
    const auto wrong = [](const std::string& message) { return Error{Status::invalid_setting, message}; };
    const size_t pieces = fragments.pieces.size(), bonds = fragments.bonds.size();
    const auto counts = [&](const char* what, size_t given, size_t there) {
        return std::to_string(given) + " " + what + " were given for " + std::to_string(there);
    };
    if (!desc.piece_materials.empty() && desc.piece_materials.size() != pieces)
        return wrong(counts("materials", desc.piece_materials.size(), pieces) + " pieces");
    if (!desc.bond_strength.empty() && desc.bond_strength.size() != bonds)
        return wrong(counts("strengths", desc.bond_strength.size(), bonds) + " bonds");
    if (!desc.piece_parts.empty() && desc.piece_parts.size() != pieces)
        return wrong(counts("lists of hulls", desc.piece_parts.size(), pieces) + " pieces");
    if (!desc.piece_parts.empty() && !desc.hulls.empty())
        return wrong("hulls and lists of hulls were given; leave one of them out");
    if (!desc.piece_objects.empty() && desc.piece_objects.size() != pieces)
        return wrong(counts("objects", desc.piece_objects.size(), pieces) + " pieces");
    std::vector<uint8_t> supports(pieces, 0);
    for (const uint32_t piece : desc.supports) {
        if (piece >= pieces)
            return wrong("support " + std::to_string(piece) + " does not exist: there are " + std::to_string(pieces)
                         + " pieces");
        supports[piece] = 1;
    }
    for (size_t k = 0; k < desc.piece_materials.size(); ++k)
        if (const Result<void> checked = check_pieces({}, desc.piece_materials[k]); !checked)
            return Error{checked.error().status, "piece " + std::to_string(k) + ": " + checked.error().message};
    for (size_t k = 0; k < desc.bond_strength.size(); ++k)
        if (!(desc.bond_strength[k] >= 0.0f) || !std::isfinite(desc.bond_strength[k]))
            return wrong("the strength of bond " + std::to_string(k) + " must be 0 Pa or more");
    for (size_t k = 0; k < desc.piece_parts.size(); ++k) {
        if (desc.piece_parts[k].empty() && !supports[k]) return wrong("piece " + std::to_string(k) + " has no hulls");
        for (const BodyPart& part : desc.piece_parts[k])
            if (!part.hull) return wrong("a hull of piece " + std::to_string(k) + " is missing");
    }
    return {};
}

// One for all bonds where they are alike. The weaker material is the one of the lower tensile strength, of equal ones
// that of the lower piece.
std::vector<Material> Structure::bond_materials(const Fragments& fragments, const StructureDesc& desc) {
    if (desc.piece_materials.empty() && desc.bond_strength.empty()) return {desc.material};
    std::vector<Material> materials;
    for (const fracture::Bond& bond : fragments.bonds) {
        Material material = desc.material;
        if (std::max(bond.a, bond.b) < desc.piece_materials.size()) {
            const Material &a = desc.piece_materials[bond.a], &b = desc.piece_materials[bond.b];
            material = b.tensile < a.tensile ? b : a;
        }
        const float strength = desc.bond_strength.empty() ? 0.0f : desc.bond_strength[materials.size()];
        materials.push_back(strength > 0.0f ? scale_strength(material, strength / material.tensile) : material);
    }
    if (materials.empty()) materials.push_back(desc.material);
    return materials;
}

std::vector<std::vector<uint32_t>> Structure::with_bodies(std::vector<std::vector<uint32_t>> islands) const {
    std::erase_if(islands, [&](const std::vector<uint32_t>& island) {
        return std::ranges::all_of(island, [&](uint32_t piece) { return pieces_[piece].parts.empty(); });
    });
    return islands;
}

std::vector<uint8_t> Structure::debris_of_islands(const World& world,
                                                  std::span<const std::vector<uint32_t>> islands) const {
    std::vector<BatchBody> batch;
    for (const std::vector<uint32_t>& island : islands) {
        BatchBody& one = batch.emplace_back();
        one.bonded = island.size() > 1;
        for (const uint32_t piece : island) {
            one.size += pieces_[piece].mass;
            one.fixed = one.fixed || pieces_[piece].anchored;
        }
    }
    return choose_debris(batch, colliding_room(world));
}

// Islands are siblings: they are added together and do not overlap.
Result<void> Structure::add_islands(World& world, std::span<const std::vector<uint32_t>> islands, const Motion& motion,
                                    std::span<const uint8_t> debris) {
    std::vector<BodyState> bodies(islands.size());
    const uint32_t siblings = world.new_siblings();
    const Result<std::vector<BodyId>> added = world.add_bodies(islands.size(), [&](size_t i) {
        BodyDesc desc = describe(islands[i], motion, bodies[i]);
        desc.debris = debris[i] != 0;
        desc.siblings = siblings;
        return desc;
    });
    if (!added) return added.error();
    for (size_t i = 0; i < bodies.size(); ++i) {
        bodies[i].id = (*added)[i];
        const auto index = static_cast<uint32_t>(bodies_.size());
        for (const uint32_t piece : bodies[i].pieces) pieces_[piece].body = index;
        body_of_id_[bodies[i].id.value] = index;
        bodies_.push_back(std::move(bodies[i]));
        dirty_.push_back(0);
        changes_.added.push_back((*added)[i]);
    }
    return {};
}

Structure::PieceState Structure::state_of(const glm::dvec3& centre, const BodyMass& mass, const Material& material,
                                          std::vector<BodyPart> hulls) {
    return {.centre = centre,
            .mass = mass.mass,
            .inertia = mass.inertia,
            .impact_threshold = breaking_force(material, std::pow(mass.mass / material.density, 2.0 / 3.0))
                                * static_cast<double>(impact_seconds),
            .parts = std::move(hulls),
            .friction = material.friction,
            .restitution = material.restitution};
}

StressNode Structure::stress_node(const PieceState& piece) {
    return {piece.centre, piece.mass, piece.inertia, piece.anchored};
}

// Precomputes the body forms of single pieces for when they come off. Most of the cost is the cross section.
void Structure::make_forms(uint32_t threads) {
    const auto count = static_cast<uint32_t>(pieces_.size());
    fracture::Threads(threads).for_chunks(count, min_forms, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (PieceState& piece : std::span(pieces_).subspan(begin, end - begin)) {
            if (piece.parts.empty()) continue;
            BodyDesc alone;
            alone.parts = piece.parts;
            alone.mass = static_cast<float>(piece.mass);
            alone.inertia = glm::mat3(piece.inertia);
            if (const Result<std::shared_ptr<const BodyForm>> form = make_form(alone)) piece.form = *form;
        }
    });
}

BodyDesc Structure::describe(const std::vector<uint32_t>& island, const Motion& motion, BodyState& body) const {
    body = {};
    body.pieces = island;
    double mass = 0.0, heaviest = -1.0;
    bool one_hull_each = true;
    BodyDesc desc;
    for (const uint32_t piece : island) {
        const PieceState& part = pieces_[piece];
        one_hull_each = one_hull_each && part.parts.size() == 1;
        if (part.mass > heaviest) {
            heaviest = part.mass;
            desc.friction = part.friction;
            desc.restitution = part.restitution;
        }
        mass += pieces_[piece].mass;
        body.centre += pieces_[piece].mass * pieces_[piece].centre;
        body.count += part.count;
        body.fixed = body.fixed || pieces_[piece].anchored;
    }
    body.centre = island.size() == 1 ? pieces_[island[0]].centre : body.centre / mass;
    if (!one_hull_each)
        for (const uint32_t piece : island)
            body.piece_of_part.insert(body.piece_of_part.end(), pieces_[piece].parts.size(), piece);
    if (island.size() == 1 && !body.fixed) desc.form = pieces_[island[0]].form;
    if (!desc.form) {
        glm::dmat3 inertia(0.0);
        for (const uint32_t piece : island) {
            const PieceState& part = pieces_[piece];
            const glm::dvec3 arm = part.centre - body.centre;
            inertia += part.inertia + part.mass * (glm::dmat3(glm::dot(arm, arm)) - glm::outerProduct(arm, arm));
            for (const BodyPart& hull : part.parts)
                desc.parts.push_back({hull.hull, glm::vec3(arm + glm::dvec3(hull.offset))});
        }
        desc.mass = static_cast<float>(mass);
        desc.inertia = glm::mat3(inertia);
    }
    const glm::dvec3 arm = body.centre - motion.centre;
    desc.fixed = body.fixed;
    desc.pose = offset_pose(motion.pose, arm);
    desc.previous = offset_pose(motion.previous, arm);
    desc.linear_velocity =
        glm::vec3(glm::dvec3(motion.linear) + glm::cross(glm::dvec3(motion.angular), to_world_axes(motion.pose, arm)));
    desc.angular_velocity = motion.angular;
    return desc;
}

bool Structure::exists(const World& world, uint32_t body) const {
    return body != none && world.contains(bodies_[body].id);
}

Structure::Motion Structure::motion_of(const World& world, const BodyState& body) const {
    return {world.pose(body.id), world.previous_pose(body.id), world.linear_velocity(body.id),
            world.angular_velocity(body.id), body.centre};
}

uint32_t Structure::index_of(BodyId body) const {
    const auto at = body_of_id_.find(body.value);
    return at == body_of_id_.end() ? none : at->second;
}

uint32_t Structure::piece_at(BodyId body, uint32_t part) const {
    const uint32_t index = index_of(body);
    if (index == none) return none;
    const std::vector<uint32_t>& pieces = pieces_by_part(bodies_[index]);
    return part < pieces.size() ? pieces[part] : none;
}

void Structure::break_bonds(std::span<const uint32_t> bonds) {
    for (const uint32_t bond : bonds) graph_.weaken(bond, 1.0);
}

void Structure::isolate(uint32_t piece) {
    break_bonds(graph_.bonds_of(piece));
}

// Calls damage(to_fragments, inside) for each body: to_fragments maps world points to the fragments, inside flags the
// body's pieces.
template<class Damage>
void Structure::damage_bodies(const World& world, const Damage& damage) {
    std::vector<uint8_t> inside(pieces_.size(), 0);
    for (uint32_t i = 0; i < bodies_.size(); ++i) {
        const BodyState& body = bodies_[i];
        if (body.pieces.size() < 2 || !exists(world, i)) continue;
        for (const uint32_t piece : body.pieces) inside[piece] = 1;
        const Pose pose = world.pose(body.id);
        damage(
            [&](const glm::vec3& point) {
                const glm::dvec3 arm(glm::dvec3(point) - glm::dvec3(pose.position));
                return glm::conjugate(glm::dquat(pose.orientation)) * arm + body.centre;
            },
            inside);
        for (const uint32_t piece : body.pieces) inside[piece] = 0;
    }
}

void Structure::damage(const World& world, glm::vec3 point, float radius, float amount) {
    damage_bodies(world, [&](const auto& to_fragments, const std::vector<uint8_t>& inside) {
        graph_.damage(to_fragments(point), radius, amount, inside);
    });
}

void Structure::damage_segment(const World& world, glm::vec3 from, glm::vec3 to, float radius, float amount) {
    damage_bodies(world, [&](const auto& to_fragments, const std::vector<uint8_t>& inside) {
        graph_.damage_segment(to_fragments(from), to_fragments(to), radius, amount, inside);
    });
}

void Structure::blow(const World& world, uint32_t piece, glm::vec3 impulse) {
    if (!exists(world, pieces_[piece].body)) return;
    const glm::dquat orientation(world.pose(body_of(piece)).orientation);
    const double size = glm::length(glm::dvec3(impulse));
    graph_.blow(piece, glm::conjugate(orientation) * glm::dvec3(impulse), 0.5 * size * size);
}

void Structure::release_anchors(std::span<const uint32_t> pieces) {
    for (const uint32_t piece : pieces) {
        pieces_[piece].anchored = false;
        if (pieces_[piece].body != none) dirty_[pieces_[piece].body] = 1;
    }
    if (desc_.wear.enabled) wear_.release(pieces);
}

std::optional<PlacedMotion> Structure::take_piece(World& world, uint32_t piece) {
    const uint32_t index = pieces_[piece].body;
    if (!exists(world, index) || bodies_[index].pieces.size() != 1) return std::nullopt;
    const Motion motion = motion_of(world, bodies_[index]);
    PlacedMotion placed;
    placed.placement = offset_pose(motion.pose, -motion.centre);
    placed.linear_velocity =
        motion.linear - glm::vec3(glm::cross(glm::dvec3(motion.angular), to_world_axes(motion.pose, motion.centre)));
    placed.angular_velocity = motion.angular;
    remove_body(world, piece);
    return placed;
}

bool Structure::divide(World& world, uint32_t piece, std::span<const Part> parts) {
    const uint32_t body = pieces_[piece].body;
    const auto is_sound = [](const Part& part) { return is_possible(part.mass); };
    if (!exists(world, body) || !std::ranges::all_of(parts, is_sound)) return false;
    assert(!parts.empty());
    std::vector<PlacedHulls> hulls;
    std::vector<glm::dvec3> centres;
    for (const Part& part : parts) {
        hulls.push_back({part.hulls, part.centre});
        centres.push_back(part.centre);
    }
    const auto hulls_of = [&](uint32_t index) { return PlacedHulls{pieces_[index].parts, pieces_[index].centre}; };
    graph_.divide(piece, centres, share_bonds(graph_, piece, hulls_of, hulls));
    std::vector<StressNode> nodes;
    std::vector<uint32_t>& together = bodies_[body].pieces;
    std::erase(together, piece);
    for (const Part& part : parts) {
        together.push_back(static_cast<uint32_t>(pieces_.size()));
        PieceState& state = pieces_.emplace_back(state_of(part.centre, part.mass, part.material, part.hulls));
        state.form = part.form;
        state.body = body;
        state.initial_pieces = pieces_[piece].initial_pieces;
        state.count = pieces_[piece].count * part.mass.mass / pieces_[piece].mass;
        state.anchored = part.anchored && pieces_[piece].anchored;
        nodes.push_back(stress_node(state));
    }
    pieces_[piece].body = none;
    if (desc_.wear.enabled) wear_.divide(piece, nodes, graph_);
    replace(world, {body, graph_.islands(together)});
    return true;
}

void Structure::remove_body(World& world, uint32_t piece) {
    if (pieces_[piece].body == none) return;
    BodyState& body = bodies_[pieces_[piece].body];
    world.remove_body(body.id);
    body_of_id_.erase(std::exchange(body.id, {}).value);
    for (const uint32_t part : std::exchange(body.pieces, {})) {
        isolate(part);
        pieces_[part].body = none;
    }
}

void Structure::remove_pieces(World& world, std::span<const uint32_t> pieces) {
    std::vector<uint8_t> goes(pieces_.size(), 0);
    for (const uint32_t piece : pieces) {
        goes[piece] = 1;
        isolate(piece);
    }
    for (const uint32_t piece : pieces) {
        const uint32_t body = pieces_[piece].body;
        if (body == none) continue; // gone with an earlier one
        const std::vector<uint32_t> together = bodies_[body].pieces;
        if (exists(world, body) && !std::ranges::all_of(together, [&](uint32_t other) { return goes[other] != 0; }))
            replace(world, {body, graph_.islands(together)});
        else
            remove_body(world, piece);
    }
    for (const uint32_t piece : pieces) remove_body(world, piece);
}

void Structure::remove(World& world) {
    for (BodyState& body : bodies_) {
        world.remove_body(std::exchange(body.id, {}));
        body.pieces.clear();
    }
    body_of_id_.clear();
    for (PieceState& piece : pieces_) piece.body = none;
}

BodyId Structure::body_of(uint32_t piece) const {
    return pieces_[piece].body == none ? BodyId{} : bodies_[pieces_[piece].body].id;
}

std::span<const uint32_t> Structure::pieces_of_body(uint32_t piece) const {
    if (pieces_[piece].body == none) return {};
    return bodies_[pieces_[piece].body].pieces;
}

bool Structure::is_detached(uint32_t piece) const {
    if (pieces_[piece].body == none) return false;
    const BodyState& body = bodies_[pieces_[piece].body];
    return !body.fixed && 2.0 * body.count <= pieces_[piece].initial_pieces;
}

glm::vec3 Structure::offset(uint32_t piece) const {
    return in_body(piece, pieces_[piece].centre);
}

glm::vec3 Structure::in_body(uint32_t piece, const glm::dvec3& point) const {
    if (pieces_[piece].body == none) return glm::vec3(0.0f);
    return glm::vec3(point - bodies_[pieces_[piece].body].centre);
}

std::vector<BodyId> Structure::bodies() const {
    std::vector<BodyId> ids;
    for (const BodyState& body : bodies_)
        if (body.id != BodyId{}) ids.push_back(body.id);
    return ids;
}

uint64_t Structure::state_hash() const {
    StateHash hash;
    for (const BondGraph::Bond& bond : graph_.bonds()) hash.add(bond.health);
    for (uint32_t piece = 0; piece < pieces_.size(); ++piece) {
        hash.add(pieces_[piece].body);
        hash.add(static_cast<uint8_t>(pieces_[piece].anchored));
    }
    return hash.value();
}

void Structure::visit_poses(const World& world, float alpha, uint64_t since, const PoseVisitor& visit) const {
    for (const BodyState& body : bodies_) {
        if (body.pieces.empty() || !world.contains(body.id) || world.last_moved_step(body.id) < since) continue;
        const Pose pose = world.interpolated_pose(body.id, alpha);
        for (const uint32_t piece : body.pieces)
            if (!pieces_[piece].parts.empty()) visit(piece, offset_pose(pose, pieces_[piece].centre - body.centre));
    }
}

} // namespace brittle::physics

#include "physics/cutting/destruction.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <ostream>
#include <utility>

#include <glm/geometric.hpp>

#include "physics/cutting/destruction_seeds.h"
#include "physics/world/body_motion.h"
#include "physics/world/state_hash.h"

namespace brittle::physics {

namespace {

using fracture::Error;
using fracture::Status;

// Jobs cut on one thread each: threads of a pool that a worker started would inherit its low priority for good. Those of
// SolidSettings::hull_threads end with the cut.
std::shared_ptr<const BreakableDesc> for_jobs(BreakableDesc desc) {
    desc.solid.threads = 1;
    return std::make_shared<const BreakableDesc>(std::move(desc));
}

} // namespace

std::ostream& operator<<(std::ostream& stream, PieceId id) {
    return id == PieceId{} ? stream << "piece none" : stream << "piece " << id.value;
}

Destruction::Destruction(const DestructionSettings& settings) : settings_(settings), background_(settings.workers) {}

Result<ObjectId> Destruction::add(World& world, const fracture::TriangleMesh& mesh, const BreakableDesc& desc) {
    Result<SolidPtr> whole = make_solid(mesh, desc.solid);
    if (!whole) return whole.error();
    return add(world, *whole, desc);
}

Result<ObjectId> Destruction::add(World& world, SolidPtr whole, const BreakableDesc& desc,
                                  std::optional<PayloadPtr> payload) {
    if (!payload) payload = desc.payload ? desc.payload(*whole, nullptr) : PayloadPtr();
    const ObjectId id{next_object_};
    objects_.emplace(id, Object{.desc = for_jobs(desc)});
    Live piece{.object = id,
               .solid = std::move(whole),
               .seed = seed_of(desc.pattern.seed, id.value),
               .born = world.steps_taken()};
    const Motion motion{desc.motion.placement, desc.motion.placement, desc.motion.linear_velocity,
                        desc.motion.angular_velocity};
    const Result<PieceId> added =
        add_piece(world, std::move(piece), std::move(*payload), motion, glm::dvec3(0.0), false);
    if (!added) {
        objects_.erase(id);
        return added.error();
    }
    ++next_object_;
    part_if_overloaded(world, *added);
    return id;
}

Result<ObjectId> Destruction::add(World& world, const fracture::Fragments& fragments, const StructureDesc& structure,
                                  const BreakableDesc& pieces, std::span<const SolidPtr> solids,
                                  std::vector<PayloadPtr> payloads) {
    std::vector<SolidPtr> own;
    if (solids.empty()) {
        Result<std::vector<SolidPtr>> made = solids_of(fragments, pieces.solid, false, pieces.solid.threads);
        if (!made) return made.error();
        solids = own = std::move(*made);
    }
    assert(solids.size() == fragments.pieces.size());
    AssemblyPart part{&fragments, structure};
    if (part.desc.hulls.empty())
        for (const SolidPtr& solid : solids) part.desc.hulls.push_back(solid->parts[0].hull);
    const Result<AssemblyId> made = assemble(world, {&part, 1}, {});
    if (!made) return made.error();
    return add(world, *made, 0, pieces, solids, std::move(payloads));
}

Result<AssemblyId> Destruction::assemble(World& world, std::span<const AssemblyPart> parts,
                                         std::span<const GlueBond> glue) {
    Result<Assembly> made = physics::assemble(world, parts, glue);
    if (!made) return made.error();
    const AssemblyId id{next_structure_++};
    SharedStructure& shared = *(structures_[id] = std::make_shared<SharedStructure>());
    shared.structure = std::make_unique<Structure>(std::move(made->structure));
    shared.pieces.resize(shared.structure->piece_count());
    shared.first_piece = std::move(made->first_piece);
    shared.placements = std::move(made->placements);
    return id;
}

ObjectId Destruction::add(const World& world, AssemblyId assembly, uint32_t part, const BreakableDesc& pieces,
                          std::span<const SolidPtr> solids, std::vector<PayloadPtr> payloads) {
    if (payloads.empty()) payloads = payloads_of(solids, pieces.payload, pieces.solid.threads);
    assert(payloads.size() == solids.size());
    const std::shared_ptr<SharedStructure>& shared = structures_.at(assembly);
    const uint32_t first = shared->first_piece[part];
    assert(solids.size() == shared->first_piece[part + 1] - first);
    const ObjectId id{next_object_++};
    Object& object = objects_[id];
    object.desc = for_jobs(pieces);
    object.bonds = shared;
    object.placement = shared->placements[part];
    const uint64_t seed = seed_of(pieces.pattern.seed, id.value);
    for (uint32_t i = 0; i < solids.size(); ++i)
        shared->pieces[first + i] = register_piece({.object = id,
                                                    .solid = solids[i],
                                                    .seed = seed_of(seed, i),
                                                    .bonded = first + i,
                                                    .born = world.steps_taken()},
                                                   std::move(payloads[i]));
    return id;
}

void Destruction::remove(World& world, ObjectId id) {
    const auto object = objects_.find(id);
    if (object == objects_.end()) return;
    std::vector<uint32_t> bonded;
    for (const PieceId piece : pieces()) {
        const Live& live = pieces_.at(piece);
        if (live.object != id) continue;
        if (live.bonded != none)
            bonded.push_back(live.bonded);
        else
            world.remove_body(live.own);
        forget_piece(piece);
    }
    if (object->second.bonds) object->second.bonds->structure->remove_pieces(world, bonded);
    objects_.erase(object);
    forget_empty();
}

// Starts a job for a held piece that is too weak for its own weight.
void Destruction::part_if_overloaded(const World& world, PieceId id) {
    const Live& piece = pieces_.at(id);
    if (!piece.solid->may_part()) return;
    const SolidSettings& settings = desc_of(piece).solid;
    std::vector<uint32_t> islands = islands_under_load(*piece.solid->blocks, settings.material,
                                                       settings.blocks.strength_scale, gravity_of(world, piece), {});
    if (std::ranges::any_of(islands, [](uint32_t island) { return island != 0; }))
        start_parting(world, id, {}, [found = std::move(islands)](const auto&...) { return found; });
}

BodyId Destruction::body_of(const Live& piece) const {
    return piece.bonded == none ? piece.own : structure_of(piece).body_of(piece.bonded);
}

// The motion of the body that holds the piece; that of the piece only if it is alone in the body.
std::optional<Destruction::Motion> Destruction::motion_of(const World& world, const Live& piece) const {
    const BodyId body = body_of(piece);
    if (!world.contains(body)) return std::nullopt;
    return Motion{in_axes_of_object(piece, world.pose(body)), in_axes_of_object(piece, world.previous_pose(body)),
                  world.linear_velocity(body), world.angular_velocity(body)};
}

std::optional<Pose> Destruction::pose_of(const World& world, const Live& piece) const {
    const BodyId body = body_of(piece);
    if (!world.contains(body)) return std::nullopt;
    return in_body(piece, world.pose(body));
}

Pose Destruction::in_body(const Live& piece, const Pose& body) const {
    if (piece.bonded == none) return body;
    return in_axes_of_object(piece, offset_pose(body, glm::dvec3(structure_of(piece).offset(piece.bonded))));
}

// A structure has the axes of its first object. The same pose, bit for bit, for a piece that is not turned against it.
Pose Destruction::in_axes_of_object(const Live& piece, const Pose& pose) const {
    const PartPlacement& placement = objects_.at(piece.object).placement;
    if (piece.bonded == none || !placement.is_turned()) return pose;
    return {pose.position, glm::quat(glm::normalize(glm::dquat(pose.orientation) * placement.turn))};
}

// All but the pose and the motion.
BodyDesc Destruction::body_of(const SolidPiece& solid) {
    BodyDesc body;
    body.parts = solid.parts;
    body.fixed = solid.anchored;
    body.mass = static_cast<float>(solid.body.mass);
    body.inertia = glm::mat3(solid.body.inertia);
    return body;
}

// Runs on the job's thread. A solid that cannot become a body is reported by add_piece().
Destruction::Broken Destruction::broken_into(Result<std::vector<SolidPtr>> pieces, const SolidPiece& cut_from,
                                             const BreakableDesc& desc, const std::optional<PartPlacement>& bonds) {
    Broken broken;
    if (!pieces) {
        broken.failure = pieces.error().message;
        return broken;
    }
    if (pieces->size() < 2) return broken;
    for (SolidPtr& solid : *pieces) {
        Made& made = broken.pieces.emplace_back();
        if (const Result<std::shared_ptr<const BodyForm>> form = make_form(body_of(*solid))) made.form = *form;
        if (desc.payload) made.payload = desc.payload(*solid, &cut_from);
        made.solid = std::move(solid);
        if (bonds) broken.parts.push_back(part_of(made, desc.solid.material, *bonds));
    }
    return broken;
}

// Runs on the job's thread.
Structure::Part Destruction::part_of(const Made& made, const Material& material, const PartPlacement& placement) {
    const SolidPiece& solid = *made.solid;
    Structure::Part part{.centre = placement.to_structure(solid.mass.centre_of_mass),
                         .mass = {solid.body.mass, placement.to_structure(solid.body.inertia)},
                         .hulls = placement.to_structure(solid.parts),
                         .form = made.form,
                         .material = material,
                         .anchored = solid.anchored};
    if (!placement.is_turned()) return part;
    BodyDesc body = body_of(solid);
    body.parts = part.hulls;
    body.inertia = glm::mat3(part.mass.inertia);
    const Result<std::shared_ptr<const BodyForm>> form = make_form(body);
    part.form = form ? *form : nullptr;
    return part;
}

// `motion` is that of the point `from`, which is in the coordinates of the object.
Result<PieceId> Destruction::add_piece(World& world, Live piece, PayloadPtr payload, const Motion& motion,
                                       const glm::dvec3& from, bool debris,
                                       const std::shared_ptr<const BodyForm>& form) {
    const BreakableDesc& desc = desc_of(piece);
    const SolidPiece& solid = *piece.solid;
    const glm::dvec3 arm = solid.mass.centre_of_mass - from;
    BodyDesc body = form ? BodyDesc{.form = form} : body_of(solid);
    body.debris = debris;
    body.pose = offset_pose(motion.pose, arm);
    body.previous = offset_pose(motion.previous, arm);
    body.linear_velocity =
        glm::vec3(glm::dvec3(motion.linear) + glm::cross(glm::dvec3(motion.angular), to_world_axes(motion.pose, arm)));
    body.angular_velocity = motion.angular;
    body.friction = desc.solid.material.friction;
    body.restitution = desc.solid.material.restitution;
    const Result<BodyId> added = world.add_body(body);
    if (!added) return added.error();
    piece.own = *added;
    const PieceId id = register_piece(std::move(piece), std::move(payload));
    piece_of_body_[added->value] = id;
    return id;
}

PieceId Destruction::register_piece(Live piece, PayloadPtr payload) {
    const PieceId id{next_piece_++};
    if (free_slots_.empty())
        piece.slot = slot_count_++;
    else
        piece.slot = free_slots_.extract(free_slots_.begin()).value();
    ++objects_.at(piece.object).pieces;
    added_[id] = {id, piece.object, piece.slot, piece.depth, piece.solid, piece.parent, std::move(payload)};
    pieces_.emplace(id, std::move(piece));
    return id;
}

// Leaves the body alone: the caller removes it, or its structure does.
void Destruction::forget_piece(PieceId id) {
    const auto at = pieces_.find(id);
    Live& piece = at->second;
    if (piece.job != none) {
        background_.cancel(piece.job);
        jobs_.erase(piece.job);
    }
    if (piece.bonded == none) piece_of_body_.erase(piece.own.value);
    free_slots_.insert(piece.slot);
    --objects_.at(piece.object).pieces;
    fading_.erase(id);
    PayloadPtr payload;
    if (auto added = added_.extract(id))
        payload = std::move(added.mapped().payload);
    else
        removed_[id] = {id, piece.slot};
    free_elsewhere(std::move(piece.solid), std::move(payload));
    pieces_.erase(at);
}

// Frees large meshes on a worker thread: a mesh of a million triangles takes 4 to 8 ms.
void Destruction::free_elsewhere(SolidPtr solid, PayloadPtr payload) {
    constexpr size_t many_triangles = 10'000; // the allocator keeps the blocks of smaller ones, so freeing them is fast
    if (solid->triangle_count() <= many_triangles) return;
    if (payload) background_.discard(std::shared_ptr<const PiecePayload>(std::move(payload)));
    background_.discard(std::move(solid));
}

// Forgets pieces whose body the caller removed from the world.
void Destruction::remove_lost(const World& world) {
    if (world.removed_count() == removed_seen_) return;
    removed_seen_ = world.removed_count();
    std::vector<PieceId> lost;
    for (const auto& [id, piece] : pieces_)
        if (!world.contains(body_of(piece))) lost.push_back(id);
    for (const PieceId id : lost) forget_piece(id);
}

void Destruction::update(World& world, double budget) {
    commits_.clear();
    remove_lost(world);
    if (world.steps_taken() != steps_seen_) {
        collect_blows(world);
        update_loads(world);
    }
    steps_seen_ = world.steps_taken();
    update_structures(world);
    commit_due(world, budget);
    update_debris(world);
    std::erase_if(objects_, [](const auto& entry) { return entry.second.pieces == 0; });
    forget_empty();
}

// Forgets structures without objects.
void Destruction::forget_empty() {
    std::erase_if(structures_, [](const auto& entry) { return entry.second.use_count() == 1; });
}

DestructionEvents Destruction::take_events() {
    DestructionEvents events;
    for (const auto& [id, removed] : removed_) events.removed.push_back(removed);
    for (auto& [id, added] : added_) events.added.push_back(std::move(added));
    for (const auto& [id, fading] : fading_) events.fading.push_back(fading);
    removed_.clear();
    added_.clear();
    fading_.clear();
    return events;
}

void Destruction::visit_poses(const World& world, float alpha, uint64_t since, const PoseVisitor& visit) const {
    for (const auto& [id, piece] : pieces_) {
        const BodyId body = body_of(piece);
        if (!world.contains(body) || world.last_moved_step(body) < since) continue;
        visit(piece.slot, in_body(piece, world.interpolated_pose(body, alpha)));
    }
}

Structure* Destruction::structure(ObjectId object) {
    const auto at = objects_.find(object);
    return at == objects_.end() || !at->second.bonds ? nullptr : at->second.bonds->structure.get();
}

const Structure* Destruction::structure(ObjectId object) const {
    const auto at = objects_.find(object);
    return at == objects_.end() || !at->second.bonds ? nullptr : at->second.bonds->structure.get();
}

std::vector<Structure*> Destruction::structures() {
    std::vector<Structure*> all;
    for (const auto& [id, shared] : structures_) all.push_back(shared->structure.get());
    return all;
}

std::vector<const Structure*> Destruction::structures() const {
    std::vector<const Structure*> all;
    for (const auto& [id, shared] : structures_) all.push_back(shared->structure.get());
    return all;
}

std::optional<uint32_t> Destruction::bonded(PieceId piece) const {
    const uint32_t index = pieces_.at(piece).bonded;
    return index == none ? std::nullopt : std::optional(index);
}

std::vector<PieceId> Destruction::pieces() const {
    std::vector<PieceId> ids;
    for (const auto& [id, piece] : pieces_) ids.push_back(id);
    return ids;
}

uint64_t Destruction::state_hash() const {
    StateHash hash;
    for (const auto& [id, piece] : pieces_) {
        hash.add(id.value);
        hash.add(piece.solid->mass.volume);
        hash.add(piece.seed);
        hash.add(piece.depth);
        hash.add(piece.blows);
        hash.add(piece.fading);
        hash.add(piece.load);
        hash.add(piece.checked_load);
        hash.add(static_cast<uint8_t>(piece.job != none));
        hash.add(static_cast<uint8_t>(piece.unbreakable));
        hash.add(piece.waiting ? piece.waiting->blow.energy : 0.0);
    }
    for (const auto& [id, shared] : structures_) hash.add(shared->structure->state_hash());
    return hash.value();
}

} // namespace brittle::physics

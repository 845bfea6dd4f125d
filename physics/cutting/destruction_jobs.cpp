// Jobs of a Destruction: blows that break a piece, and held pieces under too much load.
#include "physics/cutting/destruction.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

#include "fracture/local/cluster_queries.h"
#include "fracture/mesh/nearest.h"
#include "physics/cutting/destruction_seeds.h"
#include "physics/world/body_motion.h"

namespace brittle::physics {

namespace {

// Seeds of a piece's second and later blows, in one sequence with its children; a piece has fewer children than this.
constexpr uint64_t blow_seed_base = uint64_t{1} << 32;
// The load on a held piece is its running mean over load_seconds. Its blocks are checked again, by one job, once the
// load exceeds load_growth times the checked load plus weight_growth times the piece's weight.
constexpr double load_seconds = 0.1, load_growth = 1.25, weight_growth = 0.05;
// Of a cut whose surface costs more than the blow's energy: attempts with less damage, and the share of the energy that
// they aim at.
constexpr int max_recuts = 3;
constexpr double recut_share = 0.9;

bool finite(const glm::vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Cuts those pieces of a cut that are held and cannot bear their load any more.
std::vector<SolidPtr> standing(std::vector<SolidPtr> pieces, const SolidSettings& settings, const glm::dvec3& gravity,
                               const std::function<bool()>& cancelled) {
    std::vector<SolidPtr> all;
    for (SolidPtr& piece : pieces) {
        if (!piece->may_part()) {
            all.push_back(std::move(piece));
            continue;
        }
        const std::vector<uint32_t> islands =
            islands_under_load(*piece->blocks, settings.material, settings.blocks.strength_scale, gravity, {});
        Result<std::vector<SolidPtr>> parts(std::vector<SolidPtr>{piece});
        if (std::ranges::any_of(islands, [](uint32_t island) { return island != 0; }))
            parts = break_apart(*piece, islands, settings, cancelled);
        if (parts)
            all.insert(all.end(), parts->begin(), parts->end());
        else
            all.push_back(std::move(piece)); // its cut failed: it stands, although it is overloaded
    }
    return all;
}

} // namespace

void Destruction::collect_blows(World& world) {
    float least = std::numeric_limits<float>::infinity();
    for (const auto& [id, object] : objects_) least = std::min(least, object.desc->impact_speed);
    const auto ours = [&](BodyId body) { return piece_of_body_.contains(body.value); };
    for (const BodyBlow& blow : blows_.update(world, least, ours)) {
        const auto at = piece_of_body_.find(blow.body.value);
        const PieceId id = at->second;
        const Live& piece = pieces_.at(id);
        if (2.0f * blow.energy <= desc_of(piece).impact_speed * blow.impulse) continue;
        Hit hit{.blow = {glm::dvec3(blow.point) + piece.solid->mass.centre_of_mass,
                         to_body_axes(world.pose(blow.body), blow.normal), blow.energy,
                         static_cast<double>(blow.equivalent_impulse / impact_seconds)},
                .bounce = bounce_energy(world, blow),
                .contact = {.striker = blow.other, .arm = blow.arm, .lost = blow.energy}};
        // A contact with the ground or a fixed body is not solved again.
        if (world.contains(blow.other) && !world.fixed(blow.other))
            hit.contact.normal_impulse = blow.impulse * blow.normal;
        suspend_if_cut(world, piece, blow.friction, hit);
        hit_piece(world, id, hit);
    }
}

// Takes back the bounce of the contact of a blow that is going to cut the piece. Adds the friction and the lost energy to
// the contact.
void Destruction::suspend_if_cut(World& world, const Live& piece, const glm::vec3& friction, Hit& hit) const {
    const BodyId body = body_of(piece);
    if (hit.blow.force > piece.solid->bearable && cuts(world, piece, hit)) {
        const float before = glm::length(hit.contact.normal_impulse);
        suspend(world, body, hit.contact);
        // Without its bounce the contact dissipates the energy of the impulse that remains.
        if (before > 0.0f) {
            const double kept = static_cast<double>(glm::length(hit.contact.normal_impulse) / before);
            hit.blow.energy *= kept;
            hit.contact.lost *= kept;
        }
    }
    if (!hit.contact.empty()) add_friction(world, body, friction, hit.contact);
}

namespace {

// The impulses of the last step between a bonded piece and what hit it.
struct StepContact {
    SuspendedContact contact{};
    glm::vec3 friction{0.0f}; // N s, on the piece
};

// Without impulses where the structure has solved the contact again, for what broke off, and where the striker does not
// move.
StepContact contact_of(const World& world, const Structure& structure, const Impact& impact) {
    const StepContact none{.contact = {.striker = impact.other}};
    if (!world.contains(impact.other) || world.fixed(impact.other)) return none;
    StepContact found = none;
    found.contact.lost = static_cast<double>(impact.energy);
    float total = 0.0f;
    for (const Contact& contact : world.solved_contacts()) {
        const bool first = contact.b == impact.other && structure.piece_at(contact.a, contact.part_a) == impact.piece;
        if (!first && !(contact.a == impact.other && structure.piece_at(contact.b, contact.part_b) == impact.piece))
            continue;
        if (contact.impulse != contact.blow) return none;
        if (!(contact.impulse > 0.0f)) continue;
        total += contact.impulse;
        found.contact.normal_impulse += contact.impulse * (first ? contact.normal : -contact.normal);
        found.friction += first ? contact.friction : -contact.friction;
        const glm::vec3 arm = contact.point - world.previous_pose(impact.other).position;
        found.contact.arm += (arm - found.contact.arm) * (contact.impulse / total);
    }
    return found;
}

} // namespace

void Destruction::update_structures(World& world) {
    for (const auto& [id, shared] : structures_) {
        for (const Impact& impact : shared->structure->update(world).impacts) {
            const PieceId piece = shared->pieces[impact.piece];
            const auto at = pieces_.find(piece);
            if (at == pieces_.end() || !world.contains(body_of(at->second))) continue;
            const Pose pose = *pose_of(world, at->second);
            Hit hit{.blow = {to_body_axes(pose, impact.point - pose.position) + at->second.solid->mass.centre_of_mass,
                             to_body_axes(pose, impact.normal), impact.energy,
                             static_cast<double>(impact.impulse * impact.sharpness / impact_seconds)},
                    .contact = {.striker = impact.other}};
            if (has_bonds(at->second)) {
                const StepContact found = contact_of(world, *shared->structure, impact);
                hit.contact = found.contact;
                suspend_if_cut(world, at->second, found.friction, hit);
            }
            hit_piece(world, piece, hit);
        }
    }
}

bool Destruction::strike(const World& world, PieceId id, const glm::vec3& point, const glm::vec3& normal, double energy,
                         double force) {
    const auto at = pieces_.find(id);
    if (at == pieces_.end()) return false;
    const std::optional<Blow> blow = blow_at(world, at->second, point, normal, energy, force);
    if (!blow) return false;
    Hit hit;
    hit.blow = *blow;
    hit_piece(world, id, hit);
    return at->second.job != none;
}

std::optional<PlannedCut> Destruction::foresee(const World& world, PieceId id, const glm::vec3& point,
                                               const glm::vec3& normal, double energy, double force) const {
    const auto at = pieces_.find(id);
    if (at == pieces_.end() || at->second.job != none) return std::nullopt;
    const std::optional<Blow> blow = blow_at(world, at->second, point, normal, energy, force);
    return blow ? plan(world, at->second, *blow) : std::nullopt;
}

std::optional<Blow> Destruction::blow_at(const World& world, const Live& piece, const glm::vec3& point,
                                         const glm::vec3& normal, double energy, double force) const {
    if (!finite(point) || !finite(normal) || !(glm::length(normal) > 0.0f)) return std::nullopt;
    const std::optional<Pose> pose = pose_of(world, piece);
    if (!pose || !(energy > 0.0) || !std::isfinite(energy)) return std::nullopt;
    return Blow{to_body_axes(*pose, point - pose->position) + piece.solid->mass.centre_of_mass,
                to_body_axes(*pose, glm::normalize(normal)), energy, force};
}

// Whether a blow cuts a piece, or may cut a part of it once the running job is done. A blow that the piece bears does
// nothing while a job runs.
bool Destruction::cuts(const World& world, const Live& piece, const Hit& hit) const {
    if (piece.job != none) return hit.blow.force > piece.solid->bearable;
    return plan(world, piece, hit.blow, hit.bounce).has_value();
}

DamageLimits Destruction::limits_of(const Live& piece) const {
    const BreakableDesc& desc = *objects_.at(piece.object).desc;
    const double least = desc.solid.min_size * desc.solid.min_size * desc.solid.min_size;
    return {desc.max_pieces, least, piece.solid->bearable};
}

void Destruction::note_borne(const World& world, PieceId id, const Hit& hit) {
    const Live& piece = pieces_.at(id);
    if (!piece.solid->breakable || piece.unbreakable || piece.fading > 0) return;
    if (borne_.size() == max_borne) borne_.pop_front();
    borne_.push_back({world.steps_taken(), id, hit.contact.striker, hit.blow, hit.bounce,
                      objects_.at(piece.object).desc->solid.material, piece.solid->mass.volume, limits_of(piece)});
}

// Starts a job, or keeps the blow until the running job is done.
void Destruction::hit_piece(const World& world, PieceId id, const Hit& hit) {
    Live& piece = pieces_.at(id);
    if (!cuts(world, piece, hit)) {
        if (piece.job == none) note_borne(world, id, hit);
        return break_elsewhere(world, id, hit);
    }
    if (piece.job == none) {
        if (!(hit.blow.force > piece.solid->bearable))
            break_elsewhere(world, id, hit, plan(world, piece, hit.blow, hit.bounce));
        if (piece.job == none) start_job(world, id, hit);
        return;
    }
    if (!piece.waiting) {
        piece.waiting = hit;
        return;
    }
    const double energy = piece.waiting->blow.energy + hit.blow.energy;
    if (hit.blow.energy > piece.waiting->blow.energy)
        piece.waiting = hit; // the weaker contact stays as the world solved it
    piece.waiting->blow.energy = energy;
}

std::optional<PlannedCut> Destruction::plan(const World& world, const Live& piece, Blow blow, double bounce) const {
    if (!piece.solid->breakable || piece.unbreakable || piece.fading > 0) return std::nullopt;
    if (!(blow.force > piece.solid->bearable)) blow.energy -= bounce;
    const std::shared_ptr<const BreakableDesc>& desc = objects_.at(piece.object).desc;
    const Damage damage = damage_of(blow, desc->solid.material, piece.solid->mass.volume, limits_of(piece));
    if (damage.pieces == 0) return std::nullopt;
    const uint64_t seed = piece.blows == 0 ? piece.seed : seed_of(piece.seed, blow_seed_base + piece.blows);
    return PlannedCut{piece.solid, desc, blow, damage, seed, gravity_of(world, piece)};
}

namespace {

// The pieces of the damage, before the load on held ones; none where the cracks exceed the budget.
Result<std::vector<SolidPtr>> cut_pieces(const PlannedCut& cut, const Damage& damage, CrackBudget& budget,
                                         const std::function<bool()>& cancelled) {
    ImpactPattern pattern = cut.desc->pattern;
    pattern.seed = cut.seed;
    Blow on_surface = cut.blow;
    const SolidPiece& solid = *cut.solid;
    on_surface.point = solid.is_clustered() ? fracture::nearest_on(solid.clusters, cut.blow.point)
                                            : fracture::nearest_on(solid.surface().mesh, cut.blow.point);
    SolidSettings settings = cut.desc->solid;
    settings.rough.seed = cut.seed;
    settings.rough.detail = 1; // for the latency of blows
    if (pattern.kind == fracture::PatternKind::splinters && pattern.diagram.empty())
        settings.rough.grain = glm::length(settings.rough.grain) * longest_axis(solid.mass);
    ImpactSites sites;
    const auto broken = [&] {
        sites = solid.is_clustered() ? impact_sites(solid.clusters, solid.mass, on_surface, damage, pattern)
                                     : impact_sites(solid.surface().mesh, solid.mass, on_surface, damage, pattern);
        return break_solid(solid, sites.sites, sites.groups, settings, cancelled, &budget);
    };
    Result<std::vector<SolidPtr>> pieces = broken();
    const auto withstands = [&] {
        return pieces && pieces->size() < 2 && !budget.exceeded() && !(cancelled && cancelled());
    };
    // A failed attempt keeps the previous result.
    const auto take = [&](Result<std::vector<SolidPtr>> other) {
        if (other) pieces = std::move(other);
    };
    if (withstands() && sites.bricks) { // no whole brick comes off, so crumbs do
        pattern.kind = fracture::PatternKind::uniform;
        take(broken());
    }
    if (withstands() && sites.rest > 1 && std::ranges::find(sites.groups, sites.rest) != sites.groups.end()) {
        // Crumbs that are each below the minimum size come off as one piece.
        for (uint32_t& group : sites.groups) group = group < sites.rest ? 0 : 1;
        take(break_solid(solid, sites.sites, sites.groups, settings, cancelled, &budget));
    }
    return pieces;
}

} // namespace

Result<std::vector<SolidPtr>> carry_out(const PlannedCut& cut, const std::function<bool()>& cancelled) {
    Damage damage = cut.damage;
    // The blow's energy pays for the cracks. Damage estimates their surface; shells, splinters and bricks have more of
    // it.
    const auto fracture_energy = static_cast<double>(cut.desc->solid.material.fracture_energy);
    CrackBudget budget{.limit = cut.blow.energy / fracture_energy};
    Result<std::vector<SolidPtr>> pieces = cut_pieces(cut, damage, budget, cancelled);
    for (int k = 0; k < max_recuts && pieces && budget.exceeded(); ++k) {
        damage.radius *= std::sqrt(recut_share * budget.limit / budget.surface);
        pieces = cut_pieces(cut, damage, budget, cancelled);
    }
    if (pieces && budget.exceeded()) return std::vector<SolidPtr>{cut.solid};
    if (pieces) *pieces = standing(std::move(*pieces), cut.desc->solid, cut.gravity, cancelled);
    return pieces;
}

void Destruction::start_job(const World& world, PieceId id, const Hit& hit) {
    Live& piece = pieces_.at(id);
    const std::optional<PlannedCut> cut = plan(world, piece, hit.blow, hit.bounce);
    if (!cut) return;
    ++piece.blows;
    piece.job = next_job_++;
    jobs_[piece.job] = {id, world.steps_taken() + std::max(settings_.latency, 1u), hit};
    ++statistics_.blows;
    background_.start(piece.job, [cut = *cut, bonds = placement_if_bonded(piece)](const std::atomic<bool>& cancelled) {
        return broken_by(cut, bonds, [&] { return cancelled.load(); });
    });
}

std::optional<PartPlacement> Destruction::placement_if_bonded(const Live& piece) const {
    return has_bonds(piece) ? std::optional(objects_.at(piece.object).placement) : std::nullopt;
}

Destruction::Broken Destruction::broken_by(const PlannedCut& cut, const std::optional<PartPlacement>& bonds,
                                           const std::function<bool()>& cancelled) {
    Broken broken = broken_into(carry_out(cut, cancelled), *cut.solid, *cut.desc, bonds);
    broken.chip = cut.damage.local;
    return broken;
}

// m/s^2, in the coordinates of the object; zero for a piece without a body.
glm::dvec3 Destruction::gravity_of(const World& world, const Live& piece) const {
    const std::optional<Pose> pose = pose_of(world, piece);
    return pose ? to_body_axes(*pose, world.settings().gravity) : glm::dvec3(0.0);
}

// A blow that breaks nothing at its contact may break the weakest section of a held piece; where none breaks, `chip` is
// cut. While a job cuts the piece, the blow has no effect.
void Destruction::break_elsewhere(const World& world, PieceId id, const Hit& hit,
                                  const std::optional<PlannedCut>& chip) {
    Live& piece = pieces_.at(id);
    if (!piece.solid->may_part() || piece.job != none || piece.unbreakable || piece.fading > 0) return;
    const double impulse = static_cast<double>(glm::length(hit.contact.normal_impulse));
    if (!(impulse > 0.0)) return;
    const Material& material = desc_of(piece).solid.material;
    if (!(hit.blow.energy > piece.solid->blocks->min_area * static_cast<double>(material.fracture_energy))) return;
    start_parting(
        world, id, hit,
        [energy = hit.blow.energy, blow = PointLoad{hit.blow.point, impulse * hit.blow.normal}](
            const SolidPiece& solid, const SolidSettings& settings, const glm::dvec3& gravity) {
            return islands_after_blow(*solid.blocks, settings.material, settings.blocks.strength_scale, gravity, blow,
                                      energy);
        },
        chip);
}

// Updates the loads on held pieces, and checks the blocks of those whose load has grown.
void Destruction::update_loads(const World& world) {
    std::map<BodyId, PieceId> held; // in a fixed order
    for (const auto& [id, piece] : pieces_)
        if (piece.solid->may_part() && piece.bonded == none) held.emplace(piece.own, id);
    if (held.empty()) return;
    std::map<PieceId, std::vector<PointLoad>> loads;
    const double step = world.settings().step;
    for (const Contact& contact : world.contacts())
        for (const bool first : {true, false}) {
            const auto at = held.find(first ? contact.a : contact.b);
            if (at == held.end()) continue;
            const Live& piece = pieces_.at(at->second);
            if (contact.speed > desc_of(piece).impact_speed) continue;
            const Pose pose = world.pose(at->first);
            const glm::vec3 impulse = (first ? 1.0f : -1.0f) * (contact.impulse * contact.normal + contact.friction);
            loads[at->second].push_back(
                {to_body_axes(pose, contact.point - pose.position) + piece.solid->mass.centre_of_mass,
                 to_body_axes(pose, impulse) / step});
        }
    for (const auto& [body, id] : held) {
        Live& piece = pieces_.at(id);
        const auto found = loads.find(id);
        double sum = 0.0;
        if (found != loads.end())
            for (const PointLoad& load : found->second) sum += glm::length(load.force);
        piece.load += (sum - piece.load) * std::min(1.0, step / load_seconds);
        piece.checked_load = std::min(piece.checked_load, piece.load);
        const double weight = piece.solid->body.mass * static_cast<double>(glm::length(world.settings().gravity));
        const bool more = piece.load > load_growth * piece.checked_load + weight_growth * weight;
        if (!more || found == loads.end() || piece.job != none || piece.unbreakable || piece.fading > 0) continue;
        piece.checked_load = piece.load;
        for (PointLoad& load : found->second) load.force *= piece.load / sum; // the mean load, at the present contacts
        start_parting(world, id, {},
                      [=, pushes = std::move(found->second)](const SolidPiece& solid, const SolidSettings& settings,
                                                             const glm::dvec3& gravity) {
                          return islands_under_load(*solid.blocks, settings.material, settings.blocks.strength_scale,
                                                    gravity, pushes);
                      });
    }
}

// Starts a job that cuts a held piece between the islands that `parts` finds, after a blow elsewhere or, without a hit,
// under load. Where the piece stands, the job cuts the chip.
void Destruction::start_parting(const World& world, PieceId id, const Hit& hit, const Parting& parts,
                                const std::optional<PlannedCut>& chip) {
    Live& piece = pieces_.at(id);
    piece.job = next_job_++;
    jobs_[piece.job] = {id, world.steps_taken() + std::max(settings_.latency, 1u), hit, true};
    background_.start(piece.job, [=, solid = piece.solid, gravity = gravity_of(world, piece),
                                  desc = objects_.at(piece.object).desc,
                                  bonds = placement_if_bonded(piece)](const std::atomic<bool>& cancelled) {
        const std::vector<uint32_t> islands = parts(*solid, desc->solid, gravity);
        if (std::ranges::count(islands, 0u) == static_cast<ptrdiff_t>(islands.size()))
            return chip ? broken_by(*chip, bonds, [&] { return cancelled.load(); }) : Broken{};
        return broken_into(break_apart(*solid, islands, desc->solid, [&] { return cancelled.load(); }), *solid, *desc,
                           bonds);
    });
}

} // namespace brittle::physics

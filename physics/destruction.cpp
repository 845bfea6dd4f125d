#include "physics/destruction.h"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>
#include <limits>
#include <ostream>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/random.h"

namespace brittle::physics {

namespace {

using fracture::Error;
using fracture::Status;

glm::dvec3 turned(const Pose& pose, const glm::dvec3& arm) {
    return glm::dquat(pose.orientation) * arm;
}

glm::dvec3 turned_back(const Pose& pose, const glm::vec3& arm) {
    return glm::conjugate(glm::dquat(pose.orientation)) * glm::dvec3(arm);
}

Pose moved(const Pose& body, const glm::dvec3& arm) {
    return {glm::vec3(glm::dvec3(body.position) + turned(body, arm)), body.orientation};
}

bool finite(const glm::vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Of a child: differs for all pieces of all objects, and is the same in every run.
uint64_t seed_of(uint64_t parent, uint64_t child) {
    return fracture::Random(parent ^ (0x9e3779b97f4a7c15ull * (child + 1))).next();
}

uint64_t steps_of(double seconds, const World& world) {
    const double steps = std::ceil(seconds / static_cast<double>(world.settings().step));
    return steps < 1.0 ? 1 : steps > 1e15 ? uint64_t{1'000'000'000'000'000} : static_cast<uint64_t>(steps);
}

float speed_at(const World& world, BodyId body, const glm::vec3& point, const glm::vec3& direction) {
    if (!world.contains(body)) return 0.0f;
    const glm::vec3 arm = point - world.pose(body).position;
    return glm::dot(world.linear_velocity(body) + glm::cross(world.angular_velocity(body), arm), direction);
}

float response_at(const World& world, BodyId body, const glm::vec3& point, const glm::vec3& direction) {
    return world.contains(body) ? world.response(body, point, direction) : 0.0f;
}

void push(World& world, BodyId body, const glm::vec3& impulse, const glm::vec3& point) {
    if (world.contains(body)) world.apply_impulse(body, impulse, point);
}

// From a point in the coordinates of the object to the nearest corner of the solid's hulls, squared: near enough to tell
// which of the pieces around a contact was hit.
double distance_to(const SolidPiece& solid, const glm::dvec3& point) {
    const glm::vec3 local(point - solid.mass.centre_of_mass);
    float nearest = std::numeric_limits<float>::infinity();
    for (const BodyPart& part : solid.parts)
        for (const glm::vec3& corner : part.hull->points) {
            const glm::vec3 apart = corner + part.offset - local;
            nearest = std::min(nearest, glm::dot(apart, apart));
        }
    return nearest;
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

Result<ObjectId> Destruction::add(World& world, SolidPtr whole, const BreakableDesc& desc) {
    const ObjectId id{next_object_};
    objects_.emplace(id, Object{std::make_shared<const BreakableDesc>(desc), nullptr, {}, 0});
    Live piece{.object = id, .solid = std::move(whole), .seed = seed_of(desc.pattern.seed, id.value),
               .born = world.steps_taken()};
    const Motion motion{desc.motion.placement, desc.motion.placement, desc.motion.linear_velocity,
                        desc.motion.angular_velocity};
    const Result<PieceId> added = add_piece(world, std::move(piece), motion, glm::dvec3(0.0));
    if (!added) {
        objects_.erase(id);
        return added.error();
    }
    ++next_object_;
    return id;
}

Result<ObjectId> Destruction::add(World& world, const fracture::Fragments& fragments, const StructureDesc& structure,
                                  const BreakableDesc& pieces, std::span<const SolidPtr> solids) {
    std::vector<SolidPtr> own;
    if (solids.empty()) {
        Result<std::vector<SolidPtr>> made = solids_of(fragments, pieces.solid, false, pieces.solid.threads);
        if (!made) return made.error();
        solids = own = std::move(*made);
    }
    assert(solids.size() == fragments.pieces.size());
    StructureDesc desc = structure;
    if (desc.hulls.empty())
        for (const SolidPtr& solid : solids) desc.hulls.push_back(solid->parts[0].hull);
    Result<Structure> made = Structure::create(world, fragments, desc);
    if (!made) return made.error();
    const ObjectId id{next_object_++};
    Object& object = objects_[id];
    object.desc = std::make_shared<const BreakableDesc>(pieces);
    object.structure = std::make_unique<Structure>(std::move(*made));
    const uint64_t seed = seed_of(pieces.pattern.seed, id.value);
    for (uint32_t i = 0; i < fragments.pieces.size(); ++i)
        object.bonded.push_back(register_piece({.object = id,
                                                .solid = solids[i],
                                                .seed = seed_of(seed, i),
                                                .bonded = i,
                                                .born = world.steps_taken()}));
    return id;
}

void Destruction::remove(World& world, ObjectId id) {
    const auto object = objects_.find(id);
    if (object == objects_.end()) return;
    if (object->second.structure) object->second.structure->remove(world);
    for (const PieceId piece : pieces()) {
        const Live& live = pieces_.at(piece);
        if (live.object != id) continue;
        world.remove_body(live.own);
        forget_piece(piece);
    }
    objects_.erase(id);
}

BodyId Destruction::body_of(const Live& piece) const {
    return piece.bonded == none ? piece.own : objects_.at(piece.object).structure->body_of(piece.bonded);
}

// Of the body that the piece is in: of the piece itself where it is alone in it.
std::optional<Destruction::Motion> Destruction::motion_of(const World& world, const Live& piece) const {
    const BodyId body = body_of(piece);
    if (!world.contains(body)) return std::nullopt;
    return Motion{world.pose(body), world.previous_pose(body), world.linear_velocity(body), world.angular_velocity(body)};
}

std::optional<Pose> Destruction::pose_of(const World& world, const Live& piece, float alpha) const {
    const BodyId body = body_of(piece);
    if (!world.contains(body)) return std::nullopt;
    Pose pose = world.pose(body);
    if (alpha < 1.0f && world.last_moved_step(body) == world.steps_taken()) {
        const Pose before = world.previous_pose(body);
        pose = {glm::mix(before.position, pose.position, alpha), glm::slerp(before.orientation, pose.orientation, alpha)};
    }
    if (piece.bonded == none) return pose;
    return moved(pose, glm::dvec3(objects_.at(piece.object).structure->offset(piece.bonded)));
}

// The motion is of the point `from`, in the coordinates of the object.
Result<PieceId> Destruction::add_piece(World& world, Live piece, const Motion& motion, const glm::dvec3& from) {
    const BreakableDesc& desc = desc_of(piece);
    const SolidPiece& solid = *piece.solid;
    const glm::dvec3 arm = solid.mass.centre_of_mass - from;
    BodyDesc body;
    if (solid.parts.size() == 1 && solid.parts[0].offset == glm::vec3(0.0f))
        body.hull = *solid.parts[0].hull;
    else
        body.parts = solid.parts;
    body.fixed = solid.anchored;
    body.mass = static_cast<float>(solid.body.mass);
    body.inertia = glm::mat3(solid.body.inertia);
    body.pose = moved(motion.pose, arm);
    body.previous = moved(motion.previous, arm);
    body.linear_velocity = glm::vec3(glm::dvec3(motion.linear)
                                     + glm::cross(glm::dvec3(motion.angular), turned(motion.pose, arm)));
    body.angular_velocity = motion.angular;
    body.friction = desc.solid.material.friction;
    body.restitution = desc.solid.material.restitution;
    const Result<BodyId> added = world.add_body(body);
    if (!added) return added.error();
    piece.own = *added;
    const PieceId id = register_piece(std::move(piece));
    piece_of_body_[added->value] = id;
    return id;
}

PieceId Destruction::register_piece(Live piece) {
    const PieceId id{next_piece_++};
    if (free_slots_.empty())
        piece.slot = slot_count_++;
    else
        piece.slot = free_slots_.extract(free_slots_.begin()).value();
    ++objects_.at(piece.object).pieces;
    added_[id] = {id, piece.object, piece.slot, piece.depth, piece.solid, piece.of};
    pieces_.emplace(id, std::move(piece));
    return id;
}

// Its body is gone already, or goes with its structure.
void Destruction::forget_piece(PieceId id) {
    const auto at = pieces_.find(id);
    const Live& piece = at->second;
    if (piece.job != none) {
        background_.cancel(piece.job);
        jobs_.erase(piece.job);
    }
    if (piece.bonded == none) piece_of_body_.erase(piece.own.value);
    free_slots_.insert(piece.slot);
    --objects_.at(piece.object).pieces;
    fading_.erase(id);
    if (added_.erase(id) == 0) removed_[id] = {id, piece.slot};
    pieces_.erase(at);
}

// Bodies that someone else took out of the world.
void Destruction::remove_lost(const World& world) {
    std::vector<PieceId> lost;
    for (const auto& [id, piece] : pieces_)
        if (!world.contains(body_of(piece))) lost.push_back(id);
    for (const PieceId id : lost) forget_piece(id);
}

void Destruction::update(World& world, double budget) {
    commits_.clear();
    remove_lost(world);
    if (world.steps_taken() != steps_seen_) take_up_blows(world);
    steps_seen_ = world.steps_taken();
    update_structures(world);
    commit_due(world, budget);
    update_debris(world);
    std::erase_if(objects_, [](const auto& entry) { return entry.second.pieces == 0; });
}

void Destruction::take_up_blows(World& world) {
    float least = std::numeric_limits<float>::infinity();
    for (const auto& [id, object] : objects_) least = std::min(least, object.desc->impact_speed);
    const auto ours = [&](BodyId body) { return piece_of_body_.contains(body.value); };
    for (const BodyBlow& blow : find_blows(world.contacts(), least, ours)) {
        const auto at = piece_of_body_.find(blow.body.value);
        if (at == piece_of_body_.end() || !world.contains(blow.body)) continue;
        const PieceId id = at->second;
        const Live& piece = pieces_.at(id);
        if (2.0f * blow.energy <= desc_of(piece).impact_speed * blow.impulse) continue;
        const Pose pose = world.pose(blow.body);
        Hit hit{{turned_back(pose, blow.point - pose.position) + piece.solid->mass.centre_of_mass,
                 turned_back(pose, blow.normal), blow.energy},
                blow.sharp,
                blow.other,
                {}};
        const bool breaks = hit.sharp > piece.solid->bearable && piece.solid->breakable && piece.job == none;
        if (breaks) take_back_bounce(world, blow.body, blow, hit);
        hit_piece(world, id, hit);
    }
}

void Destruction::update_structures(World& world) {
    for (auto& [id, object] : objects_) {
        if (!object.structure) continue;
        for (const Impact& impact : object.structure->update(world).impacts) {
            const PieceId piece = object.bonded[impact.piece];
            const auto at = pieces_.find(piece);
            if (at == pieces_.end() || !world.contains(body_of(at->second))) continue;
            const Pose pose = *pose_of(world, at->second, 1.0f);
            const Hit hit{{turned_back(pose, impact.point - pose.position) + at->second.solid->mass.centre_of_mass,
                           turned_back(pose, impact.normal), impact.energy},
                          static_cast<double>(impact.impulse * impact.sharpness),
                          impact.other,
                          {}};
            hit_piece(world, piece, hit);
            if (pieces_.at(piece).job != none) object.structure->isolate(impact.piece);
        }
    }
}

bool Destruction::strike(const World& world, PieceId id, const glm::vec3& point, const glm::vec3& normal, double energy) {
    const auto at = pieces_.find(id);
    if (at == pieces_.end() || !finite(point) || !finite(normal) || !(glm::length(normal) > 0.0f)) return false;
    const std::optional<Pose> pose = pose_of(world, at->second, 1.0f);
    if (!pose || !(energy > 0.0) || !std::isfinite(energy)) return false;
    Hit hit;
    hit.blow = {turned_back(*pose, point - pose->position) + at->second.solid->mass.centre_of_mass,
                turned_back(*pose, glm::normalize(normal)), energy};
    hit.sharp = std::numeric_limits<double>::infinity();
    hit_piece(world, id, hit);
    if (at->second.bonded != none && at->second.job != none)
        objects_.at(at->second.object).structure->isolate(at->second.bonded);
    return at->second.job != none;
}

// Begins a job, or lays the blow by for when the one that runs is done.
void Destruction::hit_piece(const World& world, PieceId id, const Hit& hit) {
    Live& piece = pieces_.at(id);
    if (!(hit.sharp > piece.solid->bearable)) return;
    if (piece.job == none) {
        start_job(world, id, hit);
        return;
    }
    if (!piece.waiting) {
        piece.waiting = hit;
        return;
    }
    const double energy = piece.waiting->blow.energy + hit.blow.energy;
    if (hit.blow.energy > piece.waiting->blow.energy) piece.waiting = hit;
    piece.waiting->blow.energy = energy;
    piece.waiting->owed = glm::vec3(0.0f);
}

void Destruction::start_job(const World& world, PieceId id, const Hit& hit) {
    Live& piece = pieces_.at(id);
    if (!piece.solid->breakable || piece.unbreakable || piece.fading > 0) return;
    const std::shared_ptr<const BreakableDesc> desc = objects_.at(piece.object).desc;
    const double least = desc->solid.min_size * desc->solid.min_size * desc->solid.min_size;
    const Damage damage = damage_of(hit.blow, desc->solid.material, piece.solid->mass.volume, {desc->most_pieces, least});
    if (damage.pieces == 0) return;
    ImpactPattern pattern = desc->pattern;
    pattern.seed = piece.seed;
    piece.job = next_job_++;
    jobs_[piece.job] = {id, world.steps_taken() + std::max(settings_.latency, 1u), hit};
    ++statistics_.blows;
    background_.start(piece.job, [=, solid = piece.solid, blow = hit.blow](const std::atomic<bool>& cancelled) {
        Broken broken;
        Blow on_surface = blow;
        on_surface.point = nearest_on(solid->mesh, blow.point);
        const ImpactSites cut = impact_sites(solid->mesh, solid->mass, on_surface, damage, pattern);
        Result<std::vector<SolidPtr>> pieces = break_solid(*solid, cut.sites, cut.groups, desc->solid,
                                                           [&] { return cancelled.load(); });
        if (pieces)
            broken.pieces = std::move(*pieces);
        else
            broken.failure = pieces.error().message;
        return broken;
    });
}

// What hit the piece comes to rest at it until the pieces are there: half a bounce off a pane that then has a hole would
// be seen, as would something that falls into it. What the contact stopped is owed to both.
void Destruction::take_back_bounce(World& world, BodyId own, const BodyBlow& blow, Hit& hit) const {
    if (!world.contains(blow.other) || world.fixed(blow.other)) return;
    const float apart = speed_at(world, own, blow.point, blow.normal) - speed_at(world, blow.other, blow.point, blow.normal);
    const float response =
        response_at(world, own, blow.point, blow.normal) + response_at(world, blow.other, blow.point, blow.normal);
    if (!(response > 0.0f)) return;
    const float bounce = std::clamp(apart / response, 0.0f, blow.impulse);
    push(world, own, -bounce * blow.normal, blow.point);
    push(world, blow.other, bounce * blow.normal, blow.point);
    hit.owed = (blow.impulse - bounce) * blow.normal;
    const Pose other = world.pose(blow.other);
    hit.on_striker = turned_back(other, blow.point - other.position);
}

void Destruction::commit_due(World& world, double budget) {
    using Clock = std::chrono::steady_clock;
    const auto seconds_since = [](Clock::time_point start) {
        return std::chrono::duration<double>(Clock::now() - start).count();
    };
    const uint64_t now = world.steps_taken();
    const auto note = [&](uint32_t job) {
        if (commit(world, job)) commits_.push_back({now, job});
    };
    if (settings_.timing == Timing::scripted) {
        while (script_at_ < script_.size() && script_[script_at_].step <= now) {
            const uint32_t job = script_[script_at_++].job;
            if (jobs_.contains(job)) note(job);
        }
        return;
    }
    std::vector<uint32_t> due; // jobs that the commits begin are not
    for (const auto& [id, job] : jobs_)
        if (settings_.timing == Timing::when_ready ? background_.ready(id) : job.due <= now) due.push_back(id);
    if (settings_.timing == Timing::fixed_latency) {
        const size_t most = settings_.commits_a_step == 0 ? due.size() : settings_.commits_a_step;
        for (size_t i = 0; i < std::min(due.size(), most); ++i)
            if (jobs_.contains(due[i])) note(due[i]);
        return;
    }
    const Clock::time_point start = Clock::now();
    double longest = 0.0;
    for (const uint32_t job : due) {
        if (seconds_since(start) + longest > budget && job != due.front()) break;
        if (!jobs_.contains(job)) continue;
        const Clock::time_point begin = Clock::now();
        note(job);
        longest = std::max(longest, seconds_since(begin));
    }
    statistics_.longest_commit = std::max(statistics_.longest_commit, longest);
}

// A piece of a structure that is still held to others: its structure lets go of it with the next update.
bool Destruction::is_held(const Live& piece) const {
    if (piece.bonded == none) return false;
    const BodyId body = body_of(piece);
    return std::ranges::count_if(objects_.at(piece.object).bonded, [&](PieceId other) {
               const auto at = pieces_.find(other);
               return at != pieces_.end() && body_of(at->second) == body;
           }) > 1;
}

// False where it must wait.
bool Destruction::commit(World& world, uint32_t number) {
    Job job = jobs_.at(number);
    Live& piece = pieces_.at(job.piece);
    if (is_held(piece)) return false;
    const Broken broken = background_.take(number);
    jobs_.erase(number);
    piece.job = none;
    const std::optional<Hit> waiting = std::exchange(piece.waiting, std::nullopt);
    ++statistics_.commits;
    if (!broken.failure.empty()) {
        ++statistics_.failed;
        statistics_.last_failure = broken.failure;
        piece.unbreakable = true;
    } else if (broken.pieces.size() < 2) {
        ++statistics_.withstood;
        if (waiting) start_job(world, job.piece, *waiting);
    } else {
        exchange(world, piece, broken, job.hit);
        const std::vector<PieceId> made = replace(world, job.piece, broken);
        if (const PieceId hit = nearest_of(made, job.hit.blow.point); hit != PieceId{})
            solve_anew(world, pieces_.at(hit), job.hit);
        if (!waiting) return true;
        const PieceId next = nearest_of(made, waiting->blow.point);
        if (next != PieceId{} && waiting->sharp > pieces_.at(next).solid->bearable) start_job(world, next, *waiting);
    }
    return true;
}

// Takes a piece's body out and puts what it broke into in, with its motion.
std::vector<PieceId> Destruction::replace(World& world, PieceId old, const Broken& broken) {
    const Live parent = pieces_.at(old);
    const Motion motion = *motion_of(world, parent);
    Object& object = objects_.at(parent.object);
    if (parent.bonded != none)
        object.structure->take_piece(world, parent.bonded);
    else
        world.remove_body(parent.own);
    forget_piece(old);
    std::vector<PieceId> made;
    for (size_t i = 0; i < broken.pieces.size(); ++i) {
        const Result<PieceId> added = add_piece(world,
                                                {.object = parent.object,
                                                 .solid = broken.pieces[i],
                                                 .depth = parent.depth + 1,
                                                 .of = old,
                                                 .seed = seed_of(parent.seed, i),
                                                 .born = world.steps_taken()},
                                                motion, parent.solid->mass.centre_of_mass);
        if (added)
            made.push_back(*added);
        else // a speck whose mass single precision cannot hold
            statistics_.last_failure = added.error().message;
    }
    return made;
}

PieceId Destruction::nearest_of(std::span<const PieceId> made, const glm::dvec3& point) const {
    PieceId nearest;
    double least = std::numeric_limits<double>::infinity();
    for (const PieceId id : made)
        if (const double d = distance_to(*pieces_.at(id).solid, point); d < least) {
            least = d;
            nearest = id;
        }
    return nearest;
}

// Gives back what is owed, less what the cracks took: f of an impulse brings back f^2 of the energy. It goes through the
// point of what hit, which may have slid since: a ball off whose middle it went would be left spinning. Where the two have
// gone other ways and it would bring more energy than was lost, so much less of it.
void Destruction::exchange(World& world, const Live& piece, const Broken& broken, Hit& hit) const {
    const BodyId own = body_of(piece);
    if (!world.contains(hit.striker) || !world.contains(own)) hit.owed = glm::vec3(0.0f);
    double surface = -piece.solid->mass.area;
    for (const SolidPtr& made : broken.pieces) surface += made->mass.area;
    const double cracks = 0.5 * std::max(surface, 0.0) * static_cast<double>(desc_of(piece).solid.material.fracture_energy);
    hit.owed *= static_cast<float>(std::sqrt(std::max(0.0, 1.0 - cracks / hit.blow.energy)));
    const float along = glm::length(hit.owed);
    if (!(along > 0.0f)) return;
    const glm::vec3 normal = hit.owed / along;
    const glm::vec3 point = moved(world.pose(hit.striker), hit.on_striker).position;
    // s of it brings  linear s + quadratic s^2  of energy.
    const double linear = static_cast<double>(
        along * (speed_at(world, hit.striker, point, normal) - speed_at(world, own, point, normal)));
    const double response = static_cast<double>(response_at(world, hit.striker, point, normal)
                                                + response_at(world, own, point, normal));
    const double quadratic = 0.5 * response * static_cast<double>(along) * static_cast<double>(along);
    if (linear + quadratic > hit.blow.energy && quadratic > 0.0) {
        const double root = std::sqrt(linear * linear + 4.0 * quadratic * hit.blow.energy);
        hit.owed *= static_cast<float>(std::clamp((root - linear) / (2.0 * quadratic), 0.0, 1.0));
    }
    push(world, own, -hit.owed, point);
    push(world, hit.striker, hit.owed, point);
}

// A dead blow between what hit and the piece that is there now.
void Destruction::solve_anew(World& world, const Live& piece, const Hit& hit) {
    const float most = glm::length(hit.owed);
    if (!(most > 0.0f) || !world.contains(hit.striker)) return;
    const glm::vec3 normal = hit.owed / most;
    const glm::vec3 point = moved(world.pose(piece.own), hit.blow.point - piece.solid->mass.centre_of_mass).position;
    const float approach = speed_at(world, hit.striker, point, normal) - speed_at(world, piece.own, point, normal);
    const float response = response_at(world, piece.own, point, normal) + response_at(world, hit.striker, point, normal);
    if (!(response > 0.0f)) return;
    const float impulse = std::clamp(approach / response, 0.0f, most);
    push(world, piece.own, impulse * normal, point);
    push(world, hit.striker, -impulse * normal, point);
}

void Destruction::update_debris(World& world) {
    const double step = world.settings().step;
    std::vector<PieceId> gone;
    std::vector<Debris> candidates;
    size_t count = 0, vertices = 0;
    for (auto& [id, piece] : pieces_) {
        if (piece.fading > 0) {
            const auto all = static_cast<float>(steps_of(settings_.debris.fade_seconds, world));
            if (--piece.fading == 0)
                gone.push_back(id);
            else
                fading_[id] = {id, piece.slot, static_cast<float>(piece.fading) / all};
            continue;
        }
        ++count;
        vertices += piece.solid->positions.size();
        const BodyId body = body_of(piece);
        if (piece.depth == 0 || piece.bonded != none || piece.job != none || !world.contains(body) || world.fixed(body))
            continue;
        piece.slept = world.awake(body) ? 0 : piece.slept + 1;
        candidates.push_back({.id = id,
                              .volume = piece.solid->mass.volume,
                              .age = static_cast<double>(world.steps_taken() - piece.born) * step,
                              .slept = static_cast<double>(piece.slept) * step,
                              .vertices = piece.solid->positions.size(),
                              .visible = !visible_ || visible_(world.pose(body).position, piece.solid->radius)});
    }
    for (const PieceId id : retire_debris(candidates, count, vertices, settings_.debris)) {
        Live& piece = pieces_.at(id);
        ++statistics_.retired;
        const auto seen = std::ranges::lower_bound(candidates, id, {}, &Debris::id);
        if (seen->visible)
            piece.fading = steps_of(settings_.debris.fade_seconds, world);
        else
            gone.push_back(id);
    }
    for (const PieceId id : gone) {
        world.remove_body(pieces_.at(id).own);
        forget_piece(id);
    }
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
        visit(piece.slot, *pose_of(world, piece, alpha));
    }
}

size_t Destruction::write_poses(const World& world, std::span<Pose> out, float alpha) const {
    visit_poses(world, alpha, 0, [&](uint32_t slot, const Pose& pose) {
        if (slot < out.size()) out[slot] = pose;
    });
    return slot_count_;
}

Structure* Destruction::structure(ObjectId object) {
    const auto at = objects_.find(object);
    return at == objects_.end() ? nullptr : at->second.structure.get();
}

const Structure* Destruction::structure(ObjectId object) const {
    const auto at = objects_.find(object);
    return at == objects_.end() ? nullptr : at->second.structure.get();
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

} // namespace brittle::physics

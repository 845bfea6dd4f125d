// What a job has made takes the place of what was broken.
#include "physics/cutting/destruction.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include <glm/geometric.hpp>

#include "fracture/mesh/nearest.h"
#include "physics/cutting/destruction_seeds.h"
#include "physics/world/body_motion.h"
#include "physics/world/crowd.h"

namespace brittle::physics {

namespace {

// From a point in the coordinates of the object to the nearest of the solid's hulls, m; inside of one, 0 or less.
double distance_to(const SolidPiece& solid, const glm::dvec3& point) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const BodyPart& part : solid.parts) {
        const glm::dvec3 local = point - solid.mass.centre_of_mass - glm::dvec3(part.offset);
        nearest = std::min(nearest, fracture::distance_to_hull(part.hull->points, local)
                                        - static_cast<double>(part.hull->margin));
    }
    return nearest;
}

} // namespace

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
    return piece.bonded != none && objects_.at(piece.object).structure->together_with(piece.bonded).size() > 1;
}

// False where it must wait.
bool Destruction::commit(World& world, uint32_t number) {
    Job job = jobs_.at(number);
    Live& piece = pieces_.at(job.piece);
    if (is_held(piece)) return false;
    Broken broken = background_.take(number);
    jobs_.erase(number);
    piece.job = none;
    std::optional<Hit> waiting = std::exchange(piece.waiting, std::nullopt);
    ++statistics_.commits;
    if (job.parts && broken.pieces.size() > 1) ++statistics_.overloads;
    if (!broken.failure.empty()) {
        ++statistics_.failed;
        statistics_.last_failure = broken.failure;
        piece.unbreakable = true;
    } else if (broken.pieces.size() < 2) {
        if (!job.parts) ++statistics_.withstood;
        if (waiting) start_job(world, job.piece, *waiting);
        if (piece.job == none && (waiting || !job.parts)) {
            const bool later = waiting && (job.parts || waiting->blow.energy > job.hit.blow.energy);
            knock(world, job.piece, later ? *waiting : job.hit);
        }
    } else {
        ++statistics_.breaks;
        exchange(world, piece, crack_energy(piece, broken), job.hit);
        if (waiting) exchange(world, piece, 0.0, *waiting);
        const std::vector<PieceId> made = replace(world, job.piece, broken);
        solve_anew(world, made, job.hit);
        if (!waiting) return true;
        const PieceId next = solve_anew(world, made, *waiting);
        if (next != PieceId{} && waiting->sharp > pieces_.at(next).solid->bearable) start_job(world, next, *waiting);
    }
    return true;
}

// Takes a piece's body out and puts what it broke into in, with its motion.
std::vector<PieceId> Destruction::replace(World& world, PieceId old, Broken& broken) {
    Live parent = pieces_.at(old);
    const Motion motion = *motion_of(world, parent);
    const bool was_debris = world.debris(body_of(parent));
    Object& object = objects_.at(parent.object);
    if (parent.bonded != none)
        object.structure->take_piece(world, parent.bonded);
    else
        world.remove_body(parent.own);
    forget_piece(old);
    std::vector<Newcomer> batch;
    for (const Made& piece : broken.pieces)
        batch.push_back({.size = piece.solid->mass.volume, .fixed = piece.solid->anchored});
    const std::vector<uint8_t> debris = crowded_out(batch, room_in(world), was_debris);
    std::vector<PieceId> made;
    for (size_t i = 0; i < broken.pieces.size(); ++i) {
        Made& piece = broken.pieces[i];
        const Result<PieceId> added =
            add_piece(world,
                      {.object = parent.object,
                       .solid = std::move(piece.solid),
                       .depth = parent.depth + 1,
                       .of = old,
                       .seed = seed_of(parent.seed, i),
                       .born = world.steps_taken()},
                      std::move(piece.payload), motion, parent.solid->mass.centre_of_mass, debris[i], piece.form);
        if (added)
            made.push_back(*added);
        else // a speck whose mass single precision cannot hold
            statistics_.last_failure = added.error().message;
    }
    let_go(std::move(parent.solid)); // again: what forget_piece() handed over may be gone
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

// J, of both sides of the cracks half each.
double Destruction::crack_energy(const Live& piece, const Broken& broken) const {
    double surface = -piece.solid->mass.area;
    for (const Made& made : broken.pieces) surface += made.solid->mass.area;
    return 0.5 * std::max(surface, 0.0) * static_cast<double>(desc_of(piece).solid.material.fracture_energy);
}

// Gives back what is owed, less what the cracks took: f of an impulse brings back f^2 of the energy. It goes through the
// point of what hit, which may have slid since: a ball off whose middle it went would be left spinning. Where the two have
// gone other ways and it would bring more energy than was lost, so much less of it. Of a held piece, what the world had
// got comes back, and its friction with it.
void Destruction::exchange(World& world, const Live& piece, double cracks, Hit& hit) const {
    const BodyId own = body_of(piece);
    if (!world.contains(hit.striker) || !world.contains(own)) hit.owed = glm::vec3(0.0f);
    if (!(glm::length(hit.owed) > 0.0f)) return;
    const auto scale = [&](double part) {
        hit.owed *= static_cast<float>(part);
        hit.rubbed *= static_cast<float>(part);
    };
    scale(std::sqrt(std::max(0.0, 1.0 - cracks / hit.blow.energy)));
    const float along = glm::length(hit.owed + hit.rubbed);
    if (!(along > 0.0f)) return;
    const glm::vec3 normal = (hit.owed + hit.rubbed) / along;
    const glm::vec3 point = world.pose(hit.striker).position + hit.arm;
    // s of it brings  linear s + quadratic s^2  of energy.
    const double linear = static_cast<double>(
        along * (speed_at(world, hit.striker, point, normal) - speed_at(world, own, point, normal)));
    const double response =
        static_cast<double>(response_at(world, hit.striker, point, normal) + response_at(world, own, point, normal));
    const double quadratic = 0.5 * response * static_cast<double>(along) * static_cast<double>(along);
    if (linear + quadratic > hit.lost && quadratic > 0.0) {
        const double root = std::sqrt(linear * linear + 4.0 * quadratic * hit.lost);
        scale(std::clamp((root - linear) / (2.0 * quadratic), 0.0, 1.0));
    }
    push(world, own, -hit.owed - hit.rubbed, point);
    push(world, hit.striker, hit.owed + hit.rubbed, point);
}

// A dead blow between what hit and the piece that is there now, which is returned, and where the old one was held its friction;
// what is owed, and was lost, is then of that.
PieceId Destruction::solve_anew(World& world, std::span<const PieceId> made, Hit& hit) const {
    const PieceId id = nearest_of(made, hit.blow.point);
    const float most = glm::length(hit.owed);
    if (id == PieceId{} || !(most > 0.0f)) return id;
    const glm::vec3 point = world.pose(hit.striker).position + hit.arm;
    const BodyId own = pieces_.at(id).own;
    double lost = 0.0;
    const auto stop = [&](const glm::vec3& direction, float max_impulse) {
        const float approach = speed_at(world, hit.striker, point, direction) - speed_at(world, own, point, direction);
        const float response =
            response_at(world, own, point, direction) + response_at(world, hit.striker, point, direction);
        const float impulse = response > 0.0f ? std::clamp(approach / response, 0.0f, max_impulse) : 0.0f;
        push(world, own, impulse * direction, point);
        push(world, hit.striker, -impulse * direction, point);
        lost += static_cast<double>(impulse * (approach - 0.5f * response * impulse));
        return impulse;
    };
    const glm::vec3 normal = hit.owed / most;
    const float impulse = stop(normal, most), rubbing = glm::length(hit.rubbed);
    hit.owed = impulse * normal;
    if (rubbing > 0.0f) { // as much for what presses
        const glm::vec3 along = hit.rubbed / rubbing;
        hit.rubbed = stop(along, rubbing * (impulse / most)) * along;
    }
    hit.lost = std::min(hit.lost, lost);
    return id;
}

} // namespace brittle::physics

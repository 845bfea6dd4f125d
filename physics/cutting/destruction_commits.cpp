// Commits of a Destruction: the pieces that a job has made replace the piece that broke.
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

// Distance, m, from a point in the coordinates of the object to the nearest of the solid's hulls; 0 or less inside one.
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
        commit(world, job);
        commits_.push_back({now, job});
    };
    if (settings_.timing == Timing::scripted) {
        while (script_at_ < script_.size() && script_[script_at_].step <= now) {
            const uint32_t job = script_[script_at_++].job;
            if (jobs_.contains(job)) note(job);
        }
        return;
    }
    std::vector<uint32_t> due; // without jobs that these commits start
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

// True for a piece whose structure bonds it to others.
bool Destruction::has_bonds(const Live& piece) const {
    return piece.bonded != none && structure_of(piece).pieces_of_body(piece.bonded).size() > 1;
}

void Destruction::commit(World& world, uint32_t number) {
    Job job = jobs_.at(number);
    Live& piece = pieces_.at(job.piece);
    Broken broken = background_.take(number);
    jobs_.erase(number);
    piece.job = none;
    std::optional<Hit> waiting = std::exchange(piece.waiting, std::nullopt);
    ++statistics_.commits;
    if (job.along_blocks && !broken.chip && broken.pieces.size() > 1) ++statistics_.overloads;
    if (!broken.failure.empty()) {
        ++statistics_.failed;
        statistics_.last_failure = broken.failure;
        piece.unbreakable = true;
    } else if (broken.pieces.size() < 2) {
        if (!job.along_blocks) {
            ++statistics_.withstood;
            note_borne(world, job.piece, job.hit);
        }
        if (waiting) start_job(world, job.piece, *waiting);
        if (piece.job == none && (waiting || !job.along_blocks)) {
            const bool later = waiting && (job.along_blocks || waiting->blow.energy > job.hit.blow.energy);
            break_elsewhere(world, job.piece, later ? *waiting : job.hit);
        }
    } else {
        ++statistics_.breaks;
        if (broken.chip) {
            ++statistics_.chips;
            job.hit.contact = {};
        }
        const BodyId whole = body_of(piece);
        restore(world, whole, crack_energy(piece, broken) / job.hit.blow.energy, job.hit.contact);
        if (waiting) restore(world, whole, 0.0, waiting->contact);
        const std::vector<PieceId> made =
            has_bonds(piece) ? divide(world, job.piece, broken) : replace(world, job.piece, broken);
        const auto solve_for_part = [&](Hit& hit) {
            const PieceId part = nearest_of(made, hit.blow.point);
            if (part != PieceId{}) solve_again(world, body_of(pieces_.at(part)), hit.contact);
            return part;
        };
        solve_for_part(job.hit);
        if (!waiting) return;
        const PieceId next = solve_for_part(*waiting);
        if (next != PieceId{}) start_job(world, next, *waiting);
    }
}

Destruction::Live Destruction::child_of(const Live& parent, PieceId id, size_t index, SolidPtr solid, uint64_t now) {
    return {.object = parent.object,
            .solid = std::move(solid),
            .depth = parent.depth + 1,
            .parent = id,
            .seed = seed_of(parent.seed, index),
            .born = now};
}

// Replaces a piece that is bonded to others by the pieces it broke into, in its structure. None where that fails.
std::vector<PieceId> Destruction::divide(World& world, PieceId old, Broken& broken) {
    const Live parent = pieces_.at(old);
    SharedStructure& shared = *objects_.at(parent.object).bonds;
    const auto first = static_cast<uint32_t>(shared.structure->piece_count());
    std::vector<PieceId> made;
    if (!shared.structure->divide(world, parent.bonded, broken.parts)) {
        ++statistics_.failed;
        statistics_.last_failure = "a part of a bonded piece is too small for a body";
        pieces_.at(old).unbreakable = true;
        return made;
    }
    forget_piece(old);
    for (size_t i = 0; i < broken.pieces.size(); ++i) {
        Live child = child_of(parent, old, i, std::move(broken.pieces[i].solid), world.steps_taken());
        child.bonded = first + static_cast<uint32_t>(i);
        made.push_back(register_piece(std::move(child), std::move(broken.pieces[i].payload)));
    }
    shared.pieces.insert(shared.pieces.end(), made.begin(), made.end());
    return made;
}

// Replaces a piece by the pieces it broke into, which inherit its motion.
std::vector<PieceId> Destruction::replace(World& world, PieceId old, Broken& broken) {
    Live parent = pieces_.at(old);
    const Motion motion = *motion_of(world, parent);
    const bool was_debris = world.debris(body_of(parent));
    const std::vector<LooseJoint> joints = world.take_joints(body_of(parent));
    if (parent.bonded != none)
        structure_of(parent).take_piece(world, parent.bonded);
    else
        world.remove_body(parent.own);
    forget_piece(old);
    std::vector<BatchBody> batch;
    for (const Made& piece : broken.pieces)
        batch.push_back({.size = piece.solid->mass.volume, .fixed = piece.solid->anchored});
    const std::vector<uint8_t> debris = choose_debris(batch, colliding_room(world), was_debris);
    std::vector<PieceId> made;
    for (size_t i = 0; i < broken.pieces.size(); ++i) {
        Made& piece = broken.pieces[i];
        const Result<PieceId> added =
            add_piece(world, child_of(parent, old, i, std::move(piece.solid), world.steps_taken()),
                      std::move(piece.payload), motion, parent.solid->mass.centre_of_mass, debris[i], piece.form);
        if (added)
            made.push_back(*added);
        else // a speck whose mass underflows single precision
            statistics_.last_failure = added.error().message;
    }
    for (const LooseJoint& joint : joints) {
        const PieceId holder = nearest_of(made, parent.solid->mass.centre_of_mass
                                                    + to_body_axes(motion.pose, joint.anchor - motion.pose.position));
        if (holder != PieceId{}) world.put_joint(joint, pieces_.at(holder).own);
    }
    free_elsewhere(std::move(parent.solid)); // a second reference: the one that forget_piece() released may be gone
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

// J
double Destruction::crack_energy(const Live& piece, const Broken& broken) const {
    std::vector<SolidPtr> made;
    for (const Made& part : broken.pieces) made.push_back(part.solid);
    return new_surface(*piece.solid, made) * static_cast<double>(desc_of(piece).solid.material.fracture_energy);
}

} // namespace brittle::physics

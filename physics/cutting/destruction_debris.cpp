// Debris of a Destruction: its age, which of it is retired, and its fading.
#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "physics/cutting/destruction.h"

namespace brittle::physics {

namespace {

uint64_t steps_of(double seconds, const World& world) {
    const double steps = std::ceil(seconds / static_cast<double>(world.settings().step));
    return steps < 1.0 ? 1 : steps > 1e15 ? uint64_t{1'000'000'000'000'000} : static_cast<uint64_t>(steps);
}

} // namespace

// Evaluates visibility only where it decides which debris goes.
void Destruction::mark_visible(const World& world, std::span<Debris> candidates, size_t pieces, size_t vertices) const {
    if (!visible_) return;
    const DebrisLimits& limits = settings_.debris;
    const bool excess = pieces > limits.max_pieces || vertices > limits.max_vertices;
    for (Debris& debris : candidates)
        if (excess || debris.slept > limits.sleep_seconds)
            debris.visible = std::ranges::any_of(pieces_of_body(debris.id),
                                                 [&](PieceId id) { return is_seen(world, pieces_.at(id)); });
}

// Covers both last poses: a frame may show the piece anywhere between them.
bool Destruction::is_seen(const World& world, const Live& piece) const {
    const BodyId body = body_of(piece);
    const glm::vec3 at = in_body(piece, world.pose(body)).position;
    return visible_(at, piece.solid->radius + glm::distance(at, in_body(piece, world.previous_pose(body)).position));
}

// The piece and all pieces that are bonded to it, directly or not.
std::vector<PieceId> Destruction::pieces_of_body(PieceId id) const {
    const Live& piece = pieces_.at(id);
    if (piece.bonded == none) return {id};
    const SharedStructure& shared = *objects_.at(piece.object).bonds;
    std::vector<PieceId> pieces;
    for (const uint32_t other : shared.structure->pieces_of_body(piece.bonded)) pieces.push_back(shared.pieces[other]);
    return pieces;
}

bool Destruction::is_detached(const Live& piece) const {
    return piece.bonded == none ? piece.depth > 0 && !piece.solid->anchored
                                : structure_of(piece).is_detached(piece.bonded);
}

// The first piece of a bonded group stands for the group.
bool Destruction::is_debris(const Live& piece) const {
    if (!is_detached(piece) || piece.job != none || piece.fading > 0) return false;
    if (piece.bonded == none) return true;
    const SharedStructure& shared = *objects_.at(piece.object).bonds;
    const std::span<const uint32_t> together = shared.structure->pieces_of_body(piece.bonded);
    return together.front() == piece.bonded && std::ranges::all_of(together, [&](uint32_t other) {
               return pieces_.at(shared.pieces[other]).job == none;
           });
}

void Destruction::update_debris(World& world) {
    const double step = world.settings().step;
    const DebrisLimits& limits = settings_.debris;
    std::vector<PieceId> faded;
    size_t count = 0, vertices = 0;
    bool slept_too_long = false;
    for (auto& [id, piece] : pieces_) {
        if (piece.fading > 0) {
            const auto all = static_cast<float>(steps_of(limits.fade_seconds, world));
            if (--piece.fading == 0)
                faded.push_back(id);
            else
                fading_[id] = {id, piece.slot, static_cast<float>(piece.fading) / all};
            continue;
        }
        ++count;
        vertices += piece.solid->vertex_count();
        if (piece.bonded != none && !is_detached(piece)) piece.born = world.steps_taken();
        if (!is_debris(piece)) continue;
        piece.slept = world.awake(body_of(piece)) ? 0 : piece.slept + 1;
        slept_too_long = slept_too_long || static_cast<double>(piece.slept) * step > limits.sleep_seconds;
    }
    take_out(world, faded); // first, since a faded piece is no candidate
    if (slept_too_long || count > limits.max_pieces || vertices > limits.max_vertices)
        take_out(world, retire_debris(world, count, vertices));
}

void Destruction::take_out(World& world, std::span<const PieceId> gone) {
    for (const PieceId id : gone) {
        const Live& piece = pieces_.at(id);
        if (piece.bonded == none)
            world.remove_body(piece.own);
        else
            structure_of(piece).remove_body(world, piece.bonded);
        forget_piece(id);
    }
}

// Starts the fading of visible debris and returns the rest.
std::vector<PieceId> Destruction::retire_debris(const World& world, size_t count, size_t vertices) {
    const double step = world.settings().step;
    std::vector<Debris> candidates;
    for (const auto& [id, piece] : pieces_) {
        if (!is_debris(piece)) continue;
        Debris& debris = candidates.emplace_back(Debris{.id = id, .pieces = 0});
        debris.age = static_cast<double>(world.steps_taken() - piece.born) * step;
        debris.slept = static_cast<double>(piece.slept) * step;
        for (const PieceId part : pieces_of_body(id)) {
            const SolidPiece& solid = *pieces_.at(part).solid;
            ++debris.pieces;
            debris.volume += solid.mass.volume;
            debris.vertices += solid.vertex_count();
        }
    }
    mark_visible(world, candidates, count, vertices);
    std::vector<PieceId> gone;
    for (const PieceId id : physics::retire_debris(candidates, count, vertices, settings_.debris)) {
        const auto seen = std::ranges::lower_bound(candidates, id, {}, &Debris::id);
        for (const PieceId part : pieces_of_body(id)) {
            ++statistics_.retired;
            if (seen->visible)
                pieces_.at(part).fading = steps_of(settings_.debris.fade_seconds, world);
            else
                gone.push_back(part);
        }
    }
    return gone;
}

} // namespace brittle::physics

// What the session tells of the pieces on the stage, whole or cut anew.
#include <cmath>
#include <limits>
#include <numeric>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "tools/brittle/studio/session.h"

namespace brittle::tools {

namespace {

constexpr float far_away = 12.0f; // m from the middle, where the stage's shadow ends

} // namespace

std::vector<uint32_t> Session::piece_numbers() const {
    std::vector<uint32_t> numbers;
    if (const physics::Destruction* destruction = stage_->simulation().destruction()) {
        for (const physics::PieceId id : destruction->pieces()) numbers.push_back(id.value);
    } else {
        numbers.resize(fragments_->pieces.size());
        std::iota(numbers.begin(), numbers.end(), 0u);
    }
    return numbers;
}

bool Session::contains(uint32_t which) const {
    const physics::Destruction* destruction = stage_->simulation().destruction();
    return broken() && (destruction ? destruction->contains({which}) : which < fragments_->pieces.size());
}

const physics::SolidPiece* Session::solid_of(uint32_t of) const {
    const physics::Destruction* destruction = stage_->simulation().destruction();
    return destruction ? destruction->solid({of}).get() : nullptr;
}

uint32_t Session::slot_of(uint32_t of) const {
    const physics::Destruction* destruction = stage_->simulation().destruction();
    return destruction ? destruction->slot({of}) : of;
}

double Session::piece_volume(uint32_t of) const {
    const physics::SolidPiece* solid = solid_of(of);
    return solid ? solid->mass.volume : fragments_->pieces[of].mass.volume;
}

size_t Session::piece_triangles(uint32_t of) const {
    const physics::SolidPiece* solid = solid_of(of);
    return solid ? solid->mesh.triangles.size() : fragments_->pieces[of].triangles.size();
}

// In the piece's frame: around its centre of mass.
std::optional<double> Session::distance_to(uint32_t of, const glm::dvec3& from, const glm::dvec3& direction) const {
    if (const physics::SolidPiece* solid = solid_of(of)) {
        const std::vector<glm::dvec3> positions(solid->positions.begin(), solid->positions.end());
        return fracture::first_hit(positions, solid->mesh.triangles, from, direction);
    }
    const fracture::Piece& fragment = fragments_->pieces[of];
    return fracture::first_hit(fragments_->positions_of(fragment), fragments_->triangles_of(fragment),
                               from + fragment.mass.centre_of_mass, direction);
}

std::optional<PieceHit> Session::first_piece(const glm::dvec3& from, const glm::dvec3& direction) const {
    if (!broken()) return std::nullopt;
    std::optional<PieceHit> nearest;
    for (const uint32_t p : piece_numbers()) {
        const uint32_t slot = slot_of(p);
        if (slot >= poses_.size()) continue; // too new to have been drawn
        const physics::SolidPiece* solid = solid_of(p);
        const double radius = double{solid ? solid->radius : radii_[p]};
        const glm::dvec3 centre(poses_[slot].position), to = centre - from;
        const double along = glm::dot(to, direction);
        if (glm::dot(to, to) - along * along > radius * radius) continue;
        const glm::dquat back = glm::conjugate(glm::dquat(poses_[slot].rotation));
        const glm::dvec3 origin = back * (from - centre), way = back * direction;
        const std::optional<double> distance = distance_to(p, origin, way);
        if (!distance || (nearest && nearest->distance <= *distance)) continue;
        nearest = PieceHit{p, glm::vec3(from + *distance * direction), glm::vec3(origin + *distance * way), *distance};
    }
    return nearest;
}

engine::Bounds Session::piece_bounds(uint32_t of) const {
    const physics::SolidPiece* solid = solid_of(of);
    const glm::vec3 r(solid ? solid->radius : radii_[of]);
    const uint32_t slot = slot_of(of);
    if (slot >= poses_.size()) return stage_->home_bounds();
    return {poses_[slot].position - r, poses_[slot].position + r};
}

engine::Bounds Session::all_bounds() const {
    engine::Bounds all{glm::vec3(far_away), glm::vec3(-far_away)};
    for (const uint32_t p : broken() ? piece_numbers() : std::vector<uint32_t>{}) {
        const engine::Bounds bounds = piece_bounds(p);
        if (glm::length(bounds.centre()) < far_away) all = engine::join(all, bounds);
    }
    return all.min.x <= all.max.x ? all : stage_->home_bounds();
}

} // namespace brittle::tools

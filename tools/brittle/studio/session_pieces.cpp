// What the session tells of the pieces on the stage, whole or cut anew.
#include <glm/geometric.hpp>

#include "tools/brittle/studio/session.h"

namespace brittle::tools {

namespace {

constexpr float far_away = 12.0f; // m from the middle, where the stage's shadow ends

} // namespace

bool Session::contains(uint32_t which) const {
    return broken() && pieces().contains(which);
}

double Session::piece_volume(uint32_t of) const {
    return pieces().volume(of);
}

size_t Session::piece_triangles(uint32_t of) const {
    return pieces().triangles(of);
}

std::optional<PieceHit> Session::first_piece(const glm::dvec3& from, const glm::dvec3& direction) const {
    return broken() ? pieces().first(from, direction) : std::nullopt;
}

engine::Bounds Session::piece_bounds(uint32_t of) const {
    const glm::vec3 r(pieces().radius(of));
    const std::optional<engine::BodyPose> pose = pieces().pose(of);
    return pose ? engine::Bounds{pose->position - r, pose->position + r} : stage_->home_bounds();
}

engine::Bounds Session::all_bounds() const {
    engine::Bounds all{glm::vec3(far_away), glm::vec3(-far_away)};
    for (const uint32_t p : broken() ? pieces().numbers() : std::vector<uint32_t>{}) {
        const engine::Bounds bounds = piece_bounds(p);
        if (glm::length(bounds.centre()) < far_away) all = engine::join(all, bounds);
    }
    return all.min.x <= all.max.x ? all : stage_->home_bounds();
}

} // namespace brittle::tools

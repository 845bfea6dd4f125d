#include "tools/brittle/studio/piece_view.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "fracture/local/cluster_queries.h"
#include "fracture/mesh/triangle_tree.h"
#include "physics/cutting/impact_pattern.h"

namespace brittle::tools {

namespace {

constexpr double min_blow = 1.05; // factor on the impulse that a piece bears, so that it breaks

} // namespace

std::vector<uint32_t> PieceView::numbers() const {
    std::vector<uint32_t> all;
    if (const physics::Destruction* destruction = simulation.destruction()) {
        for (const physics::PieceId id : destruction->pieces()) all.push_back(id.value);
    } else {
        all.resize(fragments.pieces.size());
        std::iota(all.begin(), all.end(), 0u);
    }
    return all;
}

bool PieceView::contains(uint32_t piece) const {
    const physics::Destruction* destruction = simulation.destruction();
    return destruction ? destruction->contains({piece}) : piece < fragments.pieces.size();
}

const physics::SolidPiece* PieceView::solid(uint32_t piece) const {
    const physics::Destruction* destruction = simulation.destruction();
    return destruction ? destruction->solid({piece}).get() : nullptr;
}

std::optional<engine::BodyPose> PieceView::pose(uint32_t piece) const {
    const physics::Destruction* destruction = simulation.destruction();
    const uint32_t slot = destruction ? destruction->slot({piece}) : piece;
    return slot < poses.size() ? std::optional(poses[slot]) : std::nullopt;
}

double PieceView::volume(uint32_t piece) const {
    const physics::SolidPiece* own = solid(piece);
    return own ? own->mass.volume : fragments.pieces[piece].mass.volume;
}

size_t PieceView::triangles(uint32_t piece) const {
    const physics::SolidPiece* own = solid(piece);
    return own ? own->triangle_count() : fragments.pieces[piece].triangles.size();
}

float PieceView::radius(uint32_t piece) const {
    const physics::SolidPiece* own = solid(piece);
    return own ? own->radius : radii[piece];
}

std::optional<engine::Bounds> PieceView::bounds(uint32_t piece) const {
    const std::optional<engine::BodyPose> at = pose(piece);
    if (!at) return std::nullopt;
    const glm::vec3 r(radius(piece));
    return engine::Bounds{at->position - r, at->position + r};
}

// The ray is in the piece's frame, whose origin is the centre of mass.
std::optional<double> PieceView::distance_to(uint32_t piece, const glm::dvec3& from,
                                             const glm::dvec3& direction) const {
    if (const physics::SolidPiece* own = solid(piece)) {
        if (own->is_clustered()) {
            const glm::dvec3 start = own->mass.centre_of_mass + from;
            const double reach = glm::length(from) + double{own->radius};
            const std::optional<double> share = fracture::first_hit(own->clusters, start, start + reach * direction);
            return share ? std::optional(*share * reach) : std::nullopt;
        }
        const physics::SolidSurface& surface = own->surface();
        const std::vector<glm::dvec3> positions(surface.positions.begin(), surface.positions.end());
        return fracture::first_hit(positions, surface.mesh.triangles, from, direction);
    }
    const fracture::Piece& fragment = fragments.pieces[piece];
    return fracture::first_hit(fragments.positions_of(fragment), fragments.triangles_of(fragment),
                               from + fragment.mass.centre_of_mass, direction);
}

std::optional<PieceHit> PieceView::first(const glm::dvec3& from, const glm::dvec3& direction,
                                         const std::function<bool(uint32_t piece)>& skips) const {
    std::optional<PieceHit> nearest;
    for (const uint32_t piece : numbers()) {
        const std::optional<engine::BodyPose> at = pose(piece);
        if (!at) continue;
        const double reach = double{radius(piece)};
        const glm::dvec3 centre(at->position), to = centre - from;
        const double along = glm::dot(to, direction);
        if (glm::dot(to, to) - along * along > reach * reach) continue;
        const glm::dquat back = glm::conjugate(glm::dquat(at->rotation));
        const glm::dvec3 origin = back * (from - centre), way = back * direction;
        const std::optional<double> distance = distance_to(piece, origin, way);
        if (distance && skips && skips(piece)) continue;
        if (!distance || (nearest && nearest->distance <= *distance)) continue;
        nearest =
            PieceHit{piece, glm::vec3(from + *distance * direction), glm::vec3(origin + *distance * way), *distance};
    }
    return nearest;
}

std::vector<engine::BodyPose> poses_by_slot(const Simulation& simulation) {
    std::vector<engine::BodyPose> poses(simulation.destruction()->slot_count());
    simulation.visit_poses(1.0f, 0, [&](uint32_t slot, const physics::Pose& pose) {
        poses[slot] = {.rotation = pose.orientation, .position = pose.position};
    });
    return poses;
}

glm::dvec3 place_of(const Simulation& simulation, const PieceHit& hit) {
    if (simulation.body_of(hit.piece) == physics::BodyId{}) return glm::dvec3(hit.point);
    const physics::Pose pose = simulation.pose_of(hit.piece);
    return glm::dvec3(pose.position) + glm::dquat(pose.orientation) * glm::dvec3(hit.grip);
}

Hammer hammer_blow(const Simulation& simulation, const PieceHit& hit, const glm::dvec3& direction, double radius,
                   uint32_t max_pieces) {
    const physics::SolidPiece& solid = *simulation.destruction()->solid({hit.piece});
    const physics::MaterialPreset* preset = simulation.members()[simulation.member_of(hit.piece)].material;
    const double energy =
        physics::energy_of(radius, preset ? preset->material : physics::Material{}, solid.mass.volume, max_pieces);
    const double impulse = std::max(std::sqrt(2.0 * hammer_mass * energy),
                                    min_blow * solid.bearable * static_cast<double>(physics::impact_seconds));
    return {hit.piece, place_of(simulation, hit), impulse * direction};
}

} // namespace brittle::tools

#include "tools/brittle/stage/piece_drawing.h"

#include <algorithm>
#include <unordered_set>

#include "fracture/local/number_table.h"
#include "physics/cutting/solid_maker.h"
#include "tools/brittle/base/device_failure.h"
#include "tools/scenario/base/failure.h"

namespace brittle::tools {

namespace {

using fracture::Cluster;
using fracture::ClusterBranch;
using fracture::ClusterPtr;

// Triangles of a part. A blow replaces a few parts, so small ones save uploads; each costs a draw command a frame.
constexpr uint32_t max_part_triangles = 4096;

// The triangles of a branch, and the exterior ones around it.
class BranchMesh {
  public:
    BranchMesh(const fracture::ClusterMesh& mesh, const ClusterBranch& branch, const MeshLooks* looks) {
        fracture::ClusterSet own;
        std::vector<glm::uvec3> interior;
        branch.for_each([&](const ClusterPtr& cluster) {
            own.insert(cluster.get());
            for (size_t t = 0; t < cluster->triangles.size(); ++t) {
                const bool is_cut = physics::surface_tag::is_cut(cluster->tags[t]);
                (is_cut ? interior : triangles_).push_back(corners(*cluster, t));
                if (is_cut || !looks) continue;
                const auto& [a, b, c] = cluster->triangles[t];
                const auto& at = cluster->positions;
                for (const engine::CornerLook& look :
                     looks->corners(physics::surface_tag::number(cluster->tags[t]), {at[a], at[b], at[c]}))
                    looks_.push_back(look);
            }
        });
        exterior_ = static_cast<uint32_t>(triangles_.size());
        triangles_.insert(triangles_.end(), interior.begin(), interior.end());
        const uint32_t own_vertices = numbers_.size();
        mesh.visit(branch.box(), [&](const ClusterPtr& cluster) {
            if (!own.contains(cluster.get())) add_neighbours(*cluster, own_vertices);
        });
    }

    [[nodiscard]] engine::PieceMesh piece() const {
        return {.positions = positions_,
                .triangles = triangles_,
                .exterior_triangles = exterior_,
                .neighbours = neighbours_,
                .corners = looks_};
    }

  private:
    void add_neighbours(const Cluster& cluster, uint32_t own_vertices) {
        const auto is_own = [&](uint8_t v) { return numbers_.find(cluster.vertices[v]) < own_vertices; };
        for (size_t t = 0; t < cluster.triangles.size(); ++t)
            if (!physics::surface_tag::is_cut(cluster.tags[t]) && std::ranges::any_of(cluster.triangles[t], is_own))
                neighbours_.push_back(corners(cluster, t));
    }
    [[nodiscard]] glm::uvec3 corners(const Cluster& cluster, size_t triangle) {
        const auto& [a, b, c] = cluster.triangles[triangle];
        return {vertex(cluster, a), vertex(cluster, b), vertex(cluster, c)};
    }
    [[nodiscard]] uint32_t vertex(const Cluster& cluster, uint8_t v) {
        const uint32_t index = numbers_.add(cluster.vertices[v]);
        if (index == positions_.size()) positions_.emplace_back(cluster.positions[v]);
        return index;
    }

    fracture::NumberTable numbers_;
    std::vector<glm::vec3> positions_;
    std::vector<glm::uvec3> triangles_, neighbours_;
    std::vector<engine::CornerLook> looks_; // of the corners of exterior triangles
    uint32_t exterior_ = 0;
};

// A piece that never breaks has dropped its exact positions.
std::vector<engine::CornerLook> looks_of_surface(const physics::SolidPiece& solid, const MeshLooks& looks) {
    const physics::SolidSurface& surface = solid.surface();
    const auto at = [&](uint32_t v) { return glm::dvec3(surface.positions[v]) + solid.mass.centre_of_mass; };
    std::vector<engine::CornerLook> made;
    made.reserve(3 * size_t{surface.exterior_triangles});
    for (uint32_t t = 0; t < surface.exterior_triangles; ++t) {
        const fracture::Triangle& corner = surface.mesh.triangles[t];
        const auto looks_of_three = looks.corners(surface.source[t], {at(corner.x), at(corner.y), at(corner.z)});
        made.insert(made.end(), looks_of_three.begin(), looks_of_three.end());
    }
    return made;
}

// Collects points on the faces of a cut, spread evenly over their area: of each run of triangles of a certain area, the
// centroid of the last one.
class CrackPoints {
  public:
    explicit CrackPoints(const glm::dvec3& origin) : origin_(origin) {}

    void add(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
        const glm::vec3 twice(glm::cross(b - a, c - a));
        triangles_.push_back({glm::vec3((a + b + c) / 3.0 - origin_), twice, 0.5f * glm::length(twice)});
        area_ += triangles_.back().area;
    }

    [[nodiscard]] std::vector<CrackPoint> take() const {
        std::vector<CrackPoint> points;
        const float run = area_ / static_cast<float>(PieceDrawing::max_cracks);
        float sum = 0.0f;
        for (const CrackPoint& triangle : triangles_) {
            sum += triangle.area;
            if (triangle.area == 0.0f || sum < run || points.size() == PieceDrawing::max_cracks) continue;
            points.push_back({triangle.at, glm::normalize(triangle.normal), 0.5f * sum});
            sum = 0.0f;
        }
        return points;
    }

  private:
    glm::dvec3 origin_;
    std::vector<CrackPoint> triangles_; // with normals of any length
    float area_ = 0.0f;
};

std::vector<CrackPoint> cracks_of(const physics::SolidPiece& solid, const physics::SolidPiece& cut_from,
                                  std::span<const ClusterBranch> made) {
    CrackPoints points(solid.mass.centre_of_mass);
    if (!solid.is_clustered()) {
        const physics::SolidSurface& surface = solid.surface();
        const auto at = [&](uint32_t v) { return glm::dvec3(surface.positions[v]) + solid.mass.centre_of_mass; };
        for (size_t k = 0; k < surface.cut.size(); ++k) {
            if (surface.cut[k] < cut_from.cut_limit) continue;
            const fracture::Triangle& t = surface.mesh.triangles[surface.exterior_triangles + k];
            points.add(at(t.x), at(t.y), at(t.z));
        }
    }
    for (const ClusterBranch& branch : made) {
        branch.for_each([&](const ClusterPtr& cluster) {
            for (size_t t = 0; t < cluster->triangles.size(); ++t) {
                const uint32_t tag = cluster->tags[t];
                if (!physics::surface_tag::is_cut(tag) || physics::surface_tag::number(tag) < cut_from.cut_limit)
                    continue;
                const auto& [a, b, c] = cluster->triangles[t];
                points.add(cluster->positions[a], cluster->positions[b], cluster->positions[c]);
            }
        });
    }
    return points.take();
}

engine::PieceBatch draw_whole(const physics::SolidPiece& solid, const MeshLooks* looks) {
    const physics::SolidSurface& surface = solid.surface();
    const std::vector<engine::CornerLook> corners =
        looks ? looks_of_surface(solid, *looks) : std::vector<engine::CornerLook>();
    const engine::PieceMesh mesh{.positions = surface.positions,
                                 .triangles = surface.mesh.triangles,
                                 .exterior_triangles = surface.exterior_triangles,
                                 .corners = corners};
    return must(engine::PieceBatch::create({&mesh, 1}));
}

} // namespace

engine::PieceBatch draw_branches(const physics::SolidPiece& solid, std::span<const ClusterBranch> branches,
                                 const MeshLooks* looks) {
    if (looks && !looks->of_mesh) looks = nullptr;
    std::vector<BranchMesh> meshes;
    meshes.reserve(branches.size());
    std::vector<engine::PieceMesh> pieces;
    for (const ClusterBranch& branch : branches)
        pieces.push_back(meshes.emplace_back(solid.clusters, branch, looks).piece());
    return must(engine::PieceBatch::create(pieces));
}

std::unique_ptr<PieceDrawing> draw_piece(const physics::SolidPiece& solid, const physics::SolidPiece* cut_from,
                                         const MeshLooks* looks) {
    if (looks && !looks->of_mesh) looks = nullptr;
    auto drawing = std::make_unique<PieceDrawing>();
    if (solid.is_clustered()) {
        std::unordered_set<const void*> drawn;
        if (cut_from)
            for (const ClusterBranch& branch : cut_from->clusters.branches(max_part_triangles))
                drawn.insert(branch.key());
        for (const ClusterBranch& branch : solid.clusters.branches(max_part_triangles))
            (drawn.contains(branch.key()) ? drawing->kept : drawing->made).push_back(branch);
        drawing->batch = draw_branches(solid, drawing->made, looks);
    } else {
        drawing->batch = draw_whole(solid, looks);
    }
    if (cut_from) drawing->cracks = cracks_of(solid, *cut_from, drawing->made);
    return drawing;
}

engine::PieceAttachment attachment_of(const physics::SolidPiece& solid, uint32_t slot, const glm::vec3& tint,
                                      physics::PieceId id) {
    const glm::vec3 offset = solid.is_clustered() ? -glm::vec3(solid.mass.centre_of_mass) : glm::vec3(0.0f);
    return {.body = slot,
            .tint = tint,
            .offset = offset,
            .id = id.value + 1,
            .centre = glm::vec3(solid.mass.centre_of_mass)};
}

} // namespace brittle::tools

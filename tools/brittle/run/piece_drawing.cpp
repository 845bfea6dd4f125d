#include "tools/brittle/run/piece_drawing.h"

#include <algorithm>
#include <unordered_set>

#include "fracture/local/number_table.h"
#include "physics/cutting/solid_maker.h"
#include "tools/brittle/base/failure.h"

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
    BranchMesh(const fracture::ClusterMesh& mesh, const ClusterBranch& branch) {
        fracture::ClusterSet own;
        std::vector<glm::uvec3> interior;
        branch.for_each([&](const ClusterPtr& cluster) {
            own.insert(cluster.get());
            for (size_t t = 0; t < cluster->triangles.size(); ++t) {
                const bool is_cut = physics::surface_tag::is_cut(cluster->tags[t]);
                (is_cut ? interior : triangles_).push_back(corners(*cluster, t));
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
                .neighbours = neighbours_};
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
    uint32_t exterior_ = 0;
};

engine::PieceBatch draw_whole(const physics::SolidPiece& solid) {
    const physics::SolidSurface& surface = solid.surface();
    const engine::PieceMesh mesh{.positions = surface.positions,
                                 .triangles = surface.mesh.triangles,
                                 .exterior_triangles = surface.exterior_triangles};
    return must(engine::PieceBatch::create({&mesh, 1}));
}

} // namespace

engine::PieceBatch draw_branches(const physics::SolidPiece& solid, std::span<const ClusterBranch> branches) {
    std::vector<BranchMesh> meshes;
    meshes.reserve(branches.size());
    std::vector<engine::PieceMesh> pieces;
    for (const ClusterBranch& branch : branches) pieces.push_back(meshes.emplace_back(solid.clusters, branch).piece());
    return must(engine::PieceBatch::create(pieces));
}

std::unique_ptr<PieceDrawing> draw_piece(const physics::SolidPiece& solid, const physics::SolidPiece* cut_from) {
    auto drawing = std::make_unique<PieceDrawing>();
    if (solid.is_clustered()) {
        std::unordered_set<const void*> drawn;
        if (cut_from)
            for (const ClusterBranch& branch : cut_from->clusters.branches(max_part_triangles))
                drawn.insert(branch.key());
        for (const ClusterBranch& branch : solid.clusters.branches(max_part_triangles))
            (drawn.contains(branch.key()) ? drawing->kept : drawing->made).push_back(branch);
        drawing->batch = draw_branches(solid, drawing->made);
    } else {
        drawing->batch = draw_whole(solid);
    }
    return drawing;
}

engine::PieceAttachment attachment_of(const physics::SolidPiece& solid, uint32_t slot, const glm::vec3& tint,
                                      physics::PieceId id) {
    const glm::vec3 offset = solid.is_clustered() ? -glm::vec3(solid.mass.centre_of_mass) : glm::vec3(0.0f);
    return {.body = slot, .tint = tint, .offset = offset, .id = id.value + 1};
}

} // namespace brittle::tools

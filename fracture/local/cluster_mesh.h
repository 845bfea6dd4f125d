// A closed triangle mesh in clusters: runs of at most 128 neighbouring triangles, in a tree of boxes.
//
//     const ClusterMesh mesh(surface, tags, threads);
//     mesh.visit(box, [](const ClusterPtr& cluster) { ... });          // O(log n + clusters that meet the box)
//     const ClusterMesh changed = mesh.with(cluster_set, new_faces);   // shares all other clusters and nodes
//
// A ClusterMesh never changes. A changed one shares what stayed the same, so a small change of a large mesh is cheap in
// time and memory. Vertices have numbers that stay the same from change to change; clusters that meet name the same
// ones. Each triangle carries a tag, whose meaning is the caller's.
//
// Metres or any other unit. Copies are cheap; several threads may read one mesh. Equal input gives equal clusters on
// every machine, with any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <unordered_set>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/base/threads.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

struct Cluster {
    static constexpr uint32_t max_triangles = 128;

    Box box;
    std::vector<glm::dvec3> positions;
    std::vector<uint32_t> vertices;                // by position: the number of the vertex in the mesh
    std::vector<std::array<uint8_t, 3>> triangles; // indices into positions
    std::vector<uint32_t> tags;                    // by triangle
};

using ClusterPtr = std::shared_ptr<const Cluster>;
using ClusterSet = std::unordered_set<const Cluster*>;

// Triangles that are to become clusters.
struct FaceList {
    std::vector<Triangle> triangles; // indices into positions
    std::vector<glm::dvec3> positions;
    std::vector<uint32_t> vertices; // by position: the number in the mesh; empty: its index
    std::vector<uint32_t> tags;     // by triangle
};

// Returns whether two boxes have a point in common.
[[nodiscard]] inline bool overlap(const Box& a, const Box& b) {
    return a.min.x <= b.max.x && b.min.x <= a.max.x && a.min.y <= b.max.y && b.min.y <= a.max.y && a.min.z <= b.max.z
           && b.min.z <= a.max.z;
}

class ClusterBranch;

class ClusterMesh {
  public:
    ClusterMesh() = default; // no triangles
    // One tag a triangle. Vertex v of the mesh has the number v. Time O(n log n).
    ClusterMesh(const TriangleMesh& mesh, std::span<const uint32_t> tags, Threads& threads);

    [[nodiscard]] uint32_t triangle_count() const { return root_ ? root_->triangles : 0; }
    [[nodiscard]] uint32_t cluster_count() const { return root_ ? root_->clusters : 0; }
    // All numbers of vertices are less.
    [[nodiscard]] uint32_t vertex_limit() const { return vertex_limit_; }
    [[nodiscard]] Box box() const { return root_ ? root_->box : Box{}; } // of all triangles

    // Calls act(cluster) for each cluster whose box meets the given one, in a fixed order.
    template<class Act>
    void visit(const Box& box, Act&& act) const {
        visit_where([&](const Box& other) { return overlap(other, box); }, act);
    }
    template<class Act>
    void for_each(Act&& act) const {
        visit_where([](const Box&) { return true; }, act);
    }
    // Calls act(cluster) for each cluster for whose box, and for all boxes around it, may_matter(box) holds.
    template<class MayMatter, class Act>
    void visit_where(MayMatter&& may_matter, Act&& act) const {
        if (root_) visit(*root_, may_matter, act);
    }

    // Calls act(cluster) for clusters all over the mesh: at most twice so many as asked for, and no fewer unless the mesh
    // has fewer.
    template<class Act>
    void visit_some(uint32_t count, Act&& act) const {
        if (root_) visit_some(*root_, count, act);
    }

    // The largest branches of the tree with at most so many triangles each, or one cluster. Together they are the mesh.
    [[nodiscard]] std::vector<ClusterBranch> branches(uint32_t max_triangles) const;

    // This mesh without some of its clusters and with other triangles. Precondition: triangles that meet name the same
    // vertices.
    [[nodiscard]] ClusterMesh with(const ClusterSet& without, const FaceList& faces) const;

    // Returns whether all triangles hang together over common vertices. Linear in the number of triangles.
    [[nodiscard]] bool is_connected() const;
    // The parts that hang together, the one of the most triangles first; it shares its clusters with this mesh. Linear
    // in the number of triangles.
    [[nodiscard]] std::vector<ClusterMesh> parts() const;
    // The mesh with dense indices. Unless null, `tags` receives the tags of the triangles.
    [[nodiscard]] TriangleMesh flatten(std::vector<uint32_t>* tags = nullptr) const;

  private:
    friend ClusterBranch;
    struct Node;
    using NodePtr = std::shared_ptr<const Node>;
    struct Node {
        Box box;
        NodePtr low, high;  // null in a leaf
        ClusterPtr cluster; // of a leaf
        uint32_t triangles = 0;
        uint32_t clusters = 0;
    };

    template<class MayMatter, class Act>
    static void visit(const Node& node, MayMatter& may_matter, Act& act) {
        if (!may_matter(node.box)) return;
        if (node.cluster) {
            act(node.cluster);
            return;
        }
        visit(*node.low, may_matter, act);
        visit(*node.high, may_matter, act);
    }
    template<class Act>
    void visit_some(const Node& node, uint32_t count, Act& act) const {
        if (!node.cluster && uint64_t{node.clusters} * count > root_->clusters) {
            visit_some(*node.low, count, act);
            visit_some(*node.high, count, act);
            return;
        }
        const Node* some = &node;
        while (!some->cluster) some = some->low.get();
        act(some->cluster);
    }
    [[nodiscard]] std::vector<uint32_t> components() const;
    static void add_branches(const NodePtr& node, uint32_t max_triangles, std::vector<ClusterBranch>& branches);
    [[nodiscard]] static NodePtr leaf(ClusterPtr cluster);
    [[nodiscard]] static NodePtr above(NodePtr low, NodePtr high); // either may be null
    [[nodiscard]] static NodePtr tree_of(std::span<const ClusterPtr> clusters);
    [[nodiscard]] static NodePtr without(const NodePtr& node, const ClusterSet& clusters, const Box& box);
    [[nodiscard]] static NodePtr inserted(const NodePtr& node, const NodePtr& other);

    NodePtr root_;
    uint32_t vertex_limit_ = 0;
};

// Neighbouring clusters: a branch of the tree. A mesh and a changed one have those branches in common that the change
// did not touch.
class ClusterBranch {
  public:
    [[nodiscard]] uint32_t triangle_count() const { return node_->triangles; }
    [[nodiscard]] const Box& box() const { return node_->box; }
    template<class Act>
    void for_each(Act&& act) const { // act(cluster)
        const auto all = [](const Box&) { return true; };
        ClusterMesh::visit(*node_, all, act);
    }
    // Equal for equal branches, and for no others that exist at the same time.
    [[nodiscard]] const void* key() const { return node_.get(); }

  private:
    friend ClusterMesh;
    explicit ClusterBranch(ClusterMesh::NodePtr node) : node_(std::move(node)) {}

    ClusterMesh::NodePtr node_;
};

} // namespace brittle::fracture

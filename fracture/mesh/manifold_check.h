// A quick yes or no: is a triangle mesh closed, oriented and manifold? For meshes that nearly always are.
//
// It answers exactly as check_topology(...).manifold() does (topology.h), in a tenth of the time and on
// several threads; what is wrong, and where, only check_topology() tells. The test is local: around each
// vertex v, every triangle (v, next, prev) is a step from next to prev. If these steps form one ring that
// meets every neighbour once, the edges at v are paired and v has one fan; if that holds at all vertices, it
// holds for the mesh. There is no hash in it that could collide.
//
//     ManifoldCheck check;
//     if (!check.run(mesh.positions.size(), mesh.triangles, threads)) report(check_topology(...));
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fracture/base/threads.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

// Keeps its memory, 65 bytes a vertex, for the next mesh. Not synchronised.
class ManifoldCheck {
  public:
    // False too where an index is not below vertex_count. Vertices that no triangle uses do not count; a mesh
    // without triangles passes. Linear time for bounded vertex degrees, d log d for a vertex of degree d
    // beyond 8.
    [[nodiscard]] bool run(size_t vertex_count, std::span<const Triangle> triangles, Threads& threads);

    // After run(): the number of triangles at a vertex, up to 9, which stands for more.
    [[nodiscard]] uint32_t degree(uint32_t vertex) const { return degree_[vertex]; }

  private:
    struct Corner {
        uint32_t vertex, next, prev;
    };
    // A vertex range, and the corners in it that found no room.
    struct Range {
        std::vector<Corner> crowd;
        bool sound = true;
    };
    // What a run of triangles refers to.
    struct Reach {
        uint32_t lowest, highest;
    };

    [[nodiscard]] bool look_at_indices(size_t vertex_count, std::span<const Triangle> triangles, Threads& threads);
    void fill(uint32_t first, uint32_t last, std::span<const Triangle> triangles, Range& range);
    [[nodiscard]] bool are_crowds_rings(std::vector<Corner>& crowd) const;

    std::vector<uint32_t> corners_; // blocks of eight vertices, see manifold_check.cpp
    std::vector<uint8_t> degree_;   // a whole number of blocks
    std::vector<Reach> reach_;      // of each run of triangles
    std::vector<Range> ranges_;
};

} // namespace brittle::fracture

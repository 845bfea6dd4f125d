// A fast test whether a triangle mesh is closed, oriented and manifold, for meshes that nearly always are.
//
// The answer equals check_topology(...).manifold() (topology.h) and takes a tenth of the time, on several threads;
// faults are located by check_topology() only. The test is local. Around a vertex v, every triangle (v, next, prev) is
// a step from next to prev. If these steps form one ring that visits every neighbour once, the edges at v are paired
// and v has one fan. A mesh with this property at all vertices is closed, oriented and manifold. No hash is involved,
// so nothing can collide.
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

// Keeps its memory, 65 bytes per vertex, for the next mesh. Not synchronised.
class ManifoldCheck {
  public:
    // Returns whether the mesh is manifold; false if an index is not below vertex_count. Vertices that no triangle uses
    // do not count. A mesh without triangles passes. Time is linear for bounded vertex degrees, d log d for a vertex of
    // degree d above 8.
    [[nodiscard]] bool run(size_t vertex_count, std::span<const Triangle> triangles, Threads& threads);

    // Returns, after run(), the number of triangles at a vertex; 9 stands for 9 or more.
    [[nodiscard]] uint32_t degree(uint32_t vertex) const { return degree_[vertex]; }

  private:
    struct Corner {
        uint32_t vertex, next, prev;
    };
    // The state of one range of vertices; `overflow` holds corners of vertices with more corners than slots.
    struct Range {
        std::vector<Corner> overflow;
        bool manifold = true;
    };
    // The lowest and the highest vertex index in a run of triangles.
    struct IndexRange {
        uint32_t lowest, highest;
    };

    [[nodiscard]] bool check_indices(size_t vertex_count, std::span<const Triangle> triangles, Threads& threads);
    void fill(uint32_t first, uint32_t last, std::span<const Triangle> triangles, Range& range);
    [[nodiscard]] bool overflow_forms_rings(std::vector<Corner>& overflow) const;

    std::vector<uint32_t> corners_;        // in blocks of eight vertices, see manifold_check.cpp
    std::vector<uint8_t> degree_;          // per vertex, padded to whole blocks
    std::vector<IndexRange> index_ranges_; // per run of triangles
    std::vector<Range> ranges_;
};

} // namespace brittle::fracture

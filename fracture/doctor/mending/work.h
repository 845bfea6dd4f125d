// A mesh under repair, and the table of its edges that the steps of a repair use.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fracture/base/union_find.h"
#include "fracture/doctor/repair.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture::mending {

struct Work {
    TriangleMesh mesh;
    std::vector<uint32_t> source; // per triangle: the triangle of the input, or no_index
    std::vector<uint8_t> turned;  // per triangle: whether its orientation is opposite to that of its source
    std::vector<uint32_t> origin; // per vertex: the vertex of the input that it is, or is a copy of
    RepairReport report;

    explicit Work(const TriangleMesh& input);

    void append(const Triangle& triangle, uint32_t triangle_source, bool is_turned);
    // Appends a copy of the vertex and returns its index.
    uint32_t copy_vertex(uint32_t vertex);
    void turn(uint32_t triangle);
    // Drops the triangles with a flag. `gone` has one flag per triangle. Keeps the order.
    void drop(const std::vector<uint8_t>& gone);
};

// One side of a triangle. The side of corner 3 t + k runs from corner k of triangle t to the next corner.
struct EdgeUse {
    uint32_t low, high; // vertices
    uint32_t corner;
    bool forward; // from low to high
};

// The sides of all triangles, grouped by undirected edge. Edges ascend by lower vertex, then by higher vertex; the uses
// of an edge ascend by corner.
class EdgeTable {
  public:
    explicit EdgeTable(std::span<const Triangle> triangles);

    [[nodiscard]] size_t size() const { return begin_.size() - 1; }
    [[nodiscard]] std::span<const EdgeUse> operator[](size_t edge) const {
        return std::span(uses_).subspan(begin_[edge], begin_[edge + 1] - begin_[edge]);
    }
    // The edge of the side of a corner.
    [[nodiscard]] uint32_t of_corner(uint32_t corner) const { return of_corner_[corner]; }
    // The number of uses from low to high, minus the number of uses in the other direction.
    [[nodiscard]] int surplus(size_t edge) const;
    // The edge between two vertices, or no_index.
    [[nodiscard]] uint32_t find(uint32_t a, uint32_t b) const;

  private:
    std::vector<EdgeUse> uses_;
    std::vector<uint32_t> begin_; // per edge, and the end: into uses_
    std::vector<uint32_t> of_corner_;
};

[[nodiscard]] inline uint32_t next_corner(uint32_t corner) {
    return corner % 3 == 2 ? corner - 2 : corner + 1;
}

[[nodiscard]] inline uint32_t vertex_at(const TriangleMesh& mesh, uint32_t corner) {
    return mesh.triangles[corner / 3][static_cast<int>(corner % 3)];
}

[[nodiscard]] inline bool is_degenerate(const Triangle& t) {
    return t.x == t.y || t.y == t.z || t.z == t.x;
}

} // namespace brittle::fracture::mending

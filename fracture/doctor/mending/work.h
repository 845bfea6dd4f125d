// A mesh under repair, and the table of its edges that the steps of a repair share.
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
    std::vector<uint32_t> source; // per triangle: that of the input, or no_index
    std::vector<uint8_t> turned;  // per triangle: it runs against its source
    std::vector<uint32_t> origin; // per vertex: that of the input which it is or was copied from
    RepairReport report;

    explicit Work(const TriangleMesh& input);

    void append(const Triangle& triangle, uint32_t triangle_source, bool is_turned);
    // Returns the copy's index.
    uint32_t copy_vertex(uint32_t vertex);
    void turn(uint32_t triangle);
    // Keeps the order. `gone` is one flag a triangle.
    void drop(const std::vector<uint8_t>& gone);
};

// One side of a triangle. The side of corner 3 t + k leads from corner k of triangle t to the next one.
struct EdgeUse {
    uint32_t low, high; // vertices
    uint32_t corner;
    bool forward; // from low to high
};

// The sides of all triangles, those of one undirected edge together: edges ascend by lower end, then higher
// end, uses by corner.
class EdgeTable {
  public:
    explicit EdgeTable(std::span<const Triangle> triangles);

    [[nodiscard]] size_t size() const { return begin_.size() - 1; }
    [[nodiscard]] std::span<const EdgeUse> operator[](size_t edge) const {
        return std::span(uses_).subspan(begin_[edge], begin_[edge + 1] - begin_[edge]);
    }
    [[nodiscard]] uint32_t of_corner(uint32_t corner) const { return of_corner_[corner]; }
    // How often it is used from low to high, less how often the other way.
    [[nodiscard]] int surplus(size_t edge) const;
    // The edge between two vertices, or no_index.
    [[nodiscard]] uint32_t find(uint32_t a, uint32_t b) const;

  private:
    std::vector<EdgeUse> uses_;
    std::vector<uint32_t> begin_; // per edge, and the end
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

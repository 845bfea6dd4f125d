#include "fracture/doctor/mending/edge_order.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include <glm/vec2.hpp>

#include "fracture/arithmetic/plane_predicates.h"
#include "fracture/mesh/intersections.h"

namespace brittle::fracture::mending {
namespace {

class Around {
  public:
    Around(const TriangleMesh& mesh, std::span<const EdgeUse> uses)
        : uses_(uses), low_(mesh.positions[uses[0].low]), high_(mesh.positions[uses[0].high]) {
        for (const EdgeUse& use : uses)
            apexes_.push_back(mesh.positions[vertex_at(mesh, next_corner(next_corner(use.corner)))]);
        // Angles are measured from the first triangle with an area.
        for (const glm::dvec3& apex : apexes_) {
            for (int axis = 0; axis < 3 && axis_ < 0; ++axis) {
                if (side_of_line(apex, axis) == 0) continue;
                axis_ = axis;
                zero_ = apex;
            }
        }
    }

    [[nodiscard]] std::vector<uint32_t> run() const {
        std::vector<uint32_t> half(uses_.size()); // 0: angle 0, 1: below half a turn, 2: half a turn, 3: above
        for (uint32_t k = 0; k < uses_.size(); ++k) half[k] = half_of(apexes_[k]);
        std::vector<uint32_t> order(uses_.size());
        std::iota(order.begin(), order.end(), 0u);
        std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
            if (half[a] != half[b]) return half[a] < half[b];
            if (half[a] % 2 == 1)
                if (const int turn = orientation(low_, high_, apexes_[a], apexes_[b]); turn != 0) return turn < 0;
            if (uses_[a].forward != uses_[b].forward) return uses_[a].forward;
            return a < b;
        });
        return order;
    }

  private:
    // The side of the edge's line on which a point lies, in projection along an axis.
    [[nodiscard]] int side_of_line(const glm::dvec3& p, int axis) const {
        const auto flat = [axis](const glm::dvec3& q) { return glm::dvec2(q[(axis + 1) % 3], q[(axis + 2) % 3]); };
        const double side = orientation(flat(low_), flat(high_), flat(p));
        return side > 0.0 ? 1 : (side < 0.0 ? -1 : 0);
    }

    [[nodiscard]] uint32_t half_of(const glm::dvec3& apex) const {
        if (axis_ < 0) return 0;
        const int turn = orientation(low_, high_, zero_, apex);
        if (turn != 0) return turn < 0 ? 1 : 3;
        // A triangle without area has no angle and counts as 0.
        return side_of_line(apex, axis_) * side_of_line(zero_, axis_) < 0 ? 2 : 0;
    }

    std::span<const EdgeUse> uses_;
    glm::dvec3 low_, high_;
    std::vector<glm::dvec3> apexes_;
    int axis_ = -1; // a projection axis along which the triangle at angle 0 is not degenerate
    glm::dvec3 zero_{0.0};
};

} // namespace

std::vector<uint32_t> around_edge(const TriangleMesh& mesh, std::span<const EdgeUse> uses) {
    return Around(mesh, uses).run();
}

} // namespace brittle::fracture::mending

// Closes cracks: merges rim vertices in one place.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/doctor/mending/steps.h"

namespace brittle::fracture::mending {
namespace {

// The minimum size of a cell as a share of the box, so that cell numbers stay exact.
constexpr double min_cell = 0x1.0p-40;

using Cell = std::array<int64_t, 3>;

std::vector<uint32_t> rim_vertices(const TriangleMesh& mesh) {
    const EdgeTable table(mesh.triangles);
    std::vector<uint32_t> vertices;
    for (size_t e = 0; e < table.size(); ++e)
        if (table[e].size() % 2 == 1) vertices.insert(vertices.end(), {table[e][0].low, table[e][0].high});
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    return vertices;
}

class Welder {
  public:
    Welder(const TriangleMesh& mesh, double distance)
        : positions_(mesh.positions), distance_(distance), parent_(mesh.positions.size()) {
        std::iota(parent_.begin(), parent_.end(), 0u);
    }

    // Returns for each vertex the one that it is merged into.
    std::vector<uint32_t> run(std::vector<uint32_t> vertices) {
        unite_equal(vertices);
        std::erase_if(vertices, [&](uint32_t v) { return parent_[v] != v; });
        if (distance_ > 0.0) unite_near(vertices);
        for (uint32_t v = 0; v < parent_.size(); ++v) parent_[v] = root_of(parent_, v);
        return std::move(parent_);
    }

  private:
    void unite_equal(std::vector<uint32_t>& vertices) {
        std::sort(vertices.begin(), vertices.end(), [&](uint32_t a, uint32_t b) {
            const glm::dvec3 &p = positions_[a], &q = positions_[b];
            return std::tie(p.x, p.y, p.z, a) < std::tie(q.x, q.y, q.z, b);
        });
        for (size_t k = 1; k < vertices.size(); ++k)
            if (positions_[vertices[k]] == positions_[vertices[k - 1]]) unite(parent_, vertices[k - 1], vertices[k]);
    }

    // Unites near vertices, which all lie in different places.
    void unite_near(const std::vector<uint32_t>& vertices) {
        Box box;
        if (!vertices.empty()) box = {positions_[vertices[0]], positions_[vertices[0]]};
        for (const uint32_t v : vertices) {
            box.min = glm::min(box.min, positions_[v]);
            box.max = glm::max(box.max, positions_[v]);
        }
        const double cell_size = std::max(distance_, glm::length(box.size()) * min_cell);
        std::vector<std::pair<Cell, uint32_t>> members;
        for (const uint32_t v : vertices) {
            const glm::dvec3 at = glm::floor((positions_[v] - box.min) / cell_size);
            members.push_back(
                {{static_cast<int64_t>(at.x), static_cast<int64_t>(at.y), static_cast<int64_t>(at.z)}, v});
        }
        std::sort(members.begin(), members.end());
        for (const auto& [cell, v] : members) {
            for (int64_t x = cell[0] - 1; x <= cell[0] + 1; ++x) {
                for (int64_t y = cell[1] - 1; y <= cell[1] + 1; ++y) {
                    // The three cells along Z are adjacent in memory.
                    auto near =
                        std::lower_bound(members.begin(), members.end(), std::pair(Cell{x, y, cell[2] - 1}, 0u));
                    const Cell last = {x, y, cell[2] + 1};
                    for (; near != members.end() && near->first <= last; ++near) {
                        const glm::dvec3 apart = positions_[near->second] - positions_[v];
                        if (near->second > v && glm::length(apart) <= distance_) unite(parent_, v, near->second);
                    }
                }
            }
        }
    }

    const std::vector<glm::dvec3>& positions_;
    double distance_;
    std::vector<uint32_t> parent_;
};

} // namespace

bool weld_rims(Work& work, double distance) {
    std::vector<uint32_t> rim = rim_vertices(work.mesh);
    if (rim.empty()) return false;
    const std::vector<uint32_t> becomes = Welder(work.mesh, distance).run(std::move(rim));
    std::vector<uint8_t> counted(becomes.size(), 0);
    for (Triangle& t : work.mesh.triangles) {
        for (int k = 0; k < 3; ++k) {
            const uint32_t v = t[k];
            if (becomes[v] == v) continue;
            if (!counted[v]) work.report.welded_vertices.add(work.origin[v]);
            counted[v] = 1;
            t[k] = becomes[v];
        }
    }
    return std::find(counted.begin(), counted.end(), 1) != counted.end();
}

} // namespace brittle::fracture::mending

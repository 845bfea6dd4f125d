#include "fracture/doctor/mending/work.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace brittle::fracture::mending {

Work::Work(const TriangleMesh& input)
    : mesh(input), source(input.triangles.size()), turned(input.triangles.size(), 0), origin(input.positions.size()) {
    std::iota(source.begin(), source.end(), 0u);
    std::iota(origin.begin(), origin.end(), 0u);
}

void Work::append(const Triangle& triangle, uint32_t triangle_source, bool is_turned) {
    mesh.triangles.push_back(triangle);
    source.push_back(triangle_source);
    turned.push_back(is_turned ? 1 : 0);
}

uint32_t Work::copy_vertex(uint32_t vertex) {
    const glm::dvec3 place = mesh.positions[vertex];
    mesh.positions.push_back(place);
    const uint32_t input = origin[vertex];
    origin.push_back(input);
    return static_cast<uint32_t>(mesh.positions.size() - 1);
}

void Work::turn(uint32_t triangle) {
    // The first corner stays, so that turning a triangle twice restores its bits.
    std::swap(mesh.triangles[triangle].y, mesh.triangles[triangle].z);
    turned[triangle] ^= 1;
}

void Work::drop(const std::vector<uint8_t>& gone) {
    size_t kept = 0;
    for (size_t t = 0; t < gone.size(); ++t) {
        if (gone[t]) continue;
        mesh.triangles[kept] = mesh.triangles[t];
        source[kept] = source[t];
        turned[kept++] = turned[t];
    }
    mesh.triangles.resize(kept);
    source.resize(kept);
    turned.resize(kept);
}

EdgeTable::EdgeTable(std::span<const Triangle> triangles) : of_corner_(3 * triangles.size()) {
    uses_.reserve(of_corner_.size());
    for (const Triangle& t : triangles) {
        for (int k = 0; k < 3; ++k) {
            const uint32_t from = t[k], to = t[(k + 1) % 3];
            uses_.push_back({std::min(from, to), std::max(from, to), static_cast<uint32_t>(uses_.size()), from < to});
        }
    }
    std::sort(uses_.begin(), uses_.end(), [](const EdgeUse& a, const EdgeUse& b) {
        return std::tie(a.low, a.high, a.corner) < std::tie(b.low, b.high, b.corner);
    });
    for (uint32_t k = 0; k < uses_.size(); ++k) {
        if (k == 0 || uses_[k].low != uses_[k - 1].low || uses_[k].high != uses_[k - 1].high) begin_.push_back(k);
        of_corner_[uses_[k].corner] = static_cast<uint32_t>(begin_.size() - 1);
    }
    begin_.push_back(static_cast<uint32_t>(uses_.size()));
}

int EdgeTable::surplus(size_t edge) const {
    int sum = 0;
    for (const EdgeUse& use : (*this)[edge]) sum += use.forward ? 1 : -1;
    return sum;
}

uint32_t EdgeTable::find(uint32_t a, uint32_t b) const {
    if (a > b) std::swap(a, b);
    const auto at =
        std::lower_bound(uses_.begin(), uses_.end(), std::pair(a, b), [](const EdgeUse& use, const auto& ends) {
            return std::tie(use.low, use.high) < std::tie(ends.first, ends.second);
        });
    return at != uses_.end() && at->low == a && at->high == b ? of_corner_[at->corner] : no_index;
}

} // namespace brittle::fracture::mending

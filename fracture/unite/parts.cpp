#include "fracture/unite/parts.h"

#include <algorithm>
#include <numeric>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

#include "fracture/mesh/topology.h"

namespace brittle::fracture {

namespace {

// Bounds the time of is_crowded(). Where so many parts overlap along the longest axis and so few pairs meet, no part
// meets many others.
constexpr size_t max_looks_per_part = 1000;

bool contains(const Box& outer, const Box& inner) {
    return glm::all(glm::lessThanEqual(outer.min, inner.min)) && glm::all(glm::lessThanEqual(inner.max, outer.max));
}

bool meet(const Box& a, const Box& b) {
    return glm::all(glm::lessThanEqual(a.min, b.max)) && glm::all(glm::lessThanEqual(b.min, a.max));
}

double volume_of(const Box& box) {
    const glm::dvec3 size = box.size();
    return size.x * size.y * size.z;
}

} // namespace

Box both(const Box& a, const Box& b) {
    return {glm::min(a.min, b.min), glm::max(a.max, b.max)};
}

int longest_axis(const Box& box) {
    const glm::dvec3 size = box.size();
    return size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
}

std::optional<std::vector<MeshPart>> parts_of(const TriangleMesh& mesh) {
    const std::vector<uint32_t> component = triangle_components(mesh.positions.size(), mesh.triangles);
    std::vector<MeshPart> components;
    std::vector<double> volumes; // six times
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const Triangle& corners = mesh.triangles[t];
        const uint32_t n = component[t]; // numbered by first triangle
        if (n == components.size()) {
            const glm::dvec3& first = mesh.positions[corners.x];
            components.push_back({{}, {first, first}});
            volumes.push_back(0.0);
        }
        MeshPart& part = components[n];
        part.triangles.push_back(t);
        const glm::dvec3 origin = mesh.positions[mesh.triangles[part.triangles.front()].x];
        for (int k = 0; k < 3; ++k) {
            part.box.min = glm::min(part.box.min, mesh.positions[corners[k]]);
            part.box.max = glm::max(part.box.max, mesh.positions[corners[k]]);
        }
        volumes[n] += glm::dot(mesh.positions[corners.x] - origin,
                               glm::cross(mesh.positions[corners.y] - origin, mesh.positions[corners.z] - origin));
    }
    std::vector<MeshPart> parts;
    for (size_t n = 0; n < components.size(); ++n)
        if (volumes[n] >= 0.0) parts.push_back(std::move(components[n]));
    for (size_t n = 0; n < components.size(); ++n) {
        if (volumes[n] >= 0.0) continue;
        MeshPart* around = nullptr;
        for (MeshPart& part : parts)
            if (contains(part.box, components[n].box) && (!around || volume_of(part.box) < volume_of(around->box)))
                around = &part;
        if (!around) return std::nullopt;
        around->triangles.insert(around->triangles.end(), components[n].triangles.begin(),
                                 components[n].triangles.end());
    }
    for (MeshPart& part : parts) std::sort(part.triangles.begin(), part.triangles.end());
    return parts;
}

bool is_crowded(const std::vector<MeshPart>& parts, double most) {
    if (parts.empty()) return false;
    Box box = parts.front().box;
    for (const MeshPart& part : parts) box = both(box, part.box);
    const int axis = longest_axis(box);
    std::vector<uint32_t> order(parts.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
        const double at_a = parts[a].box.min[axis], at_b = parts[b].box.min[axis];
        return at_a != at_b ? at_a < at_b : a < b;
    });
    const double enough = 0.5 * most * static_cast<double>(parts.size());
    double pairs = 0.0;
    size_t left = max_looks_per_part * parts.size();
    for (size_t k = 0; k < order.size(); ++k) {
        const Box& own = parts[order[k]].box;
        for (size_t m = k + 1; m < order.size() && parts[order[m]].box.min[axis] <= own.max[axis]; ++m) {
            if (left-- == 0) return false;
            if (meet(own, parts[order[m]].box) && ++pairs > enough) return true;
        }
    }
    return false;
}

} // namespace brittle::fracture

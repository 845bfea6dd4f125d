#include "fracture/unite/parts.h"

#include <algorithm>
#include <numeric>

#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

#include "fracture/mesh/mass_properties.h"
#include "fracture/mesh/topology.h"

namespace brittle::fracture::arrangement {

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

int longest_axis_of(std::span<const MeshPart> parts) {
    Box box = parts.front().box;
    for (const MeshPart& part : parts) box = {glm::min(box.min, part.box.min), glm::max(box.max, part.box.max)};
    const glm::dvec3 size = box.size();
    return size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
}

bool is_crowded(std::span<const MeshPart> parts, double most) {
    if (parts.size() < 2) return false;
    const int axis = longest_axis_of(parts);
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

std::vector<MeshPart> components_of(const TriangleMesh& mesh) {
    const std::vector<uint32_t> component = triangle_components(mesh.positions.size(), mesh.triangles);
    std::vector<MeshPart> components;
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const Triangle& corners = mesh.triangles[t];
        if (component[t] == components.size()) { // numbered by first triangle
            const glm::dvec3& first = mesh.positions[corners.x];
            components.push_back({{}, {first, first}});
        }
        MeshPart& part = components[component[t]];
        part.triangles.push_back(t);
        for (int k = 0; k < 3; ++k) {
            part.box.min = glm::min(part.box.min, mesh.positions[corners[k]]);
            part.box.max = glm::max(part.box.max, mesh.positions[corners[k]]);
        }
    }
    return components;
}

bool is_inside_out(const TriangleMesh& mesh, const MeshPart& part) {
    std::vector<Triangle> triangles;
    for (const uint32_t t : part.triangles) triangles.push_back(mesh.triangles[t]);
    return signed_volume(mesh.positions, triangles) < 0.0;
}

} // namespace

std::optional<std::vector<MeshPart>> crowded_parts(const TriangleMesh& mesh, double most) {
    std::vector<MeshPart> components = components_of(mesh), parts;
    if (!is_crowded(components, most)) return std::nullopt;
    const auto cavities = std::stable_partition(components.begin(), components.end(),
                                                [&](const MeshPart& part) { return !is_inside_out(mesh, part); });
    parts.assign(components.begin(), cavities);
    for (auto cavity = cavities; cavity != components.end(); ++cavity) {
        MeshPart* around = nullptr;
        for (MeshPart& part : parts)
            if (contains(part.box, cavity->box) && (!around || volume_of(part.box) < volume_of(around->box)))
                around = &part;
        if (!around) return std::nullopt;
        around->triangles.insert(around->triangles.end(), cavity->triangles.begin(), cavity->triangles.end());
    }
    for (MeshPart& part : parts) std::sort(part.triangles.begin(), part.triangles.end());
    return parts;
}

size_t halve(std::span<MeshPart> parts) {
    const int axis = longest_axis_of(parts);
    const size_t half = parts.size() / 2;
    std::nth_element(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(half), parts.end(),
                     [axis](const MeshPart& a, const MeshPart& b) {
                         const double at_a = a.box.centre()[axis], at_b = b.box.centre()[axis];
                         return at_a != at_b ? at_a < at_b : a.triangles.front() < b.triangles.front();
                     });
    return half;
}

} // namespace brittle::fracture::arrangement

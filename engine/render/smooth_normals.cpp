#include "engine/render/smooth_normals.h"

#include <glm/geometric.hpp>

namespace brittle::engine {

namespace {

constexpr float crease_cosine = 0.70710678f; // 45 degrees: smooth surfaces are tessellated finer, sharp edges coarser
constexpr uint32_t max_compared = 64;        // triangles around a vertex that are compared pairwise

glm::vec3 unit_or_zero(const glm::vec3& v) {
    const float length = glm::length(v);
    return length > 0.0f ? v / length : glm::vec3(0.0f);
}

// The triangle corners at each vertex. Those of vertex v are corners[begin[v]] to corners[begin[v + 1] - 1]; corner
// 3 t + k is the k-th corner of triangle t.
struct Fans {
    std::vector<uint32_t> begin;
    std::vector<uint32_t> corners;

    Fans(size_t vertices, std::span<const glm::uvec3> triangles) : begin(vertices + 1), corners(3 * triangles.size()) {
        for (const glm::uvec3& t : triangles)
            for (int k = 0; k < 3; ++k) ++begin[t[k] + 1];
        for (size_t v = 0; v < vertices; ++v) begin[v + 1] += begin[v];
        std::vector<uint32_t> next(begin.begin(), begin.end() - 1);
        for (size_t t = 0; t < triangles.size(); ++t)
            for (uint32_t k = 0; k < 3; ++k)
                corners[next[triangles[t][static_cast<int>(k)]]++] = static_cast<uint32_t>(3 * t + k);
    }
};

} // namespace

SmoothSurface smooth_normals(std::span<const glm::vec3> positions, size_t vertices,
                             std::span<const glm::uvec3> triangles, std::span<const glm::uvec3> neighbours) {
    SmoothSurface surface{{triangles.begin(), triangles.end()}, {}, std::vector<glm::vec3>(vertices)};
    std::vector<glm::uvec3> all(surface.triangles);
    all.insert(all.end(), neighbours.begin(), neighbours.end());
    std::vector<glm::vec3> areas, units; // area-weighted and unit normals of all triangles
    for (const glm::uvec3& t : all) {
        const glm::vec3 a = positions[t.x];
        areas.push_back(glm::cross(positions[t.y] - a, positions[t.z] - a));
        units.push_back(unit_or_zero(areas.back()));
    }
    const Fans fans(positions.size(), all);
    struct Variant {
        glm::vec3 sum;
        uint32_t vertex;
    };
    std::vector<Variant> variants; // the normals at the present vertex, of the vertex itself and its copies
    for (uint32_t v = 0; v < vertices; ++v) {
        variants.clear();
        const std::span fan = std::span(fans.corners).subspan(fans.begin[v], fans.begin[v + 1] - fans.begin[v]);
        for (const uint32_t corner : fan) {
            const uint32_t t = corner / 3;
            if (t >= triangles.size()) continue;
            glm::vec3 sum = areas[t];
            if (fan.size() <= max_compared) {
                sum = glm::vec3(0.0f);
                for (const uint32_t other : fan)
                    if (glm::dot(units[t], units[other / 3]) >= crease_cosine) sum += areas[other / 3];
            }
            // Equal sets of triangles are added in equal order, so their sums are bit-equal.
            uint32_t vertex = v;
            size_t i = 0;
            while (i < variants.size() && variants[i].sum != sum) ++i;
            if (i < variants.size()) {
                vertex = variants[i].vertex;
            } else {
                if (i > 0) {
                    vertex = static_cast<uint32_t>(surface.normals.size());
                    surface.copies.push_back(v);
                    surface.normals.emplace_back();
                }
                surface.normals[vertex] = unit_or_zero(sum);
                if (i < max_compared) variants.push_back({sum, vertex});
            }
            surface.triangles[t][static_cast<int>(corner % 3)] = vertex;
        }
    }
    return surface;
}

} // namespace brittle::engine

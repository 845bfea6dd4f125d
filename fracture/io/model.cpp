#include "fracture/io/model.h"

#include <algorithm>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/pieces/attributes.h"

namespace brittle::fracture {

namespace {

// The index of a corner or triangle without a source.
constexpr uint32_t nothing_to_take = no_source;

// A list stays empty until the first corner with a value.
template<class T>
void put(std::vector<T>& list, size_t corner, const std::optional<T>& value, const T& nothing) {
    if (!value && list.empty()) return;
    list.resize(corner, nothing);
    list.push_back(value.value_or(nothing));
}

template<class T>
void fill(std::vector<T>& list, size_t size, const T& nothing) {
    if (!list.empty()) list.resize(size, nothing);
}

template<class T>
void rearrange(std::vector<T>& list, std::span<const uint32_t> from, const T& nothing) {
    if (list.empty()) return;
    std::vector<T> result;
    result.reserve(from.size());
    for (const uint32_t k : from) result.push_back(k == nothing_to_take ? nothing : list[k]);
    list = std::move(result);
}

void rearrange_attributes(Model& model, const std::vector<uint32_t>& corners, std::span<const uint32_t> triangles) {
    for (auto& set : model.uv) rearrange(set, corners, glm::vec2(0.0f));
    rearrange(model.normals, corners, glm::vec3(0.0f));
    rearrange(model.colours, corners, glm::vec4(1.0f));
    rearrange(model.material_of, triangles, no_material);
}

// Matches each corner of a new triangle with one of the old triangle: the assignment that moves them least.
std::array<uint32_t, 3> match(const TriangleMesh& mesh, const Triangle& t, const TriangleMesh& old, const Triangle& o) {
    constexpr std::array<std::array<uint32_t, 3>, 6> orders = {
        {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};
    const auto moved = [&](const std::array<uint32_t, 3>& order) {
        double sum = 0.0;
        for (int k = 0; k < 3; ++k)
            sum +=
                glm::distance(mesh.positions[t[k]], old.positions[o[static_cast<int>(order[static_cast<size_t>(k)])]]);
        return sum;
    };
    return *std::min_element(orders.begin(), orders.end(),
                             [&](const auto& a, const auto& b) { return moved(a) < moved(b); });
}

bool is_turned(const std::array<uint32_t, 3>& order) {
    return (order[0] + 1) % 3 != order[1];
}

// Gives each corner the mean of the old corners, by the weights.
template<class T>
void interpolate(std::vector<T>& list, std::span<const glm::dvec3> weights, std::span<const uint32_t> source) {
    if (list.empty()) return;
    std::vector<T> result;
    result.reserve(weights.size());
    for (size_t corner = 0; corner < weights.size(); ++corner) {
        const T* of = &list[3 * size_t{source[corner / 3]}];
        const glm::vec3 w(weights[corner]);
        const int whole = w.x == 1.0f ? 0 : (w.y == 1.0f ? 1 : (w.z == 1.0f ? 2 : -1));
        result.push_back(whole >= 0 ? of[whole] : w.x * of[0] + w.y * of[1] + w.z * of[2]);
    }
    list = std::move(result);
}

} // namespace

void append_triangle(Model& model, const Triangle& triangle, uint32_t material,
                     std::span<const CornerAttributes, 3> corners) {
    const size_t at = model.mesh.triangles.size();
    for (size_t k = 0; k < 3; ++k) {
        for (size_t set = 0; set < model.uv.size(); ++set)
            put(model.uv[set], 3 * at + k, corners[k].uv[set], glm::vec2(0.0f));
        put(model.normals, 3 * at + k, corners[k].normal, glm::vec3(0.0f));
        put(model.colours, 3 * at + k, corners[k].colour, glm::vec4(1.0f));
    }
    put(model.material_of, at, material == no_material ? std::nullopt : std::optional(material), no_material);
    model.mesh.triangles.push_back(triangle);
}

void complete_corners(Model& model) {
    const size_t triangles = model.mesh.triangles.size();
    for (auto& set : model.uv) fill(set, 3 * triangles, glm::vec2(0.0f));
    fill(model.normals, 3 * triangles, glm::vec3(0.0f));
    fill(model.colours, 3 * triangles, glm::vec4(1.0f));
    fill(model.material_of, triangles, no_material);
}

void keep_triangles(Model& model, TriangleMesh mesh, std::span<const uint32_t> kept) {
    const bool all = kept.size() == model.mesh.triangles.size();
    model.mesh = std::move(mesh);
    if (all) return;
    std::vector<uint32_t> corners;
    corners.reserve(3 * kept.size());
    for (const uint32_t t : kept)
        for (uint32_t k = 0; k < 3; ++k) corners.push_back(3 * t + k);
    rearrange_attributes(model, corners, kept);
}

void replace_mesh(Model& model, TriangleMesh mesh, std::span<const uint32_t> source) {
    std::vector<uint32_t> from(3 * mesh.triangles.size(), nothing_to_take);
    std::vector<size_t> turned;
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (source[t] == no_source) continue;
        const auto order = match(mesh, mesh.triangles[t], model.mesh, model.mesh.triangles[source[t]]);
        for (size_t k = 0; k < 3; ++k) from[3 * t + k] = 3 * source[t] + order[k];
        if (is_turned(order)) turned.push_back(t);
    }
    rearrange_attributes(model, from, source);
    if (!model.normals.empty())
        for (const size_t t : turned)
            for (size_t k = 0; k < 3; ++k) model.normals[3 * t + k] = -model.normals[3 * t + k];
    model.mesh = std::move(mesh);
}

void divide_mesh(Model& model, TriangleMesh mesh, std::span<const uint32_t> source) {
    std::vector<glm::dvec3> weights;
    std::vector<uint8_t> turned; // per triangle: whether it looks the other way
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto corners = [](const TriangleMesh& of, const Triangle& c) {
            return std::array{of.positions[c.x], of.positions[c.y], of.positions[c.z]};
        };
        const auto part = corners(mesh, mesh.triangles[t]),
                   whole = corners(model.mesh, model.mesh.triangles[source[t]]);
        for (const glm::dvec3& p : part) weights.push_back(barycentrics(whole, p));
        turned.push_back(glm::dot(glm::cross(part[1] - part[0], part[2] - part[0]),
                                  glm::cross(whole[1] - whole[0], whole[2] - whole[0]))
                         < 0.0);
    }
    for (auto& set : model.uv) interpolate(set, weights, source);
    interpolate(model.normals, weights, source);
    interpolate(model.colours, weights, source);
    rearrange(model.material_of, source, no_material);
    for (size_t corner = 0; corner < model.normals.size(); ++corner) {
        glm::vec3& normal = model.normals[corner];
        const float length = glm::length(normal);
        const bool is_old = glm::max(weights[corner].x, glm::max(weights[corner].y, weights[corner].z)) == 1.0;
        if (!is_old && length > 0.0f) normal /= length;
        if (turned[corner / 3]) normal = -normal;
    }
    model.mesh = std::move(mesh);
}

} // namespace brittle::fracture

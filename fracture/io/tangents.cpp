#include "fracture/io/tangents.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <span>

#include <glm/geometric.hpp>

#include "fracture/base/rounded_math.h"

namespace brittle::fracture {
namespace {

constexpr uint32_t none = ~0u;

// Shorter vectors have no direction. The reference implementation compares with the least normal float.
constexpr double min_length = std::numeric_limits<float>::min();

glm::dvec3 unit_or_zero(const glm::dvec3& v) {
    const double length = glm::length(v);
    return length > min_length ? v / length : glm::dvec3(0.0);
}

glm::dvec3 flattened(const glm::dvec3& v, const glm::dvec3& normal) {
    return unit_or_zero(v - glm::dot(normal, v) * normal);
}

// The set of texture coordinates of a material's normal map.
size_t uv_set_of(const Material& material) {
    return material.normal_texture && material.normal_texture->uv_set == 1 ? 1 : 0;
}

// The triangles of one material.
class TangentSpace {
  public:
    TangentSpace(const Model& model, uint32_t material, std::span<const uint32_t> triangles)
        : model_(model), uv_(model.uv[uv_set_of(model.materials[material])]), triangles_(triangles) {}

    // Fills the tangents of the corners of the triangles.
    void fill(std::vector<glm::vec4>& tangents) {
        measure();
        number_points();
        find_neighbours();
        group_of_.assign(3 * triangles_.size(), none);
        for (uint32_t c = 0; c < group_of_.size(); ++c)
            if (group_of_[c] == none && is_mapped_[c / 3]) gather(c);
        std::vector<glm::dvec3> sums(group_sign_.size(), glm::dvec3(0.0));
        for (uint32_t c = 0; c < group_of_.size(); ++c)
            if (is_mapped_[c / 3]) sums[group_of_[c]] += angle(c) * flattened(along_u_[c / 3], normals_[c]);
        for (uint32_t c = 0; c < group_of_.size(); ++c) {
            const bool is_grouped = group_of_[c] != none;
            const glm::vec3 sum(is_grouped ? unit_or_zero(sums[group_of_[c]]) : glm::dvec3(1.0, 0.0, 0.0));
            const float sign = is_grouped ? group_sign_[group_of_[c]] : 1.0f;
            tangents[corner_in_model(c)] = glm::vec4(perpendicular(glm::vec3(normals_[c]), sum), sign);
        }
    }

  private:
    // A corner c is here 3 * (place of the triangle in triangles_) + (0, 1 or 2).
    [[nodiscard]] size_t corner_in_model(uint32_t c) const { return 3 * size_t{triangles_[c / 3]} + c % 3; }
    [[nodiscard]] uint32_t vertex(uint32_t c) const {
        return model_.mesh.triangles[triangles_[c / 3]][static_cast<int>(c % 3)];
    }
    [[nodiscard]] const glm::dvec3& position(uint32_t c) const { return model_.mesh.positions[vertex(c)]; }
    static uint32_t next(uint32_t c) { return c % 3 == 2 ? c - 2 : c + 1; }
    static uint32_t previous(uint32_t c) { return c % 3 == 0 ? c + 2 : c - 1; }

    // Directions of u, handedness, and whether the texture coordinates span an area; normals of corners.
    void measure() {
        for (uint32_t t = 0; t < triangles_.size(); ++t) {
            const uint32_t c = 3 * t;
            const glm::dvec3 a = position(c), ab = position(c + 1) - a, ac = position(c + 2) - a;
            const glm::dvec2 uv(uv_[corner_in_model(c)]), uv_ab = glm::dvec2(uv_[corner_in_model(c + 1)]) - uv,
                                                          uv_ac = glm::dvec2(uv_[corner_in_model(c + 2)]) - uv;
            const double area = uv_ab.x * uv_ac.y - uv_ab.y * uv_ac.x;
            const glm::dvec3 along_u = uv_ac.y * ab - uv_ab.y * ac, along_v = uv_ab.x * ac - uv_ac.x * ab;
            is_positive_.push_back(area > 0.0);
            is_mapped_.push_back(std::abs(area) > min_length && glm::length(along_u) > min_length * std::abs(area)
                                 && glm::length(along_v) > min_length * std::abs(area));
            along_u_.push_back((area > 0.0 ? 1.0 : -1.0) * unit_or_zero(along_u));
            const glm::dvec3 flat = unit_or_zero(glm::cross(ab, ac));
            for (uint32_t k = c; k < c + 3; ++k) {
                const bool has_normal =
                    !model_.normals.empty() && model_.normals[corner_in_model(k)] != glm::vec3(0.0f);
                normals_.push_back(has_normal                ? glm::dvec3(model_.normals[corner_in_model(k)])
                                   : flat == glm::dvec3(0.0) ? glm::dvec3(0.0, 1.0, 0.0)
                                                             : flat);
            }
        }
    }

    // Numbers the points: corners with equal vertex, normal and texture coordinates.
    void number_points() {
        const auto key = [&](uint32_t c) {
            const glm::vec2& uv = uv_[corner_in_model(c)];
            const glm::dvec3& n = normals_[c];
            return std::array<double, 6>{static_cast<double>(vertex(c)), n.x, n.y, n.z, double{uv.x}, double{uv.y}};
        };
        std::vector<uint32_t> order(3 * triangles_.size());
        std::iota(order.begin(), order.end(), 0u);
        std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
            const auto key_a = key(a), key_b = key(b);
            return key_a != key_b ? key_a < key_b : a < b;
        });
        point_.resize(order.size());
        uint32_t last = 0;
        for (size_t k = 0; k < order.size(); ++k) {
            if (k > 0 && key(order[k]) != key(order[k - 1])) ++last;
            point_[order[k]] = last;
        }
    }

    // Finds for each side, from a corner to the next one, the corner with which the same side of another triangle begins.
    void find_neighbours() {
        struct Side {
            uint32_t from, to, corner; // from < to
            bool is_reversed;
        };
        std::vector<Side> sides;
        for (uint32_t c = 0; c < point_.size(); ++c) {
            const uint32_t a = point_[c], b = point_[next(c)];
            if (a != b) sides.push_back({std::min(a, b), std::max(a, b), c, b < a});
        }
        std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
            return std::array{a.from, a.to, a.corner} < std::array{b.from, b.to, b.corner};
        });
        across_.assign(point_.size(), none);
        for (size_t first = 0, last = 0; first < sides.size(); first = last) {
            while (last < sides.size() && sides[last].from == sides[first].from && sides[last].to == sides[first].to)
                ++last;
            for (size_t k = first; k < last; ++k) // more than two triangles: in order of the corners
                for (size_t m = k + 1; m < last && across_[sides[k].corner] == none; ++m)
                    if (across_[sides[m].corner] == none && sides[m].is_reversed != sides[k].is_reversed) {
                        across_[sides[k].corner] = sides[m].corner;
                        across_[sides[m].corner] = sides[k].corner;
                    }
        }
    }

    // Makes the group of a corner: those at its point in triangles that are connected around it and of its handedness.
    // A triangle without an area of texture coordinates takes the handedness of its first group.
    void gather(uint32_t corner) {
        const auto group = static_cast<uint32_t>(group_sign_.size());
        const bool is_positive = is_positive_[corner / 3];
        // glTF's v points down, so the bitangent is turned over.
        group_sign_.push_back(is_positive ? -1.0f : 1.0f);
        std::vector<uint32_t> stack{corner};
        while (!stack.empty()) {
            const uint32_t c = stack.back(), t = c / 3;
            stack.pop_back();
            if (group_of_[c] != none) continue;
            const bool is_new =
                group_of_[3 * t] == none && group_of_[3 * t + 1] == none && group_of_[3 * t + 2] == none;
            if (!is_mapped_[t] && is_new) is_positive_[t] = is_positive;
            if (is_positive_[t] != is_positive) continue;
            group_of_[c] = group;
            if (const uint32_t other = across_[previous(c)]; other != none) stack.push_back(other);
            if (const uint32_t other = across_[c]; other != none) stack.push_back(next(other));
        }
    }

    // The angle at a corner in the plane of its normal.
    [[nodiscard]] double angle(uint32_t c) const {
        const glm::dvec3 a = flattened(position(next(c)) - position(c), normals_[c]),
                         b = flattened(position(previous(c)) - position(c), normals_[c]);
        return rounded::acos(std::clamp(glm::dot(a, b), -1.0, 1.0));
    }

    const Model& model_;
    const std::vector<glm::vec2>& uv_;
    std::span<const uint32_t> triangles_;             // into the mesh
    std::vector<glm::dvec3> along_u_;                 // per triangle
    std::vector<bool> is_positive_, is_mapped_;       // per triangle
    std::vector<glm::dvec3> normals_;                 // per corner
    std::vector<uint32_t> point_, across_, group_of_; // per corner
    std::vector<float> group_sign_;                   // per group
};

} // namespace

bool uses_tangents(const Model& model, uint32_t material) {
    if (material >= model.materials.size()) return false;
    const Material& m = model.materials[material];
    const bool is_asked = m.normal_texture.has_value()
                          || m.extensions.find("clearcoatNormalTexture") != std::string::npos
                          || m.extensions.find("KHR_materials_anisotropy") != std::string::npos;
    return is_asked && !model.uv[uv_set_of(m)].empty();
}

std::vector<glm::vec4> corner_tangents(const Model& model) {
    std::vector<std::vector<uint32_t>> of_material(model.materials.size());
    std::vector<glm::vec4> tangents;
    std::vector<bool> is_used(model.materials.size());
    for (uint32_t m = 0; m < model.materials.size(); ++m) is_used[m] = uses_tangents(model, m);
    for (uint32_t t = 0; t < model.material_of.size(); ++t) {
        const uint32_t m = model.material_of[t];
        if (m < is_used.size() && is_used[m]) of_material[m].push_back(t);
    }
    for (uint32_t m = 0; m < of_material.size(); ++m) {
        if (of_material[m].empty()) continue;
        tangents.resize(3 * model.mesh.triangles.size(), glm::vec4(0.0f));
        TangentSpace(model, m, of_material[m]).fill(tangents);
    }
    return tangents;
}

glm::vec3 perpendicular(const glm::vec3& normal, const glm::vec3& tangent) {
    const glm::dvec3 n(normal);
    const glm::dvec3 near(tangent);
    const glm::dvec3 flat = near - glm::dot(n, near) * n;
    constexpr double min_share = 1e-6; // of the tangent's length; less is rounding
    if (glm::length(flat) > min_share * glm::length(near)) return glm::vec3(glm::normalize(flat));
    const glm::dvec3 axis = std::abs(n.x) < 0.5 ? glm::dvec3(1.0, 0.0, 0.0) : glm::dvec3(0.0, 1.0, 0.0);
    return glm::vec3(glm::normalize(axis - glm::dot(n, axis) * n));
}

} // namespace brittle::fracture

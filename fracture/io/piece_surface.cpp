#include "fracture/io/piece_surface.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <unordered_map>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/io/tangents.h"
#include "fracture/pieces/attributes.h"

namespace brittle::fracture {
namespace {

// The least cosine of the angle between the normals of triangles in one plane.
constexpr double same_plane = 0.99999;

// The least cosine of the angle between normals that are smoothed, and between a triangle of a cut and the plane of its
// texture coordinates.
constexpr double min_smooth = 0.5;

// Triangles with a height below this share of their longest side have no reliable plane.
constexpr double min_height = 1e-6;

// Sorts the triangles begin .. end of a piece by source and plane, and numbers the planes of each source. A source has
// one plane, except in merged pieces, which may have cuts along several bisectors with one neighbour.
std::vector<std::array<uint32_t, 3>> by_plane(const Fragments& fragments, const Piece& piece, uint32_t begin,
                                              uint32_t end) {
    const auto positions = fragments.positions_of(piece);
    const auto triangles = fragments.triangles_of(piece);
    std::vector<std::array<uint32_t, 3>> order; // source, plane, triangle
    for (uint32_t t = begin; t < end; ++t)
        order.push_back({fragments.triangle_source[piece.triangles.begin + t], 0, t});
    std::sort(order.begin(), order.end());
    std::vector<glm::dvec3> planes; // of the current source
    for (size_t k = 0; k < order.size(); ++k) {
        if (k == 0 || order[k][0] != order[k - 1][0]) planes.clear();
        const Triangle& t = triangles[order[k][2]];
        const glm::dvec3 ab = positions[t.y] - positions[t.x], ac = positions[t.z] - positions[t.x];
        const glm::dvec3 normal = glm::cross(ab, ac);
        const double length = glm::length(normal);
        const double longest = std::max({glm::dot(ab, ab), glm::dot(ac, ac), glm::dot(ac - ab, ac - ab)});
        if (!(length > min_height * longest)) continue;
        const auto plane = std::find_if(planes.begin(), planes.end(),
                                        [&](const glm::dvec3& n) { return glm::dot(n, normal) > same_plane * length; });
        order[k][1] = static_cast<uint32_t>(plane - planes.begin());
        if (plane == planes.end()) planes.push_back(normal / length);
    }
    std::sort(order.begin(), order.end());
    return order;
}

// The unit normal of triangles in one plane, from the sum of their area vectors, in which slivers hardly count. +Y for
// triangles without area, since glTF requires unit length.
glm::vec3 normal_of(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles,
                    std::span<const std::array<uint32_t, 3>> order) {
    glm::dvec3 sum{0.0};
    for (const auto& [source, number, t] : order) {
        const glm::dvec3& a = positions[triangles[t].x];
        sum += glm::cross(positions[triangles[t].y] - a, positions[triangles[t].z] - a);
    }
    // Scaled first, because the squares of tiny areas would underflow.
    const double largest = std::max({std::abs(sum.x), std::abs(sum.y), std::abs(sum.z)});
    if (!(largest > 0.0)) return {0.0f, 1.0f, 0.0f};
    return glm::vec3(glm::normalize(sum / largest));
}

// Normals and texture coordinates of one rough cut of a piece.
class RoughSurface {
  public:
    // `order` as by_plane() gives it, of one source.
    void start(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles,
               std::span<const std::array<uint32_t, 3>> order) {
        areas_.clear();
        around_.clear();
        glm::dvec3 sum(0.0);
        for (const auto& [source, number, t] : order) {
            const glm::dvec3& a = positions[triangles[t].x];
            const auto index = static_cast<uint32_t>(areas_.size());
            areas_.push_back(glm::cross(positions[triangles[t].y] - a, positions[triangles[t].z] - a));
            sum += areas_.back();
            for (int k = 0; k < 3; ++k) around_.push_back({triangles[t][k], index});
        }
        std::sort(around_.begin(), around_.end());
        mean_ = unit_or_zero(sum);
    }

    // The normal of a corner of the given triangle, an index into `order`; 0 for a triangle without area.
    [[nodiscard]] glm::vec3 normal(uint32_t triangle, uint32_t vertex) const {
        const glm::dvec3 own = unit_or_zero(areas_[triangle]);
        glm::dvec3 sum(0.0);
        for (auto at = std::lower_bound(around_.begin(), around_.end(), std::array<uint32_t, 2>{vertex, 0});
             at != around_.end() && (*at)[0] == vertex; ++at) {
            const glm::dvec3& area = areas_[(*at)[1]];
            if (glm::dot(own, area) > min_smooth * glm::length(area)) sum += area;
        }
        return glm::vec3(unit_or_zero(sum));
    }

    // The normal of the plane of a triangle's texture coordinates: that of the whole cut, or the triangle's own where
    // the cut is bent away from it.
    [[nodiscard]] glm::dvec3 plane(uint32_t triangle) const {
        const glm::dvec3 own = unit_or_zero(areas_[triangle]);
        return glm::dot(own, mean_) > min_smooth || own == glm::dvec3(0.0) ? mean_ : own;
    }

  private:
    // Scaled first, because the squares of tiny areas would underflow.
    [[nodiscard]] static glm::dvec3 unit_or_zero(const glm::dvec3& v) {
        const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
        return largest > 0.0 ? glm::normalize(v / largest) : glm::dvec3(0.0);
    }

    std::vector<glm::dvec3> areas_;               // per triangle: twice its area vector
    std::vector<std::array<uint32_t, 2>> around_; // vertex, triangle
    glm::dvec3 mean_{0.0};
};

// The attributes of a corner, as a key.
struct Corner {
    uint32_t vertex = 0;
    glm::vec3 normal{0.0f};
    glm::vec4 tangent{0.0f};
    std::array<glm::vec2, 2> uv{};
    glm::vec4 colour{1.0f};

    // Compares bytes. +0 and -0 differ, which costs an extra vertex at most.
    bool operator==(const Corner& other) const { return std::memcmp(this, &other, sizeof(Corner)) == 0; }
};
static_assert(sizeof(Corner) == 4 + 12 + 16 + 16 + 16, "no padding, because it is compared by bytes");

struct HashCorner {
    size_t operator()(const Corner& corner) const {
        std::array<uint32_t, sizeof(Corner) / 4> words{};
        std::memcpy(words.data(), &corner, sizeof(Corner));
        uint64_t hash = 0;
        for (const uint32_t word : words) {
            hash = (hash ^ word) * 0x9e3779b97f4a7c15ull;
            hash ^= hash >> 32;
        }
        return hash;
    }
};

class PartBuilder {
  public:
    PartBuilder(const Fragments& fragments, const Piece& piece, const SurfaceSettings& settings)
        : fragments_(fragments), piece_(piece), source_(settings.source), sites_(settings.sites),
          uv_by_plane_(settings.uv_by_plane && settings.sites.empty()), rough_(settings.rough),
          outside_(settings.rough && (uv_by_plane_ || !sites_.empty()) ? settings.outside : nullptr),
          tangents_(settings.tangents) {}

    std::vector<DrawnPart> build() {
        add_exterior();
        if (piece_.exterior_triangles < piece_.triangles.size()) {
            begin_part(no_material, true);
            const auto order = by_plane(fragments_, piece_, piece_.exterior_triangles, piece_.triangles.size());
            if (rough_)
                add_rough(order);
            else
                add(order);
        }
        return std::move(parts_);
    }

  private:
    void add_exterior() {
        std::vector<std::array<uint32_t, 3>> order = by_plane(fragments_, piece_, 0, piece_.exterior_triangles);
        const auto material = [&](const std::array<uint32_t, 3>& entry) {
            return source_ && !source_->material_of.empty() ? source_->material_of[entry[0]] + 1 : 0; // none first
        };
        std::stable_sort(order.begin(), order.end(),
                         [&](const auto& a, const auto& b) { return material(a) < material(b); });
        for (size_t first = 0, last = 0; first < order.size(); first = last) {
            while (last < order.size() && material(order[last]) == material(order[first])) ++last;
            begin_part(material(order[first]) - 1, false);
            add(std::span(order).subspan(first, last - first));
        }
    }

    void begin_part(uint32_t material, bool interior) {
        parts_.push_back({.material = material, .interior = interior});
        has_tangents_ = !interior && !tangents_.empty() && uses_tangents(*source_, material);
        known_.clear();
    }

    void add(std::span<const std::array<uint32_t, 3>> order) {
        const auto positions = fragments_.positions_of(piece_);
        const auto triangles = fragments_.triangles_of(piece_);
        for (size_t first = 0, last = 0; first < order.size(); first = last) {
            while (last < order.size() && order[last][0] == order[first][0] && order[last][1] == order[first][1])
                ++last;
            const auto plane = order.subspan(first, last - first);
            const glm::vec3 normal = normal_of(positions, triangles, plane);
            for (const auto& [source, number, t] : plane) {
                const auto corners = parts_.back().interior ? interior_corners(t, normal) : exterior_corners(t, source);
                for (Corner corner : corners) {
                    if (corner.normal == glm::vec3(0.0f)) corner.normal = normal;
                    if (has_tangents_)
                        corner.tangent = glm::vec4(perpendicular(corner.normal, glm::vec3(corner.tangent)),
                                                   tangents_[3 * size_t{source}].w);
                    add(corner);
                }
            }
        }
    }

    void add_rough(std::span<const std::array<uint32_t, 3>> order) {
        const auto positions = fragments_.positions_of(piece_);
        const auto triangles = fragments_.triangles_of(piece_);
        measure_depths();
        RoughSurface cut;
        for (size_t first = 0, last = 0; first < order.size(); first = last) {
            while (last < order.size() && order[last][0] == order[first][0]) ++last;
            const auto of_cut = order.subspan(first, last - first);
            cut.start(positions, triangles, of_cut);
            const glm::dvec3 middle = middle_of(of_cut[0][0]);
            for (uint32_t k = 0; k < of_cut.size(); ++k) {
                const uint32_t t = of_cut[k][2];
                const glm::vec3 flat = normal_of(positions, triangles, of_cut.subspan(k, 1));
                const glm::dvec3 plane = cut.plane(k) == glm::dvec3(0.0) ? glm::dvec3(flat) : cut.plane(k);
                for (int c = 0; c < 3; ++c) {
                    Corner corner;
                    const uint32_t v = corner.vertex = triangles[t][c];
                    corner.normal = cut.normal(k, v);
                    if (corner.normal == glm::vec3(0.0f)) corner.normal = flat;
                    const glm::dvec2 uv = plane_uv(plane, positions[v] - middle);
                    if (uv_by_plane_ || !sites_.empty()) corner.uv[0] = glm::vec2(uv.x, -uv.y);
                    if (outside_) corner.uv[1].x = depths_[v];
                    add(corner);
                }
            }
        }
    }

    // The origin of a cut's texture coordinates, equal on both sides.
    [[nodiscard]] glm::dvec3 middle_of(uint32_t other) const {
        return sites_.empty() ? glm::dvec3(0.0) : 0.5 * sites_[piece_.site] + 0.5 * sites_[other];
    }

    // Fills depths_. The points of the outside have exactly 0.
    void measure_depths() {
        if (!outside_) return;
        const auto positions = fragments_.positions_of(piece_);
        const auto triangles = fragments_.triangles_of(piece_);
        depths_.assign(positions.size(), -1.0f);
        for (const Triangle& t : triangles.first(piece_.exterior_triangles))
            depths_[t.x] = depths_[t.y] = depths_[t.z] = 0.0f;
        for (const Triangle& t : triangles.subspan(piece_.exterior_triangles))
            for (int k = 0; k < 3; ++k)
                if (float& depth = depths_[t[k]]; depth < 0.0f)
                    depth = static_cast<float>(outside_->distance(positions[t[k]]));
    }

    [[nodiscard]] std::array<Corner, 3> interior_corners(uint32_t t, const glm::vec3& normal) const {
        std::array<Corner, 3> corners{};
        std::array<glm::dvec2, 3> uv{};
        if (!sites_.empty()) uv = interior_uv(sites_, fragments_, piece_, piece_.triangles.begin + t);
        for (size_t k = 0; k < 3; ++k) {
            const uint32_t v = corners[k].vertex = fragments_.triangles_of(piece_)[t][static_cast<int>(k)];
            if (uv_by_plane_) uv[k] = plane_uv(glm::dvec3(normal), fragments_.positions_of(piece_)[v]);
            corners[k].uv[0] = glm::vec2(uv[k].x, -uv[k].y);
        }
        return corners;
    }

    [[nodiscard]] std::array<Corner, 3> exterior_corners(uint32_t t, uint32_t source) const {
        std::array<Corner, 3> corners{};
        for (size_t k = 0; k < 3; ++k) corners[k].vertex = fragments_.triangles_of(piece_)[t][static_cast<int>(k)];
        if (!has_attributes()) return corners;
        const auto weights = barycentrics(source_->mesh, fragments_, piece_, piece_.triangles.begin + t);
        const auto mix = [&](const auto& list, size_t k) {
            const glm::vec3 w(weights[k]);
            const size_t first = 3 * size_t{source};
            return w.x * list[first] + w.y * list[first + 1] + w.z * list[first + 2];
        };
        for (size_t k = 0; k < 3; ++k) {
            for (size_t set = 0; set < 2; ++set)
                if (!source_->uv[set].empty()) corners[k].uv[set] = mix(source_->uv[set], k);
            if (has_tangents_) corners[k].tangent = mix(tangents_, k);
            if (!source_->colours.empty()) corners[k].colour = glm::clamp(mix(source_->colours, k), 0.0f, 1.0f);
            if (source_->normals.empty()) continue;
            const glm::vec3 normal = mix(source_->normals, k);
            const float length = glm::length(normal);
            if (length > 1e-3f) corners[k].normal = normal / length; // opposite normals may cancel: flat shading
        }
        return corners;
    }

    [[nodiscard]] bool has_attributes() const {
        return source_
               && !(source_->uv[0].empty() && source_->uv[1].empty() && source_->colours.empty()
                    && source_->normals.empty());
    }

    void add(const Corner& corner) {
        DrawnPart& part = parts_.back();
        const auto [known, is_new] = known_.emplace(corner, static_cast<uint32_t>(part.vertices.size()));
        if (is_new) {
            part.vertices.push_back(corner.vertex);
            part.normals.push_back(corner.normal);
            if (has_tangents_) part.tangents.push_back(corner.tangent);
            for (size_t set = 0; set < 2; ++set)
                if (part.interior ? (set == 0 ? !sites_.empty() || uv_by_plane_ : outside_ != nullptr)
                                  : source_ && !source_->uv[set].empty())
                    part.uv[set].push_back(corner.uv[set]);
            if (!part.interior && source_ && !source_->colours.empty()) part.colours.push_back(corner.colour);
        }
        part.indices.push_back(known->second);
    }

    const Fragments& fragments_;
    const Piece& piece_;
    const Model* source_;
    std::span<const glm::dvec3> sites_;
    bool uv_by_plane_, rough_;
    const TriangleTree* outside_;
    std::span<const glm::vec4> tangents_;
    bool has_tangents_ = false; // of the current part
    std::vector<float> depths_; // per vertex of the piece
    std::vector<DrawnPart> parts_;
    std::unordered_map<Corner, uint32_t, HashCorner> known_; // of the current part
};

} // namespace

std::vector<DrawnPart> drawn_parts(const Fragments& fragments, const Piece& piece, const SurfaceSettings& settings) {
    return PartBuilder(fragments, piece, settings).build();
}

} // namespace brittle::fracture

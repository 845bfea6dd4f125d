#include "fracture/doctor/mending/remesh_fill.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include <glm/geometric.hpp>

namespace brittle::fracture::mending {
namespace {

constexpr double density = 1.4142135623730951; // alpha of section 4.2
constexpr int max_rounds = 24;                 // of division
constexpr int max_passes = 32;                 // of flips, each round
constexpr size_t max_points = 50'000;          // of one fill
constexpr int max_iterations = 400;            // of the conjugate gradients
constexpr double converged = 1e-20;            // square of the residual, relative

using Edge = std::pair<uint32_t, uint32_t>;

Edge edge_of(uint32_t a, uint32_t b) {
    return {std::min(a, b), std::max(a, b)};
}

class Remesher {
  public:
    Remesher(std::span<const glm::dvec3> positions, std::span<const Triangle> fill, const Neighbours& neighbours,
             const Taken& taken)
        : positions_(positions), neighbours_(neighbours), taken_(taken) {
        result_.triangles.assign(fill.begin(), fill.end());
        for (const Triangle& t : fill)
            for (int k = 0; k < 3; ++k) {
                const auto [entry, is_new] = length_.try_emplace(t[k], 0.0);
                if (is_new) entry->second = edge_length(t[k]);
            }
    }

    void refine() {
        for (int round = 0; round < max_rounds && result_.points.size() < max_points; ++round) {
            const bool divided = divide();
            for (int pass = 0; pass < max_passes && flip_edges(); ++pass) {
            }
            if (!divided) return;
        }
    }

    // Conjugate gradients for the least sum of |difference(v)|^2 over the vertices of the fill, where difference(v) is
    // the mean of v's neighbours minus v.
    void smooth() {
        if (result_.points.empty()) return;
        find_rings();
        std::vector<glm::dvec3> residual = gradient(result_.points, true), direction(residual.size());
        for (glm::dvec3& r : residual) r = -r;
        direction = residual;
        double size = dot(residual, residual);
        const double first = size;
        for (int k = 0; k < max_iterations && size > converged * first; ++k) {
            const std::vector<glm::dvec3> change = gradient(direction, false);
            const double step = size / dot(direction, change);
            if (!std::isfinite(step)) return;
            for (size_t p = 0; p < residual.size(); ++p) {
                result_.points[p] += step * direction[p];
                residual[p] -= step * change[p];
            }
            const double next = dot(residual, residual);
            for (size_t p = 0; p < residual.size(); ++p) direction[p] = residual[p] + (next / size) * direction[p];
            size = next;
        }
    }

    Remeshed take() { return std::move(result_); }

  private:
    [[nodiscard]] const glm::dvec3& at(uint32_t v) const {
        return v < positions_.size() ? positions_[v] : result_.points[v - positions_.size()];
    }

    // The mean length of the edges at a vertex of the surface.
    [[nodiscard]] double edge_length(uint32_t v) const {
        double sum = 0.0;
        const auto around = neighbours_.of(v);
        for (const uint32_t n : around) sum += glm::distance(positions_[v], positions_[n]);
        return around.empty() ? 0.0 : sum / static_cast<double>(around.size());
    }

    bool divide() {
        bool any = false;
        const size_t count = result_.triangles.size();
        for (size_t n = 0; n < count && result_.points.size() < max_points; ++n) {
            const Triangle t = result_.triangles[n];
            const glm::dvec3 middle = (at(t.x) + at(t.y) + at(t.z)) / 3.0;
            const double length = (length_[t.x] + length_[t.y] + length_[t.z]) / 3.0;
            bool is_coarse = length > 0.0;
            for (int k = 0; k < 3; ++k)
                is_coarse = is_coarse && density * glm::distance(middle, at(t[k])) > std::max(length, length_[t[k]]);
            if (!is_coarse) continue;
            const auto point = static_cast<uint32_t>(positions_.size() + result_.points.size());
            result_.points.push_back(middle);
            length_[point] = length;
            result_.triangles[n] = {t.x, t.y, point};
            result_.triangles.push_back({t.y, t.z, point});
            result_.triangles.push_back({t.z, t.x, point});
            any = true;
        }
        return any;
    }

    // Flips inner edges whose opposite corner lies in the circumsphere of the triangle, each triangle once a pass.
    bool flip_edges() {
        std::map<Edge, std::vector<std::pair<uint32_t, int>>> sides; // triangle and corner where the side begins
        for (uint32_t t = 0; t < result_.triangles.size(); ++t)
            for (int k = 0; k < 3; ++k) {
                const Triangle& c = result_.triangles[t];
                sides[edge_of(c[k], c[(k + 1) % 3])].emplace_back(t, k);
            }
        std::set<Edge> added;
        std::vector<uint8_t> changed(result_.triangles.size(), 0);
        bool any = false;
        for (const auto& [edge, uses] : sides) {
            if (uses.size() != 2 || changed[uses[0].first] || changed[uses[1].first]) continue;
            Triangle &s = result_.triangles[uses[0].first], &t = result_.triangles[uses[1].first];
            const uint32_t a = s[uses[0].second], b = s[(uses[0].second + 1) % 3], c = s[(uses[0].second + 2) % 3];
            const uint32_t d = t[(uses[1].second + 2) % 3];
            const Edge other = edge_of(c, d);
            if (c == d || taken_.edge(c, d) || sides.count(other) > 0 || added.count(other) > 0) continue;
            if (!in_sphere(at(a), at(b), at(c), at(d))) continue;
            const Triangle first(c, a, d), second(d, b, c);
            if (glm::dot(normal(first), normal(s)) <= 0.0 || glm::dot(normal(second), normal(t)) <= 0.0) continue;
            s = first;
            t = second;
            added.insert(other);
            changed[uses[0].first] = changed[uses[1].first] = 1;
            any = true;
        }
        return any;
    }

    [[nodiscard]] glm::dvec3 normal(const Triangle& t) const {
        return glm::cross(at(t.y) - at(t.x), at(t.z) - at(t.x));
    }

    // Whether d lies clearly inside the smallest sphere through a, b and c.
    static bool in_sphere(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d) {
        const glm::dvec3 u = b - a, v = c - a, n = glm::cross(u, v);
        const double area = glm::dot(n, n);
        if (!(area > 0.0)) return true; // any flip is better than a triangle without area
        const glm::dvec3 centre =
            (glm::dot(u, u) * glm::cross(v, n) + glm::dot(v, v) * glm::cross(n, u)) / (2.0 * area);
        return glm::length(d - a - centre) < (1.0 - 1e-9) * glm::length(centre);
    }

    // The neighbours of each vertex of the fill, in the fill and on the surface.
    void find_rings() {
        std::map<uint32_t, std::set<uint32_t>> rings;
        for (const Triangle& t : result_.triangles)
            for (int k = 0; k < 3; ++k) {
                std::set<uint32_t>& ring = rings[t[k]];
                ring.insert({t[(k + 1) % 3], t[(k + 2) % 3]});
                if (t[k] < positions_.size())
                    for (const uint32_t n : neighbours_.of(t[k])) ring.insert(n);
            }
        for (const auto& [vertex, ring] : rings)
            rings_.emplace_back(vertex, std::vector<uint32_t>(ring.begin(), ring.end()));
    }

    // Half the gradient of the sum with respect to the points, at `points`. Without `whole` the surface counts as zero:
    // the linear part.
    [[nodiscard]] std::vector<glm::dvec3> gradient(const std::vector<glm::dvec3>& points, bool whole) const {
        const auto value = [&](uint32_t v) {
            if (v >= positions_.size()) return points[v - positions_.size()];
            return whole ? positions_[v] : glm::dvec3(0.0);
        };
        std::vector<glm::dvec3> sum(points.size(), glm::dvec3(0.0));
        const auto add = [&](uint32_t v, const glm::dvec3& by) {
            if (v >= positions_.size()) sum[v - positions_.size()] += by;
        };
        for (const auto& [vertex, ring] : rings_) {
            const double share = 1.0 / static_cast<double>(ring.size());
            glm::dvec3 difference = -value(vertex);
            for (const uint32_t n : ring) difference += share * value(n);
            add(vertex, -difference);
            for (const uint32_t n : ring) add(n, share * difference);
        }
        return sum;
    }

    static double dot(const std::vector<glm::dvec3>& a, const std::vector<glm::dvec3>& b) {
        double sum = 0.0;
        for (size_t k = 0; k < a.size(); ++k) sum += glm::dot(a[k], b[k]);
        return sum;
    }

    std::span<const glm::dvec3> positions_;
    const Neighbours& neighbours_;
    const Taken& taken_;
    Remeshed result_;
    std::map<uint32_t, double> length_; // per vertex: of the edges that suit it
    std::vector<std::pair<uint32_t, std::vector<uint32_t>>> rings_;
};

} // namespace

Neighbours::Neighbours(const TriangleMesh& mesh) : begin_(mesh.positions.size() + 1, 0) {
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) begin_[t[k] + 1] += 2;
    for (size_t v = 1; v < begin_.size(); ++v) begin_[v] += begin_[v - 1];
    neighbours_.resize(begin_.back());
    std::vector<uint32_t> end(begin_.begin(), begin_.end() - 1);
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k)
            for (const int other : {1, 2}) neighbours_[end[t[k]]++] = t[(k + other) % 3];
}

std::span<const uint32_t> Neighbours::of(uint32_t vertex) const {
    if (vertex + 1 >= begin_.size()) return {};
    return std::span(neighbours_).subspan(begin_[vertex], begin_[vertex + 1] - begin_[vertex]);
}

Remeshed remesh_fill(std::span<const glm::dvec3> positions, std::span<const Triangle> fill,
                     const Neighbours& neighbours, const Taken& taken, bool smooth) {
    Remesher remesher(positions, fill, neighbours, taken);
    remesher.refine();
    if (smooth) remesher.smooth();
    return remesher.take();
}

} // namespace brittle::fracture::mending

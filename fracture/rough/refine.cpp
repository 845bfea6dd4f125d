#include "fracture/rough/refine.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include <glm/geometric.hpp>

namespace brittle::fracture::rough {

double SurfaceRefiner::power(uint32_t site, const glm::dvec3& p) const {
    const glm::dvec3 d = p - sites_.positions[site];
    return glm::dot(d, d) - (sites_.weights.empty() ? 0.0 : sites_.weights[site]);
}

// Returns whether a bisector between two cells passes through a ball. The nearest bisector is one of the nearest site's:
// a cell of another group that reaches into the ball is cut off there by the cell around the centre.
bool SurfaceRefiner::meets_cut(const glm::dvec3& centre, double radius, const Part& part) const {
    uint32_t nearest = candidates_[part.candidates_begin];
    double least = power(nearest, centre);
    for (uint32_t k = part.candidates_begin + 1; k < part.candidates_end; ++k) {
        const double p = power(candidates_[k], centre);
        if (p < least) {
            least = p;
            nearest = candidates_[k];
        }
    }
    for (uint32_t k = part.candidates_begin; k < part.candidates_end; ++k) {
        const uint32_t c = candidates_[k];
        const double lead = power(c, centre) - least, limit = 2.0 * radius;
        if (share_group(c, nearest)) continue;
        const glm::dvec3 d = sites_.positions[c] - sites_.positions[nearest];
        if (lead * lead <= limit * limit * glm::dot(d, d)) return true;
    }
    return false;
}

// The part with those of its parent's candidates whose cells may come near: within the balls that meets_cut() tests.
SurfaceRefiner::Part SurfaceRefiner::narrow(const Triangle& corners, uint32_t begin, uint32_t end, const Surface& out) {
    const glm::dvec3 &a = out.positions[corners.x], &b = out.positions[corners.y], &c = out.positions[corners.z];
    const glm::dvec3 centre = (a + b + c) / 3.0;
    const double longest = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
    const double limit = 2.0 * (2.0 * longest + 2.0 * warp_->reach());
    uint32_t nearest = candidates_[begin];
    double least = power(nearest, centre);
    for (uint32_t k = begin + 1; k < end; ++k) {
        const double p = power(candidates_[k], centre);
        if (p < least) {
            least = p;
            nearest = candidates_[k];
        }
    }
    Part part{corners, static_cast<uint32_t>(candidates_.size()), 0};
    for (uint32_t k = begin; k < end; ++k) {
        const uint32_t site = candidates_[k];
        const double lead = power(site, centre) - least;
        const glm::dvec3 d = sites_.positions[site] - sites_.positions[nearest];
        if (site == nearest || lead * lead <= limit * limit * glm::dot(d, d)) candidates_.push_back(site);
    }
    part.candidates_end = static_cast<uint32_t>(candidates_.size());
    return part;
}

// Returns the vertex that halves an edge, or no_index where the edge stays whole.
uint32_t SurfaceRefiner::midpoint(uint32_t a, uint32_t b, const Part& part, Surface& out) {
    if (is_far(a) || is_far(b)) return no_index;
    const double length = glm::distance(out.positions[a], out.positions[b]);
    if (!(length > 1.5 * spacing_)) return no_index;
    const uint64_t key = uint64_t{std::min(a, b)} << 32 | std::max(a, b);
    const auto [at, is_new] = midpoints_.try_emplace(key, no_index);
    if (!is_new) return at->second;
    const glm::dvec3 middle = 0.5 * (out.positions[a] + out.positions[b]);
    const glm::dvec3 warped = warp_->apply(middle);
    if (!meets_cut(warped, length, part)) return no_index;
    at->second = static_cast<uint32_t>(out.positions.size());
    out.positions.push_back(middle);
    out.warped.positions.push_back(warped);
    return at->second;
}

void SurfaceRefiner::divide(const Part& whole, uint32_t source, Surface& out) {
    parts_.assign(1, whole);
    while (!parts_.empty()) {
        const Part part = parts_.back();
        parts_.pop_back();
        candidates_.resize(part.candidates_end); // the parts that remain are older, with candidates before these
        const Triangle& t = part.corners;
        std::array<uint32_t, 3> halves{no_index, no_index, no_index}; // of the edges xy, yz, zx
        if (part.candidates_end - part.candidates_begin > 1)
            for (int k = 0; k < 3; ++k) halves[k] = midpoint(t[k], t[(k + 1) % 3], part, out);
        const int count =
            static_cast<int>(std::count_if(halves.begin(), halves.end(), [](uint32_t h) { return h != no_index; }));
        if (count == 0) {
            out.warped.triangles.push_back(t);
            out.source.push_back(source);
            if (out.source.size() > max_triangles_) return;
            continue;
        }
        const auto add = [&](uint32_t a, uint32_t b, uint32_t c) {
            parts_.push_back(narrow({a, b, c}, part.candidates_begin, part.candidates_end, out));
        };
        if (count == 3) {
            add(halves[0], halves[1], halves[2]);
            for (int k = 0; k < 3; ++k) add(t[k], halves[k], halves[(k + 2) % 3]);
            continue;
        }
        // Turned so that edge a b is halved, and of two halved edges the other one is b c.
        int first = 0;
        while (halves[first] == no_index || (count == 2 && halves[(first + 1) % 3] == no_index)) ++first;
        const uint32_t a = t[first], b = t[(first + 1) % 3], c = t[(first + 2) % 3], ab = halves[first];
        if (count == 1) {
            add(a, ab, c);
            add(ab, b, c);
            continue;
        }
        const uint32_t bc = halves[(first + 1) % 3];
        add(ab, b, bc);
        if (glm::distance(out.positions[a], out.positions[bc]) < glm::distance(out.positions[ab], out.positions[c])) {
            add(a, ab, bc);
            add(a, bc, c);
        } else {
            add(a, ab, c);
            add(ab, bc, c);
        }
    }
}

bool SurfaceRefiner::run(const TriangleMesh& mesh, std::vector<glm::dvec3> warped_positions,
                         std::span<const uint8_t> far, const Warp& warp, const WarpedSites& sites, double spacing,
                         size_t max_triangles, Surface& out) {
    warp_ = &warp;
    far_ = far;
    sites_ = sites;
    spacing_ = spacing;
    max_triangles_ = max_triangles;
    midpoints_.clear();
    out.positions.assign(mesh.positions.begin(), mesh.positions.end());
    out.warped.positions = std::move(warped_positions);
    out.warped.triangles.clear();
    out.source.clear();
    const auto is_long = [&](const Triangle& t) {
        for (int k = 0; k < 3; ++k) {
            const uint32_t a = t[k], b = t[(k + 1) % 3];
            if (!is_far(a) && !is_far(b) && glm::distance(mesh.positions[a], mesh.positions[b]) > 1.5 * spacing)
                return true;
        }
        return false;
    };
    if (sites.positions.size() < 2 || std::none_of(mesh.triangles.begin(), mesh.triangles.end(), is_long)) {
        out.warped.triangles = mesh.triangles;
        return true;
    }
    candidates_.resize(sites.positions.size());
    std::iota(candidates_.begin(), candidates_.end(), 0u);
    const auto all = static_cast<uint32_t>(candidates_.size());
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        candidates_.resize(all);
        if (is_long(mesh.triangles[t])) {
            divide(narrow(mesh.triangles[t], 0, all, out), t, out);
            if (out.source.size() > max_triangles) return false;
        } else {
            out.warped.triangles.push_back(mesh.triangles[t]);
            out.source.push_back(t);
        }
    }
    return true;
}

} // namespace brittle::fracture::rough

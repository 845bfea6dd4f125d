#include "fracture/exact/cells.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include <glm/common.hpp>

#include "fracture/base/simd.h"

namespace brittle::fracture::exact {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// The bound of side4_filter() is 32u (|h| pw + |n| px) for the homogeneous vertex; the division by w adds less than 4u.
constexpr double vertex_error = 0x28.0p-53;

// Below this ratio of w to its permanent, the position of a vertex has too few digits to bound the reach of the cell.
constexpr double min_reliable_ratio = 1e-9;

// The factor on the security radius that covers the rounding of reliable positions.
constexpr double reach_slack = 1.0 + 1e-6;

} // namespace

namespace simd {

// Computes the values of the plane at n vertices and their error bounds. Returns the number of values that are not
// certainly positive.
BRITTLE_SIMD uint64_t plane_values(const double* x, const double* y, const double* z, const double* ew,
                                   const double* ex, uint32_t n, const Bisector& l, double* value, double* bound) {
    const double nx = l.n.x, ny = l.n.y, nz = l.n.z, h = l.h, ah = l.magnitude(), length = l.length;
    uint64_t doubtful = 0;
    for (uint32_t v = 0; v < n; ++v) {
        const double g = h - (nx * x[v] + ny * y[v] + nz * z[v]);
        const double e = ah * ew[v] + length * ex[v];
        value[v] = g;
        bound[v] = e;
        doubtful += g > e ? uint64_t{0} : uint64_t{1};
    }
    return doubtful;
}

BRITTLE_SIMD double largest_norm2(const double* x, const double* y, const double* z, uint32_t n) {
    double most[4] = {0.0, 0.0, 0.0, 0.0};
    uint32_t v = 0;
    for (; v + 4 <= n; v += 4) {
        for (uint32_t k = 0; k < 4; ++k) {
            const double r = x[v + k] * x[v + k] + y[v + k] * y[v + k] + z[v + k] * z[v + k];
            most[k] = r > most[k] ? r : most[k];
        }
    }
    for (; v < n; ++v) most[0] = std::max(most[0], x[v] * x[v] + y[v] * y[v] + z[v] * z[v]);
    return std::max(std::max(most[0], most[1]), std::max(most[2], most[3]));
}

// The bounding box of all balls with a vertex as centre and the origin on their surface; `more` is added to their
// squared radii.
BRITTLE_SIMD void ball_box(const double* x, const double* y, const double* z, uint32_t n, double more, glm::dvec3& low,
                           glm::dvec3& high) {
    glm::dvec3 least(0.0), most(0.0);
    for (uint32_t v = 0; v < n; ++v) {
        const double r = std::sqrt(x[v] * x[v] + y[v] * y[v] + z[v] * z[v] + more);
        least.x = x[v] - r < least.x ? x[v] - r : least.x;
        least.y = y[v] - r < least.y ? y[v] - r : least.y;
        least.z = z[v] - r < least.z ? z[v] - r : least.z;
        most.x = x[v] + r > most.x ? x[v] + r : most.x;
        most.y = y[v] + r > most.y ? y[v] + r : most.y;
        most.z = z[v] + r > most.z ? z[v] + r : most.z;
    }
    low = least;
    high = most;
}

} // namespace simd

Box CellBuilder::facet_box(uint32_t plane) const {
    glm::dvec3 low(infinity), high(-infinity);
    for (size_t v = 0; v < used_vertices_.size(); ++v) {
        const auto& [a, b, d] = used_vertices_[v];
        if (a != plane && b != plane && d != plane) continue;
        const glm::dvec3 position(x_[v], y_[v], z_[v]);
        low = glm::min(low, position - ex_[v]); // the error of a coordinate is that of a plane of unit normal
        high = glm::max(high, position + ex_[v]);
    }
    return {diagram_->sites[c_] + low, diagram_->sites[c_] + high};
}

bool CellBuilder::build(const Diagram& diagram, const SiteTree& tree, SiteId c) {
    diagram_ = &diagram;
    c_ = c;
    used_planes_.clear();
    used_vertices_.clear();
    if (!tree.owns_cell(c)) return false;
    advantage_ = diagram.weights.empty() ? 0.0 : tree.max_weight() - diagram.weights[c];
    start_with_box();
    SiteTree::Walk walk(tree, diagram.sites[c], c, walk_memory_);
    SiteTree::Reach within = reach();
    while (walk.next(within)) {
        double nearest_idle2 = within.radius2;
        bool has_changed = false;
        for (const SiteTree::Candidate& candidate : walk.batch()) {
            if (candidate.distance2 > nearest_idle2) break; // sorted, so the rest is no nearer
            const Cut result = cut(candidate.site);
            if (result == Cut::all) return false;
            if (result == Cut::none) continue;
            nearest_idle2 = security2();
            has_changed = true;
        }
        if (has_changed) within = reach();
    }
    collect();
    return true;
}

void CellBuilder::start_with_box() {
    plane_id_.clear();
    plane_.clear();
    for (uint32_t k = 0; k < 6; ++k) {
        plane_id_.push_back(box_min_x + k);
        plane_.push_back(make_box_plane(diagram_->sites[c_], diagram_->box, box_min_x + k));
    }
    count_ = 0;
    unreliable_ = 0;
    // Corner (sx,sy,sz), bit 1 for the maximum: the normals have the determinant sx*sy*sz, which gives the order of
    // planes.
    for (uint32_t corner = 0; corner < 8; ++corner) {
        const uint32_t px = corner & 1u, py = 2 + ((corner >> 1) & 1u), pz = 4 + ((corner >> 2) & 1u);
        const bool positive = ((px + py + pz) & 1u) != 0; // one or three maxima
        const uint32_t v = count_++;
        if (positive)
            place_vertex(v, px, py, pz);
        else
            place_vertex(v, px, pz, py);
        // The edge between two planes runs along the third axis: the corner with that bit flipped.
        const uint32_t along_x = corner ^ 1u, along_y = corner ^ 2u, along_z = corner ^ 4u;
        beside_[v] = positive ? std::array{along_z, along_x, along_y} : std::array{along_y, along_x, along_z};
    }
}

void CellBuilder::place_vertex(uint32_t v, uint32_t a, uint32_t b, uint32_t d) {
    if (v >= corner_.size()) {
        const size_t size = std::max<size_t>(64, 2 * corner_.size());
        for (auto* array : {&x_, &y_, &z_, &ew_, &ex_, &value_, &bound_}) array->resize(size);
        corner_.resize(size);
        beside_.resize(size);
        is_removed_.resize(size, 0);
    }
    const CellVertex vertex = make_cell_vertex(plane_[a], plane_[b], plane_[d]);
    corner_[v] = {a, b, d};
    if (vertex.w > min_reliable_ratio * vertex.pw) {
        const double inverse = 1.0 / vertex.w;
        x_[v] = vertex.x.x * inverse;
        y_[v] = vertex.x.y * inverse;
        z_[v] = vertex.x.z * inverse;
        ew_[v] = vertex_error * vertex.pw * inverse;
        ex_[v] = vertex_error * vertex.px * inverse;
    } else { // every filter is uncertain, and the reach is unbounded
        x_[v] = y_[v] = z_[v] = 0.0;
        ew_[v] = ex_[v] = infinity;
        ++unreliable_;
    }
}

double CellBuilder::security2() const {
    if (unreliable_ > 0) return infinity;
    const double norm2 = simd::largest_norm2(x_.data(), y_.data(), z_.data(), count_);
    if (advantage_ == 0.0) return 4.0 * reach_slack * norm2;
    const double radius = std::sqrt(norm2) + std::sqrt(norm2 + advantage_);
    return reach_slack * radius * radius;
}

SiteTree::Reach CellBuilder::reach() const {
    SiteTree::Reach result{security2(), glm::dvec3(-infinity), glm::dvec3(infinity)};
    if (unreliable_ > 0) return result;
    simd::ball_box(x_.data(), y_.data(), z_.data(), count_, advantage_, result.low, result.high);
    const double slack = (reach_slack - 1.0) * std::sqrt(result.radius2);
    result.low -= slack;
    result.high += slack;
    return result;
}

CellBuilder::Cut CellBuilder::find_removed(const Bisector& l, SiteId site) {
    const uint64_t doubtful = simd::plane_values(x_.data(), y_.data(), z_.data(), ew_.data(), ex_.data(), count_, l,
                                                 value_.data(), bound_.data());
    if (doubtful == 0) return Cut::none;
    removed_.clear();
    for (uint32_t v = 0; v < count_; ++v) {
        if (value_[v] > bound_[v]) continue;
        if (!(value_[v] < -bound_[v])) {
            const auto& [a, b, d] = corner_[v];
            if (side4_exact(*diagram_, c_, plane_id_[a], plane_id_[b], plane_id_[d], site, stats) > 0) continue;
        }
        removed_.push_back(v);
    }
    if (removed_.empty()) return Cut::none;
    return removed_.size() == count_ ? Cut::all : Cut::some;
}

CellBuilder::Cut CellBuilder::cut(SiteId site) {
    const Bisector l = make_bisector(*diagram_, c_, site);
    const Cut result = find_removed(l, site);
    if (result != Cut::some) return result;
    const auto slot = static_cast<uint32_t>(plane_.size());
    plane_.push_back(l);
    plane_id_.push_back(site);
    replace_removed(slot);
    return result;
}

void CellBuilder::replace_removed(uint32_t new_slot) {
    for (const uint32_t v : removed_) is_removed_[v] = 1;
    rim_.clear();
    for (const uint32_t v : removed_) {
        for (uint32_t e = 0; e < 3; ++e) {
            const uint32_t u = beside_[v][e];
            if (is_removed_[u]) continue;
            const uint32_t p = corner_[v][e], q = corner_[v][(e + 1) % 3];
            const auto& other = corner_[u];
            const uint32_t corner = other[0] == q ? 0 : (other[1] == q ? 1 : 2);
            assert(other[corner] == q && other[(corner + 1) % 3] == p);
            rim_.push_back({p, q, u, corner, 0});
        }
        if (ew_[v] == infinity) --unreliable_;
    }
    for (const uint32_t v : removed_) is_removed_[v] = 0;

    at_plane_.resize(plane_.size());
    // New vertices reuse the places of removed ones first.
    size_t reused = 0;
    for (RimEdge& edge : rim_) {
        const uint32_t v = reused < removed_.size() ? removed_[reused++] : count_++;
        place_vertex(v, edge.p, edge.q, new_slot);
        beside_[v][0] = edge.kept;
        beside_[edge.kept][edge.corner] = v;
        at_plane_[edge.p] = v;
        edge.added = v;
    }
    for (const RimEdge& edge : rim_) {
        const uint32_t next = at_plane_[edge.q];
        beside_[edge.added][1] = next;
        beside_[next][2] = edge.added;
    }
    // Where fewer vertices were added than removed, the last vertices fill the gaps, from the back (removed_ ascends).
    for (size_t k = removed_.size(); k > reused; --k) erase(removed_[k - 1]);
}

void CellBuilder::erase(uint32_t hole) {
    const uint32_t last = --count_;
    if (hole == last) return;
    x_[hole] = x_[last];
    y_[hole] = y_[last];
    z_[hole] = z_[last];
    ew_[hole] = ew_[last];
    ex_[hole] = ex_[last];
    corner_[hole] = corner_[last];
    beside_[hole] = beside_[last];
    for (const uint32_t u : beside_[hole]) {
        for (uint32_t& w : beside_[u]) {
            if (w == last) w = hole;
        }
    }
}

void CellBuilder::collect() {
    slot_rank_.assign(plane_.size(), 0);
    for (uint32_t v = 0; v < count_; ++v) {
        for (const uint32_t slot : corner_[v]) slot_rank_[slot] = 1;
    }
    slot_order_.clear();
    for (uint32_t slot = 0; slot < plane_.size(); ++slot) {
        if (slot_rank_[slot]) slot_order_.push_back(slot);
    }
    std::sort(slot_order_.begin(), slot_order_.end(),
              [&](uint32_t a, uint32_t b) { return plane_id_[a] < plane_id_[b]; });
    for (uint32_t rank = 0; rank < slot_order_.size(); ++rank) {
        slot_rank_[slot_order_[rank]] = rank;
        used_planes_.push_back(plane_id_[slot_order_[rank]]);
    }
    for (uint32_t v = 0; v < count_; ++v) {
        const auto& [a, b, d] = corner_[v];
        used_vertices_.push_back({slot_rank_[a], slot_rank_[b], slot_rank_[d]});
    }
}

} // namespace brittle::fracture::exact

#include "fracture/triangulation/simple_loop.h"

#include <algorithm>
#include <cmath>

#include "fracture/base/simd.h"

namespace brittle::fracture::triangulation {

namespace {

// Each ear is tested against every concave vertex; with more of them than this, Ring with its grid is faster.
constexpr size_t max_concave = 48;

// A sequence of flips ends by itself in exact arithmetic. The bound guards against rounding.
constexpr uint32_t max_flips_per_triangle = 16;

// The least in_circle() that flips a diagonal: flips serve the shape of triangles only, so ties and near-ties stay.
constexpr double min_flip_gain = 1e-9;

// The side of the line ab that c lies on: 1 left, -1 right, 0 where rounding could decide. Shewchuk's bound for the
// first stage, (3 + 16u)u times the sum of the products' magnitudes with u = 2^-53, rounded up to 4u. orientation()
// (plane_predicates.h) would decide the rest exactly; this fast path leaves it to Ring.
constexpr double turn_error = 0x4.0p-53;
int turn(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    const double left = (a.x - c.x) * (b.y - c.y), right = (a.y - c.y) * (b.x - c.x);
    const double bound = turn_error * (std::abs(left) + std::abs(right));
    const double area = left - right;
    return area > bound ? 1 : (area < -bound ? -1 : 0);
}

// Whether d lies inside the circle through a, b, c: the in-circle determinant, divided by the sum of its terms'
// magnitudes, exceeds min_flip_gain.
bool is_in_circle(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& d) {
    const glm::dvec2 p = a - d, q = b - d, r = c - d;
    const double p2 = p.x * p.x + p.y * p.y, q2 = q.x * q.x + q.y * q.y, r2 = r.x * r.x + r.y * r.y;
    const double one = p2 * (q.x * r.y - q.y * r.x), two = q2 * (r.x * p.y - r.y * p.x),
                 three = r2 * (p.x * q.y - p.y * q.x);
    const double sum = one + two + three;
    return sum > 0.0 && sum / (std::abs(one) + std::abs(two) + std::abs(three)) > min_flip_gain;
}

// Returns the number of points that do not certainly lie outside the triangle a, b, c; without the vertices v and w.
BRITTLE_SIMD uint64_t points_inside(const double* x, const double* y, const uint64_t* vertex, size_t count, uint64_t v,
                                    uint64_t w, const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    const double ax = a.x, ay = a.y, bx = b.x, by = b.y, cx = c.x, cy = c.y;
    // 1 where turn() is negative.
    const auto right_of = [](double px, double py, double qx, double qy, double rx, double ry) {
        const double left = (px - rx) * (qy - ry), right = (py - ry) * (qx - rx);
        return left - right < -turn_error * (std::abs(left) + std::abs(right)) ? uint64_t{1} : uint64_t{0};
    };
    uint64_t inside = 0;
    for (size_t k = 0; k < count; ++k) {
        const uint64_t outside = right_of(ax, ay, bx, by, x[k], y[k]) | right_of(bx, by, cx, cy, x[k], y[k])
                                 | right_of(cx, cy, ax, ay, x[k], y[k]);
        const uint64_t skipped =
            (vertex[k] == v ? uint64_t{1} : uint64_t{0}) | (vertex[k] == w ? uint64_t{1} : uint64_t{0});
        inside += 1 - (outside | skipped);
    }
    return inside;
}

uint32_t after(uint32_t half_edge) {
    return half_edge % 3 == 2 ? half_edge - 2 : half_edge + 1;
}

} // namespace

bool SimpleLoop::find_concave(std::span<const glm::dvec2> points) {
    const auto n = static_cast<uint32_t>(points.size());
    next_.resize(n);
    prev_.resize(n);
    turn_.resize(n);
    outer_.assign(n, no_index);
    concave_.clear();
    concave_x_.clear();
    concave_y_.clear();
    double area = 0.0; // twice the loop's: the sum of triangles that all turn left is positive
    for (uint32_t v = 0; v < n; ++v) {
        next_[v] = v + 1 == n ? 0 : v + 1;
        prev_[v] = v == 0 ? n - 1 : v - 1;
        turn_[v] = static_cast<int8_t>(turn(points[prev_[v]], points[v], points[next_[v]]));
        if (turn_[v] == 0) return false;
        if (turn_[v] < 0) {
            concave_.push_back(v);
            concave_x_.push_back(points[v].x);
            concave_y_.push_back(points[v].y);
        }
        const glm::dvec2 a = points[v] - points[0], b = points[next_[v]] - points[0];
        area += a.x * b.y - a.y * b.x;
    }
    return area > 0.0 && concave_.size() <= max_concave;
}

bool SimpleLoop::is_ear(std::span<const glm::dvec2> points, uint32_t v) const {
    const uint32_t a = prev_[v], b = next_[v];
    return points_inside(concave_x_.data(), concave_y_.data(), concave_.data(), concave_.size(), a, b, points[a],
                         points[v], points[b])
           == 0;
}

void SimpleLoop::remove_concave(uint32_t v) {
    const auto k = static_cast<size_t>(std::find(concave_.begin(), concave_.end(), v) - concave_.begin());
    concave_[k] = concave_.back();
    concave_x_[k] = concave_x_.back();
    concave_y_[k] = concave_y_.back();
    concave_.pop_back();
    concave_x_.pop_back();
    concave_y_.pop_back();
}

void SimpleLoop::cut(uint32_t v) {
    const uint32_t a = prev_[v], b = next_[v];
    const auto h = static_cast<uint32_t>(twin_.size());
    corner_.insert(corner_.end(), {a, v, b});
    twin_.insert(twin_.end(), {outer_[a], outer_[v], no_index});
    if (outer_[a] != no_index) twin_[outer_[a]] = h;
    if (outer_[v] != no_index) twin_[outer_[v]] = h + 1;
    outer_[a] = h + 2;
    next_[a] = b;
    prev_[b] = a;
}

bool SimpleLoop::cut_ears(std::span<const glm::dvec2> points) {
    corner_.clear();
    twin_.clear();
    uint32_t left = static_cast<uint32_t>(points.size());
    uint32_t v = 0;
    for (uint32_t in_vain = 0; left > 3;) {
        if (turn_[v] <= 0 || !is_ear(points, v)) {
            v = next_[v];
            if (++in_vain > left) return false;
            continue;
        }
        const uint32_t a = prev_[v], b = next_[v];
        cut(v);
        --left;
        in_vain = 0;
        for (const uint32_t w : {a, b}) {
            // A concave vertex may become convex; a convex one that becomes concave shows that the loop crosses itself.
            const int now = turn(points[prev_[w]], points[w], points[next_[w]]);
            if (now == 0) return false;
            if (now < 0 && turn_[w] > 0) return false;
            if (now > 0 && turn_[w] < 0) remove_concave(w);
            turn_[w] = static_cast<int8_t>(now);
        }
        v = next_[b]; // ears side by side would make a fan of slivers
    }
    if (turn(points[prev_[v]], points[v], points[next_[v]]) <= 0) return false;
    const uint32_t closing = outer_[next_[v]];
    cut(v);
    const uint32_t last = static_cast<uint32_t>(twin_.size()) - 1;
    twin_[last] = closing;
    if (closing != no_index) twin_[closing] = last;
    return true;
}

bool SimpleLoop::flip_edge(std::span<const glm::dvec2> points, uint32_t h) {
    // Triangles (a,b,c) and (b,a,d) become (d,b,c) and (c,a,d).
    const uint32_t t = twin_[h];
    if (t == no_index) return false;
    const uint32_t h1 = after(h), h2 = after(h1), t1 = after(t), t2 = after(t1);
    const uint32_t a = corner_[h], b = corner_[t], c = corner_[h2], d = corner_[t2];
    if (!is_in_circle(points[a], points[b], points[c], points[d])) return false;
    if (turn(points[d], points[b], points[c]) <= 0 || turn(points[c], points[a], points[d]) <= 0) return false;
    const uint32_t across_ad = twin_[t1], across_bc = twin_[h1];
    corner_[h] = d;
    corner_[t] = c;
    // h: d->b, h1: b->c, h2: c->d;  t: c->a, t1: a->d, t2: d->c.
    corner_[h1] = b;
    corner_[t1] = a;
    const uint32_t across_db = twin_[t2], across_ca = twin_[h2];
    const auto join = [&](uint32_t x, uint32_t y) {
        twin_[x] = y;
        if (y != no_index) twin_[y] = x;
    };
    join(h, across_db);
    join(h1, across_bc);
    join(t, across_ca);
    join(t1, across_ad);
    join(h2, t2);
    for (const uint32_t e : {h, h1, t, t1}) pending_.push_back(e);
    return true;
}

void SimpleLoop::flip_edges(std::span<const glm::dvec2> points) {
    pending_.clear();
    for (uint32_t h = 0; h < twin_.size(); ++h) {
        if (twin_[h] != no_index && twin_[h] < h) pending_.push_back(h);
    }
    for (size_t flips = max_flips_per_triangle * (corner_.size() / 3); !pending_.empty() && flips > 0;) {
        const uint32_t h = pending_.back();
        pending_.pop_back();
        if (flip_edge(points, h)) --flips;
    }
}

bool SimpleLoop::triangulate(std::span<const glm::dvec2> points, std::span<const uint32_t> ids,
                             std::vector<Triangle>& out) {
    if (!find_concave(points) || !cut_ears(points)) return false;
    flip_edges(points);
    for (size_t h = 0; h < corner_.size(); h += 3)
        out.push_back({ids[corner_[h]], ids[corner_[h + 1]], ids[corner_[h + 2]]});
    return true;
}

} // namespace brittle::fracture::triangulation

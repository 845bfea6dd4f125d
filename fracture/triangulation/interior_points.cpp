#include "fracture/triangulation/interior_points.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "fracture/arithmetic/plane_predicates.h"

namespace brittle::fracture {

namespace {

// The least distance of a new point from the points of the border, in spacings. Below it, triangles at the border
// become thin; far above it, a gap opens.
constexpr double min_distance = 0.6;

// The least distance from the edges of the border, in spacings.
constexpr double min_height = 0.3;

constexpr double row_height = 0.8660254037844386; // of the lattice, in spacings: sqrt(3) / 2

// The cosine of the angle up to which two normals belong to one flat part of a surface: 18 degrees.
constexpr double min_cosine = 0.95;

// More lattice points than this along one axis are a spacing that no caller means; the loop would not end.
constexpr double max_rows = 1 << 14;

uint32_t next(uint32_t half) {
    return half % 3 == 2 ? half - 2 : half + 1;
}

} // namespace

// Fills inside_: the lattice points inside the loops, row by row.
void InteriorPoints::place_points(std::span<const Loop> loops, double spacing, std::span<const glm::dvec2> border) {
    inside_.clear();
    segments_.clear();
    glm::dvec2 low(border[loops[0][0]]), high(low);
    for (const Loop& loop : loops) {
        for (size_t k = 0; k < loop.size(); ++k) {
            segments_.push_back({loop[k], loop[k + 1 == loop.size() ? 0 : k + 1]});
            const glm::dvec2& p = border[loop[k]];
            low = {std::min(low.x, p.x), std::min(low.y, p.y)};
            high = {std::max(high.x, p.x), std::max(high.y, p.y)};
        }
    }
    const glm::dvec2 size = high - low;
    const double row = row_height * spacing;
    if (!(std::min(size.x, size.y) > 2.0 * min_distance * spacing)) return;
    if (!(std::max(size.x, size.y) < max_rows * row)) return;
    const auto rows = static_cast<uint32_t>(size.y / row);
    const auto columns = static_cast<uint32_t>(size.x / spacing);

    // The border points by square bins of one spacing.
    const uint32_t across = columns + 1, up = static_cast<uint32_t>(size.y / spacing) + 1;
    const auto bin_of = [&](double x, uint32_t count) {
        return std::min(static_cast<uint32_t>(x / spacing), count - 1);
    };
    const auto bin = [&](const glm::dvec2& p) {
        return bin_of(p.y - low.y, up) * across + bin_of(p.x - low.x, across);
    };
    bin_begin_.assign(size_t{across} * up + 2, 0);
    for (const auto& segment : segments_) ++bin_begin_[bin(border[segment[0]]) + 2];
    for (size_t k = 2; k < bin_begin_.size(); ++k) bin_begin_[k] += bin_begin_[k - 1];
    bins_.resize(segments_.size());
    for (const auto& segment : segments_) bins_[bin_begin_[bin(border[segment[0]]) + 1]++] = segment[0];
    const double least = min_distance * min_distance * spacing * spacing;
    const auto is_clear = [&](const glm::dvec2& p) {
        const uint32_t bx = bin_of(p.x - low.x, across), by = bin_of(p.y - low.y, up);
        for (uint32_t y = by - std::min(by, 1u); y <= std::min(by + 1, up - 1); ++y) {
            for (uint32_t x = bx - std::min(bx, 1u); x <= std::min(bx + 1, across - 1); ++x) {
                for (uint32_t k = bin_begin_[y * across + x]; k < bin_begin_[y * across + x + 1]; ++k) {
                    const glm::dvec2 d = border[bins_[k]] - p;
                    if (d.x * d.x + d.y * d.y < least) return false;
                }
            }
        }
        return true;
    };

    // The segments by the rows that they cross or come near to.
    const double first_row = 0.5 * (size.y - row * rows) + low.y;
    const auto row_from = [&](double y) { // the first row at or above y
        const double k = std::ceil((y - first_row) / row);
        return k <= 0.0 ? 0u : std::min(static_cast<uint32_t>(k), rows + 1);
    };
    const double height = min_height * spacing;
    row_begin_.assign(rows + 3, 0);
    for (int pass = 0; pass < 2; ++pass) {
        for (uint32_t s = 0; s < segments_.size(); ++s) {
            const auto [bottom, top] = std::minmax(border[segments_[s][0]].y, border[segments_[s][1]].y);
            for (uint32_t r = row_from(bottom - height); r < row_from(top + height); ++r) {
                if (pass == 0)
                    ++row_begin_[r + 2];
                else
                    row_segments_[row_begin_[r + 1]++] = s;
            }
        }
        if (pass == 1) break;
        for (size_t r = 2; r < row_begin_.size(); ++r) row_begin_[r] += row_begin_[r - 1];
        row_segments_.resize(row_begin_.back());
    }
    for (uint32_t r = 0; r <= rows; ++r) {
        const double y = first_row + row * r;
        crossings_.clear();
        too_near_.clear();
        for (uint32_t k = row_begin_[r]; k < row_begin_[r + 1]; ++k) {
            const glm::dvec2 &a = border[segments_[row_segments_[k]][0]], &b = border[segments_[row_segments_[k]][1]];
            const double at = a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y));
            if (row_from(std::min(a.y, b.y)) <= r && r < row_from(std::max(a.y, b.y))) crossings_.push_back(at);
            // The part of the row within the height of the line, and no farther than it beyond the ends.
            const double reach = height * glm::distance(a, b) / std::abs(b.y - a.y);
            double from = std::min(a.x, b.x) - height, to = std::max(a.x, b.x) + height;
            if (at - reach > from) from = at - reach; // false for a segment along the row
            if (at + reach < to) to = at + reach;
            if (from < to) too_near_.push_back({from, to});
        }
        std::sort(crossings_.begin(), crossings_.end());
        std::sort(too_near_.begin(), too_near_.end());
        size_t passed = 0; // the intervals that begin before the point
        double blocked_to = low.x - spacing;
        const double shift = 0.5 * (size.x - spacing * columns) + (r % 2 == 0 ? 0.0 : -0.5 * spacing) + low.x;
        const size_t begin = inside_.size();
        for (size_t k = 0; k + 1 < crossings_.size(); k += 2) {
            auto column = static_cast<int64_t>(std::ceil((crossings_[k] - shift) / spacing));
            for (;; ++column) {
                const glm::dvec2 p(shift + spacing * static_cast<double>(column), y);
                if (!(p.x < crossings_[k + 1])) break;
                for (; passed < too_near_.size() && too_near_[passed][0] <= p.x; ++passed)
                    blocked_to = std::max(blocked_to, too_near_[passed][1]);
                if (p.x > blocked_to && is_clear(p)) inside_.push_back(p);
            }
        }
        // Rows in alternating directions: each point is near the last.
        if (r % 2 == 1) std::reverse(inside_.begin() + begin, inside_.end());
    }
}

void InteriorPoints::find_twins(std::span<const Triangle> triangles) {
    sorted_.clear();
    for (uint32_t t = 0; t < triangles.size(); ++t) {
        for (uint32_t k = 0; k < 3; ++k) {
            const uint32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
            sorted_.push_back({std::min(a, b), std::max(a, b), 3 * t + k});
        }
    }
    std::sort(sorted_.begin(), sorted_.end());
    twin_.assign(3 * triangles.size(), no_index);
    for (size_t k = 0; k + 1 < sorted_.size(); ++k) {
        if (sorted_[k][0] != sorted_[k + 1][0] || sorted_[k][1] != sorted_[k + 1][1]) continue;
        twin_[sorted_[k][2]] = sorted_[k + 1][2];
        twin_[sorted_[k + 1][2]] = sorted_[k][2];
    }
}

// Returns the triangle around a point, by a walk from the last one; no_index where the walk leaves the region or does
// not end.
uint32_t InteriorPoints::locate(uint32_t point, std::span<const glm::dvec2> points,
                                std::span<const Triangle> triangles) const {
    uint32_t t = near_;
    for (size_t rounds = 0; rounds <= triangles.size(); ++rounds) {
        uint32_t exit = no_index;
        for (uint32_t k = 0; k < 3 && exit == no_index; ++k) {
            const uint32_t side = static_cast<uint32_t>((k + rounds) % 3);
            if (orientation(points[triangles[t][side]], points[triangles[t][(side + 1) % 3]], points[point]) < 0.0)
                exit = side;
        }
        if (exit == no_index) return t;
        if (twin_[3 * t + exit] == no_index) break;
        t = twin_[3 * t + exit] / 3;
    }
    // The region need not be convex: a walk may end at its border.
    for (t = 0; t < triangles.size(); ++t) {
        const auto& c = triangles[t];
        if (orientation(points[c.x], points[c.y], points[point]) >= 0.0
            && orientation(points[c.y], points[c.z], points[point]) >= 0.0
            && orientation(points[c.z], points[c.x], points[point]) >= 0.0)
            return t;
    }
    return no_index;
}

// Returns whether both triangles of an edge are strictly positive after a flip.
bool InteriorPoints::is_flippable(uint32_t half, std::span<const glm::dvec2> points,
                                  std::span<const Triangle> triangles) const {
    const uint32_t twin = twin_[half], t = half / 3, u = twin / 3;
    const glm::dvec2 &a = points[triangles[t][half % 3]], &b = points[triangles[u][twin % 3]];
    const glm::dvec2& c = points[triangles[t][next(next(half)) % 3]];
    const glm::dvec2& d = points[triangles[u][next(next(twin)) % 3]];
    return orientation(c, a, d) > 0.0 && orientation(d, b, c) > 0.0;
}

// Replaces the edge a b between the triangles a b c and b a d by the edge c d. Half-edges 3 t + 2 and 3 u + 2 are the
// new edge.
void InteriorPoints::flip(uint32_t half, std::vector<Triangle>& triangles) {
    const uint32_t twin = twin_[half], t = half / 3, u = twin / 3;
    const uint32_t a = triangles[t][half % 3], b = triangles[u][twin % 3];
    const uint32_t c = triangles[t][next(next(half)) % 3], d = triangles[u][next(next(twin)) % 3];
    const uint32_t bc = twin_[next(half)], ca = twin_[next(next(half))];
    const uint32_t ad = twin_[next(twin)], db = twin_[next(next(twin))];
    triangles[t] = {c, a, d};
    triangles[u] = {d, b, c};
    const auto join = [&](uint32_t h, uint32_t other) {
        twin_[h] = other;
        if (other != no_index) twin_[other] = h;
    };
    join(3 * t, ca);
    join(3 * t + 1, ad);
    join(3 * t + 2, 3 * u + 2);
    join(3 * u, db);
    join(3 * u + 1, bc);
}

// Flips edges until the circle test of all doubtful ones fails.
void InteriorPoints::make_delaunay(std::span<const glm::dvec2> points, std::vector<Triangle>& triangles) {
    while (!doubtful_.empty()) {
        const uint32_t half = doubtful_.back();
        doubtful_.pop_back();
        const uint32_t twin = twin_[half];
        if (twin == no_index || !is_flippable(half, points, triangles)) continue;
        const uint32_t t = half / 3, u = twin / 3;
        const glm::dvec2 &a = points[triangles[t][half % 3]], &b = points[triangles[u][twin % 3]];
        const glm::dvec2& c = points[triangles[t][next(next(half)) % 3]];
        const glm::dvec2& d = points[triangles[u][next(next(twin)) % 3]];
        const bool flat = !(orientation(a, b, c) > 0.0);
        if (!flat && !certainly_in_circle(a, b, c, d)) continue;
        flip(half, triangles);
        doubtful_.insert(doubtful_.end(), {3 * t, 3 * t + 1, 3 * u, 3 * u + 1});
    }
}

// Returns whether all corners of a triangle lie on one flat part of the surface.
bool InteriorPoints::is_flat(uint32_t a, uint32_t b, uint32_t c) const {
    if (a >= normals_.size() || b >= normals_.size() || c >= normals_.size()) return false;
    const auto agree = [](const glm::dvec3& x, const glm::dvec3& y) { return glm::dot(x, y) > min_cosine; };
    for (const glm::dvec3& x : normals_[a])
        for (const glm::dvec3& y : normals_[b])
            for (const glm::dvec3& z : normals_[c])
                if (agree(x, y) && agree(y, z) && agree(z, x)) return true;
    return false;
}

// Flips edges where that makes fewer flat triangles. Each flip lowers their count, so the sequence ends.
void InteriorPoints::leave_border(std::span<const glm::dvec2> points, std::vector<Triangle>& triangles) {
    doubtful_.clear();
    const auto flat = [&](uint32_t t) { return is_flat(triangles[t].x, triangles[t].y, triangles[t].z); };
    for (uint32_t t = 0; t < triangles.size(); ++t)
        if (flat(t)) doubtful_.insert(doubtful_.end(), {3 * t, 3 * t + 1, 3 * t + 2});
    while (!doubtful_.empty()) {
        const uint32_t half = doubtful_.back();
        doubtful_.pop_back();
        const uint32_t twin = twin_[half];
        if (twin == no_index) continue;
        const uint32_t t = half / 3, u = twin / 3;
        const uint32_t a = triangles[t][half % 3], b = triangles[u][twin % 3];
        const uint32_t c = triangles[t][next(next(half)) % 3], d = triangles[u][next(next(twin)) % 3];
        const int before = is_flat(a, b, c) + is_flat(b, a, d), after = is_flat(c, a, d) + is_flat(d, b, c);
        if (after >= before || !is_flippable(half, points, triangles)) continue;
        flip(half, triangles);
        // A neighbour may leave the border across the changed triangles now.
        for (const uint32_t h : {3 * t, 3 * t + 1, 3 * t + 2, 3 * u, 3 * u + 1})
            if (flat(h / 3) || (twin_[h] != no_index && flat(twin_[h] / 3))) doubtful_.push_back(h);
    }
}

void InteriorPoints::insert(uint32_t point, std::span<const glm::dvec2> points, std::vector<Triangle>& triangles) {
    const uint32_t t = locate(point, points, triangles);
    if (t == no_index) return;
    const Triangle c = triangles[t];
    const auto u = static_cast<uint32_t>(triangles.size());
    const uint32_t v = u + 1;
    const uint32_t yz = twin_[3 * t + 1], zx = twin_[3 * t + 2];
    triangles[t] = {c.x, c.y, point};
    triangles.push_back({c.y, c.z, point});
    triangles.push_back({c.z, c.x, point});
    twin_.resize(3 * triangles.size());
    const auto join = [&](uint32_t h, uint32_t other) {
        twin_[h] = other;
        if (other != no_index) twin_[other] = h;
    };
    join(3 * u, yz);
    join(3 * v, zx);
    join(3 * t + 1, 3 * u + 2);
    join(3 * u + 1, 3 * v + 2);
    join(3 * v + 1, 3 * t + 2);
    near_ = t;
    doubtful_.assign({3 * t, 3 * u, 3 * v});
    make_delaunay(points, triangles);
}

void InteriorPoints::run(std::span<const Loop> loops, double spacing, std::span<const Normals> normals,
                         std::vector<glm::dvec2>& points, std::vector<Triangle>& triangles) {
    if (loops.empty() || triangles.empty()) return;
    place_points(loops, spacing, points);
    find_twins(triangles);
    normals_ = normals;
    near_ = 0;
    for (const glm::dvec2& p : inside_) {
        points.push_back(p);
        const size_t before = triangles.size();
        insert(static_cast<uint32_t>(points.size() - 1), points, triangles);
        if (triangles.size() == before) points.pop_back();
    }
    leave_border(points, triangles);
}

} // namespace brittle::fracture

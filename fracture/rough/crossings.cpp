#include "fracture/rough/crossings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/mesh/intersections.h"

namespace brittle::fracture::rough {

namespace {

// Rounding of a product with a normal, as a share of the largest coordinate times the length of the normal.
constexpr double max_rounding = 1e-12;

constexpr double max_slabs = 256.0;

class PieceCrossings {
  public:
    void run(const Fragments& pieces, uint32_t piece, std::span<const uint32_t> groups, std::vector<Crossing>& found);

  private:
    void find_cuts(const Piece& piece, std::span<const uint32_t> sources, std::span<const uint32_t> groups);
    void mark_band(const Piece& piece, std::span<const Triangle> triangles, std::span<const uint32_t> sources);
    void collect(const Piece& piece, std::span<const glm::dvec3> positions, std::span<const Triangle> triangles);

    struct Boxed {
        glm::dvec3 low, high;
        glm::dvec3 corner, normal; // of the plane of the triangle; the normal has any length
        double doubt;              // the product with the normal below which a point may be on the plane
        uint32_t triangle;
        uint32_t first_slab;
    };
    [[nodiscard]] static bool is_beside(const Boxed& plane, const Triangle& other, const Triangle& own,
                                        std::span<const glm::dvec3> positions);
    [[nodiscard]] bool have_gap(const Boxed& a, const Triangle& own, const Boxed& b, const Triangle& other,
                                std::span<const glm::dvec3> positions) const;

    std::vector<uint8_t> is_cut_; // per triangle: 1 on a cut that is not within a group
    std::vector<uint8_t> band_;   // per vertex: 1 on the border of a cut, 2 and 3 in the rings of the outside around it
    std::vector<uint32_t> facet_; // per vertex: the cut that it is on
    std::vector<Boxed> boxed_;    // the triangles of the band
    std::vector<std::pair<double, uint32_t>> order_; // of these along the longest axis
    [[nodiscard]] static bool meet_in_corner(uint32_t v, const Triangle& own, const Triangle& other,
                                             std::span<const glm::dvec3> positions);

    // The box of a triangle that the sweep along the longest axis may still meet; from 0 to 1, rounded outwards.
    struct alignas(32) Open {
        float begin, end;      // along the longest axis
        float low[2], high[2]; // along the others
        uint32_t index;        // into boxed_
    };
    [[nodiscard]] Open open(uint32_t index) const;

    int longest_ = 0;
    glm::dvec3 low_{0.0};                      // of all boxes, m
    double scale_ = 0.0;                       // to a size of 1, 1/m
    double rounding_ = 0.0;                    // of a product with an axis, for each unit of the axis, m
    std::vector<uint32_t> slab_begin_, slabs_; // the triangles that reach into slabs across the second longest axis
    std::vector<Open> cuts_, outside_;
    std::vector<uint32_t> near_; // of those that are open, the ones whose boxes meet that of one triangle
};

// Fills is_cut_.
void PieceCrossings::find_cuts(const Piece& piece, std::span<const uint32_t> sources,
                               std::span<const uint32_t> groups) {
    is_cut_.assign(sources.size(), 0);
    for (uint32_t t = piece.exterior_triangles; t < sources.size(); ++t)
        is_cut_[t] = groups.empty() || groups[sources[t]] != groups[piece.site] ? 1 : 0;
}

// Fills band_.
void PieceCrossings::mark_band(const Piece& piece, std::span<const Triangle> triangles,
                               std::span<const uint32_t> sources) {
    facet_.assign(piece.vertices.size(), no_index);
    band_.assign(piece.vertices.size(), 0);
    for (uint32_t t = piece.exterior_triangles; t < triangles.size(); ++t) {
        if (!is_cut_[t]) continue;
        for (int k = 0; k < 3; ++k) {
            const uint32_t v = triangles[t][k];
            if (facet_[v] != no_index && facet_[v] != sources[t]) band_[v] = 1; // two cuts meet here
            facet_[v] = sources[t];
        }
    }
    const auto exterior = triangles.first(piece.exterior_triangles);
    for (const Triangle& t : exterior)
        for (int k = 0; k < 3; ++k)
            if (facet_[t[k]] != no_index) band_[t[k]] = 1;
    for (const uint8_t ring : {1, 2}) {
        for (const Triangle& t : exterior) {
            const bool beside = band_[t.x] == ring || band_[t.y] == ring || band_[t.z] == ring;
            for (int k = 0; k < 3 && beside; ++k)
                if (band_[t[k]] == 0) band_[t[k]] = ring + 1;
        }
    }
}

// Fills boxed_ and slabs_.
void PieceCrossings::collect(const Piece& piece, std::span<const glm::dvec3> positions,
                             std::span<const Triangle> triangles) {
    boxed_.clear();
    glm::dvec3 low(positions[0]), high(low), sum(0.0);
    for (uint32_t t = 0; t < triangles.size(); ++t) {
        if (t >= piece.exterior_triangles && !is_cut_[t]) continue;
        const Triangle& c = triangles[t];
        const uint8_t most = t < piece.exterior_triangles ? 3 : 1;
        const auto in_band = [&](uint32_t v) { return band_[v] != 0 && band_[v] <= most; };
        if (!in_band(c.x) && !in_band(c.y) && !in_band(c.z)) continue;
        const glm::dvec3 &x = positions[c.x], &y = positions[c.y], &z = positions[c.z];
        boxed_.push_back(
            {glm::min(glm::min(x, y), z), glm::max(glm::max(x, y), z), x, glm::cross(y - x, z - x), 0.0, t, 0});
        low = glm::min(low, boxed_.back().low);
        high = glm::max(high, boxed_.back().high);
        sum += boxed_.back().high - boxed_.back().low;
    }
    const glm::dvec3 size = high - low;
    rounding_ = max_rounding * glm::length(glm::max(glm::abs(low), glm::abs(high)));
    const int longest = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
    const int second = size[(longest + 1) % 3] >= size[(longest + 2) % 3] ? (longest + 1) % 3 : (longest + 2) % 3;
    low_ = low;
    scale_ = size[longest] >= std::numeric_limits<double>::min() ? 1.0 / size[longest] : 0.0; // 0: all boxes meet
    order_.clear();
    for (uint32_t k = 0; k < boxed_.size(); ++k) order_.push_back({boxed_[k].low[longest], k});
    std::sort(order_.begin(), order_.end()); // boxes are in the order of triangles
    const double mean = sum[second] / static_cast<double>(std::max<size_t>(boxed_.size(), 1));
    const double width = std::max(2.0 * mean, size[second] / max_slabs);
    const auto slab_of = [&](double x) {
        return width > 0.0 ? static_cast<uint32_t>(std::min((x - low[second]) / width, max_slabs)) : 0u;
    };
    slab_begin_.assign(slab_of(high[second]) + 3, 0);
    for (int pass = 0; pass < 2; ++pass) {
        for (const auto& [begin, k] : order_) {
            Boxed& b = boxed_[k];
            b.first_slab = slab_of(b.low[second]);
            b.doubt = rounding_ * glm::length(b.normal);
            for (uint32_t slab = b.first_slab; slab <= slab_of(b.high[second]); ++slab) {
                if (pass == 0)
                    ++slab_begin_[slab + 2];
                else
                    slabs_[slab_begin_[slab + 1]++] = k;
            }
        }
        if (pass == 1) break;
        for (size_t k = 2; k < slab_begin_.size(); ++k) slab_begin_[k] += slab_begin_[k - 1];
        slabs_.resize(slab_begin_.back());
    }
    longest_ = longest;
}

PieceCrossings::Open PieceCrossings::open(uint32_t index) const {
    const Boxed& b = boxed_[index];
    constexpr float rounding = 0x1p-22f; // more than that of a number up to 1
    const auto down = [&](int axis) { return static_cast<float>((b.low[axis] - low_[axis]) * scale_) - rounding; };
    const auto up = [&](int axis) { return static_cast<float>((b.high[axis] - low_[axis]) * scale_) + rounding; };
    const int first = (longest_ + 1) % 3, second = (longest_ + 2) % 3;
    return {down(longest_), up(longest_), {down(first), down(second)}, {up(first), up(second)}, index};
}

// Returns whether a triangle surely lies on one side of a plane, apart from corners that it shares with the triangle
// there. Most neighbours do.
bool PieceCrossings::is_beside(const Boxed& plane, const Triangle& other, const Triangle& own,
                               std::span<const glm::dvec3> positions) {
    bool above = false, below = false;
    for (int k = 0; k < 3; ++k) {
        const uint32_t v = other[k];
        if (v == own.x || v == own.y || v == own.z) continue;
        const double distance = glm::dot(plane.normal, positions[v] - plane.corner);
        above = above || !(distance < -plane.doubt);
        below = below || !(distance > plane.doubt);
    }
    return above != below;
}

// Returns whether two triangles without a common corner surely have a gap between them along an axis. The axes stand on
// an edge of one and in its plane, or on an edge of each (the separating axis theorem).
bool PieceCrossings::have_gap(const Boxed& a, const Triangle& own, const Boxed& b, const Triangle& other,
                              std::span<const glm::dvec3> positions) const {
    std::array<glm::dvec3, 3> s, t, along_s, along_t;
    for (int k = 0; k < 3; ++k) {
        s[k] = positions[own[k]] - a.corner;
        t[k] = positions[other[k]] - a.corner;
    }
    for (int k = 0; k < 3; ++k) {
        along_s[k] = s[(k + 1) % 3] - s[k];
        along_t[k] = t[(k + 1) % 3] - t[k];
    }
    const auto is_gap = [&](const glm::dvec3& axis) {
        const double s0 = glm::dot(axis, s[0]), s1 = glm::dot(axis, s[1]), s2 = glm::dot(axis, s[2]);
        const double t0 = glm::dot(axis, t[0]), t1 = glm::dot(axis, t[1]), t2 = glm::dot(axis, t[2]);
        const double doubt = rounding_ * (std::abs(axis.x) + std::abs(axis.y) + std::abs(axis.z));
        return std::min({t0, t1, t2}) - std::max({s0, s1, s2}) > doubt
               || std::min({s0, s1, s2}) - std::max({t0, t1, t2}) > doubt;
    };
    for (int k = 0; k < 3; ++k)
        if (is_gap(glm::cross(along_s[k], a.normal)) || is_gap(glm::cross(along_t[k], b.normal))) return true;
    for (int k = 0; k < 3; ++k)
        for (int m = 0; m < 3; ++m)
            if (is_gap(glm::cross(along_s[k], along_t[m]))) return true;
    return false;
}

// Returns whether two triangles with the corner `v` in common surely have no other common point: a plane through it
// separates the angles that they span there, strictly on one side at least.
bool PieceCrossings::meet_in_corner(uint32_t v, const Triangle& own, const Triangle& other,
                                    std::span<const glm::dvec3> positions) {
    const auto sides = [&](const Triangle& t) {
        const int k = t.x == v ? 0 : (t.y == v ? 1 : 2);
        return std::array{glm::normalize(positions[t[(k + 1) % 3]] - positions[v]),
                          glm::normalize(positions[t[(k + 2) % 3]] - positions[v])};
    };
    const auto s = sides(own), t = sides(other);
    // A unit vector of an angle is a sum of its two sides with factors up to 1 / |s + s'|, here a thousand at most. So
    // rounding adds far less than min_sine to a product with an axis.
    constexpr double min_sum = 1e-3, min_sine = 1e-9, max_rounded = 1e-13;
    if (!(glm::length(s[0] + s[1]) > min_sum && glm::length(t[0] + t[1]) > min_sum)) return false;
    const auto separates = [&](const glm::dvec3& axis) {
        const double length = glm::length(axis);
        const auto [s_low, s_high] = std::minmax({glm::dot(axis, s[0]), glm::dot(axis, s[1])});
        const auto [t_low, t_high] = std::minmax({glm::dot(axis, t[0]), glm::dot(axis, t[1])});
        const double strict = min_sine * length, weak = max_rounded * length;
        return (s_high < weak && t_low > strict) || (s_high < -strict && t_low > -weak)
               || (t_high < weak && s_low > strict) || (t_high < -strict && s_low > -weak);
    };
    const glm::dvec3 normal_s = glm::cross(s[0], s[1]), normal_t = glm::cross(t[0], t[1]);
    for (size_t k = 0; k < 2; ++k)
        if (separates(glm::cross(s[k], normal_s)) || separates(glm::cross(t[k], normal_t))) return true;
    for (const glm::dvec3& from : s)
        for (const glm::dvec3& to : t)
            if (separates(glm::cross(from, to))) return true;
    return false;
}

void PieceCrossings::run(const Fragments& pieces, uint32_t index, std::span<const uint32_t> groups,
                         std::vector<Crossing>& found) {
    const Piece& piece = pieces.pieces[index];
    const auto positions = pieces.positions_of(piece);
    const auto triangles = pieces.triangles_of(piece);
    const auto sources = std::span(pieces.triangle_source).subspan(piece.triangles.begin, piece.triangles.size());
    if (piece.exterior_triangles == triangles.size()) return;
    find_cuts(piece, sources, groups);
    mark_band(piece, triangles, sources);
    collect(piece, positions, triangles);
    std::vector<uint32_t> crossing;
    const auto test = [&](uint32_t slab, const Boxed& a, const Boxed& b) {
        if (b.low.x > a.high.x || a.low.x > b.high.x || b.low.y > a.high.y || a.low.y > b.high.y || b.low.z > a.high.z
            || a.low.z > b.high.z || slab != std::max(a.first_slab, b.first_slab))
            return;
        const bool a_outside = a.triangle < piece.exterior_triangles, b_outside = b.triangle < piece.exterior_triangles;
        if (!a_outside && !b_outside && sources[a.triangle] == sources[b.triangle]) return;
        const Triangle &s = triangles[a.triangle], &t = triangles[b.triangle];
        if (is_beside(a, t, s, positions) || is_beside(b, s, t, positions)) return;
        uint32_t common = no_index;
        int commons = 0;
        for (int k = 0; k < 3; ++k) {
            if (s[k] != t.x && s[k] != t.y && s[k] != t.z) continue;
            common = s[k];
            ++commons;
        }
        if (commons == 0 && have_gap(a, s, b, t, positions)) return;
        if (commons == 1 && meet_in_corner(common, s, t, positions)) return;
        if (!intersect(positions, s, t)) return;
        if (!a_outside) crossing.push_back(a.triangle);
        if (!b_outside) crossing.push_back(b.triangle);
    };
    for (uint32_t slab = 0; slab + 1 < slab_begin_.size(); ++slab) {
        cuts_.clear();
        outside_.clear();
        for (uint32_t i = slab_begin_[slab]; i < slab_begin_[slab + 1]; ++i) {
            const Boxed& b = boxed_[slabs_[i]];
            const bool b_outside = b.triangle < piece.exterior_triangles;
            const Open opened = open(slabs_[i]);
            const auto meet = [&](std::vector<Open>& all) {
                near_.resize(all.size());
                size_t kept = 0, near = 0;
                for (const Open& a : all) { // without branches, which would be mispredicted
                    const bool stays = a.end >= opened.begin;
                    near_[near] = a.index;
                    near += static_cast<size_t>(stays & (a.low[0] <= opened.high[0]) & (opened.low[0] <= a.high[0])
                                                & (a.low[1] <= opened.high[1]) & (opened.low[1] <= a.high[1]));
                    all[kept] = a;
                    kept += static_cast<size_t>(stays);
                }
                all.resize(kept);
                for (const uint32_t k : std::span(near_).first(near)) test(slab, boxed_[k], b);
            };
            meet(cuts_);
            if (!b_outside) meet(outside_); // two triangles of the outside never cross by a cut
            (b_outside ? outside_ : cuts_).push_back(opened);
        }
    }
    std::sort(crossing.begin(), crossing.end());
    crossing.erase(std::unique(crossing.begin(), crossing.end()), crossing.end());
    for (const uint32_t t : crossing) {
        const glm::dvec3 &x = positions[triangles[t].x], &y = positions[triangles[t].y], &z = positions[triangles[t].z];
        const glm::dvec3 centre = (x + y + z) / 3.0;
        const double radius = std::max({glm::distance(x, centre), glm::distance(y, centre), glm::distance(z, centre)});
        found.push_back({index, centre, radius});
    }
}

} // namespace

bool CrossingFinder::is_known(const Fragments& pieces, const Piece& piece) const {
    const auto equal = [](const auto& a, const auto& b) {
        return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
    };
    const auto sources = [](const Fragments& of, const Piece& p) {
        return std::span(of.triangle_source).subspan(p.triangles.begin, p.triangles.size());
    };
    const auto [begin, end] = std::equal_range(last_.pieces.begin(), last_.pieces.end(), piece,
                                               [](const Piece& a, const Piece& b) { return a.site < b.site; });
    return std::any_of(begin, end, [&](const Piece& other) {
        return piece.exterior_triangles == other.exterior_triangles
               && equal(pieces.positions_of(piece), last_.positions_of(other))
               && equal(pieces.triangles_of(piece), last_.triangles_of(other))
               && equal(sources(pieces, piece), sources(last_, other));
    });
}

void CrossingFinder::remember(const Fragments& pieces, std::span<const Crossing> crossings) {
    last_.positions = pieces.positions;
    last_.triangles = pieces.triangles;
    last_.triangle_source = pieces.triangle_source;
    std::vector<uint8_t> crosses(pieces.pieces.size(), 0);
    for (const Crossing& crossing : crossings) crosses[crossing.piece] = 1;
    last_.pieces.clear();
    for (size_t p = 0; p < crosses.size(); ++p)
        if (crosses[p] == 0) last_.pieces.push_back(pieces.pieces[p]);
    std::stable_sort(last_.pieces.begin(), last_.pieces.end(),
                     [](const Piece& a, const Piece& b) { return a.site < b.site; });
}

std::vector<Crossing> CrossingFinder::run(const Fragments& pieces, std::span<const uint32_t> groups, Threads& threads) {
    const auto count = static_cast<uint32_t>(pieces.pieces.size());
    std::vector<std::vector<Crossing>> found(threads.chunks(count, 1));
    threads.for_chunks(count, 1, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        PieceCrossings finder;
        for (uint32_t p = begin; p < end; ++p) {
            threads.poll(p);
            if (!is_known(pieces, pieces.pieces[p])) finder.run(pieces, p, groups, found[chunk]);
        }
    });
    std::vector<Crossing> all;
    for (const std::vector<Crossing>& part : found) all.insert(all.end(), part.begin(), part.end());
    if (all.empty())
        forget();
    else
        remember(pieces, all); // the solid may be cut again
    return all;
}

} // namespace brittle::fracture::rough

#include "fracture/unite/facets.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

namespace brittle::fracture::arrangement {
namespace {

// A facet at an edge.
struct Use {
    uint32_t high; // the edge's higher point; uses are grouped by the lower one
    uint32_t facet;
    uint32_t corner; // of the facet: where its side along the edge begins
    bool forward;    // from the lower point to the higher
};

// Returns 1 if two triangles with the same corners have the same orientation, else -1.
int same_orientation(const Triangle& a, const Triangle& b) {
    for (int k = 0; k < 3; ++k)
        if (a.x == b[k]) return a.y == b[(k + 1) % 3] ? 1 : -1;
    return 1;
}

class Complex {
  public:
    Complex(Arrangement& arrangement, std::vector<Facet>& facets, Threads& threads)
        : all_(arrangement), facets_(facets), threads_(threads) {}

    void run() {
        group_uses();
        merge_equal();
        spread();
    }

  private:
    [[nodiscard]] uint32_t corner(const Use& use, uint32_t after) const {
        return facets_[use.facet].points[static_cast<int>((use.corner + after) % 3)];
    }

    void group_uses() {
        const size_t points = all_.points.size();
        begin_.assign(points + 1, 0);
        const auto each = [&](auto&& visit) {
            for (uint32_t f = 0; f < facets_.size(); ++f)
                for (uint32_t k = 0; k < 3; ++k) {
                    const uint32_t a = facets_[f].points[static_cast<int>(k)];
                    const uint32_t b = facets_[f].points[static_cast<int>((k + 1) % 3)];
                    visit(std::min(a, b), Use{std::max(a, b), f, k, a < b});
                }
        };
        each([&](uint32_t low, const Use&) { ++begin_[low + 1]; });
        std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
        uses_.resize(begin_.back());
        std::vector<uint32_t> end(begin_.begin(), begin_.end() - 1);
        each([&](uint32_t low, const Use& use) { uses_[end[low]++] = use; });
        for (size_t low = 0; low < points; ++low)
            std::sort(uses_.begin() + begin_[low], uses_.begin() + begin_[low + 1], [](const Use& a, const Use& b) {
                return a.high != b.high ? a.high < b.high : a.facet < b.facet;
            });
    }

    // Calls visit(first, last, low) for the uses of each edge.
    template<class Visit>
    void for_edges(Visit&& visit) {
        for (uint32_t low = 0; low + 1 < begin_.size(); ++low)
            for (uint32_t first = begin_[low], last = first; first < begin_[low + 1]; first = last) {
                while (last < begin_[low + 1] && uses_[last].high == uses_[first].high) ++last;
                visit(first, last, low);
            }
    }

    // Merges facets with equal corners into the first of them.
    void merge_equal() {
        std::vector<uint32_t> into(facets_.size());
        std::iota(into.begin(), into.end(), 0u);
        for_edges([&](uint32_t first, uint32_t last, uint32_t) {
            for (uint32_t i = first; i < last; ++i)
                for (uint32_t j = i + 1; j < last; ++j)
                    if (into[uses_[j].facet] == uses_[j].facet && corner(uses_[i], 2) == corner(uses_[j], 2)
                        && uses_[i].facet != uses_[j].facet)
                        into[uses_[j].facet] = into[uses_[i].facet];
        });
        bool any = false;
        for (uint32_t f = 0; f < facets_.size(); ++f) {
            if (into[f] == f) continue;
            any = true;
            Facet& kept = facets_[into[f]];
            const int same = same_orientation(kept.points, facets_[f].points);
            kept.multiplicity += same * facets_[f].multiplicity;
            uint32_t& source = kept.source[same > 0 ? 0 : 1];
            if (source == no_index) source = facets_[f].source[0];
        }
        if (!any) return;
        std::vector<Facet> rest;
        for (uint32_t f = 0; f < facets_.size(); ++f)
            if (into[f] == f) rest.push_back(facets_[f]);
        facets_ = std::move(rest);
        group_uses();
    }

    // Sorts the uses of an edge counter-clockwise around it, as seen from its higher point towards the lower one.
    void sort_around(uint32_t first, uint32_t last) {
        const auto side_of = [&](const Use& use, const Use& other) { // 1 for counter-clockwise by less than half a turn
            const uint32_t own = facets_[use.facet].source[0], its = facets_[other.facet].source[0];
            if (own == its) return 0;
            const int side = all_.points.side(all_.corners(own), corner(other, 2));
            return use.forward ? side : -side;
        };
        const Use zero = uses_[first];
        std::vector<std::pair<int, Use>> around; // 0: within half a turn of the first, 1: half a turn, 2: more
        for (uint32_t k = first + 1; k < last; ++k) around.emplace_back(1 - side_of(zero, uses_[k]), uses_[k]);
        std::sort(around.begin(), around.end(), [&](const auto& a, const auto& b) {
            if (a.first != b.first) return a.first < b.first;
            if (a.second.facet == b.second.facet) return false;
            return side_of(a.second, b.second) > 0;
        });
        for (uint32_t k = first + 1; k < last; ++k) uses_[k] = around[k - first - 1].second;
    }

    // Gives each side of each facet its winding number: the facets that follow each other around an edge look into the
    // same space. One facet of each connected part is decided by a line to infinity.
    void spread() {
        next_.assign(3 * facets_.size(), no_index);
        for_edges([&](uint32_t first, uint32_t last, uint32_t) {
            if (last - first > 2) sort_around(first, last);
            for (uint32_t k = first; k < last; ++k) {
                const Use &use = uses_[k], &following = uses_[k + 1 == last ? first : k + 1];
                next_[3 * use.facet + use.corner] = 3 * following.facet + following.corner;
                is_forward_.resize(next_.size());
                is_forward_[3 * use.facet + use.corner] = use.forward ? 1 : 0;
            }
        });
        std::vector<uint32_t> before(next_.size());
        for (uint32_t side = 0; side < next_.size(); ++side) before[next_[side]] = side;
        std::vector<uint8_t> known(facets_.size(), 0);
        std::vector<uint32_t> queue;
        for (const bool whole : {true, false}) // lines through triangles that are not cut need less arithmetic
            for (uint32_t start = 0; start < facets_.size(); ++start) {
                if (known[start] || (whole && !is_whole(start))) continue;
                facets_[start].front = front_by_line(start);
                known[start] = 1;
                queue.assign(1, start);
                while (!queue.empty()) {
                    const uint32_t f = queue.back();
                    queue.pop_back();
                    for (uint32_t side = 3 * f; side < 3 * f + 3; ++side)
                        for (const bool onwards : {true, false}) {
                            const uint32_t other = onwards ? next_[side] : before[side];
                            const uint32_t g = other / 3;
                            if (known[g]) continue;
                            // The space that follows a forward facet is in front of it; what precedes it is behind.
                            const bool in_front = (is_forward_[side] != 0) == onwards;
                            const int winding = in_front ? facets_[f].front : facets_[f].back();
                            const bool behind = (is_forward_[other] != 0) == onwards;
                            facets_[g].front = behind ? winding - facets_[g].multiplicity : winding;
                            known[g] = 1;
                            queue.push_back(g);
                        }
                }
            }
    }

    [[nodiscard]] bool is_whole(uint32_t facet) const { return all_.cut_of[facets_[facet].source[0]] == no_index; }

    // The winding number in front of a facet, counted along a line from one of its points. Points on an edge or a vertex
    // of another triangle do not tell; then another point follows.
    int front_by_line(uint32_t facet) {
        const Facet& f = facets_[facet];
        const int axis = all_.axis[f.source[0]];
        for (uint32_t attempt = 0;; ++attempt) {
            // Weights that no two attempts share; all are positive.
            const double a = 1.0 + attempt % 7, b = 1.0 + (attempt / 7 + 3 * attempt) % 11,
                         c = 2.0 + (5 * attempt) % 13;
            const uint32_t from = add_mean(f.points, {a, b, c});
            if (const std::optional<int> above = winding_above(from, axis)) {
                const int up = all_.points.turn(f.points.x, f.points.y, f.points.z, axis);
                return up > 0 ? *above : *above - f.multiplicity;
            }
        }
    }

    // Adds the weighted mean of three points.
    uint32_t add_mean(const Triangle& points, const std::array<double, 3>& weight) {
        const ExactPoint p = all_.points.exact(points.x), q = all_.points.exact(points.y),
                         r = all_.points.exact(points.z);
        const exact::Dyadic u = exact::Dyadic(weight[0]) * q.w * r.w, v = exact::Dyadic(weight[1]) * p.w * r.w,
                            w = exact::Dyadic(weight[2]) * p.w * q.w;
        return all_.points.add({u * p.x + v * q.x + w * r.x, u * p.y + v * q.y + w * r.y, u * p.z + v * q.z + w * r.z,
                                u * p.w + v * q.w + w * r.w});
    }

    // The winding number just above a point of a facet, upwards along an axis; nothing where the line meets an edge.
    std::optional<int> winding_above(uint32_t from, int axis) {
        const glm::dvec3 p = all_.points[from];
        int winding = 0;
        bool clear = true;
        FloatBox line = float_box(p, p); // positions are rounded: up to half a step, which a step of a float contains
        for (int k = 0; k < 3; ++k) {
            const auto j = static_cast<size_t>(k);
            constexpr float infinity = std::numeric_limits<float>::infinity();
            line.low[j] = std::nextafter(line.low[j], -infinity);
            line.high[j] = k == axis ? infinity : std::nextafter(line.high[j], infinity);
        }
        all_.tree(threads_).for_meeting(line, [&](uint32_t t) {
            if (!clear) return;
            const Triangle& c = all_.mesh.triangles[t];
            const int first = all_.points.turn(c.x, c.y, from, axis);
            const int second = all_.points.turn(c.y, c.z, from, axis);
            if (first * second < 0) return;
            const int third = all_.points.turn(c.z, c.x, from, axis);
            if (first * third < 0 || second * third < 0) return;
            if (first == 0 || second == 0 || third == 0) {
                clear = false; // on an edge, or on its line: a new point is cheap
                return;
            }
            const int side = all_.points.side(all_.corners(t), from);
            if (side * first < 0) winding += first; // the point is below
        });
        return clear ? std::optional(winding) : std::nullopt;
    }

    Arrangement& all_;
    std::vector<Facet>& facets_;
    std::vector<Use> uses_;       // by edge
    std::vector<uint32_t> begin_; // per point: into uses_, for the edges of which it is the lower point
    std::vector<uint32_t> next_; // per side 3 * facet + corner: the side that follows counter-clockwise around the edge
    std::vector<uint8_t> is_forward_;
    Threads& threads_;
};

} // namespace

std::vector<Facet> find_facets(Arrangement& arrangement, const std::vector<Part>& parts, Threads& threads) {
    std::vector<Facet> facets;
    facets.reserve(arrangement.mesh.triangles.size() + parts.size());
    size_t part = 0;
    for (uint32_t t = 0; t < arrangement.mesh.triangles.size(); ++t) {
        for (; part < parts.size() && parts[part].triangle == t; ++part)
            facets.push_back({parts[part].points, 1, {t, no_index}});
        if (arrangement.cut_of[t] == no_index && arrangement.axis[t] >= 0)
            facets.push_back({arrangement.mesh.triangles[t], 1, {t, no_index}});
    }
    Complex(arrangement, facets, threads).run();
    return facets;
}

} // namespace brittle::fracture::arrangement

// Divides the carriers of an arrangement: where portions cross, and where points lie on other portions.
#include <algorithm>
#include <limits>
#include <numeric>

#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

#include "fracture/unite/arrangement.h"

namespace brittle::fracture::arrangement {
namespace {

class Divider {
  public:
    explicit Divider(Arrangement& arrangement) : all_(arrangement), points_(arrangement.points) {}

    void run() {
        find_edges();
        for (uint32_t cut = 0; cut < all_.cuts.size(); ++cut) cross_portions(cut);
        for (uint32_t carrier = 0; carrier < all_.carriers.size(); ++carrier)
            for (const uint32_t point : all_.carriers[carrier].points)
                for (const uint32_t cut : all_.carriers[carrier].cuts) news_.push_back({cut, carrier, point});
        for (size_t k = 0; k < news_.size(); ++k) hand_over(News(news_[k]));
    }

  private:
    struct News { // a point that divides a carrier, for a triangle that holds a portion of it
        uint32_t cut, carrier, point;
    };

    // Tells triangles which of their edges are carriers.
    void find_edges() {
        std::vector<uint8_t> is_end(all_.mesh.positions.size(), 0);
        for (const Carrier& carrier : all_.carriers)
            if (carrier.is_edge()) is_end[carrier.from] = is_end[carrier.to] = 1;
        for (uint32_t t = 0; t < all_.mesh.triangles.size(); ++t) {
            const Triangle& c = all_.mesh.triangles[t];
            if (is_end[c.x] + is_end[c.y] + is_end[c.z] < 2 || all_.axis[t] < 0) continue;
            for (int k = 0; k < 3; ++k) {
                const auto found = all_.carrier_of_edge.find(Arrangement::edge_key(c[k], c[(k + 1) % 3]));
                if (found == all_.carrier_of_edge.end()) continue;
                const uint32_t cut = all_.cut(t);
                all_.cuts[cut].edges[static_cast<size_t>(k)] = found->second;
                all_.carriers[found->second].cuts.push_back(cut);
            }
        }
    }

    struct Bounds {
        glm::dvec3 low, high;
    };

    [[nodiscard]] Bounds bounds_of(const Portion& portion) const {
        return {glm::min(points_[portion.from], points_[portion.to]),
                glm::max(points_[portion.from], points_[portion.to])};
    }

    // Sweeps over the portions of a triangle along the longest side of their box.
    void cross_portions(uint32_t cut) {
        const std::vector<Portion> portions = all_.cuts[cut].portions;
        if (portions.size() < 2) return;
        std::vector<Bounds> bounds;
        Bounds all{glm::dvec3(std::numeric_limits<double>::infinity()),
                   glm::dvec3(-std::numeric_limits<double>::infinity())};
        for (const Portion& portion : portions) {
            bounds.push_back(bounds_of(portion));
            all.low = glm::min(all.low, bounds.back().low);
            all.high = glm::max(all.high, bounds.back().high);
        }
        const glm::dvec3 size = all.high - all.low;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
        std::vector<uint32_t> order(portions.size());
        std::iota(order.begin(), order.end(), 0u);
        std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
            return bounds[a].low[axis] != bounds[b].low[axis] ? bounds[a].low[axis] < bounds[b].low[axis] : a < b;
        });
        for (size_t i = 0; i < order.size(); ++i)
            for (size_t j = i + 1; j < order.size() && bounds[order[j]].low[axis] <= bounds[order[i]].high[axis]; ++j) {
                const Bounds &a = bounds[order[i]], &b = bounds[order[j]];
                if (glm::all(glm::lessThanEqual(a.low, b.high)) && glm::all(glm::lessThanEqual(b.low, a.high)))
                    cross(cut, portions[order[i]], portions[order[j]]);
            }
    }

    void cross(uint32_t cut, const Portion& s, const Portion& t) {
        const int axis = all_.axis[all_.cuts[cut].triangle];
        const int from = points_.turn(s.from, s.to, t.from, axis), to = points_.turn(s.from, s.to, t.to, axis);
        if (from * to > 0) return;
        const int from_s = points_.turn(t.from, t.to, s.from, axis), to_s = points_.turn(t.from, t.to, s.to, axis);
        if (from_s * to_s > 0) return;
        if (from * to < 0 && from_s * to_s < 0) {
            const uint32_t triangle = all_.cuts[cut].triangle;
            const uint32_t point =
                points_.add(common_point(plane_of(all_.corners(triangle)), support(triangle, s), support(triangle, t)));
            add(s.carrier, point);
            add(t.carrier, point);
            return;
        }
        if (from == 0 && is_between(s, t.from)) add(s.carrier, t.from);
        if (to == 0 && is_between(s, t.to)) add(s.carrier, t.to);
        if (from_s == 0 && is_between(t, s.from)) add(t.carrier, s.from);
        if (to_s == 0 && is_between(t, s.to)) add(t.carrier, s.to);
    }

    // A plane that meets the plane of a triangle in the line of a portion.
    [[nodiscard]] ExactPlane support(uint32_t triangle, const Portion& portion) const {
        const Carrier& carrier = all_.carriers[portion.carrier];
        if (carrier.is_edge()) return plane_along(points_[carrier.from], points_[carrier.to], all_.axis[triangle]);
        return plane_of(all_.corners(carrier.triangles[carrier.triangles[0] == triangle ? 1 : 0]));
    }

    // Whether a point on the line of a portion lies strictly between its ends.
    [[nodiscard]] bool is_between(const Portion& portion, uint32_t point) const {
        if (point == portion.from || point == portion.to) return false;
        const int axis = points_.axis_between(portion.from, portion.to);
        const int ends = points_.compare(portion.from, portion.to, axis);
        return points_.compare(portion.from, point, axis) == ends && points_.compare(point, portion.to, axis) == ends;
    }

    bool add(uint32_t carrier, uint32_t point) {
        Carrier& c = all_.carriers[carrier];
        if (point == c.from || point == c.to || std::find(c.points.begin(), c.points.end(), point) != c.points.end())
            return false;
        c.points.push_back(point);
        return true;
    }

    // Looks for other portions of the triangle on which the point lies.
    void hand_over(const News& news) {
        const Cut& cut = all_.cuts[news.cut];
        bool holds = false;
        for (const uint32_t edge : cut.edges) holds = holds || edge == news.carrier;
        for (const Portion& portion : cut.portions)
            holds = holds || (portion.carrier == news.carrier && is_between(portion, news.point));
        if (!holds) return;
        for (const uint32_t edge : cut.edges)
            if (edge != no_index) hand_over(news, {edge, all_.carriers[edge].from, all_.carriers[edge].to});
        for (const Portion& portion : cut.portions) hand_over(news, portion);
    }

    void hand_over(const News& news, const Portion& portion) {
        if (portion.carrier == news.carrier || news.point == portion.from || news.point == portion.to) return;
        const Bounds box = bounds_of(portion);
        const glm::dvec3& p = points_[news.point];
        if (!glm::all(glm::lessThanEqual(box.low, p)) || !glm::all(glm::lessThanEqual(p, box.high))) return;
        const int axis = all_.axis[all_.cuts[news.cut].triangle];
        if (points_.turn(portion.from, portion.to, news.point, axis) != 0 || !is_between(portion, news.point)) return;
        if (!add(portion.carrier, news.point)) return;
        for (const uint32_t cut : all_.carriers[portion.carrier].cuts)
            news_.push_back({cut, portion.carrier, news.point});
    }

    Arrangement& all_;
    Points& points_;
    std::vector<News> news_; // in the order of their arrival
};

} // namespace

void divide_carriers(Arrangement& arrangement) {
    Divider(arrangement).run();
}

} // namespace brittle::fracture::arrangement

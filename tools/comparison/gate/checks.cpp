#include "tools/comparison/gate/checks.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <unordered_map>

namespace brittle::comparison {

namespace {

// How far from a crossing of the input one of a piece may lie, in tolerances.
constexpr double near_crossing = 1e3;

Point minus(const Point& a, const Point& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
double dot(const Point& a, const Point& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Point cross(const Point& a, const Point& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double length(const Point& a) {
    return std::sqrt(dot(a, a));
}

struct Face {
    std::array<Point, 3> corners;

    Face(const Part& part, const Corners& t) : corners{part.points[t[0]], part.points[t[1]], part.points[t[2]]} {}
    [[nodiscard]] Point doubled_area() const {
        return cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
    }
    [[nodiscard]] Point middle() const {
        Point m;
        for (int k = 0; k < 3; ++k) m[k] = (corners[0][k] + corners[1][k] + corners[2][k]) / 3.0;
        return m;
    }
    [[nodiscard]] double perimeter() const {
        return length(minus(corners[1], corners[0])) + length(minus(corners[2], corners[1]))
               + length(minus(corners[0], corners[2]));
    }
};

// Cubes of one edge length, by a hash of their indices.
class Cubes {
  public:
    explicit Cubes(double edge) : edge_(edge) {}
    [[nodiscard]] int64_t index(double at) const { return static_cast<int64_t>(std::floor(at / edge_)); }
    static uint64_t key(int64_t x, int64_t y, int64_t z) {
        return static_cast<uint64_t>(x) * 0x9e3779b97f4a7c15u + static_cast<uint64_t>(y) * 0xc2b2ae3d27d4eb4fu
               + static_cast<uint64_t>(z) * 0x165667b19e3779f9u;
    }

  private:
    double edge_;
};

// The number of each vertex, where vertices within `distance` are one; 0: only those that are equal.
std::vector<uint32_t> welded(const Part& part, double distance) {
    std::vector<uint32_t> numbers(part.points.size());
    if (distance == 0.0) {
        std::map<Point, uint32_t> first;
        for (uint32_t v = 0; v < numbers.size(); ++v) numbers[v] = first.try_emplace(part.points[v], v).first->second;
        return numbers;
    }
    const Cubes cubes(distance);
    std::unordered_map<uint64_t, std::vector<uint32_t>> seen;
    for (uint32_t v = 0; v < numbers.size(); ++v) {
        const Point& p = part.points[v];
        const std::array<int64_t, 3> at{cubes.index(p[0]), cubes.index(p[1]), cubes.index(p[2])};
        numbers[v] = v;
        for (int n = 0; n < 27 && numbers[v] == v; ++n) {
            const auto found = seen.find(Cubes::key(at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1));
            if (found == seen.end()) continue;
            for (const uint32_t other : found->second)
                if (length(minus(part.points[other], p)) <= distance) numbers[v] = other;
        }
        if (numbers[v] == v) seen[Cubes::key(at[0], at[1], at[2])].push_back(v);
    }
    return numbers;
}

// Every edge is run as often in one direction as in the other. Triangles without area that weld to an edge cancel.
bool is_closed(const Part& part, const std::vector<uint32_t>& numbers) {
    std::map<std::pair<uint32_t, uint32_t>, int> edges;
    for (const Corners& t : part.triangles)
        for (int k = 0; k < 3; ++k) {
            const uint32_t a = numbers[t[k]], b = numbers[t[(k + 1) % 3]];
            if (a != b) edges[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
        }
    return std::ranges::all_of(edges, [](const auto& edge) { return edge.second == 0; });
}

// Six times the volume, seen from a point.
double volume_of(const Part& part, const Corners& t, const Point& origin) {
    return dot(minus(part.points[t[0]], origin),
               cross(minus(part.points[t[1]], origin), minus(part.points[t[2]], origin)));
}

// The volumes of the parts whose triangles hang together by edges.
std::vector<double> part_volumes(const Part& part, const std::vector<uint32_t>& numbers) {
    std::vector<uint32_t> root(part.triangles.size());
    std::iota(root.begin(), root.end(), 0u);
    const auto find = [&](uint32_t t) {
        while (root[t] != t) t = root[t] = root[root[t]];
        return t;
    };
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> first;
    for (uint32_t t = 0; t < root.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            const uint32_t a = numbers[part.triangles[t][k]], b = numbers[part.triangles[t][(k + 1) % 3]];
            if (a != b) root[find(t)] = find(first.try_emplace({std::min(a, b), std::max(a, b)}, t).first->second);
        }
    std::map<uint32_t, double> volumes;
    for (uint32_t t = 0; t < root.size(); ++t)
        volumes[find(t)] += volume_of(part, part.triangles[t], part.points[0]) / 6.0;
    std::vector<double> result;
    for (const auto& [part_root, volume] : volumes) result.push_back(volume);
    return result;
}

// Calls visit(s, t) for all pairs of triangles whose boxes meet, by a sweep along x.
void visit_pairs(const Part& part, const std::function<void(uint32_t, uint32_t)>& visit) {
    struct Box {
        Point min, max;
        uint32_t triangle;
    };
    std::vector<Box> boxes;
    double widest = 0.0;
    for (uint32_t t = 0; t < part.triangles.size(); ++t) {
        Box box{part.points[part.triangles[t][0]], part.points[part.triangles[t][0]], t};
        for (const uint32_t v : part.triangles[t])
            for (int k = 0; k < 3; ++k) {
                box.min[k] = std::min(box.min[k], part.points[v][k]);
                box.max[k] = std::max(box.max[k], part.points[v][k]);
            }
        widest = std::max(widest, box.max[1] - box.min[1]);
        boxes.push_back(box);
    }
    // Strips along x, so that the sweep compares neighbours in y only.
    if (boxes.empty()) return;
    double low = boxes[0].min[1], high = boxes[0].max[1];
    for (const Box& box : boxes) {
        low = std::min(low, box.min[1]);
        high = std::max(high, box.max[1]);
    }
    const auto strips = static_cast<size_t>(std::clamp(std::sqrt(static_cast<double>(boxes.size())), 1.0, 256.0));
    const auto strip_of = [&](double y) {
        return high > low
                   ? std::min(strips - 1, static_cast<size_t>((y - low) / (high - low) * static_cast<double>(strips)))
                   : size_t{0};
    };
    std::ranges::sort(boxes, {}, [](const Box& box) { return box.min[0]; });
    std::vector<std::vector<const Box*>> active(strips);
    for (const Box& box : boxes) {
        const size_t first = strip_of(box.min[1]), last = strip_of(box.max[1]);
        for (size_t s = first; s <= last; ++s) {
            std::erase_if(active[s], [&](const Box* other) { return other->max[0] < box.min[0]; });
            for (const Box* other : active[s]) {
                if (std::max(first, strip_of(other->min[1])) != s) continue; // seen in an earlier strip
                if (other->min[1] <= box.max[1] && other->max[1] >= box.min[1] && other->min[2] <= box.max[2]
                    && other->max[2] >= box.min[2])
                    visit(box.triangle, other->triangle);
            }
            active[s].push_back(&box);
        }
    }
}

// Whether the segment pierces the triangle: both ends lie farther than `depth` from its plane, and the point between
// them lies farther than that inside its sides.
bool pierces(const Point& from, const Point& to, const Face& face, double depth, Point& at) {
    Point normal = face.doubled_area();
    const double size = length(normal);
    if (size == 0.0) return false;
    for (double& x : normal) x /= size;
    const double a = dot(normal, minus(from, face.corners[0])), b = dot(normal, minus(to, face.corners[0]));
    if ((a > 0.0) == (b > 0.0) || std::abs(a) <= depth || std::abs(b) <= depth) return false;
    for (int k = 0; k < 3; ++k) at[k] = from[k] + a / (a - b) * (to[k] - from[k]);
    for (int k = 0; k < 3; ++k) {
        const Point side = minus(face.corners[(k + 1) % 3], face.corners[k]);
        if (dot(cross(normal, side), minus(at, face.corners[k])) <= depth * length(side)) return false;
    }
    return true;
}

// From a point to a segment.
double distance(const Point& p, const Crossing& segment) {
    const Point along = minus(segment.end, segment.begin), to = minus(p, segment.begin);
    const double square = dot(along, along), share = square > 0.0 ? std::clamp(dot(to, along) / square, 0.0, 1.0) : 0.0;
    Point apart;
    for (int k = 0; k < 3; ++k) apart[k] = to[k] - share * along[k];
    return length(apart);
}

// Where edges of two triangles pierce the other one: the ends of the segment that both share, or one point twice.
std::vector<Crossing> crossings(const Part& part, double depth) {
    std::vector<Crossing> found;
    visit_pairs(part, [&](uint32_t s, uint32_t t) {
        const Face first(part, part.triangles[s]), second(part, part.triangles[t]);
        std::optional<Crossing> pair;
        const auto add = [&](const Point& from, const Point& to, const Face& face) {
            Point at;
            if (pierces(from, to, face, depth, at)) pair = {pair ? pair->begin : at, at};
        };
        for (int k = 0; k < 3; ++k) {
            add(first.corners[k], first.corners[(k + 1) % 3], second);
            add(second.corners[k], second.corners[(k + 1) % 3], first);
        }
        if (!pair) return;
        for (const Point& corner : first.corners) // triangles with a common corner cross from there
            if (std::ranges::find(second.corners, corner) != std::end(second.corners)) pair->end = corner;
        found.push_back(*pair);
    });
    return found;
}

// A k-d tree of the sites.
class SiteTree {
  public:
    explicit SiteTree(std::span<const Point> sites) : sites_(sites), order_(sites.size()) {
        std::iota(order_.begin(), order_.end(), 0u);
        build(0, order_.size(), 0);
    }

    // The nearest site, the lowest index of equal ones; without those at the place of site `but`, if there is one.
    [[nodiscard]] uint32_t nearest(const Point& p, uint32_t but = UINT32_MAX) const {
        std::pair<double, uint32_t> best{std::numeric_limits<double>::infinity(), UINT32_MAX};
        search(0, order_.size(), 0, p, but, best);
        return best.second;
    }

  private:
    void build(size_t begin, size_t end, int axis) {
        if (end - begin < 2) return;
        const size_t middle = (begin + end) / 2;
        const auto at = [&](size_t k) { return order_.begin() + static_cast<std::ptrdiff_t>(k); };
        std::nth_element(at(begin), at(middle), at(end),
                         [&](uint32_t a, uint32_t b) { return sites_[a][axis] < sites_[b][axis]; });
        build(begin, middle, (axis + 1) % 3);
        build(middle + 1, end, (axis + 1) % 3);
    }
    void search(size_t begin, size_t end, int axis, const Point& p, uint32_t but,
                std::pair<double, uint32_t>& best) const {
        if (begin == end) return;
        const size_t middle = (begin + end) / 2;
        const uint32_t site = order_[middle];
        const Point to = minus(sites_[site], p);
        if (but == UINT32_MAX || sites_[site] != sites_[but]) best = std::min(best, {dot(to, to), site});
        const bool is_below = to[axis] > 0.0;
        const auto half = [&](bool below) {
            if (below)
                search(begin, middle, (axis + 1) % 3, p, but, best);
            else
                search(middle + 1, end, (axis + 1) % 3, p, but, best);
        };
        half(is_below);
        if (to[axis] * to[axis] <= best.first) half(!is_below);
    }

    std::span<const Point> sites_;
    std::vector<uint32_t> order_;
};

// Finds whether a point lies on a surface.
class SurfaceGrid {
  public:
    SurfaceGrid(const Part& mesh, double tolerance) : mesh_(mesh), tolerance_(tolerance), low_(mesh.points.at(0)) {
        Point high = low_;
        for (const Point& p : mesh.points)
            for (int k = 0; k < 3; ++k) {
                low_[k] = std::min(low_[k], p[k]);
                high[k] = std::max(high[k], p[k]);
            }
        for (int k = 0; k < 3; ++k) step_ = std::max(step_, (high[k] - low_[k]) / side);
        bins_.resize(static_cast<size_t>(side) * side * side);
        for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const Face face(mesh, mesh.triangles[t]);
            std::array<std::array<int, 2>, 3> range{};
            for (int k = 0; k < 3; ++k) {
                const auto [least, largest] = std::minmax({face.corners[0][k], face.corners[1][k], face.corners[2][k]});
                range[k] = {index(least - tolerance, k), index(largest + tolerance, k)};
            }
            for (int x = range[0][0]; x <= range[0][1]; ++x)
                for (int y = range[1][0]; y <= range[1][1]; ++y)
                    for (int z = range[2][0]; z <= range[2][1]; ++z) bins_[bin(x, y, z)].push_back(t);
        }
    }

    [[nodiscard]] bool holds(const Point& p) const {
        return std::ranges::any_of(bins_[bin(index(p[0], 0), index(p[1], 1), index(p[2], 2))], [&](uint32_t t) {
            const Face face(mesh_, mesh_.triangles[t]);
            Point normal = face.doubled_area();
            const double size = length(normal);
            if (size == 0.0) return false;
            for (double& x : normal) x /= size;
            if (std::abs(dot(normal, minus(p, face.corners[0]))) > tolerance_) return false;
            for (int k = 0; k < 3; ++k) {
                const Point edge = minus(face.corners[(k + 1) % 3], face.corners[k]);
                if (dot(cross(normal, edge), minus(p, face.corners[k])) < -tolerance_ * length(edge)) return false;
            }
            return true;
        });
    }

  private:
    static constexpr int side = 48;
    [[nodiscard]] int index(double at, int axis) const {
        return static_cast<int>(std::clamp((at - low_[axis]) / step_, 0.0, side - 1.0));
    }
    static size_t bin(int x, int y, int z) { return (static_cast<size_t>(z) * side + y) * side + x; }

    const Part& mesh_;
    double tolerance_;
    Point low_;
    double step_ = 0.0;
    std::vector<std::vector<uint32_t>> bins_;
};

// The caps on one side of a facet.
struct CapSide {
    double area = 0.0;
    Point moment{}; // area times centroid
    double perimeter = 0.0;
    std::vector<Face> faces;

    void add(const Face& face) {
        const double size = length(face.doubled_area()) / 2.0;
        const Point middle = face.middle();
        area += size;
        perimeter += face.perimeter();
        for (int k = 0; k < 3; ++k) moment[k] += size * middle[k];
        faces.push_back(face);
    }
};

bool agree(const CapSide& a, const CapSide& b, double tolerance, double size) {
    const double slack = tolerance * (a.perimeter + b.perimeter);
    return std::abs(a.area - b.area) <= slack && length(minus(a.moment, b.moment)) <= slack * size;
}

// A triangle by its corners, the same for both of its sides.
std::array<Point, 3> sorted_corners(const Face& face) {
    std::array<Point, 3> corners = face.corners;
    std::ranges::sort(corners);
    return corners;
}

} // namespace

std::string Verdict::reason() const {
    std::string text;
    const auto add = [&](uint64_t count, const std::string& what) {
        if (count > 0) text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + what;
    };
    if (pieces == 0) return "no pieces";
    add(open, "open");
    add(negative, "inside out");
    add(crossing, "cross themselves");
    add(joined_islands, "hold several islands");
    add(wrong_cells, "cells of wrong volume");
    add(wrong_caps, "facets with unequal caps");
    return text;
}

Gate::Gate(const Part& mesh, std::span<const Point> sites, std::span<const double> volumes)
    : mesh_(mesh), sites_(sites), volumes_(volumes) {
    double largest = 0.0;
    for (int k = 0; k < 3; ++k) {
        const auto [low, high] =
            std::ranges::minmax_element(mesh.points, {}, [&](const Point& p) { return p[static_cast<size_t>(k)]; });
        largest = std::max(largest, (*high)[static_cast<size_t>(k)] - (*low)[static_cast<size_t>(k)]);
    }
    tolerance_ = relative_tolerance * largest;
    input_crossings_ = crossings(mesh, 0.0);
}

Verdict Gate::check(const std::vector<Part>& pieces) const {
    Verdict verdict;
    const SiteTree tree(sites_);
    const double size = tolerance_ / relative_tolerance;
    std::vector<double> volumes(sites_.size()), surfaces(sites_.size());
    std::map<std::array<uint32_t, 2>, CapSide> caps; // of a cell towards another
    double sum = 0.0;
    for (const Part& piece : pieces) {
        if (piece.triangles.empty()) continue;
        ++verdict.pieces;
        verdict.triangles += piece.triangles.size();
        const std::vector<uint32_t> exact = welded(piece, 0.0), near = welded(piece, tolerance_);
        const bool closed_exactly = is_closed(piece, exact), closed = closed_exactly || is_closed(piece, near);
        verdict.open_exactly += !closed_exactly;
        verdict.open += !closed;
        // Where the input crosses itself, its pieces may.
        const auto is_input = [&](const Point& at) {
            return std::ranges::any_of(input_crossings_, [&](const Crossing& input) {
                return distance(at, input) <= near_crossing * tolerance_;
            });
        };
        verdict.crossing += std::ranges::any_of(crossings(piece, tolerance_), [&](const Crossing& own) {
            return !is_input(own.begin) || !is_input(own.end);
        });
        double volume = 0.0, surface = 0.0;
        Point centroid{};
        const Point origin = piece.points[piece.triangles[0][0]];
        for (const Corners& t : piece.triangles) {
            const double part = volume_of(piece, t, origin) / 6.0;
            volume += part;
            const Face face(piece, t);
            surface += length(face.doubled_area()) / 2.0;
            for (int k = 0; k < 3; ++k) centroid[k] += part * (3.0 * face.middle()[k] + origin[k]) / 4.0;
        }
        verdict.negative += volume <= 0.0;
        const auto large = [&](double part) { return part > tolerance_ * surface; };
        verdict.joined_islands += std::ranges::count_if(part_volumes(piece, closed_exactly ? exact : near), large) > 1;
        for (int k = 0; k < 3; ++k) centroid[k] = volume != 0.0 ? centroid[k] / volume : origin[k];
        const uint32_t own = tree.nearest(centroid);
        volumes[own] += volume;
        surfaces[own] += surface;
        sum += volume;
        for (const Corners& t : piece.triangles) {
            const Face face(piece, t);
            const uint32_t other = tree.nearest(face.middle(), own);
            if (other == UINT32_MAX) continue; // one cell
            const Point normal = minus(sites_[other], sites_[own]);
            const double distance = length(normal);
            const bool on_bisector = std::ranges::all_of(face.corners, [&](const Point& p) {
                const Point a = minus(p, sites_[own]), b = minus(p, sites_[other]);
                return std::abs(dot(a, a) - dot(b, b)) <= 2.0 * distance * tolerance_;
            });
            if (on_bisector) caps[{own, other}].add(face);
        }
    }

    const double whole = std::accumulate(volumes_.begin(), volumes_.end(), 0.0);
    for (size_t site = 0; site < sites_.size(); ++site) {
        const double error = std::abs(volumes[site] - volumes_[site]);
        // The surface of a cell without pieces is unknown: that of a ball of its volume is the least.
        const double ball = std::cbrt(36.0 * 3.141592653589793 * volumes_[site] * volumes_[site]);
        verdict.wrong_cells += error > tolerance_ * std::max(surfaces[site], ball) + tolerance_ * tolerance_ * size;
        verdict.worst_cell = std::max(verdict.worst_cell, error / (whole / static_cast<double>(sites_.size())));
    }
    verdict.volume_error = std::abs(sum - whole) / whole;

    std::map<std::array<Point, 3>, int> twins;
    double area = 0.0, equal = 0.0;
    for (const auto& [cells, side] : caps)
        for (const Face& face : side.faces) ++twins[sorted_corners(face)];
    std::unique_ptr<SurfaceGrid> surface;
    const CapSide none;
    for (const auto& [cells, side] : caps) {
        for (const Face& face : side.faces) {
            const double one = length(face.doubled_area()) / 2.0;
            area += one;
            if (twins.at(sorted_corners(face)) == 2) equal += one;
        }
        const auto found = caps.find({cells[1], cells[0]});
        if (found != caps.end() && cells[0] > cells[1]) continue;
        const CapSide& other = found == caps.end() ? none : found->second;
        if (agree(side, other, tolerance_, size)) continue;
        // Parts of the surface may lie in the plane of a bisector, on one side only.
        if (!surface) surface = std::make_unique<SurfaceGrid>(mesh_, tolerance_);
        const auto inside = [&](const CapSide& all) {
            CapSide kept;
            for (const Face& face : all.faces)
                if (!surface->holds(face.middle())) kept.add(face);
            return kept;
        };
        verdict.wrong_caps += !agree(inside(side), inside(other), tolerance_, size);
    }
    verdict.equal_caps = area > 0.0 ? equal / area : 1.0;
    return verdict;
}

} // namespace brittle::comparison

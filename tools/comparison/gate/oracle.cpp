#include "tools/comparison/gate/oracle.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include <boost/multiprecision/cpp_int.hpp>

namespace brittle::comparison {

namespace {

using Integer = boost::multiprecision::cpp_int;
using Rational = boost::multiprecision::cpp_rational;

double dot(const Point& a, const Point& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Point minus(const Point& a, const Point& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
double squared(const Point& a, const Point& b) {
    const Point d = minus(a, b);
    return dot(d, d);
}

struct Bounds {
    Point min, max;
};

Bounds bounds_of(std::span<const Point> points) {
    constexpr double far = std::numeric_limits<double>::infinity();
    Bounds box{{far, far, far}, {-far, -far, -far}};
    for (const Point& p : points)
        for (int k = 0; k < 3; ++k) {
            box.min[k] = std::min(box.min[k], p[k]);
            box.max[k] = std::max(box.max[k], p[k]);
        }
    return box;
}

double size_of(const Bounds& box) {
    return std::max({box.max[0] - box.min[0], box.max[1] - box.min[1], box.max[2] - box.min[2]});
}

// ---- cells, in double

struct ConvexCell {
    std::vector<Point> points;
    std::vector<std::vector<uint32_t>> faces; // loops, counter-clockwise seen from outside
};

ConvexCell box_cell(const Bounds& box) {
    ConvexCell cell;
    for (int k = 0; k < 8; ++k)
        cell.points.push_back(
            {(k & 1 ? box.max : box.min)[0], (k & 2 ? box.max : box.min)[1], (k & 4 ? box.max : box.min)[2]});
    cell.faces = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    return cell;
}

// Rounds a vertex this near to a plane onto it, as a share of the size of the box: lattices give no facets without
// extent. The exact volumes do not depend on it.
constexpr double on_plane = 1e-12;

// Returns false where the half-space leaves the cell as it is.
bool clip(ConvexCell& cell, const HalfSpace& half, double size) {
    const double slack = on_plane * size * std::sqrt(dot(half.normal, half.normal));
    std::vector<double> sides;
    std::vector<int> signs;
    for (const Point& p : cell.points) {
        const double side = dot(half.normal, p) - half.offset;
        sides.push_back(side);
        signs.push_back(side > slack ? 1 : side < -slack ? -1 : 0);
    }
    if (std::ranges::none_of(signs, [](int sign) { return sign > 0; })) return false;
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> cuts;
    const auto cut = [&](uint32_t a, uint32_t b) {
        if (a > b) std::swap(a, b);
        const auto [at, is_new] = cuts.try_emplace({a, b}, static_cast<uint32_t>(cell.points.size()));
        if (is_new) {
            const double t = sides[a] / (sides[a] - sides[b]);
            Point p = cell.points[a];
            for (int k = 0; k < 3; ++k) p[k] += t * (cell.points[b][k] - cell.points[a][k]);
            cell.points.push_back(p);
        }
        return at->second;
    };
    std::vector<std::vector<uint32_t>> faces;
    for (const std::vector<uint32_t>& face : cell.faces) {
        std::vector<uint32_t> kept;
        bool inside = false;
        for (size_t k = 0; k < face.size(); ++k) {
            const uint32_t a = face[k], b = face[(k + 1) % face.size()];
            inside |= signs[a] < 0;
            if (signs[a] <= 0) kept.push_back(a);
            if (signs[a] * signs[b] < 0) kept.push_back(cut(a, b));
        }
        if (inside && kept.size() > 2) faces.push_back(std::move(kept)); // else it lies outside or on the plane
    }
    cell.faces = std::move(faces);
    // Edges without a twin border the new face.
    std::set<std::pair<uint32_t, uint32_t>> edges;
    for (const std::vector<uint32_t>& face : cell.faces)
        for (size_t k = 0; k < face.size(); ++k) edges.emplace(face[k], face[(k + 1) % face.size()]);
    std::map<uint32_t, uint32_t> next;
    for (const auto& [from, to] : edges)
        if (!edges.contains({to, from})) next[to] = from;
    if (!next.empty()) {
        std::vector<uint32_t> loop;
        uint32_t at = next.begin()->first;
        do {
            loop.push_back(at);
            const auto found = next.find(at);
            if (found == next.end()) break;
            at = found->second;
        } while (at != loop[0] && loop.size() <= next.size());
        if (loop.size() > 2) cell.faces.push_back(loop);
    }
    // Vertices that no face names any more.
    std::vector<uint32_t> number(cell.points.size(), UINT32_MAX);
    std::vector<Point> points;
    for (std::vector<uint32_t>& face : cell.faces)
        for (uint32_t& v : face) {
            if (number[v] == UINT32_MAX) {
                number[v] = static_cast<uint32_t>(points.size());
                points.push_back(cell.points[v]);
            }
            v = number[v];
        }
    cell.points = std::move(points);
    return true;
}

HalfSpace bisector(const Point& own, const Point& other) {
    return {minus(other, own), (dot(other, other) - dot(own, own)) / 2.0};
}

struct SiteCell {
    ConvexCell shape;
    std::vector<uint32_t> cutters;    // the sites that cut the cell in double
    std::vector<uint32_t> candidates; // every site that may cut it; nearest first
};

// Clips a box by the bisectors in order of distance, until none can reach the farthest vertex.
SiteCell site_cell(std::span<const Point> sites, uint32_t site, const Bounds& box) {
    SiteCell cell{box_cell(box), {}, {}};
    const double size = size_of(box);
    for (uint32_t other = 0; other < site; ++other)
        if (sites[other] == sites[site]) {
            cell.shape = {};
            return cell;
        }
    std::vector<std::pair<double, uint32_t>> order;
    for (uint32_t other = 0; other < sites.size(); ++other)
        if (sites[other] != sites[site]) order.emplace_back(squared(sites[other], sites[site]), other);
    const auto reach = [&] {
        double farthest = 0.0;
        for (const Point& p : cell.shape.points) farthest = std::max(farthest, squared(p, sites[site]));
        return 4.0 * farthest * (1.0 + 1e-6); // squared: the bisector halves the distance
    };
    size_t sorted = 0;
    for (size_t k = 0; k < order.size(); ++k) {
        if (k == sorted) {
            sorted = std::min(order.size(), 4 * sorted + 32);
            std::partial_sort(order.begin() + static_cast<std::ptrdiff_t>(k),
                              order.begin() + static_cast<std::ptrdiff_t>(sorted), order.end());
        }
        if (order[k].first > reach()) break;
        cell.candidates.push_back(order[k].second);
        if (clip(cell.shape, bisector(sites[site], sites[order[k].second]), size))
            cell.cutters.push_back(order[k].second);
    }
    return cell;
}

// ---- prisms, in double or in rational numbers

template<class T>
using Vector = std::array<T, 3>;

template<class T>
struct Corner {
    Vector<T> at;
    Point near; // `at`, rounded
};

// A face is the set of its directed edges. Their order plays no part in clipping or in the volume.
template<class T>
struct Edge {
    Corner<T> from, to;
};
template<class T>
using Prism = std::vector<std::vector<Edge<T>>>;

template<class T>
Corner<T> corner_at(const Point& p) {
    return {{T(p[0]), T(p[1]), T(p[2])}, p};
}

template<class T>
struct Plane {
    Vector<T> normal;
    T offset;
    HalfSpace near;
};

template<class T>
Plane<T> exact_bisector(const Point& own, const Point& other) {
    Plane<T> plane{{}, T(0), bisector(own, other)};
    for (int k = 0; k < 3; ++k) {
        const T a(own[k]), b(other[k]);
        plane.normal[k] = b - a;
        plane.offset += (b * b - a * a) / 2;
    }
    return plane;
}

template<class T>
T side_of(const Plane<T>& plane, const Corner<T>& c) {
    return plane.normal[0] * c.at[0] + plane.normal[1] * c.at[1] + plane.normal[2] * c.at[2] - plane.offset;
}

// The sign of a side: by double where the error bound allows.
template<class T>
bool is_outside(const Plane<T>& plane, const Corner<T>& c) {
    const double side = dot(plane.near.normal, c.near) - plane.near.offset;
    double size = std::abs(plane.near.offset);
    for (int k = 0; k < 3; ++k) size += std::abs(plane.near.normal[k] * c.near[k]);
    if (std::abs(side) > 1e-13 * size) return side > 0.0;
    return side_of(plane, c) > 0;
}

template<class T>
Corner<T> crossing(const Plane<T>& plane, const Corner<T>& a, const Corner<T>& b) {
    const T side_a = side_of(plane, a), side_b = side_of(plane, b), t = side_a / (side_a - side_b);
    Corner<T> c;
    for (int k = 0; k < 3; ++k) {
        c.at[k] = a.at[k] + t * (b.at[k] - a.at[k]);
        c.near[k] = static_cast<double>(c.at[k]);
    }
    return c;
}

template<class T>
void clip(Prism<T>& prism, const Plane<T>& plane) {
    std::vector<Edge<T>> border;
    bool cut = false;
    Prism<T> result;
    for (const std::vector<Edge<T>>& face : prism) {
        std::vector<Edge<T>> kept;
        std::vector<Corner<T>> leaves, enters;
        for (const Edge<T>& edge : face) {
            const bool from_out = is_outside(plane, edge.from), to_out = is_outside(plane, edge.to);
            cut |= from_out;
            if (!from_out && !to_out) kept.push_back(edge);
            if (!from_out && to_out)
                kept.push_back({edge.from, leaves.emplace_back(crossing(plane, edge.from, edge.to))});
            if (from_out && !to_out)
                kept.push_back({enters.emplace_back(crossing(plane, edge.from, edge.to)), edge.to});
        }
        // A convex face is left once and entered once; rounding in double may give a face without width more.
        for (size_t k = 0; k < std::min(leaves.size(), enters.size()); ++k) {
            kept.push_back({leaves[k], enters[k]});
            border.push_back({enters[k], leaves[k]});
        }
        if (!kept.empty()) result.push_back(std::move(kept));
    }
    if (!cut) return;
    if (!border.empty()) result.push_back(std::move(border));
    prism = std::move(result);
}

template<class T>
T determinant(const Vector<T>& a, const Vector<T>& b, const Vector<T>& c) {
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

// Sums six times a volume. Rational terms are summed in fixed point with `bits` binary digits, because denominators of
// long sums explode; the error is below 1e-60 of a unit.
template<class T>
struct Sum;
template<>
struct Sum<double> {
    double total = 0.0;
    void add(double term, int sign) { total += sign * term; }
    [[nodiscard]] double value() const { return total / 6.0; }
};
template<>
struct Sum<Rational> {
    static constexpr int bits = 256;
    Integer total = 0;
    void add(const Rational& term, int sign) {
        const Integer scaled =
            (boost::multiprecision::numerator(term) << bits) / boost::multiprecision::denominator(term);
        total += sign * scaled;
    }
    [[nodiscard]] double value() const { return static_cast<double>(Rational(total, Integer(6) << bits)); }
};

// The triangles of the surface, found by their place in the plane of x and y.
class Columns {
  public:
    Columns(const Part& mesh, const Bounds& box) : mesh_(mesh), box_(box), marks_(mesh.triangles.size(), UINT32_MAX) {
        side_ = std::clamp<uint32_t>(static_cast<uint32_t>(std::sqrt(mesh.triangles.size() / 4.0)), 1, 512);
        bins_.resize(side_ * side_);
        for (uint32_t t = 0; t < mesh.triangles.size(); ++t) visit(bounds(t), [&](auto& bin) { bin.push_back(t); });
    }

    [[nodiscard]] Bounds bounds(uint32_t t) const {
        const Corners& c = mesh_.triangles[t];
        const std::array<Point, 3> corners{mesh_.points[c[0]], mesh_.points[c[1]], mesh_.points[c[2]]};
        return bounds_of(corners);
    }

    // In ascending order: the triangles whose prism may meet the box.
    [[nodiscard]] std::vector<uint32_t> below_or_in(const Bounds& cell, uint32_t query) {
        std::vector<uint32_t> found;
        visit(cell, [&](const auto& bin) {
            for (const uint32_t t : bin) {
                if (std::exchange(marks_[t], query) == query) continue;
                const Bounds own = bounds(t);
                if (own.min[0] <= cell.max[0] && own.max[0] >= cell.min[0] && own.min[1] <= cell.max[1]
                    && own.max[1] >= cell.min[1] && own.max[2] >= cell.min[2])
                    found.push_back(t);
            }
        });
        std::ranges::sort(found);
        return found;
    }

  private:
    template<class Visitor>
    void visit(const Bounds& range, const Visitor& visitor) {
        std::array<std::array<uint32_t, 2>, 2> from_to{};
        for (int k = 0; k < 2; ++k)
            for (int end = 0; end < 2; ++end) {
                const double at =
                    ((end == 0 ? range.min : range.max)[k] - box_.min[k]) / (box_.max[k] - box_.min[k]) * side_;
                from_to[k][end] = static_cast<uint32_t>(std::clamp(at, 0.0, side_ - 1.0));
            }
        for (uint32_t y = from_to[1][0]; y <= from_to[1][1]; ++y)
            for (uint32_t x = from_to[0][0]; x <= from_to[0][1]; ++x) visitor(bins_[y * side_ + x]);
    }

    const Part& mesh_;
    Bounds box_;
    uint32_t side_ = 1;
    std::vector<std::vector<uint32_t>> bins_;
    std::vector<uint32_t> marks_;
};

template<class T>
double clipped_volume(const Part& mesh, double base, std::span<const uint32_t> triangles,
                      const std::vector<Plane<T>>& planes, const Point& origin) {
    Sum<T> sum;
    const Vector<T> o = corner_at<T>(origin).at;
    for (const uint32_t t : triangles) {
        std::array<Corner<T>, 3> top, bottom;
        for (int k = 0; k < 3; ++k) {
            Point p = mesh.points[mesh.triangles[t][k]];
            top[k] = corner_at<T>(p);
            p[2] = base;
            bottom[k] = corner_at<T>(p);
        }
        const T area = (top[1].at[0] - top[0].at[0]) * (top[2].at[1] - top[0].at[1])
                       - (top[2].at[0] - top[0].at[0]) * (top[1].at[1] - top[0].at[1]);
        if (area == 0) continue; // a vertical triangle spans no volume
        const int sign = area > 0 ? 1 : -1;
        if (sign < 0) {
            std::swap(top[1], top[2]);
            std::swap(bottom[1], bottom[2]);
        }
        Prism<T> prism{{}, {}};
        for (int k = 0; k < 3; ++k) {
            const int next = (k + 1) % 3;
            prism[0].push_back({top[k], top[next]});
            prism[1].push_back({bottom[next], bottom[k]});
            prism.push_back(
                {{bottom[k], bottom[next]}, {bottom[next], top[next]}, {top[next], top[k]}, {top[k], bottom[k]}});
        }
        for (const Plane<T>& plane : planes) {
            clip(prism, plane);
            if (prism.empty()) break;
        }
        const auto seen = [&](const Corner<T>& c) { return Vector<T>{c.at[0] - o[0], c.at[1] - o[1], c.at[2] - o[2]}; };
        for (const std::vector<Edge<T>>& face : prism) {
            const Vector<T> apex = seen(face[0].from);
            for (const Edge<T>& edge : face) sum.add(determinant(apex, seen(edge.from), seen(edge.to)), sign);
        }
    }
    return sum.value();
}

Bounds larger(Bounds box) {
    const double margin = 0.1 * size_of(box);
    for (int k = 0; k < 3; ++k) {
        box.min[k] -= margin;
        box.max[k] += margin;
    }
    return box;
}

} // namespace

CellVolumes cell_volumes(const Part& mesh, std::span<const Point> sites, uint64_t max_prisms) {
    CellVolumes result;
    result.cells.resize(sites.size());
    const Bounds box = bounds_of(mesh.points), around = larger(box);
    const double base = box.min[2];
    Columns columns(mesh, around);

    std::vector<SiteCell> cells;
    std::vector<std::vector<uint32_t>> triangles(sites.size());
    uint64_t prisms = 0;
    for (uint32_t site = 0; site < sites.size(); ++site) {
        cells.push_back(site_cell(sites, site, around));
        if (cells[site].shape.faces.empty()) continue;
        Bounds own = bounds_of(cells[site].shape.points);
        for (int k = 0; k < 3; ++k) { // the cell is rounded
            own.min[k] -= 1e-9 * size_of(box);
            own.max[k] += 1e-9 * size_of(box);
        }
        triangles[site] = columns.below_or_in(own, site);
        prisms += triangles[site].size();
        std::vector<Plane<double>> planes;
        for (const uint32_t other : cells[site].cutters)
            planes.push_back(exact_bisector<double>(sites[site], sites[other]));
        result.cells[site].volume = clipped_volume(mesh, base, triangles[site], planes, sites[site]);
    }
    const auto stride = std::max<uint64_t>(1, (prisms + max_prisms - 1) / std::max<uint64_t>(1, max_prisms));
    for (uint64_t site = 0; site < sites.size(); site += stride) {
        CellVolume& cell = result.cells[site];
        cell.exact = true;
        if (cells[site].shape.faces.empty()) continue;
        std::vector<Plane<Rational>> planes;
        for (const uint32_t other : cells[site].candidates)
            planes.push_back(exact_bisector<Rational>(sites[site], sites[other]));
        const double exact = clipped_volume(mesh, base, triangles[site], planes, sites[site]);
        result.deviation = std::max(result.deviation, std::abs(exact - cell.volume));
        cell.volume = exact;
    }
    return result;
}

std::vector<Part> voronoi_cells(const Part& mesh, std::span<const Point> sites) {
    std::vector<Part> parts;
    const Bounds box = larger(bounds_of(mesh.points));
    for (uint32_t site = 0; site < sites.size(); ++site) {
        Part& part = parts.emplace_back();
        const ConvexCell cell = site_cell(sites, site, box).shape;
        part.points = cell.points;
        for (const std::vector<uint32_t>& face : cell.faces)
            for (size_t k = 2; k < face.size(); ++k) part.triangles.push_back({face[0], face[k - 1], face[k]});
    }
    return parts;
}

} // namespace brittle::comparison

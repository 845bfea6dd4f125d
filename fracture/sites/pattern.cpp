#include "fracture/sites/pattern.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/base/random.h"
#include "fracture/base/rounded_math.h"
#include "fracture/mesh/inside.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/mesh/thickness.h"
#include "fracture/sites/layout.h"
#include "fracture/sites/sites.h"

namespace brittle::fracture {

namespace {

constexpr uint32_t max_sites = 1'000'000;
constexpr uint32_t max_cells = 1000;    // of a piece
constexpr uint32_t max_ball_draws = 20; // per cell of a piece
constexpr double pi = std::numbers::pi;

// The largest radius of a site's ball at grading 1, as a fraction of the mean distance between sites.
constexpr double largest_ball = 0.9;

// Draws per requested inside point before giving up: a solid that fills less than 1 in 2000 of its box gets fewer
// points.
constexpr uint64_t max_draws = 2000;

constexpr std::array<std::string_view, 10> names = {"uniform", "clustered", "radial", "grid",      "bricks",
                                                    "slices",  "splinters", "curve",  "curvature", "thickness"};

Error bad(const std::string& field, const std::string& value, const std::string& wanted) {
    return {Status::invalid_setting, "the pattern's " + field + " is " + value + "; it must be " + wanted};
}

bool finite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

Result<void> check(const Pattern& p) {
    const auto number = [](double value) {
        char digits[32];
        return std::string(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
    };
    if (p.count == 0 || p.count > max_sites) return bad("count", std::to_string(p.count), "1 to 1,000,000");
    if (!std::isfinite(p.piece_size)) return bad("piece_size", number(p.piece_size), "a length in metres, or 0");
    if (!(p.jitter <= 1.0)) return bad("jitter", number(p.jitter), "0 to 1, or negative for the kind's own");
    if (!finite(p.focus)) return bad("focus", "not finite", "three finite numbers");
    if (!finite(p.axis) || !(glm::length(p.axis) > 1e-9))
        return bad("axis", "no direction", "three numbers, not all 0");
    if (!(p.spread > 0.0) || !(p.spread <= 100.0)) return bad("spread", number(p.spread), "above 0, at most 100");
    if (!(p.slenderness >= 1.0) || !(p.slenderness <= 1e4))
        return bad("slenderness", number(p.slenderness), "1 to 10,000");
    if (!(p.grading >= 0.0) || !(p.grading <= 1.0)) return bad("grading", number(p.grading), "0 to 1");
    if (p.cells_per_piece < 1 || p.cells_per_piece > max_cells)
        return bad("cells_per_piece", std::to_string(p.cells_per_piece), "1 to 1,000");
    if (p.kind == PatternKind::curve) {
        if (p.line.size() < 2) return bad("line", std::to_string(p.line.size()) + " points", "two points or more");
        for (const glm::dvec3& at : p.line)
            if (!finite(at)) return bad("line", "not finite", "finite numbers");
    }
    return {};
}

// Finds the site whose cell holds a point. The sites are sorted along the longest side of their box; a search walks away
// from the point in both directions until no site further on can be nearer.
class CellSearch {
  public:
    explicit CellSearch(const PatternSites& made) : made_(made) {
        const glm::dvec3 size = bounds(made.sites).size();
        axis_ = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
        for (uint32_t s = 0; s < made.sites.size(); ++s) order_.push_back(s);
        std::sort(order_.begin(), order_.end(), [&](uint32_t a, uint32_t b) {
            const double x = made_.sites[a][axis_], y = made_.sites[b][axis_];
            return x != y ? x < y : a < b;
        });
        for (const double weight : made.weights) max_weight_ = std::max(max_weight_, weight);
    }

    // Leaves out the site `except`. Precondition: there is another one.
    [[nodiscard]] uint32_t at(const glm::dvec3& p, uint32_t except = no_index) const {
        const auto after = std::lower_bound(order_.begin(), order_.end(), p[axis_],
                                            [&](uint32_t s, double x) { return made_.sites[s][axis_] < x; })
                           - order_.begin();
        uint32_t best = no_index;
        double least = std::numeric_limits<double>::infinity();
        const auto visit = [&](uint32_t s) { // returns false where no further site can be nearer
            const glm::dvec3 d = made_.sites[s] - p;
            if (d[axis_] * d[axis_] - max_weight_ > least) return false;
            const double distance = glm::dot(d, d) - (made_.weights.empty() ? 0.0 : made_.weights[s]);
            if (s != except && (distance < least || (distance == least && s < best))) {
                least = distance;
                best = s;
            }
            return true;
        };
        for (auto k = after; k < std::ssize(order_) && visit(order_[static_cast<size_t>(k)]); ++k) {
        }
        for (auto k = after; k > 0 && visit(order_[static_cast<size_t>(k - 1)]); --k) {
        }
        return best;
    }

  private:
    const PatternSites& made_;
    int axis_ = 0;
    double max_weight_ = 0.0;
    std::vector<uint32_t> order_;
};

// Replaces each site by a group of `cells` sites in its cell: drawn from the whole box, so that they fill the cell, and
// the missing ones, where the cell is small, from a ball about the site.
PatternSites divide(const PatternSites& made, const Box& box, uint32_t cells, Random& random) {
    if (made.sites.size() < 2) {
        PatternSites one = made;
        one.weights.clear();
        return one;
    }
    const CellSearch search(made);
    const auto count = static_cast<uint32_t>(made.sites.size());
    std::vector<uint32_t> missing(count, cells);
    PatternSites divided;
    const auto add = [&](const glm::dvec3& p, uint32_t s) {
        divided.sites.push_back(p);
        divided.groups.push_back(made.groups.empty() ? s : made.groups[s]);
        --missing[s];
    };
    for (uint64_t k = 0; k < uint64_t{4} * cells * count; ++k) {
        const glm::dvec3 p = random.uniform_in(box);
        if (const uint32_t s = search.at(p); missing[s] > 0) add(p, s);
    }
    for (uint32_t s = 0; s < count; ++s) {
        const double radius = 0.5 * glm::distance(made.sites[s], made.sites[search.at(made.sites[s], s)]);
        // Without weights the first draw in the ball lies in the cell; a cell beside a heavy one may be away from its
        // site, or empty.
        for (uint32_t tries = 0; missing[s] > 0 && tries < max_ball_draws * cells; ++tries) {
            const glm::dvec3 d = random.uniform_in({glm::dvec3(-1.0), glm::dvec3(1.0)}), p = made.sites[s] + radius * d;
            if (glm::dot(d, d) <= 1.0 && search.at(p) == s) add(p, s);
        }
    }
    return divided;
}

// The frame of the pattern's axis, with the extents of the mesh's box in it.
struct Frame : AxisFrame {
    glm::dvec3 centre{0.0};
    double length = 0.0; // m along the axis
    double width_u = 0.0, width_v = 0.0;
};

Frame frame_of(const Pattern& pattern, const Box& box) {
    Frame f{axis_frame(glm::normalize(pattern.axis)), box.centre()};
    const auto extent = [&](const glm::dvec3& d) { return glm::dot(box.size(), glm::abs(d)); };
    f.length = extent(f.along);
    f.width_u = extent(f.u);
    f.width_v = extent(f.v);
    return f;
}

class Maker {
  public:
    Maker(const Pattern& pattern, const TriangleMesh& mesh, uint32_t count)
        : pattern_(pattern), mesh_(mesh), box_(bounds(mesh)), frame_(frame_of(pattern, box_)), count_(count),
          random_(pattern.seed) {
        if (pattern.inside) inside_.emplace(mesh);
    }

    PatternSites run() {
        switch (pattern_.kind) {
        case PatternKind::uniform:
            draw([&] { return random_.uniform_in(box_); });
            break;
        case PatternKind::clustered:
            clustered();
            break;
        case PatternKind::radial:
            radial();
            break;
        case PatternKind::grid:
            grid();
            break;
        case PatternKind::bricks:
            bricks();
            break;
        case PatternKind::slices:
            slices();
            break;
        case PatternKind::splinters:
            splinters();
            break;
        case PatternKind::curve:
            curve();
            break;
        case PatternKind::curvature:
            curvature();
            break;
        case PatternKind::thickness:
            thickness();
            break;
        }
        if (pattern_.grading > 0.0 && pattern_.kind != PatternKind::bricks) grade();
        if (inside_) leave_out_outside();
        if (pattern_.cells_per_piece > 1 && !result_.sites.empty())
            return divide(result_, box_, pattern_.cells_per_piece, random_);
        return std::move(result_);
    }

  private:
    [[nodiscard]] double jitter(double own) const { return pattern_.jitter < 0.0 ? own : pattern_.jitter; }
    double centred() { return random_.uniform() - 0.5; }
    [[nodiscard]] glm::dvec3 focus() const { return box_.min + pattern_.focus * box_.size(); }
    void add(const glm::dvec3& site) { result_.sites.push_back(site); }

    // Adds count_ points; with pattern_.inside, each is drawn until it lies inside the solid.
    template<class Draw>
    void draw(const Draw& point) {
        for (uint64_t tries = 0; result_.sites.size() < count_ && tries < max_draws * count_; ++tries) {
            const glm::dvec3 p = point();
            if (!inside_ || (*inside_)(p)) add(p);
        }
    }

    double normal() { // standard normal distribution, after Box and Muller
        const double r = std::sqrt(-2.0 * rounded::log(1.0 - random_.uniform()));
        return r * rounded::cos(2.0 * pi * random_.uniform());
    }

    void clustered() {
        const double spread = pattern_.spread * glm::length(box_.size());
        draw([&] {
            const double x = normal(), y = normal(), z = normal();
            return focus() + spread * glm::dvec3(x, y, z);
        });
    }

    void radial() {
        const double irregular = jitter(0.5);
        const RadialLayout layout{.count = count_,
                                  .reach = 0.5 * rounded::hypot(frame_.width_u, frame_.width_v),
                                  .ring_exponent = 1.6,
                                  .ring_turn = irregular,
                                  .stagger = 0.5,
                                  .angle_jitter = irregular,
                                  .ring_jitter = 0.8 * irregular};
        for (const glm::dvec3& site : radial_sites(layout, focus(), frame_, random_)) add(site);
    }

    // Returns whole numbers of cells along the sides of the box: about count_ in total, with the given proportions.
    [[nodiscard]] glm::uvec3 cells(const glm::dvec3& proportions) const {
        const glm::dvec3 size = glm::max(box_.size() / proportions, glm::dvec3(1e-9 * glm::length(box_.size())));
        const double edge = rounded::cbrt(size.x * size.y * size.z / count_);
        return glm::uvec3(glm::clamp(glm::round(size / edge), glm::dvec3(1.0), glm::dvec3(count_)));
    }

    void grid() {
        const glm::uvec3 n = cells(glm::dvec3(1.0));
        const double irregular = jitter(0.0);
        for (uint32_t z = 0; z < n.z; ++z)
            for (uint32_t y = 0; y < n.y; ++y)
                for (uint32_t x = 0; x < n.x; ++x) {
                    const double a = centred(), b = centred(), c = centred();
                    add(box_.min
                        + (glm::dvec3(x, y, z) + 0.5 + irregular * glm::dvec3(a, b, c)) / glm::dvec3(n) * box_.size());
                }
    }

    // Makes cells of half a brick, two of which form a group: the bisectors between groups are the faces of the bricks.
    void bricks() {
        const glm::uvec3 n = cells(glm::dvec3(2.0, 0.7, 1.0));
        const glm::dvec3 half = box_.size() / glm::dvec3(2.0 * n.x, n.y, n.z);
        const double irregular = 0.4 * jitter(0.0);
        for (uint32_t z = 0; z < n.z; ++z)
            for (uint32_t y = 0; y < n.y; ++y) {
                const uint32_t shift = (y + z) % 2;
                for (uint32_t x = 0; x < 2 * n.x; ++x) {
                    const double a = centred(), b = centred(), c = centred();
                    add(box_.min + (glm::dvec3(x, y, z) + 0.5 + irregular * glm::dvec3(a, b, c)) * half);
                    result_.groups.push_back((z * n.y + y) * (n.x + 1) + (x + shift) / 2);
                }
            }
    }

    void slices() {
        const double irregular = jitter(0.0);
        for (uint32_t k = 0; k < count_; ++k) {
            const double at = ((k + 0.5 + irregular * centred()) / count_ - 0.5) * frame_.length;
            const double a = centred(), b = centred();
            // A lateral offset as well, so that slices are not parallel.
            const double tilt = irregular * frame_.length / count_;
            add(frame_.centre + at * frame_.along + tilt * (a * frame_.u + b * frame_.v));
        }
    }

    void splinters() {
        const double across = std::sqrt(frame_.width_u * frame_.width_v);
        const double layers = std::clamp(
            std::round(rounded::pow(frame_.length * std::sqrt(count_) / (pattern_.slenderness * across), 2.0 / 3.0)),
            1.0, static_cast<double>(count_));
        const double depth = frame_.length / layers, width = across / std::sqrt(count_ / layers);
        SplinterLayers stack{frame_.centre, frame_.along, {}};
        for (double layer = 0.5; layer < layers; ++layer) stack.heights.push_back(layer * depth - 0.5 * frame_.length);
        const double lift_jitter = 0.4 * jitter(0.6); // width of the random range of lifts, in widths of a splinter
        for (uint32_t k = 0; k < count_; ++k) {
            const double u = centred() * frame_.width_u, v = centred() * frame_.width_v;
            const double lift = lift_jitter * centred() * width;
            add(stack.on_axis(stack.layer_of(k), lift) + u * frame_.u + v * frame_.v);
        }
    }

    // Makes pairs of sites that mirror each other in the line.
    void curve() {
        std::vector<glm::dvec3> line;
        std::vector<double> at{0.0};
        for (const glm::dvec3& p : pattern_.line) {
            line.push_back(box_.min + p * box_.size());
            if (line.size() > 1) at.push_back(at.back() + glm::distance(line[line.size() - 2], line.back()));
        }
        const uint32_t steps = std::max(1u, count_ / 2);
        const double step = at.back() / steps, irregular = jitter(0.5);
        for (uint32_t k = 0; k < steps; ++k) {
            const double s = (k + 0.5) * step;
            const auto next = std::clamp<std::ptrdiff_t>(std::upper_bound(at.begin(), at.end(), s) - at.begin(), 1,
                                                         static_cast<std::ptrdiff_t>(at.size()) - 1);
            const auto to = static_cast<size_t>(next);
            const double length = at[to] - at[to - 1];
            const glm::dvec3 tangent = length > 0.0 ? (line[to] - line[to - 1]) / length : frame_.u;
            glm::dvec3 across = glm::cross(frame_.along, tangent);
            across = glm::length(across) > 1e-9 ? glm::normalize(across) : frame_.v;
            const double a = centred(), b = centred();
            const glm::dvec3 on =
                line[to - 1] + (s - at[to - 1]) * tangent + irregular * step * (a * across + b * tangent);
            const double off = 0.5 * step * (1.0 + irregular * centred());
            add(on + off * across);
            add(on - off * across);
        }
    }

    // Draws edges with a probability proportional to length times bend angle, and places a site slightly below the
    // surface.
    void curvature() {
        struct Edge {
            uint32_t low, high, triangle;
        };
        std::vector<Edge> edges;
        for (uint32_t t = 0; t < mesh_.triangles.size(); ++t)
            for (int k = 0; k < 3; ++k) {
                const auto [low, high] = std::minmax({mesh_.triangles[t][k], mesh_.triangles[t][(k + 1) % 3]});
                edges.push_back({low, high, t});
            }
        std::sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
            return std::tie(x.low, x.high, x.triangle) < std::tie(y.low, y.high, y.triangle);
        });
        const auto normal_of = [&](uint32_t t) {
            const Triangle& c = mesh_.triangles[t];
            const glm::dvec3 n =
                glm::cross(mesh_.positions[c.y] - mesh_.positions[c.x], mesh_.positions[c.z] - mesh_.positions[c.x]);
            const double length = glm::length(n);
            return length > 0.0 ? n / length : glm::dvec3(0.0);
        };
        std::vector<double> weight; // running sum over pairs
        std::vector<size_t> pairs;
        double sum = 0.0;
        for (size_t k = 0; k + 1 < edges.size(); k += 2) {
            const glm::dvec3 a = normal_of(edges[k].triangle), b = normal_of(edges[k + 1].triangle);
            const double bend = rounded::acos(std::clamp(glm::dot(a, b), -1.0, 1.0)) + 1e-3;
            sum += bend * glm::distance(mesh_.positions[edges[k].low], mesh_.positions[edges[k].high]);
            weight.push_back(sum);
            pairs.push_back(k);
        }
        const double depth = 0.02 * glm::length(box_.size());
        draw([&] {
            const auto at = std::upper_bound(weight.begin(), weight.end(), random_.uniform() * sum) - weight.begin();
            const size_t k = pairs[std::min(static_cast<size_t>(at), pairs.size() - 1)];
            const double t = random_.uniform(), in = random_.uniform() * depth;
            const glm::dvec3 on = glm::mix(mesh_.positions[edges[k].low], mesh_.positions[edges[k].high], t);
            const glm::dvec3 out = normal_of(edges[k].triangle) + normal_of(edges[k + 1].triangle);
            return on - in * (glm::length(out) > 1e-9 ? glm::normalize(out) : out);
        });
    }

    // Draws a point of the surface and a site between it and the opposite side. Pieces as wide as the local thickness
    // mean a site density of its inverse cube in the volume, hence of its inverse square on the surface.
    void thickness() {
        const Thickness through(mesh_);
        const double least = 0.02 * glm::length(box_.size());
        std::vector<double> weight; // running sum
        double sum = 0.0;
        for (uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
            const Triangle& c = mesh_.triangles[t];
            const glm::dvec3 &p = mesh_.positions[c.x], &q = mesh_.positions[c.y], &r = mesh_.positions[c.z];
            const double thick = std::max(through.at(t, (p + q + r) / 3.0).value_or(0.0), least);
            sum += glm::length(glm::cross(q - p, r - p)) / (thick * thick);
            weight.push_back(sum);
        }
        draw([&] {
            const auto at = std::upper_bound(weight.begin(), weight.end(), random_.uniform() * sum) - weight.begin();
            const auto t = static_cast<uint32_t>(std::min<size_t>(static_cast<size_t>(at), weight.size() - 1));
            const Triangle& c = mesh_.triangles[t];
            double u = random_.uniform(), v = random_.uniform();
            if (u + v > 1.0) {
                u = 1.0 - u;
                v = 1.0 - v;
            }
            const glm::dvec3& p = mesh_.positions[c.x];
            const glm::dvec3 on = p + u * (mesh_.positions[c.y] - p) + v * (mesh_.positions[c.z] - p);
            return on + random_.uniform() * through.at(t, on).value_or(0.0) * through.inward(t);
        });
    }

    // Gives the sites random balls as weights, up to largest_ball. Squaring the random number makes small balls common.
    void grade() {
        const glm::dvec3 size = box_.size();
        const double spacing = rounded::cbrt(size.x * size.y * size.z / static_cast<double>(result_.sites.size()));
        for (size_t k = 0; k < result_.sites.size(); ++k) {
            const double u = random_.uniform(), radius = largest_ball * pattern_.grading * spacing * u * u;
            result_.weights.push_back(radius * radius);
        }
    }

    void leave_out_outside() {
        PatternSites kept;
        for (size_t k = 0; k < result_.sites.size(); ++k) {
            if (!(*inside_)(result_.sites[k])) continue;
            kept.sites.push_back(result_.sites[k]);
            if (!result_.groups.empty()) kept.groups.push_back(result_.groups[k]);
            if (!result_.weights.empty()) kept.weights.push_back(result_.weights[k]);
        }
        result_ = std::move(kept);
    }

    const Pattern& pattern_;
    const TriangleMesh& mesh_;
    Box box_;
    Frame frame_;
    uint32_t count_;
    Random random_;
    std::optional<InsideTest> inside_; // for pattern_.inside
    PatternSites result_;
};

} // namespace

std::span<const std::string_view> pattern_names() {
    return names;
}

Result<PatternSites> make_sites(const Pattern& pattern, const TriangleMesh& mesh) {
    if (Result<void> checked = check(pattern); !checked) return checked.error();
    if (mesh.triangles.empty()) return Error{Status::empty_mesh, "the mesh has no triangles to break"};
    uint32_t count = pattern.count;
    if (pattern.piece_size > 0.0) {
        const double volume = std::abs(signed_volume(mesh.positions, mesh.triangles));
        const double wanted = std::round(volume / rounded::pow(pattern.piece_size, 3.0));
        if (!(wanted <= max_sites))
            return bad("piece_size", std::to_string(pattern.piece_size),
                       "larger: the solid holds more than a million pieces of that size");
        count = std::max(1u, static_cast<uint32_t>(wanted));
    }
    if (uint64_t{count} * pattern.cells_per_piece > max_sites)
        return bad("cells_per_piece", std::to_string(pattern.cells_per_piece),
                   "smaller: " + std::to_string(count) + " pieces would have more than a million cells");
    PatternSites sites = Maker(pattern, mesh, count).run();
    if (sites.sites.empty())
        return Error{Status::invalid_setting, "none of the pattern's sites lies inside the solid; give more, or leave "
                                              "out `inside`"};
    return sites;
}

std::vector<glm::dvec3> place(std::span<const glm::dvec3> sites, const Box& from, const Box& onto,
                              const Placement& placement) {
    const auto longest = [](const glm::dvec3& size) { return std::max({size.x, size.y, size.z}); };
    const double scale = longest(from.size()) > 0.0 ? longest(onto.size()) / longest(from.size()) : 1.0;
    std::vector<glm::dvec3> placed;
    placed.reserve(sites.size());
    for (glm::dvec3 p : sites) {
        p -= from.centre();
        for (int axis = 0; axis < 3; ++axis) {
            const double angle = std::fmod(placement.turn[axis], 360.0) * pi / 180.0;
            const double c = rounded::cos(angle), s = rounded::sin(angle);
            const int a = (axis + 1) % 3, b = (axis + 2) % 3;
            const double x = p[a], y = p[b];
            p[a] = c * x - s * y;
            p[b] = s * x + c * y;
        }
        placed.push_back(onto.centre() + scale * placement.scale * p + placement.move);
    }
    return placed;
}

} // namespace brittle::fracture

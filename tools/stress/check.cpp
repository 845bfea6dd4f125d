#include "tools/stress/check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <tuple>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/exact/exact.h"
#include "fracture/fracture.h"
#include "fracture/mesh/intersections.h"
#include "fracture/pieces/certificate.h"
#include "tools/stress/check_local.h"
#include "tools/stress/check_union.h"

namespace brittle::stress {

using namespace fracture;

namespace {

// Limits of the checks of rough cuts: triangles times sites of a case, triangles that roughness adds, and pairs that are
// tested for a crossing.
constexpr size_t max_rough_work = 10'000;
constexpr uint64_t max_rough_triangles = 4'000, max_pairs = 200'000;

// Limit for `sequential`, which clips all triangles for all pairs of sites.
constexpr size_t max_sequential_work = 60'000;

std::string format(const char* text, double a, double b = 0.0) {
    char buffer[200];
    std::snprintf(buffer, sizeof buffer, text, a, b);
    return buffer;
}

std::string topology_complaint(const Fragments& f, const Piece& piece) {
    struct HalfEdge {
        uint32_t from, to, triangle;
    };
    std::vector<HalfEdge> edges;
    const auto triangles = f.triangles_of(piece);
    for (uint32_t t = 0; t < triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k) {
            if (triangles[t][k] >= piece.vertices.size()) return "an index is out of range";
            edges.push_back({triangles[t][k], triangles[t][(k + 1) % 3], t});
        }
    }
    const auto before = [](const HalfEdge& x, const HalfEdge& y) {
        return std::tie(x.from, x.to) < std::tie(y.from, y.to);
    };
    std::sort(edges.begin(), edges.end(), before);
    const auto find = [&](uint32_t from, uint32_t to) -> const HalfEdge* {
        const auto at = std::lower_bound(edges.begin(), edges.end(), HalfEdge{from, to, 0}, before);
        return at != edges.end() && at->from == from && at->to == to ? &*at : nullptr;
    };
    for (size_t k = 0; k < edges.size(); ++k) {
        if (k > 0 && edges[k].from == edges[k - 1].from && edges[k].to == edges[k - 1].to)
            return "an edge is used twice in one direction";
        if (!find(edges[k].to, edges[k].from)) return "an edge has one triangle only";
    }
    size_t at = 0;
    for (uint32_t v = 0; v < piece.vertices.size(); ++v) {
        const size_t begin = at;
        while (at < edges.size() && edges[at].from == v) ++at;
        if (begin == at) return "a vertex has no triangle";
        size_t steps = 0;
        const HalfEdge* edge = &edges[begin];
        do { // across the edge, then along the triangle to the edge that leaves v
            const Triangle& t = triangles[find(edge->to, v)->triangle];
            const int k = t.x == v ? 0 : (t.y == v ? 1 : 2);
            edge = find(v, t[(k + 1) % 3]);
        } while (++steps <= at - begin && edge != &edges[begin]);
        if (steps != at - begin) return "a vertex has several fans of triangles";
    }
    return {};
}

struct Measure {
    long double volume = 0.0L, area = 0.0L;
};

// Relative to the first corner: far from the origin, products would cancel the digits of small pieces.
template<class Position>
Measure measure(std::span<const Triangle> triangles, const Position& position) {
    Measure sum;
    const std::array<long double, 3> origin = position(triangles[0].x);
    for (const Triangle& t : triangles) {
        std::array<std::array<long double, 3>, 3> p{};
        for (int k = 0; k < 3; ++k) {
            p[static_cast<size_t>(k)] = position(t[k]);
            for (size_t axis = 0; axis < 3; ++axis) p[static_cast<size_t>(k)][axis] -= origin[axis];
        }
        const auto& [a, b, c] = p;
        const auto cross = [](const auto& x, const auto& y) {
            return std::array{x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]};
        };
        const auto bc = cross(b, c);
        sum.volume += (a[0] * bc[0] + a[1] * bc[1] + a[2] * bc[2]) / 6.0L;
        const auto n =
            cross(std::array{b[0] - a[0], b[1] - a[1], b[2] - a[2]}, std::array{c[0] - a[0], c[1] - a[1], c[2] - a[2]});
        sum.area += std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / 2.0L;
    }
    return sum;
}

std::array<long double, 3> extended(const glm::dvec3& p) {
    return {p.x, p.y, p.z};
}

std::string volume_complaint(const Case& c, const Fragments& f) {
    const Box box = bounds(c.mesh);
    const glm::dvec3 centre = box.centre();
    const glm::dvec3 furthest = glm::max(glm::abs(box.min), glm::abs(box.max));
    const double extent = std::max({furthest.x, furthest.y, furthest.z});
    const double size = std::max({box.size().x, box.size().y, box.size().z});
    const Measure input = measure(c.mesh.triangles, [&](uint32_t v) { return extended(c.mesh.positions[v]); });
    Measure sum, stored;
    long double absolute = 0.0L;
    for (const Piece& piece : f.pieces) {
        const auto positions = f.positions_of(piece);
        const auto triangles = f.triangles_of(piece);
        const Measure one = measure(triangles, [&](uint32_t v) { return extended(positions[v]); });
        const Measure rounded = measure(triangles, [&](uint32_t v) {
            const glm::dvec3 p = positions[v] - centre;
            return std::array<long double, 3>{static_cast<float>(p.x), static_cast<float>(p.y),
                                              static_cast<float>(p.z)};
        });
        sum.volume += one.volume;
        sum.area += one.area;
        stored.volume += rounded.volume;
        absolute += std::abs(one.volume);
        const long double piece_rounding = 64 * 0x1p-53L * extent * one.area + 1e-12L * std::abs(one.volume);
        if (std::abs(piece.mass.volume - one.volume) > piece_rounding)
            return format("a piece of volume %.17g says %.17g", static_cast<double>(one.volume), piece.mass.volume);
    }
    absolute = std::max(absolute, std::abs(input.volume));
    const long double rounding = 64 * 0x1p-53L * extent * (input.area + sum.area);
    if (!(std::abs(sum.volume - input.volume) <= std::max(1e-12L * absolute, rounding)))
        return format("pieces sum to %.17g of %.17g", static_cast<double>(sum.volume),
                      static_cast<double>(input.volume));
    const long double float_rounding = 8 * 0x1p-24L * size * input.area;
    if (!(std::abs(stored.volume - input.volume) <= std::max(1e-6L * absolute, float_rounding + rounding)))
        return format("pieces stored as floats sum to %.17g of %.17g", static_cast<double>(stored.volume),
                      static_cast<double>(input.volume));
    return {};
}

// Merging pieces may split an edge of a cap on one side alone (merge.h); then the areas of the sides must agree. Sheets
// without volume merge at any setting.
std::string cap_complaint(const Case& c, const Fragments& f) {
    std::map<uint32_t, glm::dvec3> places;
    using Corner = std::array<double, 3>;
    using Side = std::tuple<uint32_t, uint32_t, std::array<Corner, 3>>; // this site, the other, corners
    std::map<Side, int> balance;
    const auto from_least = [](std::array<Corner, 3> corners) {
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
        return corners;
    };
    for (const Piece& piece : f.pieces) {
        for (uint32_t v = piece.vertices.begin; v < piece.vertices.end; ++v) {
            if (places.emplace(f.vertex_point[v], f.positions[v]).first->second != f.positions[v])
                return "a point is at two places";
        }
        for (uint32_t t = piece.triangles.begin + piece.exterior_triangles; t < piece.triangles.end; ++t) {
            std::array<Corner, 3> corners{};
            for (int k = 0; k < 3; ++k) {
                const glm::dvec3& p = f.positions[piece.vertices.begin + f.triangles[t][k]];
                corners[static_cast<size_t>(k)] = {p.x, p.y, p.z};
            }
            const uint32_t other = f.triangle_source[t];
            ++balance[{piece.site, other, from_least(corners)}];
            std::swap(corners[1], corners[2]);
            --balance[{other, piece.site, from_least(corners)}];
        }
    }
    const auto differing = std::count_if(balance.begin(), balance.end(), [](const auto& s) { return s.second != 0; });
    if (differing > 16 && c.groups.empty() && c.min_volume == 0.0)
        return std::to_string(differing) + " cap triangles differ on their two sides";
    std::map<std::pair<uint32_t, uint32_t>, glm::dvec3> unpaired; // sums of area vectors
    double extent = 0.0;
    for (const auto& [side, count] : balance) {
        if (count == 0) continue;
        const auto& [site, other, corners] = side;
        const auto p = [&corners = corners](size_t k) {
            return glm::dvec3(corners[k][0], corners[k][1], corners[k][2]);
        };
        unpaired[std::minmax(site, other)] += 0.5 * count * glm::cross(p(1) - p(0), p(2) - p(0));
        extent = std::max({extent, glm::length(p(0)), glm::length(p(1)), glm::length(p(2))});
    }
    const glm::dvec3 size = bounds(c.mesh).size();
    for (const auto& [sites, area] : unpaired) {
        if (glm::length(area) > 1e-12 * extent * std::max({size.x, size.y, size.z}))
            return "two sides of a cap differ in area between sites " + std::to_string(sites.first) + " and "
                   + std::to_string(sites.second);
    }
    return {};
}

std::string cell_complaint(const Case& c, const Fragments& f) {
    const glm::dvec3 size = bounds(c.mesh).size();
    const double scale = std::max({size.x, size.y, size.z});
    for (const Piece& piece : f.pieces) {
        const glm::dvec3& own = c.sites[piece.site];
        for (const glm::dvec3& p : f.positions_of(piece)) {
            for (size_t k = 0; k < c.sites.size(); ++k) {
                const glm::dvec3& other = c.sites[k];
                const glm::dvec3 n = other - own;
                const double length = glm::length(n);
                if (!(length > 0.0)) continue;
                const double shift = c.weights.empty() ? 0.0 : 0.5 * (c.weights[piece.site] - c.weights[k]) / length;
                const double beyond = glm::dot(p - 0.5 * (own + other), n) / length - shift;
                const double rounding =
                    1e-13 * (glm::length(p) + glm::length(own) + glm::length(other) + std::abs(shift));
                if (beyond > 1e-9 * scale + rounding)
                    return "a vertex of site " + std::to_string(piece.site) + "'s piece lies "
                           + format("%g outside its cell, mesh size %g", beyond, scale);
            }
        }
    }
    return {};
}

// Checks cells before pieces merge, because a fold without volume, or a part of a thin mesh, merges with a neighbour in
// another cell.
std::string cell_complaint_before_merging(const Case& c) {
    const Result<Fragments> cut = exact::fracture_exact(c.mesh, c.sites, {.threads = 1, .weights = c.weights});
    return cut ? cell_complaint(c, *cut) : std::string(); // no complaint where it refuses solids that touch in a vertex
}

// The volume of a crumb may be as small as its rounding error, hence slightly negative.
std::string inside_out_complaint(const Case& c, const Fragments& f) {
    const Box box = bounds(c.mesh);
    const glm::dvec3 furthest = glm::max(glm::abs(box.min), glm::abs(box.max));
    const double extent = std::max({furthest.x, furthest.y, furthest.z});
    for (const Piece& piece : f.pieces)
        if (!(piece.mass.volume > -64 * 0x1p-53 * extent * piece.mass.area))
            return "site " + std::to_string(piece.site) + format(": a piece has volume %g", piece.mass.volume);
    return {};
}

// No cut separates cells of one group, and no piece below the minimum volume has a neighbour.
std::string group_complaint(const Case& c, const Fragments& f) {
    for (const Bond& bond : f.bonds) {
        const Piece &a = f.pieces[bond.a], &b = f.pieces[bond.b];
        if (!c.groups.empty() && c.min_volume == 0.0 && c.groups[a.site] == c.groups[b.site])
            return "two pieces of a group touch";
        if (std::min(std::abs(a.mass.volume), std::abs(b.mass.volume)) < (1.0 - 1e-9) * c.min_volume)
            return "a small piece has a neighbour";
    }
    return {};
}

std::string difference_from_sequential(const Case& c, const Fragments& f) {
    const Result<Fragments> reference =
        fracture::fracture(c.mesh, c.sites, {.algorithm = Algorithm::sequential, .weights = c.weights});
    if (!reference) return "sequential refuses it: " + reference.error().message;
    struct Cell {
        double volume = 0.0;
        int islands = 0;
    };
    std::map<uint32_t, std::array<Cell, 2>> cells;
    double whole = 0.0;
    for (const Piece& piece : f.pieces) {
        cells[piece.site][0].volume += piece.mass.volume;
        ++cells[piece.site][0].islands;
        whole += piece.mass.volume;
    }
    for (const Piece& piece : reference->pieces) {
        cells[piece.site][1].volume += piece.mass.volume;
        ++cells[piece.site][1].islands;
    }
    for (const auto& [site, cell] : cells) {
        if (std::abs(cell[0].volume - cell[1].volume) > 1e-9 * whole)
            return "cell " + std::to_string(site)
                   + format(" has %.17g, by sequential %.17g", cell[0].volume, cell[1].volume);
        // One of the two may drop an island of negligible volume.
        if (cell[0].islands != cell[1].islands && std::min(cell[0].volume, cell[1].volume) > 1e-6 * whole)
            return "cell " + std::to_string(site)
                   + format(" has %g islands, by sequential %g", cell[0].islands, cell[1].islands);
    }
    return {};
}

// Checks the pieces of the cut alone: of a mesh that crosses itself, fracture() refuses those that are inside out.
std::string complaint_of_cut(const Case& c) {
    const Result<Fragments> cut = exact::fracture_exact(c.mesh, c.sites, {.threads = 1, .weights = c.weights});
    if (!cut) return {}; // solids that touch in a vertex
    for (const Piece& piece : cut->pieces)
        if (std::string wrong = topology_complaint(*cut, piece); !wrong.empty())
            return "site " + std::to_string(piece.site) + ": " + wrong;
    if (std::string wrong = volume_complaint(c, *cut); !wrong.empty()) return wrong;
    const Result<Fragments> again = exact::fracture_exact(c.mesh, c.sites, {.threads = 4, .weights = c.weights});
    return again && hash(*again) == hash(*cut) ? "" : "differs with 4 threads";
}

// The triangles that cross another one of their piece, where the whole search is cheap; 0 otherwise.
uint64_t count_crossings(const Fragments& f) {
    uint64_t sum = 0;
    for (const Piece& piece : f.pieces) {
        const auto positions = f.positions_of(piece);
        const auto triangles = f.triangles_of(piece);
        const TriangleMesh mesh{{positions.begin(), positions.end()}, {triangles.begin(), triangles.end()}};
        sum += find_intersections(mesh, max_pairs).pairs;
    }
    return sum;
}

// Cuts the case with rough cuts: the same promises, and no crossing that is not counted.
std::string complaint_of_rough(const Case& c) {
    const auto run = [&](uint32_t threads) {
        Settings settings{.threads = threads, .groups = c.groups, .weights = c.weights, .min_volume = c.min_volume};
        settings.rough = {.amount = 0.5, .seed = c.sites.size(), .max_triangles = max_rough_triangles};
        return fracture::fracture(c.mesh, c.sites, settings);
    };
    const Result<Fragments> result = run(1);
    if (!result) {
        const bool may_invert = !c.simple && result.error().status == Status::inverted_part;
        return c.expect == Expect::pieces && !may_invert ? "refused: " + result.error().message : "";
    }
    const Fragments& f = *result;
    for (const Piece& piece : f.pieces)
        if (std::string wrong = topology_complaint(f, piece); !wrong.empty())
            return "site " + std::to_string(piece.site) + ": " + wrong;
    if (std::string wrong = volume_complaint(c, f); !wrong.empty()) return wrong;
    if (std::string wrong = cap_complaint(c, f); !wrong.empty()) return wrong;
    const Result<Fragments> again = run(3);
    if (!again || hash(*again) != hash(f)) return "differs with 3 threads";
    if (c.simple && c.groups.empty() && f.crossings == 0 && count_crossings(f) > 0)
        return "has crossings that are not counted";
    return {};
}

} // namespace

std::string complaint(const Case& c) {
    if (std::string wrong = union_complaint(c); !wrong.empty()) return wrong;
    const auto run = [&](uint32_t threads) {
        return fracture::fracture(
            c.mesh, c.sites,
            {.threads = threads, .groups = c.groups, .weights = c.weights, .min_volume = c.min_volume});
    };
    const Result<Fragments> result = run(1);
    if (!result && !c.simple && result.error().status == Status::inverted_part) return complaint_of_cut(c);
    if (!result) {
        if (c.expect == Expect::pieces) return "refused: " + result.error().message;
        return result.error().message.empty() ? "refused without a reason" : "";
    }
    if (c.expect == Expect::refusal) return "not refused";
    const Fragments& f = *result;
    for (const Piece& piece : f.pieces) {
        if (std::string wrong = topology_complaint(f, piece); !wrong.empty())
            return "site " + std::to_string(piece.site) + ": " + wrong;
    }
    if (std::string wrong = volume_complaint(c, f); !wrong.empty()) return wrong;
    if (std::string wrong = cap_complaint(c, f); !wrong.empty()) return wrong;
    if (std::string wrong = cell_complaint_before_merging(c); !wrong.empty()) return wrong;
    if (c.simple) {
        if (std::string wrong = inside_out_complaint(c, f); !wrong.empty()) return wrong;
        if (c.groups.empty() && c.min_volume == 0.0)
            if (std::string wrong = cell_complaint(c, f); !wrong.empty()) return wrong;
    }
    const uint32_t others[] = {2, 4, 8};
    const uint32_t threads = others[(c.sites.size() + c.mesh.triangles.size()) % 3];
    const Result<Fragments> again = run(threads);
    if (std::string wrong = group_complaint(c, f); !wrong.empty()) return wrong;
    if (!again || hash(*again) != hash(f)) return "differs with " + std::to_string(threads) + " threads";
    if (std::string wrong = local_complaint(c); !wrong.empty()) return wrong;
    if (c.generic && c.mesh.triangles.size() * c.sites.size() <= max_sequential_work)
        if (std::string wrong = difference_from_sequential(c, f); !wrong.empty()) return wrong;
    // Rounding decides what thin and tangled meshes become when they are bent.
    if (!c.simple || !c.generic || c.mesh.triangles.size() * c.sites.size() > max_rough_work) return {};
    std::string wrong = complaint_of_rough(c);
    return wrong.empty() ? wrong : "rough cuts: " + wrong;
}

} // namespace brittle::stress

#include "fracture/unite/unite.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <optional>
#include <span>
#include <tuple>

#include <glm/common.hpp>

#include "fracture/doctor/mending/steps.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/unite/arrangement.h"
#include "fracture/unite/facets.h"
#include "fracture/unite/parts.h"

namespace brittle::fracture {
namespace {

using arrangement::Arrangement;
using arrangement::Facet;
using arrangement::MeshPart;

// The rounding of new vertices can make triangles cross that are nearly in one plane. Another round unites these; hardly
// any mesh needs more than two. Where faces are nearly in one plane, rounding may go on for ever, and cut more triangles
// from round to round. Later rounds therefore begin with the mesh that needed the fewest cuts, and move the vertices of
// the triangles in question to a grid, which becomes coarser, until nothing crosses.
constexpr uint32_t max_rounds = 16;
constexpr uint32_t exact_rounds = 3;
constexpr int first_grid = -50; // exponent, relative to that of the largest coordinate
constexpr double coarser = 4.0; // from round to round: the last exponent is -26
// A mesh in which a part meets more others than this on average is united by halves, a few parts at once at first.
constexpr double max_neighbours = 8.0;
constexpr size_t max_parts_at_once = 4;
// The most often that edges with equal ends are halved (mending::separate()).
constexpr int max_separations = 16;

bool is_solid(int winding) {
    return winding > 0;
}

// Whether a facet bounds the region as a triangle of the input does.
bool is_clean(const Facet& facet) {
    return facet.multiplicity == 1 && facet.front == 0;
}

double inside_out_volume(const Arrangement& all, std::span<const Facet> facets) {
    std::vector<glm::dvec3> positions;
    std::vector<Triangle> triangles;
    for (const Facet& facet : facets) {
        if ((facet.front < 0) == (facet.back() < 0)) continue;
        const auto first = static_cast<uint32_t>(positions.size());
        for (int k = 0; k < 3; ++k) positions.push_back(all.points[facet.points[k]]);
        triangles.push_back(facet.front < 0 ? Triangle(first, first + 2, first + 1)
                                            : Triangle(first, first + 1, first + 2));
    }
    return std::max(signed_volume(positions, triangles), 0.0);
}

Triangle with_lowest_first(const Triangle& t) {
    if (t.x < t.y && t.x < t.z) return t;
    return t.y < t.z ? Triangle(t.y, t.z, t.x) : Triangle(t.z, t.x, t.y);
}

// Drops pairs of triangles that are each other's backs.
void cancel_backs(std::vector<Triangle>& triangles, std::vector<uint32_t>& source) {
    const auto corners = [](const Triangle& t) {
        std::array<uint32_t, 3> c{t.x, t.y, t.z};
        std::sort(c.begin(), c.end());
        return c;
    };
    std::vector<uint32_t> order(triangles.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
        return std::tuple(corners(triangles[a]), a) < std::tuple(corners(triangles[b]), b);
    });
    std::vector<uint8_t> gone(triangles.size(), 0);
    for (size_t k = 0; k < order.size(); ++k)
        for (size_t j = k + 1; j < order.size() && corners(triangles[order[j]]) == corners(triangles[order[k]]); ++j)
            if (!gone[order[k]] && !gone[order[j]]
                && with_lowest_first(triangles[order[j]]) != with_lowest_first(triangles[order[k]]))
                gone[order[k]] = gone[order[j]] = 1;
    size_t kept = 0;
    for (size_t t = 0; t < triangles.size(); ++t) {
        if (gone[t]) continue;
        triangles[kept] = triangles[t];
        source[kept++] = source[t];
    }
    triangles.resize(kept);
    source.resize(kept);
}

struct Boundary {
    TriangleMesh mesh;
    std::vector<uint32_t> source;
    std::vector<uint8_t> is_fresh; // per triangle: not one of the arrangement's mesh
};

// Takes the facets that bound the region, with the region behind them.
Boundary boundary_of(const Arrangement& all, std::span<const Facet> facets) {
    std::vector<Triangle> triangles;
    std::vector<uint32_t> source;
    bool any_merged = false;
    for (const Facet& facet : facets) {
        if (is_solid(facet.front) == is_solid(facet.back())) continue;
        const bool turned = is_solid(facet.front);
        Triangle t(all.points.first_at(facet.points.x), all.points.first_at(facet.points.y),
                   all.points.first_at(facet.points.z));
        any_merged = any_merged || t != facet.points;
        if (t.x == t.y || t.y == t.z || t.z == t.x) continue;
        if (turned) std::swap(t.y, t.z);
        triangles.push_back(t);
        source.push_back(turned && facet.source[1] != no_index ? facet.source[1] : facet.source[0]);
    }
    if (any_merged) cancel_backs(triangles, source);
    std::vector<uint32_t> index(all.points.size(), no_index);
    for (const Triangle& t : triangles)
        for (int k = 0; k < 3; ++k) index[t[k]] = 0;
    TriangleMesh mesh;
    for (uint32_t p = 0; p < index.size(); ++p) {
        if (index[p] == no_index) continue;
        index[p] = static_cast<uint32_t>(mesh.positions.size());
        mesh.positions.push_back(all.points[p]);
    }
    for (const Triangle& t : triangles) mesh.triangles.push_back({index[t.x], index[t.y], index[t.z]});

    mending::Work work(mesh);
    for (int k = 0; k < max_separations && mending::separate(work); ++k) {
    }
    Boundary boundary{std::move(work.mesh), {}, {}};
    for (const uint32_t t : work.source) {
        boundary.source.push_back(source[t]);
        boundary.is_fresh.push_back(work.report.halved_edges.count > 0 || all.cut_of[source[t]] != no_index ? 1 : 0);
    }
    return boundary;
}

// Moves the vertices of fresh triangles to a grid, with all others at their places. The triangles that these move become
// fresh.
void snap(TriangleMesh& mesh, std::vector<uint8_t>& is_fresh, double step) {
    const arrangement::Points points(mesh.positions);
    std::vector<uint8_t> moves(mesh.positions.size(), 0); // by the first vertex of each place
    for (size_t t = 0; t < mesh.triangles.size(); ++t)
        for (int k = 0; is_fresh[t] && k < 3; ++k) moves[points.first_at(mesh.triangles[t][k])] = 1;
    for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
        const uint32_t first = points.first_at(v);
        if (!moves[first]) continue;
        mesh.positions[v] = glm::round(points[first] / step) * step;
        if (mesh.positions[v] != points[first]) moves[first] = 2;
    }
    for (size_t t = 0; t < mesh.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k)
            if (moves[points.first_at(mesh.triangles[t][k])] == 2) is_fresh[t] = 1;
}

// The exponent of the largest coordinate.
int exponent_of(const TriangleMesh& mesh) {
    const Box box = bounds(mesh);
    const glm::dvec3 far = glm::max(glm::abs(box.min), glm::abs(box.max));
    int exponent = 0;
    static_cast<void>(std::frexp(std::max({far.x, far.y, far.z}), &exponent));
    return exponent;
}

void count_changes(const TriangleMesh& before, const United& united, UniteReport& report) {
    std::vector<uint8_t> remains(before.triangles.size(), 0);
    for (const uint32_t t : united.source_triangle) remains[t] = 1;
    report.dropped_triangles = static_cast<uint32_t>(std::count(remains.begin(), remains.end(), 0));
    const auto less = [](const glm::dvec3& a, const glm::dvec3& b) {
        return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
    };
    std::vector<glm::dvec3> known = before.positions;
    std::sort(known.begin(), known.end(), less);
    for (const glm::dvec3& p : united.mesh.positions)
        report.new_vertices += std::binary_search(known.begin(), known.end(), p, less) ? 0 : 1;
}

// An arrangement of a mesh and, on request, its facets.
struct Divided {
    Divided(const TriangleMesh& mesh, const std::vector<uint8_t>& is_fresh, Threads& threads) : all(mesh) {
        find_contacts(all, is_fresh, threads);
    }

    void find_facets(Threads& threads) {
        divide_carriers(all);
        facets = arrangement::find_facets(all, divide_triangles(all, threads), threads);
    }

    Arrangement all;
    std::vector<Facet> facets;
};

// What a round begins with.
struct State {
    TriangleMesh mesh;
    std::vector<uint32_t> source;
    std::vector<uint8_t> is_fresh;
};

// What the rounds of one union made.
struct Rounds {
    State state;
    uint32_t count = 0;
    bool complete = false;
    bool has_negative = false; // a winding number before the first
    double inside_out = 0.0;   // m^3, before the first
};

// Unites the mesh of a state. Marks in `is_cut`, by triangle of the input, those that the first round divides.
Rounds run_rounds(State begin, uint32_t rounds, std::vector<uint8_t>& is_cut, Threads& threads) {
    Rounds done{.state = std::move(begin)};
    State& state = done.state;
    State best;
    size_t fewest_cuts = SIZE_MAX;
    double grid = std::ldexp(1.0, exponent_of(state.mesh) + first_grid);
    for (uint32_t round = 0; round < rounds; ++round) {
        std::optional<Divided> divided(std::in_place, state.mesh, state.is_fresh, threads);
        const size_t cuts = divided->all.cuts.size();
        // Rounding can also lay triangles onto each other, or turn a part inside out: no triangle is cut then.
        divided->find_facets(threads);
        done.complete = std::all_of(divided->facets.begin(), divided->facets.end(), is_clean);
        if (done.complete) break;
        if (round == 0) {
            done.inside_out = inside_out_volume(divided->all, divided->facets);
            done.has_negative = std::any_of(divided->facets.begin(), divided->facets.end(),
                                            [](const Facet& f) { return f.front < 0 || f.back() < 0; });
            for (const arrangement::Cut& cut : divided->all.cuts) is_cut[state.source[cut.triangle]] = 1;
        } else if (cuts < fewest_cuts) {
            best = state;
            fewest_cuts = cuts;
        }
        if (round >= exact_rounds) {
            state = best;
            snap(state.mesh, state.is_fresh, grid);
            grid *= coarser;
            divided.emplace(state.mesh, state.is_fresh, threads);
            divided->find_facets(threads);
        }
        Boundary boundary = boundary_of(divided->all, divided->facets);
        for (uint32_t& source : boundary.source) source = state.source[source];
        state = {std::move(boundary.mesh), std::move(boundary.source), std::move(boundary.is_fresh)};
        ++done.count;
    }
    if (!done.complete && !best.mesh.triangles.empty()) state = std::move(best);
    return done;
}

// Unites a mesh of many parts that meet each other: the parts of each half of them, then the two results. The walls
// inside a half are gone when it meets the other, so triangles are not divided by what other parts hide.
//
// A half stands for its parts only if no winding number in it is negative, so unite() takes the mesh as a whole where one
// is. Nor does it take a half in which triangles still cross after the rounds without a grid.
class Halves {
  public:
    Halves(const TriangleMesh& mesh, std::vector<uint8_t>& is_cut, Threads& threads)
        : mesh_(mesh), is_cut_(is_cut), threads_(threads) {}

    // Returns nothing where the mesh must be taken as a whole.
    [[nodiscard]] std::optional<Rounds> run(std::vector<MeshPart> parts) { return unite_parts(std::span(parts)); }

  private:
    [[nodiscard]] std::optional<Rounds> unite_parts(std::span<MeshPart> parts) {
        if (parts.size() <= max_parts_at_once) return finish(begin(parts), 0);
        const size_t half = arrangement::halve(parts);
        std::optional<Rounds> low = unite_parts(parts.first(half));
        if (!low) return std::nullopt;
        std::optional<Rounds> high = unite_parts(parts.subspan(half));
        if (!high) return std::nullopt;
        return finish(joined(std::move(low->state), std::move(high->state)), std::max(low->count, high->count));
    }

    [[nodiscard]] std::optional<Rounds> finish(State state, uint32_t rounds_before) {
        Rounds done = run_rounds(std::move(state), exact_rounds, is_cut_, threads_);
        if (!done.complete || done.has_negative) return std::nullopt;
        done.count = std::max(done.count, rounds_before);
        return done;
    }

    // The triangles of some parts, with vertices in the order of the mesh.
    [[nodiscard]] State begin(std::span<const MeshPart> parts) const {
        State state;
        for (const MeshPart& part : parts)
            state.source.insert(state.source.end(), part.triangles.begin(), part.triangles.end());
        std::sort(state.source.begin(), state.source.end());
        std::vector<uint32_t> used;
        for (const uint32_t t : state.source)
            for (int k = 0; k < 3; ++k) used.push_back(mesh_.triangles[t][k]);
        std::sort(used.begin(), used.end());
        used.erase(std::unique(used.begin(), used.end()), used.end());
        const auto index = [&](uint32_t v) {
            return static_cast<uint32_t>(std::lower_bound(used.begin(), used.end(), v) - used.begin());
        };
        for (const uint32_t v : used) state.mesh.positions.push_back(mesh_.positions[v]);
        for (const uint32_t t : state.source) {
            const Triangle& c = mesh_.triangles[t];
            state.mesh.triangles.push_back({index(c.x), index(c.y), index(c.z)});
        }
        state.is_fresh.assign(state.source.size(), 1);
        return state;
    }

    // Triangles within a half do not cross, so those of one half are fresh and the others are not.
    [[nodiscard]] static State joined(State a, State b) {
        if (a.mesh.triangles.size() < b.mesh.triangles.size()) std::swap(a, b);
        const auto first = static_cast<uint32_t>(a.mesh.positions.size());
        a.mesh.positions.insert(a.mesh.positions.end(), b.mesh.positions.begin(), b.mesh.positions.end());
        for (const Triangle& t : b.mesh.triangles) a.mesh.triangles.push_back(t + first);
        a.source.insert(a.source.end(), b.source.begin(), b.source.end());
        a.is_fresh.assign(a.is_fresh.size(), 0);
        a.is_fresh.resize(a.source.size(), 1);
        return a;
    }

    const TriangleMesh& mesh_;
    std::vector<uint8_t>& is_cut_;
    Threads& threads_;
};

// Brings triangles into the order of their sources, and vertices into that of the input, with the new ones behind them.
void put_in_order(const TriangleMesh& input, State& state) {
    std::vector<uint32_t> order(state.source.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [&](uint32_t a, uint32_t b) { return state.source[a] < state.source[b]; });
    std::vector<uint32_t> place(state.mesh.positions.size(), no_index); // by vertex: the vertex of the input there
    for (size_t t = 0; t < state.source.size(); ++t)
        for (int k = 0; k < 3; ++k)
            for (int m = 0; m < 3; ++m) {
                const uint32_t v = state.mesh.triangles[t][k], old = input.triangles[state.source[t]][m];
                if (state.mesh.positions[v] == input.positions[old]) place[v] = std::min(place[v], old);
            }
    std::vector<uint32_t> vertices(place.size()), index(place.size());
    std::iota(vertices.begin(), vertices.end(), 0u);
    std::stable_sort(vertices.begin(), vertices.end(), [&](uint32_t a, uint32_t b) { return place[a] < place[b]; });
    State sorted;
    for (const uint32_t v : vertices) {
        index[v] = static_cast<uint32_t>(sorted.mesh.positions.size());
        sorted.mesh.positions.push_back(state.mesh.positions[v]);
    }
    for (const uint32_t t : order) {
        const Triangle& c = state.mesh.triangles[t];
        sorted.mesh.triangles.push_back({index[c.x], index[c.y], index[c.z]});
        sorted.source.push_back(state.source[t]);
    }
    state = std::move(sorted);
}

std::optional<Rounds> unite_by_halves(const TriangleMesh& mesh, std::vector<uint8_t>& is_cut, Threads& threads) {
    std::optional<std::vector<MeshPart>> parts = arrangement::crowded_parts(mesh, max_neighbours);
    if (!parts) return std::nullopt;
    std::optional<Rounds> done = Halves(mesh, is_cut, threads).run(*std::move(parts));
    if (done && done->count > 0) put_in_order(mesh, done->state);
    return done;
}

State state_of(const TriangleMesh& mesh) {
    State state{mesh, std::vector<uint32_t>(mesh.triangles.size()), std::vector<uint8_t>(mesh.triangles.size(), 1)};
    std::iota(state.source.begin(), state.source.end(), 0u);
    return state;
}

United unite_in_rounds(const TriangleMesh& mesh, uint32_t rounds, uint32_t thread_count) {
    Threads threads(thread_count);
    std::vector<uint8_t> is_cut(mesh.triangles.size(), 0);
    std::optional<Rounds> done = unite_by_halves(mesh, is_cut, threads);
    if (!done) {
        std::fill(is_cut.begin(), is_cut.end(), uint8_t{0});
        done = run_rounds(state_of(mesh), rounds, is_cut, threads);
    }
    UniteReport report;
    report.volume_before = report.volume_after = signed_volume(mesh.positions, mesh.triangles);
    report.inside_out = done->inside_out;
    report.cut_triangles = static_cast<uint32_t>(std::count(is_cut.begin(), is_cut.end(), 1));
    report.rounds = done->count;
    report.complete = done->complete;
    if (!report.changed()) {
        done->state = state_of(mesh);
        return {std::move(done->state.mesh), std::move(done->state.source), report};
    }
    United united{std::move(done->state.mesh), std::move(done->state.source), report};
    united.report.volume_after = signed_volume(united.mesh.positions, united.mesh.triangles);
    count_changes(mesh, united, united.report);
    return united;
}

} // namespace

United unite(const TriangleMesh& mesh, uint32_t thread_count) {
    return unite_in_rounds(mesh, max_rounds, thread_count);
}

UniteReport measure_union(const TriangleMesh& mesh, uint32_t thread_count) {
    return unite_in_rounds(mesh, 1, thread_count).report;
}

std::string describe(const UniteReport& report) {
    if (!report.changed()) return {};
    char line[256];
    std::string text;
    std::snprintf(line, sizeof line,
                  "parts united: volume %.6g m^3, before %.6g m^3 counted as often as the surface winds around it\n",
                  report.volume_after, report.volume_before);
    text += line;
    std::snprintf(line, sizeof line, "%u triangles divided where they meet others, %u dropped, %u new vertices\n",
                  report.cut_triangles, report.dropped_triangles, report.new_vertices);
    text += line;
    if (report.inside_out > 1e-9 * std::abs(report.volume_before)) {
        std::snprintf(line, sizeof line, "%.6g m^3 that the surface encloses inside out dropped\n", report.inside_out);
        text += line;
    }
    if (!report.complete) text += "triangles still cross, because rounding moved new vertices: unite once more\n";
    return text;
}

} // namespace brittle::fracture

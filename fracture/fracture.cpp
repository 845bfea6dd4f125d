#include "fracture/fracture.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/exact/exact.h"
#include "fracture/exact/scene.h"
#include "fracture/exact/surface.h"
#include "fracture/mesh/half_edge.h"
#include "fracture/mesh/mass_properties.h"
#include "fracture/mesh/topology.h"
#include "fracture/pieces/certificate.h"
#include "fracture/pieces/merge.h"
#include "fracture/rough/rough.h"
#include "fracture/sequential/sequential.h"

namespace brittle::fracture {

struct Workspace::State {
    exact::Scratch exact;
    rough::RoughCut rough;
    // The sequential algorithm checks its input by the same means.
    exact::Scene scene;
    exact::Surface surface;
};

namespace {

// The largest permitted coordinate, m: the inertia tensor is of degree five and would overflow beyond it.
constexpr double max_coordinate = 1e50;

constexpr uint32_t max_threads = 1024;

// The relative volume, in units of the area times the diagonal of the box, that is zero up to rounding.
constexpr double min_volume = 1e-15;
// The relative volume, in units of the squared diagonal of the box times the diagonal or the largest coordinate, above
// which a solid needs no closer check. Most solids exceed it.
constexpr double ample_volume = 1e-6;

// The largest coordinate, by magnitude.
double extent_of(const Box& box) {
    const glm::dvec3 furthest = glm::max(glm::abs(box.min), glm::abs(box.max));
    return std::max({furthest.x, furthest.y, furthest.z});
}

bool in_range(const glm::dvec3& p) {
    // Comparisons with NaN are false.
    return std::abs(p.x) <= max_coordinate && std::abs(p.y) <= max_coordinate && std::abs(p.z) <= max_coordinate;
}

Result<void> check_coordinates(std::span<const glm::dvec3> points, Status status, const char* what) {
    for (size_t i = 0; i < points.size(); ++i) {
        const glm::dvec3& p = points[i];
        if (in_range(p)) continue;
        char text[192];
        std::snprintf(text, sizeof text, "%s %zu is at (%g, %g, %g); coordinates must be finite and at most 1e50", what,
                      i, p.x, p.y, p.z);
        return Error{status, text};
    }
    return {};
}

Error bad_min_volume(double value) {
    char text[96];
    std::snprintf(text, sizeof text, "the minimum volume is %g; it must be finite and not negative", value);
    return {Status::invalid_setting, text};
}

// Checks the settings and the coordinates. The topology of the mesh is checked later.
Result<void> check_values(const TriangleMesh& mesh, const Box& box, std::span<const glm::dvec3> sites,
                          const Settings& settings) {
    if (settings.threads > max_threads)
        return Error{Status::invalid_setting, "threads is " + std::to_string(settings.threads) + "; give at most "
                                                  + std::to_string(max_threads) + ", or 0 for one per core"};
    for (const std::vector<uint32_t>* groups : {&settings.groups, &settings.merged_later})
        if (!groups->empty() && groups->size() != sites.size())
            return Error{Status::invalid_setting, "there are " + std::to_string(groups->size()) + " groups for "
                                                      + std::to_string(sites.size())
                                                      + " sites; give one group per site, or none"};
    if (!settings.weights.empty() && settings.weights.size() != sites.size())
        return Error{Status::invalid_setting, "there are " + std::to_string(settings.weights.size()) + " weights for "
                                                  + std::to_string(sites.size())
                                                  + " sites; give one weight per site, or none"};
    for (size_t i = 0; i < settings.weights.size(); ++i)
        if (!std::isfinite(settings.weights[i]))
            return Error{Status::invalid_setting,
                         "site " + std::to_string(i) + " has a weight that is not finite; give a finite one"};
    if (!(settings.min_volume >= 0.0) || !std::isfinite(settings.min_volume))
        return bad_min_volume(settings.min_volume);
    if (Result<void> ok = rough::check(settings.rough); !ok) return ok;
    if (settings.algorithm != Algorithm::exact && !settings.rough.is_flat())
        return Error{Status::invalid_setting, "roughness needs the exact algorithm; choose it, or set roughness to 0"};
    if (settings.algorithm != Algorithm::exact && (!settings.groups.empty() || settings.min_volume > 0.0))
        return Error{Status::invalid_setting, "groups and a minimum volume need the exact algorithm; choose it, or "
                                              "leave both out"};
    // The box may miss a NaN; the check in scene.cpp finds it at a lower cost than a scan here.
    if (!in_range(box.min) || !in_range(box.max))
        return check_coordinates(mesh.positions, Status::invalid_mesh, "vertex");
    return check_coordinates(sites, Status::invalid_sites, "site");
}

Result<void> check_volume(const TriangleMesh& mesh, const Box& box) {
    const MassProperties mass = mass_properties(mesh.positions, mesh.triangles);
    if (std::abs(mass.volume) <= min_volume * mass.area * glm::length(box.size()))
        return Error{Status::no_volume, "the mesh encloses no volume; give a surface around a solid"};
    if (mass.volume > 0.0) return {};
    char text[128];
    std::snprintf(text, sizeof text, "the mesh is inside out: its volume is %g; reverse its triangles", mass.volume);
    return Error{Status::inside_out, text};
}

// Returns whether a face and its only neighbour are the two sides of one triangle. This component has no volume. It is
// the only closed one in which a cut can leave a loop of two edges.
bool is_two_sided(const HalfEdgeMesh& mesh, uint32_t face) {
    const uint32_t a = mesh.faces[face];
    const uint32_t b = mesh[a].next;
    const uint32_t c = mesh[b].next;
    const uint32_t across = mesh[mesh[a].twin].face;
    return mesh[mesh[b].twin].face == across && mesh[mesh[c].twin].face == across;
}

Result<HalfEdgeMesh> build_solid(const TriangleMesh& mesh) {
    Result<HalfEdgeMesh> built = build_half_edges(mesh.positions, mesh.triangles);
    if (!built) return built;

    std::vector<uint32_t> solid;
    for (uint32_t face = 0; face < built->faces.size(); ++face)
        if (!is_two_sided(*built, face)) solid.push_back(face);
    if (solid.size() == built->faces.size()) return built;
    HalfEdgeMesh without;
    for (const glm::dvec3& p : built->positions) add_vertex(without, p);
    for (const uint32_t face : solid)
        if (add_face(without, corners(*built, face), built->sources[face]) != AddFace::added)
            return Error{Status::non_manifold, "triangle " + std::to_string(face) + " is not manifold"};
    return without;
}

// Chooses the pieces to merge with their neighbours: those of one group, those below the minimum volume, and those
// without volume. Where a bisector runs along a face of the solid, symbolic perturbation may leave a sheet of zero
// thickness in the cell across. `small` as in MergeRules. Returns the representative of each piece; empty for no merger.
std::vector<uint32_t> choose_mergers(const Settings& settings, const Box& box, std::span<const uint8_t> small,
                                     const Fragments& fragments) {
    const std::vector<uint8_t> flat = flat_pieces(fragments, box);
    if (flat.empty() && small.empty() && settings.groups.empty() && settings.min_volume <= 0.0) return {};
    return choose_mergers(fragments, {settings.groups, settings.min_volume, flat, small});
}

// Merges the pieces with equal representatives, if there are any. `start` is when choosing them began.
void merge(std::span<const uint32_t> representative, std::chrono::steady_clock::time_point start,
           const Settings& settings, Fragments& fragments) {
    if (representative.empty()) return;
    Threads threads(settings.threads);
    threads.cancel_by(settings.cancelled);
    merge_pieces(fragments, representative, threads);
    const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - start;
    fragments.timings.push_back({"merge", elapsed.count()});
}

double volume_of(const Fragments& fragments) {
    double sum = 0.0;
    for (const Piece& piece : fragments.pieces) sum += piece.mass.volume;
    return sum;
}

// Checks that every piece has positive volume and that together they have the given volume, that of the mesh.
Result<void> check_pieces(const Fragments& fragments, double volume) {
    const double missing = volume - volume_of(fragments);
    if (std::abs(missing) > max_volume_error * std::abs(volume)) {
        char text[320];
        std::snprintf(text, sizeof text,
                      "the pieces miss %.2g of the volume, because parts of the mesh are as thin as the rounding of "
                      "their coordinates; move the mesh to the origin, thicken it or choose fewer sites",
                      std::abs(missing / volume));
        return Error{Status::lost_volume, text};
    }
    size_t inverted = 0;
    const Piece* first = nullptr;
    for (const Piece& piece : fragments.pieces) {
        if (piece.mass.volume > 0.0) continue;
        if (!first) first = &piece;
        ++inverted;
    }
    if (!first) return {};
    const glm::dvec3& at = first->mass.centre_of_mass;
    char text[384];
    std::snprintf(
        text, sizeof text,
        "the surface turns itself inside out near (%g, %g, %g): %zu of %zu pieces would have negative volume, "
        "there %g in the cell of site %u; turn parts that face inwards (--repair), or unite parts that "
        "pass through each other (--unite)",
        at.x, at.y, at.z, inverted, fragments.pieces.size(), first->mass.volume, first->site);
    return Error{Status::inverted_part, text};
}

// Returns whether the only fault is one that split_fans() repairs: several fans at a vertex.
bool only_touches(const TriangleMesh& mesh, const Error& error) {
    return error.status == Status::non_manifold && check_topology(mesh.positions.size(), mesh.triangles).closed();
}

// Replaces the vertex indices of the split mesh by those of the original mesh.
void restore_vertex_indices(const TriangleMesh& mesh, const TriangleMesh& split, Fragments& fragments) {
    std::vector<uint32_t> original(split.positions.size(), no_index);
    for (size_t t = 0; t < mesh.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) original[split.triangles[t][k]] = mesh.triangles[t][k];
    for (uint32_t& point : fragments.vertex_point)
        if (point < original.size()) point = original[point];
}

// Numbers the points by position, for the sequential algorithm, which has no other identity for them.
void number_points(std::span<const glm::dvec3> vertices, Fragments& fragments) {
    constexpr uint32_t first_cut_point = 1u << 30;
    const auto before = [](const glm::dvec3& a, const glm::dvec3& b) {
        return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
    };
    std::vector<std::pair<glm::dvec3, uint32_t>> places; // vertices first, then the others in the order of the pieces
    for (uint32_t v = 0; v < vertices.size(); ++v) places.push_back({vertices[v], v});
    for (const glm::dvec3& p : fragments.positions)
        places.push_back({p, first_cut_point + static_cast<uint32_t>(places.size() - vertices.size())});
    std::stable_sort(places.begin(), places.end(),
                     [&](const auto& a, const auto& b) { return before(a.first, b.first); });
    fragments.vertex_point.clear();
    for (const glm::dvec3& p : fragments.positions)
        fragments.vertex_point.push_back(
            std::lower_bound(places.begin(), places.end(), p, [&](const auto& place, const glm::dvec3& q) {
                return before(place.first, q);
            })->second);
}

// Cuts a rough solid: the mesh may be the input with its fans split.
Result<void> run_rough(const TriangleMesh& mesh, std::span<const glm::dvec3> sites, const Settings& settings,
                       Workspace::State& state, Fragments& out) {
    state.rough.start(mesh, sites, settings);
    return state.rough.run(
        mesh, sites, settings, state.exact,
        [&](const std::vector<uint8_t>& flakes) { return choose_mergers(settings, bounds(mesh), flakes, out); }, out);
}

Result<void> run_rough(const TriangleMesh& mesh, const Box& box, std::span<const glm::dvec3> sites,
                       const Settings& settings, Workspace::State& state, Fragments& out) {
    try {
        Result<void> done = run_rough(mesh, sites, settings, state, out);
        if (!done && only_touches(mesh, done.error())) {
            const TriangleMesh split = split_fans(mesh);
            done = run_rough(split, sites, settings, state, out);
            if (done) restore_vertex_indices(mesh, split, out);
        }
        if (!done) return done;
    } catch (const Threads::Cancelled&) {
        return Error{Status::cancelled, "the fracture was cancelled"};
    }
    if (Result<void> checked = check_volume(mesh, box); !checked) return checked;
    return check_pieces(out, signed_volume(mesh.positions, mesh.triangles));
}

Result<void> run_exact(const TriangleMesh& mesh, const Box& box, std::span<const glm::dvec3> sites,
                       const Settings& settings, Workspace::State& state, Fragments& out) {
    if (!settings.rough.is_flat()) return run_rough(mesh, box, sites, settings, state, out);
    Result<void> done = exact::fracture_exact(mesh, sites, settings, state.exact, out);
    if (!done && only_touches(mesh, done.error())) {
        const TriangleMesh split = split_fans(mesh);
        done = exact::fracture_exact(split, sites, settings, state.exact, out);
        if (done) restore_vertex_indices(mesh, split, out);
    }
    if (!done) return done;
    // The sum over the pieces gives the volume of the mesh, so it is integrated only in doubtful cases.
    double volume = volume_of(out);
    const double diagonal = glm::length(box.size());
    if (!(volume > ample_volume * diagonal * diagonal * std::max(diagonal, extent_of(box)))) {
        if (Result<void> checked = check_volume(mesh, box); !checked) return checked;
        volume = signed_volume(mesh.positions, mesh.triangles);
    }
    try {
        const auto start = std::chrono::steady_clock::now();
        merge(choose_mergers(settings, box, {}, out), start, settings, out);
    } catch (const Threads::Cancelled&) {
        return Error{Status::cancelled, "the fracture was cancelled"};
    }
    return check_pieces(out, volume);
}

Result<void> run_sequential(const TriangleMesh& mesh, const Box& box, std::span<const glm::dvec3> sites,
                            const Settings& settings, Workspace::State& state, Fragments& out) {
    const auto start = std::chrono::steady_clock::now();
    Threads threads(settings.threads);
    if (Result<void> ok = exact::scale_mesh(mesh, threads, state.scene); !ok) return ok;
    Result<void> sound = state.surface.inspect(mesh, threads);
    const bool touches = !sound && only_touches(mesh, sound.error());
    if (!sound && !touches) return sound;
    if (Result<void> ok = check_volume(mesh, box); !ok) return ok;
    const Result<HalfEdgeMesh> solid = build_solid(touches ? split_fans(mesh) : mesh);
    if (!solid) return solid.error();
    const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - start;

    Result<Fragments> fragments = fracture_sequential(*solid, sites, settings);
    if (!fragments) return fragments.error();
    out = *std::move(fragments);
    number_points(mesh.positions, out);
    out.timings.insert(out.timings.begin(), {"prepare", elapsed.count()});
    return check_pieces(out, signed_volume(mesh.positions, mesh.triangles));
}

} // namespace

Workspace::Workspace() : state_(std::make_unique<State>()) {}
Workspace::~Workspace() = default;
Workspace::Workspace(Workspace&&) noexcept = default;
Workspace& Workspace::operator=(Workspace&&) noexcept = default;

Result<void> fracture(const TriangleMesh& mesh, std::span<const glm::dvec3> sites, const Settings& settings,
                      Workspace& workspace, Fragments& out) {
    const Box box = bounds(mesh);
    if (Result<void> checked = check_values(mesh, box, sites, settings); !checked) return checked;
    out.crossings = 0;
    out.rough_triangles = 0;
    const auto run = settings.algorithm == Algorithm::exact ? run_exact : run_sequential;
    return run(mesh, box, sites, settings, workspace.state(), out);
}

Result<Fragments> fracture(const TriangleMesh& mesh, std::span<const glm::dvec3> sites, const Settings& settings) {
    Workspace workspace;
    Fragments fragments;
    if (Result<void> done = fracture(mesh, sites, settings, workspace, fragments); !done) return done.error();
    return fragments;
}

} // namespace brittle::fracture

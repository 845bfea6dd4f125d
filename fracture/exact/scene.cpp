#include "fracture/exact/scene.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <string>

#include <glm/common.hpp>

#include "fracture/base/simd.h"

namespace brittle::fracture::exact {

namespace {

// The margin of the box around the mesh, which must lie strictly inside, in units of the scaled mesh size. It decides
// nothing else; a close box keeps cells small.
constexpr double box_margin = 0x1.0p-3;
constexpr uint32_t min_vertices_per_chunk = 8192;

// Indices of half-edges and of vertices of all kinds fit 32 bits, and cutting adds to their number.
constexpr size_t max_triangles = size_t{1} << 28;
constexpr size_t max_vertices = size_t{1} << 28;
constexpr size_t max_sites = size_t{1} << 28;

bool in_range(const glm::dvec3& p) { // comparisons with NaN are false
    return std::abs(p.x) <= max_input_coordinate && std::abs(p.y) <= max_input_coordinate
           && std::abs(p.z) <= max_input_coordinate;
}

Error at(Status status, const char* what, size_t index, const glm::dvec3& p, const char* advice) {
    char text[320];
    std::snprintf(text, sizeof text, "%s %zu is at (%.9g, %.9g, %.9g); %s", what, index, p.x, p.y, p.z, advice);
    return {status, text};
}

Result<void> check_counts(const TriangleMesh& mesh) {
    if (mesh.triangles.empty()) return Error{Status::empty_mesh, "the mesh has no triangles"};
    if (mesh.positions.empty()) return Error{Status::invalid_mesh, "the mesh has triangles but no vertices"};
    const auto too_many = [](size_t count, const char* what, size_t most) {
        return Error{Status::invalid_mesh, "the mesh has " + std::to_string(count) + ' ' + what + "; at most "
                                               + std::to_string(most) + " can be cut"};
    };
    if (mesh.triangles.size() > max_triangles) return too_many(mesh.triangles.size(), "triangles", max_triangles);
    if (mesh.positions.size() > max_vertices) return too_many(mesh.positions.size(), "vertices", max_vertices);
    return {};
}

// Returns whether all coordinates are finite and in the range of the input.
BRITTLE_SIMD bool all_in_range(std::span<const glm::dvec3> points) {
    const double* const coordinates = &points[0].x;
    uint64_t outside = 0;
    for (size_t k = 0; k < 3 * points.size(); ++k) // comparisons with NaN are false
        outside += std::abs(coordinates[k]) <= max_input_coordinate ? uint64_t{0} : uint64_t{1};
    return outside == 0;
}

} // namespace

double unit_scale(double size) {
    if (!(size > 0.0) || !std::isfinite(size)) return 1.0;
    // The limit of 2^1000 keeps the factor and its inverse normal numbers, even for meshes of subnormal size.
    return std::ldexp(1.0, -std::clamp(std::ilogb(size), -1000, 1000));
}

Result<void> scale_sites(std::span<const glm::dvec3> sites, double to_scene, std::vector<glm::dvec3>& out) {
    if (sites.empty()) return Error{Status::invalid_sites, "there are no sites; give at least one"};
    if (sites.size() > max_sites) {
        return Error{Status::invalid_sites, "there are " + std::to_string(sites.size()) + " sites; at most "
                                                + std::to_string(max_sites) + " can cut"};
    }
    out.resize(sites.size());
    for (size_t i = 0; i < sites.size(); ++i) {
        if (!in_range(sites[i])) {
            return at(Status::invalid_sites, "site", i, sites[i], "coordinates must be finite and at most 1e100");
        }
        for (int k = 0; k < 3; ++k) {
            const double x = sites[i][k] * to_scene;
            if (!(std::abs(x) <= max_coordinate)) {
                return at(Status::invalid_sites, "site", i, sites[i],
                          "that is more than 1e30 mesh sizes away: move it closer or leave it out");
            }
            out[i][k] = snap(x);
        }
    }
    return {};
}

Result<void> scale_weights(std::span<const double> weights, double to_scene, std::vector<double>& out) {
    out.resize(weights.size());
    for (size_t i = 0; i < weights.size(); ++i) {
        const double w = weights[i] * to_scene * to_scene;
        if (!(std::abs(w) <= max_coordinate * max_coordinate)) {
            char text[160];
            std::snprintf(text, sizeof text,
                          "site %zu has the weight %.9g; it must be finite and below 1e60 mesh sizes squared", i,
                          weights[i]);
            return Error{Status::invalid_setting, text};
        }
        out[i] = snap(w);
    }
    return {};
}

Result<void> scale_mesh(const TriangleMesh& mesh, Threads& threads, Scene& scene) {
    if (auto ok = check_counts(mesh); !ok) return ok;
    const auto count = static_cast<uint32_t>(mesh.positions.size());
    const std::span<const glm::dvec3> positions = mesh.positions;
    std::vector<Box> boxes(threads.chunks(count, min_vertices_per_chunk));
    std::atomic<bool> sound = true;
    threads.for_chunks(count, min_vertices_per_chunk, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        boxes[chunk] = bounds(positions.subspan(begin, end - begin));
        if (!all_in_range(positions.subspan(begin, end - begin))) sound = false;
    });
    if (!sound) {
        for (size_t v = 0; v < count; ++v) {
            if (!in_range(positions[v]))
                return at(Status::invalid_mesh, "vertex", v, positions[v],
                          "coordinates must be finite and at most 1e100");
        }
    }
    Box all = boxes[0];
    for (const Box& box : boxes) all = {glm::min(all.min, box.min), glm::max(all.max, box.max)};

    const glm::dvec3 size = all.size();
    double largest = std::max({size.x, size.y, size.z});
    if (!(largest > 0.0)) {
        largest = std::max({std::abs(all.max.x), std::abs(all.max.y), std::abs(all.max.z)});
    }
    scene.to_scene = unit_scale(largest);
    scene.to_input = 1.0 / scene.to_scene;
    scene.positions.resize(count);
    threads.for_chunks(count, min_vertices_per_chunk, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t v = begin; v < end; ++v) {
            const glm::dvec3 p = mesh.positions[v] * scene.to_scene;
            scene.positions[v] = {snap(p.x), snap(p.y), snap(p.z)};
        }
    });
    // One unit in the last place of coordinates up to 2^52 is at most 1, so meshes far from the origin need a wider
    // margin.
    const glm::dvec3 low = all.min * scene.to_scene;
    const glm::dvec3 high = all.max * scene.to_scene;
    for (int k = 0; k < 3; ++k) {
        const double margin = box_margin + 0x1.0p-50 * std::max(std::abs(low[k]), std::abs(high[k]));
        scene.box.min[k] = low[k] - margin;
        scene.box.max[k] = high[k] + margin;
    }
    return {};
}

Result<void> make_scene(const TriangleMesh& mesh, std::span<const glm::dvec3> sites, std::span<const double> weights,
                        Threads& threads, Scene& scene) {
    if (auto ok = scale_mesh(mesh, threads, scene); !ok) return ok;
    if (auto ok = scale_weights(weights, scene.to_scene, scene.weights); !ok) return ok;
    return scale_sites(sites, scene.to_scene, scene.sites);
}

} // namespace brittle::fracture::exact

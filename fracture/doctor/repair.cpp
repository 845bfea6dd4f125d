#include "fracture/doctor/repair.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "fracture/arithmetic/plane_predicates.h"
#include "fracture/doctor/mending/spare_patches.h"
#include "fracture/doctor/mending/steps.h"
#include "fracture/mesh/topology.h"

namespace brittle::fracture {
namespace {

using mending::Work;

constexpr double max_coordinate = 1e50; // m, the limit of fracture()
constexpr uint32_t max_triangles = 1u << 30;
constexpr double weld_part = 1e-6; // of the diagonal; the default weld distance

// One round nearly always suffices, and a second finds no work. Tangled meshes can take more; the limit bounds the
// time.
constexpr int max_rounds = 16;

void check_input(const TriangleMesh& mesh, RepairReport& report) {
    report.too_large = mesh.triangles.size() > max_triangles || mesh.positions.size() > max_triangles;
    if (report.too_large) return;
    for (uint32_t v = 0; v < mesh.positions.size(); ++v)
        for (int k = 0; k < 3; ++k)
            if (!(std::abs(mesh.positions[v][k]) <= max_coordinate)) {
                report.bad_vertices.add(v);
                break;
            }
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const Triangle& c = mesh.triangles[t];
        if (std::max({c.x, c.y, c.z}) >= mesh.positions.size()) report.bad_triangles.add(t);
    }
}

bool is_flat(const TriangleMesh& mesh, const Triangle& t) {
    const glm::dvec3 &a = mesh.positions[t.x], &b = mesh.positions[t.y], &c = mesh.positions[t.z];
    return orientation(glm::dvec2(a.x, a.y), {b.x, b.y}, {c.x, c.y}) == 0.0
           && orientation(glm::dvec2(a.y, a.z), {b.y, b.z}, {c.y, c.z}) == 0.0
           && orientation(glm::dvec2(a.z, a.x), {b.z, b.x}, {c.z, c.x}) == 0.0;
}

bool round(Work& work, const RepairSettings& settings, double weld_distance) {
    if (check_topology(work.mesh.positions.size(), work.mesh.triangles).manifold()) {
        const bool dropped = mending::drop_duplicates(work); // a triangle with its back is a manifold too
        const bool turned = mending::turn_parts(work, settings.cavities);
        return (settings.covered_parts && mending::drop_covered(work)) || turned || dropped;
    }
    bool changed = mending::weld_rims(work, weld_distance);
    changed = mending::drop_degenerate(work) || changed;
    changed = mending::drop_duplicates(work) || changed;
    // A patch with the wrong orientation as a whole can be told from the right one by its surroundings, once these
    // agree: spare patches are removed again after neighbours have been oriented.
    if (settings.spare_patches) changed = mending::drop_spare_patches(work) || changed;
    if (mending::orient_neighbours(work)) {
        changed = true;
        if (settings.spare_patches) mending::drop_spare_patches(work);
    }
    changed = mending::close_holes(work, settings) || changed;
    // separate() needs to know which side of each triangle is solid, so parts are turned before. Afterwards each
    // separated part may need another orientation.
    changed = mending::turn_parts(work, settings.cavities) || changed;
    if (mending::separate(work)) {
        changed = true;
        mending::turn_parts(work, settings.cavities);
    }
    return changed;
}

// Counts the flaws that remain.
void count_rest(const Work& work, RepairReport& report) {
    for (uint32_t t = 0; t < work.turned.size(); ++t)
        if (work.turned[t] && work.source[t] != no_index) report.turned_triangles.add(work.source[t]);
    const TopologyReport topology = check_topology(work.mesh.positions.size(), work.mesh.triangles);
    if (topology.non_manifold_edges > 0)
        report.crowded_edges.add(work.origin[topology.first_non_manifold_edge->x], topology.non_manifold_edges);
    if (topology.misoriented_edges > 0)
        report.misoriented_edges.add(work.origin[topology.first_misoriented_edge->x], topology.misoriented_edges);
    for (uint32_t t = 0; t < work.mesh.triangles.size(); ++t)
        if (work.source[t] != no_index && is_flat(work.mesh, work.mesh.triangles[t]))
            report.flat_triangles.add(work.source[t]);
}

std::string count(uint64_t number, const char* one, const char* many) {
    return std::to_string(number) + " " + (number == 1 ? one : many);
}

} // namespace

Repaired repair(const TriangleMesh& mesh, const RepairSettings& settings) {
    Work work(mesh);
    check_input(mesh, work.report);
    if (!work.report.too_large && work.report.bad_triangles.count + work.report.bad_vertices.count == 0) {
        const Box box = bounds(mesh);
        const double distance =
            settings.weld_distance >= 0.0 ? settings.weld_distance : weld_part * glm::length(box.size());
        for (int k = 0; k < max_rounds && round(work, settings, distance); ++k) {
        }
        count_rest(work, work.report);
    }
    return {std::move(work.mesh), std::move(work.source), work.report};
}

bool RepairReport::changed() const {
    return welded_vertices.count + degenerate_triangles.count + duplicate_triangles.count + spare_triangles.count
               + loose_triangles.count + covered_parts.count + turned_triangles.count + split_vertices.count
               + halved_edges.count + closed_holes.count
           > 0;
}

std::string describe(const RepairReport& report) {
    if (report.too_large) return "not repaired: more than 2^30 triangles or vertices\n";
    std::string text;
    const auto line = [&](const RepairReport::Change& change, const char* one, const char* many, const char* where) {
        if (change.count == 0) return;
        text += count(change.count, one, many);
        if (change.first != no_index) text += std::string(", the first ") + where + " " + std::to_string(change.first);
        text += '\n';
    };
    line(report.bad_triangles, "triangle names a vertex that does not exist: not repaired",
         "triangles name vertices that do not exist: not repaired", "is triangle");
    line(report.bad_vertices, "vertex is not finite or beyond 1e50 m: not repaired",
         "vertices are not finite or beyond 1e50 m: not repaired", "is vertex");
    line(report.welded_vertices, "vertex welded to another", "vertices welded to others", "is vertex");
    line(report.degenerate_triangles, "triangle that named a vertex twice dropped",
         "triangles that named a vertex twice dropped", "is triangle");
    line(report.duplicate_triangles, "duplicate triangle dropped", "duplicate triangles dropped", "is triangle");
    line(report.spare_triangles, "triangle that covered another dropped", "triangles that covered others dropped",
         "is triangle");
    line(report.loose_triangles, "loose triangle dropped", "loose triangles dropped", "is triangle");
    line(report.covered_parts, "part inside another dropped", "parts inside others dropped", "begins with triangle");
    line(report.turned_triangles, "triangle turned", "triangles turned", "is triangle");
    if (report.closed_holes.count > 0)
        text += count(report.closed_holes.count, "hole", "holes") + " closed with "
                + count(report.new_triangles, "triangle", "triangles") + ", the first at vertex "
                + std::to_string(report.closed_holes.first) + '\n';
    line(report.new_vertices, "vertex added in a hole", "vertices added in holes", "next to vertex");
    if (report.crossing_fills.count > 0)
        text += count(report.crossing_fills.count, "hole", "holes") + " closed across the surface, where "
                + count(report.fill_crossings, "pair", "pairs")
                + " of triangles pass through each other, the first at vertex "
                + std::to_string(report.crossing_fills.first) + ": --unite makes one solid of them\n";
    line(report.cut_edges, "edge of a one-sided surface cut", "edges of one-sided surfaces cut", "at vertex");
    line(report.split_edges, "edge of more than two triangles split", "edges of more than two triangles split",
         "at vertex");
    line(report.halved_edges, "edge halved, because another has the same ends",
         "edges halved, because others have the same ends", "at vertex");
    line(report.split_vertices, "vertex added where parts only touched", "vertices added where parts only touched",
         "a copy of vertex");
    line(report.open_rims, "hole left open: too long", "holes left open: too long", "at vertex");
    line(report.long_rims, "hole left open: more than 4096 edges and not simple in projection",
         "holes left open: more than 4096 edges and not simple in projection", "at vertex");
    line(report.misoriented_edges, "edge left with triangles that face opposite ways",
         "edges left with triangles that face opposite ways", "at vertex");
    line(report.crowded_edges, "edge left with more than two triangles", "edges left with more than two triangles",
         "at vertex");
    line(report.flat_triangles, "triangle without area left: the surface would be open without it",
         "triangles without area left: the surface would be open without them", "is triangle");
    return text;
}

Repair remove_spare_patches(const TriangleMesh& mesh) {
    const mending::SparePatches spare = mending::find_spare_patches(mesh);
    Repair repair{{mesh.positions, {}}, spare.triangles, spare.patches};
    for (size_t t = 0; t < mesh.triangles.size(); ++t)
        if (!spare.is_spare[t]) repair.mesh.triangles.push_back(mesh.triangles[t]);
    return repair;
}

} // namespace brittle::fracture

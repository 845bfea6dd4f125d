#include "fracture/repair.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "fracture/mending/spare_patches.h"
#include "fracture/mending/steps.h"

namespace brittle::fracture {
namespace {

using mending::Work;

constexpr double largest_coordinate = 1e50; // m, as fracture() asks
constexpr uint32_t most_triangles = 1u << 30;
constexpr double weld_part = 1e-6; // of the diagonal, where no distance is given

// One round nearly always does, and a second finds nothing left. Tangles can take more; none may take forever.
constexpr int most_rounds = 16;

void check_input(const TriangleMesh& mesh, RepairReport& report) {
    report.too_large = mesh.triangles.size() > most_triangles || mesh.positions.size() > most_triangles;
    if (report.too_large) return;
    for (uint32_t v = 0; v < mesh.positions.size(); ++v)
        for (int k = 0; k < 3; ++k)
            if (!(std::abs(mesh.positions[v][k]) <= largest_coordinate)) {
                report.bad_vertices.add(v);
                break;
            }
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const Triangle& c = mesh.triangles[t];
        if (std::max({c.x, c.y, c.z}) >= mesh.positions.size()) report.bad_triangles.add(t);
    }
}

bool round(Work& work, const RepairSettings& settings, double weld_distance) {
    bool changed = mending::weld_rims(work, weld_distance);
    changed = mending::drop_degenerate(work) || changed;
    changed = mending::drop_duplicates(work) || changed;
    if (settings.spare_patches) changed = mending::drop_spare_patches(work) || changed;
    return changed;
}

} // namespace

Repaired repair(const TriangleMesh& mesh, const RepairSettings& settings) {
    Work work(mesh);
    check_input(mesh, work.report);
    if (!work.report.too_large && work.report.bad_triangles.count + work.report.bad_vertices.count == 0) {
        const Box box = bounds(mesh);
        const double distance =
            settings.weld_distance >= 0.0 ? settings.weld_distance : weld_part * glm::length(box.size());
        for (int k = 0; k < most_rounds && round(work, settings, distance); ++k) {}
    }
    return {std::move(work.mesh), std::move(work.source), work.report};
}

Repair remove_spare_patches(const TriangleMesh& mesh) {
    const mending::SparePatches spare = mending::find_spare_patches(mesh);
    Repair repair{{mesh.positions, {}}, spare.triangles, spare.patches};
    for (size_t t = 0; t < mesh.triangles.size(); ++t)
        if (!spare.is_spare[t]) repair.mesh.triangles.push_back(mesh.triangles[t]);
    return repair;
}

} // namespace brittle::fracture

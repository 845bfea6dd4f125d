#include "fracture/sequential/sequential.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <utility>
#include <vector>

#include <glm/common.hpp>

#include "fracture/base/threads.h"
#include "fracture/mesh/islands.h"
#include "fracture/sequential/clip.h"

namespace brittle::fracture {

namespace {

// The result of one cell: written from any thread, read in the order of the sites.
struct Cell {
    CellBounds bounds;
    HalfEdgeMesh mesh;
    std::vector<Island> islands;
};

// Counts the finished steps, reports progress and polls for cancellation, in one thread at a time.
class Progress {
  public:
    Progress(const Settings& settings, size_t steps) : settings_(settings), steps_(steps) {}

    void step() {
        if (!settings_.progress && !settings_.cancelled) return;
        const std::scoped_lock lock(mutex_);
        if (settings_.progress) settings_.progress(static_cast<double>(++done_) / static_cast<double>(steps_));
        if (settings_.cancelled && settings_.cancelled()) cancelled_ = true;
    }
    [[nodiscard]] bool cancelled() const { return cancelled_; }

  private:
    const Settings& settings_;
    size_t steps_;
    size_t done_ = 0;
    std::atomic<bool> cancelled_ = false;
    std::mutex mutex_;
};

Box bounds_of(std::span<const glm::dvec3> positions) {
    Box box{positions.front(), positions.front()};
    for (const glm::dvec3& p : positions) {
        box.min = glm::min(box.min, p);
        box.max = glm::max(box.max, p);
    }
    return box;
}

void append(Fragments& fragments, uint32_t site, const Island& island) {
    Piece piece;
    piece.site = site;
    piece.mass = island.mass;
    piece.exterior_triangles = island.exterior_triangles;
    piece.vertices.begin = static_cast<uint32_t>(fragments.positions.size());
    piece.triangles.begin = static_cast<uint32_t>(fragments.triangles.size());
    fragments.positions.insert(fragments.positions.end(), island.positions.begin(), island.positions.end());
    fragments.triangles.insert(fragments.triangles.end(), island.triangles.begin(), island.triangles.end());
    for (const FaceSource& source : island.sources) fragments.triangle_source.push_back(source.index);
    piece.vertices.end = static_cast<uint32_t>(fragments.positions.size());
    piece.triangles.end = static_cast<uint32_t>(fragments.triangles.size());
    fragments.pieces.push_back(piece);
}

} // namespace

HalfEdgeMesh cut_cell(const HalfEdgeMesh& mesh, std::span<const Bisector> bisectors, uint32_t site) {
    if (bisectors.empty()) return mesh;
    HalfEdgeMesh cell = clip(mesh, bisectors.front(), site);
    for (const Bisector& plane : bisectors.subspan(1)) {
        if (cell.faces.empty()) break;
        cell = clip(cell, plane, site);
    }
    return cell;
}

Result<Fragments> fracture_sequential(const HalfEdgeMesh& mesh, std::span<const glm::dvec3> sites,
                                      const Settings& settings) {
    Fragments fragments;
    if (mesh.faces.empty()) return fragments;
    const Box box = bounds_of(mesh.positions);
    const glm::dvec3 furthest = glm::max(glm::abs(box.min), glm::abs(box.max));
    const double extent = std::max({furthest.x, furthest.y, furthest.z});
    std::vector<Cell> cells(sites.size());
    Progress progress(settings, 3 * sites.size());
    Threads threads(settings.threads);

    const auto timed = [&](const char* phase, const auto& work) {
        const auto start = std::chrono::steady_clock::now();
        work();
        const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - start;
        fragments.timings.push_back({phase, elapsed.count()});
    };
    const auto for_each_cell = [&](const auto& work) {
        threads.for_chunks(static_cast<uint32_t>(sites.size()), 1, [&](uint32_t, uint32_t begin, uint32_t end) {
            for (uint32_t site = begin; site < end && !progress.cancelled(); ++site) {
                work(site, cells[site]);
                progress.step();
            }
        });
    };

    timed("cells", [&] {
        for_each_cell(
            [&](uint32_t site, Cell& cell) { cell.bounds = cell_bounds(sites, site, box, settings.weights); });
    });
    timed("clip", [&] {
        for_each_cell([&](uint32_t site, Cell& cell) {
            if (!cell.bounds.empty) cell.mesh = cut_cell(mesh, cell.bounds.bisectors, site);
        });
    });
    timed("islands", [&] {
        for_each_cell([&](uint32_t, Cell& cell) {
            cell.islands = split_islands(cell.mesh.positions, triangle_list(cell.mesh), cell.mesh.sources, extent);
            cell.mesh = {};
        });
    });
    if (progress.cancelled()) return Error{Status::cancelled, "the fracture was cancelled"};
    timed("assemble", [&] {
        for (uint32_t site = 0; site < cells.size(); ++site)
            for (const Island& island : cells[site].islands) append(fragments, site, island);
    });
    return fragments;
}

} // namespace brittle::fracture

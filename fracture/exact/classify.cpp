#include "fracture/exact/classify.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace brittle::fracture::exact {

namespace {

constexpr uint32_t min_vertices_per_chunk = 8192;

// So many points fit the cache of a core while they are sorted.
constexpr size_t max_points_per_grid = 1 << 15;

// What a search reads.
struct Cells {
    const Diagram& problem;
    const VoronoiDiagram& diagram;
    const Frames& frames;
    const SiteTree& tree;
};

// The neighbour that is nearer to q than c by the largest margin, decided exactly; none where c is nearest.
SiteId nearer_neighbour(const Cells& cells, const glm::dvec3& q, SiteId c, PredicateStats& stats) {
    const Frames& frames = cells.frames;
    const Frames::Cell& cell = frames.cells[c];
    const glm::dvec3 y = q - cell.site;
    SiteId nearer = VoronoiDiagram::none;
    double least = 0.0;
    for (Frames::Slot l = cell.begin; l < cell.end; ++l) {
        const double g = frames.value_at(l, y);
        int side = side1_filter(g, cell.error);
        if (side > 0) continue;
        if (side == 0) side = side1_exact(cells.problem, c, frames.site[l], q, stats);
        if (side < 0 && (nearer == VoronoiDiagram::none || g < least)) {
            nearer = frames.site[l];
            least = g;
        }
    }
    return nearer;
}

// Returns the cell of q, a vertex of the mesh. The search starts in cell c. Where it comes to a cell that was not built,
// because it lies outside the solid, it goes on from the nearest site.
SiteId locate(const Cells& cells, const glm::dvec3& q, SiteId c, PredicateStats& stats) {
    const Frames& frames = cells.frames;
    for (;;) {
        if (cells.diagram.cell_is_empty[c]) {
            c = VoronoiDiagram::none;
            cells.tree.visit_nearest(q, [&](SiteId site) {
                if (c == VoronoiDiagram::none || side1_exact(cells.problem, c, site, q, stats) < 0) c = site;
            });
            assert(!cells.diagram.cell_is_empty[c]);
        }
        const Frames::Cell& cell = frames.cells[c];
        if (cell.begin == cell.end) return c;
        const glm::dvec3 y = q - cell.site;
        const uint32_t n = Frames::padded(cell.end - cell.begin);
        const MinDistance least = min_distance_at(frames, cell.begin, n, static_cast<float>(y.x),
                                                  static_cast<float>(y.y), static_cast<float>(y.z));
        if (least.distance > cell.float_error) return c;
        if (least.distance < -cell.float_error) {
            c = frames.site[least.slot];
            continue;
        }
        const SiteId nearer = nearer_neighbour(cells, q, c, stats);
        if (nearer == VoronoiDiagram::none) return c;
        c = nearer;
    }
}

// Points sorted by the bins of a grid.
class Bins {
  public:
    void sort(std::span<const glm::dvec3> points) {
        const double bins = std::max(1.0, std::round(std::cbrt(static_cast<double>(points.size()) / points_per_bin)));
        const Box box = bounds(points);
        const glm::dvec3 size = glm::max(box.size(), glm::dvec3(min_size));
        low_ = box.min;
        bins_ = static_cast<uint32_t>(bins);
        per_bin_ = bins / size;
        const glm::dvec3 furthest = glm::max(glm::abs(box.min), glm::abs(box.max));
        radius_ = radius_slack * 0.5 * glm::length(size) / bins
                  + position_slack * std::max({furthest.x, furthest.y, furthest.z});
        bin_of_.resize(points.size());
        begin_.assign(size_t{bins_} * bins_ * bins_ + 2, 0);
        for (size_t k = 0; k < points.size(); ++k) {
            bin_of_[k] = find(points[k]);
            ++begin_[bin_of_[k] + 2];
        }
        for (size_t bin = 2; bin < begin_.size(); ++bin) begin_[bin] += begin_[bin - 1];
        order_.resize(points.size());
        for (uint32_t k = 0; k < points.size(); ++k) order_[begin_[bin_of_[k] + 1]++] = k;
    }

    [[nodiscard]] uint32_t count() const { return static_cast<uint32_t>(begin_.size()) - 2; }
    [[nodiscard]] std::span<const uint32_t> points_of(uint32_t bin) const {
        return std::span(order_).subspan(begin_[bin], begin_[bin + 1] - begin_[bin]);
    }
    [[nodiscard]] glm::dvec3 centre(uint32_t bin) const {
        const glm::uvec3 place(bin / (bins_ * bins_), bin / bins_ % bins_, bin % bins_);
        return low_ + (glm::dvec3(place) + 0.5) / per_bin_;
    }
    // Of a ball around a bin.
    [[nodiscard]] double radius() const { return radius_; }

  private:
    [[nodiscard]] uint32_t find(const glm::dvec3& q) const {
        const glm::uvec3 place = glm::min(glm::uvec3((q - low_) * per_bin_), bins_ - 1);
        return (place.x * bins_ + place.y) * bins_ + place.z;
    }

    // Most bins lie far from the surface and stay empty.
    static constexpr double points_per_bin = 6.0;
    // The extent of a flat grid, in units of the scaled mesh size.
    static constexpr double min_size = 1e-6;
    // Cover the rounding of the bounds and of the centre of a bin: a factor on half of its diagonal, and a share of the
    // largest coordinate.
    static constexpr double radius_slack = 1.0 + 1e-6;
    static constexpr double position_slack = 0x1.0p-50;

    glm::dvec3 low_;
    glm::dvec3 per_bin_{0.0};
    double radius_ = 0.0;
    uint32_t bins_ = 1;
    std::vector<uint32_t> bin_of_, begin_, order_;
};

// The cells that meet one bin, as far as its points have shown. A point is tested against those planes of a cell that
// may meet the bin: none where the bin lies in one cell, else mostly one or two.
class CellsOfBin {
  public:
    CellsOfBin(const Cells& cells, SiteId anywhere, PredicateStats& stats)
        : cells_(cells), stats_(stats), last_(anywhere) {}

    // `point` lies in the bin.
    void start(const glm::dvec3& centre, double radius, const glm::dvec3& point) {
        centre_ = centre;
        radius_ = radius;
        regions_.clear();
        planes_.clear();
        last_ = locate(cells_, point, last_, stats_);
        add_region(last_);
    }

    // The cell that contains the whole bin; none where there may be several.
    [[nodiscard]] SiteId whole() const { return planes_.empty() ? regions_[0].cell : VoronoiDiagram::none; }

    [[nodiscard]] SiteId cell_at(const glm::dvec3& q) {
        for (const Region& region : regions_)
            if (is_inside(region, q)) return region.cell;
        last_ = locate(cells_, q, last_, stats_);
        const auto is_last = [&](const Region& region) { return region.cell == last_; };
        if (regions_.size() < max_regions && std::none_of(regions_.begin(), regions_.end(), is_last)) add_region(last_);
        return last_;
    }

  private:
    struct Plane {
        float x, y, z, h;
    };
    // The part of the bin that lies in one cell.
    struct Region {
        glm::dvec3 site;
        float error; // bound for the distances
        SiteId cell;
        uint32_t planes_begin, planes_end; // the planes of the cell that may meet the bin
    };

    [[nodiscard]] static float distance(const Plane& plane, const glm::vec3& y) {
        return plane.h - (plane.x * y.x + plane.y * y.y + plane.z * y.z);
    }

    [[nodiscard]] bool is_inside(const Region& region, const glm::dvec3& q) const {
        const glm::vec3 y(q - region.site);
        for (uint32_t k = region.planes_begin; k < region.planes_end; ++k)
            if (!(distance(planes_[k], y) > region.error)) return false;
        return true;
    }

    void add_region(SiteId c) {
        const Frames::Cell& cell = cells_.frames.cells[c];
        const glm::vec3 y(centre_ - cell.site);
        const auto begin = static_cast<uint32_t>(planes_.size());
        for (Frames::Slot l = cell.begin; l < cell.end; ++l) {
            const Plane plane{cells_.frames.fx[l], cells_.frames.fy[l], cells_.frames.fz[l], cells_.frames.fh[l]};
            if (static_cast<double>(distance(plane, y)) - static_cast<double>(cell.float_error) > radius_) continue;
            planes_.push_back(plane);
        }
        regions_.push_back({cell.site, cell.float_error, c, begin, static_cast<uint32_t>(planes_.size())});
    }

    // With more cells in a bin, a search costs less than the tests.
    static constexpr size_t max_regions = 8;

    const Cells& cells_;
    PredicateStats& stats_;
    SiteId last_; // where the next search starts
    glm::dvec3 centre_{0.0};
    double radius_ = 0.0;
    std::vector<Region> regions_;
    std::vector<Plane> planes_;
};

void classify_by_bins(const Cells& cells, std::span<const glm::dvec3> points, SiteId anywhere, const Threads& threads,
                      std::span<SiteId> cell_of, PredicateStats& stats) {
    Bins bins;
    CellsOfBin near(cells, anywhere, stats);
    for (size_t begin = 0; begin < points.size(); begin += max_points_per_grid) {
        const size_t count = std::min(max_points_per_grid, points.size() - begin);
        const auto sorted = points.subspan(begin, count);
        const auto cell_of_sorted = cell_of.subspan(begin, count);
        bins.sort(sorted);
        for (uint32_t bin = 0; bin < bins.count(); ++bin) {
            threads.poll(bin);
            const std::span<const uint32_t> inside = bins.points_of(bin);
            if (inside.empty()) continue;
            near.start(bins.centre(bin), bins.radius(), sorted[inside.front()]);
            const SiteId whole = near.whole();
            for (const uint32_t k : inside)
                cell_of_sorted[k] = whole != VoronoiDiagram::none ? whole : near.cell_at(sorted[k]);
        }
    }
}

// Decides the vertices that a classifier has marked uncertain.
void correct(const Cells& cells, std::span<const glm::dvec3> points, SiteId anywhere, const Threads& threads,
             std::span<SiteId> cell_of, PredicateStats& stats) {
    for (uint32_t k = 0; k < points.size(); ++k) {
        threads.poll(k);
        if ((cell_of[k] & Classifier::uncertain) == 0) continue;
        const SiteId guess = cell_of[k] & ~Classifier::uncertain;
        cell_of[k] = locate(cells, points[k], guess < cells.problem.sites.size() ? guess : anywhere, stats);
    }
}

} // namespace

void classify(const Diagram& problem, const VoronoiDiagram& diagram, const Frames& frames, const SiteTree& tree,
              std::span<const glm::dvec3> positions, bool guessed, Threads& threads, std::vector<SiteId>& cell_of,
              PredicateStats& stats) {
    const auto count = static_cast<uint32_t>(positions.size());
    cell_of.resize(count);
    const auto any = std::find(diagram.cell_is_empty.begin(), diagram.cell_is_empty.end(), uint8_t{0});
    assert(any != diagram.cell_is_empty.end());
    const auto anywhere = static_cast<SiteId>(any - diagram.cell_is_empty.begin());
    const Cells cells{problem, diagram, frames, tree};
    std::vector<PredicateStats> part(threads.chunks(count, min_vertices_per_chunk));
    threads.for_chunks(count, min_vertices_per_chunk, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        const auto points = positions.subspan(begin, end - begin);
        const auto cell_of_points = std::span(cell_of).subspan(begin, end - begin);
        if (guessed)
            correct(cells, points, anywhere, threads, cell_of_points, part[chunk]);
        else
            classify_by_bins(cells, points, anywhere, threads, cell_of_points, part[chunk]);
    });
    for (const PredicateStats& p : part) stats += p;
}

} // namespace brittle::fracture::exact

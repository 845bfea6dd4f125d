#include "fracture/exact/classify.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace brittle::fracture::exact {

namespace {

constexpr uint32_t min_vertices_per_chunk = 2048;

// The factor on the radius of a ball that covers its rounding, that of the step to the next vertex, and of their
// squares.
constexpr double ball_slack = 1.0 - 1e-12;

// The neighbour that is nearer to q than c by the largest margin, decided exactly; none where c is nearest.
SiteId nearer_neighbour(const Diagram& problem, const Frames& frames, const glm::dvec3& q, SiteId c,
                        PredicateStats& stats) {
    const Frames::Cell& cell = frames.cells[c];
    const glm::dvec3 y = q - cell.site;
    SiteId nearer = VoronoiDiagram::none;
    double least = 0.0;
    for (Frames::Slot l = cell.begin; l < cell.end; ++l) {
        const double g = frames.value_at(l, y);
        int side = side1_filter(g, cell.error);
        if (side > 0) continue;
        if (side == 0) side = side1_exact(problem, c, frames.site[l], q, stats);
        if (side < 0 && (nearer == VoronoiDiagram::none || g < least)) {
            nearer = frames.site[l];
            least = g;
        }
    }
    return nearer;
}

// Caches in a grid of bins the balls of the points classified before, as starting points.
class Hints {
  public:
    Hints(const Box& box, uint32_t points, SiteId anywhere) : low_(box.min) {
        const double bins = std::clamp(std::round(std::cbrt(points / points_per_bin)), 1.0, max_bins_per_axis);
        bins_ = static_cast<uint32_t>(bins);
        per_bin_ = bins / box.size();
        balls_.assign(size_t{bins_} * bins_ * bins_, KnownBall{VoronoiDiagram::none});
        last_.cell = anywhere;
    }

    // The ball to start from for q. The caller replaces it by the ball that it finds.
    [[nodiscard]] KnownBall& at(const glm::dvec3& q) {
        uint32_t bin = 0;
        for (int k = 0; k < 3; ++k) {
            const auto b = static_cast<uint32_t>(std::max(0.0, (q[k] - low_[k]) * per_bin_[k]));
            bin = bin * bins_ + std::min(b, bins_ - 1);
        }
        KnownBall& ball = balls_[bin];
        if (ball.cell == VoronoiDiagram::none) ball.cell = last_.cell;
        return ball;
    }
    void keep_last(const KnownBall& ball) { last_.cell = ball.cell; }

  private:
    // Most bins lie far from the surface and stay empty.
    static constexpr double points_per_bin = 2.0;
    static constexpr double max_bins_per_axis = 16.0;

    glm::dvec3 low_;
    glm::dvec3 per_bin_{0.0};
    uint32_t bins_ = 1;
    KnownBall last_{0};
    std::vector<KnownBall> balls_;
};

} // namespace

KnownBall locate(const Diagram& problem, const Frames& frames, const glm::dvec3& q, const KnownBall& from,
                 PredicateStats& stats) {
    SiteId c = from.cell;
    for (;;) {
        const Frames::Cell& cell = frames.cells[c];
        if (cell.begin == cell.end) return {c, q, 0.0};
        const glm::dvec3 y = q - cell.site;
        const uint32_t n = Frames::padded(cell.end - cell.begin);
        const MinDistance least = min_distance_at(frames, cell.begin, n, static_cast<float>(y.x),
                                                  static_cast<float>(y.y), static_cast<float>(y.z));
        if (least.distance > cell.float_error) {
            return {c, q, ball_slack * (static_cast<double>(least.distance) - static_cast<double>(cell.float_error))};
        }
        if (least.distance < -cell.float_error) {
            c = frames.site[least.slot];
            continue;
        }
        const SiteId nearer = nearer_neighbour(problem, frames, q, c, stats);
        if (nearer == VoronoiDiagram::none) return {c, q, 0.0};
        c = nearer;
    }
}

void classify(const Diagram& problem, const VoronoiDiagram& diagram, const Frames& frames,
              std::span<const glm::dvec3> positions, bool guessed, Threads& threads, std::vector<SiteId>& cell_of,
              PredicateStats& stats) {
    const auto count = static_cast<uint32_t>(positions.size());
    cell_of.resize(count);
    const auto any = std::find(diagram.cell_is_empty.begin(), diagram.cell_is_empty.end(), uint8_t{0});
    assert(any != diagram.cell_is_empty.end());
    const auto anywhere = static_cast<SiteId>(any - diagram.cell_is_empty.begin());
    std::vector<PredicateStats> part(threads.chunks(count, min_vertices_per_chunk));
    threads.for_chunks(count, min_vertices_per_chunk, [&](uint32_t chunk, uint32_t begin, uint32_t end) {
        Hints hints(problem.box, end - begin, anywhere);
        for (uint32_t v = begin; v < end; ++v) {
            threads.poll(v);
            KnownBall& ball = hints.at(positions[v]);
            if (guessed) {
                if ((cell_of[v] & Classifier::uncertain) == 0) continue;
                const SiteId start = cell_of[v] & ~Classifier::uncertain;
                if (start < problem.sites.size() && !diagram.cell_is_empty[start]) ball = {start};
            }
            const glm::dvec3 step = positions[v] - ball.centre;
            const double step2 = step.x * step.x + step.y * step.y + step.z * step.z;
            if (!(step2 < ball.radius * ball.radius)) {
                ball = locate(problem, frames, positions[v], ball, part[chunk]);
                hints.keep_last(ball);
            }
            cell_of[v] = ball.cell;
        }
    });
    for (const PredicateStats& p : part) stats += p;
}

} // namespace brittle::fracture::exact

#include "fracture/exact/edges.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cassert>
#include <cmath>

#include "fracture/classifier.h"

namespace brittle::fracture::exact {

namespace {

constexpr uint32_t min_triangles_per_chunk = 256;

// A quotient whose denominator exceeds its error bound by this factor has nine correct digits or more. Any other is
// computed exactly, then rounded.
constexpr double well_conditioned = 1e7;

uint64_t key_of(uint32_t low, uint32_t high) {
    return uint64_t{low} << 32 | high; // never 0: low < high
}

uint64_t hash_of(uint64_t key) {
    key *= 0x9e3779b97f4a7c15ull;
    return key ^ (key >> 32);
}

// The bisector through which an edge leaves its cell, among those tested so far.
struct Exit {
    Frames::Slot slot = no_index;
    double at_low = 0.0, at_high = 0.0;
};

// The point where the edge meets the bisector of two cells, always computed in the frame of the lower cell.
glm::dvec3 point_on_edge(const Diagram& problem, SiteId a, SiteId b, const glm::dvec3& low, const glm::dvec3& high) {
    const SiteId c = std::min(a, b), other = std::max(a, b);
    const glm::dvec3& site = problem.sites[c];
    const Bisector plane = make_bisector(problem, c, other);
    const glm::dvec3 y0 = low - site, y1 = high - site;
    const double g0 = value(plane, y0), g1 = value(plane, y1);
    const double reach =
        std::sqrt(std::max(y0.x * y0.x + y0.y * y0.y + y0.z * y0.z, y1.x * y1.x + y1.y * y1.y + y1.z * y1.z));
    const double difference = g0 - g1;
    const bool good = std::abs(difference) > well_conditioned * value_error(plane.length, reach, plane.weight);
    const double t = good ? std::clamp(g0 / difference, 0.0, 1.0) : edge_parameter_exact(problem, c, other, low, high);
    const glm::dvec3 p = low + t * (high - low);
    return glm::clamp(p, glm::min(low, high), glm::max(low, high));
}

} // namespace

void EdgeCutter::walk_edge(const Scene& scene, const VoronoiDiagram& diagram, const Frames& frames, uint32_t low,
                           uint32_t high, SiteId from, SiteId to, Chunk& chunk) const {
    const Diagram problem = scene.diagram();
    const glm::dvec3 &q0 = scene.positions[low], &q1 = scene.positions[high];
    const auto first = static_cast<uint32_t>(chunk.points.size());
    for (SiteId c = from; c != to;) {
        const Frames::Cell& cell = frames.cells[c];
        const glm::dvec3 y0 = q0 - cell.site, y1 = q1 - cell.site;
        const uint32_t filled = Frames::padded(cell.end - cell.begin);
        if (chunk.beyond.size() < filled) chunk.beyond.resize(filled);
        plane_values_at(frames, cell.begin, filled, y1, chunk.beyond.data());
        Exit exit;
        for (Frames::Slot l = cell.begin; l < cell.end; ++l) {
            const double at_high = chunk.beyond[l - cell.begin];
            int side = side1_filter(at_high, cell.error);
            if (side > 0) continue;
            if (side == 0) side = side1_exact(problem, c, frames.site[l], q1, chunk.stats);
            if (side > 0) continue;
            const double at_low = frames.value_at(l, y0);
            if (exit.slot != no_index) { // keep the bisector that the edge meets first
                side = side2_filter(exit.at_low, exit.at_high, at_low, at_high, cell.error);
                if (side == 0) {
                    side = side2_exact(problem, c, frames.site[exit.slot], frames.site[l], q0, q1, chunk.stats);
                }
                if (side > 0) continue;
            }
            exit = {l, at_low, at_high};
        }
        assert(exit.slot != no_index);
        if (exit.slot == no_index) break;
        const SiteId next = frames.site[exit.slot];
        const uint32_t facet = diagram.neighbours[cell.first_neighbour + (exit.slot - cell.begin)].facet;
        chunk.points.push_back({{c, next}, facet, VertexId{}, {}});
        chunk.positions.push_back(point_on_edge(problem, c, next, q0, q1));
        c = next;
    }
    chunk.walks.push_back({key_of(low, high), first, static_cast<uint32_t>(chunk.points.size()) - first});
}

bool EdgeCutter::cross_once(const Scene& scene, const VoronoiDiagram& diagram, const Frames& frames, uint32_t low,
                            uint32_t high, SiteId from, SiteId to, Chunk& chunk) {
    const Frames::Cell& cell = frames.cells[from];
    const auto begin = frames.site.begin() + cell.begin, end = frames.site.begin() + cell.end;
    const auto found = std::find(begin, end, to);
    if (found == end) return false;
    const uint32_t facet = diagram.neighbours[cell.first_neighbour + static_cast<uint32_t>(found - begin)].facet;
    chunk.walks.push_back({key_of(low, high), static_cast<uint32_t>(chunk.points.size()), 1});
    chunk.points.push_back({{from, to}, facet, VertexId{}, {}});
    chunk.positions.push_back(point_on_edge(scene.diagram(), from, to, scene.positions[low], scene.positions[high]));
    return true;
}

void EdgeCutter::insert(const Walk& walk) {
    const size_t mask = table_.size() - 1;
    for (size_t slot = hash_of(walk.key) & mask;; slot = (slot + 1) & mask) {
        std::atomic_ref<uint64_t> key(table_[slot].key);
        uint64_t found = 0;
        if (key.compare_exchange_strong(found, walk.key, std::memory_order_relaxed)) {
            table_[slot].first = walk.first;
            table_[slot].count = walk.count;
            return;
        }
        assert(found != walk.key && "surface.h ensures one owner per edge");
    }
}

const EdgeCutter::Walk& EdgeCutter::find(uint64_t key) const {
    const size_t mask = table_.size() - 1;
    size_t slot = hash_of(key) & mask;
    while (table_[slot].key != key && table_[slot].key != 0) slot = (slot + 1) & mask;
    assert(table_[slot].key == key && "surface.h ensures an owner for each edge");
    return table_[slot];
}

void EdgeCutter::run(const Scene& scene, const VoronoiDiagram& diagram, const Frames& frames,
                     std::span<const Triangle> triangles, std::span<const SiteId> cell_of, Threads& threads, Cut& cut,
                     PredicateStats& stats) {
    const auto count = static_cast<uint32_t>(cut.crossing.size());
    const uint32_t parts = threads.chunks(count, min_triangles_per_chunk);
    chunks_.resize(std::max<size_t>(chunks_.size(), parts));
    threads.for_chunks(count, min_triangles_per_chunk, [&](uint32_t k, uint32_t begin, uint32_t end) {
        Chunk& chunk = chunks_[k];
        chunk.walks.clear();
        chunk.points.clear();
        chunk.positions.clear();
        chunk.stats = {};
        for (uint32_t x = begin; x < end; ++x) {
            threads.poll(x);
            const Triangle& t = triangles[cut.crossing[x].triangle];
            for (int e = 0; e < 3; ++e) {
                const uint32_t from = t[e], to = t[e == 2 ? 0 : e + 1];
                if (from > to || cell_of[from] == cell_of[to]) continue;
                if ((cut.crossing[x].known & Classifier::edge_alone(static_cast<uint32_t>(e))) != 0
                    && cross_once(scene, diagram, frames, from, to, cell_of[from], cell_of[to], chunk)) {
                    continue;
                }
                walk_edge(scene, diagram, frames, from, to, cell_of[from], cell_of[to], chunk);
            }
        }
    });

    uint32_t points = 0;
    size_t walks = 0;
    for (uint32_t k = 0; k < parts; ++k) {
        chunks_[k].base = points;
        points += static_cast<uint32_t>(chunks_[k].points.size());
        walks += chunks_[k].walks.size();
        stats += chunks_[k].stats;
    }
    cut.edge_points.resize(points);
    cut.edge_positions.resize(points);
    table_.assign(std::bit_ceil(2 * walks + 2), Walk{0, 0, 0});
    threads.for_chunks(count, min_triangles_per_chunk, [&](uint32_t k, uint32_t, uint32_t) {
        const Chunk& chunk = chunks_[k];
        std::copy(chunk.points.begin(), chunk.points.end(), cut.edge_points.begin() + chunk.base);
        std::copy(chunk.positions.begin(), chunk.positions.end(), cut.edge_positions.begin() + chunk.base);
        for (const Walk& walk : chunk.walks) insert({walk.key, walk.first + chunk.base, walk.count});
    });

    threads.for_chunks(count, min_triangles_per_chunk, [&](uint32_t, uint32_t begin, uint32_t end) {
        for (uint32_t x = begin; x < end; ++x) {
            CrossingTriangle& crossing = cut.crossing[x];
            const Triangle& t = triangles[crossing.triangle];
            for (int e = 0; e < 3; ++e) {
                const uint32_t a = t[e], b = t[e == 2 ? 0 : e + 1];
                crossing.first[static_cast<size_t>(e)] = crossing.count[static_cast<size_t>(e)] = 0;
                if (cell_of[a] == cell_of[b]) continue;
                const Walk& walk = find(key_of(std::min(a, b), std::max(a, b)));
                crossing.first[static_cast<size_t>(e)] = walk.first;
                crossing.count[static_cast<size_t>(e)] = walk.count;
            }
        }
    });
}

} // namespace brittle::fracture::exact

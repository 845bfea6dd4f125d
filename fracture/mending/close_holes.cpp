// Rims of holes, and what fills them.
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <set>

#include <glm/geometric.hpp>

#include "fracture/mending/fill_loop.h"
#include "fracture/mending/steps.h"

namespace brittle::fracture::mending {
namespace {

// A side that a triangle is missing for; the triangle's side would lead from `from` to `to`. Where two triangles
// disagree for good, as on a Moebius strip, one is missing for each: the surface is cut there and each side is filled.
struct RimSide {
    uint32_t from, to;
};

std::vector<RimSide> rim_sides(const EdgeTable& table) {
    std::vector<RimSide> sides;
    for (size_t e = 0; e < table.size(); ++e) {
        const auto uses = table[e];
        const int surplus = table.surplus(e);
        const RimSide side = surplus > 0 ? RimSide{uses[0].high, uses[0].low} : RimSide{uses[0].low, uses[0].high};
        sides.insert(sides.end(), static_cast<size_t>(std::abs(surplus)), side);
    }
    std::stable_sort(sides.begin(), sides.end(), [](const RimSide& a, const RimSide& b) { return a.from < b.from; });
    return sides;
}

// 0 to 4, growing with the angle of (x, y) from the X axis.
double pseudo_angle(double x, double y) {
    const double size = std::abs(x) + std::abs(y);
    if (!(size > 0.0)) return 0.0;
    const double t = y / size;
    return x < 0.0 ? 2.0 - t : (t < 0.0 ? 4.0 + t : t);
}

// Takes rim sides apart into loops that visit no vertex twice.
class LoopFinder {
  public:
    LoopFinder(const TriangleMesh& mesh, std::vector<RimSide> sides)
        : mesh_(mesh), sides_(std::move(sides)), begin_(mesh.positions.size() + 1, 0), used_(sides_.size(), 0),
          place_(mesh.positions.size(), no_index) {
        for (const RimSide& side : sides_) ++begin_[side.from + size_t{1}];
        bool forks = false;
        for (size_t v = 1; v < begin_.size(); ++v) {
            forks = forks || begin_[v] > 1;
            begin_[v] += begin_[v - 1];
        }
        if (forks) sum_normals();
    }

    std::vector<std::vector<uint32_t>> run() {
        for (uint32_t k = 0; k < sides_.size(); ++k)
            if (!used_[k]) walk_from(sides_[k].from);
        return std::move(loops_);
    }

  private:
    void sum_normals() {
        normals_.assign(mesh_.positions.size(), glm::dvec3(0.0));
        for (const Triangle& t : mesh_.triangles) {
            const glm::dvec3& a = mesh_.positions[t.x];
            const glm::dvec3 normal = glm::cross(mesh_.positions[t.y] - a, mesh_.positions[t.z] - a);
            for (int k = 0; k < 3; ++k) normals_[t[k]] += normal;
        }
    }

    void walk_from(uint32_t start) {
        std::vector<uint32_t> path = {start};
        place_[start] = 0;
        while (true) {
            const uint32_t side = choose(path);
            if (side == no_index) break; // back where it began: as many sides enter a vertex as leave it
            used_[side] = 1;
            const uint32_t to = sides_[side].to;
            if (place_[to] == no_index) {
                place_[to] = static_cast<uint32_t>(path.size());
                path.push_back(to);
                continue;
            }
            const auto first = path.begin() + place_[to];
            loops_.emplace_back(first, path.end());
            for (auto v = first + 1; v != path.end(); ++v) place_[*v] = no_index;
            path.erase(first + 1, path.end());
        }
        assert(path.size() == 1);
        place_[start] = no_index;
    }

    // The unused side that leaves the path's end: where there are several, the first one in the hole's sense after the
    // side that the path came by.
    [[nodiscard]] uint32_t choose(const std::vector<uint32_t>& path) const {
        const uint32_t v = path.back();
        uint32_t best = no_index;
        double least = 0.0;
        for (uint32_t k = begin_[v]; k < begin_[v + size_t{1}]; ++k) {
            if (used_[k]) continue;
            if (path.size() < 2 || normals_.empty()) return k;
            const double angle = angle_between(path[path.size() - 2], v, sides_[k].to);
            if (best != no_index && angle >= least) continue;
            best = k;
            least = angle;
        }
        return best;
    }

    // Clockwise around the normal at v, from the direction to `from` to that to `to`.
    [[nodiscard]] double angle_between(uint32_t from, uint32_t v, uint32_t to) const {
        const glm::dvec3 a = mesh_.positions[from] - mesh_.positions[v], b = mesh_.positions[to] - mesh_.positions[v];
        const glm::dvec3& n = normals_[v];
        const double size = glm::length(n);
        if (!(size > 0.0)) return 0.0;
        const glm::dvec3 unit = n / size;
        const glm::dvec3 flat_a = a - unit * glm::dot(a, unit), flat_b = b - unit * glm::dot(b, unit);
        return pseudo_angle(glm::dot(flat_a, flat_b), -glm::dot(unit, glm::cross(flat_a, flat_b)));
    }

    const TriangleMesh& mesh_;
    std::vector<RimSide> sides_; // by `from`
    std::vector<uint32_t> begin_;
    std::vector<uint8_t> used_;
    std::vector<uint32_t> place_; // of a vertex on the path
    std::vector<glm::dvec3> normals_; // only where rims fork
    std::vector<std::vector<uint32_t>> loops_;
};

std::array<uint32_t, 3> sorted_corners(const Triangle& t) {
    std::array<uint32_t, 3> c = {t.x, t.y, t.z};
    std::sort(c.begin(), c.end());
    return c;
}

// The mesh's triangles and edges, and those of the fills.
class TakenByMesh final : public Taken {
  public:
    TakenByMesh(const std::vector<Triangle>& triangles, const EdgeTable& table) : table_(table) {
        triangles_.reserve(triangles.size());
        for (uint32_t t = 0; t < triangles.size(); ++t) triangles_.emplace_back(sorted_corners(triangles[t]), t);
        std::sort(triangles_.begin(), triangles_.end());
    }

    [[nodiscard]] bool triangle(const Triangle& t) const override {
        return find(t) != no_index || new_triangles_.count(sorted_corners(t)) > 0;
    }
    [[nodiscard]] bool edge(uint32_t a, uint32_t b) const override {
        return table_.find(a, b) != no_index || new_edges_.count({std::min(a, b), std::max(a, b)}) > 0;
    }

    // The mesh's triangle of these corners, or no_index.
    [[nodiscard]] uint32_t find(const Triangle& t) const {
        const auto corners = sorted_corners(t);
        const auto at = std::lower_bound(triangles_.begin(), triangles_.end(), std::pair(corners, 0u));
        return at != triangles_.end() && at->first == corners ? at->second : no_index;
    }

    void add(const Triangle& t) {
        new_triangles_.insert(sorted_corners(t));
        for (int k = 0; k < 3; ++k) {
            const uint32_t a = t[k], b = t[(k + 1) % 3];
            new_edges_.insert({std::min(a, b), std::max(a, b)});
        }
    }

  private:
    const EdgeTable& table_;
    std::vector<std::pair<std::array<uint32_t, 3>, uint32_t>> triangles_;
    std::set<std::array<uint32_t, 3>> new_triangles_;
    std::set<std::pair<uint32_t, uint32_t>> new_edges_;
};

double length_of(const TriangleMesh& mesh, const std::vector<uint32_t>& loop) {
    double sum = 0.0;
    for (size_t k = 0; k < loop.size(); ++k)
        sum += glm::distance(mesh.positions[loop[k]], mesh.positions[loop[(k + 1) % loop.size()]]);
    return sum;
}

// Where no triangles between the corners will do, all of those around a new vertex will.
uint32_t add_centre(Work& work, const std::vector<uint32_t>& loop) {
    glm::dvec3 sum(0.0);
    for (const uint32_t v : loop) sum += work.mesh.positions[v] / static_cast<double>(loop.size());
    const uint32_t lowest = *std::min_element(loop.begin(), loop.end());
    const uint32_t centre = work.copy_vertex(lowest);
    work.mesh.positions[centre] = sum;
    work.report.new_vertices.add(work.origin[lowest]);
    return centre;
}

// Whether the triangle's corners go around as those of the other, which has the same ones.
bool same_sense(const Triangle& a, const Triangle& b) {
    for (int k = 0; k < 3; ++k)
        if (a.x == b[k]) return a.y == b[(k + 1) % 3];
    return false;
}

} // namespace

bool close_holes(Work& work, const RepairSettings& settings) {
    const EdgeTable table(work.mesh.triangles);
    std::vector<RimSide> sides = rim_sides(table);
    work.report.open_rims = work.report.long_rims = {};
    if (sides.empty()) return false;
    TakenByMesh taken(work.mesh.triangles, table);
    std::vector<uint8_t> loose(work.mesh.triangles.size(), 0);
    std::vector<uint8_t> is_cut(table.size(), 0);
    bool any_loose = false;
    std::vector<Triangle> fills;
    for (const std::vector<uint32_t>& loop : LoopFinder(work.mesh, std::move(sides)).run()) {
        uint32_t place = no_index;
        for (const uint32_t v : loop) place = std::min(place, work.origin[v]);
        if (loop.size() == 3 && settings.loose_triangles) {
            const Triangle back(loop[0], loop[1], loop[2]);
            const uint32_t t = taken.find(back);
            if (t != no_index && !loose[t] && !same_sense(back, work.mesh.triangles[t])) {
                loose[t] = 1;
                any_loose = true;
                work.report.loose_triangles.add(work.source[t]);
                continue;
            }
        }
        const bool wanted = settings.close_holes > 0.0 && length_of(work.mesh, loop) <= settings.close_holes;
        Fill fill = wanted ? fill_loop(work.mesh.positions, loop, taken) : Fill{};
        if (!wanted || fill.too_long) {
            (fill.too_long ? work.report.long_rims : work.report.open_rims).add(place);
            continue;
        }
        if (fill.triangles.empty()) {
            const uint32_t centre = add_centre(work, loop);
            for (size_t k = 0; k < loop.size(); ++k)
                fill.triangles.emplace_back(loop[k], loop[(k + 1) % loop.size()], centre);
        }
        for (const Triangle& t : fill.triangles) {
            taken.add(t);
            fills.push_back(t);
        }
        for (size_t k = 0; k < loop.size(); ++k) {
            const uint32_t e = table.find(loop[k], loop[(k + 1) % loop.size()]);
            if (table[e].size() == 2 && !is_cut[e]) work.report.cut_edges.add(work.origin[table[e][0].low]);
            is_cut[e] = 1;
        }
        work.report.closed_holes.add(place);
        work.report.new_triangles += fill.triangles.size();
    }
    if (any_loose) work.drop(loose);
    for (const Triangle& t : fills) work.append(t, no_index, false);
    return any_loose || !fills.empty();
}

} // namespace brittle::fracture::mending

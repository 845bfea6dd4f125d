// Finds the rims of holes and fills them.
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>

#include <glm/geometric.hpp>

#include "fracture/doctor/mending/crossings.h"
#include "fracture/doctor/mending/fill_in_plane.h"
#include "fracture/doctor/mending/fill_loop.h"
#include "fracture/doctor/mending/remesh_fill.h"
#include "fracture/doctor/mending/steps.h"

namespace brittle::fracture::mending {
namespace {

// A side of the rim: the missing triangle's side would run from `from` to `to`. Where two triangles cannot agree in
// orientation, as on a Moebius strip, a triangle is missing for each of them: the surface is cut there and each side of
// the cut is filled.
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

// A number from 0 to 4 that grows with the angle between (x, y) and the X axis.
double pseudo_angle(double x, double y) {
    const double size = std::abs(x) + std::abs(y);
    if (!(size > 0.0)) return 0.0;
    const double t = y / size;
    return x < 0.0 ? 2.0 - t : (t < 0.0 ? 4.0 + t : t);
}

// The number of sides compared at a vertex, so that no vertex costs quadratic time.
constexpr uint32_t max_choices = 16;

// Divides the sides of rims into loops that visit no vertex twice.
class LoopFinder {
  public:
    LoopFinder(const TriangleMesh& mesh, std::vector<RimSide> sides)
        : mesh_(mesh), sides_(std::move(sides)), end_(mesh.positions.size(), 0),
          place_(mesh.positions.size(), no_index) {
        for (const RimSide& side : sides_) ++end_[side.from];
        const bool forks = std::any_of(end_.begin(), end_.end(), [](uint32_t count) { return count > 1; });
        if (forks) sum_normals();
        std::partial_sum(end_.begin(), end_.end(), end_.begin());
        next_.assign(1, 0);
        next_.insert(next_.end(), end_.begin(), end_.end());
    }

    std::vector<Loop> run() {
        for (uint32_t v = 0; v < end_.size(); ++v)
            while (next_[v] < end_[v]) walk_from(v);
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
            const uint32_t v = path.back();
            if (next_[v] == end_[v]) break; // back at the start: as many sides enter a vertex as leave it
            const uint32_t to = take_side(path);
            if (place_[to] == no_index) {
                place_[to] = static_cast<uint32_t>(path.size());
                path.push_back(to);
                continue;
            }
            const auto first = path.begin() + place_[to];
            loops_.emplace_back(first, path.end());
            for (auto passed = first + 1; passed != path.end(); ++passed) place_[*passed] = no_index;
            path.erase(first + 1, path.end());
        }
        assert(path.size() == 1);
        place_[start] = no_index;
    }

    // Uses up a side that leaves the end of the path, and returns its far end. Of several sides it takes the first one
    // in the sense of the hole after the side by which the path arrived.
    uint32_t take_side(const std::vector<uint32_t>& path) {
        const uint32_t v = path.back(), first = next_[v], last = std::min(end_[v], first + max_choices);
        uint32_t best = first;
        if (path.size() > 1 && last - first > 1) {
            double least = angle_between(path[path.size() - 2], v, sides_[first].to);
            for (uint32_t k = first + 1; k < last; ++k) {
                const double angle = angle_between(path[path.size() - 2], v, sides_[k].to);
                if (angle >= least) continue;
                best = k;
                least = angle;
            }
        }
        const auto begin = sides_.begin() + first;
        std::rotate(begin, sides_.begin() + best, sides_.begin() + best + 1);
        return sides_[next_[v]++].to;
    }

    // The clockwise pseudo-angle around the normal at v, from the direction of `from` to that of `to`.
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
    std::vector<RimSide> sides_;      // sorted by `from`
    std::vector<uint32_t> end_;       // per vertex: the end of the sides that leave it
    std::vector<uint32_t> next_;      // per vertex: the first of these sides that is unused
    std::vector<uint32_t> place_;     // per vertex: its place on the path, or no_index
    std::vector<glm::dvec3> normals_; // only where rims fork
    std::vector<Loop> loops_;
};

std::array<uint32_t, 3> sorted_corners(const Triangle& t) {
    std::array<uint32_t, 3> c = {t.x, t.y, t.z};
    std::sort(c.begin(), c.end());
    return c;
}

// The existing triangles and edges: those of the mesh and those of the fills.
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

    // The triangle of the mesh with these corners, or no_index.
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

double length_of(const TriangleMesh& mesh, const Loop& loop) {
    double sum = 0.0;
    for (size_t k = 0; k < loop.size(); ++k)
        sum += glm::distance(mesh.positions[loop[k]], mesh.positions[loop[(k + 1) % loop.size()]]);
    return sum;
}

// Adds a vertex in the middle of a loop. The triangles from it to the sides never exist already.
uint32_t add_centre(Work& work, const Loop& loop) {
    glm::dvec3 sum(0.0);
    for (const uint32_t v : loop) sum += work.mesh.positions[v] / static_cast<double>(loop.size());
    const uint32_t lowest = *std::min_element(loop.begin(), loop.end());
    const uint32_t centre = work.copy_vertex(lowest);
    work.mesh.positions[centre] = sum;
    work.report.new_vertices.add(work.origin[lowest]);
    return centre;
}

// Whether two triangles with the same vertices have the same orientation.
bool same_sense(const Triangle& a, const Triangle& b) {
    for (int k = 0; k < 3; ++k)
        if (a.x == b[k]) return a.y == b[(k + 1) % 3];
    return false;
}

// One round of filling. The mesh changes only at its end, so that indices stay valid until then.
class HoleCloser {
  public:
    HoleCloser(Work& work, const RepairSettings& settings)
        : work_(work), settings_(settings), table_(work.mesh.triangles), taken_(work.mesh.triangles, table_),
          loose_(work.mesh.triangles.size(), 0), is_cut_(table_.size(), 0) {}

    bool run(std::vector<RimSide> sides) {
        const std::vector<Loop> loops = LoopFinder(work_.mesh, std::move(sides)).run();
        std::vector<uint8_t> done(loops.size(), 0);
        for (const std::vector<uint32_t>& ring : find_rings(work_.mesh.positions, loops)) fill_ring(loops, ring, done);
        for (size_t k = 0; k < loops.size(); ++k)
            if (!done[k] && !drop_loose(loops[k])) fill(loops[k]);
        if (any_loose_) work_.drop(loose_);
        for (const Triangle& t : fills_) work_.append(t, no_index, false);
        return any_loose_ || !fills_.empty();
    }

  private:
    [[nodiscard]] bool is_wanted(const Loop& loop) const {
        return settings_.close_holes > 0.0 && length_of(work_.mesh, loop) <= settings_.close_holes;
    }

    [[nodiscard]] uint32_t place_of(const Loop& loop) const {
        uint32_t place = no_index;
        for (const uint32_t v : loop) place = std::min(place, work_.origin[v]);
        return place;
    }

    void fill_ring(const std::vector<Loop>& loops, const std::vector<uint32_t>& ring, std::vector<uint8_t>& done) {
        std::vector<Loop> parts;
        for (const uint32_t k : ring) {
            if (!is_wanted(loops[k])) return;
            parts.push_back(loops[k]);
        }
        const std::vector<Triangle> triangles = fill_in_plane(work_.mesh.positions, parts, taken_);
        if (triangles.empty() || taken_inside(triangles, taken_) > 0) return; // each loop is filled on its own instead
        accept(triangles);
        for (const uint32_t k : ring) {
            done[k] = 1;
            count_closed(loops[k]);
        }
    }

    bool drop_loose(const Loop& loop) {
        if (loop.size() != 3 || !settings_.loose_triangles) return false;
        const Triangle back(loop[0], loop[1], loop[2]);
        const uint32_t t = taken_.find(back);
        if (t == no_index || loose_[t] || same_sense(back, work_.mesh.triangles[t])) return false;
        loose_[t] = 1;
        any_loose_ = true;
        work_.report.loose_triangles.add(work_.source[t]);
        return true;
    }

    void fill(const Loop& loop) {
        if (!is_wanted(loop)) {
            work_.report.open_rims.add(place_of(loop));
            return;
        }
        Fill fill = fill_loop(work_.mesh.positions, loop, taken_);
        if (fill.too_long) {
            work_.report.long_rims.add(place_of(loop));
            return;
        }
        if (fill.triangles.empty()) {
            const uint32_t centre = add_centre(work_, loop);
            for (size_t k = 0; k < loop.size(); ++k)
                fill.triangles.emplace_back(loop[k], loop[(k + 1) % loop.size()], centre);
            accept(fill.triangles);
        } else {
            accept_best(loop, fill.triangles);
        }
        count_closed(loop);
    }

    // Takes the first fill that intersects no triangle, else the one with the fewest intersections: the given one and that
    // of least area, each as it was asked for, plain, and smooth.
    void accept_best(const Loop& loop, const std::vector<Triangle>& given) {
        if (loop.size() == 3) return accept(given); // there is no other
        using Remesh = RepairSettings::Remesh;
        Remeshed best = finished(given, settings_.remesh_holes);
        uint64_t crossings = count_crossings(best).value_or(0);
        const auto attempt = [&](const std::vector<Triangle>& fill, Remesh remesh) {
            if (crossings == 0 || fill.empty()) return;
            Remeshed other = finished(fill, remesh);
            const std::optional<uint64_t> its = count_crossings(other);
            if (!its || *its >= crossings) return;
            crossings = *its;
            best = std::move(other);
        };
        if (crossings > 0) {
            const std::vector<Triangle> least = fill_by_area(work_.mesh.positions, loop, taken_);
            for (const Remesh remesh : {settings_.remesh_holes, Remesh::none, Remesh::smooth})
                for (const std::vector<Triangle>& fill : {given, least}) attempt(fill, remesh);
        }
        if (crossings > 0) {
            work_.report.crossing_fills.add(place_of(loop));
            work_.report.fill_crossings += crossings;
        }
        const uint32_t lowest = *std::min_element(loop.begin(), loop.end());
        const auto known = static_cast<uint32_t>(work_.mesh.positions.size());
        for (const glm::dvec3& p : best.points) work_.mesh.positions[work_.copy_vertex(lowest)] = p;
        if (!best.points.empty())
            work_.report.new_vertices.add(work_.origin[lowest], work_.mesh.positions.size() - known);
        accept(best.triangles);
    }

    Remeshed finished(const std::vector<Triangle>& fill, RepairSettings::Remesh remesh) {
        if (remesh == RepairSettings::Remesh::none) return {fill, {}};
        if (!neighbours_) neighbours_.emplace(work_.mesh);
        return remesh_fill(work_.mesh.positions, fill, *neighbours_, taken_, remesh == RepairSettings::Remesh::smooth);
    }

    std::optional<uint64_t> count_crossings(const Remeshed& fill) {
        if (!crossings_) crossings_.emplace(work_.mesh);
        std::vector<glm::dvec3>& positions = work_.mesh.positions;
        const size_t known = positions.size();
        positions.insert(positions.end(), fill.points.begin(), fill.points.end());
        const std::optional<uint64_t> count = crossings_->count(fill.triangles);
        positions.resize(known);
        return count;
    }

    void accept(const std::vector<Triangle>& triangles) {
        for (const Triangle& t : triangles) {
            taken_.add(t);
            fills_.push_back(t);
        }
        work_.report.new_triangles += triangles.size();
    }

    void count_closed(const Loop& loop) {
        for (size_t k = 0; k < loop.size(); ++k) {
            const uint32_t e = table_.find(loop[k], loop[(k + 1) % loop.size()]);
            if (table_[e].size() == 2 && !is_cut_[e]) work_.report.cut_edges.add(work_.origin[table_[e][0].low]);
            is_cut_[e] = 1;
        }
        work_.report.closed_holes.add(place_of(loop));
    }

    Work& work_;
    const RepairSettings& settings_;
    EdgeTable table_;
    TakenByMesh taken_;
    std::vector<uint8_t> loose_;  // per triangle
    std::vector<uint8_t> is_cut_; // per edge: counted as a cut edge
    bool any_loose_ = false;
    std::vector<Triangle> fills_;
    std::optional<Crossings> crossings_;   // made when it is first needed, as is
    std::optional<Neighbours> neighbours_; // of the mesh without fills
};

} // namespace

bool close_holes(Work& work, const RepairSettings& settings) {
    work.report.open_rims = work.report.long_rims = {};
    std::vector<RimSide> sides = rim_sides(EdgeTable(work.mesh.triangles));
    return !sides.empty() && HoleCloser(work, settings).run(std::move(sides));
}

} // namespace brittle::fracture::mending

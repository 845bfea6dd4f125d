#include "fracture/triangulation/triangulate.h"

#include <algorithm>

#include <glm/common.hpp>

#include "fracture/triangulation/loop_nesting.h"
#include "fracture/triangulation/ring.h"
#include "fracture/triangulation/simple_loop.h"

namespace brittle::fracture {
namespace {

using namespace triangulation;

bool has_hole(std::span<const LoopInfo> loops) {
    return std::any_of(loops.begin(), loops.end(), [](const LoopInfo& loop) { return loop.hole_of != no_index; });
}

} // namespace

struct Triangulator::State {
    void clear() {
        result.triangles.clear();
        result.forced_ears = 0;
        result.vertex_tests = 0;
    }

    [[nodiscard]] bool has_repeated_ids(std::span<const LoopInfo> loops) {
        if (loops.size() < 2) return false; // within one loop the ids are distinct after splitting
        ids.clear();
        for (const LoopInfo& loop : loops) ids.insert(ids.end(), loop.ids.begin(), loop.ids.end());
        std::sort(ids.begin(), ids.end());
        return std::adjacent_find(ids.begin(), ids.end()) != ids.end();
    }

    SimpleLoop simple_loop;
    std::vector<glm::dvec2> loop_points;
    Nesting nesting;
    EdgeSet edges;
    Ring ring;
    std::vector<uint32_t> ids;
    Triangulation result;
};

Triangulator::Triangulator() = default;
Triangulator::~Triangulator() = default;
Triangulator::Triangulator(Triangulator&&) noexcept = default;
Triangulator& Triangulator::operator=(Triangulator&&) noexcept = default;

const Triangulation& Triangulator::run(std::span<const glm::dvec2> points, std::span<const Loop> loops) {
    if (!state_) state_ = std::make_unique<State>();
    State& s = *state_;
    s.clear();
    s.nesting.run(points, loops);
    const std::span<const LoopInfo> parts = s.nesting.loops();
    // A diagonal can repeat an edge only if a point has several nodes: at the ends of bridges, and where loops share
    // ids.
    const bool holes = has_hole(parts), repeated = holes || s.has_repeated_ids(parts);
    if (repeated) {
        s.edges.clear();
        for (const LoopInfo& loop : parts) {
            for (size_t k = 0; k < loop.ids.size(); ++k) {
                s.edges.insert(loop.ids[k], loop.ids[(k + 1) % loop.ids.size()]);
            }
        }
    }
    for (uint32_t i = 0; i < parts.size(); ++i) {
        if (parts[i].hole_of != no_index) continue;
        s.ring.start(points, repeated ? &s.edges : nullptr);
        s.ring.set_outer(parts[i]);
        if (holes) s.ring.bridge_holes(parts, i);
        s.ring.clip();
        s.ring.flip_edges();
        s.ring.emit(s.result);
    }
    return s.result;
}

// Counter-clockwise loops are outer loops, none a hole of another, so each is triangulated on its own.
const Triangulation& Triangulator::run_simple(std::span<const glm::dvec2> points, std::span<const Loop> loops) {
    if (!state_) state_ = std::make_unique<State>();
    State& s = *state_;
    s.clear();
    for (const Loop& loop : loops) {
        s.loop_points.clear();
        for (const uint32_t id : loop) s.loop_points.push_back(points[id]);
        if (!s.simple_loop.triangulate(s.loop_points, loop, s.result.triangles)) return run(points, loops);
    }
    return s.result;
}

Triangulation triangulate(std::span<const glm::dvec2> points, std::span<const Loop> loops) {
    Triangulator triangulator;
    return triangulator.run(points, loops);
}

glm::dvec2 project(const glm::dvec3& point, const glm::dvec3& normal) {
    const glm::dvec3 size = glm::abs(normal);
    if (size.x >= size.y && size.x >= size.z) {
        return normal.x >= 0.0 ? glm::dvec2(point.y, point.z) : glm::dvec2(point.z, point.y);
    }
    if (size.y >= size.z) return normal.y >= 0.0 ? glm::dvec2(point.z, point.x) : glm::dvec2(point.x, point.z);
    return normal.z >= 0.0 ? glm::dvec2(point.x, point.y) : glm::dvec2(point.y, point.x);
}

} // namespace brittle::fracture

// Bodies that touch nothing but the ground, as most debris does, and are not resting: solved four at a time from
// their contact points to their contact points.
//
// For sixteen bodies at a time rows are made, all sweeps run over them, overlap is corrected, and impulses go back to
// the points; the rows are never stored. The operations and their order are those of RowSolver: not a bit differs.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/solver/ground_rows.h"

namespace brittle::physics {

class LoneBodies {
  public:
    // The solver's bodies, and what becomes of their velocities and of the correction of overlap.
    struct State {
        const SolverBody* bodies;
        VelocityChange *changes, *corrections;
    };

    void clear() { bodies_.clear(); }
    // A body that is not resting; the manifold has points.
    void add(GroundManifold& ground, uint32_t body) { bodies_.push_back({&ground, body}); }
    // After the last add(): puts bodies with as many points side by side.
    void arrange();
    [[nodiscard]] uint32_t count() const { return static_cast<uint32_t>(bodies_.size()); }

    // Solves the bodies of some groups; for different groups, on any threads. Leaves the impulses in the points.
    [[nodiscard]] uint32_t groups() const;
    void solve(uint32_t begin, uint32_t end, const State& state, const GroundStep& step, int sweeps) const;

  private:
    struct Lone {
        GroundManifold* ground;
        uint32_t body;
    };
    struct Block;

    static void solve(std::span<const Lone> group, const State& state, const GroundStep& step, int sweeps);

    std::vector<Lone> bodies_, scratch_;
};

} // namespace brittle::physics

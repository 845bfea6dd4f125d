// Lone bodies: bodies that touch the ground only and are not resting, as most debris.
//
// Sixteen bodies at a time, four in lanes, go through the whole solution: rows are built from the contact points, all
// sweeps run over them, overlap is corrected, and impulses are written back to the points. The rows are never stored.
// The operations and their order are those of RowSolver (row.h), so results are equal bit for bit.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/solver/ground_rows.h"

namespace brittle::physics {

class LoneBodies {
  public:
    // The solver's bodies; dv of the velocities and dv of the split impulses, both written.
    struct State {
        const SolverBody* bodies;
        VelocityChange *changes, *corrections;
    };

    void clear() { bodies_.clear(); }
    // Precondition: the body is not resting and the manifold has points.
    void add(GroundManifold& ground, uint32_t body) { bodies_.push_back({&ground, body}); }
    // Sorts bodies by number of points. Call it after the last add().
    void arrange();
    [[nodiscard]] uint32_t count() const { return static_cast<uint32_t>(bodies_.size()); }

    // Solves a range of groups and stores the impulses in their contact points. Thread-safe for different groups.
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

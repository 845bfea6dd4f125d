// Bodies that touch nothing but the ground, as most debris does, and are not held: solved four at a time from their points to their
// points, while all of it is at hand.
//
// Rows are made, all sweeps run over them, overlap is undone, and impulses go back to the points, of sixteen bodies at a time: their rows
// are never kept. The same operations as in RowSolver, in the same order: not a bit is different. Bullet's units.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/solver/ground_rows.h"

namespace brittle::physics {

class LoneBodies {
  public:
    // The solver's movers, and what becomes of them: of their velocities, and of moving out of overlap.
    struct Movers {
        const Mover* movers;
        Motion *motions, *parting;
    };

    void clear() { bodies_.clear(); }
    // One that does not rest; the manifold has points.
    void add(GroundManifold& ground, uint32_t mover) { bodies_.push_back({&ground, mover}); }
    // When all are there: those with as many points side by side.
    void arrange();
    [[nodiscard]] uint32_t count() const { return static_cast<uint32_t>(bodies_.size()); }

    // Those of some groups; for different ones, on any threads. Leaves what becomes of a point in it.
    [[nodiscard]] uint32_t groups() const;
    void solve(uint32_t begin, uint32_t end, const Movers& movers, const GroundStep& step, int sweeps) const;

  private:
    struct Lone {
        GroundManifold* ground;
        uint32_t mover;
    };
    struct Block;

    static void solve(std::span<const Lone> group, const Movers& movers, const GroundStep& step, int sweeps);

    std::vector<Lone> bodies_, scratch_;
};

} // namespace brittle::physics

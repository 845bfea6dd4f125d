// Lone bodies: bodies that touch the ground only and are not resting, as most debris.
//
// Sixteen bodies at a time, four in lanes, go through the whole solution: rows are built from the contact points, all
// substeps run over them, and impulses are written back to the points. The rows are never stored. Rows are solved in
// the same order as in StaticRows; results may differ from those of RowSolver by rounding.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/solver/ground_rows.h"
#include "physics/solver/static_rows.h"

namespace brittle::physics {

class LoneBodies {
  public:
    void clear() { bodies_.clear(); }
    // Precondition: the body is not resting and the manifold has points.
    void add(GroundManifold& ground, uint32_t body) { bodies_.push_back({&ground, body}); }
    // Sorts bodies by number of points. Call it after the last add().
    void arrange();
    [[nodiscard]] uint32_t count() const { return static_cast<uint32_t>(bodies_.size()); }

    // Solves a range of groups and stores the impulses in their contact points. Thread-safe for different groups.
    [[nodiscard]] uint32_t groups() const;
    void solve(uint32_t begin, uint32_t end, const StaticRows::State& state, const GroundStep& step,
               const Substeps& substeps) const;

  private:
    struct Lone {
        GroundManifold* ground;
        uint32_t body;
    };
    struct Block;

    static void solve(std::span<const Lone> group, const StaticRows::State& state, const GroundStep& step,
                      const Substeps& substeps);

    std::vector<Lone> bodies_, scratch_;
};

} // namespace brittle::physics

// What carries too much for long gives way: bonds of a structure wear under weight and what rests on it.
//
// Each step the stresses (stress.h) are brought up to date, a bounded number of iterations at a time, and where they are in
// balance with the loads, bonds beyond their strength lose health: speed * (ratio - 1) a second, where ratio is that
// of load_ratio() over the health that is left. So a column that is cut takes its part of the house down a moment later,
// bond by bond, and what stands stands for ever. Blows are no loads: BondGraph::blow() has those.
//
// Coordinates are those of the fragments; SI units. Deterministic.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/bonds/bond_graph.h"
#include "physics/bonds/stress.h"
#include "physics/material.h"

namespace brittle::physics {

struct WearSettings {
    bool enabled = true;
    // Of the material's handbook strengths. Those are of flawless samples: a model of a metre in them carries a
    // hundred times its own weight, and nothing ever falls. At a twentieth, as with old mortar, a concrete slab over a
    // gap of a metre just carries itself when it is a sixth of that thick.
    float strength_scale = 0.05f;
    float speed = 8.0f;        // health lost in a second by a bond at twice its strength
    uint32_t iterations = 16;  // of the solver in one step; one takes 0.2 ms for 1000 pieces
    float load_seconds = 0.1f; // contacts count by their mean over about so long
};

class Wear {
  public:
    Wear() = default;
    Wear(std::span<const StressNode> nodes, const BondGraph& graph, const Material& material,
         const WearSettings& settings);

    void remove_bonds(std::span<const uint32_t> bonds);
    void release(std::span<const uint32_t> nodes);

    // One step of so many seconds: the weights of the pieces that something holds, and the forces of contacts in this step.
    // Contacts with none in a step fade. Overloaded bonds of the graph lose health.
    void step(BondGraph& graph, std::span<const NodeLoad> weights, std::span<const NodeLoad> contact_loads,
              double seconds);

    [[nodiscard]] const StressSolver& solver() const { return solver_; }
    // Of each bond, as it was when the stresses were last in balance; 1: breaks when intact.
    [[nodiscard]] std::span<const double> ratios() const { return ratios_; }

  private:
    StressSolver solver_;
    Material material_; // strengths scaled
    WearSettings settings_;
    std::vector<NodeLoad> mean_contact_loads_, solver_loads_; // of contacts; those that the solver has
    std::vector<NodeLoad> next_loads_;                        // scratch of one call
    std::vector<double> ratios_;
    bool ratios_due_ = true; // ratios_ are not those of the solver
};

} // namespace brittle::physics

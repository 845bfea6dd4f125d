// Wear: bonds of a structure that are overloaded for some time lose health and break.
//
// Each step updates the stresses (stress.h) by a bounded number of iterations. Once they are in equilibrium with the
// loads, each overloaded bond loses health at the rate speed * (ratio - 1) per second, where ratio is load_ratio()
// divided by the remaining health. A cut column thus takes its part of the house down a moment later, bond by bond,
// and a structure that bears its load stands for ever. Blows are no loads: BondGraph::blow() handles them.
//
// Coordinates are those of the fragments; SI units. Deterministic. Not thread-safe.
//
//     Wear wear(nodes, graph, settings);
//     each step: wear.step(graph, weights, contact_loads, seconds);
//                wear.remove_bonds(graph.take_broken());
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
    float strength_scale = sustained_strength; // factor on the material's strengths
    float speed = 8.0f;                        // health per second that a bond at twice its strength loses
    uint32_t iterations = 16;                  // of the solver in one step; one costs 0.2 ms for 1000 pieces
    float load_seconds = 0.1f;                 // s, time constant of the moving average of contact loads
};

class Wear {
  public:
    Wear() = default;
    Wear(std::span<const StressNode> nodes, const BondGraph& graph, const WearSettings& settings);

    void remove_bonds(std::span<const uint32_t> bonds);
    // After graph.divide(): the node's parts, whose numbers begin at the number of nodes so far.
    void divide(uint32_t node, std::span<const StressNode> parts, const BondGraph& graph);
    void release(std::span<const uint32_t> nodes);

    // Advances by one step of `seconds`. weights: by piece, the weight of pieces in fixed bodies, zero for others.
    // contact_loads: by piece, the loads of this step's contacts; the average of a contact that ended decays.
    // Overloaded bonds of the graph lose health.
    void step(BondGraph& graph, std::span<const NodeLoad> weights, std::span<const NodeLoad> contact_loads,
              double seconds);

    [[nodiscard]] const StressSolver& solver() const { return solver_; }
    // By bond: load_ratio() at the last equilibrium; an intact bond wears above 1.
    [[nodiscard]] std::span<const double> ratios() const { return ratios_; }

  private:
    StressSolver solver_;
    std::vector<Material> materials_; // as BondGraph::materials(), with strength_scale applied
    WearSettings settings_;
    std::vector<NodeLoad> mean_contact_loads_, solver_loads_; // by node
    std::vector<NodeLoad> next_loads_;                        // scratch of step()
    std::vector<double> ratios_;
    bool ratios_due_ = true; // whether ratios_ are older than the solver's loads
};

} // namespace brittle::physics

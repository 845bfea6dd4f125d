#include "physics/bonds/wear.h"

#include <algorithm>

#include <glm/geometric.hpp>

namespace brittle::physics {

namespace {

constexpr double tolerance = 0.01; // of the stresses
// Load changes below this share of the load, or of the piece's weight at 9.81 m/s^2, are ignored: contact forces
// fluctuate.
constexpr double load_tolerance = 0.05, weight_tolerance = 0.01 * 9.81;
// Averages below this share of that weight are set to zero.
constexpr double min_contact_ratio = 1e-3;

// A broken bond has no area.
std::vector<StressBond> stress_bonds(const BondGraph& graph) {
    std::vector<StressBond> bonds;
    for (const BondGraph::Bond& bond : graph.bonds())
        bonds.push_back({bond.live() ? bond.a : 0, bond.live() ? bond.b : 0, bond.live() ? bond.area : 0.0,
                         bond.centroid, bond.normal});
    return bonds;
}

} // namespace

Wear::Wear(std::span<const StressNode> nodes, const BondGraph& graph, const WearSettings& settings)
    : settings_(settings), mean_contact_loads_(nodes.size()), solver_loads_(nodes.size()),
      ratios_(graph.bonds().size(), 0.0) {
    for (const Material& material : graph.materials())
        materials_.push_back(scale_strength(material, settings.strength_scale));
    solver_ = StressSolver(nodes, stress_bonds(graph));
}

void Wear::remove_bonds(std::span<const uint32_t> bonds) {
    if (bonds.empty()) return;
    solver_.remove_bonds(bonds);
    for (const uint32_t bond : bonds) ratios_[bond] = 0.0;
    ratios_due_ = true;
}

void Wear::divide(uint32_t node, std::span<const StressNode> parts, const BondGraph& graph) {
    solver_.divide(node, parts, stress_bonds(graph));
    for (std::vector<NodeLoad>* loads : {&mean_contact_loads_, &solver_loads_}) {
        (*loads)[node] = {};
        loads->resize(solver_.node_count());
    }
    ratios_.resize(graph.bonds().size(), 0.0);
    ratios_due_ = true;
}

void Wear::release(std::span<const uint32_t> nodes) {
    solver_.release(nodes);
    ratios_due_ = true;
}

void Wear::step(BondGraph& graph, std::span<const NodeLoad> weights, std::span<const NodeLoad> contact_loads,
                double seconds) {
    const double share = std::min(1.0, seconds / std::max<double>(settings_.load_seconds, seconds));
    bool unchanged = true;
    next_loads_.resize(solver_loads_.size());
    for (size_t i = 0; i < solver_loads_.size(); ++i) {
        NodeLoad& mean = mean_contact_loads_[i];
        const double weight = solver_.node(i).mass * 9.81;
        mean.force += (contact_loads[i].force - mean.force) * share;
        mean.torque += (contact_loads[i].torque - mean.torque) * share;
        if (contact_loads[i].force == glm::dvec3(0.0) && glm::length(mean.force) < min_contact_ratio * weight)
            mean = {};
        next_loads_[i] = {weights[i].force + mean.force, weights[i].torque + mean.torque};
        const double change = glm::length(next_loads_[i].force - solver_loads_[i].force);
        unchanged =
            unchanged
            && change <= load_tolerance * glm::length(solver_loads_[i].force) + weight_tolerance * solver_.node(i).mass;
    }
    if (!unchanged) {
        solver_loads_ = next_loads_;
        solver_.set_loads(solver_loads_);
        ratios_due_ = true;
    }
    if (ratios_due_ && solver_.solve(settings_.iterations, tolerance)) {
        for (uint32_t i = 0; i < ratios_.size(); ++i)
            ratios_[i] =
                graph.bonds()[i].live() ? load_ratio(solver_.stress(i), materials_[graph.bonds()[i].material]) : 0.0;
        ratios_due_ = false;
    }
    if (ratios_due_) return;
    for (uint32_t i = 0; i < ratios_.size(); ++i) {
        const double health = graph.bonds()[i].health;
        if (ratios_[i] > health && health > 0.0)
            graph.weaken(i, seconds * static_cast<double>(settings_.speed) * (ratios_[i] / health - 1.0));
    }
}

} // namespace brittle::physics

#include "physics/bonds/wear.h"

#include <algorithm>

#include <glm/geometric.hpp>

namespace brittle::physics {

namespace {

constexpr double tolerance = 0.01; // of the stresses
// A load that changed by less than this share of it, or of what its piece weighs on earth, is the same: contacts tremble.
constexpr double same_load = 0.05, same_weight = 0.01 * 9.81;
// Contacts below this share of that weight are gone.
constexpr double gone = 1e-3;

} // namespace

Wear::Wear(std::span<const StressNode> nodes, const BondGraph& graph, const Material& material,
           const WearSettings& settings)
    : material_(material), settings_(settings), means_(nodes.size()), loads_(nodes.size()),
      ratios_(graph.bonds().size(), 0.0) {
    std::vector<StressBond> bonds;
    for (const BondGraph::Bond& bond : graph.bonds())
        bonds.push_back({bond.live() ? bond.a : 0, bond.live() ? bond.b : 0, bond.live() ? bond.area : 0.0,
                         bond.centroid, bond.normal});
    solver_ = StressSolver(nodes, bonds);
    for (float* strength : {&material_.tensile, &material_.compressive, &material_.shear})
        *strength *= settings.strength_scale;
}

void Wear::remove_bonds(std::span<const uint32_t> bonds) {
    if (bonds.empty()) return;
    solver_.remove_bonds(bonds);
    for (const uint32_t bond : bonds) ratios_[bond] = 0.0;
    due_ = true;
}

void Wear::release(std::span<const uint32_t> nodes) {
    solver_.release(nodes);
    due_ = true;
}

void Wear::step(BondGraph& graph, std::span<const NodeLoad> weights, std::span<const NodeLoad> pushes, double seconds) {
    const double share = std::min(1.0, seconds / std::max<double>(settings_.load_seconds, seconds));
    bool same = true;
    next_.resize(loads_.size());
    for (size_t i = 0; i < loads_.size(); ++i) {
        NodeLoad& mean = means_[i];
        const double weight = solver_.node(i).mass * 9.81;
        mean.force += (pushes[i].force - mean.force) * share;
        mean.torque += (pushes[i].torque - mean.torque) * share;
        if (pushes[i].force == glm::dvec3(0.0) && glm::length(mean.force) < gone * weight) mean = {};
        next_[i] = {weights[i].force + mean.force, weights[i].torque + mean.torque};
        const double change = glm::length(next_[i].force - loads_[i].force);
        same = same && change <= same_load * glm::length(loads_[i].force) + same_weight * solver_.node(i).mass;
    }
    if (!same) {
        loads_ = next_;
        solver_.set_loads(loads_);
        due_ = true;
    }
    if (due_ && solver_.solve(settings_.iterations, tolerance)) {
        for (uint32_t i = 0; i < ratios_.size(); ++i)
            ratios_[i] = graph.bonds()[i].live() ? load_ratio(solver_.stress(i), material_) : 0.0;
        due_ = false;
    }
    if (due_) return;
    for (uint32_t i = 0; i < ratios_.size(); ++i) {
        const double health = graph.bonds()[i].health;
        if (ratios_[i] > health && health > 0.0)
            graph.weaken(i, seconds * static_cast<double>(settings_.speed) * (ratios_[i] / health - 1.0));
    }
}

} // namespace brittle::physics

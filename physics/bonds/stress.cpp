#include "physics/bonds/stress.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace brittle::physics {

namespace {

constexpr uint32_t none = UINT32_MAX;
constexpr double shear_ratio = 0.4; // shear modulus over Young's modulus, of stone, glass and steel
// Loads of a free island below this share of the applied force are rounding; 1 for forces, m for torques.
constexpr double rounding_ratio = 1e-9;
constexpr size_t max_groups = 32; // of the coarse correction; the cost of its factor is cubic in them
constexpr size_t min_group_size = 6;
constexpr double singular_pivot = 1e-10; // relative to the diagonal entry

double dot(const auto& a, const auto& b) {
    double sum = 0.0;
    for (size_t i = 0; i < a.size(); ++i)
        sum += glm::dot(a[i].linear, b[i].linear) + glm::dot(a[i].angular, b[i].angular);
    return sum;
}

// Replaces a matrix by its lower Cholesky factor, row-major. A singular pivot gets a zero row, whose unknown solves to
// zero.
void factorise(std::span<double> matrix, size_t n) {
    for (size_t i = 0; i < n; ++i) {
        double* row = &matrix[i * n];
        const double own = row[i];
        for (size_t j = 0; j < i; ++j) {
            const double* other = &matrix[j * n];
            double sum = row[j];
            for (size_t k = 0; k < j; ++k) sum -= row[k] * other[k];
            row[j] = other[j] > 0.0 ? sum / other[j] : 0.0;
        }
        double pivot = own;
        for (size_t k = 0; k < i; ++k) pivot -= row[k] * row[k];
        if (pivot > singular_pivot * own && own > 0.0)
            row[i] = std::sqrt(pivot);
        else
            std::fill(row, row + i + 1, 0.0);
    }
}

void solve_factor(std::span<const double> factor, size_t n, std::span<double> x) {
    for (size_t i = 0; i < n; ++i) {
        const double* row = &factor[i * n];
        double sum = x[i];
        for (size_t k = 0; k < i; ++k) sum -= row[k] * x[k];
        x[i] = row[i] > 0.0 ? sum / row[i] : 0.0;
    }
    for (size_t i = n; i-- > 0;) {
        const double* row = &factor[i * n];
        x[i] = row[i] > 0.0 ? x[i] / row[i] : 0.0;
        for (size_t k = 0; k < i; ++k) x[k] -= row[k] * x[i];
    }
}

glm::dmat3 cross_matrix(const glm::dvec3& v) { // cross_matrix(v) * u = cross(v, u)
    return {glm::dvec3(0.0, v.z, -v.y), glm::dvec3(-v.z, 0.0, v.x), glm::dvec3(v.y, -v.x, 0.0)};
}

// A spring's stiffness at its own point, and the 6 x 6 blocks that it causes between two nodes (or groups) from which
// that point lies at row_arm and column_arm.
struct Stiffness {
    glm::dmat3 translational, rotational;

    template<class Put>
    void block(const glm::dvec3& row_arm, const glm::dvec3& column_arm, double sign, Put put) const {
        const glm::dmat3 row = cross_matrix(row_arm), column = cross_matrix(column_arm);
        const glm::dmat3 force_linear = translational, force_angular = -translational * column,
                         torque_linear = row * translational,
                         torque_angular = -(row * translational * column) + rotational;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                put(i, j, sign * force_linear[j][i]);
                put(i, j + 3, sign * force_angular[j][i]);
                put(i + 3, j, sign * torque_linear[j][i]);
                put(i + 3, j + 3, sign * torque_angular[j][i]);
            }
    }
};

Stiffness stiffness_of(const auto& spring) {
    const glm::dmat3 along = glm::outerProduct(spring.normal, spring.normal);
    return {glm::dmat3(spring.shear) + along * (spring.axial - spring.shear),
            glm::dmat3(spring.bending) + along * (spring.torsion - spring.bending)};
}

} // namespace

double load_ratio(const BondStress& stress, const Material& material) {
    const double tensile = stress.tension + stress.bending - stress.compression;
    const double compressive = stress.compression + stress.bending - stress.tension;
    return std::max({tensile / static_cast<double>(material.tensile),
                     compressive / static_cast<double>(material.compressive),
                     stress.shear / static_cast<double>(material.shear)});
}

StressSolver::StressSolver(std::span<const StressNode> nodes, std::span<const StressBond> bonds)
    : nodes_(nodes.begin(), nodes.end()), bonds_(bonds.begin(), bonds.end()) {
    x_.resize(nodes.size());
    applied_.resize(nodes.size());
    build(std::vector<uint8_t>(nodes.size(), 1));
}

void StressSolver::remove_bonds(std::span<const uint32_t> bonds) {
    std::vector<uint8_t> changed(nodes_.size(), 0);
    bool any = false;
    for (const uint32_t bond : bonds) {
        if (!(std::exchange(bonds_[bond].area, 0.0) > 0.0)) continue;
        any = true;
        changed[bonds_[bond].a] = changed[bonds_[bond].b] = 1;
    }
    if (any) build(changed);
}

void StressSolver::divide(uint32_t node, std::span<const StressNode> parts, std::span<const StressBond> bonds) {
    const auto first = static_cast<uint32_t>(nodes_.size());
    const auto is_changed = [&](uint32_t index) { return index == node || index >= first; };
    for (const StressNode& part : parts) {
        nodes_.push_back(part);
        const NodeVector& whole = x_[node];
        x_.push_back({whole.linear + glm::cross(whole.angular, part.centre - nodes_[node].centre), whole.angular});
    }
    nodes_[node].fixed = false;
    x_[node] = {};
    applied_[node] = {};
    applied_.resize(nodes_.size());
    bonds_.assign(bonds.begin(), bonds.end());
    std::vector<uint8_t> changed(nodes_.size(), 0);
    for (uint32_t index = 0; index < nodes_.size(); ++index) changed[index] = is_changed(index);
    for (const StressBond& bond : bonds_)
        if (bond.area > 0.0 && (is_changed(bond.a) || is_changed(bond.b))) changed[bond.a] = changed[bond.b] = 1;
    build(changed);
}

void StressSolver::release(std::span<const uint32_t> nodes) {
    bool any = false;
    for (const uint32_t node : nodes) any = std::exchange(nodes_[node].fixed, false) || any;
    if (any) build(std::vector<uint8_t>(nodes_.size(), 1));
}

// changed: by node, 1 where the node's bonds are new or were removed; the blocks of other nodes stay.
void StressSolver::build(const std::vector<uint8_t>& changed) {
    springs_.clear();
    spring_of_bond_.assign(bonds_.size(), none);
    for (uint32_t i = 0; i < bonds_.size(); ++i) {
        const StressBond& bond = bonds_[i];
        if (!(bond.area > 0.0)) continue;
        assert(bond.a < nodes_.size() && bond.b < nodes_.size());
        const StressNode &a = nodes_[bond.a], &b = nodes_[bond.b];
        const double length = std::max(glm::length(b.centre - a.centre), 1e-9);
        const double second_moment = bond.area * bond.area / (4.0 * std::numbers::pi);
        spring_of_bond_[i] = static_cast<uint32_t>(springs_.size());
        springs_.push_back({bond.a, bond.b, i, bond.centroid - a.centre, bond.centroid - b.centre, bond.normal,
                            bond.area / length, shear_ratio * bond.area / length, second_moment / length,
                            2.0 * shear_ratio * second_moment / length});
    }
    inverse_.resize(nodes_.size());
    for (size_t node = 0; node < nodes_.size(); ++node)
        if (changed[node]) inverse_[node] = {};
    for (const Spring& spring : springs_) {
        const Stiffness stiffness = stiffness_of(spring);
        for (const auto& [node, arm] : {std::pair(spring.a, spring.arm_a), {spring.b, spring.arm_b}}) {
            if (!changed[node]) continue;
            stiffness.block(arm, arm, 1.0, [&, at = node](int i, int j, double value) {
                inverse_[at][static_cast<size_t>(i * 6 + j)] += value;
            });
        }
    }
    for (size_t node = 0; node < nodes_.size(); ++node) {
        if (!changed[node]) continue;
        Block& block = inverse_[node];
        factorise(block, 6);
        Block inverse;
        for (size_t column = 0; column < 6; ++column) {
            std::array<double, 6> unit{};
            unit[column] = 1.0;
            solve_factor(block, 6, unit);
            for (size_t row = 0; row < 6; ++row) inverse[row * 6 + column] = unit[row];
        }
        block = inverse;
    }
    find_groups();
    build_coarse();
    loads_ = applied_;
    remove_acceleration(loads_);
    restart();
}

// Labels islands, and groups of neighbouring free nodes within them, by breadth-first search from the first unlabelled
// node.
void StressSolver::find_groups() {
    const size_t count = nodes_.size();
    std::vector<uint32_t> first(count + 1, 0), next_to;
    for (const Spring& spring : springs_) ++first[spring.a + 1], ++first[spring.b + 1];
    for (size_t i = 0; i < count; ++i) first[i + 1] += first[i];
    next_to.resize(first[count]);
    std::vector<uint32_t> at(first.begin(), first.end() - 1);
    for (const Spring& spring : springs_) next_to[at[spring.a]++] = spring.b, next_to[at[spring.b]++] = spring.a;

    std::vector<uint32_t> queue;
    const auto walk = [&](uint32_t start, std::vector<uint32_t>& label, uint32_t value, size_t most, auto&& enters) {
        queue.assign(1, start);
        label[start] = value;
        for (size_t i = 0; i < queue.size(); ++i)
            for (uint32_t n = first[queue[i]]; n < first[queue[i] + 1] && queue.size() < most; ++n) {
                const uint32_t node = next_to[n];
                if (label[node] != none || !enters(node)) continue;
                label[node] = value;
                queue.push_back(node);
            }
    };
    island_of_.assign(count, none);
    island_fixed_.clear();
    for (uint32_t i = 0; i < count; ++i) {
        if (island_of_[i] != none) continue;
        walk(i, island_of_, static_cast<uint32_t>(island_fixed_.size()), count, [](uint32_t) { return true; });
        island_fixed_.push_back(std::ranges::any_of(queue, [&](uint32_t node) { return nodes_[node].fixed; }));
    }
    const size_t size = std::max(min_group_size, (count + max_groups - 1) / max_groups);
    group_of_.assign(count, none);
    group_centre_.clear();
    for (uint32_t i = 0; i < count; ++i) {
        if (group_of_[i] != none || nodes_[i].fixed || first[i] == first[i + 1]) continue;
        walk(i, group_of_, static_cast<uint32_t>(group_centre_.size()), size,
             [&](uint32_t node) { return !nodes_[node].fixed; });
        // A small remnant between groups stays ungrouped; the block preconditioner suffices for it.
        if (queue.size() * 3 < size && count > size) {
            for (const uint32_t node : queue) group_of_[node] = none - 1;
            continue;
        }
        glm::dvec3 centre(0.0);
        for (const uint32_t node : queue) centre += nodes_[node].centre;
        group_centre_.push_back(centre / static_cast<double>(queue.size()));
    }
    for (uint32_t& group : group_of_)
        if (group == none - 1) group = none;
}

// Assembles and factorises the stiffness between the rigid motions of the groups about their centres.
void StressSolver::build_coarse() {
    const size_t n = 6 * group_centre_.size();
    coarse_factor_.assign(n * n, 0.0);
    coarse_solution_.assign(n, 0.0);
    for (const Spring& spring : springs_) {
        const uint32_t group_a = group_of_[spring.a], group_b = group_of_[spring.b];
        if (group_a == group_b) continue; // a rigid motion does not strain it
        const Stiffness stiffness = stiffness_of(spring);
        const glm::dvec3 place = nodes_[spring.a].centre + spring.arm_a;
        for (const uint32_t row : {group_a, group_b})
            for (const uint32_t column : {group_a, group_b}) {
                if (row == none || column == none) continue;
                stiffness.block(
                    place - group_centre_[row], place - group_centre_[column], row == column ? 1.0 : -1.0,
                    [&](int i, int j, double value) {
                        coarse_factor_[(row * 6 + static_cast<size_t>(i)) * n + column * 6 + static_cast<size_t>(j)] +=
                            value;
                    });
            }
    }
    factorise(coarse_factor_, n);
}

void StressSolver::set_loads(std::span<const NodeLoad> loads) {
    assert(loads.size() == nodes_.size());
    applied_.assign(loads.begin(), loads.end());
    loads_ = applied_;
    remove_acceleration(loads_);
    restart();
}

// Subtracts the rigid acceleration of each free island from its loads (d'Alembert).
void StressSolver::remove_acceleration(std::vector<NodeLoad>& loads) const {
    struct Island {
        double mass = 0.0;
        glm::dvec3 centre{0.0}, force{0.0}, torque{0.0};
        glm::dmat3 inertia{0.0};
    };
    std::vector<Island> islands(island_fixed_.size());
    for (size_t i = 0; i < nodes_.size(); ++i) {
        Island& island = islands[island_of_[i]];
        island.mass += nodes_[i].mass;
        island.centre += nodes_[i].mass * nodes_[i].centre;
        island.force += loads[i].force;
    }
    for (Island& island : islands)
        if (island.mass > 0.0) island.centre /= island.mass;
    for (size_t i = 0; i < nodes_.size(); ++i) {
        Island& island = islands[island_of_[i]];
        const glm::dvec3 arm = nodes_[i].centre - island.centre;
        island.torque += loads[i].torque + glm::cross(arm, loads[i].force);
        island.inertia +=
            nodes_[i].inertia + nodes_[i].mass * (glm::dmat3(glm::dot(arm, arm)) - glm::outerProduct(arm, arm));
    }
    for (size_t i = 0; i < nodes_.size(); ++i) {
        const Island& island = islands[island_of_[i]];
        if (island_fixed_[island_of_[i]] || !(island.mass > 0.0) || !(glm::determinant(island.inertia) > 0.0)) continue;
        const glm::dvec3 spin = glm::inverse(island.inertia) * island.torque;
        const glm::dvec3 arm = nodes_[i].centre - island.centre;
        loads[i].force -= nodes_[i].mass * (island.force / island.mass + glm::cross(spin, arm));
        loads[i].torque -= nodes_[i].inertia * spin;
        // In free fall only rounding is left.
        const double rounding = rounding_ratio * glm::length(applied_[i].force);
        if (glm::length(loads[i].force) <= rounding && glm::length(loads[i].torque) <= rounding) loads[i] = {};
    }
}

BondLoad StressSolver::load_of(const Spring& spring) const {
    const NodeVector &a = x_[spring.a], &b = x_[spring.b];
    const glm::dvec3 translation =
        b.linear + glm::cross(b.angular, spring.arm_b) - a.linear - glm::cross(a.angular, spring.arm_a);
    const glm::dvec3 rotation = b.angular - a.angular;
    const glm::dvec3& n = spring.normal;
    return {-(spring.shear * translation + (spring.axial - spring.shear) * glm::dot(translation, n) * n),
            -(spring.bending * rotation + (spring.torsion - spring.bending) * glm::dot(rotation, n) * n)};
}

// out = stiffness * x
void StressSolver::apply(const NodeVectors& x, NodeVectors& out) const {
    std::ranges::fill(out, NodeVector{});
    for (const Spring& spring : springs_) {
        const NodeVector &a = x[spring.a], &b = x[spring.b];
        const glm::dvec3& n = spring.normal;
        const glm::dvec3 translation =
            b.linear + glm::cross(b.angular, spring.arm_b) - a.linear - glm::cross(a.angular, spring.arm_a);
        const glm::dvec3 rotation = b.angular - a.angular;
        const glm::dvec3 force =
            spring.shear * translation + ((spring.axial - spring.shear) * glm::dot(translation, n)) * n;
        const glm::dvec3 moment =
            spring.bending * rotation + ((spring.torsion - spring.bending) * glm::dot(rotation, n)) * n;
        out[spring.a].linear -= force;
        out[spring.a].angular -= glm::cross(spring.arm_a, force) + moment;
        out[spring.b].linear += force;
        out[spring.b].angular += glm::cross(spring.arm_b, force) + moment;
    }
    for (size_t i = 0; i < nodes_.size(); ++i)
        if (nodes_[i].fixed) out[i] = {};
}

void StressSolver::precondition(const NodeVectors& r, NodeVectors& z) const {
    std::ranges::fill(coarse_solution_, 0.0);
    for (size_t i = 0; i < nodes_.size(); ++i) {
        const Block& block = inverse_[i];
        const std::array<double, 6> in{r[i].linear.x,  r[i].linear.y,  r[i].linear.z,
                                       r[i].angular.x, r[i].angular.y, r[i].angular.z};
        std::array<double, 6> out{};
        for (size_t row = 0; row < 6; ++row)
            for (size_t column = 0; column < 6; ++column) out[row] += block[row * 6 + column] * in[column];
        z[i] = {{out[0], out[1], out[2]}, {out[3], out[4], out[5]}};
        if (group_of_[i] == none) continue;
        const glm::dvec3 torque =
            r[i].angular + glm::cross(nodes_[i].centre - group_centre_[group_of_[i]], r[i].linear);
        for (int axis = 0; axis < 3; ++axis) {
            coarse_solution_[group_of_[i] * 6 + static_cast<size_t>(axis)] += r[i].linear[axis];
            coarse_solution_[group_of_[i] * 6 + 3 + static_cast<size_t>(axis)] += torque[axis];
        }
    }
    solve_factor(coarse_factor_, coarse_solution_.size(), coarse_solution_);
    for (size_t i = 0; i < nodes_.size(); ++i) {
        if (group_of_[i] == none) continue;
        const double* g = &coarse_solution_[group_of_[i] * 6];
        const glm::dvec3 rotation(g[3], g[4], g[5]);
        z[i].linear +=
            glm::dvec3(g[0], g[1], g[2]) + glm::cross(rotation, nodes_[i].centre - group_centre_[group_of_[i]]);
        z[i].angular += rotation;
    }
    for (size_t i = 0; i < nodes_.size(); ++i)
        if (nodes_[i].fixed) z[i] = {};
}

void StressSolver::restart() {
    converged_ = false;
    restarted_ = true;
}

bool StressSolver::solve(uint32_t iterations, double tolerance) {
    if (converged_) return true;
    if (restarted_) {
        r_.resize(nodes_.size()), z_.resize(nodes_.size()), q_.resize(nodes_.size());
        apply(x_, q_);
        load_size_ = 0.0;
        for (size_t i = 0; i < nodes_.size(); ++i) {
            // A node without bonds cannot transmit its load.
            const bool free = !nodes_[i].fixed && inverse_[i][0] > 0.0;
            r_[i] = free ? NodeVector{loads_[i].force - q_[i].linear, loads_[i].torque - q_[i].angular} : NodeVector{};
            if (free)
                load_size_ += glm::dot(loads_[i].force, loads_[i].force) + glm::dot(loads_[i].torque, loads_[i].torque);
        }
        precondition(r_, z_);
        p_ = z_;
        rz_ = dot(r_, z_);
        restarted_ = false;
    }
    if (load_size_ == 0.0) {
        x_.assign(nodes_.size(), NodeVector{});
        return converged_ = true;
    }
    // Both the residual and the energy of the error must be small: the residual says little about slender parts, the
    // energy little about stiff ones.
    const auto below_tolerance = [&] {
        double residual = 0.0, work = 0.0;
        for (size_t i = 0; i < nodes_.size(); ++i) {
            residual += glm::dot(r_[i].linear, r_[i].linear);
            work += glm::dot(loads_[i].force, x_[i].linear) + glm::dot(loads_[i].torque, x_[i].angular);
        }
        const double square = tolerance * tolerance;
        return residual <= square * load_size_ && rz_ <= square * work;
    };
    for (uint32_t i = 0; i < iterations; ++i) {
        if (!(rz_ > 0.0) || below_tolerance()) return converged_ = true;
        apply(p_, q_);
        const double curvature = dot(p_, q_);
        if (!(curvature > 0.0)) return converged_ = true;
        const double step = rz_ / curvature;
        for (size_t n = 0; n < nodes_.size(); ++n) {
            x_[n].linear += step * p_[n].linear, x_[n].angular += step * p_[n].angular;
            r_[n].linear -= step * q_[n].linear, r_[n].angular -= step * q_[n].angular;
        }
        precondition(r_, z_);
        const double before = std::exchange(rz_, dot(r_, z_));
        const double beta = rz_ / before;
        for (size_t n = 0; n < nodes_.size(); ++n) {
            p_[n].linear = z_[n].linear + beta * p_[n].linear;
            p_[n].angular = z_[n].angular + beta * p_[n].angular;
        }
        ++iterations_;
    }
    return converged_ = below_tolerance();
}

BondLoad StressSolver::load(uint32_t bond) const {
    return spring_of_bond_[bond] == none ? BondLoad{} : load_of(springs_[spring_of_bond_[bond]]);
}

BondStress StressSolver::stress(uint32_t bond) const {
    BondStress stress;
    if (spring_of_bond_[bond] == none) return stress;
    const BondLoad through = load(bond);
    const double area = bonds_[bond].area;
    const glm::dvec3& n = bonds_[bond].normal;
    const double radius = std::sqrt(area / std::numbers::pi), second_moment = area * area / (4.0 * std::numbers::pi);
    const double axial = glm::dot(through.force, n), twist = glm::dot(through.moment, n);
    stress.compression = std::max(axial, 0.0) / area;
    stress.tension = std::max(-axial, 0.0) / area;
    stress.shear = glm::length(through.force - axial * n) / area + std::abs(twist) * radius / (2.0 * second_moment);
    stress.bending = glm::length(through.moment - twist * n) * radius / second_moment;
    return stress;
}

NodeLoad StressSolver::reaction(uint32_t node) const {
    NodeLoad reaction;
    if (!nodes_[node].fixed) return reaction;
    reaction = {-applied_[node].force, -applied_[node].torque};
    for (const Spring& spring : springs_) {
        if (spring.a != node && spring.b != node) continue;
        const BondLoad through = load_of(spring);
        const double sign = spring.a == node ? 1.0 : -1.0;
        const glm::dvec3& arm = spring.a == node ? spring.arm_a : spring.arm_b;
        reaction.force += sign * through.force;
        reaction.torque += sign * (through.moment + glm::cross(arm, through.force));
    }
    return reaction;
}

} // namespace brittle::physics

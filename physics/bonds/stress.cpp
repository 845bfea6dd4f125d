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
constexpr double shear_ratio = 0.4; // of the shear modulus to Young's: that of stone, glass and steel
constexpr double min_rest = 1e-9;   // of a load whose island falls, N or N m for each N
constexpr size_t max_groups = 32;   // of the coarse correction, whose factor costs their cube
constexpr size_t min_group_size = 6;
constexpr double singular_pivot = 1e-10; // of a Cholesky factor, as a share of the diagonal

double dot(const auto& a, const auto& b) {
    double sum = 0.0;
    for (size_t i = 0; i < a.size(); ++i) sum += glm::dot(a[i].move, b[i].move) + glm::dot(a[i].turn, b[i].turn);
    return sum;
}

// Lower Cholesky factor in place, row-major. A motion that nothing resists gets a row that solves to zero.
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

// The matrix of a spring between the motions of points at arms from where it acts: row and column arms may differ.
struct Stiffness {
    glm::dmat3 pull, bend;

    template<class Put>
    void block(const glm::dvec3& row_arm, const glm::dvec3& column_arm, double sign, Put put) const {
        const glm::dmat3 row = cross_matrix(row_arm), column = cross_matrix(column_arm);
        const glm::dmat3 moved = pull, turned = -pull * column, torque = row * pull,
                         torque_turned = -(row * pull * column) + bend;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                put(i, j, sign * moved[j][i]);
                put(i, j + 3, sign * turned[j][i]);
                put(i + 3, j, sign * torque[j][i]);
                put(i + 3, j + 3, sign * torque_turned[j][i]);
            }
    }
};

Stiffness stiffness_of(const auto& spring) {
    const glm::dmat3 along = glm::outerProduct(spring.normal, spring.normal);
    return {glm::dmat3(spring.push_aside) + along * (spring.pull - spring.push_aside),
            glm::dmat3(spring.bend) + along * (spring.twist - spring.bend)};
}

} // namespace

double load_ratio(const BondStress& stress, const Material& material) {
    const double pull = stress.tension + stress.bending - stress.compression;
    const double press = stress.compression + stress.bending - stress.tension;
    return std::max({pull / static_cast<double>(material.tensile), press / static_cast<double>(material.compressive),
                     stress.shear / static_cast<double>(material.shear)});
}

StressSolver::StressSolver(std::span<const StressNode> nodes, std::span<const StressBond> bonds)
    : nodes_(nodes.begin(), nodes.end()), bonds_(bonds.begin(), bonds.end()) {
    x_.resize(nodes.size());
    given_.resize(nodes.size());
    build();
}

void StressSolver::remove_bonds(std::span<const uint32_t> bonds) {
    bool any = false;
    for (const uint32_t bond : bonds) any = std::exchange(bonds_[bond].area, 0.0) > 0.0 || any;
    if (any) build();
}

void StressSolver::release(std::span<const uint32_t> nodes) {
    bool any = false;
    for (const uint32_t node : nodes) any = std::exchange(nodes_[node].fixed, false) || any;
    if (any) build();
}

void StressSolver::build() {
    springs_.clear();
    spring_of_bond_.assign(bonds_.size(), none);
    for (uint32_t i = 0; i < bonds_.size(); ++i) {
        const StressBond& bond = bonds_[i];
        if (!(bond.area > 0.0)) continue;
        assert(bond.a < nodes_.size() && bond.b < nodes_.size());
        const StressNode &a = nodes_[bond.a], &b = nodes_[bond.b];
        const double length = std::max(glm::length(b.centre - a.centre), 1e-9);
        const double second = bond.area * bond.area / (4.0 * std::numbers::pi);
        spring_of_bond_[i] = static_cast<uint32_t>(springs_.size());
        springs_.push_back({bond.a, bond.b, i, bond.centroid - a.centre, bond.centroid - b.centre, bond.normal,
                            bond.area / length, shear_ratio * bond.area / length, second / length,
                            2.0 * shear_ratio * second / length});
    }
    inverse_.assign(nodes_.size(), Block{});
    for (const Spring& spring : springs_) {
        const Stiffness stiffness = stiffness_of(spring);
        for (const auto& [node, arm] : {std::pair(spring.a, spring.arm_a), {spring.b, spring.arm_b}})
            stiffness.block(arm, arm, 1.0, [&, at = node](int i, int j, double value) {
                inverse_[at][static_cast<size_t>(i * 6 + j)] += value;
            });
    }
    for (Block& block : inverse_) {
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
    loads_ = given_;
    relieve(loads_);
    restart();
}

// Islands, and groups of neighbouring free nodes within them: breadth first from the first node that has none.
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
    held_.clear();
    for (uint32_t i = 0; i < count; ++i) {
        if (island_of_[i] != none) continue;
        walk(i, island_of_, static_cast<uint32_t>(held_.size()), count, [](uint32_t) { return true; });
        held_.push_back(std::ranges::any_of(queue, [&](uint32_t node) { return nodes_[node].fixed; }));
    }
    const size_t size = std::max(min_group_size, (count + max_groups - 1) / max_groups);
    group_of_.assign(count, none);
    group_centre_.clear();
    for (uint32_t i = 0; i < count; ++i) {
        if (group_of_[i] != none || nodes_[i].fixed || first[i] == first[i + 1]) continue;
        walk(i, group_of_, static_cast<uint32_t>(group_centre_.size()), size,
             [&](uint32_t node) { return !nodes_[node].fixed; });
        // What is left over between groups stays without one; the blocks of the nodes serve it.
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

// The stiffness between the rigid motions of the groups about their centres.
void StressSolver::build_coarse() {
    const size_t n = 6 * group_centre_.size();
    factor_.assign(n * n, 0.0);
    coarse_.assign(n, 0.0);
    for (const Spring& spring : springs_) {
        const uint32_t group_a = group_of_[spring.a], group_b = group_of_[spring.b];
        if (group_a == group_b) continue; // rigid together
        const Stiffness stiffness = stiffness_of(spring);
        const glm::dvec3 place = nodes_[spring.a].centre + spring.arm_a;
        for (const uint32_t row : {group_a, group_b})
            for (const uint32_t column : {group_a, group_b}) {
                if (row == none || column == none) continue;
                stiffness.block(
                    place - group_centre_[row], place - group_centre_[column], row == column ? 1.0 : -1.0,
                    [&](int i, int j, double value) {
                        factor_[(row * 6 + static_cast<size_t>(i)) * n + column * 6 + static_cast<size_t>(j)] += value;
                    });
            }
    }
    factorise(factor_, n);
}

void StressSolver::set_loads(std::span<const NodeLoad> loads) {
    assert(loads.size() == nodes_.size());
    given_.assign(loads.begin(), loads.end());
    loads_ = given_;
    relieve(loads_);
    restart();
}

// Takes the acceleration as a whole out of islands that nothing holds.
void StressSolver::relieve(std::vector<NodeLoad>& loads) const {
    struct Whole {
        double mass = 0.0;
        glm::dvec3 centre{0.0}, force{0.0}, torque{0.0};
        glm::dmat3 inertia{0.0};
    };
    std::vector<Whole> wholes(held_.size());
    for (size_t i = 0; i < nodes_.size(); ++i) {
        Whole& whole = wholes[island_of_[i]];
        whole.mass += nodes_[i].mass;
        whole.centre += nodes_[i].mass * nodes_[i].centre;
        whole.force += loads[i].force;
    }
    for (Whole& whole : wholes)
        if (whole.mass > 0.0) whole.centre /= whole.mass;
    for (size_t i = 0; i < nodes_.size(); ++i) {
        Whole& whole = wholes[island_of_[i]];
        const glm::dvec3 arm = nodes_[i].centre - whole.centre;
        whole.torque += loads[i].torque + glm::cross(arm, loads[i].force);
        whole.inertia +=
            nodes_[i].inertia + nodes_[i].mass * (glm::dmat3(glm::dot(arm, arm)) - glm::outerProduct(arm, arm));
    }
    for (size_t i = 0; i < nodes_.size(); ++i) {
        const Whole& whole = wholes[island_of_[i]];
        if (held_[island_of_[i]] || !(whole.mass > 0.0) || !(glm::determinant(whole.inertia) > 0.0)) continue;
        const glm::dvec3 spin = glm::inverse(whole.inertia) * whole.torque;
        const glm::dvec3 arm = nodes_[i].centre - whole.centre;
        loads[i].force -= nodes_[i].mass * (whole.force / whole.mass + glm::cross(spin, arm));
        loads[i].torque -= nodes_[i].inertia * spin;
        // In a fall nothing but rounding is left.
        const double rounding = min_rest * glm::length(given_[i].force);
        if (glm::length(loads[i].force) <= rounding && glm::length(loads[i].torque) <= rounding) loads[i] = {};
    }
}

BondLoad StressSolver::load_of(const Spring& spring) const {
    const Motion &a = x_[spring.a], &b = x_[spring.b];
    const glm::dvec3 apart = b.move + glm::cross(b.turn, spring.arm_b) - a.move - glm::cross(a.turn, spring.arm_a);
    const glm::dvec3 bent = b.turn - a.turn;
    const glm::dvec3& n = spring.normal;
    return {-(spring.push_aside * apart + (spring.pull - spring.push_aside) * glm::dot(apart, n) * n),
            -(spring.bend * bent + (spring.twist - spring.bend) * glm::dot(bent, n) * n)};
}

// out = stiffness * x
void StressSolver::apply(const Motions& x, Motions& out) const {
    std::ranges::fill(out, Motion{});
    for (const Spring& spring : springs_) {
        const Motion &a = x[spring.a], &b = x[spring.b];
        const glm::dvec3& n = spring.normal;
        const glm::dvec3 apart = b.move + glm::cross(b.turn, spring.arm_b) - a.move - glm::cross(a.turn, spring.arm_a);
        const glm::dvec3 bent = b.turn - a.turn;
        const glm::dvec3 force =
            spring.push_aside * apart + ((spring.pull - spring.push_aside) * glm::dot(apart, n)) * n;
        const glm::dvec3 moment = spring.bend * bent + ((spring.twist - spring.bend) * glm::dot(bent, n)) * n;
        out[spring.a].move -= force;
        out[spring.a].turn -= glm::cross(spring.arm_a, force) + moment;
        out[spring.b].move += force;
        out[spring.b].turn += glm::cross(spring.arm_b, force) + moment;
    }
    for (size_t i = 0; i < nodes_.size(); ++i)
        if (nodes_[i].fixed) out[i] = {};
}

void StressSolver::precondition(const Motions& r, Motions& z) const {
    std::ranges::fill(coarse_, 0.0);
    for (size_t i = 0; i < nodes_.size(); ++i) {
        const Block& block = inverse_[i];
        const std::array<double, 6> in{r[i].move.x, r[i].move.y, r[i].move.z, r[i].turn.x, r[i].turn.y, r[i].turn.z};
        std::array<double, 6> out{};
        for (size_t row = 0; row < 6; ++row)
            for (size_t column = 0; column < 6; ++column) out[row] += block[row * 6 + column] * in[column];
        z[i] = {{out[0], out[1], out[2]}, {out[3], out[4], out[5]}};
        if (group_of_[i] == none) continue;
        const glm::dvec3 torque = r[i].turn + glm::cross(nodes_[i].centre - group_centre_[group_of_[i]], r[i].move);
        for (int axis = 0; axis < 3; ++axis) {
            coarse_[group_of_[i] * 6 + static_cast<size_t>(axis)] += r[i].move[axis];
            coarse_[group_of_[i] * 6 + 3 + static_cast<size_t>(axis)] += torque[axis];
        }
    }
    solve_factor(factor_, coarse_.size(), coarse_);
    for (size_t i = 0; i < nodes_.size(); ++i) {
        if (group_of_[i] == none) continue;
        const double* g = &coarse_[group_of_[i] * 6];
        const glm::dvec3 turn(g[3], g[4], g[5]);
        z[i].move += glm::dvec3(g[0], g[1], g[2]) + glm::cross(turn, nodes_[i].centre - group_centre_[group_of_[i]]);
        z[i].turn += turn;
    }
    for (size_t i = 0; i < nodes_.size(); ++i)
        if (nodes_[i].fixed) z[i] = {};
}

void StressSolver::restart() {
    converged_ = false;
    fresh_ = true;
}

bool StressSolver::solve(uint32_t iterations, double tolerance) {
    if (converged_) return true;
    if (fresh_) {
        r_.resize(nodes_.size()), z_.resize(nodes_.size()), q_.resize(nodes_.size());
        apply(x_, q_);
        load_size_ = 0.0;
        for (size_t i = 0; i < nodes_.size(); ++i) {
            // A node without bonds has nothing to pass its load on to.
            const bool free = !nodes_[i].fixed && inverse_[i][0] > 0.0;
            r_[i] = free ? Motion{loads_[i].force - q_[i].move, loads_[i].torque - q_[i].turn} : Motion{};
            if (free)
                load_size_ += glm::dot(loads_[i].force, loads_[i].force) + glm::dot(loads_[i].torque, loads_[i].torque);
        }
        precondition(r_, z_);
        p_ = z_;
        rz_ = dot(r_, z_);
        fresh_ = false;
    }
    if (load_size_ == 0.0) {
        x_.assign(nodes_.size(), Motion{});
        return converged_ = true;
    }
    // Forces are in balance, and the energy of the error is small against that of the solution: the one says little of
    // slender parts, the other little of stiff ones.
    const auto small = [&] {
        double rest = 0.0, work = 0.0;
        for (size_t i = 0; i < nodes_.size(); ++i) {
            rest += glm::dot(r_[i].move, r_[i].move);
            work += glm::dot(loads_[i].force, x_[i].move) + glm::dot(loads_[i].torque, x_[i].turn);
        }
        const double square = tolerance * tolerance;
        return rest <= square * load_size_ && rz_ <= square * work;
    };
    for (uint32_t i = 0; i < iterations; ++i) {
        if (!(rz_ > 0.0) || small()) return converged_ = true;
        apply(p_, q_);
        const double curvature = dot(p_, q_);
        if (!(curvature > 0.0)) return converged_ = true;
        const double step = rz_ / curvature;
        for (size_t n = 0; n < nodes_.size(); ++n) {
            x_[n].move += step * p_[n].move, x_[n].turn += step * p_[n].turn;
            r_[n].move -= step * q_[n].move, r_[n].turn -= step * q_[n].turn;
        }
        precondition(r_, z_);
        const double before = std::exchange(rz_, dot(r_, z_));
        const double share = rz_ / before;
        for (size_t n = 0; n < nodes_.size(); ++n) {
            p_[n].move = z_[n].move + share * p_[n].move;
            p_[n].turn = z_[n].turn + share * p_[n].turn;
        }
        ++iterations_;
    }
    return converged_ = small();
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
    const double radius = std::sqrt(area / std::numbers::pi), second = area * area / (4.0 * std::numbers::pi);
    const double pressed = glm::dot(through.force, n), twist = glm::dot(through.moment, n);
    stress.compression = std::max(pressed, 0.0) / area;
    stress.tension = std::max(-pressed, 0.0) / area;
    stress.shear = glm::length(through.force - pressed * n) / area + std::abs(twist) * radius / (2.0 * second);
    stress.bending = glm::length(through.moment - twist * n) * radius / second;
    return stress;
}

NodeLoad StressSolver::reaction(uint32_t node) const {
    NodeLoad reaction;
    if (!nodes_[node].fixed) return reaction;
    reaction = {-given_[node].force, -given_[node].torque};
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

#include "physics/bonds/bond_graph.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include <glm/geometric.hpp>

namespace brittle::physics {

namespace {

constexpr double min_blow_ratio = 0.1; // share of the strength of a piece's bonds; weaker blows leave no damage
constexpr double passed_share = 0.5;   // of a broken bond's excess impulse, to the piece behind
constexpr int max_blow_depth = 8;      // pieces in a row that a blow can pass through

// Returns the distance of a point from a bond's area, taken as a disc.
double distance_to(const BondGraph::Bond& bond, const glm::dvec3& point) {
    const glm::dvec3 arm = point - bond.centroid;
    const double height = glm::dot(arm, bond.normal);
    const double outside_disc = glm::length(arm - bond.normal * height) - std::sqrt(bond.area / std::numbers::pi);
    return std::hypot(height, std::max(outside_disc, 0.0));
}

double distance_to(const BondGraph::Bond& bond, const glm::dvec3& from, const glm::dvec3& to) {
    const glm::dvec3 path = to - from;
    const double square = glm::dot(path, path), along = glm::dot(path, bond.normal);
    const auto at = [&](double t) { return distance_to(bond, from + path * std::clamp(t, 0.0, 1.0)); };
    // Candidates: the segment's nearest point to the centre, and its intersection with the plane.
    double nearest = at(square > 0.0 ? glm::dot(bond.centroid - from, path) / square : 0.0);
    if (along != 0.0) nearest = std::min(nearest, at(glm::dot(bond.centroid - from, bond.normal) / along));
    return nearest;
}

} // namespace

BondGraph::BondGraph(const fracture::Fragments& fragments, const Material& material)
    : BondGraph(fragments, std::vector<Material>{material}) {}

BondGraph::BondGraph(const fracture::Fragments& fragments, std::vector<Material> materials)
    : materials_(std::move(materials)) {
    assert(materials_.size() == 1 || materials_.size() == fragments.bonds.size());
    for (const fracture::Piece& piece : fragments.pieces) centres_.push_back(piece.mass.centre_of_mass);
    const auto count = static_cast<uint32_t>(centres_.size());
    for (const fracture::Bond& from : fragments.bonds) {
        Bond bond{from.a, from.b, from.area, from.centroid, from.normal};
        if (materials_.size() > 1) bond.material = static_cast<uint32_t>(bonds_.size());
        const bool sound =
            from.a < count && from.b < count && from.a != from.b && from.area > 0.0 && std::isfinite(from.area);
        if (sound)
            find_strength(bond);
        else
            bond.health = 0.0;
        bonds_.push_back(bond);
    }
    list_bonds();
}

// Sets what follows from the area and from the places of both pieces.
void BondGraph::find_strength(Bond& bond) const {
    const glm::dvec3 span = centres_[bond.b] - centres_[bond.a];
    bond.lever = std::min(1.0, bond.area / std::max(glm::dot(span, span), 1e-300));
    bond.share = contact_strength_share(material_of(bond), bond.area);
}

// Lists the live bonds by piece.
void BondGraph::list_bonds() {
    first_.assign(centres_.size() + 1, 0);
    for (const Bond& bond : bonds_)
        if (bond.live()) ++first_[bond.a + 1], ++first_[bond.b + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    of_piece_.resize(first_.back());
    std::vector<uint32_t> next(first_.begin(), first_.end() - 1);
    for (uint32_t i = 0; i < bonds_.size(); ++i)
        if (bonds_[i].live()) of_piece_[next[bonds_[i].a]++] = of_piece_[next[bonds_[i].b]++] = i;
}

void BondGraph::divide(uint32_t piece, std::span<const glm::dvec3> centres, std::span<const BondShare> shares) {
    const auto first = static_cast<uint32_t>(piece_count());
    centres_.insert(centres_.end(), centres.begin(), centres.end());
    for (auto at = shares.begin(); at != shares.end();) {
        const uint32_t index = at->bond;
        const Bond whole = bonds_[index];
        for (const auto begin = at; at != shares.end() && at->bond == index; ++at) {
            Bond bond = whole;
            (whole.a == piece ? bond.a : bond.b) = first + at->part;
            bond.area = whole.area * at->share;
            bond.centroid = at->centroid;
            find_strength(bond);
            if (at == begin)
                bonds_[index] = bond;
            else
                bonds_.push_back(bond);
        }
    }
    list_bonds();
}

std::span<const uint32_t> BondGraph::bonds_of(uint32_t piece) const {
    return std::span(of_piece_).subspan(first_[piece], first_[piece + 1] - first_[piece]);
}

size_t BondGraph::live_count() const {
    return static_cast<size_t>(std::ranges::count_if(bonds_, &Bond::live));
}

void BondGraph::weaken(uint32_t bond, double share) {
    Bond& weakened = bonds_[bond];
    if (!weakened.live() || !(share > 0.0)) return;
    weakened.health = std::max(weakened.health - share, 0.0);
    if (!weakened.live()) broken_.push_back(bond);
}

void BondGraph::damage(const glm::dvec3& point, double radius, double amount, std::span<const uint8_t> inside) {
    for (uint32_t i = 0; i < bonds_.size(); ++i) {
        if (!bonds_[i].live() || !inside[bonds_[i].a]) continue;
        const double distance = distance_to(bonds_[i], point);
        if (distance < radius) weaken(i, amount * (1.0 - distance / radius));
    }
}

void BondGraph::damage_segment(const glm::dvec3& from, const glm::dvec3& to, double radius, double amount,
                               std::span<const uint8_t> inside) {
    for (uint32_t i = 0; i < bonds_.size(); ++i)
        if (bonds_[i].live() && inside[bonds_[i].a] && distance_to(bonds_[i], from, to) <= radius) weaken(i, amount);
}

double BondGraph::impulse_strength(const Bond& bond, uint32_t from, const glm::dvec3& direction) const {
    const Material& material = material_of(bond);
    const double along = glm::dot(direction, bond.normal) * (from == bond.a ? 1.0 : -1.0);
    const double across = std::sqrt(std::max(1.0 - along * along, 0.0)) * bond.lever;
    const double normal_strength = along > 0.0
                                       ? along * static_cast<double>(std::min(material.tensile, material.compressive))
                                       : along * bond.lever * static_cast<double>(material.tensile);
    return std::hypot(normal_strength, across * static_cast<double>(material.shear))
           * static_cast<double>(impact_seconds) * bond.area * bond.share;
}

// The energy of a bond's surface as a share of that of the first material.
double BondGraph::energy_share(const Bond& bond) const {
    const auto energy = [](const Material& material) { return static_cast<double>(material.fracture_energy); };
    return bond.material == 0 ? 1.0 : energy(material_of(bond)) / energy(materials_.front());
}

double BondGraph::bearing(uint32_t piece, const glm::dvec3& direction) const {
    double sum = 0.0;
    for (const uint32_t bond : bonds_of(piece))
        sum += bonds_[bond].health * impulse_strength(bonds_[bond], piece, direction);
    return sum;
}

double BondGraph::breaking_energy(uint32_t piece) const {
    double area = 0.0; // of the first material
    for (const uint32_t bond : bonds_of(piece))
        area += bonds_[bond].health * bonds_[bond].area * energy_share(bonds_[bond]);
    return area * static_cast<double>(materials_.front().fracture_energy);
}

double BondGraph::blow(uint32_t piece, const glm::dvec3& impulse, double energy, double max_passed) {
    const double size = glm::length(impulse);
    if (!(size > 0.0) || !(energy > 0.0)) return 0.0;
    const glm::dvec3 direction = impulse / size;
    double energy_left = energy;
    std::vector<std::pair<uint32_t, double>> front{{piece, size}}, next;
    for (int depth = 0; depth < max_blow_depth && !front.empty() && energy_left > 0.0; ++depth, front.swap(next)) {
        next.clear();
        for (const auto& [hit, share] : front) {
            double strength = 0.0, area = 0.0;
            for (const uint32_t bond : bonds_of(hit))
                if (bonds_[bond].live()) strength += impulse_strength(bonds_[bond], hit, direction);
            if (!(share > min_blow_ratio * strength) || strength == 0.0) continue;
            const double loss = share / strength; // of health; equal for all bonds of the piece
            for (const uint32_t bond : bonds_of(hit))
                area += std::min(loss, bonds_[bond].health) * bonds_[bond].area * energy_share(bonds_[bond]);
            const double cost = area * static_cast<double>(materials_.front().fracture_energy),
                         paid = std::min(energy_left / cost, 1.0);
            energy_left = paid < 1.0 ? 0.0 : energy_left - cost;
            for (const uint32_t bond : bonds_of(hit)) {
                if (!bonds_[bond].live()) continue;
                const double passed =
                    (loss - bonds_[bond].health) * impulse_strength(bonds_[bond], hit, direction) * passed_share;
                weaken(bond, paid * std::min(loss, bonds_[bond].health));
                if (bonds_[bond].live()) continue;
                const uint32_t behind = bonds_[bond].other(hit);
                const auto known = std::ranges::find(next, behind, &std::pair<uint32_t, double>::first);
                if (known == next.end())
                    next.emplace_back(behind, passed);
                else
                    known->second += passed;
            }
            if (energy_left == 0.0) break;
        }
        double passed_total = 0.0;
        for (const auto& [behind, share] : next) passed_total += share;
        if (depth == 0 && passed_total > max_passed)
            for (auto& [behind, share] : next) share *= max_passed / passed_total;
    }
    return energy - energy_left;
}

std::vector<uint32_t> BondGraph::take_broken() {
    return std::exchange(broken_, {});
}

std::vector<std::vector<uint32_t>> BondGraph::islands(std::span<const uint32_t> pieces) const {
    constexpr uint32_t outside = UINT32_MAX;
    std::vector<uint32_t> root(piece_count(), outside);
    for (const uint32_t piece : pieces) root[piece] = piece;
    const auto find = [&](uint32_t piece) {
        while (root[piece] != piece) piece = root[piece] = root[root[piece]];
        return piece;
    };
    for (const uint32_t piece : pieces)
        for (const uint32_t bond : bonds_of(piece)) {
            if (!bonds_[bond].live() || root[bonds_[bond].other(piece)] == outside) continue;
            const uint32_t one = find(piece), two = find(bonds_[bond].other(piece));
            root[std::max(one, two)] = std::min(one, two);
        }
    std::vector<uint32_t> sorted(pieces.begin(), pieces.end());
    std::ranges::sort(sorted);
    std::vector<std::vector<uint32_t>> parts;
    std::vector<uint32_t> part_of(piece_count(), outside);
    for (const uint32_t piece : sorted) {
        const uint32_t at = find(piece); // the lowest piece of its island comes first
        if (part_of[at] == outside) part_of[at] = static_cast<uint32_t>(parts.size()), parts.emplace_back();
        parts[part_of[at]].push_back(piece);
    }
    return parts;
}

} // namespace brittle::physics

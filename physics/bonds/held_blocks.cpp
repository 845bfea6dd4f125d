#include "physics/bonds/held_blocks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "fracture/base/random.h"
#include "fracture/base/union_find.h"
#include "fracture/fracture.h"
#include "fracture/mesh/thickness.h"

namespace brittle::physics {

namespace {

constexpr uint32_t surface_samples = 2048;
constexpr uint64_t sample_seed = 1; // of the surface samples, the only random numbers
// Lower bound of the thickness, as a share of the bounding box's diagonal: keeps rims from being cut into crumbs.
constexpr double min_thickness = 0.01;
constexpr double max_gap = 0.5;           // thicknesses between sites
constexpr double tolerance = 1e-3;        // of the stresses
constexpr uint32_t max_iterations = 2000; // of one solution; far more than hundreds of blocks need
// Contacts with at least this share of the worst load ratio break together: fewer rounds, nearly the same cracks.
constexpr double simultaneous_ratio = 0.8;

struct MidPoint { // halfway through the solid from a surface point
    glm::dvec3 position;
    double thickness;
};

// Starts from points that are spread evenly over the surface.
std::vector<MidPoint> mid_points(const fracture::TriangleMesh& mesh) {
    const fracture::Thickness through(mesh);
    const double least = min_thickness * glm::length(fracture::bounds(mesh).size());
    std::vector<double> area; // running sum
    double sum = 0.0;
    for (const fracture::Triangle& t : mesh.triangles) {
        const glm::dvec3& p = mesh.positions[t.x];
        sum += glm::length(glm::cross(mesh.positions[t.y] - p, mesh.positions[t.z] - p));
        area.push_back(sum);
    }
    std::vector<MidPoint> found;
    if (!(sum > 0.0) || !std::isfinite(sum)) return found;
    fracture::Random random(sample_seed);
    for (uint32_t k = 0; k < surface_samples; ++k) {
        const double sample_area = (k + random.uniform()) / surface_samples * sum;
        const auto t = static_cast<uint32_t>(std::min<ptrdiff_t>(
            std::ranges::upper_bound(area, sample_area) - area.begin(), static_cast<ptrdiff_t>(area.size()) - 1));
        double u = random.uniform(), v = random.uniform();
        if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
        const fracture::Triangle& c = mesh.triangles[t];
        const glm::dvec3& p = mesh.positions[c.x];
        const glm::dvec3 on = p + u * (mesh.positions[c.y] - p) + v * (mesh.positions[c.z] - p);
        if (const std::optional<double> thick = through.at(t, on))
            found.push_back({on + 0.5 * *thick * through.inward(t), std::max(*thick, least)});
    }
    return found;
}

void set_min_area(HeldBlocks& blocks) {
    blocks.min_area = std::numeric_limits<double>::infinity();
    for (const StressBond& bond : blocks.bonds) blocks.min_area = std::min(blocks.min_area, bond.area);
}

// Blocks under load, whose overloaded contacts break. Islands without a fixed block fall and carry no load.
class LoadedBlocks {
  public:
    LoadedBlocks(const HeldBlocks& blocks, const Material& material)
        : blocks_(blocks), material_(material), solver_(blocks.nodes, blocks.bonds), live_(blocks.bonds.size(), 1),
          loads_(blocks.nodes.size()) {
        find_islands();
    }

    void add_weight(const glm::dvec3& gravity) {
        for (size_t i = 0; i < loads_.size(); ++i) loads_[i].force += blocks_.nodes[i].mass * gravity;
    }
    void add_load(uint32_t node, const PointLoad& load) {
        loads_[node].force += load.force;
        loads_[node].torque += glm::cross(load.point - blocks_.nodes[node].centre, load.force);
    }
    [[nodiscard]] uint32_t nearest(const glm::dvec3& point) const {
        uint32_t best = 0;
        double least = std::numeric_limits<double>::infinity();
        for (uint32_t i = 0; i < blocks_.nodes.size(); ++i)
            if (const double d = glm::distance(point, blocks_.nodes[i].centre); d < least) least = d, best = i;
        return best;
    }

    // Breaks the most loaded contacts among those with a load ratio above limit; returns false if there are none.
    bool break_worst(double limit) {
        for (size_t i = 0; i < loads_.size(); ++i) solver_loads_[i] = island_held_[island_[i]] ? loads_[i] : NodeLoad{};
        solver_.set_loads(solver_loads_);
        solver_.solve(max_iterations, tolerance);
        std::vector<double> ratios(live_.size(), 0.0);
        double worst = 0.0;
        for (uint32_t bond = 0; bond < live_.size(); ++bond) {
            if (!live_[bond] || !island_held_[island_[blocks_.bonds[bond].a]]) continue;
            ratios[bond] = load_ratio(solver_.stress(bond), material_);
            worst = std::max(worst, ratios[bond]);
        }
        if (!(worst > limit)) return false;
        std::vector<uint32_t> broken;
        for (uint32_t bond = 0; bond < live_.size(); ++bond)
            if (ratios[bond] > limit && ratios[bond] >= simultaneous_ratio * worst) broken.push_back(bond);
        for (const uint32_t bond : broken) live_[bond] = 0;
        solver_.remove_bonds(broken);
        find_islands();
        return true;
    }

    [[nodiscard]] bool is_held(uint32_t node) const { return island_held_[island_[node]] != 0; }
    [[nodiscard]] const std::vector<uint32_t>& islands() const { return island_; }

  private:
    void find_islands() {
        const auto count = static_cast<uint32_t>(blocks_.nodes.size());
        std::vector<uint32_t> parent(count);
        std::iota(parent.begin(), parent.end(), 0u);
        for (uint32_t bond = 0; bond < live_.size(); ++bond)
            if (live_[bond]) fracture::unite(parent, blocks_.bonds[bond].a, blocks_.bonds[bond].b);
        island_.assign(count, 0);
        island_held_.clear();
        for (uint32_t i = 0; i < count; ++i) {
            const uint32_t root = fracture::root_of(parent, i);
            if (root == i) {
                island_[i] = static_cast<uint32_t>(island_held_.size());
                island_held_.push_back(0);
            }
            island_[i] = island_[root];
            island_held_[island_[i]] |= blocks_.nodes[i].fixed ? 1 : 0;
        }
        solver_loads_.resize(count);
    }

    const HeldBlocks& blocks_;
    const Material& material_;
    StressSolver solver_;
    std::vector<uint8_t> live_; // by bond
    std::vector<NodeLoad> loads_, solver_loads_;
    std::vector<uint32_t> island_;     // by node
    std::vector<uint8_t> island_held_; // by island
};

} // namespace

std::vector<glm::dvec3> block_sites(const fracture::TriangleMesh& mesh, uint32_t max_sites) {
    const std::vector<MidPoint> candidates = mid_points(mesh);
    if (candidates.empty()) return {};
    std::vector<double> gap(candidates.size(), std::numeric_limits<double>::infinity()); // squared, in thicknesses
    std::vector<glm::dvec3> sites;
    auto next =
        static_cast<size_t>(std::ranges::min_element(candidates, {}, &MidPoint::thickness) - candidates.begin());
    while (sites.size() < max_sites && gap[next] > max_gap * max_gap) {
        sites.push_back(candidates[next].position);
        for (size_t i = 0; i < candidates.size(); ++i) {
            const glm::dvec3 apart = (candidates[i].position - sites.back()) / candidates[i].thickness;
            gap[i] = std::min(gap[i], glm::dot(apart, apart));
        }
        next = static_cast<size_t>(std::ranges::max_element(gap) - gap.begin());
    }
    return sites;
}

std::shared_ptr<const HeldBlocks>
held_blocks(const fracture::TriangleMesh& mesh, float density, const HeldBlockSettings& settings,
            const std::function<bool(const fracture::Fragments&, const fracture::Piece&)>& held, uint32_t threads,
            const std::function<bool()>& cancelled) {
    auto blocks = std::make_shared<HeldBlocks>();
    blocks->sites = block_sites(mesh, std::max(settings.max_blocks, 2u));
    if (blocks->sites.empty()) return nullptr;
    const fracture::Result<fracture::Fragments> cut =
        fracture::fracture(mesh, blocks->sites, {.threads = threads, .cancelled = cancelled});
    if (!cut) return nullptr;
    for (const fracture::Piece& piece : cut->pieces) {
        blocks->nodes.push_back({piece.mass.centre_of_mass, piece.mass.volume * static_cast<double>(density),
                                 piece.mass.inertia * static_cast<double>(density), held(*cut, piece)});
        blocks->cells.push_back(piece.site);
    }
    for (const fracture::Bond& bond : cut->bonds)
        blocks->bonds.push_back({bond.a, bond.b, bond.area, bond.centroid, bond.normal});
    for (const StressNode& node : blocks->nodes) blocks->first_masses.push_back(node.mass);
    for (const StressBond& bond : blocks->bonds) blocks->first_areas.push_back(bond.area);
    set_min_area(*blocks);
    return blocks;
}

namespace {

glm::dmat3 about_offset(double mass, const glm::dvec3& offset) {
    return mass * (glm::dot(offset, offset) * glm::dmat3(1.0) - glm::outerProduct(offset, offset));
}

// Takes a part out of a node (the theorem of Huygens and Steiner).
void take_out(StressNode& node, double mass, const glm::dvec3& centre, const glm::dmat3& inertia) {
    const double left = node.mass - mass;
    const glm::dvec3 moved = (mass / left) * (node.centre - centre); // of the node's centre
    node.inertia += about_offset(node.mass, moved) - inertia - about_offset(mass, centre - node.centre - moved);
    node.centre += moved;
    node.mass = left;
}

// Takes a part out of a contact.
void take_out(StressBond& bond, double area, const glm::dvec3& centroid) {
    const double left = bond.area - area;
    bond.centroid += (area / left) * (bond.centroid - centroid);
    bond.area = left;
}

} // namespace

std::shared_ptr<const HeldBlocks> blocks_without(const HeldBlocks& blocks, const fracture::TriangleMesh& lost,
                                                 float density, uint32_t threads) {
    constexpr double min_mass_share = 0.5, min_area_share = 0.5; // shares of the first ones
    constexpr double negligible_area = 1e-3;                     // of the smallest contact
    const fracture::Result<fracture::Fragments> cut = fracture::fracture(lost, blocks.sites, {.threads = threads});
    if (!cut) return nullptr;
    auto left = std::make_shared<HeldBlocks>(blocks);
    // Of the blocks of one cell, a piece is part of the nearest.
    const auto node_of = [&](const fracture::Piece& piece) {
        std::optional<uint32_t> nearest;
        double least = std::numeric_limits<double>::infinity();
        for (uint32_t node = 0; node < blocks.nodes.size(); ++node) {
            const double distance = glm::distance(blocks.nodes[node].centre, piece.mass.centre_of_mass);
            if (blocks.cells[node] == piece.site && distance < least) least = distance, nearest = node;
        }
        return nearest;
    };
    std::vector<uint32_t> nodes; // by piece
    for (const fracture::Piece& piece : cut->pieces) {
        const std::optional<uint32_t> found = node_of(piece);
        if (!found) return nullptr;
        const uint32_t node = nodes.emplace_back(*found);
        const double mass = piece.mass.volume * static_cast<double>(density);
        if (!(left->nodes[node].mass - mass > min_mass_share * blocks.first_masses[node])) return nullptr;
        take_out(left->nodes[node], mass, piece.mass.centre_of_mass, piece.mass.inertia * static_cast<double>(density));
    }
    for (const fracture::Bond& contact : cut->bonds) {
        const uint32_t a = nodes[contact.a], b = nodes[contact.b];
        if (a == b || contact.area < negligible_area * blocks.min_area) continue;
        const auto bond = std::ranges::find_if(left->bonds, [&](const StressBond& other) {
            return (other.a == a && other.b == b) || (other.a == b && other.b == a);
        });
        if (bond == left->bonds.end()) return nullptr;
        const double first = blocks.first_areas[static_cast<size_t>(bond - left->bonds.begin())];
        if (!(bond->area - contact.area > min_area_share * first)) return nullptr;
        take_out(*bond, contact.area, contact.centroid);
    }
    set_min_area(*left);
    return left;
}

std::vector<uint32_t> islands_under_load(const HeldBlocks& blocks, const Material& material, float strength_scale,
                                         const glm::dvec3& gravity, std::span<const PointLoad> contact_loads) {
    const Material reduced = scale_strength(material, strength_scale);
    LoadedBlocks loaded(blocks, reduced);
    loaded.add_weight(gravity);
    for (const PointLoad& load : contact_loads) loaded.add_load(loaded.nearest(load.point), load);
    while (loaded.break_worst(1.0)) {
    }
    return loaded.islands();
}

std::vector<uint32_t> islands_after_blow(const HeldBlocks& blocks, const Material& material, float strength_scale,
                                         const glm::dvec3& gravity, const PointLoad& impulse, double energy) {
    const Material reduced = scale_strength(material, strength_scale);
    // The section that breaks depends on where stresses are largest, not on their size: hence the limit 0.
    LoadedBlocks blown(blocks, reduced);
    const uint32_t hit = blown.nearest(impulse.point);
    blown.add_load(hit, impulse);
    while (blown.is_held(hit) && blown.break_worst(0.0)) {
    }
    const std::vector<uint32_t>& islands = blown.islands();
    double area = 0.0, mass = 0.0;
    for (const StressBond& bond : blocks.bonds)
        if ((islands[bond.a] == islands[hit]) != (islands[bond.b] == islands[hit])) area += bond.area;
    for (size_t i = 0; i < islands.size(); ++i)
        if (islands[i] == islands[hit]) mass += blocks.nodes[i].mass;
    const double kinetic = std::min(0.5 * glm::dot(impulse.force, impulse.force) / mass, energy);
    const bool breaks = !blown.is_held(hit) && kinetic > area * static_cast<double>(material.fracture_energy);
    std::vector<uint32_t> whole(islands.size(), 0);
    if (!breaks) return whole;
    // Breaks the section, then all contacts that are overloaded without it.
    HeldBlocks left = blocks;
    std::erase_if(left.bonds, [&](const StressBond& bond) {
        return (islands[bond.a] == islands[hit]) != (islands[bond.b] == islands[hit]);
    });
    return islands_under_load(left, material, strength_scale, gravity, {});
}

} // namespace brittle::physics

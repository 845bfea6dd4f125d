#include "fracture/mesh/islands.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include <glm/geometric.hpp>

#include "fracture/mesh/topology.h"

namespace brittle::fracture {

namespace {

// The volume, in units of area times largest coordinate, below which an island is not a solid: rounding a coordinate
// moves a point by up to 2^-53 of it, and points of a cut by a few times as much. For example, a plate with a width and
// coordinates of one metre is dropped below a thickness of 2e-15 m.
constexpr double flat_island = 1e-15;
// The same for negative volumes. Crumbs of degenerate cuts have them down to this bound.
constexpr double inverted_by_rounding = 0x40.0p-53;

// The sine of the angle within which a point is on a triangle. From a point on it, a triangle covers half of the
// sphere; within this angle of its plane the sign of that half is noise.
constexpr double on_triangle = 1e-9;

Island gather(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles,
              std::span<const FaceSource> sources, std::span<const uint32_t> members,
              std::vector<uint32_t>& local /* per vertex, no_index on entry and on return */) {
    Island island;
    for (const bool interior : {false, true}) {
        for (const uint32_t index : members) {
            if (sources[index].interior != interior) continue;
            Triangle t = triangles[index];
            for (int i = 0; i < 3; ++i) {
                uint32_t& vertex = local[t[i]];
                if (vertex == no_index) {
                    vertex = static_cast<uint32_t>(island.positions.size());
                    island.positions.push_back(positions[t[i]]);
                }
                t[i] = vertex;
            }
            island.triangles.push_back(t);
            island.sources.push_back(sources[index]);
        }
        if (!interior) island.exterior_triangles = static_cast<uint32_t>(island.triangles.size());
    }
    for (const uint32_t index : members)
        for (int i = 0; i < 3; ++i) local[triangles[index][i]] = no_index;
    island.mass = mass_properties(island.positions, island.triangles);
    return island;
}

void append(Island& island, const Island& cavity) {
    const auto offset = static_cast<uint32_t>(island.positions.size());
    island.positions.insert(island.positions.end(), cavity.positions.begin(), cavity.positions.end());
    const auto insert = [&](size_t at, size_t begin, size_t end) {
        std::vector<Triangle> moved(cavity.triangles.begin() + static_cast<std::ptrdiff_t>(begin),
                                    cavity.triangles.begin() + static_cast<std::ptrdiff_t>(end));
        for (Triangle& t : moved) t += offset;
        island.triangles.insert(island.triangles.begin() + static_cast<std::ptrdiff_t>(at), moved.begin(), moved.end());
        island.sources.insert(island.sources.begin() + static_cast<std::ptrdiff_t>(at),
                              cavity.sources.begin() + static_cast<std::ptrdiff_t>(begin),
                              cavity.sources.begin() + static_cast<std::ptrdiff_t>(end));
    };
    insert(island.triangles.size(), cavity.exterior_triangles, cavity.triangles.size());
    insert(island.exterior_triangles, 0, cavity.exterior_triangles);
    island.exterior_triangles += cavity.exterior_triangles;
    island.mass = mass_properties(island.positions, island.triangles);
}

struct Winding {
    double number = 0.0;
    bool on_surface = false; // `number` is then meaningless
};

Winding wind(const glm::dvec3& point, std::span<const glm::dvec3> positions, std::span<const Triangle> triangles) {
    Winding winding;
    double solid_angle = 0.0;
    for (const Triangle& t : triangles) {
        const glm::dvec3 a = positions[t.x] - point;
        const glm::dvec3 b = positions[t.y] - point;
        const glm::dvec3 c = positions[t.z] - point;
        const double la = glm::length(a);
        const double lb = glm::length(b);
        const double lc = glm::length(c);
        const double volume = glm::dot(a, glm::cross(b, c));
        const double cosine = la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb;
        winding.on_surface =
            winding.on_surface
            || (cosine <= on_triangle * la * lb * lc && std::abs(volume) <= on_triangle * la * lb * lc);
        solid_angle += 2.0 * std::atan2(volume, cosine);
    }
    winding.number = solid_angle / (4.0 * std::numbers::pi);
    return winding;
}

// Returns the index of the smallest island around the cavity, or islands.size().
size_t owner_of(const Island& cavity, std::span<const Island> islands) {
    size_t owner = islands.size();
    for (size_t i = 0; i < islands.size(); ++i) {
        const Island& candidate = islands[i];
        if (candidate.mass.volume <= -cavity.mass.volume) continue;
        if (owner != islands.size() && candidate.mass.volume >= islands[owner].mass.volume) continue;
        if (encloses(candidate.positions, candidate.triangles, cavity.positions, cavity.triangles)) owner = i;
    }
    return owner;
}

} // namespace

double winding_number(const glm::dvec3& point, std::span<const glm::dvec3> positions,
                      std::span<const Triangle> triangles) {
    return wind(point, positions, triangles).number;
}

bool encloses(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles,
              std::span<const glm::dvec3> shell_positions, std::span<const Triangle> shell) {
    double sum = 0.0;
    for (const Triangle& t : shell) {
        const glm::dvec3 middle = (shell_positions[t.x] + shell_positions[t.y] + shell_positions[t.z]) / 3.0;
        const Winding winding = wind(middle, positions, triangles);
        if (!winding.on_surface) return winding.number > 0.5;
        sum += winding.number;
    }
    return sum > 0.5 * static_cast<double>(shell.size()); // every triangle of the shell touches the mesh
}

bool is_flat(const MassProperties& mass, std::span<const glm::dvec3> positions, std::span<const Triangle> triangles,
             double extent) {
    for (const glm::dvec3& p : positions) extent = std::max({extent, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    const double share = mass.volume < 0.0 ? inverted_by_rounding : flat_island;
    return std::abs(mass.volume) <= share * mass.area * extent + volume_error_bound(positions, triangles);
}

std::vector<Island> split_islands(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles,
                                  std::span<const FaceSource> sources, double extent) {
    const std::vector<uint32_t> component = triangle_components(positions.size(), triangles);
    std::vector<std::vector<uint32_t>> members; // per component: its triangles
    for (uint32_t i = 0; i < triangles.size(); ++i) {
        if (component[i] >= members.size()) members.resize(component[i] + 1);
        members[component[i]].push_back(i);
    }

    std::vector<Island> islands;
    std::vector<Island> cavities;
    std::vector<uint32_t> local(positions.size(), no_index);
    for (const std::vector<uint32_t>& shell : members) {
        Island island = gather(positions, triangles, sources, shell, local);
        const bool is_cut = island.exterior_triangles < island.triangles.size();
        if (is_flat(island.mass, island.positions, island.triangles, is_cut ? extent : 0.0)) continue;
        (island.mass.volume < 0.0 ? cavities : islands).push_back(std::move(island));
    }
    // Find all owners before moving any cavity, so that the tested islands are solid.
    std::vector<size_t> owners;
    for (const Island& cavity : cavities) owners.push_back(owner_of(cavity, islands));
    const size_t solid = islands.size();
    for (size_t i = 0; i < cavities.size(); ++i) {
        if (owners[i] < solid)
            append(islands[owners[i]], cavities[i]);
        else
            islands.push_back(std::move(cavities[i]));
    }
    return islands;
}

} // namespace brittle::fracture

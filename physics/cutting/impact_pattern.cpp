#include "physics/cutting/impact_pattern.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <numeric>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "fracture/base/random.h"
#include "fracture/local/cluster_queries.h"
#include "fracture/mesh/inside.h"
#include "fracture/mesh/principal_axes.h"
#include "fracture/sites/layout.h"

namespace brittle::physics {

namespace {

using fracture::AxisFrame;
using fracture::PatternKind;
using fracture::Random;

constexpr double pi = std::numbers::pi;
constexpr double pieces_per_size = 24.0; // n = pieces_per_size sqrt(A) / L
constexpr uint32_t min_pieces = 4;
constexpr double half_ball = 2.0 / 3.0 * pi;
// Surface between n cubes that fill a half ball of radius R, by R^2 n^(1/3): 3 V^(2/3) with V = half_ball R^3.
const double surface_per_radius = 3.0 * std::pow(half_ball, 2.0 / 3.0);
// Numbers of sites of the shell around the damage, and of the rest beyond it. The cells of the rest are its collision
// hulls, so they must not be larger than the solid's features.
constexpr uint32_t shell_sites = 16, outer_sites = 12;
constexpr uint32_t shell_around = 5; // sites around a layer of splinters
// Distance between the layers of splinters, and width of the random range of a site's height in its layer: shares of
// the length of the damage by the number of layers.
constexpr double layer_spacing = 1.6, lift_jitter = 0.1;
// Radius of the shell by that of the damage, chosen so that the bisectors between the outermost pieces and the shell
// are near the rim of the damage.
constexpr double shell_ratio = 1.35;
constexpr double inner_ratio = 0.75; // largest distance of the pieces' sites by the radius of the damage
// Stars of glass. Spread of the angles between rays, as a share of their mean; growth of the distance of concentric
// cracks; farthest of them by the mean distance of the edges; shares of concentric cracks and of rays that are left
// out, and of shards that stay at the rim of a hole.
constexpr double ray_jitter = 0.6, ring_growth = 1.9, ring_reach = 0.5;
constexpr double missing_rings = 0.3, missing_rays = 0.25, rim_shards = 0.4;
constexpr uint32_t min_rays = 3, max_rays = 16, min_edge_rays = 3;

bool finite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

glm::dvec3 direction(Random& random) {
    const double z = 2.0 * random.uniform() - 1.0, angle = 2.0 * pi * random.uniform();
    const double r = std::sqrt(1.0 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
}

// A random point of the unit half ball about +along; power 1/3 fills it evenly, larger powers crowd its centre.
glm::dvec3 in_half_ball(Random& random, const glm::dvec3& along, double power) {
    glm::dvec3 d = direction(random);
    if (glm::dot(d, along) < 0.0) d = -d;
    return d * std::pow(random.uniform(), power);
}

// What the layout of sites asks about a solid.
class Shape {
  public:
    explicit Shape(const fracture::TriangleMesh& mesh) : mesh_(&mesh) {}
    explicit Shape(const fracture::ClusterMesh& clusters) : clusters_(&clusters) {}

    [[nodiscard]] fracture::Box box() const { return clusters_ ? clusters_->box() : fracture::bounds(*mesh_); }
    // The largest coordinate along a direction, seen from a point; at least 0.
    [[nodiscard]] double farthest_along(const glm::dvec3& from, const glm::dvec3& direction) const {
        if (clusters_) return std::max(0.0, fracture::farthest_along(*clusters_, from, direction));
        double farthest = 0.0;
        for (const glm::dvec3& p : mesh_->positions) farthest = std::max(farthest, glm::dot(p - from, direction));
        return farthest;
    }
    // The radius, or the distance of the vertex that is farthest from the point, whichever is less.
    [[nodiscard]] double within(double radius, const glm::dvec3& point) const {
        const glm::dvec3 size = box().size(); // a vertex lies on each side of the box
        if (radius <= 0.5 * std::max({size.x, size.y, size.z})) return radius;
        if (clusters_) return std::min(radius, fracture::farthest_from(*clusters_, point));
        double farthest = 0.0;
        for (const glm::dvec3& p : mesh_->positions) farthest = std::max(farthest, glm::distance(p, point));
        return std::min(radius, farthest);
    }
    // Vertices all over the surface: of some clusters, or all.
    [[nodiscard]] std::vector<glm::dvec3> spread_vertices() const {
        constexpr uint32_t enough = 4096;
        if (!clusters_) return mesh_->positions;
        std::vector<glm::dvec3> some;
        clusters_->visit_some(enough,
                              [&](const fracture::ClusterPtr& cluster) { some.push_back(cluster->positions[0]); });
        return some;
    }
    [[nodiscard]] std::function<bool(const glm::dvec3&)> inside_test() const {
        if (clusters_) return [this](const glm::dvec3& point) { return fracture::is_inside(*clusters_, point); };
        return [test = std::make_shared<const fracture::InsideTest>(*mesh_)](const glm::dvec3& point) {
            return (*test)(point);
        };
    }

  private:
    // The other one is null.
    const fracture::TriangleMesh* mesh_ = nullptr;
    const fracture::ClusterMesh* clusters_ = nullptr;
};

class Maker {
  public:
    Maker(const Shape& solid, const Blow& blow, const Damage& damage, const ImpactPattern& pattern)
        : solid_(solid), blow_(blow), damage_(damage), pattern_(pattern), random_(pattern.seed),
          depth_(solid.farthest_along(blow.point, blow.normal)) {
        reach_ = inner_ratio * solid_.within(damage_.radius, blow_.point);
    }

    ImpactSites run(const fracture::MassProperties& mass) {
        bool ended = false; // the kind has placed its own sites of the rest around the damage
        bool whole = false; // nothing is left of the solid
        switch (pattern_.kind) {
        case PatternKind::radial:
            ended = reach_ >= depth_ && damage_.pieces >= min_rays;
            if (ended)
                whole = star();
            else
                radial();
            break;
        case PatternKind::splinters:
            splinters(longest_axis(mass));
            ended = true;
            break;
        case PatternKind::clustered:
        case PatternKind::thickness:
            crowd(damage_.pieces, 1.0);
            break;
        case PatternKind::bricks:
            ended = result_.bricks = bricks();
            if (ended) break;
            [[fallthrough]];
        default:
            crowd(damage_.pieces / 2, 1.0);
            crowd(damage_.pieces - damage_.pieces / 2, 1.0 / 3.0);
        }
        if (!ended) shell();
        if (!whole) rest();
        return finished();
    }

    ImpactSites from_diagram() {
        fracture::Box from{glm::dvec3(std::numeric_limits<double>::infinity()),
                           glm::dvec3(-std::numeric_limits<double>::infinity())};
        for (const glm::dvec3& site : pattern_.diagram) {
            from.min = glm::min(from.min, site);
            from.max = glm::max(from.max, site);
        }
        fracture::Placement placement = pattern_.placement;
        placement.turn.y += 360.0 * random_.uniform();
        result_.sites = fracture::place(pattern_.diagram, from, solid_.box(), placement);
        for (const glm::dvec3& site : result_.sites)
            result_.groups.push_back(glm::distance(site, blow_.point) <= damage_.radius ? result_.rest++ : stays);
        return finished();
    }

  private:
    static constexpr uint32_t stays = UINT32_MAX; // stands for the rest's group until all pieces are counted

    ImpactSites finished() {
        std::ranges::replace(result_.groups, stays, result_.rest);
        return std::move(result_);
    }

    void add(const glm::dvec3& site, uint32_t group) {
        result_.sites.push_back(site);
        result_.groups.push_back(group);
    }
    void add_piece(const glm::dvec3& site) { add(site, result_.rest++); }
    void add_rest(const glm::dvec3& site) { add(site, stays); }

    // In a solid thinner than the damage is deep, the half ball is flattened to the solid's depth.
    void crowd(uint32_t count, double power) {
        const double flatter = 1.0 - std::min(1.0, depth_ / reach_);
        for (uint32_t i = 0; i < count; ++i) {
            const glm::dvec3 at = in_half_ball(random_, blow_.normal, power);
            add_piece(blow_.point + reach_ * (at - flatter * glm::dot(at, blow_.normal) * blow_.normal));
        }
    }

    // The cracks of a plate that the blow goes through: rays from the contact, and concentric cracks between them.
    // - Layers of sites on common rays: the bisectors of two rays' sites all lie in one plane through the contact, a
    //   straight crack. Those between two layers are the concentric cracks, straight across each sector.
    // - The outermost layer has no end, so its rays reach the edges of the solid, or a crack of an earlier blow, which
    //   is an edge of the solid that is left. Only as many do as the energy pays for; the shards between two others
    //   are one.
    // - Where it pays for fewer than min_edge_rays, the outermost layer is the rest, a plate with a hole. Some shards
    //   of the last ring stay with it, so that the hole's rim has sharp points.
    // Returns whether the rays reach the edges.
    bool star() {
        const auto wanted = static_cast<uint32_t>(std::round(std::sqrt(3.0 * damage_.pieces)));
        const uint32_t rays = std::clamp(wanted, min_rays, std::clamp(damage_.pieces / 2, min_rays, max_rays));
        uint32_t layers = std::max(1u, damage_.pieces / rays);
        const AxisFrame frame = fracture::axis_frame(blow_.normal);
        std::vector<glm::dvec3> ways; // of the rays' sites
        const double turn = random_.uniform();
        double edge = 0.0; // mean distance of the edges, at most
        for (uint32_t k = 0; k < rays; ++k) {
            const double angle = 2.0 * pi * (k + turn + ray_jitter * (random_.uniform() - 0.5)) / rays;
            ways.push_back(std::cos(angle) * frame.u + std::sin(angle) * frame.v);
            edge += solid_.farthest_along(blow_.point, ways.back()) / rays;
        }
        // Distances of the concentric cracks: last_ring, last_ring / ring_growth, ...
        const double last_ring = std::min(inner_ratio * damage_.radius, ring_reach * edge);
        double inner_length = rays * last_ring, first_ring = last_ring;
        for (uint32_t layer = 1; layer < layers; ++layer) {
            inner_length += 2.0 * pi * first_ring;
            if (layer + 1 < layers) first_ring /= ring_growth;
        }
        const double surface = surface_per_radius * damage_.radius * damage_.radius * std::cbrt(damage_.pieces);
        const double paid = (surface / depth_ - inner_length) / std::max(edge - last_ring, 1e-3 * edge);
        const auto edge_rays =
            static_cast<uint32_t>(std::clamp(paid, 0.0, std::ceil(rays * (1.0 - missing_rays * random_.uniform()))));
        const bool hole = damage_.local || edge_rays < min_edge_rays;
        if (hole && layers++ > 1) first_ring /= ring_growth; // the rest begins beyond last_ring

        std::vector<uint32_t> group(layers * rays); // by layer and ray: a cell of the same piece
        std::iota(group.begin(), group.end(), 0u);
        const uint32_t last = layers - 1;
        const auto join = [&](uint32_t one, uint32_t other) {
            const uint32_t from = std::max(group[one], group[other]), to = std::min(group[one], group[other]);
            std::ranges::replace(group, from, to);
        };
        for (uint32_t layer = 2; layer < layers - (hole ? 1u : 0u); ++layer) // the contact is free
            for (uint32_t k = 0; k < rays; ++k)
                if (random_.uniform() < missing_rings) join((layer - 1) * rays + k, layer * rays + k);
        if (hole) {
            for (uint32_t k = 1; k < rays; ++k) join(last * rays, last * rays + k);
            for (uint32_t k = 0; k < rays; ++k)
                if (layers > 2 && random_.uniform() < rim_shards) join(last * rays, (last - 1) * rays + k);
        } else {
            std::vector<uint32_t> candidates(rays);
            std::iota(candidates.begin(), candidates.end(), 0u);
            for (uint32_t k = rays; k > edge_rays; --k) {
                const auto at = candidates.begin() + static_cast<ptrdiff_t>(random_.uniform() * k);
                join(last * rays + *at, last * rays + (*at + 1) % rays);
                candidates.erase(at);
            }
        }
        const uint32_t outside = hole ? group[last * rays] : stays;
        std::vector<uint32_t> number(group.size(), stays); // of the piece
        double distance = 2.0 * first_ring / (1.0 + ring_growth);
        for (uint32_t layer = 0; layer < layers; ++layer, distance *= ring_growth)
            for (uint32_t k = 0; k < rays; ++k) {
                const uint32_t own = group[layer * rays + k];
                if (own != outside && number[own] == stays) number[own] = result_.rest++;
                add(blow_.point + distance * ways[k], number[own]);
            }
        return !hole;
    }

    // Rings and rays of shards in a solid that the blow does not go through.
    void radial() {
        const fracture::RadialLayout layout{.count = damage_.pieces,
                                            .exact = true,
                                            .reach = reach_,
                                            .ring_exponent = 1.4,
                                            .ring_turn = 1.0,
                                            .angle_jitter = 0.5,
                                            .ring_jitter = 0.4};
        const AxisFrame frame = fracture::axis_frame(blow_.normal);
        for (const glm::dvec3& site : fracture::radial_sites(layout, blow_.point, frame, random_)) add_piece(site);
    }

    // An odd number of layers across the grain, the middle one at the contact. The shell has sites around each layer,
    // level with it: shell sites at other heights would be nearer to the region between two layers than the layers' own
    // sites, and the rest would keep that region, above all at the contact.
    void splinters(const glm::dvec3& grain) {
        const AxisFrame frame = fracture::axis_frame(grain);
        const double stretch = std::cbrt(pattern_.slenderness); // stretches the damage at constant volume
        const double length = reach_ * stretch * stretch, width = reach_ / stretch;
        // With n / k pieces in each of k layers, the slenderness is 0.9 sqrt(n) / k^1.5 of the one given, so
        // k = (0.81 n)^(1/3).
        const uint32_t layers = 2 * (static_cast<uint32_t>(std::cbrt(0.81 * damage_.pieces)) / 2) + 1;
        const double spacing = layer_spacing * length / layers;
        fracture::SplinterLayers stack{blow_.point, frame.along, {}};
        for (uint32_t layer = 0; layer < layers; ++layer)
            stack.heights.push_back((layer - 0.5 * (layers - 1.0)) * spacing);
        const auto across = [&](double r, double angle) {
            return r * (std::cos(angle) * frame.u + std::sin(angle) * frame.v);
        };
        for (uint32_t i = 0; i < damage_.pieces; ++i) {
            const double lift = lift_jitter * (random_.uniform() - 0.5) * length / layers;
            const double angle = 2.0 * pi * random_.uniform();
            add_piece(stack.on_axis(stack.layer_of(i), lift) + across(width * std::sqrt(random_.uniform()), angle));
        }
        const double beside = shell_ratio * damage_.radius / stretch;
        for (uint32_t layer = 0; layer < layers; ++layer) {
            const double turn = random_.uniform();
            for (uint32_t k = 0; k < shell_around; ++k)
                add_rest(stack.on_axis(layer) + across(beside, 2.0 * pi * (k + turn) / shell_around));
        }
        for (const double end : {-0.5 * (layers + 1.0), 0.5 * (layers + 1.0)})
            add_rest(blow_.point + end * spacing * frame.along);
    }

    // The halves next to the bricks belong to the rest; without their sites, sites farther off would give the bricks
    // other faces.
    bool bricks() {
        const auto inside = solid_.inside_test();
        const BricksTaken taken =
            bricks_near(pattern_.bond, solid_.box(), blow_.point, damage_.radius, damage_.pieces, inside);
        for (const auto& halves : taken.bricks) {
            for (const glm::dvec3& site : halves) add(site, result_.rest);
            ++result_.rest;
        }
        clear_ = taken.diagonal;
        for (const glm::dvec3& site : taken.beside) add_rest(site);
        return !taken.bricks.empty();
    }

    // Sites of the rest, evenly on a sphere around the contact (a golden-angle spiral).
    void shell() {
        const double golden = pi * (3.0 - std::sqrt(5.0)), turn = 2.0 * pi * random_.uniform();
        for (uint32_t i = 0; i < shell_sites; ++i) {
            const double z = 1.0 - (2.0 * i + 1.0) / shell_sites, r = std::sqrt(1.0 - z * z);
            const glm::dvec3 on(r * std::cos(golden * i + turn), r * std::sin(golden * i + turn), z);
            add_rest(blow_.point + shell_ratio * damage_.radius * on);
        }
    }

    // Sites of the rest outside the shell, far from it and from each other.
    void rest() {
        std::vector<glm::dvec3> far;
        const double beyond = 2.0 * shell_ratio * damage_.radius;
        const std::vector<glm::dvec3> near(result_.sites);
        const auto clear = [&](const glm::dvec3& p) { // certain beyond this distance from the damage
            return glm::distance(p, blow_.point) > beyond + 2.0 * clear_
                   || std::ranges::all_of(near,
                                          [&](const glm::dvec3& site) { return glm::distance(p, site) >= clear_; });
        };
        for (const glm::dvec3& p : solid_.spread_vertices())
            if (glm::distance(p, blow_.point) > beyond && clear(p)) far.push_back(p);
        for (const glm::dvec3& p : spread_points(far, outer_sites, result_.sites)) add_rest(p);
    }

    const Shape& solid_;
    const Blow& blow_;
    const Damage& damage_;
    const ImpactPattern& pattern_;
    Random random_;
    double reach_ = 0.0; // m, largest distance of the pieces' sites from the contact
    double depth_ = 0.0; // m, of the solid along the normal
    double clear_ = 0.0; // m, minimum distance of the rest's sites from all others
    ImpactSites result_; // `rest` counts the pieces so far
};

} // namespace

glm::dvec3 longest_axis(const fracture::MassProperties& mass) {
    const fracture::PrincipalAxes principal = fracture::principal_axes(mass.inertia);
    int least = 0;
    for (int axis = 1; axis < 3; ++axis)
        if (principal.moments[axis] < principal.moments[least]) least = axis;
    return principal.axes[least];
}

double energy_of(double radius, const Material& material, double volume, uint32_t max_pieces) {
    if (!(radius > 0.0) || !(volume > 0.0) || !std::isfinite(radius) || !std::isfinite(volume)) return 0.0;
    // Bisection: the radius grows with the energy, and the limits of the number of pieces bound the energy.
    const auto energy = [&](double pieces) {
        return surface_per_radius * radius * radius * std::cbrt(pieces) * static_cast<double>(material.fracture_energy);
    };
    double low = energy(1.0), high = energy(std::max<double>(max_pieces, min_pieces));
    for (int k = 0; k < 60; ++k) {
        const double middle = 0.5 * (low + high);
        const Blow blow{.energy = middle};
        (damage_of(blow, material, volume, {.max_pieces = max_pieces}).radius < radius ? low : high) = middle;
    }
    return high;
}

double breaking_energy(const Blow& blow, double bounce, const Material& material, double volume,
                       const DamageLimits& limits) {
    constexpr double most = 1000.0; // times the speed
    const auto breaks = [&](double speed) {
        Blow faster = blow;
        faster.force *= speed;
        faster.energy *= speed * speed;
        if (!(faster.force > limits.bearable)) faster.energy *= 1.0 - bounce;
        return damage_of(faster, material, volume, limits).pieces > 0;
    };
    if (!breaks(most)) return std::numeric_limits<double>::infinity();
    double low = 1.0 / most, high = most;
    for (int k = 0; k < 60; ++k) {
        const double middle = std::sqrt(low * high);
        (breaks(middle) ? high : low) = middle;
    }
    return blow.energy * high * high;
}

Damage damage_of(const Blow& blow, const Material& material, double volume, const DamageLimits& limits) {
    if (!finite(blow.point) || !finite(blow.normal) || !(glm::length(blow.normal) > 0.5) || !(blow.energy > 0.0)
        || !(blow.force > 0.0) || !std::isfinite(blow.energy) || !(volume > 0.0) || !std::isfinite(volume))
        return {};
    const double surface = blow.energy / static_cast<double>(material.fracture_energy);
    double pieces = std::max(std::round(pieces_per_size * std::sqrt(surface) / std::cbrt(volume)), double{min_pieces});
    pieces = std::min(pieces, static_cast<double>(std::max(limits.max_pieces, 1u)));
    double radius = std::sqrt(surface / (surface_per_radius * std::cbrt(pieces)));
    const bool local = !(blow.force > limits.bearable);
    if (const double crack = contact_crack(material, blow.force); local && crack < radius) {
        pieces = std::max(std::round(pieces * crack / radius), std::min(pieces, double{min_pieces}));
        radius = crack;
    }
    if (!(radius > 0.0)) return {};
    if (limits.min_volume > 0.0) {
        const double damaged = std::min(half_ball * radius * radius * radius, volume);
        if (volume < 2.0 * limits.min_volume || damaged < limits.min_volume) return {};
        pieces = std::min(pieces, std::floor(damaged / limits.min_volume));
    }
    return {radius, static_cast<uint32_t>(pieces), local};
}

namespace {

ImpactSites impact_sites(const Shape& shape, const fracture::MassProperties& mass, const Blow& blow,
                         const Damage& damage, const ImpactPattern& pattern) {
    if (!(damage.radius > 0.0) || damage.pieces == 0) return {};
    Maker maker(shape, blow, damage, pattern);
    return pattern.diagram.empty() ? maker.run(mass) : maker.from_diagram();
}

} // namespace

ImpactSites impact_sites(const fracture::TriangleMesh& solid, const fracture::MassProperties& mass, const Blow& blow,
                         const Damage& damage, const ImpactPattern& pattern) {
    return impact_sites(Shape(solid), mass, blow, damage, pattern);
}

ImpactSites impact_sites(const fracture::ClusterMesh& solid, const fracture::MassProperties& mass, const Blow& blow,
                         const Damage& damage, const ImpactPattern& pattern) {
    return impact_sites(Shape(solid), mass, blow, damage, pattern);
}

std::vector<glm::dvec3> spread_points(std::span<const glm::dvec3> vertices, uint32_t count,
                                      std::span<const glm::dvec3> given) {
    constexpr size_t max_looked_at = 4096;
    const size_t stride = std::max<size_t>(1, vertices.size() / max_looked_at);
    std::vector<glm::dvec3> points;
    for (size_t i = 0; i < vertices.size(); i += stride) points.push_back(vertices[i]);
    std::vector<double> gap(points.size(), std::numeric_limits<double>::infinity());
    const auto note = [&](const glm::dvec3& from) {
        for (size_t i = 0; i < points.size(); ++i) {
            const glm::dvec3 apart = points[i] - from;
            gap[i] = std::min(gap[i], glm::dot(apart, apart));
        }
    };
    for (const glm::dvec3& site : given) note(site);
    std::vector<glm::dvec3> chosen;
    while (chosen.size() < count && !points.empty()) {
        const auto farthest = std::ranges::max_element(gap);
        if (*farthest == 0.0) break; // only duplicates remain
        chosen.push_back(points[static_cast<size_t>(farthest - gap.begin())]);
        note(chosen.back());
    }
    return chosen;
}

} // namespace brittle::physics

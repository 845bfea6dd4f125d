#include "tools/scenario/recipe/strike.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "fracture/shapes/shapes.h"

namespace brittle::tools {

using fracture::PatternKind;

namespace {

// Half the side of the cube, and the distance of the sites that close it, both as multiples of the radius. Neighbouring
// closing sites lie 36 degrees apart, so at most 20 degrees from any direction. A cell of the ball ends at the
// bisectors with them, at (1.6^2 - 1) / 2 / (1.6 cos 20 - 1) = 1.55 radii at most.
constexpr double reach = 1.6;
// Ratio of the cube's volume to the ball's.
constexpr double cube_by_ball = 8.0 * reach * reach * reach / (4.0 / 3.0 * 3.14159265358979323846);
constexpr uint32_t max_pieces = 10'000;

fracture::Error fault(size_t strike, const std::string& what) {
    return {fracture::Status::invalid_setting, "strike " + std::to_string(strike) + ": " + what};
}

bool finite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

fracture::Pattern pattern_in_cube(const Strike& strike, const fracture::Pattern& pattern, size_t number) {
    fracture::Pattern inside = pattern;
    if (inside.kind == PatternKind::curvature || inside.kind == PatternKind::thickness
        || inside.kind == PatternKind::curve)
        inside.kind = PatternKind::uniform;
    if (inside.kind == PatternKind::radial) inside.axis = strike.direction;
    inside.count = static_cast<uint32_t>(std::lround(cube_by_ball * strike.pieces));
    inside.piece_size = 0.0;
    inside.seed = pattern.seed + number;
    inside.focus = glm::dvec3(0.5);
    inside.inside = false;
    return inside;
}

} // namespace

fracture::Result<fracture::PatternSites> strike_sites(std::span<const Strike> strikes,
                                                      const fracture::Pattern& pattern) {
    fracture::PatternSites all;
    for (size_t k = 0; k < strikes.size(); ++k) {
        const Strike& strike = strikes[k];
        if (!finite(strike.at)) return fault(k, "its point is not finite");
        if (!(strike.radius > 0.0) || !std::isfinite(strike.radius))
            return fault(k, "its radius is " + std::to_string(strike.radius) + " m; it must be positive");
        if (!finite(strike.direction) || glm::length(strike.direction) == 0.0)
            return fault(k, "its direction has no length");
        if (strike.pieces < 1 || strike.pieces > max_pieces)
            return fault(k, "its number of pieces is " + std::to_string(strike.pieces) + "; it must be from 1 to "
                                + std::to_string(max_pieces));
        fracture::TriangleMesh cube = fracture::cuboid(glm::dvec3(2.0 * reach * strike.radius));
        const glm::dvec3 offset = strike.at - fracture::bounds(cube).centre();
        for (glm::dvec3& p : cube.positions) p += offset;
        auto made = fracture::make_sites(pattern_in_cube(strike, pattern, k), cube);
        if (!made) return made.error();
        // Each strike has groups of its own. Sites without a group get one of their own.
        const auto base = static_cast<uint32_t>(all.sites.size());
        for (size_t s = 0; s < made->sites.size(); ++s) {
            all.sites.push_back(made->sites[s]);
            all.groups.push_back(base + (made->groups.empty() ? static_cast<uint32_t>(s) : made->groups[s]));
            all.weights.push_back(made->weights.empty() ? 0.0 : made->weights[s]);
        }
        // Without these sites long cells, e.g. splinters, would reach far out of the cube.
        for (const glm::dvec3& p : fracture::icosphere(1, reach * strike.radius).positions) {
            all.groups.push_back(static_cast<uint32_t>(all.sites.size()));
            all.sites.push_back(strike.at + p);
            all.weights.push_back(0.0);
        }
    }
    if (std::all_of(all.weights.begin(), all.weights.end(), [](double w) { return w == 0.0; })) all.weights.clear();
    const auto breaks = [&](const glm::dvec3& p) {
        return std::any_of(strikes.begin(), strikes.end(),
                           [&](const Strike& s) { return glm::distance(p, s.at) < s.radius; });
    };
    // A group (e.g. a brick) stays as a whole if any of its sites stays.
    std::vector<uint8_t> stays(all.sites.size(), 0);
    for (size_t s = 0; s < all.sites.size(); ++s)
        if (!breaks(all.sites[s])) stays[all.groups[s]] = 1;
    const auto rest = static_cast<uint32_t>(all.sites.size());
    for (uint32_t& group : all.groups)
        if (stays[group]) group = rest;
    return all;
}

} // namespace brittle::tools

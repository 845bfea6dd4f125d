#include "tools/scenario/run/stage_placement.h"

#include <algorithm>
#include <cmath>

namespace brittle::tools {

namespace {

constexpr double stage_size = 2.0; // m, longest side of the mesh

} // namespace

StagePlacement placement_on_stage(const fracture::TriangleMesh& mesh, const WorldOptions& world, LengthUnit units) {
    const fracture::Box box = fracture::bounds(mesh);
    const double longest = std::max({box.size().x, box.size().y, box.size().z});
    if (!(longest > 0.0) || !std::isfinite(longest)) return {};
    const double scale = units == LengthUnit::fit ? stage_size / longest : metres_of(units);
    return {{box.centre().x, box.min.y, box.centre().z}, scale, foot_height(world)};
}

Input placed_on_stage(Input input, const WorldOptions& world) {
    const StagePlacement placement = placement_on_stage(input.model.mesh, world, input.units);
    for (glm::dvec3& p : input.model.mesh.positions) p = placement.to_stage(p);
    for (glm::dvec3& site : input.sites) site = placement.to_stage(site);
    for (double& weight : input.weights) weight *= placement.scale * placement.scale;
    input.scale *= placement.scale;
    return input;
}

} // namespace brittle::tools

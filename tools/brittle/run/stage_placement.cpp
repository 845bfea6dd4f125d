#include "tools/brittle/run/stage_placement.h"

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

} // namespace brittle::tools

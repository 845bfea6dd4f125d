// Placement of a mesh on the stage: scaled so that its longest side is 2 m, or by the unit of its file; centred, and on
// the ground or above it.
#pragma once

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"
#include "tools/scenario/recipe/input.h"
#include "tools/scenario/recipe/world_options.h"

namespace brittle::tools {

struct StagePlacement {
    glm::dvec3 foot{0.0}; // in the file's coordinates: centre of the box in X and Z, at its lowest Y
    double scale = 1.0;   // metres on the stage per metre of the file
    double height = 0.0;  // m, height of the foot above the ground

    [[nodiscard]] glm::dvec3 to_stage(const glm::dvec3& p) const {
        return (p - foot) * scale + glm::dvec3(0.0, height, 0.0);
    }
    [[nodiscard]] glm::dvec3 to_file(const glm::dvec3& p) const {
        return (p - glm::dvec3(0.0, height, 0.0)) / scale + foot;
    }
};

// Returns the placement for a mesh and a world; the identity if the mesh has no extent.
[[nodiscard]] StagePlacement placement_on_stage(const fracture::TriangleMesh& mesh, const WorldOptions& world = {},
                                                LengthUnit units = LengthUnit::fit);

// Returns the input with mesh, sites and weights moved by placement_on_stage().
[[nodiscard]] Input placed_on_stage(Input input, const WorldOptions& world = {});

} // namespace brittle::tools

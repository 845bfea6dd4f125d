// Where a mesh comes to on the stage: scaled so that its longest side is 2 m, in the middle, above the ground or on it.
#pragma once

#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"
#include "tools/brittle/recipe/world_options.h"

namespace brittle::tools {

struct StagePlacement {
    glm::dvec3 foot{0.0}; // in the file: the middle of the box, at its lowest
    double scale = 1.0;   // metres on the stage by those in the file
    double height = 0.0;  // m, of the foot above the ground

    [[nodiscard]] glm::dvec3 to_stage(const glm::dvec3& p) const {
        return (p - foot) * scale + glm::dvec3(0.0, height, 0.0);
    }
    [[nodiscard]] glm::dvec3 to_file(const glm::dvec3& p) const {
        return (p - glm::dvec3(0.0, height, 0.0)) / scale + foot;
    }
};

// As it is where the mesh has no extent.
[[nodiscard]] StagePlacement placement_on_stage(const fracture::TriangleMesh& mesh, const WorldOptions& world = {});

} // namespace brittle::tools

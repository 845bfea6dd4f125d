// Contents of a picture besides whole pieces (recipe/picture_options.h): Voronoi cells, a partly cut cell, the camera.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/camera/camera.h"
#include "engine/render/scene.h"
#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"
#include "tools/scenario/recipe/picture_options.h"

namespace brittle::tools {

struct Input;

// Returns the edges of the Voronoi diagram in a box a little larger than the mesh's, two vertices per line.
[[nodiscard]] std::vector<engine::LineVertex>
cell_lines(const fracture::TriangleMesh& mesh, std::span<const glm::dvec3> sites, std::span<const double> weights);
[[nodiscard]] std::vector<engine::LineVertex> cell_lines(const Input& input);

// Returns one piece: the mesh cut by the first planes of site 0's cell, as in the paper's figure 9. `planes` may exceed
// the planes of the cell. Throws a Failure if the mesh cannot be cut.
[[nodiscard]] fracture::Fragments partly_cut(const Input& input, uint32_t planes);

[[nodiscard]] engine::Camera picture_camera(const PictureOptions& options, const engine::Bounds& mesh, float aspect);

} // namespace brittle::tools

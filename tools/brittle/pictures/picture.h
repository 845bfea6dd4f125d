// What a picture shows beside the pieces (recipe/picture_options.h): cells, a partly cut cell, the camera.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/render/camera.h"
#include "engine/render/scene.h"
#include "fracture/mesh/mesh.h"
#include "fracture/pieces/fragments.h"
#include "tools/brittle/recipe/picture_options.h"

namespace brittle::tools {

struct Input;

// Two a line: the edges of the Voronoi diagram in a box a little larger than the mesh's.
[[nodiscard]] std::vector<engine::LineVertex>
cell_lines(const fracture::TriangleMesh& mesh, std::span<const glm::dvec3> sites, std::span<const double> weights);
[[nodiscard]] std::vector<engine::LineVertex> cell_lines(const Input& input);

// One piece: what the first planes of site 0's cell leave of the mesh, as the paper's figure 9 shows it. Fewer planes where
// the cell has fewer. Throws a Failure where the mesh cannot be cut.
[[nodiscard]] fracture::Fragments partly_cut(const Input& input, uint32_t planes);

[[nodiscard]] engine::Camera picture_camera(const PictureOptions& options, const engine::Bounds& mesh, float aspect);

} // namespace brittle::tools

// What a picture of a broken mesh shows: options of `brittle render`, and the "picture" of a recipe. The recipes under
// assets/scenes are the figures of the paper.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/render/camera.h"
#include "engine/render/scene.h"
#include "fracture/fragments.h"
#include "fracture/mesh.h"

namespace brittle::tools {

struct Input;

struct PictureOptions {
    uint32_t frames = 120;  // of 1/60 s simulated time, after the first picture
    bool whole = false;     // the unbroken mesh
    uint32_t planes = 0;    // cut the cell of site 0 out by so many of its planes only, nearest first; 0: break it all
    float explode = 0.0f;   // draw the pieces moved apart by this share of their distance to the middle
    bool sites = false;     // the sites as spheres
    bool hulls = false;     // the collision hulls as lines
    bool smooth = false;    // round exteriors; else facets
    bool wireframe = false; // edges of triangles over the pieces
    bool cells = false;     // the Voronoi cells in the mesh's box as lines
    float azimuth = 31.5f;  // degrees, from +Z towards +X
    float elevation = 17.0f; // degrees, from the ground
    float distance = 1.0f;  // of the camera; 1 shows the mesh, the ground and room for pieces to spread
};

// Two a line: the edges of the Voronoi diagram in a box a little larger than the mesh's.
[[nodiscard]] std::vector<engine::LineVertex> cell_lines(const fracture::TriangleMesh& mesh,
                                                         std::span<const glm::dvec3> sites, std::span<const double> weights);
[[nodiscard]] std::vector<engine::LineVertex> cell_lines(const Input& input);

// One piece: what the first planes of site 0's cell leave of the mesh, as the paper's figure 9 shows it. Fewer planes where
// the cell has fewer. Throws a Failure where the mesh cannot be cut.
[[nodiscard]] fracture::Fragments partly_cut(const Input& input, uint32_t planes);

[[nodiscard]] engine::Camera picture_camera(const PictureOptions& options, const engine::Bounds& mesh, float aspect);

} // namespace brittle::tools

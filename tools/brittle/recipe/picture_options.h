// What a picture of a broken mesh shows: options of `brittle render`, and the "picture" of a recipe. The recipes under
// assets/scenes are the figures of the paper.
#pragma once

#include <cstdint>

namespace brittle::tools {

struct PictureOptions {
    uint32_t frames = 120;   // of 1/60 s simulated time, after the first picture
    bool whole = false;      // the unbroken mesh
    uint32_t planes = 0;     // cut the cell of site 0 out by so many of its planes only, nearest first; 0: break it all
    float explode = 0.0f;    // draw the pieces moved apart by this share of their distance to the middle
    bool sites = false;      // the sites as spheres
    bool hulls = false;      // the collision hulls as lines
    bool smooth = false;     // round exteriors; else facets
    bool wireframe = false;  // edges of triangles over the pieces
    bool cells = false;      // the Voronoi cells in the mesh's box as lines
    float azimuth = 31.5f;   // degrees, from +Z towards +X
    float elevation = 17.0f; // degrees, from the ground
    float distance = 1.0f;   // of the camera; 1 shows the mesh, the ground and room for pieces to spread
};

} // namespace brittle::tools

// Contents of a picture of a broken mesh: options of `brittle render`, and the "picture" of a recipe. The recipes under
// assets/scenes are the figures of the paper.
#pragma once

#include <cstdint>
#include <string>

namespace brittle::tools {

// What colours pieces have in a picture: the materials of their mesh with the grain of fracture surfaces, or a colour for
// each piece. Automatic: materials where the mesh has some.
enum class PieceColours { automatic, pieces, materials };

inline constexpr uint32_t min_picture = 16, max_picture = 8192; // pixels, width and height of a picture

struct PictureOptions {
    uint32_t every = 10;            // interval between the frames that are written
    uint32_t width = 0, height = 0; // pixels; 0: those of ViewOptions
    std::string quality{};          // auto, fast or best; empty: that of ViewOptions
    uint32_t frames = 120;          // number of frames of 1/60 s after the first picture
    bool whole = false;             // draw the unbroken mesh
    // Cut out only the cell of site 0, by this many of its planes, nearest first; 0: fracture the whole mesh.
    uint32_t planes = 0;
    float explode = 0.0f; // draw the pieces apart, by this share of their distance from the middle
    float dust = 1.0f;    // share of the dust and splinters of breaks that is drawn, 0 to 1
    bool sites = false;   // draw the sites as spheres
    bool hulls = false;   // draw the collision hulls as lines
    PieceColours colours = PieceColours::automatic;
    std::string interior_texture{}; // image for fracture surfaces in the view of materials; empty: their grain
    bool smooth = false;            // shade exteriors smoothly; else by facets
    bool wireframe = false;         // draw the edges of triangles over the pieces
    bool cells = false;             // draw the Voronoi cells in the mesh's box as lines
    float azimuth = 31.5f;          // degrees, from +Z towards +X
    float elevation = 17.0f;        // degrees above the ground
    float distance = 1.0f; // distance of the camera; 1 shows the mesh, the ground and room for pieces to spread
};

} // namespace brittle::tools

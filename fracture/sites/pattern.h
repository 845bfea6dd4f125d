// Fracture patterns: families of Voronoi sites, made from one plain description.
//
//     Result<PatternSites> sites = make_sites({.kind = PatternKind::bricks, .count = 60}, mesh);
//     settings.groups = sites->groups;
//     Result<Fragments> fragments = fracture(mesh, sites->sites, settings);
//
// A pattern does not depend on the mesh until it is placed: its lengths are relative to the mesh's box, so one
// description fits any mesh. Equal patterns on equal meshes give equal sites on every machine. All functions are
// reentrant.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/base/error.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

enum class PatternKind {
    uniform,   // uniformly random in the box
    clustered, // random, with a normal distribution around the focus
    radial,    // broken glass: rings and rays around the axis through the focus; shards extend through the solid
    grid,      // a regular grid of boxes
    bricks,    // boxes in running bond, with courses along Y and bricks along X; uses groups
    slices,    // slabs perpendicular to the axis
    splinters, // pieces elongated along the axis, as of broken wood
    curve,     // a crack along a polyline; the crack surface is parallel to the axis
    curvature, // random near the surface, denser where its curvature is larger
    thickness  // random inside the solid, spaced by its local thickness
};

[[nodiscard]] std::span<const std::string_view> pattern_names(); // names of the kinds, in the order of the enum

struct Pattern {
    PatternKind kind = PatternKind::uniform;
    // Intended count of sites; exact for uniform, clustered, slices, curvature and thickness.
    uint32_t count = 20;
    // Intended edge length of pieces, m; if positive, count becomes the volume of the solid divided by its cube.
    double piece_size = 0.0;
    uint64_t seed = 1;
    // Irregularity, 0 to 1; negative selects the default of the kind (0 for grid, bricks and slices).
    double jitter = -1.0;
    glm::dvec3 focus{0.5}; // point in the box, 0 to 1 along each axis
    glm::dvec3 axis{0.0, 1.0, 0.0};
    double spread = 0.15;     // clustered: standard deviation, as a fraction of the box's diagonal
    double slenderness = 8.0; // splinters: ratio of length to width
    // Curve: the polyline, in the coordinates of `focus`.
    std::vector<glm::dvec3> line{{0.0, 0.5, 0.5}, {1.0, 0.5, 0.5}};
    // Spread of the cell sizes, by random weights: 0 for cells of similar size, to 1; not for bricks.
    double grading = 0.0;
    // Cells that make up each piece, from 1 to 1,000: pieces have many facets and are not convex, at about 16 like crushed
    // stone. The pieces of a kind keep their places; `count` times this may be a million at most.
    uint32_t cells_per_piece = 1;
    // Keeps only sites inside the solid: random kinds draw others instead, regular kinds drop theirs.
    bool inside = false;
};

struct PatternSites {
    std::vector<glm::dvec3> sites;
    std::vector<uint32_t> groups; // for Settings::groups: one group per site, or empty
    std::vector<double> weights;  // for Settings::weights: one weight per site, or empty
};

// Makes the sites of the pattern for a mesh, at most a million. With several cells a piece there are no weights.
// Errors: invalid_setting, with the field, its value and its range, or because no site lies inside the solid;
// empty_mesh.
[[nodiscard]] Result<PatternSites> make_sites(const Pattern& pattern, const TriangleMesh& mesh);

// Maps sites from one box onto another, for diagrams that are stored in a file and reused on any mesh or piece. The
// sites are rotated about the centre of the first box (about X, then Y, then Z), scaled uniformly by the ratio of the
// boxes' longest sides and by `scale`, and translated to the centre of the second box plus `move`.
struct Placement {
    glm::dvec3 turn{0.0}; // rotation about X, Y and Z, degrees; any finite numbers
    double scale = 1.0;
    glm::dvec3 move{0.0}; // translation, m, applied last
};
[[nodiscard]] std::vector<glm::dvec3> place(std::span<const glm::dvec3> sites, const Box& from, const Box& onto,
                                            const Placement& placement = {});

} // namespace brittle::fracture

// Where to break: families of Voronoi sites, from one plain description.
//
//     Result<PatternSites> sites = make_sites({.kind = PatternKind::bricks, .count = 60}, mesh);
//     settings.groups = sites->groups;
//     Result<Fragments> fragments = fracture(mesh, sites->sites, settings);
//
// A pattern knows nothing of a mesh until it is placed: lengths are shares of the mesh's box, so one description fits
// any mesh. Equal patterns on equal meshes give equal sites on every machine.
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
    uniform,   // at random in the box
    clustered, // at random, most of them near the focus
    radial,    // broken glass: rings and rays around the axis through the focus, shards as deep as the solid
    grid,      // boxes
    bricks,    // boxes in running bond, courses along Y, bricks along X; uses groups
    slices,    // slabs across the axis
    splinters, // long along the axis, as wood breaks
    curve,     // a crack along a line of points, as deep along the axis as the solid
    curvature, // at random near the surface, where it bends most
    thickness  // at random inside, pieces as large as the solid is thick
};

[[nodiscard]] std::span<const std::string_view> pattern_names(); // in the order of the enum

struct Pattern {
    PatternKind kind = PatternKind::uniform;
    uint32_t count = 20;     // of pieces aimed at; exact for uniform, clustered, slices, curvature and thickness
    double piece_size = 0.0; // m; if positive, count is the solid's volume by its cube
    uint64_t seed = 1;
    double jitter = -1.0;  // how irregular, 0 to 1; negative: as becomes the kind (0 for grid, bricks and slices)
    glm::dvec3 focus{0.5}; // in the box: 0 to 1 along each axis
    glm::dvec3 axis{0.0, 1.0, 0.0};
    double spread = 0.15;     // clustered: standard deviation, share of the box's diagonal
    double slenderness = 8.0; // splinters: length by width
    std::vector<glm::dvec3> line{{0.0, 0.5, 0.5}, {1.0, 0.5, 0.5}}; // curve: in the box, as focus
    double grading = 0.0; // 0: cells of like sizes; to 1: from crumbs to lumps, by random weights; not for bricks
    bool inside = false;  // only sites inside the solid; those of random kinds are drawn anew, others left out
};

struct PatternSites {
    std::vector<glm::dvec3> sites;
    std::vector<uint32_t> groups; // for Settings::groups: one each, or none
    std::vector<double> weights;  // for Settings::weights: likewise
};

// Errors: invalid_setting, naming the field and its range; empty_mesh. At most a million sites.
[[nodiscard]] Result<PatternSites> make_sites(const Pattern& pattern, const TriangleMesh& mesh);

// Moves sites that were made for one box onto another, as a whole: turned about the first box's centre (degrees about
// X, then Y, then Z), scaled evenly to the other box's longest side and by `scale`, and moved to its centre. For
// diagrams that are made once, in a file, and put on any mesh or piece.
struct Placement {
    glm::dvec3 turn{0.0}; // degrees
    double scale = 1.0;
    glm::dvec3 move{0.0}; // m, in the end
};
[[nodiscard]] std::vector<glm::dvec3> place(std::span<const glm::dvec3> sites, const Box& from, const Box& onto,
                                            const Placement& placement = {});

} // namespace brittle::fracture

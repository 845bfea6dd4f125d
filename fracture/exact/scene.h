// The problem in the form that the predicates require: mesh and sites scaled by one power of two.
//
// The scale makes the mesh about one unit long, so that products of up to seven coordinates neither overflow nor
// underflow. A power of two keeps every bit, so the decisions hold for the input itself. (Coordinates below 2^-98 of
// the size of the mesh are snapped, see predicates.h.) There is no translation: it would round.
#pragma once

#include <span>
#include <vector>

#include "fracture/base/error.h"
#include "fracture/base/threads.h"
#include "fracture/exact/predicates.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture::exact {

// The largest coordinate of the input, in metres. Volumes overflow beyond it.
inline constexpr double max_input_coordinate = 1e100;

struct Scene {
    std::vector<glm::dvec3> positions; // of the mesh, scaled
    std::vector<glm::dvec3> sites;     // scaled; all sites of the input, duplicates included
    std::vector<double> weights;       // scaled; one per site, or empty
    Box box;                           // scaled; contains the mesh strictly
    double to_scene = 1.0;             // from input lengths to scene lengths, a power of two
    double to_input = 1.0;             // 1 / to_scene

    [[nodiscard]] Diagram diagram() const { return {sites, box, weights}; }
};

// The power of two that scales `size` into [1, 2); 1 for a size of zero.
[[nodiscard]] double unit_scale(double size);

// Scales the sites into `out`. Errors: invalid_sites for no site, too many sites, a site that is not finite, or one
// outside the range of the predicates (2^100 mesh sizes).
[[nodiscard]] Result<void> scale_sites(std::span<const glm::dvec3> sites, double to_scene,
                                       std::vector<glm::dvec3>& out);

// Scales the weights, which are squared lengths, into `out`. Errors: invalid_setting for a weight that is not finite or
// beyond the square of that range.
[[nodiscard]] Result<void> scale_weights(std::span<const double> weights, double to_scene, std::vector<double>& out);

// Scales the mesh into the scene and reuses its memory. Leaves the sites unchanged and does not examine the indices of
// the triangles (surface.h does). Errors: empty_mesh; invalid_mesh for a position that is not finite or beyond
// max_input_coordinate, and for too many vertices or triangles.
[[nodiscard]] Result<void> scale_mesh(const TriangleMesh& mesh, Threads& threads, Scene& scene);

// Scales mesh, sites and weights. Errors: as scale_mesh(), scale_sites() and scale_weights().
[[nodiscard]] Result<void> make_scene(const TriangleMesh& mesh, std::span<const glm::dvec3> sites,
                                      std::span<const double> weights, Threads& threads, Scene& scene);

} // namespace brittle::fracture::exact

// The problem in the form that the predicates want: mesh and sites scaled by one power of two.
//
// Scaling makes the mesh about one unit long, so that products of up to seven coordinates neither overflow
// nor underflow; a power of two keeps every bit, so what is decided here is true of the input itself.
// (Coordinates below 2^-98 of the mesh's size are snapped, see predicates.h.) No translation: it would round.
#pragma once

#include <span>
#include <vector>

#include "fracture/base/error.h"
#include "fracture/base/threads.h"
#include "fracture/exact/predicates.h"
#include "fracture/mesh/mesh.h"

namespace brittle::fracture::exact {

// Beyond this volumes overflow; in metres.
inline constexpr double max_input_coordinate = 1e100;

struct Scene {
    std::vector<glm::dvec3> positions; // of the mesh, scaled
    std::vector<glm::dvec3> sites;     // scaled; all sites of the input, duplicates too
    std::vector<double> weights;       // scaled; of the sites, or none
    Box box;                           // scaled; the mesh lies strictly inside
    double to_scene = 1.0;             // powers of two
    double to_input = 1.0;

    [[nodiscard]] Diagram diagram() const { return {sites, box, weights}; }
};

// The power of two that brings a length of that size to [1, 2); 1 for zero.
[[nodiscard]] double unit_scale(double size);

// The sites scaled into `out`. Errors: invalid_sites for no site, too many, one that is not finite, or one farther out
// than the predicates' range (2^100 mesh sizes).
[[nodiscard]] Result<void> scale_sites(std::span<const glm::dvec3> sites, double to_scene,
                                       std::vector<glm::dvec3>& out);

// Weights of sites, squared lengths, likewise. Errors: invalid_setting, for one that is not finite or beyond the square of
// that range.
[[nodiscard]] Result<void> scale_weights(std::span<const double> weights, double to_scene, std::vector<double>& out);

// The mesh scaled into the scene, reusing its memory; leaves the sites alone and does not look at the
// triangles' indices (surface.h does). Errors: empty_mesh, and invalid_mesh for a position that is not finite
// or beyond max_input_coordinate, or for too many vertices or triangles.
[[nodiscard]] Result<void> scale_mesh(const TriangleMesh& mesh, Threads& threads, Scene& scene);

// All of it. Errors: as scale_mesh(), scale_sites() and scale_weights().
[[nodiscard]] Result<void> make_scene(const TriangleMesh& mesh, std::span<const glm::dvec3> sites,
                                      std::span<const double> weights, Threads& threads, Scene& scene);

} // namespace brittle::fracture::exact

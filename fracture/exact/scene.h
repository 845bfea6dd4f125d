// The problem in the form that the predicates want: mesh and sites scaled by one power of two.
//
// Scaling makes the mesh about one unit long, so that products of up to seven coordinates neither overflow
// nor underflow; a power of two keeps every bit, so what is decided here is true of the input itself.
// (Coordinates below 2^-98 of the mesh's size are snapped, see predicates.h.) No translation: it would round.
#pragma once

#include <span>
#include <vector>

#include "fracture/error.h"
#include "fracture/parallel.h"
#include "fracture/exact/predicates.h"
#include "fracture/mesh.h"

namespace brittle::fracture::exact {

inline constexpr uint32_t kNone = 0xffffffffu; // no index

struct Scene {
    std::vector<glm::dvec3> positions; // of the mesh, scaled
    std::vector<glm::dvec3> sites;     // scaled; all sites of the input, duplicates too
    Box box;                           // scaled; the mesh lies strictly inside
    double to_scene = 1.0;             // powers of two
    double to_input = 1.0;

    [[nodiscard]] Diagram diagram() const { return {sites, box}; }
};

// The power of two that brings a length of that size to [1, 2); 1 for zero.
[[nodiscard]] double unit_scale(double size);

// The sites scaled into `out`. Errors: invalid_sites for no site, a non-finite one, or one farther out than
// the predicates' range (2^100 mesh sizes).
[[nodiscard]] Result<void> scale_sites(std::span<const glm::dvec3> sites, double to_scene,
                                       std::vector<glm::dvec3>& out);

// Fills the scene, reusing its memory. Errors: as scale_sites(), empty_mesh, and invalid_mesh for a
// non-finite position. Does not look at the triangles: see surface.h.
[[nodiscard]] Result<void> make_scene(const TriangleMesh& mesh, std::span<const glm::dvec3> sites,
                                      Threads& threads, Scene& scene);

} // namespace brittle::fracture::exact

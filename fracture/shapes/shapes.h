// Procedural closed meshes with known volumes, for tests, benchmarks and a first try without a file.
// All are closed, oriented and manifold. Lengths in metres, centred on the origin unless said otherwise.
// Counts outside what makes sense (two segments, forty subdivisions) are clamped, so that no argument asks
// for unbounded memory.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

[[nodiscard]] TriangleMesh cube(double edge = 2.0);
// The cube with each face cut into n x n squares of two triangles: integer-like coordinates, coplanar
// neighbours.
[[nodiscard]] TriangleMesh lattice_cube(uint32_t n, double edge = 2.0);
// 20 * 4^subdivisions triangles, vertices on the sphere.
[[nodiscard]] TriangleMesh icosphere(uint32_t subdivisions = 4, double radius = 1.0);
// Axis Y; major radius to the tube's centre.
[[nodiscard]] TriangleMesh torus(uint32_t major_segments = 96, uint32_t minor_segments = 48, double major_radius = 1.0,
                                 double minor_radius = 0.4);
// A (p, q) torus knot as a tube: p turns around axis Y, q around the torus of radii 1 and 0.5 it lies on. A
// common divisor of p and q is dropped. Free of self-intersections for the defaults; many turns need a
// thinner tube.
[[nodiscard]] TriangleMesh torus_knot(uint32_t p = 2, uint32_t q = 3, uint32_t segments = 400, uint32_t ring = 24,
                                      double tube_radius = 0.25);
// A sphere with a concentric spherical cavity (two components, the inner one inside out).
[[nodiscard]] TriangleMesh hollow_sphere(uint32_t subdivisions = 4, double radius = 1.0, double cavity = 0.6);
// A Menger sponge: a cube of which each level cuts square tunnels through the middle, in 3^level steps; level 0 is the
// cube, 4 the most. Genus 5 at level 1, 81 at level 2.
[[nodiscard]] TriangleMesh menger_sponge(uint32_t level = 2, double edge = 2.0);
// A box of these lengths.
[[nodiscard]] TriangleMesh cuboid(const glm::dvec3& size);
// Two columns and a round arch between them under a flat top, feet at y = 0: 2 m wide, 1.5 m high, 0.3 m deep; the opening is
// 1.2 m wide.
[[nodiscard]] TriangleMesh arch(uint32_t segments = 24);
// A round tower, hollow and open above: 2 m high, foot at y = 0, 0.92 m across there and 0.72 m below the battlements,
// which stand out over it; a door 0.5 m high towards +Z, a window to each other side. Genus 4.
[[nodiscard]] TriangleMesh tower();
// A calf: trunk, neck, head with ears and horns, tail and four legs, smoothly joined; 2.4 m long, one
// component of genus 0. Feet at y = 0, looking along +Z. A plane across the legs leaves four separate parts
// below it, as in the paper's figure 12. resolution is the number of lattice cells along its length.
[[nodiscard]] TriangleMesh four_legged_animal(uint32_t resolution = 64);
// A man in a long robe on a plinth, one arm raised, a hand at his belt; 2 m high, one component of genus 1. Its foot is at
// y = 0, it looks along +Z. resolution is the number of lattice cells along its height.
[[nodiscard]] TriangleMesh statue(uint32_t resolution = 64);

// Names that shape() knows, for help texts: cube, lattice_cube, icosphere, torus, torus_knot, hollow_sphere,
// menger_sponge, pane (2 x 1.4 x 0.03 m), wall (2 x 1.2 x 0.2 m), arch, tower, animal, statue.
[[nodiscard]] std::span<const std::string_view> shape_names();
// The shape of that name with its default arguments (lattice_cube: n = 16); nothing for an unknown name. NAME:N gives one of
// another fineness: lattice_cube:N, icosphere:SUBDIVISIONS, torus:SEGMENTS around (half as many across), torus_knot:SEGMENTS
// (a sixteenth across), menger_sponge:LEVEL, animal:RESOLUTION, statue:RESOLUTION.
[[nodiscard]] std::optional<TriangleMesh> shape(std::string_view name);

} // namespace brittle::fracture

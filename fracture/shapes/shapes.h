// Procedural closed meshes with known volumes, for tests, benchmarks and a first try without a file.
//
// All shapes are closed, oriented and manifold. Lengths are in metres; shapes are centred on the origin unless stated
// otherwise. Counts that make no sense (two segments, forty subdivisions) are clamped, which bounds time and memory.
// All functions are reentrant.
//
//     const TriangleMesh mesh = torus();
//     const std::optional<TriangleMesh> finer = shape("torus:256");
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "fracture/mesh/mesh.h"

namespace brittle::fracture {

[[nodiscard]] TriangleMesh cube(double edge = 2.0);
// A cube whose faces are divided into n x n squares of two triangles each: coordinates on a lattice, coplanar
// neighbours.
[[nodiscard]] TriangleMesh lattice_cube(uint32_t n, double edge = 2.0);
// A sphere of 20 * 4^subdivisions triangles with all vertices at distance `radius`.
[[nodiscard]] TriangleMesh icosphere(uint32_t subdivisions = 4, double radius = 1.0);
// A torus around axis Y. The major radius is the distance from the axis to the centre of the tube.
[[nodiscard]] TriangleMesh torus(uint32_t major_segments = 96, uint32_t minor_segments = 48, double major_radius = 1.0,
                                 double minor_radius = 0.4);
// A tube along a (p, q) torus knot: p turns around axis Y, q turns around the tube of a torus with radii 1 and 0.5. A
// common divisor of p and q is removed. The default arguments give no self-intersection; many turns need a thinner
// tube.
[[nodiscard]] TriangleMesh torus_knot(uint32_t p = 2, uint32_t q = 3, uint32_t segments = 400, uint32_t ring = 24,
                                      double tube_radius = 0.25);
// A sphere with a concentric spherical cavity: two components, the inner one inside out.
[[nodiscard]] TriangleMesh hollow_sphere(uint32_t subdivisions = 4, double radius = 1.0, double cavity = 0.6);
// A Menger sponge: a cube in which each level cuts square tunnels through the middle, in 3^level steps. Level 0 is the
// cube, 4 is the maximum. Genus 5 at level 1, 81 at level 2.
[[nodiscard]] TriangleMesh menger_sponge(uint32_t level = 2, double edge = 2.0);
// A box of the given size.
[[nodiscard]] TriangleMesh cuboid(const glm::dvec3& size);
// Two columns joined by a round arch under a flat top: 2 m wide, 1.5 m high, 0.3 m deep, with the base at y = 0. The
// opening is 1.2 m wide.
[[nodiscard]] TriangleMesh arch(uint32_t segments = 24);
// A round tower, hollow and open at the top: 2 m high, with the base at y = 0, 0.92 m in diameter there and 0.72 m
// below the battlements, which overhang the wall. A door, 0.5 m high, faces +Z; each other side has a window. Genus 4.
[[nodiscard]] TriangleMesh tower();
// A calf: trunk, neck, head with ears and horns, tail and four legs, blended smoothly; 2.4 m long, one component of
// genus 0. It stands on y = 0 and looks along +Z. A plane across the legs leaves four separate parts below it, as in
// figure 12 of the paper. `resolution` is the count of lattice cells along its length.
[[nodiscard]] TriangleMesh four_legged_animal(uint32_t resolution = 64);
// A man in a long robe on a plinth, one arm raised and one hand at his belt; 2 m high, one component of genus 1. It
// stands on y = 0 and looks along +Z. `resolution` is the count of lattice cells along its height.
[[nodiscard]] TriangleMesh statue(uint32_t resolution = 64);

// A closed solid of revolution around axis Y. The profile lists radius and height, m, of its rings, with the solid on
// their left; flat discs close it at the first and the last ring. Radii are positive. A profile that comes back inside
// itself makes a vessel.
[[nodiscard]] TriangleMesh lathe(const std::vector<glm::dvec2>& profile, uint32_t sides);
// Household things that stand on y = 0: a vase, 0.4 m high, 0.26 m in diameter; a plate, 0.26 m in diameter; a table on
// one leg, 0.75 m high, 0.92 m in diameter; the basin of a fountain with a bowl on a column, 1.1 m high, 2 m in
// diameter.
[[nodiscard]] TriangleMesh vase(uint32_t sides = 40);
[[nodiscard]] TriangleMesh plate(uint32_t sides = 40);
[[nodiscard]] TriangleMesh round_table(uint32_t sides = 40);
[[nodiscard]] TriangleMesh basin(uint32_t sides = 48);
// A solid flight of stairs, 1.2 m wide, that stands on y = 0 and rises towards -Z: each step is 0.3 m deep and 0.17 m
// high.
[[nodiscard]] TriangleMesh stairs(uint32_t steps = 12);

// The following shapes are several solids that stand on each other, y = 0 being the ground. A fracture with one site
// cuts nothing and makes each solid a piece. `joint`, m, is the gap between two solids: meshes that touch are not
// valid.

// A semicircular arch of wedges (voussoirs) with a mean radius of 1 m, 0.5 m deep. An arch without mortar stands if its
// thickness is at least 0.1075 of its radius (Milankovitch, 1907).
[[nodiscard]] TriangleMesh stone_arch(double thickness = 0.15, uint32_t stones = 15, double joint = 1e-4);
// A house of playing cards, 88 x 63 x 2 mm. `levels` pairs of leaning cards stand at the bottom, one pair less on each
// further level, with a row of lying cards between two levels. Cards lean by 20 degrees: a foot needs a coefficient of
// friction of at most tan 20 = 0.364, whatever its load. The cards of a level follow each other.
[[nodiscard]] TriangleMesh card_house(uint32_t levels = 4, double joint = 1e-5);
// Dominoes, 48 x 24 x 7.5 mm and 13.5 mm apart, on a spiral; the first of the mesh is the outermost, at +X, and falls
// towards -Z.
[[nodiscard]] TriangleMesh domino_spiral(uint32_t count = 200);
// A wall of cubes, one less in each row: rows * (rows + 1) / 2 of them, a tenth of their edge apart.
[[nodiscard]] TriangleMesh pyramid(uint32_t rows = 50, double edge = 1.0, double joint = 1e-4);
// Cubes on each other.
[[nodiscard]] TriangleMesh stack(uint32_t count = 50, double edge = 1.0, double joint = 1e-4);

// Returns the names that shape() accepts: cube, lattice_cube, icosphere, torus, torus_knot, hollow_sphere,
// menger_sponge, pane (2 x 1.4 x 0.03 m), wall (2 x 1.2 x 0.2 m), arch, tower, animal, statue, vase, plate, table, basin,
// stairs, stone_arch, card_house, domino_spiral, pyramid, stack.
[[nodiscard]] std::span<const std::string_view> shape_names();
// Returns the named shape with default arguments (lattice_cube: n = 16), or nothing for an unknown name. NAME:N sets
// the resolution: lattice_cube:N, icosphere:SUBDIVISIONS, torus:SEGMENTS around (half as many across),
// torus_knot:SEGMENTS (a sixteenth across), menger_sponge:LEVEL, animal:RESOLUTION, statue:RESOLUTION,
// vase, plate, table and basin:SIDES, stairs:STEPS, stone_arch:THICKNESS (hundredths of its radius), card_house:LEVELS, domino_spiral:COUNT, pyramid:ROWS, stack:COUNT.
[[nodiscard]] std::optional<TriangleMesh> shape(std::string_view name);

} // namespace brittle::fracture

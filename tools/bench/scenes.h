// Scenes of rigid bodies whose outcome is known: from statics, from mechanics, or because real ones stand.
//
// Plain data, the same on every call. The program rigid_bodies measures them, benchmarks time them, and tests may step
// them. Every hull is made like a piece's (collision_hull()). Metres, kilograms, seconds; Y up; the ground is y = 0.
// A builder's friction is the coefficient of a contact: World multiplies those of two bodies, so each body gets its
// square root. Unless stated, all bodies collide and sleeping is off, so that nothing hides a drift.
//
//     const Scene scene = stack(20, 1.0);
//     World world(scene.settings);
//     Result<std::vector<BodyId>> bodies = world.add_bodies(scene.bodies);
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "physics/world/world.h"

namespace brittle::tools {

struct Scene {
    physics::WorldSettings settings{.debris_size = 0.0f, .max_colliding = 0, .sleeping = false};
    std::vector<physics::BodyDesc> bodies{};
    // By body: points whose convex hull is the solid, relative to the centre of mass, in body axes. The body's own hull
    // is smaller by its margin. For programs that make other shapes of the solid.
    std::vector<std::vector<glm::dvec3>> solids{};
};

inline constexpr double stone_density = 2400.0; // kg/m^3
inline constexpr double earth_gravity = 9.81;   // m/s^2, as in WorldSettings

// Adds a body of the convex hull of world points, at rest, and returns it. Mass and inertia are those of the full hull.
physics::BodyDesc& add_convex(Scene& scene, std::span<const glm::dvec3> points, double density = stone_density,
                              uint32_t max_vertices = 32);
// Adds a box with its axes along the world's.
physics::BodyDesc& add_box(Scene& scene, const glm::dvec3& size, const glm::dvec3& centre,
                           double density = stone_density);
// Sets the coefficient of contacts among bodies and with the ground.
void set_friction(Scene& scene, double coefficient);

// `count` cubes on each other.
[[nodiscard]] Scene stack(int count, double edge);
// A stack of `count` cubes under a cube of the same size and `ratio` times the mass.
[[nodiscard]] Scene loaded_stack(int count, double edge, double ratio);

// The shape card_house, with a coefficient of friction of 0.49: its feet need at most 0.364.
[[nodiscard]] Scene card_house(int levels);

// The shape stone_arch between two fixed blocks whose tops are y = 0. The blocks are the last bodies. There is no
// ground: an arch that fails falls through.
inline constexpr int arch_stones = 15;
[[nodiscard]] Scene arch(double thickness, int stones = arch_stones, double friction = 0.7);

// The shape pyramid: rows * (rows + 1) / 2 cubes.
[[nodiscard]] Scene pyramid(int rows, double edge);

// A flat box on a fixed slab that is tilted by `angle`, rad, about Z: it slides towards -X.
[[nodiscard]] Scene slope(double angle, double friction);

// A body of 0.2 m with its lowest point `height` above the ground, or above a fixed slab if there is one, in a vacuum.
// `restitution` is that of the contact.
enum class Dropped { ball, cube };
[[nodiscard]] Scene drop(Dropped what, double restitution, bool on_slab, double height);

// A row of dominoes along X. The first one has the angular velocity that lets it fall; feet do not slip.
struct Dominoes {
    int count = 60;
    double height = 0.048, width = 0.024, thickness = 0.0075; // m
    double gap = 0.0135;                                      // m, between two dominoes
    double friction = 0.2;                                    // between two dominoes
};
[[nodiscard]] Scene dominoes(const Dominoes& row);

// Heaps of the sizes that Box3D publishes, rebuilt from their descriptions: not its coordinates. Sleeping is off.
//
// 5,120 hulls of 32 random points near a sphere of 0.5 m fall in 20 layers of 16 x 16.
[[nodiscard]] Scene convex_pile();
// 10,584 rocks, hulls of 12 points, fall in 24 layers of 21 x 21 into a pit with four fixed walls, around a beam that
// stirs them: the last body. Call stir() before every step.
[[nodiscard]] Scene junkyard();
void stir(physics::World& world, physics::BodyId beam);
// 196 pyramids of 10 rows, 10,780 cubes, in 14 rows of 14.
[[nodiscard]] Scene many_pyramids();

// A body with three different moments that spins about the middle one, in empty space.
[[nodiscard]] Scene dzhanibekov();

} // namespace brittle::tools

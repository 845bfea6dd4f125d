// What the pieces do after the fracture: options of `brittle render` and `brittle demo`, and the "world" of a recipe.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/sites/pattern.h"
#include "physics/cutting/running_bond.h"

namespace brittle::tools {

// A ball that is shot at what is there. In the coordinates of the stage: metres, the mesh 2 m long around the Y axis.
struct Shot {
    double time = 0.0; // s, after the beginning
    glm::dvec3 from{0.0, 1.0, 4.0};
    glm::dvec3 velocity{0.0, 0.0, -12.0}; // m/s
    double radius = 0.1;                  // m
    double density = 7800.0;              // kg/m^3; steel
};

// A spot that was painted: the world holds what of the mesh reaches into a ball. In metres of the stage from the foot of
// the mesh, which is in the middle below it: so it stays where it is when the mesh is lifted.
struct Anchor {
    glm::dvec3 at{0.0};
    double radius = 0.1; // m

    friend bool operator==(const Anchor&, const Anchor&) = default;
};

// How blows cut what starts whole: in the manner of a pattern, or along a diagram made beforehand. That is fitted to the box
// of each piece that is hit, turned about Y by the blow's seed, and then placed (physics::ImpactPattern).
struct BlowPattern {
    fracture::PatternKind kind = fracture::PatternKind::uniform;
    double slenderness = 8.0;          // of splinters
    std::vector<glm::dvec3> diagram{}; // sites, in coordinates of any kind; or none
    fracture::Placement placement{};   // of the diagram
};

struct WorldOptions {
    bool bonded = false;          // pieces hold together until blows, loads or wear break their bonds
    bool anchored = false;        // bonded unless it is breakable, and what stands on the ground is held by it
    double height = 0.5;          // m, of the mesh above the ground at first; 0 where it is anchored
    double air_density = 1.2;     // kg/m^3; 0 is a vacuum, 1000 water in which nothing floats
    uint32_t max_colliding = 500; // awake, with each other; what comes off beyond is debris; 0: no limit
    double strength = 1.0;        // of bonds and pieces, in the material's; 0.075 is stone laid in weak mortar
    // Cut anew where it is hit, again and again. Where it is not bonded as well, it starts whole: the pattern says how blows
    // cut, and anchored means that what of it comes near the ground is held.
    bool breakable = false;
    double min_size = 0.05;      // m, cube root of volume; no smaller piece is made
    uint32_t blow_pieces = 48;   // at most, of one blow
    physics::RunningBond bond{}; // of bricks that blows take out, to be fitted: its corner is not looked at
    uint32_t piece_limit =
        2000; // in the world; beyond it debris goes, what is unseen, then what is small and old first
    std::vector<Anchor> anchors{};      // bonded unless it is breakable, and held there
    uint64_t seed = 1;                  // of where blows cut: see world_of()
    std::optional<BlowPattern> blows{}; // see world_of(); unset: as the material breaks
    std::vector<Shot> shots{};
};

// Of the mesh's foot above the ground, m.
[[nodiscard]] inline double foot_height(const WorldOptions& world) {
    return world.anchored ? 0.0 : world.height;
}

// Whether pieces that are there from the beginning hold together.
[[nodiscard]] inline bool holds_together(const WorldOptions& world) {
    return world.bonded || world.anchored || !world.anchors.empty();
}

// Whether the mesh is not cut beforehand.
[[nodiscard]] inline bool starts_whole(const WorldOptions& world) {
    return world.breakable && !world.bonded;
}

} // namespace brittle::tools

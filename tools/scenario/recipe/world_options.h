// Physics of the pieces after the fracture: options of `brittle render` and `brittle demo`, and the "world" of a
// recipe.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "fracture/settings.h"
#include "fracture/sites/pattern.h"
#include "physics/cutting/running_bond.h"
#include "physics/world/world.h"

namespace brittle::tools {

// A ball shot at the mesh, in the coordinates of the stage: metres, with the mesh 2 m long around the Y axis.
struct Shot {
    double time = 0.0; // s, after the start
    glm::dvec3 from{0.0, 1.0, 4.0};
    glm::dvec3 velocity{0.0, 0.0, -12.0}; // m/s
    double radius = 0.1;                  // m
    double density = 7800.0;              // kg/m^3; steel
};

// A ball within which the mesh is fixed to the world. The coordinates are metres of the stage, relative to the foot of
// the mesh (the middle of its box, at its lowest point), so that an anchor keeps its place on the mesh when the mesh is
// lifted.
struct Anchor {
    glm::dvec3 at{0.0};
    double radius = 0.1; // m

    friend bool operator==(const Anchor&, const Anchor&) = default;
};

// A joint of a piece or of a shot ball, with the world or with another piece (physics/world/joint.h). Points are
// relative to the foot of the mesh, as those of anchors.
struct JointOptions {
    physics::JointKind kind = physics::JointKind::distance;
    // The ball that is shot as the first (0), second ... of the run; the joint comes with it, at its centre. Nothing:
    // the piece that is nearest to `at`.
    std::optional<uint32_t> shot{};
    glm::dvec3 at{0.0};
    // The other side: the world, or the piece that is nearest to `to` (`at` for other kinds than distance) among those
    // of other bodies.
    bool to_piece = false;
    glm::dvec3 to{0.0};                 // the other anchor of a distance joint
    glm::dvec3 axis{0.0, 1.0, 0.0};     // of a hinge
    double min_length = 0.0;            // m
    std::optional<double> max_length{}; // m; empty: the distance at the start
    double max_force = 0.0;             // N; 0: it never breaks
    double max_torque = 0.0;            // N m, of a fixed joint; 0: it never breaks
    // A distance joint as a chain of balls, each jointed to the next, that collide and can be shot. It is as long as
    // its ends are apart at the start. From a shot ball it hangs at the surface.
    uint32_t links = 0;
    double link_radius = 0.03; // m

    friend bool operator==(const JointOptions&, const JointOptions&) = default;
};

// Cuts of blows in a world that starts whole: by the kind of a pattern, or along a given diagram. The diagram is fitted
// to the box of each piece that is hit, turned about Y by the seed of the blow, and then placed
// (physics::ImpactPattern).
struct BlowPattern {
    fracture::PatternKind kind = fracture::PatternKind::uniform;
    double slenderness = 8.0;          // length by width of splinters
    std::vector<glm::dvec3> diagram{}; // sites of the diagram, in any coordinates; or empty
    fracture::Placement placement{};   // placement of the diagram
};

struct WorldOptions {
    physics::EngineKind engine = physics::EngineKind::solver;
    bool bonded = false;      // pieces hold together until blows, loads or wear break their bonds
    bool anchored = false;    // parts that stand on the ground are fixed; bonded, unless breakable
    double height = 0.5;      // m, initial height of the mesh above the ground; ignored if anchored
    double air_density = 1.2; // kg/m^3; 0 is a vacuum, 1000 is water, but nothing floats
    // Limit on awake bodies that are no debris; further pieces that break off are debris; 0: none.
    uint32_t max_colliding = 500;
    // Strength of bonds and pieces, as a multiple of the material's; 0.075 is stone laid in weak mortar.
    double strength = 1.0;
    // Blows cut pieces again and again. A world that is breakable and not bonded starts whole: the pattern gives the
    // cuts of blows, and `anchored` fixes pieces that come near the ground.
    bool breakable = false;
    double min_size = 0.05;    // m, cube root of the volume of the smallest piece that a blow makes
    uint32_t blow_pieces = 48; // maximum number of pieces of one blow
    // Size and orientation of the bricks that blows take out. The bond is fitted to the mesh; its corner is ignored.
    physics::RunningBond bond{};
    // Maximum number of pieces. Debris beyond it is removed, first unseen, then small and old pieces.
    uint32_t piece_limit = 2000;
    std::vector<Anchor> anchors{};      // fixed balls; bonded, unless breakable
    uint64_t seed = 1;                  // seed of the cuts of blows; set by world_of()
    fracture::Roughness rough{};        // of the cuts of blows, in metres of the stage; set by world_of()
    std::optional<BlowPattern> blows{}; // set by world_of(); empty: as the material breaks
    std::vector<Shot> shots{};
    std::vector<JointOptions> joints{};
};

// Returns the height of the mesh's foot above the ground, m.
[[nodiscard]] inline double foot_height(const WorldOptions& world) {
    return world.anchored ? 0.0 : world.height;
}

// Returns whether the pieces of the initial fracture are bonded.
[[nodiscard]] inline bool holds_together(const WorldOptions& world) {
    return world.bonded || world.anchored || !world.anchors.empty();
}

// Returns whether the mesh starts as one piece.
[[nodiscard]] inline bool starts_whole(const WorldOptions& world) {
    return world.breakable && !world.bonded;
}

} // namespace brittle::tools

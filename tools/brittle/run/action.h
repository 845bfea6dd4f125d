// What a person or a script does to a simulation while it runs. An action takes effect between two steps, so
// what follows depends on the step and not on the frame rate; replay logs hold actions (docs/replay.md).
//
// World coordinates of the stage: metres, kilograms, seconds. Pieces are indices into the fragments; those that come of
// them count on from there, in the order in which they come, and no number is used again. To add a
// kind: a struct here, a line in fault_of(), an overload in simulation.cpp, a row in replay/action_json.cpp
// and in the schema.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include <glm/vec3.hpp>

namespace brittle::tools {

// A ball flies from there. It stays until the simulation is cleared.
struct Shoot {
    glm::dvec3 from{0.0};
    glm::dvec3 velocity{0.0}; // m/s
    double radius = 0.1;      // m
    double density = 7800.0;  // kg/m^3
};

// Structure::damage(): bonds near the point lose health. Nothing where pieces are not bonded; so the
// following three.
struct Damage {
    glm::dvec3 point{0.0};
    double radius = 0.1; // m
    double amount = 1.0; // of a bond's health, which is 1
};

// Structure::damage_segment(): a saw.
struct Saw {
    glm::dvec3 from{0.0};
    glm::dvec3 to{0.0};
    double radius = 0.01; // m
    double amount = 1.0;
};

constexpr double hammer_mass = 1.0; // kg

// A hammer of a kilogram. It breaks bonds (Structure::blow()) and, where things are breakable, the piece itself at the
// point of it that is nearest (Destruction::strike()), both with all of its energy; it moves nothing.
struct Hammer {
    uint32_t piece = 0;
    glm::dvec3 point{0.0};
    glm::dvec3 impulse{0.0}; // N s
};

// The world lets go of bonded pieces; of all where the list is empty.
struct Release {
    std::vector<uint32_t> pieces;
};

// An impulse on the body that holds the piece.
struct Push {
    uint32_t piece = 0;
    glm::dvec3 point{0.0};
    glm::dvec3 impulse{0.0}; // N s
};

// Takes hold of a piece at a point, and lets go of what was held before.
struct Grab {
    uint32_t piece = 0;
    glm::dvec3 point{0.0};
};

// Where the point that is held is drawn to from now on.
struct Drag {
    glm::dvec3 to{0.0};
};

struct LetGo {};

// What someone sees of the world from now on: of debris in excess, what no one sees goes first and at once
// (Destruction::set_view()). Until the first, all is seen. Nothing where nothing is breakable.
struct Watch {
    glm::dvec3 eye{0.0, 1.0, 4.0};
    glm::dvec3 target{0.0}; // in the middle of the picture
    double fov = 0.6;       // radians, from its lower edge to its upper one
    double aspect = 1.5;    // its width by its height

    friend bool operator==(const Watch&, const Watch&) = default;
};

using Action = std::variant<Shoot, Damage, Saw, Hammer, Release, Push, Grab, Drag, LetGo, Watch>;

// The first thing about an action that makes no sense, for people, with the name of the field; or nothing.
[[nodiscard]] std::string fault_of(const Action& action, size_t piece_count);

} // namespace brittle::tools

// Actions of a person or a script on a running simulation. An action takes effect between two steps, so its result
// depends on the step and not on the frame rate. Replay logs consist of actions (docs/replay.md).
//
// Coordinates are those of the stage: metres, kilograms, seconds. Pieces are indices into the fragments. Pieces that
// are cut later get the following numbers, in order of creation; no number is used twice.
//
// To add a kind of action: a struct here, a case in fault_of(), an overload in simulation.cpp, a row in
// replay/action_json.cpp and in the schema.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include <glm/vec3.hpp>

namespace brittle::tools {

// Shoots a ball, which stays until the simulation is cleared.
struct Shoot {
    glm::dvec3 from{0.0};
    glm::dvec3 velocity{0.0}; // m/s
    double radius = 0.1;      // m
    double density = 7800.0;  // kg/m^3
};

// Structure::damage(): takes health from the bonds near a point. Like Saw and Release it has no effect without bonds.
struct Damage {
    glm::dvec3 point{0.0};
    double radius = 0.1; // m
    double amount = 1.0; // share of a bond's full health, which is 1
};

// Structure::damage_segment(): takes health from the bonds near a segment, as a saw does.
struct Saw {
    glm::dvec3 from{0.0};
    glm::dvec3 to{0.0};
    double radius = 0.01; // m
    double amount = 1.0;
};

constexpr double hammer_mass = 1.0; // kg

// A blow of a hammer of hammer_mass. It breaks bonds (Structure::blow()) and, in a breakable world, the piece itself at
// its point nearest to `point` (Destruction::strike()), both with its whole energy. It moves no body.
struct Hammer {
    uint32_t piece = 0;
    glm::dvec3 point{0.0};
    glm::dvec3 impulse{0.0}; // N s
};

// Releases bonded pieces from the world; all of them if the list is empty.
struct Release {
    std::vector<uint32_t> pieces;
};

// Applies an impulse to the body that holds the piece.
struct Push {
    uint32_t piece = 0;
    glm::dvec3 point{0.0};
    glm::dvec3 impulse{0.0}; // N s
};

// Grabs a piece at a point and releases the piece held before.
struct Grab {
    uint32_t piece = 0;
    glm::dvec3 point{0.0};
};

// Target towards which the grabbed point is pulled from now on.
struct Drag {
    glm::dvec3 to{0.0};
};

struct LetGo {};

// The view of the camera from now on. Of the debris beyond the limit, pieces outside the view are removed first and at
// once (Destruction::set_view()). Before the first Watch everything counts as seen. No effect in a world that is not
// breakable.
struct Watch {
    glm::dvec3 eye{0.0, 1.0, 4.0};
    glm::dvec3 target{0.0}; // point in the middle of the picture
    double fov = 0.6;       // radians, vertical angle of view
    double aspect = 1.5;    // width by height of the picture

    friend bool operator==(const Watch&, const Watch&) = default;
};

using Action = std::variant<Shoot, Damage, Saw, Hammer, Release, Push, Grab, Drag, LetGo, Watch>;

// Returns a message with the name of the first invalid field of an action, or an empty string.
[[nodiscard]] std::string fault_of(const Action& action, size_t piece_count);

} // namespace brittle::tools

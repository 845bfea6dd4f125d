// The part of a body that depends on neither its pose nor its world. make_form() makes it ahead, on any thread; bodies
// may share it.
#pragma once

#include <glm/mat3x3.hpp>

#include "physics/world/hull.h"

namespace brittle::physics {

// The data that every engine reads. An engine derives from it to store what it computes ahead.
struct BodyForm {
    BodyForm() = default;
    BodyForm(const BodyForm&) = delete;
    BodyForm& operator=(const BodyForm&) = delete;
    virtual ~BodyForm() = default;

    CollisionHull hull{};    // relative to the centre of mass, in body axes; without cross section and faces
    float mass = 0.0f;       // kg
    glm::mat3 inertia{1.0f}; // kg m^2, about the centre of mass in body axes
    bool fixed = false;
};

} // namespace brittle::physics

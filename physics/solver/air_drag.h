// Drag of still air on a body: quadratic in its linear and its angular velocity.
//
// - Linear: m dv/dt = -1/2 rho C A |v| v, where A is the area of the body's shadow along v (cross_section.h): a pane
//   that flies edge-on has little drag. There is no lift and no aerodynamic torque.
// - Angular, for each principal axis: I dw/dt = -1/2 rho C A g^3 |w| w, where g is the radius of gyration about the
//   axis and A the mean shadow over the directions across it: the drag of the whole shadow at radius g. Compared with
//   the integrated pressure on the leading faces, this is half for a plate that turns about its middle line, and 1.4
//   times as much for a cube.
// - A step evaluates the exact solution v / (1 + k |v| t), so no velocity reverses and energy falls at any step size.
// - A body of several hulls has the sum of their shadows or the shadow of their common box, whichever is smaller on
//   average: the sum is too large where hulls hide each other, the box where it is half empty.
//
// S. F. Hoerner, "Fluid-Dynamic Drag", 1965.
#pragma once

#include <span>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "physics/solver/velocity.h"

namespace brittle::physics {

// C of tumbling pieces with edges: a cube has 0.8 edge-on and 1.05 face-on, a plate 1.2 face-on. A smooth ball has 0.5.
inline constexpr float drag_coefficient = 1.0f;

class AirDrag {
  public:
    AirDrag() = default; // no drag
    // sides: CrossSection::sides, m^2. turn: the rotation from their axes to the principal axes. moments: principal,
    // kg m^2.
    AirDrag(std::span<const glm::vec3> sides, const glm::quat& turn, float mass, const glm::dvec3& moments);

    // Applies the drag of air (kg/m^3) over a time (s) to the velocities of a body whose principal axes are the columns
    // of `basis`. Changes of less than `unfelt`, m/s, are skipped.
    void brake(Velocity& velocity, const glm::mat3& basis, float density, float seconds, float unfelt) const;

  private:
    std::vector<float> lanes_; // sides times 1/2 C / m, in groups of four: 4 x, 4 y, 4 z; padded with 0
    float most_ = 0.0f;        // m^2/kg, upper bound of their shadow in any direction
    glm::vec3 spin_{0.0f};     // 1/2 C A g^3 / I, m^3/kg
    float radius_ = 0.0f;      // the largest g, m
};

} // namespace brittle::physics

// What still air does to a body that moves through it: quadratic drag, and the same for its spin.
//
// - Way: m dv/dt = -1/2 rho C A |v| v, A being the body's shadow along its way (cross_section.h): a pane meets little
//   with its edge. No lift, no torque: what flies askew is not turned.
// - Spin: each of its three parts about a principal axis loses what way would, were all of the shadow across that
//   axis at the radius of gyration g about it: I dw/dt = -1/2 rho C A g^3 |w| w, with A the mean over the directions
//   across. Against the pressure on the faces that lead, integrated, that is half for a plate that turns about its
//   middle line and 1.4 times as much for a cube.
// - A step follows the exact solution, v / (1 + k |v| t), so that however fast and light, nothing turns round, and
//   energy falls.
// - Bodies that have several hulls: the sum of their shadows or that of the box around them, whichever is less on
//   average, as either is too much where hulls hide each other or leave the box half empty.
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

// Of edged pieces that tumble: a cube has 0.8 on its edge and 1.05 flat, a plate 1.2 flat. A smooth ball would have
// 0.5.
inline constexpr float drag_coefficient = 1.0f;

class AirDrag {
  public:
    AirDrag() = default; // as in a vacuum
    // Sides of the shadow (CrossSection::sides), the turn from their axes to the principal ones, moments in those;
    // m^2, kg, kg m^2.
    AirDrag(std::span<const glm::vec3> sides, const glm::quat& turn, float mass, const glm::dvec3& moments);

    // Takes from the velocities of a body with these principal axes what air of a density, kg/m^3, takes in a time,
    // s; nothing where that is less than `unfelt`, m/s.
    void brake(Velocity& velocity, const glm::mat3& basis, float density, float seconds, float unfelt) const;

  private:
    std::vector<float> lanes_; // sides times 1/2 C / m, by groups of four: four x, four y, four z; filled up with zero
    float most_ = 0.0f;        // at least their shadow from any side; m^2/kg
    glm::vec3 spin_{0.0f};     // 1/2 C A g^3 / I, m^3/kg
    float radius_ = 0.0f;      // the largest g, m
};

} // namespace brittle::physics

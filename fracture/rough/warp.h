// A smooth one-to-one map of space, made of noise: the warp that turns flat cuts into rough ones.
//
//     const Warp warp(roughness, wavelength);
//     const glm::dvec3 y = warp.apply(x);     // a plane in y is a rough surface in x
//     const glm::dvec3 z = warp.inverse(y);   // close to x, see inverse_rounds
//
// The warp is a chain of steps x -> x + a n(x), one for each octave. n is gradient noise whose gradients are orthogonal
// matrices (Perlin, "An Image Synthesizer", 1985, and "Improving Noise", 2002, for the weights). Its Lipschitz constant
// is at most noise_slope, and a * noise_slope is below 1. So each step is one to one, and so is the chain, however many
// octaves it has.
//
// Where a cut must stay flat, the noise is faded out around balls (CalmBall), which keeps each step one to one.
//
// Only + - * and comparisons, in a fixed order: equal bits on every machine. Concurrent reads are safe.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "fracture/settings.h"

namespace brittle::fracture::rough {

// A bound of the Lipschitz constant of the noise in its lattice: the maximum of the sum over the eight corners c of a
// lattice cell of |w_c u + (grad w_c . u) (x - c)| over all points x and unit vectors u, 2.7923 at the centre.
inline constexpr double noise_slope = 2.8;
// A bound of the noise: the distance from the centre of a lattice cell to its corners, sqrt(3) / 2.
inline constexpr double noise_height = 0.8661;

// Rounds of the fixed-point iteration that inverts a step. At amount 1 a round leaves about 0.3 of the error, 0.9 at
// worst. The inverse places points; that both sides of a cut use the same one matters, its last digits do not.
inline constexpr uint32_t inverse_rounds = 6;

// A ball inside which the warp does nothing. Around it the noise rises to its full height over fade_wavelengths.
struct CalmBall {
    glm::dvec3 centre;
    double radius; // m
};
// The rise adds at most 1.5 / fade_wavelengths times the height of the noise per wavelength to the slope of a step.
inline constexpr double fade_wavelengths = 1.5;

class Warp {
  public:
    // The identity.
    Warp() = default;
    // `wavelength` replaces roughness.wavelength, which may be 0. Preconditions: the values are in their ranges.
    Warp(const Roughness& roughness, double wavelength, std::span<const CalmBall> calm = {});

    [[nodiscard]] glm::dvec3 apply(const glm::dvec3& point) const;
    [[nodiscard]] glm::dvec3 inverse(const glm::dvec3& point) const;
    void apply(std::span<glm::dvec3> points) const;
    void inverse(std::span<glm::dvec3> points) const;

    // A bound of the distance between a point and its image, m.
    [[nodiscard]] double reach() const { return reach_; }

  private:
    struct Step {
        glm::dmat3 to_lattice; // from metres to the lattice of the noise, whose cells have sides of 1
        glm::dvec3 offset;     // of the lattice
        glm::dmat3 to_metres;  // from the noise to a displacement
        uint64_t seed;
    };
    std::vector<Step> steps_;
    std::vector<CalmBall> calm_;
    double fade_ = 0.0; // m
    double reach_ = 0.0;

    friend void warp_points(const Warp& warp, std::span<glm::dvec3> points, bool inverse);
};

} // namespace brittle::fracture::rough

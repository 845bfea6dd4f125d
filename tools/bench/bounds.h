// How far a simulation may be from the truth of a scene: the bounds of rigid_bodies and of tools/compare --physics.
#pragma once

#include <cstddef>

namespace brittle::tools {

inline constexpr double max_drift = 0.005;            // m, of bodies that must stand or rest
inline constexpr double max_restitution_error = 0.03; // of a measured coefficient
inline constexpr double max_speed_error = 0.1;        // of a slide or a wave, as a share of the theory's
inline constexpr double max_overlap = 0.0049;         // m, of two pieces in a pile
inline constexpr double max_overlap_p95 = 0.001;      // m, 95th percentile of the overlaps in a pile
inline constexpr double max_share_inside = 0.2;       // of a body's volume, inside another one

// An arch near the least thickness is decided by rounded corners and gaps.
inline constexpr double surely_falls = 0.09, surely_stands = 0.13; // thickness in mean radii
inline constexpr double arch_fall = 0.1;                           // m, by which a stone has left its place
inline constexpr double card_fall = 0.02;                          // m
inline constexpr double stack_fall = 0.5;                          // edges of a cube

// The wave is timed between these dominoes, away from both ends, each when it has tilted by 2.3 degrees.
inline constexpr size_t first_timed_domino = 20, last_timed_domino = 55;
inline constexpr double tilted_cosine = 0.9998; // of half the angle

} // namespace brittle::tools
